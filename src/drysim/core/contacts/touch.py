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
    just_met,
)
from drysim.core.contacts.holding import end_of_hold
from drysim.core.contacts.yielding import end_of_yield
from drysim.core.events import LIFT, SLIP, STICK, limit_force, note, sign
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
    """Give when within `left` s a mode ends, what is after it, and the state then.

    Parameters
    ----------
    law, waves, stretch, x_0
        As in `leave_hold`.
    mode : int
    left, t : float
        Length of the stretch, and time at its start [s].

    Notes
    -----
    Where surfaces part or meet, which no motion changes, the state is not given.
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
