"""Scenes that once were solved worse than they are now, each under its own name."""

from __future__ import annotations

import math

import pytest
from drawn import Scene
from taylor import solve

from drysim.metrics.table import measure


def test_block_that_creeps_far_from_the_middle_loses_no_friction_energy():
    # The way was the difference of two places ten metres off.
    scene = Scene(1.0, 0.0, 0.0, 0.3, 0.3, x_r=10.0, v_r=0.001, u_dd=(0.0, 0.0), dt=0.001)
    metrics = measure(scene.trajectory(), (0.0, scene.end), None)
    assert metrics["energy_friction"] == pytest.approx(0.3 * (1e-6 - 0.15e-6), rel=1e-14)
    assert metrics["energy_residual"] < 1e-14


@pytest.mark.parametrize("share", [1.0, 0.1, 1e-2, 1e-3])
def test_acceleration_that_spring_and_friction_all_but_cancel_is_exact(share):
    # x_dd² was a quadratic form in spring and friction force, 1e3 to 1e6 times x_dd, so it was
    # 15 % off or below zero. What is left is the rounding of F_fk/k_x.
    m, k_x, F = 11616.7, 2.2066e10, 0.6254
    u_dd = tuple(share * value for value in (1e-8, 2e-8, 3e-8, 2e-8, 1e-8, 3e-8))
    scene = Scene(m, k_x, 2756.0 * m, F, F, F / k_x, -1e-20 * share, u_dd=u_dd, dt=3.8e-9)
    exact, trajectory = solve(scene), scene.trajectory()
    true = math.sqrt(float(exact.integrals["x_dd2"]) / scene.end)
    assert len(trajectory.events.t) == len(exact.events) + 1
    assert measure(trajectory, (0.0, scene.end), None)["a_x"] == pytest.approx(true, rel=1e-5)


def test_balance_of_energies_below_the_least_normal_number_is_closed():
    # Squares of 1e-157 keep few digits, so the balance left 1.7e-10 of next to nothing.
    scene = Scene(1.0, 1.0, 2.0, 0.0, 0.0, u_dd=(0.0, 7.415683190862855e-157), dt=1.25)
    metrics = measure(scene.trajectory(), (0.0, scene.end), None)
    assert 0.0 < metrics["energy_input"] < 1e-300
    assert metrics["energy_residual"] < 1e-14
