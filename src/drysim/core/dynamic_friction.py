"""Forces of Stribeck, Dahl, LuGre and Leuven friction, their series, and what Leuven remembers.

`force_term` gives the friction force of a law term by term: in that alone the series of one law
differs from another's. `drysim.core.taylor` makes the motion of it.

The bristles of Leuven remember where they turned, and the branch they are on. Everything is
told by the force alone, as the deflection z = F_h/σ_0 that it stands for, so the force goes on
without a jump whatever loop closes or is forgotten.
"""

from __future__ import annotations

import math

from drysim.core.compile import compiled, inlined
from drysim.core.events import sign
from drysim.core.model import LEUVEN, STRIBECK
from drysim.core.roots import NEVER, first_series_root

FLAT_EXPONENT = 37.0
"""Exponent from which on the Stribeck curve is flat to double precision."""

NEGLIGIBLE_SPEED_FACTOR = 100.0
"""Tolerances of a speed that it takes to tell a fractional power of it from its series: at a
few tolerances the terms of the series are beyond the numbers."""


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
    limit = stribeck_curve(law, v)
    if law.kind == STRIBECK:
        return d * limit
    share = law.sigma_0 * d * z / limit
    if law.kind == LEUVEN and law.power != 1:
        share = math.copysign(abs(share) ** law.power, share)
    z_d = v - v * share
    return law.sigma_0 * z + law.sigma_1 * z_d + law.sigma_2 * v


@compiled
def stribeck_curve(law, v):
    """Give the Stribeck curve at a speed [N]: F_fs at rest, F_fk far from it."""
    if law.F_fs == law.F_fk:
        return law.F_fk
    q = abs(v) / law.v_s
    share = q if law.exponent == 1 else (q * q if law.exponent == 2 else q**law.exponent)
    return law.F_fk + (law.F_fs - law.F_fk) * math.exp(-share)


@inlined
def flat_speed(law):
    """Give the speed [m/s] from which on the Stribeck curve is flat."""
    if law.exponent == 1:
        return FLAT_EXPONENT * law.v_s
    return (
        math.sqrt(FLAT_EXPONENT) if law.exponent == 2 else FLAT_EXPONENT ** (1.0 / law.exponent)
    ) * law.v_s


@inlined
def has_fractional_exponent(law):
    """Tell whether the Stribeck curve is a series in the speed away from rest alone."""
    return law.exponent != 1 and law.exponent != 2


@inlined
def negligible_speed(law, series):
    """Give the speed [m/s] at which a fractional power of it counts as none; 0 for the others.

    What this neglects is the share of a tolerance by which friction has fallen.
    """
    if not has_fractional_exponent(law):
        return 0.0
    return NEGLIGIBLE_SPEED_FACTOR * law.tolerance * max(series.scale[0], law.v_s)


# The force term by term.


@inlined
def force_term(law, series, d, n, falls, per_curve):
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
    known = excess_term(law, series, d, n) if falls and n > 0 else 0.0
    if law.kind == STRIBECK:
        series.F[n] = d * ((law.F_fk if n == 0 else 0.0) + series.g[n])
        return
    if law.kind == LEUVEN:
        series.p[n] = (d * law.sigma_0 * series.z[n] - known) * per_curve
        z_d = travel_term(law, series, d, n)
        # The deflection rises less and less with the travel.
        rise = series.slope[0] * series.w[n] + series.slope[1] * product_term(
            series.w, series.z, n
        )
        series.z[n + 1] = rise / (n + 1)
    else:
        product = product_term(series.v, series.z, n)
        series.p[n] = (d * product - known) * per_curve
        z_d = series.v[n] - law.sigma_0 * series.p[n]
        series.z[n + 1] = z_d / (n + 1)
    series.F[n] = law.sigma_0 * series.z[n] + law.sigma_1 * z_d + law.sigma_2 * series.v[n]


@inlined
def start_excess(law, series, d, v):
    """Set the beginning of the Stribeck curve's excess over F_fk [N], and of its exponent."""
    q = d * v / law.v_s
    series.s[0] = q if law.exponent == 1 else (q * q if law.exponent == 2 else q**law.exponent)
    series.g[0] = (law.F_fs - law.F_fk) * math.exp(-series.s[0])


@inlined
def excess_term(law, series, d, n):
    """Set term n, above 0, of the excess: its rate is -s' times it.

    `series.s` holds n times the terms of the exponent, but for the first. Gives the part of term n
    of the curve times p that is known before p's own. The sums go on side by side: each has to
    wait for its last term.
    """
    square, fall, known = 0.0, 0.0, 0.0
    if n % 2 == 0:
        k = n // 2
        square = series.v[k] * series.v[k]
        fall = series.s[k] * series.g[k]
        known = series.g[k] * series.p[k]
    for k in range((n - 1) // 2, 0, -1):
        m = n - k
        square += 2.0 * (series.v[k] * series.v[m])
        fall += series.s[k] * series.g[m] + series.s[m] * series.g[k]
        known += series.g[k] * series.p[m] + series.g[m] * series.p[k]
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
    return known + series.g[n] * series.p[0]


@inlined
def product_term(one, two, n):
    """Give term n of the product of two series, from both ends at once."""
    total = one[n // 2] * two[n // 2] if n % 2 == 0 else 0.0
    for k in range((n - 1) // 2, -1, -1):
        total += one[k] * two[n - k] + one[n - k] * two[k]
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
            # Whether the deflection is above zero, or goes there from zero.
            up = series.z[0] > 0.0 or (series.z[0] == 0.0 and series.slope[1] < 0.0)
            side = 1.0 if up == (d > 0) else -1.0
            series.w[n] = series.v[n] - side * product_term(series.v, series.square, n)
            return series.w[n]
        series.share[n] = product_term(series.p, series.square, n)
    series.w[n] = series.v[n] - product_term(series.v, series.share, n)
    return series.w[n]


@inlined
def power_term(law, series, n):
    """Set term n of sgn(p) |p|^power, from its rate; of a faint force all of them are 0."""
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
    """Tell whether the share that bristles take is a series away from zero force alone."""
    return law.power != 1 and law.power != 2 and law.power != 3


@inlined
def negligible_deflection(law):
    """Give the deflection [m] within which a general power of the force counts as none.

    What this neglects on the way from zero is a tolerance of the deflection at F_fk.
    """
    return law.tolerance ** (1.0 / (law.power + 1.0)) * law.F_fk / law.sigma_0


# What the bristles of Leuven remember, and what ends a branch.


COUNT, DIRECTION, AT_LIMIT = 0, 1, 2
"""Places in `Jet.branch`: how many turns are remembered, the direction of travel, and whether
the hysteresis force equals the sliding limit just now."""

LIMIT_REACHED, LOOP_CLOSED, SMOOTH_END = 1, 2, 3
"""What ends a branch: travel comes to rest at the sliding limit, a loop closes; or what ends
a series: the deflection comes near zero, where all powers but the odd are not smooth."""

LIMIT_ROUNDING = 1e-13
"""Share of F_fs by which force and sliding limit may differ in rounding alone: some hundred
roundings. Bristles that follow the limit that closely have no direction of their own."""


@compiled
def update_branch(law, series, d, v, z):
    """Let the bristles travel as they do for a mass in direction d at speed v [m/s].

    Bristles that are as near the sliding limit as rounding lets them be keep their branch.
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
    """Turn the bristles round at deflection z [m]."""
    count = series.branch[COUNT]
    direction = series.branch[DIRECTION]
    series.branch[DIRECTION] = -direction
    if count == 0 and z * direction <= 0.0:
        return
    if count == len(series.reversals):
        drop_smallest_loop(series)
        count = series.branch[COUNT]
    series.reversals[count] = z
    series.branch[COUNT] = count + 1


@compiled
def drop_smallest_loop(series):
    """Forget the two turns in a row whose neighbours are the most like them.

    The force does not notice; later on it errs as if these neighbours were one.
    """
    count = series.branch[COUNT]
    reversals = series.reversals
    least = NEVER
    at = 1
    for i in range(1, count - 2):
        change = abs(reversals[i - 1] - reversals[i + 1]) + abs(reversals[i] - reversals[i + 2])
        if change < least:
            least = change
            at = i
    for i in range(at, count - 2):
        reversals[i] = reversals[i + 2]
    series.branch[COUNT] = count - 2


@compiled
def set_masing_slope(law, series):
    """Set the rise of z per travel on the present branch: Masing's rule.

    The virgin curve is z = L (1 - exp(-travel/L)), L = F_h/σ_0; a branch from a turn is the
    same curve twice as large. Either way the rise falls linearly with z.
    """
    count = series.branch[COUNT]
    span = law.F_h / law.sigma_0 * (1.0 if count == 0 else 2.0)
    direction = series.branch[DIRECTION]
    origin = 0.0 if count == 0 else series.reversals[count - 1]
    series.slope[0] = 1.0 + direction * origin / span
    series.slope[1] = -direction / span


@compiled
def branch_exit(law, series, n, d, h):
    """Give when within h [s] the present branch ends, and what ends it; infinity and 0 if not.

    `series.share` is worked in.
    """
    first, cause = NEVER, 0
    if h <= 0.0:
        return first, cause
    work = series.share
    level = loop_closure(series)
    direction = series.branch[DIRECTION]
    if abs(level) != NEVER:
        for k in range(n + 1):
            work[k] = -direction * series.z[k]
        work[0] += direction * level
        first = first_series_root(work, n, h)
        if first != NEVER:
            cause = LOOP_CLOSED
    ahead = smooth_end(law, series)
    if ahead != NEVER and first > 0.0:
        for k in range(n + 1):
            work[k] = -direction * series.z[k]
        work[0] += ahead
        crossing = first_series_root(work, n, min(h, first))
        if crossing < first:
            first, cause = crossing, SMOOTH_END
    if first > 0.0 and set_limit_gap(law, series, work, n, d, h) > LIMIT_ROUNDING * law.F_fs:
        even = first_series_root(work, n - 1, min(h, first))
        # Bristles that the limit turned just now go its way: what turns them back at the same
        # instant is rounding, and on a loop of no width it would do so for ever.
        if even < first and (even > 0.0 or series.branch[AT_LIMIT] == 0):
            first, cause = even, LIMIT_REACHED
    return first, cause


@inlined
def loop_closure(series):
    """Give the deflection at which the present loop closes [m], else infinity."""
    count = series.branch[COUNT]
    if count == 0:
        return series.branch[DIRECTION] * NEVER
    return -series.reversals[0] if count == 1 else series.reversals[count - 2]


@inlined
def smooth_end(law, series):
    """Give how far along the branch, as z [m], the power of the force stops to be a series.

    That of 2 does so at zero; a general one where the force is faint, and where no longer.
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
def set_limit_gap(law, series, work, n, d, h):
    """Set the distance of the force from the sliding limit; gives its size at most [N].

    It is no more than that limit varies: bristles come to one that stays without ever turning.
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
    """Go over to the next branch; gives the deflection [m] there, freed of rounding."""
    if cause == LOOP_CLOSED:
        level = loop_closure(series)
        if law.sigma_0 * abs(level - z) > LIMIT_ROUNDING * law.F_fs:
            series.branch[AT_LIMIT] = 0
        z = level
        # The two turns of the loop are forgotten, the older branch goes on.
        series.branch[COUNT] -= min(series.branch[COUNT], 2)
    elif cause == SMOOTH_END:
        z = series.branch[DIRECTION] * smooth_end(law, series)
    else:
        push_reversal(series, z)
        series.branch[AT_LIMIT] = 1
    return z
