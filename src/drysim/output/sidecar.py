"""drysim.json: what made these numbers; of a run also spectra.csv.

It holds no absolute path, no user and no host, and nothing but JSON: what every such file says
is `sidecar_fields`, and values and words leave the machine as `sanitise` and its like make them.
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
from drysim.core.model import NormalForceLaw, Samples, Sines
from drysim.errors import EXIT_INTERRUPTED, EXIT_NUMERICS_FAILED
from drysim.output.tables import format_floats, join_columns, write_csv
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
"""Packages that take part in the numbers and pictures; named when they were loaded."""

Fields = dict[str, Any]


class Provenance(NamedTuple):
    """What every command that writes files ends with.

    Attributes
    ----------
    command : str
        The command line, quoted as for a shell.
    exit_code : int
    files : mapping
        SHA-256 (hex) by name of the file in the output folder.
    """

    command: str
    exit_code: int
    files: Mapping[str, str]


def run_fields(outcome: Outcome, provenance: Provenance) -> Fields:
    """Give everything that made the numbers of an outcome, ready for JSON.

    Values that are not finite are None.
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
    """Give how spectra were made."""
    return {
        "method": "Welch, Hann window, half overlapping, mean of the window removed",
        "series": "means over every step, their fading with frequency taken back",
        "segment": found.segment,
        "segments": found.segments,
        "resolution": 1.0 / found.segment,
    }


def write_spectra_csv(outcome: Outcome, folder: Path) -> None:
    """Write spectra.csv, but only when spectra were asked for."""
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
    cells = [
        [text if text != "nan" else "" for text in format_floats(column)]
        for column in columns.values()
    ]
    write_csv(folder / "spectra.csv", list(columns), [join_columns(cells)])


def sidecar_fields(
    result: Outcome | Ensemble | Table | BenchCase,
    motion: Sines | Samples | None,
    numerics: Mapping[str, Any],
    metrics: Mapping[str, Any],
    provenance: Provenance,
    **further: Any,
) -> Fields:
    """Give what was found with all that every drysim.json says.

    Parameters
    ----------
    made : Outcome or Ensemble or Table or Panel
        What was computed.
    motion : Sines or Samples or None
        How the base moved; None where it moved differently from case to case.
    numerics, metrics : mapping
        How the numbers were made, and what they came to.
    ending : Ending
    **further
        What else is told, behind the metrics.
    """
    scenario, law = result.scenario, result.scenario.law()
    force_record = law.force_record if isinstance(law, NormalForceLaw) else None
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
    """Give what every drysim.json begins with."""
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
    """Give where a scenario came from: its file by its bare name, its hash, overrides."""
    return {**known, "file": sanitise_file(str(known.get("file", "")))}


def excitation_fields(scenario: Scenario, motion: Sines | Samples | None) -> Fields:
    """Give the kind of base motion and, where it is a series, its hash."""
    block = scenario.excitation
    fields: Fields = {"kind": block.kind, "seed": getattr(block, "seed", None)}
    if isinstance(motion, Samples):
        fields["sha256"] = signal_sha256(motion.u_dd)
        if motion.realised:
            fields["realised"] = motion.realised
    return fields


def _check_fields(verdict: Verdict) -> Fields:
    """Give a verdict; over many cases also where it was decided, of a mean how sure it is.

    One that was not judged has neither passed nor failed. Where there is no value the reason is
    told.
    """
    fields = {"check": str(verdict.check), "passed": verdict.passed, "value": verdict.value}
    if verdict.reason:
        fields["reason"] = verdict.reason
    if verdict.seeds > 1:
        fields |= {"half_width": verdict.half_width, "seeds": verdict.seeds}
    return fields if verdict.where is None else {**fields, "where": dict(verdict.where)}


def creation_time() -> str:
    """Give the time of day in UTC, or what SOURCE_DATE_EPOCH says it is."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    try:
        time_utc = datetime.fromtimestamp(int(epoch), UTC)
    except (ValueError, OverflowError, OSError):
        time_utc = datetime.fromtimestamp(int(time.time()), UTC)
    return time_utc.strftime("%Y-%m-%dT%H:%M:%SZ")


def software_versions() -> dict[str, str]:
    """Give the versions of Python and of what was loaded; nothing is loaded for its version."""
    versions = {"python": ".".join(map(str, sys.version_info[:3]))}
    for name in SOFTWARE_PACKAGES:
        if name in sys.modules:
            versions[name] = str(getattr(sys.modules[name], "__version__", ""))
    return versions


def json_text(fields: Mapping[str, Any]) -> str:
    """Give a sidecar as JSON, in ASCII so that every terminal and pipe can take it."""
    return json.dumps(fields, indent=2, allow_nan=False) + "\n"


# Values and words as they may leave the machine.


ABSOLUTE_FOLDERS = re.compile(
    r"(?<![\w.)\]/~:-])(?:~\w*|[A-Za-z]:)?[\\/](?:[^\\/\s'\"`:;,=]+[\\/])*(?=\w)"
)
"""The folders of an absolute path within a sentence."""

LEADING_FOLDERS = re.compile(r"(^|=)(?:~\w*|[A-Za-z]:)?[\\/](?:.*[\\/])?(?=.)")
"""The folders of an absolute path that is a word of a command, spaces and all."""


def sanitise(value: Any) -> Any:
    """Give a value as JSON knows it: finite numbers, no absolute path, nothing of numpy."""
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
    """Give the name of a file as it was given, but without the folders of an absolute one."""
    return LEADING_FOLDERS.sub("", file, count=1)


def sanitise_command(command: str) -> str:
    """Give a command line, without the folders of absolute paths."""
    try:
        words = shlex.split(command)
    except ValueError:
        return command
    return shlex.join(LEADING_FOLDERS.sub(r"\1", word) for word in words)
