"""What the bristles of Leuven remember: where they turned, and the branch they are on.

Everything is told by the force alone, as the deflection z = F_h/σ_0 that it stands for, so the
force goes on without a jump whatever loop closes or is forgotten.
"""

from __future__ import annotations

from drysim.core.compiled import compiled, inlined
from drysim.core.dynamic_laws.dynamic import faint_deflection, general_power, sliding_limit
from drysim.core.dynamic_laws.locate import locate
from drysim.core.events import sign
from drysim.core.samples.stop import NEVER

COUNT, WAY, EVEN = 0, 1, 2
"""Places in `Jet.branch`: how many turns are remembered, the direction of travel, and whether
the hysteresis force equals the sliding limit just now."""

LIMIT, LOOP, EDGE = 1, 2, 3
"""What ends a branch: travel comes to rest at the sliding limit, a loop closes; or what ends
a series: the deflection comes near zero, where all powers but the odd are not smooth."""

NOISE = 1e-13
"""Share of F_fs by which force and sliding limit may differ in rounding alone: some hundred
roundings. Bristles that follow the limit that closely have no direction of their own."""


@inlined
def origin(jet):
    """Give the deflection at which the present branch began [m]."""
    count = jet.branch[COUNT]
    return 0.0 if count == 0 else jet.turned[count - 1]


@compiled
def set_slope(law, jet):
    """Set the rise of z per travel on the present branch: Masing's rule.

    The virgin curve is z = L (1 - exp(-travel/L)), L = F_h/σ_0; a branch from a turn is the
    same curve twice as large. Either way the rise falls linearly with z.
    """
    count = jet.branch[COUNT]
    span = law.F_h / law.sigma_0 * (1.0 if count == 0 else 2.0)
    way = jet.branch[WAY]
    jet.slope[0] = 1.0 + way * origin(jet) / span
    jet.slope[1] = -way / span


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


@inlined
def loop_end(jet):
    """Give the deflection at which the present loop closes [m], else infinity."""
    count = jet.branch[COUNT]
    if count == 0:
        return jet.branch[WAY] * NEVER
    return -jet.turned[0] if count == 1 else jet.turned[count - 2]


@compiled
def close_loop(jet):
    """Close the present loop: its two turns are forgotten, the older branch goes on."""
    jet.branch[COUNT] -= min(jet.branch[COUNT], 2)


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
        close_loop(jet)
    elif what == EDGE:
        z = jet.branch[WAY] * edge(law, jet)
    else:
        turn(jet, z)
        jet.branch[EVEN] = 1
    return z
