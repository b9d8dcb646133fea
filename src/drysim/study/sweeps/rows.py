"""The rows of a sweep, made from blocks when they are asked for, so that none need be held."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from itertools import accumulate, chain, groupby

from drysim.scenario.sweep.lazy import Lazy
from drysim.study.sweeps.batch import Batch
from drysim.study.sweeps.table import Row

HELD = 20_000
"""Rows up to which they are made once and held: some 30 MB."""

AT_A_TIME = 4096
"""Rows that are gathered into a block."""


class Rows(Lazy[Row]):
    """The rows of blocks that follow each other."""

    def __init__(self, batches: Sequence[Batch], firsts: Sequence[int], length: int) -> None:
        self.batches = batches
        self._firsts = firsts
        self._length = length
        self._held: tuple[Row, ...] | None = None

    @classmethod
    def of(cls, batches: Sequence[Batch], lengths: Sequence[int] = ()) -> Rows:
        """Give the rows of blocks; their lengths, where the blocks are not at hand."""
        ends = [0, *accumulate(lengths or map(len, batches))]
        return cls(batches, ends[:-1], ends[-1])

    def __len__(self) -> int:
        """Give the number of rows."""
        return self._length

    def __iter__(self) -> Iterator[Row]:
        """Give the rows in order."""
        if self._length > HELD:
            return chain.from_iterable(self.batches)
        if self._held is None:
            self._held = tuple(chain.from_iterable(self.batches))
        return iter(self._held)

    def one(self, number: int) -> Row:
        """Give one row."""
        at = bisect_right(self._firsts, number) - 1
        return self.batches[at].row(number - self._firsts[at])


def batches_of(rows: Iterable[Row]) -> Iterable[Batch]:
    """Give rows as blocks, each of one approach."""
    if isinstance(rows, Rows):
        return rows.batches
    return _gathered(rows)


def _gathered(rows: Iterable[Row]) -> Iterator[Batch]:
    first = 0
    for _, group in groupby(rows, key=lambda row: (row.approach, tuple(row.point))):
        several = list(group)
        for at in range(0, len(several), AT_A_TIME):
            part = several[at : at + AT_A_TIME]
            yield Batch.of(first, part)
            first += len(part)
