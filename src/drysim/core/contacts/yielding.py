"""When a spring contact yields, when a yielding one holds again, and when the mass turns."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.samples.stop import NEVER
from drysim.core.sines.cease import leave_slip
from drysim.core.sines.vanish import Blend, vanish

HALF_SWING = 3.2
"""Radians of the oscillator within which a contact that its swing makes yield does so."""


@compiled
def turning(stretch, waves, way, h):
    """Give the first time in (0, h] at which v_r is zero, or infinity, and x_r then."""
    if way == 0:
        return NEVER, stretch.x_r
    c, w, x_r, v_r, a, j, _, g, r = stretch
    return leave_slip(c, w, waves, x_r, v_r, a, j, g, r, way, h)


@inlined
def turning_before(stretch, waves, law, way, change, v_r):
    """Give what `turning` gives up to a change whose v_r is known."""
    speed = Blend(0.0, 0.0, float(way), 0.0, 0.0)
    turn, x_turn, _ = vanish(stretch, waves, law, speed, 0, change, way * v_r > 0.0)
    return turn, x_turn


@compiled
def leave_hold(stretch, waves, law, x_0, side, poised, h):
    """Give the first time in [0, h] at which a holding contact yields to one side, and how.

    Parameters
    ----------
    stretch, waves, h
        As in `vanish`, with the spring of the contact in the stretch.
    law : Slider
    x_0 : float
        Where the contact carries no force [m].
    side : int
        +1 where x_r yields upwards, -1 downwards.
    poised : bool
        Whether it holds at this very limit, and just so: value and rate are zero exactly.

    Returns
    -------
    s, x_r, v_r
        As `vanish` gives them, of what the contact may still bear.
    """
    room = Blend(x_0, -side * law.k_t, 0.0, law.F_fk, 0.0)
    return vanish(stretch, waves, law, room, 2 if poised else 0, h, False)


@compiled
def swings_to(stretch, way, gap):
    """Guess whether the oscillator, left alone, goes so far [m] in its direction."""
    lean = way * stretch.a / stretch.w
    return lean + math.sqrt(lean * lean + stretch.v_r * stretch.v_r / stretch.w) >= gap


@compiled
def end_of_hold(stretch, waves, law, x_0, poised, way, gap, h):
    """Give when within h [s] the mass turns, and when a contact that holds yields.

    Parameters
    ----------
    stretch, waves, law, x_0
        As in `leave_hold`.
    poised : int
        The side at whose limit it holds just so, 0 for none.
    way : int
        Direction of motion.
    gap : float
        How far it may move until it yields if the limit stays [m].
    h : float
        Length of the stretch [s].

    Returns
    -------
    turn, x_turn : float
        Time [s], infinite for none, and x_r then.
    change, after, x_r, v_r
        Time, direction of yielding and the state then.

    Notes
    -----
    Whichever is guessed to come first is looked for first, so that the other one is looked for
    no longer than it matters.
    """
    change, after, x, v = NEVER, way, stretch.x_r, stretch.v_r
    looked = 0.0
    if way != 0 and swings_to(stretch, way, gap):
        looked = min(HALF_SWING / math.sqrt(stretch.w), h)
        change, x, v = leave_hold(stretch, waves, law, x_0, way, poised == way, looked)
    if change < NEVER:
        turn, x_turn = turning_before(stretch, waves, law, way, change, v)
    else:
        turn, x_turn = turning(stretch, waves, way, h)
    # Up to a turn x_r is monotone: a constant limit is not met before it is beyond there.
    short = law.variation == 0.0 and turn < NEVER and way * (x_turn - stretch.x_r) < gap
    until = min(turn, h)
    if change == NEVER and way != 0 and looked < until and not short:
        change, x, v = leave_hold(stretch, waves, law, x_0, way, poised == way, until)
    if law.variation > 0.0:
        for side in (-1, 1):
            # On the side that the mass leaves, a force that is not on it cannot yield.
            if side != way and (way == 0 or side * (stretch.x_r - x_0) > 0.0):
                until = min(change, turn, h)
                found, x_s, v_s = leave_hold(
                    stretch, waves, law, x_0, side, poised == side, until
                )
                if found < change:
                    change, after, x, v = found, side, x_s, v_s
    return turn, x_turn, change, after, x, v


@compiled
def end_of_yield(stretch, waves, law, d, way, h):
    """Give when within h [s] the mass turns, and when a yielding contact holds again.

    It does when the mass no longer outruns the limit of its spring, which with a constant
    normal force is when it stops. Result and parameters as in `end_of_hold`, with the direction
    d of yielding.
    """
    x, v = stretch.x_r, stretch.v_r
    if law.variation > 0.0:
        faster = Blend(0.0, 0.0, float(d), 0.0, -law.F_fk / law.k_t)
        change, x, v = vanish(stretch, waves, law, faster, 0, h, False)
        if change < NEVER and way != 0:
            turn, x_turn = turning_before(stretch, waves, law, way, change, v)
        else:
            turn, x_turn = turning(stretch, waves, way, h)
        return turn, x_turn, change, 0, x, v
    if way != d:
        return NEVER, x, 0.0, 0, x, v
    turn, x_turn = turning(stretch, waves, way, h)
    return turn, x_turn, turn, 0, x_turn, 0.0
