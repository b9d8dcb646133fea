"""drysim.json, the provenance of a result.

The metrics of a sweep and a comparison are extremes with their places, those of an ensemble are
means and statistics over its seeds. The file contains no absolute path, no user and no host,
and is strict JSON: `sidecar_fields` collects the fields, `sanitise` and its siblings clean
values and text.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import sys
import time
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import asdict
from datetime import UTC, datetime
from math import isfinite
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import drysim
from drysim.core.compile import engine
from drysim.core.model import Samples, Sines, without_rest
from drysim.errors import EXIT_INTERRUPTED, EXIT_NUMERICS_FAILED
from drysim.metrics.table import METRICS
from drysim.scenario.axes import DIRECTION_KEY
from drysim.study.case import signal_sha256
from drysim.study.statistics import CONFIDENCE, OK, QUANTILES, stopping_rule
from drysim.study.table import JUMP_METRICS, RATIO_KEY

if TYPE_CHECKING:
    from drysim.bench.hard_cases import HardCaseResult, HardCases
    from drysim.bench.score import Bench, BenchCase
    from drysim.metrics.checks import Verdict
    from drysim.metrics.spectra import Spectra
    from drysim.scenario.axes import Axis
    from drysim.scenario.model import Scenario
    from drysim.study.branches import BranchesResult
    from drysim.study.compare import Comparison
    from drysim.study.design import Candidate, DesignResult
    from drysim.study.ensemble import Ensemble
    from drysim.study.fit import FitResult
    from drysim.study.outcome import Outcome
    from drysim.study.regimes import RegimeMap
    from drysim.study.statistics import Row, Statistic
    from drysim.study.table import BestCase, Extreme, Table, Tally


FORMAT_VERSION = 1
"""Version of the layout of drysim.json."""

SOFTWARE_PACKAGES = ("numpy", "scipy", "numba", "pydantic", "yaml", "matplotlib")
"""Packages that affect numbers and pictures; listed if they were imported."""

Fields = dict[str, Any]


class Provenance(NamedTuple):
    """What the command contributes to drysim.json."""

    command: str
    """The command line, quoted for a shell."""
    exit_code: int
    files: Mapping[str, str]
    """Name of each file in the output folder to its SHA-256 (hex)."""


def run_fields(outcome: Outcome, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for a run.

    Values that are not finite become None.
    """
    numerics = {
        **asdict(outcome.response.numerics),
        "step": outcome.response.dt,
        "cases": 1,
        "energy_residual": outcome.metrics["energy_residual"],
        "law_residual": outcome.metrics["law_residual"],
    }
    if outcome.spectra is not None:
        numerics["spectra"] = _spectra_fields(outcome.spectra)
    return sidecar_fields(
        outcome, outcome.response.motion, numerics, outcome.metrics, provenance
    )


def _spectra_fields(found: Spectra) -> Fields:
    """Return the parameters of the spectral estimate."""
    return {
        "method": "Welch, Hann window, half overlapping, mean of the window removed",
        "series": "means over each step, corrected for their attenuation with frequency",
        "segment": found.segment,
        "segments": found.segments,
        "resolution": 1.0 / found.segment,
    }


def sidecar_fields(
    result: Outcome
    | Ensemble
    | Table
    | BenchCase
    | FitResult
    | DesignResult
    | BranchesResult
    | RegimeMap,
    motion: Sines | Samples | None,
    numerics: Mapping[str, Any],
    metrics: Mapping[str, Any],
    provenance: Provenance,
    **further: Any,
) -> Fields:
    """Return the content of drysim.json.

    Parameters
    ----------
    result : object
        What was computed.
    motion : Sines or Samples or None
        The base motion; None if it differs from case to case.
    numerics, metrics : mapping
        How the numbers were computed, and the numbers.
    provenance : Provenance
    **further
        Further fields, placed after the metrics.
    """
    scenario, law = result.scenario, result.scenario.law()
    force_record = law.force_record
    records = getattr(result, "inputs", ()) or getattr(motion, "inputs", ())
    inputs = (*records, *(force_record.inputs if force_record else ()))
    fields = {
        **header_fields(provenance, getattr(result, "complete", True)),
        "scenario": {"name": scenario.name, **origin_fields(scenario.origin)},
        "inputs": [
            {"file": sanitise_file(file), "sha256": sha256, "size": size}
            for file, sha256, size in inputs
        ],
        "excitation": excitation_fields(scenario, motion),
        "numerics": numerics,
        "software": software_versions(),
        "metrics": metrics,
        **further,
        "checks": [_check_fields(verdict) for verdict in result.checks],
        "warnings": [asdict(warning) for warning in result.warnings],
        "files": provenance.files,
    }
    return {key: sanitise(value) for key, value in fields.items()}


def header_fields(provenance: Provenance, complete: bool = True) -> Fields:
    """Return the first fields of every drysim.json."""
    exit_code = provenance.exit_code
    return {
        "format": FORMAT_VERSION,
        "version": drysim.__version__,
        "command": sanitise_command(provenance.command),
        "created": creation_time(),
        "complete": complete and exit_code not in (EXIT_NUMERICS_FAILED, EXIT_INTERRUPTED),
        "exit_code": exit_code,
    }


def origin_fields(known: Mapping[str, Any]) -> Fields:
    """Return the origin of a scenario: file name without folders, hash, overrides."""
    return {**known, "file": sanitise_file(str(known.get("file", "")))}


def excitation_fields(scenario: Scenario, motion: Sines | Samples | None) -> Fields:
    """Return the kind of base motion and, of a series, its hash."""
    block = scenario.excitation
    fields: Fields = {"kind": block.kind, "seed": getattr(block, "seed", None)}
    if isinstance(motion, Samples):
        fields["sha256"] = signal_sha256(without_rest(motion).u_dd)
        if motion.realised:
            fields["realised"] = motion.realised
    return fields


def _check_fields(verdict: Verdict) -> Fields:
    """Return a verdict; over many cases with the deciding place, of a mean with its half-width.

    `passed` is None if the check was not judged; `reason` replaces a missing value.
    """
    fields = {"check": str(verdict.check), "passed": verdict.passed, "value": verdict.value}
    if verdict.reason:
        fields["reason"] = verdict.reason
    if verdict.cases:
        fields |= {"failed": verdict.failed, "cases": verdict.cases}
    if verdict.seeds > 1:
        fields |= {"half_width": verdict.half_width, "seeds": verdict.seeds}
    return fields if verdict.where is None else {**fields, "where": dict(verdict.where)}


def creation_time() -> str:
    """Return the current time in UTC, or that of SOURCE_DATE_EPOCH."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    try:
        time_utc = datetime.fromtimestamp(int(epoch), UTC)
    except (ValueError, OverflowError, OSError):
        time_utc = datetime.fromtimestamp(int(time.time()), UTC)
    return time_utc.strftime("%Y-%m-%dT%H:%M:%SZ")


def software_versions() -> dict[str, str]:
    """Return the versions of Python and of the imported packages; imports nothing."""
    versions = {"python": ".".join(map(str, sys.version_info[:3]))}
    for name in SOFTWARE_PACKAGES:
        if name in sys.modules:
            versions[name] = str(getattr(sys.modules[name], "__version__", ""))
    return versions


def json_text(fields: Mapping[str, Any]) -> str:
    """Return fields as JSON in ASCII, which every terminal and pipe can encode."""
    return json.dumps(fields, indent=2, allow_nan=False) + "\n"


# Sweeps, comparisons, ensembles and benches.


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
    metrics = _metric_fields(own)
    further: Fields = {"best": _best_fields(table.best)} if table.best else {}
    if table.hysteresis is not None:
        further["hysteresis"] = [
            {
                "key": table.axes[0].key,
                "from": one.low,
                "to": one.high,
                "T_a": {
                    row.point[DIRECTION_KEY]: row.metrics["T_a"] for row in (one.up, one.down)
                },
                "where": one.point,
            }
            for one in table.hysteresis
        ]
    if table.jumps is not None:
        further["jumps"] = [
            {
                "key": RATIO_KEY,
                "at": jump.value,
                "where": jump.point,
                **{
                    name: {"below": jump.below.metrics[name], "above": jump.above.metrics[name]}
                    for name in JUMP_METRICS
                },
            }
            for jump in table.jumps
        ]
    return sidecar_fields(table, table.motion, numerics, metrics, provenance, **further)


def _best_fields(best: BestCase) -> Fields:
    """Return the best admissible case, or the check that the closest one fails."""
    at = None if best.row is None else dict(best.row.point)
    count = {"admissible": best.admissible, "cases": best.cases}
    fields: Fields = {"metric": best.objective, "value": best.value, "at": at, **count}
    if best.closest:
        fields["closest"] = _check_fields(best.closest)
    if best.over_records:
        fields["over_records"] = _best_fields(best.over_records)
    return fields


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
    """Return how the numbers were computed, with the worst residuals and closure."""
    return {
        "cases": len(table.rows),
        "statuses": _count_statuses(table.tallies.values()),
        "swept": _axis_fields(table.axes),
        "step": table.scenario.solver.step,
        **table.numerics,
        "energy_residual": own and own.greatest("energy_residual"),
        "law_residual": own and own.greatest("law_residual"),
        "closure": own and own.greatest("closure"),
    } | _seed_fields(own)


def _axis_fields(axes: Iterable[Axis]) -> list[Fields]:
    """Return the swept keys with their units and numbers of values."""
    return [{"key": axis.key, "unit": axis.unit, "values": len(axis.values)} for axis in axes]


def _seed_fields(own: Tally | None) -> Fields:
    """Return the number of seeds of the means."""
    if own is None or own.seeds is None:
        return {}
    return {"seeds": {"least": own.seeds.least, "greatest": own.seeds.most}}


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
    from drysim.study.compare import deviations, largest_deviation

    worst = largest_deviation(deviations(comparison, approach))
    if worst is None or approach == comparison.yardstick:
        return {}
    found = {"value": worst.value, "where": dict(worst.row.point)}
    mean = {} if worst.half_width is None else {"half_width": worst.half_width}
    return {"T_a_deviation": found | mean}


# Ensembles.


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


# Benches.


CASE_KEYS = ("scenario", "inputs", "excitation")
"""Fields of drysim.json that differ between the cases of a bench."""


def fit_fields(result: FitResult, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for a fit."""
    agree, total = result.starts
    numerics = {
        "method": "least squares on the exact motion",
        "step": result.measurement.dt,
        "samples": len(result.measurement.t),
        "selected": int(result.selected.sum()),
        "held_out_from": result.fitted_end,
        "starts": {"total": total, "agree": agree},
    }
    found = {
        "parameters": [one._asdict() for one in result.parameters],
        "correlations": [
            {"keys": [a, b], "correlation": value} for a, b, value in result.correlations
        ],
        "channels": [one._asdict() for one in result.channels],
        "laws": [one._asdict() for one in result.laws],
    }
    return sidecar_fields(
        result, result.motion, numerics, result.metrics, provenance, fit=found
    )


def design_fields(result: DesignResult, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for a design study."""
    from drysim.study.design import keys_at_bounds

    names, front = result.design.minimise, result.front if len(result.front) > 1 else ()
    regions = {"optimum": result.optimum, "within_1_percent": result.flat}

    def fields_of(one: Candidate) -> Fields:
        return {
            "design": one.number,
            "values": one.values,
            "objectives": dict(zip(names, one.objectives, strict=True)),
            "excess": max(one.excess, default=0.0),
            "admissible": one.is_admissible,
        }

    found = {
        "vary": {one.key: {**one.words, "unit": one.unit} for one in result.design.vary},
        "minimise": list(names),
        "within": [str(limit) for limit in result.limits],
        "shown": result.shown_name,
        "at_bounds": keys_at_bounds(result),
        "best": result.best and fields_of(result.best),
        "closest": None if result.best or not result.closest else fields_of(result.closest),
        "half_widths": dict(zip(names, result.half_widths, strict=True)),
        **{name: region and region.ends for name, region in regions.items()},
        "binding": [
            {"limit": str(one.limit), "objective_without": one.objective}
            for one in result.binding
        ],
        "variants": {one.name: fields_of(one.candidate) for one in result.variants},
        "front": [fields_of(one) for one in front],
        "conditions": [_condition_fields(result, row) for row in result.several_rows],
        "metrics_at": result.shown_row and result.place_of(result.shown_row),
    }
    numerics = {
        **result.numerics,
        "method": "surrogate model of objectives and limits (radial basis functions), refined "
        "by exact solutions under the same base motion",
        "evaluations": len(result.candidates),
        "converged": result.converged,
        "swept": _axis_fields(result.design.conditions.axes),
        "cases": sum(row.seeds for one in result.candidates for row in one.rows),
        "seeds": result.candidates[0].rows[0].seeds,
    }
    return sidecar_fields(
        result, result.motion, numerics, result.metrics, provenance, design=found
    )


def branches_fields(result: BranchesResult, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for branches."""
    found = {
        "key": result.axis.key,
        "unit": result.axis.unit,
        "own_value": result.own,
        "starts": result.starts,
        "branches": [
            {
                "branch": one.number,
                "kind": one.kind,
                "periods": one.periods,
                "points": len(one.values),
                "lowest": float(one.values.min()),
                "highest": float(one.values.max()),
                "stable_points": int(one.stable.sum()),
                "ends": list(one.ends),
            }
            for one in result.branches
        ],
        "bifurcations": [one._asdict() for one in result.bifurcations],
        "motions": [{**one._asdict(), "branch": one.branch.number} for one in result.motions],
    }
    numerics = {
        **result.numerics,
        "method": f"pseudo-arclength continuation of periodic orbits, {result.method}",
        "points": sum(len(one.values) for one in result.branches),
        "residual": result.residual,
        "multiplier_error": result.multiplier_error,
    }
    return sidecar_fields(result, result.motion, numerics, {}, provenance, branches=found)


CONDITION_METRICS = ("T_a", "SEAT", "x_r_peak", "stroke_used")
"""Metrics of the best design under each condition, after its objectives."""


def _condition_fields(result: DesignResult, row: Row) -> Fields:
    """Return limits and main metrics of the shown design under one of its conditions."""
    names = dict.fromkeys((*result.design.minimise, *CONDITION_METRICS))
    return {
        "at": result.place_of(row),
        "metrics": {name: row.metrics.get(name) for name in names},
        "half_widths": {name: row.half_widths.get(name) for name in names},
        "checks": [_check_fields(verdict) for verdict in result.judge((row,))],
    }


def map_fields(result: RegimeMap, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for a regime map."""
    lines, place = result.boundaries, result.place
    numerics = {
        "method": "break-aways counted on a grid; lines interpolated on its edges"
        if place.rates is not None
        else "periodic orbits on a grid; boundaries bisected on its edges",
        "engine": engine(),
        "cases": result.cases,
        "cell": [float(shares[1]) for shares in result.grid.shares],
        "width": max((line.width for line in lines), default=0.0),
    }
    found = {
        "axes": [
            {"key": axis.key, "unit": axis.unit, **axis.words, "count": count}
            for axis, count in zip(result.axes, result.grid, strict=True)
        ],
        "regimes": result.regimes,
        "boundaries": dict(Counter(line.name for line in lines)),
        "here": {
            "values": dict(place.values),
            "motion": list(result.describe_place()),
            "rates": place.rates and place.rates._asdict(),
            "nearest": [
                {"key": one.key, "distance": one.distance, "what": one.sentence}
                for one in place.changes
            ],
        },
    }  # fmt: skip
    return sidecar_fields(
        result, result.motion, numerics, result.metrics, provenance, map=found
    )


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


# Values and text without private data.


ABSOLUTE_FOLDERS = re.compile(
    r"(?<![\w.)\]/~:-])(?:~\w*|[A-Za-z]:)?[\\/](?:[^\\/\s'\"`:;,=]+[\\/])*(?=\w)"
)
"""The folders of an absolute path within a sentence."""

LEADING_FOLDERS = re.compile(r"(^|=)(?:~\w*|[A-Za-z]:)?[\\/](?:.*[\\/])?(?=.)")
"""The folders of an absolute path that is one argument of a command, with blanks."""


def sanitise(value: Any) -> Any:
    """Return a value as JSON type: finite numbers, no absolute paths, no numpy types."""
    if isinstance(value, Mapping):
        return {str(key): sanitise(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [sanitise(inner) for inner in value]
    if isinstance(value, np.generic):
        return sanitise(value.item())
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, str):
        return ABSOLUTE_FOLDERS.sub("", value).encode(errors="replace").decode()
    return str(value) if isinstance(value, PurePath) else value


def sanitise_file(file: str) -> str:
    """Return a file name as it was typed, an absolute one without its folders."""
    return LEADING_FOLDERS.sub("", file, count=1)


def sanitise_command(command: str) -> str:
    """Return a command line, absolute paths without their folders."""
    try:
        words = shlex.split(command)
    except ValueError:
        return command
    return shlex.join(LEADING_FOLDERS.sub(r"\1", word) for word in words)
