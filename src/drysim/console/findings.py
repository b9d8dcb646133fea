"""What a bench and the hard cases say: tables of approaches, and what to think of them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from drysim.approach import EXACT
from drysim.bench.hard_cases import FAILED, HELD, TOLERANCE, UNPROMISED, WRONG
from drysim.bench.score import EXACT_BELOW
from drysim.console.summaries import headed, show_folder, show_scene, show_title, show_warnings
from drysim.console.terminal import NONE, line, show_columns, stdout
from drysim.wording import number, percent

if TYPE_CHECKING:
    from drysim.bench.hard_cases import Ordeals, Trial
    from drysim.bench.score import Bench, Panel, Score

BENCH_SPARED = ("energy", "samples", "T_a error", "ns a sample")
HARD_SPARED = ("viscous", "smooth", "signum", "moreau", "switch")
"""What a narrow terminal does without, in this order."""


def show_bench(bench: Bench, folder: Path | None = None) -> None:
    """Show speed against error.

    Parameters
    ----------
    bench : Bench
    folder : Path, optional
        Where the files were written.
    """
    paper = stdout()
    for panel in bench.panels:
        show_title(paper, panel.scenario)
        show_scene(paper, [*panel.words, ("engine", bench.engine)])
        show_columns(paper, bench_columns(panel), ("entry", "verdict"), BENCH_SPARED)
        for head, sentence in findings(panel):
            headed(paper, head, sentence)
        paper.print()
    show_folder(paper, folder)
    show_warnings(bench.warnings)


def bench_columns(panel: Panel) -> list[list[str]]:
    """Give the table column by column, headings first."""
    scores = panel.scores
    return [
        ["entry", *map(name, scores)],
        ["ns a sample", *(_short(one.time, 3) for one in scores)],
        ["× lfilter", *(_short(one.ratio, 3) for one in scores)],
        ["x_r error", *(_short(one.error_x_r, 2) for one in scores)],
        ["T_a error", *(_short(one.error_T_a, 2) for one in scores)],
        ["energy", *(_short(one.energy_residual, 2) for one in scores)],
        ["samples", *(str(one.samples or NONE) for one in scores)],
        ["verdict", *(one.verdict.partition(",")[0] for one in scores)],
    ]


def name(score: Score) -> str:
    """Give what tells an entry from the others."""
    step = f"Δt {number(score.step * 1e3, 'ms')}" if score.step else ""
    return " ".join(part for part in (score.approach, score.setting, step) if part)


def _short(value: float | None, digits: int) -> str:
    return NONE if value is None else number(value, digits=digits)


def findings(panel: Panel) -> Iterator[tuple[str, str]]:
    """Say what the exact approach was held to, what comes next to it, and what failed."""
    exact, held = panel.scores[0], panel.reference
    if held is not None and held.in_doubt:
        yield "held to", f"nothing: {name(held)} is in doubt itself"
    elif held is not None and held.error_x_r is not None:
        own = number(held.uncertainty or 0.0, digits=2)
        sentence = (
            f"the errors of {exact.approach} are those of {name(held)} against it, over "
            f"{held.samples} samples: an upper bound; two runs of the reference differ by {own}"
        )
        yield "held to", sentence
    elif exact.error_x_r is not None:
        yield "held to", f"{exact.approach} is held to the error of x_r that it states itself"
    others = [
        one for one in panel.scores[1:]
        if one.time and one.error_x_r is not None and one.error_x_r <= EXACT_BELOW
    ]  # fmt: skip
    if exact.time and others:
        next_one = min(others, key=lambda one: one.time or 0.0)
        times = number((next_one.time or 0.0) / exact.time, digits=2)
        yield "next", f"{name(next_one)} is as exact and takes {times} times as long"
    for one in panel.scores:
        if one.verdict.startswith("failed"):
            yield "failed", f"{name(one)}: {one.verdict.partition(', ')[2]}"


def show_hard(ordeals: Ordeals, folder: Path | None = None) -> None:
    """Show what became of the hard cases.

    Parameters
    ----------
    ordeals : Ordeals
    folder : Path, optional
        Where the files were written.
    """
    paper = stdout()
    line(paper, ("hard cases", "bold"))
    show_columns(paper, hard_columns(ordeals), ("case",), HARD_SPARED)
    line(paper)
    rule = (
        f"{EXACT} keeps every check of a case; T_a, peak and RMS of x_r by the others are "
        f"within {percent(TOLERANCE)} of it"
    )
    headed(paper, "held", rule)
    bare = [one.scenario.name for one in ordeals.cases if one.trials[0].word == UNPROMISED]
    if bare:
        sentence = (
            f"{', '.join(bare)}: without checks nothing is promised that {EXACT} could hold "
            "or break; give `checks`"
        )
        headed(paper, UNPROMISED, sentence, "bold red")
    for case in ordeals.cases:
        for one in case.trials:
            if one.word == FAILED or (one.approach == EXACT and one.word == WRONG):
                words = f"{one.approach} on {case.scenario.name}: {one.how}"
                headed(paper, one.word, words, "bold red")
    show_folder(paper, folder)


def hard_columns(ordeals: Ordeals) -> list[list[str]]:
    """Give the table column by column, headings first, the sums below."""
    names = [one.approach for one in ordeals.cases[0].trials]
    table = [["case", *(case.scenario.name for case in ordeals.cases), "held"]]
    for at, name in enumerate(names):
        trials = [case.trials[at] for case in ordeals.cases]
        count = sum(one.word == HELD for one in trials)
        table.append([name, *map(cell, trials), f"{count} of {len(trials)}"])
    return table


def cell(trial: Trial) -> str:
    """Give what became of one approach in one case."""
    return trial.how if trial.how and trial.word != FAILED else trial.word
