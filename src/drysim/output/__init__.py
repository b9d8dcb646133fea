"""Output folders: the files of finished work. Computes nothing and shows nothing.

`write` writes the files of a result, as its kind names them. `folder.write_folder` writes them
in `<name>.partial`, adds drysim.json last, and replaces the old folder by the new one.
`check_writable` and `lock_partial` verify before any work that this is allowed.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drysim.errors import EXIT_INTERRUPTED
from drysim.output.folder import STORES as STORES
from drysim.output.folder import LockedFolder, write_folder
from drysim.output.folder import check_disk_space as check_disk_space
from drysim.output.folder import check_no_result as check_no_result
from drysim.output.folder import check_writable as check_writable
from drysim.output.folder import has_report as has_report
from drysim.output.folder import lock_partial as lock_partial
from drysim.output.folder import resumable_parts as resumable_parts
from drysim.results import kind_of
from drysim.results.fields import json_text as json_text
from drysim.results.kind import PNG, SCENARIO_FILE, write_scenario

if TYPE_CHECKING:
    from drysim.study.outcome import AnyResult


def write(
    result: AnyResult,
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
    result : AnyResult
        Of one of `drysim.results.KINDS`.
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
    writers = [partial(write_files, form)]
    if plots and exit_code != EXIT_INTERRUPTED:
        writers.append(partial(write_pictures, picture_format))
    to_page = None
    if report:
        from drysim.output.report import page

        to_page = partial(page, plots=plots)
    return write_folder(result, folder, writers, command, exit_code, to_page)


def save(
    result: AnyResult, folder: str | Path, *, plots: bool = True, report: bool = False
) -> Path:
    """Write the output folder of a result that no command computed; see `Result.save`."""
    kind_of(result)
    out = Path(folder)
    check_writable(out)
    code = result.exit_code()
    write(result, out, plots=plots, command="", exit_code=code, report=report)
    return out


def write_files(form: str, result: AnyResult, folder: Path) -> None:
    """Write the scenario and the tables of a result."""
    kind = kind_of(result)
    write_scenario(kind.scenario(result), folder / SCENARIO_FILE)
    for file in kind.files:
        if file.form in ("", form):
            file.write(result, folder if "*" in file.name else folder / file.name)


def write_pictures(picture_format: str, result: AnyResult, folder: Path) -> None:
    """Draw and write the pictures of a result."""
    from drysim.plots.style import save_picture
    from drysim.results.pictures import pictures_of

    for picture, draw in pictures_of(result):
        save_picture(draw, folder / f"{picture.name}.{picture_format}")
