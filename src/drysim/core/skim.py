"""Whole steps of sampled base motion over a spring contact: one affine map each."""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.flow import flow
from drysim.core.steps import FINE, Map, map_of
from drysim.core.trail import mark


class Whole(NamedTuple):
    """Whole steps in one mode of the contact.

    Attributes
    ----------
    c, w : float
        b/m [1/s] and stiffness/m [1/s²].
    fine : bool
        Whether a step holds at most one extremum of v_r, so that its ends tell of a dip.
    map : Map
        Of the state, a unit of constant force per mass against it.
    x_0, x_1, v_0, v_1 : float
        What ü at both ends of a step takes from x_r [s²] and v_r [s].
    """

    c: float
    w: float
    fine: bool
    map: Map
    x_0: float
    x_1: float
    v_0: float
    v_1: float


@compiled
def whole_steps(c, w, dt):
    """Give the whole steps of length dt [s] of an oscillator."""
    y, _, Y, YY = flow(c, w, dt)
    x_1, v_1 = YY / dt, Y / dt
    fine = (c + math.sqrt(w)) * dt <= FINE
    return Whole(c, w, fine, map_of(c, w, 1.0, dt), Y - x_1, x_1, y - v_1, v_1)


@inlined
def skim(steps, u_dd, n, end, x_r, v_r, f, low, high, trail, at, full, rest, mode):
    """Take whole steps while the mass goes on in its direction between two limits of x_r.

    Parameters
    ----------
    steps : Whole
    u_dd : array, shape (samples,)
        Base acceleration [m/s²].
    n, end : int
        Step to begin with and the one to stop before.
    x_r, v_r : float
        State at sample n [m, m/s].
    f : float
        Constant contact force per mass [m/s²].
    low, high : float
        Limits of x_r [m].
    trail, at, full : Trail, int, int
        Where to write the steps, how many are written and may be.
    rest, mode : float, int
        Where the contact carries no force [m], and its mode; written with each step.

    Returns
    -------
    n, x_r, v_r, at
        The first step that wants a closer look, and the state there.
    """
    if not steps.fine:
        return n, x_r, v_r, at
    c, w, _, one, x_0, x_1, v_0, v_1 = steps
    a = -(u_dd[n] + c * v_r + w * x_r + f)
    way = 1.0 if v_r > 0.0 else -1.0
    while n < end and at < full and v_r != 0.0:
        u_0 = u_dd[n]
        u_end = u_dd[n + 1]
        x = one.x_x * x_r + one.x_v * v_r - (x_0 * u_0 + x_1 * u_end + one.x_f * f)
        v = one.v_x * x_r + one.v_v * v_r - (v_0 * u_0 + v_1 * u_end + one.v_f * f)
        a_end = -(u_end + c * v + w * x + f)
        if way * v <= 0.0 or (way * a < 0.0 and way * a_end > 0.0) or not low < x < high:
            break
        at = mark(trail, at, n, 0.0, x_r, v_r, rest, mode)
        n += 1
        x_r = x
        v_r = v
        a = a_end
    return n, x_r, v_r, at
