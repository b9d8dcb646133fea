"""What is finished of a sweep or a run under way, on disk, so that a kill loses none of it.

`Store` keeps blocks of the cases of a sweep, `Journal` the seeds of a run. Both begin with
what they belong to, so that work goes on with its own parts alone: those of another scenario,
record or drysim are refused. Whatever a kill has cut short is passed over, and every number
reads back to its last bit.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import zlib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple, Self, TextIO
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

import drysim
from drysim import system
from drysim.core.compile import source_digest
from drysim.errors import OutputError, UsageError
from drysim.scenario.axes import columns_of
from drysim.scenario.model import Scenario
from drysim.scenario.sampling import Lazy
from drysim.study.case import hashes_of
from drysim.study.plan import Piece
from drysim.study.statistics import NAMES, Batch, OverSeeds, Row

# The finished blocks of a sweep under way.

WHAT = "sweep.json"
"""What is swept, so that blocks of another sweep are not taken for its own."""

CASES = ".cases"
"""What the name of a file with blocks ends with."""

FULL = 1 << 26
"""Size of a file from which on the next block begins another one [B]."""

LONGEST_LINE = 1 << 26
"""Bytes of the first line of a block at most: the notes and seeds of 4096 cases take 1e7."""


class Place(NamedTuple):
    """Where a block lies."""

    file: Path
    begin: int
    size: int


class Store:
    """A folder with files of finished blocks of cases.

    A block is appended to a file as soon as it is finished. A process writes to files of its
    own alone, so that whatever a kill has cut short stays at the end of a file, where it is
    passed over. Every number is held to its last bit: a sweep that goes on gives the very table
    of one that was never interrupted. Blocks may come in any order and from any machine.
    """

    def __init__(self, folder: Path, what: Mapping[str, Any], resume: bool) -> None:
        self.folder = folder
        self.sweep = digest_of(what)
        self._places: dict[int, Place] = {}
        self._file, self._end, self._files = folder, FULL, 0
        self._lock = Lock()
        # Links and devices that somebody put there are nothing to go on with.
        if resume and not folder.is_symlink() and (folder / WHAT).is_file():
            if self._what() != dict(what):
                raise of_another(folder.parent)
            files = sorted(folder.glob(f"*{CASES}"))
            for file in files:  # the latest last, whose blocks count
                self._find(file)
            self._files = len(files)
            return
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        draft = (folder / WHAT).with_suffix(".new")
        draft.write_text(json.dumps(dict(what)) + "\n", encoding="utf-8")
        draft.replace(folder / WHAT)

    def write(self, piece: Piece, batch: Batch) -> None:
        """Keep the cases of a piece."""
        self.keep(piece, packed(batch, self.sweep))

    def keep(self, piece: Piece, words: bytes) -> None:
        """Keep the cases of a piece, packed already.

        Raises
        ------
        OutputError
            When the folder, or the file in it, is there no more.
        """
        with self._lock:
            place = Place(self._file, self._end, len(words))
            if fresh := self._end >= FULL:
                name = f"{self._files:06d}-{uuid4().hex[:12]}{CASES}"  # nobody else's
                place = Place(self.folder / name, 0, len(words))
            try:
                with place.file.open("xb" if fresh else "r+b") as stream:
                    stream.seek(place.begin)
                    stream.write(words)
            except FileNotFoundError:
                raise system.removed(self.folder.parent) from None
            except BaseException:
                with suppress(OSError):  # what is cut short takes room on a full disk
                    os.truncate(place.file, place.begin)
                raise
            self._file, self._end = place.file, place.begin + place.size
            self._files += fresh
            self._places[piece.first] = place

    def read(self, piece: Piece) -> Batch | None:
        """Give the cases of a piece; None where they are still to be computed."""
        try:
            file, begin, size = self._places[piece.first]
            with file.open("rb") as stream:
                stream.seek(begin)
                return unpacked(stream.read(size), piece, self.sweep)
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def holds(self, piece: Piece) -> bool:
        """Tell whether the cases of a piece are kept, with all their bytes."""
        return piece.first in self._places

    def _find(self, file: Path) -> None:
        """Note the blocks of a file, up to the first that is cut short."""
        with suppress(OSError, ValueError, system.Irregular), system.opened(file) as stream:
            size, begin = os.fstat(stream.fileno()).st_size, 0
            while head := heading(stream.readline(LONGEST_LINE)):
                end = begin + head.size
                if end > size:
                    return
                if head.sweep == self.sweep:
                    self._places[head.first] = Place(file, begin, head.size)
                begin = stream.seek(end)

    def _what(self) -> Any:
        try:
            return json.loads((self.folder / WHAT).read_text(encoding="utf-8"))
        except ValueError:
            return None


class Stored(Lazy[Batch]):
    """The blocks of a store, read when they are asked for."""

    def __init__(self, store: Store, kept: Sequence[Piece]) -> None:
        self._store = store
        self._kept = kept

    def __len__(self) -> int:
        """Give the number of blocks."""
        return len(self._kept)

    def one(self, number: int) -> Batch:
        """Read one block."""
        batch = self._store.read(self._kept[number])
        if batch is None:
            raise OutputError(
                f"{self._store.folder} lost cases that were kept there",
                "let nothing else write there, and run the command again with --resume",
            )
        return batch


# A block of cases as bytes, the same on the disk and on the way between machines.

FORCES = ("F_fk", "F_fs")

CHECKSUM = 4
"""Bytes at the end of a block: the CRC-32 of all before them."""


def packed(batch: Batch, sweep: str) -> bytes:
    """Give a block of cases as bytes: a line of JSON, statuses, columns of doubles, checksum.

    Every number is kept to its last bit; a column of one value alone is a number in the line.
    The points are left out: they follow from the number of the first case. That number and the
    digest of the sweep are in the line, so a block is never taken for another one.
    """
    columns = {"F_fk": batch.F_fk, "F_fs": batch.F_fs, **batch.metrics}
    own = {name: np.ascontiguousarray(columns[name], "<f8") for name in (*FORCES, *NAMES)}
    same = {name: column[0].item() for name, column in own.items() if _is_one_value(column)}
    rest = [column.data for name, column in own.items() if name not in same]
    body: list[Any] = [np.ascontiguousarray(batch.status).data, *rest]
    head = {
        "sweep": sweep,
        "first": batch.first,
        "cases": len(batch),
        "bytes": sum(part.nbytes for part in body),
        "columns": [name for name in own if name not in same],
        "same": same,
        "notes": {str(i): note for i, note in batch.notes.items()},
        "over": {str(i): vars(over) for i, over in batch.over.items()},
    }
    parts = [json.dumps(head).encode() + b"\n", *body]
    return b"".join([*parts, _checksum(parts)])


def unpacked(words: bytes, piece: Piece, sweep: str) -> Batch:
    """Give the cases of a piece from their bytes.

    Raises
    ------
    ValueError, KeyError, TypeError
        When the bytes are not those of a whole block, or are those of another one.
    """
    whole = memoryview(words)[:-CHECKSUM]
    if words[-CHECKSUM:] != _checksum([whole]):
        raise ValueError("the block was cut short or spoiled")
    end = words.index(b"\n")
    head, rest = json.loads(words[:end]), whole[end + 1 :]
    n, names = head["cases"], head["columns"]
    if (head["sweep"], head["first"], n) != (sweep, piece.first, piece.end - piece.begin):
        raise ValueError("the block is that of another place")
    status = np.frombuffer(rest, np.int8, n)
    numbers = np.frombuffer(rest, "<f8", n * len(names), n).reshape(len(names), n)
    known: dict[str, Any] = dict(zip(names, numbers, strict=True))
    known |= {name: np.full(n, value) for name, value in head["same"].items()}
    points = columns_of(piece.scenario.sweep, piece.begin, piece.end)
    metrics = {name: known[name] for name in NAMES}
    notes = {int(i): note for i, note in head["notes"].items()}
    over = {int(i): OverSeeds(**said) for i, said in head["over"].items()}
    F_fk, F_fs = (known[force] for force in FORCES)
    word = piece.scenario.word
    return Batch(piece.first, word, points, F_fk, F_fs, metrics, status, notes, over)


class Heading(NamedTuple):
    """What the first line of a block says: of which sweep and case, and its size [B]."""

    sweep: str
    first: int
    size: int


def heading(line: bytes) -> Heading | None:
    """Read the first line of a block; None where it is not one."""
    try:
        head = json.loads(line)
        first, size = int(head["first"]), int(head["bytes"])
        return Heading(head["sweep"], first, len(line) + size + CHECKSUM) if size >= 0 else None
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError):
        return None


def _checksum(parts: Iterable[bytes | memoryview]) -> bytes:
    """Give what tells whether a byte was lost or changed."""
    total = 0
    for part in parts:
        total = zlib.crc32(part, total)
    return total.to_bytes(CHECKSUM, "little")


def _is_one_value(column: NDArray[np.float64]) -> bool:
    """Tell whether all numbers of a column are alike in every bit."""
    bits = column.view(np.int64)
    return bool((bits == bits[:1]).all()) and bits.size > 0


# The finished seeds of a run under way.


class Journal:
    """A file whose first line says what is run, and every other line is a finished seed.

    The line of a seed begins with a checksum of itself and of what is run: one that a kill has
    cut short, that was changed or is of another run, is passed over. Numbers are written so
    that they read back as they were: a run that goes on gives the very ensemble of one that
    was never interrupted.
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

    def __exit__(self, *fault: object) -> None:
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
            raise system.removed(self.file.parent)
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
        return system.size(file) > 0
    except (OSError, system.Irregular):
        return False


# What makes two pieces of work one, so that one may go on with what another has left.


def identity(scenario: Scenario) -> dict[str, Any]:
    """Give what makes it one: all words of the scenario, its files, and drysim."""
    words = json.dumps(scenario.resolved(), sort_keys=True)
    digest = hashlib.sha256(words.encode()).hexdigest()
    own = {"drysim": drysim.__version__, "core": source_digest()}
    return own | {"scenario": digest, "files": hashes_of(scenario)}


def digest_of(what: Mapping[str, Any]) -> str:
    """Return what makes it one in short (hex): each finished part of the work bears it."""
    return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:32]


def of_another(folder: Path) -> UsageError:
    """Give the error for finished cases that are none of this sweep."""
    return UsageError(
        f"{folder} holds cases of another sweep, another record or another drysim",
        "run the command without --resume to begin anew",
    )
