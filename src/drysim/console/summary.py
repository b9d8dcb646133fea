"""Summary of a result on the terminal: title, scene, numbers, checks, folder, warnings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from drysim.console.terminal import (
    print_line,
    print_paragraph,
    print_table,
    stderr,
    stdout,
    wrap,
)
from drysim.study.summary import BAD, GOOD, PLAIN
from drysim.wording import format_count

if TYPE_CHECKING:
    from drysim.console.terminal import AnyConsole
    from drysim.errors import WarningMessage
    from drysim.study.summary import Note, Row, Summary

LABEL_WIDTH = 14
"""Columns of the labels on the left."""

STYLES = {"": "bold", GOOD: "green", BAD: "bold red", PLAIN: ""}
"""Styles of the tones of a value."""


def show_summary(
    summary: Summary, folder: Path | None = None, warnings: Sequence[WarningMessage] = ()
) -> None:
    """Show a summary, the folder of the files, and warnings.

    Parameters
    ----------
    summary : Summary
    folder : Path, optional
        Where the files were written.
    warnings : sequence of WarningMessage, optional
        Printed on stderr.
    """
    console = stdout()
    print_summary(console, summary)
    if folder is not None:
        print_line(console)
        print_line(console, ("  written".ljust(LABEL_WIDTH), "dim"), str(folder))
    show_warnings(warnings)


def show_brief(
    name: str, summary: Summary, folder: Path, warnings: Sequence[WarningMessage], code: int
) -> None:
    """Show one of several results: a line, checks that do not hold, and warnings.

    Parameters
    ----------
    name : str
    summary : Summary
    folder : Path
        Where the files were written.
    warnings : sequence of WarningMessage
    code : int
        The exit code of this result.
    """
    console = stdout()
    passed = [check.passed for check in summary.checks]
    failed, skipped, every = passed.count(False), passed.count(None), len(passed)
    parts = [count_checks(failed, every, "fails", "fail")] if failed else []
    parts += [count_checks(skipped, every, "is skipped", "are skipped")] if skipped else []
    held = count_checks(every, every, "holds", "hold") if every else "no checks"
    parts = parts or [held]
    if warnings:
        parts.append(format_count(len(warnings), "warning"))
    head = ("fails: ", "bold red") if code else ("ok: ", "green")
    print_line(console, head, f"{name}: {', '.join(parts)}; {folder}")
    print_notes(console, summary.faults)
    for check in summary.checks:
        if not check.passed:
            mark, style = check_mark(check.passed)
            print_labelled(console, mark, check.sentence, style)
    show_warnings(warnings)


def count_checks(count: int, every: int, singular: str, plural: str) -> str:
    """Return e.g. `1 of 3 checks fails`, or `3 checks hold` of all."""
    part = "" if count == every else f"{count} of "
    return f"{part}{format_count(every, 'check')} {singular if count == 1 else plural}"


def print_summary(console: AnyConsole, summary: Summary) -> None:
    """Print a summary."""
    for part in summary.parts:
        print_summary(console, part)
        print_line(console)
    if summary.name:
        print_line(console, (summary.name, "bold"))
    if summary.about:
        print_paragraph(console, "", summary.about)
    if summary.scene:
        print_line(console)
    for label, sentence in summary.scene:
        print_labelled(console, label, sentence)
    if summary.faults:
        print_line(console)
    print_notes(console, summary.faults)
    if summary.table is not None:
        columns, texts, optional, _ = summary.table
        print_table(console, columns, texts, optional)
    for rows in filter(None, summary.groups):
        print_rows(console, rows, summary.width)
    if summary.notes:
        print_line(console)
    print_notes(console, summary.notes)
    if summary.checks:
        print_line(console)
    for passed, sentence in summary.checks:
        mark, style = check_mark(passed)
        print_labelled(console, mark, sentence, style)
    print_notes(console, summary.conclusion)
    if summary.verdict:
        print_line(console)
    for place, sentence in enumerate(summary.verdict):
        for line in wrap(console, sentence, 2):
            print_line(console, ("  ", ""), (line, "" if place else "bold"))


def print_notes(console: AnyConsole, notes: Iterable[Note]) -> None:
    """Print labelled sentences in their tone."""
    for label, sentence, tone in notes:
        print_labelled(console, label, sentence, STYLES[tone] if tone else "dim")


def print_labelled(console: AnyConsole, label: str, sentence: str, style: str = "dim") -> None:
    """Print a sentence next to its label."""
    print_paragraph(console, f"  {label}".ljust(LABEL_WIDTH), sentence, style)


def print_rows(console: AnyConsole, rows: Sequence[Row], width: int) -> None:
    """Print rows: label, value, explanation.

    The values take at least `width` columns. An explanation that does not fit continues below.
    Two blanks end a label beyond the usual width, and a value with an explanation.
    """
    longest = max(len(row.label) for row in rows)
    label_width = LABEL_WIDTH if longest + 3 <= LABEL_WIDTH else longest + 4
    width = max([width, *(len(row.value) + 2 for row in rows if row.remark)])
    print_line(console)
    for row in rows:
        label, value = f"  {row.label}".ljust(label_width), row.value.ljust(width)
        first, *continuation = wrap(console, row.remark, label_width + width) or [""]
        shown = value if first else row.value
        print_line(console, (label, "dim"), (shown, STYLES[row.tone]), first)
        for line in continuation:
            print_line(console, " " * (label_width + width), line)


def check_mark(passed: bool | None) -> tuple[str, str]:
    """Return the mark of a check and its style."""
    if passed is None:
        return "· skipped", "dim"
    return ("✓ holds", "green") if passed else ("✗ fails", "bold red")


MAX_ALIKE = 3
"""Number of warnings with one slug that are printed, as for the records of a sweep."""


def show_warnings(warnings: Sequence[WarningMessage]) -> None:
    """Print warnings on stderr, one paragraph each; with a hint at a terminal."""
    console = stderr()
    seen: Counter[str] = Counter()
    for warning in warnings:
        seen[warning.slug] += 1
        if seen[warning.slug] > MAX_ALIKE:
            continue
        if console.is_terminal:
            sentence = f"{warning.sentence} (drysim explain {warning.slug})"
            print_paragraph(console, "warning: ", sentence, "yellow")
        else:
            print_line(console, "warning: ", warning.sentence)
    for slug, count in seen.items():
        if count > MAX_ALIKE:
            many = format_count(count - MAX_ALIKE, "more warning")
            print_line(console, "warning: ", f"{many} of the kind {slug}: see drysim.json")


def show_interrupted(kept: int, what: str, folder: Path, is_all: bool = False) -> None:
    """Print on stderr how much of interrupted work was kept, and how to continue.

    `is_all` says that nothing but the files of the result is left to do.
    """
    console = stderr()
    if not kept:
        print_line(console, f"interrupted before any {what} was finished")
        return
    if is_all:
        print_line(
            console,
            f"interrupted after the last of {format_count(kept, what)}: kept in "
            f"{folder}.partial; the same command with --resume writes the result",
        )
        return
    cases = f"{format_count(kept, f'finished {what}')} {'is' if kept == 1 else 'are'}"
    print_line(
        console,
        f"interrupted: {cases} kept in {folder}.partial; the same command with --resume "
        "computes only the rest",
    )
