"""drysim.json of sweeps, comparisons, ensembles and benches, and the CSV files of the last two.

The metrics of a sweep and a comparison are extremes with their places, those of an ensemble are
statistics over its seeds; ensemble.csv has a row per seed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drysim.metrics.table import METRICS
from drysim.output.sidecar import (
    Fields,
    Provenance,
    excitation_fields,
    header_fields,
    origin_fields,
    sanitise,
    sidecar_fields,
    software_versions,
)
from drysim.output.tables import (
    VIOLATION_COLUMNS,
    VIOLATION_METRICS,
    column_header,
    format_cell,
    join_columns,
    metric_columns,
    requested_metrics,
    write_csv,
)
from drysim.scenario.blocks import SEED_KEY
from drysim.study import compare
from drysim.study.case import combined_sha256
from drysim.study.statistics import CONFIDENCE, OK, QUANTILES, stopping_rule

if TYPE_CHECKING:
    from drysim.bench.hard_cases import HardCaseResult, HardCases
    from drysim.bench.score import Bench, BenchCase
    from drysim.study.compare import Comparison
    from drysim.study.ensemble import Ensemble
    from drysim.study.statistics import Statistic
    from drysim.study.table import Extreme, Table, Tally


def table_fields(table: Table, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for a sweep.

    The metrics are extremes over the cases of the scenario's approach, references left out.
    """
    approach, *references = table.approaches or ("",)
    own = table.tallies.get(approach)
    numerics = {
        "approach": approach,
        "reference": next(iter(references), None),
        **_numerics_fields(table, own),
    }
    return sidecar_fields(table, table.motion, numerics, _metric_fields(own), provenance)


def comparison_fields(comparison: Comparison, provenance: Provenance) -> Fields:
    """Return the content for a comparison: extremes per approach, deviations, verdict."""
    table, yardstick = comparison.table, comparison.yardstick
    numerics = {
        "approaches": table.approaches,
        "yardstick": yardstick,
        "laws": comparison.laws,
        **_numerics_fields(table, table.tallies.get(yardstick)),
    }
    metrics = {
        name: {**_metric_fields(tally), **_deviation_fields(comparison, name)}
        for name, tally in table.tallies.items()
    }
    response = comparison.responses.get(yardstick)
    motion = table.motion if response is None else response.motion
    return sidecar_fields(
        table, motion, numerics, metrics, provenance, verdict=comparison.verdict
    )


def _numerics_fields(table: Table, own: Tally | None) -> Fields:
    """Return how the numbers were computed, with the worst energy residual and closure."""
    return {
        "cases": len(table.rows),
        "statuses": _count_statuses(table.tallies.values()),
        "swept": [
            {"key": axis.key, "unit": axis.unit, "values": len(axis.values)}
            for axis in table.axes
        ],
        "step": table.scenario.solver.step,
        **table.numerics,
        "energy_residual": own and own.greatest("energy_residual"),
        "closure": own and own.greatest("closure"),
    } | _seed_fields(own)


def _seed_fields(own: Tally | None) -> Fields:
    """Return the number of seeds of the means, and their hash if all cases share them."""
    if own is None or own.seeds is None:
        return {}
    found = own.seeds
    shared = {"sha256_of_seeds": min(found.hashes)} if len(found.hashes) == 1 else {}
    return {"seeds": {"least": found.least, "greatest": found.most}} | shared


def _count_statuses(tallies: Collection[Tally]) -> dict[str, int]:
    """Count the statuses of the cases of all approaches."""
    lost: Counter[str] = Counter()
    for tally in tallies:
        lost.update({status: found.cases for status, found in tally.lost.items()})
    good = sum(tally.cases for tally in tallies) - lost.total()
    return {OK: good, **lost} if good else dict(lost)


def _metric_fields(tally: Tally | None) -> Fields:
    """Return the extremes of every metric that has a value in any case."""
    if tally is None:
        return {}
    return {
        name: {
            "least": _extreme_fields(ends[0], name),
            "greatest": _extreme_fields(ends[1], name),
        }
        | _quantile_fields(tally, name)
        for metric in METRICS
        if (ends := tally.extremes.get(name := metric.name)) is not None
    }


def _quantile_fields(tally: Tally, name: str) -> Fields:
    """Return the quantiles of a metric, if they were computed."""
    summary = tally.quantiles[name].summary() if name in tally.quantiles else {}
    return {"quantiles": summary} if summary else {}


def _extreme_fields(extreme: Extreme, metric: str) -> Fields:
    """Return an extreme and its place; of a mean over seeds also its half-width."""
    row = extreme.row
    mean = {"half_width": row.half_widths.get(metric), "seeds": row.seeds}
    return {"value": extreme.value, "where": dict(row.point)} | (mean if row.over else {})


def _deviation_fields(comparison: Comparison, approach: str) -> Fields:
    """Return the greatest deviation from the reference, and its place."""
    worst = compare.largest_deviation(compare.deviations(comparison, approach))
    if worst is None or approach == comparison.yardstick:
        return {}
    found = {"value": worst.value, "where": dict(worst.row.point)}
    mean = {} if worst.half_width is None else {"half_width": worst.half_width}
    return {"T_a_deviation": found | mean}


# Ensembles.


SEED_HEADER = f"{SEED_KEY} [-]"


def write_ensemble_csv(result: Ensemble, folder: Path) -> None:
    """Write ensemble.csv: all metrics of every seed, and the hash of its base motion."""
    names = [name for name in requested_metrics(result.scenario) if name != "closure"]
    headers = [SEED_HEADER, *map(column_header, names), "status", "sha256"]
    columns = [
        map(str, result.seeds),
        *metric_columns(result.rows, names),
        [row.status for row in result.rows],
        [row.sha256 for row in result.rows],
    ]
    write_csv(folder / "ensemble.csv", headers, [join_columns(columns)])


def write_seed_violations_csv(result: Ensemble, folder: Path) -> None:
    """Write stroke_violations.csv: the seeds that exceed the stroke limit, if any."""
    rows = [row for row in result.rows if row.metrics.get("violations")]
    if rows:
        seeds = [str(row.seed) for row in rows]
        columns = [seeds, *metric_columns(rows, VIOLATION_METRICS)]
        headers = [SEED_HEADER, *map(column_header, VIOLATION_COLUMNS)]
        write_csv(folder / "stroke_violations.csv", headers, [join_columns(columns)])


def ensemble_fields(result: Ensemble, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for an ensemble.

    The metrics are means.
    """
    residual = result.statistics["energy_residual"]
    numerics = {
        **asdict(result.shown.response.numerics),
        "step": result.response.dt,
        "cases": len(result.rows),
        "energy_residual": residual and residual.greatest[0],
    }
    motion = result.response.motion
    drawn = {
        **excitation_fields(result.scenario, motion),
        "sha256": combined_sha256(row.sha256 for row in result.rows),
        "seeds": len(result.rows),
        "sha256_of": "sha256 of every seed, one per line",
    }
    more = {"excitation": drawn, "ensemble": _statistics_fields(result)}
    return sidecar_fields(result, motion, numerics, result.metrics, provenance, **more)


def _statistics_fields(result: Ensemble) -> Fields:
    """Return the statistics of every metric that has a value."""
    until = stopping_rule(result.scenario)
    return {
        "seeds": len(result.rows),
        "first": result.seeds[0],
        "last": result.seeds[-1],
        "failed": sum(row.status != OK for row in result.rows),
        "until": until and until.model_dump(),
        "confidence": CONFIDENCE,
        "metrics": {
            name: _statistic_fields(found)
            for name, found in result.statistics.items()
            if found is not None
        },
    }


def _statistic_fields(found: Statistic) -> dict[str, Any]:
    """Return the statistics of one metric."""
    (least, at_least), (greatest, at_greatest) = found.least, found.greatest
    quantiles = {
        f"{100 * share:g} %": value
        for share, value in zip(QUANTILES, found.quantiles, strict=True)
    }
    return {
        "seeds": found.seeds,
        "mean": found.mean,
        "half_width": found.half_width,
        "std": found.std,
        "quantiles": quantiles,
        "least": {"value": least, "seed": at_least},
        "greatest": {"value": greatest, "seed": at_greatest},
    }


# Benches: speed_error.csv, hard_cases.csv, and their drysim.json.


BENCH_COLUMNS = ("step", "time_per_sample", "error_x_r", "error_T_a", "energy_residual")
LAST_BENCH_COLUMNS = ("time_over_lfilter", "samples", "repeats")
"""Columns of numbers, before and after the verdict."""

CASE_KEYS = ("scenario", "inputs", "excitation")
"""Fields of drysim.json that differ between the cases of a bench."""


def write_speed_error_csv(bench: Bench, folder: Path) -> None:
    """Write speed_error.csv: a row per entry and case."""
    headers = [
        "approach", "setting", *map(column_header, BENCH_COLUMNS), "verdict",
        "case", *map(column_header, LAST_BENCH_COLUMNS),
    ]  # fmt: skip
    rows = []
    for panel in bench.cases:
        for one in panel.scores:
            before = (one.step, one.time, one.error_x_r, one.error_T_a, one.energy_residual)
            rows.append(
                [
                    one.approach,
                    quote_cell(one.setting),
                    *map(format_cell, before),
                    quote_cell(one.verdict),
                    panel.scenario.name,
                    *map(format_cell, (one.ratio, one.samples, one.repeats)),
                ]
            )
    write_csv(folder / "speed_error.csv", headers, [join_columns(zip(*rows, strict=True))])


def bench_fields(bench: Bench, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for a bench."""
    numerics = {"engine": bench.engine, "cases": len(bench.cases)}
    metrics = {panel.scenario.name: _exact_fields(panel) for panel in bench.cases}
    frames = [
        sidecar_fields(panel, panel.motion, numerics, metrics, provenance)
        for panel in bench.cases
    ]
    cases = [
        {key: frame[key] for key in CASE_KEYS}
        | {"lfilter": panel.lfilter, "scores": [asdict(one) for one in panel.scores]}
        for panel, frame in zip(bench.cases, frames, strict=True)
    ]
    summary = {key: value for key, value in frames[0].items() if key not in CASE_KEYS}
    return summary | {"cases": cases, "warnings": [asdict(one) for one in bench.warnings]}


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


def write_hard_cases_csv(result: HardCases, folder: Path) -> None:
    """Write hard_cases.csv: a row per approach and case."""
    from drysim.bench.hard_cases import COMPARED_METRICS

    deviations = [f"{metric}_deviation" for metric in COMPARED_METRICS]
    numbers = [*deviations, "checks", "passed", "time"]
    headers = ["case", "approach", "verdict", "how", *map(column_header, numbers)]
    rows = []
    for case in result.cases:
        for one in case.results:
            off = [format_cell(one.deviations.get(metric)) for metric in COMPARED_METRICS]
            counts = [str(one.checks), str(one.passed), str(one.time)]
            words = [case.scenario.name, one.approach, one.verdict, quote_cell(one.reason)]
            rows.append([*words, *off, *counts])
    write_csv(folder / "hard_cases.csv", headers, [join_columns(zip(*rows, strict=True))])


def _trial_fields(result: HardCaseResult) -> Fields:
    """Return the result of one approach, under the keys of drysim.json."""
    fields = result._asdict()
    named = {"approach": "approach", "word": "verdict", "how": "reason"}
    return {key: fields.pop(name) for key, name in named.items()} | fields


def hard_case_fields(result: HardCases, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for the hard cases."""
    results = [one for case in result.cases for one in case.results]
    metrics: Fields = {
        name: dict(Counter(one.verdict for one in results if one.approach == name))
        for name in dict.fromkeys(one.approach for one in results)
    }
    cases: list[Fields] = [
        {
            "scenario": {"name": case.scenario.name, **origin_fields(case.scenario.origin)},
            "trials": [_trial_fields(one) for one in case.results],
        }
        for case in result.cases
    ]
    fields: Fields = {
        **header_fields(provenance),
        "numerics": {"engine": result.engine, "cases": len(cases)},
        "software": software_versions(),
        "metrics": metrics,
        "cases": cases,
        "checks": [],
        "warnings": [],
        "files": provenance.files,
    }
    return {key: sanitise(value) for key, value in fields.items()}


def quote_cell(words: str) -> str:
    """Return text as a CSV cell on one line, quoted if it has a comma or a quote."""
    words = " ".join(words.split())
    return '"' + words.replace('"', '""') + '"' if set(words) & set(',"') else words
