"""Integrals over what lies on either side of an event within a short step."""

from __future__ import annotations

from drysim.core.compiled import fused

INNER = (0.17267316464601143, 0.5, 0.8273268353539886)
WEIGHTS = (0.2722222222222222, 0.35555555555555557, 0.2722222222222222)
OUTER = 0.05
"""Of Gauss and Lobatto for five points, of which two are known: as exact as four of Gauss and
Legendre, which exhaust double precision on a short stretch, see `stretches`."""


@fused
def away_from(q, s):
    """Give distance and speed at time s from an event, at which the speed is 0."""
    s_2 = s * s
    s_4 = s_2 * s_2
    v = (q[1] + q[2] * s) + s_2 * (q[3] + q[4] * s)
    v += s_4 * ((q[5] + q[6] * s) + s_2 * (q[7] + q[8] * s))
    x = (q[1] * (1.0 / 2.0) + q[2] * (1.0 / 3.0) * s) + s_2 * (
        q[3] * (1.0 / 4.0) + q[4] * (1.0 / 5.0) * s
    )
    x += s_4 * (
        (q[5] * (1.0 / 6.0) + q[6] * (1.0 / 7.0) * s)
        + s_2 * (q[7] * (1.0 / 8.0) + q[8] * (1.0 / 9.0) * s)
    )
    return s_2 * x, s * v


@fused
def beside(steps, q, x_s, d, u_s, slope, s, x_e, v_e, felt_e, u_e):
    """Give the integrals of x_r², v_r², x_dd² and ü v_r from an event to an end of the step.

    Parameters
    ----------
    steps : Steps
    q : tuple of float
        Series of the speed from the event on, or back from it.
    x_s, u_s : float
        x_r [m] and ü [m/s²] at the event.
    d : float
        Direction, 0 where it sticks.
    slope : float
        Of ü [m/s³].
    s : float
        Time from the event to the end [s]; below 0 to the beginning of the step.
    x_e, v_e, felt_e, u_e : float
        What is there: x_r, v_r, minus x_dd where it slides, and ü.
    """
    c, w, pull, slides = steps.c, steps.w, d * steps.f, d != 0.0
    first = w * x_s + pull if slides else u_s
    last = felt_e if slides else u_e
    x2 = OUTER * (x_s * x_s + x_e * x_e)
    v2, power = OUTER * (v_e * v_e), OUTER * (u_e * v_e)
    x_dd2 = OUTER * (first * first + last * last)
    for i in range(len(INNER)):
        t = s * INNER[i]
        way, speed_there = away_from(q, t)
        x, v, u = x_s + d * way, d * speed_there, u_s + slope * t
        x_dd = w * x + c * v + pull if slides else u
        x2 += WEIGHTS[i] * (x * x)
        v2 += WEIGHTS[i] * (v * v)
        x_dd2 += WEIGHTS[i] * (x_dd * x_dd)
        power += WEIGHTS[i] * (u * v)
    h = abs(s)
    return h * x2, h * v2, h * x_dd2, h * power
