"""The hard cases: the exact approach is held to their checks, the others to it."""

from __future__ import annotations

import json

import pytest

import drysim as package
from drysim.bench import hard_cases
from drysim.bench.timing import tried
from seat import rows_of

SLIDING = """\
drysim: 1
name: sliding
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45}
excitation: {kind: harmonic, frequency: 2, rms: 0.75}
solver: {step: 2.5e-3}
"""
HELD = SLIDING.replace("sliding", "held").replace("2, rms: 0.75", "5, rms: 0.33")


def ordeal(tmp_path, words, **changes):
    """Give what becomes of a scenario, by its words; trials by approach."""
    file = tmp_path / "scene.yaml"
    file.write_text(words)
    found = hard_cases.ordeal(package.load(file, changes), 30.0, lambda: None)
    return {one.approach: one for one in found.trials}


def test_exact_approach_holds_and_others_are_wrong_where_the_mass_should_stick(
    drysim, tmp_path
):
    (tmp_path / "held.yaml").write_text(HELD + "checks: [T_a == 1, x_r_peak == 0]\n")
    answer = drysim("bench", "--hard", "held.yaml")
    assert answer.code == 0
    table = rows_of(tmp_path / "out/held-hard/hard_cases.csv")
    rows = {row["approach"]: row for row in table}
    assert {name: row["verdict"] for name, row in rows.items()} == {
        "stick-slip": "held", "switch": "held", "moreau": "held", "signum": "wrong",
        "smooth": "wrong", "viscous": "wrong",
    }  # fmt: skip
    assert rows["signum"]["how"] == "T_a +84 %"
    assert float(rows["signum"]["T_a_deviation [-]"]) == pytest.approx(0.84, abs=0.01)


def test_exact_approach_that_breaks_a_check_makes_the_exit_code_1(drysim, tmp_path):
    (tmp_path / "held.yaml").write_text(HELD + "checks: [T_a == 1, x_r_peak > 1 mm]\n")
    answer = drysim("bench", "--hard", "held.yaml", "--json")
    assert answer.code == 1
    first = json.loads(answer.out)["cases"][0]["trials"][0]
    assert (first["word"], first["how"]) == ("wrong", "1 of 2 checks fail")


def test_without_checks_the_exact_approach_holds_nothing(drysim, tmp_path):
    (tmp_path / "held.yaml").write_text(HELD)
    answer = drysim("bench", "--hard", "held.yaml")
    assert answer.code == 0
    assert "no checks   held: without checks nothing is promised" in answer.out
    table = rows_of(tmp_path / "out/held-hard/hard_cases.csv")
    verdicts = {row["approach"]: row["verdict"] for row in table}
    assert verdicts["stick-slip"] == "no checks"
    assert verdicts["signum"] == "wrong"


def test_approach_that_asks_for_too_much_has_failed_and_says_why(tmp_path):
    words = SLIDING + "measure: {steady: false, settle: 0, duration: 10 s}\n"
    trials = ordeal(tmp_path, words, **{"solver.smooth.sharpness": 1e12})
    assert trials["smooth"].word == "failed"
    assert "GB of memory" in trials["smooth"].how
    assert trials["moreau"].word == "held"


def test_approach_that_takes_too_long_has_failed(tmp_path):
    (tmp_path / "held.yaml").write_text(HELD)
    scenario = package.load(tmp_path / "held.yaml")
    late = tried(lambda: hard_cases.solved(scenario, "moreau"), 1e-5)
    assert late == "given up after 1e-5 s"


def test_every_point_of_a_swept_hard_case_counts(tmp_path):
    words = HELD + "sweep: {excitation.rms: [0.33, 0.5]}\nchecks: [T_a > 0.9]\n"
    exact = ordeal(tmp_path, words)["stick-slip"]
    assert (exact.word, exact.checks, exact.passed) == ("held", 2, 2)


@pytest.mark.parametrize(
    ("metric", "off", "words"),
    [("T_a", 0.84, "T_a +84 %"), ("x_r_peak", -1.0, "peak -100 %"),
     ("x_r_rms", 51.0, "x_r ×52"), ("x_r_rms", 1e9, "blows up")],
)  # fmt: skip
def test_deviation_is_spoken(metric, off, words):
    assert hard_cases.spoken(metric, off) == words


def test_dry_run_of_the_hard_cases_names_them_all(drysim):
    told = json.loads(drysim("bench", "--hard", "--dry-run", "--json").out)
    assert len(told["cases"]) > 20
    assert told["folder"] == "out/hard"


@pytest.mark.slow
def test_exact_approach_holds_every_hard_case(process):
    answer = process("bench", "--hard", "--json", "--patience", 120)
    assert answer.code == 0
    counts = json.loads(answer.out)["metrics"]
    assert set(counts["stick-slip"]) == {"held"}
    assert counts["signum"]["wrong"] > 5


def test_two_benches_are_not_run_as_one(drysim):
    answer = drysim("bench", "--steady", "--hard", "--dry-run")
    assert answer[:2] == (2, "")
    assert "--steady and --hard ask for two benches" in answer.err
