"""Integrals over stretches of sliding, and the rules of quadrature."""

from __future__ import annotations

import math

import numpy as np
import pytest
from segments import as_arrays, drawn_trajectory, sampled_solution

from drysim.core import trajectory

# Integrals over a stretch of sliding, by few nodes where it is short.


@pytest.mark.parametrize(
    ("c", "w"),
    [(0.0, 100.0), (6.7, 100.0), (20.0, 100.0), (90.0, 100.0), (0.0, 0.0), (9.0, 0.0)],
)
@pytest.mark.parametrize("radians", [0.05, 0.4, 0.9, 30.0])
def test_parts_of_a_stretch_have_the_integrals_of_the_whole(kernel, c, w, radians):
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
        moving = kernel.forcing.Scene(plant, kernel_law, waves, u_dd, h)
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


# Points at the samples of a motion between end stops, with any contact.


@pytest.mark.parametrize("seed", range(24))
def test_both_engines_write_the_same_points_and_no_velocity_at_rest(plain, fast, seed):
    drawn = drawn_trajectory(np.random.default_rng(seed), 150)
    solution = as_arrays(sampled_solution(drawn))
    count, written = len(solution.scene.u_dd), []
    for core in (plain, fast):
        x_r, v_r, *others = np.empty((6, count))
        points = core.model.Points(x_r, v_r, np.empty(count, np.int8), *others)
        core.trajectory.evaluate_samples(solution, (0, count), points)
        written.append(points)
    for one, other in zip(*written, strict=True):
        assert np.array_equal(one, other)
    assert not v_r[points.d == 0].any()
