"""Finished ranges of a sweep or of an ensemble on disk, from which `--resume` continues.

The store holds the identity of the computation (scenario, files, version), so that only the
same computation continues from it. An incomplete batch is ignored. All numbers read back bit
for bit.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple
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
from drysim.study.statistics import METRIC_NAMES, Batch, OverSeeds

IDENTITY_FILE = "sweep.json"
"""File with the identity of the computation, checked before a resume."""

CASES_SUFFIX = ".cases"
"""Suffix of the files with batches."""

MAX_FILE_BYTES = 1 << 26
"""Size of a file from which the next batch starts a new one [bytes]."""

MAX_HEADER_BYTES = 1 << 26
"""Largest header line of a batch [bytes]; notes and seeds of 4096 cases take 1e7."""


class Location(NamedTuple):
    """Position of a batch on disk."""

    file: Path
    begin: int
    size: int


class Store:
    """Folder with the finished batches of a sweep or of an ensemble.

    A batch is appended to a file as soon as it is finished. Each process writes only to its own
    files, so an interrupted write leaves an incomplete batch only at the end of a file, where
    it is ignored. Batches may come in any order and from any machine. Resumed work returns the
    same results as uninterrupted work, bit for bit.

    Parameters
    ----------
    folder : Path
    identity : mapping
        As `work_identity` returns it.
    resume : bool
        Whether to keep the batches in the folder; otherwise they are deleted.

    Raises
    ------
    UsageError
        When the batches belong to another computation.
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
        folder.mkdir(exist_ok=True)  # a file that is still open may be left, as on Windows
        draft = (folder / IDENTITY_FILE).with_suffix(".new")
        draft.write_text(json.dumps(dict(identity)) + "\n", encoding="utf-8")
        system.replace(draft, folder / IDENTITY_FILE)

    def write(self, case_range: CaseRange, batch: Batch) -> None:
        """Write the batch of a range."""
        self.write_packed(case_range, pack(batch, self.sweep))

    def write_packed(self, case_range: CaseRange, content: bytes) -> None:
        """Write the batch of a range, already in binary format.

        Raises
        ------
        OutputError
            When the folder, or the file in it, was removed.
        """
        with self._lock:
            location = Location(self._file, self._end, len(content))
            if fresh := self._end >= MAX_FILE_BYTES:
                name = f"{self._files:06d}-{uuid4().hex[:12]}{CASES_SUFFIX}"  # unique
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
        """Return the batch of a range; None if it is missing or damaged."""
        try:
            file, begin, size = self._locations[case_range.first]
            with file.open("rb") as stream:
                stream.seek(begin)
                return unpack(stream.read(size), case_range, self.sweep)
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def finished(self, ranges: Iterable[CaseRange]) -> Iterator[tuple[CaseRange, Batch]]:
        """Yield each of these ranges that the store holds, with its batch."""
        for case_range in ranges:
            if (batch := self.read(case_range)) is not None:
                yield case_range, batch

    def has(self, case_range: CaseRange) -> bool:
        """Whether the store holds the complete batch of a range."""
        return case_range.first in self._locations

    def _index_file(self, file: Path) -> None:
        """Record the locations of the batches in a file, up to the first incomplete one."""
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
    """Batches of a store, read on access, except for the first ones, which stay in memory.

    A summary of the first cases is shown when the store is already removed.
    """

    def __init__(
        self, store: Store, ranges: Sequence[CaseRange], in_memory: Sequence[Batch] = ()
    ) -> None:
        self._store = store
        self._ranges = ranges
        self._in_memory = in_memory

    def __len__(self) -> int:
        """Return the number of batches."""
        return len(self._ranges)

    def one(self, number: int) -> Batch:
        """Return one batch."""
        if number < len(self._in_memory):
            return self._in_memory[number]
        batch = self._store.read(self._ranges[number])
        if batch is None:
            raise OutputError(
                f"cases are missing from {self._store.folder}",
                "make sure that nothing else writes there; repeat the command with --resume",
            )
        return batch


# Binary format of a batch, on disk and between machines.

FORCE_COLUMNS = ("F_fk", "F_fs")

CHECKSUM = 4
"""Size of the checksum at the end of a batch, the CRC-32 of all bytes before [bytes]."""


def pack(batch: Batch, sweep: str) -> bytes:
    """Return a batch in binary format: a JSON line, statuses, columns of doubles, checksum.

    A column with a single value is stored as a number in the JSON line. Of the points there is
    only a checksum: they follow from the number of the first case. This number and the digest
    of the sweep are in the line, so a batch is never mistaken for another one.
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
        "points": _points_checksum(batch.points),
    }
    parts = [json.dumps(header).encode() + b"\n", *body]
    return b"".join([*parts, _checksum(parts)])


def unpack(content: bytes, case_range: CaseRange, sweep: str) -> Batch:
    """Return the batch of a range from its binary format.

    Raises
    ------
    ValueError, KeyError, TypeError
        When the bytes are incomplete or damaged, or belong to another range.
    """
    whole = memoryview(content)[:-CHECKSUM]
    if content[-CHECKSUM:] != _checksum([whole]):
        raise ValueError("the batch is incomplete or damaged")
    end = content.index(b"\n")
    header, rest = json.loads(content[:end]), whole[end + 1 :]
    n, names = header["cases"], header["columns"]
    if (header["sweep"], header["first"], n) != (
        sweep,
        case_range.first,
        case_range.end - case_range.begin,
    ):
        raise ValueError("the batch belongs to another range")
    status = np.frombuffer(rest, np.int8, n)
    numbers = np.frombuffer(rest, "<f8", n * len(names), n).reshape(len(names), n)
    known: dict[str, Any] = dict(zip(names, numbers, strict=True))
    known |= {name: np.full(n, value) for name, value in header["same"].items()}
    points = point_columns(case_range.scenario.sweep, case_range.begin, case_range.end)
    if header["points"] != _points_checksum(points):
        raise ValueError("the batch has other points")
    metrics = {name: known[name] for name in METRIC_NAMES}
    notes = {int(i): note for i, note in header["notes"].items()}
    over = {int(i): OverSeeds(**fields) for i, fields in header["over"].items()}
    F_fk, F_fs = (known[force] for force in FORCE_COLUMNS)
    label = case_range.scenario.label
    columns = (points, F_fk, F_fs, metrics, status)
    return Batch(case_range.first, label, *columns, notes, over)


class BlockHeader(NamedTuple):
    """Digest of the sweep, number of the first case, size of the batch [bytes]."""

    sweep: str
    first: int
    size: int


def parse_header(line: bytes) -> BlockHeader | None:
    """Return the header in the first line of a batch; None if the line is no header."""
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


def _points_checksum(points: Mapping[str, NDArray[Any]]) -> int:
    """Return a checksum of the points of a batch."""
    texts = (
        column.tobytes() if column.dtype.kind in "fi" else json.dumps(column.tolist()).encode()
        for column in points.values()
    )
    return zlib.crc32(b"".join(texts))


def _checksum(parts: Iterable[bytes | memoryview]) -> bytes:
    """Return the CRC-32 of the parts."""
    total = 0
    for part in parts:
        total = zlib.crc32(part, total)
    return total.to_bytes(CHECKSUM, "little")


def _is_constant(column: NDArray[np.float64]) -> bool:
    """Whether all numbers of a column are identical in every bit."""
    bits = column.view(np.int64)
    return bool((bits == bits[:1]).all()) and bits.size > 0


# Identity of a computation: only the same one may be resumed.


def work_identity(scenario: Scenario) -> dict[str, Any]:
    """Return the identity of a computation: hashes of scenario and files, version of drysim."""
    content = json.dumps(scenario.resolved(), sort_keys=True)
    digest = hashlib.sha256(content.encode()).hexdigest()
    own = {"drysim": drysim.__version__, "core": source_digest()}
    return own | {"scenario": digest, "files": file_hashes(scenario)}


def identity_digest(identity: Mapping[str, Any]) -> str:
    """Return a digest of an identity (hex), which each finished part carries."""
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:32]


def other_work_error(folder: Path) -> UsageError:
    """Return the error for finished cases of another computation."""
    return UsageError(
        f"{folder} holds cases of other work: another scenario, record or version of drysim",
        "run the command without --resume to start over",
    )
