"""Output folders: the files of finished work. Computes nothing and shows nothing.

`write` chooses the files of a result by its kind (`KINDS`; from `tables` and `drysim.plots`).
`folder.write_folder` writes them in `<name>.partial`, adds drysim.json last, and replaces the
old folder by the new one. `check_writable` and `lock_partial` verify before any work that this
is allowed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

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
    from drysim.output.sidecar import Provenance
    from drysim.scenario.model import Scenario

Writer = Callable[[Any, Path], None]
"""Writes a file of a result into a folder, if there is anything to write."""

Scenarios = Callable[[Any], Iterable[tuple["Scenario | None", str]]]
"""Returns the scenarios that are written with a result, and the names of their files."""


class Kind(NamedTuple):
    """What is written of one kind of result, besides its pictures and its report."""

    files: tuple[Writer, ...]
    to_fields: Callable[[Any, Provenance], dict[str, Any]]
    """Returns the content of drysim.json."""
    scenarios: Scenarios = lambda result: [(result.scenario, SCENARIO_FILE)]


def bench_scenarios(result: Any) -> list[tuple[Scenario, str]]:
    """Return the scenarios of a bench; several each under their own name."""
    found = [panel.scenario for panel in result.cases]
    if len(found) == 1:
        return [(found[0], SCENARIO_FILE)]
    return [(one, f"{one.name}.yaml") for one in found]


def for_shown_seed(write: Writer) -> Writer:
    """Adapt a writer of an outcome to an ensemble, of which it writes the shown seed."""
    return lambda result, folder: write(result.shown, folder)


RUN_FILES = (
    tables.write_response_csv,
    tables.write_events_csv,
    tables.write_spectra_csv,
    tables.write_bands_csv,
)

KINDS = {
    "run": Kind((*RUN_FILES, tables.write_violations_csv), sidecar.run_fields),
    "ensemble": Kind(
        (
            tables.write_ensemble_csv,
            tables.write_seed_violations_csv,
            *map(for_shown_seed, RUN_FILES),
        ),
        sidecar.ensemble_fields,
    ),
    "sweep": Kind((tables.write_case_violations_csv,), sidecar.table_fields),
    "comparison": Kind(
        (tables.write_comparison_csv,),
        sidecar.comparison_fields,
        lambda result: [(result.table.scenario, SCENARIO_FILE)],
    ),
    "bench": Kind((tables.write_speed_error_csv,), sidecar.bench_fields, bench_scenarios),
    "hard": Kind((tables.write_hard_cases_csv,), sidecar.hard_case_fields, lambda result: []),
    "fit": Kind(
        (tables.write_fit_csv, tables.write_residuals_csv),
        sidecar.fit_fields,
        lambda result: [(result.source, SCENARIO_FILE), (result.scenario, FITTED_FILE)],
    ),
    "design": Kind(
        (tables.write_design_csv,),
        sidecar.design_fields,
        lambda result: [
            (result.source, SCENARIO_FILE),
            (result.scenario if result.best else None, BEST_FILE),
        ],
    ),
    "branches": Kind(
        (tables.write_branches_csv, tables.write_bifurcations_csv), sidecar.branches_fields
    ),
    "map": Kind((tables.write_map_csv,), sidecar.map_fields),
}
"""Kinds of results. The cases of a sweep are a further file, in one of two formats."""


def write(
    kind: str,
    result: Any,
    folder: Path | LockedFolder,
    *,
    plots: bool,
    command: str,
    exit_code: int,
    picture_format: str = PNG,
    report: bool = False,
    form: str = "csv",
) -> dict[str, Any]:
    """Write the output folder of a result, completely or not at all.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    result
    folder : Path or LockedFolder
        Replaces what drysim wrote there before. A locked folder is completed: its
        `<name>.partial` replaces the output folder. With exit code 130 it stays and keeps its
        finished cases, for `--resume`.
    plots : bool
        Whether to draw pictures.
    command : str
        The command line, quoted for a shell.
    exit_code : int
        Exit code of the command; an interrupted one draws no pictures.
    picture_format : str
        `png`, `svg` or `pdf`.
    report : bool
        Whether to write report.html, with pictures if `plots` is true.
    form : str
        Format of the cases of a sweep: `csv` or `parquet`.

    Returns
    -------
    dict
        The content of drysim.json.

    Raises
    ------
    OutputError
        The folder was not written by drysim, or cannot be written.
    """
    files, to_fields, scenarios = KINDS[kind]
    writers: list[Writer] = [partial(write_scenarios, scenarios), *files]
    if kind == "sweep":
        is_csv = form == "csv"
        cases = tables.write_transmissibility_csv
        writers.append(cases if is_csv else tables.write_transmissibility_parquet)
    if plots and exit_code != EXIT_INTERRUPTED:
        writers.append(partial(write_pictures, kind, picture_format))
    to_page = None
    if report:
        from drysim.output.report import page_of

        to_page = partial(page_of, plots)
    return write_folder(result, folder, writers, to_fields, command, exit_code, to_page)


def write_scenarios(scenarios: Scenarios, result: Any, folder: Path) -> None:
    """Write the scenarios of a result: all defaults explicit, can be run again as they are."""
    for scenario, name in scenarios(result):
        if scenario is not None:
            words = dump(scenario.resolved(relative_to=folder))
            (folder / name).write_text(words, encoding="utf-8", newline="\n")


def scenario_of(kind: str, result: Any) -> Scenario:
    """Return the scenario of a result, as its scenario.yaml has it."""
    scenario, _ = next(iter(KINDS[kind].scenarios(result)))
    assert scenario is not None, "only what was found may be missing"
    return scenario


def pictures_of(kind: str, result: Any) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield the name of each picture of a result, and what draws it, which is imported late."""
    for name, function in PICTURES.get(kind, {}).items():
        module, draw = function.split(".")
        yield name, partial(getattr(import_module(f"drysim.plots.{module}"), draw), result)
    if kind == "ensemble":
        yield from pictures_of("run", result.shown)


def write_pictures(kind: str, picture_format: str, result: Any, folder: Path) -> None:
    """Draw and write the pictures of a result."""
    from drysim.plots.style import save_picture

    for name, draw in pictures_of(kind, result):
        save_picture(draw, folder / f"{name}.{picture_format}")
