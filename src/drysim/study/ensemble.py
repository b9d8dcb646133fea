"""Ensemble: one scenario under many seeds of its base motion.

An ensemble is a sweep over the seed: the seeds are solved and stored like the cases of a sweep,
until all are done, or until the confidence interval of a mean is as narrow as the stopping rule
demands. The result of a seed depends neither on the other seeds nor on the number of workers.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, ClassVar

from drysim.approach.solution import Events, Response
from drysim.core import compile
from drysim.errors import SolverError, WarningMessage
from drysim.metrics.checks import EVERY_SEED, MEAN, Verdict
from drysim.metrics.table import Values
from drysim.metrics.text import format_metrics
from drysim.parallel import WorkerPool, worker_count
from drysim.scenario.blocks import SEED_KEY
from drysim.scenario.model import Scenario
from drysim.study import plan
from drysim.study import run as one_case
from drysim.study.budget import case_cost
from drysim.study.case import Case
from drysim.study.outcome import Outcome, Result, count_verdicts, format_repr
from drysim.study.preparation import assemble, base_motion, prepare
from drysim.study.run import MotionCache
from drysim.study.statistics import (
    Batch,
    BatchCallback,
    Rows,
    Statistic,
    ignore_batch,
    max_seeds,
    needed_seeds,
    seed_range,
    statistics,
    with_seed,
    with_seeds,
)
from drysim.study.sweep import solve_interval, solve_ranges
from drysim.study.warnings import ensemble_warnings
from drysim.wording import format_count

if TYPE_CHECKING:
    from drysim.study.store import Store
    from drysim.study.table import Table


@dataclass(frozen=True, eq=False)
class Ensemble(Result):
    """A scenario under many seeds.

    Attributes
    ----------
    scenario : Scenario
        The scenario that was solved.
    rows : sequence of Row
        One row per seed, in order.
    statistics : mapping
        `Statistic` by metric; None where the metric is unknown for all seeds.
    shown : Outcome
        Outcome of the first seed that has numbers, with its response.
    checks : tuple of Verdict
        Verdicts over the seeds.
    warnings : tuple of WarningMessage
    complete : bool
        Whether all required seeds were computed.
    """

    kind: ClassVar[str] = "ensemble"

    scenario: Scenario
    rows: Rows
    statistics: Mapping[str, Statistic | None]
    shown: Outcome
    checks: tuple[Verdict, ...] = ()
    warnings: tuple[WarningMessage, ...] = ()
    complete: bool = True

    @property
    def metrics(self) -> Values:
        """Mean of each metric over the seeds for which it is known, in SI units."""
        return {name: metric and metric.mean for name, metric in self.statistics.items()}

    @property
    def response(self) -> Response:
        """Response of the first seed."""
        return self.shown.response

    @property
    def events(self) -> Events:
        """Events of the first seed."""
        return self.shown.events

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds in order."""
        (seeds,) = self.rows.batches
        return tuple(seeds.points[SEED_KEY].tolist())

    def __repr__(self) -> str:
        """Return number of seeds, key metrics and verdicts in one line."""
        many = format_count(len(self.rows), "seed")
        verdicts = count_verdicts(self.checks, self.warnings)
        return format_repr(
            "Ensemble", self.scenario.name, many, format_metrics(self.metrics), verdicts
        )

    @property
    def has_failed_cases(self) -> bool:
        """Whether the numerics failed for a seed."""
        (seeds,) = self.rows.batches
        return not seeds.has_numbers().all()


def run(scenario: Scenario, *, workers: int | None = None) -> Outcome | Ensemble | Table:
    """Solve a scenario.

    Parameters
    ----------
    scenario : Scenario
        As `drysim.load` returns it.
    workers : int, optional
        Number of workers for many seeds; default: one per processor.

    Returns
    -------
    Outcome or Ensemble or Table
        An ensemble if the scenario requests several seeds; its metrics are means. A table of
        cases if `friction.static_ratio` is an interval.

    Raises
    ------
    RecordError
        When the record of the excitation is invalid.
    ScenarioError
        When the case needs more memory than the machine has.
    SolverError
        When the numerics fail; the message contains the time.
    UsageError
        When `scenario` is not a Scenario, or `workers` not a number of workers.
    """
    case = prepare(scenario, interval=True)
    worker_count(workers)  # validated for a single seed, too
    if scenario.static_interval:
        return solve_interval(case)
    if max_seeds(scenario) == 1:
        return one_case.solve(case)
    return solve(case, workers=workers)


def solve(
    case: Case,
    *,
    workers: int | None = None,
    store: Store | None = None,
    finished: BatchCallback = ignore_batch,
) -> Ensemble:
    """Solve a prepared case under all its seeds.

    Parameters
    ----------
    case : Case
        Case of the first seed.
    workers : int, optional
        Number of workers; default: one per processor. The ensemble does not depend on it.
    store : Store, optional
        Seeds that it holds are not computed again, all others are written to it.
    finished : callable, optional
        Called with each batch of seeds as it is computed, in order.

    Raises
    ------
    SolverError
        When the numerics fail for every seed.
    """
    scenario, seeds = case.scenario, seed_range(case.scenario)
    compile.choose_engine(case_cost(case) * len(seeds), case.kernels)

    motions, ranges = MotionCache(), plan.seed_ranges(case)

    def solve_one(number: int) -> Batch:
        return plan.solve_seeds(case, ranges[number], motions)

    with WorkerPool(plan.seed_workers(case, workers)) as pool:
        solve_all = partial(pool.map_unordered, solve_one)
        with closing(solve_ranges(ranges, solve_one, solve_all, store, finished)) as batches:
            solved = needed_seeds(scenario, (batch for _, batch in batches))
    return make_ensemble(case, solved)


def partial_ensemble(case: Case, store: Store) -> Ensemble:
    """Return the ensemble of the first finished seeds of an interrupted run.

    Raises
    ------
    KeyboardInterrupt
        When the first seed is not finished.
    """
    stored = []
    for case_range in plan.seed_ranges(case):
        if (batch := store.read(case_range)) is None:
            break
        stored.append(batch)
    if not stored:
        raise KeyboardInterrupt
    return make_ensemble(case, needed_seeds(case.scenario, stored), complete=False)


def make_ensemble(case: Case, seeds: Batch, complete: bool = True) -> Ensemble:
    """Return the ensemble of finished seeds with its verdicts; errors as in `solve`."""
    scenario, good = case.scenario, seeds.part(seeds.has_numbers())
    if not len(good):
        raise SolverError(f"the numerics fail for every seed; the first: {seeds.notes[0]}")
    one_seed = with_seed(scenario, good.points[SEED_KEY][0].item())
    shown = one_case.solve(assemble(one_seed, base_motion(one_seed)))
    by_metric = statistics(good)
    means = {name: metric and metric.mean for name, metric in by_metric.items()}
    verdicts = []
    for check in scenario.checks:
        values, statistic = good.metrics[check.metric], by_metric[check.metric]
        judged = means if check.judges == MEAN else {check.metric: check.over_seeds(values)}
        verdict = check.judge(judged)
        if statistic:
            width, count, numbers = statistic.half_width, statistic.seeds, good.points[SEED_KEY]
            verdict = with_seeds(verdict, width, count, values, numbers)
        is_final = check.judges == EVERY_SEED and verdict.failed_seeds
        if not complete and not is_final:
            verdict = check.undecided_before_all("seeds")
        verdicts.append(verdict)
    warnings = tuple(ensemble_warnings(case, seeds, by_metric, verdicts, shown))
    rows = Rows([seeds])
    return Ensemble(scenario, rows, by_metric, shown, tuple(verdicts), warnings, complete)
