"""The force of friction laws with a rate or a state of their own."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.plant import LEUVEN, STRIBECK


@compiled
def sliding_limit(law, v):
    """Give the Stribeck curve at a speed [N]: F_fs at rest, F_fk far from it."""
    if law.F_fs == law.F_fk:
        return law.F_fk
    q = abs(v) / law.v_s
    return law.F_fk + (law.F_fs - law.F_fk) * math.exp(-(q if law.exponent == 1 else q * q))


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
    if law.kind == LEUVEN and law.power > 1:
        share *= abs(share) ** (law.power - 1)
    z_d = v - v * share
    return law.sigma_0 * z + law.sigma_1 * z_d + law.sigma_2 * v
