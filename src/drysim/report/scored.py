"""Files of a bench: speed_error.csv, and what drysim.json says of it."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from drysim.report.cells import joined, text
from drysim.report.sidecar import Ending, Fields, framed
from drysim.report.tables import heading, write

if TYPE_CHECKING:
    from drysim.study.bench.scores import Bench, Panel

NUMBERS = ("step", "time_per_sample", "error_x_r", "error_T_a", "energy_residual")
FURTHER = ("time_over_lfilter", "samples", "repeats")
"""Columns of numbers, before and behind the verdict."""

OF_A_CASE = ("scenario", "inputs", "excitation")
"""What drysim.json says of every case of a bench."""


def speed_error(bench: Bench, folder: Path) -> None:
    """Write speed_error.csv: a row for every entry on every case.

    Parameters
    ----------
    bench : Bench
    folder : Path
        Where to write.
    """
    headings = [
        "approach", "setting", *map(heading, NUMBERS), "verdict",
        "case", *map(heading, FURTHER),
    ]  # fmt: skip
    rows = [cells(panel, at) for panel in bench.panels for at in range(len(panel.scores))]
    write(folder / "speed_error.csv", headings, [joined(zip(*rows, strict=True))])


def cells(panel: Panel, at: int) -> list[str]:
    """Give one row of speed_error.csv."""
    one = panel.scores[at]
    before = (one.step, one.time, one.error_x_r, one.error_T_a, one.energy_residual)
    return [
        one.approach, quoted(one.setting), *map(text, before), quoted(one.verdict),
        panel.scenario.name, *map(text, (one.ratio, one.samples, one.repeats)),
    ]  # fmt: skip


def of_bench(bench: Bench, ending: Ending) -> Fields:
    """Give everything that made the numbers of a bench, ready for JSON."""
    numerics = {"engine": bench.engine, "cases": len(bench.panels), "absent": bench.absent}
    metrics = {panel.scenario.name: _found(panel) for panel in bench.panels}
    frames = [framed(panel, panel.motion, numerics, metrics, ending) for panel in bench.panels]
    cases = [
        {key: frame[key] for key in OF_A_CASE}
        | {"lfilter": panel.lfilter, "scores": [asdict(one) for one in panel.scores]}
        for panel, frame in zip(bench.panels, frames, strict=True)
    ]
    told = {key: value for key, value in frames[0].items() if key not in OF_A_CASE}
    return told | {"cases": cases, "warnings": [asdict(one) for one in bench.warnings]}


def _found(panel: Panel) -> Fields:
    """Give what came out for the exact approach."""
    exact = panel.scores[0]
    return {
        "time_per_sample": exact.time,
        "time_over_lfilter": exact.ratio,
        "error_x_r": exact.error_x_r,
        "error_T_a": exact.error_T_a,
        "energy_residual": exact.energy_residual,
    }


def quoted(words: str) -> str:
    """Give words as a cell: in quotes where they hold a comma, a quote or a line end."""
    words = " ".join(words.split())
    return '"' + words.replace('"', '""') + '"' if set(words) & set(',"') else words
