"""The step of the output grid: where it has a default, and what a message proposes."""

from __future__ import annotations

import pytest
from seat import EM6_SEAT

import drysim
from drysim.errors import ScenarioError
from drysim.scenario.load import scenario
from drysim.scenario.steps import default_step, proposed_step
from drysim.study.compare import compare
from drysim.study.preparation import prepare

HARMONIC = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
"""
REST = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
start: {x_r: 0.02}
excitation: {kind: rest}
measure: {duration: 2}
"""
SINES = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
excitation:
  kind: sines
  components: [{frequency: 1.6, rms: 1}, {frequency: 0.7, rms: 1}]
measure: {steady: true}
"""

GENERATED = {
    "{kind: psd, points: [[0.5, 0.1], [30, 0.1]], duration: 60, seed: 1}": 1e-3,
    "{kind: standard, class: EM6, duration: 60, seed: 1}": 2e-3,
    "{kind: road, class: B, speed: 20, duration: 60, seed: 1}": None,
    "{kind: sweep, from: 0.5, to: 10, rms: 1, duration: 60}": 5e-3,
    "{kind: shock, pulse: half-sine, amplitude: 10, duration: 11 ms}": 1e-4,
    "{kind: shock, pulse: sawtooth, amplitude: 10, duration: 5 ms, start: 15 ms}": 5e-5,
}
"""Base motion that is sampled, and the step that is proposed [s]."""


def numbers_of(row) -> dict[str, float]:
    """Return the metrics of a case that are known."""
    return {name: value for name, value in row.metrics.items() if value is not None}


@pytest.mark.parametrize(
    ("text", "step"),
    [
        (HARMONIC, 1 / 160),
        (HARMONIC + "measure: {direction: vertical}", 1 / 400),
        (HARMONIC + "measure: {settle: 1, duration: 2}", 1 / 160),
        (HARMONIC.replace("7500", "7500e4"), 1 / 1600),
        (SINES, 10 / 1600),
        (REST, 1 / 159.2),
        (REST.replace("7500", "0"), 2e-3),
    ],
)
def test_step_has_a_default_under_sines_and_at_rest(text, step):
    loaded = scenario(text)
    assert loaded.solver.step is None
    assert loaded.step == pytest.approx(step, rel=1e-3)
    case = prepare(loaded)
    assert not [warning for warning in case.warnings if warning.slug.startswith("coarse")]
    again = scenario(loaded.resolved())
    assert again.solver.step == loaded.step
    assert drysim.run(loaded).metrics == drysim.run(again).metrics


def test_default_step_is_a_whole_part_of_the_common_period():
    assert default_step((1.6, 0.7), 0.3, None, False) == pytest.approx(10.0 / 1600, rel=1e-12)
    assert default_step((1.6,), 3.1, None, False) == pytest.approx(1 / 1.6 / 194, rel=1e-12)


def test_metrics_of_a_sweep_do_not_depend_on_the_default_step():
    sweep = "sweep: {excitation.frequency: {from: 0.5, to: 8, step: 2.5}}\n"
    by_default = drysim.sweep(scenario(HARMONIC + sweep))
    stated = drysim.sweep(scenario(HARMONIC + sweep + "solver: {step: 1e-3}"))
    assert by_default.scenario.resolved()["solver"].keys() == {"approach"}
    for case, other in zip(by_default.rows, stated.rows, strict=True):
        assert numbers_of(case) == pytest.approx(numbers_of(other), rel=1e-12)


@pytest.mark.parametrize("excitation", GENERATED)
def test_step_of_sampled_motion_is_required_and_proposed(excitation):
    text = REST.replace("{kind: rest}", excitation).replace(
        "measure: {duration: 2}", "measure: {duration: 2}" if "shock" in excitation else ""
    )
    with pytest.raises(ScenarioError) as fault:
        scenario(text)
    (problem,) = fault.value.problems
    assert problem.sentence.startswith("solver.step is required: time step of base motion and")
    step = float(problem.sentence.rpartition("such as ")[2].removesuffix(" s"))
    if GENERATED[excitation] is not None:
        assert step == GENERATED[excitation]
    case = prepare(scenario(f"{text}\nsolver: {{step: {step!r}}}"))
    assert not [warning for warning in case.warnings if warning.slug == "coarse-step"]


def test_no_step_is_proposed_where_none_divides_all_times():
    text = EM6_SEAT.replace("10 s", "1.2345678 s").replace("solver: {step: 5 ms}\n", "")
    with pytest.raises(ScenarioError) as fault:
        scenario(text)
    assert fault.value.problems[0].sentence.endswith("time step of base motion and output [s]")


@pytest.mark.parametrize("more", ["solver: {approach: signum}", "reference: switch"])
def test_step_is_required_by_approaches_of_fixed_steps(more):
    sweep = "sweep: {excitation.rms: [1, 2]}\n"
    with pytest.raises(ScenarioError, match=r"solver\.step is required: .*, such as 0\.005 s"):
        scenario(f"{HARMONIC}{sweep}{more}")


def test_step_is_required_for_the_approaches_of_a_comparison():
    with pytest.raises(ScenarioError, match=r"solver\.step is required for signum: "):
        compare(scenario(HARMONIC), "signum vs stick-slip")
    exact = compare(scenario(HARMONIC), "viscous vs stick-slip")
    assert exact.reference == "stick-slip"


def test_proposal_is_none_where_nothing_moves_fast():
    assert proposed_step(scenario(REST).excitation, (), 0.0) is None
