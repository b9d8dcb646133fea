"""The exact motion between end stops: slide, stick, meet a stop, leave it."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.contacts.touch import STALL
from drysim.core.events import CONTACT, SLIP, STICK, note
from drysim.core.plant import Plant
from drysim.core.samples.glide import lifted
from drysim.core.samples.steps import faint_per_force
from drysim.core.samples.stop import NEVER, locate_stop, velocity
from drysim.core.sines.cease import leave_slip
from drysim.core.sines.slide import slide
from drysim.core.stops.bumper import (
    APART,
    AWAY,
    BROKE,
    CHATTERS,
    MEET,
    POISED,
    STEADY,
    TOUCHING,
    fade_out,
    fresh_of,
    meet,
    mode_of,
    pushes,
    steady_pull,
    touch_of,
    way_of,
)
from drysim.core.stops.impact import chatter_time, pressures, rebound
from drysim.core.stops.passage import pass_on
from drysim.core.stops.rest import leave_rest, let_go, stand
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
def bound(
    plant, law, waves, u_dd, dt, n, s, h, end, xi, v_r, z, mode, trail, at, log, count, capacity
):
    """Follow the motion over intervals of ü, or until steps or log are nearly full.

    Parameters and result as in `touch` of a spring contact, with x_r as z + xi.
    """
    stalled = 0
    full = capacity - ENOUGH
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
        c, w, g = begin_stretch(plant, law, waves, mode, z, u_0, t)
        if fresh == CHATTERS:
            F_L = m * base_motion(waves, u_0, slope, 0.0)[0] + plant.k_x * z
            load = normal_force(law, waves, 0.0)[0]
            p, q = pressures(plant, law, 1 if z > 0.0 else -1, F_L, load)
            lasts = chatter_time(law, p, q, abs(v_r))[0] if p > 0.0 else 0.0
            step = min(lasts, left)
            # The time that is left falls with the speed of the rebound.
            v_r *= 1.0 - step / lasts if lasts > left else 0.0
            if lasts <= left:
                mode = mode_of(APART, 0, STEADY)
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
            if whole:
                turn = locate_stop(c, w, d * v_r, d * a, -d * slope, left)
            else:
                turn, _ = leave_slip(c, w, waves, xi, v_r, a, j, g, -slope, d, left)
            change, after = next_change(
                c, w, waves, law, xi, v_r, g, -slope, z, touch, d, fresh == POISED,
                min(turn, left),
            )  # fmt: skip
            step = min(turn, change, left)
            before = v_r
            xi, v_r, kept, _ = slide(c, w, waves, xi, v_r, g, -slope, step)
            if faint:
                v_r, kept = velocity(c, w, before, a, -slope, step)
            v_r = 0.0 if step == turn else v_r
            mode = mode_of(touch, d, STEADY)
            if step in (change, turn):
                kept = math.nan
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
