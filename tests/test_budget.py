"""Work out of proportion is told before it is done, and what nobody waits for is refused."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from hang import no_hang
from seat import SEAT

import drysim
from drysim.approach.cost import step_cost
from drysim.approach.fixed_step import Switch
from drysim.core.compile import MAX_PLAIN_STEPS
from drysim.errors import ScenarioError
from drysim.scenario.fit import Fit
from drysim.study import sweep
from drysim.study.budget import case_cost
from drysim.study.preparation import prepare

NOISE = {"kind": "psd", "points": [["0.5 Hz", 1], ["10 Hz", 1]], "duration": 0.1, "seed": 1}


@pytest.fixture
def prepared(scenario):
    """Return a case of the seat with some keys changed."""
    return lambda **keys: prepare(scenario(SEAT, **keys))


def slow(case):
    """Return the sentences about slow scenes."""
    return [caution.sentence for caution in case.warnings if caution.slug == "slow-scene"]


def test_easy_scene_is_not_called_slow(prepared):
    assert slow(prepared()) == []
    assert slow(prepared(excitation__frequency=500)) == []


DAMPED = {
    "oscillator__damping": 1e8,
    "friction": {"law": "dahl", "kinetic": 15, "bristle_stiffness": 1e5},
}


@pytest.mark.parametrize(
    ("overrides", "what"),
    [
        (DAMPED, "one step spans 3333 damping time constants;"),
        ({"excitation__frequency": 1e6}, "one step spans 15708 rad of the base motion;"),
        ({"oscillator__stiffness": 1e14}, "one step spans 2887 rad of the oscillator;"),
        (
            {"friction__normal_variation": {"amplitude": 0.5, "frequency": 1e5}},
            "one step spans 1571 rad of the normal force;",
        ),
        (
            {"friction": {"law": "dahl", "kinetic": 15, "bristle_stiffness": 1e14}},
            "one step spans 2887 rad of the oscillation on the bristles;",
        ),
        (
            {
                "friction": {
                    "law": "lugre", "kinetic": 15, "bristle_stiffness": 1e5,
                    "bristle_damping": 1e9, "stribeck_velocity": 0.01,
                }
            },
            "one step spans 33333 damping time constants of the bristles;",
        ),
        (
            {"friction": {"law": "jenkins", "kinetic": 15, "tangential_stiffness": 1e14}},
            "one step spans 2887 rad of the oscillation on the contact;",
        ),
    ],
)  # fmt: skip
def test_scene_that_turns_fast_is_called_slow(prepared, overrides, what):
    (sentence,) = slow(prepared(**overrides))
    assert sentence.startswith(what)
    assert "; this may take 100 times longer than usual, up to " in sentence


@pytest.mark.parametrize(
    ("overrides", "key"),
    [
        ({"excitation__frequency": 1e9}, "excitation"),
        ({"oscillator__stiffness": 1e22, "oscillator__damping": 0}, "oscillator.stiffness"),
        (
            {"friction": {"law": "dahl", "kinetic": 15, "bristle_stiffness": 1e25}},
            "friction.bristle_stiffness",
        ),
        (
            {
                "friction": {
                    "law": "leuven", "kinetic": 15, "bristle_stiffness": 1e5,
                    "bristle_damping": 1e12, "stribeck_velocity": 0.01,
                }
            },
            "friction.bristle_damping",
        ),
        (DAMPED | {"oscillator__damping": 1e14}, "oscillator.damping"),
    ],
)  # fmt: skip
def test_scene_that_nobody_waits_for_is_refused_with_the_hours(prepared, overrides, key):
    with pytest.raises(ScenarioError) as refused:
        prepared(**overrides)
    (problem,) = refused.value.problems
    assert re.match(rf"{key}: \S+ s span \S+ (rad of|damping time) ", problem.sentence)
    assert " h of work; check the units" in problem.sentence


def test_stiff_spring_that_never_moves_or_is_damped_is_not_refused(prepared):
    assert slow(prepared(oscillator__stiffness=1e22, friction__kinetic=1e4)) == []
    assert slow(prepared(oscillator={"mass": 75, "stiffness": 1e22, "damping_ratio": 0.5}))


def test_time_of_a_slow_orbit_is_told_for_a_period(prepared):
    (sentence,) = slow(prepared(**DAMPED))
    assert sentence.endswith("longer than usual, up to 1.3 s in total")
    (sentence,) = slow(prepared(**DAMPED, measure={}))
    assert sentence.endswith("up to 0.42 s per period, and the orbit may take many periods")


@pytest.mark.parametrize("stops", [{"restitution": 0.5}, {"stiffness": 1e5, "damping": 1e12}])
@pytest.mark.parametrize("damping", [1e8, 1e16])
def test_strong_damper_is_not_called_slow(prepared, stops, damping):
    # Measured: ten times as long a step at 1e10 N·s/m, which is below a microsecond.
    stroke = {"limit": 0.015, "stops": stops}
    assert slow(prepared(oscillator__damping=damping)) == []
    assert slow(prepared(oscillator__damping=damping, stroke=stroke)) == []
    still = {"law": "stribeck", "kinetic": 1e4, "stribeck_velocity": 0.01}
    assert slow(prepared(oscillator__damping=damping, friction=still)) == []


def test_damping_beyond_measure_takes_no_time(prepared):
    # A step was divided into a panel for every four decays.
    file = prepared(oscillator__damping=1e12, excitation=NOISE, measure={}).scenario
    with no_hang():
        outcome = drysim.run(file)
    assert outcome.metrics["energy_residual"] < 1e-9


def test_more_events_than_a_step_has_room_for_are_told_with_their_time(seat, drysim):
    # 50,000 reversals of a mass that rings at 160 kHz, all within the first step.
    words = {
        "oscillator": "{mass: 1, stiffness: 1e12, damping: 0}",
        "friction.kinetic": 1000,
        "start.x_r": 1e-4,
        "excitation": "{kind: psd, points: [[0.5, 1], [4, 1]], duration: 10, seed: 3}",
        "measure": "null",
        "solver.step": 0.1,
    }
    sets = [part for key, value in words.items() for part in ("--set", f"{key}={value}")]
    answer = drysim("run", seat, "--no-plots", *sets)
    assert answer.code == 3
    assert "at t = 0.1 s more than 4096 events fall within a step of 0.1 s" in answer.err
    assert "use a shorter step" in answer.err
    assert answer.err.startswith("note: one step spans 100000 rad of the oscillator;")


LUGRE = {
    "law": "lugre", "kinetic": 15, "bristle_stiffness": 1e5, "bristle_damping": 500,
    "stribeck_velocity": 0.01,
}  # fmt: skip


@pytest.fixture
def engine(monkeypatch):
    """Return what the choice of the engine reads of a study: steps and kernels."""

    def told(settle, *job):
        seen = []
        monkeypatch.setattr(
            "drysim.core.compile.choose_engine",
            lambda steps, kernels="": seen.append((steps, kernels)),
        )
        settle(*job)
        return seen[0]

    return told


def test_cost_of_a_step_by_series_counts_in_the_choice_of_the_engine(prepared, engine):
    cases = {"excitation.frequency": [1.0, 2.0, 4.0], "oscillator.mass": [60, 70, 80, 90]}
    easy, dear = (prepared(sweep=cases, **law) for law in ({}, {"friction": LUGRE}))
    steps, kernels = engine(sweep.choose_engine, easy, [easy.scenario])
    assert steps <= MAX_PLAIN_STEPS
    assert kernels == "march.march_sines_from_start"
    steps, kernels = engine(sweep.choose_engine, dear, [dear.scenario])
    assert steps > MAX_PLAIN_STEPS
    assert kernels == "taylor.march_taylor"
    assert case_cost(dear) == 5 * case_cost(easy)


def test_engine_of_a_run_is_that_of_the_fit_that_may_follow_it(prepared):
    case = prepared()
    block = {"measured": {"file": "x.csv", "x_r": 1}, "free": {"friction.kinetic": {}}}
    fit = Fit.model_validate(block)
    fitted = replace(case, scenario=case.scenario.model_copy(update={"fit": fit}))
    assert case_cost(fitted) == 2_000 * case_cost(case)


@pytest.mark.parametrize(("least", "steps"), [(100.0, 1_000), (0.0, 300_000)])
def test_orbits_cost_more_without_a_damper(prepared, engine, least, steps):
    swept = {"oscillator.damping": [least, 500.0]}
    case = prepared(sweep=swept, measure={"steady": True})
    chosen = engine(sweep.choose_engine, case, [case.scenario])
    assert chosen == (steps, "orbit.solve_orbits")


def test_law_that_costs_the_most_decides_where_several_are_solved(prepared, engine):
    case = prepared(sweep={"excitation.frequency": [1.0, 2.0]}, friction=LUGRE)
    others = [case.scenario.with_approach("viscous"), case.scenario]
    assert engine(sweep.choose_engine, case, others)[1] == "taylor.march_taylor"


def test_fixed_steps_cost_the_same_whatever_the_law(prepared):
    under_lugre, case = prepared(friction=LUGRE), prepared()
    assert step_cost(Switch(), under_lugre.law, under_lugre.motion) == step_cost(
        Switch(), case.law, case.motion
    )


def test_rows_and_bytes_of_a_large_response_are_told_before_the_work(prepared):
    slugs = {one.slug: one for one in prepared(solver__step=1e-9).warnings}
    told = slugs["large-response"]
    assert told.numbers["rows"] == 2_000_000_001
    assert "response.csv will have 2e+09 rows, about 200 GB" in told.sentence
    sweep = {"excitation.frequency": [1.0, 2.0]}  # which writes none
    for case in (prepared(solver__step=1e-6), prepared(solver__step=1e-9, sweep=sweep)):
        assert "large-response" not in {one.slug for one in case.warnings}
