"""Mean squares of a base that moves by sines, in closed form."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.waves import FREQUENCY, OMEGA, PHASE, STRIDE, A

SMALL = 0.5
"""Angle up to which six terms of a series exhaust double precision: 0.5^14·6/15! is 3e-16 of
the first."""


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
            at_i = angle(values[p + FREQUENCY], values[p + PHASE], middle)
            at_j = angle(values[q + FREQUENCY], values[q + PHASE], middle)
            # About the middle of the window, sines and cosines of what is left do not mix.
            half_i = math.pi * values[p + FREQUENCY] * length
            half_j = math.pi * values[q + FREQUENCY] * length
            apart, along = lack(half_i - half_j), lack(half_i + half_j)
            product = values[p + A] * values[q + A] * (
                math.sin(at_i) * math.sin(at_j) * (1.0 - 0.5 * (apart + along))
                + math.cos(at_i) * math.cos(at_j) * 0.5 * (along - apart)
            )  # fmt: skip
            both = values[p + OMEGA] * values[q + OMEGA]
            u_dd2 += product
            u2 += product / (both * both)
    return u_dd2, u2


@compiled
def angle(f, phase, t):
    """Give the angle of a wave at time t [rad]."""
    return 2.0 * math.pi * ((f * t) % 1.0) + phase


@compiled
def lack(x):
    """Give 1 - sin(x)/x, to its last digits however small x is."""
    if abs(x) > SMALL:
        return 1.0 - math.sin(x) / x
    s = x * x
    tail = 1.0 - s / 72.0 * (1.0 - s / 110.0 * (1.0 - s / 156.0))
    return s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * tail))
