"""The hard cases through every approach: which hold, which are wrong and how, which fail."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import TYPE_CHECKING

from drysim.approach import EXACT, SHELF
from drysim.core.compiled import PLAIN_STEPS, engine, settle
from drysim.errors import EXIT_CHECK_FAILED, EXIT_NUMERICS_FAILED, EXIT_OK
from drysim.metrics import Metrics
from drysim.scenario import load
from drysim.scenario.sweep.axis import points
from drysim.study import gallery
from drysim.study.bench.patience import tried
from drysim.study.bench.trial import FAILED, WRONG, Solved, Trial, judged
from drysim.study.case import assemble, prepare
from drysim.study.sweeps.cases import Motions

if TYPE_CHECKING:
    from drysim.scenario import Scenario


@dataclass(frozen=True, eq=False)
class Ordeal:
    """A hard case with its trials, one for every approach of the shelf."""

    scenario: Scenario
    trials: tuple[Trial, ...]


@dataclass(frozen=True, eq=False)
class Ordeals:
    """All hard cases."""

    cases: tuple[Ordeal, ...]
    engine: str

    def exit_code(self) -> int:
        """Give 3 when the exact approach failed, 1 when it was wrong; others are findings."""
        words = {
            one.word for case in self.cases for one in case.trials if one.approach == EXACT
        }
        if FAILED in words:
            return EXIT_NUMERICS_FAILED
        return EXIT_CHECK_FAILED if WRONG in words else EXIT_OK


def scenarios(file: str | None, changes: Sequence[str]) -> list[Scenario]:
    """Give the hard cases of the gallery, or the one that is named, ready to be solved.

    Raises
    ------
    ScenarioError
        With every problem of a file.
    """
    files = [file] if file else [piece.file for piece in gallery.pieces(gallery.HARD)]
    cases = [load(one, list(changes)) for one in files]
    for case in cases:
        prepare(case)
    return cases


def run(cases: Sequence[Scenario], patience: float, finished: Callable[[], None]) -> Ordeals:
    """Put every approach through every case; each may take so long [s] for one of them."""
    settle(PLAIN_STEPS + 1)
    return Ordeals(tuple(ordeal(case, patience, finished) for case in cases), engine())


def ordeal(scenario: Scenario, patience: float, finished: Callable[[], None]) -> Ordeal:
    """Put every approach through one case."""
    answers: dict[str, tuple[Solved | str, float]] = {}
    for name in (EXACT, *(name for name in SHELF if name != EXACT)):
        begin = perf_counter()
        answer = tried(partial(solved, scenario, name), patience)
        answers[name] = answer, perf_counter() - begin
        finished()
    exact, free = answers[EXACT][0], answers["viscous"][0]
    return Ordeal(
        scenario,
        tuple(judged(name, *found, exact, free) for name, found in answers.items()),
    )


def solved(scenario: Scenario, name: str) -> Solved:
    """Give the metrics of every point of a case under an approach, and what the checks say."""
    from drysim.study.run import solve  # files are written without it

    motions, checks = Motions(), []
    found: list[Metrics] = []
    for point in points(scenario.sweep):
        own = scenario.at(point).with_approach(name)
        outcome = solve(assemble(own, motions.of(own)))
        found.append(outcome.metrics)
        checks += [verdict for verdict in outcome.checks if verdict.passed is not None]
    return Solved(found, len(checks), sum(verdict.passed is True for verdict in checks))
