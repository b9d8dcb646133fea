"""Files: what finished work leaves on the disk. Computes nothing and shows nothing.

`write` and its like choose the writers of what was made, `tables`, `many`, `speed_error` and
`drysim.plots` among them. `folder.put` lets them write into `<name>.partial`, adds drysim.json
last (`sidecar`), and puts the folder in its place; whether it may is for `check` and
`claim_partial` to say, before any work.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drysim.errors import EXIT_INTERRUPTED
from drysim.output import sidecar, tables
from drysim.output.folder import SCENARIO, Claim, put
from drysim.output.folder import check as check
from drysim.output.folder import claim_partial as claim_partial
from drysim.output.folder import resumable as resumable
from drysim.output.sidecar import json_text as json_text
from drysim.output.sidecar import of_run
from drysim.yaml_document import dump

if TYPE_CHECKING:
    from drysim.bench.hard_cases import Ordeals
    from drysim.bench.score import Bench
    from drysim.scenario.model import Scenario
    from drysim.study.compare import Comparison
    from drysim.study.ensemble import Ensemble
    from drysim.study.outcome import Outcome
    from drysim.study.table import Table


def own(made: Outcome | Ensemble | Table, folder: Path) -> None:
    """Write scenario.yaml: resolved, defaults spelled out, it runs again as it is."""
    _write(made.scenario, folder, SCENARIO)


def compared(made: Comparison, folder: Path) -> None:
    """Write scenario.yaml: what all approaches share."""
    _write(made.table.scenario, folder, SCENARIO)


def benched(made: Bench, folder: Path) -> None:
    """Write scenario.yaml; of several scenes each under its own name."""
    alone = len(made.panels) == 1
    for panel in made.panels:
        _write(panel.scenario, folder, SCENARIO if alone else f"{panel.scenario.name}.yaml")


def _write(scenario: Scenario, folder: Path, name: str) -> None:
    """Write a scenario as plain words."""
    words = dump(scenario.resolved(relative_to=folder))
    (folder / name).write_text(words, encoding="utf-8", newline="\n")


WRITERS = (
    own,
    tables.response,
    tables.events,
    tables.stroke_violations,
    sidecar.spectra,
)
"""Each takes an outcome and a folder, and writes its file when there is anything to write."""

PAINTERS = ("response", "spectra")
"""The same in `drysim.plots`, for files that `--no-plots` leaves out."""


def write(
    outcome: Outcome, folder: Path, *, plots: bool, command: str, exit_code: int
) -> dict[str, Any]:
    """Write the output folder of a run, completely or not at all.

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
    writers = WRITERS + _painters(PAINTERS * plots)
    return put(outcome, folder, writers, of_run, command, exit_code)


def write_ensemble(
    ensemble: Ensemble, folder: Path | Claim, *, plots: bool, command: str, exit_code: int
) -> dict[str, Any]:
    """Write the output folder of many seeds; parameters and errors are as in `write_table`."""
    from drysim.output import many

    writers = (
        own,
        many.ensemble,
        _of_shown(tables.response),
        _of_shown(tables.events),
        many.stroke_violations,
        _of_shown(sidecar.spectra),
    )
    if plots and exit_code != EXIT_INTERRUPTED:
        writers += (*_painters(("ensemble",)), *map(_of_shown, _painters(PAINTERS)))
    return put(ensemble, folder, writers, many.of_ensemble, command, exit_code)


def write_table(
    table: Table,
    folder: Path | Claim,
    *,
    plots: bool,
    command: str,
    exit_code: int,
    form: str = "csv",
) -> dict[str, Any]:
    """Write the output folder of a sweep; parameters and errors are those of `write`.

    Parameters
    ----------
    folder : Path or Claim
        A claim is finished: its `<name>.partial` takes the place of the output folder. With
        exit code 130 it stays where it is and keeps its finished cases, for `--resume`.
    form : str
        How the cases are written: `csv` or `parquet`.
    """
    from drysim.output import many

    cases = tables.transmissibility if form == "csv" else tables.transmissibility_parquet
    drawn = ("transmissibility", "stroke") * (plots and exit_code != EXIT_INTERRUPTED)
    writers = (own, cases, tables.stroke_violations_of_cases, *_painters(drawn))
    return put(table, folder, writers, many.of_table, command, exit_code)


def write_comparison(
    comparison: Comparison, folder: Path | Claim, *, plots: bool, command: str, exit_code: int
) -> dict[str, Any]:
    """Write the output folder of a comparison; parameters and errors are those of `write`."""
    from drysim.output import many

    writers = (compared, tables.comparison, *_painters(("comparison",) * plots))
    return put(comparison, folder, writers, many.of_comparison, command, exit_code)


def write_bench(
    bench: Bench, folder: Path, *, plots: bool, command: str, exit_code: int
) -> dict[str, Any]:
    """Write the output folder of a bench; parameters and errors are those of `write`."""
    from drysim.output import many

    writers = (benched, many.speed_error, *_painters(("speed_error",) * plots))
    return put(bench, folder, writers, many.of_bench, command, exit_code)


def write_hard(hard: Ordeals, folder: Path, *, command: str, exit_code: int) -> dict[str, Any]:
    """Write the output folder of the hard cases; parameters and errors are those of `write`."""
    from drysim.output import many

    writers = (many.hard_cases,)
    return put(hard, folder, writers, many.of_ordeals, command, exit_code)


def _of_shown(write: Callable[[Outcome, Path], None]) -> Callable[[Ensemble, Path], None]:
    """Give a writer that writes the file of the seed that an ensemble shows."""
    return lambda made, folder: write(made.shown, folder)


def _painters(names: tuple[str, ...]) -> tuple[Callable[[Any, Path], None], ...]:
    """Give the functions that draw; they are loaded for pictures alone."""
    if not names:
        return ()
    from drysim.plots.comparison import comparison
    from drysim.plots.ensemble import ensemble
    from drysim.plots.response import response
    from drysim.plots.spectra import spectra
    from drysim.plots.speed_error import speed_error
    from drysim.plots.sweep import stroke, transmissibility

    known: dict[str, Callable[[Any, Path], None]] = {
        "response": response,
        "spectra": spectra,
        "transmissibility": transmissibility,
        "stroke": stroke,
        "comparison": comparison,
        "ensemble": ensemble,
        "speed_error": speed_error,
    }
    return tuple(known[name] for name in names)
