"""Integrals of a motion over samples: sums over runs of steps against quadrature of all."""

from __future__ import annotations

import numpy as np
import pytest
from segments import as_arrays, drawn_trajectory, every_segment, sampled_solution

from drysim.approach.stick_slip import StickSlip
from drysim.core import measure
from drysim.core.measure import PRODUCTS, SUMS
from drysim.core.model import CoulombLaw, Plant, Samples, State
from drysim.core.trajectory import integrate_segments


def compare_with_quadrature(rng: np.random.Generator, samples: int) -> None:
    """Measure a drawn motion in drawn windows both ways."""
    trajectory = drawn_trajectory(rng, samples)
    solution, count, dt = sampled_solution(trajectory), samples - 1, trajectory.motion.dt
    ends = rng.uniform(0.0, trajectory.end, 2), dt * rng.integers(0, samples, 2)
    whole, _ = integrate_segments(every_segment(solution), 0.0, trajectory.end, 0.0)
    for begin, end in ((0.0, trajectory.end), *(np.sort(window).tolist() for window in ends)):
        steps = min(int(begin / dt), count - 1), min(int(np.ceil(end / dt)), count)
        sums, peak = measure.measure(solution, steps, (begin, end))
        expected, highest = integrate_segments(every_segment(solution), begin, end, 0.0)
        # What is left of a motion that dies out has the rounding of all of it.
        for one, other, total in zip(sums, expected, whole, strict=True):
            assert abs(one - other) <= 1e-12 * abs(other) + 1e-13 * abs(total) + 1e-18
        assert peak == pytest.approx(highest, rel=1e-13)


@pytest.mark.parametrize("seed", range(24))
def test_sums_over_runs_are_the_quadrature_of_all_segments(seed):
    compare_with_quadrature(np.random.default_rng(seed), 150)


# In 592 stops and break-aways lie in steps of more than a tenth of a radian.
@pytest.mark.parametrize(
    "seed", [592, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(100, 600))]
)
def test_sums_over_runs_are_the_quadrature_of_all_segments_of_long_motions(seed):
    compare_with_quadrature(np.random.default_rng(seed), 1500)


@pytest.mark.parametrize("seed", range(24))
def test_numpy_and_the_kernel_sum_the_same(plain, fast, seed):
    samples = 150
    drawn = drawn_trajectory(np.random.default_rng(seed), samples)
    solution = as_arrays(sampled_solution(drawn))
    steps, window = (0, samples - 1), (0.0, (samples - 1) * solution.scene.dt)
    by_numpy, by_kernel = (
        core.measure.measure(solution, steps, window) for core in (plain, fast)
    )
    assert by_numpy[0] == pytest.approx(by_kernel[0], rel=1e-12, abs=1e-18)
    assert by_numpy[1] == pytest.approx(by_kernel[1], rel=1e-12)


def test_a_wrong_state_at_one_sample_changes_the_sums():
    rng = np.random.default_rng(1)
    u_dd, plant = rng.standard_normal(150), Plant(5.0, 2000.0, 20.0)
    trajectory = StickSlip().trajectory(
        plant, CoulombLaw(0.5, 0.5), Samples(u_dd, 2e-3), State(0.01, 0.0)
    )
    solution = sampled_solution(trajectory)
    window = 0.0, trajectory.end
    before, _ = measure.measure(solution, (0, 149), window)
    # Next to the end of a step, so that only sums over runs read it.
    inside = np.flatnonzero(np.diff(solution.rows.n) > 4)[0]
    solution.samples.v_r[int(solution.rows.n[inside]) + 2] *= 1.001
    after, _ = measure.measure(solution, (0, 149), window)
    assert after.v2 != pytest.approx(before.v2, rel=1e-7)


def test_only_the_products_that_are_summed_are_needed():
    """A scene in which every variable of a step differs gives the integrals of its flow."""
    c, w, dt = 3.0, 400.0, 0.01
    forms = np.empty((4, SUMS))
    measure.step_forms(c, w, dt, forms)
    squares, distance = forms[:, :PRODUCTS], forms[0, PRODUCTS:]
    rng = np.random.default_rng(5)
    x_r, v_r, f, u_0, u_1 = rng.standard_normal(5)
    forces = measure.RunForces(1.0, 0.0, 0.0, c, w, 0.0, f, 1.0)
    variables = np.array(measure.step_variables(forces, x_r, v_r, u_0, u_1))
    nodes, weights = np.polynomial.legendre.leggauss(20)
    s, weights = 0.5 * dt * (nodes + 1.0), 0.5 * dt * weights
    y, y_d, Y, YY = np.array([measure.flow(c, w, at) for at in s]).T
    p, r = -u_0 - f - w * x_r, (u_0 - u_1) / dt
    x, v = x_r + v_r * y + p * Y + r * YY, v_r * y_d + p * y + r * Y
    u, x_dd = u_0 - r * s, -(c * v + w * x + f)
    expected = [weights @ product for product in (x * x, v * v, x_dd * x_dd, u * v)]
    products = variables[list(measure.FIRST)] * variables[list(measure.SECOND)]
    assert squares @ products == pytest.approx(expected, rel=1e-12)
    assert distance @ variables[1:4] == pytest.approx(weights @ v, rel=1e-12)
