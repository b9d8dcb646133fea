"""The summary of the hard cases: a table of cases and approaches."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from drysim.approach import EXACT
from drysim.console.columns import show_columns
from drysim.console.paper import line, stdout
from drysim.console.parts import headed, show_folder
from drysim.study.bench.trial import FAILED, HELD, TOLERANCE, UNPROMISED, WRONG
from drysim.wording import percent

if TYPE_CHECKING:
    from drysim.study.bench.hard import Ordeals
    from drysim.study.bench.trial import Trial

SPARED = ("viscous", "smooth", "signum", "moreau", "switch")
"""What a narrow terminal does without, in this order."""


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
    show_columns(paper, columns(ordeals), ("case",), SPARED)
    line(paper)
    headed(paper, "held", rule())
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


def rule() -> str:
    """Say what it takes to hold."""
    return (
        f"{EXACT} keeps every check of a case; T_a, peak and RMS of x_r by the others are "
        f"within {percent(TOLERANCE)} of it"
    )


def columns(ordeals: Ordeals) -> list[list[str]]:
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
