"""Sequences whose values are made when they are asked for."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from operator import index
from typing import TypeVar, overload

Made = TypeVar("Made", covariant=True)


class Lazy(Sequence[Made]):
    """A sequence of a known length that makes one value at a time, and holds none."""

    @abstractmethod
    def one(self, number: int) -> Made:
        """Give the value of a number from 0 to the length less 1."""

    @overload
    def __getitem__(self, number: int) -> Made: ...
    @overload
    def __getitem__(self, number: slice) -> Sequence[Made]: ...
    def __getitem__(self, number: int | slice) -> Made | Sequence[Made]:
        """Give one value, or some."""
        if isinstance(number, slice):
            return [self.one(i) for i in range(*number.indices(len(self)))]
        at, count = index(number), len(self)
        if not -count <= at < count:
            raise IndexError(f"there is no number {at} among {count}, counted from 0")
        return self.one(at % count)
