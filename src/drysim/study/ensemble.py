"""Ensemble: one scenario under many seeds of its base motion.

The seeds are solved in order until all are done, or until the confidence interval of a mean is
as narrow as the stopping rule demands. If the scene allows it (`can_measure_together`), one
call of a kernel measures a block of seeds; otherwise each seed is solved by itself. The result
of a seed depends neither on the other seeds of its block nor on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from drysim import system
from drysim.approach import EXACT
from drysim.approach.solution import Events, Response
from drysim.core import compile
from drysim.core.compile import COMPILED, engine
from drysim.core.model import CoulombLaw, Samples, Sines
from drysim.errors import SolverError, WarningMessage
from drysim.metrics.checks import Verdict
from drysim.metrics.stroke import Values, excursions, stroke_statistics
from drysim.metrics.table import METRICS, energy_metrics, mean_metrics
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
from drysim.study.run import MotionSource, trajectory_of, try_measure
from drysim.study.statistics import (
    FAILED,
    OK,
    Row,
    Statistic,
    has_enough_seeds,
    max_seeds,
    seed_range,
    statistics,
    stopping_rule,
    with_interval,
    with_seed,
)
from drysim.study.warnings import ensemble_warnings
from drysim.system import map_in_order, worker_count
from drysim.wording import format_count

if TYPE_CHECKING:
    from drysim.approach.many_records import BatchResult


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
    compile.choose_engine(case.work * max_seeds(case.scenario), case.step_cost.kernels)
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
    seeds, kept = seed_range(scenario), done or {}
    one_seed = with_seed(scenario, seeds[0])
    first = assemble(one_seed, motion_of(one_seed))
    step = block_length(first, len(seeds))

    def block(begin: int) -> list[Row]:
        every = seeds[begin : begin + step]
        missing = [seed for seed in every if seed - seeds[0] not in kept]
        new = dict(zip(missing, solve_seed_block(first, missing, motion_of), strict=True))
        return [new[seed] if seed in new else kept[seed - seeds[0]] for seed in every]

    rows: list[Row] = []
    with closing(map_in_order(block, range(0, len(seeds), step), threads)) as found:
        for one in chain.from_iterable(found):
            rows.append(one)
            yield one
            if has_enough_seeds(scenario, rows):
                return


def solve_seed_block(
    case: Case, seeds: Sequence[int], motion_of: MotionSource
) -> Iterator[Row]:
    """Yield the rows of some seeds; several seeds are measured together."""
    scenario, law = case.scenario, case.law
    if len(seeds) < 2:
        yield from (solve_seed(scenario, seed, motion_of) for seed in seeds)
        return
    digests: list[str] = []

    def drawn() -> Iterator[Samples]:
        for seed in seeds:
            motion = as_samples(motion_of(with_seed(scenario, seed)))
            digests.append(signal_sha256(motion.u_dd))
            yield motion

    same, found = (scenario.label, law.F_fk, law.F_fs), measure_block(case, drawn(), len(seeds))
    for i, (seed, metrics) in enumerate(zip(seeds, found, strict=True)):
        if metrics is None:
            yield solve_seed(scenario, seed, motion_of)
        else:
            yield Row({SEED_KEY: seed}, *same, metrics, sha256=digests[i])


def solve_seed(scenario: Scenario, seed: int, motion_of: MotionSource = base_motion) -> Row:
    """Return the row of one seed; a numerical failure becomes a status."""
    one_seed, law = with_seed(scenario, seed), scenario.law()
    motion = as_samples(motion_of(one_seed))
    found = try_measure(one_seed, lambda _: motion)
    sha256 = signal_sha256(motion.u_dd)
    return Row({SEED_KEY: seed}, scenario.label, law.F_fk, law.F_fs, *found, sha256)


def as_samples(motion: Sines | Samples) -> Samples:
    """Return a random motion, which is sampled."""
    assert isinstance(motion, Samples), "random motion is sampled"
    return motion


# Blocks of seeds, measured by one call of the kernel.

MAX_SEEDS_PER_BLOCK, MIN_SEEDS_PER_BLOCK = 128, 8
"""Seeds of a block: the most that the kernel marches together, and its group size."""

MIN_BLOCKS = 4
"""Least number of blocks, so that threads share the work of few seeds."""

MAX_SEEDS_PER_DECISION = 32
"""Most seeds of a block where a stopping rule decides how many are needed."""

MAX_SAMPLES_PER_BLOCK = 1 << 22
"""Most samples of a block: 100 MB with all derived arrays."""


def block_length(case: Case, seeds: int) -> int:
    """Return the number of seeds of a block; 1 if each seed is solved by itself.

    This is the only place that decides between the two. The number of threads plays no part.
    """
    limit = min(MAX_SEEDS_PER_BLOCK, MAX_SAMPLES_PER_BLOCK // max(case.steps, 1))
    if stopping_rule(case.scenario):
        limit = min(limit, MAX_SEEDS_PER_DECISION)
    if (
        limit < MIN_SEEDS_PER_BLOCK
        or seeds < MIN_SEEDS_PER_BLOCK
        or not can_measure_together(case)
    ):
        return 1
    share = -(-seeds // MIN_BLOCKS)
    return min(limit, max(MIN_SEEDS_PER_BLOCK, share + -share % MIN_SEEDS_PER_BLOCK))


def can_measure_together(case: Case) -> bool:
    """Whether a block of seeds of this case can be measured by one call of the kernel."""
    from drysim.approach.many_records import can_batch

    return (
        engine() == COMPILED
        and case.approach.approach == EXACT
        and case.period is None
        and case.scenario.measure.weights is None
        and isinstance(case.motion, Samples)
        and window_samples(case) is not None
        and can_batch(case.plant, case.law, case.step)
    )


def window_samples(case: Case) -> tuple[int, int] | None:
    """Return first and last sample of the window; None if it begins or ends between samples."""
    from drysim.approach.scene import GRID_TOLERANCE

    shares = [t / case.step for t in case.window]
    begin, end = map(round, shares)
    near = all(abs(t - round(t)) <= GRID_TOLERANCE * max(1.0, t) for t in shares)
    return (begin, end) if near and begin < end else None


def measure_block(
    case: Case, motions: Iterable[Samples], count: int
) -> Iterator[Values | None]:
    """Yield the metrics of a case under each of `count` base motions.

    None means that the numerics fail and the seed must be solved by itself.
    """
    from drysim.approach.many_records import make_batch, measure_batch

    window = window_samples(case)
    assert type(case.law) is CoulombLaw, "only called after `can_measure_together`"
    assert window is not None, "only called after `can_measure_together`"
    motions_in_lanes = make_batch(motions, count, window)
    many = measure_batch(case.plant, case.law, motions_in_lanes, case.start)
    columns = mean_metrics(many.totals, case.window[1] - case.window[0])
    columns |= energy_metrics(case.plant, case.law.F_fk, many.totals, many.first, many.last)
    known = {name: optional_values(column, count) for name, column in columns.items()}
    for i, found in enumerate(many.found.tolist()):
        if not found:
            yield None
            continue
        values: Values = {name: column[i] for name, column in known.items()}
        values |= stroke_metrics(case, motions_in_lanes.motion(i), many, i)
        yield {metric.name: values.get(metric.name) for metric in METRICS}


def optional_values(column: object, count: int) -> list[float | None]:
    """Convert a column to numbers, NaN to None."""
    if not isinstance(column, np.ndarray):
        return [None] * count
    return [None if value != value else value for value in column.tolist()]


def stroke_metrics(case: Case, motion: Samples, many: BatchResult, i: int) -> Values:
    """Return the metrics of one seed that depend on its turning points."""
    displacements, suffices, x_rM = many.paths[i], float(many.suffices[i]), case.limit
    length = case.window[1] - case.window[0]
    peak = float(np.abs(displacements).max())
    values: Values = {"x_r_peak": peak, "stroke_suffices": suffices, "chatter_share": 0.0}
    values |= stroke_statistics(displacements, length, x_rM, case.stationary)
    if x_rM is not None:
        times, t_first, t_beyond = 0, None, 0.0
        if suffices >= x_rM:
            one_seed = replace(case, motion=motion)
            trajectory = trajectory_of(one_seed, case.start, case.step, case.window[1])
            path = trajectory.path((0.0, trajectory.end), x_rM)
            times, t_first, t_beyond = excursions(trajectory, path, x_rM)
        values |= {"stroke_used": peak / x_rM, "violations": times, "t_beyond": t_beyond}
        values["t_first_violation"] = t_first
    return values
