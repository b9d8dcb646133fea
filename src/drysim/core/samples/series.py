"""A short stretch of sliding as its power series: what most steps that hold an event need.

Ten terms serve a brief one; with those that `longer` adds they serve one five times as long.

The general way (`flow`, `stop`) serves every length; on a step far shorter than the times of
the oscillator itself a few terms do the same for a third of the work.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compiled import compiled, inlined

TERMS, MORE = 10, 6
"""Terms of the series, and those that `longer` adds. They are counted from the end, for the
compiler leaves out what a series has not, but looks whether it could be there."""

BRIEF = 0.1
"""Radians (or decays) in a brief stretch: ten terms of its series exhaust double precision."""

NEARLY = 1e-6
"""Relative step of Halley's method, of third order, after which nothing is left to mend."""

HALLEY_CAP = 8
"""The first guess is off by less than that mostly; what strays takes the general way."""


class Tail(NamedTuple):
    """How acceleration (a) and jerk (j) at the start go on in the terms of v from s³ to s⁹."""

    a_3: float
    j_3: float
    a_4: float
    j_4: float
    a_5: float
    j_5: float
    a_6: float
    j_6: float
    a_7: float
    j_7: float
    a_8: float
    j_8: float
    a_9: float
    j_9: float


@compiled
def tail_of(c, w):
    """Give the tail of the series: each derivative is minus c times the last, w that before."""
    a_3, j_3 = -w, -c
    a_4, j_4 = -c * a_3, -(c * j_3 + w)
    a_5, j_5 = -(c * a_4 + w * a_3), -(c * j_4 + w * j_3)
    a_6, j_6 = -(c * a_5 + w * a_4), -(c * j_5 + w * j_4)
    a_7, j_7 = -(c * a_6 + w * a_5), -(c * j_6 + w * j_5)
    a_8, j_8 = -(c * a_7 + w * a_6), -(c * j_7 + w * j_6)
    a_9, j_9 = -(c * a_8 + w * a_7), -(c * j_8 + w * j_7)
    return Tail(
        a_3 / 6.0, j_3 / 6.0, a_4 / 24.0, j_4 / 24.0, a_5 / 120.0, j_5 / 120.0,
        a_6 / 720.0, j_6 / 720.0, a_7 / 5040.0, j_7 / 5040.0, a_8 / 40320.0, j_8 / 40320.0,
        a_9 / 362880.0, j_9 / 362880.0,
    )  # fmt: skip


@compiled
def series(tail, v, a, j):
    """Give the coefficients of v(s) = q_0 + q_1 s + q_2 s² + ... from v, a and the jerk."""
    return (
        v, a, 0.5 * j, tail.a_3 * a + tail.j_3 * j, tail.a_4 * a + tail.j_4 * j,
        tail.a_5 * a + tail.j_5 * j, tail.a_6 * a + tail.j_6 * j, tail.a_7 * a + tail.j_7 * j,
        tail.a_8 * a + tail.j_8 * j, tail.a_9 * a + tail.j_9 * j,
    )  # fmt: skip


@compiled
def distance(q, s):
    """Give the distance slid in time s."""
    s_2 = s * s
    s_4 = s_2 * s_2
    low = (q[0] + q[1] * (1.0 / 2.0) * s) + s_2 * (q[2] * (1.0 / 3.0) + q[3] * (1.0 / 4.0) * s)
    high = (q[4] * (1.0 / 5.0) + q[5] * (1.0 / 6.0) * s) + s_2 * (
        q[6] * (1.0 / 7.0) + q[7] * (1.0 / 8.0) * s
    )
    high += s_4 * (q[8] * (1.0 / 9.0) + q[9] * (1.0 / 10.0) * s)
    if len(q) > TERMS:
        n = len(q) - MORE
        far = (q[n] * (1.0 / 11.0) + q[n + 1] * (1.0 / 12.0) * s) + s_2 * (
            (q[n + 2] * (1.0 / 13.0) + q[n + 3] * (1.0 / 14.0) * s)
            + s_2 * (q[n + 4] * (1.0 / 15.0) + q[n + 5] * (1.0 / 16.0) * s)
        )
        high += s_4 * s_2 * far
    return s * (low + s_4 * high)


@compiled
def speed(q, s):
    """Give the velocity after time s."""
    s_2 = s * s
    s_4 = s_2 * s_2
    low = (q[0] + q[1] * s) + s_2 * (q[2] + q[3] * s)
    high = (q[4] + q[5] * s) + s_2 * (q[6] + q[7] * s) + s_4 * (q[8] + q[9] * s)
    if len(q) > TERMS:
        n = len(q) - MORE
        far = (q[n] + q[n + 1] * s) + s_2 * (
            (q[n + 2] + q[n + 3] * s) + s_2 * (q[n + 4] + q[n + 5] * s)
        )
        high += s_4 * s_2 * far
    return low + s_4 * high


@compiled
def rate(q, s):
    """Give the acceleration after time s."""
    s_2 = s * s
    s_4 = s_2 * s_2
    low = (q[1] + 2.0 * q[2] * s) + s_2 * (3.0 * q[3] + 4.0 * q[4] * s)
    high = (5.0 * q[5] + 6.0 * q[6] * s) + s_2 * (7.0 * q[7] + 8.0 * q[8] * s)
    high += s_4 * (9.0 * q[9])
    if len(q) > TERMS:
        n = len(q) - MORE
        far = (10.0 * q[n] + 11.0 * q[n + 1] * s) + s_2 * (
            (12.0 * q[n + 2] + 13.0 * q[n + 3] * s)
            + s_2 * (14.0 * q[n + 4] + 15.0 * q[n + 5] * s)
        )
        high += s_4 * s * far
    return low + s_4 * high


@inlined
def fall(q, h):
    """Give when in (0, h] a velocity above zero that ends below is zero, and the way there.

    A short stretch holds at most one extremum, so there is one such time. The first guess is
    where the parabola through the start is zero, mended by the next two terms; where Halley's
    method strays from there, a time of -1 says so. The way is that to the last guess and what
    the last step adds, so it need not wait for the time.
    """
    square = q[1] * q[1] - 4.0 * q[0] * q[2]
    if square <= 0.0:
        return -1.0, 0.0
    root = math.sqrt(square)
    s = 2.0 * q[0] / (root - q[1]) if root > q[1] else (-q[1] - root) / (2.0 * q[2])
    s += s * s * s * (q[3] + s * q[4]) * (1.0 / root)
    for _ in range(HALLEY_CAP):
        a = rate(q, s)
        if not (a < 0.0 and s > 0.0):
            return -1.0, 0.0
        v, way = speed(q, s), distance(q, s)
        per_a = 1.0 / a
        step = -v * per_a
        step -= step * step * (q[2] + 3.0 * q[3] * s) * per_a
        s += step
        if abs(step) <= NEARLY * s:
            return min(s, h), way + step * (v + 0.5 * step * a)
    return -1.0, 0.0
