"""Files of a bench: speed_error.csv, hard_cases.csv, and what drysim.json says of them."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from drysim.bench.hard_cases import COMPARED
from drysim.output.sidecar import Ending, Fields, framed, head, origin, plain, software
from drysim.output.tables import heading, joined, text, write

if TYPE_CHECKING:
    from drysim.bench.hard_cases import Ordeals
    from drysim.bench.score import Bench, Panel


NUMBERS = ("step", "time_per_sample", "error_x_r", "error_T_a", "energy_residual")
FURTHER = ("time_over_lfilter", "samples", "repeats")
"""Columns of numbers, before and behind the verdict."""

OF_A_CASE = ("scenario", "inputs", "excitation")
"""What drysim.json says of every case of a bench."""


def speed_error(bench: Bench, folder: Path) -> None:
    """Write speed_error.csv: a row for every entry on every case."""
    headings = [
        "approach", "setting", *map(heading, NUMBERS), "verdict",
        "case", *map(heading, FURTHER),
    ]  # fmt: skip
    rows = []
    for panel in bench.panels:
        for one in panel.scores:
            before = (one.step, one.time, one.error_x_r, one.error_T_a, one.energy_residual)
            rows.append([
                one.approach, quoted(one.setting), *map(text, before), quoted(one.verdict),
                panel.scenario.name, *map(text, (one.ratio, one.samples, one.repeats)),
            ])  # fmt: skip
    write(folder / "speed_error.csv", headings, [joined(zip(*rows, strict=True))])


def of_bench(bench: Bench, ending: Ending) -> Fields:
    """Give everything that made the numbers of a bench, ready for JSON."""
    numerics = {"engine": bench.engine, "cases": len(bench.panels)}
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


def hard_cases(ordeals: Ordeals, folder: Path) -> None:
    """Write hard_cases.csv: a row for every approach on every case."""
    deviations = [f"{metric}_deviation" for metric in COMPARED]
    numbers = [*deviations, "checks", "passed", "time"]
    headings = ["case", "approach", "verdict", "how", *map(heading, numbers)]
    rows = []
    for case in ordeals.cases:
        for one in case.trials:
            off = [text(one.deviations.get(metric)) for metric in COMPARED]
            counts = [str(one.checks), str(one.passed), str(one.time)]
            words = [case.scenario.name, one.approach, one.word, quoted(one.how)]
            rows.append([*words, *off, *counts])
    write(folder / "hard_cases.csv", headings, [joined(zip(*rows, strict=True))])


def of_ordeals(ordeals: Ordeals, ending: Ending) -> Fields:
    """Give everything that made the verdicts, ready for JSON."""
    trials = [one for case in ordeals.cases for one in case.trials]
    metrics: Fields = {
        name: dict(Counter(one.word for one in trials if one.approach == name))
        for name in dict.fromkeys(one.approach for one in trials)
    }
    cases: list[Fields] = [
        {
            "scenario": {"name": case.scenario.name, **origin(case.scenario.origin)},
            "trials": [one._asdict() for one in case.trials],
        }
        for case in ordeals.cases
    ]
    fields: Fields = {
        **head(ending),
        "numerics": {"engine": ordeals.engine, "cases": len(cases)},
        "software": software(),
        "metrics": metrics,
        "cases": cases,
        "checks": [],
        "warnings": [],
        "files": ending.files,
    }
    return {key: plain(value) for key, value in fields.items()}


def quoted(words: str) -> str:
    """Give words as a cell: in quotes where they hold a comma, a quote or a line end."""
    words = " ".join(words.split())
    return '"' + words.replace('"', '""') + '"' if set(words) & set(',"') else words
