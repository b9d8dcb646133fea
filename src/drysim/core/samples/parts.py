"""A step too long for a series, walked in parts up to the one that holds its first stop."""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.flow import flow
from drysim.core.samples.longer import SHORT, longer_series
from drysim.core.samples.series import distance, rate, speed
from drysim.core.samples.steps import FINE, rate_of
from drysim.core.samples.stop import NEVER
from drysim.core.samples.within import stop_by_flow, stop_by_series

MOST_PARTS = 64
"""Parts, each no longer than a fine step, that a step is walked in at most: what is longer is
left to the general way."""


class Parts(NamedTuple):
    """What a step too long for a series is walked in.

    Attributes
    ----------
    few : bool
        Whether they are few enough to be walked.
    h, h_short : float
        Lengths of a part, which holds one extremum of v_r at most, and of a short one [s].
    whole, short : tuple of float, shape (4,)
        `flow` over them.
    """

    few: bool
    h: float
    h_short: float
    whole: tuple[float, float, float, float]
    short: tuple[float, float, float, float]


@compiled
def parts_of(steps):
    """Give the parts of such steps."""
    c, w, dt = steps.c, steps.w, steps.dt
    count = parts_by(rate_of(c, w) * dt, FINE)
    h = dt / count
    h_short = h / parts_by((c + math.sqrt(w)) * h, SHORT)
    few = rate_of(c, w) * dt <= FINE * MOST_PARTS
    return Parts(few, h, h_short, flow(c, w, h), flow(c, w, h_short))


@compiled
def parts_by(radians, longest):
    """Give how many parts of so many radians something takes, as far as it is walked."""
    return max(math.ceil(min(radians / longest, MOST_PARTS)), 1)


@inlined
def slide_on(steps, parts, v, a, r, h):
    """Slide up to the first stop in a long step, or in what is left of it, or to its end.

    Parameters
    ----------
    steps : Steps
    parts : Parts
        Of them.
    v, a, r, h : float
        As in `locate_stop`.

    Returns
    -------
    stop, way, v_end : float
        When it stops [s], infinity when it does not; how far it slides until then, or to the
        end [m], and how fast it is there [m/s].
    """
    c, w = steps.c, steps.w
    for_ever = never_stops(c, w, v, a, r)
    if for_ever or not parts.few:
        y, y_d, Y, YY = steps.whole if h == steps.dt else flow(c, w, h)
        p = a + c * v
        way, v_end = v * y + p * Y + r * YY, v * y_d + p * y + r * Y
        if for_ever:
            return NEVER, way, v_end
        stop, far = stop_by_flow(c, w, v, a, r, v_end, h)
        return stop, way if stop == NEVER else far, v_end
    s, way = 0.0, 0.0
    while s < h:
        s, far, v, a = pass_parts(steps, parts, v, a, r, s, h)
        way += far
        length = min(parts.h_short, h - s)
        q = longer_series(steps.tail, steps.more, v, a, r - c * a - w * v)
        v_end = speed(q, length)
        stop, far = stop_by_series(q, v_end, length)
        if not stop > 0.0:
            stop, far = stop_by_flow(c, w, v, a, r, v_end, length)
        if stop != NEVER:
            return s + stop, way + far, 0.0
        way += distance(q, length)
        a = rate(q, length)
        v = max(v_end, 0.0)
        s += length
    return NEVER, way, v


@inlined
def never_stops(c, w, v, a, r):
    """Tell whether a mass that slides so will never stop under this force.

    Its velocity is an oscillator of its own under the steady force r, whose energy a² + w v² -
    2 r v, counted from rest, only falls. It has to be at least 0 where v = 0.
    """
    return a * a < v * (2.0 * r - w * v)


@inlined
def pass_parts(steps, parts, v, a, r, s, h):
    """Pass the parts from time s up to h that hold no stop; gives s, the way, v and a there.

    A part holds one extremum of v at most, and the acceleration outlasts it, so its signs at
    both ends tell of a dip.
    """
    c, w = steps.c, steps.w
    length, (y, y_d, Y, YY) = parts.h, parts.whole
    way, coarse = 0.0, True
    while True:
        p = a + c * v
        v_1 = v * y_d + p * y + r * Y
        a_1 = a * y_d + (r - w * v) * y
        if s + length > h or v_1 <= 0.0 or (a < 0.0 < a_1 and not never_stops(c, w, v, a, r)):
            if not coarse:
                return s, way, v, a
            coarse = False
            length, (y, y_d, Y, YY) = parts.h_short, parts.short
            continue
        way += v * y + p * Y + r * YY
        v, a = v_1, a_1
        s += length
