"""drysim against a solution in 50 digits that shares no line and no formula with it."""

from __future__ import annotations

import math
import random
from itertools import pairwise
from pathlib import Path

import mpmath as mp
import pytest
from against import AGREES, distance, unexplained
from drawn import Scene, scenes
from hypothesis import HealthCheck, Phase, given, settings
from taylor import DIGITS, solve

import drysim
from drysim.core.model import Samples
from drysim.metrics.table import measure
from drysim.study.preparation import prepare

HARD = Path(__file__).parents[2] / "scenarios" / "hard"

QUICK = {
    "around-critical-damping": {},
    "around-critical-damping at ζ = 1 + 1e-8": {"oscillator.damping_ratio": 1.00000001},
    "flat-tops-on-the-limit": {},
    "huge-motion": {},
    "many-stops-a-half-cycle": {},
    "spring-of-five-radians-a-step": {},
    "spring-or-damper-missing": {},
    "spring-or-damper-missing but a spring": {"oscillator.stiffness": 7500},
    "static-above-kinetic": {},
    "static-above-kinetic by 1e-7": {"friction.static_ratio": 1.0000001},
    "tiny-motion": {},
    "two-turns-in-one-step": {},
}
LONG = {
    "coarsely-quantised-record": {},
    "around-critical-damping at ζ = 50": {"oscillator.damping_ratio": 50},
    "edge-of-the-stuck-zone": {"start.x_r": "2.000001 mm"},
    "limit-just-exceeded": {},
    "resonance-that-grows": {},
    "spring-of-fifty-radians-a-step": {},
}
RADIANS, FAST = 60.0, 12


def scene_of(name: str, overrides: dict[str, object]) -> Scene:
    """Return a hard case in plain numbers, from its start to the end of its window."""
    case = prepare(drysim.load(HARD / f"{name.split()[0]}.yaml", overrides))
    numbers = (*case.plant, case.law.F_fk, case.law.F_fs, *case.start)
    if isinstance(case.motion, Samples):
        count = round(case.window[1] / case.motion.dt) + 1
        u_dd = tuple(case.motion.u_dd[:count].tolist())
        return Scene(*numbers, u_dd=u_dd, dt=case.motion.dt)
    return Scene(*numbers, sines=tuple(zip(*case.motion, strict=True)), duration=case.window[1])


def visible(scene: Scene) -> Scene:
    """Round phases and samples to 15 places.

    Of a base whose ü changes its sign within 1e-38 of a stretch, 50 digits do not see it.
    """
    sines = tuple((A, f, round(phase, 15)) for A, f, phase in scene.sines)
    scale = max(map(abs, scene.u_dd), default=0.0) or 1.0
    u_dd = tuple(scale * round(each / scale, 15) for each in scene.u_dd)
    return scene._replace(sines=sines, u_dd=u_dd)


def agree_on_drawn_scenes(examples: int, **chosen: bool) -> None:
    """Draw scenes and hold drysim against 50 digits."""

    @settings(
        max_examples=examples,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
        phases=(Phase.generate,),  # to shrink a scene would take hours
        **chosen,
    )
    @given(scenes(radians=RADIANS))
    def tried(scene: Scene) -> None:
        scene = visible(scene)
        if scene.F_fs > 0.0:
            assert unexplained(scene, scene.trajectory()) <= AGREES

    tried()


def test_fifty_digits_know_the_free_decay_in_closed_form() -> None:
    scene = Scene(1.0, 1.0, 0.0, 1.0, 1.0, 12.0, 6.0, duration=25.0)
    found = solve(scene)
    with mp.workdps(DIGITS):
        turns = [abs(x) for _, _, x in found.events[:7]]
        assert max(abs(a - b - 2) for a, b in pairwise(turns)) < 1e-45
    assert [kind for _, kind, _ in found.events] == [-2, 2, -2, 2, -2, 2, -2, 0]
    assert float(found.events[-1][0]) == pytest.approx(22.42355635, abs=5e-9)
    assert float(found.integrals["stuck"]) == pytest.approx(25 - 22.42355635, abs=5e-9)


@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in LONG)]
)
def test_hard_case_agrees_with_fifty_digits(name):
    scene = scene_of(name, (QUICK | LONG)[name])
    assert unexplained(scene, scene.trajectory()) <= AGREES


@pytest.mark.parametrize("sampled", [False, True])
def test_friction_that_varies_agrees_with_fifty_digits(sampled):
    sines = ((1.4, 1.1, 0.4), (0.9, 3.7, 1.0))
    scene = Scene(75.0, 7500.0, 500.0, 30.0, 40.0, variation=(0.5, 3.1, 0.3))
    if sampled:
        u_dd = tuple(1.5 * math.sin(0.8 * n) for n in range(40))
        scene = scene._replace(u_dd=u_dd, dt=0.05)
    else:
        scene = scene._replace(sines=sines, duration=2.0)
    assert unexplained(scene, scene.trajectory()) <= AGREES


@pytest.mark.parametrize("name", ["m", "k_x", "b", "F_fk", "F_fs"])
def test_rounding_explains_no_other_scene(name):
    scene = Scene(75.0, 7500.0, 500.0, 30.0, 40.0, sines=((1.4, 1.1, 0.4),), duration=2.0)
    other = scene._replace(**{name: (1.0 + 1e-7) * getattr(scene, name)})
    assert unexplained(scene, other.trajectory()) > AGREES


@pytest.mark.parametrize("sampled", [False, True])
def test_motion_that_begins_with_nothing_but_a_jerk_agrees_with_fifty_digits(sampled):
    """At rest in the middle, with ü = 0 and next to no friction, x_r grows as s³."""
    rng = random.Random(7)
    for _ in range(12):
        m, omega, A = (10 ** rng.uniform(*ends) for ends in ((-3, 3), (-1, 2), (-3, 3)))
        b = 2.0 * rng.choice((0.0, 0.1, 2.0)) * m * omega
        F = rng.choice((5e-324, 1e-310, 1e-300, 1e-16 * m * A))
        span = 10 ** rng.uniform(-2.5, 0.3) / omega
        F_fs, x_r = F * rng.choice((1.0, 2.0)), rng.choice((0.0, F / m))
        scene = Scene(m, m * omega**2, b, F, F_fs, x_r)
        if sampled:
            scene = scene._replace(u_dd=(0.0, A), dt=span)
        else:
            scene = scene._replace(sines=((A, 0.3 * omega, 0.0),), duration=span)
        assert distance(solve(scene), scene.trajectory(), scene.end) <= AGREES


def test_motion_whose_velocity_underflows_at_first_turns_only_once():
    """Where ü changes its sign within 1e-100 s, it moves as if it had started there."""
    rng = random.Random(11)
    for _ in range(200):
        t = 10 ** rng.uniform(-305, -100)
        m, omega, A = (10 ** rng.uniform(*ends) for ends in ((-3, 3), (-1, 2), (-2, 2)))
        F = m * A * omega * t * 10 ** rng.uniform(-12, 0.5)
        b, k_x = (rng.choice((0.0, 1.0)) * m * omega**power for power in (1, 2))
        motion = ((A, omega / math.tau, -omega * t),)
        scene = Scene(m, k_x, b, F, 1.8 * F, sines=motion, duration=1.0 / omega)
        from_zero = scene._replace(sines=((*motion[0][:2], 0.0),))
        assert distance(solve(from_zero), from_zero.trajectory(), scene.end) <= AGREES
        trajectory = scene.trajectory()
        assert trajectory.state(scene.end) == pytest.approx(
            from_zero.trajectory().state(scene.end), rel=AGREES
        )
        assert len(trajectory.events) <= 3


def test_drawn_scene_agrees_with_fifty_digits():
    agree_on_drawn_scenes(FAST, derandomize=True)


@pytest.mark.slow
@pytest.mark.parametrize("examples", [100, pytest.param(4000, marks=pytest.mark.by_hand)])
def test_many_more_drawn_scenes_agree_with_fifty_digits(examples):
    agree_on_drawn_scenes(examples)


# Scenes that once were solved worse than they are now.


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
