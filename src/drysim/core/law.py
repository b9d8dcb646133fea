"""What stands in for the sign of the velocity in approaches that know no stick."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled

SIGN, ARCTAN, TANH, ERF, RATIONAL = 0, 1, 2, 3, 4
"""Forms of the sliding force; all but the first are Eq. (8)."""


@compiled
def sliding_share(form, c, v_r):
    """Give the sliding force relative to F_fk [-].

    Parameters
    ----------
    form : int
        `SIGN` (sign(0) = 0) or one of the smooth forms.
    c : float
        Sharpness of the smooth forms [s/m].
    v_r : float
        Relative velocity [m/s].
    """
    if form == SIGN:
        return 1.0 if v_r > 0.0 else (-1.0 if v_r < 0.0 else 0.0)
    if form == TANH:
        return math.tanh(c * v_r)
    if form == ARCTAN:
        return 2.0 / math.pi * math.atan(c * v_r)
    if form == ERF:
        return math.erf(c * v_r)
    return c * v_r / (1.0 + c * abs(v_r))


@compiled
def sliding_shares(form, c, values):
    """Replace velocities [m/s] by their sliding force relative to F_fk, in place."""
    for n in range(len(values)):
        values[n] = sliding_share(form, c, values[n])
