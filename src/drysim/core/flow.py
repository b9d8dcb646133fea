"""The closed-form flow of the oscillator: what every exact solution is made of.

The equation is x" + c x' + w x = g(s) with c = b/m and w = k_x/m. A short stretch is summed as
its power series until nothing is left to add; a long one is doubled up from a short one. No
damping regime is special: no formula divides by w, by c, or by a difference of roots.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled

SHORT = 0.5
"""A stretch is short when its length times the fastest rate is below this."""

TERMS = 17
"""Terms that exhaust double precision on a short stretch: 0.5^17·17/19! is below 1e-20."""

HELD = 0.75
"""Value of c y that only a motion far beyond critical damping comes to, critical is 2/e, and
only while its spring has given back less than the rest of 1."""

INVERSE_FACTORIAL = tuple(1.0 / math.factorial(n) for n in range(TERMS + 4))


@compiled
def few(rate):
    """Give the number of series terms that exhaust double precision at rate·length `rate`."""
    if rate > 0.0625:
        return TERMS
    return 10 if rate > 0.004 else 7


@compiled
def flow(c, w, s):
    """Give the response to a unit kick, its slope, and its first two integrals.

    Parameters
    ----------
    c, w : float
        b/m [1/s] and k_x/m [1/s²], at least 0.
    s : float
        Length of the stretch [s], at least 0.

    Returns
    -------
    y, y_d : float
        Solution of y" + c y' + w y = 0, y(0) = 0, y'(0) = 1 [s], and its slope [-].
    Y, YY : float
        Integral of y from 0 to s [s²], the response to a unit step, and the integral of Y
        [s³], the response to a unit ramp.

    Notes
    -----
    From x_0, v_0 under g = g_0 + r s: x = x_0 + v_0 y + (g_0 - w x_0) Y + r YY.
    """
    rate = (c + math.sqrt(w)) * s
    doublings = 0
    h = s
    while rate > SHORT:
        rate *= 0.5
        h *= 0.5
        doublings += 1
    ch = c * h
    wh = w * h * h
    q_before = 0.0
    q = 1.0
    second = 0.0
    third = 0.0
    for n in range(1, few(rate)):
        second += q * INVERSE_FACTORIAL[n + 2]
        third += q * INVERSE_FACTORIAL[n + 3]
        q, q_before = -(ch * q + wh * q_before), q
    # The equation, integrated, gives the rest without cancellation on a short stretch.
    YY = second * h * h * h
    Y = h * h * (0.5 - ch * second - wh * third)
    y = h - c * Y - w * YY
    y_d = 1.0 - c * y - w * Y
    for _ in range(doublings):
        # Both are the same; but 1 - w Y loses what is left of a motion that dies away, and
        # y_d + c y of one that a damper holds doubles the rounding of y each time.
        keep = 1.0 - w * Y if c * y > HELD else y_d + c * y
        YY = YY * (1.0 + keep) + Y * (h + y)
        Y, y, y_d = Y * (1.0 + keep) + y * y, y * (keep + y_d), y_d * y_d - w * y * y
        h *= 2.0
    return y, y_d, Y, YY
