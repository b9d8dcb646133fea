"""A few steps of every lane at once, as if nothing happened; they stand where nothing does."""

from __future__ import annotations

from typing import NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.events import ROUNDING
from drysim.core.many.lanes import (
    AHEAD,
    LANES,
    PLACE,
    RISE,
    STRIDE,
    SUMS,
    WAITS,
    D,
    U,
    V,
    X,
)
from drysim.core.samples.steps import MARGIN

TAME = 0.05
"""Share that must be left of 1 for the bound on a dip to mean anything."""

EVER = 1e300
"""In place of that bound: then every step is looked at closely. Times nothing it is nothing."""


class Pace(NamedTuple):
    """What a step takes, should nothing happen in it.

    x_r becomes x_r + y v_r - Y push - YY change, and v_r becomes y_d v_r - y push - Y change,
    with push the force per mass of base, spring and friction at the start and change that of ü.
    """

    m: float
    k_x: float
    F_fs: float
    c: float
    w: float
    f: float
    y: float
    y_d: float
    Y: float
    Y_by_h: float
    YY_by_h: float
    steep: float
    fast: float


@compiled
def pace_of(plant, law, steps):
    """Give what a step takes.

    Notes
    -----
    In a step |v_r"| <= M = |change|/dt + c (v/dt + M dt) + w (v + M dt²/2), with v the greater
    |v_r| of both ends; and a function that bends so little falls at most M dt²/8 below its
    lower end: steep |change| + fast v, which is widened so that rounding cannot matter.
    """
    c, w, dt = steps.c, steps.w, steps.dt
    tame = 1.0 - (c + 0.5 * w * dt) * dt
    steep = MARGIN * 0.125 * dt / tame if tame > TAME else EVER
    return Pace(
        plant.m, plant.k_x, law.F_fs, c, w, steps.f, steps.one.x_v, steps.one.v_v,
        steps.x_0 + steps.x_1, steps.v_1, steps.x_1, steep, steep * (c + w * dt),
    )  # fmt: skip


@inlined
def grip_of(pace, x, d):
    """Give what does not change in a lane during a stride.

    The direction, whether it slides, friction per mass, the force of the spring, and what the
    contact bears; the last two of a stuck lane.
    """
    F_k = pace.k_x * x
    return d, d != 0.0, pace.f * d, F_k, pace.F_fs + ROUNDING * (pace.F_fs + abs(F_k))


@inlined
def step(pace, grip, x, v, u, rise, along, u_1):
    """Give the state at the end of a step, whether it may hold an event, and what it sums.

    `along` is the speed in the direction of sliding; so is what is given of the end.
    """
    d, slides, pull, F_k, hold = grip
    contact = pace.w * x + pull
    felt = pace.c * v + contact
    felt = felt if slides else u
    change = u_1 - u
    bend = change - rise
    terms = x * x, v * v, felt * felt, u * v, along, u * u, x * bend, v * bend, u * bend
    push = u + contact
    x_1 = x + (pace.y * v - (pace.Y * push + pace.YY_by_h * change))
    v_1 = pace.y_d * v - (pace.y * push + pace.Y_by_h * change)
    along_1 = d * v_1
    doubt = pace.steep * abs(change) + pace.fast * (along + along_1)
    dips = min(along, along_1) <= doubt and d * (felt + u) > 0.0
    stops = along_1 <= 0.0 or dips
    breaks = abs(pace.m * u_1 + F_k) > hold
    event = stops if slides else breaks
    return x_1 if slides else x, v_1 if slides else 0.0, change, along_1, event, terms


@inlined
def plus(one, other):
    """Add what two steps sum."""
    return (
        one[0] + other[0], one[1] + other[1], one[2] + other[2], one[3] + other[3],
        one[4] + other[4], one[5] + other[5], one[6] + other[6], one[7] + other[7],
        one[8] + other[8],
    )  # fmt: skip


@compiled
def stride(pace, at, lanes, until):
    """Let every lane stride on, or wait where a step may hold an event or is the last but few.

    Parameters
    ----------
    pace : Pace
    at : array, shape (SIZE,)
        See `lanes`; written.
    lanes : int
    until : float
        Last sample that was fetched, by its place.
    """
    last = until - STRIDE
    for lane in range(lanes):
        x, v, d = at[X + lane], at[V + lane], at[D + lane]
        u, rise, place = at[U + lane], at[RISE + lane], at[PLACE + lane]
        u_1, u_2 = at[AHEAD + lane], at[AHEAD + LANES + lane]
        u_3, u_4 = at[AHEAD + 2 * LANES + lane], at[AHEAD + 3 * LANES + lane]
        grip = grip_of(pace, x, d)
        x_1, v_1, r_1, along, e_1, z_1 = step(pace, grip, x, v, u, rise, d * v, u_1)
        x_2, v_2, r_2, along, e_2, z_2 = step(pace, grip, x_1, v_1, u_1, r_1, along, u_2)
        z = plus(z_1, z_2)
        x_3, v_3, r_3, along, e_3, z_3 = step(pace, grip, x_2, v_2, u_2, r_2, along, u_3)
        z = plus(z, z_3)
        x_4, v_4, r_4, along, e_4, z_4 = step(pace, grip, x_3, v_3, u_3, r_3, along, u_4)
        z = plus(z, z_4)
        waits = (e_1 or e_2) or (e_3 or e_4) or place > last
        slides = d != 0.0
        at[X + lane], at[V + lane] = x if waits else x_4, v if waits else v_4
        at[U + lane], at[RISE + lane] = u if waits else u_4, rise if waits else r_4
        at[PLACE + lane] = place if waits else place + STRIDE
        at[WAITS + lane] = 1.0 if waits and place < until else 0.0
        i = SUMS + lane
        at[i] += 0.0 if waits else z[0]
        at[i + LANES] += 0.0 if waits else z[1]
        at[i + 2 * LANES] += 0.0 if waits else z[2]
        at[i + 3 * LANES] += 0.0 if waits else z[3]
        at[i + 4 * LANES] += 0.0 if waits else z[4]
        at[i + 5 * LANES] += 0.0 if waits else z[5]
        at[i + 6 * LANES] += z[6] if slides and not waits else 0.0
        at[i + 7 * LANES] += 0.0 if waits else z[7]
        at[i + 8 * LANES] += z[8] if slides and not waits else 0.0
        at[i + 9 * LANES] += 0.0 if slides or waits else z[8]
        at[i + 10 * LANES] += 0.0 if slides or waits else STRIDE
        at[i + 11 * LANES] += 0.0 if waits else d * (r_4 - rise)
