"""The output folder: atomic, locked, resumable.

Problem
    An output folder is complete or absent, whatever ends the process and whenever. Files that
    drysim did not write, or that were edited since, are never replaced. An interrupted sweep or
    ensemble can continue.

Method
    1. `check_writable` verifies the folder before any computation.
    2. The files are written to `<name>.partial`, which is locked while the work lasts.
       drysim.json is written there first and marks the folder as drysim's; it is rewritten
       last, because it contains the names and hashes of all other files.
    3. The old folder is renamed to `<name>.replaced`, `<name>.partial` to `<name>`, and the old
       folder is removed.

After a kill
    `<name>.partial` holds the finished cases for `--resume`. A kill between two renames leaves
    the old folder as `<name>.replaced`; the next run restores it.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
import shutil
import stat
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from functools import partial as bind
from pathlib import Path
from secrets import token_hex
from typing import TYPE_CHECKING, Any, NamedTuple

from drysim.errors import EXIT_INTERRUPTED, OutputError
from drysim.forced_exit import at_forced_exit, no_forced_exit
from drysim.messages import format_value, shorten
from drysim.results import all_kinds, fields_of, kind_of
from drysim.results.fields import (
    DIGEST,
    FORMAT_VERSION,
    Provenance,
    digest_of,
    is_intact,
    json_text,
)
from drysim.results.kind import SCENARIO_FILE
from drysim.study.summary import BAD, Note, Summary
from drysim.system import (
    NotARegularFile,
    file_sha256,
    flush_to_disk,
    is_path_too_long,
    lock_folder,
    removed_error,
    replace,
)
from drysim.wording import format_count, sanitise

if TYPE_CHECKING:
    from drysim.results.kind import Kind
    from drysim.study.outcome import AnyResult

MARKER = "drysim.json"
"""The file that identifies a folder of drysim: first written, last removed."""

MARKER_DRAFT = "drysim.json.new"
"""A marker being written; renamed to `MARKER`, so that no marker is ever incomplete."""

STORES = {"cases": "sweep", "seeds": "run", "designs": "design", "steps": "fit"}
"""Folders with the finished parts of interrupted work, and the command that resumes each."""

RESUMABLE_FILES = re.compile(
    rf"cases\.(jsonl|new)|({'|'.join(STORES)})/(sweep\.(json|new)|\d+\.(npz|new)|[-0-9a-f]+\.cases)"
)
"""Files that hold finished work until all of it is done, also those of earlier versions:
`cases.jsonl` and `*.cases`."""

REPORT_FILE = "report.html"
"""The report of a result."""

GENERATOR = '<meta name="generator" content="drysim '
"""The line of a report by which it is recognised."""

IGNORED_FILES = re.compile(
    r"\.DS_Store|Thumbs\.db|desktop\.ini|\.nfs[0-9a-f]+|~\$.*|\.~lock\..*#", re.DOTALL
)
"""Files of file managers, network disks (removed while open) and office programs (a table that
they show); they may be deleted with the folder."""

BYTE_UNITS = {"GB": 1e9, "MB": 1e6, "kB": 1e3}
"""Units of file sizes [B]."""

DAMAGE = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)
"""What reading values of a wrong type or size raises."""

FIELD_TYPES = {
    "metrics": dict, "checks": list, "numerics": dict, "command": str, "complete": bool
}  # fmt: skip
"""Fields that drysim.json of every finished result has, and their types."""

TYPE_NAMES = {dict: "an object", list: "a list", str: "text", bool: "true or false"}
"""The types in words of JSON."""

AGAIN_HINT = "remove the folder and compute the result again"
OTHER_FOLDER_HINT = "choose another folder with --out"
ERRNO_HINTS = {
    errno.ENOSPC: f"free disk space, or {OTHER_FOLDER_HINT}",
    errno.ENAMETOOLONG: "choose a shorter name with --out",
    errno.EBUSY: "name a folder inside it with --out",
    errno.EMFILE: "raise the limit of open files, e.g. `ulimit -n 1024`",
    errno.ENFILE: "close programs that have many files open",
}


def write_folder(
    result: AnyResult,
    folder: Path | LockedFolder,
    writers: Sequence[Callable[[AnyResult, Path], None]],
    command: str,
    exit_code: int,
    to_page: Callable[[dict[str, Any], Path], str] | None = None,
) -> dict[str, Any]:
    """Write all files and drysim.json of a result, and put the folder in place.

    Parameters
    ----------
    result
    folder : Path or LockedFolder
    writers : sequence of callable
        Each writes its files of the result into a folder.
    command : str
    exit_code : int
    to_page : callable, optional
        Returns the report, given the content of drysim.json and the folder.

    Returns
    -------
    dict
        The content of drysim.json.
    """
    held = nullcontext(folder) if isinstance(folder, LockedFolder) else lock_partial(folder)
    with held as locked, ExitStack() as stack:
        check_lock(locked)
        check_ownership(resolve_name(locked.folder))  # it may differ now
        kind = kind_of(result)
        stack.enter_context(at_forced_exit(bind(remove_unlisted, locked.partial, kind)))
        for writer in writers:
            writer(result, locked.partial)
        files = {
            path.relative_to(locked.partial).as_posix(): file_sha256(path)
            for path in result_files(locked.partial, kind)
        }
        fields = fields_of(result, Provenance(command, exit_code, files))
        fields[DIGEST] = digest_of(fields)
        if to_page is not None and exit_code != EXIT_INTERRUPTED:
            write_report(locked.partial, to_page(fields, locked.partial), fields)
        else:
            write_marker(locked.partial, json_text(fields))
        if exit_code == EXIT_INTERRUPTED:
            release_partial(locked.partial)
        else:
            with no_forced_exit():
                install_partial(locked)
    return fields


def write_report(folder: Path, page: str, fields: dict[str, Any]) -> None:
    """Write the report of a result into its folder, and add it to the files in its fields.

    The marker lists the report before it is there: after a kill, no file is unknown. Fields
    that were changed since drysim wrote them do not become intact by this.
    """
    content, intact = page.encode(), is_intact(fields)
    listed = {**fields["files"], REPORT_FILE: hashlib.sha256(content).hexdigest()}
    fields["files"] = dict(sorted(listed.items()))
    if intact:
        fields[DIGEST] = digest_of(fields)
    write_marker(folder, json_text(fields))
    (folder / MARKER_DRAFT).write_bytes(content)
    replace(folder / MARKER_DRAFT, folder / REPORT_FILE)


def result_files(partial: Path, kind: Kind) -> list[Path]:
    """Return all files of a result, with those in its subfolders."""
    candidates = (path for path in partial.rglob("*") if path.is_file())
    return sorted(
        path for path in candidates if kind.writes(path.relative_to(partial).as_posix())
    )


# The lock on a folder, from before the work until its result is in place.


class NotReplacedError(OutputError):
    """A result is complete in `<name>.partial`, but the old folder cannot give way to it."""


class LockedFolder(NamedTuple):
    """A locked output folder."""

    folder: Path
    """The output folder."""
    partial: Path
    """`<name>.partial`, where the files are written."""
    held: os.stat_result
    """Identity of `<name>.partial` when it was locked."""


@contextmanager
def lock_partial(
    folder: Path, resume: bool = False, check: Callable[[Path], object] | None = None
) -> Iterator[LockedFolder]:
    """Lock `<name>.partial` and mark it as drysim's while the block runs.

    Parameters
    ----------
    folder : Path
        The output folder as the user named it.
    resume : bool, optional
        Keep the finished cases of an interrupted sweep.
    check : callable, optional
        Called with `<name>.partial` when it is locked and nothing in it was changed.

    Yields
    ------
    LockedFolder
        For the functions that write files. If the block fails, `<name>.partial` stays if it
        holds finished cases and is removed otherwise; `folder` is unchanged.

    Raises
    ------
    OutputError
        The folder was not written by drysim, or cannot be written.
    """
    check_writable(folder)
    with translate_os_errors(folder):
        target = resolve_name(folder)
        partial = sibling(target, "partial")
        partial.mkdir(parents=True, exist_ok=True)
        try:
            with exclusive_lock(partial, folder):
                if check is not None:
                    check(partial)
                yield from _mark_partial(folder, target, partial, resume)
        except OSError:
            with suppress(OSError):
                partial.rmdir()  # works for an empty folder even if no more files can be opened
            raise


def _mark_partial(
    folder: Path, target: Path, partial: Path, resume: bool
) -> Iterator[LockedFolder]:
    """Mark `<name>.partial` as drysim's and yield it; on failure keep what can be resumed."""
    with at_forced_exit(lambda: abandon_partial(folder, partial)):
        try:
            recover(target, sibling(target, "replaced"))
            # Without its marker the next run would not recognise the cases as drysim's.
            remove_contents(partial, {*STORES, MARKER} if resume else set())
            marker = {"format": FORMAT_VERSION, "complete": False}
            write_marker(partial, json.dumps(marker) + "\n")
            yield LockedFolder(folder, partial, partial.stat())
        except NotReplacedError:
            raise
        except BaseException as fault:
            gone = isinstance(fault, FileNotFoundError) and not partial.exists()
            release_partial(partial)
            if gone:
                raise removed_error(partial) from fault
            raise


def check_lock(locked: LockedFolder) -> None:
    """Verify that `<name>.partial` is still the folder that was locked.

    Raises
    ------
    OutputError
        When it was removed, or replaced by another one.
    """
    try:
        same = os.path.samestat(locked.partial.stat(), locked.held)
    except FileNotFoundError:
        same = False
    if not same:
        raise removed_error(locked.partial)


def write_marker(folder: Path, text: str) -> None:
    """Write drysim.json of a folder atomically.

    The draft is flushed to the disk before the rename: after a power cut, a folder with an
    empty marker would not be recognised as drysim's.
    """
    (folder / MARKER_DRAFT).write_text(text, encoding="utf-8", newline="\n")
    flush_to_disk(folder / MARKER_DRAFT)
    replace(folder / MARKER_DRAFT, folder / MARKER)


def install_partial(locked: LockedFolder) -> None:
    """Replace the output folder by `<name>.partial`, without its finished cases.

    Raises
    ------
    NotReplacedError
        When the old folder cannot give way, as on Windows while a file of it is open.
    """
    target = resolve_name(locked.folder)
    check_lock(locked)
    kept = [path for path in locked.partial.iterdir() if path.name not in STORES]
    for path in [*kept, locked.partial]:
        flush_to_disk(path)
    foreign = {path.partition("/")[0] for path in foreign_files(locked.partial)}
    for name in set(STORES) - foreign:
        shutil.rmtree(locked.partial / name, ignore_errors=True)
    try:
        replace_folder(locked.partial, target, sibling(target, "replaced"))
    except (OSError, OutputError) as fault:
        if not locked.partial.exists():
            raise
        reason = getattr(fault, "strerror", None) or str(fault)
        raise NotReplacedError(
            f"cannot replace {locked.folder}: {reason.lower()}",
            f"the result is complete in {locked.partial}; close the programs that show files "
            f"of {locked.folder}, and rename it",
        ) from fault


def release_partial(partial: Path) -> None:
    """Keep `<name>.partial` if it holds finished cases, else remove it."""
    with suppress(OSError):
        if not _finished_parts(partial) and not foreign_files(partial):
            remove_contents(partial)
            partial.rmdir()


def remove_unlisted(partial: Path, kind: Kind) -> None:
    """Remove the files of a result that is not complete, before a forced exit."""
    with suppress(OSError):  # the work may remove a file at the same time
        listed = _listed_files(_read_marker(partial))
        for file in result_files(partial, kind):
            if file.relative_to(partial).as_posix() not in listed:
                file.unlink(missing_ok=True)


def abandon_partial(folder: Path, partial: Path) -> str:
    """Leave `<name>.partial` in order before a forced exit; return what is kept, if anything.

    The work may still be running, but it cannot put the folder in place any more.
    """
    kept = bool(_finished_parts(partial))
    release_partial(partial)
    if not kept:
        return ""
    return (
        f"interrupted: what is finished is kept in {sanitise(str(folder))}.partial; the same "
        "command with --resume computes only the rest"
    )


def stored_kind(folder: Path) -> str:
    """Return the name of the kind of result that an output folder holds; empty for none."""
    return str((_read_marker(folder) or {}).get("kind", ""))


def has_report(folder: Path) -> bool:
    """Whether an output folder holds a report that drysim wrote."""
    return REPORT_FILE in _listed_files(_read_marker(folder)) and _exists(folder / REPORT_FILE)


def resumable_parts(folder: Path) -> list[str]:
    """Return what interrupted work left for an output folder, as named in `STORES`."""
    return _finished_parts(sibling(resolve_name(folder), "partial"))


def _finished_parts(partial: Path) -> list[str]:
    """Return the stores of a folder that hold finished cases or seeds."""
    return [
        name
        for name in STORES
        if any(file.stat().st_size for file in (partial / name).glob("*.npz"))
    ]


# Ownership: whether drysim may write or replace a folder, decided before any work.


def check_writable(folder: Path) -> None:
    """Verify, before any computation, that a folder may be written; it need not exist.

    Raises
    ------
    OutputError
        The folder was not written by drysim, or cannot be written; nothing was changed.
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


def check_no_result(folder: Path) -> None:
    """Verify that a folder that is to hold several results is not a result itself.

    Raises
    ------
    OutputError
        The folder is a result, or will be: work on it, or what a kill left, is beside it.
    """
    with translate_os_errors(folder):
        target = resolve_name(folder)
        names = (target, *(sibling(target, suffix) for suffix in ("partial", "replaced")))
        place = next((name for name in names if _read_marker(name) is not None), None)
    if place is not None:
        why = "is a result itself" if place == target else f"has {place.name} beside it"
        raise OutputError(
            f"{folder} {why}: the results of several scenarios cannot be written into it",
            OTHER_FOLDER_HINT,
        )


def check_disk_space(folder: Path, volume: float) -> None:
    """Verify, before any computation, that the disk has room for `volume` bytes.

    Raises
    ------
    OutputError
        When it has not, with the free and the needed size.
    """
    with translate_os_errors(folder):
        free = float(shutil.disk_usage(_existing_parent(resolve_name(folder))).free)
    if volume > free:
        needed, has = format_bytes(volume), format_bytes(free)
        raise OutputError(
            f"cannot write {folder}: it needs about {needed}, and {has} are free",
            f"use a longer step or a shorter duration, {ERRNO_HINTS[errno.ENOSPC]}",
        )


def format_bytes(size: float) -> str:
    """Return a number of bytes with its unit."""
    for unit, bytes_per_unit in BYTE_UNITS.items():
        if size >= bytes_per_unit:
            return f"{size / bytes_per_unit:.3g} {unit}"
    return f"{size:.0f} bytes"


def resolve_name(folder: Path) -> Path:
    """Return a folder named `.` or `..` by its own name."""
    return folder if folder.name not in ("", "..") else Path(os.path.realpath(folder))


def sibling(target: Path, suffix: str) -> Path:
    """Return the sibling `<name>.<suffix>`."""
    return target.with_name(f"{target.name}.{suffix}")


@contextmanager
def translate_os_errors(folder: Path) -> Iterator[None]:
    """Turn the OSErrors of the block into errors with a reason, a place and a hint.

    Raises
    ------
    OutputError
        In place of any OSError of the block.
    """
    try:
        yield
    except OSError as fault:
        reason = (fault.strerror or str(fault)).lower()
        number = errno.ENAMETOOLONG if is_path_too_long(fault) else fault.errno or 0
        hint = ERRNO_HINTS.get(number, OTHER_FOLDER_HINT)
        raise OutputError(f"cannot write {folder}: {reason}", hint) from fault


def check_ownership(target: Path, leftover: bool = False) -> None:
    """Raise OutputError if a path exists that drysim did not write."""
    if not _exists(target):
        return
    hint = f"move it away, or {OTHER_FOLDER_HINT}"
    if target.is_symlink():
        raise OutputError(
            f"{target} is a symbolic link", f"name the folder itself, or {OTHER_FOLDER_HINT}"
        )
    if not target.is_dir():
        raise OutputError(f"{target} is a file, not a folder", hint)
    names = {name for name in os.listdir(target) if not IGNORED_FILES.fullmatch(name)}
    held = names - {MARKER_DRAFT}
    marker = _read_marker(target)
    if held and marker is None:
        raise OutputError(f"{target} was not written by drysim; it stays as it is", hint)
    foreign = foreign_files(target, leftover)
    if not leftover:
        listed = {name.partition("/")[0] for name in _listed_files(marker)}
        foreign += [name for name in held - listed - {*STORES} if _is_empty(target / name)]
    if foreign:
        results = [name for name in sorted(foreign) if Path(name).name == MARKER]
        if results and _read_marker(target / Path(results[0]).parent) is not None:
            sentence = f"{target} holds another result, {Path(results[0]).parent.as_posix()}"
            raise OutputError(sentence, hint)
        raise OutputError(f"{target} holds {min(foreign)}, which drysim did not write", hint)
    if leftover or marker is None:
        return
    if _is_edited(target / SCENARIO_FILE, marker):
        raise OutputError(
            f"{target / SCENARIO_FILE} was edited since drysim wrote it, and would be replaced",
            f"save it elsewhere, or {OTHER_FOLDER_HINT}",
        )


def foreign_files(folder: Path, leftover: bool = True) -> list[str]:
    """Return the files in a folder of a result that drysim neither keeps nor writes there.

    Finished cases may be left in any folder: a network disk keeps a file that is still open. In
    a leftover, a `<name>.partial`, a file of a result need not be in the marker yet.
    """
    listed = _listed_files(_read_marker(folder)) | {MARKER, MARKER_DRAFT}
    links = [name for name in STORES if (folder / name).is_symlink()]
    unknown = sorted(
        path
        for path in [*_files_within(folder), *links]
        if path not in listed and not RESUMABLE_FILES.fullmatch(path)
    )
    if unknown and leftover:  # all kinds take a while to import
        kinds = [*all_kinds()]
        return [
            path
            for path in unknown
            if path != REPORT_FILE and not any(kind.writes(path) for kind in kinds)
        ]
    return unknown


def _is_empty(path: Path) -> bool:
    """Whether a path is a folder without any file."""
    return path.is_dir() and not any(_files_within(path))


def _read_marker(target: Path) -> dict[str, Any] | None:
    """Return the marker of a folder that drysim wrote, None for any other folder."""
    file = target / MARKER
    try:
        marker = json.loads(file.read_bytes()) if file.is_file() else None
    except (OSError, ValueError, RecursionError):
        return None
    return (
        marker if isinstance(marker, dict) and isinstance(marker.get("format"), int) else None
    )


def read_stored_fields(folder: Path) -> dict[str, Any]:
    """Read the drysim.json of a result.

    Raises
    ------
    OutputError
        When the folder has none, or one of a later version.
    """
    file = folder / MARKER
    hint = (
        "name an output folder of `drysim run`, `sweep`, `compare`, `fit`, `assess`, "
        "`design`, `branches`, `map` or `bench`"
    )
    try:
        if not stat.S_ISDIR(folder.stat().st_mode):
            remedy = f"name its folder, {folder.parent}" if folder.name == MARKER else hint
            raise OutputError(f"{folder} is a file, not a folder", remedy)
        if not _exists(file):
            results = (path for path in folder.iterdir() if _read_marker(path) is not None)
            if first := min(results, default=None):
                hint = f"it holds results: name one of them, such as {first}"
            raise OutputError(f"{folder} is no result of drysim: it has no {MARKER}", hint)
        if parts := _finished_parts(folder):
            hint = _resume_hint(parts)
        if not file.is_file():  # a pipe may never end
            raise OutputError(f"{file} is not a plain file", hint)
        fields = json.loads(file.read_text(encoding="utf-8"), parse_constant=_no_number)
    except OSError as fault:
        if isinstance(fault, FileNotFoundError) and (parts := resumable_parts(folder)):
            sentence = f"{folder} is not finished: its parts are in {folder}.partial"
            raise OutputError(sentence, _resume_hint(parts)) from fault
        backup = sibling(resolve_name(folder), "replaced")
        if isinstance(fault, FileNotFoundError) and _read_marker(backup) is not None:
            sentence = f"{folder} was about to be replaced when its command was killed"
            hint = f"the earlier result is in {folder}.replaced; compute it again"
            raise OutputError(sentence, hint) from fault
        reason = (fault.strerror or str(fault)).lower()
        raise OutputError(f"cannot read {folder}: {reason}", hint) from fault
    except (ValueError, RecursionError) as fault:
        place = ""
        if isinstance(fault, json.JSONDecodeError):
            place = f" from line {fault.lineno}, column {fault.colno} on"
        raise OutputError(
            f"{file} is damaged: it is not valid JSON{place}", AGAIN_HINT
        ) from fault
    if not isinstance(fields, dict) or not FIELD_TYPES.keys() <= fields.keys():
        raise OutputError(f"{file} has no finished result", hint)
    version = fields.get("format")
    if isinstance(version, int) and version != FORMAT_VERSION:
        age, what_to_do = (
            ("an earlier", "repeat its command; scenario.yaml holds the scenario")
            if version < FORMAT_VERSION
            else ("a later", "update drysim")
        )
        raise OutputError(
            f"{file} was written by {age} version of drysim: it has format {version}, and this "
            f"version reads format {FORMAT_VERSION}",
            what_to_do,
        )
    for name, kinds in FIELD_TYPES.items():
        if not isinstance(fields[name], kinds):
            value = shorten(json.dumps(fields[name]), 40)
            what = f"{name} is {value}, which is not {TYPE_NAMES[kinds]}"
            raise OutputError(f"{file} is damaged: {what}", AGAIN_HINT)
    return fields


def _resume_hint(parts: Sequence[str]) -> str:
    """Return how to finish work that left these parts."""
    return f"finish it with its command and --resume, `drysim {STORES[parts[0]]} ... --resume`"


@contextmanager
def translate_damage(folder: Path, fields: Mapping[str, Any]) -> Iterator[None]:
    """Turn what values of a wrong type or size raise into an error of drysim.json.

    Raises
    ------
    OutputError
        In place of an exception of the block.
    """
    try:
        yield
    except DAMAGE as fault:
        sentence = f"{folder / MARKER} is damaged: {describe_damage(fault, fields)}"
        raise OutputError(sentence, AGAIN_HINT) from fault


def describe_damage(fault: Exception, fields: Mapping[str, Any]) -> str:
    """Describe what is wrong with a value of drysim.json, with its place if that is known."""
    from pydantic import ValidationError

    if not isinstance(fault, ValidationError):
        return "a value is missing, or is not as drysim writes it"
    first = fault.errors(include_url=False)[0]
    path, value = list(first["loc"]), first["input"]
    if fault.title == Summary.__name__:
        path.insert(0, "summary")
    if first["type"] == "missing":
        return f"{'.'.join(map(str, path))} is missing"
    while path and not _has_path(fields, path):
        path.pop()  # the type that was tried last
    place = ".".join(map(str, path))
    return f"{place} is {format_value(value)}, which drysim does not write there"


def _has_path(value: Any, path: Sequence[str | int]) -> bool:
    """Whether a tree of JSON has a value under these keys and indices."""
    try:
        for step in path:
            value = value[step]
    except (LookupError, TypeError):
        return False
    return True


def _no_number(word: str) -> None:
    """Refuse NaN and Infinity, which are not JSON."""
    raise ValueError(word)


def add_report(folder: Path, page: str, fields: dict[str, Any]) -> None:
    """Write the report of a finished result into its folder.

    `fields` are those of drysim.json from which the report was made.

    Raises
    ------
    OutputError
        As of `check_report`, and when another result has taken the place of this one.
    """
    with translate_os_errors(folder), exclusive_lock(folder, folder):
        check_report_place(folder)
        if read_stored_fields(folder) != fields:
            raise OutputError(
                f"{folder} was replaced by another result while its report was written",
                "repeat the command",
            )
        write_report(folder, page, fields)


def check_report(file: Path, folder: Path) -> None:
    """Verify, before any work, that a report may be written; `folder` is that of the result.

    Raises
    ------
    OutputError
        When the file is no report of drysim, or cannot be written.
    """
    if file.absolute() != (folder / REPORT_FILE).absolute():
        check_new_file(file, [folder], GENERATOR, "--out")
        return
    with translate_os_errors(file):
        check_report_place(folder)
        if not os.access(folder, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


def check_new_file(file: Path, folders: Sequence[Path], mark: str, option: str) -> None:
    """Verify, before any work, that a file outside of the folders of results may be written.

    Parameters
    ----------
    file : Path
    folders : sequence of Path
        Output folders, in which it must not lie.
    mark : str
        What its first lines contain if drysim wrote it, so that it may be replaced.
    option : str
        The option that names it.

    Raises
    ------
    OutputError
        When it is another file, or cannot be written.
    """
    with translate_os_errors(file):
        if file.is_dir():
            raise OutputError(f"{file} is a folder", f"name a file with {option}")
        for folder in folders:
            if folder.resolve() in file.resolve().parents:
                sentence = f"{file} would be a file in {folder} that is not part of the result"
                raise OutputError(sentence, f"choose another folder with {option}")
        if _exists(file) and not (file.is_file() and has_mark(file, mark)):
            sentence = f"{file} was not written by drysim; it stays as it is"
            raise OutputError(sentence, f"choose another file with {option}")
        parent = _existing_parent(file)
        if not parent.is_dir():
            raise OutputError(
                f"cannot write {file}: {parent} is not a folder", f"name another with {option}"
            )
        if not os.access(parent, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


def check_report_place(folder: Path) -> None:
    """Raise OutputError if the folder of a result has a report that drysim did not write.

    Other files of the user may lie there: a report replaces none of them.
    """
    if folder.is_symlink():
        raise OutputError(f"{folder} is a symbolic link", "name the folder itself")
    if _exists(folder / REPORT_FILE) and REPORT_FILE not in _listed_files(_read_marker(folder)):
        sentence = f"{folder} holds {REPORT_FILE}, which drysim did not write"
        raise OutputError(sentence, "move it away, or choose another file with --out")


def has_mark(file: Path, mark: str) -> bool:
    """Whether the first lines of a file contain the mark of drysim."""
    with file.open("rb") as stream:
        return mark.encode() in stream.read(1000)


def save_file(file: Path, text: str) -> None:
    """Write a file outside of a result, atomically, and the folders above it."""
    # The name is unique: a draft that a kill left behind is in nobody's way.
    draft = file.with_name(f"{file.name}.{token_hex(8)}.new")
    with translate_os_errors(file):
        file.parent.mkdir(parents=True, exist_ok=True)
        try:
            draft.write_bytes(text.encode())
            replace(draft, file)
        except BaseException:
            draft.unlink(missing_ok=True)
            raise


def _listed_files(marker: dict[str, Any] | None) -> set[str]:
    """Return the files that a marker lists."""
    files = marker.get("files") if marker else None
    return set(files if isinstance(files, dict) else ())


def _files_within(folder: Path) -> Iterator[str]:
    """Yield the files in a folder of a result, as relative paths."""
    for path in folder.rglob("*"):
        if not path.is_dir() and not IGNORED_FILES.fullmatch(path.name):
            yield path.relative_to(folder).as_posix()


def _is_edited(file: Path, marker: dict[str, Any]) -> bool:
    """Whether the scenario of a result was edited since drysim wrote it."""
    files = marker.get("files")
    written = files.get(file.name) if isinstance(files, dict) else None
    return written is not None and file.is_file() and str(written) != file_sha256(file)


def _existing_parent(target: Path) -> Path:
    """Return the nearest existing folder above a path."""
    parent = target.absolute().parent
    while not _exists(parent):
        parent = parent.parent
    return parent


def _exists(path: Path) -> bool:
    """Whether a path exists; a dangling symbolic link does."""
    try:
        os.lstat(path)
    except (FileNotFoundError, NotADirectoryError):
        return False
    except ValueError:
        raise OutputError(
            f"{str(path)!r} cannot be the name of a folder", OTHER_FOLDER_HINT
        ) from None
    return True


# Atomic replacement, locks, and recovery after a kill.


def replace_folder(partial: Path, target: Path, backup: Path) -> None:
    """Replace an old folder by a new one, and remove the old one."""
    if target.exists() and not any(target.iterdir()):
        target.rmdir()
    if not target.exists():
        replace(partial, target)
        flush_to_disk(target.parent)
        return
    with exclusive_lock(target, target):
        # A kill between these two leaves the old folder as `backup`: see recover().
        replace(target, backup)
        try:
            replace(partial, target)
        except OSError:
            replace(backup, target)
            raise
        flush_to_disk(target.parent)
        remove_folder(backup)


def recover(target: Path, backup: Path) -> None:
    """Complete a replacement that a kill interrupted between two renames."""
    if backup.exists() and target.exists():
        remove_folder(backup)
    elif backup.exists():
        replace(backup, target)


@contextmanager
def exclusive_lock(target: Path, folder: Path) -> Iterator[None]:
    """Lock a folder against other processes; the lock ends with the process, even if killed.

    Raises
    ------
    OutputError
        When another process holds the lock, or has replaced the folder.
    """
    try:
        with lock_folder(target):
            yield
    except BlockingIOError:
        raise OutputError(
            f"another drysim process is writing {folder}",
            f"wait for it, or {OTHER_FOLDER_HINT}",
        ) from None


def remove_contents(folder: Path, keep: Collection[str] = ()) -> None:
    """Remove the contents of a folder, the marker last, so that the rest stays recognised."""
    for path in (folder, *folder.rglob("*")):
        if path.is_dir() and not path.is_symlink():
            path.chmod(path.stat().st_mode | stat.S_IRWXU)  # a read-only folder keeps its files
    for path in sorted(folder.iterdir(), key=lambda path: path.name == MARKER):
        if path.name in keep:
            continue
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()


def remove_folder(folder: Path) -> None:
    """Remove a folder as far as possible; the next run removes the rest."""
    with suppress(OSError):
        remove_contents(folder)
    with suppress(OSError):
        folder.rmdir()  # works for an empty folder even if no more files can be opened


def note_on_files(folder: Path, fields: dict[str, Any]) -> Note:
    """Return whether the files of a result and its drysim.json are as drysim wrote them.

    The report is left out: `drysim report` replaces it.
    """
    files = {name: sha for name, sha in fields["files"].items() if name != REPORT_FILE}
    hashes = {name: sha256_of(folder / name) for name in files}
    lost = [name for name, sha in hashes.items() if not sha]
    modified = [name for name, sha in hashes.items() if sha and sha != files[name]]
    modified += [] if is_intact(fields) else [MARKER]
    states = {"Changed since drysim wrote them": modified, "Missing or unreadable": lost}
    if parts := [f"{state}: {', '.join(names)}." for state, names in states.items() if names]:
        return Note("files", " ".join(parts), BAD)
    count = format_count(len(files), "file")
    return Note("files", f"All {count} of the result are as drysim wrote them.")


def sha256_of(file: Path) -> str:
    """Return the SHA-256 of a file, empty if it cannot be read."""
    with suppress(NotARegularFile, OSError):
        return file_sha256(file)
    return ""
