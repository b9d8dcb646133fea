"""When a spring contact that holds yields."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.contacts.ring import clear_of, ringing, stays_within
from drysim.core.events import onset
from drysim.core.samples.stop import NEVER
from drysim.core.sines.blend import Blend, blended, bound_of, far_from_zero, instant, most_twist
from drysim.core.sines.leave import WINDOW
from drysim.core.sines.stretch import force_rates
from drysim.core.sines.vanish import seek, vanish
from drysim.core.waves import normal_force

HALF_SWING = 3.2
"""Radians of the oscillator within which a contact that its swing makes yield does so."""


@compiled
def leave_hold(stretch, waves, law, x_0, side, poised, begin, until):
    """Give the first time at which a holding contact yields to one side, and how.

    Parameters
    ----------
    stretch, waves
        As in `vanish`, with the spring of the contact in the stretch.
    law : Slider
    x_0 : float
        Where the contact carries no force [m].
    side : int
        +1 where x_r yields upwards, -1 downwards.
    poised : bool
        Whether at the start it holds at this very limit, and just so: value and rate are zero
        exactly.
    begin, until : float
        Times of the stretch [s].

    Returns
    -------
    s, x_r, v_r
        As `vanish` gives them, of what the contact may still bear.
    """
    room = Blend(x_0, -side * law.k_t, 0.0, law.F_fk, 0.0)
    if begin == 0.0:
        return vanish(stretch, waves, law, room, 2 if poised else 0, until)
    bound = bound_of(waves, law, room, stretch.r, until)
    now = instant(stretch, waves, begin)
    course = blended(law, waves, room, now)
    if course.value <= 0.0:
        return now.s, now.x_r, now.v_r
    if far_from_zero(course, most_twist(room, stretch.w, now, bound), bound, until - begin):
        return NEVER, now.x_r, now.v_r
    return seek(stretch, waves, law, room, bound, now, course, until)


@compiled
def or_before(stretch, waves, law, x_0, side, poised, begin, until, s, x, v):
    """Give time, side and state of a contact that yields, unless it yields before.

    Parameters
    ----------
    stretch, waves, law, x_0, side, poised, begin, until
        As in `leave_hold`: what may be before.
    s, x, v
        When it yields to the other side, as `leave_hold` gives it.
    """
    if begin < until:
        t, x_t, v_t = leave_hold(stretch, waves, law, x_0, side, poised, begin, until)
        if t < s:
            return t, side, x_t, v_t
    return s, -side, x, v


@compiled
def swings_to(stretch, way, gap):
    """Guess whether the oscillator, left alone, goes so far [m] in its direction."""
    lean = way * stretch.a / stretch.w
    return lean + math.sqrt(lean * lean + stretch.v_r * stretch.v_r / stretch.w) >= gap


@compiled
def end_of_hold(stretch, waves, law, x_0, poised, h):
    """Give when within h [s] a contact that holds yields.

    Parameters
    ----------
    stretch, waves, law, x_0
        As in `leave_hold`.
    poised : int
        The side at whose limit it holds just so, 0 for none.
    h : float
        Length of the stretch [s].

    Returns
    -------
    s, side, x_r, v_r
        Time [s], infinite for never, direction of yielding, and the state then.

    Notes
    -----
    A contact that swings within the stretch is looked at swing by swing, and only where its
    envelope does not show that it holds. A peak stands for half a swing on either side, so
    that the one before has told of the other side up to this peak.
    """
    reach, way = law.F_fk / law.k_t, onset(stretch.v_r, stretch.a, stretch.j)
    gap = reach * normal_force(law, waves, 0.0)[0] - way * (stretch.x_r - x_0)
    if way * poised <= 0 and swings_to(stretch, way, gap):
        looked = min(HALF_SWING / math.sqrt(stretch.w), h)
        s, x, v = leave_hold(stretch, waves, law, x_0, way, False, 0.0, looked)
        if s < NEVER:
            other = -way, poised == -way, 0.0, s
            return or_before(stretch, waves, law, x_0, *other, s, x, v)
    own = ringing(stretch, waves)
    if own.side == 0 or h <= own.half:
        side = way if way != 0 else 1
        # Window by window: a side that never yields is not followed to the end each time.
        fastest = force_rates(waves, stretch.r)[3]
        begin, until = 0.0, min(WINDOW / fastest, h) if fastest > 0.0 else h
        while True:
            s, x, v = leave_hold(
                stretch, waves, law, x_0, side, begin == 0.0 and poised == side, begin, until
            )
            other = -side, begin == 0.0 and poised == -side, begin, min(s, until)
            s, side, x, v = or_before(stretch, waves, law, x_0, *other, s, x, v)
            if s < NEVER or until >= h:
                return s, side, x, v
            begin, until = until, min(3.0 * until, h)
    number, clear = -1 if own.phase > 0.0 else 0, 0.0
    while clear < h:
        side = own.side if number % 2 == 0 else -own.side
        peak = own.phase / own.omega + number * own.half
        before = own.half
        if clear > 0.0 or side != poised:
            before = clear_of(own, stretch, waves, law, x_0, side, peak)
        begin, until = max(clear, peak - before), min(peak + own.half, h)
        if before >= 0.0 and begin < until:
            s, x, v = leave_hold(stretch, waves, law, x_0, side, poised == side, begin, until)
            if s < NEVER:
                other = -side, poised == -side, max(clear, peak), s
                return or_before(stretch, waves, law, x_0, *other, s, x, v)
        number += 1
        if peak >= clear:
            clear = stays_within(own, stretch, waves, law, x_0, reach, True, peak, h)
            number = max(number, math.floor((own.omega * clear - own.phase) / math.pi))
    return NEVER, 0, stretch.x_r, stretch.v_r
