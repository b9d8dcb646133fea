"""The base on a grid: its acceleration, each wave turned from one point to the next."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.waves import FREQUENCY, OMEGA, PHASE, STRIDE, A

RENEW = 256
"""Points after which a march over the grid begins afresh from the event before: few enough
that rounding does not add up, and always the same ones, so that blocks change no number."""


@compiled
def sample_base(waves, first, dt, u_out):
    """Write ü of the base [m/s²] on the grid n·dt, from point `first` on."""
    last = first + len(u_out)
    for k in range(len(u_out)):
        u_out[k] = 0.0
    values = waves.values
    for i in range(waves.base):
        at = STRIDE * i
        f, phase, A_i = values[at + FREQUENCY], values[at + PHASE], values[at + A]
        turn = math.sin(values[at + OMEGA] * dt)
        back = 2.0 * math.sin(0.5 * values[at + OMEGA] * dt) ** 2
        block = first - first % RENEW
        while block < last:
            theta = 2.0 * math.pi * ((f * (block * dt)) % 1.0) + phase
            sine = math.sin(theta)
            cosine = math.cos(theta)
            for k in range(block, min(block + RENEW, last)):
                if k >= first:
                    u_out[k - first] += A_i * sine
                sine, cosine = (
                    sine + (cosine * turn - sine * back),
                    cosine - (sine * turn + cosine * back),
                )
            block += RENEW
