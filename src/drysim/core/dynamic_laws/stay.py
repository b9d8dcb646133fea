"""How long a mass stays where Stribeck's friction holds it."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.plant import Law
from drysim.core.samples.stop import NEVER
from drysim.core.sines.leave import break_away
from drysim.core.waves import OMEGA, STRIDE, anchor


@compiled
def calm_length(waves):
    """Give the longest step [s] of a stuck mass, within which a series knows the waves."""
    fastest = 0.0
    for i in range(waves.size):
        fastest = max(fastest, waves.values[STRIDE * i + OMEGA])
    return 1.0 / fastest if fastest > 0.0 else NEVER


@compiled
def end_of_stay(plant, law, waves, x_r, u_0, slope, t, h):
    """Give when a stuck mass breaks away within h [s], or infinity, and in which direction."""
    limits = Law(law.F_fs, law.F_fs, 0.0, 0.0, 0.0)
    anchor(waves, plant, limits, t, 0)
    return break_away(plant, limits, waves, x_r, u_0, slope, slope, h)
