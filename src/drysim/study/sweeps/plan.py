"""Plan: a sweep as pieces, blocks of cases that follow each other.

What a piece holds depends on the scenario and its number alone.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import TYPE_CHECKING, NamedTuple, Self

from drysim.scenario.sweep.axis import columns_of, size
from drysim.scenario.sweep.lazy import Lazy
from drysim.study.sweeps import orbits
from drysim.study.sweeps.batch import Batch
from drysim.study.sweeps.cases import Job, Motions
from drysim.study.sweeps.over_seeds import ALONE, Crew, row_of

if TYPE_CHECKING:
    from drysim.scenario import Scenario
    from drysim.study.case import Case

TOGETHER = ((1 << 17, 512), (1 << 27, 4096), (None, 65_536))
"""Up to so many cases, so many orbits to a call of the kernel: 10 ms of work, beside which the
rest of a call is a tenth; of more cases longer calls, lest there be too many blocks."""

MOST_BLOCKS, MOST_ALONE = 4096, 64
"""Blocks that cases which are solved one by one are cut into, and cases of one at most."""


class Piece(NamedTuple):
    """Cases of one approach that are solved at a time.

    Attributes
    ----------
    scenario : Scenario
        Of the approach, with its sweep block.
    first : int
        Number of the first case among those of all approaches.
    begin, end : int
        Numbers of the first case and of the one after the last in the approach's own grid.
    """

    scenario: Scenario
    first: int
    begin: int
    end: int


class Pieces(Lazy[Piece]):
    """The pieces of every scenario, in order; each is made from its number when asked for."""

    def __init__(self, scenarios: Sequence[Scenario]) -> None:
        self.scenarios = tuple(scenarios)
        self.cases = [size(scenario.sweep) for scenario in scenarios]
        together = map(orbits.together, scenarios)
        self._steps = [length_of(*one) for one in zip(self.cases, together, strict=True)]
        self._counts = [-(-n // step) for n, step in zip(self.cases, self._steps, strict=True)]
        self._ends = list(accumulate(self._counts))

    def __len__(self) -> int:
        """Give the number of pieces."""
        return self._ends[-1]

    def one(self, number: int) -> Piece:
        """Give one piece."""
        i = bisect_right(self._ends, number)
        begin = (number - self._ends[i] + self._counts[i]) * self._steps[i]
        end = min(begin + self._steps[i], self.cases[i])
        return Piece(self.scenarios[i], sum(self.cases[:i]) + begin, begin, end)


def length_of(cases: int, together: bool) -> int:
    """Give the length of the pieces of so many cases; the same on every machine."""
    if together:
        return next(step for most, step in TOGETHER if most is None or cases <= most)
    return min(max(1, cases // MOST_BLOCKS), MOST_ALONE)


def solve_piece(piece: Piece, motions: Motions, crew: Crew = ALONE) -> Batch:
    """Give the cases of a piece, solved; errors as in `sweep`."""
    scenario, first, begin, end = piece
    if orbits.together(scenario):
        return orbits.solve(scenario, first, begin, end)
    points = columns_of(scenario.sweep, begin, end)
    rows = [
        row_of(Job(first + i, scenario, point), motions, crew)
        for i in range(end - begin)
        for point in [{key: column[i].item() for key, column in points.items()}]
    ]
    return Batch.of(first, rows)


@dataclass(frozen=True, eq=False)
class Plan:
    """The blocks of a sweep, which threads, processes and other machines compute alike.

    Attributes
    ----------
    pieces : Pieces
        Which cases each block holds.
    motions : Motions
        Base motions that blocks have in common: kept, not part of what a block depends on.
    """

    pieces: Pieces
    motions: Motions = field(default_factory=Motions)

    @classmethod
    def of(cls, scenarios: Sequence[Scenario], case: Case) -> Self:
        """Give the plan of the approaches to a case whose base motion is known."""
        return cls(Pieces(scenarios), Motions.beginning_with(case))

    def block(self, number: int, crew: Crew = ALONE) -> Batch:
        """Give a block of cases by its number; errors as in `sweep`."""
        return solve_piece(self.pieces[number], self.motions, crew)
