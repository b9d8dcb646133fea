"""drysim.json: what made these numbers; of a run also spectra.csv.

It holds no absolute path, no user and no host, and nothing but JSON: what every such file says
is `framed`, and values and words leave the machine as `plain` and its like make them.
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
from drysim.core.model import Pressed, Samples, Sines
from drysim.errors import EXIT_INTERRUPTED, EXIT_NUMERICS_FAILED
from drysim.output.tables import joined, texts, write
from drysim.study.case import sha256_of

if TYPE_CHECKING:
    from drysim.bench.score import Panel
    from drysim.metrics.checks import Verdict
    from drysim.metrics.spectra import Spectra
    from drysim.scenario.model import Scenario
    from drysim.study.ensemble import Ensemble
    from drysim.study.outcome import Outcome
    from drysim.study.table import Table


FORMAT = 1
"""Version of the layout of drysim.json."""

SOFTWARE = ("numpy", "scipy", "numba", "pydantic", "yaml", "matplotlib")
"""Packages that take part in the numbers and pictures; named when they were loaded."""

Fields = dict[str, Any]


class Ending(NamedTuple):
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


def of_run(outcome: Outcome, ending: Ending) -> Fields:
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
        numerics["spectra"] = _spectra(outcome.spectra)
    return framed(outcome, outcome.response.motion, numerics, outcome.metrics, ending)


def _spectra(found: Spectra) -> Fields:
    """Give how spectra were made."""
    return {
        "method": "Welch, Hann window, half overlapping, mean of the window removed",
        "series": "means over every step, their fading with frequency taken back",
        "segment": found.segment,
        "segments": found.segments,
        "resolution": 1.0 / found.segment,
    }


def spectra(outcome: Outcome, folder: Path) -> None:
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
        [text if text != "nan" else "" for text in texts(column)] for column in columns.values()
    ]
    write(folder / "spectra.csv", list(columns), [joined(cells)])


def framed(
    made: Outcome | Ensemble | Table | Panel,
    motion: Sines | Samples | None,
    numerics: Mapping[str, Any],
    metrics: Mapping[str, Any],
    ending: Ending,
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
    scenario, law = made.scenario, made.scenario.law()
    pressure = law.pressure if isinstance(law, Pressed) else None
    inputs = (*getattr(motion, "inputs", ()), *(pressure.inputs if pressure else ()))
    fields = {
        **head(ending, getattr(made, "complete", True)),
        "scenario": {"name": scenario.name, **origin(scenario.origin)},
        "inputs": [
            {"file": bare_name(file), "sha256": sha256, "size": size}
            for file, sha256, size in inputs
        ],
        "excitation": excitation(scenario, motion),
        "numerics": numerics,
        "software": software(),
        "metrics": metrics,
        **further,
        "checks": [_check(verdict) for verdict in made.checks],
        "warnings": [asdict(caution) for caution in made.warnings],
        "files": ending.files,
    }
    return {key: plain(value) for key, value in fields.items()}


def head(ending: Ending, complete: bool = True) -> Fields:
    """Give what every drysim.json begins with."""
    exit_code = ending.exit_code
    return {
        "format": FORMAT,
        "version": drysim.__version__,
        "command": bare_command(ending.command),
        "created": created(),
        "complete": complete and exit_code not in (EXIT_NUMERICS_FAILED, EXIT_INTERRUPTED),
        "exit_code": exit_code,
    }


def origin(known: Mapping[str, Any]) -> Fields:
    """Give where a scenario came from: its file by its bare name, its hash, overrides."""
    return {**known, "file": bare_name(str(known.get("file", "")))}


def excitation(scenario: Scenario, motion: Sines | Samples | None) -> Fields:
    """Give the kind of base motion and, where it is a series, its hash."""
    asked = scenario.excitation
    fields: Fields = {"kind": asked.kind, "seed": getattr(asked, "seed", None)}
    if isinstance(motion, Samples):
        fields["sha256"] = sha256_of(motion.u_dd)
        if motion.realised:
            fields["realised"] = motion.realised
    return fields


def _check(verdict: Verdict) -> Fields:
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


def created() -> str:
    """Give the time of day in UTC, or what SOURCE_DATE_EPOCH says it is."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    try:
        moment = datetime.fromtimestamp(int(epoch), UTC)
    except (ValueError, OverflowError, OSError):
        moment = datetime.fromtimestamp(int(time.time()), UTC)
    return moment.strftime("%Y-%m-%dT%H:%M:%SZ")


def software() -> dict[str, str]:
    """Give the versions of Python and of what was loaded; nothing is loaded for its version."""
    versions = {"python": ".".join(map(str, sys.version_info[:3]))}
    for name in SOFTWARE:
        if name in sys.modules:
            versions[name] = str(getattr(sys.modules[name], "__version__", ""))
    return versions


def json_text(fields: Mapping[str, Any]) -> str:
    """Give a sidecar as JSON, in ASCII so that every terminal and pipe can take it."""
    return json.dumps(fields, indent=2, allow_nan=False) + "\n"


# Values and words as they may leave the machine.


ABSOLUTE = re.compile(
    r"(?<![\w.)\]/~:-])(?:~\w*|[A-Za-z]:)?[\\/](?:[^\\/\s'\"`:;,=]+[\\/])*(?=\w)"
)
"""The folders of an absolute path within a sentence."""

LEADING = re.compile(r"(^|=)(?:~\w*|[A-Za-z]:)?[\\/](?:.*[\\/])?(?=.)")
"""The folders of an absolute path that is a word of a command, spaces and all."""


def plain(value: Any) -> Any:
    """Give a value as JSON knows it: finite numbers, no absolute path, nothing of numpy."""
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, str):
        return ABSOLUTE.sub("", value).encode(errors="replace").decode()
    return str(value) if isinstance(value, PurePath) else value


def bare_name(file: str) -> str:
    """Give the name of a file as it was given, but without the folders of an absolute one."""
    return LEADING.sub("", file, count=1)


def bare_command(command: str) -> str:
    """Give a command line, without the folders of absolute paths."""
    try:
        words = shlex.split(command)
    except ValueError:
        return command
    return shlex.join(LEADING.sub(r"\1", word) for word in words)
