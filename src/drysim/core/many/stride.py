"""A few steps of every lane at once, as if nothing happened; they stand where nothing does."""

from __future__ import annotations

from typing import NamedTuple

from drysim.core.compiled import compiled, fused
from drysim.core.events import ROUNDING
from drysim.core.many.lanes import AHEAD, LANES, STRIDE, SUMS, WAITS, WIDTH, D, V, X
from drysim.core.samples.steps import MARGIN, Map

TAME = 0.05
"""Share that must be left of 1 for the bound on a dip to mean anything."""

EVER = 1e300
"""In place of that bound: then every step is looked at closely. Times nothing it is nothing."""


class Pace(NamedTuple):
    """What a step takes, should nothing happen in it: mass, spring and friction, its map.

    Attributes
    ----------
    m, k_x, F_fs : float
    c, w, f : float
        b/m [1/s], k_x/m [1/s²] and F_fk/m [m/s²].
    one : Map
    x_0, x_1, v_0, v_1 : float
        As in `Steps`.
    steep, fast : float
        A step hides no dip of |v_r| to zero above steep |change of ü| + fast |v_r|.
    """

    m: float
    k_x: float
    F_fs: float
    c: float
    w: float
    f: float
    one: Map
    x_0: float
    x_1: float
    v_0: float
    v_1: float
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
        plant.m, plant.k_x, law.F_fs, c, w, steps.f, steps.one,
        steps.x_0, steps.x_1, steps.v_0, steps.v_1, steep, steep * (c + w * dt),
    )  # fmt: skip


class Grip(NamedTuple):
    """What does not change in a lane during a stride.

    Attributes
    ----------
    d : float
        Direction of sliding, 0 where it sticks.
    slides : bool
    pull, x_f, v_f : float
        Friction per mass [m/s²], and what it takes from x_r and v_r in a step.
    F_k, hold : float
        Force of the spring and what the contact bears [N], of a stuck lane.
    """

    d: float
    slides: bool
    pull: float
    x_f: float
    v_f: float
    F_k: float
    hold: float


@fused
def grip_of(pace, x, d):
    """Give what does not change in a lane during a stride that begins there."""
    F_k = pace.k_x * x
    hold = pace.F_fs + ROUNDING * (pace.F_fs + abs(F_k))
    return Grip(d, d != 0.0, pace.f * d, pace.one.x_f * d, pace.one.v_f * d, F_k, hold)


@fused
def step(pace, grip, x, v, u, u_1):
    """Give the state at the end of a step, and minus x_dd at its start where it slides."""
    # What the state takes part in comes last: the next step waits for it.
    one = pace.one
    x_1 = one.x_x * x + (one.x_v * v - (pace.x_0 * u + (pace.x_1 * u_1 + grip.x_f)))
    v_1 = one.v_v * v + (one.v_x * x - (pace.v_0 * u + (pace.v_1 * u_1 + grip.v_f)))
    felt = pace.c * v + (pace.w * x + grip.pull)
    return x_1 if grip.slides else x, v_1 if grip.slides else 0.0, felt


@fused
def added(z, x, v, felt, u, bend):
    """Add a sample to sums of products; `bend` is what the change of ü changes by there."""
    return (
        x * x + z[0], v * v + z[1], felt * felt + z[2], u * v + z[3], v + z[4], u * u + z[5],
        x * bend + z[6], v * bend + z[7], u * bend + z[8],
    )  # fmt: skip


NOTHING = (0.0,) * 9
"""Sums of no samples."""


@compiled
def stride(pace, at, lanes):
    """Let every lane stride on, or wait where a step may hold an event.

    Parameters
    ----------
    pace : Pace
    at : array, shape (SIZE,)
        See `lanes`; written.
    lanes : int
    """
    for first in range(0, lanes, WIDTH):
        stride_of_eight(pace, at[first:])


@fused
def stride_of_eight(pace, at):
    """Let as many lanes as a register holds stride on, or wait."""
    for i in range(WIDTH):
        x, v, d = at[X + i], at[V + i], at[D + i]
        u_b, u, u_1 = at[AHEAD + i], at[AHEAD + LANES + i], at[AHEAD + 2 * LANES + i]
        u_2, u_3 = at[AHEAD + 3 * LANES + i], at[AHEAD + 4 * LANES + i]
        u_4 = at[AHEAD + 5 * LANES + i]
        r_0, r_1, r_2, r_3, r_4 = u - u_b, u_1 - u, u_2 - u_1, u_3 - u_2, u_4 - u_3
        grip = grip_of(pace, x, d)
        slides, F_k, hold = grip.slides, grip.F_k, grip.hold
        x_1, v_1, felt = step(pace, grip, x, v, u, u_1)
        z = added(NOTHING, x, v, felt, u, r_1 - r_0)
        x_2, v_2, felt = step(pace, grip, x_1, v_1, u_1, u_2)
        z = added(z, x_1, v_1, felt, u_1, r_2 - r_1)
        x_3, v_3, felt = step(pace, grip, x_2, v_2, u_2, u_3)
        z = added(z, x_2, v_2, felt, u_2, r_3 - r_2)
        x_4, v_4, felt = step(pace, grip, x_3, v_3, u_3, u_4)
        z = added(z, x_3, v_3, felt, u_3, r_4 - r_3)
        # Whether any of these steps may hold an event is asked of all of them at once.
        s_0, s_1, s_2, s_3, s_4 = d * v, d * v_1, d * v_2, d * v_3, d * v_4
        slow = min(min(min(s_0, s_1), min(s_2, s_3)), s_4)
        fast = max(max(max(s_0, s_1), max(s_2, s_3)), s_4)
        change = max(max(abs(r_1), abs(r_2)), max(abs(r_3), abs(r_4)))
        low, high = min(min(u_1, u_2), min(u_3, u_4)), max(max(u_1, u_2), max(u_3, u_4))
        stops = slow <= pace.steep * change + pace.fast * (fast + fast)
        breaks = pace.m * high + F_k > hold or pace.m * low + F_k < -hold
        waits = stops if slides else breaks
        at[X + i], at[V + i] = x if waits else x_4, v if waits else v_4
        at[WAITS + i] = 1.0 if waits else 0.0
        j, bend = SUMS + i, r_4 - r_0
        at[j] = at[j] if waits else at[j] + z[0]
        at[j + LANES] = at[j + LANES] if waits else at[j + LANES] + z[1]
        old, x_dd2 = at[j + 2 * LANES], z[2] if slides else z[5]
        at[j + 2 * LANES] = old if waits else old + x_dd2
        at[j + 3 * LANES] = at[j + 3 * LANES] if waits else at[j + 3 * LANES] + z[3]
        at[j + 4 * LANES] = at[j + 4 * LANES] if waits else at[j + 4 * LANES] + d * z[4]
        at[j + 5 * LANES] = at[j + 5 * LANES] if waits else at[j + 5 * LANES] + z[5]
        old, glides, stays = at[j + 6 * LANES], slides and not waits, not (slides or waits)
        at[j + 6 * LANES] = old + z[6] if glides else old
        at[j + 7 * LANES] = at[j + 7 * LANES] if waits else at[j + 7 * LANES] + z[7]
        at[j + 8 * LANES] = at[j + 8 * LANES] + z[8] if glides else at[j + 8 * LANES]
        at[j + 9 * LANES] = at[j + 9 * LANES] + z[8] if stays else at[j + 9 * LANES]
        at[j + 10 * LANES] = at[j + 10 * LANES] + STRIDE if stays else at[j + 10 * LANES]
        at[j + 11 * LANES] = at[j + 11 * LANES] if waits else at[j + 11 * LANES] + d * bend
