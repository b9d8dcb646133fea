"""Terminal output of benches and of the hard cases: tables of approaches, and findings."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from drysim.approach import EXACT
from drysim.bench.hard_cases import FAILED, HELD, NO_CHECKS, TOLERANCE, WRONG
from drysim.bench.score import EXACT_BELOW
from drysim.console.summaries import (
    print_labelled,
    show_folder,
    show_scene,
    show_title,
    show_warnings,
)
from drysim.console.terminal import NO_VALUE, print_line, print_table, stdout
from drysim.wording import format_number, format_percent

if TYPE_CHECKING:
    from drysim.bench.hard_cases import HardCaseResult, HardCases
    from drysim.bench.score import Bench, BenchCase, Score

OPTIONAL_BENCH_COLUMNS = ("energy", "samples", "T_a error", "ns/sample")
OPTIONAL_HARD_COLUMNS = ("viscous", "smooth", "signum", "moreau", "switch")
"""Columns that a narrow terminal omits, in this order."""


def show_bench(bench: Bench, folder: Path | None = None) -> None:
    """Show speed against error.

    Parameters
    ----------
    bench : Bench
    folder : Path, optional
        Where the files were written.
    """
    console = stdout()
    for panel in bench.cases:
        show_title(console, panel.scenario)
        show_scene(console, [*panel.words, ("engine", bench.engine)])
        print_table(console, bench_columns(panel), ("entry", "verdict"), OPTIONAL_BENCH_COLUMNS)
        for head, sentence in bench_findings(panel):
            print_labelled(console, head, sentence)
        console.print()
    show_folder(console, folder)
    show_warnings(bench.warnings)


def bench_columns(panel: BenchCase) -> list[list[str]]:
    """Return the table of a panel by columns, header first."""
    scores = panel.scores
    return [
        ["entry", *map(entry_label, scores)],
        ["ns/sample", *(_format_optional(one.time, 3) for one in scores)],
        ["× lfilter", *(_format_optional(one.ratio, 3) for one in scores)],
        ["x_r error", *(_format_optional(one.error_x_r, 2) for one in scores)],
        ["T_a error", *(_format_optional(one.error_T_a, 2) for one in scores)],
        ["energy", *(_format_optional(one.energy_residual, 2) for one in scores)],
        ["samples", *(str(one.samples or NO_VALUE) for one in scores)],
        ["verdict", *(one.verdict.partition(",")[0] for one in scores)],
    ]


def entry_label(score: Score) -> str:
    """Return the approach, setting and step that identify an entry."""
    step = f"Δt {format_number(score.step * 1e3, 'ms')}" if score.step else ""
    return " ".join(part for part in (score.approach, score.setting, step) if part)


def _format_optional(value: float | None, digits: int) -> str:
    return NO_VALUE if value is None else format_number(value, digits=digits)


def bench_findings(panel: BenchCase) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: reference of the exact approach, next best, failures."""
    exact, reference = panel.scores[0], panel.reference
    if reference is not None and reference.in_doubt:
        yield "reference", f"none: {entry_label(reference)} is not reliable itself"
    elif reference is not None and reference.error_x_r is not None:
        own = format_number(reference.uncertainty or 0.0, digits=2)
        sentence = (
            f"{entry_label(reference)}; {exact.approach} differs from it by the errors above, "
            f"over {reference.samples} samples: an upper bound; two reference runs differ"
            f" by {own}"
        )
        yield "reference", sentence
    elif exact.error_x_r is not None:
        yield "reference", f"none; the error of x_r is an estimate of {exact.approach} itself"
    others = [
        one for one in panel.scores[1:]
        if one.time and one.error_x_r is not None and one.error_x_r <= EXACT_BELOW
    ]  # fmt: skip
    if exact.time and others:
        next_one = min(others, key=lambda one: one.time or 0.0)
        times = format_number((next_one.time or 0.0) / exact.time, digits=2)
        yield (
            "next best",
            f"{entry_label(next_one)} is as accurate and takes {times} times as long",
        )
    for one in panel.scores:
        if one.verdict.startswith("failed"):
            yield "failed", f"{entry_label(one)}: {one.verdict.partition(', ')[2]}"


def show_hard_cases(result: HardCases, folder: Path | None = None) -> None:
    """Show the results of the hard cases.

    Parameters
    ----------
    result : HardCases
    folder : Path, optional
        Where the files were written.
    """
    console = stdout()
    print_line(console, ("hard cases", "bold"))
    print_table(console, hard_case_columns(result), ("case",), OPTIONAL_HARD_COLUMNS)
    print_line(console)
    rule = (
        f"{EXACT} passes every check of the case; the others have T_a, peak and RMS of x_r "
        f"within {format_percent(TOLERANCE)} of it"
    )
    print_labelled(console, "held", rule)
    without_checks = [
        one.scenario.name for one in result.cases if one.results[0].verdict == NO_CHECKS
    ]
    if without_checks:
        names = ", ".join(without_checks)
        sentence = f"{names}: {EXACT} cannot be verified; add `checks`"
        print_labelled(console, NO_CHECKS, sentence, "bold red")
    for case in result.cases:
        for one in case.results:
            if one.verdict == FAILED or (one.approach == EXACT and one.verdict == WRONG):
                words = f"{one.approach} on {case.scenario.name}: {one.reason}"
                print_labelled(console, one.verdict, words, "bold red")
    show_folder(console, folder)


def hard_case_columns(result: HardCases) -> list[list[str]]:
    """Return the table by columns, header first, sums last."""
    names = [one.approach for one in result.cases[0].results]
    table = [["case", *(case.scenario.name for case in result.cases), "held"]]
    for at, name in enumerate(names):
        results = [case.results[at] for case in result.cases]
        count = sum(one.verdict == HELD for one in results)
        table.append([name, *map(result_cell, results), f"{count} of {len(results)}"])
    return table


def result_cell(result: HardCaseResult) -> str:
    """Return the table cell of one approach in one case."""
    return result.reason if result.reason and result.verdict != FAILED else result.verdict
