"""Finished parts of a computation on disk, from which `--resume` continues.

The store holds the identity of the computation (scenario, files, version), so that only the
same computation continues from it. Each range of a sweep or of an ensemble, and each step of a
fit, is a file of arrays, an archive of numpy (.npz), which checks every array by a CRC-32. All
numbers read back bit for bit.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import drysim
from drysim import system
from drysim.core.compile import source_digest
from drysim.errors import OutputError, UsageError
from drysim.scenario.axes import point_columns
from drysim.scenario.files import file_hashes
from drysim.scenario.model import Scenario
from drysim.scenario.sampling import LazySequence
from drysim.study.plan import AsText, CaseRange
from drysim.study.statistics import Batch, OverSeeds

IDENTITY_FILE = "sweep.json"
"""File with the identity of the computation, checked before a resume."""

BATCH_SUFFIX = ".npz"
"""Suffix of the files with batches; their names are the numbers of the first cases."""


class Store:
    """Folder with the finished batches of a sweep or of an ensemble.

    A batch is a file, which gets its name only when it is complete: an interruption at any time
    loses no other batch. Batches may come in any order and from any machine. Resumed work
    returns the same results as uninterrupted work, bit for bit.

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
        self._finished: set[str] = set()
        if resume and is_resumable(folder, identity):
            self._finished.update(file.name for file in folder.glob(f"*{BATCH_SUFFIX}"))
            return
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(exist_ok=True)  # a file that is still open may be left, as on Windows
        content = json.dumps(dict(identity)) + "\n"
        write_whole(folder / IDENTITY_FILE, content.encode())

    def write(self, case_range: CaseRange, batch: Batch) -> None:
        """Write the batch of a range.

        Raises
        ------
        OutputError
            When the folder was removed.
        """
        self._write(self.file(case_range), pack(batch, self.sweep))

    def read(self, case_range: CaseRange) -> Batch | None:
        """Return the batch of a range; None if it is missing or damaged."""
        try:
            with system.open_regular_file(self.file(case_range)) as stream:
                return unpack(stream.read(), case_range, self.sweep)
        except Exception:  # a damaged file may raise anything
            return None

    def text(self, case_range: CaseRange) -> bytes:
        """Return the text of the batch of a range; empty if it is missing or damaged."""
        try:
            with (
                system.open_regular_file(self.file(case_range)) as stream,
                zipfile.ZipFile(stream) as archive,
            ):
                return read_array(archive, "text").tobytes()
        except Exception:  # a damaged file may raise anything
            return b""

    def write_value(self, number: int, value: Any) -> None:
        """Write a finished step: a value of lists, arrays and numbers, by its number.

        Raises
        ------
        OutputError
            When the folder was removed.
        """
        content = json.dumps({"sweep": self.sweep, "value": value}, default=as_list)
        archive = BytesIO()
        np.savez(archive, value=np.frombuffer(content.encode(), np.uint8))
        self._write(self.file_of(number), archive.getvalue())

    def read_value(self, number: int) -> Any:
        """Return a finished step, arrays as lists; None if it is missing or damaged."""
        try:
            with (
                system.open_regular_file(self.file_of(number)) as stream,
                zipfile.ZipFile(stream) as archive,
            ):
                content = json.loads(read_array(archive, "value").tobytes())
            return content["value"] if content["sweep"] == self.sweep else None
        except Exception:  # a damaged file may raise anything
            return None

    def finished(self, ranges: Iterable[CaseRange]) -> Iterator[tuple[CaseRange, Batch]]:
        """Yield each of these ranges that the store holds, with its batch."""
        for case_range in ranges:
            if (batch := self.read(case_range)) is not None:
                yield case_range, batch

    def __len__(self) -> int:
        """Return the number of batches."""
        return len(self._finished)

    def has(self, case_range: CaseRange) -> bool:
        """Whether the store holds the batch of a range."""
        return self.file(case_range).name in self._finished

    def file(self, case_range: CaseRange) -> Path:
        """Return the file of a range."""
        return self.file_of(case_range.first)

    def file_of(self, number: int) -> Path:
        """Return the file of a range by its first case, or of a step by its number."""
        return self.folder / f"{number:012d}{BATCH_SUFFIX}"

    def _write(self, file: Path, content: bytes) -> None:
        try:
            write_whole(file, content)
        except FileNotFoundError:
            raise system.removed_error(self.folder.parent) from None
        self._finished.add(file.name)


def as_list(array: NDArray[Any]) -> Any:
    """Return an array as JSON has it."""
    return array.tolist()


def write_whole(file: Path, content: bytes) -> None:
    """Write a file under its name when it is complete, or not at all."""
    draft = file.with_suffix(".new")
    try:
        draft.write_bytes(content)
        system.replace(draft, file)
    except BaseException:
        with suppress(OSError):  # free the disk space of the incomplete file
            draft.unlink()
        raise


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

    def texts(self, as_text: AsText) -> Iterator[bytes]:
        """Yield the text of each batch; `as_text` formats those that have none."""
        for number, case_range in enumerate(self._ranges):
            yield self._store.text(case_range) or as_text(self.item(number))

    def item(self, number: int) -> Batch:
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


# A batch as an archive of arrays, on disk and between machines.


def pack(batch: Batch, sweep: str) -> bytes:
    """Return a batch as an archive of arrays, without the points, which follow from its range.

    The number of the first case and the digest of the sweep are in the header, so a batch is
    never mistaken for another one.
    """
    header = {
        "sweep": sweep,
        "first": batch.first,
        "names": batch.names,
        "notes": {str(i): note for i, note in batch.notes.items()},
        "over": {str(i): vars(over) for i, over in batch.over.items()},
    }
    header_text, text = (
        np.frombuffer(part, np.uint8) for part in (json.dumps(header).encode(), batch.text)
    )
    archive = BytesIO()
    status, numbers = batch.status, batch.numbers
    np.savez(archive, header=header_text, status=status, numbers=numbers, text=text)
    return archive.getvalue()


def unpack(content: bytes, case_range: CaseRange, sweep: str) -> Batch:
    """Return the batch of a range from its archive.

    Raises
    ------
    Exception
        Of any class, when the archive is incomplete or damaged, or belongs to another range.
    """
    with zipfile.ZipFile(BytesIO(content)) as archive:
        header, status, numbers, text = (
            read_array(archive, name) for name in ("header", "status", "numbers", "text")
        )
    fields, n = json.loads(header.tobytes()), case_range.end - case_range.begin
    if (fields["sweep"], fields["first"], len(status)) != (sweep, case_range.first, n):
        raise ValueError("the batch belongs to another range")
    scenario = case_range.scenario
    points = point_columns(scenario.sweep, case_range.begin, case_range.end)
    notes = {int(i): note for i, note in fields["notes"].items()}
    over = {int(i): OverSeeds(**over) for i, over in fields["over"].items()}
    columns = points, tuple(fields["names"]), numbers, status
    return Batch(case_range.first, scenario.label, *columns, notes, over, text.tobytes())


def read_array(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    """Return an array of an archive, whose checksum is verified before it is interpreted."""
    array: NDArray[Any] = np.load(BytesIO(archive.read(f"{name}.npy")))
    return array


# Identity of a computation: only the same one may be resumed.


def work_identity(scenario: Scenario) -> dict[str, Any]:
    """Return the identity of a computation: hashes of scenario, files and drysim's source."""
    content = json.dumps(scenario.resolved(), sort_keys=True)
    digest = hashlib.sha256(content.encode()).hexdigest()
    package = Path(drysim.__file__).parent
    program = {"drysim": drysim.__version__, "source": source_digest(package)}
    return program | {"scenario": digest, "files": file_hashes(scenario)}


def identity_digest(identity: Mapping[str, Any]) -> str:
    """Return a digest of an identity (hex), which each finished part carries."""
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:32]


def is_resumable(folder: Path, identity: Mapping[str, Any]) -> bool:
    """Whether a folder holds a store, of this computation; links are never resumed from.

    Raises
    ------
    UsageError
        When the store is that of another computation.
    """
    file = folder / IDENTITY_FILE
    if folder.is_symlink() or not file.is_file():
        return False
    try:
        stored = json.loads(file.read_text(encoding="utf-8"))
    except ValueError:
        stored = None
    if stored != dict(identity):
        raise UsageError(
            f"{folder.parent} holds cases of other work: another scenario, record or version "
            "of drysim",
            "run the command without --resume to start over",
        )
    return True
