"""What is wrong with scenarios and records, fault by fault: for people, JSON, GitHub."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from drysim.console.terminal import line, stderr, stdout, workflow_command
from drysim.errors import DrysimError, Problem, RecordError
from drysim.wording import several

if TYPE_CHECKING:
    from drysim.console.terminal import Paper


SOURCE = 88
"""Columns of a source line that are shown; of a longer one the part around the fault."""

STYLES = {"error": ("red", ""), "warning": ("yellow", "warning: "), "note": ("dim", "note: ")}
"""Colour and first word of a problem, by its severity."""

GITHUB = {"note": "notice"}
"""Severities that GitHub calls otherwise."""

BEFORE = 40
"""Columns that are shown before the fault in a line that is too long."""


def show_fault(fault: DrysimError) -> None:
    """Show on stderr why a command gave up.

    Parameters
    ----------
    fault : DrysimError
        With its problems, where it has them, and its hint.
    """
    paper = stderr()
    sentence, problems = fault.message, getattr(fault, "problems", ())
    if isinstance(fault, RecordError):
        sentence, problems = f"{fault.problem.file} cannot be used", (fault.problem,)
    line(paper, ("error: ", "bold red"), sentence)
    _list(paper, problems)
    if fault.hint:
        line(paper)
        line(paper, fault.hint)


def show_problems(found: Mapping[str, Sequence[Problem]], form: str = "text") -> None:
    """Show on stdout what is wrong with scenario files.

    Parameters
    ----------
    found : mapping
        Problems by file, as it was named; none for a sound file.
    form : str
        `text`, `json` or `github`.
    """
    if form == "json":
        print(json.dumps(_object(found), indent=2))
        return
    paper = stdout()
    if form == "github":
        for problems in found.values():
            for problem in problems:
                workflow_command(paper, _annotation(problem))
        return
    for at, (file, problems) in enumerate(found.items()):
        if at:
            line(paper)
        _verdict(paper, file, problems)
        _list(paper, problems)


def _verdict(paper: Paper, file: str, problems: Sequence[Problem]) -> None:
    """Say in one line whether a file is a scenario."""
    errors = sum(problem.severity == "error" for problem in problems)
    warnings = sum(problem.severity == "warning" for problem in problems)
    if errors:
        count = several(errors, "problem")
        line(paper, ("error: ", "bold red"), f"{file} is not a scenario yet: {count}")
    elif warnings:
        count = several(warnings, "warning")
        line(paper, ("ok: ", "green"), f"{file} is a scenario, with {count}")
    else:
        line(paper, ("ok: ", "green"), f"{file} is a scenario")


def _list(paper: Paper, problems: Sequence[Problem]) -> None:
    """Show problems, each with its place, its source line and a caret below the fault."""
    if problems:
        line(paper)
    for problem in problems:
        style, word = STYLES[problem.severity]
        line(paper, (f"{problem.place}: ", "bold"), (word, style), problem.sentence)
        if problem.line and problem.source:
            _show_source(paper, problem, style)


def _show_source(paper: Paper, problem: Problem, style: str) -> None:
    """Show the faulty line and underline the fault."""
    from rich.cells import cell_len

    source, column = _excerpt(problem)
    gutter = f"  {problem.line} │ "
    line(paper, (gutter, "dim"), source.rstrip())
    if problem.column:
        width = cell_len(source[column : column + problem.width])
        blank = " " * (len(gutter) - 2) + "│ " + " " * cell_len(source[:column])
        line(paper, (blank, "dim"), ("^" * max(width, 1), style))


def _excerpt(problem: Problem) -> tuple[str, int]:
    """Give the faulty line, of a long one what is around the fault, and its place there."""
    source, column = problem.source, max(problem.column - 1, 0)
    if len(source) > SOURCE:
        first = max(column - BEFORE, 0)
        source, column = source[first : first + SOURCE], column - first
    return "".join(sign if sign.isprintable() else " " for sign in source), column


def _object(found: Mapping[str, Sequence[Problem]]) -> dict[str, object]:
    """Give all problems as one JSON object; what has no line or column has none there."""
    files = [
        {
            "file": file,
            "sound": all(problem.severity != "error" for problem in problems),
            "problems": [
                {
                    **asdict(problem),
                    "line": problem.line or None,
                    "column": problem.column or None,
                    "source": _excerpt(problem)[0],
                }
                for problem in problems
            ],
        }
        for file, problems in found.items()
    ]
    return {"format": 1, "files": files}


def _annotation(problem: Problem) -> str:
    """Give a problem as a workflow command of GitHub, escaped as it wants it."""
    places = {"file": problem.file, "line": problem.line, "col": problem.column}
    known = ",".join(f"{key}={_property(str(value))}" for key, value in places.items() if value)
    level = GITHUB.get(problem.severity, problem.severity)
    return f"::{level} {known}::{_data(problem.sentence)}"


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
