"""drysim.json, the provenance of a result, and spectra.csv of a run.

The file contains no absolute path, no user and no host, and is strict JSON: `sidecar_fields`
collects the fields, `sanitise` and its siblings clean values and text.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import sys
import time
from collections.abc import Mapping
from dataclasses import asdict
from datetime import UTC, datetime
from math import isfinite
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import drysim
from drysim.core.model import Samples, Sines
from drysim.errors import EXIT_INTERRUPTED, EXIT_NUMERICS_FAILED
from drysim.output.tables import (
    format_cell,
    format_numbers,
    join_columns,
    join_rows,
    write_csv,
)
from drysim.study.case import signal_sha256

if TYPE_CHECKING:
    from drysim.bench.score import BenchCase
    from drysim.metrics.checks import Verdict
    from drysim.metrics.spectra import Spectra
    from drysim.scenario.model import Scenario
    from drysim.study.ensemble import Ensemble
    from drysim.study.outcome import Outcome
    from drysim.study.table import Table


FORMAT_VERSION = 1
"""Version of the layout of drysim.json."""

SOFTWARE_PACKAGES = ("numpy", "scipy", "numba", "pydantic", "yaml", "matplotlib")
"""Packages that affect numbers and pictures; listed if they were imported."""

Fields = dict[str, Any]


class Provenance(NamedTuple):
    """What the command contributes to drysim.json.

    Attributes
    ----------
    command : str
        The command line, quoted for a shell.
    exit_code : int
    files : mapping
        Name of each file in the output folder to its SHA-256 (hex).
    """

    command: str
    exit_code: int
    files: Mapping[str, str]


def run_fields(outcome: Outcome, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for a run.

    Values that are not finite become None.
    """
    numerics = {
        **asdict(outcome.response.numerics),
        "step": outcome.response.dt,
        "cases": 1,
        "energy_residual": outcome.metrics["energy_residual"],
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


def write_spectra_csv(outcome: Outcome, folder: Path) -> None:
    """Write spectra.csv, if spectra were requested."""
    found = outcome.spectra
    if found is None:
        return
    columns = {
        "f [Hz]": found.f,
        "G_u [(m/s2)2/Hz]": found.G_u,
        "G_x [(m/s2)2/Hz]": found.G_x,
        "H1 [-]": np.abs(found.H1),
        "phase [rad]": np.angle(found.H1),
        "coherence [-]": found.coherence,
    }
    rows = join_rows([format_numbers(list(columns.values()))])
    write_csv(folder / "spectra.csv", list(columns), [rows])


def write_bands_csv(outcome: Outcome, folder: Path) -> None:
    """Write bands.csv, if one-third-octave bands were requested."""
    if outcome.spectra is None or outcome.spectra.bands is None:
        return
    from drysim.metrics.spectra import BANDS

    a_u, a_x, a_wu, a_w = outcome.spectra.bands
    columns = {"f [Hz]": np.array(BANDS), "a_u [m/s2]": a_u, "a_x [m/s2]": a_x}
    if a_wu is not None and a_w is not None:
        columns |= {"a_wu [m/s2]": a_wu, "a_w [m/s2]": a_w}
    cells = [[format_cell(value) for value in column.tolist()] for column in columns.values()]
    write_csv(folder / "bands.csv", list(columns), [join_columns(cells)])


def sidecar_fields(
    result: Outcome | Ensemble | Table | BenchCase,
    motion: Sines | Samples | None,
    numerics: Mapping[str, Any],
    metrics: Mapping[str, Any],
    provenance: Provenance,
    **further: Any,
) -> Fields:
    """Return the content of drysim.json.

    Parameters
    ----------
    result : Outcome or Ensemble or Table or BenchCase
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
    inputs = (*getattr(motion, "inputs", ()), *(force_record.inputs if force_record else ()))
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
        fields["sha256"] = signal_sha256(motion.u_dd)
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
