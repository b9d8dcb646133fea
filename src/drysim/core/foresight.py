"""How far a series of the motion may be trusted, and where its velocity is zero first."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.dynamic import sliding_limit
from drysim.core.jet import value
from drysim.core.leave import parabola
from drysim.core.stop import NEVER, RESOLUTION

FLAT = 37.0
"""Exponent from which on the Stribeck curve is flat to double precision."""

BEYOND = 1.05
"""A series that begins nearer than this to the edge of the flat part foresees the rise."""


CURVE_SLACK = 10.0
"""Tolerances of F_fs that the curve at the end of a series may be off; roundings add up."""


@compiled
def first_zero(series, n, d, h):
    """Give the first time in (0, h] at which a velocity in direction d is zero, or infinity.

    Steps that a bound on the curvature proves safe lead to the first zero from below, so none
    is missed; a zero at the beginning itself is divided out.
    """
    first = 0
    while first <= n and series[first] == 0.0:
        first += 1
    if first >= n:
        return NEVER
    rest = 0.0
    bend = 0.0
    power = 1.0
    for k in range(1, n - first + 1):
        size = abs(series[first + k])
        rest += size * power * h
        if k > 1:
            bend += k * (k - 1) * size * power / h
        power *= h
    if abs(series[first]) > rest:
        return NEVER
    s = 0.0
    while True:
        v = 0.0
        a = 0.0
        for k in range(n, first - 1, -1):
            a = a * s + v
            v = v * s + d * series[k]
        if v <= 0.0:
            return s
        step = parabola(v, a, bend)
        if s + step > h:
            return NEVER
        if step <= RESOLUTION * s:
            return s
        s += step


@compiled
def foreseen(law, jet, n, d, h):
    """Give the length [s], at most h, over which a series foresees the Stribeck curve.

    Where the speed is far above v_s the rise of the curve lies beyond the last term, so a
    series ends where the rise begins to count.
    """
    edge = (FLAT if law.exponent == 1 else math.sqrt(FLAT)) * law.v_s
    v = jet.v[0]
    if law.F_fs == law.F_fk or d * v <= BEYOND * edge:
        return h
    jet.v[0] = v - d * edge
    arrives = first_zero(jet.v, n, d, h)
    jet.v[0] = v
    return min(arrives, h)


@compiled
def followed(law, jet, n, h):
    """Give the length [s], at most h, at whose end the series still is the Stribeck curve.

    Near the edge of the flat part the terms of the rise grow for long before they fall, so
    small terms alone do not tell that a series is complete.
    """
    if law.F_fs == law.F_fk:
        return h
    slack = CURVE_SLACK * law.tolerance * law.F_fs
    while (
        abs(law.F_fk + value(jet.g, n - 1, h) - sliding_limit(law, value(jet.v, n, h))) > slack
        and h > 0.0
    ):
        h *= 0.5
    return h
