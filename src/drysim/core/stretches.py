"""Exact integrals over a stretch between two events under ü that changes linearly."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.gauss import FOUR_NODES, FOUR_WEIGHTS, SIX_NODES, SIX_WEIGHTS
from drysim.core.samples.longer import SHORT, longer_series
from drysim.core.samples.series import distance, rate, series, speed


@inlined
def stretch(steps, u_0, slope, x_r, v_r, d, h):
    """Give x2, v2, x_dd2, power and rub of one stretch between events, as in `Totals`."""
    if d == 0:
        u_1 = u_0 + slope * h
        u2 = h / 3.0 * (u_0 * u_0 + u_0 * u_1 + u_1 * u_1)
        return x_r * x_r * h, 0.0, u2, 0.0, 0.0
    c, w, f = steps.c, steps.w, d * steps.f
    if not steps.brief:
        return slid(c, w, f, steps.tail, steps.more, u_0, slope, x_r, v_r, d, h)
    a = -(u_0 + c * v_r + w * x_r + f)
    q = series(steps.tail, v_r, a, -slope - c * a - w * v_r)
    # Four exhaust double precision where `series` serves: the error is below (2·0.1)⁸/10⁹.
    sums = summed(q, FOUR_NODES, FOUR_WEIGHTS, c, w, f, u_0, slope, x_r, h)
    return *sums, d * distance(q, h)


@compiled
def slid(c, w, f, tail, more, u_0, slope, x_r, v_r, d, h):
    """Give what `stretch` gives of sliding for any length, in panels that a series serves.

    `f` is the friction force per mass, with its sign [m/s²].
    """
    radians = c + math.sqrt(w)
    longest = SHORT / radians if radians > 0.0 else math.inf
    a = -(u_0 + c * v_r + w * x_r + f)
    x2, v2, x_dd2, power, x, s = 0.0, 0.0, 0.0, 0.0, x_r, 0.0
    while s < h:
        length = min(longest, h - s)
        q = longer_series(tail, more, v_r, a, -slope - c * a - w * v_r)
        u = u_0 + slope * s
        # Six do where `longer_series` serves: (2·0.5)¹²/10¹⁵.
        sums = summed(q, SIX_NODES, SIX_WEIGHTS, c, w, f, u, slope, x, length)
        x2, v2 = x2 + sums[0], v2 + sums[1]
        x_dd2, power = x_dd2 + sums[2], power + sums[3]
        x, v_r, a = x + distance(q, length), speed(q, length), rate(q, length)
        s += length
    return x2, v2, x_dd2, power, d * (x - x_r)


@inlined
def summed(q, nodes, weights, c, w, f, u_0, slope, x_r, h):
    """Give x2, v2, x_dd2 and power of a motion whose velocity is a series."""
    x2, v2, x_dd2, power = 0.0, 0.0, 0.0, 0.0
    for i in range(len(nodes)):
        s = h * nodes[i]
        x, v = x_r + distance(q, s), speed(q, s)
        x_dd = w * x + c * v + f
        x2 += weights[i] * x * x
        v2 += weights[i] * v * v
        x_dd2 += weights[i] * x_dd * x_dd
        power += weights[i] * (u_0 + slope * s) * v
    return h * x2, h * v2, h * x_dd2, h * power
