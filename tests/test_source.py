"""Files and what they earn: every pair in problems/ is a faulty file and the exact words."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import pytest

from drysim import yaml_document
from drysim.errors import Problem, ScenarioError
from drysim.scenario.load import load
from drysim.yaml_document import Unreadable, dump, read

PROBLEMS = Path(__file__).parent / "problems"


def told(problem: Problem) -> str:
    """Give a problem as the contract lays it out."""
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
    assert problem.sentence.startswith("excitation.kind is required; known are rest, harmonic")


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
    """Give what a YAML text means."""

    def meant(text: str) -> dict[str, object]:
        (tmp_path / "a.yaml").write_text(text)
        return read(tmp_path / "a.yaml").value

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
    assert read(tmp_path / "a.yaml", ["all.1.f=2"]).value == {"all": [{"f": 1}, {"f": 2}]}


def test_document_names_its_file_and_hash(tmp_path):
    file = tmp_path / "a.yaml"
    file.write_bytes(b"\xef\xbb\xbfa: \xc3\xbc\r\n")
    document = read(file)
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
    """Give the sentence for a path that cannot be read."""
    with pytest.raises(Unreadable) as fault:
        read(path)
    assert fault.value.problem.file == str(path)
    return fault.value.problem.sentence


def test_missing_file_is_refused_with_its_neighbour(tmp_path):
    (tmp_path / "seat.yaml").touch()
    meant = tmp_path / "seat.yaml"
    assert refusal(tmp_path / "saet.yaml") == f"no such file; did you mean `{meant}`?"
    assert refusal(tmp_path / "no" / "seat.yaml") == "no such file"


def test_link_that_leads_nowhere_is_told_as_such_and_not_as_itself(tmp_path):
    (tmp_path / "seat.yaml").symlink_to("moved.yaml")
    sentence = "no such file: it is a link that leads nowhere"
    assert refusal(tmp_path / "seat.yaml") == sentence


def test_folder_is_refused_with_the_scenario_in_it(tmp_path):
    assert refusal(tmp_path) == "this is a folder; name a file in it"
    (tmp_path / "seat.yaml").touch()
    meant = tmp_path / "seat.yaml"
    assert refusal(tmp_path) == f"this is a folder; did you mean `{meant}`?"


def test_pipe_is_refused_without_waiting_for_it(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert refusal(tmp_path / "pipe") == "this is a pipe; name a file"
    assert refusal("/dev/zero") == "this is a device; name a file"


def test_file_above_a_megabyte_is_refused(tmp_path):
    (tmp_path / "a.yaml").write_text("#" + "x" * 1_000_000)
    assert "larger than 1 MB" in refusal(tmp_path / "a.yaml")


def test_name_that_no_file_can_have_is_refused():
    assert "cannot be read" in refusal("a\0b")


def test_a_megabyte_of_digits_is_read_at_once(tmp_path):
    (tmp_path / "a.yaml").write_text(f"a: {'1' * 900_000}x\nb: [{'1' * 90_000}]\n")
    assert read(tmp_path / "a.yaml").value["b"] == [float("inf")]


def test_any_letter_lost_or_doubled_is_a_scenario_or_a_located_problem(tmp_path):
    file = tmp_path / "seat.yaml"
    text = (PROBLEMS / "contract-example.yaml").read_text()
    for i in range(len(text)):
        for slip in (text[:i] + text[i + 1 :], text[:i] + text[i] + text[i:]):
            file.write_text(slip)
            with pytest.raises(ScenarioError) as fault:
                load(file)
            assert all(p.column - 1 <= len(p.source) for p in fault.value.problems)
