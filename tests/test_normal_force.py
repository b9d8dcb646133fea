"""A normal force in scenarios: recorded or lifting; what uses it, refuses it, and says so."""

from __future__ import annotations

import json

import numpy as np
import pytest

import drysim
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import Law, Plant, Pressed, Samples, State
from drysim.errors import RecordError, ScenarioError
from drysim.scenario.load import load
from drysim.study.case import prepare
from drysim.study.validate import examine

HEAD = """drysim: 1
oscillator: {{mass: 75, stiffness: 7500, damping: 500}}
friction: {{law: coulomb, mu_kinetic: 0.3, mu_static: 0.36, {force}}}
stroke: {{limit: 25 mm}}
excitation: {{kind: harmonic, frequency: 2, rms: 0.75}}
solver: {{step: 2.5e-3}}
"""
RECORD = "normal_record: {file: force.csv, column: F_N, rate: 100 Hz}"
WINDOW = "measure: {settle: 1 s, duration: 3 s}\n"


@pytest.fixture
def scene(tmp_path):
    """Write a scenario beside a record of its normal force, 5 s long; gives its path."""

    def written(force=RECORD, more=WINDOW, values=None, header="F_N [N]"):
        t = np.arange(501) / 100
        values = 100 + 130 * np.sin(2 * np.pi * 0.9 * t) if values is None else values
        lines = "\n".join(map(repr, np.asarray(values).tolist()))
        (tmp_path / "force.csv").write_text(f"{header}\n{lines}\n")
        path = tmp_path / "seat.yaml"
        path.write_text(HEAD.format(force=force) + more)
        return path

    return written


def test_constant_record_is_a_constant_normal_force(scene):
    one = drysim.run(load(scene(values=np.full(501, 100.0))))
    other = drysim.run(load(scene("normal: 100")))
    assert np.abs(one.response.x_r - other.response.x_r).max() < 1e-12 * 5e-3
    for name in ("T_a", "T_x", "x_r_peak", "stuck_share", "energy_friction"):
        assert one.metrics[name] == pytest.approx(other.metrics[name], rel=1e-11)


def test_record_lifts_off_and_its_run_says_so(scene):
    outcome = drysim.run(load(scene()))
    assert {"lift", "slip+", "slip-", "stick"} <= set(outcome.response.events.names)
    assert outcome.response.numerics.core == "pressed"
    assert outcome.response.numerics.closest_decision > 0
    assert outcome.metrics["energy_residual"] < 1e-12


def test_forces_stand_for_the_mean_and_units_are_converted(scene):
    law = load(scene(values=[0.1, 0.3] * 250 + [0.2], header="F_N [kN]")).law()
    assert law.F_fk == pytest.approx(0.3 * 200, rel=1e-12)
    assert law.F_fs == pytest.approx(0.36 * 200, rel=1e-12)
    assert law.pressure.relative[:2] == pytest.approx([0.5, 1.5], rel=1e-12)


def test_resolved_scenario_runs_again(scene, tmp_path):
    scenario = load(scene())
    words = scenario.resolved(tmp_path / "out")
    assert words["friction"]["normal_record"]["file"] == "../force.csv"
    assert "normal" not in words["friction"]


def test_record_in_options_of_another_law_is_resolved_to_its_own_file(scene, tmp_path):
    """It kept the path that it has beside the scenario, which leads nowhere elsewhere."""
    loaded = load(scene())
    pressed = {k: v for k, v in loaded.spoken("friction").items() if k != "law"}
    dahl = {"law": "dahl", "kinetic": 15, "bristle_stiffness": 1e5, "coulomb": pressed}
    scenario = load(scene(), {"friction": dahl})
    assert [one.slug for one in prepare(scenario).cautions if one.slug == "unread-record"] == []
    words = scenario.resolved(tmp_path / "out")
    assert words["friction"]["coulomb"]["normal_record"]["file"] == "../force.csv"


def test_amplitude_of_one_and_more_is_solved_by_modes(scene):
    for amplitude, kind in ((0.999, "leap"), (1.0, "pressed"), (1.7, "pressed")):
        force = f"normal: 100, normal_variation: {{amplitude: {amplitude}, frequency: 4}}"
        outcome = drysim.run(load(scene(force, more="")))
        assert outcome.response.numerics.core == kind
        assert outcome.metrics["closure"] < 1e-11


def test_swept_amplitudes_on_both_sides_of_one_agree_with_runs(scene):
    force = "normal: 100, normal_variation: {amplitude: 0.5, frequency: 4}"
    sweep = "sweep: {friction.normal_variation.amplitude: [0.5, 0.99, 1.0, 1.5]}\n"
    scenario = load(scene(force, more=sweep))
    for row in drysim.sweep(scenario):
        alone = drysim.run(scenario.at(row.point))
        assert row.metrics["T_a"] == pytest.approx(alone.metrics["T_a"], rel=1e-9)


def test_record_is_read_once_for_all_cases_and_hashed(scene, tmp_path, monkeypatch):
    from drysim.records import file, record

    scenario = load(scene(more=WINDOW + "sweep: {friction.mu_kinetic: [0.1, 0.2, 0.3]}\n"))
    calls, read = [], file.read
    monkeypatch.setattr(record, "read", lambda *given: calls.append(given) or read(*given))
    rows = list(drysim.sweep(scenario))
    assert len({row.metrics["T_a"] for row in rows}) == 3
    assert len(calls) == 1


def test_sidecar_names_the_record(scene, tmp_path, capsys):
    from drysim.cli import main

    assert main(["run", str(scene()), "--no-plots", "-q", "-o", str(tmp_path / "out")]) == 0
    inputs = json.loads((tmp_path / "out" / "drysim.json").read_text())["inputs"]
    assert [entry["file"] for entry in inputs] == ["force.csv"]
    assert len(inputs[0]["sha256"]) == 64


def test_other_approaches_take_the_mean_in_a_comparison(scene):
    scenario = load(scene())
    mean = scenario.law().pressure.mean
    law = scenario.with_approach("signum").law()
    assert not isinstance(law, Pressed)
    assert law.F_fk == pytest.approx(0.3 * mean, rel=1e-12)
    losses = scenario.losses("signum")
    assert "signum knows no varying normal force and takes it as constant" in losses


def test_other_laws_take_the_mean_in_a_comparison(scene):
    scenario = load(scene(RECORD + ", stribeck: {stribeck_velocity: 0.01}"))
    law = scenario.with_law("stribeck").law()
    assert law.F_fk == pytest.approx(scenario.law().F_fk, rel=1e-12)


@pytest.mark.parametrize(
    ("force", "more", "sentence"),
    [
        (RECORD, "measure: {duration: 6 s}\n", "friction.normal_record ends at 5 s, before"),
        (RECORD, "", "measure.duration is required for harmonic"),
        (RECORD, "measure: {steady: true}\n", "needs a normal force that repeats"),
        (RECORD + ", normal: 3", WINDOW, "give normal or normal_record, not both"),
        (RECORD.replace("rate", "unit: m, rate"), WINDOW, "is a unit of length, not force"),
        (RECORD.replace("file: force.csv, ", ""), WINDOW, "normal_record.file is required"),
        (RECORD.replace(", rate: 100 Hz", ""), WINDOW, "how the samples are spaced"),
        (RECORD.replace("force.csv", "farce.csv"), WINDOW, "did you mean `force.csv`?"),
        (RECORD.replace("F_N", "F_T"), WINDOW, "there is no column `F_T`"),
        (
            RECORD.replace("rate", "scale: -1, rate"),
            WINDOW,
            "the mean of the normal force is -",
        ),
        (
            "normal_variation: {amplitude: 1.2, frequency: 4}, " + RECORD,
            WINDOW,
            "give normal_record or normal_variation, not both",
        ),
    ],
)
def test_faults_are_told_before_anything_is_computed(scene, force, more, sentence):
    problems = examine(str(scene(force, more)))
    assert [problem.severity for problem in problems] == ["error"]
    assert sentence in problems[0].sentence


@pytest.mark.parametrize(
    ("amplitude", "frequency", "slugs"),
    [(40, 35, ["record-interpolated"]), (40, 3, []), (2, 35, [])],
)
def test_force_that_interpolation_takes_away_is_a_warning(scene, amplitude, frequency, slugs):
    t = np.arange(501) / 100
    values = 100 + amplitude * np.sin(2 * np.pi * frequency * t)
    pressure = load(scene(values=values)).law().pressure
    assert [caution.slug for caution in pressure.cautions] == slugs
    if slugs:
        assert "of 28.26 N RMS, " in pressure.cautions[0].sentence


def test_unit_is_mandatory(scene):
    way = "write `unit: N` in the scenario's `friction.normal_record` block"
    with pytest.raises(RecordError, match=way):
        load(scene(header="F_N")).law()


@pytest.mark.parametrize("name", ["switch", "moreau", "signum", "smooth"])
@pytest.mark.parametrize(
    "force", [RECORD, "normal: 100, normal_variation: {amplitude: 1.2, frequency: 4}"]
)
def test_approaches_without_a_use_for_it_refuse_it(scene, name, force):
    with pytest.raises(ScenarioError) as found:
        load(scene(force), {"solver.approach": name, "friction.mu_static": 0.3})
    assert "has no use for a varying normal force" in found.value.problems[0].sentence


@pytest.mark.parametrize(
    "force", [RECORD, "normal: 100, normal_variation: {amplitude: 1.2, frequency: 4}"]
)
def test_end_stops_refuse_surfaces_that_part(scene, force):
    stops = {"stroke.stops.restitution": 0.3}
    with pytest.raises(ScenarioError) as found:
        load(scene(force), stops)
    assert "end stops go with a normal force" in found.value.problems[0].sentence


def test_faintest_force_that_varies_holds_what_nothing_pulls():
    """The squares of its rates are below the numbers: a margin that stays was missed."""
    law = Law(1e-300, 1e-300, 0.5, 1.0, 0.0)
    still = Samples(np.zeros(3), 2.5)
    events = StickSlip().solve(Plant(1.0, 1.0, 0.0), law, still, State(0.0, 0.0), 2.5).events
    assert events.t.tolist() == [0.0]
