"""Comparison: what approaches and laws make of one base motion, and how far they are apart."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Set
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from drysim.errors import UsageError
from drysim.quantity import short
from drysim.study.brief import line
from drysim.study.ensembles.statistics import interval
from drysim.study.sweeps.table import Row

if TYPE_CHECKING:
    from drysim.approach.response import Response
    from drysim.study.sweeps.table import Table


@dataclass(frozen=True, eq=False)
class Comparison:
    """Several approaches, or friction laws, on the very same base motion.

    Attributes
    ----------
    table : Table
        One row for each word and case; a row's approach is the word.
    yardstick : str
        The word that the others are measured against.
    responses : mapping
        Response of each approach for one case, for a picture of the motion itself.
    shown : mapping
        The swept values of that case; empty without a sweep.
    verdict : tuple of str
        What the comparison says, in sentences; the first is the verdict itself.
    laws : mapping
        The friction law behind each word; empty for none.
    """

    table: Table
    yardstick: str
    responses: Mapping[str, Response]
    shown: Mapping[str, float]
    verdict: tuple[str, ...]
    laws: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Give the verdict, in a line."""
        words = f"{', '.join(self.table.approaches)} against {self.yardstick}"
        return line("Comparison", self.table.scenario.name, words, *self.verdict[:1])

    @property
    def of_laws(self) -> bool:
        """Whether any of the words is a friction law."""
        return any(word == law for word, law in self.laws.items())

    def counterpart(self, row: Row) -> Row | None:
        """Give the yardstick's row at the same point; None where there is no single one.

        A key that the yardstick has no use for takes no part.
        """
        return self._yardstick_rows.get(_place(row, self._yardstick_keys))

    def deviation(self, row: Row) -> float | None:
        """Give T_a of a row relative to the yardstick's at the same point, minus 1 [-].

        Of many seeds it is the mean over those that both have, compared seed by seed.
        """
        if not isinstance(row, Row) or row != self._rows.get(_mark(row)):
            given = short(repr(row))
            raise UsageError(f"a deviation is that of a row of the table, not of {given}")
        found = self.off(row)
        return found[0] if found else None

    def off(self, row: Row) -> tuple[float, float | None] | None:
        """Give the deviation of a row and, of a mean, the half-width of its interval."""
        other = self.counterpart(row)
        return off_by(row, other) if other else None

    def pairs(self, approach: str) -> Iterator[tuple[Row, Row]]:
        """Give the rows of an approach, each with the yardstick's row at the same point.

        Where the approach has no use for a key of the yardstick, its row stands for many.
        """
        own = list(self.table.of(approach))
        keys: Set[str] = own[0].point.keys() if own else frozenset()
        if not self._yardstick_keys - keys:
            found = ((row, self.counterpart(row)) for row in own)
            yield from ((row, other) for row, other in found if other is not None)
            return
        places = {_place(row, keys): row for row in own}
        for other in self.table.of(self.yardstick):
            if (row := places.get(_place(other, keys))) is not None:
                yield row, other

    @cached_property
    def _rows(self) -> dict[tuple[str, frozenset[tuple[str, float]]], Row]:
        return {_mark(row): row for row in self.table.rows}

    @cached_property
    def _yardstick_keys(self) -> Set[str]:
        return next((row.point.keys() for row in self.table.of(self.yardstick)), frozenset())

    @cached_property
    def _yardstick_rows(self) -> dict[frozenset[tuple[str, float]], Row]:
        rows = self.table.of(self.yardstick)
        return {_place(row, self._yardstick_keys): row for row in rows}


def off_by(row: Row, other: Row) -> tuple[float, float | None] | None:
    """Give T_a of a row relative to another's, minus 1 [-], and the half-width of its interval.

    None where T_a is not known; no half-width where it is no mean over seeds.
    """
    if row.over and other.over:
        pairs = zip(row.over.T_a, other.over.T_a, strict=False)
        found = [own / theirs - 1.0 for own, theirs in pairs if own is not None and theirs]
        return interval(found) if found else None
    own, theirs = row.metrics.get("T_a"), other.metrics.get("T_a")
    return (own / theirs - 1.0, None) if own is not None and theirs else None


def _mark(row: Row) -> tuple[str, frozenset[tuple[str, float]]]:
    """Give what tells a row of a table from all others."""
    return row.approach, frozenset(row.point.items())


def _place(row: Row, keys: Collection[str]) -> frozenset[tuple[str, float]]:
    """Give what a row is at, as far as some keys tell."""
    return frozenset((key, value) for key, value in row.point.items() if key in keys)
