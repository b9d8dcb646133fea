"""Bytes of a file that are read by parts; the file must stay what it was."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

from drysim import regular
from drysim.errors import Problem, RecordError

WINDOW = 1 << 20
"""Bytes read at a time: small beside the numbers, large beside the cost of a call."""


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
    stamp: regular.Stamp
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
            with regular.opened(self.path) as stream:
                stream.seek(at)
                found, stamp = stream.read(count), regular.stamp_of(stream.fileno())
        except (OSError, regular.Irregular):
            raise changed(self.path) from None
        if stamp != self.stamp:
            raise changed(self.path)
        return found


def changed(path: Path) -> RecordError:
    """Give the error for a file that is no longer the one that was looked at first."""
    sentence = "the record changed while it was read; wait until it is whole"
    return RecordError(Problem(sentence, str(path), 0))


def examine(path: Path) -> tuple[Reader, str, bool]:
    """Read a file once; gives its reader, its SHA-256 (hex) and whether it holds anything.

    Raises
    ------
    RecordError
        When the file changes meanwhile.
    """
    digest, filled = hashlib.sha256(), False
    with regular.opened(path) as stream:
        stamp = regular.stamp_of(stream.fileno())
        while block := stream.read(WINDOW):
            digest.update(block)
            filled = filled or bool(block.strip())
        if regular.stamp_of(stream.fileno()) != stamp:
            raise changed(path)
    return Reader(path, stamp[1], stamp), digest.hexdigest(), filled
