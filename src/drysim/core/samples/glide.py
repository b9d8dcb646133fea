"""Sliding over samples for as long as nothing happens, four steps at a time.

A step waits for the one before it. Four states in a row, each carried four steps further, are
four chains that do not wait for each other; and what the base does within four steps hangs on
no state, so it is summed beforehand.

A mass that creeps to rest after the base has fallen silent has a velocity far below the forces
that the affine map makes it of: `creep` carries velocity and acceleration on by themselves.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.samples.steps import faint_below

ONE_OF_FOUR = 0.0625
"""What one step can hide, relative to what four can: the square of its length."""

LEAST, LIFT = 1e-250, 2.0**300
"""Below the first a velocity and its rate are multiplied by the second, see `lifted`."""


@compiled
def look_ahead(base, u_dd, ahead):
    """Sum what the base takes from the state within every four steps of a stretch.

    Parameters
    ----------
    base : tuple of float, shape (5,)
        `Steps.x_base` or `Steps.v_base`.
    u_dd : array, shape (n + 4,)
        Base acceleration of the stretch [m/s²].
    ahead : array, shape (at least n,)
        Written: of the four steps that begin at each sample.
    """
    p_0, p_1, p_2, p_3, p_4 = base
    for i in range(len(u_dd) - 4):
        ahead[i] = (
            p_0 * u_dd[i] + p_1 * u_dd[i + 1] + p_2 * u_dd[i + 2] + p_3 * u_dd[i + 3]
            + p_4 * u_dd[i + 4]
        )  # fmt: skip


@inlined
def glide(steps, u_dd, n, until, x_r, v_r, d, x_out, v_out, d_out, begin, x_ahead, v_ahead):
    """Slide until sample `until`, a step that may hold an event or a faint velocity.

    Parameters
    ----------
    steps : Steps
        Of fine steps.
    u_dd : array, shape (samples,)
        Base acceleration [m/s²].
    n, until : int
        Sample to begin at, and the last.
    x_r, v_r, d
        State there [m, m/s], and direction of sliding.
    x_out, v_out, d_out : array, shape (samples,)
        Written from n + 1 to the sample reached; up to three more may be scribbled on.
    begin : int
        Sample, not after n, at which `x_ahead` and `v_ahead` begin.
    x_ahead, v_ahead : array
        What the base does in every four steps, see `look_ahead`.

    Returns
    -------
    n, x_r, v_r
        Sample reached and the state there.
    """
    while n < until:
        fourth = n + 4 if steps.steep < math.inf else until
        n, x_r, v_r = one_by_one(
            steps, u_dd, n, min(fourth, until), x_r, v_r, d, x_out, v_out, d_out
        )
        if n < fourth:
            break
        n = four_by_four(steps, u_dd, n, until, d, x_out, v_out, d_out, begin, x_ahead, v_ahead)
        x_r = x_out[n]
        v_r = v_out[n]
    return n, x_r, v_r


@inlined
def one_by_one(steps, u_dd, n, until, x_r, v_r, d, x_out, v_out, d_out):
    """Slide step by step; parameters and returns as in `glide`.

    A fine step holds at most one extremum of v_r, and the acceleration outlasts it, so its
    signs at both ends tell of a dip.
    """
    c, w, f = steps.c, steps.w, d * steps.f
    x_x, x_v, x_f, v_x, v_v, v_f = steps.one
    x_0, x_1, v_0, v_1 = steps.x_0, steps.x_1, steps.v_0, steps.v_1
    x_f *= d
    v_f *= d
    u_0 = u_dd[n]
    a = -(u_0 + c * v_r + w * x_r + f)
    faint = faint_below(steps, x_r)
    while n < until:
        u_1 = u_dd[n + 1]
        x_next = x_x * x_r + x_v * v_r - (x_0 * u_0 + x_1 * u_1 + x_f)
        v_next = v_x * x_r + v_v * v_r - (v_0 * u_0 + v_1 * u_1 + v_f)
        a_next = -(u_1 + c * v_next + w * x_next + f)
        if d * v_next <= faint or (d * a < 0.0 and d * a_next > 0.0):
            break
        n += 1
        u_0 = u_1
        x_r = x_next
        v_r = v_next
        a = a_next
        x_out[n] = x_r
        v_out[n] = v_r
        d_out[n] = d
    return n, x_r, v_r


@compiled
def four_by_four(steps, u_dd, n, until, d, x_out, v_out, d_out, begin, x_ahead, v_ahead):
    """Carry the four states up to sample n on, four steps each; gives the sample reached.

    Parameters as in `glide`. Four new states stand when both ends are so fast that no dip fits
    in between; else those stand that come before the first in doubt.
    """
    i = n - 3 - begin
    if begin < 0 or i < 0:
        # Never so; but the compiler is told that no index counts from the end.
        return n
    x_x, x_v, x_f, v_x, v_v, v_f = steps.four
    x_f *= d
    v_f *= d
    m = begin + 3
    x_a, x_b, x_c, x_d = x_out[m + i - 3], x_out[m + i - 2], x_out[m + i - 1], x_out[m + i]
    v_a, v_b, v_c, v_d = v_out[m + i - 3], v_out[m + i - 2], v_out[m + i - 1], v_out[m + i]
    u_0 = u_dd[m + i]
    before = d * v_d
    faint = faint_below(steps, x_d)
    while i + 4 <= until - m:
        x_a, v_a = (
            x_x * x_a + x_v * v_a - (x_ahead[i] + x_f),
            v_x * x_a + v_v * v_a - (v_ahead[i] + v_f),
        )
        x_b, v_b = (
            x_x * x_b + x_v * v_b - (x_ahead[i + 1] + x_f),
            v_x * x_b + v_v * v_b - (v_ahead[i + 1] + v_f),
        )
        x_c, v_c = (
            x_x * x_c + x_v * v_c - (x_ahead[i + 2] + x_f),
            v_x * x_c + v_v * v_c - (v_ahead[i + 2] + v_f),
        )
        x_d, v_d = (
            x_x * x_d + x_v * v_d - (x_ahead[i + 3] + x_f),
            v_x * x_d + v_v * v_d - (v_ahead[i + 3] + v_f),
        )
        u_1, u_2, u_3, u_4 = (
            u_dd[m + i + 1], u_dd[m + i + 2], u_dd[m + i + 3], u_dd[m + i + 4]
        )  # fmt: skip
        change = max(max(abs(u_1 - u_0), abs(u_2 - u_1)), max(abs(u_3 - u_2), abs(u_4 - u_3)))
        after = d * v_d
        dip = steps.steep * change + steps.fast * max(before, abs(after))
        if not min(before, after) > dip + faint:
            x_out[m + i + 1] = x_a
            x_out[m + i + 2] = x_b
            x_out[m + i + 3] = x_c
            v_out[m + i + 1] = v_a
            v_out[m + i + 2] = v_b
            v_out[m + i + 3] = v_c
            d_out[m + i + 1] = d
            d_out[m + i + 2] = d
            d_out[m + i + 3] = d
            doubt = dip * ONE_OF_FOUR + faint
            first = (before > doubt) * (d * v_a > doubt)
            second = first * (d * v_b > doubt)
            return m + i + first + second + second * (d * v_c > doubt)
        x_out[m + i + 1] = x_a
        x_out[m + i + 2] = x_b
        x_out[m + i + 3] = x_c
        x_out[m + i + 4] = x_d
        v_out[m + i + 1] = v_a
        v_out[m + i + 2] = v_b
        v_out[m + i + 3] = v_c
        v_out[m + i + 4] = v_d
        d_out[m + i + 1] = d
        d_out[m + i + 2] = d
        d_out[m + i + 3] = d
        d_out[m + i + 4] = d
        before = after
        u_0 = u_4
        i += 4
    return m + i


@compiled
def creep(steps, u_dd, n, until, x_r, v_r, a, d, x_out, v_out, d_out):
    """Slide with a faint velocity until sample `until` or a step that may hold an event.

    Parameters and returns as in `glide`, with the relative acceleration a [m/s²] at the sample.

    Notes
    -----
    Differentiated, the equation of motion is v" + c v' + w v = -dü/dt. Neither ü, the spring
    nor friction occurs in it, so v and a keep their relative accuracy however small they are
    beside the forces. The position follows from the affine map as ever.
    """
    c, w = steps.c, steps.w
    y, y_d, Y, _ = steps.whole
    x_x, x_v, x_f, _, _, _ = steps.one
    x_f *= d
    while n < until and LEAST < d * v_r <= faint_below(steps, x_r):
        r = (u_dd[n] - u_dd[n + 1]) / steps.dt
        v_next = v_r * y_d + (a + c * v_r) * y + r * Y
        a_next = a * y_d + (r - w * v_r) * y
        if d * v_next <= 0.0 or (d * a < 0.0 and d * a_next > 0.0):
            break
        x_r = x_x * x_r + x_v * v_r - (steps.x_0 * u_dd[n] + steps.x_1 * u_dd[n + 1] + x_f)
        v_r = v_next
        a = a_next
        n += 1
        x_out[n] = x_r
        v_out[n] = v_r
        d_out[n] = d
    return n, x_r, v_r, a


@inlined
def lifted(v_r, a):
    """Return v_r and a, multiplied by a power of two where they are about to underflow.

    While the base is silent only their ratio decides whether and when the mass stops, and
    what is lifted is still far below any rounding.
    """
    lift = LIFT if max(abs(v_r), abs(a)) <= LEAST else 1.0
    return v_r * lift, a * lift
