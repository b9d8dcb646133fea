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
from drysim.scenario.axes import point_columns
from drysim.scenario.model import Scenario
from drysim.scenario.sampling import LazySequence
from drysim.study.case import file_hashes
from drysim.study.plan import CaseRange
from drysim.study.statistics import METRIC_NAMES, Batch, OverSeeds, Row

# Finished ranges of a sweep in progress.

IDENTITY_FILE = "sweep.json"
"""What is swept, so that blocks of another sweep are not taken for its own."""

CASES_SUFFIX = ".cases"
"""What the name of a file with blocks ends with."""

MAX_FILE_BYTES = 1 << 26
"""Size of a file from which on the next block begins another one [B]."""

MAX_HEADER_BYTES = 1 << 26
"""Bytes of the first line of a block at most: the notes and seeds of 4096 cases take 1e7."""


class Location(NamedTuple):
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

    def __init__(self, folder: Path, identity: Mapping[str, Any], resume: bool) -> None:
        self.folder = folder
        self.sweep = identity_digest(identity)
        self._locations: dict[int, Location] = {}
        self._file, self._end, self._files = folder, MAX_FILE_BYTES, 0
        self._lock = Lock()
        # Links and special files are never resumed from.
        if resume and not folder.is_symlink() and (folder / IDENTITY_FILE).is_file():
            if self._read_identity() != dict(identity):
                raise other_work_error(folder.parent)
            files = sorted(folder.glob(f"*{CASES_SUFFIX}"))
            for file in files:  # in order of creation: the latest block counts
                self._index_file(file)
            self._files = len(files)
            return
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        draft = (folder / IDENTITY_FILE).with_suffix(".new")
        draft.write_text(json.dumps(dict(identity)) + "\n", encoding="utf-8")
        draft.replace(folder / IDENTITY_FILE)

    def write(self, case_range: CaseRange, batch: Batch) -> None:
        """Keep the cases of a piece."""
        self.write_packed(case_range, pack(batch, self.sweep))

    def write_packed(self, case_range: CaseRange, content: bytes) -> None:
        """Keep the cases of a piece, packed already.

        Raises
        ------
        OutputError
            When the folder, or the file in it, is there no more.
        """
        with self._lock:
            location = Location(self._file, self._end, len(content))
            if fresh := self._end >= MAX_FILE_BYTES:
                name = f"{self._files:06d}-{uuid4().hex[:12]}{CASES_SUFFIX}"  # unique among processes
                location = Location(self.folder / name, 0, len(content))
            try:
                with location.file.open("xb" if fresh else "r+b") as stream:
                    stream.seek(location.begin)
                    stream.write(content)
            except FileNotFoundError:
                raise system.removed_error(self.folder.parent) from None
            except BaseException:
                with suppress(OSError):  # free the disk space of the incomplete block
                    os.truncate(location.file, location.begin)
                raise
            self._file, self._end = location.file, location.begin + location.size
            self._files += fresh
            self._locations[case_range.first] = location

    def read(self, case_range: CaseRange) -> Batch | None:
        """Give the cases of a piece; None where they are still to be computed."""
        try:
            file, begin, size = self._locations[case_range.first]
            with file.open("rb") as stream:
                stream.seek(begin)
                return unpack(stream.read(size), case_range, self.sweep)
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def has(self, case_range: CaseRange) -> bool:
        """Tell whether the cases of a piece are kept, with all their bytes."""
        return case_range.first in self._locations

    def _index_file(self, file: Path) -> None:
        """Note the blocks of a file, up to the first that is cut short."""
        with (
            suppress(OSError, ValueError, system.NotARegularFile),
            system.open_regular_file(file) as stream,
        ):
            size, begin = os.fstat(stream.fileno()).st_size, 0
            while header := parse_header(stream.readline(MAX_HEADER_BYTES)):
                end = begin + header.size
                if end > size:
                    return
                if header.sweep == self.sweep:
                    self._locations[header.first] = Location(file, begin, header.size)
                begin = stream.seek(end)

    def _read_identity(self) -> Any:
        try:
            return json.loads((self.folder / IDENTITY_FILE).read_text(encoding="utf-8"))
        except ValueError:
            return None


class StoredBatches(LazySequence[Batch]):
    """The blocks of a store, read when they are asked for."""

    def __init__(self, store: Store, ranges: Sequence[CaseRange]) -> None:
        self._store = store
        self._ranges = ranges

    def __len__(self) -> int:
        """Give the number of blocks."""
        return len(self._ranges)

    def one(self, number: int) -> Batch:
        """Read one block."""
        batch = self._store.read(self._ranges[number])
        if batch is None:
            raise OutputError(
                f"{self._store.folder} lost cases that were kept there",
                "let nothing else write there, and run the command again with --resume",
            )
        return batch


# Binary format of a batch, on disk and between machines.

FORCE_COLUMNS = ("F_fk", "F_fs")

CHECKSUM = 4
"""Bytes at the end of a block: the CRC-32 of all before them."""


def pack(batch: Batch, sweep: str) -> bytes:
    """Give a block of cases as bytes: a line of JSON, statuses, columns of doubles, checksum.

    Every number is kept to its last bit; a column of one value alone is a number in the line.
    The points are left out: they follow from the number of the first case. That number and the
    digest of the sweep are in the line, so a block is never taken for another one.
    """
    columns = {"F_fk": batch.F_fk, "F_fs": batch.F_fs, **batch.metrics}
    own = {
        name: np.ascontiguousarray(columns[name], "<f8")
        for name in (*FORCE_COLUMNS, *METRIC_NAMES)
    }
    same = {name: column[0].item() for name, column in own.items() if _is_constant(column)}
    rest = [column.data for name, column in own.items() if name not in same]
    body: list[Any] = [np.ascontiguousarray(batch.status).data, *rest]
    header = {
        "sweep": sweep,
        "first": batch.first,
        "cases": len(batch),
        "bytes": sum(part.nbytes for part in body),
        "columns": [name for name in own if name not in same],
        "same": same,
        "notes": {str(i): note for i, note in batch.notes.items()},
        "over": {str(i): vars(over) for i, over in batch.over.items()},
    }
    parts = [json.dumps(header).encode() + b"\n", *body]
    return b"".join([*parts, _checksum(parts)])


def unpack(content: bytes, case_range: CaseRange, sweep: str) -> Batch:
    """Give the cases of a piece from their bytes.

    Raises
    ------
    ValueError, KeyError, TypeError
        When the bytes are not those of a whole block, or are those of another one.
    """
    whole = memoryview(content)[:-CHECKSUM]
    if content[-CHECKSUM:] != _checksum([whole]):
        raise ValueError("the block was cut short or spoiled")
    end = content.index(b"\n")
    header, rest = json.loads(content[:end]), whole[end + 1 :]
    n, names = header["cases"], header["columns"]
    if (header["sweep"], header["first"], n) != (
        sweep,
        case_range.first,
        case_range.end - case_range.begin,
    ):
        raise ValueError("the block is that of another place")
    status = np.frombuffer(rest, np.int8, n)
    numbers = np.frombuffer(rest, "<f8", n * len(names), n).reshape(len(names), n)
    known: dict[str, Any] = dict(zip(names, numbers, strict=True))
    known |= {name: np.full(n, value) for name, value in header["same"].items()}
    points = point_columns(case_range.scenario.sweep, case_range.begin, case_range.end)
    metrics = {name: known[name] for name in METRIC_NAMES}
    notes = {int(i): note for i, note in header["notes"].items()}
    over = {int(i): OverSeeds(**fields) for i, fields in header["over"].items()}
    F_fk, F_fs = (known[force] for force in FORCE_COLUMNS)
    label = case_range.scenario.label
    return Batch(case_range.first, label, points, F_fk, F_fs, metrics, status, notes, over)


class BlockHeader(NamedTuple):
    """What the first line of a block says: of which sweep and case, and its size [B]."""

    sweep: str
    first: int
    size: int


def parse_header(line: bytes) -> BlockHeader | None:
    """Read the first line of a block; None where it is not one."""
    try:
        header = json.loads(line)
        first, size = int(header["first"]), int(header["bytes"])
        return (
            BlockHeader(header["sweep"], first, len(line) + size + CHECKSUM)
            if size >= 0
            else None
        )
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError):
        return None


def _checksum(parts: Iterable[bytes | memoryview]) -> bytes:
    """Give what tells whether a byte was lost or changed."""
    total = 0
    for part in parts:
        total = zlib.crc32(part, total)
    return total.to_bytes(CHECKSUM, "little")


def _is_constant(column: NDArray[np.float64]) -> bool:
    """Tell whether all numbers of a column are alike in every bit."""
    bits = column.view(np.int64)
    return bool((bits == bits[:1]).all()) and bits.size > 0


# Finished seeds of a run in progress.


class Journal:
    """A file whose first line says what is run, and every other line is a finished seed.

    The line of a seed begins with a checksum of itself and of what is run: one that a kill has
    cut short, that was changed or is of another run, is passed over. Numbers are written so
    that they read back as they were: a run that goes on gives the very ensemble of one that
    was never interrupted.
    """

    def __init__(self, file: Path, identity: Mapping[str, Any], resume: bool) -> None:
        self.file = file
        self.identity = dict(identity)
        self.run = identity_digest(self.identity)
        self.done: dict[int, Row] = {}
        if resume and _has_journal(file):
            self.done = self._read()
        lines = [format_entry(number, row, self.run) for number, row in self.done.items()]
        fresh = self.file.with_suffix(".new")
        fresh.write_text(json.dumps(self.identity) + "\n" + "".join(lines), encoding="utf-8")
        with suppress(OSError):
            self.file.rmdir()  # an empty folder may be replaced
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
        self._stream.write(format_entry(number, row, self.run))
        self._stream.flush()
        if not os.fstat(self._stream.fileno()).st_nlink:
            raise system.removed_error(self.file.parent)
        self.done[number] = row

    def _read(self) -> dict[int, Row]:
        """Give the finished seeds of the same run."""
        lines = self.file.read_text(encoding="utf-8", errors="replace").splitlines()
        if parse_json(lines[0] if lines else "") != self.identity:
            raise other_work_error(self.file.parent)
        seeds = (parse_entry(line, self.run) for line in lines[1:])
        return dict(seed for seed in seeds if seed is not None)


def format_entry(number: int, row: Row, run: str) -> str:
    """Give the line of a seed, by its number from 0, in the journal of a run."""
    # vars() is faster than asdict(), which copies each value.
    content = json.dumps({"number": number, "row": vars(row)})
    return f"{checksum(content, run)} {content}\n"


def checksum(content: str, run: str) -> str:
    """Return what tells whether words were changed, or are those of another run (hex)."""
    return hashlib.sha256(f"{run} {content}".encode()).hexdigest()[:16]


def parse_json(line: str) -> Any:
    """Give what a line says, or None where it was cut short or is none of ours."""
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None


def parse_entry(line: str, run: str) -> tuple[int, Row] | None:
    """Give number and row of the seed of a line, or None where there is none of this run."""
    expected, _, content = line.partition(" ")
    if expected != checksum(content, run):
        return None
    try:
        fields = parse_json(content)
        return int(fields["number"]), Row(**fields["row"])
    except (KeyError, TypeError, ValueError):
        return None


def _has_journal(file: Path) -> bool:
    """Whether there is a journal; a device or a pipe in its place is none."""
    try:
        return system.file_size(file) > 0
    except (OSError, system.NotARegularFile):
        return False


# Identity of a computation: only the same one may be resumed.


def work_identity(scenario: Scenario) -> dict[str, Any]:
    """Give what makes it one: all words of the scenario, its files, and drysim."""
    content = json.dumps(scenario.resolved(), sort_keys=True)
    digest = hashlib.sha256(content.encode()).hexdigest()
    own = {"drysim": drysim.__version__, "core": source_digest()}
    return own | {"scenario": digest, "files": file_hashes(scenario)}


def identity_digest(identity: Mapping[str, Any]) -> str:
    """Return what makes it one in short (hex): each finished part of the work bears it."""
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:32]


def other_work_error(folder: Path) -> UsageError:
    """Give the error for finished cases that are none of this sweep."""
    return UsageError(
        f"{folder} holds cases of another sweep, another record or another drysim",
        "run the command without --resume to begin anew",
    )
