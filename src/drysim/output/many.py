"""drysim.json of many cases, and the CSV files of ensembles and benches.

Of a sweep and a comparison drysim.json tells the extremes with where they are, of an ensemble
the statistics over its seeds; ensemble.csv has a row for each seed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drysim.metrics.table import BOUNDED, COMFORT, METRICS, UNITS
from drysim.output.sidecar import (
    Ending,
    Fields,
    excitation,
    framed,
    head,
    origin,
    plain,
    software,
)
from drysim.output.tables import STROKE, VIOLATION, heading, joined, known, text, write
from drysim.scenario.blocks import SEED
from drysim.study import compare
from drysim.study.case import sha256_together
from drysim.study.statistics import CONFIDENCE, OK, QUANTILES, until_of

if TYPE_CHECKING:
    from drysim.bench.hard_cases import Ordeals
    from drysim.bench.score import Bench, Panel
    from drysim.study.compare import Comparison
    from drysim.study.ensemble import Ensemble
    from drysim.study.statistics import Statistic
    from drysim.study.table import Extreme, Table, Tally


def of_table(table: Table, ending: Ending) -> Fields:
    """Give everything that made the numbers of a sweep, ready for JSON.

    The metrics are extremes over the approach that was asked for, its reference left aside.
    """
    approach, *references = table.approaches or ("",)
    own = table.tallies.get(approach)
    numerics = {
        "approach": approach,
        "reference": next(iter(references), None),
        **_numerics(table, own),
    }
    return framed(table, table.motion, numerics, _metrics(own), ending)


def of_comparison(comparison: Comparison, ending: Ending) -> Fields:
    """Give the same for a comparison: extremes for each approach, deviations, the verdict."""
    table, yardstick = comparison.table, comparison.yardstick
    numerics = {
        "approaches": table.approaches,
        "yardstick": yardstick,
        "laws": comparison.laws,
        **_numerics(table, table.tallies.get(yardstick)),
    }
    metrics = {
        name: {**_metrics(tally), **_deviation(comparison, name)}
        for name, tally in table.tallies.items()
    }
    response = comparison.responses.get(yardstick)
    motion = table.motion if response is None else response.motion
    return framed(table, motion, numerics, metrics, ending, verdict=comparison.verdict)


def _numerics(table: Table, own: Tally | None) -> Fields:
    """Give how the numbers were made, and how well the worst of them closes."""
    return {
        "cases": len(table.rows),
        "statuses": _statuses(table.tallies.values()),
        "swept": [
            {"key": axis.key, "unit": axis.unit, "values": len(axis.values)}
            for axis in table.axes
        ],
        "step": table.scenario.solver.step,
        **table.numerics,
        "energy_residual": own and own.greatest("energy_residual"),
        "closure": own and own.greatest("closure"),
    } | _seeds(own)


def _seeds(own: Tally | None) -> Fields:
    """Give how many seeds the cases are means over; where all share them, their hash."""
    if own is None or own.seeds is None:
        return {}
    found = own.seeds
    shared = {"sha256_of_seeds": min(found.hashes)} if len(found.hashes) == 1 else {}
    return {"seeds": {"least": found.least, "greatest": found.most}} | shared


def _statuses(tallies: Collection[Tally]) -> dict[str, int]:
    """Count what became of the cases of all approaches."""
    lost: Counter[str] = Counter()
    for tally in tallies:
        lost.update({status: found.cases for status, found in tally.lost.items()})
    good = sum(tally.cases for tally in tallies) - lost.total()
    return {OK: good, **lost} if good else dict(lost)


def _metrics(tally: Tally | None) -> Fields:
    """Give the extremes of every metric that is known anywhere."""
    if tally is None:
        return {}
    return {
        name: {"least": _where(ends[0], name), "greatest": _where(ends[1], name)}
        | _quantiles(tally, name)
        for metric in METRICS
        if (ends := tally.extremes.get(name := metric.name)) is not None
    }


def _quantiles(tally: Tally, name: str) -> Fields:
    """Give the quantiles of a metric, where they were gathered."""
    told = tally.quantiles[name].told() if name in tally.quantiles else {}
    return {"quantiles": told} if told else {}


def _where(extreme: Extreme, metric: str) -> Fields:
    """Give an extreme and where it is; of a mean over many seeds how well it is known."""
    row = extreme.row
    mean = {"half_width": row.half_widths.get(metric), "seeds": row.seeds}
    return {"value": extreme.value, "where": dict(row.point)} | (mean if row.over else {})


def _deviation(comparison: Comparison, approach: str) -> Fields:
    """Give the greatest deviation from the yardstick, with where it is."""
    worst = compare.worst_of(compare.deviations(comparison, approach))
    if worst is None or approach == comparison.yardstick:
        return {}
    found = {"value": worst.value, "where": dict(worst.row.point)}
    mean = {} if worst.half_width is None else {"half_width": worst.half_width}
    return {"T_a_deviation": found | mean}


# Many seeds.


HEADING = f"{SEED} [-]"


def ensemble(made: Ensemble, folder: Path) -> None:
    """Write ensemble.csv: every metric of every seed, and the hash of its base motion."""
    left_out = {"closure"}
    left_out |= set() if made.scenario.measure.weights else {*COMFORT}
    left_out |= set() if made.scenario.stops else {*BOUNDED}
    names = [name for name in UNITS if name not in left_out]
    headings = [HEADING, *map(heading, names), "status", "sha256"]
    columns = [
        map(str, made.seeds),
        *known(made.rows, names),
        [row.status for row in made.rows],
        [row.sha256 for row in made.rows],
    ]
    write(folder / "ensemble.csv", headings, [joined(columns)])


def stroke_violations(made: Ensemble, folder: Path) -> None:
    """Write stroke_violations.csv: the seeds with which the stroke limit was met, if any."""
    rows = [row for row in made.rows if row.metrics.get("violations")]
    if rows:
        seeds = [str(row.seed) for row in rows]
        columns = [seeds, *known(rows, VIOLATION)]
        headings = [HEADING, *map(heading, STROKE)]
        write(folder / "stroke_violations.csv", headings, [joined(columns)])


def of_ensemble(made: Ensemble, ending: Ending) -> Fields:
    """Give everything that made the numbers of an ensemble, ready for JSON.

    The metrics are means.
    """
    residual = made.statistics["energy_residual"]
    numerics = {
        **asdict(made.shown.response.numerics),
        "step": made.response.dt,
        "cases": len(made.rows),
        "energy_residual": residual and residual.greatest[0],
    }
    motion = made.response.motion
    drawn = {
        **excitation(made.scenario, motion),
        "sha256": sha256_together(row.sha256 for row in made.rows),
        "seeds": len(made.rows),
        "sha256_of": "sha256 of every seed, one a line",
    }
    more = {"excitation": drawn, "ensemble": _ensemble(made)}
    return framed(made, motion, numerics, made.metrics, ending, **more)


def _ensemble(made: Ensemble) -> Fields:
    """Give the statistics of every metric that is known."""
    until = until_of(made.scenario)
    return {
        "seeds": len(made.rows),
        "first": made.seeds[0],
        "last": made.seeds[-1],
        "failed": sum(row.status != OK for row in made.rows),
        "until": until and until.model_dump(),
        "confidence": CONFIDENCE,
        "metrics": {
            name: _statistic(found)
            for name, found in made.statistics.items()
            if found is not None
        },
    }


def _statistic(found: Statistic) -> dict[str, Any]:
    """Give one statistic in words and numbers."""
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


# Benches: speed_error.csv, hard_cases.csv, and what drysim.json says of them.


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
    from drysim.bench.hard_cases import COMPARED

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
