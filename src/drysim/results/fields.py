"""drysim.json, the provenance of a result.

The metrics of a sweep and a comparison are extremes with their places, those of an ensemble are
means and statistics over its seeds. The file contains no absolute path, no user and no host,
and is strict JSON: `stored_fields` collects the fields, `sanitise` and its siblings clean
values and text.
"""

from __future__ import annotations

import hashlib
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
from drysim.core.model import Samples, Signal, Sines, blocks, without_rest
from drysim.errors import EXIT_INTERRUPTED, EXIT_NUMERICS_FAILED
from drysim.metrics.table import METRICS
from drysim.results.stored import metric_tables
from drysim.results.tables import COLUMN_UNITS
from drysim.study.statistics import OK

if TYPE_CHECKING:
    from drysim.metrics.checks import Verdict
    from drysim.scenario.axes import Axis
    from drysim.scenario.model import Scenario
    from drysim.study.table import Extreme, Table, Tally


FORMAT_VERSION = 2
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


def stored_fields(
    result: Any,
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
        **header_fields(result.kind, provenance, getattr(result, "complete", True)),
        "scenario": {"name": scenario.name, **origin_fields(scenario.origin)},
        "inputs": [
            {"file": sanitise_file(file), "sha256": sha256, "size": size}
            for file, sha256, size in inputs
        ],
        "excitation": excitation_fields(scenario, motion),
        "numerics": numerics,
        "software": software_versions(),
        "metrics": metrics,
        "units": metric_units(metrics),
        **further,
        "checks": [check_fields(verdict) for verdict in result.checks],
        "warnings": [asdict(warning) for warning in result.warnings],
        "files": provenance.files,
    }
    return {key: sanitise(value) for key, value in fields.items()}


def header_fields(kind: str, provenance: Provenance, complete: bool = True) -> Fields:
    """Return the first fields of every drysim.json."""
    exit_code = provenance.exit_code
    return {
        "format": FORMAT_VERSION,
        "version": drysim.__version__,
        "kind": kind,
        "command": sanitise_command(provenance.command),
        "created": creation_time(),
        "complete": complete and exit_code not in (EXIT_NUMERICS_FAILED, EXIT_INTERRUPTED),
        "exit_code": exit_code,
    }


def origin_fields(origin: Mapping[str, Any]) -> Fields:
    """Return the origin of a scenario: file name without folders, hash, overrides."""
    return {**origin, "file": sanitise_file(str(origin.get("file", "")))}


def excitation_fields(scenario: Scenario, motion: Sines | Samples | None) -> Fields:
    """Return the kind of base motion and, of a series, its hash."""
    block = scenario.excitation
    fields: Fields = {"kind": block.kind, "seed": getattr(block, "seed", None)}
    if isinstance(motion, Samples):
        fields["sha256"] = _signal_sha256(without_rest(motion).u_dd)
        if motion.realised:
            fields["realised"] = motion.realised
    return fields


def _signal_sha256(signal: Signal) -> str:
    """Return the SHA-256 (hex) of a signal as little-endian doubles."""
    digest = hashlib.sha256()
    for part in blocks(signal):
        digest.update(np.ascontiguousarray(part, dtype="<f8").data)
    return digest.hexdigest()


def check_fields(verdict: Verdict) -> Fields:
    """Return a verdict; over many cases with the deciding place, of a mean with its half-width.

    Value and limit have the unit of the metric. `passed` is None if the check was not judged;
    `reason` replaces a missing value.
    """
    check = verdict.check
    fields = {
        "check": str(check),
        "metric": check.metric,
        "operator": check.op,
        "limit": check.limit,
        "unit": COLUMN_UNITS[check.metric],
        "passed": verdict.passed,
        "value": verdict.value,
    }
    if verdict.reason:
        fields["reason"] = verdict.reason
    if verdict.cases:
        fields |= {"failed": verdict.failed, "cases": verdict.cases}
    if verdict.is_quantile_of_draws:
        fields["judges"] = check.judges
    if verdict.seeds > 1:
        fields |= {"judges": check.judges, "half_width": verdict.half_width}
        fields["seeds"] = verdict.seeds
    if verdict.failed_seeds:
        fields["failed_seeds"] = verdict.failed_seeds
    if verdict.worst_seed is not None:
        fields["worst_seed"] = verdict.worst_seed
    return fields if verdict.where is None else {**fields, "where": dict(verdict.where)}


def metric_units(metrics: Mapping[str, Any]) -> dict[str, str]:
    """Return the unit of every metric of a result, those of all approaches together."""
    return {
        name: COLUMN_UNITS[name]
        for _, table in metric_tables(metrics)
        for name in table
        if name in COLUMN_UNITS
    }


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


DIGEST = "sha256"
"""Field with the hash of the others."""


def digest_of(fields: Mapping[str, Any]) -> str:
    """Return the SHA-256 (hex) of the fields of a drysim.json.

    It is that of their JSON with sorted keys and without blanks, whatever the layout of the
    file. `DIGEST` itself is left out, and `created`, in which alone two runs differ.
    """
    content = {key: value for key, value in fields.items() if key not in (DIGEST, "created")}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def is_intact(fields: Mapping[str, Any]) -> bool:
    """Whether the fields of a drysim.json are those that drysim wrote."""
    return fields.get(DIGEST) == digest_of(fields)


def json_text(fields: Mapping[str, Any]) -> str:
    """Return fields as JSON in ASCII, which every terminal and pipe can encode."""
    return json.dumps(fields, indent=2, allow_nan=False) + "\n"


# Sweeps, comparisons, ensembles and benches.


def numerics_fields(table: Table, tally: Tally | None) -> Fields:
    """Return how the numbers were computed, with the worst residuals and closure."""
    return {
        "cases": len(table.rows),
        "statuses": _count_statuses(table.tallies.values()),
        "swept": axis_fields(table.axes),
        "step": table.scenario.solver.step,
        **table.numerics,
        "energy_residual": tally and tally.greatest("energy_residual"),
        "law_residual": tally and tally.greatest("law_residual"),
        "closure": tally and tally.greatest("closure"),
    } | _seed_fields(tally)


def axis_fields(axes: Iterable[Axis]) -> list[Fields]:
    """Return the swept keys with their units and numbers of values."""
    return [{"key": axis.key, "unit": axis.unit, "values": len(axis.values)} for axis in axes]


def _seed_fields(tally: Tally | None) -> Fields:
    """Return the number of seeds of the means."""
    if tally is None or tally.seeds is None:
        return {}
    return {"seeds": {"least": tally.seeds.least, "greatest": tally.seeds.most}}


def _count_statuses(tallies: Collection[Tally]) -> dict[str, int]:
    """Count the statuses of the cases of all approaches."""
    lost: Counter[str] = Counter()
    for tally in tallies:
        lost.update({status: loss.cases for status, loss in tally.lost.items()})
    good = sum(tally.cases for tally in tallies) - lost.total()
    return {OK: good, **lost} if good else dict(lost)


def metric_fields(tally: Tally | None) -> Fields:
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
        arguments = shlex.split(command)
    except ValueError:
        return command
    return shlex.join(LEADING_FOLDERS.sub(r"\1", word) for word in arguments)
