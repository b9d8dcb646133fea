"""What a file offers: columns of numbers by name and number, whatever the file's format."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.signal import Signal
from drysim.errors import RecordError
from drysim.excitation.record.file import Cell
from drysim.quantity import near, shown

Floats = NDArray[np.float64]


def gap(at_most: str = "50 ms", which: str = "short ones") -> str:
    """Say what to do about samples that are missing."""
    way = f"`gaps: {{fill: line, at_most: {at_most}}}`"
    return f"the record has a gap; {way} fills {which}"


GAP = gap()
"""What to say of a sample that is missing, where the length of the gap is not known yet."""

INFINITE = "an infinite sample is no gap that could be filled; export the record anew"
"""What to say of a sample that overflowed."""

LISTED = 12
"""How many of a file's columns a message lists."""


class Label(NamedTuple):
    """What a file says of a column: the text as written, and name and unit that it holds.

    `firm` is false where the unit may be a remark, as in `acc (filtered)`.
    """

    text: str
    name: str
    unit: str = ""
    firm: bool = True

    @property
    def quote(self) -> str:
        """The text as messages quote it, shortened."""
        return Cell(self.text, 0).quote


@dataclass(frozen=True, kw_only=True)
class Columns:
    """Columns of numbers in a file; each implementation knows where its numbers are.

    Attributes
    ----------
    shown : str
        The file as messages name it.
    labels : tuple of Label
        What the file says of each column; empty when nothing has a name.
    width : int
        Number of columns.
    word, key : str
        What a column is called, and the key of a record that chooses it.
    place : str
        Where a unit stands: header or file.
    shares : bool
        Whether the numbers are shares of a full scale that the file does not know.
    """

    shown: str
    labels: tuple[Label, ...]
    width: int
    word: str = "column"
    key: str = "column"
    place: str = "header"
    shares: bool = False

    def numbers(self, wanted: list[int], gappy: int | None = None) -> list[Signal]:
        """Give columns as finite numbers, NaN where a sample of the `gappy` one is missing."""
        raise NotImplementedError

    def last_digit(self, index: int) -> float:
        """Give the unit of the last digit that a column's numbers are written with."""
        raise NotImplementedError

    def at(self, row: int, index: int, sentence: str) -> RecordError:
        """Give the error at a 0-based row of a column."""
        raise NotImplementedError

    def fault(self, sentence: str, index: int | None = None) -> RecordError:
        """Give the error for a fault of the whole file, or of one column."""
        raise NotImplementedError

    def clock(self, index: int) -> int | None:
        """Give the 0-based column of the times that belong to a column, where there is one."""
        return None

    def own(self, index: int) -> tuple[float, float] | None:
        """Give the step and the first time [s] that the file itself knows of a column."""
        return None

    def series(self) -> list[int]:
        """Give the 0-based columns that may be samples."""
        return list(range(self.width))

    @property
    def way_round(self) -> str:
        """How to pass over what the file says of its columns, where it can be."""
        return ""

    def called(self, index: int) -> str:
        """Give a column as messages name it."""
        name = self.labels[index].quote if self.labels else ""
        return f"{self.word} {index + 1}" + (f" (`{name}`)" if name else "")

    def names(self) -> str:
        """Give the columns there are as a list for messages."""
        if not any(label.text for label in self.labels):
            return f"{self.width}, without names" + (
                ": the file has no header" if self.place == "header" else ""
            )
        series = self.series()
        listed = ", ".join(f"`{self.labels[i].quote}`" for i in series[:LISTED])
        return listed + (f" and {len(series) - LISTED} more" if len(series) > LISTED else "")

    def find(self, wanted: str | int) -> int:
        """Give the 0-based column of a name, with or without its unit, or of a 1-based number.

        Raises
        ------
        RecordError
            When there is no such column, or more than one.
        """
        if isinstance(wanted, int):
            if wanted <= self.width:
                return wanted - 1
            raise self.fault(
                f"there is no {self.word} {shown(wanted)}; there are: {self.names()}"
            )
        full = [label.text for label in self.labels]
        bare = [label.name for label in self.labels]
        hits = [i for i, text in enumerate(full) if text == wanted.strip()]
        hits = hits or [i for i, text in enumerate(bare) if text == wanted.strip()]
        if len(hits) == 1:
            return hits[0]
        if hits:
            numbers = " and ".join(str(i + 1) for i in hits[:LISTED])
            both = f"{self.word}s {numbers} are both {shown(wanted)}"
            raise self.fault(f"{both}; give the {self.word}'s number")
        nearest = near(wanted, filter(None, bare + full))
        guess = f" did you mean {shown(nearest)}?" if nearest else ""
        raise self.fault(
            f"there is no {self.word} {shown(wanted)};{guess} there are: {self.names()}"
        )
