"""A variable of a MAT file, and bytes that are read from it without ever leaving them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.errors import RecordError
from drysim.excitation.record.columns import Floats
from drysim.excitation.record.file import File, fault
from drysim.excitation.record.reader import Reader
from drysim.excitation.record.stored import Stored


class Variable(NamedTuple):
    """A full array of real numbers; they are loaded when asked for."""

    name: str
    shape: tuple[int, ...]
    load: Callable[[], Floats | Stored]


class Bytes(NamedTuple):
    """Bytes of a file, or what was packed in it; `order` is `<` or `>`."""

    file: File
    raw: Reader | bytes
    order: str

    def whole(self, at: int, size: int = 4) -> int:
        """Give an unsigned whole number."""
        return int(self.numbers(at, 1, f"u{size}")[0])

    def numbers(self, at: int, count: int, kind: str) -> NDArray[np.generic]:
        """Give numbers of a kind; errors as in `behind`."""
        return np.frombuffer(self.raw[at : self.behind(at, count, kind)], self.order + kind)

    def behind(self, at: int, count: int, kind: str) -> int:
        """Give where numbers of a kind end.

        Raises
        ------
        RecordError
            When the bytes end before them.
        """
        end = at + count * np.dtype(kind).itemsize
        if at < 0 or end > len(self.raw):
            raise self.damaged("bytes are missing at its end")
        return end

    def text(self, at: int, size: int) -> str:
        """Give text up to the first zero byte."""
        return self.numbers(at, size, "u1").tobytes().split(b"\0")[0].decode("latin-1")

    def stored(self, at: int, count: int, kind: str) -> Stored:
        """Give numbers that stay where they are; errors as in `behind`."""
        self.behind(at, count, kind)
        return Stored(partial(self._part, at, kind), 0, count)

    def _part(self, at: int, kind: str, first: int, last: int) -> Floats:
        start = self.behind(at, first, kind)
        return self.numbers(start, last - first, kind).astype(np.float64)

    def damaged(self, what: str) -> RecordError:
        """Give the error for a file that is not what it should be."""
        return fault(self.file.shown, f"the record is no MAT file, or damaged: {what}")
