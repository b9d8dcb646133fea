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

from drysim.approach import APPROACHES_BY_NAME, EXACT
from drysim.bench.timing import try_within
from drysim.core.compile import MAX_PLAIN_STEPS, choose_engine, engine
from drysim.errors import EXIT_CHECK_FAILED, EXIT_NUMERICS_FAILED, EXIT_OK
from drysim.metrics.table import Metrics
from drysim.scenario.axes import iter_points
from drysim.scenario.load import load
from drysim.study import gallery
from drysim.study.case import assemble, prepare
from drysim.study.run import MotionCache
from drysim.wording import format_number

if TYPE_CHECKING:
    from drysim.scenario.model import Scenario


HELD, WRONG, FAILED = "held", "wrong", "failed"

NO_CHECKS = "no checks"
"""What the exact approach comes to where nothing is promised: it is held to nothing then."""

TOLERANCE = 0.01
"""How far T_a, the RMS and the peak of x_r may be off [-]: what nobody minds."""

COMPARED_METRICS = ("T_a", "x_r_peak", "x_r_rms")
"""The metrics by which an answer is told from the exact one."""

FACTOR_ABOVE, BLOW_UP_ABOVE = 10.0, 1e6
"""Errors [-] from which a multiple says more than percents, and no number says anything."""


class HardCaseResult(NamedTuple):
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


class CaseMetrics(NamedTuple):
    """What an approach made of every point of a case: metrics, and checks as (all, passed)."""

    metrics: list[Metrics]
    checks: int
    passed: int


def judge(
    name: str,
    answer: CaseMetrics | str,
    time: float,
    exact: CaseMetrics | str,
    free: CaseMetrics | str,
) -> HardCaseResult:
    """Give the verdict on one approach: held to the checks, or to the exact one."""
    if isinstance(answer, str):
        return HardCaseResult(name, FAILED, answer, {}, 0, 0, time)
    found = (answer.checks, answer.passed, time)
    if name == EXACT:
        failed = answer.checks - answer.passed
        how = f"{failed} of {answer.checks} checks fail" if failed else ""
        word = HELD if answer.checks else NO_CHECKS
        return HardCaseResult(name, WRONG if failed else word, how, {}, *found)
    if isinstance(exact, str):
        return HardCaseResult(name, FAILED, f"nothing to hold it to: {exact}", {}, *found)
    off = largest_deviations(answer, exact, free)
    worst = max(off, key=lambda metric: abs(off[metric]), default="")
    if not worst or abs(off[worst]) <= TOLERANCE:
        return HardCaseResult(name, HELD, "", off, *found)
    return HardCaseResult(name, WRONG, format_deviation(worst, off[worst]), off, *found)


def largest_deviations(
    answer: CaseMetrics, exact: CaseMetrics, free: CaseMetrics | str
) -> dict[str, float]:
    """Give the greatest deviation of every compared metric over all points of a case.

    A mass that should never move is off by what it moves, relative to the motion without
    friction.
    """
    frees: list[Metrics] = (
        [{} for _ in exact.metrics] if isinstance(free, str) else free.metrics
    )
    worst: dict[str, float] = {}
    for own, reference, frictionless in zip(answer.metrics, exact.metrics, frees, strict=True):
        for metric in COMPARED_METRICS:
            value, known = own.get(metric), reference.get(metric)
            scale = known or frictionless.get(metric) or 1.0
            if value is not None and known is not None:
                off = (value - known) / scale
                worst[metric] = max(worst.get(metric, 0.0), off, key=abs)
    return worst


def format_deviation(metric: str, off: float) -> str:
    """Give a deviation in words, e.g. `T_a +84 %`."""
    word = metric.replace("x_r_peak", "peak").replace("x_r_rms", "x_r")
    if off > BLOW_UP_ABOVE:
        return "blows up"
    if off > FACTOR_ABOVE:
        return f"{word} ×{format_number(1.0 + off, digits=2)}"
    return f"{word} {'+' if off > 0.0 else ''}{format_number(100.0 * off, '%', 2)}"


@dataclass(frozen=True, eq=False)
class HardCase:
    """A hard case with its trials, one for every approach of the shelf."""

    scenario: Scenario
    results: tuple[HardCaseResult, ...]


@dataclass(frozen=True, eq=False)
class HardCases:
    """All hard cases."""

    cases: tuple[HardCase, ...]
    engine: str

    def exit_code(self) -> int:
        """Give 3 when the exact approach failed, 1 when it was wrong; others are findings."""
        words = {
            one.word for case in self.cases for one in case.results if one.approach == EXACT
        }
        if FAILED in words:
            return EXIT_NUMERICS_FAILED
        return EXIT_CHECK_FAILED if WRONG in words else EXIT_OK


def load_scenarios(file: str | None, changes: Sequence[str]) -> list[Scenario]:
    """Give the hard cases of the gallery, or the one that is named, ready to be solved.

    Raises
    ------
    ScenarioError
        With every problem of a file.
    """
    files = (
        [file]
        if file
        else [entry.file for entry in gallery.list_scenarios(gallery.HARD_FOLDER)]
    )
    cases = [load(one, list(changes)) for one in files]
    for case in cases:
        prepare(case)
    return cases


def run(cases: Sequence[Scenario], patience: float, finished: Callable[[], None]) -> HardCases:
    """Put every approach through every case; each may take so long [s] for one of them."""
    choose_engine(MAX_PLAIN_STEPS + 1)
    return HardCases(tuple(run_case(case, patience, finished) for case in cases), engine())


def run_case(scenario: Scenario, patience: float, finished: Callable[[], None]) -> HardCase:
    """Put every approach through one case."""
    answers: dict[str, tuple[CaseMetrics | str, float]] = {}
    for name in (EXACT, *(name for name in APPROACHES_BY_NAME if name != EXACT)):
        begin = perf_counter()
        answer = try_within(partial(solve_case, scenario, name), patience)
        answers[name] = answer, perf_counter() - begin
        finished()
    exact, free = answers[EXACT][0], answers["viscous"][0]
    return HardCase(
        scenario,
        tuple(judge(name, *found, exact, free) for name, found in answers.items()),
    )


def solve_case(scenario: Scenario, name: str) -> CaseMetrics:
    """Give the metrics of every point of a case under an approach, and what the checks say."""
    from drysim.study.run import solve  # files are written without it

    motions, checks = MotionCache(), []
    found: list[Metrics] = []
    for point in iter_points(scenario.sweep):
        own = scenario.at(point).with_approach(name)
        outcome = solve(assemble(own, motions.of(own)))
        found.append(outcome.metrics)
        checks += [verdict for verdict in outcome.checks if verdict.passed is not None]
    return CaseMetrics(found, len(checks), sum(verdict.passed is True for verdict in checks))
