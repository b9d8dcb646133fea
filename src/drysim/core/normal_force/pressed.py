"""The exact motion under Coulomb's friction whose normal force may vanish, or was recorded.

Between the samples of base and force both are linear, so that limits, sticking and sliding are
solved as under constant limits.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.events import (
    LIFT,
    REVERSAL,
    ROUNDING,
    SLIP,
    STICK,
    limit_force,
    note,
    onset,
    sign,
)
from drysim.core.normal_force.load import load_within, meets_at, parts_at, span_at
from drysim.core.plant import Law
from drysim.core.samples.glide import lifted
from drysim.core.samples.steps import faint_per_force
from drysim.core.samples.stop import NEVER, locate_stop, velocity
from drysim.core.sines.cease import leave_slip
from drysim.core.sines.leave import break_away
from drysim.core.sines.slide import slide
from drysim.core.sines.stretch import starting
from drysim.core.trail import ENOUGH, mark
from drysim.core.waves import anchor, base_motion

STUCK, FREE, BREAKING = 0, 3, 2
"""Modes besides sliding in direction +1 or -1: stuck, lifted off, or, with the sign of the
direction, breaking away just then."""

STALL = 100
"""Changes in a row without progress in time that put a scene at the end of double precision."""


@compiled
def heading(mode):
    """Give the direction of sliding in contact, 0 where the surfaces do not rub."""
    return 0 if mode == FREE else sign(mode)


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
        return FREE
    if v_r != 0.0:
        return sign(v_r)
    F_L = limit_force(plant, x_r, base_motion(waves, u_0, slope, 0.0)[0])
    return STUCK if stays(plant, law, x_r, F_L, load) else -sign(F_L)


@inlined
def leave_rest(plant, law, waves, span, x_r, u_0, slope, h):
    """Give when within h [s] a stuck mass breaks away, or infinity, and in which direction."""
    if waves.base == 0 and slope == 0.0 and limit_force(plant, x_r, u_0) == 0.0:
        # Nothing pulls, also where the limit itself comes and goes.
        return NEVER, 0
    limits = Law(
        law.F_fk * span.load, law.F_fs * span.load, law.variation, law.omega, law.phase
    )
    drift = law.F_fs * span.rate / plant.m
    return break_away(plant, limits, waves, x_r, u_0, slope - drift, slope + drift, h)


@inlined
def leave_motion(c, w, waves, x_r, v_r, a, j, g, r, way, h):
    """Give the first time in (0, h] at which v_r is zero, or infinity."""
    if way == 0:
        return NEVER
    if waves.size == 0:
        return locate_stop(c, w, way * v_r, way * a, way * r, h)
    return leave_slip(c, w, waves, x_r, v_r, a, j, g, r, way, h)[0]


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
            meets_at(law, waves, span, t) if mode == FREE else parts_at(law, waves, span, t)
        )
        until = min(left, change)
        if mode == STUCK:
            turn, way = leave_rest(plant, law, waves, span, x_r, u_0, slope, until)
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
            way = onset(v_r, a, j) if mode == FREE else d
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
            elif mode == FREE:
                count = note(log, count, n, when, -way * REVERSAL, x_r, F_L)
            elif stays(plant, law, x_r, F_L, load):
                mode = STUCK
                count = note(log, count, n, when, STICK, x_r, F_L)
            else:
                mode = -sign(F_L)
                count = note(log, count, n, when, mode * REVERSAL, x_r, F_L)
        elif change <= left and change < NEVER:
            kept = math.nan
            if mode != FREE:
                mode, kind = FREE, LIFT
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
