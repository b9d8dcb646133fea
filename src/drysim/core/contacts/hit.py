"""Where a step over a spring contact holds a stop or the limit: a guess, made exact at once.

The cubic through both ends of a stretch guesses; the closed form at the guess, and the series
about that point, leave rounding only. What they do not settle takes the general way.
"""

from __future__ import annotations

import math

from drysim.core.bracket import BISECTIONS, kept_between
from drysim.core.compiled import compiled, inlined
from drysim.core.contacts.whole import part_flow
from drysim.core.flow import flow
from drysim.core.samples.stop import NEVER, RESOLUTION, locate_stop

NEAR = 2e-4
"""Radians from a point within which four terms of the series about it are exact: the next is
below 1e-16."""

ROUNDS = 6
"""One round does mostly; what has not settled after some takes the general way."""


@compiled
def cross(c, w, v, a, r, gap, h):
    """Give the time in (0, h] at which a mass has gone the way `gap` [m], or infinity.

    Parameters
    ----------
    c, w, v, a, r
        As in `locate_stop`; the velocity does not change its sign up to h.
    """
    y, _, Y, YY = flow(c, w, h)
    p = a + c * v
    if v * y + p * Y + r * YY <= gap:
        return NEVER
    low, high = 0.0, h
    s = gap / v if 0.0 < gap < v * h else 0.5 * h
    for _ in range(BISECTIONS):
        y, y_d, Y, YY = flow(c, w, s)
        beyond = v * y + p * Y + r * YY - gap
        low, high = (low, s) if beyond > 0.0 else (s, high)
        speed = v * y_d + p * y + r * Y
        step = -beyond / speed if speed > 0.0 else NEVER
        if abs(step) <= RESOLUTION * s:
            return s
        s = kept_between(low, high, s + step)
        if not low < s < high:
            return high
    return s


@inlined
def guess(value, rate, value_end, rate_end, h):
    """Give where the cubic through both ends of a stretch, falling from above zero, is zero."""
    per_h = 1.0 / h
    bend = (value_end - value - rate * h) * per_h * per_h
    root = math.sqrt(max(rate * rate - 4.0 * bend * value, 0.0))
    s = 2.0 * value / (root - rate) if rate < 0.0 else -0.5 * (rate + root) / bend
    twist = (rate_end - rate - 2.0 * bend * h) * per_h * per_h
    slope = rate + 2.0 * bend * s + twist * s * (3.0 * s - 2.0 * h)
    return s - twist * s * s * (s - h) / slope if slope < 0.0 else s


@inlined
def sharpened(steps, v, a, r, gap, crossing, s):
    """Give a time, and the way and velocity then, of which s is a good guess.

    Parameters
    ----------
    steps, v, a, r
        As in `locate_stop`.
    gap : float
        The way that is looked for [m], where it is `crossing`; else it is a stop.

    Returns
    -------
    s, way, v
        s is negative where the guess was not good.
    """
    c, w = steps.c, steps.w
    p = a + c * v
    for _ in range(ROUNDS):
        y, y_d, Y, YY = part_flow(steps, s)
        way = v * y + p * Y + r * YY
        v_s = v * y_d + p * y + r * Y
        a_s = a * y_d + (r - w * v) * y
        j_s = r - c * a_s - w * v_s
        k_s = -(c * j_s + w * a_s)
        value, rate, bend, twist = v_s, a_s, j_s, k_s
        if crossing:
            value, rate, bend, twist = way - gap, v_s, a_s, j_s
        step = -value / rate
        step -= step * step * (0.5 * bend + twist * step / 6.0) / (rate + bend * step)
        if abs(step) * steps.rate <= NEAR and abs(bend * step) <= NEAR * abs(rate):
            way += step * (v_s + step * (0.5 * a_s + step * j_s / 6.0))
            return s + step, way, v_s + step * (a_s + step * (0.5 * j_s + step * k_s / 6.0))
        s += step
        if not 0.0 < s <= steps.dt:
            break
    return -1.0, 0.0, 0.0


@inlined
def moved(steps, v, a, r, s):
    """Give way and velocity at time s of a stretch."""
    y, y_d, Y, YY = part_flow(steps, s)
    p = a + steps.c * v
    return v * y + p * Y + r * YY, v * y_d + p * y + r * Y


@inlined
def turn_of(steps, v, a, r, v_end, a_end, h):
    """Give when a velocity above zero that does not end above it is zero, and the way then.

    Parameters
    ----------
    steps : Whole
        Of fine steps.
    v, a, r : float
        As in `locate_stop`.
    v_end, a_end : float
        Velocity [m/s] and its rate [m/s²] at the end.
    h : float
        Length [s], a step at most.

    Returns
    -------
    s, way
        s is negative where the guess was not good.
    """
    s, way, _ = sharpened(steps, v, a, r, 0.0, False, guess(v, a, v_end, a_end, h))
    return (s, way) if 0.0 < s <= h else (-1.0, 0.0)


@inlined
def next_stop(steps, v, a, r, h):
    """Give the first stop within h, or infinity, and the way until then or the end.

    Parameters
    ----------
    steps : Whole
    v, a, r, h : float
        As in `locate_stop`; h is a step at most.

    Returns
    -------
    stop, way, v_end : float
        Time [s]; distance [m] and velocity [m/s] then, or at the end.
    """
    y, y_d, _, _ = part_flow(steps, h)
    way, v_end = moved(steps, v, a, r, h)
    a_end = a * y_d + (r - steps.w * v) * y
    if steps.fine:
        if v_end > 0.0 and (a >= 0.0 or a_end <= 0.0):
            return NEVER, way, v_end
        if v_end <= 0.0:
            stop, far = turn_of(steps, v, a, r, v_end, a_end, h)
            if stop > 0.0:
                return stop, far, 0.0
    stop = locate_stop(steps.c, steps.w, v, a, r, h)
    if stop == NEVER:
        return NEVER, way, max(v_end, 0.0)
    return stop, moved(steps, v, a, r, stop)[0], 0.0


@inlined
def next_crossing(steps, v, a, r, gap, way, v_end, h):
    """Give when a mass that does not stop before h [s] has gone the way `gap` [m], and v then.

    `way` and `v_end` are those at h, and `way` is not less than `gap`.
    """
    s = guess(gap, -v, gap - way, -v_end, h)
    s, _, v_s = sharpened(steps, v, a, r, gap, True, s)
    if not 0.0 < s <= h:
        s = min(cross(steps.c, steps.w, v, a, r, gap, h), h)
        v_s = moved(steps, v, a, r, s)[1]
    return s, max(v_s, 0.0)
