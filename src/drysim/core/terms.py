"""The force of dynamic laws term by term: in what the series of one law differs."""

from __future__ import annotations

import math

from drysim.core.compiled import inlined
from drysim.core.plant import LEUVEN, STRIBECK


@inlined
def inner_sums(jet, n):
    """Give the inner part of term n of the products v v, v z, s' g and g p.

    One loop for all: the sums do not wait for each other.
    """
    vv, vz, sg, gp = 0.0, 0.0, 0.0, 0.0
    for k in range(1, n):
        vv += jet.v[k] * jet.v[n - k]
        vz += jet.v[k] * jet.z[n - k]
        sg += k * jet.s[k] * jet.g[n - k]
        gp += jet.g[k] * jet.p[n - k]
    return vv, vz, sg, gp


@inlined
def excess_term(law, jet, d, n, vv, sg):
    """Set term n of the Stribeck curve's excess over F_fk [N]: its rate is -s' times it."""
    if law.exponent == 1:
        jet.s[n] = d * jet.v[n] / law.v_s
    else:
        square = vv + (2.0 if n > 0 else 1.0) * jet.v[0] * jet.v[n]
        jet.s[n] = square / (law.v_s * law.v_s)
    if n == 0:
        jet.g[0] = (law.F_fs - law.F_fk) * math.exp(-jet.s[0])
    else:
        jet.g[n] = -(sg + n * jet.s[n] * jet.g[0]) / n


@inlined
def force_term(law, jet, d, n):
    """Set term n of the friction force [N] and, for bristles, term n + 1 of z."""
    vv, vz, sg, gp = inner_sums(jet, n)
    if law.F_fs != law.F_fk:
        excess_term(law, jet, d, n, vv, sg)
    if law.kind == STRIBECK:
        jet.F[n] = d * ((law.F_fk if n == 0 else 0.0) + jet.g[n])
        return
    if n > 0:
        gp += jet.g[n] * jet.p[0]
    curve = law.F_fk + jet.g[0]
    if law.kind == LEUVEN:
        jet.p[n] = (d * law.sigma_0 * jet.z[n] - gp) / curve
        z_d = travel_term(law, jet, d, n)
        jet.z[n + 1] = deflection_term(jet, n) / (n + 1)
    else:
        product = vz + jet.v[0] * jet.z[n]
        if n > 0:
            product += jet.v[n] * jet.z[0]
        jet.p[n] = (d * product - gp) / curve
        z_d = jet.v[n] - law.sigma_0 * jet.p[n]
        jet.z[n + 1] = z_d / (n + 1)
    jet.F[n] = law.sigma_0 * jet.z[n] + law.sigma_1 * z_d + law.sigma_2 * jet.v[n]


@inlined
def product_term(one, two, n):
    """Give term n of the product of two series."""
    total = 0.0
    for k in range(n + 1):
        total += one[k] * two[n - k]
    return total


@inlined
def travel_term(law, jet, d, n):
    """Set term n of w = v (1 - sgn(p) |p|^power) [m/s], with p the force over its limit."""
    if law.power == 1:
        jet.w[n] = jet.v[n] - product_term(jet.v, jet.p, n)
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
def heads_up(jet):
    """Tell whether the deflection is above zero, or goes there from zero."""
    return jet.z[0] > 0.0 or (jet.z[0] == 0.0 and jet.slope[1] < 0.0)


@inlined
def deflection_term(jet, n):
    """Give term n of the rate of z [m/s], which rises less and less with the travel."""
    return jet.slope[0] * jet.w[n] + jet.slope[1] * product_term(jet.w, jet.z, n)
