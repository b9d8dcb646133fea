"""Every law holds for every scene that hypothesis draws."""

from __future__ import annotations

import contextlib
import math
import random

import pytest
from drawn import Scene, scenes
from hypothesis import HealthCheck, given, settings
from laws import LAWS, Law, energy_closes, finer_grid_changes_no_metric

from drysim.errors import SolverError

FAST, MANY = 40, 1000
"""Examples of a law in `make test`, which are always the same, and in `make slow`."""


def hold(law: Law, examples: int, **chosen: bool) -> None:
    """Try a law on so many scenes; a scene that ends in a statement is none."""

    @settings(
        max_examples=examples,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
        **chosen,
    )
    @given(scenes())
    def tried(scene: Scene) -> None:
        with contextlib.suppress(SolverError):
            law(scene)

    tried()


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
@pytest.mark.parametrize("examples", [FAST, pytest.param(MANY, marks=pytest.mark.slow)])
def test_law_holds_for_any_scene(law, examples):
    hold(law, examples, derandomize=examples == FAST)


def test_finer_grid_changes_no_metric_where_the_velocity_only_touches_zero():
    ramp = {"sines": (), "u_dd": (0.0, 10.0**0.5), "dt": 50.0, "variation": (0.0, 0.0, 0.0)}
    F = 0.3 * 10.0**0.5
    finer_grid_changes_no_metric(Scene(1.0, 1.0, 0.0, F, F, 0.0, 0.0, **ramp))


@pytest.mark.parametrize("b", [5e-324, 1e-323, 1e-315, 1e-310, 3e-308, 1e-290])
@pytest.mark.parametrize("k_x", [0.0, 5e-324, 1e-310])
def test_energy_closes_beside_a_damper_or_spring_near_underflow(b, k_x):
    base = {"sines": (), "u_dd": (0.0, 0.0), "dt": 5.0, "variation": (0.0, 0.0, 0.0)}
    for F in (0.0, 0.3):
        energy_closes(Scene(1.0, k_x, b, F, F, 0.0, 1.0, **base))


def test_motion_under_tiny_forces_and_sines_that_cancel_is_finite_with_few_events():
    """Sizes down to the end of double precision, phases as close to a zero of their sine."""
    rng = random.Random(3)

    def size() -> float:
        return rng.choice((1.0, 10 ** -rng.uniform(0, 300)))

    for _ in range(300):
        omega, A = 10 ** rng.uniform(-1, 2), size()
        F = A * size()
        k_x, b = (rng.choice((0.0, 1.0)) * omega**power for power in (2, 1))
        phases = [rng.choice((0.0, 1.0, -1.0, math.pi)) * size() for _ in range(2)]
        phases[1] = rng.choice((phases[1], -phases[0]))
        sines = tuple((A, omega * rng.uniform(0.01, 1), phase) for phase in phases)
        scene = Scene(1.0, k_x, b, F, F * rng.choice((1.0, 1.8, 1e6)), sines=sines)
        scene = scene._replace(duration=20.0 / omega)
        trajectory = scene.trajectory()
        assert all(map(math.isfinite, trajectory.state(scene.end)))
        assert len(trajectory.events) < 200
