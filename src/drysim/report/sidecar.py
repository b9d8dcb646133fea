"""drysim.json: what made these numbers. Holds no absolute path, no user and no host."""

from __future__ import annotations

import hashlib
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
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

import drysim
from drysim.core.motion import Samples
from drysim.errors import EXIT_INTERRUPTED, EXIT_NUMERICS_FAILED

if TYPE_CHECKING:
    from drysim.study.outcome import Outcome

FORMAT = 1
"""Version of the layout of drysim.json."""

SOFTWARE = ("numpy", "scipy", "numba", "pydantic", "yaml", "matplotlib")
"""Packages that take part in the numbers and pictures; named when they were loaded."""

ABSOLUTE = re.compile(
    r"(?<![\w.)\]/~:-])(?:~\w*|[A-Za-z]:)?[\\/](?:[^\\/\s'\"`:;,=]+[\\/])*(?=\w)"
)
"""The folders of an absolute path within a sentence."""

LEADING = re.compile(r"(^|=)(?:~\w*|[A-Za-z]:)?[\\/](?:.*[\\/])?(?=.)")
"""The folders of an absolute path that is a word of a command, spaces and all."""


def sidecar(
    outcome: Outcome, command: str, exit_code: int, files: Mapping[str, str]
) -> dict[str, Any]:
    """Give everything that made the numbers of an outcome, ready for JSON.

    Parameters
    ----------
    outcome : Outcome
    command : str
        The command line, quoted as for a shell.
    exit_code : int
        With which the command ends.
    files : mapping
        SHA-256 (hex) by name of the file in the output folder.

    Returns
    -------
    dict
        As the contract has it; values that are not finite are None.
    """
    scenario = outcome.scenario
    fields = {
        "format": FORMAT,
        "version": drysim.__version__,
        "command": _command(command),
        "created": created(),
        "complete": exit_code not in (EXIT_NUMERICS_FAILED, EXIT_INTERRUPTED),
        "exit_code": exit_code,
        "scenario": {"name": scenario.name, **_origin(scenario.origin)},
        "inputs": [
            {"file": _bare_name(file), "sha256": sha256, "size": size}
            for file, sha256, size in getattr(outcome.response.motion, "inputs", ())
        ],
        "excitation": _excitation(outcome),
        "numerics": _numerics(outcome),
        "software": software(),
        "metrics": outcome.metrics,
        "checks": [
            {"check": str(verdict.check), "passed": verdict.passed, "value": verdict.value}
            for verdict in outcome.checks
        ],
        "warnings": [asdict(caution) for caution in outcome.warnings],
        "files": files,
    }
    return {key: _plain(value) for key, value in fields.items()}


def text(fields: Mapping[str, Any]) -> str:
    """Give a sidecar as JSON, in ASCII so that every terminal and pipe can take it."""
    return json.dumps(fields, indent=2, allow_nan=False) + "\n"


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


def _excitation(outcome: Outcome) -> dict[str, Any]:
    """Give the kind of base motion and, where it is a series, its hash."""
    excitation, motion = outcome.scenario.excitation, outcome.response.motion
    fields: dict[str, Any] = {
        "kind": excitation.kind,
        "seed": getattr(excitation, "seed", None),
    }
    if isinstance(motion, Samples):
        series = np.ascontiguousarray(motion.u_dd, dtype="<f8")
        fields["sha256"] = hashlib.sha256(series.data).hexdigest()
        if motion.realised:
            fields["realised"] = motion.realised
    return fields


def _numerics(outcome: Outcome) -> dict[str, Any]:
    """Give how the numbers were made, and how well they close."""
    return {
        **asdict(outcome.response.numerics),
        "step": outcome.response.dt,
        "cases": 1,
        "energy_residual": outcome.metrics["energy_residual"],
    }


def _origin(origin: Mapping[str, Any]) -> dict[str, Any]:
    return {**origin, "file": _bare_name(str(origin.get("file", "")))}


def _bare_name(file: str) -> str:
    """Give the name of a file as it was given, but without the folders of an absolute one."""
    return LEADING.sub("", file, count=1)


def _command(command: str) -> str:
    try:
        words = shlex.split(command)
    except ValueError:
        return command
    return shlex.join(LEADING.sub(r"\1", word) for word in words)


def _plain(value: Any) -> Any:
    """Give a value as JSON knows it: finite numbers, no absolute path, nothing of numpy."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, str):
        return ABSOLUTE.sub("", value).encode(errors="replace").decode()
    return str(value) if isinstance(value, PurePath) else value
