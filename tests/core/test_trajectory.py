"""Passages and excursions counted from turn to turn, where the answer can be seen."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scenes import waves_of

from drysim.core import trajectory

# Passages and excursions counted from turn to turn, where the answer can be seen.


TURNS = [0.0, 3.0, -4.0, 1.0, -1.0, 5.0]
"""Displacements at the turns of a motion that goes on to 2 [m]."""


def test_passages_count_each_return_to_the_limit_on_either_side(
    kernel: SimpleNamespace,
) -> None:
    t, turns = np.arange(6.0), np.array(TURNS)
    count, limits = kernel.trajectory.extremes_and_crossings, kernel.model.StrokeLimits
    scene = (t, turns, 0.0, 2.0, 6.0)
    assert tuple(count(*scene, limits(2.5, 2.5))) == (-4.0, 5.0, 2, 3)
    assert tuple(count(*scene, limits(4.5, 4.5))) == (-4.0, 5.0, 2, 1)
    assert tuple(count(*scene, limits(2.5, 4.5))) == (-4.0, 5.0, 2, 2)
    back_and_forth = np.array([3.0, -3.0, 3.0])
    found = count(np.arange(3.0), back_and_forth, 3.0, 2.9, 3.0, limits(2.5, 2.5))
    assert tuple(found) == (-3.0, 3.0, 1, 2)


@pytest.mark.parametrize("repeats", [False, True])
def test_mass_that_never_comes_back_has_one_excursion_as_long_as_all(
    kernel: SimpleNamespace, repeats: bool
) -> None:
    law, plant = kernel.model.CoulombLaw(1.0, 1.0), kernel.model.Plant(1.0, 0.0, 0.0)
    waves = waves_of(kernel, [(1.0, 1.0, 0.0)], law)
    kernel_law = kernel.modes.coulomb_kernel_law(plant, law, np.zeros(2))
    scene = kernel.march.Scene(plant, kernel_law, waves, np.zeros(2), 7.0)
    code = kernel.modes.encode_mode(kernel.modes.mode_of(0, 0, 0, 0))
    still = kernel.events.Segments(*(np.full(1, x) for x in (0, 0.0, 0.3, 0.0, 0.0, code)))
    path = still.s, still.x_r
    scene = (kernel.trajectory.Solution(scene, still), path, 0.3, 7.0)
    find, limits = kernel.trajectory.excursions, kernel.model.StrokeLimits
    assert tuple(find(*scene, limits(0.2, 0.4), repeats)) == (1, 0, 0.0, 7.0)
    assert tuple(find(*scene, limits(0.4, 0.2), repeats)) == (0, 0, -1.0, 0.0)


# Integrals over a stretch of sliding, by few nodes where it is short.


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
    plant, law = kernel.model.Plant(1.0, w, c), kernel.model.CoulombLaw(f, f)
    waves = kernel.forcing.Waves(np.zeros(0), 0, 0)
    rng = np.random.Generator(np.random.PCG64(8))
    for _ in range(20):
        u_0, slope = rng.normal(), rng.normal() * rate
        x_r, v_r, d = rng.normal() / rate**2, abs(rng.normal()) / rate, 1
        u_dd = np.array([u_0, u_0 + slope * h])
        kernel_law = kernel.modes.coulomb_kernel_law(plant, law, u_dd)
        code = kernel.modes.encode_mode(kernel.modes.mode_of(d, d, 0, 0))
        moving = kernel.march.Scene(plant, kernel_law, waves, u_dd, h)
        part = kernel.trajectory.resume_mode(moving, (0, 0.0), (x_r, v_r, 0.0), code)
        scene = kernel_law, waves, part, 0.0
        whole = kernel.trajectory.integrate_motion(*scene, 0.0, h)
        early = kernel.trajectory.integrate_motion(*scene, 0.0, 0.3 * h)
        late = kernel.trajectory.integrate_motion(*scene, 0.3 * h, h)
        size = max(1.0, abs(slope) * h) ** 2 * h
        for i, per in enumerate((rate**4, rate**2, 1.0, rate)):
            assert (early[i] + late[i]) * per == pytest.approx(
                whole[i] * per, rel=1e-13, abs=1e-14 * size
            )


# Gauss and Legendre's rules are those of numpy, moved to a panel of length 1.


@pytest.mark.parametrize(("name", "points"), [("FOUR", 4), ("SIX", 6), ("TWELVE", 12)])
def test_rule_is_that_of_numpy(name, points):
    nodes, weights = np.polynomial.legendre.leggauss(points)
    np.testing.assert_allclose(
        getattr(trajectory, f"{name}_NODES"), 0.5 + 0.5 * nodes, rtol=1e-14
    )
    np.testing.assert_allclose(
        getattr(trajectory, f"{name}_WEIGHTS"), 0.5 * weights, rtol=1e-13
    )
