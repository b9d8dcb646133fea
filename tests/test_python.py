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
