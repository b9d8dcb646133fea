"""Store: the finished blocks of a sweep under way, so that a kill loses none of them."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, overload

import numpy as np

from drysim.errors import UsageError
from drysim.scenario.sweep.axis import columns_of
from drysim.study.batch import NAMES, Batch
from drysim.study.pieces import Piece
from drysim.study.table import OverSeeds

WHAT = "sweep.json"
"""What is swept, so that blocks of another sweep are not taken for its own."""

FORCES = ("F_fk", "F_fs")


class Store:
    """A folder with a file for every finished block of cases.

    A file appears whole or not at all, and holds every number to its last bit: a sweep that
    goes on gives the very table of one that was never interrupted. Blocks may come in any
    order and from any process.
    """

    def __init__(self, folder: Path, what: Mapping[str, Any], resume: bool) -> None:
        self.folder = folder
        # Links and devices that somebody put there are nothing to go on with.
        if resume and not folder.is_symlink() and (folder / WHAT).is_file():
            if self._what() != dict(what):
                raise UsageError(
                    f"{folder.parent} holds cases of another sweep or another drysim",
                    "run the command without --resume to begin anew",
                )
            return
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        (folder / WHAT).write_text(json.dumps(dict(what)) + "\n", encoding="utf-8")

    def write(self, piece: Piece, batch: Batch) -> None:
        """Keep the cases of a piece."""
        head = {
            "cases": len(batch),
            "columns": [*FORCES, *NAMES],
            "notes": {str(i): note for i, note in batch.notes.items()},
            "over": {str(i): vars(over) for i, over in batch.over.items()},
        }
        columns = [batch.F_fk, batch.F_fs, *(batch.metrics[name] for name in NAMES)]
        words = json.dumps(head).encode() + b"\n"
        numbers = np.stack(columns).astype("<f8").tobytes()
        file = self._file(piece)
        draft = file.with_suffix(f".{os.getpid()}")
        draft.write_bytes(words + batch.status.tobytes() + numbers)
        draft.replace(file)

    def read(self, piece: Piece) -> Batch | None:
        """Give the cases of a piece; None where they are still to be computed."""
        try:
            words, _, rest = self._file(piece).read_bytes().partition(b"\n")
            head = json.loads(words)
            n, names = head["cases"], head["columns"]
            status = np.frombuffer(rest, np.int8, n)
            numbers = np.frombuffer(rest, "<f8", n * len(names), n).reshape(len(names), n)
        except (OSError, ValueError, KeyError, TypeError):
            return None
        known = dict(zip(names, numbers, strict=True))
        points = columns_of(piece.scenario.axes, piece.begin, piece.end)
        metrics = {name: known[name] for name in NAMES}
        notes = {int(i): note for i, note in head["notes"].items()}
        over = {int(i): OverSeeds(**said) for i, said in head["over"].items()}
        approach = piece.scenario.solver.approach
        F_fk, F_fs = (known[force] for force in FORCES)
        return Batch(piece.first, approach, points, F_fk, F_fs, metrics, status, notes, over)

    def holds(self, piece: Piece) -> bool:
        """Tell whether the cases of a piece are kept."""
        return self._file(piece).is_file()

    def _file(self, piece: Piece) -> Path:
        return self.folder / f"{piece.first:012d}.cases"

    def _what(self) -> Any:
        try:
            return json.loads((self.folder / WHAT).read_text(encoding="utf-8"))
        except ValueError:
            return None


class Stored(Sequence[Batch]):
    """The blocks of a store, read when they are asked for."""

    def __init__(self, store: Store, kept: Sequence[Piece]) -> None:
        self._store = store
        self._kept = kept

    def __len__(self) -> int:
        """Give the number of blocks."""
        return len(self._kept)

    @overload
    def __getitem__(self, number: int) -> Batch: ...
    @overload
    def __getitem__(self, number: slice) -> Sequence[Batch]: ...
    def __getitem__(self, number: int | slice) -> Batch | Sequence[Batch]:
        """Read one block, or some when they are asked for."""
        if isinstance(number, slice):
            return Stored(self._store, self._kept[number])
        batch = self._store.read(self._kept[number])
        assert batch is not None, "a block that was kept stays until the sweep is written"
        return batch
