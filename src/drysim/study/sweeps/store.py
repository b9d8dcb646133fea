"""Store: the finished blocks of a sweep under way, so that a kill loses none of them."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from drysim.errors import OutputError
from drysim.scenario.sweep.lazy import Lazy
from drysim.study.identity import of_another
from drysim.study.sweeps.batch import Batch
from drysim.study.sweeps.packing import is_whole, packed, unpacked
from drysim.study.sweeps.plan import Piece

WHAT = "sweep.json"
"""What is swept, so that blocks of another sweep are not taken for its own."""

CASES = ".cases"
"""What the name of a block's file ends with."""

LONGEST_LINE = 1 << 26
"""Bytes of the first line of a block at most: the notes and seeds of 4096 cases take 1e7."""


class Store:
    """A folder with a file for every finished block of cases.

    A file appears whole or not at all, and holds every number to its last bit: a sweep that
    goes on gives the very table of one that was never interrupted. Blocks may come in any
    order and from any process or machine.
    """

    def __init__(self, folder: Path, what: Mapping[str, Any], resume: bool) -> None:
        self.folder = folder
        # Links and devices that somebody put there are nothing to go on with.
        if resume and not folder.is_symlink() and (folder / WHAT).is_file():
            if self._what() != dict(what):
                raise of_another(folder.parent)
            self._drop_drafts()
            return
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        self._put(folder / WHAT, (json.dumps(dict(what)) + "\n").encode())

    def write(self, piece: Piece, batch: Batch) -> None:
        """Keep the cases of a piece."""
        self.keep(piece, packed(batch))

    def keep(self, piece: Piece, words: bytes) -> None:
        """Keep the cases of a piece, packed already."""
        self._put(self._file(piece), words)

    def read(self, piece: Piece) -> Batch | None:
        """Give the cases of a piece; None where they are still to be computed."""
        try:
            return unpacked(self._file(piece).read_bytes(), piece)
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def holds(self, piece: Piece) -> bool:
        """Tell whether the cases of a piece are kept, with all their bytes."""
        try:
            with self._file(piece).open("rb") as stream:
                size = os.fstat(stream.fileno()).st_size
                return is_whole(stream.readline(LONGEST_LINE), size)
        except OSError:
            return False

    def _put(self, file: Path, words: bytes) -> None:
        """Write a file whole or not at all; a draft without room is dropped."""
        draft = file.with_suffix(f".{os.getpid()}")
        try:
            draft.write_bytes(words)
            draft.replace(file)
        except OSError:
            draft.unlink(missing_ok=True)
            raise

    def _drop_drafts(self) -> None:
        """Remove what a process that was killed had begun to write."""
        for path in self.folder.iterdir():
            if path.suffix[1:].isdigit() and not path.is_dir():
                path.unlink(missing_ok=True)

    def _file(self, piece: Piece) -> Path:
        return self.folder / f"{piece.first:012d}{CASES}"

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
