"""The file behind a record: read once, hashed as read, and faults that point into it."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Collection
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from drysim import regular
from drysim.errors import Problem, RecordError
from drysim.quantity import near

COPIES = 3
"""The file, what is made of its bytes, and the numbers: room for three at least."""

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
        text = "".join(c if c.isprintable() else "?" for c in self.text)
        return text if len(text) <= LONGEST_QUOTE else text[: LONGEST_QUOTE - 1] + "…"


class File(NamedTuple):
    """Bytes of a record as read, and their SHA-256; `shown` is the path as messages name it."""

    shown: str
    path: Path
    raw: bytes
    sha256: str


class TextFile(NamedTuple):
    r"""Text of a record, every line ended by \n, without byte order mark."""

    shown: str
    text: bytes


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
        raw = _content(path, suffixes)
    except regular.Irregular as other:
        raise fault(str(path), f"the record is {other}; only a regular file is read") from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise fault(str(path), f"the record cannot be read: {why}") from None
    if not raw.strip():
        raise fault(str(path), "the record is empty")
    return File(str(path), path, raw, hashlib.sha256(raw).hexdigest())


def _content(path: Path, suffixes: Collection[str]) -> bytes:
    """Give the bytes of a record; a file below /proc, which claims to have none, has none."""
    try:
        size = regular.size(path)
    except FileNotFoundError:
        raise fault(str(path), f"the record is not there{_neighbour(path, suffixes)}") from None
    if path.suffix.lower() not in suffixes:
        kinds = ", ".join(suffixes)
        suffix = f"from `{path.suffix}`" if path.suffix else "without a suffix"
        raise fault(str(path), f"a record {suffix} cannot be read; what is read: {kinds}")
    fit(str(path), size)
    raw = regular.content(path, size + 1) if size else b""
    if len(raw) != size:
        raise fault(str(path), "the record changed while it was read; wait until it is whole")
    return raw


def fit(shown: str, size: int) -> None:
    """Make sure that a record of some bytes, packed or not, can be read into memory.

    Raises
    ------
    RecordError
        When the machine has too little.
    """
    need, have = size * COPIES, _memory()
    if need > have:
        sentence = f"the record needs {need / 1e9:.3g} GB of memory"
        raise fault(shown, f"{sentence}, this machine has {have / 1e9:.3g} GB")


def _neighbour(path: Path, suffixes: Collection[str]) -> str:
    if not path.parent.is_dir():
        return f": there is no folder `{path.parent}`"
    if path.is_symlink():
        return ": it is a link that leads nowhere"
    files = islice(path.parent.iterdir(), LOOKED_AT)
    nearest = near(path.name, (file.name for file in files if file.suffix.lower() in suffixes))
    return f"; did you mean `{nearest}`?" if nearest else ""


def _memory() -> float:
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return float("inf")
