"""Steps of sampled base motion over a spring contact: whole ones by a map, and parts."""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compiled import inlined
from drysim.core.flow import INVERSE_FACTORIAL, flow
from drysim.core.samples.steps import FINE, Map, map_of

TERMS = 16
"""Terms that exhaust double precision on a fine step: 6/19! is below 1e-16."""


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
        c, w, dt, 1.0 / dt, rate, rate * dt <= FINE, end, map_of(c, w, 1.0, dt),
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


@inlined
def skim(steps, u_dd, n, until, x_r, v_r, f, low, high, x_out, v_out, d_out):
    """Take whole steps while the mass goes on in its direction between two limits of x_r.

    Parameters
    ----------
    steps : Whole
    u_dd : array, shape (samples,)
        Base acceleration [m/s²].
    n, until : int
        Sample to begin at, and the last.
    x_r, v_r : float
        State at sample n [m, m/s].
    f : float
        Constant contact force per mass [m/s²].
    low, high : float
        Limits of x_r [m].
    x_out, v_out, d_out : array, shape (samples,)
        Written from n + 1 to the sample reached.

    Returns
    -------
    n, x_r, v_r
        The sample whose step wants a closer look, and the state there.
    """
    c, w, one = steps.c, steps.w, steps.one
    x_0, x_1, v_0, v_1 = steps.x_0, steps.x_1, steps.v_0, steps.v_1
    x_f, v_f = one.x_f * f, one.v_f * f
    u_0 = u_dd[n]
    a = -(u_0 + c * v_r + w * x_r + f)
    way = 1.0 if v_r > 0.0 else -1.0
    while n < until:
        u_1 = u_dd[n + 1]
        x = one.x_x * x_r + one.x_v * v_r - (x_0 * u_0 + x_1 * u_1 + x_f)
        v = one.v_x * x_r + one.v_v * v_r - (v_0 * u_0 + v_1 * u_1 + v_f)
        a_end = -(u_1 + c * v + w * x + f)
        if way * v <= 0.0 or (way * a < 0.0 and way * a_end > 0.0) or not low < x < high:
            break
        n += 1
        u_0, x_r, v_r, a = u_1, x, v, a_end
        x_out[n] = x_r
        v_out[n] = v_r
        d_out[n] = 0
    return n, x_r, v_r
