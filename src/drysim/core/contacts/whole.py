"""Steps of sampled base motion over a spring contact: whole ones by a map, and parts."""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compiled import inlined
from drysim.core.flow import INVERSE_FACTORIAL, flow
from drysim.core.samples.steps import Map, map_of

TERMS = 16
"""Terms that exhaust double precision on a fine step: 6/19! is below 1e-16."""

SERVED = 1.0
"""Radians (or decays) a fine step may hold for these terms."""


class Whole(NamedTuple):
    """Steps in one mode of the contact.

    Attributes
    ----------
    c, w : float
        b/m [1/s] and stiffness/m [1/s²].
    dt, per_dt, rate : float
        Length of a step [s], its inverse and the fastest rate of the oscillator [1/s].
    fine : bool
        Whether a step holds one extremum of v_r at most, so that its ends tell of a dip, and
        `second` and `third` serve it.
    end : tuple of float
        The flow of a whole step.
    one : Map
        Of the state, with a unit of constant force per mass against it.
    x_0, x_1, v_0, v_1 : float
        What ü at both ends of a step takes from x_r [s²] and v_r [s].
    second, third : tuple of float, shape (TERMS,)
        Series of the second and third integral of the flow in the share of a step.
    """

    c: float
    w: float
    dt: float
    per_dt: float
    rate: float
    fine: bool
    end: tuple[float, float, float, float]
    one: Map
    x_0: float
    x_1: float
    v_0: float
    v_1: float
    second: tuple[float, ...]
    third: tuple[float, ...]


def whole_steps(plant, dt):
    """Give the steps of length dt [s] of an oscillator."""
    c, w = plant.b / plant.m, plant.k_x / plant.m
    rate = c + math.sqrt(w)
    end = flow(c, w, dt)
    y, _, Y, YY = end
    x_1, v_1 = YY / dt, Y / dt
    terms = [1.0, -c * dt]
    while len(terms) < TERMS:
        terms.append(-(c * dt * terms[-1] + w * dt * dt * terms[-2]))
    second, third = (
        tuple(term * INVERSE_FACTORIAL[n + more] for n, term in enumerate(terms))
        for more in (3, 4)
    )
    return Whole(
        c, w, dt, 1.0 / dt, rate, rate * dt <= SERVED, end, map_of(c, w, 1.0, dt),
        Y - x_1, x_1, y - v_1, v_1, second, third,
    )  # fmt: skip


@inlined
def summed(q, z):
    """Give the sum of a series of `TERMS` terms."""
    z_2 = z * z
    z_4 = z_2 * z_2
    low = q[0] + q[1] * z + z_2 * (q[2] + q[3] * z)
    middle = q[4] + q[5] * z + z_2 * (q[6] + q[7] * z)
    high = q[8] + q[9] * z + z_2 * (q[10] + q[11] * z)
    last = q[12] + q[13] * z + z_2 * (q[14] + q[15] * z)
    return low + z_4 * (middle + z_4 * (high + z_4 * last))


@inlined
def part_flow(steps, s):
    """Give what `flow` gives, for a time s within a step [s]."""
    c, w = steps.c, steps.w
    if s == steps.dt:
        return steps.end
    if not steps.fine:
        return flow(c, w, s)
    z = s * steps.per_dt
    s_2 = s * s
    second = s * summed(steps.second, z)
    YY = s_2 * second
    Y = s_2 * (0.5 - c * second - w * s_2 * summed(steps.third, z))
    y = s - c * Y - w * YY
    return y, 1.0 - c * y - w * Y, Y, YY
