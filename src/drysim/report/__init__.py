"""Files: what a finished outcome leaves on the disk. Computes nothing and shows nothing."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drysim.report import plots as pictures
from drysim.report import tables
from drysim.report.claim import MARKER
from drysim.report.claim import check as check
from drysim.report.folder import fresh, mark
from drysim.report.sidecar import sidecar as sidecar
from drysim.report.sidecar import text as text
from drysim.source import dump

if TYPE_CHECKING:
    from drysim.study.outcome import Outcome


def resolved_scenario(outcome: Outcome, folder: Path) -> None:
    """Write scenario.yaml: overrides and defaults spelled out; it runs again as it is."""
    words = dump(outcome.scenario.resolved(relative_to=folder))
    (folder / "scenario.yaml").write_text(words, encoding="utf-8", newline="\n")


WRITERS = (resolved_scenario, tables.response, tables.events, tables.stroke_violations)
"""Each takes an outcome and a folder, and writes its file when there is anything to write."""

PAINTERS = (pictures.response,)
"""The same, for files that `--no-plots` leaves out."""


def write(
    outcome: Outcome, folder: Path, *, plots: bool, command: str, exit_code: int
) -> dict[str, Any]:
    """Write the output folder, completely or not at all.

    Parameters
    ----------
    outcome : Outcome
    folder : Path
        Takes the place of what drysim wrote there before.
    plots : bool
        Whether pictures are wanted.
    command : str
        The command line, quoted as for a shell.
    exit_code : int
        With which the command ends.

    Returns
    -------
    dict
        What drysim.json says.

    Raises
    ------
    OutputError
        The folder is not ours to replace, or cannot be written.
    """
    with fresh(folder) as partial:
        for writer in WRITERS + PAINTERS * plots:
            writer(outcome, partial)
        written = sorted(path for path in partial.iterdir() if path.name != MARKER)
        told = sidecar(
            outcome, command, exit_code, {path.name: _sha256(path) for path in written}
        )
        mark(partial, text(told))
    return told


def _sha256(file: Path) -> str:
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
