"""JUnit XML, which CI services show: a suite for each scenario, a test case for each check."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

from drysim.errors import DrysimError, Problem
from drysim.output.folder import check_new_file, save_file
from drysim.wording import format_count, sanitise

FAILURE, ERROR, SKIPPED = "failure", "error", "skipped"
"""What a test case may contain, if it did not pass."""

MARK = '<testsuites name="drysim"'
"""The element by which a file of drysim is recognised."""

COMPLETE, NO_WARNINGS, VALID = "complete", "no warnings", "valid"
"""Names of the test cases besides the checks."""


class JunitCase(NamedTuple):
    """A check, or something else that passes or not."""

    name: str
    outcome: str = ""
    """`failure`, `error`, `skipped`, or empty if it passed."""
    message: str = ""
    lines: Sequence[str] = ()
    """What else is known."""
    time: float = 0.0
    """Time that it took [s]."""


class Suite(NamedTuple):
    """The test cases of a scenario."""

    name: str
    cases: Sequence[JunitCase]
    output: Sequence[str] = ()
    """Warnings and notes that make nothing fail."""


def result_suite(fields: Mapping[str, Any], strict: bool, time: float) -> Suite:
    """Return the suite of a result.

    Parameters
    ----------
    fields : mapping
        The content of drysim.json.
    strict : bool
        Whether warnings and skipped checks are failures.
    time : float
        Time of the computation [s].
    """
    summary = fields["summary"]
    warnings = [warning["sentence"] for warning in fields["warnings"]]
    cases = [JunitCase(COMPLETE, time=time)]
    if not fields["complete"]:
        faults = [note["sentence"] for note in summary["faults"]]
        message = "the numerics failed in some cases"
        cases = [JunitCase(COMPLETE, ERROR, message, faults, time)]
    if strict:
        outcome = FAILURE if warnings else ""
        count = format_count(len(warnings), "warning")
        cases.append(JunitCase(NO_WARNINGS, outcome, count, warnings))
    cases += [
        check_case(check, judgement["sentence"], strict)
        for check, judgement in zip(fields["checks"], summary["checks"], strict=True)
    ]
    return Suite(fields["scenario"]["name"], cases, [] if strict else warnings)


def check_case(check: Mapping[str, Any], sentence: str, strict: bool) -> JunitCase:
    """Return the test case of a check, as in drysim.json; `sentence` says how it was judged."""
    name, unit = check["check"], check["unit"].replace("-", "")
    if check["passed"]:
        return JunitCase(name)
    if check["passed"] is None:
        return JunitCase(name, FAILURE if strict else SKIPPED, sentence)
    value = check.get("reason") if check["value"] is None else f"{check['value']!r} {unit}"
    lines = [f"metric: {check['metric']}", f"value: {value}"]
    lines.append(f"limit: {check['operator']} {check['limit']!r} {unit}")
    return JunitCase(name, FAILURE, sentence, lines)


def fault_suite(name: str, fault: DrysimError, time: float) -> Suite:
    """Return the suite of a scenario without a result."""
    return Suite(name, [JunitCase(COMPLETE, ERROR, fault.message, [], time)])


def validation_suite(file: str, problems: Iterable[Problem], failing: Sequence[str]) -> Suite:
    """Return the suite of a validated file; `failing` are the severities that make it fail."""
    problems = list(problems)
    faults = [str(problem) for problem in problems if problem.severity in failing]
    others = [str(problem) for problem in problems if problem.severity not in failing]
    message = faults[0] if len(faults) == 1 else format_count(len(faults), "problem")
    case = JunitCase(VALID, FAILURE if faults else "", message, faults)
    return Suite(file, [case], others)


def check_junit(file: Path, folders: Sequence[Path] = ()) -> None:
    """Verify, before any work, that a file may be written; errors as of `check_new_file`."""
    check_new_file(file, folders, MARK, "--junit")


def save_junit(file: Path, suites: Sequence[Suite]) -> None:
    """Write suites into a file, atomically."""
    save_file(file, junit_text(suites))


def junit_text(suites: Sequence[Suite]) -> str:
    """Return suites as JUnit XML."""
    every = [case for suite in suites for case in suite.cases]
    root = ElementTree.Element("testsuites", {"name": "drysim", **counts(every)})
    for suite in suites:
        name = sanitise(suite.name)
        element = ElementTree.SubElement(
            root, "testsuite", {"name": name, **counts(suite.cases)}
        )
        for case in suite.cases:
            attributes = {"classname": name, "name": sanitise(case.name)}
            child = ElementTree.SubElement(
                element, "testcase", attributes | {"time": f"{case.time:.3f}"}
            )
            if case.outcome:
                inner = ElementTree.SubElement(child, case.outcome)
                inner.set("message", sanitise(case.message))
                inner.text = text_of(dict.fromkeys([case.message, *case.lines]))
        if suite.output:
            ElementTree.SubElement(element, "system-out").text = text_of(suite.output)
    ElementTree.indent(root)
    body = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{body}\n'


def text_of(lines: Iterable[str]) -> str:
    """Return lines as text in which every character is one of XML."""
    return "\n".join(map(sanitise, lines))


def counts(cases: Sequence[JunitCase]) -> dict[str, str]:
    """Return the attributes of a suite that count its test cases."""
    outcomes = [case.outcome for case in cases]
    return {
        "tests": str(len(cases)),
        "failures": str(outcomes.count(FAILURE)),
        "errors": str(outcomes.count(ERROR)),
        "skipped": str(outcomes.count(SKIPPED)),
        "time": f"{sum(case.time for case in cases):.3f}",
    }
