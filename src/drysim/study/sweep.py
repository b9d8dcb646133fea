"""Solve all cases of a sweep and collect them in a table.

Workers on this machine, or those of a cluster, solve the ranges of the plan. The table takes
them in the order of the grid, so it does not depend on who solved them. Ranges that a store
already holds are not solved again (`solve_ranges`, also for the seeds of an ensemble).
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, nullcontext
from dataclasses import replace
from functools import partial
from itertools import chain
from threading import Event
from typing import TYPE_CHECKING

from drysim.approach.cost import step_cost
from drysim.approach.solution import FIXED_STEP
from drysim.approach.solvers import solver_of
from drysim.approach.stick_slip import ExactApproach
from drysim.core import compile
from drysim.errors import WarningMessage
from drysim.parallel import WorkerPool, worker_count
from drysim.scenario.axes import (
    EXTREME_KEY,
    GREATEST,
    LEAST,
    Axis,
    are_draws,
    count_points,
    point_columns,
    points_in,
)
from drysim.scenario.model import Scenario
from drysim.study import interval
from drysim.study.case import Case
from drysim.study.plan import (
    AsText,
    CaseRange,
    CaseRanges,
    Plan,
    Workers,
    approaches_of,
    can_solve_together,
)
from drysim.study.preparation import prepare
from drysim.study.run import MotionCache, count_cases, unused_spectra_warnings
from drysim.study.statistics import (
    MAX_CACHED_ROWS,
    Batch,
    BatchCallback,
    Rows,
    ignore_batch,
    max_seeds,
)
from drysim.study.store import Store, StoredBatches
from drysim.study.table import (
    RATIO_KEY,
    Table,
    Tally,
    has_shared_motion,
    verdict_over_draws,
)
from drysim.study.warnings import (
    certificate_warnings,
    status_warnings,
    table_interval_warnings,
    table_stroke_warnings,
)
from drysim.wording import format_range

if TYPE_CHECKING:
    from drysim.study.cluster import ClusterExecutor


def sweep(
    scenario: Scenario, *, workers: int | None = None, finished: BatchCallback = ignore_batch
) -> Table:
    """Solve every case of a scenario's sweep.

    Parameters
    ----------
    scenario : Scenario
        With a sweep block.
    workers : int, optional
        Number of workers; default: one per processor. The table does not depend on it.
    finished : callable, optional
        Called with each batch of cases as it is computed, in order.

    Returns
    -------
    Table
        The cases of the scenario, followed by those of its reference approach. If
        `friction.static_ratio` is an interval: the least value of each metric in every case,
        followed by the greatest ones, told apart by the key `extreme`.

    Raises
    ------
    ScenarioError
        When the scenario has no sweep block, or a case is invalid.
    RecordError
        When the record of the excitation is invalid.
    UsageError
        When `scenario` is not a Scenario, or `workers` not a number of workers.
    """
    case = prepare(scenario, swept=True, interval=True)
    if scenario.static_interval:
        return solve_swept_interval(case, workers=workers, finished=finished)
    return solve(case, workers=workers, finished=finished)


def solve(
    case: Case,
    *,
    workers: int | None = None,
    execute: Execute | None = None,
    store: Store | None = None,
    finished: BatchCallback = ignore_batch,
    as_text: AsText | None = None,
) -> Table:
    """Solve the sweep of a prepared case; otherwise as `sweep`.

    Parameters
    ----------
    execute : callable, optional
        Solves the cases, such as `on_cluster(link)`; default: `on_workers(workers)`.
    store : Store, optional
        Ranges that it holds are not computed again, all others are written to it. For a large
        sweep it is the only copy.
    as_text : callable, optional
        Formats each batch, in the workers of this machine; its text is stored with it.
    """
    scenarios = approaches_of(case.scenario)
    choose_engine(case, scenarios)
    plan = replace(Plan.of(scenarios, case), as_text=as_text)
    with nullcontext(execute) if execute else on_workers(workers) as solve_all:
        return gather(case, solve_all(plan, case, store, finished), store)


Execute = Callable[
    [Plan, Case, "Store | None", BatchCallback], Iterator[tuple[CaseRange, Batch]]
]
"""Function that solves the cases of a plan and yields each range with its batch, in order. The
results do not depend on who solves them."""


@contextmanager
def on_workers(workers: int | None) -> Iterator[Execute]:
    """Yield the function that solves cases by workers on this machine.

    The workers are kept for several plans, with the base motions that these share.
    """
    count, cancelled = worker_count(workers), Event()
    is_cancelled = cancelled.is_set
    with WorkerPool(count) as pool:

        def execute(
            plan: Plan, case: Case, store: Store | None, finished: BatchCallback
        ) -> Iterator[tuple[CaseRange, Batch]]:
            case_workers = Workers.at(case, count, sum(plan.ranges.cases), is_cancelled)
            solve_one = replace(plan, case_workers=case_workers).block
            shared = plan.motions, is_cancelled
            solve_all = partial(pool.map_unordered, solve_one, shared=shared)
            return solve_ranges(plan.ranges, solve_one, solve_all, store, finished)

        try:
            yield execute
        finally:
            cancelled.set()


def on_cluster(cluster: ClusterExecutor) -> Execute:
    """Return the function that solves cases on the workers of a cluster."""
    from drysim.study.cluster import Payload

    def execute(
        plan: Plan, case: Case, store: Store | None, finished: BatchCallback
    ) -> Iterator[tuple[CaseRange, Batch]]:
        compile.choose_engine(compile.MAX_PLAIN_STEPS + 1)  # as on the workers
        payload = Payload.of(case.scenario, plan.ranges.first)
        solve_all = partial(cluster.solve, payload)
        return solve_ranges(plan.ranges, plan.block, solve_all, store, finished)

    return execute


def partial_table(case: Case, store: Store) -> Table:
    """Return the table of the finished cases of an interrupted sweep."""
    finished = store.finished(CaseRanges(approaches_of(case.scenario)))
    return gather(case, finished, store, complete=False)


STEPS_PER_ORBIT, STEPS_PER_UNDAMPED_ORBIT = 500, 150_000
"""Cost of a periodic orbit in the choice of the engine, in steps of sampled motion. Measured:
200 to 1,000 steps; without a damper and dry friction the motion never settles."""

STEPS_PER_MARCHED_ORBIT = 2_000
"""The same for an orbit that is marched period by period."""


def choose_engine(case: Case, scenarios: Sequence[Scenario], count: int | None = None) -> None:
    """Choose the engine for all cases, or `count`, by the law with the most expensive step."""
    steps_per_sample, kernels = max(
        (step_cost(each.solver.member(), each.law(), case.motion) for each in scenarios),
        key=lambda cost: cost.steps,
    )
    least_steps = STEPS_PER_MARCHED_ORBIT
    if all(map(can_solve_together, scenarios)):
        kernels = "orbit.solve_orbits"
        least_steps = STEPS_PER_ORBIT if is_damped(case) else STEPS_PER_UNDAMPED_ORBIT
    steps = max(case.steps, least_steps) * steps_per_sample
    count = count_cases(scenarios) if count is None else count
    compile.choose_engine(steps * max_seeds(case.scenario) * count, kernels)


def is_damped(case: Case) -> bool:
    """Return whether every case of a sweep has a damper."""
    keys = "oscillator.damping", "oscillator.damping_ratio"
    swept = [
        min(axis.values) for axis in case.scenario.sweep if axis.key in keys and axis.values
    ]
    return min(swept, default=case.plant.b) > 0.0


SolveAll = Callable[[Sequence[int]], Generator[tuple[int, "Batch | None"]]]
"""Function that yields numbers of ranges with their batches, in any order. A batch is None if a
case is invalid and its error is not raised where it was solved."""

MAX_EARLY = 8
"""Batches that wait for their turn in memory; further ones are read back from the store."""


def solve_ranges(
    ranges: Sequence[CaseRange],
    solve_one: Callable[[int], Batch],
    solve_all: SolveAll,
    store: Store | None,
    finished: BatchCallback,
) -> Generator[tuple[CaseRange, Batch]]:
    """Yield each range with its batch, in order; a range in the store is only read.

    A batch is stored as soon as it is solved, in any order, so that an interruption loses only
    the ranges in progress.

    Parameters
    ----------
    ranges : sequence of CaseRange
    solve_one : callable
        Solves the range with a number, in this process.
    solve_all : callable
        Solves the ranges with these numbers, by workers.
    store : Store or None
        Takes each new batch.
    finished : callable
        Called with each new batch, in order.
    """
    missing: Sequence[int] = range(len(ranges))
    if store is not None and len(store):
        missing = [number for number in missing if not store.has(ranges[number])]
    new: dict[int, Batch | None] = {}  # None: to be read from the store, or invalid
    with closing(solve_all(missing)) as solved:
        for number, case_range in enumerate(ranges):
            while not (number in new or (store is not None and store.has(case_range))):
                other, batch = next(solved)
                if store is not None and batch is not None:
                    store.write(ranges[other], batch)
                new[other] = batch if store is None or len(new) < MAX_EARLY else None
            is_new, batch = number in new, new.pop(number, None)
            if batch is None and store is not None:
                batch = store.read(case_range)
            if batch is None:
                # Its file is damaged, or a case is invalid: its error is raised here.
                is_new, batch = True, solve_one(number)
                if store is not None:
                    store.write(case_range, batch)
            if is_new:
                finished(batch)
            yield case_range, batch


# Cases whose static ratio is an interval.


CASES_PER_COVER = 256
"""Cases whose values of the ratio are chosen and solved together."""


def solve_interval(case: Case) -> Table:
    """Solve a prepared case over the interval of its static ratio.

    Returns
    -------
    Table
        One row per value of the ratio that was solved, in ascending order.
    """
    scenario, single = case.scenario, case.scenario.copy_with({"sweep": ()})
    choose_engine(case, [single], 2 * interval.FIRST_VALUES)
    (covered,) = interval.cover(single, [{}], MotionCache.starting_with(case), WorkerPool(1))
    rows = covered.rows
    swept = interval.at_points(single, [{}], [*rows])
    batch = Batch.of(0, [*rows.values()])
    table = make_table(swept, replace(case, scenario=swept), Rows([batch]))
    for tally in table.summary.values():
        tally.quantiles.clear()  # the values gather at jumps: their shares mean nothing
    further = (
        interval.undecided_warnings(table.checks, rows),
        interval.cover_warnings([covered]),
    )
    warnings = (*table.warnings, *chain(*further))
    return replace(table, scenario=scenario, warnings=warnings, jumps=covered.jumps)


def solve_swept_interval(
    case: Case, *, workers: int | None = None, finished: BatchCallback = ignore_batch
) -> Table:
    """Solve the sweep of a prepared case over the interval of its static ratio.

    Returns
    -------
    Table
        The least value of each metric in every case, followed by the greatest ones.
    """
    (scenario,) = approaches_of(case.scenario)
    assert scenario.static_interval is not None, "only called with an interval"
    count = count_points(scenario.sweep)
    choose_engine(case, [scenario], 2 * interval.FIRST_VALUES * count)
    motions = MotionCache.starting_with(case)
    least: list[Batch] = []
    greatest: list[Batch] = []
    covered: list[interval.Covered] = []
    with WorkerPool(worker_count(workers)) as pool:
        for begin in range(0, count, CASES_PER_COVER):
            end = min(begin + CASES_PER_COVER, count)
            points = [*points_in(point_columns(scenario.sweep, begin, end))]
            block = interval.cover(scenario, points, motions, pool)
            for batches, first, which in (
                (least, begin, LEAST),
                (greatest, count + begin, GREATEST),
            ):
                covered_points = zip(block, points, strict=True)
                extremes = [each.extreme(point, which) for each, point in covered_points]
                batches.append(Batch.of(first, extremes))
            finished(least[-1])
            covered += block
    ends = scenario.static_interval
    description = f"least and greatest over {RATIO_KEY} {format_range(ends.low, ends.high)}"
    axis = Axis(EXTREME_KEY, "", (LEAST, GREATEST), description=description)
    swept = scenario.copy_with({"sweep": (*scenario.sweep, axis)})
    rows = Rows([*least, *greatest])
    table = make_table(swept, replace(case, scenario=swept), rows)
    further = interval.cover_warnings(covered), interval.unknown_warnings(covered)
    return replace(
        table,
        scenario=scenario,
        warnings=(*table.warnings, *chain(*further)),
        jumps=tuple(jump for each in covered for jump in each.jumps),
    )


# From the batches of a sweep to its table.


def gather(
    case: Case,
    blocks: Iterator[tuple[CaseRange, Batch]],
    store: Store | None,
    complete: bool = True,
) -> Table:
    """Return the table of batches as they arrive; a store keeps most of them on disk."""
    scenario = case.scenario
    in_memory: list[Batch] = []
    ranges: list[CaseRange] = []

    def collect() -> Iterator[Batch]:
        for case_range, batch in blocks:
            ranges.append(case_range)
            if store is None or case_range.first < MAX_CACHED_ROWS:
                in_memory.append(batch)
            yield batch

    tallies = Tally.of(collect(), scenario, scenario.label)
    batches = in_memory if store is None else StoredBatches(store, ranges, in_memory)
    rows = Rows(batches, [case_range.end - case_range.begin for case_range in ranges])
    return make_table(scenario, case, rows, tallies=tallies, complete=complete)


def make_table(
    scenario: Scenario,
    case: Case,
    rows: Rows,
    losses: Iterable[WarningMessage] = (),
    tallies: Mapping[str, Tally] | None = None,
    complete: bool = True,
) -> Table:
    """Return the table of a scenario's cases, with verdicts and warnings.

    Parameters
    ----------
    scenario : Scenario
    case : Case
        The scenario with the approach, or the law, to which checks and warnings apply.
    rows : Rows
    losses : iterable of WarningMessage, optional
        Warnings to place before all others.
    tallies : mapping, optional
        `Tally` by approach, if they were gathered as the rows came.
    complete : bool, optional
        Whether all cases were computed.
    """
    tallies = tallies or Tally.of(rows.batches, scenario, case.scenario.label)
    tally = tallies.get(case.scenario.label, Tally("", scenario.checks))
    warnings = (
        *losses,
        *case.warnings,
        *unused_spectra_warnings(case),
        *status_warnings(tallies.values(), scenario.sweep),
        *table_stroke_warnings(tally, scenario),
        *certificate_warnings(*map(tally.greatest, ("energy_residual", "law_residual"))),
        *table_interval_warnings(scenario, tally.seeds),
    )
    motion = case.motion if has_shared_motion(scenario.sweep) else None
    verdicts = tally.verdicts
    if are_draws(scenario.sweep):
        batches = [each for each in rows.batches if each.approach == case.scenario.label]
        verdicts = tuple(verdict_over_draws(verdict, batches) for verdict in verdicts)
    if not complete:
        verdicts = tuple(
            verdict
            if verdict.failed and not verdict.is_quantile_of_draws
            else verdict.check.undecided_before_all("cases")
            for verdict in verdicts
        )
    return Table(
        scenario,
        scenario.sweep,
        rows,
        verdicts,
        warnings,
        complete,
        motion,
        describe_numerics(case),
        tallies,
        case.inputs,
        case.records,
    )


def describe_numerics(case: Case) -> dict[str, object]:
    """Return core, reason, engine and step of the solution, as far as all cases share them."""
    core, why = FIXED_STEP, "fixed steps"
    if isinstance(case.approach, ExactApproach):
        core, why, *_ = solver_of(case.law, case.motion)
    return {"core": core, "why": why, "engine": compile.engine(), "step": case.step}
