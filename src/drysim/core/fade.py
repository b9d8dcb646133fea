"""The flow without its last integral, by the shortest way: what motion under waves needs."""

from __future__ import annotations

import math

from drysim.core.compiled import inlined
from drysim.core.flow import SHORT, flow

CALM = 0.05
"""Share of w that is left of w - c²/4 where sines and cosines are as good as the series."""


@inlined
def fade(c, w, s):
    """Give y, y_d and Y as `flow` does: in closed form where that loses nothing.

    It would cancel on a short stretch, and near critical damping.
    """
    square = w - 0.25 * c * c
    if square < CALM * w or w * s * s < SHORT * SHORT:
        return flow(c, w, s)[:3]
    omega_d = math.sqrt(square)
    decay = math.exp(-0.5 * c * s)
    even = decay * math.cos(omega_d * s)
    y = decay * math.sin(omega_d * s) / omega_d
    return y, even - 0.5 * c * y, (1.0 - even - 0.5 * c * y) / w
