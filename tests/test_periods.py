"""A steady motion repeats after its true period, and states how far it is from its orbit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from law_scenes import PAPER, sine
from periods import KINDS, changes_after, draw_steady_scene, true_period

from drysim.approach.solution import Orbit
from drysim.core.model import AnyState, CoulombLaw, PiecewiseLaw, State
from drysim.orbits import coulomb
from drysim.orbits.return_map import PeriodicSystem
from drysim.orbits.search import (
    OrbitConvergence,
    find_orbit,
    fixed_point_distance,
    march_period,
    shortest_repetition,
)
from drysim.study.branches import branches
from drysim.study.run import closure_by_period

REPEATS = 1e-8
"""Scaled change that is no motion of its own [-]: what remains after a long march is below
1e-11, and what distinguishes the periods of a drawn subharmonic above 1e-5."""

SWINGS = {
    "lift-off": (4,),
    "friction by direction": (2, 6, 37),
    "damper by direction": (17, 43),
    "dahl": (9, 19, 47),
    "leuven": (16, 29, 50, 57),
    "petrov": (1, 11, 59),
    "one bumper": (8, 53),
}
"""Drawn scenes that swing about their orbit: a motion of one period is within the tolerance of
itself two to four periods earlier before it is of itself one period earlier."""


def orbit_of(kind: str, seed: int) -> tuple[PeriodicSystem, Orbit]:
    scene, start = draw_steady_scene(kind, seed)
    return scene, find_orbit(scene.plant, scene.law, scene.motion, start, scene.period)


def assert_true_period(kind: str, seed: int, marched: int) -> None:
    """Assert that an orbit repeats after no fewer periods than stated, by a long march."""
    scene, orbit = orbit_of(kind, seed)
    if orbit.settled:
        found = true_period(changes_after(scene, orbit.state, marched, orbit.periods), REPEATS)
        assert (kind, seed, orbit.periods) == (kind, seed, found)


@pytest.mark.parametrize("kind", KINDS)
def test_steady_motion_repeats_after_its_least_period(kind):
    for seed in {*range(3), *SWINGS.get(kind, ())}:
        assert_true_period(kind, seed, 100)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_every_drawn_steady_motion_repeats_after_its_least_period(kind):
    for seed in range(150):
        assert_true_period(kind, seed, 150)


@pytest.mark.parametrize("turn", [1 / 2, 1 / 3, 1 / 4, 2 / 5])
@pytest.mark.parametrize("modulus", [0.3, 0.765, 0.99, 0.9995])
def test_motion_that_swings_in_on_its_orbit_has_the_period_of_its_base(modulus, turn):
    multiplier = modulus * np.exp(2j * np.pi * turn)
    for size in np.geomspace(1e-9, 1e-14, 60):
        before = size * multiplier ** -np.arange(9.0)
        changes = np.abs(before[1:] - before[0])
        assert shortest_repetition(changes, 1e-12) in (0, 1)


@pytest.mark.parametrize("apart", [1.0, 1e-3, 1e-6])
@pytest.mark.parametrize("periods", [2, 3, 4, 6])
def test_motion_that_settles_on_several_periods_has_them(periods, apart):
    changes = np.full(8, apart)
    changes[periods - 1 :: periods] = 1e-12
    assert shortest_repetition(changes, 1e-12) == periods


def test_fixed_step_orbit_is_not_longer_because_it_swings():
    changes = closure_by_period(1.0 + 1e-9 * (-0.76) ** np.arange(9.0), 1, 8)
    assert changes[1] < 1e-10 < changes[0]
    assert shortest_repetition(changes, 1e-10) == 1


# The kernel of Coulomb friction follows the same rule.


@pytest.mark.parametrize(("change", "periods"), [(1e-13, True), (1e-6, False)])
def test_repetition_under_coulomb_friction_is_distinct_only_from_what_changes_more(
    change, periods
):
    from drysim.core import orbit

    past = coulomb.period_buffers()
    past.x_r[0], past.x_r[1] = 1.0 + change, 1.01
    state = orbit.PeriodState(1.0, 0.0, 0)
    assert orbit.is_distinct(past, 2, state, 1.0, 2, change) == periods


# Distance to the orbit.


def deviation(scene: PeriodicSystem, orbit: Orbit, repetitions: int) -> float:
    """Return the scaled distance of an orbit from where a long march leads."""
    state: AnyState = orbit.state
    length = orbit.periods * scene.period
    for _ in range(repetitions):
        trajectory = march_period(scene.plant, scene.law, scene.motion, state, length)
        state = trajectory.state(length)
    speed = max(abs(trajectory.state(at).v_r) for at in np.linspace(0.0, length, 60).tolist())
    peak = max(float(np.abs(trajectory.path.x_r).max()), abs(state.x_r))
    off = np.abs(np.array(state[:2]) - np.array(orbit.state[:2]))
    return float((off / (peak or 1.0, speed or 1.0)).max())


@pytest.mark.parametrize("kind", KINDS)
def test_distance_to_the_orbit_covers_how_far_a_long_march_still_goes(kind):
    for seed in range(3):
        scene, orbit = orbit_of(kind, seed)
        if orbit.settled:
            assert deviation(scene, orbit, 80) <= 3.0 * orbit.distance
            assert orbit.distance < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_distance_covers_how_far_every_drawn_motion_still_goes(kind):
    for seed in range(60):
        scene, orbit = orbit_of(kind, seed)
        if orbit.settled:
            assert deviation(scene, orbit, 120) <= 3.0 * orbit.distance


def test_distance_beside_a_multiplier_near_1_covers_what_the_closure_does_not():
    """Just below the fold of the paper's oscillator; a start beside the orbit approaches it."""
    ratio, F_fk, motion = 1.3807, 45.0, sine(0.5, 0.5)
    forces = F_fk, ratio * F_fk
    marched = PiecewiseLaw(*forces, compression=forces)
    start = State(0.0016, 0.002)
    exact = coulomb.find_coulomb_orbit(PAPER, CoulombLaw(*forces), motion, start, 2.0)
    found = find_orbit(PAPER, marched, motion, start, 2.0)
    scene = PeriodicSystem(PAPER, marched, motion, 2.0)
    assert (exact.settled, found.settled) == (True, True)
    peak = float(np.abs(march_period(*scene[:3], exact.state, 2.0).path.x_r).max())
    off = abs(found.state.x_r - exact.state.x_r) / peak
    assert off > 10.0 * found.closure
    assert off <= found.distance


@pytest.mark.parametrize("multiplier", [0.5, -0.9, 0.999])
def test_distance_is_the_sum_of_all_changes_to_come(multiplier):
    M, gap = np.diag([multiplier, 0.1]), np.array([1e-9, 0.0])
    expected = 1e-9 / (1.0 - multiplier)
    assert fixed_point_distance(M, gap, 0.0) == pytest.approx(expected, rel=1e-12)
    convergence, law = OrbitConvergence(1e-12), PiecewiseLaw(1.0, 1.0)
    for n in range(20):
        convergence.add(State(1.0 + 1e-6 * multiplier**n, 0.0), [1.0, 1.0])
    left = 1e-6 * abs(multiplier) ** 19
    distance, last = convergence.observed_distance(1, law), left * (1.0 / abs(multiplier) + 1.0)
    assert left <= distance <= 1.1 * last / (1.0 - abs(multiplier))


def test_motion_that_is_not_attracted_has_no_distance():
    assert math.isinf(fixed_point_distance(np.eye(2), np.zeros(2), 1e-15))
    assert math.isinf(fixed_point_distance(np.full((2, 2), np.nan), np.zeros(2), 1e-15))


SWINGING = """\
oscillator: {mass: 75, stiffness: 7500, damping: {extension: 75, compression: 60.3}}
friction: {law: coulomb, kinetic: {extension: 10.16, compression: 7.64}, static_ratio: 1.2}
excitation: {kind: harmonic, frequency: 3.17, amplitude: 1.35}
solver: {step: 1.5e-3}
sweep: {friction.static_ratio: {from: 1.2, to: 1.5, count: 13}}
"""


def test_branches_of_a_motion_that_swings_are_one_stable_branch(scenario):
    (branch,) = branches(scenario(SWINGING)).branches
    assert branch.periods == 1
    assert branch.stable.all()
    assert branch.multipliers[0].imag.tolist() == [0.0, 0.0]
    # By an integrator of high order with events, and central differences.
    expected = pytest.approx([-0.76551403, -0.75157517], abs=1e-7)
    assert sorted(branch.multipliers[0].real) == expected


# A scene that begins later, and as a row of numbers.


def forcing(scene: PeriodicSystem, t: np.ndarray) -> np.ndarray:
    """Return ü [m/s²] and the relative normal force [-] at some times [s]."""
    u_dd = sum(
        A * np.sin(math.tau * f * t + phase) for A, f, phase in zip(*scene.motion, strict=True)
    )
    law = scene.law
    load = law.variation and law.variation * np.sin(law.omega * t + law.phase)
    return np.array([u_dd, load + np.zeros_like(t)])


@pytest.mark.parametrize("kind", KINDS)
def test_a_delay_of_whole_periods_changes_nothing_and_of_a_part_shifts_the_forcing(kind):
    for seed in range(8):
        scene = draw_steady_scene(kind, seed).scene
        assert scene.delayed(3.0) == scene
        share = float(np.random.default_rng(seed).uniform(-2.0, 2.0))
        t = np.linspace(0.0, scene.period, 9)
        later = forcing(scene, t + share * scene.period)
        size = sum(scene.motion.A) + scene.law.variation
        assert np.abs(forcing(scene.delayed(share), t) - later).max() < 1e-13 * size


@pytest.mark.parametrize("kind", ["coulomb", "load"])
def test_a_row_of_numbers_is_the_scene_it_was_made_of(kind):
    for seed in range(8):
        scene, start = draw_steady_scene(kind, seed)
        row = coulomb.scene_row(scene.plant, scene.law, scene.motion, start, scene.period)
        assert PeriodicSystem.from_row(row) == scene
