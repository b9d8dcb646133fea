"""Whole steps of sliding: everything about them that does not change during a march."""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.flow import flow
from drysim.core.samples.longer import SHORT, More, more_of
from drysim.core.samples.series import BRIEF, Tail, tail_of

FINE = 3.0
"""Radians (or decays) a fine step may hold: what decays within it leaves a twentieth, far above
rounding, and extrema are π apart."""

FAINT = 1e-6
"""Share of the force balance below which v_r is carried on with its own rate, see `creep`.
The smaller it is, the less of the rate survives the rounding of that balance: 1e-10 here."""

MARGIN = 2.0
"""What the bound on a dip between samples is widened by, so that rounding cannot matter."""


class Map(NamedTuple):
    """The affine map of a stretch of sliding, without what the base does.

    x_r becomes x_x x_r + x_v v_r - d x_f, and v_r becomes v_x x_r + v_v v_r - d v_f.
    """

    x_x: float
    x_v: float
    x_f: float
    v_x: float
    v_v: float
    v_f: float


class Steps(NamedTuple):
    """The steps of a march.

    Attributes
    ----------
    c, w, f : float
        b/m [1/s], k_x/m [1/s²] and F_fk/m [m/s²].
    dt : float
        Length of a step [s].
    whole : tuple of float, shape (4,)
        `flow` over a step.
    fine, short, brief : bool
        Whether a step holds one extremum of v_r at most, and whether `longer_series` and
        `series` serve it.
    tail, more : Tail, More
    one, four : Map
        Of one step and of four.
    x_0, x_1, v_0, v_1 : float
        What ü at both ends of a step takes from x_r [s²] and v_r [s].
    x_base, v_base : tuple of float, shape (5,)
        What ü at five samples in a row takes from x_r and v_r in the four steps between them.
    steep, fast : float
        Four steps hide no dip of v_r to zero while |v_r| at both ends is above
        steep max |Δü| + fast max |v_r|; infinite where they are too long to tell.
    faint_f, faint_x : float
        v_r is faint where |v_r| <= faint_f + faint_x |x_r|, see `faint_below`.
    """

    c: float
    w: float
    f: float
    dt: float
    whole: tuple[float, float, float, float]
    fine: bool
    short: bool
    brief: bool
    tail: Tail
    more: More
    one: Map
    four: Map
    x_0: float
    x_1: float
    v_0: float
    v_1: float
    x_base: tuple[float, float, float, float, float]
    v_base: tuple[float, float, float, float, float]
    steep: float
    fast: float
    faint_f: float
    faint_x: float


@compiled
def rate_of(c, w):
    """Give the radians, or the decays of what lasts, that a second holds at most [1/s]."""
    return max(math.sqrt(w), 0.5 * c)


@compiled
def faint_per_force(c, w):
    """Return the largest faint velocity [m/s] for forces of 1 N/kg, see `faint_below`."""
    rate = rate_of(c, w)
    return FAINT / rate if rate > 0.0 else 0.0


@compiled
def map_of(c, w, f, s):
    """Give the affine map of a stretch of length s [s]."""
    y, y_d, Y, _ = flow(c, w, s)
    return Map(1.0 - w * Y, y, Y * f, -w * y, y_d, y * f)


@compiled
def left_of(c, w, s, x_r, v_r):
    """Give what is left of a state after free motion of length s [s]."""
    y, y_d, Y, _ = flow(c, w, s)
    return x_r * (1.0 - w * Y) + v_r * y, v_r * y_d - w * y * x_r


@compiled
def steps_of(plant, law, dt):
    """Give the steps of a march, each of length dt [s].

    Notes
    -----
    In four steps |v_r"| <= M = |Δü|/dt + c (v/(4 dt) + 4 M dt) + w (v + 2 M dt²), with v the
    greater |v_r| of both ends; and a function that bends so little falls at most 2 M dt² below
    its lower end.
    """
    c, w, f = plant.b / plant.m, plant.k_x / plant.m, law.F_fk / plant.m
    radians = (c + math.sqrt(w)) * dt
    whole = flow(c, w, dt)
    y, _, Y, YY = whole
    x_1, v_1 = YY / dt, Y / dt
    x_0, v_0 = Y - x_1, y - v_1
    # What each end of a step gives, one, two and three steps later.
    a, p = left_of(c, w, dt, x_0, v_0), left_of(c, w, dt, x_1, v_1)
    b, q = left_of(c, w, 2.0 * dt, x_0, v_0), left_of(c, w, 2.0 * dt, x_1, v_1)
    g, r = left_of(c, w, 3.0 * dt, x_0, v_0), left_of(c, w, 3.0 * dt, x_1, v_1)
    tame = 1.0 - (4.0 * c + 2.0 * w * dt) * dt
    tail = tail_of(c, w)
    bend = MARGIN * 2.0 / tame if tame > 0.25 else math.inf
    rate, faint = rate_of(c, w), faint_per_force(c, w)
    return Steps(
        c, w, f, dt, whole, rate * dt <= FINE, radians <= SHORT, radians <= BRIEF,
        tail, more_of(tail, c, w),
        map_of(c, w, f, dt), map_of(c, w, f, 4.0 * dt), x_0, x_1, v_0, v_1,
        (g[0], b[0] + r[0], a[0] + q[0], x_0 + p[0], x_1),
        (g[1], b[1] + r[1], a[1] + q[1], v_0 + p[1], v_1),
        bend * dt, bend * (0.25 * c + w * dt) * dt, faint * f, faint * w,
    )  # fmt: skip


@compiled
def step_end(steps, x_r, v_r, d, u_0, u_1):
    """Give x_r and v_r at the end of a step, should nothing happen in it."""
    one = steps.one
    return (
        one.x_x * x_r + one.x_v * v_r - (steps.x_0 * u_0 + steps.x_1 * u_1 + d * one.x_f),
        one.v_x * x_r + one.v_v * v_r - (steps.v_0 * u_0 + steps.v_1 * u_1 + d * one.v_f),
    )


@inlined
def faint_below(steps, x_r):
    """Return the |v_r| up to which v_r is faint [m/s].

    The affine map makes v_r of forces that cancel; the rounding of those would decide the sign
    of a velocity that is fainter still.
    """
    return steps.faint_f + steps.faint_x * abs(x_r)
