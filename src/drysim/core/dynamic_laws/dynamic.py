"""The force of friction laws with a rate or a state of their own."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.plant import LEUVEN, STRIBECK

FLAT = 37.0
"""Exponent from which on the Stribeck curve is flat to double precision."""


@inlined
def fractional(law):
    """Tell whether the Stribeck curve is a series in the speed away from rest alone."""
    return law.exponent != 1 and law.exponent != 2


SLOWNESS = 100.0
"""Tolerances of a speed that it takes to tell a fractional power of it from its series: at a
few tolerances the terms of the series are beyond the numbers."""


@inlined
def slow_speed(law, jet):
    """Give the speed [m/s] at which a fractional power of it counts as none; 0 for the others.

    What this neglects is the share of a tolerance by which friction has fallen.
    """
    if not fractional(law):
        return 0.0
    return SLOWNESS * law.tolerance * max(jet.scale[0], law.v_s)


@inlined
def general_power(law):
    """Tell whether the share that bristles take is a series away from zero force alone."""
    return law.power != 1 and law.power != 2 and law.power != 3


@inlined
def faint_deflection(law):
    """Give the deflection [m] within which a general power of the force counts as none.

    What this neglects on the way from zero is a tolerance of the deflection at F_fk.
    """
    return law.tolerance ** (1.0 / (law.power + 1.0)) * law.F_fk / law.sigma_0


@inlined
def flat_from(law):
    """Give the speed [m/s] from which on the Stribeck curve is flat."""
    if law.exponent == 1:
        return FLAT * law.v_s
    return (math.sqrt(FLAT) if law.exponent == 2 else FLAT ** (1.0 / law.exponent)) * law.v_s


@compiled
def sliding_limit(law, v):
    """Give the Stribeck curve at a speed [N]: F_fs at rest, F_fk far from it."""
    if law.F_fs == law.F_fk:
        return law.F_fk
    q = abs(v) / law.v_s
    share = q if law.exponent == 1 else (q * q if law.exponent == 2 else q**law.exponent)
    return law.F_fk + (law.F_fs - law.F_fk) * math.exp(-share)


@compiled
def dynamic_force(law, d, v, z):
    """Give the friction force while the mass moves [N].

    Parameters
    ----------
    law : Dynamic
    d : int
        Direction of motion, -1 or +1.
    v, z : float
        Relative velocity [m/s] and deflection of the bristles [m].
    """
    limit = sliding_limit(law, v)
    if law.kind == STRIBECK:
        return d * limit
    share = law.sigma_0 * d * z / limit
    if law.kind == LEUVEN and law.power != 1:
        share = math.copysign(abs(share) ** law.power, share)
    z_d = v - v * share
    return law.sigma_0 * z + law.sigma_1 * z_d + law.sigma_2 * v
