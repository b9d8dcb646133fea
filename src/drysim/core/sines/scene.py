"""A scene under sines as a row of numbers: quicker to hand on than tuples."""

from __future__ import annotations

from drysim.core.compiled import inlined
from drysim.core.plant import Law, Plant
from drysim.core.waves import STRIDE, Waves

M, K_X, B, F_FK, F_FS, VARIATION, OMEGA_N, PHASE_N, X_R, V_R, REST = range(11)
"""Columns of a scene: plant, law and start; from REST on what its waves hold, or what else a
kernel asks for."""


@inlined
def plant_and_law(scene):
    """Give the plant and the law of a scene."""
    law = Law(scene[F_FK], scene[F_FS], scene[VARIATION], scene[OMEGA_N], scene[PHASE_N])
    return Plant(scene[M], scene[K_X], scene[B]), law


@inlined
def unpacked(scene):
    """Give plant, law and waves of a scene; the last wave is friction's, where that varies."""
    plant, law = plant_and_law(scene)
    values = scene[REST:]
    size = len(values) // STRIDE
    return plant, law, Waves(values, size, size - 1 if law.variation != 0.0 else size)
