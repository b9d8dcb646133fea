"""Files and what they earn: every pair in problems/ is a faulty file and the exact words."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
from pathlib import Path

import numpy as np
import pytest
import yaml

from drysim import yaml_document
from drysim.errors import Problem, ScenarioError, UsageError
from drysim.scenario.load import load
from drysim.yaml_document import UnreadableError, dump, read_document

PROBLEMS = Path(__file__).parent / "problems"


def told(problem: Problem) -> str:
    """Return a problem as the contract lays it out."""
    if not problem.line:
        return f"{problem.file}: {problem.sentence}"
    number = str(problem.line)
    return (
        f"{problem.file}:{problem.line}:{problem.column}: {problem.sentence}\n"
        f"  {number} │ {problem.source}\n"
        f"  {' ' * len(number)} │ {' ' * (problem.column - 1)}{'^' * problem.width}"
    )


@pytest.mark.parametrize("file", sorted(PROBLEMS.glob("*.yaml")), ids=lambda file: file.stem)
def test_faulty_file_earns_exactly_these_words(file, monkeypatch):
    monkeypatch.chdir(PROBLEMS)
    with pytest.raises(ScenarioError) as fault:
        load(file.name)
    words = [f"error: {fault.value.message}", "", *map(told, fault.value.problems)]
    assert "\n".join(words) + "\n" == file.with_suffix(".txt").read_text()


def test_missing_kind_is_asked_for_with_the_whole_shelf(tmp_path):
    text = (PROBLEMS / "mistyped-block.yaml").read_text().replace("exitation", "excitation")
    (tmp_path / "seat.yaml").write_text(text.replace("  kind: harmonic\n", ""))
    with pytest.raises(ScenarioError) as fault:
        load(tmp_path / "seat.yaml")
    (problem,) = fault.value.problems
    assert problem.sentence.startswith("excitation.kind is required; use one of rest, harmonic")


def test_every_pair_of_problems_is_complete():
    assert {f.stem for f in PROBLEMS.glob("*.yaml")} == {f.stem for f in PROBLEMS.glob("*.txt")}


@pytest.mark.parametrize("file", sorted(PROBLEMS.glob("*.yaml")), ids=lambda file: file.stem)
def test_faults_stand_at_the_same_place_without_the_fast_parser(file, monkeypatch):
    def places() -> list[tuple[int, int]]:
        with pytest.raises(ScenarioError) as fault:
            load(file)
        return [(problem.line, problem.column) for problem in fault.value.problems]

    fast = places()
    monkeypatch.setattr(yaml_document, "_LOADER", yaml_document.yaml.SafeLoader)
    assert places() == fast


@pytest.fixture
def value(tmp_path):
    """Return what a YAML text means."""

    def meant(text: str) -> dict[str, object]:
        (tmp_path / "a.yaml").write_text(text)
        return read_document(tmp_path / "a.yaml").value

    return meant


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("1e3", 1000.0),
        ("2.5e-3", 0.0025),
        (".5", 0.5),
        ("-7", -7),
        ("010", 10),
        ("+1.", 1.0),
        ("9" * 30, 1e30),
        ("true", True),
        ("FALSE", False),
        ("'1e3'", "1e3"),
        *((word, word) for word in ["on", "No", "yes", "1:30", "0x10", "1_000", "2001-01-01"]),
        *((word, word) for word in ["inf", "nan", "25 mm", "1e", "e3", ".", "-"]),
        ("-.inf", -float("inf")),
        ("|\n  two\n  lines", "two\nlines\n"),
    ],
)
def test_only_numbers_are_numbers_and_words_stay_words(value, text, meant):
    found = value(f"a: {text}\n" if text != "-" else "a: '-'\n")["a"]
    assert (type(found), found) == (type(meant), meant)


def test_keys_are_always_words(value):
    assert value("on: 1\n2: 3\n1e3: 4\n") == {"on": 1, "2": 3, "1e3": 4}


def test_an_alias_repeats_its_anchor_and_may_be_overridden_alone(tmp_path):
    (tmp_path / "a.yaml").write_text("all: [&sine {f: 1}, *sine]\n")
    assert read_document(tmp_path / "a.yaml", ["all.1.f=2"]).value == {
        "all": [{"f": 1}, {"f": 2}]
    }


def test_document_names_its_file_and_hash(tmp_path):
    file = tmp_path / "a.yaml"
    file.write_bytes(b"\xef\xbb\xbfa: \xc3\xbc\r\n")
    document = read_document(file)
    assert document.value == {"a": "ü"}
    assert document.file == str(file)
    assert document.sha256 == hashlib.sha256(file.read_bytes()).hexdigest()


@pytest.mark.parametrize(
    "text",
    ["1e3", "on", "1:30", "null", "~", "", "x: y # z", "-", " in ", "two\nlines", "ü²", "<<"],
)
def test_what_is_dumped_reads_back_the_same(value, text):
    mapping = {"a": text, "b": [1e-5, 1e22, 0.1, -3, True], "c": {"d": {"e": text}}}
    assert value(dump(mapping)) == mapping


def refusal(path) -> str:
    """Return the sentence for a path that cannot be read."""
    with pytest.raises(UnreadableError) as fault:
        read_document(path)
    assert fault.value.problem.file == str(path)
    return fault.value.problem.sentence


def test_what_is_no_file_of_a_scenario_is_refused_with_a_remedy(tmp_path):
    meant = tmp_path / "seat.yaml"
    assert refusal(tmp_path) == "this is a folder; name a file in it"
    meant.touch()
    assert refusal(tmp_path) == f"this is a folder; did you mean `{meant}`?"
    assert refusal(tmp_path / "saet.yaml") == f"no such file; did you mean `{meant}`?"
    assert refusal(tmp_path / "no" / "seat.yaml") == "no such file"
    (tmp_path / "link.yaml").symlink_to("moved.yaml")
    assert refusal(tmp_path / "link.yaml") == "no such file: broken symbolic link"
    assert refusal(tmp_path / "*.yml") == "no such file: no file has a name of this pattern"
    os.mkfifo(tmp_path / "pipe")
    assert refusal(tmp_path / "pipe") == "this is a pipe; name a file"
    assert refusal("/dev/zero") == "this is a device; name a file"
    meant.write_text("#" + "x" * 1_000_000)
    assert "larger than 1 MB" in refusal(meant)
    assert "cannot be read" in refusal("a\0b")


def test_a_megabyte_of_digits_is_read_at_once(tmp_path):
    (tmp_path / "a.yaml").write_text(f"a: {'1' * 900_000}x\nb: [{'1' * 90_000}]\n")
    assert read_document(tmp_path / "a.yaml").value["b"] == [float("inf")]


def test_any_letter_lost_or_doubled_is_a_scenario_or_a_located_problem(tmp_path):
    file = tmp_path / "seat.yaml"
    text = (PROBLEMS / "contract-example.yaml").read_text()
    for i in range(len(text)):
        for slip in (text[:i] + text[i + 1 :], text[:i] + text[i] + text[i:]):
            file.write_text(slip)
            with pytest.raises(ScenarioError) as fault:
                load(file)
            assert all(p.column - 1 <= len(p.source) for p in fault.value.problems)


# Values laid over a scenario: the same road from the shell and from Python.


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
    assert {*sentences(fault)} == {
        "--set oscillator.mas=8: unknown key `mas` in oscillator; did you mean `mass`?",
        "--set strok.limit=20mm: unknown key `strok`; did you mean `stroke`?",
        "--set solver.step=0: solver.step must be above 0 s, not 0",
        "--set mass: write KEY=VALUE, such as `friction.kinetic=30`",
        "--set a=[: a value is missing before the end",
        "--set b=: has no value; `null` removes the key",
    }


@pytest.mark.parametrize(
    ("key", "value", "sentence"),
    [
        ("solver.step.size", 1, "solver.step is a value; it has no `size`"),
        ("checks.0", "T_a < 1", "checks is a list without entries; it has no `0`"),
        ("friction", None, "there is no `friction` to remove"),
        ("solver.step", object(), "a value of type object is not allowed in a scenario"),
        ("oscillator.mass", True, "oscillator.mass must be a number [kg], not true"),
    ],
)
def test_faulty_override_from_python_names_its_key(scenario, key, value, sentence):
    with pytest.raises(ScenarioError) as fault:
        scenario(SEAT + "checks: []\n", {key: value})
    assert sentences(fault) == [f"overrides[{key!r}]: {sentence}"]


def test_value_is_read_by_the_rules_of_the_file_and_the_last_counts(scenario):
    shell = ["about=on", "checks=[T_a < 1, x_r_peak < 25 mm]"]
    shell += ["friction={law: coulomb, kinetic: 1e1}"]
    found = scenario(SEAT, shell)
    assert found.about == "on"
    assert [check.limit for check in found.checks] == [1.0, 0.025]
    assert found.law().F_fk == 10.0
    assert scenario(SEAT, ["oscillator.mass=80", "oscillator.mass=90"]).oscillator.mass == 90.0


def test_approach_without_friction_is_taken_once_the_friction_is(scenario):
    text = SEAT + "friction: {law: coulomb, kinetic: 15}\n"
    with pytest.raises(ScenarioError, match="1 error") as fault:
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
        (np.ones((2, 2)), "sweep.excitation.rms #1 must be a number [m/s²], not a list"),
        (np.array([1.0, 2j]), "a value of type complex is not allowed in a scenario"),
        (np.ma.masked_equal([1.0, 2.0], 2.0), "sweep.excitation.rms #2 must be a number"),
        ({1.0, 2.0}, "a value of type set is not allowed in a scenario"),
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
    text = f"{SEAT}stroke: {{limit: 1 cm}}\n"
    assert scenario(text, {"stroke": None}).stroke is None
    with pytest.raises(ScenarioError) as found:
        scenario(text, {"stroke": value})
    (problem,) = found.value.problems
    assert "a masked value of type " in problem.sentence


@pytest.mark.parametrize("overrides", [5, None, [5], {"oscillator.mass=80"}])
def test_overrides_are_a_mapping_or_words(scenario, overrides):
    with pytest.raises(UsageError, match="overrides must be a mapping by dotted key, or words"):
        scenario(SEAT, overrides)


@pytest.mark.parametrize("path", [None, {}, 0, b"seat.yaml"])
def test_scenario_is_loaded_from_a_path(path):
    with pytest.raises(UsageError, match="must be given as the path of a file, not as"):
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
    *("[]", "[signum]", "[[1]]", "{}", "{a: 1}", "{a: [b]}"),
    *("null", "3", "1.5", ".nan", "true"),
)


@pytest.mark.parametrize("key", CHOICES)
def test_choice_of_any_shape_is_taken_or_refused_in_a_sentence(tmp_path, scenario, key):
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
    with pytest.raises(ScenarioError, match=r"character U\+D800 is not allowed in a scenario"):
        scenario(SEAT, {key: "a\ud800"})
