"""The force of dynamic laws term by term: in what the series of one law differs."""

from __future__ import annotations

import math

from drysim.core.compiled import inlined
from drysim.core.dynamic_laws.dynamic import faint_deflection, general_power
from drysim.core.plant import LEUVEN, STRIBECK


@inlined
def force_term(law, jet, d, n, falls, per_curve):
    """Set term n of the friction force [N] and, for bristles, term n + 1 of z.

    Parameters
    ----------
    law, jet, d
        As in `grow`.
    n : int
        All terms before it are set.
    falls : bool
        Whether friction changes with the speed here.
    per_curve : float
        One over the Stribeck curve at the beginning [1/N].
    """
    known = excess_term(law, jet, d, n) if falls and n > 0 else 0.0
    if law.kind == STRIBECK:
        jet.F[n] = d * ((law.F_fk if n == 0 else 0.0) + jet.g[n])
        return
    if law.kind == LEUVEN:
        jet.p[n] = (d * law.sigma_0 * jet.z[n] - known) * per_curve
        z_d = travel_term(law, jet, d, n)
        jet.z[n + 1] = deflection_term(jet, n) / (n + 1)
    else:
        product = product_term(jet.v, jet.z, n)
        jet.p[n] = (d * product - known) * per_curve
        z_d = jet.v[n] - law.sigma_0 * jet.p[n]
        jet.z[n + 1] = z_d / (n + 1)
    jet.F[n] = law.sigma_0 * jet.z[n] + law.sigma_1 * z_d + law.sigma_2 * jet.v[n]


@inlined
def excess_start(law, jet, d, v):
    """Set the beginning of the Stribeck curve's excess over F_fk [N], and of its exponent."""
    q = d * v / law.v_s
    jet.s[0] = q if law.exponent == 1 else (q * q if law.exponent == 2 else q**law.exponent)
    jet.g[0] = (law.F_fs - law.F_fk) * math.exp(-jet.s[0])


@inlined
def excess_term(law, jet, d, n):
    """Set term n, above 0, of the excess: its rate is -s' times it.

    `jet.s` holds n times the terms of the exponent, but for the first. Gives the part of term n
    of the curve times p that is known before p's own. The sums go on side by side: each has to
    wait for its last term.
    """
    square, fall, known = 0.0, 0.0, 0.0
    if n % 2 == 0:
        k = n // 2
        square = jet.v[k] * jet.v[k]
        fall = jet.s[k] * jet.g[k]
        known = jet.g[k] * jet.p[k]
    for k in range((n - 1) // 2, 0, -1):
        m = n - k
        square += 2.0 * (jet.v[k] * jet.v[m])
        fall += jet.s[k] * jet.g[m] + jet.s[m] * jet.g[k]
        known += jet.g[k] * jet.p[m] + jet.g[m] * jet.p[k]
    if law.exponent == 1:
        jet.s[n] = n * d * jet.v[n] / law.v_s
    elif law.exponent == 2:
        jet.s[n] = n * (square + 2.0 * jet.v[0] * jet.v[n]) / (law.v_s * law.v_s)
    else:
        total = law.exponent * n * jet.v[n] * jet.s[0]
        for k in range(1, n):
            total += (law.exponent * k / (n - k) - 1.0) * jet.v[k] * jet.s[n - k]
        jet.s[n] = total / jet.v[0]
    jet.g[n] = -(fall + jet.s[n] * jet.g[0]) / n
    return known + jet.g[n] * jet.p[0]


@inlined
def product_term(one, two, n):
    """Give term n of the product of two series, from both ends at once."""
    total = one[n // 2] * two[n // 2] if n % 2 == 0 else 0.0
    for k in range((n - 1) // 2, -1, -1):
        total += one[k] * two[n - k] + one[n - k] * two[k]
    return total


@inlined
def travel_term(law, jet, d, n):
    """Set term n of w = v (1 - sgn(p) |p|^power) [m/s], with p the force over its limit."""
    if law.power == 1:
        jet.w[n] = jet.v[n] - product_term(jet.v, jet.p, n)
        return jet.w[n]
    if general_power(law):
        power_term(law, jet, n)
        jet.w[n] = jet.v[n] - product_term(jet.v, jet.share, n)
        return jet.w[n]
    jet.square[n] = product_term(jet.p, jet.p, n)
    if law.power == 2:
        side = 1.0 if heads_up(jet) == (d > 0) else -1.0
        jet.w[n] = jet.v[n] - side * product_term(jet.v, jet.square, n)
        return jet.w[n]
    jet.share[n] = product_term(jet.p, jet.square, n)
    jet.w[n] = jet.v[n] - product_term(jet.v, jet.share, n)
    return jet.w[n]


@inlined
def power_term(law, jet, n):
    """Set term n of sgn(p) |p|^power, from its rate; of a faint force all of them are 0."""
    if n == 0:
        faint = abs(jet.z[0]) <= faint_deflection(law)
        jet.share[0] = 0.0 if faint else math.copysign(abs(jet.p[0]) ** law.power, jet.p[0])
        return
    total = 0.0
    if jet.share[0] != 0.0:
        for k in range(1, n + 1):
            total += (law.power * k - (n - k)) * jet.p[k] * jet.share[n - k]
        total /= n * jet.p[0]
    jet.share[n] = total


@inlined
def heads_up(jet):
    """Tell whether the deflection is above zero, or goes there from zero."""
    return jet.z[0] > 0.0 or (jet.z[0] == 0.0 and jet.slope[1] < 0.0)


@inlined
def deflection_term(jet, n):
    """Give term n of the rate of z [m/s], which rises less and less with the travel."""
    return jet.slope[0] * jet.w[n] + jet.slope[1] * product_term(jet.w, jet.z, n)
