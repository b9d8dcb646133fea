"""A variable of a MAT file, and bytes that are read from it without ever leaving them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.errors import RecordError
from drysim.excitation.record.file import File, fault


class Variable(NamedTuple):
    """A full array of real numbers; they are loaded when asked for."""

    name: str
    shape: tuple[int, ...]
    load: Callable[[], NDArray[np.generic]]


class Bytes(NamedTuple):
    """Bytes of a file, or what was packed in it; `order` is `<` or `>`."""

    file: File
    raw: bytes
    order: str

    def whole(self, at: int, size: int = 4) -> int:
        """Give an unsigned whole number."""
        return int(self.numbers(at, 1, f"u{size}")[0])

    def numbers(self, at: int, count: int, kind: str) -> NDArray[np.generic]:
        """Give numbers of a kind.

        Raises
        ------
        RecordError
            When the bytes end before them.
        """
        dtype = np.dtype(self.order + kind)
        if at < 0 or at + count * dtype.itemsize > len(self.raw):
            raise self.damaged("bytes are missing at its end")
        return np.frombuffer(self.raw, dtype, count, at)

    def text(self, at: int, size: int) -> str:
        """Give text up to the first zero byte."""
        return self.numbers(at, size, "u1").tobytes().split(b"\0")[0].decode("latin-1")

    def damaged(self, what: str) -> RecordError:
        """Give the error for a file that is not what it should be."""
        return fault(self.file.shown, f"the record is no MAT file, or damaged: {what}")
