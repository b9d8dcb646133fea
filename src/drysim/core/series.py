"""A short stretch of sliding as its power series: what most steps that hold an event need.

The general way (`flow`, `stop`) serves every length; on a step far shorter than the times of
the oscillator itself a few terms do the same for a third of the work.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled

SHORT = 0.0625
"""Radians (or decays) in a short stretch: nine terms of its series exhaust double precision."""

NEARLY = 1e-7
"""Relative step of Newton's method after which the next would be below the last digit."""

NEWTON_CAP = 8
"""Newton starts on a parabola and needs 2 rounds; what needs more takes the general way."""


@compiled
def series(c, w, v, a, r):
    """Give the coefficients of v(s) = q_0 + q_1 s + q_2 s² + ...

    Parameters
    ----------
    c, w, v, a, r : float
        As in `locate_stop`.
    """
    j = r - c * a - w * v
    d_3 = -(c * j + w * a)
    d_4 = -(c * d_3 + w * j)
    d_5 = -(c * d_4 + w * d_3)
    d_6 = -(c * d_5 + w * d_4)
    d_7 = -(c * d_6 + w * d_5)
    d_8 = -(c * d_7 + w * d_6)
    return (
        v, a, j * (1.0 / 2.0), d_3 * (1.0 / 6.0), d_4 * (1.0 / 24.0), d_5 * (1.0 / 120.0),
        d_6 * (1.0 / 720.0), d_7 * (1.0 / 5040.0), d_8 * (1.0 / 40320.0),
    )  # fmt: skip


@compiled
def distance(q, s):
    """Give the distance slid in time s."""
    return s * (
        q[0] + s * (q[1] * (1.0 / 2.0) + s * (q[2] * (1.0 / 3.0) + s * (q[3] * (1.0 / 4.0)
        + s * (q[4] * (1.0 / 5.0) + s * (q[5] * (1.0 / 6.0) + s * (q[6] * (1.0 / 7.0)
        + s * (q[7] * (1.0 / 8.0) + s * q[8] * (1.0 / 9.0))))))))
    )  # fmt: skip


@compiled
def speed(q, s):
    """Give velocity and acceleration after time s."""
    v = q[0] + s * (q[1] + s * (q[2] + s * (q[3] + s * (q[4] + s * (q[5] + s * (q[6] + s * (
        q[7] + s * q[8])))))))  # fmt: skip
    a = q[1] + s * (2.0 * q[2] + s * (3.0 * q[3] + s * (4.0 * q[4] + s * (5.0 * q[5] + s * (
        6.0 * q[6] + s * (7.0 * q[7] + s * (8.0 * q[8])))))))  # fmt: skip
    return v, a


@compiled
def fall(q, h):
    """Give the time in (0, h] at which a velocity above zero that ends below it is zero, or -1.

    A short stretch holds at most one extremum, so there is one such time. Newton starts where
    the parabola through the start is zero; where it strays, -1 says so.
    """
    square = q[1] * q[1] - 4.0 * q[0] * q[2]
    if square <= 0.0:
        return -1.0
    root = math.sqrt(square)
    s = 2.0 * q[0] / (root - q[1]) if root > q[1] else (-q[1] - root) / (2.0 * q[2])
    for _ in range(NEWTON_CAP):
        v, a = speed(q, s)
        if not (a < 0.0 and s > 0.0):
            return -1.0
        step = -v / a
        s += step
        if abs(step) <= NEARLY * s:
            return min(s, h)
    return -1.0
