"""Sliding on stiff bristles that have settled: their deflection follows the speed.

At stiffness σ_0 bristles settle within the distance F/σ_0. A series that resolves this takes
steps of some ten such distances, however smooth the motion. Once they have settled, z is the
solution of z = d g(v) (1 - w/v)/σ_0 with w its own rate: each round through this equation is
nearer by the ratio of the two times, and the series is as long as the slow motion allows.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.dynamic_laws.dynamic import sliding_limit
from drysim.core.dynamic_laws.jet import ORDER, reach, start_curve
from drysim.core.dynamic_laws.terms import excess_term, product_term
from drysim.core.plant import LEUVEN
from drysim.core.samples.stop import NEVER

SETTLED = 2
"""What a direction in a trail has besides the rounds of a series on settled bristles."""

STIFF = 40.0
"""Times of settling in a step from which on the settled series pays: four steps that resolve
them cost as much as its rounds."""

MOST_ROUNDS = 12
"""Rounds after which bristles count as not settled: each takes a power of a small ratio."""

NEAR = 0.1
"""Relative distance from the sliding limit beyond which bristles surely have not settled."""


@inlined
def settling_rate(law, v, z):
    """Give the rate at which bristles settle [1/s]; 0 where they are far from it."""
    limit = sliding_limit(law, v)
    pull = law.sigma_0 * abs(z)
    return law.sigma_0 * abs(v) / limit if abs(pull - limit) < NEAR * limit else 0.0


@compiled
def calm_plant(plant):
    """Give the shortest time of the oscillator itself [s]."""
    rate = max(math.sqrt(plant.k_x / plant.m), plant.b / plant.m)
    return 1.0 / rate if rate > 0.0 else NEVER


@compiled
def settle(plant, law, jet, d, x, v, z, h, v_least, z_least):
    """Set the series of the motion on settled bristles.

    Parameters
    ----------
    as in `grow`

    Returns
    -------
    n, h, rounds : int, float, int
        The last term, the length for which the series holds [s], and the rounds that it took;
        0 where the bristles at z have not settled.
    """
    rate = law.sigma_0 * abs(v) / sliding_limit(law, v)
    for n in range(ORDER + 2):
        jet.w[n] = 0.0
    change = 0.0
    for rounds in range(1, MOST_ROUNDS + 1):
        last = settled_round(plant, law, jet, d, x, v, h, v_least, z_least)
        if last == ORDER:
            h = min(h, reach(law, jet, v_least, z_least))
        before = change
        change = update_rate(plant, law, jet, last, rate, h, v_least, z_least)
        if rate * h < STIFF or (rounds > 2 and not change < 0.5 * before):
            return 0, h, 0
        if change <= 1.0:
            settled = abs(jet.z[0] - z) <= z_least
            return last, h, (rounds if settled else 0)
    return 0, h, 0


@compiled
def settled_round(plant, law, jet, d, x, v, h, v_least, z_least):
    """Go once through the equation of settled bristles; gives the last term that counts."""
    m, k_x, b = plant
    jet.x[0] = x
    jet.v[0] = v
    falls = start_curve(law, jet, d, v, False)
    power = 1.0
    small = 0
    for n in range(ORDER + 1):
        deflection = settled_term(law, jet, d, n, falls)
        jet.z[n] = deflection
        tiny = abs(deflection) * power <= z_least
        jet.F[n] = law.sigma_0 * deflection + law.sigma_1 * jet.w[n] + law.sigma_2 * jet.v[n]
        jet.x[n + 1] = jet.v[n] / (n + 1)
        pull = (k_x * jet.x[n] + b * jet.v[n] + jet.F[n]) / m
        jet.v[n + 1] = -(jet.u[n] + pull) / (n + 1)
        power *= h
        small = small + 1 if tiny and abs(jet.v[n + 1]) * power <= v_least else 0
        if small == 3:
            jet.z[n + 1] = 0.0
            return min(n + 1, ORDER)
    return ORDER


@inlined
def settled_term(law, jet, d, n, falls):
    """Give term n of z = d g(v) (1 - w/v)^(1/power)/σ_0 [m]."""
    if falls and n > 0:
        excess_term(law, jet, d, n)
    lag = jet.w[n]
    for k in range(1, n + 1):
        lag -= jet.v[k] * jet.p[n - k]
    jet.p[n] = lag / jet.v[0]
    jet.share[n] = root_term(law, jet, n)
    limit = law.F_fk * jet.share[n]
    if falls:
        limit += product_term(jet.g, jet.share, n)
    return d * limit / law.sigma_0


@inlined
def root_term(law, jet, n):
    """Give term n of (1 - p)^(1/power)."""
    rest = 1.0 - jet.p[0]
    if n == 0:
        return rest if law.power == 1 else rest ** (1.0 / law.power)
    if law.power == 1:
        return -jet.p[n]
    total = 0.0
    for k in range(1, n + 1):
        total -= (k / law.power - (n - k)) * jet.p[k] * jet.share[n - k]
    return total / (n * rest)


@compiled
def update_rate(plant, law, jet, last, rate, h, v_least, z_least):
    """Set w from the series of z; gives how far that moves z or v, over what may be."""
    change = 0.0
    power = 1.0
    for n in range(ORDER + 1):
        fresh = (n + 1) * jet.z[n + 1] if n < last else 0.0
        if law.kind == LEUVEN:
            for k in range(n):
                fresh -= jet.slope[1] * jet.w[k] * jet.z[n - k]
            fresh /= jet.slope[0] + jet.slope[1] * jet.z[0]
        off = abs(fresh - jet.w[n]) * power
        jet.w[n] = fresh
        push = law.sigma_1 * off * h / (plant.m * v_least)
        change = max(change, off / (rate * z_least), push)
        power *= h
    return change


@compiled
def settle_again(plant, law, jet, d, x, v, rounds):
    """Set the whole series of settled bristles after so many rounds."""
    for n in range(ORDER + 2):
        jet.w[n] = 0.0
    for _ in range(rounds):
        settled_round(plant, law, jet, d, x, v, 1.0, 0.0, 0.0)
        update_rate(plant, law, jet, ORDER, 1.0, 1.0, 1.0, 1.0)
