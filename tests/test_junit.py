"""`--junit`: what passes and fails as JUnit XML, in the structure that CI services read."""

from __future__ import annotations

import json
from inspect import signature
from pathlib import Path
from xml.etree import ElementTree

import pytest
from every_kind import WAYS, result_of
from seat import SEAT

from drysim.cli import COMMANDS
from drysim.errors import SolverError
from drysim.output import junit
from drysim.output.junit import JunitCase, Suite, junit_text, result_suite

COUNTED = {"tests": "testcase", "failures": "failure", "errors": "error", "skipped": "skipped"}
"""Attributes of a suite, and the elements that they count."""

ATTRIBUTES = {
    "testsuites": {"name", "time", *COUNTED},
    "testsuite": {"name", "time", *COUNTED},
    "testcase": {"classname", "name", "time"},
    "failure": {"message"},
    "error": {"message"},
    "skipped": {"message"},
    "system-out": set(),
}
CONTENT = {
    "testsuites": {"testsuite"},
    "testsuite": {"testcase", "system-out"},
    "testcase": {"failure", "error", "skipped"},
}
"""Attributes and children of the elements, a part of what the schemas of Jenkins and GitLab
allow."""


def suites_of(text):
    """Return the suites in a text, which has the structure of JUnit XML."""
    root = ElementTree.fromstring(text)
    assert root.tag == "testsuites"
    for element in root.iter():
        assert set(element.keys()) == ATTRIBUTES[element.tag]
        assert {child.tag for child in element} <= CONTENT.get(element.tag, set())
        assert float(element.get("time", 0.0)) >= 0.0
    for element in (root, *root):
        for attribute, tag in COUNTED.items():
            assert int(element.get(attribute)) == len([*element.iter(tag)]), attribute
    for case in root.iter("testcase"):
        assert len(case) <= 1
        assert case.get("name")
    return list(root)


def read(file):
    """Return suite, test case, outcome and message of each test case in a file."""
    return [
        (suite.get("name"), case.get("name"), *outcome_of(case))
        for suite in suites_of(Path(file).read_text(encoding="utf-8"))
        for case in suite.iter("testcase")
    ]


def outcome_of(case):
    """Return outcome and message of a test case."""
    return (case[0].tag, case[0].get("message")) if len(case) else ("", "")


def test_each_check_of_each_scenario_is_a_test_case(drysim, seat):
    checks = "checks: [T_a < 9, x_r_peak < 1 mm, T_a < 1 at friction.kinetic > 99]\n"
    seat.write_text(SEAT + checks)
    seat.with_name("other.yaml").write_text(SEAT.replace("name: seat", "name: other"))
    words = ["run", seat, seat.with_name("other.yaml"), "--no-plots", "--quiet"]
    assert drysim(*words, "--junit", "reports/junit.xml").code == 1
    *cases, skipped, last = read("reports/junit.xml")
    assert cases[:2] == [("seat", "complete", "", ""), ("seat", "T_a < 9", "", "")]
    name, check, outcome, message = cases[2]
    assert (name, check, outcome) == ("seat", "x_r_peak < 1 mm", "failure")
    assert message.startswith("x_r_peak < 1 mm, with ")
    assert message.endswith(" mm")
    assert skipped[1:3] == ("T_a < 1 at friction.kinetic > 99", "skipped")
    assert last == ("other", "complete", "", "")
    (suite, _) = suites_of(Path("reports/junit.xml").read_text(encoding="utf-8"))
    value = json.loads(Path("out/seat/drysim.json").read_text())["metrics"]["x_r_peak"]
    text = next(suite.iter("failure")).text
    assert text.splitlines()[1:] == [
        "metric: x_r_peak", f"value: {value!r} m", "limit: < 0.001 m",
    ]  # fmt: skip


def test_strict_makes_failures_of_warnings_and_of_skipped_checks(drysim, seat):
    seat.write_text(
        SEAT + "checks: [T_a < 1 at friction.kinetic > 99]\nstroke: {limit: 1 mm}\n"
    )
    words = ["run", seat, "--no-plots", "--quiet", "--junit", "junit.xml"]
    assert drysim(*words).code == 0
    assert [outcome for *_, outcome, _ in read("junit.xml")] == ["", "skipped"]
    (suite,) = suites_of(Path("junit.xml").read_text(encoding="utf-8"))
    assert "the stroke limit of 1 mm is exceeded" in suite.find("system-out").text
    assert drysim(*words, "--strict").code == 1
    cases = read("junit.xml")
    assert [(case, outcome) for _, case, outcome, _ in cases] == [
        ("complete", ""),
        ("no warnings", "failure"),
        ("T_a < 1 at friction.kinetic > 99", "failure"),
    ]


def test_each_validated_file_is_a_test_case(drysim, seat):
    faulty, doubtful = seat.with_name("faulty.yaml"), seat.with_name("doubtful.yaml")
    faulty.write_text(SEAT.replace("stiffness", "stifness"))
    doubtful.write_text(SEAT + "stroke: {limit: 60}\n")
    words = ["validate", "seat.yaml", "faulty.yaml", "doubtful.yaml", "--junit", "junit.xml"]
    assert drysim(*words).code == 2
    cases = read("junit.xml")
    assert [case[:3] for case in cases] == [
        ("seat.yaml", "valid", ""),
        ("faulty.yaml", "valid", "failure"),
        ("doubtful.yaml", "valid", ""),
    ]
    assert cases[1][3].startswith("faulty.yaml:3:")
    assert drysim(*words, "--strict").code == 2
    assert [case[2] for case in read("junit.xml")] == ["", "failure", "failure"]


def test_numerics_that_fail_are_an_error(drysim, seat, monkeypatch):
    from drysim.study import run

    def solve(case):
        raise SolverError("the numerics failed at t = 1 s")

    monkeypatch.setattr(run, "solve", solve)
    assert drysim("run", seat, "--junit", "junit.xml").code == 3
    assert read("junit.xml") == [
        ("seat", "complete", "error", "the numerics failed at t = 1 s")
    ]


@pytest.mark.parametrize("kind", [kind for kind in WAYS if kind not in ("bench", "hard")])
@pytest.mark.parametrize("strict", [False, True])
def test_something_fails_where_the_exit_code_is_not_0(kind, strict, tmp_path):
    result = result_of(kind)
    folder = result.save(tmp_path / kind, plots=False)
    fields = json.loads((folder / "drysim.json").read_text())
    (suite,) = suites_of(junit_text([result_suite(fields, strict, 1.5)]))
    failed = suite.get("failures") != "0" or suite.get("errors") != "0"
    assert failed == (result.exit_code(strict) != 0)
    assert float(suite.get("time")) == 1.5


def test_any_text_is_well_formed():
    text = "".join(map(chr, range(0x300))) + "\ud800\ufffe\uffff\U0001f600]]>&lt;<!--"
    cases = [JunitCase(text, outcome, text, [text, text]) for outcome in COUNTED.values()][1:]
    (suite,) = suites_of(junit_text([Suite(text, cases, [text])]))
    assert "]]>&lt;<!--" in suite.get("name")
    assert "\\x00" in suite.find("system-out").text


@pytest.mark.parametrize(
    ("file", "sentence"),
    [
        ("seat.yaml", "was not written by drysim; it stays as it is"),
        ("out/seat/junit.xml", "would be a file in out/seat that is not part of the result"),
        ("seat.yaml/junit.xml", "is not a folder"),
        (".", "is a folder"),
    ],
)
def test_file_of_the_user_is_not_replaced_and_nothing_is_computed(drysim, seat, file, sentence):
    for command in ("run", "validate"):
        done = drysim(command, seat, "--junit", file)
        if (command, file) != ("validate", "out/seat/junit.xml"):
            assert (done.code, done.out) == (2, "")
            assert sentence in done.err
            assert [path.name for path in seat.parent.iterdir()] == ["seat.yaml"]
    assert seat.read_text() == SEAT


def test_file_that_cannot_be_written_after_the_work_ends_with_1(drysim, seat, monkeypatch):
    monkeypatch.setattr(junit, "save_file", broken_disk)
    assert drysim("run", seat, "--no-plots", "-q", "--junit", "junit.xml").code == 1
    assert Path("out/seat/drysim.json").exists()


def broken_disk(file, text):
    """Fail as `save_file` does on a full disk."""
    from drysim.output.folder import translate_os_errors

    with translate_os_errors(file):
        raise OSError(28, "No space left on device")


def test_each_command_that_judges_checks_has_the_option():
    judging = [command for command in COMMANDS if "strict" in signature(command).parameters]
    assert len(judging) > 5
    lacking = [command for command in judging if "junit" not in signature(command).parameters]
    assert lacking == []
