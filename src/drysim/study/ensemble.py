"""Ensemble: one scenario under many seeds of its base motion.

The seeds are solved in order until all are done, or until the confidence interval of a mean is
as narrow as the stopping rule demands. Each seed is a case of its own, and its result depends
neither on the other seeds nor on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass

from drysim import system
from drysim.approach.solution import Events, Response
from drysim.core import compile
from drysim.core.model import Samples
from drysim.errors import SolverError, WarningMessage
from drysim.metrics.checks import Verdict
from drysim.metrics.table import Values
from drysim.scenario.blocks import SEED_KEY
from drysim.scenario.model import Scenario
from drysim.study import run as one_case
from drysim.study.case import (
    Case,
    assemble,
    base_motion,
    prepare,
    response_memory,
    signal_sha256,
)
from drysim.study.outcome import Outcome, count_verdicts, exit_code, format_metrics, format_repr
from drysim.study.run import MotionSource, try_measure
from drysim.study.statistics import (
    FAILED,
    OK,
    Row,
    Statistic,
    has_enough_seeds,
    max_seeds,
    seed_range,
    statistics,
    with_interval,
    with_seed,
)
from drysim.study.warnings import ensemble_warnings
from drysim.system import map_in_order, worker_count
from drysim.wording import format_count


@dataclass(frozen=True, eq=False)
class Ensemble:
    """A scenario under many seeds.

    Attributes
    ----------
    scenario : Scenario
        The scenario that was solved.
    rows : tuple of Row
        One row per seed, in order.
    statistics : mapping
        `Statistic` by metric; None where the metric is unknown for all seeds.
    shown : Outcome
        Outcome of the first seed that has numbers, with its response.
    checks : tuple of Verdict
        Verdicts on the means.
    warnings : tuple of WarningMessage
    complete : bool
        Whether all required seeds were computed.
    """

    scenario: Scenario
    rows: tuple[Row, ...]
    statistics: Mapping[str, Statistic | None]
    shown: Outcome
    checks: tuple[Verdict, ...] = ()
    warnings: tuple[WarningMessage, ...] = ()
    complete: bool = True

    @property
    def metrics(self) -> Values:
        """Mean of each metric over the seeds for which it is known, in SI units."""
        return {name: found and found.mean for name, found in self.statistics.items()}

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
        return tuple(row.seed for row in self.rows)

    def __repr__(self) -> str:
        """Return number of seeds, key metrics and verdicts in one line."""
        kept, many = (
            count_verdicts(self.checks, self.warnings),
            format_count(len(self.rows), "seed"),
        )
        return format_repr(
            "Ensemble", self.scenario.name, many, format_metrics(self.metrics), kept
        )

    def exit_code(self, strict: bool = False) -> int:
        """Return 3 if a seed failed, 1 if a check failed, else 0.

        `strict` counts warnings as failed checks.
        """
        lost = any(row.status == FAILED for row in self.rows)
        return exit_code(self.checks, self.warnings, strict, lost)


def run(scenario: Scenario, *, workers: int | None = None) -> Outcome | Ensemble:
    """Solve a scenario.

    Parameters
    ----------
    scenario : Scenario
        As `drysim.load` returns it.
    workers : int, optional
        Number of threads for many seeds; default: one per processor.

    Returns
    -------
    Outcome or Ensemble
        An ensemble if the scenario requests several seeds; its metrics are means.

    Raises
    ------
    RecordError
        When the record of the excitation is invalid.
    ScenarioError
        When the case needs more memory than the machine has.
    SolverError
        When the numerics fail; the message contains the time.
    UsageError
        When `scenario` is not a Scenario, or `workers` not a number of threads.
    """
    case = prepare(scenario)
    worker_count(workers)  # validated for a single seed, too
    if max_seeds(scenario) == 1:
        return one_case.solve(case)
    return solve(case, workers=workers)


RowCallback = Callable[[int, Row], None]


def ignore_row(number: int, row: Row) -> None:
    """Do nothing: the default callback."""


def solve(
    case: Case,
    *,
    workers: int | None = None,
    done: Mapping[int, Row] | None = None,
    finished: RowCallback = ignore_row,
) -> Ensemble:
    """Solve a prepared case under all its seeds.

    Parameters
    ----------
    case : Case
        Case of the first seed.
    workers : int, optional
        Number of threads; default: one per processor. The ensemble does not depend on it.
    done : mapping, optional
        Rows of an interrupted run, by index of the seed from 0.
    finished : callable, optional
        Called with index and row of each seed as it is computed, in order.

    Raises
    ------
    SolverError
        When the numerics fail for every seed.
    """
    compile.choose_engine(case.work * max_seeds(case.scenario), case.kernels)
    rows: list[Row] = []
    known = done or {}
    for row in solve_seeds(case.scenario, thread_count(case, workers), known):
        if len(rows) not in known:
            finished(len(rows), row)
        rows.append(row)
    return make_ensemble(case, rows)


def make_ensemble(case: Case, rows: Sequence[Row], complete: bool = True) -> Ensemble:
    """Return the ensemble of finished seeds with its verdicts; errors as in `solve`."""
    scenario, good = case.scenario, [row for row in rows if row.status == OK]
    if not good:
        raise SolverError(f"the numerics fail for every seed; the first: {rows[0].note}")
    one_seed = with_seed(scenario, good[0].seed)
    shown = one_case.solve(assemble(one_seed, base_motion(one_seed)))
    found = statistics(good)
    means = {name: one and one.mean for name, one in found.items()}
    verdicts = []
    for check in scenario.checks:
        verdict, one = check.judge(means), found[check.metric]
        verdicts.append(with_interval(verdict, one.half_width, one.seeds) if one else verdict)
    warnings = tuple(ensemble_warnings(case, rows, found, verdicts, shown))
    return Ensemble(scenario, tuple(rows), found, shown, tuple(verdicts), warnings, complete)


def thread_count(case: Case, workers: int | None) -> int:
    """Return the number of seeds to solve in parallel, as many as fit into memory."""
    wanted = worker_count(workers)
    if compile.engine() == compile.PLAIN:
        return 1  # the interpreter lock allows one thread
    limit = int(
        system.total_memory()
        // response_memory(case.steps, bool(case.scenario.measure.weights))
    )
    return max(1, min(wanted, limit))


# Rows of metrics, seed by seed in order.


def solve_seeds(
    scenario: Scenario,
    threads: int,
    done: Mapping[int, Row] | None = None,
    motion_of: MotionSource = base_motion,
) -> Iterator[Row]:
    """Yield the row of each seed that a scenario needs, in order.

    Parameters
    ----------
    scenario : Scenario
    threads : int
    done : mapping, optional
        Rows that are already known, by index of the seed from 0.
    motion_of : callable, optional
        Returns the base motion of a scenario.
    """
    seeds, known = seed_range(scenario), done or {}

    def row(number: int) -> Row:
        return known.get(number) or solve_seed(scenario, seeds[number], motion_of)

    rows: list[Row] = []
    with closing(map_in_order(row, range(len(seeds)), threads)) as found:
        for one in found:
            rows.append(one)
            yield one
            if has_enough_seeds(scenario, rows):
                return


def solve_seed(scenario: Scenario, seed: int, motion_of: MotionSource = base_motion) -> Row:
    """Return the row of one seed; a numerical failure becomes a status."""
    one_seed, law = with_seed(scenario, seed), scenario.law()
    motion = motion_of(one_seed)
    assert isinstance(motion, Samples), "random motion is sampled"
    found = try_measure(one_seed, lambda _: motion)
    sha256 = signal_sha256(motion.u_dd)
    return Row({SEED_KEY: seed}, scenario.label, law.F_fk, law.F_fs, *found, sha256)
