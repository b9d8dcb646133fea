"""Integrals over many steps by the rule of trapezia, made exact by what its ends say.

Within a step the motion is smooth, so the series of Euler and Maclaurin is exact: the rule,
and at either end of a step a form of what the motion is there. Where one step ends and the
next begins, nothing but the slope of ü has changed, so of two forms one term is left. So a
step costs a few sums in place of all products of what it is made of.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from drysim.core.compiled import fused

X2, V2, X_DD2, POWER, RUB, STUCK, U_DD2, INTEGRALS = range(8)
"""Integrals, as in `Totals`, and how many."""

TERMS = 18
"""Of the series: each is a tenth of the one before where a step is as long as it may be."""

LONGEST = 1.0
"""Radians (or decays) a step may hold for these terms."""

SCENES = 16
"""Whose forms are kept: each block of a scene asks for them."""

X_R, FELT, BASE, SPEED, RATE, SLOPE = range(6)
"""What a step of sliding is made of: x_r, minus x_dd, ü, v_r and its rate, the slope of ü."""


class Trapezia(NamedTuple):
    """The forms at the ends of a step.

    Attributes
    ----------
    h : float
        Length of a step [s].
    x2, x_dd2 : tuple of float, shape (8,)
        Of x_r (minus x_dd) times v, a and s; of v times v, a and s; of a times a and s. Here v
        is v_r, a its rate and s the slope of ü.
    v2 : tuple of float, shape (5,)
        The last five of these.
    power : tuple of float, shape (5,)
        Of ü times v, a and s; of v times s; of a times s.
    rub : tuple of float, shape (2,)
        Of v and a, in the direction of sliding.
    """

    h: float
    x2: tuple[float, ...]
    v2: tuple[float, ...]
    x_dd2: tuple[float, ...]
    power: tuple[float, ...]
    rub: tuple[float, ...]


def served(plant, dt):
    """Tell whether the rule serves steps of length dt [s]."""
    return bool((plant.b / plant.m + math.sqrt(plant.k_x / plant.m)) * dt <= LONGEST)


@lru_cache(maxsize=SCENES)
def trapezia(c, w, h):
    """Give the forms of a step of length h [s] of a plant with b/m [1/s] and k_x/m [1/s²]."""
    rates = np.zeros((6, 6))
    rates[X_R, SPEED] = rates[BASE, SLOPE] = rates[SPEED, RATE] = 1.0
    rates[FELT, [SPEED, RATE]] = w, c
    rates[RATE, [SPEED, RATE, SLOPE]] = -w, -c, -1.0
    rest = ((SPEED, SPEED), (SPEED, RATE), (SPEED, SLOPE), (RATE, RATE), (RATE, SLOPE))

    def of(one, other, pairs):
        form = end_form(rates, h, one, other)
        return tuple(float(form[pair]) for pair in pairs)

    def beside(row):
        return (row, SPEED), (row, RATE), (row, SLOPE)

    return Trapezia(
        float(h),
        of(X_R, X_R, (*beside(X_R), *rest)),
        of(SPEED, SPEED, rest),
        of(FELT, FELT, (*beside(FELT), *rest)),
        of(BASE, SPEED, (*beside(BASE), (SPEED, SLOPE), (RATE, SLOPE))),
        line_form(rates, h),
    )


def end_form(rates, h, one, other):
    """Give the form at the end of a step for the product of two things, its pairs added up."""
    form, found = np.zeros((6, 6)), np.zeros((6, 6))
    form[one, other] = 1.0
    for k, weight in enumerate(series_weights(), 1):
        form = rates.T @ form + form @ rates
        found -= weight * h ** (2 * k) * form
        form = rates.T @ form + form @ rates
    both = found + found.T
    np.fill_diagonal(both, np.diag(found))
    return both


def line_form(rates, h):
    """Give what v_r and its rate have at the end of a step for the way."""
    line, found = np.zeros(6), np.zeros(6)
    line[SPEED] = 1.0
    for k, weight in enumerate(series_weights(), 1):
        line = rates.T @ line
        found -= weight * h ** (2 * k) * line
        line = rates.T @ line
    return float(found[SPEED]), float(found[RATE])


def series_weights():
    """Give B_2k/(2k)! for k = 1, 2 ..., B_2k being the numbers of Bernoulli."""
    terms = [1.0]  # of z/(e^z - 1), whose odd ones but the first vanish
    factorials = np.cumprod([1.0, *range(1, 2 * TERMS + 2)])
    for n in range(1, 2 * TERMS + 1):
        terms.append(-sum(terms[k] / factorials[n - k + 1] for k in range(n)))
    return terms[2::2]


@fused
def ends(rule, d, x_r, felt, u_dd, v_r, slope):
    """Give what the end of a step adds to its integrals, and what its beginning takes off.

    Parameters
    ----------
    rule : Trapezia
    d : float
        Direction of sliding, 0 where it sticks.
    x_r, felt, u_dd, v_r : float
        Displacement [m]; minus x_dd where it slides, and ü [m/s²]; velocity [m/s].
    slope : float
        Of ü within the step [m/s³].

    Returns
    -------
    tuple of float, shape (INTEGRALS,)
    """
    slides = d != 0.0
    base = -rule.h * rule.h / 6.0 * u_dd * slope
    a = -(felt + u_dd) if slides else 0.0
    s = slope if slides else 0.0
    vv, va, vs, aa, as_ = v_r * v_r, v_r * a, v_r * s, a * a, a * s
    p, q, r, t, o = rule.x2, rule.v2, rule.x_dd2, rule.power, rule.rub
    x2 = x_r * (p[0] * v_r + p[1] * a + p[2] * s)
    x2 += p[3] * vv + p[4] * va + p[5] * vs + p[6] * aa + p[7] * as_
    x_dd2 = felt * (r[0] * v_r + r[1] * a + r[2] * s)
    x_dd2 += r[3] * vv + r[4] * va + r[5] * vs + r[6] * aa + r[7] * as_
    return (
        x2,
        q[0] * vv + q[1] * va + q[2] * vs + q[3] * aa + q[4] * as_,
        x_dd2 if slides else base,
        u_dd * (t[0] * v_r + t[1] * a + t[2] * s) + (t[3] * vs + t[4] * as_),
        d * (o[0] * v_r + o[1] * a),
        0.0,
        base,
    )


@fused
def halves(rule, d, x_r, felt, u_dd, v_r):
    """Give what half of a sample counts in every integral; parameters as in `ends`."""
    half = 0.5 * rule.h
    x_dd = felt if d != 0.0 else u_dd
    return (
        half * (x_r * x_r), half * (v_r * v_r), half * (x_dd * x_dd), half * (u_dd * v_r),
        half * (d * v_r), 0.0 if d != 0.0 else half, half * (u_dd * u_dd),
    )  # fmt: skip


@fused
def summed(rule, pace, sums, d_bend, stuck_bend, stuck):
    """Give the integrals that sums over samples come to.

    Parameters
    ----------
    rule : Trapezia
    pace : Pace
    sums : tuple of float, shape (9,)
        Those of x_r², v_r², x_dd², ü v_r, |v_r| and ü²; of x_r, v_r and ü times what the
        change of ü changes by at the sample, the first and the last where it slides.
    d_bend, stuck_bend, stuck : float
        Those of the direction times that, and of ü times that where it sticks; how many
        samples there are where it sticks.

    Returns
    -------
    tuple of float, shape (INTEGRALS,)
    """
    h = rule.h
    xs, vs, us = -sums[6] / h, -sums[7] / h, -sums[8] / h
    felt_s = pace.w * xs + pace.c * vs - pace.f * d_bend / h
    as_ = -(felt_s + us)
    p, q, r, t = rule.x2, rule.v2, rule.x_dd2, rule.power
    return (
        h * sums[0] + (p[2] * xs + p[5] * vs + p[7] * as_),
        h * sums[1] + (q[2] * vs + q[4] * as_),
        h * sums[2] + (r[2] * felt_s + r[5] * vs + r[7] * as_) + h / 6.0 * stuck_bend,
        h * sums[3] + (t[2] * us + t[3] * vs + t[4] * as_),
        h * sums[4],
        h * stuck,
        h * sums[5] + h / 6.0 * (sums[8] + stuck_bend),
    )
