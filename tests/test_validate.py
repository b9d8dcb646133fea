"""`drysim validate`: what a file says of itself before anything is computed."""

from __future__ import annotations

import shutil

import pytest
from golden import GALLERY

from drysim.manual.words import WARNING, entries
from drysim.study.validate import KEYS_BY_WARNING, validate


def test_scenario_to_fit_is_valid_without_values_of_its_free_keys():
    (note,) = validate(str(GALLERY / "fit-seat.yaml"))
    assert (note.severity, note.sentence) == (
        "note",
        "measured: x_dd, x_r, 8000 samples over 39.995 s",
    )


def test_fault_of_the_measurement_is_found_by_validating():
    (fault,) = validate(str(GALLERY / "fit-seat.yaml"), ["fit.measured.x_dd=seet"])
    assert fault.severity == "error"
    assert "seet" in fault.sentence


def test_key_without_a_start_is_found_by_validating():
    changes = ["friction.law=stribeck", "fit.free={friction.stribeck_velocity: {}}"]
    values = ["oscillator.stiffness=4500", "oscillator.damping=300", "friction.kinetic=32"]
    (fault,) = validate(
        str(GALLERY / "fit-seat.yaml"), [*changes, *values, "friction.static_ratio=1.3"]
    )
    assert fault.sentence.startswith("friction.stribeck_velocity needs a start")


@pytest.mark.parametrize("given", [("mu_static", "mu_kinetic"), ("mu_kinetic", "mu_static")])
def test_one_limit_of_friction_may_be_given_and_the_other_fitted(given, tmp_path):
    known, free = given
    words = (GALLERY / "fit-rig.yaml").read_text(encoding="utf-8")
    words = words.replace("static_ratio: 1.0 ", f"{known}: 0.2").replace(
        "friction.mu_kinetic: {}", f"friction.{free}: {{}}"
    )
    (tmp_path / "rig.yaml").write_text(words, encoding="utf-8")
    shutil.copy(GALLERY / "fit-rig-measured.csv", tmp_path)
    assert not [one for one in validate(str(tmp_path / "rig.yaml")) if one.severity == "error"]


DOUBTFUL = """\
name: doubtful
oscillator: {mass: 75, stiffness: 7500, damping: 0.3}
friction: {law: coulomb, kinetic: 450}
stroke:
  limit: 25
excitation:
  kind: harmonic
  frequency: 1.6
  rms: 1
  phase: 90
solver:
  step: 0.05
  smooth: {sharpness: 100}
checks:
  - x_r_peak < 25 mm
  - stuck_share < 80 at friction.kinetic > 0
"""


def test_warning_stands_at_the_line_that_it_is_about(tmp_path):
    file = tmp_path / "doubtful.yaml"
    file.write_text(DOUBTFUL)
    warnings = {
        (problem.line, problem.column): (problem.key, problem.sentence.partition(" ")[0])
        for problem in validate(str(file))
    }
    assert warnings == {
        (2, 41): ("oscillator.damping", "oscillator.damping"),
        (3, 1): ("friction", "the"),
        (5, 3): ("stroke.limit", "stroke.limit"),
        (6, 1): ("excitation", "a"),
        (12, 3): ("solver.step", "solver.step"),
        (13, 3): ("solver.smooth", "solver.smooth"),
        (16, 5): ("checks.1", "the"),
    }
    assert {problem.severity for problem in validate(str(file))} == {"warning"}


@pytest.mark.parametrize(
    "block",
    [
        "sweep:\n  stroke.limit: [25, 30]",
        "sweep:\n  zip: {oscillator.mass: [60, 90], stroke.limit: [25, 30]}",
        "design: {minimise: T_a, vary: {stroke.limit: {from: 25, to: 30}}}",
        "design:\n  minimise: T_a\n  vary: {oscillator.mass: {from: 60, to: 90}}\n"
        "  over: {stroke.limit: [25, 30]}",
    ],
)
def test_warning_about_a_varied_length_stands_where_it_is_varied(tmp_path, block):
    file = tmp_path / "varied.yaml"
    file.write_text(f"{DOUBTFUL.partition('checks:')[0]}{block}\n")
    (problem,) = (each for each in validate(str(file)) if "millimetres" in each.sentence)
    assert (
        file.read_text()
        .splitlines()[problem.line - 1][problem.column - 1 :]
        .startswith("stroke.limit: ")
    )


def test_warning_about_a_value_that_was_set_names_its_option(tmp_path):
    (tmp_path / "doubtful.yaml").write_text(DOUBTFUL)
    changes = ["stroke.limit=60"]
    (problem,) = (
        problem
        for problem in validate(str(tmp_path / "doubtful.yaml"), changes)
        if problem.key == "stroke.limit"
    )
    assert problem.place == "--set stroke.limit=60"


def test_warning_about_a_record_stands_at_its_file():
    rig = GALLERY / "fit-rig.yaml"
    (warning,) = (problem for problem in validate(str(rig)) if problem.severity == "warning")
    line = rig.read_text(encoding="utf-8").splitlines()[warning.line - 1]
    assert line.strip() == "measured:"


def test_faults_of_measured_channels_are_found_without_an_assessment():
    swapped = {"assess.measured.x_dd": "floor", "excitation.column": "seat"}
    problems = validate(str(GALLERY / "assess-seat.yaml"), swapped)
    (warning,) = (problem for problem in problems if problem.severity == "warning")
    assert warning.sentence.startswith("base and mass seem to be swapped")
    assert warning.key == "assess.measured"


def test_every_key_to_blame_is_one_of_a_known_warning():
    slugs = {entry.word for entry in entries() if entry.kind == WARNING}
    assert KEYS_BY_WARNING.keys() <= slugs
