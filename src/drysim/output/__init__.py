"""Output folders: the files of finished work. Computes nothing and shows nothing.

`write_run` and its siblings choose the writers for a result (from `tables` and
`drysim.plots`). `folder.write_folder` runs them in `<name>.partial`, adds drysim.json last,
and replaces the old folder by the new one. `check_writable` and `lock_partial` verify before
any work that this is allowed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NotRequired, TypedDict, Unpack

from drysim.errors import EXIT_INTERRUPTED
from drysim.output import sidecar, tables
from drysim.output.folder import (
    BEST_FILE,
    FITTED_FILE,
    PICTURES,
    PNG,
    SCENARIO_FILE,
    LockedFolder,
    write_folder,
)
from drysim.output.folder import STORES as STORES
from drysim.output.folder import check_writable as check_writable
from drysim.output.folder import lock_partial as lock_partial
from drysim.output.folder import resumable_parts as resumable_parts
from drysim.output.sidecar import json_text as json_text
from drysim.yaml_document import dump

if TYPE_CHECKING:
    from drysim.bench.hard_cases import HardCases
    from drysim.bench.score import Bench
    from drysim.output.sidecar import Provenance
    from drysim.scenario.model import Scenario
    from drysim.study.branches import BranchesResult
    from drysim.study.compare import Comparison
    from drysim.study.design import DesignResult
    from drysim.study.ensemble import Ensemble
    from drysim.study.fit import FitResult
    from drysim.study.outcome import Outcome
    from drysim.study.regimes import RegimeMap
    from drysim.study.table import Table


def write_scenario_yaml(
    result: Outcome | Ensemble | Table | BranchesResult | RegimeMap, folder: Path
) -> None:
    """Write scenario.yaml: all defaults explicit, can be run again as it is."""
    _write_yaml(result.scenario, folder, SCENARIO_FILE)


def write_shared_yaml(result: Comparison, folder: Path) -> None:
    """Write scenario.yaml of a comparison: what all approaches share."""
    _write_yaml(result.table.scenario, folder, SCENARIO_FILE)


def write_bench_yaml(result: Bench, folder: Path) -> None:
    """Write scenario.yaml; several scenarios each under their own name."""
    alone = len(result.cases) == 1
    for panel in result.cases:
        _write_yaml(
            panel.scenario, folder, SCENARIO_FILE if alone else f"{panel.scenario.name}.yaml"
        )


def write_fit_yaml(result: FitResult, folder: Path) -> None:
    """Write scenario.yaml with the fit block, and fitted.yaml with the values instead."""
    _write_yaml(result.source, folder, SCENARIO_FILE)
    _write_yaml(result.scenario, folder, FITTED_FILE)


def write_design_yaml(result: DesignResult, folder: Path) -> None:
    """Write scenario.yaml with the design block, and best.yaml with the best design."""
    _write_yaml(result.source, folder, SCENARIO_FILE)
    if result.best is not None:
        _write_yaml(result.scenario, folder, BEST_FILE)


def _write_yaml(scenario: Scenario, folder: Path, name: str) -> None:
    """Write a scenario as YAML."""
    words = dump(scenario.resolved(relative_to=folder))
    (folder / name).write_text(words, encoding="utf-8", newline="\n")


RUN_WRITERS = (
    write_scenario_yaml,
    tables.write_response_csv,
    tables.write_events_csv,
    tables.write_violations_csv,
    tables.write_spectra_csv,
    tables.write_bands_csv,
)
"""Each takes an outcome and a folder, and writes its file if there is anything to write."""


class WriteOptions(TypedDict):
    """Options of the writers of a result with pictures and a report."""

    plots: bool
    """Whether to draw pictures."""
    command: str
    """The command line, quoted for a shell."""
    exit_code: int
    """Exit code of the command; an interrupted one draws no pictures."""
    picture_format: NotRequired[str]
    """`png` (default), `svg` or `pdf`."""
    report: NotRequired[bool]
    """Whether to write report.html, with pictures if `plots` is true; default false."""


def write_run(
    outcome: Outcome,
    folder: Path,
    **options: Unpack[WriteOptions],
) -> dict[str, Any]:
    """Write the output folder of a run, completely or not at all.

    Parameters
    ----------
    outcome : Outcome
    folder : Path
        Replaces what drysim wrote there before.
    **options
        See `WriteOptions`.

    Returns
    -------
    dict
        The content of drysim.json.

    Raises
    ------
    OutputError
        The folder was not written by drysim, or cannot be written.
    """
    return _write("run", outcome, folder, RUN_WRITERS, sidecar.run_fields, **options)


def write_ensemble(
    ensemble: Ensemble,
    folder: Path | LockedFolder,
    *,
    plots: bool,
    command: str,
    exit_code: int,
    picture_format: str = PNG,
    report: bool = False,
) -> dict[str, Any]:
    """Write the output folder of an ensemble; parameters and errors as in `write_table`."""
    writers: tuple[Callable[[Any, Path], None], ...] = (
        write_scenario_yaml,
        tables.write_ensemble_csv,
        _for_shown_seed(tables.write_response_csv),
        _for_shown_seed(tables.write_events_csv),
        tables.write_seed_violations_csv,
        _for_shown_seed(tables.write_spectra_csv),
        _for_shown_seed(tables.write_bands_csv),
    )
    drawn = plots and exit_code != EXIT_INTERRUPTED
    writers += _plot_writers("ensemble", drawn, picture_format)
    writers += tuple(map(_for_shown_seed, _plot_writers("run", drawn, picture_format)))
    return write_folder(
        ensemble,
        folder,
        writers,
        sidecar.ensemble_fields,
        command,
        exit_code,
        _report_writer(report, plots),
    )


def write_table(
    table: Table,
    folder: Path | LockedFolder,
    *,
    form: str = "csv",
    **options: Unpack[WriteOptions],
) -> dict[str, Any]:
    """Write the output folder of a sweep; further parameters and errors as in `write_run`.

    Parameters
    ----------
    folder : Path or LockedFolder
        A locked folder is completed: its `<name>.partial` replaces the output folder. With exit
        code 130 it stays and keeps its finished cases, for `--resume`.
    form : str
        Format of the cases: `csv` or `parquet`.
    """
    cases = (
        tables.write_transmissibility_csv
        if form == "csv"
        else tables.write_transmissibility_parquet
    )
    writers = (
        write_scenario_yaml,
        cases,
        tables.write_case_violations_csv,
    )
    return _write("sweep", table, folder, writers, sidecar.table_fields, **options)


def write_comparison(
    comparison: Comparison,
    folder: Path | LockedFolder,
    **options: Unpack[WriteOptions],
) -> dict[str, Any]:
    """Write the output folder of a comparison; parameters and errors as in `write_run`."""
    writers = (
        write_shared_yaml,
        tables.write_comparison_csv,
    )
    return _write(
        "comparison", comparison, folder, writers, sidecar.comparison_fields, **options
    )


def write_bench(
    bench: Bench,
    folder: Path,
    *,
    plots: bool,
    command: str,
    exit_code: int,
    picture_format: str = PNG,
) -> dict[str, Any]:
    """Write the output folder of a bench; parameters and errors as in `write_run`."""
    writers = (
        write_bench_yaml,
        tables.write_speed_error_csv,
        *_plot_writers("bench", plots, picture_format),
    )
    return write_folder(bench, folder, writers, sidecar.bench_fields, command, exit_code)


def write_hard_cases(
    result: HardCases, folder: Path, *, command: str, exit_code: int
) -> dict[str, Any]:
    """Write the output folder of the hard cases; parameters and errors as in `write_run`."""
    writers = (tables.write_hard_cases_csv,)
    return write_folder(result, folder, writers, sidecar.hard_case_fields, command, exit_code)


def write_fit(
    result: FitResult,
    folder: Path,
    **options: Unpack[WriteOptions],
) -> dict[str, Any]:
    """Write the output folder of a fit; parameters and errors as in `write_run`."""
    writers = (
        write_fit_yaml,
        tables.write_fit_csv,
        tables.write_residuals_csv,
    )
    return _write("fit", result, folder, writers, sidecar.fit_fields, **options)


def write_design(
    result: DesignResult,
    folder: Path | LockedFolder,
    **options: Unpack[WriteOptions],
) -> dict[str, Any]:
    """Write the output folder of a design study; parameters and errors as in `write_table`."""
    writers = (
        write_design_yaml,
        tables.write_design_csv,
    )
    return _write("design", result, folder, writers, sidecar.design_fields, **options)


def write_branches(
    result: BranchesResult,
    folder: Path,
    **options: Unpack[WriteOptions],
) -> dict[str, Any]:
    """Write the output folder of branches; parameters and errors as in `write_run`."""
    writers = (
        write_scenario_yaml,
        tables.write_branches_csv,
        tables.write_bifurcations_csv,
    )
    return _write("branches", result, folder, writers, sidecar.branches_fields, **options)


def write_map(
    result: RegimeMap,
    folder: Path,
    **options: Unpack[WriteOptions],
) -> dict[str, Any]:
    """Write the output folder of a regime map; parameters and errors as in `write_run`."""
    writers = (
        write_scenario_yaml,
        tables.write_map_csv,
    )
    return _write("map", result, folder, writers, sidecar.map_fields, **options)


def _write(
    kind: str,
    result: Any,
    folder: Path | LockedFolder,
    files: Sequence[Callable[[Any, Path], None]],
    to_fields: Callable[[Any, Provenance], dict[str, Any]],
    *,
    plots: bool,
    command: str,
    exit_code: int,
    picture_format: str = PNG,
    report: bool = False,
) -> dict[str, Any]:
    """Write the output folder of a result: its files, pictures, report and drysim.json."""
    drawn = plots and exit_code != EXIT_INTERRUPTED
    writers = (*files, *_plot_writers(kind, drawn, picture_format))
    page = _report_writer(report, plots)
    return write_folder(result, folder, writers, to_fields, command, exit_code, page)


def _report_writer(
    wanted: bool, plots: bool
) -> Callable[[Any, dict[str, Any], Path], str] | None:
    """Return what makes the report of a result, None without; its template is read late."""
    if not wanted:
        return None
    from drysim.output.report import page_of

    return partial(page_of, plots)


def _for_shown_seed(write: Callable[[Outcome, Path], None]) -> Callable[[Ensemble, Path], None]:
    """Adapt a writer of an outcome to an ensemble, of which it writes the shown seed."""
    return lambda result, folder: write(result.shown, folder)


def _plot_writers(
    kind: str, drawn: bool, picture_format: str
) -> tuple[Callable[[Any, Path], None], ...]:
    """Return a writer for each picture of a kind of result; what draws it is imported late."""
    pictures = PICTURES[kind].items() if drawn else ()
    return tuple(
        partial(_write_picture, f"{name}.{picture_format}", draw) for name, draw in pictures
    )


def _write_picture(name: str, function: str, result: Any, folder: Path) -> None:
    """Draw a picture of a result and write it."""
    from drysim.plots.style import save_picture

    module, draw = function.split(".")
    drawn = getattr(import_module(f"drysim.plots.{module}"), draw)
    save_picture(lambda: drawn(result), folder / name)
