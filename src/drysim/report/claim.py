"""Whose folder is it? Tells before any work whether drysim may write or replace one."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from drysim.errors import OutputError

MARKER = "drysim.json"
"""The file by which drysim knows a folder again: the first one in it and the last to leave."""

DRAFT = "drysim.json.new"
"""A marker that is being written; it becomes `MARKER` by rename, so that none is ever torn."""

JOURNAL = "cases.jsonl"
"""Finished seeds of a run under way, kept in `<name>.partial`: one line says what is run, each
further one is a seed."""

CASES = "cases"
"""The same for a sweep: a folder with a file for every finished block of cases."""

KEPT = re.compile(r"cases\.(jsonl|new)|cases/(sweep\.(json|new)|[-0-9a-f]+\.cases)")
"""What is kept there until the work is done."""

RESULTS = re.compile(
    r"(response|spectra|transmissibility|stroke|ensemble|comparison|speed_error)\.(csv|png)"
    r"|(events|stroke_violations|hard_cases)\.csv|transmissibility/approach=[^/]+/\d+\.parquet"
    r"|(scenario|paper-(high|low)-friction|paper-random)\.yaml"
)
"""Every file of a result: a kill may leave some in `<name>.partial` before they are listed."""

SCENARIO = "scenario.yaml"
"""The resolved scenario of a result: the one file in it that people edit."""

STRAY = frozenset({".DS_Store", "Thumbs.db", "desktop.ini"})
"""What file managers leave behind without being asked; it may go with the folder."""

SIZES = {"GB": 1e9, "MB": 1e6, "kB": 1e3}
"""Units that sizes are told in [B]."""

ELSEWHERE = "choose another folder with --out"
HINTS = {
    errno.ENOSPC: f"make room on the disk, or {ELSEWHERE}",
    errno.ENAMETOOLONG: "choose a shorter name with --out",
    errno.EBUSY: "name a folder inside it with --out",
    errno.EMFILE: "let a process open more files, by `ulimit -n 1024`",
    errno.ENFILE: "end what holds so many files open",
}


def check(folder: Path) -> None:
    """Find out, before any computation, whether a folder may be written.

    Parameters
    ----------
    folder : Path
        The output folder; it need not exist.

    Raises
    ------
    OutputError
        The folder is not ours to replace, or cannot be written; nothing was touched.
    """
    with sentences(folder):
        place = named(folder)
        refuse_foreign(place)
        for suffix in ("partial", "replaced"):
            refuse_foreign(beside(place, suffix), leftover=True)
        parent = _there(place)
        if not parent.is_dir():
            raise OutputError(
                f"cannot write {folder}: {parent.name} is not a folder", ELSEWHERE
            )
        if not os.access(parent, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


def require_room(folder: Path, volume: float) -> None:
    """Find out, before any computation, whether a disk has room for so many bytes.

    Raises
    ------
    OutputError
        When it has not: what is free, and what is needed at least.
    """
    with sentences(folder):
        free = float(shutil.disk_usage(_there(named(folder))).free)
    if volume > free:
        needed, has = spoken(volume), spoken(free)
        sentence = f"cannot write {folder}: it takes {needed} at least, and {has} are free"
        raise OutputError(sentence, HINTS[errno.ENOSPC])


def spoken(size: float) -> str:
    """Give a number of bytes in words."""
    for unit, one in SIZES.items():
        if size >= one:
            return f"{size / one:.3g} {unit}"
    return f"{size:.0f} bytes"


def _there(place: Path) -> Path:
    """Give the nearest folder above a place that is there."""
    parent = place.absolute().parent
    while not _exists(parent):
        parent = parent.parent
    return parent


def named(folder: Path) -> Path:
    """Give a folder that the user calls `.` or `..` by its own name."""
    return folder if folder.name not in ("", "..") else Path(os.path.realpath(folder))


def beside(place: Path, suffix: str) -> Path:
    """Give the sibling `<name>.<suffix>`."""
    return place.with_name(f"{place.name}.{suffix}")


@contextlib.contextmanager
def sentences(folder: Path) -> Iterator[None]:
    """Turn what the system says into what, where and what to do.

    Raises
    ------
    OutputError
        In place of any OSError of the block.
    """
    try:
        yield
    except OSError as fault:
        reason = (fault.strerror or str(fault)).lower()
        hint = HINTS.get(fault.errno or 0, ELSEWHERE)
        raise OutputError(f"cannot write {folder}: {reason}", hint) from fault


def _exists(path: Path) -> bool:
    """Whether there is anything of that name; a link that leads nowhere counts."""
    try:
        os.lstat(path)
    except (FileNotFoundError, NotADirectoryError):
        return False
    except ValueError:
        raise OutputError(f"{str(path)!r} cannot be the name of a folder", ELSEWHERE) from None
    return True


def refuse_foreign(place: Path, leftover: bool = False) -> None:
    """Raise when something is in the way that drysim did not write."""
    if not _exists(place):
        return
    away = f"move it away, or {ELSEWHERE}"
    if place.is_symlink():
        raise OutputError(
            f"{place} is a symbolic link", f"name the folder itself, or {ELSEWHERE}"
        )
    if not place.is_dir():
        raise OutputError(f"{place} is a file, not a folder", away)
    held = set(os.listdir(place)) - STRAY - {DRAFT}
    marker = _marker(place)
    if held and marker is None:
        raise OutputError(f"{place} was not written by drysim; it stays as it is", away)
    if leftover:
        if foreign := strangers(place):
            raise OutputError(f"{place} holds {foreign[0]}, which drysim did not write", away)
        return
    if marker is None:
        return
    ours = _listed(marker)
    folders = {name.partition("/")[0] for name in ours if "/" in name}
    inner = {f"{name}/{path}" for name in held & folders for path in _inside(place / name)}
    foreign = sorted((held - {MARKER} - folders) - ours | inner - ours)
    if foreign:
        raise OutputError(f"{place} holds {foreign[0]}, which drysim did not write", away)
    if _edited(place / SCENARIO, marker):
        raise OutputError(
            f"{place / SCENARIO} was edited since drysim wrote it, and would be replaced",
            f"save it elsewhere, or {ELSEWHERE}",
        )


def strangers(partial: Path) -> list[str]:
    """Return the files in a `<name>.partial` that drysim neither keeps nor writes there."""
    ours = _listed(_marker(partial)) | {MARKER, DRAFT}
    return sorted(
        path
        for path in _inside(partial)
        if path not in ours and not KEPT.fullmatch(path) and not RESULTS.fullmatch(path)
    )


def _listed(marker: dict[str, Any] | None) -> set[str]:
    """Return the files that a marker names."""
    files = marker.get("files") if marker else None
    return set(files if isinstance(files, dict) else ())


def _inside(folder: Path) -> Iterator[str]:
    """Give the files within a folder of a result, by their path from it."""
    for path in folder.rglob("*"):
        if not path.is_dir() and path.name not in STRAY:
            yield path.relative_to(folder).as_posix()


def _edited(file: Path, marker: dict[str, Any]) -> bool:
    """Whether the scenario of a result, which runs again as it is, is somebody's own by now."""
    files = marker.get("files")
    written = files.get(file.name) if isinstance(files, dict) else None
    if written is None or not file.is_file():
        return False
    return str(written) != hashlib.sha256(file.read_bytes()).hexdigest()


def _marker(place: Path) -> dict[str, Any] | None:
    """Give the marker of a folder that drysim wrote, None for any other folder."""
    file = place / MARKER
    try:
        marker = json.loads(file.read_bytes()) if file.is_file() else None
    except (OSError, ValueError, RecursionError):
        return None
    return (
        marker if isinstance(marker, dict) and isinstance(marker.get("format"), int) else None
    )
