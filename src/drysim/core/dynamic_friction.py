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
from drysim.core.roots import NEVER, locate

FLAT = 37.0
"""Exponent from which on the Stribeck curve is flat to double precision."""

SLOWNESS = 100.0
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
    limit = sliding_limit(law, v)
    if law.kind == STRIBECK:
        return d * limit
    share = law.sigma_0 * d * z / limit
    if law.kind == LEUVEN and law.power != 1:
        share = math.copysign(abs(share) ** law.power, share)
    z_d = v - v * share
    return law.sigma_0 * z + law.sigma_1 * z_d + law.sigma_2 * v


@compiled
def sliding_limit(law, v):
    """Give the Stribeck curve at a speed [N]: F_fs at rest, F_fk far from it."""
    if law.F_fs == law.F_fk:
        return law.F_fk
    q = abs(v) / law.v_s
    share = q if law.exponent == 1 else (q * q if law.exponent == 2 else q**law.exponent)
    return law.F_fk + (law.F_fs - law.F_fk) * math.exp(-share)


@inlined
def flat_from(law):
    """Give the speed [m/s] from which on the Stribeck curve is flat."""
    if law.exponent == 1:
        return FLAT * law.v_s
    return (math.sqrt(FLAT) if law.exponent == 2 else FLAT ** (1.0 / law.exponent)) * law.v_s


@inlined
def fractional(law):
    """Tell whether the Stribeck curve is a series in the speed away from rest alone."""
    return law.exponent != 1 and law.exponent != 2


@inlined
def slow_speed(law, jet):
    """Give the speed [m/s] at which a fractional power of it counts as none; 0 for the others.

    What this neglects is the share of a tolerance by which friction has fallen.
    """
    if not fractional(law):
        return 0.0
    return SLOWNESS * law.tolerance * max(jet.scale[0], law.v_s)


# The force term by term.


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
        # The deflection rises less and less with the travel.
        rise = jet.slope[0] * jet.w[n] + jet.slope[1] * product_term(jet.w, jet.z, n)
        jet.z[n + 1] = rise / (n + 1)
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
    else:
        jet.square[n] = product_term(jet.p, jet.p, n)
        if law.power == 2:
            # Whether the deflection is above zero, or goes there from zero.
            up = jet.z[0] > 0.0 or (jet.z[0] == 0.0 and jet.slope[1] < 0.0)
            side = 1.0 if up == (d > 0) else -1.0
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
def general_power(law):
    """Tell whether the share that bristles take is a series away from zero force alone."""
    return law.power != 1 and law.power != 2 and law.power != 3


@inlined
def faint_deflection(law):
    """Give the deflection [m] within which a general power of the force counts as none.

    What this neglects on the way from zero is a tolerance of the deflection at F_fk.
    """
    return law.tolerance ** (1.0 / (law.power + 1.0)) * law.F_fk / law.sigma_0


# What the bristles of Leuven remember, and what ends a branch.


COUNT, WAY, EVEN = 0, 1, 2
"""Places in `Jet.branch`: how many turns are remembered, the direction of travel, and whether
the hysteresis force equals the sliding limit just now."""

LIMIT, LOOP, EDGE = 1, 2, 3
"""What ends a branch: travel comes to rest at the sliding limit, a loop closes; or what ends
a series: the deflection comes near zero, where all powers but the odd are not smooth."""

NOISE = 1e-13
"""Share of F_fs by which force and sliding limit may differ in rounding alone: some hundred
roundings. Bristles that follow the limit that closely have no direction of their own."""


@compiled
def head(law, jet, d, v, z):
    """Let the bristles travel as they do for a mass in direction d at speed v [m/s].

    Bristles that are as near the sliding limit as rounding lets them be keep their branch.
    """
    gap = sliding_limit(law, v) - d * law.sigma_0 * z
    way = d * sign(gap)
    if jet.branch[WAY] == 0:
        jet.branch[WAY] = way
    elif way != jet.branch[WAY] and abs(gap) > NOISE * law.F_fs:
        turn(jet, z)
    jet.branch[EVEN] = 0


@compiled
def turn(jet, z):
    """Turn the bristles round at deflection z [m]."""
    count = jet.branch[COUNT]
    way = jet.branch[WAY]
    jet.branch[WAY] = -way
    if count == 0 and z * way <= 0.0:
        return
    if count == len(jet.turned):
        forget(jet)
        count = jet.branch[COUNT]
    jet.turned[count] = z
    jet.branch[COUNT] = count + 1


@compiled
def forget(jet):
    """Forget the two turns in a row whose neighbours are the most like them.

    The force does not notice; later on it errs as if these neighbours were one.
    """
    count = jet.branch[COUNT]
    turned = jet.turned
    least = NEVER
    at = 1
    for i in range(1, count - 2):
        change = abs(turned[i - 1] - turned[i + 1]) + abs(turned[i] - turned[i + 2])
        if change < least:
            least = change
            at = i
    for i in range(at, count - 2):
        turned[i] = turned[i + 2]
    jet.branch[COUNT] = count - 2


@compiled
def set_slope(law, jet):
    """Set the rise of z per travel on the present branch: Masing's rule.

    The virgin curve is z = L (1 - exp(-travel/L)), L = F_h/σ_0; a branch from a turn is the
    same curve twice as large. Either way the rise falls linearly with z.
    """
    count = jet.branch[COUNT]
    span = law.F_h / law.sigma_0 * (1.0 if count == 0 else 2.0)
    way = jet.branch[WAY]
    origin = 0.0 if count == 0 else jet.turned[count - 1]
    jet.slope[0] = 1.0 + way * origin / span
    jet.slope[1] = -way / span


@compiled
def branch_end(law, jet, n, d, h):
    """Give when within h [s] the present branch ends, and what ends it; infinity and 0 if not.

    `jet.share` is worked in.
    """
    first, what = NEVER, 0
    if h <= 0.0:
        return first, what
    work = jet.share
    level = loop_end(jet)
    way = jet.branch[WAY]
    if abs(level) != NEVER:
        for k in range(n + 1):
            work[k] = -way * jet.z[k]
        work[0] += way * level
        first = locate(work, n, h)
        if first != NEVER:
            what = LOOP
    ahead = edge(law, jet)
    if ahead != NEVER and first > 0.0:
        for k in range(n + 1):
            work[k] = -way * jet.z[k]
        work[0] += ahead
        crossing = locate(work, n, min(h, first))
        if crossing < first:
            first, what = crossing, EDGE
    if first > 0.0 and to_limit(law, jet, work, n, d, h) > NOISE * law.F_fs:
        even = locate(work, n - 1, min(h, first))
        # Bristles that the limit turned just now go its way: what turns them back at the same
        # instant is rounding, and on a loop of no width it would do so for ever.
        if even < first and (even > 0.0 or jet.branch[EVEN] == 0):
            first, what = even, LIMIT
    return first, what


@inlined
def loop_end(jet):
    """Give the deflection at which the present loop closes [m], else infinity."""
    count = jet.branch[COUNT]
    if count == 0:
        return jet.branch[WAY] * NEVER
    return -jet.turned[0] if count == 1 else jet.turned[count - 2]


@inlined
def edge(law, jet):
    """Give how far along the branch, as z [m], the power of the force stops to be a series.

    That of 2 does so at zero; a general one where the force is faint, and where no longer.
    """
    z = jet.branch[WAY] * jet.z[0]
    if law.power == 2:
        return 0.0 if z < 0.0 else NEVER
    if not general_power(law):
        return NEVER
    faint = faint_deflection(law)
    if z < -faint:
        return -faint
    return 2.0 * faint if z <= faint else NEVER


@inlined
def to_limit(law, jet, work, n, d, h):
    """Set the distance of the force from the sliding limit; gives its size at most [N].

    It is no more than that limit varies: bristles come to one that stays without ever turning.
    """
    side = d * jet.branch[WAY]
    size, varies = 0.0, 0.0
    power = 1.0
    for k in range(n):
        gap = jet.g[k] - d * law.sigma_0 * jet.z[k]
        if k == 0:
            gap = 0.0 if jet.branch[EVEN] != 0 else gap + law.F_fk
        else:
            varies += abs(jet.g[k]) * power
        work[k] = side * gap
        size += abs(gap) * power
        power *= h
    return min(size, varies)


@compiled
def end_branch(law, jet, what, z):
    """Go over to the next branch; gives the deflection [m] there, freed of rounding."""
    if what == LOOP:
        level = loop_end(jet)
        if law.sigma_0 * abs(level - z) > NOISE * law.F_fs:
            jet.branch[EVEN] = 0
        z = level
        # The two turns of the loop are forgotten, the older branch goes on.
        jet.branch[COUNT] -= min(jet.branch[COUNT], 2)
    elif what == EDGE:
        z = jet.branch[WAY] * edge(law, jet)
    else:
        turn(jet, z)
        jet.branch[EVEN] = 1
    return z
