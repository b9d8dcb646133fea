"""Mean squares of a base that moves by sines, in closed form."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.waves import FREQUENCY, OMEGA, PHASE, STRIDE, A


@compiled
def mean_squares(waves, begin, end):
    """Give the mean squares of ü [m²/s⁴] and of u [m²] over a window [s].

    u is the displacement without offset and drift, -Σ A/(2π f)² sin(2π f t + phase).
    """
    length, middle = end - begin, 0.5 * (begin + end)
    u_dd2, u2 = 0.0, 0.0
    values = waves.values
    for i in range(waves.base):
        for j in range(waves.base):
            p, q = STRIDE * i, STRIDE * j
            f_i, f_j = values[p + FREQUENCY], values[q + FREQUENCY]
            phase_i, phase_j = values[p + PHASE], values[q + PHASE]
            product = 0.5 * values[p + A] * values[q + A] * (
                mean_cosine(f_i - f_j, phase_i - phase_j, length, middle)
                - mean_cosine(f_i + f_j, phase_i + phase_j, length, middle)
            )  # fmt: skip
            both = values[p + OMEGA] * values[q + OMEGA]
            u_dd2 += product
            u2 += product / (both * both)
    return u_dd2, u2


@compiled
def mean_cosine(f, phase, length, middle):
    """Give the mean of cos(2π f t + phase) over a window of some length about its middle."""
    half = math.pi * f * length
    fade = math.sin(half) / half if half != 0.0 else 1.0
    return fade * math.cos(2.0 * math.pi * ((f * middle) % 1.0) + phase)
