"""The exact motion between end stops: slide, stick, meet a stop, leave it."""

from __future__ import annotations

from drysim.core.bumper import (
    APART,
    AWAY,
    BROKE,
    MEET,
    POISED,
    STEADY,
    TOUCHING,
    fade_out,
    fresh_of,
    meet,
    mode_of,
    place,
    pushes,
    steady_pull,
    touch_of,
    wall_of,
    way_of,
)
from drysim.core.cease import leave_slip
from drysim.core.compiled import compiled
from drysim.core.contact import STALL
from drysim.core.events import (
    CONTACT,
    IMPACT,
    RELEASE,
    REVERSAL,
    ROUNDING,
    SLIP,
    STICK,
    note,
    sign,
)
from drysim.core.impact import comes_to_rest
from drysim.core.leave import leave_stick
from drysim.core.passage import pass_on
from drysim.core.plant import Plant
from drysim.core.slide import slide
from drysim.core.stop import NEVER, locate_stop
from drysim.core.trail import mark
from drysim.core.waves import anchor, base_motion, normal_force

ENOUGH = 4
"""Steps and events that one step may add to trail and log, and one to end with."""


@compiled
def moment(n, s, length, end):
    """Give interval and time in it of an instant, of the next one where an interval ends."""
    if s < length:
        return n, s
    return (n + 1, 0.0) if n < end else (n, length)


@compiled
def begin_stretch(plant, law, waves, mode, z, u_0, t):
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
def at_rest(plant, law, touch, z, xi, u_dd, load):
    """Give the direction in which a mass with v_r = 0 slides on, 0 where it sticks, and F_L.

    Eq. (9) with the force of a bumper. A rigid stop bears what presses the mass against it.
    """
    pull = steady_pull(plant, law, touch, z, xi)
    F_L = plant.m * u_dd + pull
    hold = law.F_fs * load
    d = -sign(F_L) if abs(F_L) > hold + ROUNDING * (hold + abs(pull)) else 0
    return (0 if d != 0 and d == wall_of(law, z, xi) else d), F_L


@compiled
def first_bounds(plant, law, x_r, v_r, u_dd, load):
    """Give xi, v_r, z and the mode at t = 0."""
    z, xi, touch = place(law, x_r, v_r)
    d = sign(v_r)
    if d == 0:
        d, _ = at_rest(plant, law, touch, z, xi, u_dd, load)
    return xi, v_r, z, mode_of(touch, d, STEADY)


@compiled
def leave_rest(plant, law, waves, touch, z, xi, u_0, slope, left):
    """Give when a stuck mass breaks away, or infinity, and in which direction."""
    # What springs pull with is constant: one spring of 1 N/m that is so many metres long.
    pull = steady_pull(plant, law, touch, z, xi)
    wall = wall_of(law, z, xi)
    one = Plant(plant.m, 1.0, 0.0)
    up, down = NEVER, NEVER
    if wall >= 0:
        up = leave_stick(one, law, waves, pull, u_0, slope, 1, left)
    if wall <= 0:
        down = leave_stick(one, law, waves, pull, u_0, slope, -1, min(up, left))
    return (down, 1) if down < up else (up, -1)


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


@compiled
def rebound(plant, law, waves, slope, n, s, length, t, v_r, z, d, u_dd, load, log, count):
    """Throw the mass back from a rigid stop, or lay it to rest; gives v_r and mode.

    Parameters
    ----------
    n, s, length, t : int, float, float, float
        Interval, time in it, its length [s]; and time since the start of the motion [s].
    v_r, d : float, int
        Velocity [m/s] before the impact, and its direction: the side of the stop.
    z : float
        Where the stop is [m].
    u_dd, load : float
        ü [m/s²] and the relative normal force then.
    """
    F_L = plant.m * u_dd + plant.k_x * z
    count = note(log, count, n, s, -d * IMPACT, z, F_L)
    speed = law.e * max(d * v_r, 0.0)
    if speed == 0.0:
        return 0.0, mode_of(APART, -d, STEADY), count
    lasts = comes_to_rest(plant, law, waves, slope, d, F_L, load, t, speed)
    if lasts < 0.0:
        return -d * speed, mode_of(APART, -d, STEADY), count
    count = note(log, count, n, min(s + lasts, length), STICK, z, F_L)
    return 0.0, mode_of(APART, 0, STEADY), count


@compiled
def let_go(law, touch, after, d, n, s, z, xi, F_L, log, count):
    """Change how the mass is to a bumper on its way inwards; gives xi and mode."""
    if abs(after) == AWAY and d * xi >= 0.0:
        after = APART
    if abs(touch) == TOUCHING:
        count = note(log, count, n, s, d * RELEASE, z + xi, F_L)
    elif after != APART:
        count = note(log, count, n, s, d * CONTACT, z + xi, F_L)
    if after == APART:
        return 0.0, mode_of(APART, d, STEADY), count
    return xi, mode_of(after, d, POISED), count


@compiled
def stand(plant, law, n, s, xi, z, mode, u_dd, load, log, count):
    """Decide what a mass does whose velocity is zero: stick, or slide on; gives its mode."""
    touch = touch_of(mode)
    if abs(touch) == AWAY:
        touch = touch // AWAY
    d, F_L = at_rest(plant, law, touch, z, xi, u_dd, load)
    count = note(log, count, n, s, d * REVERSAL if d != 0 else STICK, z + xi, F_L)
    return mode_of(touch, d, STEADY), count


@compiled
def bound(
    plant, law, waves, u_dd, dt, n, s, h, end, xi, v_r, z, mode, trail, at, log, count, capacity
):
    """Follow the motion over intervals of ü, or until steps or log are nearly full.

    Parameters and result as in `touch` of a spring contact, with x_r as z + xi.
    """
    stalled = 0
    full = capacity - ENOUGH
    m = plant.m
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
        c, w, g = begin_stretch(plant, law, waves, mode, z, u_0, t)
        if d == 0:
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
            if whole:
                turn = locate_stop(c, w, d * v_r, d * a, -d * slope, left)
            else:
                turn, _ = leave_slip(c, w, waves, xi, v_r, a, j, g, -slope, d, left)
            change, after = next_change(
                c, w, waves, law, xi, v_r, g, -slope, z, touch, d, fresh == POISED,
                min(turn, left),
            )  # fmt: skip
            step = min(turn, change, left)
            xi, v_r, _, _ = slide(c, w, waves, xi, v_r, g, -slope, step)
            v_r = 0.0 if step == turn else v_r
            mode = mode_of(touch, d, STEADY)
            if step in (change, turn):
                then, ends = moment(n, s + step, length, end)
                u_then = base_motion(waves, u_0, slope, step)[0]
                load = normal_force(law, waves, step)[0]
                if step == change and touch == APART:
                    at = mark(trail, at, then, ends, xi, max(d * v_r, 0.0) * d, z, MEET)
                    z = d * law.x_rM
                    xi = 0.0
                    mode = mode_of(after, d, STEADY)
                    if law.k_s > 0.0:
                        F_L = steady_pull(plant, law, APART, z, xi) + m * u_then
                        count = note(log, count, then, ends, d * CONTACT, z, F_L)
                    else:
                        v_r, mode, count = rebound(
                            plant, law, waves, slope, then, ends, h if then == end else dt,
                            t + step, v_r, z, d, u_then, load, log, count,
                        )  # fmt: skip
                elif step == change:
                    F_L = steady_pull(plant, law, touch, z, xi) + m * u_then
                    xi, mode, count = let_go(
                        law, touch, after, d, then, ends, z, xi, F_L, log, count
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
