"""The exact motion over a spring contact that yields: hold, yield, lift off."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.contacts.hit import cross
from drysim.core.contacts.yielding import leave_hold, leave_yield, starting
from drysim.core.events import LIFT, REVERSAL, SLIP, STICK, limit_force, note, sign
from drysim.core.normal_force.load import next_zero_load
from drysim.core.plant import Plant
from drysim.core.samples.stop import NEVER, locate_stop
from drysim.core.sines.cease import leave_slip
from drysim.core.sines.slide import slide
from drysim.core.trail import ENOUGH, mark
from drysim.core.waves import anchor, base_motion, normal_force

HOLD, FREE, POISED = 0, 2, 4
"""Modes of the contact besides yielding in direction +1 or -1: it holds, it is lifted off, or,
with the sign of the direction, it has just ceased to yield and holds at its very limit."""

STALL = 100
"""Changes in a row without progress in time that put a scene at the end of double precision."""


@compiled
def holds(mode):
    """Tell whether the contact holds."""
    return mode == HOLD or abs(mode) == POISED


@compiled
def spring(plant, law, mode):
    """Give the oscillator as it is in a mode: a holding contact is one more spring."""
    return Plant(plant.m, plant.k_x + (law.k_t if holds(mode) else 0.0), plant.b)


@compiled
def steady_force(law, mode, x_0):
    """Give the part of the contact force that is constant in a mode [N]."""
    if holds(mode):
        return -law.k_t * x_0
    return 0.0 if mode == FREE else mode * law.F_fk


@compiled
def contact_force(law, mode, x_r, x_0, load):
    """Give the contact force [N]; `load` is the normal force relative to its mean."""
    if holds(mode):
        return law.k_t * (x_r - x_0)
    return 0.0 if mode == FREE else mode * law.F_fk * load


@compiled
def begin_stretch(plant, law, waves, mode, x_0, t):
    """Set the waves for a stretch from time t [s]; gives b/m, k/m and steady force/m."""
    effective = spring(plant, law, mode)
    anchor(waves, effective, law, t, mode if abs(mode) == 1 else 0)
    m = plant.m
    return effective.b / m, effective.k_x / m, steady_force(law, mode, x_0) / m


@compiled
def first_contact(law, x_r):
    """Give mode and x_0 at t = 0, where the contact carries no force."""
    load = 1.0 + law.variation * math.sin(law.phase)
    return (HOLD if load > 0.0 else FREE), x_r


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
    whole = waves.size == 0
    reach = law.F_fk / law.k_t
    while n <= end and at < full and count < full:
        length = h if n == end else dt
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        t = n * dt + s
        u_0 = u_dd[n] + slope * s
        at = mark(trail, at, n, s, x_r, v_r, x_0, mode)
        left = length - s
        c, w, f = begin_stretch(plant, law, waves, mode, x_0, t)
        g = -u_0 - f
        a, j = starting(c, w, waves, x_r, v_r, g, -slope)
        way = sign(v_r)
        if way == 0:
            way = sign(a) if a != 0.0 else sign(j)
        turn = NEVER
        if way != 0:
            if whole:
                turn = locate_stop(c, w, way * v_r, way * a, -way * slope, left)
            else:
                turn, _ = leave_slip(c, w, waves, x_r, v_r, a, j, g, -slope, way, left)
        if whole and holds(mode) and way != 0:
            gap = reach - way * (x_r - x_0)
            gap = 0.0 if mode == way * POISED else gap
            change = cross(c, w, way * v_r, way * a, -way * slope, gap, min(turn, left))
            after = way
        else:
            change, after = end_of_mode(
                law, waves, mode, c, w, x_r, v_r, a, j, g, -slope, x_0, way, turn, left, t
            )
        step = min(turn, change, left)
        stalled = 0 if t + step > t else stalled + 1
        if stalled > STALL:
            return n, s, x_r, v_r, x_0, mode, at, -1
        x_r, v_r, _, _ = slide(c, w, waves, x_r, v_r, g, -slope, step)
        F_L = 0.0
        if min(turn, change) < NEVER:
            F_L = limit_force(plant, x_r, base_motion(waves, u_0, slope, step)[0])
        if turn <= change and turn < NEVER:
            v_r = 0.0
        if change <= turn and change < NEVER:
            load = normal_force(law, waves, step)[0]
            force = contact_force(law, mode, x_r, x_0, max(load, 0.0))
            mode, x_0 = next_mode(law, waves, mode, after, x_r, v_r, x_0, force, step)
            kind = LIFT if mode == FREE else (STICK if holds(mode) else mode * SLIP)
            count = note(log, count, n, min(s + step, length), kind, x_r, F_L)
        elif abs(mode) == POISED:
            mode = HOLD
        if turn < change:
            count = note(log, count, n, min(s + step, length), -way * REVERSAL, x_r, F_L)
        if step >= left:
            n += 1
            s = 0.0
        else:
            s += step
    return n, s, x_r, v_r, x_0, mode, at, count


@compiled
def end_of_mode(law, waves, mode, c, w, x_r, v_r, a, j, g, r, x_0, way, turn, left, t):
    """Give when a mode ends within `left` s, or infinity, and the mode that follows."""
    if mode == FREE:
        lands = next_zero_load(law, waves, t, False)
        return (lands if lands <= left else NEVER), HOLD
    lifts = next_zero_load(law, waves, t, True)
    until = min(lifts, turn, left)
    change, after = NEVER, mode
    if holds(mode):
        for side in (-1, 1):
            # With a constant limit only the side that the mass moves to can yield.
            if side == way or law.variation > 0.0:
                found = leave_hold(
                    c, w, waves, law, x_r, v_r, a, g, r, x_0, side, mode == side * POISED, until
                )
                if found < change:
                    change, after = found, side
    elif law.variation > 0.0:
        change, after = leave_yield(c, w, waves, law, x_r, v_r, a, j, g, r, mode, until), HOLD
    else:
        change, after = turn if way == mode else 0.0, HOLD
    if lifts <= left and lifts <= change and lifts <= turn:
        return lifts, FREE
    return change, after


@compiled
def next_mode(law, waves, mode, after, x_r, v_r, x_0, force, s):
    """Give the mode that follows, and where its contact carries no force."""
    if after == FREE:
        return FREE, x_r
    if mode == FREE:
        rate = law.F_fk * normal_force(law, waves, s)[1]
        return (sign(v_r) if law.k_t * abs(v_r) > rate else HOLD), x_r
    if after == HOLD:
        return mode * POISED, x_r - force / law.k_t
    return after, x_0
