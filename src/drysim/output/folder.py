"""The output folder: atomic, locked, resumable.

A folder appears complete or not at all: the files are written into `<name>.partial`, which is
ours by a lock for as long as the work lasts, and one rename puts it in the place of the old
folder. drysim.json comes into `<name>.partial` first, to mark it as ours, and is written anew
when all other files are there, since it names and hashes them. By it drysim knows a folder
again: what it did not write itself, or what somebody has edited since, is never replaced, and
`check_writable` tells so before any work. A kill leaves `<name>.partial` with the finished cases, for
`--resume`; one between two renames leaves the old folder aside, and the next run puts it back.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
import shutil
import stat
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from drysim.errors import EXIT_INTERRUPTED, OutputError
from drysim.output.sidecar import Provenance, json_text
from drysim.system import removed_error

MARKER = "drysim.json"
"""The file by which drysim knows a folder again: the first one in it and the last to leave."""

MARKER_DRAFT = "drysim.json.new"
"""A marker that is being written; it becomes `MARKER` by rename, so that none is ever torn."""

JOURNAL = "cases.jsonl"
"""Finished seeds of a run under way, kept in `<name>.partial`: one line says what is run, each
further one is a seed."""

CASES_FOLDER = "cases"
"""The same for a sweep: a folder with a file for every finished block of cases."""

RESUMABLE_FILES = re.compile(r"cases\.(jsonl|new)|cases/(sweep\.(json|new)|[-0-9a-f]+\.cases)")
"""What is kept there until the work is done."""

RESULT_FILES = re.compile(
    r"(response|spectra|transmissibility|stroke|ensemble|comparison|speed_error)\.(csv|png)"
    r"|(events|stroke_violations|hard_cases)\.csv|transmissibility/approach=[^/]+/\d+\.parquet"
    r"|(scenario|paper-(high|low)-friction|paper-random)\.yaml"
)
"""Every file of a result: a kill may leave some in `<name>.partial` before they are listed."""

SCENARIO_FILE = "scenario.yaml"
"""The resolved scenario of a result: the one file in it that people edit."""

IGNORED_FILES = frozenset({".DS_Store", "Thumbs.db", "desktop.ini"})
"""What file managers leave behind without being asked; it may go with the folder."""

BYTE_UNITS = {"GB": 1e9, "MB": 1e6, "kB": 1e3}
"""Units that sizes are told in [B]."""

OTHER_FOLDER_HINT = "choose another folder with --out"
ERRNO_HINTS = {
    errno.ENOSPC: f"make room on the disk, or {OTHER_FOLDER_HINT}",
    errno.ENAMETOOLONG: "choose a shorter name with --out",
    errno.EBUSY: "name a folder inside it with --out",
    errno.EMFILE: "let a process open more files, by `ulimit -n 1024`",
    errno.ENFILE: "end what holds so many files open",
}

Made = TypeVar("Made")


def write_folder(
    result: Made,
    folder: Path | LockedFolder,
    writers: Sequence[Callable[[Made, Path], None]],
    to_fields: Callable[[Made, Provenance], dict[str, Any]],
    command: str,
    exit_code: int,
) -> dict[str, Any]:
    """Let all writers write, tell what made their files, and put the folder in its place."""
    held = nullcontext(folder) if isinstance(folder, LockedFolder) else lock_partial(folder)
    with held as locked:
        check_lock(locked)
        check_ownership(
            resolve_name(locked.folder)
        )  # what somebody has put there meanwhile stays
        for writer in writers:
            writer(result, locked.partial)
        files = {
            path.relative_to(locked.partial).as_posix(): _sha256(path)
            for path in result_files(locked.partial)
        }
        fields = to_fields(result, Provenance(command, exit_code, files))
        write_marker(locked.partial, json_text(fields))
        if exit_code == EXIT_INTERRUPTED:
            release_partial(locked.partial)
        else:
            install_partial(locked)
    return fields


def result_files(partial: Path) -> list[Path]:
    """Give every file of a result, those in folders of its own included."""
    candidates = (path for path in partial.rglob("*") if path.is_file())
    return sorted(
        path
        for path in candidates
        if RESULT_FILES.fullmatch(path.relative_to(partial).as_posix())
    )


def _sha256(file: Path) -> str:
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


# Our hold on a folder, from before the work until its result is in place.


class LockedFolder(NamedTuple):
    """Our hold on an output folder: its name, and `<name>.partial`, where the work is done."""

    folder: Path
    partial: Path
    held: os.stat_result

    @property
    def journal(self) -> Path:
        """Where finished seeds are kept while the work goes on."""
        return self.partial / JOURNAL

    @property
    def cases(self) -> Path:
        """Where finished blocks of cases are kept."""
        return self.partial / CASES_FOLDER


@contextmanager
def lock_partial(folder: Path, resume: bool = False) -> Iterator[LockedFolder]:
    """Take `<name>.partial` for ourselves, marked as ours and locked, for as long as the block.

    Parameters
    ----------
    folder : Path
        The output folder as the user names it.
    resume : bool, optional
        Keep the finished cases that an interrupted sweep has left there.

    Yields
    ------
    Claim
        To be handed to whoever writes the files. When the block fails, `<name>.partial` stays
        if it holds finished cases and is removed otherwise; `folder` is as it was.

    Raises
    ------
    OutputError
        The folder is not ours to replace, or cannot be written.
    """
    check_writable(folder)
    with translate_os_errors(folder):
        target = resolve_name(folder)
        partial = sibling(target, "partial")
        partial.mkdir(parents=True, exist_ok=True)
        try:
            with exclusive_lock(partial, folder):
                yield from _mark_partial(folder, target, partial, resume)
        except OSError:
            with suppress(OSError):
                partial.rmdir()  # an empty one, even where no more files can be opened
            raise


def _mark_partial(
    folder: Path, target: Path, partial: Path, resume: bool
) -> Iterator[LockedFolder]:
    """Mark `<name>.partial` as ours and give it; when that fails, leave what can be resumed.

    Some files are held open for the time after a failure: to remove a folder, it is opened.
    """
    with ExitStack() as reserve:
        try:
            for end in (*os.pipe(), *os.pipe()):  # each is as good as a file held open
                reserve.callback(os.close, end)
            recover(target, sibling(target, "replaced"))
            # Without its marker the journal would be a stranger to the next drysim.
            remove_contents(partial, {CASES_FOLDER, JOURNAL, MARKER} if resume else set())
            write_marker(partial, '{"format": 1, "complete": false}\n')
            yield LockedFolder(folder, partial, partial.stat())
        except BaseException as fault:
            reserve.close()
            gone = isinstance(fault, FileNotFoundError) and not partial.exists()
            release_partial(partial)
            if gone:
                raise removed_error(partial) from fault
            raise


def check_lock(locked: LockedFolder) -> None:
    """Make sure that `<name>.partial` is still the folder that we hold.

    Raises
    ------
    OutputError
        When somebody has removed it, or has put another in its place.
    """
    try:
        same = os.path.samestat(locked.partial.stat(), locked.held)
    except FileNotFoundError:
        same = False
    if not same:
        raise removed_error(locked.partial)


def write_marker(folder: Path, text: str) -> None:
    """Give a folder its drysim.json, in one piece or not at all.

    It is on the disk before it has its name: without it, after a power cut, the folder would be
    a stranger to the next drysim.
    """
    (folder / MARKER_DRAFT).write_text(text, encoding="utf-8", newline="\n")
    flush_to_disk(folder / MARKER_DRAFT)
    os.replace(folder / MARKER_DRAFT, folder / MARKER)


def install_partial(locked: LockedFolder) -> None:
    """Put `<name>.partial` in the place of the output folder, without its finished cases."""
    target = resolve_name(locked.folder)
    check_lock(locked)
    kept = [
        path for path in locked.partial.iterdir() if path.name not in (JOURNAL, CASES_FOLDER)
    ]
    for path in [*kept, locked.partial]:
        flush_to_disk(path)
    locked.journal.unlink(missing_ok=True)
    if not any(path.startswith(f"{CASES_FOLDER}/") for path in foreign_files(locked.partial)):
        shutil.rmtree(locked.cases, ignore_errors=True)
    replace_folder(locked.partial, target, sibling(target, "replaced"))


def release_partial(partial: Path) -> None:
    """Leave `<name>.partial` for a later time, or remove it when it holds no finished case."""
    with suppress(OSError):
        if not _has_finished_work(partial) and not foreign_files(partial):
            remove_contents(partial)
            partial.rmdir()


def holds_sweep(folder: Path) -> bool:
    """Tell whether an output folder holds the table of a sweep."""
    names = ("transmissibility.csv", "transmissibility")
    return any((folder / name).exists() for name in names)


def is_resumable(folder: Path) -> bool:
    """Tell whether an interrupted sweep has left finished cases beside an output folder."""
    return _has_finished_work(sibling(resolve_name(folder), "partial"))


def _has_finished_work(partial: Path) -> bool:
    """Whether a folder holds finished cases."""
    if any(file.stat().st_size for file in (partial / CASES_FOLDER).glob("*.cases")):
        return True
    try:
        with (partial / JOURNAL).open("rb") as lines:
            return len(list(islice(lines, 2))) == 2
    except OSError:
        return False


# Whose folder is it? Tells before any work whether drysim may write or replace one.


def check_writable(folder: Path) -> None:
    """Find out, before any computation, whether a folder may be written; it need not exist.

    Raises
    ------
    OutputError
        The folder is not ours to replace, or cannot be written; nothing was touched.
    """
    with translate_os_errors(folder):
        target = resolve_name(folder)
        check_ownership(target)
        for suffix in ("partial", "replaced"):
            check_ownership(sibling(target, suffix), leftover=True)
        parent = _existing_parent(target)
        if not parent.is_dir():
            raise OutputError(
                f"cannot write {folder}: {parent.name} is not a folder", OTHER_FOLDER_HINT
            )
        if not os.access(parent, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


def check_disk_space(folder: Path, volume: float) -> None:
    """Find out, before any computation, whether a disk has room for so many bytes.

    Raises
    ------
    OutputError
        When it has not: what is free, and what is needed at least.
    """
    with translate_os_errors(folder):
        free = float(shutil.disk_usage(_existing_parent(resolve_name(folder))).free)
    if volume > free:
        needed, has = format_bytes(volume), format_bytes(free)
        sentence = f"cannot write {folder}: it takes {needed} at least, and {has} are free"
        raise OutputError(sentence, ERRNO_HINTS[errno.ENOSPC])


def format_bytes(size: float) -> str:
    """Give a number of bytes in words."""
    for unit, one in BYTE_UNITS.items():
        if size >= one:
            return f"{size / one:.3g} {unit}"
    return f"{size:.0f} bytes"


def resolve_name(folder: Path) -> Path:
    """Give a folder that the user calls `.` or `..` by its own name."""
    return folder if folder.name not in ("", "..") else Path(os.path.realpath(folder))


def sibling(target: Path, suffix: str) -> Path:
    """Give the sibling `<name>.<suffix>`."""
    return target.with_name(f"{target.name}.{suffix}")


@contextmanager
def translate_os_errors(folder: Path) -> Iterator[None]:
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
        hint = ERRNO_HINTS.get(fault.errno or 0, OTHER_FOLDER_HINT)
        raise OutputError(f"cannot write {folder}: {reason}", hint) from fault


def check_ownership(target: Path, leftover: bool = False) -> None:
    """Raise when something is in the way that drysim did not write."""
    if not _exists(target):
        return
    hint = f"move it away, or {OTHER_FOLDER_HINT}"
    if target.is_symlink():
        raise OutputError(
            f"{target} is a symbolic link", f"name the folder itself, or {OTHER_FOLDER_HINT}"
        )
    if not target.is_dir():
        raise OutputError(f"{target} is a file, not a folder", hint)
    held = set(os.listdir(target)) - IGNORED_FILES - {MARKER_DRAFT}
    marker = _read_marker(target)
    if held and marker is None:
        raise OutputError(f"{target} was not written by drysim; it stays as it is", hint)
    if leftover:
        if foreign := foreign_files(target):
            raise OutputError(f"{target} holds {foreign[0]}, which drysim did not write", hint)
        return
    if marker is None:
        return
    ours = _listed_files(marker)
    folders = {name.partition("/")[0] for name in ours if "/" in name}
    inner = {
        f"{name}/{path}" for name in held & folders for path in _files_within(target / name)
    }
    foreign = sorted((held - {MARKER} - folders) - ours | inner - ours)
    if foreign:
        raise OutputError(f"{target} holds {foreign[0]}, which drysim did not write", hint)
    if _is_edited(target / SCENARIO_FILE, marker):
        raise OutputError(
            f"{target / SCENARIO_FILE} was edited since drysim wrote it, and would be replaced",
            f"save it elsewhere, or {OTHER_FOLDER_HINT}",
        )


def foreign_files(partial: Path) -> list[str]:
    """Return the files in a `<name>.partial` that drysim neither keeps nor writes there."""
    ours = _listed_files(_read_marker(partial)) | {MARKER, MARKER_DRAFT}
    return sorted(
        path
        for path in _files_within(partial)
        if path not in ours
        and not RESUMABLE_FILES.fullmatch(path)
        and not RESULT_FILES.fullmatch(path)
    )


def _read_marker(target: Path) -> dict[str, Any] | None:
    """Give the marker of a folder that drysim wrote, None for any other folder."""
    file = target / MARKER
    try:
        marker = json.loads(file.read_bytes()) if file.is_file() else None
    except (OSError, ValueError, RecursionError):
        return None
    return (
        marker if isinstance(marker, dict) and isinstance(marker.get("format"), int) else None
    )


def _listed_files(marker: dict[str, Any] | None) -> set[str]:
    """Return the files that a marker names."""
    files = marker.get("files") if marker else None
    return set(files if isinstance(files, dict) else ())


def _files_within(folder: Path) -> Iterator[str]:
    """Give the files within a folder of a result, by their path from it."""
    for path in folder.rglob("*"):
        if not path.is_dir() and path.name not in IGNORED_FILES:
            yield path.relative_to(folder).as_posix()


def _is_edited(file: Path, marker: dict[str, Any]) -> bool:
    """Whether the scenario of a result, which runs again as it is, is somebody's own by now."""
    files = marker.get("files")
    written = files.get(file.name) if isinstance(files, dict) else None
    return written is not None and file.is_file() and str(written) != _sha256(file)


def _existing_parent(target: Path) -> Path:
    """Give the nearest folder above a place that is there."""
    parent = target.absolute().parent
    while not _exists(parent):
        parent = parent.parent
    return parent


def _exists(path: Path) -> bool:
    """Whether there is anything of that name; a link that leads nowhere counts."""
    try:
        os.lstat(path)
    except (FileNotFoundError, NotADirectoryError):
        return False
    except ValueError:
        raise OutputError(
            f"{str(path)!r} cannot be the name of a folder", OTHER_FOLDER_HINT
        ) from None
    return True


# One folder in the place of another at one instant, locks, and what a kill leaves behind.


def replace_folder(partial: Path, target: Path, backup: Path) -> None:
    """Put the new folder in place of the old one, and remove that."""
    if target.exists() and not any(target.iterdir()):
        target.rmdir()
    if not target.exists():
        partial.rename(target)
        flush_to_disk(target.parent)
        return
    with exclusive_lock(target, target):
        if _exchange(partial, target):
            backup = partial
        else:
            # A kill between these two leaves the old folder aside: see recover().
            target.rename(backup)
            try:
                partial.rename(target)
            except OSError:
                backup.rename(target)
                raise
        flush_to_disk(target.parent)
        remove_folder(backup)


def _exchange(one: Path, other: Path) -> bool:
    """Swap two folders at one instant; False where the system cannot (all but Linux)."""
    import ctypes

    try:
        rename = ctypes.CDLL(None).renameat2
    except (AttributeError, OSError, TypeError):
        return False
    at_fdcwd, swap = -100, 2  # AT_FDCWD and RENAME_EXCHANGE of <linux/fs.h>
    return bool(rename(at_fdcwd, os.fsencode(one), at_fdcwd, os.fsencode(other), swap) == 0)


def recover(target: Path, backup: Path) -> None:
    """Finish what a kill between two renames left behind."""
    if backup.exists() and target.exists():
        remove_folder(backup)
    elif backup.exists():
        backup.rename(target)


@contextmanager
def exclusive_lock(target: Path, folder: Path) -> Iterator[None]:
    """Hold a folder against other drysims; the lock dies with the process, even by kill -9.

    Raises
    ------
    OutputError
        When another one holds it, or has put another folder in its place.
    """
    if os.name == "nt":  # Folders cannot be locked there.
        yield
        return
    import fcntl

    busy = OutputError(
        f"another drysim is writing {folder} right now", f"wait for it, or {OTHER_FOLDER_HINT}"
    )
    handle = os.open(target, os.O_RDONLY)
    try:
        # Some network disks know no locks: any other OSError means to go on without.
        with suppress(OSError):
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise busy from None
        if not os.path.samestat(os.fstat(handle), os.stat(target)):
            raise busy
        yield
    finally:
        os.close(handle)


def remove_contents(folder: Path, keep: Collection[str] = ()) -> None:
    """Remove what a folder holds, the marker last, so that the rest stays known as ours."""
    for path in (folder, *folder.rglob("*")):
        if path.is_dir() and not path.is_symlink():
            path.chmod(path.stat().st_mode | stat.S_IRWXU)  # nothing leaves a read-only folder
    for path in sorted(folder.iterdir(), key=lambda path: path.name == MARKER):
        if path.name in keep:
            continue
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()


def remove_folder(folder: Path) -> None:
    """Remove a folder of ours; what cannot be removed now goes with the next run."""
    with suppress(OSError):
        remove_contents(folder)
    with suppress(OSError):
        folder.rmdir()  # an empty one even where no more files can be opened to see it


def flush_to_disk(path: Path) -> None:
    """Wait until a file or folder is on the disk."""
    if os.name == "nt" and path.is_dir():  # Folders cannot be opened there.
        return
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
