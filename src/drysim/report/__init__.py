"""Files: what finished work leaves on the disk. Computes nothing and shows nothing.

`write` and its like choose the writers of what was made. `folder.put` lets them write into
`<name>.partial`, adds drysim.json last (`sidecar`), and puts the folder in its place (`swap`);
whether it may is for `claim` to say, before any work.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drysim.errors import EXIT_INTERRUPTED
from drysim.report import scenarios, spectrum, tables
from drysim.report.claim import check as check
from drysim.report.folder import Claim as Claim
from drysim.report.folder import claim_partial as claim_partial
from drysim.report.folder import put
from drysim.report.folder import resumable as resumable
from drysim.report.sidecar import sidecar as sidecar
from drysim.report.sidecar import text as text

if TYPE_CHECKING:
    from drysim.study.bench.hard import Ordeals
    from drysim.study.bench.scores import Bench
    from drysim.study.comparisons.comparison import Comparison
    from drysim.study.ensembles.ensemble import Ensemble
    from drysim.study.outcome import Outcome
    from drysim.study.sweeps.table import Table


WRITERS = (
    scenarios.own,
    tables.response,
    tables.events,
    tables.stroke_violations,
    spectrum.spectra,
)
"""Each takes an outcome and a folder, and writes its file when there is anything to write."""

PAINTERS = ("response", "spectra")
"""The same in `drysim.report.plots`, for files that `--no-plots` leaves out."""

TABLE_PAINTERS = ("transmissibility", "stroke")
COMPARISON_PAINTERS = ("comparison",)
BENCH_PAINTERS = ("speed_error",)


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
    return put(outcome, folder, writers, sidecar, command, exit_code)


def write_ensemble(
    ensemble: Ensemble, folder: Path | Claim, *, plots: bool, command: str, exit_code: int
) -> dict[str, Any]:
    """Write the output folder of many seeds; parameters and errors are as in `write_table`."""
    from drysim.report import ensembles

    writers = (
        scenarios.own,
        ensembles.ensemble,
        _of_shown(tables.response),
        _of_shown(tables.events),
        ensembles.stroke_violations,
        _of_shown(spectrum.spectra),
    )
    if plots and exit_code != EXIT_INTERRUPTED:
        writers += (*_painters(("ensemble",)), *map(_of_shown, _painters(PAINTERS)))
    return put(ensemble, folder, writers, ensembles.told, command, exit_code)


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
    from drysim.report import digest, parquet, rows

    cases = rows.transmissibility if form == "csv" else parquet.transmissibility
    drawn = TABLE_PAINTERS * (plots and exit_code != EXIT_INTERRUPTED)
    files = (scenarios.own, cases, rows.stroke_violations)
    writers = files + _painters(drawn)
    return put(table, folder, writers, digest.of_table, command, exit_code)


def write_comparison(
    comparison: Comparison, folder: Path | Claim, *, plots: bool, command: str, exit_code: int
) -> dict[str, Any]:
    """Write the output folder of a comparison; parameters and errors are those of `write`."""
    from drysim.report import digest, rows

    writers = (scenarios.compared, rows.comparison, *_painters(COMPARISON_PAINTERS * plots))
    return put(comparison, folder, writers, digest.of_comparison, command, exit_code)


def write_bench(
    bench: Bench, folder: Path, *, plots: bool, command: str, exit_code: int
) -> dict[str, Any]:
    """Write the output folder of a bench; parameters and errors are those of `write`."""
    from drysim.report import scored

    writers = (scenarios.benched, scored.speed_error, *_painters(BENCH_PAINTERS * plots))
    return put(bench, folder, writers, scored.of_bench, command, exit_code)


def write_hard(hard: Ordeals, folder: Path, *, command: str, exit_code: int) -> dict[str, Any]:
    """Write the output folder of the hard cases; parameters and errors are those of `write`."""
    from drysim.report import ordeals

    writers = (ordeals.hard_cases,)
    return put(hard, folder, writers, ordeals.of_ordeals, command, exit_code)


def _of_shown(write: Callable[[Outcome, Path], None]) -> Callable[[Ensemble, Path], None]:
    """Give a writer that writes the file of the seed that an ensemble shows."""
    return lambda made, folder: write(made.shown, folder)


def _painters(names: tuple[str, ...]) -> tuple[Callable[[Any, Path], None], ...]:
    """Give the functions that draw; they are loaded for pictures alone."""
    if not names:
        return ()
    from drysim.report import plots

    return tuple(getattr(plots, name) for name in names)
