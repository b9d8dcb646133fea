"""Event-driven march: exact propagation from event to event, without a time grid.

Problem
    With dry friction the equation of motion depends on the mode of the contact (stick, slip,
    hold, yield, separated) and of the end stops. Within a mode it is linear and has a
    closed-form solution. The time at which a mode ends, the event, must be found without
    missing an earlier one, and the solution continued in the mode that follows.

Method
    Each step of `march_modes` begins a segment in the current mode, propagates the closed-form
    motion to its first exit within the interval of ü (`first_exit`), with v_r = 0 exactly at a
    stop, and decides the mode that follows (`enter_next_mode`). `core.modes` and `core.roots`
    hold the equations, exits and resets.

    Over samples, intervals without an event are advanced by the affine maps of `core.sampled`
    in any mode of rest or motion (`advance_whole_steps`), and the exits of a short interval
    are found in its power series (`exit_of_short_step`). Only the state at every sample and
    the changes of mode are kept.

    `march_sines` is the same for Coulomb friction alone: its state is x_r, v_r and the
    direction of sliding, and its events are the solution. `core.sampled` is the march of
    Coulomb friction with constant limits over samples.

Why nothing is missed
    The exit searches return the first root of their observable, proved by bounds on its
    derivatives. There is no velocity tolerance: a stop is a root of v_r, and the mode is part
    of the state. An event may be followed by another at the same time; `MAX_STALLED_EVENTS` of
    them in a row mean that double precision does not resolve the motion, and the march reports
    it.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compile import ZERO, compiled, inlined, merged
from drysim.core.events import (
    CONTACT,
    IMPACT,
    MAX_EVENTS_PER_STEP,
    REVERSAL,
    SLIP,
    STICK,
    EventLog,
    SampledLimit,
    decision_margin,
    direction_from_rest,
    excess_margin,
    grazing_margin,
    initial_direction,
    limit_force,
    motion_direction,
    record_event,
    record_segment,
    sign,
    slide_time,
    stick_limit,
    stop_depth,
)
from drysim.core.forcing import (
    PHASE,
    V_R,
    WAVE_COLUMNS,
    X_R,
    A,
    Segment,
    base_motion,
    motion_at,
    relative_normal_force,
    set_phases,
    slip_equation,
    start_segment,
    unpack_scene,
)
from drysim.core.model import MAX_STAGES
from drysim.core.modes import (
    APART,
    ARRIVAL,
    AT_REST,
    CHATTERING,
    FREE,
    HOLD,
    LEAVING,
    REGULAR,
    Hold,
    Instant,
    LoadRamp,
    Mode,
    ModeState,
    SegmentBase,
    bumper_force,
    bumper_line,
    chatter_time,
    contact_force,
    encode_mode,
    force_rate_bound,
    guard_end_stop,
    guard_hold,
    guard_rest,
    guard_separation,
    guard_yield,
    is_rigid_slip,
    load_at,
    load_varies,
    mode_equation,
    mode_forces,
    mode_from_rest,
    mode_of,
    origin_of,
    reset_break_away,
    reset_bumper,
    reset_impact,
    reset_zero_load,
    rest_margin,
    return_accelerations,
    side_of,
    stop_stage,
    wall_side,
)
from drysim.core.oscillator import (
    cancellation_speed,
    cancellation_threshold,
    discretise_slip,
    grazing_speed,
    read_steps,
    series_distance,
    series_velocity,
    velocity_series,
    write_steps,
)
from drysim.core.roots import (
    MAX_BISECTIONS,
    NEVER,
    Stuck,
    break_away_time,
    first_stop,
    lowest_speed,
    quiet_time,
    safeguarded_newton,
    velocity_and_acceleration,
)
from drysim.core.sampled import (
    CHUNK,
    Chunk,
    Contact,
    Direction,
    OneWay,
    Rest,
    SlipState,
    advance_rest,
    advance_slip,
    rescale,
    slide,
    step_through_events,
    sum_base_motion,
)
from drysim.core.status import CROWDED_STEP, NO_PROGRESS

MAX_STALLED_EVENTS = 100
"""Steps in a row without progress in time after which double precision is exhausted."""


# Coulomb friction under waves: slip, stop, stick, break away.


class Interval(NamedTuple):
    """Interval in which ü besides the waves is linear.

    Attributes
    ----------
    n : int
        Its index, for the log.
    t, h : float
        Start and length [s].
    u_0, slope : float
        ü besides the waves at the start [m/s²], and its rate [m/s³].
    """

    n: int
    t: float
    h: float
    u_0: float
    slope: float


@compiled
def march_sines(plant, law, waves, interval, state, log):
    """Solve one interval with Coulomb friction from event to event.

    The march stops early when the log is nearly full.

    Parameters
    ----------
    plant, law : Plant, CoulombLaw
    waves : Waves
    interval : Interval
    state : SlipState
        Where to begin.
    log : EventLog
        Written: the events.

    Returns
    -------
    SlipState
        State reached. A call that starts there continues as if uninterrupted.

    Notes
    -----
    With F_fs = F_fk a slip starts with zero relative acceleration. The acceleration just after
    a break-away is therefore set to d (F_fs - F_fk) N/m exactly instead of evaluated with
    rounding.
    """
    m, k_x, _ = plant
    n, t, h, u_0, slope = interval
    _, begin, x_r, v_r, d, _, count, closest = state
    capacity = len(log.n)
    limit = law.F_fs, slope
    just_broke_away = False
    stalled = 0
    while begin < h and (just_broke_away or count + 2 <= capacity):
        before = begin
        set_phases(waves, plant, law, t + begin, d)
        u_begin = u_0 + slope * begin
        left = h - begin
        if d == 0:
            stuck = Stuck(m, k_x * x_r, u_begin, limit, limit, law.variation, law.omega)
            stay, d, margin = break_away_time(stuck, waves, left)
            closest = min(closest, margin)
            if stay == NEVER:
                return SlipState(n, h, x_r, 0.0, 0, math.nan, count, closest)
            begin = min(begin + stay, h)
            load = relative_normal_force(law, waves, stay)[0]
            count = record_event(log, count, n, begin, d * SLIP, x_r, -d * law.F_fs * load)
            just_broke_away = True
            continue
        equation = slip_equation(plant, law, d, u_begin, slope)
        segment = start_segment(equation, waves, x_r, v_r)
        if just_broke_away:
            load = relative_normal_force(law, waves, 0.0)[0]
            segment = with_acceleration(segment, d * (law.F_fs - law.F_fk) * load / m)
        just_broke_away = False
        stop, x_stop, low = first_stop(segment, waves, law, d, left)
        if low < NEVER and law.F_fs > law.F_fk:
            time = slide_time(log, count, n, begin + min(stop, left), h)
            closest = min(closest, grazing_margin(plant, law.F_fs, low, time))
        if stop == NEVER:
            x_r, v_r, _, _, _ = motion_at(equation, waves, x_r, v_r, left)
            return SlipState(n, h, x_r, v_r, d, math.nan, count, closest)
        begin = min(begin + stop, h)
        stalled = 0 if begin > before else stalled + 1
        if stalled > MAX_STALLED_EVENTS:
            return SlipState(n, begin, x_r, v_r, d, math.nan, NO_PROGRESS, closest)
        # v_r is set to zero exactly: the stop is an event, not a small velocity.
        x_r, v_r = x_stop, 0.0
        u_dd, rate, _ = base_motion(waves, u_begin, slope, stop)
        F_L = limit_force(plant, x_r, u_dd)
        load, load_d, _ = relative_normal_force(law, waves, stop)
        F_fs = law.F_fs * load
        if law.F_fs > law.F_fk:
            a = -(d * F_L + law.F_fk * load) / m
            low = stop_depth(a, -d * rate - (law.F_fk * load_d + plant.b * a) / m)
            time = slide_time(log, count, n, begin, h)
            closest = min(closest, grazing_margin(plant, F_fs, low, time))
        closest = min(closest, decision_margin(F_L, F_fs))
        d = direction_from_rest(F_L, F_fs, k_x * x_r)
        kind = STICK if d == 0 else d * REVERSAL
        count = record_event(log, count, n, begin, kind, x_r, F_L)
    return SlipState(n, begin, x_r, v_r, d, math.nan, count, closest)


@inlined
def with_acceleration(segment, a):
    """Return a segment whose acceleration at the start is known without cancellation."""
    equation = segment.equation
    change = a - segment.a
    j = segment.j - equation.c * change
    k = segment.k - equation.c * (j - segment.j) - equation.w * change
    return Segment(equation, segment.x_r, segment.v_r, a, j, k)


@compiled
def march_sines_from_start(row, end, log, kind):
    """Solve a scene under waves alone from t = 0 to `end` [s], or until the log is nearly full.

    `row` is a scene as in `drysim.core.forcing`, with its waves; `log` holds the rows of an
    event log as one array and `kind` its kinds. Returns as `march_sines`; `closest` includes
    the margin of the initial mode.
    """
    plant, law, waves = unpack_scene(row)
    log = EventLog(log[0], log[1], kind, log[2], log[3])
    state = initial_slip_state(plant, law, waves, row[X_R], row[V_R], log)
    interval = Interval(0, 0.0, end, 0.0, 0.0)
    return march_sines(plant, law, waves, interval, state, log)


@compiled
def initial_slip_state(plant, law, waves, x_r, v_r, log):
    """Return the `SlipState` at t = 0 under waves alone; write it to the log as first event."""
    u_dd = 0.0
    for i in range(waves.base):
        row = WAVE_COLUMNS * i
        u_dd += waves.values[row + A] * math.sin(waves.values[row + PHASE])
    d, F_L, margin = initial_direction(plant, law, x_r, v_r, u_dd)
    count = record_event(log, 0, 0, 0.0, d, x_r, F_L)
    return SlipState(int(ZERO), 0.0, x_r, v_r, d, math.nan, count, margin)


@compiled
def write_slip_segments(log, v_r, end, out):
    """Write a motion with Coulomb friction under waves alone as segments; return their number.

    Parameters
    ----------
    log : EventLog
        Its events; the first one is the start.
    v_r : float
        Velocity at the start [m/s]; it is 0 at every later event.
    end : SlipState
        State at the end of the motion.
    out : Segments
        Written, with the state at the end.
    """
    for i in range(end.events):
        d, time = sign(log.kind[i]), (int(ZERO), log.s[i])
        mode = encode_mode(mode_of(d, d, APART, 0))
        record_segment(out, i, time, (log.x_r[i], v_r if i == 0 else 0.0, 0.0), mode)
    mode = encode_mode(mode_of(end.d, end.d, APART, 0))
    state = end.x_r, end.v_r, 0.0
    return record_segment(out, end.events, (int(ZERO), end.s), state, mode)


@compiled
def march_varying_limits(scene, past, end, state, out, log):
    """March over samples with varying friction limits, one call of `march_sines` per step.

    Parameters
    ----------
    scene : Scene
    past : int
        Number of samples of the motion before those of the scene.
    end : int
        Last sample to march to.
    state : SlipState
        Where to begin, at a sample.
    out : tuple of array
        Written: x_r [m], v_r [m/s] and direction of sliding at the samples.
    log : EventLog
        Written: the events.

    Returns
    -------
    SlipState
        At the sample reached, before `end` if the log is nearly full.
    """
    plant, law, waves, u_dd, dt = scene
    x_out, v_out, d_out = out
    while state.n < end and state.events + MAX_EVENTS_PER_STEP <= len(log.n):
        n, count = state.n, state.events
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        interval = Interval(n, (past + n) * dt, dt, u_dd[n], slope)
        state = march_sines(plant, law, waves, interval, state, log)
        closest, limit = state.closest, sampled_limit(law, law.F_fs, past * dt, dt)
        for i in range(count, state.events):
            if abs(log.kind[i]) == SLIP:
                F_k, leaves = plant.k_x * log.x_r[i], sign(log.kind[i])
                closest = excess_margin(plant, u_dd, limit, n, F_k, leaves, closest)
        _, s, x_r, v_r, d, a, count, _ = state
        if s < dt or count < 0:
            fault = count if count < 0 else CROWDED_STEP
            return SlipState(n, 0.0, x_r, v_r, d, a, fault, closest)
        x_out[n + 1], v_out[n + 1], d_out[n + 1] = x_r, v_r, d
        state = SlipState(n + 1, 0.0, x_r, v_r, d, a, count, closest)
    return state


@inlined
def sampled_limit(law, F_fs, t, dt):
    """Return the `SampledLimit` of samples from time t [s] on; the normal force is a sine."""
    return SampledLimit(F_fs, law.variation, law.phase + law.omega * t, law.omega * dt)


# Any piecewise-linear law: from mode to mode.

MODES_LOG_RESERVE = 4
"""Segments and events that one step may add to their logs, and one final entry."""


class MarchState(NamedTuple):
    """State of a march.

    Attributes
    ----------
    n, s : int, float
        Interval of ü, and time since its start [s].
    xi, v_r : float
        Displacement from the origin of the mode [m], which is 0 or the position of an end stop;
        and velocity [m/s].
    a : float
        Acceleration where the forces would give it with cancellation only [m/s²], else nan: it
        is carried over an interval in which |v_r| is very small, and over an event of an
        elastic contact that takes no time.
    x_0 : float
        x_r at which an elastic contact carries no force [m].
    mode : Mode
    used, events : int
        Numbers of segments and of events in the logs; `events` may be a `Status` instead.
    closest : float
        Smallest relative margin of a decision about sticking so far [-].
    """

    n: int
    s: float
    xi: float
    v_r: float
    a: float
    x_0: float
    mode: Any
    used: int
    events: int
    closest: float


class ModeSegment(NamedTuple):
    """Segment of a motion in one mode, with all that decides how it ends.

    Attributes
    ----------
    mode, x_0
        As in `MarchState`.
    motion : Segment
        Motion of xi from the start of the segment.
    creeps : bool
        Whether |v_r| is so small that the sum of forces cancels.
    base : SegmentBase
    ramp : LoadRamp
    left : float
        Time for which base motion and normal force keep their form [s].
    """

    mode: Any
    x_0: float
    motion: Any
    creeps: bool
    base: Any
    ramp: Any
    left: float


NO_EXIT, CONTACT_EXIT, BREAK_AWAY, STOP_EXIT, TURN, ZERO_LOAD, CHATTER_END, UNDECIDED = range(8)
"""How a segment ends: its time is up; an elastic contact yields, or holds again; a mass at rest
leaves; a stop or a stage of it is reached or left; v_r is zero; the normal force is zero; all
rebounds of a chatter are over; not known yet."""


class Exit(NamedTuple):
    """End of a segment: the first exit from its mode.

    Attributes
    ----------
    kind : int
        `NO_EXIT` or one of those that follow it.
    s : float
        Time since the start of the segment [s].
    xi, v_r, a : float
        State there, as in `MarchState`.
    after : int
        New state of the contact, direction in which the mass leaves, or new state with respect
        to the end stops.
    closest : float
        Smallest relative margin of a decision about sticking before [-].
    """

    kind: int
    s: float
    xi: float
    v_r: float
    a: float
    after: int
    closest: float


class Course(NamedTuple):
    """How far a march goes.

    Attributes
    ----------
    last, length : int, float
        Last interval of ü, and its length [s].
    until : int
        Number of the first interval that is not solved.
    closes : bool
        Whether the state there is recorded as the end of the last segment.
    capacity : int
        Length of the logs.
    """

    last: int
    length: float
    until: int
    closes: bool
    capacity: int


class ModeSteps(NamedTuple):
    """Constants of whole sample steps in every mode, and what the base contributes to them.

    Attributes
    ----------
    first : int
        Sample of the base motion at which n counts from 0.
    rows : array, shape (MODES, STEP_COLUMNS)
        `SlipSteps` by `steps_index`; zeros where not computed yet.
    x_sums, v_sums : array, shape (MODES, CHUNK)
        As in `Chunk`.
    begin, until : array of int, shape (MODES,)
        The samples of these sums, as in `Chunk`.
    """

    first: int
    rows: Any
    x_sums: Any
    v_sums: Any
    begin: Any
    until: Any


class ModesLog(NamedTuple):
    """What a march writes.

    Attributes
    ----------
    segments : Segments
        Starts of the segments, except those that begin at a sample in the mode before.
    events : EventLog
    samples : SampledMotion
        xi, v_r and direction of motion at all samples.
    """

    segments: Any
    events: Any
    samples: Any


@compiled
def march_modes(scene, course, state, steps, out):
    """Solve a motion from mode to mode, until a log is nearly full.

    Parameters
    ----------
    scene : Scene
    course : Course
    state : MarchState
        Where to begin.
    steps : ModeSteps
        Work space.
    out : ModesLog
        Written; `samples` holds the state at sample n.

    Returns
    -------
    MarchState
        State reached; n is `course.until` at the end of the motion. A call that starts there
        continues as if uninterrupted.
    """
    _, law, waves, u_dd, dt = scene
    segments, log, samples = out
    n, s, xi, v_r, a, x_0, mode, used, count, closest = state
    last, last_length, until, closes, capacity = course
    full = capacity - MODES_LOG_RESERVE
    affine = waves.size == 0 and law.step == 0.0
    whole = until if until <= last or last_length == dt else last
    stalled, latest = int(ZERO), Latest(used, UNRECORDED, x_0)
    constants, has_constants = ModeConstants(int(ZERO), 0.0, 0.0, 0.0, 0.0), False
    while n < until and latest.used < full and count < full:
        if affine and not has_constants and mode.direction != AT_REST:
            constants, has_constants = mode_constants(scene, mode, x_0, steps), True
        if affine and n < whole and mode.entry == REGULAR:
            here = MarchState(n, s, xi, v_r, a, x_0, mode, latest.used, count, closest)
            reached = n
            if s == 0.0:
                reached, closest = advance_whole_steps(
                    scene, whole, here, constants, steps, samples
                )
            passes = reached < whole and slides_or_sticks(law, mode, xi)
            if reached > n or passes:
                latest = record_mode(segments, latest, (n, s), (xi, v_r, x_0), mode)
            if reached > n:
                n, a = reached, math.nan
                xi, v_r = samples.x_r[n], samples.v_r[n]
                if n == until:
                    break
            if passes:
                here = MarchState(n, s, xi, v_r, a, x_0, mode, latest.used, count, closest)
                here = advance_through_events(scene, here, steps, full, out)
                goes_on = here.n == n and here.events == count
                if here.events > count:
                    row = UNRECORDED if here.s > 0.0 else lasting_mode(here.mode)
                    latest, has_constants = Latest(here.used, row, x_0), False
                n, s, xi, v_r, a, x_0, mode, _, count, closest = here
                if not goes_on:
                    continue
        length = last_length if n == last else dt
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        base = SegmentBase((steps.first + n) * dt + s, u_dd[n] + slope * s, slope)
        here = MarchState(n, s, xi, v_r, a, x_0, mode, latest.used, count, closest)
        time, ramp = slide_time(log, count, n, s, dt), LoadRamp(1.0, 0.0, NEVER)
        leave = undecided_exit()
        if affine:
            leave = exit_of_short_step(scene, base, here, length - s, constants, steps, time)
        if leave.kind == UNDECIDED:
            part = begin_segment(scene, base, here, length - s)
            mode, ramp, leave = part.mode, part.ramp, first_exit(scene, part, time)
            has_constants = False
        latest = record_mode(segments, latest, (n, s), (xi, v_r, x_0), mode)
        kind, step, xi, v_r, a, _, margin = leave
        closest = min(closest, margin)
        if kind != NO_EXIT:
            then, rest = interval_time(n, s + step, length, last)
            here = MarchState(then, rest, xi, v_r, a, x_0, mode, latest.used, count, closest)
            here = enter_next_mode(scene, base, ramp, leave, here, segments, log)
            _, _, xi, v_r, a, x_0, mode, used, count, closest = here
            latest, has_constants = Latest(used, UNRECORDED, x_0), False
        elif mode.entry != CHATTERING:
            mode = mode_of(mode.contact, mode.direction, mode.end_stop, mode.origin)
        stalled = 0 if base.t + step > base.t else stalled + 1
        if step >= length - s:
            n, s = n + 1, 0.0
            samples.x_r[n], samples.v_r[n], samples.d[n] = xi, v_r, mode.direction
        else:
            s += step
            latest = Latest(latest.used, UNRECORDED, x_0)
        if stalled > MAX_STALLED_EVENTS:
            return MarchState(n, s, xi, v_r, a, x_0, mode, latest.used, NO_PROGRESS, closest)
    used = latest.used
    if closes and state.n < until <= n:
        # The state at the end, after an event there.
        end = (until - 1, last_length if until > last else dt)
        used = record_segment(segments, used, end, (xi, v_r, x_0), encode_mode(mode))
    return MarchState(n, s, xi, v_r, a, x_0, mode, used, count, closest)


UNRECORDED = -2
"""Mode of the latest row of a log where a segment that begins now needs another in any case."""


class Latest(NamedTuple):
    """Number of rows in a log of segments, and mode and x_0 of the latest, as in `Segments`."""

    used: int
    mode: int
    x_0: float


@inlined
def record_mode(segments, latest, time, state, mode):
    """Write the start of a segment, unless it begins at a sample in the mode before.

    Parameters as in `record_segment`; returns the `Latest` row.
    """
    code = lasting_mode(mode)
    if latest.mode == code and latest.x_0 == state[2]:
        return latest
    used = record_segment(segments, latest.used, time, state, encode_mode(mode))
    return Latest(used, code, state[2])


@inlined
def lasting_mode(mode):
    """Return a mode as one integer, without what only the start of its segment has."""
    contact, direction, end_stop, origin, _, entry = mode
    entry = CHATTERING if entry == CHATTERING else REGULAR
    return encode_mode(Mode(contact, direction, end_stop, origin, 0, entry))


@compiled
def interval_time(n, s, length, end):
    """Return interval and time of an event; the end of an interval is the start of the next."""
    if s < length:
        return n, s
    return (n + 1, 0.0) if n < end else (n, length)


@merged
def begin_segment(scene, base, state, left):
    """Return the segment that begins in a state, `left` before the end of its interval [s]."""
    plant, law, waves, _, _ = scene
    _, _, xi, v_r, carried, x_0, mode, _, _, _ = state
    equation, ramp = mode_equation(plant, law, waves, mode, x_0, base)
    motion = start_segment(equation, waves, xi, v_r)
    free = abs(mode.direction) == 1 and not is_rigid_slip(law, mode)
    if free and mode.entry != LEAVING:
        d = motion_direction(v_r, motion.a, motion.j)
        if d == -mode.direction:
            contact, _, end_stop, origin, poised, entry = mode
            mode = Mode(contact, d, end_stop, origin, poised, entry)
            equation, ramp = mode_equation(plant, law, waves, mode, x_0, base)
            motion = start_segment(equation, waves, xi, v_r)
    creeps = False
    if mode.direction != AT_REST:
        if law.k_t == 0.0 and waves.size == 0:
            force = abs(equation.g + base.u_0) + equation.w * abs(xi)
            creeps = abs(v_r) <= cancellation_speed(equation.c, equation.w) * force
        motion = with_known_acceleration(scene, mode, motion, ramp, creeps, carried)
    return ModeSegment(mode, x_0, motion, creeps, base, ramp, min(left, ramp.left))


@merged
def with_known_acceleration(scene, mode, motion, ramp, creeps, carried):
    """Return a motion whose acceleration at the start is not the difference of large forces.

    ====================================  ====================  ============================
    motion                                acceleration          because
    ====================================  ====================  ============================
    away from a rigid stop, at first      0                     no force presses it there
    slip after a break-away               d (F_fs - F_fk) N/m   F_L = -d F_fs N
    creep                                 `carried`             the sum of forces cancels
    on an elastic contact, after an       `carried`             its force is continuous
    event that took no time
    from rest, as an elastic contact      0, not outwards       else it would yield again by
    has just ceased to yield                                    rounding
    ====================================  ====================  ============================
    """
    plant, law, waves, _, _ = scene
    v_r, a, is_carried = motion.v_r, motion.a, carried == carried
    if mode.entry == LEAVING:
        a = 0.0
    if mode.poised != 0 and is_rigid_slip(law, mode):
        limits = side_of(law, mode.contact)
        load = load_at(law, waves, ramp, 0.0)[0]
        a = mode.contact * (limits.F_fs - limits.F_fk) * load / plant.m
    if creeps and is_carried:
        c, w, _, r = motion.equation
        v_r, a = rescale(v_r, carried)
        j = r - c * a - w * v_r
        motion = Segment(motion.equation, motion.x_r, v_r, a, j, motion.k)
    elif law.k_t > 0.0 and is_carried:
        a = carried
    elif law.k_t > 0.0 and v_r == 0.0 and mode.contact == HOLD and mode.entry != LEAVING:
        a = 0.0 if mode.poised * a > 0.0 else a
    return with_acceleration(motion, a)


# The first exit from a mode.


@merged
def first_exit(scene, part, time):
    """Return the first `Exit` of a segment, which begins at a `time` after an event [s]."""
    if part.mode.entry == CHATTERING:
        return guard_chatter(scene, part)
    law = scene.law
    lift = guard_separation(law, scene.waves, part.ramp, part.mode.contact)
    if part.mode.direction == AT_REST:
        return exit_from_rest(scene, part, lift)
    return exit_from_motion(scene, part, lift, time)


@merged
def guard_chatter(scene, part):
    """Return when all rebounds are over: they accumulate at a finite time.

    The remaining time of a chatter is proportional to the rebound speed.
    """
    plant, law, waves, _, _ = scene
    mode, x_0, motion, _, base, ramp, left = part
    u = base_motion(waves, base.u_0, base.slope, 0.0)[0]
    load = load_at(law, waves, ramp, 0.0)[0]
    p, q = return_accelerations(plant, law, mode, x_0, u, load)
    duration = chatter_time(law, p, q, abs(motion.v_r))[0] if p > 0.0 else 0.0
    if duration <= left:
        return Exit(CHATTER_END, duration, motion.x_r, 0.0, math.nan, AT_REST, NEVER)
    speed = motion.v_r * (1.0 - left / duration)
    return Exit(NO_EXIT, left, motion.x_r, speed, math.nan, AT_REST, NEVER)


@merged
def exit_from_rest(scene, part, lift):
    """Return the first exit of a mass at rest; the normal force is zero at time `lift` [s]."""
    plant, law, waves, _, _ = scene
    mode, x_0, motion, _, base, ramp, left = part
    xi, v_r, until = motion.x_r, motion.v_r, min(left, lift)
    state = ModeState(mode, xi, v_r, x_0)
    stay, d, closest = guard_rest(plant, law, waves, state, base, ramp, until)
    # An exit at the end of the interval is decided in the next one.
    if stay <= until and stay < left:
        return Exit(BREAK_AWAY, stay, xi, v_r, math.nan, d, closest)
    kind = ZERO_LOAD if lift <= left else NO_EXIT
    return Exit(kind, until, xi, v_r, math.nan, d, closest)


@merged
def exit_from_motion(scene, part, lift, time):
    """Return the first exit of a moving mass; the normal force is zero at time `lift` [s].

    The segment begins at a `time` after the last event [s]. Of exits at the same time a change
    of the contact comes first, then one at a stop, then a zero of v_r, which an exit at a stop
    includes, and a zero of the normal force last.
    """
    plant, law, waves, _, _ = scene
    mode, x_0, motion, creeps, _, ramp, left = part
    equation, xi, v_r, a, j, _ = motion
    until, elastic = min(left, lift), law.k_t > 0.0
    d = mode.direction if mode.entry == LEAVING else motion_direction(v_r, a, j)
    if is_rigid_slip(law, mode):
        d = mode.contact
    if d == 0 and waves.size > 0:
        step = quiet_time(waves, equation)
        if step < until:
            # The waves move the mass, but too slowly at first to tell where to.
            x, v, _, _, _ = motion_at(equation, waves, xi, v_r, step)
            return Exit(NO_EXIT, step, x, v, math.nan, d, NEVER)
    turn, low, change, transition = NEVER, NEVER, NEVER, NEVER
    contact, end_stop, closest = HOLD, mode.end_stop, NEVER
    x, v = xi, v_r
    yields = elastic and abs(mode.contact) == 1
    # Under a constant normal force the end of a yield is the zero of v_r.
    if not yields or load_varies(law):
        turn, _, low = first_stop(motion, waves, law, d, until)
    if yields:
        change, x, v = guard_yield(motion, waves, law, ramp, mode.contact, min(turn, until))
    elif elastic and mode.contact == HOLD and (d != 0 or mode.poised == 0 or waves.size > 0):
        anchor = x_0 - origin_of(law, mode.origin)
        hold = Hold(motion, waves, law, ramp, anchor, mode.poised)
        change, contact, x, v = guard_hold(hold, d, min(turn, until))
    if d != 0:
        before = min(turn, change, until)
        transition, end_stop = guard_end_stop(motion, waves, law, mode, before)
    step = min(turn, change, transition, until)
    if step == change:
        return Exit(CONTACT_EXIT, step, x, v, a if step == 0.0 else math.nan, contact, closest)
    x, v, a_end, j_end, _ = motion_at(equation, waves, xi, v_r, step)
    side = side_of(law, d)
    if side.F_fs > side.F_fk and is_rigid_slip(law, mode):
        if step == turn:
            low = min(low, stop_depth(d * a_end, d * j_end))
        if low < NEVER:
            closest = grazing_margin(plant, side.F_fs * ramp.load, low, time + step)
    if creeps:
        v, a_end = velocity_and_acceleration(equation.c, equation.w, v_r, a, equation.r, step)
    if step == turn:
        v = 0.0
    if step == transition:
        return Exit(STOP_EXIT, step, x, v, math.nan, end_stop, closest)
    if step == turn:
        return Exit(TURN, step, x, v, math.nan, d, closest)
    if step == lift:
        return Exit(ZERO_LOAD, step, x, v, math.nan, d, closest)
    return Exit(NO_EXIT, step, x, v, math.nan if elastic else a_end, d, closest)


# The next mode.


@merged
def enter_next_mode(scene, base, ramp, leave, state, segments, log):
    """Return the state after an exit, in the mode that follows; write events to the log.

    Parameters
    ----------
    scene : Scene
    base, ramp, leave : SegmentBase, LoadRamp, Exit
        The segment that ends, and how.
    state : MarchState
        At the exit, with the mode of the segment.
    segments, log : Segments, EventLog
        Written: the events, and the velocity of an arrival at a stop.
    """
    law, waves = scene.law, scene.waves
    u_dd = base_motion(waves, base.u_0, base.slope, leave.s)[0]
    load, load_d = load_at(law, waves, ramp, leave.s)
    now = Instant(base.t + leave.s, u_dd, max(load, 0.0))
    if leave.kind == STOP_EXIT and state.mode.end_stop == APART:
        rate = force_rate_bound(scene.plant, law, waves, base.slope, ramp)
        state = reset_arrival(scene, now, rate, state, segments, log)
    elif leave.kind == STOP_EXIT:
        state = reset_stage(scene, now, leave.after, state, log)
    elif leave.kind != TURN:
        return reset_contact(scene, now, load_d, leave, state, log)
    if state.v_r == 0.0 and state.mode.direction != AT_REST:
        state = reset_stop(scene, now, state, log)
    return state


@compiled
def static_force(scene, mode, xi, u_dd):
    """Return x_r [m] and F_L [N], the force of a bumper at v_r = 0 included."""
    plant, law, _, _, _ = scene
    x_r, forces = origin_of(law, mode.origin) + xi, mode_forces(plant, law, mode, 0.0)
    return x_r, limit_force(plant, x_r, u_dd) + bumper_force(forces, xi, 0.0)


@merged
def reset_arrival(scene, now, rate, state, segments, log):
    """Return the state after an arrival at a stop, from which xi is measured then.

    `rate` bounds the rate of the force per mass [m/s³].
    """
    plant, law, _, _, _ = scene
    n, s, xi, v_r, a, x_0, mode, used, events, closest = state
    contact, d = mode.contact, mode.direction
    # Record the arrival with its velocity, which has the sign of the side even if zero.
    arrival = xi, math.copysign(max(d * v_r, 0.0), d), x_0
    used = record_segment(segments, used, (n, s), arrival, ARRIVAL)
    x_r = origin_of(law, d)
    F_L = limit_force(plant, x_r, now.u_dd)
    if law.k_s[0] > 0.0:
        events = record_event(log, events, n, s, d * CONTACT, x_r, F_L)
        mode = mode_of(contact, d, d, d)
    else:
        events = record_event(log, events, n, s, -d * IMPACT, x_r, F_L)
        if law.k_t > 0.0 and abs(contact) == 1:
            f = contact_force(mode_forces(plant, law, mode, x_0), x_r, now.load)
            x_0, contact = x_r - f / law.k_t, HOLD
        hit = ModeState(mode_of(contact, d, APART, d), 0.0, v_r, x_0)
        v_r, mode = reset_impact(plant, law, hit, now, rate)
    return MarchState(n, s, 0.0, v_r, a, x_0, mode, used, events, closest)


@merged
def reset_stage(scene, now, after, state, log):
    """Return the state after another stage of a bumper, or its end, is reached."""
    n, s, xi, v_r, a, x_0, mode, used, events, closest = state
    x_r, F_L = static_force(scene, mode, xi, now.u_dd)
    xi, mode, kind = reset_bumper(mode, after, xi)
    if kind != 0:
        events = record_event(log, events, n, s, kind, x_r, F_L)
    return MarchState(n, s, xi, v_r, a, x_0, mode, used, events, closest)


@merged
def reset_stop(scene, now, state, log):
    """Return the state after v_r = 0: the mass stays at rest, or moves on."""
    plant, law, _, _, _ = scene
    n, s, xi, v_r, a, x_0, mode, used, events, closest = state
    side, stage, released = stop_stage(mode.end_stop)
    if released:
        mode = mode_of(mode.contact, mode.direction, side * stage, mode.origin)
    mode = mode_from_rest(plant, law, mode, x_0, xi, now.u_dd, now.load)
    if law.k_t == 0.0 or mode.direction == AT_REST:
        kind = STICK if mode.direction == AT_REST else REVERSAL * mode.direction
        x_r, F_L = static_force(scene, mode, xi, now.u_dd)
        events = record_event(log, events, n, s, kind, x_r, F_L)
        closest = min(closest, rest_margin(law, mode, xi, F_L, now.load))
    return MarchState(n, s, xi, v_r, a, x_0, mode, used, events, closest)


@merged
def reset_contact(scene, now, load_d, leave, state, log):
    """Return the state after the contact changes: it yields, holds, separates or closes."""
    plant, law, _, _, _ = scene
    n, s, xi, v_r, a, x_0, mode, used, events, closest = state
    contact, d, end_stop, origin, _, _ = mode
    x_r, F_L = static_force(scene, mode, xi, now.u_dd)
    if leave.kind == CONTACT_EXIT:
        if leave.after == HOLD:
            f = contact_force(mode_forces(plant, law, mode, x_0), x_r, now.load)
            x_0 = x_r - f / law.k_t
            # A mass that has stopped moves back.
            d = d if v_r != 0.0 else -contact
        poised = contact if leave.after == HOLD else 0
        mode = Mode(leave.after, d, end_stop, origin, poised, REGULAR)
        kind = STICK if leave.after == HOLD else leave.after * SLIP
    elif leave.kind == BREAK_AWAY:
        wall = wall_side(law, mode, xi)
        mode, kind = reset_break_away(law, mode, leave.after, x_r - x_0, now.load)
        if abs(kind) == SLIP:
            F_fs = side_of(law, leave.after).F_fs
            if scene.waves.base == 0 and wall == 0 and law.step == 0.0:
                F_k, limit = F_L - plant.m * now.u_dd, sampled_limit(law, F_fs, 0.0, scene.dt)
                closest = excess_margin(plant, scene.u_dd, limit, n, F_k, leave.after, closest)
            F_L = -leave.after * F_fs * now.load
    elif leave.kind == ZERO_LOAD:
        x_0 = x_r
        before = ModeState(mode, xi, v_r, x_0)
        mode, kind = reset_zero_load(plant, law, before, now.u_dd, load_d)
    else:
        mode, kind = mode_of(contact, AT_REST, APART, origin), STICK
    events = record_event(log, events, n, s, kind, x_r, F_L)
    return MarchState(n, s, xi, v_r, a, x_0, mode, used, events, closest)


# Whole samples at a time, and short ones in power series: linear ü, constant normal force.


MODES = 4 * (MAX_STAGES + 1)
"""Equations of motion that differ in stiffness or damping."""


@compiled
def steps_index(law, mode):
    """Return the row of a moving mode in `ModeSteps`."""
    _, stage, released = stop_stage(mode.end_stop)
    index = 0 if released or law.k_s[0] == 0.0 else stage
    index = 2 * index + int(law.k_t > 0.0 and mode.contact == HOLD)
    return 2 * index + int(law.up.b != law.down.b and mode.direction < 0)


@compiled
def compute_mode_steps(plant, law, mode, dt, steps):
    """Compute the row of a moving mode in `ModeSteps`."""
    forces = mode_forces(plant, law, mode, 0.0)
    c = (forces.plant.b + forces.b_s) / plant.m
    w = (plant.k_x + forces.k_t + forces.k_s) / plant.m
    write_steps(steps.rows[steps_index(law, mode)], discretise_slip(c, w, dt))


@inlined
def known_mode_steps(plant, law, mode, dt, steps):
    """Return the index of a moving mode in `ModeSteps`, whose row is computed if need be."""
    index = steps_index(law, mode)
    if steps.rows[index][2] != dt:
        compute_mode_steps(plant, law, mode, dt, steps)
    return index


class ModeConstants(NamedTuple):
    """Constants of a motion in one mode and direction.

    Attributes
    ----------
    row : int
        Index in `ModeSteps`.
    f : float
        Constant force per mass against xi [m/s²].
    contact, end_stop : float
        Positions d·xi [m] at which a contact yields and an end stop takes over. Infinite for
        never; below any position where the change does not depend on position alone.
    grazing : float
        The `grazing_speed`; 0 unless a rigid contact slides.
    """

    row: int
    f: float
    contact: float
    end_stop: float
    grazing: float


@inlined
def mode_constants(scene, mode, x_0, steps):
    """Return the `ModeConstants` of a moving mode."""
    plant, law, _, _, dt = scene
    d = mode.direction
    index = known_mode_steps(plant, law, mode, dt, steps)
    forces, x_origin = mode_forces(plant, law, mode, x_0), origin_of(law, mode.origin)
    force = forces.F - forces.offset + forces.k_t * (x_origin - x_0)
    f = (force + plant.k_x * x_origin) / plant.m
    contact, grazing = NEVER, 0.0
    if forces.k_t > 0.0:
        contact = law.up.F_fk / law.k_t + d * (x_0 - x_origin)
    elif is_rigid_slip(law, mode):
        side, row = side_of(law, mode.contact), steps.rows[index]
        grazing = grazing_speed(row[0], row[1], dt, plant.m, side.F_fk, side.F_fs)
    side, stage, released = stop_stage(mode.end_stop)
    if stage == 0:
        end_stop = side_of(law, d).limit - d * x_origin
    elif side == d:
        end_stop = law.begins[stage] if stage < MAX_STAGES and not released else NEVER
    else:
        end_stop = -NEVER if released or law.b_s > 0.0 else -law.begins[stage - 1]
    return ModeConstants(index, f, contact, end_stop, grazing)


@compiled
def resting_mass(plant, law, mode, x_0, xi):
    """Return a mass at rest as `Rest`; a rigid stop carries any force towards it."""
    x_r = origin_of(law, mode.origin) + xi
    forces, wall = mode_forces(plant, law, mode, x_0), wall_side(law, mode, xi)
    F_k = plant.k_x * x_r + bumper_force(forces, xi, 0.0)
    rising, falling = law.down.F_fs, law.up.F_fs
    if law.k_t > 0.0 or mode.contact == FREE:
        rising = falling = 0.0
        F_k += contact_force(forces, x_r, 0.0)
    return Rest(plant.m, F_k, rising if wall >= 0 else NEVER, falling if wall <= 0 else NEVER)


@compiled
def moves_freely(law, mode, v_r):
    """Return whether the mass moves in its mode, and not from the limit of its contact."""
    if abs(mode.contact) == 1:
        return mode.contact * v_r > 0.0
    holds = law.k_t > 0.0 and mode.contact == HOLD and mode.poised == 0 and v_r != 0.0
    return holds and mode.direction * v_r > 0.0


@inlined
def advance_whole_steps(scene, until, state, constants, steps, samples):
    """Advance by whole steps while the mass stays in its mode.

    Parameters
    ----------
    scene, steps, samples
        As in `march_modes`; no waves, and a constant normal force.
    constants : ModeConstants
        Of the mode.
    until : int
        Last sample to advance to.
    state : MarchState
        At a sample, in regular motion.

    Returns
    -------
    n, closest
        The first step that may hold an event, and the smallest relative margin of a decision
        about sticking so far [-].
    """
    plant, law, _, u_dd, _ = scene
    n, _, xi, v_r, _, x_0, mode, _, _, closest = state
    if mode.direction == AT_REST:
        rest = resting_mass(plant, law, mode, x_0, xi)
        samples.x_r[n] = xi
        decides = wall_side(law, mode, xi) == 0
        n, least = advance_rest(rest, u_dd, (n, until), samples, closest if decides else 0.0)
        return n, least if decides else closest
    if not moves_freely(law, mode, v_r):
        return n, closest
    index, f, contact, end_stop, grazing = constants
    row, reach, d = read_steps(steps.rows[index]), min(contact, end_stop), mode.direction
    if not (row.fine and d * xi < reach):
        return n, closest
    motion = OneWay(d, f, reach, grazing)
    x_sums, v_sums = steps.x_sums[index], steps.v_sums[index]
    samples.x_r[n], samples.v_r[n] = xi, v_r
    while n < until:
        end = min(n - n % CHUNK + CHUNK, until)
        if steps.until[index] != end or steps.begin[index] > n:
            sum_base_motion(row.x_base, u_dd[n : end + 1], x_sums)
            sum_base_motion(row.v_base, u_dd[n : end + 1], v_sums)
            steps.begin[index], steps.until[index] = n, end
        chunk = Chunk(steps.begin[index], end, u_dd, x_sums, v_sums)
        n = advance_slip(row, chunk, n, motion, samples)
        if n < end:
            break
    return n, closest


@inlined
def slides_or_sticks(law, mode, xi):
    """Return whether a rigid contact slides or sticks apart from the stops."""
    if law.k_t > 0.0 or mode.end_stop != APART or mode.contact != mode.direction:
        return False
    return mode.direction != AT_REST or wall_side(law, mode, xi) == 0


@inlined
def advance_through_events(scene, state, steps, full, out):
    """Advance a rigid contact through the events of a step, to its end or to a stop.

    Parameters
    ----------
    scene, steps, out
        As in `march_modes`; no waves, and a constant normal force.
    state : MarchState
        In a mode of `slides_or_sticks`, which is in the log.
    full : int
        Number of rows of the logs after which to stop.

    Returns
    -------
    MarchState
        At the next sample; or with n as it was after the last event before the mass may reach
        a stop, the mode after which is not yet in the log.
    """
    plant, law, _, u_dd, dt = scene
    n, s, xi, v_r, a, x_0, mode, used, count, closest = state
    segments, log, samples = out
    d, x_origin = mode.direction, origin_of(law, mode.origin)
    up = slide_direction(plant, law, 1, x_origin, dt, steps)
    down = slide_direction(plant, law, -1, x_origin, dt, steps)
    if mode.poised != 0:
        side = side_of(law, d)
        a = d * (side.F_fs - side.F_fk) / plant.m
    elif a == a:
        v_r, a = rescale(v_r, a)
    here = step_through_events(
        Contact(plant, x_origin, up, down), u_dd,
        SlipState(n, s, xi, v_r, d, a, count, closest), log, count + full - max(used, count),
    )  # fmt: skip
    poised = mode.poised if here.events == count else 0
    for i in range(count, here.events):
        kind, s_i = log.kind[i], log.s[i]
        d = sign(kind)
        poised = d if abs(kind) == SLIP else 0
        log.n[i], log.s[i] = (n, s_i) if s_i < dt else (n + 1, 0.0)
        if i + 1 < here.events or here.n > n:
            mode = Mode(d, d, APART, mode.origin, poised, REGULAR)
            row = (log.x_r[i], 0.0, x_0)
            used = record_segment(segments, used, (log.n[i], log.s[i]), row, encode_mode(mode))
        log.x_r[i] += x_origin
    if here.n > n:
        poised = 0
        samples.x_r[here.n], samples.v_r[here.n] = here.x_r, here.v_r
        samples.d[here.n] = here.d
    mode = Mode(here.d, here.d, APART, mode.origin, poised, REGULAR)
    return MarchState(
        here.n, here.s, here.x_r, here.v_r, here.a, x_0, mode, used, here.events, here.closest
    )


@inlined
def slide_direction(plant, law, d, x_origin, dt, steps):
    """Return the `Direction` d of a rigid contact apart from the stops."""
    side = side_of(law, d)
    row = steps.rows[known_mode_steps(plant, law, mode_of(d, d, APART, 0), dt, steps)]
    return Direction(read_steps(row), side.F_fk, side.F_fs, side.limit - d * x_origin)


@inlined
def undecided_exit():
    """Return an exit that is not known yet."""
    return Exit(UNDECIDED, 0.0, math.nan, math.nan, math.nan, int(AT_REST), NEVER)


@merged
def exit_of_short_step(scene, base, state, left, constants, steps, time):
    """Return the first `Exit` from a mode in the power series of its motion.

    The exit is `UNDECIDED` where the step is too long for the series, or its start or its end
    needs more than positions and v_r.

    Parameters
    ----------
    scene, steps
        As in `march_modes`; no waves, and a constant normal force.
    base : SegmentBase
    state : MarchState
    left : float
        Time to the end of the step [s].
    constants : ModeConstants
    time : float
        Time since the last event [s].
    """
    plant, law, _, _, _ = scene
    _, _, xi, v_r, a, _, mode, _, _, _ = state
    d, rigid, yields = mode.direction, is_rigid_slip(law, mode), abs(mode.contact) == 1
    if mode.entry != REGULAR:
        return undecided_exit()
    if d == AT_REST:
        return exit_of_rest(plant, law, base, state, left)
    index, f, contact, end_stop, grazing = constants
    row = read_steps(steps.rows[index])
    c, w = row.c, row.w
    if not row.short or (yields and mode.contact != d) or (mode.poised == d and not rigid):
        return undecided_exit()
    if rigid and mode.poised != 0:
        side = side_of(law, d)
        a = d * (side.F_fs - side.F_fk) / plant.m
    elif a != a:
        a = -(base.u_0 + c * v_r + w * xi + f)
    elif law.k_t == 0.0:
        v_r, a = rescale(v_r, a)
    if not (d * v_r > 0.0 or (v_r == 0.0 and (rigid or d * a > 0.0))):
        return undecided_exit()
    if end_stop == -NEVER and keeps_touch(law, mode, (xi, v_r, a, -base.slope), row, left):
        _, stage, released = stop_stage(mode.end_stop)
        end_stop = -law.begins[stage - 1] if stage > 1 or released else NEVER
    gap, r = min(contact, end_stop) - d * xi, -d * base.slope
    if not gap > 0.0:
        return undecided_exit()
    stop, distance, v_end, low = slide(row, d * v_r, d * a, r, left, grazing)
    closest = NEVER
    if not distance < gap:
        # Both x_r and the distance of the series are monotone up to the stop.
        s, v_end = time_of_distance(row, d * v_r, d * a, r, gap, min(stop, left))
        if grazing > 0.0:
            low = lowest_speed(c, w, d * v_r, d * a, r, s)
        if low < grazing:
            closest = grazing_margin(plant, side_of(law, d).F_fs, low, time + s)
        if contact <= end_stop:
            return Exit(CONTACT_EXIT, s, d * contact, d * v_end, math.nan, d, closest)
        after = next_stage(mode)
        return Exit(STOP_EXIT, s, d * end_stop, d * v_end, math.nan, after, closest)
    x, s, kind, a_end = xi + d * distance, min(stop, left), TURN, math.nan
    after = d
    if yields and not rigid:
        kind, after = CONTACT_EXIT, HOLD
    if stop == NEVER:
        kind = NO_EXIT
        if law.k_t == 0.0 and v_end <= cancellation_threshold(row, f, x):
            _, a_end = velocity_and_acceleration(c, w, v_r, a, -base.slope, left)
    elif grazing > 0.0:
        a_stop = r * s - d * (base.u_0 + w * x + f)
        low = min(low, stop_depth(a_stop, r - c * a_stop))
    if low < grazing:
        closest = grazing_margin(plant, side_of(law, d).F_fs, low, time + s)
    return Exit(kind, s, x, d * v_end, a_end, after, closest)


@compiled
def keeps_touch(law, mode, motion, row, h):
    """Return whether a mass that moves away from a bumper provably touches it up to h [s].

    Or, if it is released, whether it provably does not. `motion` is xi, v_r, acceleration and
    rate of the force per mass, and `row` the `SlipSteps`.

    Notes
    -----
    By the bounds of `core.roots` the jerk is at most J = sqrt(j² + w a²) and the acceleration
    |a| + J s, under ü that changes linearly. They bound the curvature of the force.
    """
    xi, v_r, a, r = motion
    side, stage, released = stop_stage(mode.end_stop)
    stiffness, offset = bumper_line(law, stage)
    sense = -side if released else side
    force = sense * (stiffness * xi + law.b_s * v_r - side * offset)
    rate = sense * (stiffness * v_r + law.b_s * a)
    j = r - row.c * a - row.w * v_r
    jerk = math.sqrt(j * j + row.w * a * a)
    curvature = stiffness * (abs(a) + jerk * h) + law.b_s * jerk
    return force - h * (max(-rate, 0.0) + 0.5 * h * curvature) > 0.0


@inlined
def next_stage(mode):
    """Return the state at the stops after the position is reached at which it changes."""
    side, stage, _ = stop_stage(mode.end_stop)
    if stage == 0:
        return mode.direction
    if side == mode.direction:
        return side * (stage + 1)
    return APART if stage == 1 else mode.end_stop - side


@inlined
def time_of_distance(steps, v, a, r, distance, h):
    """Return when within a short h [s] a motion has covered a distance [m], and its speed then.

    Parameters as in `slide`; it covers at least that distance within h, and v keeps its sign.
    """
    q = velocity_series(steps.factors, v, a, r - steps.c * a - steps.w * v)
    low, high, s = 0.0, h, h
    for _ in range(MAX_BISECTIONS):
        gap = distance - series_distance(q, s)
        low, high, s, done = safeguarded_newton(low, high, s, gap, -series_velocity(q, s))
        if done:
            break
    return s, max(series_velocity(q, s), 0.0)


@inlined
def exit_of_rest(plant, law, base, state, left):
    """Return the first `Exit` of a mass at rest while ü changes linearly, for `left` [s]."""
    _, _, xi, v_r, _, x_0, mode, _, _, _ = state
    rest = resting_mass(plant, law, mode, x_0, xi)
    m, F_k, rising, falling = rest
    up, down = stick_limit(rising, F_k), stick_limit(falling, F_k)
    begin, end = m * base.u_0 + F_k, m * (base.u_0 + base.slope * left) + F_k
    s, d, closest = NEVER, AT_REST, NEVER
    if begin > up or begin < -down:
        s, d = 0.0, -sign(begin)
    elif end > up or end < -down:
        d = -sign(end)
        limit = rising if d < 0 else -falling
        s = max((limit - begin) / (m * base.slope), 0.0)
    if s < left:
        return Exit(BREAK_AWAY, s, xi, v_r, math.nan, d, closest)
    if d == AT_REST and wall_side(law, mode, xi) == 0 and end != 0.0:
        closest = decision_margin(end, rising if end > 0.0 else falling)
    return Exit(NO_EXIT, left, xi, v_r, math.nan, AT_REST, closest)
