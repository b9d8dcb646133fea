"""Plan: a sweep as blocks; what a block holds depends on the scenario and its number alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self

from drysim.study.sweeps.cases import Motions
from drysim.study.sweeps.over_seeds import ALONE, Crew
from drysim.study.sweeps.pieces import Pieces, solve_piece

if TYPE_CHECKING:
    from drysim.scenario import Scenario
    from drysim.study.case import Case
    from drysim.study.sweeps.batch import Batch


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
