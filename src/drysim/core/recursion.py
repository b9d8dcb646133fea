"""The oscillator without dry friction over samples: a linear recursion, no event code."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.flow import flow


@compiled
def recursion(plant, u_dd, dt, x_r, v_r, x_out, v_out):
    """March from the first sample to the last.

    Parameters
    ----------
    plant : Plant
    u_dd : array, shape (n,)
        Base acceleration [m/s²], linear between samples.
    dt : float
        Distance of the samples [s].
    x_r, v_r : float
        State at the first sample [m, m/s].
    x_out, v_out : array, shape (n,)
        Written.
    """
    m, k_x, b = plant
    w = k_x / m
    y, y_d, Y, YY = flow(b / m, w, dt)
    x_x, x_1 = 1.0 - w * Y, YY / dt
    v_x, v_1 = -w * y, Y / dt
    x_0 = Y - x_1
    v_0 = y - v_1
    x_out[0] = x_r
    v_out[0] = v_r
    before = u_dd[0]
    for n in range(1, len(u_dd)):
        now = u_dd[n]
        x_r, v_r = (
            x_x * x_r + y * v_r - (x_0 * before + x_1 * now),
            v_x * x_r + y_d * v_r - (v_0 * before + v_1 * now),
        )
        before = now
        x_out[n] = x_r
        v_out[n] = v_r
