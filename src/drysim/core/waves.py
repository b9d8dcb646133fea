"""The sines of a scene as kernels read them, and where each is as a stretch starts."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compiled import compiled, inlined

STRIDE = 12
"""Columns of a wave in the flat table: one array is quicker to hand on than one a column."""

A, FREQUENCY, OMEGA, PHASE = 0, 1, 2, 3
"""Amplitude of ü [m/s²], frequency [Hz], angular frequency [rad/s], phase at t = 0 [rad]."""

THETA, SINE, COSINE = 4, 5, 6
"""Phase at the start of the stretch [rad], its sine and cosine."""

ALONG, ACROSS, X_START, V_START, STEADY = 7, 8, 9, 10, 11
"""Steady response to the wave: ALONG sin + ACROSS cos [m], its state as the stretch starts
[m, m/s], and whether it may be set off against the motion (1 or 0)."""

UNSET = (0.0,) * (STRIDE - THETA)
"""What `anchor` sets."""

MOST_SWING = 16.0
"""Square of the greatest swing, relative to that of an oscillator free or stiff, up to which
the steady response may be set off against the motion: two bits are lost at most."""


class Waves(NamedTuple):
    """The sines of a scene.

    Attributes
    ----------
    values : array (or list) of float, shape (STRIDE size,)
        Wave by wave the columns named above; from THETA on they are set by `anchor`.
    size : int
        Number of waves.
    base : int
        How many of them move the base; one more may stand for friction limits that vary, whose
        amplitude `anchor` sets for the direction of sliding.
    """

    values: Any
    size: int
    base: int


@compiled
def set_wave(values, i, amplitude, frequency, phase):
    """Write a wave into the table."""
    at = STRIDE * i
    values[at + A] = amplitude
    values[at + FREQUENCY] = frequency
    values[at + OMEGA] = 2.0 * math.pi * frequency
    values[at + PHASE] = phase


@inlined
def anchor(waves, plant, law, t, d):
    """Start a stretch at time t [s] in direction d: set the phases, and friction's wave."""
    c = plant.b / plant.m
    w = plant.k_x / plant.m
    values = waves.values
    if waves.size > waves.base:
        values[STRIDE * waves.base + A] = d * law.F_fk * law.variation / plant.m
    for i in range(waves.size):
        at = STRIDE * i
        theta = 2.0 * math.pi * ((values[at + FREQUENCY] * t) % 1.0) + values[at + PHASE]
        sine, cosine = math.sin(theta), math.cos(theta)
        values[at + THETA] = theta
        values[at + SINE] = sine
        values[at + COSINE] = cosine
        omega = values[at + OMEGA]
        spring = w - omega * omega
        size = spring * spring + (c * omega) ** 2
        values[at + STEADY] = 0.0
        if size > 0.0 and MOST_SWING * size >= (w + omega * omega) ** 2:
            along = -values[at + A] * spring / size
            across = values[at + A] * c * omega / size
            values[at + STEADY] = 1.0
            values[at + ALONG] = along
            values[at + ACROSS] = across
            values[at + X_START] = along * sine + across * cosine
            values[at + V_START] = omega * (along * cosine - across * sine)


@inlined
def base_motion(waves, u_0, slope, s):
    """Give ü [m/s²] and its first two rates at time s of a stretch."""
    u_dd = u_0 + slope * s
    rate = slope
    bend = 0.0
    values = waves.values
    for i in range(waves.base):
        at = STRIDE * i
        omega = values[at + OMEGA]
        sine, cosine = values[at + SINE], values[at + COSINE]
        if s != 0.0:
            angle = omega * s + values[at + THETA]
            sine, cosine = math.sin(angle), math.cos(angle)
        value = values[at + A] * sine
        u_dd += value
        rate += values[at + A] * omega * cosine
        bend -= value * omega * omega
    return u_dd, rate, bend


@inlined
def normal_force(law, waves, s):
    """Give the normal force relative to its mean [-], and its first two rates, at time s."""
    if waves.size == waves.base:
        return 1.0, 0.0, 0.0
    at = STRIDE * waves.base
    sine, cosine = waves.values[at + SINE], waves.values[at + COSINE]
    if s != 0.0:
        angle = law.omega * s + waves.values[at + THETA]
        sine, cosine = math.sin(angle), math.cos(angle)
    swing = law.variation * sine
    return 1.0 + swing, law.variation * law.omega * cosine, -swing * law.omega**2
