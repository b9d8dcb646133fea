"""Whole steps of sampled base motion on the way between two stops: one affine map each."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.flow import flow
from drysim.core.samples.steps import FINE, faint_per_force, map_of, rate_of
from drysim.core.trail import mark


@compiled
def pass_on(plant, u_dd, dt, n, end, xi, v_r, f, low, high, trail, at, full, z, mode):
    """Take whole steps while the mass goes on in its direction between two limits.

    Parameters
    ----------
    plant : Plant
    u_dd : array, shape (samples,)
        Base acceleration [m/s²].
    dt : float
        Length of a step [s].
    n, end : int
        Step to begin with and the one to stop before.
    xi, v_r : float
        State at sample n [m, m/s].
    f, low, high : float
        Constant force per mass against the motion [m/s²], and limits of xi [m].
    trail, at, full : Trail, int, int
        Where to write the steps, how many are written and may be.
    z, mode : float, int
        What is written with each step.

    Returns
    -------
    n, xi, v_r, at
        The first step that wants a closer look, and the state there.
    """
    c, w = plant.b / plant.m, plant.k_x / plant.m
    if rate_of(c, w) * dt > FINE:
        # Only a fine step tells by its ends of a dip of v_r in between.
        return n, xi, v_r, at
    y, _, Y, YY = flow(c, w, dt)
    one = map_of(c, w, 1.0, dt)
    x_1, v_1 = YY / dt, Y / dt
    x_0, v_0 = Y - x_1, y - v_1
    a = -(u_dd[n] + c * v_r + w * xi + f)
    way = 1.0 if v_r > 0.0 else -1.0
    faint = faint_per_force(c, w)
    while n < end and at < full:
        u_0 = u_dd[n]
        u_1 = u_dd[n + 1]
        x = one.x_x * xi + one.x_v * v_r - (x_0 * u_0 + x_1 * u_1 + one.x_f * f)
        v = one.v_x * xi + one.v_v * v_r - (v_0 * u_0 + v_1 * u_1 + one.v_f * f)
        a_end = -(u_1 + c * v + w * x + f)
        slow = way * v <= faint * (abs(f) + w * abs(x))
        if slow or (way * a < 0.0 and way * a_end > 0.0) or not low < x < high:
            break
        at = mark(trail, at, n, 0.0, xi, v_r, z, mode)
        n += 1
        xi, v_r, a = x, v, a_end
    return n, xi, v_r, at
