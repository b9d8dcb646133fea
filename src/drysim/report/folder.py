"""The output folder: it appears complete or not at all, by one rename of `<name>.partial`.

Knows no file but the sidecar, which names and hashes all others.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from drysim.errors import EXIT_INTERRUPTED
from drysim.report.claim import (
    CASES,
    DRAFT,
    JOURNAL,
    MARKER,
    RESULTS,
    beside,
    check,
    named,
    refuse_foreign,
    sentences,
    strangers,
)
from drysim.report.sidecar import Ending, text
from drysim.report.swap import alone, empty, recover, swap, sync
from drysim.study.identity import removed

Made = TypeVar("Made")


class Claim(NamedTuple):
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
        return self.partial / CASES


@contextmanager
def claim_partial(folder: Path, resume: bool = False) -> Iterator[Claim]:
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
    check(folder)
    with sentences(folder):
        place = named(folder)
        partial = beside(place, "partial")
        partial.mkdir(parents=True, exist_ok=True)
        try:
            with alone(partial, folder):
                yield from _held(folder, place, partial, resume)
        except OSError:
            with suppress(OSError):
                partial.rmdir()  # an empty one, even where no more files can be opened
            raise


def _held(folder: Path, place: Path, partial: Path, resume: bool) -> Iterator[Claim]:
    """Mark `<name>.partial` as ours and give it; when that fails, leave what can be resumed.

    Some files are held open for the time after a failure: to remove a folder, it is opened.
    """
    with ExitStack() as spare:
        try:
            for end in (*os.pipe(), *os.pipe()):  # each is as good as a file held open
                spare.callback(os.close, end)
            recover(place, beside(place, "replaced"))
            # Without its marker the journal would be a stranger to the next drysim.
            empty(partial, {CASES, JOURNAL, MARKER} if resume else set())
            mark(partial, '{"format": 1, "complete": false}\n')
            yield Claim(folder, partial, partial.stat())
        except BaseException as fault:
            spare.close()
            gone = isinstance(fault, FileNotFoundError) and not partial.exists()
            leave(partial)
            if gone:
                raise removed(partial) from fault
            raise


def finish(claim: Claim) -> None:
    """Put `<name>.partial` in the place of the output folder, without its finished cases."""
    place = named(claim.folder)
    require(claim)
    kept = [path for path in claim.partial.iterdir() if path.name not in (JOURNAL, CASES)]
    for path in [*kept, claim.partial]:
        sync(path)
    claim.journal.unlink(missing_ok=True)
    if not any(path.startswith(f"{CASES}/") for path in strangers(claim.partial)):
        shutil.rmtree(claim.cases, ignore_errors=True)
    swap(claim.partial, place, beside(place, "replaced"))


def leave(partial: Path) -> None:
    """Leave `<name>.partial` for a later time, or remove it when it holds no finished case."""
    with suppress(OSError):
        if not _resumable(partial) and not strangers(partial):
            empty(partial)
            partial.rmdir()


def require(claim: Claim) -> None:
    """Make sure that `<name>.partial` is still the folder that we hold.

    Raises
    ------
    OutputError
        When somebody has removed it, or has put another in its place.
    """
    try:
        same = os.path.samestat(claim.partial.stat(), claim.held)
    except FileNotFoundError:
        same = False
    if not same:
        raise removed(claim.partial)


def mark(folder: Path, text: str) -> None:
    """Give a folder its drysim.json, in one piece or not at all.

    It is on the disk before it has its name: without it, after a power cut, the folder would be
    a stranger to the next drysim.
    """
    (folder / DRAFT).write_text(text, encoding="utf-8", newline="\n")
    sync(folder / DRAFT)
    os.replace(folder / DRAFT, folder / MARKER)


def holds_sweep(folder: Path) -> bool:
    """Tell whether an output folder holds the table of a sweep."""
    return any(
        (folder / name).exists() for name in ("transmissibility.csv", "transmissibility")
    )


def resumable(folder: Path) -> bool:
    """Tell whether an interrupted sweep has left finished cases beside an output folder."""
    return _resumable(beside(named(folder), "partial"))


def _resumable(partial: Path) -> bool:
    """Whether a folder holds finished cases."""
    if any(file.stat().st_size for file in (partial / CASES).glob("*.cases")):
        return True
    try:
        with (partial / JOURNAL).open("rb") as lines:
            return len(list(islice(lines, 2))) == 2
    except OSError:
        return False


def put(
    made: Made,
    folder: Path | Claim,
    writers: Sequence[Callable[[Made, Path], None]],
    tell: Callable[[Made, Ending], dict[str, Any]],
    command: str,
    exit_code: int,
) -> dict[str, Any]:
    """Let all writers write, tell what made their files, and put the folder in its place."""
    held = nullcontext(folder) if isinstance(folder, Claim) else claim_partial(folder)
    with held as claim:
        require(claim)
        refuse_foreign(named(claim.folder))  # what somebody has put there meanwhile stays
        for writer in writers:
            writer(made, claim.partial)
        files = {
            path.relative_to(claim.partial).as_posix(): _sha256(path)
            for path in written(claim.partial)
        }
        told = tell(made, Ending(command, exit_code, files))
        mark(claim.partial, text(told))
        if exit_code == EXIT_INTERRUPTED:
            leave(claim.partial)
        else:
            finish(claim)
    return told


def written(partial: Path) -> list[Path]:
    """Give every file of a result, those in folders of its own included."""
    every = (path for path in partial.rglob("*") if path.is_file())
    return sorted(
        path for path in every if RESULTS.fullmatch(path.relative_to(partial).as_posix())
    )


def _sha256(file: Path) -> str:
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
