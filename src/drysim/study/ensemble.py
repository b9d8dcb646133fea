"""Ensemble: a scenario under many seeds of its base motion, and what they have in common.

The seeds are taken in their order, a number of them at a time, until they are all, or enough
for the interval of a mean to be as narrow as asked. Where the scene allows it, one call of the
kernel measures a block of them; every other seed is solved by itself. What a seed comes to
depends neither on those beside it nor on the number of threads.
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
    warnings: tuple[WarningMessage, ...] = ()
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
        kept, many = (
            count_verdicts(self.checks, self.warnings),
            format_count(len(self.rows), "seed"),
        )
        return format_repr(
            "Ensemble", self.scenario.name, many, format_metrics(self.metrics), kept
        )

    def exit_code(self, strict: bool = False) -> int:
        """Give 3 when a seed failed, 1 when a check did; `strict` counts warnings as checks."""
        lost = any(row.status == FAILED for row in self.rows)
        return exit_code(self.checks, self.warnings, strict, lost)


def run(scenario: Scenario, *, workers: int | None = None) -> Outcome | Ensemble:
    """Give the response, the metrics and the verdicts of a scenario.

    Parameters
    ----------
    scenario : Scenario
        As `drysim.load` gives it.
    workers : int, optional
        Threads for many seeds; default: one for each processor.

    Returns
    -------
    Outcome or Ensemble
        An ensemble where the scenario asks for many seeds; its metrics are means.

    Raises
    ------
    RecordError
        When the record of the excitation cannot be used.
    ScenarioError
        When the case needs more memory than the machine has.
    SolverError
        When the numerics fail; the time is named.
    UsageError
        When it is no scenario, or `workers` no number of threads.
    """
    case = prepare(scenario)
    worker_count(workers)  # validated for a single seed, too
    if max_seeds(scenario) == 1:
        return one_case.solve(case)
    return solve(case, workers=workers)


RowCallback = Callable[[int, Row], None]


def ignore_row(number: int, row: Row) -> None:
    """Do nothing with a finished seed."""


def solve(
    case: Case,
    *,
    workers: int | None = None,
    done: Mapping[int, Row] | None = None,
    finished: RowCallback = ignore_row,
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
    compile.choose_engine(case.work * max_seeds(case.scenario), case.step_cost.kernels)
    rows: list[Row] = []
    known = done or {}
    for row in solve_seeds(case.scenario, thread_count(case, workers), known):
        if len(rows) not in known:
            finished(len(rows), row)
        rows.append(row)
    return make_ensemble(case, rows)


def make_ensemble(case: Case, rows: Sequence[Row], complete: bool = True) -> Ensemble:
    """Give the ensemble of finished seeds, with all verdicts; errors as in `solve`."""
    scenario, good = case.scenario, [row for row in rows if row.status == OK]
    if not good:
        raise SolverError(f"the numerics fail with every seed; the first says: {rows[0].note}")
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
    """Give how many seeds may be under way at a time: as many as fit into the memory."""
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
    """Give the row of every seed that a scenario needs, in order."""
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
    """Give the rows of some seeds, which are measured together where there are several."""
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
    """Give the row of one seed; a failure of the numerics is a status, not an end."""
    one_seed, law = with_seed(scenario, seed), scenario.law()
    motion = as_samples(motion_of(one_seed))
    found = try_measure(one_seed, lambda _: motion)
    sha256 = signal_sha256(motion.u_dd)
    return Row({SEED_KEY: seed}, scenario.label, law.F_fk, law.F_fs, *found, sha256)


def as_samples(motion: Sines | Samples) -> Samples:
    """Give a motion that was drawn, which is samples."""
    assert isinstance(motion, Samples), "what is drawn is samples"
    return motion


# Blocks of seeds, measured by one call of the kernel.

MAX_SEEDS_PER_BLOCK, MIN_SEEDS_PER_BLOCK = 128, 8
"""Seeds of a block: as many as the kernel marches together, and a group of them."""

MIN_BLOCKS = 4
"""Blocks at least, so that threads can share the work of few seeds."""

MAX_SEEDS_PER_DECISION = 32
"""Seeds of a block at most where an interval decides how many are needed."""

MAX_SAMPLES_PER_BLOCK = 1 << 22
"""Samples of a block at most: 100 MB with what is made of them."""


def block_length(case: Case, seeds: int) -> int:
    """Give how many of so many seeds a block holds; 1 where each is solved by itself.

    The one place that says which scenes go by blocks. It does not depend on the number of
    threads, nor do results: what a seed comes to does not depend on those beside it.
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
    """Tell whether the exact solution of a case can be measured side by side with others."""
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
    """Give the samples at which the window begins and ends; None where it does between two."""
    from drysim.approach.scene import GRID_TOLERANCE

    shares = [t / case.step for t in case.window]
    begin, end = map(round, shares)
    near = all(abs(t - round(t)) <= GRID_TOLERANCE * max(1.0, t) for t in shares)
    return (begin, end) if near and begin < end else None


def measure_block(
    case: Case, motions: Iterable[Samples], count: int
) -> Iterator[Values | None]:
    """Give the metrics of a case under each of so many base motions.

    None stands for one that must be solved by itself: its numerics fail.
    """
    from drysim.approach.many_records import make_batch, measure_batch

    window = window_samples(case)
    assert type(case.law) is CoulombLaw, "asked for of what `can_measure_together` only"
    assert window is not None, "asked for of what `can_measure_together` only"
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
    """Give the numbers of a column, None for what is not known."""
    if not isinstance(column, np.ndarray):
        return [None] * count
    return [None if value != value else value for value in column.tolist()]


def stroke_metrics(case: Case, motion: Samples, many: BatchResult, i: int) -> Values:
    """Give the metrics of one seed that are read off its way from stop to stop."""
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
