"""Problems of scenarios and records, one by one: as text, JSON or GitHub annotations."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from drysim.console.terminal import print_line, print_workflow_command, stderr, stdout
from drysim.errors import DrysimError, Problem, RecordError
from drysim.wording import format_count

if TYPE_CHECKING:
    from drysim.console.terminal import AnyConsole


MAX_SOURCE_WIDTH = 88
"""Columns shown of a source line; of a longer line the part around the problem is shown."""

SEVERITY_STYLES = {
    "error": ("red", ""),
    "warning": ("yellow", "warning: "),
    "note": ("dim", "note: "),
}
"""Colour and first word of a problem, by severity."""

GITHUB_LEVELS = {"note": "notice"}
"""Severities that GitHub names differently."""

SOURCE_CONTEXT = 40
"""Columns shown before the problem in a line that is too long."""


def show_error(fault: DrysimError) -> None:
    """Show on stderr why a command failed.

    Parameters
    ----------
    fault : DrysimError
        With its problems, if it has any, and its hint.
    """
    console = stderr()
    sentence, problems = fault.message, getattr(fault, "problems", ())
    if isinstance(fault, RecordError):
        problems = (fault.problem,)
        sentence = f"{(fault.problem.named_at or fault.problem).file}: 1 error"
    print_line(console, ("error: ", "bold red"), sentence)
    _print_problems(console, problems)
    if fault.hint:
        print_line(console)
        for line in fault.hint.split("\n"):
            print_line(console, line)


def show_problems(
    problems_by_file: Mapping[str, Sequence[Problem]], form: str = "text", strict: bool = False
) -> None:
    """Show the problems of scenario files on stdout.

    Parameters
    ----------
    problems_by_file : mapping
        Problems by file as it was named; none for a valid file.
    form : str
        `text`, `json` or `github`.
    strict : bool
        Whether warnings count as errors.
    """
    if form == "json":
        print(json.dumps(_to_dict(problems_by_file), indent=2))
        return
    console = stdout()
    if form == "github":
        for problems in problems_by_file.values():
            for problem in problems:
                # The record may not be in the pull request; the scenario is.
                for place in filter(None, (problem.named_at, problem)):
                    print_workflow_command(console, _github_annotation(place, strict))
        return
    for number, (file, problems) in enumerate(problems_by_file.items()):
        if number:
            print_line(console)
        _print_heading(console, file, problems, strict)
        _print_problems(console, problems)


def _print_heading(
    console: AnyConsole, file: str, problems: Sequence[Problem], strict: bool
) -> None:
    """Print one line per file: valid or not, with the number of problems."""
    errors = sum(problem.severity == "error" for problem in problems)
    warnings = sum(problem.severity == "warning" for problem in problems)
    if errors:
        count = format_count(errors, "error")
        print_line(console, ("error: ", "bold red"), f"{file}: {count}")
    elif warnings:
        count = format_count(warnings, "warning")
        if strict:
            print_line(console, ("fails: ", "bold red"), f"{file}: {count} under --strict")
            return
        print_line(console, ("ok: ", "green"), f"{file}: {count}")
    else:
        print_line(console, ("ok: ", "green"), file)


def _print_problems(console: AnyConsole, problems: Sequence[Problem]) -> None:
    """Print problems, each with its location, its source line and a caret below the fault."""
    if problems:
        print_line(console)
    for problem in problems:
        style, word = SEVERITY_STYLES[problem.severity]
        print_line(console, (f"{problem.place}: ", "bold"), (word, style), problem.sentence)
        if problem.line and problem.source:
            _print_source(console, problem, style)


def _print_source(console: AnyConsole, problem: Problem, style: str) -> None:
    """Print the faulty line and underline the fault."""
    from rich.cells import cell_len

    source, column = _excerpt(problem)
    gutter = f"  {problem.line} │ "
    print_line(console, (gutter, "dim"), source.rstrip())
    if problem.column:
        width = cell_len(source[column : column + problem.width])
        blank = " " * (len(gutter) - 2) + "│ " + " " * cell_len(source[:column])
        remark = f" {problem.remark}" if problem.remark else ""
        print_line(console, (blank, "dim"), ("^" * max(width, 1), style), (remark, "dim"))


def _excerpt(problem: Problem) -> tuple[str, int]:
    """Return the faulty line, cut to the part around the fault, and the fault's column."""
    source, column = problem.source, max(problem.column - 1, 0)
    if len(source) > MAX_SOURCE_WIDTH:
        first = max(column - SOURCE_CONTEXT, 0)
        source, column = source[first : first + MAX_SOURCE_WIDTH], column - first
    return "".join(
        character if character.isprintable() else " " for character in source
    ), column


def _to_dict(problems_by_file: Mapping[str, Sequence[Problem]]) -> dict[str, object]:
    """Return all problems as one JSON object; an unknown line or column is None."""
    files = [
        {
            "file": file,
            "sound": all(problem.severity != "error" for problem in problems),
            "problems": [
                {
                    **{key: x for key, x in asdict(problem).items() if key != "named_at"},
                    "line": problem.line or None,
                    "column": problem.column or None,
                    "source": _excerpt(problem)[0],
                }
                for problem in problems
            ],
        }
        for file, problems in problems_by_file.items()
    ]
    return {"format": 1, "files": files}


def _github_annotation(problem: Problem, strict: bool) -> str:
    """Return a problem as a GitHub workflow command; if strict, a warning is an error."""
    places = {"file": problem.file, "line": problem.line, "col": problem.column}
    properties = ",".join(
        f"{key}={_escape_property(str(value))}" for key, value in places.items() if value
    )
    levels = GITHUB_LEVELS | ({"warning": "error"} if strict else {})
    level = levels.get(problem.severity, problem.severity)
    return f"::{level} {properties}::{_escape_data(problem.sentence)}"


def _escape_data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _escape_property(text: str) -> str:
    return _escape_data(text).replace(":", "%3A").replace(",", "%2C")
