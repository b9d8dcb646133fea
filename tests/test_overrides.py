"""Values laid over a scenario: the same road from the shell and from Python."""

from __future__ import annotations

import contextlib
import functools

import numpy as np
import pytest
import yaml

from drysim.errors import ScenarioError, UsageError
from drysim.scenario.load import load

SEAT = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {step: 2.5e-3}
"""


def sentences(fault: pytest.ExceptionInfo[ScenarioError]) -> list[str]:
    return [f"{problem.file}: {problem.sentence}" for problem in fault.value.problems]


def test_overrides_count_from_the_shell_and_from_python(scenario):
    shell = ["oscillator.mass=80", "stroke.limit=20 mm", "excitation.rms=1e0"]
    python = {"oscillator.mass": 80, "stroke": {"limit": "20 mm"}, "excitation.rms": 1.0}
    assert scenario(SEAT, shell).resolved() == scenario(SEAT, python).resolved()
    assert scenario(SEAT, shell).stroke.limit == 0.02


def test_overrides_reach_into_lists_and_take_keys_away(scenario):
    sines = "sines, components: [{frequency: 1, rms: 1}, {frequency: 2, rms: 1}]"
    text = SEAT.replace("harmonic, frequency: 1.6, rms: 1.0", sines)
    shell = ["excitation.components.1.frequency=3 Hz", "measure.duration=9", "stroke=null"]
    found = scenario(f"{text}stroke: {{limit: 1 cm}}\n", shell)
    assert found.excitation.motion().f == (1.0, 3.0)
    assert found.stroke is None


def test_faulty_overrides_are_named_all_at_once(scenario):
    shell = ["oscillator.mas=8", "strok.limit=20mm", "solver.step=0", "mass", "a=[", "b="]
    with pytest.raises(ScenarioError) as fault:
        scenario(SEAT, shell)
    assert sorted(sentences(fault)) == sorted(
        [
            "--set oscillator.mas=8: unknown key `mas` in oscillator; did you mean `mass`?",
            "--set strok.limit=20mm: unknown key `strok`; did you mean `stroke`?",
            "--set solver.step=0: solver.step must be above 0 s, not 0",
            "--set mass: write KEY=VALUE, such as `friction.kinetic=30`",
            "--set a=[: a value is missing before the end",
            "--set b=: has no value; `null` takes the key away",
        ]
    )


@pytest.mark.parametrize(
    ("key", "value", "sentence"),
    [
        ("solver.step.size", 1, "solver.step is a value; it has no `size`"),
        ("checks.0", "T_a < 1", "checks is a list without entries; it has no `0`"),
        ("friction", None, "there is no `friction` to take away"),
        ("solver.step", object(), "a value of type object has no place in a scenario"),
        ("oscillator.mass", True, "oscillator.mass must be a number [kg], not true"),
    ],
)
def test_faulty_override_from_python_names_its_key(scenario, key, value, sentence):
    with pytest.raises(ScenarioError) as fault:
        scenario(SEAT + "checks: []\n", {key: value})
    assert sentences(fault) == [f"overrides[{key!r}]: {sentence}"]


def test_value_is_read_by_the_rules_of_the_file(scenario):
    shell = [
        "about=on",
        "checks=[T_a < 1, x_r_peak < 25 mm]",
        "friction={law: coulomb, kinetic: 1e1}",
    ]
    found = scenario(SEAT, shell)
    assert found.about == "on"
    assert [check.limit for check in found.checks] == [1.0, 0.025]
    assert found.law().F_fk == 10.0


def test_last_value_of_a_key_counts(scenario):
    assert scenario(SEAT, ["oscillator.mass=80", "oscillator.mass=90"]).oscillator.mass == 90.0


def test_approach_without_friction_is_taken_once_the_friction_is(scenario):
    text = SEAT + "friction: {law: coulomb, kinetic: 15}\n"
    with pytest.raises(ScenarioError, match="1 problem") as fault:
        scenario(text, ["solver.approach=viscous"])
    assert "--set friction=null" in fault.value.problems[0].sentence
    assert scenario(text, ["solver.approach=viscous", "friction=null"]).friction is None


def test_numbers_and_arrays_of_numpy_are_numbers_and_lists(scenario):
    overrides = {
        "oscillator.mass": np.float64(80),
        "oscillator.damping": np.array(400.0),
        "excitation.rms": np.int32(2),
        "sweep": {"excitation.frequency": np.linspace(1, 2, 3)},
    }
    loaded = scenario(SEAT, overrides)
    assert loaded.origin["overrides"] == {
        "oscillator.mass": 80.0,
        "oscillator.damping": 400.0,
        "excitation.rms": 2,
        "sweep": {"excitation.frequency": [1.0, 1.5, 2.0]},
    }
    assert loaded.sweep[0].values == (1.0, 1.5, 2.0)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (np.ones((2, 2)), "sweep.excitation.rms.0 must be a number [m/s²], not a list"),
        (np.array([1.0, 2j]), "a value of type complex has no place in a scenario"),
        (np.ma.masked_equal([1.0, 2.0], 2.0), "sweep.excitation.rms.1 must be a number"),
        ({1.0, 2.0}, "a value of type set has no place in a scenario"),
    ],
)
def test_what_is_no_list_of_numbers_earns_a_sentence(scenario, value, words):
    with pytest.raises(ScenarioError) as fault:
        scenario(SEAT, {"sweep": {"excitation.rms": value}})
    assert words in fault.value.problems[0].sentence


@pytest.mark.parametrize(
    "value",
    [
        np.ma.masked,
        np.ma.masked_array(3.0, True),
        np.datetime64("NaT", "s"),
        np.array(None),
        {"limit": np.ma.masked},
    ],
)
def test_masked_value_of_numpy_takes_no_block_away(scenario, value):
    """It had, as None does: `tolist` makes None of it."""
    text = f"{SEAT}stroke: {{limit: 1 cm}}\n"
    assert scenario(text, {"stroke": None}).stroke is None
    with pytest.raises(ScenarioError) as found:
        scenario(text, {"stroke": value})
    (problem,) = found.value.problems
    assert "with nothing behind its mask has no place in a scenario" in problem.sentence


@pytest.mark.parametrize("overrides", [5, None, [5], {"oscillator.mass=80"}])
def test_overrides_are_a_mapping_or_words(scenario, overrides):
    with pytest.raises(UsageError, match="overrides are a mapping by dotted key, or words"):
        scenario(SEAT, overrides)


@pytest.mark.parametrize("path", [None, {}, 0, b"seat.yaml"])
def test_scenario_is_loaded_from_a_path(path):
    with pytest.raises(UsageError, match="loaded from the path of a file, not from"):
        load(path)


EVERYTHING = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45, dahl: {bristle_stiffness: 1e6}}
excitation:
  {kind: psd, points: [[1, 1], [10, 1]], duration: 10, until: {metric: T_a, half_width: 0.1}}
solver: {approach: stick-slip, step: 2.5e-3, smooth: {form: tanh}, signum: {method: rk4}}
measure: {direction: vertical, weighting: Wk}
sweep:
  sample:
    kind: latin
    count: 3
    seed: 1
    over: {oscillator.damping: {distribution: normal, mean: 9, sd: 1}}
  oscillator.stiffness: {from: 1, to: 2, count: 2, scale: log}
reference: viscous
"""

CHOICES = (
    "solver", "solver.approach", "solver.smooth.form", "solver.signum.method", "reference",
    "friction", "friction.law", "friction.dahl.law", "excitation", "excitation.kind",
    "excitation.until.metric", "measure.direction", "measure.weighting",
    "sweep", "sweep.sample.kind", "sweep.sample.over", "sweep.oscillator.stiffness.scale",
    "sweep.sample",
)  # fmt: skip
"""Keys that choose one of several, and blocks that are chosen so."""

SHAPES = (
    "[]",
    "[signum]",
    "[[1]]",
    "{}",
    "{a: 1}",
    "{a: [b]}",
    "null",
    "3",
    "1.5",
    ".nan",
    "true",
)


@pytest.mark.parametrize("key", CHOICES)
def test_choice_of_any_shape_is_taken_or_refused_in_a_sentence(tmp_path, scenario, key):
    """A list or a block had ended in a traceback: neither can be looked up in a table."""
    assert scenario(EVERYTHING).reference == "viscous"
    for text in SHAPES:
        value = yaml.safe_load(text)
        words = yaml.safe_load(EVERYTHING)
        *steps, last = key.split(".")
        if steps[:1] == ["sweep"] and "stiffness" in steps:
            steps = ["sweep", "oscillator.stiffness"]
        functools.reduce(dict.__getitem__, steps, words)[last] = value
        in_file = yaml.safe_dump(words)
        for source, overrides in (
            (EVERYTHING, [f"{key}={text}"]), (EVERYTHING, {key: value}), (in_file, ()),
        ):  # fmt: skip
            with contextlib.suppress(ScenarioError):
                scenario(source, overrides)


@pytest.mark.parametrize("value", [[], ["normal"], {}, {"a": 1}, 3])
def test_distribution_is_chosen_by_its_name(scenario, value):
    words = yaml.safe_load(EVERYTHING)
    words["sweep"]["sample"]["over"]["oscillator.damping"]["distribution"] = value
    with pytest.raises(ScenarioError, match="distribution must be uniform, normal, lognormal"):
        scenario(yaml.safe_dump(words))


@pytest.mark.parametrize(
    ("value", "given"),
    [("[signum]", "a list"), ("{a: 1}", "a block of keys"), ("[]", "a list")],
)
def test_approach_that_is_no_word_earns_one_sentence(scenario, value, given):
    with pytest.raises(ScenarioError) as fault:
        scenario(SEAT, [f"solver.approach={value}"])
    told = f"--set solver.approach={value}: solver.approach must be text, not {given}"
    assert sentences(fault) == [told]


@pytest.mark.parametrize("key", ["name", "oscillator.mass", "excitation.kind"])
def test_half_a_character_from_python_earns_a_sentence(scenario, key):
    """A lone surrogate is no text that a file could hold."""
    with pytest.raises(ScenarioError, match=r"character U\+D800 has no place in a scenario"):
        scenario(SEAT, {key: "a\ud800"})
