"""Store: the finished blocks of a sweep under way, so that a kill loses none of them."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple
from uuid import uuid4

from drysim import regular
from drysim.errors import OutputError
from drysim.scenario.sweep.lazy import Lazy
from drysim.study.identity import digest_of, of_another, removed
from drysim.study.sweeps.batch import Batch
from drysim.study.sweeps.packing import heading, packed, unpacked
from drysim.study.sweeps.plan import Piece

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
                raise removed(self.folder.parent) from None
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
        with suppress(OSError, ValueError, regular.Irregular), regular.opened(file) as stream:
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
