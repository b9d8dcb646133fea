"""Forces of Stribeck, Dahl, LuGre and Leuven friction as Taylor series; Leuven's hysteresis.

Problem
    The four laws differ in the friction force only; `core.taylor` supplies the motion. With
    g(v) the Stribeck curve, d the direction of motion and z the deflection:

    - Stribeck: F = d g(v);
    - Dahl, LuGre: z' = v - σ_0 |v| z/g(v), F = σ_0 z + σ_1 z' + σ_2 v;
    - Leuven: F = σ_0 z + σ_1 w + σ_2 v with σ_0 z the hysteresis force F_h, the rate of travel
      w = v (1 - sgn(p) |p|^power) and p = F_h d/g(v).

Method
    `force_term` computes the force term by term, each from the terms before it by Cauchy
    products. Powers of a series follow from their differential equation.

    The hysteresis force of Leuven follows Masing's rule with non-local memory: the virgin curve
    is exponential, a branch after a reversal is the same curve scaled by two, and a closed loop
    is removed from the stack of reversals together with its two reversal points. All of this is
    stated in terms of z = F_h/σ_0 alone, so the force stays continuous when a loop closes or is
    dropped.

Why nothing is missed
    The end of a branch is the first root of a polynomial (`branch_exit`), found by safe steps.

Reference: V. Lampaert, J. Swevers and F. Al-Bender, IEEE Trans. Autom. Control 47 (2002) 683;
C. Canudas de Wit et al., ibid. 40 (1995) 419.
"""

from __future__ import annotations

import math

from drysim.core.compile import compiled, inlined
from drysim.core.events import sign
from drysim.core.model import LEUVEN, STRIBECK
from drysim.core.roots import NEVER, first_series_root

FLAT_EXPONENT = 37.0
"""Exponent above which the Stribeck curve is flat to double precision: exp(-37) is 9e-17."""

NEGLIGIBLE_SPEED_FACTOR = 100.0
"""Speed, in tolerances, from which on a fractional power of it is expanded in a series; at a
few tolerances the coefficients overflow."""


@compiled
def dynamic_force(law, d, v, z):
    """Return the friction force of a moving mass [N].

    Parameters
    ----------
    law : DynamicLaw
    d : int
        Direction of motion, -1 or +1.
    v, z : float
        Relative velocity [m/s] and deflection of the bristles [m].
    """
    limit = stribeck_curve(law, v)
    if law.kind == STRIBECK:
        return d * limit
    share = law.sigma_0 * d * z / limit
    if law.kind == LEUVEN and law.power != 1:
        share = math.copysign(abs(share) ** law.power, share)
    z_d = v - v * share
    return law.sigma_0 * z + law.sigma_1 * z_d + law.sigma_2 * v


@compiled
def dissipated_power(law, v, z, slope):
    """Return the power that friction dissipates [W], whatever the direction of its motion.

    Parameters
    ----------
    law, v, z
        As in `dynamic_force`.
    slope : float
        Slope of z per travel on the branch of the hysteresis [-]; `LEUVEN` only.

    Notes
    -----
    Bristles store σ_0 z²/2. The hysteresis of Leuven stores the energy of the springs in Iwan's
    model, sliders in series with springs side by side, which is the only reading of Masing's
    rule that never returns more than it took. Where the slope has fallen from 1 to s, the
    sliders that yield dissipate F_h (1 - s + s ln s) per travel. The term of σ_1 may be below
    zero: LuGre and Leuven with a small σ_2 are not passive while bristles are deflected beyond
    the limit, as after a steep rise of the speed.
    """
    limit = stribeck_curve(law, v)
    if law.kind == STRIBECK:
        return limit * abs(v)
    share = law.sigma_0 * z / limit if v > 0.0 else -law.sigma_0 * z / limit
    if law.kind == LEUVEN and law.power != 1:
        share = math.copysign(abs(share) ** law.power, share)
    travel = v - v * share
    power = law.sigma_0 * z * (v * share) + (law.sigma_1 * travel + law.sigma_2 * v) * v
    if law.kind == LEUVEN and 0.0 < slope < 1.0:
        power += law.F_h * (1.0 - slope + slope * math.log(slope)) * abs(travel)
    return power


@compiled
def stribeck_curve(law, v):
    """Return the Stribeck curve at a speed [N]: F_fs at rest, F_fk at high speed."""
    if law.F_fs == law.F_fk:
        return law.F_fk
    return law.F_fk + (law.F_fs - law.F_fk) * math.exp(-stribeck_exponent(law, abs(v)))


@inlined
def stribeck_exponent(law, speed):
    """Return the exponent (speed/v_s)^exponent of the Stribeck curve [-]."""
    q = speed / law.v_s
    return q if law.exponent == 1 else (q * q if law.exponent == 2 else q**law.exponent)


@inlined
def flat_speed(law):
    """Return the speed [m/s] above which the Stribeck curve is flat."""
    if law.exponent == 1:
        return FLAT_EXPONENT * law.v_s
    return (
        math.sqrt(FLAT_EXPONENT) if law.exponent == 2 else FLAT_EXPONENT ** (1.0 / law.exponent)
    ) * law.v_s


@inlined
def has_fractional_exponent(law):
    """Return whether the Stribeck curve is analytic in the speed only away from rest."""
    return law.exponent != 1 and law.exponent != 2


@inlined
def negligible_speed(law, series):
    """Return the speed [m/s] below which a fractional power of it is neglected; 0 if analytic.

    The error is the share of a tolerance by which friction has fallen there.
    """
    if not has_fractional_exponent(law):
        return 0.0
    return NEGLIGIBLE_SPEED_FACTOR * law.tolerance * max(series.scale[0], law.v_s)


# The series of the force.


@inlined
def force_term(law, series, d, n, falls, per_curve):
    """Set term n of the friction force [N] and, for bristles, term n + 1 of z.

    Parameters
    ----------
    law, series, d
        As in `extend_series`.
    n : int
        Index of the term; all terms before it are set.
    falls : bool
        Whether the Stribeck curve depends on speed here.
    per_curve : float
        Reciprocal of the Stribeck curve at the start [1/N].
    """
    remainder = excess_term(law, series, d, n) if falls and n > 0 else 0.0
    if law.kind == STRIBECK:
        series.F[n] = d * ((law.F_fk if n == 0 else 0.0) + series.g[n])
        return
    if law.kind == LEUVEN:
        series.p[n] = (d * law.sigma_0 * series.z[n] - remainder) * per_curve
        z_d = travel_term(law, series, d, n)
        # z' = (slope[0] + slope[1] z) w.
        rise = series.slope[0] * series.w[n] + series.slope[1] * product_term(
            series.w, series.z, n
        )
        series.z[n + 1] = rise / (n + 1)
    else:
        product = product_term(series.v, series.z, n)
        series.p[n] = (d * product - remainder) * per_curve
        z_d = series.v[n] - law.sigma_0 * series.p[n]
        series.z[n + 1] = z_d / (n + 1)
    series.F[n] = law.sigma_0 * series.z[n] + law.sigma_1 * z_d + law.sigma_2 * series.v[n]


@inlined
def excess_term(law, series, d, n):
    """Set term n > 0 of the excess g - F_fk of the Stribeck curve, from its derivative.

    The excess e = (F_fs - F_fk) exp(-s) obeys e' = -s' e.

    `series.s` holds n times the coefficients of the exponent s for n > 0. Returns the part of
    term n of e·p that does not contain p[n]. The three sums share one loop because each waits
    for its own last addition.
    """
    square, fall, product = 0.0, 0.0, 0.0
    if n % 2 == 0:
        k = n // 2
        square = series.v[k] * series.v[k]
        fall = series.s[k] * series.g[k]
        product = series.g[k] * series.p[k]
    for k in range((n - 1) // 2, 0, -1):
        m = n - k
        square += 2.0 * (series.v[k] * series.v[m])
        fall += series.s[k] * series.g[m] + series.s[m] * series.g[k]
        product += series.g[k] * series.p[m] + series.g[m] * series.p[k]
    if law.exponent == 1:
        series.s[n] = n * d * series.v[n] / law.v_s
    elif law.exponent == 2:
        series.s[n] = n * (square + 2.0 * series.v[0] * series.v[n]) / (law.v_s * law.v_s)
    else:
        total = law.exponent * n * series.v[n] * series.s[0]
        for k in range(1, n):
            total += (law.exponent * k / (n - k) - 1.0) * series.v[k] * series.s[n - k]
        series.s[n] = total / series.v[0]
    series.g[n] = -(fall + series.s[n] * series.g[0]) / n
    return product + series.g[n] * series.p[0]


@inlined
def product_term(left, right, n):
    """Return term n of the Cauchy product of two series."""
    total = left[n // 2] * right[n // 2] if n % 2 == 0 else 0.0
    for k in range((n - 1) // 2, -1, -1):
        total += left[k] * right[n - k] + left[n - k] * right[k]
    return total


@inlined
def travel_term(law, series, d, n):
    """Set term n of w = v (1 - sgn(p) |p|^power) [m/s], with p the force over its limit."""
    if law.power == 1:
        series.w[n] = series.v[n] - product_term(series.v, series.p, n)
        return series.w[n]
    if has_general_power(law):
        power_term(law, series, n)
    else:
        series.square[n] = product_term(series.p, series.p, n)
        if law.power == 2:
            # The sign of p along the motion, also when it starts at zero.
            up = series.z[0] > 0.0 or (series.z[0] == 0.0 and series.slope[1] < 0.0)
            side = 1.0 if up == (d > 0) else -1.0
            series.w[n] = series.v[n] - side * product_term(series.v, series.square, n)
            return series.w[n]
        series.share[n] = product_term(series.p, series.square, n)
    series.w[n] = series.v[n] - product_term(series.v, series.share, n)
    return series.w[n]


@inlined
def power_term(law, series, n):
    """Set term n of q = sgn(p) |p|^power from p q' = power p' q; 0 for a negligible force."""
    if n == 0:
        faint = abs(series.z[0]) <= negligible_deflection(law)
        series.share[0] = (
            0.0 if faint else math.copysign(abs(series.p[0]) ** law.power, series.p[0])
        )
        return
    total = 0.0
    if series.share[0] != 0.0:
        for k in range(1, n + 1):
            total += (law.power * k - (n - k)) * series.p[k] * series.share[n - k]
        total /= n * series.p[0]
    series.share[n] = total


@inlined
def has_general_power(law):
    """Return whether sgn(p) |p|^power has a series away from zero force only."""
    return law.power != 1 and law.power != 2 and law.power != 3


@inlined
def negligible_deflection(law):
    """Return the deflection [m] below which a general power of the force is neglected.

    The error while passing zero is one tolerance of the deflection at F_fk.
    """
    return law.tolerance ** (1.0 / (law.power + 1.0)) * law.F_fk / law.sigma_0


# Hysteresis of Leuven: stack of reversals and ends of branches.


COUNT, DIRECTION, AT_LIMIT = 0, 1, 2
"""Indices in `TaylorSeries.branch`: number of reversals, direction of travel, and whether
the hysteresis force equals the sliding limit at this instant."""

LIMIT_REACHED, LOOP_CLOSED, SMOOTH_END = 1, 2, 3
"""What ends a branch: travel stops at the sliding limit, or a loop closes; or what ends a
series: the deflection comes near zero, where powers of |p| other than odd ones are not
smooth."""

LIMIT_ROUNDING = 1e-13
"""Share of F_fs by which force and sliding limit may differ by rounding alone: some hundred
roundings. Bristles this close to the limit keep the direction of their branch."""


@compiled
def update_branch(law, series, d, v, z):
    """Set the direction of travel for a mass moving in direction d at speed v [m/s].

    A change of direction is a reversal. Within rounding of the sliding limit the branch is
    kept.
    """
    gap = stribeck_curve(law, v) - d * law.sigma_0 * z
    direction = d * sign(gap)
    if series.branch[DIRECTION] == 0:
        series.branch[DIRECTION] = direction
    elif direction != series.branch[DIRECTION] and abs(gap) > LIMIT_ROUNDING * law.F_fs:
        push_reversal(series, z)
    series.branch[AT_LIMIT] = 0


@compiled
def push_reversal(series, z):
    """Reverse the travel at deflection z [m] and push the reversal onto the stack."""
    count = series.branch[COUNT]
    direction = series.branch[DIRECTION]
    series.branch[DIRECTION] = -direction
    # Without deflection in this direction there is no loop yet: stay on the virgin curve.
    if count == 0 and z * direction <= 0.0:
        return
    if count == len(series.reversals):
        drop_smallest_loop(series)
        count = series.branch[COUNT]
    series.reversals[count] = z
    series.branch[COUNT] = count + 1


@compiled
def drop_smallest_loop(series):
    """Remove the two successive reversals i, i + 1 of least effect from the stack.

    That is where z[i - 1] and z[i + 1], and z[i] and z[i + 2], differ least. The present force
    is unchanged; its later error is of the size of these differences.
    """
    count = series.branch[COUNT]
    reversals = series.reversals
    least = NEVER
    smallest = 1
    for i in range(1, count - 2):
        change = abs(reversals[i - 1] - reversals[i + 1]) + abs(reversals[i] - reversals[i + 2])
        if change < least:
            least = change
            smallest = i
    for i in range(smallest, count - 2):
        reversals[i] = reversals[i + 2]
    series.branch[COUNT] = count - 2


@compiled
def set_masing_slope(law, series):
    """Set the slope of z per travel on the present branch by Masing's rule.

    The virgin curve is z = L (1 - exp(-travel/L)) with L = F_h/σ_0; a branch after a reversal
    is the same curve scaled by two. In both cases the slope is linear in z.
    """
    count = series.branch[COUNT]
    span = law.F_h / law.sigma_0 * (1.0 if count == 0 else 2.0)
    direction = series.branch[DIRECTION]
    origin = 0.0 if count == 0 else series.reversals[count - 1]
    series.slope[0] = 1.0 + direction * origin / span
    series.slope[1] = -direction / span


@compiled
def branch_exit(law, series, n, d, h):
    """Return when within h [s] the present branch ends, or infinity, and the cause.

    `series.share` is used as work space.
    """
    first, cause = NEVER, 0
    if h <= 0.0:
        return first, cause
    work = series.share
    closure = series.branch[DIRECTION] * loop_closure(series)
    if closure != NEVER:
        first = first_series_root(set_deflection_gap(series, work, n, closure), n, h)
        if first != NEVER:
            cause = LOOP_CLOSED
    ahead = smooth_end(law, series)
    if ahead != NEVER and first > 0.0:
        gap = set_deflection_gap(series, work, n, ahead)
        crossing = first_series_root(gap, n, min(h, first))
        if crossing < first:
            first, cause = crossing, SMOOTH_END
    if first > 0.0 and set_limit_gap(law, series, work, n, d, h) > LIMIT_ROUNDING * law.F_fs:
        even = first_series_root(work, n - 1, min(h, first))
        # Right after a reversal at the limit the gap is zero. A root at the same instant is
        # rounding, and on a loop of zero width it would recur without end.
        if even < first and (even > 0.0 or series.branch[AT_LIMIT] == 0):
            first, cause = even, LIMIT_REACHED
    return first, cause


@inlined
def loop_closure(series):
    """Return the deflection at which the present loop closes [m], or infinity."""
    count = series.branch[COUNT]
    if count == 0:
        return series.branch[DIRECTION] * NEVER
    return -series.reversals[0] if count == 1 else series.reversals[count - 2]


@inlined
def smooth_end(law, series):
    """Return the deflection along the branch at which the series stops being valid [m].

    The power of the force is not analytic there. For power 2 this is zero; for a general power,
    both ends of the range of negligible deflection.
    """
    z = series.branch[DIRECTION] * series.z[0]
    if law.power == 2:
        return 0.0 if z < 0.0 else NEVER
    if not has_general_power(law):
        return NEVER
    faint = negligible_deflection(law)
    if z < -faint:
        return -faint
    return 2.0 * faint if z <= faint else NEVER


@inlined
def set_deflection_gap(series, work, n, ahead):
    """Set and return the series of what is left to a deflection along the branch [m]."""
    for k in range(n + 1):
        work[k] = -series.branch[DIRECTION] * series.z[k]
    work[0] += ahead
    return work


@inlined
def set_limit_gap(law, series, work, n, d, h):
    """Set the series of limit minus force in the work array; return a bound on its size [N].

    The bound is at most the variation of the limit: under a constant limit the bristles
    approach it without a reversal.
    """
    side = d * series.branch[DIRECTION]
    size, varies = 0.0, 0.0
    power = 1.0
    for k in range(n):
        gap = series.g[k] - d * law.sigma_0 * series.z[k]
        if k == 0:
            gap = 0.0 if series.branch[AT_LIMIT] != 0 else gap + law.F_fk
        else:
            varies += abs(series.g[k]) * power
        work[k] = side * gap
        size += abs(gap) * power
        power *= h
    return min(size, varies)


@compiled
def next_branch(law, series, cause, z):
    """Continue on the next branch; return the deflection there [m] without rounding error."""
    if cause == LOOP_CLOSED:
        level = loop_closure(series)
        if law.sigma_0 * abs(level - z) > LIMIT_ROUNDING * law.F_fs:
            series.branch[AT_LIMIT] = 0
        z = level
        # Both reversals of the closed loop are removed; the older branch continues.
        series.branch[COUNT] -= min(series.branch[COUNT], 2)
    elif cause == SMOOTH_END:
        z = series.branch[DIRECTION] * smooth_end(law, series)
    else:
        push_reversal(series, z)
        series.branch[AT_LIMIT] = 1
    return z
