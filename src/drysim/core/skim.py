"""Whole steps of sampled base motion over a spring contact: one affine map each."""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.flow import flow
from drysim.core.steps import FINE


class Map(NamedTuple):
    """A whole step as an affine map of the state, ü at both ends and a constant force per mass.

    Attributes
    ----------
    c, w : float
        b/m [1/s] and stiffness/m [1/s²].
    x_x, x_v, x_0, x_1, x_f, v_x, v_v, v_0, v_1, v_f : float
        Coefficients of the state after the step.
    fine : bool
        Whether a step holds at most one extremum of v_r, so that its ends tell of a dip.
    """

    c: float
    w: float
    x_x: float
    x_v: float
    x_0: float
    x_1: float
    x_f: float
    v_x: float
    v_v: float
    v_0: float
    v_1: float
    v_f: float
    fine: bool


@compiled
def step_map(c, w, dt):
    """Give the map of a whole step [s]."""
    y, y_d, Y, YY = flow(c, w, dt)
    x_1, v_1 = YY / dt, Y / dt
    fine = (c + math.sqrt(w)) * dt <= FINE
    return Map(
        c, w, 1.0 - w * Y, y, Y - x_1, x_1, Y, -w * y, y_d, y - v_1, v_1, y, fine
    )  # fmt: skip


@inlined
def skim(map, u_dd, n, end, x_r, v_r, f, low, high, steps, at, full, x_0, mode):
    """Take whole steps while the mass goes on in its direction between two limits of x_r.

    Parameters
    ----------
    map : Map
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
    steps, at, full : Steps, int, int
        Where to write the steps, how many are written and may be.
    x_0, mode : float, int
        To write with each step.

    Returns
    -------
    n, x_r, v_r, at
        The first step that wants a closer look, and the state there.
    """
    if not map.fine:
        return n, x_r, v_r, at
    c, w, x_x, x_v, x_u, x_1, x_f, v_x, v_v, v_u, v_1, v_f, _ = map
    a = -(u_dd[n] + c * v_r + w * x_r + f)
    way = 1.0 if v_r > 0.0 else -1.0
    while n < end and at < full and v_r != 0.0:
        u_0 = u_dd[n]
        u_end = u_dd[n + 1]
        x = x_x * x_r + x_v * v_r - (x_u * u_0 + x_1 * u_end + x_f * f)
        v = v_x * x_r + v_v * v_r - (v_u * u_0 + v_1 * u_end + v_f * f)
        a_end = -(u_end + c * v + w * x + f)
        if way * v <= 0.0 or (way * a < 0.0 and way * a_end > 0.0) or not low < x < high:
            break
        steps.n[at] = n
        steps.s[at] = 0.0
        steps.x_r[at] = x_r
        steps.v_r[at] = v_r
        steps.z[at] = x_0
        steps.d[at] = mode
        at += 1
        n += 1
        x_r = x
        v_r = v
        a = a_end
    return n, x_r, v_r, at
