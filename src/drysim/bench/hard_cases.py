"""`drysim bench --hard`: every approach through the hard cases of the gallery.

The exact approach is held to the checks of every case, the others to the exact one: which
hold, which are wrong and how, which fail.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple

from drysim.approach import EXACT, SHELF
from drysim.bench.timing import tried
from drysim.core.compile import PLAIN_STEPS, engine, settle
from drysim.errors import EXIT_CHECK_FAILED, EXIT_NUMERICS_FAILED, EXIT_OK
from drysim.metrics.table import Metrics
from drysim.scenario.axes import points
from drysim.scenario.load import load
from drysim.study import gallery
from drysim.study.case import assemble, prepare
from drysim.study.run import Motions
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.scenario.model import Scenario


HELD, WRONG, FAILED = "held", "wrong", "failed"

UNPROMISED = "no checks"
"""What the exact approach comes to where nothing is promised: it is held to nothing then."""

TOLERANCE = 0.01
"""How far T_a, the RMS and the peak of x_r may be off [-]: what nobody minds."""

COMPARED = ("T_a", "x_r_peak", "x_r_rms")
"""The metrics by which an answer is told from the exact one."""

TOO_LARGE, BLOWN = 10.0, 1e6
"""Errors [-] from which a multiple says more than percents, and no number says anything."""


class Trial(NamedTuple):
    """One approach on one hard case.

    Attributes
    ----------
    approach : str
    word : str
        `held`, `wrong` or `failed`; `no checks` of the exact one where nothing is promised.
    how : str
        The worst metric and by how much it is off, or why the approach failed.
    deviations : mapping
        The greatest deviation of every compared metric [-], where it is known.
    checks, passed : int
        Checks that apply to the case, and those that passed.
    time : float
        Time of all its points [s].
    """

    approach: str
    word: str
    how: str
    deviations: Mapping[str, float]
    checks: int
    passed: int
    time: float


class Solved(NamedTuple):
    """What an approach made of every point of a case: metrics, and checks as (all, passed)."""

    metrics: list[Metrics]
    checks: int
    passed: int


def judged(
    name: str, answer: Solved | str, time: float, exact: Solved | str, free: Solved | str
) -> Trial:
    """Give the verdict on one approach: held to the checks, or to the exact one."""
    if isinstance(answer, str):
        return Trial(name, FAILED, answer, {}, 0, 0, time)
    found = (answer.checks, answer.passed, time)
    if name == EXACT:
        missed = answer.checks - answer.passed
        how = f"{missed} of {answer.checks} checks fail" if missed else ""
        word = HELD if answer.checks else UNPROMISED
        return Trial(name, WRONG if missed else word, how, {}, *found)
    if isinstance(exact, str):
        return Trial(name, FAILED, f"nothing to hold it to: {exact}", {}, *found)
    off = deviations(answer, exact, free)
    worst = max(off, key=lambda metric: abs(off[metric]), default="")
    if not worst or abs(off[worst]) <= TOLERANCE:
        return Trial(name, HELD, "", off, *found)
    return Trial(name, WRONG, spoken(worst, off[worst]), off, *found)


def deviations(answer: Solved, exact: Solved, free: Solved | str) -> dict[str, float]:
    """Give the greatest deviation of every compared metric over all points of a case.

    A mass that should never move is off by what it moves, relative to the motion without
    friction.
    """
    frees: list[Metrics] = (
        [{} for _ in exact.metrics] if isinstance(free, str) else free.metrics
    )
    worst: dict[str, float] = {}
    for own, theirs, bare in zip(answer.metrics, exact.metrics, frees, strict=True):
        for metric in COMPARED:
            value, known = own.get(metric), theirs.get(metric)
            scale = known or bare.get(metric) or 1.0
            if value is not None and known is not None:
                off = (value - known) / scale
                worst[metric] = max(worst.get(metric, 0.0), off, key=abs)
    return worst


def spoken(metric: str, off: float) -> str:
    """Give a deviation in words, e.g. `T_a +84 %`."""
    word = metric.replace("x_r_peak", "peak").replace("x_r_rms", "x_r")
    if off > BLOWN:
        return "blows up"
    if off > TOO_LARGE:
        return f"{word} ×{number(1.0 + off, digits=2)}"
    return f"{word} {'+' if off > 0.0 else ''}{number(100.0 * off, '%', 2)}"


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
