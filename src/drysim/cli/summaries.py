"""The command that reads a result again: summarise."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from drysim.cli import options
from drysim.cli.streams import reader_may_leave
from drysim.errors import EXIT_OK, OutputError

Folder = Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder that drysim wrote.")]

TOLD = ("metrics", "ensemble", "checks", "numerics")
"""What of drysim.json is told again; only many seeds are an ensemble."""


def summarise(folder: Folder, as_json: options.Json = False) -> int:
    """Extremes, quantiles and checks of a result on the disk."""
    from drysim import console

    told = read(folder)
    with reader_may_leave():
        if as_json:
            words = {name: told[name] for name in TOLD if name in told}
            typer.echo(json.dumps(words, indent=2))
        else:
            console.show_retold(told)
    return EXIT_OK


def read(folder: Path) -> dict[str, Any]:
    """Give the drysim.json of a result.

    Raises
    ------
    OutputError
        When the folder holds none.
    """
    from drysim.report.claim import MARKER

    file = folder / MARKER
    try:
        told = json.loads(file.read_text(encoding="utf-8"))
    except OSError as fault:
        raise OutputError(
            f"cannot read {file}: {(fault.strerror or str(fault)).lower()}",
            "name the folder that a run, a sweep or a comparison has written",
        ) from fault
    except ValueError:
        told = None
    needed = {"scenario", "metrics", "checks", "numerics", "command", "complete"}
    if not isinstance(told, dict) or not needed <= told.keys():
        raise OutputError(
            f"{file} holds no finished result",
            "name the folder that a run, a sweep or a comparison has written",
        )
    return told
