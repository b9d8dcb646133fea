"""The hard cases: every approach on each of them. Their files, fields and summary."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from drysim.approach import EXACT
from drysim.bench.hard_cases import (
    COMPARED_METRICS,
    FAILED,
    HELD,
    NO_CHECKS,
    TOLERANCE,
    WRONG,
)
from drysim.results.fields import header_fields, origin_fields, sanitise, software_versions
from drysim.results.kind import File, Kind
from drysim.results.tables import column_header, format_cell, join_cells, quote_cell, write_csv
from drysim.study.summary import BAD, Grid, Note, Summary
from drysim.wording import format_percent

if TYPE_CHECKING:
    from drysim.bench.hard_cases import HardCaseResult, HardCases
    from drysim.results.fields import Fields, Provenance

OPTIONAL_COLUMNS = ("viscous", "smooth", "signum", "moreau", "switch")
"""Columns that a narrow terminal omits, in this order."""


def summarise(result: HardCases) -> Summary:
    """Return the summary of the hard cases."""
    return Summary(
        name="hard cases",
        table=Grid(hard_case_columns(result), ("case",), OPTIONAL_COLUMNS),
        notes=tuple(findings(result)),
    )


def findings(result: HardCases) -> Iterator[Note]:
    """Yield when a case is held, and where the exact approach does not hold it."""
    yield Note(
        "held",
        f"{EXACT} passes every check of the case; the others have T_a, peak and RMS of x_r "
        f"within {format_percent(TOLERANCE)} of it",
    )
    without_checks = [
        case.scenario.name for case in result.cases if case.results[0].verdict == NO_CHECKS
    ]
    if without_checks:
        names = ", ".join(without_checks)
        yield Note(NO_CHECKS, f"{names}: {EXACT} cannot be verified; add `checks`", BAD)
    for case in result.cases:
        for trial in case.results:
            if trial.verdict == FAILED or (trial.approach == EXACT and trial.verdict == WRONG):
                sentence = f"{trial.approach} on {case.scenario.name}: {trial.reason}"
                yield Note(trial.verdict, sentence, BAD)


def hard_case_columns(result: HardCases) -> list[list[str]]:
    """Return the table by columns, header first, sums last."""
    names = [trial.approach for trial in result.cases[0].results]
    table = [["case", *(case.scenario.name for case in result.cases), "held"]]
    for place, name in enumerate(names):
        results = [case.results[place] for case in result.cases]
        count = sum(trial.verdict == HELD for trial in results)
        table.append([name, *map(result_cell, results), f"{count} of {len(results)}"])
    return table


def result_cell(result: HardCaseResult) -> str:
    """Return the table cell of one approach in one case."""
    return result.reason if result.reason and result.verdict != FAILED else result.verdict


def write_hard_cases_csv(result: HardCases, file: Path) -> None:
    """Write hard_cases.csv: a row per approach and case."""
    deviations = [f"{metric}_deviation" for metric in COMPARED_METRICS]
    numbers = [*deviations, "checks", "passed", "time"]
    headers = ["case", "approach", "verdict", "how", *map(column_header, numbers)]
    rows = []
    for case in result.cases:
        for trial in case.results:
            texts = [
                case.scenario.name,
                trial.approach,
                trial.verdict,
                quote_cell(trial.reason),
            ]
            off = [format_cell(trial.deviations.get(metric)) for metric in COMPARED_METRICS]
            counts = [str(trial.checks), str(trial.passed), str(trial.time)]
            rows.append([*texts, *off, *counts])
    write_csv(file, headers, [join_cells(rows)])


def hard_case_fields(result: HardCases, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for the hard cases."""
    trials = [trial for case in result.cases for trial in case.results]
    metrics: Fields = {
        name: dict(Counter(trial.verdict for trial in trials if trial.approach == name))
        for name in dict.fromkeys(trial.approach for trial in trials)
    }
    cases: list[Fields] = [
        {
            "scenario": {"name": case.scenario.name, **origin_fields(case.scenario.origin)},
            "trials": [_trial_fields(trial) for trial in case.results],
        }
        for case in result.cases
    ]
    fields: Fields = {
        **header_fields(result.kind, provenance),
        "numerics": {"engine": result.engine, "cases": len(cases)},
        "software": software_versions(),
        "metrics": metrics,
        "cases": cases,
        "checks": [],
        "warnings": [],
        "files": provenance.files,
    }
    return {key: sanitise(value) for key, value in fields.items()}


def _trial_fields(result: HardCaseResult) -> Fields:
    """Return the result of one approach, under the keys of drysim.json."""
    fields = result._asdict()
    named = {"approach": "approach", "word": "verdict", "how": "reason"}
    return {key: fields.pop(name) for key, name in named.items()} | fields


HARD = Kind(
    name="hard",
    what="the hard cases",
    files=(File("hard_cases.csv", write_hard_cases_csv),),
    fields=hard_case_fields,
    summary=summarise,
    scenario=lambda result: None,
)
