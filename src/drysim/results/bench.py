"""A bench: speed against error of all approaches. Its files, fields, picture and summary."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from itertools import starmap
from pathlib import Path
from typing import TYPE_CHECKING

from drysim import wording
from drysim.bench.score import EXACT_BELOW
from drysim.console.terminal import NO_VALUE
from drysim.results.fields import stored_fields
from drysim.results.kind import File, Kind, Picture, write_scenario
from drysim.results.tables import column_header, format_cell, join_cells, quote_cell, write_csv
from drysim.study.summary import Grid, Note, Summary
from drysim.wording import format_number

if TYPE_CHECKING:
    from drysim.bench.score import Bench, BenchCase, Score
    from drysim.results.fields import Fields, Provenance
    from drysim.scenario.model import Scenario

OPTIONAL_COLUMNS = ("energy", "samples", "T_a error", "ns/sample")
"""Columns that a narrow terminal omits, in this order."""


def summarise(bench: Bench) -> Summary:
    """Return the summary of a bench: speed against error, case by case."""
    parts = tuple(
        Summary(
            name=wording.sanitise(panel.scenario.name),
            about=panel.scenario.about,
            scene=(*panel.scene, ("engine", bench.engine)),
            table=Grid(bench_columns(panel), ("entry", "verdict"), OPTIONAL_COLUMNS),
            notes=tuple(starmap(Note, bench_findings(panel))),
        )
        for panel in bench.cases
    )
    return Summary(name="", parts=parts)


def bench_columns(panel: BenchCase) -> list[list[str]]:
    """Return the table of a panel by columns, header first."""
    scores = panel.scores
    return [
        ["entry", *map(entry_label, scores)],
        ["ns/sample", *(_format_optional(score.time, 3) for score in scores)],
        ["× lfilter", *(_format_optional(score.ratio, 3) for score in scores)],
        ["x_r error", *(_format_optional(score.error_x_r, 2) for score in scores)],
        ["T_a error", *(_format_optional(score.error_T_a, 2) for score in scores)],
        ["energy", *(_format_optional(score.energy_residual, 2) for score in scores)],
        ["samples", *(str(score.samples or NO_VALUE) for score in scores)],
        ["verdict", *(score.verdict.partition(",")[0] for score in scores)],
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
        difference = format_number(reference.uncertainty or 0.0, digits=2)
        sentence = (
            f"{entry_label(reference)}; {exact.approach} differs from it by the errors above, "
            f"over {reference.samples} samples: an upper bound; two reference runs differ"
            f" by {difference}"
        )
        yield "reference", sentence
    elif exact.error_x_r is not None:
        yield "reference", f"none; the error of x_r is an estimate of {exact.approach} itself"
    others = [
        score for score in panel.scores[1:]
        if score.time and score.error_x_r is not None and score.error_x_r <= EXACT_BELOW
    ]  # fmt: skip
    if exact.time and others:
        next_best = min(others, key=lambda score: score.time or 0.0)
        times = format_number((next_best.time or 0.0) / exact.time, digits=2)
        yield (
            "next best",
            f"{entry_label(next_best)} is exact to {EXACT_BELOW:g}, too, and takes "
            f"{times} times as long",
        )
    for score in panel.scores:
        if score.verdict.startswith("failed"):
            yield "failed", f"{entry_label(score)}: {score.verdict.partition(', ')[2]}"


BENCH_COLUMNS = ("step", "time_per_sample", "error_x_r", "error_T_a", "energy_residual")


LAST_BENCH_COLUMNS = ("time_over_lfilter", "samples", "repeats")
"""Columns of numbers, before and after the verdict."""


def write_speed_error_csv(bench: Bench, file: Path) -> None:
    """Write speed_error.csv: a row per entry and case."""
    headers = [
        "approach", "setting", *map(column_header, BENCH_COLUMNS), "verdict",
        "case", *map(column_header, LAST_BENCH_COLUMNS),
    ]  # fmt: skip
    rows = []
    for panel in bench.cases:
        for score in panel.scores:
            before = (
                score.step,
                score.time,
                score.error_x_r,
                score.error_T_a,
                score.energy_residual,
            )
            rows.append(
                [
                    score.approach,
                    quote_cell(score.setting),
                    *map(format_cell, before),
                    quote_cell(score.verdict),
                    panel.scenario.name,
                    *map(format_cell, (score.ratio, score.samples, score.repeats)),
                ]
            )
    write_csv(file, headers, [join_cells(rows)])


CASE_KEYS = ("scenario", "inputs", "excitation")
"""Fields of drysim.json that differ between the cases of a bench."""


def bench_fields(bench: Bench, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for a bench."""
    numerics = {"engine": bench.engine, "cases": len(bench.cases)}
    metrics = {panel.scenario.name: _exact_fields(panel) for panel in bench.cases}
    frames = [
        stored_fields(panel, panel.motion, numerics, metrics, provenance)
        for panel in bench.cases
    ]
    cases = [
        {key: frame[key] for key in CASE_KEYS}
        | {"lfilter": panel.lfilter, "scores": [asdict(score) for score in panel.scores]}
        for panel, frame in zip(bench.cases, frames, strict=True)
    ]
    summary = {key: value for key, value in frames[0].items() if key not in CASE_KEYS}
    return summary | {
        "cases": cases,
        "warnings": [asdict(warning) for warning in bench.warnings],
    }


def _exact_fields(panel: BenchCase) -> Fields:
    """Return the results of the exact approach."""
    exact = panel.scores[0]
    return {
        "time_per_sample": exact.time,
        "time_over_lfilter": exact.ratio,
        "error_x_r": exact.error_x_r,
        "error_T_a": exact.error_T_a,
        "energy_residual": exact.energy_residual,
    }


def scenario_of(bench: Bench) -> Scenario | None:
    """Return the scenario of a bench of a single one."""
    return bench.cases[0].scenario if len(bench.cases) == 1 else None


def write_scenarios(bench: Bench, folder: Path) -> None:
    """Write the scenarios of a bench of several, each under its own name."""
    if len(bench.cases) > 1:
        for panel in bench.cases:
            write_scenario(panel.scenario, folder / f"{panel.scenario.name}.yaml")


BENCH = Kind(
    name="bench",
    what="a bench",
    files=(
        File("speed_error.csv", write_speed_error_csv),
        File("paper-*.yaml", write_scenarios),
    ),
    pictures=(
        Picture("speed_error", "speed_error.draw", "Error of the approaches over their time"),
    ),
    fields=bench_fields,
    summary=summarise,
    scenario=scenario_of,
)
