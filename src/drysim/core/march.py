"""Event-driven march: exact propagation from event to event, without a time grid.

Problem
    With dry friction the equation of motion depends on the mode of the contact (stick, slip,
    hold, yield, separated) and of the end stops. Within a mode it is linear and has a
    closed-form solution. The time at which a mode ends, the event, must be found without
    missing an earlier one, and the solution continued in the mode that follows.

Method
    Each step of `march_modes` finds the earliest exit of the current mode within the interval
    of ü (`core.modes`, `core.roots`), propagates the closed-form motion to it, sets v_r = 0
    exactly at a stop, and decides the next mode there. An interval between two samples without
    an event is one step, or one affine map where the mass keeps its direction
    (`advance_samples`).

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

from drysim.core.compile import ZERO, compiled, inlined
from drysim.core.events import (
    CONTACT,
    IMPACT,
    MAX_EVENTS_PER_STEP,
    REVERSAL,
    SLIP,
    STICK,
    EventLog,
    decision_margin,
    direction_from_rest,
    initial_direction,
    limit_force,
    motion_direction,
    record_event,
    record_segment,
    sign,
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
from drysim.core.modes import (
    APART,
    ARRIVAL,
    AT_REST,
    CHATTERING,
    HOLD,
    LEAVING,
    REGULAR,
    RELEASED,
    UNKNOWN,
    Hold,
    Instant,
    Mode,
    ModeState,
    SegmentBase,
    bumper_force,
    chatter_time,
    contact_force,
    encode_mode,
    end_of_hold,
    end_of_yield,
    ends_at_turns,
    force_rate_bound,
    is_rigid_slip,
    leave_rest,
    load_at,
    mode_equation,
    mode_from_rest,
    mode_of,
    next_end_stop_transition,
    origin_of,
    pass_end_stop,
    pass_zero_load,
    rebound,
    rest_exit_time,
    return_accelerations,
    separation_time,
    side_of,
)
from drysim.core.oscillator import (
    FINE_STEP,
    affine_map,
    cancellation_speed,
    characteristic_rate,
    end_weights,
    flow,
)
from drysim.core.roots import (
    NEVER,
    Stuck,
    break_away_time,
    stop_time,
    stop_under_waves,
    velocity_and_acceleration,
)
from drysim.core.sampled import rescale

MAX_STALLED_EVENTS = 100
"""Steps in a row without progress in time after which double precision is exhausted."""


class Scene(NamedTuple):
    """What a march needs to know and does not change.

    Attributes
    ----------
    plant : Plant
    law : KernelLaw, CoulombLaw or DynamicLaw
    waves : Waves
    u_dd, dt : array of float, float
        Base acceleration besides the waves at the samples [m/s²], and their interval [s].
    """

    plant: Any
    law: Any
    waves: Any
    u_dd: Any
    dt: float


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


class SlipState(NamedTuple):
    """State of a march with Coulomb friction.

    Attributes
    ----------
    s : float
        Time since the start of the interval [s].
    x_r, v_r, d
        State there [m, m/s] and direction of sliding, 0 when stuck.
    events : int
        Number of events in the log; -1 if events recur without progress in time.
    closest : float
        Smallest margin of a stop decision [-]; infinite before the first.
    """

    s: float
    x_r: float
    v_r: float
    d: int
    events: int
    closest: float


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
    begin, x_r, v_r, d, count, closest = state
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
            stay, d = break_away_time(stuck, waves, left)
            if stay == NEVER:
                return SlipState(h, x_r, 0.0, 0, count, closest)
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
        stop, x_stop = stop_under_waves(segment, waves, law, d, left)
        if stop == NEVER:
            x_r, v_r, _, _, _ = motion_at(equation, waves, x_r, v_r, left)
            return SlipState(h, x_r, v_r, d, count, closest)
        begin = min(begin + stop, h)
        stalled = 0 if begin > before else stalled + 1
        if stalled > MAX_STALLED_EVENTS:
            return SlipState(begin, x_r, v_r, d, -1, closest)
        # v_r is set to zero exactly: the stop is an event, not a small velocity.
        x_r, v_r = x_stop, 0.0
        u_dd = base_motion(waves, u_begin, slope, stop)[0]
        F_L = limit_force(plant, x_r, u_dd)
        F_fs = law.F_fs * relative_normal_force(law, waves, stop)[0]
        closest = min(closest, decision_margin(F_L, F_fs))
        d = direction_from_rest(F_L, F_fs, k_x * x_r)
        kind = STICK if d == 0 else d * REVERSAL
        count = record_event(log, count, n, begin, kind, x_r, F_L)
    return SlipState(begin, x_r, v_r, d, count, closest)


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
        at = WAVE_COLUMNS * i
        u_dd += waves.values[at + A] * math.sin(waves.values[at + PHASE])
    d, F_L, margin = initial_direction(plant, law, x_r, v_r, u_dd)
    count = record_event(log, 0, 0, 0.0, d, x_r, F_L)
    return SlipState(0.0, x_r, v_r, d, count, margin)


@compiled
def march_varying_limits(scene, past, n, end, state, out, log):
    """March over samples with varying friction limits, one call of `march_sines` per step.

    Parameters
    ----------
    scene : Scene
    past : int
        Number of samples of the motion before those of the scene.
    n, end : int
        First sample, and the last one to march to.
    state : SlipState
        State at sample n.
    out : tuple of array
        Written: x_r [m], v_r [m/s] and direction of sliding at the samples.
    log : EventLog
        Written: the events.

    Returns
    -------
    n, state
        Sample reached, before `end` if the log is nearly full, and the state there.
    """
    plant, law, waves, u_dd, dt = scene
    x_out, v_out, d_out = out
    while n < end and state.events + MAX_EVENTS_PER_STEP <= len(log.n):
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        interval = Interval(n, (past + n) * dt, dt, u_dd[n], slope)
        _, x_r, v_r, d, count, closest = state
        start = SlipState(0.0, x_r, v_r, d, count, closest)
        state = march_sines(plant, law, waves, interval, start, log)
        if state.s < dt or state.events < 0:
            _, x_r, v_r, d, _, closest = state
            return n, SlipState(0.0, x_r, v_r, d, -1, closest)
        n += 1
        x_out[n] = state.x_r
        v_out[n] = state.v_r
        d_out[n] = state.d
    return n, state


# Any piecewise-linear law: from mode to mode.

MODES_LOG_RESERVE = 4
"""Segments and events that one step may add to their logs, and one final entry."""


class MarchState(NamedTuple):
    """State of a march.

    Attributes
    ----------
    n, s : int, float
        Interval of ü, and time since its start [s].
    xi, v_r, x_0 : float
        Displacement from the origin of the mode [m], velocity [m/s], and x_r at which an
        elastic contact carries no force [m].
    mode : Mode
    used, events : int
        Numbers of segments and of events in the logs; `events` is -1 if events recur without
        progress in time.
    """

    n: int
    s: float
    xi: float
    v_r: float
    x_0: float
    mode: Any
    used: int
    events: int


@compiled
def march_modes(scene, end, last_length, state, segments, log, capacity):
    """Solve a motion from mode to mode, until a log is nearly full.

    Parameters
    ----------
    scene : Scene
    end, last_length : int, float
        Last interval, and its length [s].
    state : MarchState
        Where to begin.
    segments, log : Segments, EventLog
        Written: the start of each segment, with its mode encoded, and the events.
    capacity : int
        Length of the logs.

    Returns
    -------
    MarchState
        State reached; n is above `end` at the end of the motion. A call that starts there
        continues as if uninterrupted.
    """
    plant, law, waves, u_dd, dt = scene
    n, s, xi, v_r, x_0, mode, at, count = state
    full = capacity - MODES_LOG_RESERVE
    turns_end, no_waves = ends_at_turns(law), waves.size == 0
    affine = no_waves and law.step == 0.0
    stalled = int(ZERO)
    # Where |v_r| is so small that the sum of forces cancels, the acceleration is carried from
    # interval to interval instead, as in `sampled.march`.
    a_carried = math.nan
    while n <= end and at < full and count < full:
        if affine and s == 0.0 and mode.end_stop == APART and moves_freely(law, mode, v_r):
            here = MarchState(n, s, xi, v_r, x_0, mode, at, count)
            n, xi, v_r, at = advance_samples(scene, end, here, segments, full)
            if at >= full:
                break
            if n > here.n:
                a_carried = math.nan
        length = last_length if n == end else dt
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        u_0, t = u_dd[n] + slope * s, n * dt + s
        base = SegmentBase(t, u_0, slope)
        equation, ramp = mode_equation(plant, law, waves, mode, x_0, base)
        segment = start_segment(equation, waves, xi, v_r)
        free = abs(mode.direction) == 1 and not is_rigid_slip(law, mode)
        if mode.entry == LEAVING:
            # The sum of forces is zero, and its rate leads away from the stop.
            segment = with_acceleration(segment, 0.0)
        elif free:
            d = motion_direction(v_r, segment.a, segment.j)
            if d == -mode.direction:
                mode = Mode(
                    mode.contact, d, mode.end_stop, mode.origin, mode.poised, mode.entry
                )
                equation, ramp = mode_equation(plant, law, waves, mode, x_0, base)
                segment = start_segment(equation, waves, xi, v_r)
        c, w, g, r = equation
        at = record_segment(segments, at, (n, s), (xi, v_r, x_0), encode_mode(mode))
        left = min(length - s, ramp.left)
        lift = separation_time(law, waves, ramp, t, mode.contact)
        until = min(left, lift)
        x_origin = origin_of(law, mode.origin)
        # Time and kind of the first exit. `stop` is a zero of v_r, or the end of rest.
        stop, change, transition = NEVER, NEVER, NEVER
        side, after, direction = HOLD, mode.end_stop, 0
        x, v = xi, v_r
        a, creeping = segment.a, False
        if mode.entry == CHATTERING:
            # The impacts accumulate at a finite time and are solved as one segment.
            u = base_motion(waves, u_0, slope, 0.0)[0]
            load = load_at(law, waves, ramp, 0.0)[0]
            p, q = return_accelerations(plant, law, mode, x_0, u, load)
            duration = chatter_time(law, p, q, abs(v_r))[0] if p > 0.0 else 0.0
            step = min(duration, left)
            # The remaining time of a chatter is proportional to the rebound speed.
            v_r *= 1.0 - step / duration if duration > left else 0.0
            if duration <= left:
                mode = mode_of(mode.contact, AT_REST, APART, mode.origin)
                F_L = limit_force(plant, x_origin, u)
                then, ends = interval_time(n, s + step, length, end)
                count = record_event(log, count, then, ends, STICK, x_origin, F_L)
            n, s, stalled = next_time(n, s, step, length, t, stalled)
            if stalled > MAX_STALLED_EVENTS:
                return MarchState(n, s, xi, v_r, x_0, mode, at, -1)
            continue
        if mode.direction == AT_REST:
            state = ModeState(mode, xi, v_r, x_0)
            stop, direction = rest_exit_time(plant, law, waves, state, base, ramp, until)
            # An exit at the end of the interval is decided in the next one.
            stop = stop if stop < left else NEVER
        else:
            # At a break-away F_L = ±F_fs N, so the acceleration is known without cancellation.
            if mode.poised != 0 and is_rigid_slip(law, mode):
                limits = side_of(law, mode.contact)
                load = load_at(law, waves, ramp, 0.0)[0]
                a = mode.contact * (limits.F_fs - limits.F_fk) * load / plant.m
            if law.k_t == 0.0:
                creeping = no_waves and abs(v_r) <= cancellation_speed(c, w) * (
                    abs(g + u_0) + w * abs(xi)
                )
                if creeping and a_carried == a_carried:
                    v_r, a = rescale(v_r, a_carried)
                    segment = Segment(equation, xi, v_r, a, r - c * a - w * v_r, segment.k)
            elif a_carried == a_carried:
                # The force of an elastic contact is continuous over events that take no time.
                a = a_carried
            elif v_r == 0.0 and mode.poised * a > 0.0 and ceases_to_yield(mode):
                # It does not yield again by rounding of forces.
                a = 0.0
            segment = with_acceleration(segment, a)
            d = mode.contact
            if not is_rigid_slip(law, mode):
                d = motion_direction(v_r, a, segment.j)
            d = mode.direction if mode.entry == LEAVING else d
            if law.k_t == 0.0 or (turns_end and d != 0):
                stop = stop_time(segment, waves, law, d, until)
            rests = d == 0 and mode.poised != 0 and no_waves
            if law.k_t > 0.0 and mode.contact == HOLD and not rests:
                hold = Hold(segment, waves, law, ramp, x_0 - x_origin, mode.poised)
                change, side, x, v = end_of_hold(hold, min(stop, until))
            elif law.k_t > 0.0 and abs(mode.contact) == 1:
                change, x, v = end_of_yield(
                    segment, waves, law, ramp, mode.contact, min(stop, until)
                )
            if turns_end and d != 0:
                transition, after = next_end_stop_transition(
                    segment, waves, law, mode, min(stop, change, until)
                )
        step = min(stop, change, transition, until)
        before = v_r
        if step == change:
            xi, v_r = x, v
            a_carried = a if step == 0.0 else math.nan
        elif mode.direction != AT_REST:
            xi, v_r, a_carried, _, _ = motion_at(equation, waves, xi, v_r, step)
            if creeping:
                v_r, a_carried = velocity_and_acceleration(c, w, before, a, r, step)
            v_r = 0.0 if step == stop else v_r
        if law.k_t > 0.0 and step != change:
            a_carried = math.nan
        if step in (stop, change, transition, lift):
            a_carried = a_carried if law.k_t > 0.0 else math.nan
            then, ends = interval_time(n, s + step, length, end)
            u = base_motion(waves, u_0, slope, step)[0]
            load, load_d = load_at(law, waves, ramp, step)
            load = max(load, 0.0)
            x_r = x_origin + xi
            F_L = limit_force(plant, x_r, u) + bumper_force(law, mode, xi, 0.0)
            d, contact = mode.direction, mode.contact
            if step == change:
                contact = side
                if contact == HOLD:
                    x_0 = x_r - contact_force(law, mode, x_r, x_0, load) / law.k_t
                poised = mode.contact if contact == HOLD else 0
                mode = Mode(contact, d, mode.end_stop, mode.origin, poised, REGULAR)
                kind = STICK if contact == HOLD else contact * SLIP
                count = record_event(log, count, then, ends, kind, x_r, F_L)
            elif d == AT_REST and step == stop:
                mode, kind = leave_rest(law, mode, direction, x_r - x_0, load)
                if abs(kind) == SLIP:
                    F_L = -direction * side_of(law, direction).F_fs * load
                count = record_event(log, count, then, ends, kind, x_r, F_L)
            elif step in (transition, stop):
                if step == transition and mode.end_stop == APART:
                    # Record the arrival with its velocity, then measure xi from the stop.
                    v = max(d * v_r, 0.0) * d
                    at = record_segment(segments, at, (then, ends), (xi, v, x_0), ARRIVAL)
                    xi, x_origin = 0.0, origin_of(law, d)
                    F_L = limit_force(plant, x_origin, u)
                    if law.k_s[0] > 0.0:
                        mode = mode_of(contact, d, d, d)
                        count = record_event(log, count, then, ends, d * CONTACT, x_origin, F_L)
                    else:
                        count = record_event(log, count, then, ends, -d * IMPACT, x_origin, F_L)
                        if law.k_t > 0.0 and abs(contact) == 1:
                            f = contact_force(law, mode, x_origin, x_0, load)
                            x_0, contact = x_origin - f / law.k_t, HOLD
                        mode = mode_of(contact, d, APART, d)
                        state = ModeState(mode, xi, v_r, x_0)
                        rate = force_rate_bound(plant, law, waves, slope, ramp)
                        v_r, mode = rebound(plant, law, state, Instant(t + step, u, load), rate)
                elif step == transition:
                    xi, mode, kind = pass_end_stop(mode, after, xi)
                    if kind != 0:
                        count = record_event(log, count, then, ends, kind, x_r, F_L)
                else:
                    mode = mode_of(contact, d, mode.end_stop, mode.origin)
                if mode.direction != AT_REST and (step == stop or v_r == 0.0):
                    if abs(mode.end_stop) > RELEASED:
                        touching = mode.end_stop - sign(mode.end_stop) * RELEASED
                        mode = mode_of(contact, d, touching, mode.origin)
                    mode = mode_from_rest(plant, law, mode, x_0, xi, u, load)
                    x_r = x_origin + xi
                    F_L = limit_force(plant, x_r, u) + bumper_force(law, mode, xi, 0.0)
                    if law.k_t == 0.0 or mode.direction == AT_REST:
                        kind = STICK if mode.direction == AT_REST else REVERSAL * mode.direction
                        count = record_event(log, count, then, ends, kind, x_r, F_L)
            else:
                x_0 = x_r
                state = ModeState(mode, xi, v_r, x_0)
                mode, kind = pass_zero_load(plant, law, state, u, load_d)
                count = record_event(log, count, then, ends, kind, x_r, F_L)
        elif mode.poised != 0 or mode.entry != REGULAR:
            mode = mode_of(mode.contact, mode.direction, mode.end_stop, mode.origin)
        n, s, stalled = next_time(n, s, step, length, t, stalled)
        if stalled > MAX_STALLED_EVENTS:
            return MarchState(n, s, xi, v_r, x_0, mode, at, -1)
    if n > end and turns_end:
        last = end, last_length
        at = record_segment(segments, at, last, (xi, v_r, x_0), encode_mode(mode))
    return MarchState(n, s, xi, v_r, x_0, mode, at, count)


@compiled
def next_time(n, s, step, length, t, stalled):
    """Return interval and time after a step, and the number of steps without progress."""
    stalled = 0 if t + step > t else stalled + 1
    if step >= length - s:
        return n + 1, 0.0, stalled
    return n, s + step, stalled


@compiled
def interval_time(n, s, length, end):
    """Return interval and time of an event; the end of an interval is the start of the next."""
    if s < length:
        return n, s
    return (n + 1, 0.0) if n < end else (n, length)


@compiled
def ceases_to_yield(mode):
    """Return whether an elastic contact has just ceased to yield and is still at its limit."""
    return mode.contact == HOLD and mode.poised != 0 and mode.entry != LEAVING


@compiled
def moves_freely(law, mode, v_r):
    """Return whether the mass moves in its mode, and not from the limit of its contact."""
    if abs(mode.contact) == 1:
        return mode.contact * v_r > 0.0
    holds = law.k_t > 0.0 and mode.contact == HOLD and mode.poised == 0 and v_r != 0.0
    return holds and (mode.direction == UNKNOWN or mode.direction * v_r > 0.0)


@compiled
def advance_samples(scene, end, state, segments, full):
    """Advance by whole samples while v_r keeps its sign and the contact its mode.

    Parameters
    ----------
    scene, segments
        As in `march_modes`; no waves, and a constant normal force.
    end : int
        Number of the last step.
    state : MarchState
        At a sample, apart from the stops.
    full : int
        Most segments there may be.

    Returns
    -------
    n, xi, v_r, used
        The first step that may hold an event, the state there, and the number of segments.

    Notes
    -----
    Each step is one affine map. A fine step holds at most one extremum of v_r, so the
    acceleration at both ends shows any dip of v_r, and xi is monotone in a step without one.
    """
    plant, law, _, u_dd, dt = scene
    n, _, xi, v_r, x_0, mode, at, _ = state
    direction = sign(v_r)
    side, code = side_of(law, direction), encode_mode(mode)
    x_origin = origin_of(law, mode.origin)
    low, high = -law.down.limit - x_origin, law.up.limit - x_origin
    if mode.contact == HOLD:
        x_limit = law.up.F_fk / law.k_t
        low, high = max(low, x_0 - x_limit - x_origin), min(high, x_0 + x_limit - x_origin)
        c, w = side.b / plant.m, (plant.k_x + law.k_t) / plant.m
        f = (plant.k_x * x_origin + law.k_t * (x_origin - x_0)) / plant.m
    else:
        c, w = side.b / plant.m, plant.k_x / plant.m
        f = mode.contact * side.F_fk / plant.m + w * x_origin
    if characteristic_rate(c, w) * dt > FINE_STEP:
        return n, xi, v_r, at
    x_x, x_v, x_f, v_x, v_v, v_f = affine_map(c, w, f, dt)
    y, _, Y, YY = flow(c, w, dt)
    x_before, x_after, v_before, v_after = end_weights(y, Y, YY, dt)
    a = -(u_dd[n] + c * v_r + w * xi + f)
    threshold = cancellation_speed(c, w)
    while n < end and at < full:
        u_0 = u_dd[n]
        u_1 = u_dd[n + 1]
        x = x_x * xi + x_v * v_r - (x_before * u_0 + x_after * u_1 + x_f)
        v = v_x * xi + v_v * v_r - (v_before * u_0 + v_after * u_1 + v_f)
        a_end = -(u_1 + c * v + w * x + f)
        is_slow = direction * v <= threshold * (abs(f) + w * abs(x))
        if is_slow or (direction * a < 0.0 and direction * a_end > 0.0) or not low < x < high:
            break
        at = record_segment(segments, at, (n, 0.0), (xi, v_r, x_0), code)
        n += 1
        xi, v_r, a = x, v, a_end
    return n, xi, v_r, at
