"""The file behind a record: read once, hashed as read, and faults that point into it."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from drysim import machine, regular
from drysim.errors import Problem, RecordError
from drysim.excitation.record.reader import Reader, changed, examine
from drysim.quantity import meant, near

COPIES = 3
"""The file, what is made of its bytes, and the numbers: room for three at least."""

LEAST = 0.25
"""Bytes held for a byte of any file, at least: a number of 8 for 32 characters."""

LONGEST_QUOTE = 40
"""Characters of a cell that a message may quote, so that no message retells a file."""

FARTHEST_CARET = 100
"""Beyond this column a source line of blanks and one cell helps nobody."""

LOOKED_AT = 1000
"""Files of a folder among which a near name is looked for."""


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


def fault(shown: str, sentence: str, line: int = 0, cell: Cell | None = None) -> RecordError:
    """Give the error for one fault; its source line shows the faulty cell among blanks."""
    if cell is None:
        return RecordError(Problem(sentence, shown, line))
    quote = cell.quote
    near = cell.column <= FARTHEST_CARET
    source = " " * (cell.column - 1) + quote if near else ""
    return RecordError(
        Problem(sentence, shown, line, cell.column, max(1, len(quote)), source=source)
    )


def read(path: Path, suffixes: Collection[str]) -> File:
    """Read the file of a record once.

    Parameters
    ----------
    path : Path
        Where the file is; messages name it so.
    suffixes : collection of str
        What is read.

    Returns
    -------
    File

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
    except regular.Irregular as other:
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
        size = regular.size(path)
    except FileNotFoundError:
        raise fault(str(path), f"the record is not there{_neighbour(path, suffixes)}") from None
    if path.suffix.lower() not in suffixes:
        kinds = ", ".join(suffixes)
        suffix = f"from `{path.suffix}`" if path.suffix else "without a suffix"
        raise fault(str(path), f"a record {suffix} cannot be read; what is read: {kinds}")
    return size


def fit(shown: str, size: int) -> None:
    """Make sure that a record of some bytes, packed or not, can be read into memory.

    Raises
    ------
    RecordError
        When the machine has too little.
    """
    room(shown, size * COPIES)


def room(shown: str, need: float) -> None:
    """Make sure that the machine has so many bytes for a record; errors as in `fit`."""
    have = machine.memory()
    if need > have:
        sentence = f"the record needs {need / 1e9:.3g} GB of memory"
        raise fault(shown, f"{sentence}, this machine has {have / 1e9:.3g} GB")


def _neighbour(path: Path, suffixes: Collection[str]) -> str:
    if not path.parent.is_dir():
        return f": there is no folder `{path.parent}`"
    if path.is_symlink():
        return ": it is a link that leads nowhere"
    files = islice(path.parent.iterdir(), LOOKED_AT)
    names = (file.name for file in files if file.suffix.lower() in suffixes)
    return meant(near(path.name, names))
