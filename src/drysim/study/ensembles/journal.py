"""Journal: the finished seeds of a run under way, so that a kill loses none of them."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TextIO

from drysim import regular
from drysim.study.identity import digest_of, of_another, removed
from drysim.study.sweeps.table import Row

if TYPE_CHECKING:
    from types import TracebackType


class Journal:
    """A file whose first line says what is run, and every other line is a finished seed.

    The line of a seed begins with a checksum of itself and of what is run: one that a kill has
    cut short, that was changed or is of another run, is passed over. Numbers are written so
    that they read back as they were: a run that goes on gives the very ensemble of one that
    was never interrupted.
    Not to be confused with `Store`, which keeps blocks of the cases of a sweep.
    """

    def __init__(self, file: Path, what: Mapping[str, Any], resume: bool) -> None:
        self.file = file
        self.what = dict(what)
        self.run = digest_of(self.what)
        self.done: dict[int, Row] = {}
        if resume and _is_there(file):
            self.done = self._read()
        lines = [entry(number, row, self.run) for number, row in self.done.items()]
        fresh = self.file.with_suffix(".new")
        fresh.write_text(json.dumps(self.what) + "\n" + "".join(lines), encoding="utf-8")
        with suppress(OSError):
            self.file.rmdir()  # an empty folder in its place is nothing to keep
        fresh.replace(self.file)
        self._stream: TextIO | None = None

    def __enter__(self) -> Self:
        """Open the file for more lines."""
        self._stream = self.file.open("a", encoding="utf-8")
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the file; what is in it stays."""
        if self._stream is not None:
            self._stream.close()

    def add(self, number: int, row: Row) -> None:
        """Write a finished seed.

        Raises
        ------
        OutputError
            When the file is there no more.
        """
        assert self._stream is not None, "a journal is written within its context"
        self._stream.write(entry(number, row, self.run))
        self._stream.flush()
        if not os.fstat(self._stream.fileno()).st_nlink:
            raise removed(self.file.parent)
        self.done[number] = row

    def _read(self) -> dict[int, Row]:
        """Give the finished seeds of the same run."""
        lines = self.file.read_text(encoding="utf-8", errors="replace").splitlines()
        if whole(lines[0] if lines else "") != self.what:
            raise of_another(self.file.parent)
        seeds = (finished(line, self.run) for line in lines[1:])
        return dict(seed for seed in seeds if seed is not None)


def entry(number: int, row: Row, run: str) -> str:
    """Give the line of a seed, by its number from 0, in the journal of a run."""
    # Not asdict(), which copies every value of every metric one by one.
    words = json.dumps({"number": number, "row": vars(row)})
    return f"{checksum(words, run)} {words}\n"


def checksum(words: str, run: str) -> str:
    """Return what tells whether words were changed, or are those of another run (hex)."""
    return hashlib.sha256(f"{run} {words}".encode()).hexdigest()[:16]


def whole(line: str) -> Any:
    """Give what a line says, or None where it was cut short or is none of ours."""
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None


def finished(line: str, run: str) -> tuple[int, Row] | None:
    """Give number and row of the seed of a line, or None where there is none of this run."""
    seal, _, words = line.partition(" ")
    if seal != checksum(words, run):
        return None
    try:
        said = whole(words)
        return int(said["number"]), Row(**said["row"])
    except (KeyError, TypeError, ValueError):
        return None


def _is_there(file: Path) -> bool:
    """Whether there is a journal; a device or a pipe in its place is none."""
    try:
        return regular.size(file) > 0
    except (OSError, regular.Irregular):
        return False
