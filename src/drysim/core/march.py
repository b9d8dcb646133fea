"""Event-driven march: exact propagation from event to event, without a time grid.

Problem
    With dry friction the equation of motion depends on the mode of the contact (stick, slip,
    hold, yield, separated, at a stop). Within a mode it is linear and has a closed-form
    solution. The time at which a mode ends, the event, must be found without missing an earlier
    one, and the solution continued in the mode that follows.

Method
    Each step of a march finds the earliest exit of the current mode within the interval of ü
    (`core.roots`, `core.modes`), propagates the closed-form motion to it, sets v_r = 0 exactly
    at a stop, and decides the next mode there. An interval between two samples without an event
    is one step. There is one kernel per setting:

    - `march_sines`: Coulomb friction under waves, friction limits that vary included;
    - `march_elastic`: an elastic contact that holds, yields and separates;
    - `march_stops`: Coulomb friction between end stops;
    - `march_normal_force`: Coulomb friction under a normal force that may vanish or is
      recorded.

    Sampled motion under constant limits has a faster march, `core.sampled`.

Why nothing is missed
    The exit searches return the first root of their observable, proved by bounds on its
    derivatives. There is no velocity tolerance: a stop is a root of v_r, and the mode is part
    of the state. An event may be followed by another at the same time; `MAX_STALLED_EVENTS` of
    them in a row mean that double precision does not resolve the motion, and the march reports
    it.
"""

from __future__ import annotations

import math

from drysim.core.compile import compiled, inlined
from drysim.core.events import (
    CONTACT,
    FORCE_ROUNDING,
    LIFT,
    LOG_RESERVE,
    MAX_EVENTS_PER_STEP,
    REVERSAL,
    SLIP,
    STICK,
    EventLog,
    decision_margin,
    initial_mode,
    limit_force,
    motion_direction,
    record_event,
    record_segment,
    sign,
)
from drysim.core.forcing import (
    V_R,
    X_R,
    base_motion,
    motion_at,
    relative_normal_force,
    set_phases,
    start_segment,
    unpack_scene,
)
from drysim.core.model import CoulombLaw, Plant
from drysim.core.modes import (
    APART,
    ARRIVAL,
    AT_LIMIT,
    BREAKING_AWAY,
    BUMPER_AT_ZERO,
    BUMPER_STEADY,
    CHATTERING,
    FREE,
    HOLD,
    SEPARATED,
    TOUCHING,
    arrival_time,
    begin_segment,
    bumper_acts,
    bumper_zero_time,
    chatter_time,
    closing_mode,
    closing_time,
    contact_force,
    decode_beginning,
    decode_direction,
    decode_stop_state,
    encode_mode,
    end_of_hold,
    end_of_yield,
    is_holding,
    load_at,
    load_ramp_at,
    next_zero_load,
    rebound,
    release_bumper,
    rest_exit_time,
    restoring_force,
    return_accelerations,
    separation_time,
    stick_or_slide,
)
from drysim.core.oscillator import cancellation_speed
from drysim.core.roots import (
    NEVER,
    break_away_time,
    locate_stop,
    slip_exit_time,
    velocity_and_acceleration,
)
from drysim.core.sampled import advance_between_stops, rescale

MAX_STALLED_EVENTS = 100
"""Events in a row without progress in time after which double precision is exhausted."""


# Coulomb friction under waves: slip, stop, stick, break away.


@compiled
def march_sines(
    plant, law, waves, u_0, slope, n, t, h, begin, x_r, v_r, d, log, count, capacity
):
    """Solve one interval with Coulomb friction from event to event.

    The march stops early when the log is nearly full.

    Parameters
    ----------
    plant, law : Plant, CoulombLaw
    waves : Waves
    u_0, slope : float
        Part of ü besides the waves at the start of the interval [m/s²], and its rate [m/s³].
    n : int
        Index of the interval, for the log.
    t, h : float
        Start and length of the interval [s].
    begin : float
        Start of the solution within the interval [s].
    x_r, v_r, d
        State there [m, m/s] and direction of sliding, 0 when stuck.
    log : EventLog
    count, capacity : int
        Number of events in the log, and its length.

    Returns
    -------
    begin, x_r, v_r, d, count, closest
        Time reached within the interval and state there, number of events in the log (-1 if
        events recur without progress in time), smallest margin of a stop decision [-]. A call
        that starts from the returned state continues as if uninterrupted.

    Notes
    -----
    With F_fs = F_fk a slip starts with zero relative acceleration. The acceleration just after
    a break-away is therefore set to d (F_fs - F_fk) N/m exactly instead of evaluated with
    rounding.
    """
    m, k_x, b = plant
    c = b / m
    w = k_x / m
    closest = NEVER
    just_broke_away = False
    stalled = 0
    while begin < h and (just_broke_away or count + 2 <= capacity):
        before = begin
        set_phases(waves, plant, law, t + begin, d)
        u_begin = u_0 + slope * begin
        left = h - begin
        if d == 0:
            stay, d = break_away_time(plant, law, waves, x_r, u_begin, slope, slope, left)
            if stay == NEVER:
                return h, x_r, 0.0, 0, count, closest
            begin = min(begin + stay, h)
            load = relative_normal_force(law, waves, stay)[0]
            count = record_event(log, count, n, begin, d * SLIP, x_r, -d * law.F_fs * load)
            just_broke_away = True
            continue
        u_dd, rate, _ = base_motion(waves, u_begin, slope, 0.0)
        load, load_d, _ = relative_normal_force(law, waves, 0.0)
        if just_broke_away:
            a = d * (law.F_fs - law.F_fk) * load / m
        else:
            a = -(u_dd + c * v_r + w * x_r + d * law.F_fk * load / m)
        just_broke_away = False
        j = -rate - d * law.F_fk * load_d / m - c * a - w * v_r
        g = -u_begin - d * law.F_fk / m
        stop, x_stop = slip_exit_time(c, w, waves, x_r, v_r, a, j, g, -slope, d, left)
        if stop == NEVER:
            x_r, v_r, _, _ = motion_at(c, w, waves, x_r, v_r, g, -slope, left)
            return h, x_r, v_r, d, count, closest
        begin = min(begin + stop, h)
        stalled = 0 if begin > before else stalled + 1
        if stalled > MAX_STALLED_EVENTS:
            return begin, x_r, v_r, d, -1, closest
        # v_r is set to zero exactly: the stop is an event, not a small velocity.
        x_r, v_r = x_stop, 0.0
        u_dd = base_motion(waves, u_begin, slope, stop)[0]
        F_L = limit_force(plant, x_r, u_dd)
        F_fs = law.F_fs * relative_normal_force(law, waves, stop)[0]
        closest = min(closest, decision_margin(F_L, F_fs))
        # Equality sticks, to within the rounding of F_L.
        if abs(F_L) <= F_fs + FORCE_ROUNDING * (F_fs + abs(k_x * x_r)):
            d = 0
            count = record_event(log, count, n, begin, STICK, x_r, F_L)
        else:
            d = -sign(F_L)
            count = record_event(log, count, n, begin, d * REVERSAL, x_r, F_L)
    return begin, x_r, v_r, d, count, closest


@compiled
def march_sines_from_start(scene, end, log, kind):
    """Solve a scene under waves alone from t = 0 to `end` [s], or until the log is nearly full.

    `scene` is an array as in `drysim.core.forcing` with its waves; `log` holds the rows of an
    event log as one array and `kind` its kinds. Returns as `march_sines`; `closest` includes
    the margin of the initial mode.
    """
    plant, law, waves = unpack_scene(scene)
    x_r, v_r = scene[X_R], scene[V_R]
    capacity = len(kind)
    log = EventLog(log[0], log[1], kind, log[2], log[3])
    set_phases(waves, plant, law, 0.0, 0)
    u_dd = base_motion(waves, 0.0, 0.0, 0.0)[0]
    d, F_L, margin = initial_mode(plant, law, x_r, v_r, u_dd)
    count = record_event(log, 0, 0, 0.0, d, x_r, F_L)
    begin, x_r, v_r, d, count, closest = march_sines(
        plant, law, waves, 0.0, 0.0, 0, 0.0, end, 0.0, x_r, v_r, d, log, count, capacity
    )
    return begin, x_r, v_r, d, count, min(closest, margin)


@compiled
def march_varying_limits(
    plant, law, waves, past, u_dd, dt, n, end, x_r, v_r, d, x_out, v_out, d_out, log, count, cap
):
    """March over samples with varying friction limits, one call of `march_sines` per step.

    Parameters as in `sampled.march`. `past` is the number of samples of the motion before the
    given ones and `cap` the capacity of the log.
    """
    closest = NEVER
    while n < end and count + MAX_EVENTS_PER_STEP <= cap:
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        reached, x_r, v_r, d, count, margin = march_sines(
            plant, law, waves, u_dd[n], slope, n, (past + n) * dt, dt, 0.0, x_r, v_r, d, log,
            count, cap
        )  # fmt: skip
        closest = min(closest, margin)
        if reached < dt or count < 0:
            return n, x_r, v_r, d, -1, closest
        n += 1
        x_out[n] = x_r
        v_out[n] = v_r
        d_out[n] = d
    return n, x_r, v_r, d, count, closest


# Elastic contact: hold, yield, separate, close.


@compiled
def march_elastic(
    plant, law, waves, u_dd, dt, n, s, h, end, x_r, v_r, x_0, mode, segments, at, log, count,
    capacity,
):  # fmt: skip
    """Solve the motion over an elastic contact from interval to interval.

    The march stops early when one of the logs is nearly full. Parameters and returns as in
    `march_taylor`, with the displacement x_0 at which the contact carries no force [m] in place
    of z, and the mode in place of the direction.
    """
    stalled = 0
    full = capacity - LOG_RESERVE
    while n <= end and at < full and count < full:
        length = h if n == end else dt
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        t = n * dt + s
        u_0 = u_dd[n] + slope * s
        at = record_segment(segments, at, n, s, x_r, v_r, x_0, mode)
        left = length - s
        c, w, f = begin_segment(plant, law, waves, mode, x_0, t)
        segment = start_segment(c, w, waves, x_r, v_r, -u_0 - f, -slope)
        change, after, x, v = mode_exit(law, waves, segment, mode, x_0, left, t)
        step = min(change, left)
        stalled = 0 if t + step > t else stalled + 1
        if stalled > MAX_STALLED_EVENTS:
            return n, s, x_r, v_r, x_0, mode, at, -1
        # The exit search returns the state at its root, with v_r = 0 exactly after a yield.
        if change < NEVER and mode != FREE and after != FREE:
            x_r, v_r = x, v
        else:
            x_r, v_r, _, _ = motion_at(c, w, waves, x_r, v_r, segment.g, -slope, step)
        if change < NEVER:
            F_L = limit_force(plant, x_r, base_motion(waves, u_0, slope, step)[0])
            load = relative_normal_force(law, waves, step)[0]
            force = contact_force(law, mode, x_r, x_0, max(load, 0.0))
            mode, x_0 = next_mode(law, waves, mode, after, x_r, v_r, x_0, force, step)
            kind = LIFT if mode == FREE else (STICK if is_holding(mode) else mode * SLIP)
            count = record_event(log, count, n, min(s + step, length), kind, x_r, F_L)
        elif abs(mode) == AT_LIMIT:
            mode = HOLD
        if step >= left:
            n += 1
            s = 0.0
        else:
            s += step
    return n, s, x_r, v_r, x_0, mode, at, count


@compiled
def mode_exit(law, waves, segment, mode, x_0, left, t):
    """Return when within `left` [s] a mode ends, the mode that follows, and the state then.

    The mode starts at time t [s]; parameters as in `end_of_hold`. The state is not computed
    where surfaces separate or close, which does not depend on the motion.
    """
    until = min(next_zero_load(law, waves, t, mode != FREE), left)
    change, after, x, v = NEVER, HOLD, segment.x_r, segment.v_r
    if is_holding(mode):
        poised = sign(mode) if mode != HOLD else 0
        change, after, x, v = end_of_hold(segment, waves, law, x_0, poised, until)
    elif mode != FREE:
        change, x, v = end_of_yield(segment, waves, law, mode, until)
    if until < left and until <= change:
        return until, HOLD if mode == FREE else FREE, x, v
    return change, after, x, v


@compiled
def next_mode(law, waves, mode, after, x_r, v_r, x_0, force, s):
    """Return the mode that follows, and the x_r at which its contact carries no force."""
    if after == FREE:
        return FREE, x_r
    if mode == FREE:
        return closing_mode(law, v_r, law.F_fk * relative_normal_force(law, waves, s)[1]), x_r
    if after == HOLD:
        return mode * AT_LIMIT, x_r - force / law.k_t
    return after, x_0


# End stops: slip, stop, reach an end stop, leave it.


STOPS_LOG_RESERVE = 4
"""Segments and events that one step may add to their logs, and one final entry."""


@compiled
def march_stops(
    plant,
    law,
    waves,
    u_dd,
    dt,
    n,
    s,
    h,
    end,
    xi,
    v_r,
    z,
    mode,
    segments,
    at,
    log,
    count,
    capacity,
):
    """Solve the motion between end stops from interval to interval.

    The march stops early when one of the logs is nearly full. Parameters and returns as in
    `march_elastic`, with x_r = z + xi: z is the position of the stop that acts (0 if none), and
    xi keeps the full precision of a small distance from it.
    """
    stalled = 0
    full = capacity - STOPS_LOG_RESERVE
    m = plant.m
    # Where |v_r| is so small that the sum of forces cancels, the acceleration is carried from
    # interval to interval instead, as in `advance_creep`.
    a_carried = math.nan
    no_waves = waves.size == 0
    while n <= end and at < full and count < full:
        touch, d, fresh = (
            decode_stop_state(mode),
            decode_direction(mode),
            decode_beginning(mode),
        )
        # Sampled slip clear of the stops: whole steps by an affine map while no event is near.
        if no_waves and s == 0.0 and touch == APART and d * v_r > 0.0:
            f = d * law.F_fk / m + plant.k_x / m * z
            low, high = -law.x_rM - z, law.x_rM - z
            n, xi, v_r, at = advance_between_stops(
                plant, u_dd, dt, n, end, xi, v_r, f, low, high, segments, at, full, z, mode
            )
            if at >= full:
                break
        length = h if n == end else dt
        left = length - s
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        u_0 = u_dd[n] + slope * s
        t = n * dt + s
        at = record_segment(segments, at, n, s, xi, v_r, z, mode)
        c, w, g = begin_stops_segment(plant, law, waves, mode, z, u_0, t)
        # Chatter: the impacts accumulate at a finite time and are solved as one segment.
        if fresh == CHATTERING:
            F_L = m * base_motion(waves, u_0, slope, 0.0)[0] + plant.k_x * z
            load = relative_normal_force(law, waves, 0.0)[0]
            p, q = return_accelerations(plant, law, 1 if z > 0.0 else -1, F_L, load)
            duration = chatter_time(law, p, q, abs(v_r))[0] if p > 0.0 else 0.0
            step = min(duration, left)
            # The remaining time of a chatter is proportional to the rebound speed.
            v_r *= 1.0 - step / duration if duration > left else 0.0
            if duration <= left:
                mode = encode_mode(APART, 0, BUMPER_STEADY)
                then, ends = interval_time(n, s + step, length, end)
                count = record_event(log, count, then, ends, STICK, z, F_L)
        elif d == 0:
            step, direction = rest_exit_time(plant, law, waves, touch, z, xi, u_0, slope, left)
            # An exit at the end of the interval is decided in the next one.
            if step < left:
                touch = touch if bumper_acts(law, touch) else APART
                mode = encode_mode(touch, direction, BREAKING_AWAY)
                F_L = -direction * law.F_fs * relative_normal_force(law, waves, step)[0]
                count = record_event(log, count, n, s + step, direction * SLIP, z + xi, F_L)
        else:
            _, _, a, j = motion_at(c, w, waves, xi, v_r, g, -slope, 0.0)
            # At a break-away F_L = ±F_fs, so the acceleration is known without cancellation.
            if fresh == BREAKING_AWAY:
                load = relative_normal_force(law, waves, 0.0)[0]
                a_exact = d * (law.F_fs - law.F_fk) * load / m
                j -= c * (a_exact - a)
                a = a_exact
            creeping = no_waves and abs(v_r) <= cancellation_speed(c, w) * (
                abs(g + u_0) + w * abs(xi)
            )
            if creeping and a_carried == a_carried:
                v_r, a = rescale(v_r, a_carried)
            exit_time = slip_end_time(c, w, waves, xi, v_r, a, j, g, -slope, d, left)
            change, after = next_stop_transition(
                c, w, waves, law, xi, v_r, g, -slope, z, touch, d, fresh == BUMPER_AT_ZERO,
                min(exit_time, left),
            )  # fmt: skip
            step = min(exit_time, change, left)
            before = v_r
            xi, v_r, a_carried, _ = motion_at(c, w, waves, xi, v_r, g, -slope, step)
            if creeping:
                v_r, a_carried = velocity_and_acceleration(c, w, before, a, -slope, step)
            v_r = 0.0 if step == exit_time else v_r
            mode = encode_mode(touch, d, BUMPER_STEADY)
            if step in (change, exit_time):
                a_carried = math.nan
                then, ends = interval_time(n, s + step, length, end)
                u_then = base_motion(waves, u_0, slope, step)[0]
                load = relative_normal_force(law, waves, step)[0]
                # Record the arrival with its velocity, then measure xi from the stop.
                if step == change and touch == APART:
                    at = record_segment(
                        segments, at, then, ends, xi, max(d * v_r, 0.0) * d, z, ARRIVAL
                    )
                    z = d * law.x_rM
                    xi = 0.0
                    mode = encode_mode(after, d, BUMPER_STEADY)
                    if law.k_s > 0.0:
                        F_L = restoring_force(plant, law, APART, z, xi) + m * u_then
                        count = record_event(log, count, then, ends, d * CONTACT, z, F_L)
                    else:
                        v_r, mode, count = rebound(
                            plant, law, waves, slope, then, ends, t + step, v_r, z, d, u_then,
                            load, log, count,
                        )  # fmt: skip
                elif step == change:
                    F_L = restoring_force(plant, law, touch, z, xi) + m * u_then
                    xi, mode, count = release_bumper(
                        touch, after, d, then, ends, z, xi, F_L, log, count
                    )
                if decode_direction(mode) != 0 and (
                    step == exit_time or (v_r == 0.0 and law.k_s == 0.0)
                ):
                    mode, count = stick_or_slide(
                        plant, law, then, ends, xi, z, mode, u_then, load, log, count
                    )
        step = min(step, left)
        stalled = 0 if t + step > t else stalled + 1
        if stalled > MAX_STALLED_EVENTS:
            return n, s, xi, v_r, z, mode, at, -1
        if step >= left:
            n += 1
            s = 0.0
        else:
            s += step
    if n > end:
        at = record_segment(segments, at, end, h, xi, v_r, z, mode)
    return n, s, xi, v_r, z, mode, at, count


@compiled
def interval_time(n, s, length, end):
    """Return interval and time of an event; the end of an interval is the start of the next."""
    if s < length:
        return n, s
    return (n + 1, 0.0) if n < end else (n, length)


@compiled
def begin_stops_segment(plant, law, waves, mode, z, u_0, t):
    """Set the phases for a segment from time t [s]; return c, w and the force per mass g."""
    touch, d = decode_stop_state(mode), decode_direction(mode)
    k, b = plant.k_x, plant.b
    if bumper_acts(law, touch):
        k += law.k_s
        b += law.b_s
    m = plant.m
    set_phases(waves, Plant(m, k, b), law, t, d)
    return b / m, k / m, -u_0 - d * law.F_fk / m - plant.k_x / m * z


@compiled
def next_stop_transition(c, w, waves, law, xi, v_r, g, r, z, touch, d, poised, until):
    """Return when the mass reaches a stop, or a bumper releases or acts again, else infinity.

    Returns also the state relative to the stops that follows.
    """
    if touch == APART:
        far = law.x_rM - d * z
        return arrival_time(c, w, waves, xi, v_r, g, r, d, far, until), d * TOUCHING
    side = 1 if touch > 0 else -1
    if abs(touch) == SEPARATED:
        felt = bumper_zero_time(c, w, waves, law, xi, v_r, g, r, -side, poised, until)
        separation = arrival_time(c, w, waves, xi, v_r, g, r, d, 0.0, min(felt, until))
        return (separation, APART) if separation < felt else (felt, side * TOUCHING)
    if side == d:
        return NEVER, touch
    if law.b_s == 0.0:
        return arrival_time(c, w, waves, xi, v_r, g, r, d, 0.0, until), APART
    return bumper_zero_time(
        c, w, waves, law, xi, v_r, g, r, side, poised, until
    ), side * SEPARATED


@inlined
def slip_end_time(c, w, waves, x_r, v_r, a, j, g, r, direction, h):
    """Return the first time in (0, h] at which v_r is zero, or infinity."""
    if direction == 0:
        return NEVER
    if waves.size == 0:
        return locate_stop(c, w, direction * v_r, direction * a, direction * r, h)
    return slip_exit_time(c, w, waves, x_r, v_r, a, j, g, r, direction, h)[0]


# Coulomb friction under a normal force that may vanish or is recorded: slip, stick, separate.
#
# ü and the normal force are linear between their samples, so the equation of slip has linear
# forcing, and the stick limits F_fs N(t) are linear, as in `march_sines` without waves.


STUCK, LIFTED_OFF, BREAK_AWAY = 0, 3, 2
"""Modes besides slip in direction +1 or -1: stuck; separated; or, times the direction, the
start of a slip at a break-away."""


@compiled
def march_normal_force(
    plant, law, waves, u_dd, dt, n, s, h, end, x_r, v_r, z, mode, segments, at, log, count,
    capacity,
):  # fmt: skip
    """Solve the motion under a normal force that may vanish or is recorded.

    The march stops early when one of the logs is nearly full. Parameters and returns as in
    `march_taylor`, with the mode in place of the direction; z is passed through unused.
    """
    stalled = 0
    full = capacity - LOG_RESERVE
    # Where |v_r| is so small that the sum of forces cancels, the acceleration is carried from
    # interval to interval instead, as in `advance_creep`.
    a_carried = math.nan
    c, w = plant.b / plant.m, plant.k_x / plant.m
    while n <= end and at < full and count < full:
        length = h if n == end else dt
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        t = n * dt + s
        u_0 = u_dd[n] + slope * s
        at = record_segment(segments, at, n, s, x_r, v_r, z, mode)
        d = slip_direction(mode)
        set_phases(waves, plant, law, t, d)
        span = load_ramp_at(law, t)
        left = min(length - s, span.left)
        change = (
            closing_time(law, waves, span, t)
            if mode == LIFTED_OFF
            else separation_time(law, waves, span, t)
        )
        until = min(left, change)
        if mode == STUCK:
            exit_time, direction = stick_exit_normal_force(
                plant, law, waves, span, x_r, u_0, slope, until
            )
            step = min(exit_time, until)
        else:
            f = d * law.F_fk / plant.m
            g, r = -u_0 - f * span.load, -slope - f * span.rate
            segment = start_segment(c, w, waves, x_r, v_r, g, r)
            a, j = segment.a, segment.j
            # At a break-away F_L = ±F_fs N, so the acceleration is known without cancellation.
            if abs(mode) == BREAK_AWAY:
                load = load_at(law, waves, span, 0.0)[0]
                start = d * (law.F_fs - law.F_fk) * load / plant.m
                a, j = start, j - c * (start - a)
            creeping = waves.size == 0 and abs(v_r) <= cancellation_speed(c, w) * (
                abs(f) * span.load + w * abs(x_r)
            )
            if creeping and a_carried == a_carried:
                v_r, a = rescale(v_r, a_carried)
                j = r - c * a - w * v_r
            direction = motion_direction(v_r, a, j) if mode == LIFTED_OFF else d
            exit_time = slip_end_time(c, w, waves, x_r, v_r, a, j, g, r, direction, until)
            step = min(exit_time, until)
            before = v_r
            x_r, v_r, a_carried, _ = motion_at(c, w, waves, x_r, v_r, g, r, step)
            if creeping:
                v_r, a_carried = velocity_and_acceleration(c, w, before, a, r, step)
        stalled = 0 if t + step > t else stalled + 1
        if stalled > MAX_STALLED_EVENTS:
            return n, s, x_r, v_r, z, mode, at, -1
        load = load_at(law, waves, span, step)[0]
        F_L = limit_force(plant, x_r, base_motion(waves, u_0, slope, step)[0])
        when = min(s + step, length)
        if exit_time <= until and exit_time < NEVER:
            v_r, a_carried = 0.0, math.nan
            if mode == STUCK:
                mode = direction * BREAK_AWAY
                count = record_event(
                    log, count, n, when, direction * SLIP, x_r, -direction * law.F_fs * load
                )
            elif mode == LIFTED_OFF:
                count = record_event(log, count, n, when, -direction * REVERSAL, x_r, F_L)
            elif is_within_static_limit(plant, law, x_r, F_L, load):
                mode = STUCK
                count = record_event(log, count, n, when, STICK, x_r, F_L)
            else:
                mode = -sign(F_L)
                count = record_event(log, count, n, when, mode * REVERSAL, x_r, F_L)
        elif change <= left and change < NEVER:
            a_carried = math.nan
            if mode != LIFTED_OFF:
                mode, kind = LIFTED_OFF, LIFT
            else:
                mode = sign(v_r) if v_r != 0.0 else -sign(F_L)
                kind = mode * SLIP
            count = record_event(log, count, n, when, kind, x_r, F_L)
        elif abs(mode) == BREAK_AWAY:
            mode = d
        if step >= length - s:
            n += 1
            s = 0.0
        else:
            s += step
    return n, s, x_r, v_r, z, mode, at, count


@compiled
def slip_direction(mode):
    """Return the direction of sliding in contact, 0 where there is no sliding friction."""
    return 0 if mode == LIFTED_OFF else sign(mode)


@compiled
def is_within_static_limit(plant, law, x_r, F_L, load):
    """Return whether a mass at rest sticks: |F_L| <= F_fs to within rounding."""
    F_fs = law.F_fs * max(load, 0.0)
    return abs(F_L) <= F_fs + FORCE_ROUNDING * (F_fs + abs(plant.k_x * x_r))


@compiled
def initial_normal_force_mode(plant, law, waves, u_0, slope, x_r, v_r):
    """Return the mode at t = 0."""
    set_phases(waves, plant, law, 0.0, 0)
    span = load_ramp_at(law, 0.0)
    load, rate = load_at(law, waves, span, 0.0)
    # A normal force that only touches zero does not separate the surfaces.
    lifts = law.step > 0.0 or law.variation > 1.0
    if load < 0.0 or (load == 0.0 and rate <= 0.0 and lifts):
        return LIFTED_OFF
    if v_r != 0.0:
        return sign(v_r)
    F_L = limit_force(plant, x_r, base_motion(waves, u_0, slope, 0.0)[0])
    return STUCK if is_within_static_limit(plant, law, x_r, F_L, load) else -sign(F_L)


@inlined
def stick_exit_normal_force(plant, law, waves, span, x_r, u_0, slope, h):
    """Return when within h [s] a stuck mass breaks away, or infinity, and its direction."""
    if waves.base == 0 and slope == 0.0 and limit_force(plant, x_r, u_0) == 0.0:
        # F_L stays 0, and no limit is exceeded even where it vanishes.
        return NEVER, 0
    limits = CoulombLaw(
        law.F_fk * span.load, law.F_fs * span.load, law.variation, law.omega, law.phase
    )
    drift = law.F_fs * span.rate / plant.m
    return break_away_time(plant, limits, waves, x_r, u_0, slope - drift, slope + drift, h)
