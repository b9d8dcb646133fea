"""The exact march from event to event, with no grid in between.

Each kernel follows the motion in one setting: `leap` under Coulomb's friction and waves, limits
that vary included; `touch` over a spring contact that yields and lifts off; `bound` between end
stops; `press` under Coulomb's friction whose normal force may vanish, or was recorded. (Sampled
base motion under constant limits has a faster way, see `sampled`.)

From an event on the motion is known in closed form, until the mode of the contact ends. So each
turn of a march finds when it ends - the mass stops or breaks away, the surfaces part or meet,
an end stop is met or left - by `roots` and `modes`, which miss none, goes there at once, and
settles what follows. An interval between two samples that holds no event is one such turn. An
event that needs no time is followed by the next, but not for ever: a scene in which a hundred
do is at the end of double precision, and the march says so.
"""

from __future__ import annotations

import math

from drysim.core.compile import compiled, inlined
from drysim.core.events import (
    CONTACT,
    ENOUGH,
    LIFT,
    REVERSAL,
    ROOM,
    ROUNDING,
    SLIP,
    STICK,
    Log,
    limit_force,
    mark,
    note,
    onset,
    opening,
    sign,
    tightness,
)
from drysim.core.forcing import (
    V_R,
    X_R,
    anchor,
    base_motion,
    normal_force,
    slide,
    starting,
    unpacked,
)
from drysim.core.model import Law, Plant
from drysim.core.modes import (
    APART,
    AWAY,
    BROKE,
    BUMPER_POISED,
    BUMPER_STEADY,
    CHATTERS,
    FREE,
    HOLD,
    MEET,
    POISED,
    TOUCHING,
    begin_stretch,
    chatter_time,
    contact_force,
    end_of_hold,
    end_of_yield,
    fade_out,
    fresh_of,
    holds,
    just_met,
    leave_rest,
    let_go,
    load_within,
    meet,
    meets_at,
    mode_of,
    next_zero_load,
    parts_at,
    pressures,
    pushes,
    rebound,
    span_at,
    stand,
    steady_pull,
    touch_of,
    way_of,
)
from drysim.core.oscillator import faint_per_force
from drysim.core.roots import NEVER, break_away, leave_slip, locate_stop, velocity
from drysim.core.sampled import lifted, pass_on

STALL = 100
"""Events in a row without progress in time that put a scene at the end of double precision."""


# Coulomb's friction under waves: slide, stop, stick, break away.


@compiled
def leap(plant, law, waves, u_0, slope, n, t, h, begin, x_r, v_r, d, log, count, capacity):
    """Solve one interval from event to event, or until the log is nearly full.

    Parameters
    ----------
    plant, law : Plant, Law
    waves : Waves
    u_0, slope : float
        Part of ü that is not waves: at the start of the interval [m/s²], and its rate [m/s³].
    n : int
        Number of the interval, for the log.
    t, h : float
        Start and length of the interval [s].
    begin : float
        Where in the interval to start [s].
    x_r, v_r, d
        State there [m, m/s] and direction of sliding, 0 when stuck.
    log : Log
    count, capacity : int
        Events already in the log, and its length.

    Returns
    -------
    begin, x_r, v_r, d, count, closest
        Time reached within the interval and the state there, events in the log
        (negative when they follow each other without end), tightest stop decision [-]. A leap
        that starts there goes on as if never stopped.
    """
    m, k_x, b = plant
    c = b / m
    w = k_x / m
    closest = NEVER
    broke = False
    stalled = 0
    while begin < h and (broke or count + 2 <= capacity):
        before = begin
        anchor(waves, plant, law, t + begin, d)
        u_begin = u_0 + slope * begin
        left = h - begin
        if d == 0:
            stay, d = break_away(plant, law, waves, x_r, u_begin, slope, slope, left)
            if stay == NEVER:
                return h, x_r, 0.0, 0, count, closest
            begin = min(begin + stay, h)
            load = normal_force(law, waves, stay)[0]
            count = note(log, count, n, begin, d * SLIP, x_r, -d * law.F_fs * load)
            broke = True
            continue
        u_dd, rate, _ = base_motion(waves, u_begin, slope, 0.0)
        load, load_d, _ = normal_force(law, waves, 0.0)
        if broke:
            a = d * (law.F_fs - law.F_fk) * load / m
        else:
            a = -(u_dd + c * v_r + w * x_r + d * law.F_fk * load / m)
        broke = False
        j = -rate - d * law.F_fk * load_d / m - c * a - w * v_r
        g = -u_begin - d * law.F_fk / m
        stop, x_stop = leave_slip(c, w, waves, x_r, v_r, a, j, g, -slope, d, left)
        if stop == NEVER:
            x_r, v_r, _, _ = slide(c, w, waves, x_r, v_r, g, -slope, left)
            return h, x_r, v_r, d, count, closest
        begin = min(begin + stop, h)
        stalled = 0 if begin > before else stalled + 1
        if stalled > STALL:
            return begin, x_r, v_r, d, -1, closest
        x_r, v_r = x_stop, 0.0
        u_dd = base_motion(waves, u_begin, slope, stop)[0]
        F_L = limit_force(plant, x_r, u_dd)
        F_fs = law.F_fs * normal_force(law, waves, stop)[0]
        closest = min(closest, tightness(F_L, F_fs))
        if abs(F_L) <= F_fs + ROUNDING * (F_fs + abs(k_x * x_r)):
            d = 0
            count = note(log, count, n, begin, STICK, x_r, F_L)
        else:
            d = -sign(F_L)
            count = note(log, count, n, begin, d * REVERSAL, x_r, F_L)
    return begin, x_r, v_r, d, count, closest


@compiled
def leap_off(scene, end, log, kind):
    """Solve a scene under waves alone from t = 0 to `end` [s], or until the log is nearly full.

    Returns as in `leap`; it begins with the state at t = 0, and `closest` counts how near its
    mode is to the other. The scene is an array as in `drysim.core.forcing`, its waves included;
    `log` are the rows of a log as one array, `kind` its kinds.
    """
    plant, law, waves = unpacked(scene)
    x_r, v_r = scene[X_R], scene[V_R]
    capacity = len(kind)
    log = Log(log[0], log[1], kind, log[2], log[3])
    anchor(waves, plant, law, 0.0, 0)
    u_dd = base_motion(waves, 0.0, 0.0, 0.0)[0]
    d, F_L, margin = opening(plant, law, x_r, v_r, u_dd)
    count = note(log, 0, 0, 0.0, d, x_r, F_L)
    begin, x_r, v_r, d, count, closest = leap(
        plant, law, waves, 0.0, 0.0, 0, 0.0, end, 0.0, x_r, v_r, d, log, count, capacity
    )
    return begin, x_r, v_r, d, count, min(closest, margin)


@compiled
def leap_steps(
    plant, law, waves, past, u_dd, dt, n, end, x_r, v_r, d, x_out, v_out, d_out, log, count, cap
):
    """March over samples where the friction limits vary: one leap a step; else like `march`.

    `past` is how many samples of the motion come before those that are given; `cap` is the
    capacity of the log.
    """
    closest = NEVER
    while n < end and count + ROOM <= cap:
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        reached, x_r, v_r, d, count, tight = leap(
            plant, law, waves, u_dd[n], slope, n, (past + n) * dt, dt, 0.0, x_r, v_r, d, log,
            count, cap
        )  # fmt: skip
        closest = min(closest, tight)
        if reached < dt or count < 0:
            return n, x_r, v_r, d, -1, closest
        n += 1
        x_out[n] = x_r
        v_out[n] = v_r
        d_out[n] = d
    return n, x_r, v_r, d, count, closest


# A spring contact that yields: hold, yield, lift off, meet.


@compiled
def touch(
    plant, law, waves, u_dd, dt, n, s, h, end, x_r, v_r, x_0, mode, trail, at, log, count,
    capacity,
):  # fmt: skip
    """Follow the motion over intervals of ü, or until steps or log are nearly full.

    Parameters and result as in `trace`, with x_0 where the contact carries no force [m] in
    place of z, and the mode in place of the direction.
    """
    stalled = 0
    full = capacity - ENOUGH
    while n <= end and at < full and count < full:
        length = h if n == end else dt
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        t = n * dt + s
        u_0 = u_dd[n] + slope * s
        at = mark(trail, at, n, s, x_r, v_r, x_0, mode)
        left = length - s
        c, w, f = begin_stretch(plant, law, waves, mode, x_0, t)
        stretch = starting(c, w, waves, x_r, v_r, -u_0 - f, -slope)
        change, after, x, v = end_of_mode(law, waves, stretch, mode, x_0, left, t)
        step = min(change, left)
        stalled = 0 if t + step > t else stalled + 1
        if stalled > STALL:
            return n, s, x_r, v_r, x_0, mode, at, -1
        if change < NEVER and mode != FREE and after != FREE:
            x_r, v_r = x, v
        else:
            x_r, v_r, _, _ = slide(c, w, waves, x_r, v_r, stretch.g, -slope, step)
        if change < NEVER:
            F_L = limit_force(plant, x_r, base_motion(waves, u_0, slope, step)[0])
            load = normal_force(law, waves, step)[0]
            force = contact_force(law, mode, x_r, x_0, max(load, 0.0))
            mode, x_0 = next_mode(law, waves, mode, after, x_r, v_r, x_0, force, step)
            kind = LIFT if mode == FREE else (STICK if holds(mode) else mode * SLIP)
            count = note(log, count, n, min(s + step, length), kind, x_r, F_L)
        elif abs(mode) == POISED:
            mode = HOLD
        if step >= left:
            n += 1
            s = 0.0
        else:
            s += step
    return n, s, x_r, v_r, x_0, mode, at, count


@compiled
def end_of_mode(law, waves, stretch, mode, x_0, left, t):
    """Give when within `left` [s] a mode ends, what is after it, and the state then.

    It begins at time t; the rest is as in `leave_hold`. Where surfaces part or meet, which no
    motion changes, the state is not given.
    """
    until = min(next_zero_load(law, waves, t, mode != FREE), left)
    change, after, x, v = NEVER, HOLD, stretch.x_r, stretch.v_r
    if holds(mode):
        poised = sign(mode) if mode != HOLD else 0
        change, after, x, v = end_of_hold(stretch, waves, law, x_0, poised, until)
    elif mode != FREE:
        change, x, v = end_of_yield(stretch, waves, law, mode, until)
    if until < left and until <= change:
        return until, HOLD if mode == FREE else FREE, x, v
    return change, after, x, v


@compiled
def next_mode(law, waves, mode, after, x_r, v_r, x_0, force, s):
    """Give the mode that follows, and where its contact carries no force."""
    if after == FREE:
        return FREE, x_r
    if mode == FREE:
        return just_met(law, v_r, law.F_fk * normal_force(law, waves, s)[1]), x_r
    if after == HOLD:
        return mode * POISED, x_r - force / law.k_t
    return after, x_0


# Between end stops: slide, stop, meet a stop, leave it.


BOUNDED_ENOUGH = 4
"""Steps and events that one step may add to trail and log, and one to end with."""


@compiled
def bound(
    plant, law, waves, u_dd, dt, n, s, h, end, xi, v_r, z, mode, trail, at, log, count, capacity
):
    """Follow the motion over intervals of ü, or until steps or log are nearly full.

    Parameters and result as in `touch` of a spring contact, with x_r as z + xi.
    """
    stalled = 0
    full = capacity - BOUNDED_ENOUGH
    m = plant.m
    # Relative acceleration from one interval to the next while v_r is faint, see `creep`. The
    # next call works it out afresh, to rounding.
    kept = math.nan
    whole = waves.size == 0
    while n <= end and at < full and count < full:
        touch, d, fresh = touch_of(mode), way_of(mode), fresh_of(mode)
        if whole and s == 0.0 and touch == APART and d * v_r > 0.0:
            f = d * law.F_fk / m + plant.k_x / m * z
            low, high = -law.x_rM - z, law.x_rM - z
            n, xi, v_r, at = pass_on(
                plant, u_dd, dt, n, end, xi, v_r, f, low, high, trail, at, full, z, mode
            )
            if at >= full:
                break
        length = h if n == end else dt
        left = length - s
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        u_0 = u_dd[n] + slope * s
        t = n * dt + s
        at = mark(trail, at, n, s, xi, v_r, z, mode)
        c, w, g = begin_bounded_stretch(plant, law, waves, mode, z, u_0, t)
        if fresh == CHATTERS:
            F_L = m * base_motion(waves, u_0, slope, 0.0)[0] + plant.k_x * z
            load = normal_force(law, waves, 0.0)[0]
            p, q = pressures(plant, law, 1 if z > 0.0 else -1, F_L, load)
            lasts = chatter_time(law, p, q, abs(v_r))[0] if p > 0.0 else 0.0
            step = min(lasts, left)
            # The time that is left falls with the speed of the rebound.
            v_r *= 1.0 - step / lasts if lasts > left else 0.0
            if lasts <= left:
                mode = mode_of(APART, 0, BUMPER_STEADY)
                then, ends = moment(n, s + step, length, end)
                count = note(log, count, then, ends, STICK, z, F_L)
        elif d == 0:
            step, way = leave_rest(plant, law, waves, touch, z, xi, u_0, slope, left)
            # At the very end of an interval the next one decides.
            if step < left:
                touch = touch if pushes(law, touch) else APART
                mode = mode_of(touch, way, BROKE)
                F_L = -way * law.F_fs * normal_force(law, waves, step)[0]
                count = note(log, count, n, s + step, way * SLIP, z + xi, F_L)
        else:
            _, _, a, j = slide(c, w, waves, xi, v_r, g, -slope, 0.0)
            if fresh == BROKE:
                load = normal_force(law, waves, 0.0)[0]
                a_exact = d * (law.F_fs - law.F_fk) * load / m
                j -= c * (a_exact - a)
                a = a_exact
            faint = whole and abs(v_r) <= faint_per_force(c, w) * (abs(g + u_0) + w * abs(xi))
            if faint and kept == kept:
                v_r, a = lifted(v_r, kept)
            turn = leave_motion(c, w, waves, xi, v_r, a, j, g, -slope, d, left)
            change, after = next_change(
                c, w, waves, law, xi, v_r, g, -slope, z, touch, d, fresh == BUMPER_POISED,
                min(turn, left),
            )  # fmt: skip
            step = min(turn, change, left)
            before = v_r
            xi, v_r, kept, _ = slide(c, w, waves, xi, v_r, g, -slope, step)
            if faint:
                v_r, kept = velocity(c, w, before, a, -slope, step)
            v_r = 0.0 if step == turn else v_r
            mode = mode_of(touch, d, BUMPER_STEADY)
            if step in (change, turn):
                kept = math.nan
                then, ends = moment(n, s + step, length, end)
                u_then = base_motion(waves, u_0, slope, step)[0]
                load = normal_force(law, waves, step)[0]
                if step == change and touch == APART:
                    at = mark(trail, at, then, ends, xi, max(d * v_r, 0.0) * d, z, MEET)
                    z = d * law.x_rM
                    xi = 0.0
                    mode = mode_of(after, d, BUMPER_STEADY)
                    if law.k_s > 0.0:
                        F_L = steady_pull(plant, law, APART, z, xi) + m * u_then
                        count = note(log, count, then, ends, d * CONTACT, z, F_L)
                    else:
                        v_r, mode, count = rebound(
                            plant, law, waves, slope, then, ends, t + step, v_r, z, d, u_then,
                            load, log, count,
                        )  # fmt: skip
                elif step == change:
                    F_L = steady_pull(plant, law, touch, z, xi) + m * u_then
                    xi, mode, count = let_go(
                        touch, after, d, then, ends, z, xi, F_L, log, count
                    )
                if way_of(mode) != 0 and (step == turn or (v_r == 0.0 and law.k_s == 0.0)):
                    mode, count = stand(
                        plant, law, then, ends, xi, z, mode, u_then, load, log, count
                    )
        step = min(step, left)
        stalled = 0 if t + step > t else stalled + 1
        if stalled > STALL:
            return n, s, xi, v_r, z, mode, at, -1
        if step >= left:
            n += 1
            s = 0.0
        else:
            s += step
    if n > end:
        at = mark(trail, at, end, h, xi, v_r, z, mode)
    return n, s, xi, v_r, z, mode, at, count


@compiled
def moment(n, s, length, end):
    """Give interval and time in it of an instant, of the next one where an interval ends."""
    if s < length:
        return n, s
    return (n + 1, 0.0) if n < end else (n, length)


@compiled
def begin_bounded_stretch(plant, law, waves, mode, z, u_0, t):
    """Set the waves for a stretch from time t [s]; gives b/m, k/m and the force per mass."""
    touch, d = touch_of(mode), way_of(mode)
    k, b = plant.k_x, plant.b
    if pushes(law, touch):
        k += law.k_s
        b += law.b_s
    m = plant.m
    anchor(waves, Plant(m, k, b), law, t, d)
    return b / m, k / m, -u_0 - d * law.F_fk / m - plant.k_x / m * z


@compiled
def next_change(c, w, waves, law, xi, v_r, g, r, z, touch, d, poised, until):
    """Give when the mass meets a stop or a bumper lets go or is felt again, or infinity.

    Gives also how it is to the stops then.
    """
    if touch == APART:
        far = law.x_rM - d * z
        return meet(c, w, waves, xi, v_r, g, r, d, far, until), d * TOUCHING
    side = 1 if touch > 0 else -1
    if abs(touch) == AWAY:
        felt = fade_out(c, w, waves, law, xi, v_r, g, r, -side, poised, until)
        clear = meet(c, w, waves, xi, v_r, g, r, d, 0.0, min(felt, until))
        return (clear, APART) if clear < felt else (felt, side * TOUCHING)
    if side == d:
        return NEVER, touch
    if law.b_s == 0.0:
        return meet(c, w, waves, xi, v_r, g, r, d, 0.0, until), APART
    return fade_out(c, w, waves, law, xi, v_r, g, r, side, poised, until), side * AWAY


@inlined
def leave_motion(c, w, waves, x_r, v_r, a, j, g, r, way, h):
    """Give the first time in (0, h] at which v_r is zero, or infinity."""
    if way == 0:
        return NEVER
    if waves.size == 0:
        return locate_stop(c, w, way * v_r, way * a, way * r, h)
    return leave_slip(c, w, waves, x_r, v_r, a, j, g, r, way, h)[0]


# Coulomb's friction whose normal force may vanish, or was recorded: rub, stick, lift off.
#
# Between the samples of base and force both are linear, so that limits, sticking and sliding
# are solved as under constant limits.


STUCK, PRESSED_FREE, BREAKING = 0, 3, 2
"""Modes besides sliding in direction +1 or -1: stuck, lifted off, or, with the sign of the
direction, breaking away just then."""


@compiled
def press(
    plant, law, waves, u_dd, dt, n, s, h, end, x_r, v_r, z, mode, trail, at, log, count,
    capacity,
):  # fmt: skip
    """Follow the motion over intervals of ü, or until steps or log are nearly full.

    Parameters and result as in `trace`; z has no meaning here and is handed through, and the
    mode stands in place of the direction.
    """
    stalled = 0
    full = capacity - ENOUGH
    # Relative acceleration from one interval to the next while v_r is faint, see `creep`. The
    # next call works it out afresh, to rounding.
    kept = math.nan
    c, w = plant.b / plant.m, plant.k_x / plant.m
    while n <= end and at < full and count < full:
        length = h if n == end else dt
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        t = n * dt + s
        u_0 = u_dd[n] + slope * s
        at = mark(trail, at, n, s, x_r, v_r, z, mode)
        d = heading(mode)
        anchor(waves, plant, law, t, d)
        span = span_at(law, t)
        left = min(length - s, span.left)
        change = (
            meets_at(law, waves, span, t)
            if mode == PRESSED_FREE
            else parts_at(law, waves, span, t)
        )
        until = min(left, change)
        if mode == STUCK:
            turn, way = leave_pressed_rest(plant, law, waves, span, x_r, u_0, slope, until)
            step = min(turn, until)
        else:
            f = d * law.F_fk / plant.m
            g, r = -u_0 - f * span.load, -slope - f * span.rate
            stretch = starting(c, w, waves, x_r, v_r, g, r)
            a, j = stretch.a, stretch.j
            if abs(mode) == BREAKING:
                load = load_within(law, waves, span, 0.0)[0]
                start = d * (law.F_fs - law.F_fk) * load / plant.m
                a, j = start, j - c * (start - a)
            faint = waves.size == 0 and abs(v_r) <= faint_per_force(c, w) * (
                abs(f) * span.load + w * abs(x_r)
            )
            if faint and kept == kept:
                v_r, a = lifted(v_r, kept)
                j = r - c * a - w * v_r
            way = onset(v_r, a, j) if mode == PRESSED_FREE else d
            turn = leave_motion(c, w, waves, x_r, v_r, a, j, g, r, way, until)
            step = min(turn, until)
            before = v_r
            x_r, v_r, kept, _ = slide(c, w, waves, x_r, v_r, g, r, step)
            if faint:
                v_r, kept = velocity(c, w, before, a, r, step)
        stalled = 0 if t + step > t else stalled + 1
        if stalled > STALL:
            return n, s, x_r, v_r, z, mode, at, -1
        load = load_within(law, waves, span, step)[0]
        F_L = limit_force(plant, x_r, base_motion(waves, u_0, slope, step)[0])
        when = min(s + step, length)
        if turn <= until and turn < NEVER:
            v_r, kept = 0.0, math.nan
            if mode == STUCK:
                mode = way * BREAKING
                count = note(log, count, n, when, way * SLIP, x_r, -way * law.F_fs * load)
            elif mode == PRESSED_FREE:
                count = note(log, count, n, when, -way * REVERSAL, x_r, F_L)
            elif stays(plant, law, x_r, F_L, load):
                mode = STUCK
                count = note(log, count, n, when, STICK, x_r, F_L)
            else:
                mode = -sign(F_L)
                count = note(log, count, n, when, mode * REVERSAL, x_r, F_L)
        elif change <= left and change < NEVER:
            kept = math.nan
            if mode != PRESSED_FREE:
                mode, kind = PRESSED_FREE, LIFT
            else:
                mode = sign(v_r) if v_r != 0.0 else -sign(F_L)
                kind = mode * SLIP
            count = note(log, count, n, when, kind, x_r, F_L)
        elif abs(mode) == BREAKING:
            mode = d
        if step >= length - s:
            n += 1
            s = 0.0
        else:
            s += step
    return n, s, x_r, v_r, z, mode, at, count


@compiled
def heading(mode):
    """Give the direction of sliding in contact, 0 where the surfaces do not rub."""
    return 0 if mode == PRESSED_FREE else sign(mode)


@compiled
def stays(plant, law, x_r, F_L, load):
    """Tell whether a mass at rest stays: |F_L| is within the static limit, roundings apart."""
    F_fs = law.F_fs * max(load, 0.0)
    return abs(F_L) <= F_fs + ROUNDING * (F_fs + abs(plant.k_x * x_r))


@compiled
def first_pressed(plant, law, waves, u_0, slope, x_r, v_r):
    """Give the mode at t = 0."""
    anchor(waves, plant, law, 0.0, 0)
    span = span_at(law, 0.0)
    load, rate = load_within(law, waves, span, 0.0)
    # A force that only touches zero parts no surfaces.
    lifts = law.step > 0.0 or law.variation > 1.0
    if load < 0.0 or (load == 0.0 and rate <= 0.0 and lifts):
        return PRESSED_FREE
    if v_r != 0.0:
        return sign(v_r)
    F_L = limit_force(plant, x_r, base_motion(waves, u_0, slope, 0.0)[0])
    return STUCK if stays(plant, law, x_r, F_L, load) else -sign(F_L)


@inlined
def leave_pressed_rest(plant, law, waves, span, x_r, u_0, slope, h):
    """Give when within h [s] a stuck mass breaks away, or infinity, and in which direction."""
    if waves.base == 0 and slope == 0.0 and limit_force(plant, x_r, u_0) == 0.0:
        # Nothing pulls, also where the limit itself comes and goes.
        return NEVER, 0
    limits = Law(
        law.F_fk * span.load, law.F_fs * span.load, law.variation, law.omega, law.phase
    )
    drift = law.F_fs * span.rate / plant.m
    return break_away(plant, limits, waves, x_r, u_0, slope - drift, slope + drift, h)
