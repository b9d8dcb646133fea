"""An ensemble: one case under many seeds. Its files, fields, pictures and summary."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drysim import wording
from drysim.metrics.checks import seeds_for_quantile
from drysim.metrics.table import HOURLY_STROKE, METRICS_BY_NAME, PEAK_STROKE
from drysim.metrics.text import (
    MEANINGS,
    describe_main_numbers,
    describe_residual,
    format_value,
)
from drysim.results.fields import excitation_fields, stored_fields
from drysim.results.kind import File, Kind, Picture, describe_incomplete, judgements
from drysim.results.run import RUN, describe_hourly_use, run_scene
from drysim.results.tables import (
    SEED_COLUMN,
    STATUS_COLUMN,
    metric_column,
    requested_metrics,
    write_cases,
    write_violations,
)
from drysim.scenario.text import describe_seeds
from drysim.study.statistics import CONFIDENCE, OK, QUANTILES, max_seeds, stopping_rule
from drysim.study.summary import BAD, Row, Summary
from drysim.study.table import hourly_stroke_used
from drysim.wording import (
    display_unit,
    format_count,
    format_interval,
    format_number,
    format_percent,
    format_range,
)

if TYPE_CHECKING:
    from drysim.results.fields import Fields, Provenance
    from drysim.study.ensemble import Ensemble
    from drysim.study.statistics import Statistic

VALUE_WIDTH = 22
"""Columns of the values."""


MAIN_METRICS = ("T_a", "SEAT", "a_w", "T_x", PEAK_STROKE, HOURLY_STROKE, "stuck_share")
"""Metrics with a row of their own, besides that of the stopping rule."""

END_STOP_METRICS = {
    "impact_speed": "at up to",
    "stop_force_peak": "force up to",
    "impulse_peak": "impulse up to",
}
"""Metrics of the severity of end-stop impacts, and the words before their values."""

MIN_QUANTILE_SEEDS = seeds_for_quantile(max(QUANTILES))
"""Least number of seeds whose scatter is described by quantiles."""


def summarise(ensemble: Ensemble) -> Summary:
    """Return the summary of an ensemble."""
    return Summary(
        name=wording.sanitise(ensemble.scenario.name),
        about=ensemble.scenario.about,
        scene=tuple(ensemble_scene(ensemble)),
        groups=(tuple(ensemble_rows(ensemble)),),
        width=VALUE_WIDTH,
        checks=judgements(ensemble.checks),
        answer=(describe_main_numbers(ensemble.metrics),),
    )


def ensemble_scene(ensemble: Ensemble) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was solved, and with which seeds."""
    for name, sentence in run_scene(ensemble.shown):
        yield name, sentence
        if name == "base":
            until = stopping_rule(ensemble.scenario)
            yield "seeds", describe_seeds(ensemble.seeds, until)
            if not ensemble.complete:
                yield (
                    "state",
                    describe_incomplete(
                        len(ensemble.rows), max_seeds(ensemble.scenario), "seed"
                    ),
                )


def ensemble_rows(ensemble: Ensemble) -> Iterator[Row]:
    """Yield the main metrics, and the metric of the stopping rule."""
    until = stopping_rule(ensemble.scenario)
    good = sum(row.status == OK for row in ensemble.rows)
    peak = ensemble.statistics[PEAK_STROKE]
    peak_scale = peak.greatest[0] if peak else 0.0
    for name in dict.fromkeys((*MAIN_METRICS, *([until.metric] if until else []))):
        metric, statistic = METRICS_BY_NAME[name], ensemble.statistics[name]
        decides = until is not None and name == until.metric
        # A mean over only some of the seeds is biased: omitted here, but kept in drysim.json.
        if statistic is not None and (decides or statistic.seeds == good):
            scale, unit = display_unit(metric.shown, statistic.greatest[0], peak_scale)
            width = None if statistic.half_width is None else statistic.half_width * scale
            mean = format_interval(statistic.mean * scale, width, unit)
            scatter = _describe_scatter(ensemble, name, statistic, scale, unit)
            yield Row(metric.label, mean, "; ".join(scatter))
    yield from _limit_rows(ensemble)
    residual = ensemble.statistics["energy_residual"]
    if residual:
        yield Row("energy", describe_residual(residual.greatest[0], "at most "))
    if lost := sum(row.status != OK for row in ensemble.rows):
        yield Row("failed", format_count(lost, "seed"), tone=BAD)


def _describe_scatter(
    ensemble: Ensemble, metric: str, statistic: Statistic, scale: float, unit: str
) -> Iterator[str]:
    """Yield what a metric is, and its scatter over the seeds."""
    if metric in MEANINGS:
        yield MEANINGS[metric]
    low, high = (statistic.quantiles[place] * scale for place in (0, -1))
    if format_number(low) != format_number(high):
        which = "90 % of" if statistic.seeds >= MIN_QUANTILE_SEEDS else f"all {statistic.seeds}"
        yield f"{which} seeds: {format_range(low, high, unit)}"
    if statistic.seeds < len(ensemble.rows):
        yield f"from {statistic.seeds} of {len(ensemble.rows)} seeds"
    used, stroke = ensemble.statistics.get("stroke_used"), ensemble.scenario.stroke
    if metric == HOURLY_STROKE and stroke is not None and not ensemble.scenario.stops:
        hourly = hourly_stroke_used(ensemble.metrics, stroke.limits)
        yield f"mean {describe_hourly_use(hourly)}"
    if metric == PEAK_STROKE and used:
        share, seed = used.greatest
        yield f"largest with seed {seed}, {format_percent(share)} of the stroke limit"


def _limit_rows(ensemble: Ensemble) -> Iterator[Row]:
    """Yield how many seeds exceed the stroke limit, and how hard they hit end stops."""
    beyond = sum(bool(row.metrics.get("violations")) for row in ensemble.rows)
    if beyond:
        seeds, how = f"{beyond} of {format_count(len(ensemble.rows), 'seed')}", []
        name, value = "limit", f"exceeded for {seeds}"
        for metric, verb in END_STOP_METRICS.items():
            if (statistic := ensemble.statistics.get(metric)) and statistic.greatest[0] > 0:
                greatest, seed = statistic.greatest
                name, value = "stops hit", seeds
                how.append(f"{verb} {format_value(metric, greatest)} with seed {seed}")
        yield Row(name, value, ", ".join(how), BAD)


def write_ensemble_csv(result: Ensemble, file: Path) -> None:
    """Write ensemble.csv: all metrics of every seed."""
    names = [name for name in requested_metrics(result.scenario) if name != "closure"]
    columns = [SEED_COLUMN, *map(metric_column, names), STATUS_COLUMN]
    write_cases(file, columns, result.rows)


def write_seed_violations_csv(result: Ensemble, file: Path) -> None:
    """Write stroke_violations.csv: the seeds that exceed the stroke limit, if any."""
    if any(row.metrics.get("violations") for row in result.rows):
        write_violations(file, [SEED_COLUMN], result.rows, result.scenario.label)


def ensemble_fields(result: Ensemble, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for an ensemble.

    The metrics are means.
    """
    statistics = result.statistics
    energy, law = (statistics[name] for name in ("energy_residual", "law_residual"))
    numerics = {
        **asdict(result.shown.response.numerics),
        "step": result.response.dt,
        "cases": len(result.rows),
        "energy_residual": energy and energy.greatest[0],
        "law_residual": law and law.greatest[0],
    }
    motion = result.response.motion
    drawn = excitation_fields(result.shown.scenario, motion) | {"seeds": len(result.rows)}
    more = {"excitation": drawn, "ensemble": _statistics_fields(result)}
    return stored_fields(result, motion, numerics, result.metrics, provenance, **more)


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
            name: _statistic_fields(statistic)
            for name, statistic in result.statistics.items()
            if statistic is not None
        },
    }


def _statistic_fields(statistic: Statistic) -> dict[str, Any]:
    """Return the statistics of one metric."""
    (least, at_least), (greatest, at_greatest) = statistic.least, statistic.greatest
    quantiles = {
        f"{100 * share:g} %": value
        for share, value in zip(QUANTILES, statistic.quantiles, strict=True)
    }
    return {
        "seeds": statistic.seeds,
        "mean": statistic.mean,
        "half_width": statistic.half_width,
        "std": statistic.std,
        "quantiles": quantiles,
        "least": {"value": least, "seed": at_least},
        "greatest": {"value": greatest, "seed": at_greatest},
    }


def of_shown_seed(file: File) -> File:
    """Return a file of a run as a file of an ensemble, whose shown seed it describes."""
    return file._replace(write=lambda ensemble, path: file.write(ensemble.shown, path))


ENSEMBLE = Kind(
    name="ensemble",
    what="one case under many seeds",
    files=(
        File("ensemble.csv", write_ensemble_csv),
        File("stroke_violations.csv", write_seed_violations_csv),
        *(of_shown_seed(file) for file in RUN.files if file.name != "stroke_violations.csv"),
    ),
    pictures=(
        Picture(
            "ensemble",
            "ensemble.draw",
            "Share of the seeds below a value, and the mean over the number of seeds",
        ),
        *(picture._replace(shown=lambda ensemble: ensemble.shown) for picture in RUN.pictures),
    ),
    fields=ensemble_fields,
    summary=summarise,
)
