"""The summary of a bench: scene by scene a table of entries, and what to think of them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from drysim.console.columns import NONE, show_columns
from drysim.console.paper import stdout
from drysim.console.parts import headed, show_folder, show_scene, show_title, show_warnings
from drysim.study.bench.scores import EXACT
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.study.bench.scores import Bench, Panel, Score

LEFT = ("entry", "verdict")
SPARED = ("energy", "samples", "T_a error", "ns a sample")
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
        show_columns(paper, columns(panel), LEFT, SPARED)
        for head, sentence in findings(panel):
            headed(paper, head, sentence)
        paper.print()
    if bench.absent:
        headed(paper, "absent", absent(bench.absent))
    show_folder(paper, folder)
    show_warnings(bench.warnings)


def columns(panel: Panel) -> list[list[str]]:
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


def findings(panel: Panel) -> Iterator[tuple[str, str]]:
    """Say what the exact approach was held to, what comes next to it, and what failed."""
    exact, held = panel.scores[0], panel.reference
    if held is not None and held.in_doubt:
        yield "held to", f"nothing: {name(held)} is in doubt itself"
    elif held is not None and held.error_x_r is not None:
        own = number(held.uncertainty or 0.0, digits=2)
        yield (
            "held to",
            (
                f"the errors of {exact.approach} are those of {name(held)} against it, over "
                f"{held.samples} samples: an upper bound; two runs of the reference differ "
                f"by {own}"
            ),
        )
    elif exact.error_x_r is not None:
        yield "held to", f"{exact.approach} is held to the error of x_r that it states itself"
    others = [
        one for one in panel.scores[1:]
        if one.time and one.error_x_r is not None and one.error_x_r <= EXACT
    ]  # fmt: skip
    if exact.time and others:
        next_one = min(others, key=lambda one: one.time or 0.0)
        times = number((next_one.time or 0.0) / exact.time, digits=2)
        yield "next", f"{name(next_one)} is as exact and takes {times} times as long"
    for one in panel.scores:
        if one.verdict.startswith("failed"):
            yield "failed", f"{name(one)}: {one.verdict.partition(', ')[2]}"


def absent(packages: tuple[str, ...]) -> str:
    """Say which peers are not installed."""
    return f"{', '.join(packages)}: not installed, and not needed by drysim"


def _short(value: float | None, digits: int) -> str:
    return NONE if value is None else number(value, digits=digits)
