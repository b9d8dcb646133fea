"""The output folder: it appears complete or not at all, by one rename of `<name>.partial`.

Knows no file but the sidecar, which names and hashes all others.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from drysim.errors import EXIT_INTERRUPTED
from drysim.report.claim import CASES, DRAFT, JOURNAL, MARKER, beside, check, named, sentences
from drysim.report.sidecar import Ending, text
from drysim.report.swap import alone, empty, recover, remove, swap, sync

Made = TypeVar("Made")


class Claim(NamedTuple):
    """Our hold on an output folder: its name, and `<name>.partial`, where the work is done."""

    folder: Path
    partial: Path

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
        with alone(partial, folder):
            try:
                recover(place, beside(place, "replaced"))
                # Without its marker the journal would be a stranger to the next drysim.
                empty(partial, {CASES, JOURNAL, MARKER} if resume else set())
                mark(partial, '{"format": 1, "complete": false}\n')
                yield Claim(folder, partial)
            except BaseException:
                if not _resumable(partial):
                    remove(partial)
                raise


def finish(claim: Claim) -> None:
    """Put `<name>.partial` in the place of the output folder, without its finished cases."""
    place = named(claim.folder)
    kept = [path for path in claim.partial.iterdir() if path.name not in (JOURNAL, CASES)]
    for path in [*kept, claim.partial]:
        sync(path)
    claim.journal.unlink(missing_ok=True)
    shutil.rmtree(claim.cases, ignore_errors=True)
    swap(claim.partial, place, beside(place, "replaced"))


def leave(claim: Claim) -> None:
    """Leave `<name>.partial` for a later time, or remove it when it holds no finished case."""
    if not _resumable(claim.partial):
        remove(claim.partial)


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
    if any((partial / CASES).glob("*.cases")):
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
        for writer in writers:
            writer(made, claim.partial)
        files = {
            path.relative_to(claim.partial).as_posix(): _sha256(path)
            for path in written(claim.partial)
        }
        told = tell(made, Ending(command, exit_code, files))
        mark(claim.partial, text(told))
        (leave if exit_code == EXIT_INTERRUPTED else finish)(claim)
    return told


def written(partial: Path) -> list[Path]:
    """Give every file of a result, those in folders of its own included."""
    inner = (path for path in partial.iterdir() if path.name not in (CASES, JOURNAL, MARKER))
    files = (path.rglob("*") if path.is_dir() else [path] for path in inner)
    return sorted(path for found in files for path in found if path.is_file())


def _sha256(file: Path) -> str:
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
