"""The exact motion over a spring contact that yields: hold, yield, lift off."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.contacts.contact import (
    FREE,
    HOLD,
    POISED,
    begin_stretch,
    contact_force,
    holds,
)
from drysim.core.contacts.holding import end_of_hold
from drysim.core.contacts.ring import ring
from drysim.core.contacts.yielding import end_of_yield, turning
from drysim.core.events import LIFT, REVERSAL, SLIP, STICK, limit_force, note, sign
from drysim.core.normal_force.load import next_zero_load
from drysim.core.samples.stop import NEVER
from drysim.core.sines.slide import slide
from drysim.core.sines.stretch import starting
from drysim.core.trail import ENOUGH, mark
from drysim.core.waves import base_motion, normal_force

STALL = 100
"""Changes in a row without progress in time that put a scene at the end of double precision."""


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
    fresh = True
    while n <= end and at < full and count < full:
        length = h if n == end else dt
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        t = n * dt + s
        u_0 = u_dd[n] + slope * s
        if fresh:
            at = mark(trail, at, n, s, x_r, v_r, x_0, mode)
            fresh = False
        left = length - s
        c, w, f = begin_stretch(plant, law, waves, mode, x_0, t)
        stretch = starting(c, w, waves, x_r, v_r, -u_0 - f, -slope)
        way = sign(v_r)
        if way == 0:
            way = sign(stretch.a) if stretch.a != 0.0 else sign(stretch.j)
        turn, x_turn, change, after, x, v = end_of_mode(
            law, waves, stretch, mode, x_0, way, left, t
        )
        step = min(turn, change, left)
        stalled = 0 if t + step > t else stalled + 1
        if stalled > STALL:
            return n, s, x_r, v_r, x_0, mode, at, -1
        if turn <= change and turn < NEVER:
            x_r, v_r = x_turn, 0.0
        elif change < NEVER and mode != FREE and after != FREE:
            x_r, v_r = x, v
        else:
            x_r, v_r, _, _ = slide(c, w, waves, x_r, v_r, stretch.g, -slope, step)
        F_L = 0.0
        if min(turn, change) < NEVER:
            F_L = limit_force(plant, x_r, base_motion(waves, u_0, slope, step)[0])
        if change <= turn and change < NEVER:
            load = normal_force(law, waves, step)[0]
            force = contact_force(law, mode, x_r, x_0, max(load, 0.0))
            mode, x_0 = next_mode(law, waves, mode, after, x_r, v_r, x_0, force, step)
            kind = LIFT if mode == FREE else (STICK if holds(mode) else mode * SLIP)
            count = note(log, count, n, min(s + step, length), kind, x_r, F_L)
            fresh = True
        elif abs(mode) == POISED:
            mode = HOLD
        if turn < change:
            count = note(log, count, n, min(s + step, length), -way * REVERSAL, x_r, F_L)
            if mode == HOLD:
                step, x_r, count = ring(
                    plant, law, waves, stretch, x_0, -way, n, s, step, x_r, left, log, count,
                    full,
                )  # fmt: skip
        if step >= left:
            n += 1
            s = 0.0
            fresh = True
        else:
            s += step
    return n, s, x_r, v_r, x_0, mode, at, count


@compiled
def end_of_mode(law, waves, stretch, mode, x_0, way, left, t):
    """Give when within `left` s the mass turns and when a mode ends, as `end_of_hold` does.

    Where surfaces part or meet, which no motion changes, the state then is not given.
    """
    x, v = stretch.x_r, stretch.v_r
    until = min(next_zero_load(law, waves, t, mode != FREE), left)
    if mode == FREE:
        turn, x_turn = turning(stretch, waves, way, until)
        change, after = NEVER, HOLD
    elif holds(mode):
        load = normal_force(law, waves, 0.0)[0]
        poised = sign(mode) if mode != HOLD else 0
        gap = law.F_fk * load / law.k_t - way * (x - x_0) if poised != way else 0.0
        turn, x_turn, change, after, x, v = end_of_hold(
            stretch, waves, law, x_0, poised, way, gap, until
        )
    else:
        turn, x_turn, change, after, x, v = end_of_yield(stretch, waves, law, mode, way, until)
    if until < left and until <= min(turn, change):
        return turn, x_turn, until, HOLD if mode == FREE else FREE, x, v
    return turn, x_turn, change, after, x, v


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
