"""`drysim bench --hard`: every approach on the hard cases of the gallery.

The exact approach is judged by the checks of the case, every other approach by its deviation
from the exact one. The verdict is `held`, `wrong` or `failed`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from drysim.approach import APPROACHES_BY_NAME, EXACT
from drysim.bench.timing import try_within
from drysim.core.compile import MAX_PLAIN_STEPS, choose_engine, engine
from drysim.errors import EXIT_CHECK_FAILED, EXIT_NUMERICS_FAILED, EXIT_OK, WarningMessage
from drysim.metrics.table import Metrics
from drysim.scenario.axes import iter_points
from drysim.scenario.load import load
from drysim.study import gallery
from drysim.study.outcome import Result, format_repr
from drysim.study.preparation import assemble, prepare
from drysim.study.run import MotionCache
from drysim.wording import format_count, format_deviation, format_number

if TYPE_CHECKING:
    from drysim.metrics.checks import Verdict
    from drysim.scenario.model import Scenario


HELD, WRONG, FAILED = "held", "wrong", "failed"

NO_CHECKS = "no checks"
"""Verdict on the exact approach in a case without checks."""

TOLERANCE = 0.01
"""Largest accepted deviation of T_a, RMS and peak of x_r [-]: negligible in practice."""

COMPARED_METRICS = {"T_a": "T_a", "x_r_peak": "peak", "x_r_rms": "x_r"}
"""Metrics that are compared with those of the exact approach, and their short labels."""

FACTOR_ABOVE, BLOW_UP_ABOVE = 10.0, 1e6
"""Deviations above which a factor is printed instead of per cent, and "blows up" [-]."""


class HardCaseResult(NamedTuple):
    """Result of one approach on one hard case.

    Attributes
    ----------
    approach : str
    verdict : str
        `held`, `wrong` or `failed`; `no checks` for the exact approach in a case without any.
    reason : str
        The metric with the largest deviation and its deviation, or the reason of the failure.
    deviations : mapping
        Largest deviation of every compared metric [-], where known.
    checks, passed : int
        Number of checks that apply to the case, and of those that passed.
    time : float
        Computing time of all points [s].
    """

    approach: str
    verdict: str
    reason: str
    deviations: Mapping[str, float]
    checks: int
    passed: int
    time: float


class CaseMetrics(NamedTuple):
    """Metrics of an approach at every point of a case, and the numbers of its checks."""

    metrics: list[Metrics]
    checks: int
    passed: int


def judge(
    name: str,
    answer: CaseMetrics | str,
    time: float,
    exact: CaseMetrics | str,
    frictionless: CaseMetrics | str,
) -> HardCaseResult:
    """Return the verdict on one approach.

    Parameters
    ----------
    name : str
        The approach.
    answer : CaseMetrics or str
        Its metrics, or the reason of its failure.
    time : float
        Its computing time [s].
    exact, frictionless : CaseMetrics or str
        The same of the exact approach, and of the oscillator without friction.
    """
    if isinstance(answer, str):
        return HardCaseResult(name, FAILED, answer, {}, 0, 0, time)
    verdict, reason, deviations = HELD, "", dict[str, float]()
    if name == EXACT:
        failed = answer.checks - answer.passed
        if failed:
            verdict, reason = WRONG, f"{failed} of {answer.checks} checks fail"
        elif not answer.checks:
            verdict = NO_CHECKS
    elif isinstance(exact, str):
        verdict, reason = FAILED, f"no exact solution to compare with: {exact}"
    else:
        deviations = largest_deviations(answer, exact, frictionless)
        worst = max(deviations, key=lambda metric: abs(deviations[metric]), default="")
        if worst and abs(deviations[worst]) > TOLERANCE:
            verdict, reason = WRONG, describe_deviation(worst, deviations[worst])
    return HardCaseResult(name, verdict, reason, deviations, answer.checks, answer.passed, time)


def largest_deviations(
    answer: CaseMetrics, exact: CaseMetrics, frictionless_answer: CaseMetrics | str
) -> dict[str, float]:
    """Return the largest deviation of every compared metric over all points of a case [-].

    Where the exact value is zero, as for a mass that never slips, the deviation is relative to
    the value without friction.
    """
    frictionless_metrics: list[Metrics] = (
        [{} for _ in exact.metrics]
        if isinstance(frictionless_answer, str)
        else frictionless_answer.metrics
    )
    worst: dict[str, float] = {}
    for metrics, reference, frictionless in zip(
        answer.metrics, exact.metrics, frictionless_metrics, strict=True
    ):
        for metric in COMPARED_METRICS:
            value, exact_value = metrics.get(metric), reference.get(metric)
            scale = exact_value or frictionless.get(metric) or 1.0
            if value is not None and exact_value is not None:
                deviation = (value - exact_value) / scale
                worst[metric] = max(worst.get(metric, 0.0), deviation, key=abs)
    return worst


def describe_deviation(metric: str, deviation: float) -> str:
    """Return the deviation of a metric, e.g. `T_a +84 %`."""
    label = COMPARED_METRICS[metric]
    if deviation > BLOW_UP_ABOVE:
        return "blows up"
    if deviation > FACTOR_ABOVE:
        return f"{label} ×{format_number(1.0 + deviation, digits=2)}"
    return f"{label} {format_deviation(deviation, digits=2)}"


@dataclass(frozen=True, eq=False)
class HardCase:
    """A hard case with the results of all approaches."""

    scenario: Scenario
    results: tuple[HardCaseResult, ...]


@dataclass(frozen=True, eq=False)
class HardCases(Result):
    """All hard cases."""

    kind: ClassVar[str] = "hard"
    checks: ClassVar[tuple[Verdict, ...]] = ()
    warnings: ClassVar[tuple[WarningMessage, ...]] = ()

    cases: tuple[HardCase, ...]
    engine: str

    def __repr__(self) -> str:
        """Return how many cases each approach holds in one line."""
        held = Counter(
            result.approach
            for case in self.cases
            for result in case.results
            if result.verdict == HELD
        )
        counts = ", ".join(f"{name} {count}" for name, count in held.items())
        cases = format_count(len(self.cases), "case")
        return format_repr("HardCases", cases, f"held by {counts}")

    def exit_code(self, strict: bool = False) -> int:
        """Return the exit code: 3 if the exact approach failed, 1 if it was wrong, else 0."""
        verdicts = {
            result.verdict
            for case in self.cases
            for result in case.results
            if result.approach == EXACT
        }
        if FAILED in verdicts:
            return EXIT_NUMERICS_FAILED
        return EXIT_CHECK_FAILED if WRONG in verdicts else EXIT_OK


def load_scenarios(file: str | None, changes: Sequence[str]) -> list[Scenario]:
    """Load and validate the hard cases of the gallery, or the given file.

    Parameters
    ----------
    file : str or None
    changes : sequence of str
        Changes as KEY=VALUE.

    Raises
    ------
    ScenarioError
        With all errors of a file.
    """
    files = (
        [file]
        if file
        else [entry.file for entry in gallery.list_scenarios(gallery.HARD_FOLDER)]
    )
    cases = [load(path, list(changes)) for path in files]
    for case in cases:
        prepare(case)
    return cases


def run(cases: Sequence[Scenario], patience: float, finished: Callable[[], None]) -> HardCases:
    """Run every approach on every case.

    Parameters
    ----------
    cases : sequence of Scenario
    patience : float
        Time limit of one approach on one case [s].
    finished : callable
        Called after every approach.
    """
    choose_engine(MAX_PLAIN_STEPS + 1)
    return HardCases(tuple(run_case(case, patience, finished) for case in cases), engine())


def run_case(scenario: Scenario, patience: float, finished: Callable[[], None]) -> HardCase:
    """Run every approach on one case; parameters as of `run`."""
    answers: dict[str, tuple[CaseMetrics | str, float]] = {}
    for name in (EXACT, *(name for name in APPROACHES_BY_NAME if name != EXACT)):
        begin = perf_counter()
        answer = try_within(partial(solve_case, scenario, name), patience)
        answers[name] = answer, perf_counter() - begin
        finished()
    exact, frictionless = answers[EXACT][0], answers["viscous"][0]
    return HardCase(
        scenario,
        tuple(judge(name, *answer, exact, frictionless) for name, answer in answers.items()),
    )


def solve_case(scenario: Scenario, name: str) -> CaseMetrics:
    """Return metrics and checks of an approach at every point of a case."""
    from drysim.study.run import solve  # needed to solve, not to write files

    motions, checks = MotionCache(), []
    metrics: list[Metrics] = []
    for point in iter_points(scenario.sweep):
        scenario_at_point = scenario.at(point).with_approach(name)
        outcome = solve(assemble(scenario_at_point, motions.of(scenario_at_point)))
        metrics.append(outcome.metrics)
        checks += [verdict for verdict in outcome.checks if verdict.passed is not None]
    return CaseMetrics(metrics, len(checks), sum(verdict.passed is True for verdict in checks))
