"""Files of the hard cases: hard_cases.csv, and what drysim.json says of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from drysim.report.bare import plain
from drysim.report.cells import joined, text
from drysim.report.scored import quoted
from drysim.report.sidecar import Ending, Fields, head, origin, software
from drysim.report.tables import heading, write
from drysim.study.bench.trial import COMPARED

if TYPE_CHECKING:
    from drysim.study.bench.hard import Ordeals

DEVIATIONS = tuple(f"{metric}_deviation" for metric in COMPARED)
HEADINGS = ("case", "approach", "verdict", "how", *map(heading, DEVIATIONS))
COUNTS = ("checks", "passed", "time")


def hard_cases(ordeals: Ordeals, folder: Path) -> None:
    """Write hard_cases.csv: a row for every approach on every case.

    Parameters
    ----------
    ordeals : Ordeals
    folder : Path
        Where to write.
    """
    columns = [*HEADINGS, *map(heading, COUNTS)]
    write(folder / "hard_cases.csv", columns, [joined(zip(*cells(ordeals), strict=True))])


def cells(ordeals: Ordeals) -> Iterator[list[str]]:
    """Give the rows of hard_cases.csv."""
    for case in ordeals.cases:
        for one in case.trials:
            off = [text(one.deviations.get(metric)) for metric in COMPARED]
            counts = [str(one.checks), str(one.passed), str(one.time)]
            yield [case.scenario.name, one.approach, one.word, quoted(one.how), *off, *counts]


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
