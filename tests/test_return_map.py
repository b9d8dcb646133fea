"""Return map of marched laws: against the closed form, its limits, and a second solver."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from seat import load_text

import drysim
from drysim.orbits.continuation import Continuation, Repetition
from drysim.orbits.return_map import closed_form_jacobian, event_counts
from drysim.study.branches import MarchedStudy, Study, prepare_branches

PAPER = """
drysim: 1
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45, static_ratio: 1.2}
excitation: {kind: harmonic, frequency: 0.5, rms: 0.5}
solver: {step: 2.5e-3}
sweep:
  friction.static_ratio: {from: 1, to: 1.5, step: 0.1}
"""

BUMPERS = """
drysim: 1
oscillator: {mass: 75, stiffness: 7500, damping: 60}
stroke: {limit: 25 mm, stops: {stiffness: 20 kN/m}}
excitation: {kind: harmonic, frequency: 2.1, rms: 0.6}
solver: {step: 2.5e-3, approach: viscous}
sweep:
  excitation.frequency: {from: 1.7, to: 2.6, count: 4}
"""
M, K_X, B, K_S, LIMIT = 75.0, 7500.0, 60.0, 20e3, 0.025

SHAKEN = """
drysim: 1
oscillator: {{mass: 75, stiffness: 7500, damping: 150}}
friction: {friction}
excitation: {{kind: harmonic, frequency: 2, rms: 1}}
solver: {{step: 2.5e-3}}
sweep:
  excitation.rms: [0.9, 1, 1.2]
"""


def shaken(folder: Path, friction: str, changes=()) -> drysim.Scenario:
    """Return a seat with a friction law."""
    return load_text(folder, SHAKEN.format(friction=friction), changes)


def orbit_from_rest(scenario: drysim.Scenario, p: float):
    """Return study, orbit and its fixed point, as marched from rest at a share of the range."""
    study = MarchedStudy(scenario, scenario.sweep[0])
    scene = study.scene(p)
    found = study.return_map.orbit(p, scene.starts[0])
    continuation = Continuation(study.return_map, study.is_symmetric)
    point = continuation.at_parameter(p, found.state, found.peak, Repetition(found.periods))
    return study, found, point


# Against the closed form of Coulomb friction


@pytest.mark.parametrize("repetition", [Repetition(), Repetition(1, True), Repetition(2)])
def test_image_and_jacobian_of_coulomb_friction_are_those_of_the_trajectory(
    tmp_path, repetition
):
    case = prepare_branches(load_text(tmp_path, PAPER, {"excitation.rms": 0.9}))
    exact = Study(case.scenario, case.scenario.sweep[0]).return_map
    marched = MarchedStudy(case.scenario, case.scenario.sweep[0]).return_map
    for p, state in ((0.0, [0.004, 0.001]), (0.4, [-0.002, 0.03]), (0.8, [0.003, -0.02])):
        one = exact(p, np.array(state), repetition)
        scene = marched.scene_from(p, repetition)
        end, trajectory = marched.march(scene, np.array(state), repetition)
        assert end == pytest.approx(one.state, abs=1e-13)
        assert event_counts(scene.law, trajectory) == one.counts
        scale = np.array([1.0, math.pi])
        off = closed_form_jacobian(trajectory, repetition) - one.jacobian
        assert np.abs(off * scale / scale[:, None]).max() < 1e-12


def test_fold_of_coulomb_friction_is_that_of_the_closed_form(tmp_path):
    text = PAPER.replace("{from: 1, to: 1.5, step: 0.1}", "{from: 1.34, to: 1.45, count: 3}")
    case = prepare_branches(load_text(tmp_path, text))
    (fold,) = (
        one
        for one in MarchedStudy(case.scenario, case.scenario.sweep[0]).solve(case).bifurcations
        if one.kind == "fold"
    )
    assert fold.value == pytest.approx(1.380717757, abs=1e-6)


# Limits of other laws


def test_a_very_stiff_elastic_contact_tends_to_coulomb_friction(tmp_path):
    rigid = shaken(tmp_path, "{law: coulomb, kinetic: 45}")
    expected = orbit_from_rest(rigid, 0.0)[2].image.peak
    off = []
    for k_t in (1e6, 1e7, 1e8):
        soft = shaken(tmp_path, f"{{law: jenkins, kinetic: 45, tangential_stiffness: {k_t:g}}}")
        off.append(abs(orbit_from_rest(soft, 0.0)[2].image.peak / expected - 1.0))
    # A reversal without a stop takes a time of the order of sqrt(m/k_t).
    assert off[0] / off[1] == pytest.approx(math.sqrt(10.0), rel=1e-2)
    assert off[1] / off[2] == pytest.approx(math.sqrt(10.0), rel=1e-2)


@pytest.mark.parametrize(
    ("friction", "size"),
    [
        ("{law: jenkins, kinetic: 45, tangential_stiffness: 20000}", 3),
        pytest.param(
            "{law: stribeck, kinetic: 45, static: 54, stribeck_velocity: 0.05}",
            2,
            marks=pytest.mark.slow,
        ),
        ("{law: dahl, kinetic: 45, bristle_stiffness: 50000}", 3),
        ("{law: coulomb, kinetic: {extension: 30, compression: 45}}", 2),
        ("{law: coulomb, kinetic: 45, normal_variation: {amplitude: 0.3, frequency: 4}}", 2),
    ],
)
def test_a_marched_orbit_is_a_fixed_point_whose_jacobian_predicts_its_neighbours(
    tmp_path, friction, size
):
    study, found, point = orbit_from_rest(shaken(tmp_path, friction), 0.5)
    assert point.state.shape == (size,)
    assert point.state == pytest.approx(found.state, abs=1e-9 * found.peak)
    assert Continuation(study.return_map, study.is_symmetric).residual(point) < 1e-9
    beside = point.state.copy()
    beside[0] += 1e-4 * found.peak
    image = study.return_map(0.5, beside, Repetition(found.periods))
    change = image.state[:2] - point.image.state[:2]
    predicted = (point.image.jacobian @ (beside - point.state))[:2]
    speed = study.return_map.speed(0.5)
    assert np.abs((change - predicted) / [1.0, speed]).max() < 1e-7 * found.peak
    assert (np.abs(point.multipliers) < 1.0).all()
    by_differences = "stribeck" in friction or "dahl" in friction
    assert (point.image.jacobian_error > 0.0) == by_differences


def test_an_elastic_contact_that_never_yields_leaves_its_neutral_multiplier_out(tmp_path):
    stiff = shaken(tmp_path, "{law: jenkins, kinetic: 1000, tangential_stiffness: 20000}")
    _, found, point = orbit_from_rest(stiff, 0.5)
    # The linear oscillator with both springs.
    decay = math.exp(-150 / (2 * 75) * 0.5)
    assert sorted(np.abs(point.multipliers)) == pytest.approx([0.0, decay, decay], abs=1e-7)
    assert found.state[0] == pytest.approx(found.state[2], rel=1e-12)


# A linear spring with bumpers: the resonance bends over.


def bumper_peak(frequency: float, start, rtol: float) -> float:
    """Return the largest |x_r| of the motion that a start settles on, by another solver."""
    from scipy.integrate import solve_ivp

    omega = math.tau * frequency
    A = 0.6 * math.sqrt(2.0)

    def rate(t, y):
        depth = max(abs(y[0]) - LIMIT, 0.0)
        force = K_X * y[0] + B * y[1] + math.copysign(K_S * depth, y[0])
        return y[1], -A * math.sin(omega * t) - force / M

    def turn(t, y):
        return y[1]

    def touch(t, y):
        return abs(y[0]) - LIMIT

    settle = 60.0 / frequency
    ends = (0.0, settle), (settle, settle + 1.0 / frequency)
    y, size = start, 0.0
    for span in ends:
        found = solve_ivp(
            rate, span, y, "DOP853", rtol=rtol, atol=rtol * 1e-3, events=(turn, touch),
            max_step=0.05 / frequency,
        )  # fmt: skip
        y, size = found.y[:, -1], float(np.abs(found.y_events[0][:, 0]).max())
    return size


@pytest.fixture(scope="module")
def bumpers(tmp_path_factory):
    """Return the branches of the seat with bumpers."""
    return drysim.branches(load_text(tmp_path_factory.mktemp("bumpers"), BUMPERS))


def test_bumpers_bend_the_resonance_over_between_two_folds(bumpers):
    (branch,) = bumpers.branches
    folds = [one.value for one in bumpers.bifurcations if one.kind == "fold"]
    assert len(folds) == 2
    assert folds[0] < bumpers.stated_value < folds[1]
    assert [one.stable for one in bumpers.motions] == [True, True, False]
    assert branch.ends == ("range", "range")
    assert bumpers.residual < 1e-9
    assert not branch.multiplier_error.any()
    # Liouville: the damper alone contracts.
    product = np.abs(branch.multipliers).prod(axis=1)
    assert product == pytest.approx(np.exp(-B / M / branch.values), rel=1e-9)


def test_stable_motions_between_bumpers_are_those_of_another_solver(bumpers):
    low, high = sorted(one.x_r_peak for one in bumpers.motions if one.stable)
    middle = next(one.x_r_peak for one in bumpers.motions if not one.stable)
    assert low < middle < high
    assert low < LIMIT < middle
    for expected, start in ((low, (0.0, 0.0)), (high, (0.0, -high * math.tau * 2.1))):
        coarse, fine = (bumper_peak(2.1, start, rtol) for rtol in (2e-9, 1e-9))
        settled = abs(fine / expected - 1.0)
        assert settled < max(1e-4, 10.0 * abs(fine / coarse - 1.0))


# What is refused


@pytest.mark.parametrize(
    ("friction", "changes", "words"),
    [
        (
            "{law: coulomb, kinetic: 45, normal_variation: {amplitude: 0.3, frequency: 2}}",
            {"sweep": {"excitation.frequency": [1, 2]}},
            "no common period",
        ),
        ("{law: coulomb, kinetic: 45}", {"solver.approach": "switch"}, "an exact approach"),
        (
            "{law: leuven, kinetic: 30, static: 45, stribeck_velocity: 0.02,"
            " bristle_stiffness: 1e5, bristle_damping: 300}",
            {},
            "does not support the Leuven law",
        ),
        ("{law: coulomb, kinetic: 45}", {"sweep": {"stroke.limit": [0.1, 0.2]}}, "stroke"),
    ],
)
def test_what_cannot_be_followed_is_refused_with_the_reason(tmp_path, friction, changes, words):
    with pytest.raises(drysim.ScenarioError) as fault:
        drysim.branches(shaken(tmp_path, friction, changes))
    assert words in str(fault.value) + str(fault.value.problems)
