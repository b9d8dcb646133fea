"""Sliding and sticking under waves: the motion, and the margin to break-away.

A stretch is driven by ü = u_0 + slope s + Σ A sin(omega s + theta); friction limits that vary
are one more wave.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compiled import compiled
from drysim.core.events import ROUNDING
from drysim.core.flow import flow
from drysim.core.wave import wave


class Waves(NamedTuple):
    """The sines of a scene as parallel arrays (or lists), shape (waves,).

    The first `base` of them move the base; one more may stand for friction limits that vary.

    Attributes
    ----------
    A : array of float
        Amplitude of ü [m/s²]; of the friction wave: set by `anchor` for the direction of
        sliding.
    f, omega : array of float
        Frequency [Hz] and angular frequency [rad/s].
    phase : array of float
        Phase at t = 0 [rad].
    theta : array of float
        Phase at the start of the stretch [rad]; set by `anchor`.
    base : int
        Number of waves that move the base.
    """

    A: Any
    f: Any
    omega: Any
    phase: Any
    theta: Any
    base: int


@compiled
def anchor(waves, law, m, t, d):
    """Start a stretch at time t [s] in direction d: set the phases, and friction's wave."""
    for i in range(len(waves.A)):
        waves.theta[i] = 2.0 * math.pi * ((waves.f[i] * t) % 1.0) + waves.phase[i]
    if len(waves.A) > waves.base:
        waves.A[waves.base] = d * law.F_fk * law.variation / m


@compiled
def slide(c, w, waves, x_r, v_r, g, r, s):
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
    x_r, v_r, a, j : float
        Relative displacement [m], velocity [m/s], acceleration [m/s²] and jerk [m/s³].
    """
    n = len(waves.A)
    y, y_d, Y, YY = 0.0, 0.0, 0.0, 0.0
    if n == 0 or r != 0.0:
        y, y_d, Y, YY = flow(c, w, s)
    x = 0.0
    v = 0.0
    push = 0.0
    push_d = 0.0
    for i in range(n):
        omega = waves.omega[i]
        from_sine = -waves.A[i] * math.cos(waves.theta[i])
        from_cosine = -waves.A[i] * math.sin(waves.theta[i])
        y, y_d, Y, R, P, P_d, sine, cosine = wave(c, w, omega, s)
        x += from_sine * omega * R + from_cosine * P
        v += from_sine * omega * P + from_cosine * P_d
        push += from_sine * omega * sine + from_cosine * cosine
        push_d += omega * (from_sine * cosine - from_cosine * omega * sine)
    # What the waves do and what is left of the start are added up apart: a motion that dies out
    # under a steady force keeps the sign of its velocity and acceleration.
    a = push - c * v - w * x
    j = push_d - c * a - w * v
    p = g - w * x_r
    a_start = (p - c * v_r) * y_d + (r - w * v_r) * y
    v_start = v_r * y_d + p * y + r * Y
    x += x_r + v_r * y + p * Y + r * YY
    return x, v + v_start, a + a_start, j + r - c * a_start - w * v_start


@compiled
def base_motion(waves, u_0, slope, s):
    """Give ü [m/s²] and its first two rates at time s of a stretch."""
    u_dd = u_0 + slope * s
    rate = slope
    bend = 0.0
    for i in range(waves.base):
        omega = waves.omega[i]
        angle = omega * s + waves.theta[i]
        value = waves.A[i] * math.sin(angle)
        u_dd += value
        rate += waves.A[i] * omega * math.cos(angle)
        bend -= value * omega * omega
    return u_dd, rate, bend


@compiled
def normal_force(law, waves, s):
    """Give the normal force relative to its mean [-], and its first two rates, at time s."""
    if len(waves.A) == waves.base:
        return 1.0, 0.0, 0.0
    angle = law.omega * s + waves.theta[waves.base]
    swing = law.variation * math.sin(angle)
    return 1.0 + swing, law.variation * law.omega * math.cos(angle), -swing * law.omega**2


@compiled
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
