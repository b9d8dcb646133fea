"""A step too long for a series, walked in parts up to the one that holds its first stop."""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.flow import flow
from drysim.core.samples.longer import SHORT, longer_series
from drysim.core.samples.series import distance, rate, speed
from drysim.core.samples.steps import FINE, rate_of
from drysim.core.samples.stop import NEVER, never_stops
from drysim.core.samples.within import stop_by_flow, stop_by_series

MOST_PARTS = 64
"""Parts, each no longer than a fine step, that are walked at most: a stop that is farther off
is left to the general way. That takes long for each swing, but a creep at one stride."""


class Parts(NamedTuple):
    """What a step too long for a series is walked in.

    Attributes
    ----------
    h, h_short : float
        Lengths of a part, which holds one extremum of v_r at most, and of a short one [s].
    whole, short : tuple of float, shape (4,)
        `flow` over them.
    """

    h: float
    h_short: float
    whole: tuple[float, float, float, float]
    short: tuple[float, float, float, float]


@compiled
def parts_of(steps):
    """Give the parts of such steps."""
    c, w = steps.c, steps.w
    h = steps.dt if steps.fine else FINE / rate_of(c, w)
    h_short = h / max(math.ceil((c + math.sqrt(w)) * h / SHORT), 1)
    return Parts(h, h_short, flow(c, w, h), flow(c, w, h_short))


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
    stop, way, v_end, a_end : float
        When it stops [s], infinity when it does not; how far it slides until then, or to the
        end [m]; velocity [m/s] and, at the end, acceleration there [m/s²].
    """
    c, w = steps.c, steps.w
    s, way = 0.0, 0.0
    until = 0.0 if never_stops(c, w, v, a, r) else min(h, MOST_PARTS * parts.h)
    while s < until:
        s, far, v, a = pass_parts(steps, parts, v, a, r, s, until)
        way += far
        length = min(parts.h_short, until - s)
        q = longer_series(steps.tail, steps.more, v, a, r - c * a - w * v)
        v_end = speed(q, length)
        stop, far = stop_by_series(q, v_end, length)
        if not stop > 0.0:
            stop, far = stop_by_flow(c, w, v, a, r, v_end, length)
        if stop != NEVER:
            return s + stop, way + far, 0.0, a
        way += distance(q, length)
        a = rate(q, length)
        v = max(v_end, 0.0)
        s += length
    left = h - until
    if left > 0.0:
        y, y_d, Y, YY = steps.whole if left == steps.dt else flow(c, w, left)
        p = a + c * v
        v_end = v * y_d + p * y + r * Y
        if not never_stops(c, w, v, a, r):
            stop, far = stop_by_flow(c, w, v, a, r, v_end, left)
            if stop != NEVER:
                return until + stop, way + far, 0.0, a
        way += v * y + p * Y + r * YY
        v, a = v_end, a * y_d + (r - w * v) * y
    return NEVER, way, v, a


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
