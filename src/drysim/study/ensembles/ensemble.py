"""Ensemble: a scenario under many seeds of its base motion, and what they have in common."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from drysim.core import compiled
from drysim.errors import SolverError
from drysim.study.base_motion import base_motion
from drysim.study.brief import judged, line, values
from drysim.study.case import Case, assemble
from drysim.study.ensembles.by_seed import rows_of, threads
from drysim.study.ensembles.seeds import most, of_seed
from drysim.study.ensembles.statistics import Statistic, statistics
from drysim.study.outcome import exit_code
from drysim.study.sweeps.table import FAILED, OK, Row
from drysim.wording import several

if TYPE_CHECKING:
    from drysim.approach.events import Events
    from drysim.approach.response import Response
    from drysim.checks import Verdict
    from drysim.errors import Caution
    from drysim.metrics import Values
    from drysim.scenario import Scenario
    from drysim.study.outcome import Outcome


Finished = Callable[[int, Row], None]


def nothing(number: int, row: Row) -> None:
    """Do nothing with a finished seed."""


@dataclass(frozen=True, eq=False)
class Ensemble:
    """A scenario under many seeds.

    Attributes
    ----------
    scenario : Scenario
        What was asked.
    rows : tuple of Row
        One for each seed, in order.
    statistics : mapping
        `Statistic` by name of the metric; None where no seed knows it.
    shown : Outcome
        The first seed that has numbers, as a run of its own: with its response.
    checks : tuple of Verdict
        On the means.
    warnings : tuple of Caution
    complete : bool
        Whether every seed was computed that is needed.
    """

    scenario: Scenario
    rows: tuple[Row, ...]
    statistics: Mapping[str, Statistic | None]
    shown: Outcome
    checks: tuple[Verdict, ...] = ()
    warnings: tuple[Caution, ...] = ()
    complete: bool = True

    @property
    def metrics(self) -> Values:
        """The mean of every metric over the seeds that know it, SI."""
        return {name: found and found.mean for name, found in self.statistics.items()}

    @property
    def response(self) -> Response:
        """The response of the first seed."""
        return self.shown.response

    @property
    def events(self) -> Events:
        """The events of the first seed."""
        return self.shown.events

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds, in order."""
        return tuple(row.seed for row in self.rows)

    def __repr__(self) -> str:
        """Give what came out, in a line."""
        kept, many = judged(self.checks, self.warnings), several(len(self.rows), "seed")
        return line("Ensemble", self.scenario.name, many, values(self.metrics), kept)

    def exit_code(self, strict: bool = False) -> int:
        """Give 3 when a seed failed, 1 when a check did; `strict` counts warnings as checks."""
        lost = any(row.status == FAILED for row in self.rows)
        return exit_code(self.checks, self.warnings, strict, lost)


def solve(
    case: Case,
    *,
    workers: int | None = None,
    done: Mapping[int, Row] | None = None,
    finished: Finished = nothing,
) -> Ensemble:
    """Give the ensemble of a case that is ready to be solved.

    Parameters
    ----------
    case : Case
        Of the first seed.
    workers : int, optional
        Threads; default: one for each processor. The ensemble does not depend on it.
    done : mapping, optional
        Rows by number of the seed, from 0, that an interrupted run has left.
    finished : callable, optional
        Called with number and row of every seed as it is computed, in order.

    Raises
    ------
    SolverError
        When the numerics fail with every seed.
    """
    compiled.settle(case.work * most(case.scenario), case.price.kernels)
    rows: list[Row] = []
    for row in rows_of(case.scenario, threads(case, workers), done or {}):
        if len(rows) not in (done or {}):
            finished(len(rows), row)
        rows.append(row)
    return ensemble_of(case, rows)


def ensemble_of(case: Case, rows: Sequence[Row], complete: bool = True) -> Ensemble:
    """Give the ensemble of finished seeds, with all verdicts; errors as in `solve`."""
    from drysim.study import run
    from drysim.study.ensembles import doubts

    scenario, good = case.scenario, [row for row in rows if row.status == OK]
    if not good:
        raise SolverError(f"the numerics fail with every seed; the first says: {rows[0].note}")
    alone = of_seed(scenario, good[0].seed)
    shown = run.solve(assemble(alone, base_motion(alone)))
    found = statistics(good)
    means = {name: one and one.mean for name, one in found.items()}
    verdicts = tuple(
        doubts.of_statistic(check.judge(means), found[check.metric])
        for check in scenario.checks
    )
    warnings = tuple(doubts.remarks(case, rows, found, verdicts, shown))
    return Ensemble(scenario, tuple(rows), found, shown, verdicts, warnings, complete)
