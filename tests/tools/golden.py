"""What the scenarios of the gallery gave when last written by `python tests/tools/golden.py`.

A refactoring changes none of it. Kept are the metrics of each run, its events by kind, its
warnings and verdicts, and of each sweep the number of cases with a metric and its mean.
"""

from __future__ import annotations

import json
from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any

import drysim
from drysim.study.fit import FitResult, fit

HERE = Path(__file__).parents[1]
FILE = HERE / "data" / "golden.json"
GALLERY = HERE.parent / "scenarios"
SHIPPED = sorted(GALLERY.glob("*.yaml"))
FITS = [file for file in SHIPPED if drysim.load(file).fit is not None]
DESIGNS = [file for file in SHIPPED if drysim.load(file).design is not None]
ASSESSED = [file for file in SHIPPED if drysim.load(file).assess is not None]
SCENARIOS = [file for file in SHIPPED if file not in FITS + DESIGNS + ASSESSED]
HARD = sorted((GALLERY / "hard").glob("*.yaml"))
SWEEPS = [file for file in SCENARIOS if drysim.load(file).sweep]
ROUNDING = ("energy_residual", "law_residual", "closure")
"""Metrics that are pure rounding, which another processor has differently."""

TINY_PEAK = 1e-20
"""Peak of x_r [m] below which rounding decides whether a motion crosses zero."""


@cache
def outcome(file: Path) -> drysim.Outcome:
    """Return the outcome of `run`, computed once a session."""
    return drysim.run(drysim.load(file))


@cache
def table(file: Path) -> drysim.Table:
    """Return the table of `sweep`, computed once a session."""
    return drysim.sweep(drysim.load(file))


@cache
def fitted(file: Path) -> FitResult:
    """Return the result of `fit`, computed once a session."""
    return fit(drysim.load(file))


def of_run(file: Path) -> dict[str, Any]:
    """Return what is kept of a run."""
    found = outcome(file)
    kinds = Counter(found.events.kind.tolist())
    metrics = {key: of_value(key, value) for key, value in found.metrics.items()}
    if (metrics["x_r_peak"] or 1.0) < TINY_PEAK:
        metrics["crossing_rate"] = None
    return {
        "metrics": metrics,
        "events": {str(kind): count for kind, count in sorted(kinds.items())},
        "warnings": sorted(warning.slug for warning in found.warnings),
        "checks": [verdict.passed for verdict in found.checks],
    }


def of_sweep(file: Path) -> dict[str, Any]:
    """Return what is kept of a sweep: states of its cases, means of the metrics they have."""
    rows = list(table(file).rows)
    kept: dict[str, Any] = {"states": dict(sorted(Counter(row.status for row in rows).items()))}
    for key in rows[0].metrics:
        values = [row.metrics[key] for row in rows if row.metrics.get(key) is not None]
        mean = sum(values) / len(values) if values else None
        kept[key] = [len(values), of_value(key, mean)]
    return kept


def of_value(key: str, value: float | None) -> float | str | None:
    """Return a metric as it is kept: of rounding, only that it is known."""
    return "known" if value is not None and key in ROUNDING else value


def all_of_it() -> dict[str, Any]:
    """Return what the file keeps of the whole gallery."""
    runs = {file.stem: of_run(file) for file in (*SCENARIOS, *HARD)}
    return {"run": runs, "sweep": {file.stem: of_sweep(file) for file in SWEEPS}}


if __name__ == "__main__":
    FILE.write_text(json.dumps(all_of_it(), indent=1) + "\n")
