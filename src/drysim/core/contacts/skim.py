"""Whole steps of sampled base motion while a spring contact holds: one affine map each."""

from __future__ import annotations

from drysim.core.compiled import inlined
from drysim.core.contacts.hit import turn_of


@inlined
def skim(steps, u_dd, n, until, x_r, v_r, f, low, high, x_out, v_out, d_out):
    """Take whole steps while the contact holds: between two limits of x_r, there and back.

    Parameters
    ----------
    steps : Whole
        Of fine steps.
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

    Notes
    -----
    A fine step holds one extremum of v_r at most. So a velocity that falls as the step begins
    is no greater than then until the mass turns, and no greater than at the end once it has
    turned twice: where that takes x_r to no limit, its turns need not be known.
    """
    c, w, dt, one = steps.c, steps.w, steps.dt, steps.one
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
            if v == 0.0 or not low < x < high:
                break
            turns = way * v < 0.0
            inside = low < x_r + v_r * dt < high and (turns or low < x - v * dt < high)
            if way * a >= 0.0 or not inside:
                if not turns:
                    break
                r = -way * (u_1 - u_0) * steps.per_dt
                s, far = turn_of(steps, way * v_r, way * a, r, way * v, way * a_end, dt)
                if s < 0.0 or not low < x_r + way * far < high:
                    break
            if turns:
                way = -way
        n += 1
        u_0, x_r, v_r, a = u_1, x, v, a_end
        x_out[n] = x_r
        v_out[n] = v_r
        d_out[n] = 0
    return n, x_r, v_r
