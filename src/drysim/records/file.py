"""The file behind a record: read once, hashed as read, and faults that point into it.

Only a regular file of a known suffix that memory has room for is read. Its bytes are not kept:
a `Reader` gives slices of them and refuses every access once the file was written to, cut or
replaced, so that what is computed belongs to the hash that is told.
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from drysim import system
from drysim.errors import Problem, RecordError
from drysim.units import meant, near

WINDOW = 1 << 20
"""Bytes read at a time: small beside the numbers, large beside the cost of a call."""

LEAST = 0.25
"""Bytes held for a byte of any file, at least: a number of 8 for 32 characters."""

LONGEST_QUOTE = 40
"""Characters of a cell that a message may quote, so that no message retells a file."""

LOOKED_AT = 1000
"""Files of a folder among which a near name is looked for."""


@dataclass(frozen=True, eq=False)
class Reader:
    """The bytes of a file, as slices; the latest part that was read is kept.

    Raises
    ------
    RecordError
        By every access, when the file was written to, cut or replaced in the meantime.
    """

    path: Path
    size: int
    stamp: system.Stamp
    latest: dict[int, bytes] = field(default_factory=dict)

    def __len__(self) -> int:
        """Give how many there are."""
        return self.size

    def __getitem__(self, part: slice) -> bytes:
        """Give some neighbouring bytes."""
        first, last, _ = part.indices(self.size)
        for at, kept in self.latest.items():
            if at <= first and last <= at + len(kept):
                return kept[first - at : last - at]
        if last - first > WINDOW:
            return self._read(first, last - first)
        self.latest.clear()
        kept = self._read(first, WINDOW)
        self.latest[first] = kept
        return kept[: max(last - first, 0)]

    def find(self, wanted: bytes, first: int = 0) -> int:
        """Give where one byte stands from a place on, -1 for nowhere."""
        for at in range(first, self.size, WINDOW // 4):
            found = self[at : at + WINDOW // 4].find(wanted)
            if found >= 0:
                return at + found
        return -1

    def _read(self, at: int, count: int) -> bytes:
        try:
            with system.opened(self.path) as stream:
                stream.seek(at)
                found, stamp = stream.read(count), system.stamp_of(stream.fileno())
        except (OSError, system.Irregular):
            raise changed(self.path) from None
        if stamp != self.stamp:
            raise changed(self.path)
        return found


class Cell(NamedTuple):
    """Text between two delimiters, and the 1-based column of its first character."""

    text: str
    column: int

    @property
    def quote(self) -> str:
        """The text as messages quote it, shortened."""
        text = printable(self.text)
        return text if len(text) <= LONGEST_QUOTE else text[: LONGEST_QUOTE - 1] + "…"


def printable(text: str) -> str:
    """Return a text with a question mark for each character that has no glyph."""
    return "".join(c if c.isprintable() else "?" for c in text)


@dataclass(frozen=True, eq=False)
class File:
    """A record as it was read first: its SHA-256; `shown` is the path as messages name it.

    `skip` is the number of rows at its top that do not count.
    """

    shown: str
    path: Path
    reader: Reader
    sha256: str
    skip: int = 0

    @cached_property
    def raw(self) -> bytes:
        """All bytes at once, where memory has room for them and what is made of them."""
        fit(self.shown, len(self.reader))
        return self.reader[:]


class TextFile(NamedTuple):
    """Text of a record, which begins at an offset: the one of a line counted from 1."""

    shown: str
    text: Reader | bytes
    begin: int = 0
    line: int = 1


def read(path: Path, suffixes: Collection[str]) -> File:
    """Read the file of a record once, if its suffix is one of those that are read.

    Raises
    ------
    RecordError
        When the file is missing, empty, not a regular file, of a kind that is not read, or
        larger than the machine's memory allows.
    """
    try:
        size = _size(path, suffixes)
        room(str(path), size * LEAST)
        reader, sha256, filled = examine(path)
    except system.Irregular as other:
        raise fault(str(path), f"the record is {other}; only a regular file is read") from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise fault(str(path), f"the record cannot be read: {why}") from None
    if not size or not filled:
        raise fault(str(path), "the record is empty")
    if size != len(reader):
        raise changed(path)
    return File(str(path), path, reader, sha256)


def _size(path: Path, suffixes: Collection[str]) -> int:
    """Give the size of a record; a file below /proc, which claims to have none, has none."""
    try:
        size = system.size(path)
    except FileNotFoundError:
        raise fault(str(path), f"the record is not there{_neighbour(path, suffixes)}") from None
    if path.suffix.lower() not in suffixes:
        kinds = ", ".join(suffixes)
        suffix = f"from `{path.suffix}`" if path.suffix else "without a suffix"
        raise fault(str(path), f"a record {suffix} cannot be read; what is read: {kinds}")
    return size


def _neighbour(path: Path, suffixes: Collection[str]) -> str:
    if not path.parent.is_dir():
        return f": there is no folder `{path.parent}`"
    if path.is_symlink():
        return ": it is a link that leads nowhere"
    files = islice(path.parent.iterdir(), LOOKED_AT)
    names = (file.name for file in files if file.suffix.lower() in suffixes)
    return meant(near(path.name, names))


def examine(path: Path) -> tuple[Reader, str, bool]:
    """Read a file once; gives its reader, its SHA-256 (hex) and whether it holds anything.

    Raises
    ------
    RecordError
        When the file changes meanwhile.
    """
    digest, filled = hashlib.sha256(), False
    with system.opened(path) as stream:
        stamp = system.stamp_of(stream.fileno())
        while block := stream.read(WINDOW):
            digest.update(block)
            filled = filled or bool(block.strip())
        if system.stamp_of(stream.fileno()) != stamp:
            raise changed(path)
    return Reader(path, stamp[1], stamp), digest.hexdigest(), filled


def changed(path: Path) -> RecordError:
    """Give the error for a file that is no longer the one that was looked at first."""
    sentence = "the record changed while it was read; wait until it is whole"
    return RecordError(Problem(sentence, str(path), 0))


def fault(shown: str, sentence: str, line: int = 0, cell: Cell | None = None) -> RecordError:
    """Give the error for one fault; its source line shows the faulty cell among blanks."""
    if cell is None:
        return RecordError(Problem(sentence, shown, line))
    quote = cell.quote
    # Far to the right, a source line of blanks and one cell helps nobody.
    source = " " * (cell.column - 1) + quote if cell.column <= 100 else ""
    return RecordError(
        Problem(sentence, shown, line, cell.column, max(1, len(quote)), source=source)
    )


def fit(shown: str, size: int) -> None:
    """Make sure that a record of some bytes, packed or not, can be read into memory.

    There must be room for three: the file, what is made of its bytes, and the numbers.

    Raises
    ------
    RecordError
        When the machine has too little.
    """
    room(shown, size * 3)


def room(shown: str, need: float) -> None:
    """Make sure that the machine has so many bytes for a record; errors as in `fit`."""
    have = system.memory()
    if need > have:
        sentence = f"the record needs {need / 1e9:.3g} GB of memory"
        raise fault(shown, f"{sentence}, this machine has {have / 1e9:.3g} GB")
