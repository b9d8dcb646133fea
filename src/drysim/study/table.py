"""Table: the outcomes of many cases, without their responses."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from drysim.errors import EXIT_CHECK_FAILED, EXIT_NUMERICS_FAILED, EXIT_OK

if TYPE_CHECKING:
    from drysim.approach.response import Response
    from drysim.checks import Verdict
    from drysim.core.motion import Samples, Sines
    from drysim.errors import Caution
    from drysim.scenario import Axis, Scenario
    from drysim.study.tally import Tally

OK = "ok"
NOT_SETTLED = "not settled"
NOT_UNIQUE = "not unique"
FAILED = "failed"


@dataclass(frozen=True)
class Row:
    """One case of a sweep, solved by one approach.

    Attributes
    ----------
    point : mapping
        Swept keys and their values in SI, in the order of the axes; a key that the approach has
        no use for (friction under `viscous`) is missing.
    approach : str
        Name on the shelf.
    F_fk, F_fs : float
        Friction forces [N].
    metrics : mapping
        As `drysim.metrics.measure` gives them; all None where the status is not `ok`.
    status : str
        `ok`, `not settled`, `not unique` or `failed`.
    note : str
        What is to be said about a status other than `ok`.
    sha256 : str
        Of the base acceleration (hex), where the case is one seed of many.
    """

    point: Mapping[str, float]
    approach: str
    F_fk: float
    F_fs: float
    metrics: Mapping[str, float | int | None]
    status: str = OK
    note: str = ""
    sha256: str = ""


@dataclass(frozen=True, eq=False)
class Table:
    """All cases of a sweep or of a comparison.

    Attributes
    ----------
    scenario : Scenario
    axes : tuple of Axis
        Swept keys with unit and values; the first varies fastest. Empty for a comparison of one
        case.
    rows : sequence of Row
        Approach by approach, each in the order of the grid.
    checks : tuple of Verdict
    warnings : tuple of Caution
    complete : bool
        Whether every case was computed.
    motion : Sines or Samples or None
        The base motion, where all cases share one.
    numerics : mapping
        How the numbers were made, as far as all cases share it: core, why, engine, ...
    told : mapping
        What the cases of each approach come to, where it was gathered as they were computed.
    """

    scenario: Scenario
    axes: tuple[Axis, ...]
    rows: Sequence[Row]
    checks: tuple[Verdict, ...] = ()
    warnings: tuple[Caution, ...] = ()
    complete: bool = True
    motion: Sines | Samples | None = None
    numerics: Mapping[str, object] = field(default_factory=dict)
    told: Mapping[str, Tally] = field(default_factory=dict)

    def __len__(self) -> int:
        """Give the number of rows."""
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        """Give the rows in order."""
        return iter(self.rows)

    def __getitem__(self, number: int) -> Row:
        """Give one row."""
        return self.rows[number]

    @property
    def approaches(self) -> tuple[str, ...]:
        """The approaches in the order in which they were asked for."""
        return tuple(self.tallies)

    @cached_property
    def tallies(self) -> Mapping[str, Tally]:
        """What the cases come to, by approach; the one that was asked for comes first."""
        from drysim.study.rows import batches_of
        from drysim.study.tally import Tally

        return self.told or Tally.of(batches_of(self.rows))

    def exit_code(self, strict: bool = False) -> int:
        """Give 3 when a case failed, 1 when a check did; `strict` counts warnings as checks."""
        if any(FAILED in tally.lost for tally in self.tallies.values()):
            return EXIT_NUMERICS_FAILED
        failed = not all(verdict.passed for verdict in self.checks)
        return EXIT_CHECK_FAILED if failed or (strict and self.warnings) else EXIT_OK

    @property
    def own(self) -> tuple[Row, ...]:
        """The rows of the approach that was asked for, those of its reference left aside."""
        return tuple(self.of(self.approaches[0])) if self.rows else ()

    def of(self, approach: str) -> Iterator[Row]:
        """Give the rows of one approach."""
        return (row for row in self.rows if row.approach == approach)


@dataclass(frozen=True, eq=False)
class Comparison:
    """Several approaches on the very same base motion.

    Attributes
    ----------
    table : Table
        One row for each approach and case.
    yardstick : str
        The approach that the others are measured against.
    responses : mapping
        Response of each approach for one case, for a picture of the motion itself.
    shown : mapping
        The swept values of that case; empty without a sweep.
    verdict : tuple of str
        What the comparison says, in sentences; the first is the verdict itself.
    """

    table: Table
    yardstick: str
    responses: Mapping[str, Response]
    shown: Mapping[str, float]
    verdict: tuple[str, ...]

    def counterpart(self, row: Row) -> Row | None:
        """Give the yardstick's row at the same point; None where there is no single one.

        A key that the yardstick has no use for takes no part.
        """
        return self._yardstick_rows.get(_place(row, self._yardstick_keys))

    def deviation(self, row: Row) -> float | None:
        """Give T_a of a row relative to the yardstick's at the same point, minus 1 [-]."""
        other = self.counterpart(row)
        own, theirs = row.metrics.get("T_a"), other.metrics.get("T_a") if other else None
        return own / theirs - 1.0 if own is not None and theirs else None

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
    def _yardstick_keys(self) -> Set[str]:
        return next((row.point.keys() for row in self.table.of(self.yardstick)), frozenset())

    @cached_property
    def _yardstick_rows(self) -> dict[frozenset[tuple[str, float]], Row]:
        rows = self.table.of(self.yardstick)
        return {_place(row, self._yardstick_keys): row for row in rows}


def _place(row: Row, keys: Collection[str]) -> frozenset[tuple[str, float]]:
    """Give what a row is at, as far as some keys tell."""
    return frozenset((key, value) for key, value in row.point.items() if key in keys)
