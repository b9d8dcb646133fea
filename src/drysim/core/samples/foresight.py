"""How far a series of the motion may be trusted, and where its velocity is zero first."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.dynamic_laws.dynamic import flat_from, fractional, sliding_limit
from drysim.core.dynamic_laws.jet import BEYOND
from drysim.core.samples.stop import NEVER, RESOLUTION
from drysim.core.sines.leave import parabola

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
    power_before, power = 0.0, 1.0
    for k in range(1, n - first + 1):
        size = abs(series[first + k])
        rest += size * power * h
        bend += k * (k - 1) * size * power_before
        power_before, power = power, power * h
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
def foreseen(law, jet, n, d, h, slow):
    """Give the length [s], at most h, over which a series foresees the Stribeck curve.

    Where the speed is far above v_s the rise of the curve lies beyond the last term, so a
    series ends where the rise begins to count; and where it is too slow for friction to have
    fallen, at `slow` [m/s].
    """
    if law.F_fs == law.F_fk:
        return h
    edge = flat_from(law)
    v = jet.v[0]
    if d * v > BEYOND * edge:
        return min(passes(jet, n, d, edge, h), h)
    if slow > 0.0 and d * v <= slow:
        return min(passes(jet, n, -d, -2.0 * slow, h), h)
    return h


@compiled
def passes(jet, n, d, level, h):
    """Give when within h [s] the velocity in direction d comes down to a level [m/s]."""
    v = jet.v[0]
    jet.v[0] = v - d * level
    arrives = first_zero(jet.v, n, d, h)
    jet.v[0] = v
    return arrives


@compiled
def followed(plant, law, jet, n, d, h, v_least):
    """Give the length [s], at most h, at whose end the series still is the Stribeck curve.

    Near rest a curve that is steep there may be off by what changes the speed by
    `v_least` [m/s].

    Near the edge of the flat part the terms of the rise grow for long before they fall, so
    small terms alone do not tell that a series is complete. One that begins on the flat part
    is `foreseen` to stay there.
    """
    if law.F_fs == law.F_fk or d * jet.v[0] > BEYOND * flat_from(law):
        return h
    steep = 1.0 if fractional(law) else 0.0
    while h > 0.0:
        slack = max(CURVE_SLACK * law.tolerance * law.F_fs, steep * plant.m * v_least / h)
        v, excess = jet.v[n], 0.0
        for k in range(n - 1, -1, -1):
            v = v * h + jet.v[k]
            excess = excess * h + jet.g[k]
        if abs(law.F_fk + excess - sliding_limit(law, v)) <= slack:
            return h
        h *= 0.5
    return h
