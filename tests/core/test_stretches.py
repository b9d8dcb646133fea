"""Integrals over a stretch of sliding by series against those over panels of the flow."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest


@pytest.mark.parametrize(
    ("c", "w"),
    [(0.0, 100.0), (6.7, 100.0), (20.0, 100.0), (90.0, 100.0), (0.0, 0.0), (9.0, 0.0)],
)
@pytest.mark.parametrize("radians", [0.05, 0.4, 0.9, 30.0])
def test_parts_of_a_stretch_have_the_integrals_of_the_whole(
    kernel: SimpleNamespace, c: float, w: float, radians: float
) -> None:
    rate = c + math.sqrt(w) if c + w else 1.0
    h, f = radians / rate, 0.3
    plant, law = kernel.model.Plant(1.0, w, c), kernel.model.Law(f, f)
    waves = kernel.forcing.Waves(np.zeros(0), 0, 0)
    steps = kernel.oscillator.steps_of(plant, law, h)
    rng = np.random.Generator(np.random.PCG64(8))
    for _ in range(20):
        u_0, slope = rng.normal(), rng.normal() * rate
        x_r, v_r, d = rng.normal() / rate**2, abs(rng.normal()) / rate, 1
        scene = plant, law, waves, u_0, slope, 0.0, x_r, v_r, d
        whole = kernel.trajectory.integrate(*scene, 0.0, h)
        # Only what begins at the start is summed by series.
        early = kernel.trajectory.integrate(*scene, 0.0, 0.3 * h)
        late = kernel.trajectory.integrate(*scene, 0.3 * h, h)
        between = kernel.trajectory.stretch(steps, u_0, slope, x_r, v_r, d, h)
        size = max(1.0, abs(slope) * h) ** 2 * h
        for i, per in enumerate((rate**4, rate**2, 1.0, rate)):
            assert (early[i] + late[i]) * per == pytest.approx(
                whole[i] * per, rel=1e-13, abs=1e-14 * size
            )
            assert between[i] * per == pytest.approx(
                whole[i] * per, rel=1e-13, abs=1e-14 * size
            )
