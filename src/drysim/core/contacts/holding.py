"""When a spring contact that holds yields, or the mass turns before."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.contacts.yielding import turning_before
from drysim.core.samples.stop import NEVER, RESOLUTION
from drysim.core.sines.blend import (
    Blend,
    Instant,
    blended,
    bound_of,
    falls_surely,
    far_from_zero,
    instant,
    most_twist,
    safe_blend,
    starting_course,
)
from drysim.core.sines.cease import to_zero
from drysim.core.sines.vanish import seek, vanish

HALF_SWING = 3.2
"""Radians of the oscillator within which a contact that its swing makes yield does so."""


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
def turn_or_yield(stretch, waves, law, room, zeros, way, h):
    """Give the first of two times within h [s]: the mass turns, or a room is used up.

    Parameters
    ----------
    stretch, waves, law, zeros, h
        As in `vanish`.
    room : Blend
        What the contact may still bear on the side of the motion.
    way : int
        Direction of motion, not 0.

    Returns
    -------
    s, x_r, v_r, turns
        Time and state, as `vanish` gives them, and whether the mass turns then.

    Notes
    -----
    Both are approached at once, as long as neither is sure to come; then the one that is, and
    the other only up to there.
    """
    speed = Blend(0.0, 0.0, float(way), 0.0, 0.0)
    of_speed = bound_of(waves, law, speed, stretch.r, h)
    of_room = bound_of(waves, law, room, stretch.r, h)
    now = Instant(0.0, stretch.x_r, stretch.v_r, stretch.a, stretch.j, stretch.k)
    slows = blended(law, waves, speed, now)
    fills = starting_course(law, waves, room, now, zeros)
    while True:
        slow_most = most_twist(speed, stretch.w, now, of_speed)
        fill_most = most_twist(room, stretch.w, now, of_room)
        yields = far_from_zero(slows, slow_most, of_speed, h - now.s)
        turns = not yields and far_from_zero(fills, fill_most, of_room, h - now.s)
        if not (turns or yields):
            turns = falls_surely(slows, slow_most, of_speed)
            yields = falls_surely(fills, fill_most, of_room)
            if turns and yields:
                turns = to_zero(slows.value, slows.rate, slows.bend) < to_zero(
                    fills.value, fills.rate, fills.bend
                )
        if turns or yields:
            break
        slow_step = safe_blend(slows, slow_most, of_speed)
        step = min(slow_step, safe_blend(fills, fill_most, of_room))
        if step <= RESOLUTION * now.s:
            return now.s, now.x_r, now.v_r, step == slow_step
        if now.s + step >= h:
            return NEVER, now.x_r, now.v_r, False
        now = instant(stretch, waves, now.s + step)
        slows = blended(law, waves, speed, now)
        fills = blended(law, waves, room, now)
        if slows.value <= 0.0 or fills.value <= 0.0:
            return now.s, now.x_r, now.v_r, slows.value <= 0.0
    if turns:
        s, x_r, v_r, first = first_of_two(
            stretch, waves, law, now, speed, of_speed, slows, room, of_room, fills, h
        )
        return s, x_r, v_r, first and s < NEVER
    s, x_r, v_r, first = first_of_two(
        stretch, waves, law, now, room, of_room, fills, speed, of_speed, slows, h
    )
    return s, x_r, v_r, not first


@inlined
def first_of_two(stretch, waves, law, now, one, of_one, its, other, of_other, others, h):
    """Give when the first of two blends vanishes, the state then, and whether it is `one`.

    From an instant on; that one is looked for first, and the other only up to there.
    """
    s, x_r, v_r = seek(stretch, waves, law, one, of_one, now, its, h, False)
    until = min(s, h)
    most = most_twist(other, stretch.w, now, of_other)
    if not far_from_zero(others, most, of_other, until - now.s):
        # The speed at the end tells whether it may have been zero before.
        stays = s < NEVER and other.x == 0.0 and other.v * v_r > 0.0
        t, x, v = seek(stretch, waves, law, other, of_other, now, others, until, stays)
        if t < until:
            return t, x, v, False
    return s, x_r, v_r, True


@compiled
def swings_to(stretch, way, gap):
    """Guess whether the oscillator, left alone, goes so far [m] in its direction."""
    lean = way * stretch.a / stretch.w
    return lean + math.sqrt(lean * lean + stretch.v_r * stretch.v_r / stretch.w) >= gap


@compiled
def end_of_hold(stretch, waves, law, x_0, poised, way, gap, h):
    """Give when within h [s] the mass turns, or a contact that holds yields before.

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
    """
    turn, x_turn, change, after = NEVER, stretch.x_r, NEVER, way
    x, v = stretch.x_r, stretch.v_r
    if way != 0:
        if swings_to(stretch, way, gap):
            looked = min(HALF_SWING / math.sqrt(stretch.w), h)
            change, x, v = leave_hold(stretch, waves, law, x_0, way, poised == way, looked)
        if change < NEVER:
            turn, x_turn = turning_before(stretch, waves, law, way, change, v)
        else:
            room = Blend(x_0, -way * law.k_t, 0.0, law.F_fk, 0.0)
            s, x, v, turns = turn_or_yield(
                stretch, waves, law, room, 2 if poised == way else 0, way, h
            )
            if turns:
                turn, x_turn = s, x
            else:
                change = s
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
