"""Sliding and sticking under waves: the motion, and the margin to break-away.

A stretch is driven by ü = u_0 + slope s + Σ A sin(omega s + theta); friction limits that vary
are one more wave.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.events import ROUNDING
from drysim.core.fade import fade
from drysim.core.flow import SHORT, flow
from drysim.core.wave import wave
from drysim.core.waves import (
    ACROSS,
    ALONG,
    COSINE,
    OMEGA,
    SINE,
    STEADY,
    STRIDE,
    THETA,
    V_START,
    X_START,
    A,
    base_motion,
    normal_force,
)

FADED = 40.0
"""Decays after which a strong damper has left nothing of what the start lacked in velocity."""


@compiled
def slide(c, w, waves, x_r, v_r, g, r, s):
    """Give x_r, v_r, a and j as `slide_and_snap` does."""
    return slide_and_snap(c, w, waves, x_r, v_r, g, r, s)[:4]


@inlined
def slide_and_snap(c, w, waves, x_r, v_r, g, r, s):
    """Give the motion at time s of a stretch of sliding.

    Parameters
    ----------
    c, w : float
        As in `flow`.
    waves : Waves
        Anchored at the start of the stretch.
    x_r, v_r : float
        State at the start [m, m/s].
    g, r : float
        Force per mass at the start without the waves [m/s²], and its rate [m/s³].
    s : float
        Time since the start [s].

    Returns
    -------
    x_r, v_r, a, j, k : float
        Relative displacement [m], velocity [m/s], acceleration [m/s²], jerk [m/s³] and its
        rate [m/s⁴].
    """
    YY = 0.0
    if r == 0.0:
        y, y_d, Y = fade(c, w, s)
    else:
        y, y_d, Y, YY = flow(c, w, s)
    x, v, a, j, k = 0.0, 0.0, 0.0, 0.0, 0.0
    values = waves.values
    for i in range(waves.size):
        at = STRIDE * i
        if values[at + A] == 0.0:
            continue
        omega = values[at + OMEGA]
        steady = values[at + STEADY]
        lasts = (
            omega * s > SHORT or c * s > FADED or (steady > 1.0 and w * s * s > SHORT * SHORT)
        )
        if steady > 0.0 and lasts:
            swing, rate, push, push_d, push_dd = steady_response(values, at, s)
            # What the start lacks of the steady response dies out with it.
            x_r -= values[at + X_START]
            v_r -= values[at + V_START]
        else:
            swing, rate, push, push_d, push_dd = from_rest(c, w, values, at, s, y, y_d)
        x += swing
        v += rate
        a += push
        j += push_d
        k += push_dd
    # What the waves do and what is left of the start are added up apart: a motion that dies out
    # under a steady force keeps the sign of its velocity and acceleration.
    p = g - w * x_r
    a_start = (p - c * v_r) * y_d + (r - w * v_r) * y
    v_start = v_r * y_d + p * y + r * Y
    x += x_r + v_r * y + p * Y + r * YY
    j_start = r - c * a_start - w * v_start
    return x, v + v_start, a + a_start, j + j_start, k - c * j_start - w * a_start


@inlined
def steady_response(values, at, s):
    """Give x_r, v_r, a, j and k of the steady response to a wave at time s."""
    omega = values[at + OMEGA]
    angle = omega * s + values[at + THETA]
    sine, cosine = math.sin(angle), math.cos(angle)
    swing = values[at + ALONG] * sine + values[at + ACROSS] * cosine
    rate = omega * (values[at + ALONG] * cosine - values[at + ACROSS] * sine)
    push, push_d = -omega * omega * swing, -omega * omega * rate
    return swing, rate, push, push_d, -omega * omega * push


@inlined
def from_rest(c, w, values, at, s, y, y_d):
    """Give x_r, v_r, a, j and k that a wave alone has made from rest by time s."""
    omega = values[at + OMEGA]
    from_sine = -values[at + A] * values[at + COSINE]
    from_cosine = -values[at + A] * values[at + SINE]
    R, P, P_d, sine, cosine = wave(c, w, omega, s, y, y_d)
    x = from_sine * omega * R + from_cosine * P
    v = from_sine * omega * P + from_cosine * P_d
    push = from_sine * omega * sine + from_cosine * cosine
    a = push - c * v - w * x
    j = omega * (from_sine * cosine - from_cosine * omega * sine) - c * a - w * v
    return x, v, a, j, -omega * omega * push - c * j - w * a


@inlined
def margin(plant, law, waves, x_r, u_0, slope, side, s):
    """Give the force still missing for break-away on one side, with its first two rates.

    Parameters
    ----------
    side : int
        +1 where F_L would break the contact by rising, -1 by falling.
    s : float
        Time since the start of the stretch [s].

    Returns
    -------
    G, G_d, G_dd : float
        F_fs - side·F_L [N], [N/s], [N/s²], roundings allowed for; below zero the mass has
        broken away.
    """
    u_dd, rate, bend = base_motion(waves, u_0, slope, s)
    load, load_d, load_dd = normal_force(law, waves, s)
    F_k = plant.k_x * x_r
    hold = law.F_fs * load
    return (
        hold + ROUNDING * (hold + abs(F_k)) - side * (plant.m * u_dd + F_k),
        law.F_fs * load_d - side * plant.m * rate,
        law.F_fs * load_dd - side * plant.m * bend,
    )
