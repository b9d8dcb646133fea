"""Load: how many blocks go to a worker together, so that handing them out costs little."""

from __future__ import annotations

from collections.abc import Sequence

WORK = 0.5
"""Work that goes together [s]: a task of its own costs scheduler, worker and client some 6 ms
of processor time, however little there is in it."""

MOST_BYTES = 16_000_000
"""Bytes that come back together at most: a scheduler passes them on whole."""


class Load:
    """What the blocks that have come tell of those to come.

    The first go one by one: nobody knows yet what they take. The last go one by one, too, so
    that no worker is left with many of them while others have none.

    Parameters
    ----------
    count : int
        How many blocks there are, those included that nobody wants any more.
    """

    def __init__(self, count: int) -> None:
        self._count = self._left = count
        self._fit = 1

    def blocks(self, room: int) -> int:
        """Give how many go together now, where so many tasks may be under way."""
        return max(1, min(self._fit, self._left // room))

    def sent(self, numbers: Sequence[int]) -> None:
        """Note which blocks are on their way."""
        self._left = self._count - numbers[-1] - 1

    def took(self, blocks: Sequence[bytes | None], seconds: float) -> None:
        """Note how long some blocks took."""
        size = sum(map(len, filter(None, blocks)))
        share = max(seconds / WORK, size / MOST_BYTES, 1e-9)
        self._fit = max(1, int(len(blocks) / share))
