"""Scenarios from mappings and text, and what else the commands can do, in Python."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from seat import SEAT

import drysim
from drysim.errors import ScenarioError, UsageError
from drysim.yaml_document import read_document

RECORD = {"kind": "record", "file": "base.csv", "time": "t", "column": "u_dd"}


@pytest.fixture
def keys(seat):
    """Return the keys of the small scenario as nested mappings."""
    return read_document(seat).value


def test_scenario_of_a_mapping_or_of_text_is_that_of_the_file(seat, keys):
    loaded = drysim.load(seat)
    for source in (keys, SEAT):
        scenario = drysim.scenario(source)
        assert scenario.resolved() == loaded.resolved()
        assert drysim.run(scenario).metrics == drysim.run(loaded).metrics
    assert drysim.scenario(keys) == drysim.scenario(keys)


def test_scenario_takes_values_of_numpy_tuples_paths_and_overrides(keys, place):
    np.savetxt("base.csv", np.ones((9, 2)) * np.arange(9)[:, None], "%g", ",")
    Path("base.csv").write_text("t [s],u_dd [m/s^2]\n" + Path("base.csv").read_text())
    keys["oscillator"]["mass"] = np.float64(80)
    damping = np.array([9.5])
    keys["sweep"] = {"friction.kinetic": (5, np.int64(15)), "oscillator.damping": damping}
    keys["excitation"] = RECORD | {"file": Path("base.csv")}
    del keys["measure"], keys["name"], keys["solver"]
    scenario = drysim.scenario(keys, {"friction.kinetic": 7})
    assert (scenario.name, scenario.oscillator.mass) == ("scenario", 80.0)
    assert scenario.friction.kinetic == 7.0
    assert [[*axis.values] for axis in scenario.sweep] == [[5.0, 15.0], [9.5]]
    assert drysim.scenario(scenario.resolved()).resolved() == scenario.resolved()


def test_errors_of_a_mapping_are_at_their_keys(keys):
    keys["friction"]["kinetics"] = 3
    keys["oscillator"]["mass"] = "heavy"
    with pytest.raises(ScenarioError) as fault:
        drysim.scenario(keys)
    unknown, wrong = fault.value.problems
    assert (unknown.key, wrong.key) == ("friction.kinetics", "oscillator.mass")
    assert str(unknown).startswith("friction.kinetics: unknown key `kinetics` in friction")
    assert str(wrong) == wrong.sentence
    assert wrong.sentence.startswith("oscillator.mass")
    assert (wrong.place, wrong.line, wrong.source) == ("", 0, "")


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        ("name: seat\nfriction: {law: x", "<scenario>:2:11: this `{` is not closed by `}`"),
        ("", "<scenario>: the file is empty"),
        ("name: \x07", "<scenario>:1:7: character U+0007 is not allowed in a scenario"),
        ({}, "oscillator is required"),
        ({"name": {1, 2}}, "<scenario>['name']: a value of type set is not allowed"),
    ],
)
def test_text_that_is_no_scenario_is_an_error_with_its_place(source, sentence):
    with pytest.raises(ScenarioError) as fault:
        drysim.scenario(source)
    assert sentence in str(fault.value)


@pytest.mark.parametrize("source", ["seat.yaml", Path("seat.yaml"), 5, None, [("name", "a")]])
def test_scenario_of_something_else_is_a_usage_error(source):
    with pytest.raises(UsageError) as fault:
        drysim.scenario(source)
    assert fault.value.hint == "drysim.load reads a file"
    assert fault.value.__notes__ == [fault.value.hint]
    assert pickle.loads(pickle.dumps(fault.value)).__notes__ == [fault.value.hint]


def test_package_of_scenarios_is_called_whatever_was_imported_before():
    program = (
        "import drysim, {}\n"
        "import drysim.scenario.axes as module\n"
        "from drysim.scenario import schema\n"
        "print(callable(drysim.scenario), module.__name__, bool(schema()))"
    )
    for module in ("os", "drysim.scenario.load", "drysim.cli"):
        done = subprocess.run(
            [sys.executable, "-c", program.format(module)], capture_output=True, text=True
        )
        assert done.stdout == "True drysim.scenario.axes True\n", done.stderr


def test_problems_are_those_of_the_command(seat, keys, place):
    overrides = {"oscillator.mass": "heavy"}
    (problem,) = drysim.validate(seat, overrides)
    assert problem.severity == "error"
    assert str(problem) == "overrides['oscillator.mass']: " + problem.sentence
    assert [one.sentence for one in drysim.validate(keys, overrides)] == [problem.sentence]
    assert drysim.validate(os.fspath(seat)) == drysim.validate(drysim.load(seat)) == ()
    del keys["measure"], keys["solver"]
    (missing,) = drysim.validate(keys | {"excitation": RECORD})
    assert "the record does not exist" in missing.sentence
    with pytest.raises(UsageError, match="takes no overrides"):
        drysim.validate(drysim.load(seat), overrides)
    with pytest.raises(UsageError, match="not as 5"):
        drysim.validate(5)


def test_words_are_explained_as_by_the_command(command):
    for word in ("T_a", "friction.kinetic", "stroke-violated", "--resume"):
        assert f"{drysim.explain(word)}\n" == command("explain", word).out
    with pytest.raises(UsageError, match=r"nothing is known about `T_aa`; did you mean"):
        drysim.explain("T_aa")


def test_names_of_a_comparison_are_listed_or_given_one_by_one(seat):
    scenario = drysim.load(seat)
    one = drysim.compare(scenario, "signum", "stick-slip")
    assert one == drysim.compare(scenario, names=["signum", "stick-slip"])
    assert one == drysim.compare(scenario, "signum vs stick-slip")
    assert drysim.compare(scenario, ["smooth", "signum"], "moreau").reference == "moreau"
    with pytest.raises(UsageError, match="expected names"):
        drysim.compare(scenario, "signum", 5)


# What Python shows of an answer, and of a fault: a line or two, never a wall of numbers.


BRIEF_SEAT = """\
name: seat
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45}
excitation: {kind: harmonic, frequency: 2, rms: 0.75}
solver: {step: 2.5e-3}
sweep: {friction.kinetic: [0, 45]}
checks: [x_r_peak < 1 mm, T_a < 2]
"""
BRIEF_NOISE = {"kind": "standard", "class": "EM3", "duration": 10, "seeds": 3}


def test_outcome_shows_itself_in_a_line():
    outcome = drysim.run(drysim.scenario(BRIEF_SEAT))
    assert repr(outcome) == (
        "<Outcome of seat: T_a 0.976, T_x 0.4485, peak |x_r| 2.794 mm; 5 events; "
        "1 of 2 checks held>"
    )
    elsewhere = {"checks": ["T_a < 2", "T_a < 1 at friction.kinetic < 1"]}
    told = repr(drysim.run(drysim.scenario(BRIEF_SEAT, elsewhere)))
    assert told.endswith("1 of 2 checks held and 1 skipped>")
    assert repr(outcome.response) == "<Response: 201 points at 0.0025 s, 5 events>"
    assert repr(outcome.events).startswith("<Events: 5; ")


def test_answers_of_many_cases_show_themselves_in_a_line():
    table = drysim.sweep(drysim.scenario(BRIEF_SEAT))
    assert repr(table) == (
        "<Table of seat: 2 cases by stick-slip; T_a 0.976 to 1.28, T_x 0.449 to 1.55, "
        "peak |x_r| 2.79 to 10.4 mm; best none; 1 of 2 checks held>"
    )
    comparison = drysim.compare(drysim.scenario(BRIEF_SEAT), "signum vs stick-slip")
    assert repr(comparison).startswith(
        "<Comparison of seat: signum, stick-slip, viscous against stick-slip; signum "
    )
    own = repr(drysim.sweep(drysim.scenario(BRIEF_SEAT))).partition("; ")[2].partition("; ")[0]
    assert f"; {own} by stick-slip; best none; 1 of 2 checks held" in repr(comparison.table)
    many = drysim.run(drysim.scenario(BRIEF_SEAT, {"excitation": BRIEF_NOISE}))
    assert repr(many).startswith("<Ensemble of seat: 3 seeds; T_a 1.0")
    assert len(repr(many)) < 200


def test_comparison_takes_its_words_as_a_text_or_as_a_list():
    scenario = drysim.scenario(BRIEF_SEAT)
    one = drysim.compare(scenario, "signum vs stick-slip")
    for words in (["signum", "stick-slip"], ["signum vs stick-slip"]):
        assert drysim.compare(scenario, words).verdict == one.verdict
    for words in (None, 5, [5, 6]):
        with pytest.raises(drysim.UsageError, match="expected names, such as"):
            drysim.compare(scenario, words)


def test_what_is_no_scenario_no_row_and_no_number_of_threads_earns_a_sentence():
    scenario = drysim.scenario(BRIEF_SEAT)
    for solve in (drysim.run, drysim.sweep, lambda one: drysim.compare(one, "signum viscous")):
        with pytest.raises(drysim.UsageError, match="expected a scenario"):
            solve("seat.yaml")
    many = drysim.scenario(BRIEF_SEAT, {"excitation": BRIEF_NOISE})
    for workers in ("2", 0, -1, 2.5, True):
        for solve, one in (
            (drysim.sweep, scenario),
            (drysim.run, many),
            (drysim.run, scenario),
        ):
            with pytest.raises(drysim.UsageError, match="workers must be a whole number of at"):
                solve(one, workers=workers)
    comparison = drysim.compare(scenario, "signum vs stick-slip", workers=np.int64(2))
    with pytest.raises(drysim.UsageError, match="expected a row of the table, not 'x'"):
        comparison.deviation("x")
    slower = drysim.scenario(BRIEF_SEAT, {"oscillator.damping": 900})
    with pytest.raises(drysim.UsageError, match=r"expected a row of the table, not `?Row"):
        comparison.deviation(drysim.sweep(slower)[0])
    assert comparison.deviation(comparison.table[1]) == comparison.deviation(
        drysim.compare(scenario, "signum vs stick-slip").table[1]
    )
    table = comparison.table
    assert table[-1] == table[4] == list(table)[4]
    assert table[1:3] == list(table)[1:3]
    for number in (5, -6):
        with pytest.raises(IndexError, match=f"index {number} is out of range for length 5"):
            table[number]


def test_fault_shows_every_problem_with_its_place(seat):
    text = BRIEF_SEAT.replace("mass: 75", "mas: 75").replace("kinetic: 45}", "kinetic: -1}")
    seat.write_text(text)
    with pytest.raises(ScenarioError) as caught:
        drysim.load(seat)
    assert str(caught.value).splitlines() == [
        f"{seat}: 2 errors",
        f"{seat}:2:14: unknown key `mas` in oscillator; did you mean `mass`?",
        f"{seat}:3:35: friction.kinetic must be at least 0 N, not -1",
    ]


def test_fault_of_a_record_shows_its_place(seat):
    file = seat.with_name("r.csv")
    file.write_text("a [g]\n1\noops\n")
    record = {"kind": "record", "file": "r.csv", "rate": 400}
    scenario = drysim.load(seat, {"excitation": record, "solver": None, "measure": None})
    with pytest.raises(drysim.RecordError) as caught:
        drysim.run(scenario)
    assert (
        str(caught.value) == f"{file}:3:1: row 3, column 1 (`a [g]`): `oops` is not a number; "
        "if it is no sample, `rows: {to: 2}` leaves it out"
    )
