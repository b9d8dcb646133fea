"""A block of cases as bytes, the same on the disk and on the way between machines."""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from drysim.scenario.sweep.axis import columns_of
from drysim.study.sweeps.batch import NAMES, Batch
from drysim.study.sweeps.table import OverSeeds

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from drysim.study.sweeps.plan import Piece

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
    own = sweep, piece.first, piece.end - piece.begin
    if (head["sweep"], head["first"], n) != own:
        raise ValueError("the block is that of another place")
    status = np.frombuffer(rest, np.int8, n)
    numbers = np.frombuffer(rest, "<f8", n * len(names), n).reshape(len(names), n)
    known: dict[str, Any] = dict(zip(names, numbers, strict=True))
    known |= {name: np.full(n, value) for name, value in head["same"].items()}
    points = columns_of(piece.scenario.sweep, piece.begin, piece.end)
    metrics = {name: known[name] for name in NAMES}
    notes = {int(i): note for i, note in head["notes"].items()}
    over = {int(i): OverSeeds(**said) for i, said in head["over"].items()}
    approach = piece.scenario.word
    F_fk, F_fs = (known[force] for force in FORCES)
    return Batch(piece.first, approach, points, F_fk, F_fs, metrics, status, notes, over)


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
