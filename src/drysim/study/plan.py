"""Plan of a sweep: its cases in ranges, and the solution of one range.

A range (a "block" in messages) holds cases of one approach with consecutive numbers. It
depends only on the scenario and on its own number, so threads, processes and other machines
compute the same results. Periodic orbits under Coulomb friction are solved many at once, by
one call of the kernel (`solve_orbit_range`). All other cases are solved one by one
(`solve_case`), each over all its seeds if it has several. An ensemble is planned as the sweep
of a scenario over its seeds (`seed_ranges`).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from contextlib import closing
from dataclasses import dataclass, field, replace
from itertools import accumulate
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from drysim import system
from drysim.approach.stick_slip import ExactApproach
from drysim.core import compile
from drysim.core.model import (
    NO_LIMITS,
    AnyState,
    Floats,
    Plant,
    Sines,
    State,
    StrokeLimits,
    Totals,
)
from drysim.core.status import Status
from drysim.direction import ByDirection
from drysim.errors import SolverError
from drysim.excitation.harmonic import Harmonic, SineSum
from drysim.friction import Coulomb
from drysim.metrics.stroke import Excursions
from drysim.metrics.table import METRICS_BY_NAME, STROKE_USED, Measured, evaluate, stack
from drysim.parallel import forks_workers, map_in_order, worker_count
from drysim.scenario.axes import (
    SWEEP_KEY,
    Axis,
    chain_length,
    chain_order,
    count_points,
    point_columns,
    points_in,
)
from drysim.scenario.blocks import SEED_KEY
from drysim.scenario.examples import sweep_example
from drysim.scenario.model import Columns, Scenario
from drysim.scenario.sampling import LazySequence
from drysim.scenario.window import common_period
from drysim.study.budget import response_memory
from drysim.study.case import Case
from drysim.study.preparation import assemble
from drysim.study.run import MotionCache, observe_motion, solve_row, solve_row_from
from drysim.study.statistics import (
    FAILED,
    FORCES,
    METRIC_NAMES,
    NOT_SETTLED,
    NOT_UNIQUE,
    OK,
    SEEDS_PER_CHECK,
    STATUSES,
    Batch,
    OverSeeds,
    Row,
    averages_seeds,
    is_narrow,
    means,
    needed_seeds,
    seed_range,
    stopping_rule,
    with_seed,
)
from drysim.wording import Point

MIN_ORBIT_RANGES = 32
"""Least number of ranges of periodic orbits, so that no worker waits for the last one; fewer if
they would hold less than `MIN_ORBITS`."""

MIN_ORBITS, MAX_ORBITS, MANY_ORBITS = 512, 4096, 65_536
"""Orbits per range: 512 are some 10 ms of work, beside which what Python does for a range takes
a third, and of four times as many a tenth. `MANY_ORBITS` keep the ranges of the largest sweeps
few."""

MAX_ORBITS_IN_SHORT_RANGES = 1 << 27
"""Cases up to which a range has at most `MAX_ORBITS`."""

MAX_RANGES, MAX_CASES_PER_RANGE = 4096, 64
"""Number of ranges into which cases solved one by one are divided, and most cases in one."""


STEPS_PER_RANGE, MIN_SEED_RANGES = 800_000, 16
"""Steps of the seeds in a range, some 25 ms of work beside which storing it takes little time;
and least number of ranges, so that none of several workers waits for the last one."""


class Workers(NamedTuple):
    """Seeds of a case that are solved in parallel, and whether the computation is cancelled."""

    seeds: int
    is_cancelled: Callable[[], bool]

    @classmethod
    def at(cls, case: Case, workers: int, count: int, is_cancelled: Callable[[], bool]) -> Self:
        """Return the workers for each of `count` cases; spare workers share the seeds."""
        return cls(max(1, seed_workers(case, workers) // count), is_cancelled)


ONE_WORKER = Workers(1, lambda: False)
"""One worker, never cancelled."""


def seed_workers(case: Case, workers: int | None) -> int:
    """Return the number of seeds to solve in parallel, as many as fit into memory."""
    wanted = worker_count(workers)
    if compile.engine() == compile.PLAIN and not forks_workers():
        return 1  # the interpreter lock allows one thread
    weighted = bool(case.scenario.measure.weights)
    limit = int(system.total_memory() // response_memory(case.steps, weighted))
    return max(1, min(wanted, limit))


AsText = Callable[[Batch], bytes]
"""Function that returns the cases of a batch as rows of a table."""


@dataclass(frozen=True, eq=False)
class Plan:
    """Ranges of a sweep, identical on every thread, process and machine."""

    ranges: CaseRanges
    """Cases of each range."""
    motions: MotionCache = field(default_factory=MotionCache)
    """Base motions that ranges share. The cache does not affect the results."""
    as_text: AsText | None = None
    """Formats the batches, in the workers."""
    case_workers: Workers = ONE_WORKER

    @classmethod
    def of(cls, scenarios: Sequence[Scenario], case: Case, first: int = 0) -> Self:
        """Return the plan for these scenarios; the base motion of `case` is known."""
        return cls(CaseRanges(scenarios, first), MotionCache.starting_with(case))

    def block(self, number: int) -> Batch:
        """Solve the range with this number, with its text if that is asked for.

        Raises
        ------
        ScenarioError, RecordError
            When a case of the range is invalid.
        """
        batch = solve_range(self.ranges[number], self.motions, self.case_workers)
        return batch if self.as_text is None else replace(batch, text=self.as_text(batch))


def approaches_of(scenario: Scenario) -> tuple[Scenario, ...]:
    """Return the scenario and, if it names one, the same scenario with its reference approach.

    Raises
    ------
    ScenarioError
        When it has no sweep block.
    """
    if not scenario.sweep:
        sentence = "sweep is required: the keys to vary and their values"
        raise scenario.error(sentence, SWEEP_KEY, sweep_example(scenario))
    reference = scenario.reference
    return (scenario, scenario.with_approach(reference)) if reference else (scenario,)


class CaseRange(NamedTuple):
    """Consecutive cases of one approach that are solved together."""

    scenario: Scenario
    """Scenario with the approach and the sweep block."""
    first: int
    """Number of the first case, counted over all approaches."""
    begin: int
    end: int
    """First case, and the case after the last, in the grid of this approach."""


class CaseRanges(LazySequence[CaseRange]):
    """Ranges of all scenarios in order, each computed from its number on access.

    The cases are numbered from `first`.
    """

    def __init__(self, scenarios: Sequence[Scenario], first: int = 0) -> None:
        self.scenarios = tuple(scenarios)
        self.first = first
        self.cases = [count_points(scenario.sweep) for scenario in scenarios]
        together = map(can_solve_together, scenarios)
        self._lengths = [
            chain_length(scenario.sweep) or range_length(count, at_once)
            for scenario, count, at_once in zip(scenarios, self.cases, together, strict=True)
        ]
        self._counts = [
            -(-n // step) for n, step in zip(self.cases, self._lengths, strict=True)
        ]
        self._ends = list(accumulate(self._counts))

    def __len__(self) -> int:
        """Return the number of ranges."""
        return self._ends[-1]

    def item(self, number: int) -> CaseRange:
        """Return the range with this number."""
        i = bisect_right(self._ends, number)
        begin = (number - self._ends[i] + self._counts[i]) * self._lengths[i]
        end = min(begin + self._lengths[i], self.cases[i])
        first = self.first + sum(self.cases[:i]) + begin
        return CaseRange(self.scenarios[i], first, begin, end)


def seed_ranges(case: Case, least: int = MIN_SEED_RANGES) -> list[CaseRange]:
    """Return the seeds of a case as ranges of a sweep over the seed, at least so many."""
    seeds = seed_range(case.scenario)
    swept = case.scenario.copy_with({"sweep": (Axis(SEED_KEY, "-", seeds),)})
    # Few seeds are solved beyond the end of a stopping rule.
    most = SEEDS_PER_CHECK if stopping_rule(case.scenario) else len(seeds)
    length = min(STEPS_PER_RANGE // case.steps, len(seeds) // least, most) or 1
    firsts = range(0, len(seeds), length)
    return [CaseRange(swept, i, i, min(i + length, len(seeds))) for i in firsts]


def range_length(cases: int, together: bool) -> int:
    """Return the length of the ranges of so many cases; the same on every machine."""
    if together:
        most = MAX_ORBITS if cases <= MAX_ORBITS_IN_SHORT_RANGES else MANY_ORBITS
        return min(max(cases // MIN_ORBIT_RANGES, MIN_ORBITS), most)
    return min(max(1, cases // MAX_RANGES), MAX_CASES_PER_RANGE)


def solve_range(
    case_range: CaseRange, motions: MotionCache, case_workers: Workers = ONE_WORKER
) -> Batch:
    """Solve the cases of a range; errors as in `Plan.block`."""
    scenario, first, begin, end = case_range
    if can_solve_together(scenario):
        return solve_orbit_range(case_range)
    if chain_length(scenario.sweep):
        return solve_chain(case_range, motions, case_workers.is_cancelled)
    points = points_in(point_columns(scenario.sweep, begin, end))
    rows = [solve_case(scenario, point, motions, case_workers) for point in points]
    return Batch.of(first, rows)


def solve_chain(
    case_range: CaseRange, motions: MotionCache, is_cancelled: Callable[[], bool]
) -> Batch:
    """Solve the cases of a chain, each from the last state of the previous one."""
    scenario, first, begin, end = case_range
    columns = point_columns(scenario.sweep, begin, end)
    points, rows = list(points_in(columns)), dict[int, Row]()
    state: AnyState | None = None
    for i in chain_order(scenario.sweep, columns):
        if is_cancelled():
            raise CancelledError
        rows[i], state = solve_row_from(scenario, points[i], motions, state)
    return Batch.of(first, [rows[i] for i in range(end - begin)])


# Cases with several seeds: the row holds means and their confidence intervals.


def solve_case(
    swept: Scenario, point: dict[str, Any], motions: MotionCache, case_workers: Workers
) -> Row:
    """Solve one case of a sweep, over all its seeds if it has several."""
    if not averages_seeds(swept):
        return solve_row(swept, point, motions)
    scenario = swept.at(point)
    case = assemble(scenario, motions.of(with_seed(scenario, seed_range(scenario)[0])))

    def solve_some(case_range: CaseRange) -> Batch:
        if case_workers.is_cancelled():
            raise CancelledError
        return solve_seeds(case, case_range, motions)

    solved = map_in_order(solve_some, seed_ranges(case, case_workers.seeds), case_workers.seeds)
    with closing(solved):
        return mean_row(scenario, point, needed_seeds(scenario, solved))


def solve_seeds(case: Case, case_range: CaseRange, motions: MotionCache) -> Batch:
    """Return the results of some seeds of a case; a numerical failure becomes a status.

    Parameters
    ----------
    case : Case
        Case of any seed: the base motion is all that differs.
    case_range : CaseRange
        One of `seed_ranges`.
    motions : MotionCache
    """
    scenario, first, begin, end = case_range
    points, law = point_columns(scenario.sweep, begin, end), case.law
    observed, notes = [], dict[int, str]()
    for i, seed in enumerate(points[SEED_KEY].tolist()):
        motion = motions.of(with_seed(case.scenario, seed))
        try:
            observed.append(observe_motion(replace(case, motion=motion), case.start)[0])
        except SolverError as fault:
            notes[i] = str(fault)
    size = end - begin
    status = np.full(size, STATUSES.index(OK), dtype=np.int8)
    status[list(notes)] = STATUSES.index(FAILED)
    metrics = {
        name: values
        for name, values in (evaluate(stack(observed)) if observed else {}).items()
        if values is not None
    }
    numbers = np.full((len(FORCES) + len(metrics), size), np.nan)
    numbers[0], numbers[1] = law.F_fk, law.F_fs
    for row, values in zip(numbers[len(FORCES) :], metrics.values(), strict=True):
        row[status == STATUSES.index(OK)] = values
    names = (*FORCES, *metrics)
    return Batch(first, case.scenario.label, points, names, numbers, status, notes)


def mean_row(scenario: Scenario, point: Point, seeds: Batch) -> Row:
    """Combine all seeds of a case; the case fails if one seed fails."""
    count, forces = len(seeds), (float(seeds.F_fk[0]), float(seeds.F_fs[0]))
    first = int(seeds.points[SEED_KEY][0])
    case = Row(point, seeds.approach, *forces, {}, over=OverSeeds(count, first))
    if seeds.notes:
        i, note = next(iter(seeds.notes.items()))
        which = f"{len(seeds.notes)} of {count} seeds failed, the first is seed"
        note = f"{which} {seeds.points[SEED_KEY][i]}: {note}"
        return replace(case, status=FAILED, note=note)
    averages, until = means(seeds), stopping_rule(scenario)
    over = OverSeeds(
        count,
        first,
        {name: half_width for name, (_, half_width) in averages.items()},
        {name: seeds.values(name) for name in seed_metrics(scenario)},
        until is None or is_narrow(until, seeds.metrics[until.metric].tolist()),
    )
    metrics = dict.fromkeys(METRIC_NAMES) | {name: mean for name, (mean, _) in averages.items()}
    return replace(case, metrics=metrics, over=over)


def seed_metrics(scenario: Scenario) -> tuple[str, ...]:
    """Return the metrics whose values are kept for every seed."""
    design, names = scenario.design, ["T_a"]
    if design is not None:
        limits = design.limits(scenario.checks, None)
        names += [*design.minimise, *(limit.metric for limit in limits), STROKE_USED]
    names += [check.metric for check in scenario.checks]
    if scenario.stroke is not None:
        names += ["violations", STROKE_USED, "stroke_suffices"]
    return tuple(dict.fromkeys(names))


# Periodic orbits: one call of the kernel solves a whole range.


def can_solve_together(scenario: Scenario) -> bool:
    """Whether one call of the kernel can solve the cases of a sweep as periodic orbits."""
    friction, measure = scenario.active_friction, scenario.measure
    return (
        measure.steady
        and measure.weights is None
        and scenario.stops is None
        and isinstance(scenario.solver.member(), ExactApproach)
        and isinstance(scenario.excitation, Harmonic | SineSum)
        and not isinstance(scenario.oscillator.damping, ByDirection)
        and (
            friction is None
            or (
                isinstance(friction, Coulomb)
                and not isinstance(friction.kinetic, ByDirection)
                and not isinstance(friction.static, ByDirection)
                and not _may_lift_off(scenario)
            )
        )
    )


def _may_lift_off(scenario: Scenario) -> bool:
    """Whether the normal force of any case may vanish; cases with a record have no orbits."""
    varied = getattr(scenario.active_friction, "normal_variation", None)
    key = "friction.normal_variation.amplitude"
    swept = (axis for axis in scenario.sweep if axis.key == key)
    most = max((max(axis.values) for axis in swept), default=0.0)
    return max(most, varied.amplitude if varied else 0.0) >= 1.0


def solve_orbit_range(case_range: CaseRange) -> Batch:
    """Solve the cases of a range as periodic orbits.

    Raises
    ------
    ScenarioError
        When the values of a case contradict each other.
    """
    from drysim.core.orbit import STATUS
    from drysim.orbits.coulomb import solve_orbits

    scenario, first, begin, end = case_range
    points = point_columns(scenario.sweep, begin, end)
    scenes, forces = scene_array(scenario, points, end - begin)
    chained = chain_length(scenario.sweep) > 0
    if chained:
        results = solve_orbit_chain(scenes, chain_order(scenario.sweep, points))
    else:
        results = solve_orbits(scenes)
    status, notes = orbit_statuses(results)
    metrics = orbit_metrics(scenes, results, status)
    numbers = np.array([*forces, *metrics.values()])
    batch = Batch(first, scenario.label, points, (*FORCES, *metrics), numbers, status, notes)
    crowded = results[:, STATUS] == Status.LOG_FULL
    if chained and crowded.any():
        return solve_chain(case_range, MotionCache(), ONE_WORKER.is_cancelled)
    return solve_individually(scenario, batch, crowded) if crowded.any() else batch


def solve_orbit_chain(scenes: Floats, order: Sequence[int]) -> Floats:
    """Return the answers of scenes, each from the orbit of the one before it in `order`.

    Their start states are replaced in `scenes`. A scene without an orbit passes on the state
    from which it started.
    """
    from drysim.core.forcing import V_R, X_R
    from drysim.core.orbit import STATUS, V_BEGIN, X_BEGIN
    from drysim.orbits.coulomb import solve_orbits

    solved = {}
    state = scenes[order[0], [X_R, V_R]]
    for i in order:
        scenes[i, [X_R, V_R]] = state
        solved[i] = solve_orbits(scenes[i : i + 1])
        if solved[i][0, STATUS] == Status.OK:
            state = solved[i][0, [X_BEGIN, V_BEGIN]]
    return np.concatenate([solved[i] for i in range(len(scenes))])


def solve_individually(scenario: Scenario, batch: Batch, which: NDArray[np.bool_]) -> Batch:
    """Replace the selected cases of a batch, whose events fill the log, by single solutions."""
    rows, motions = list(batch), MotionCache()
    for i in np.flatnonzero(which).tolist():
        rows[i] = solve_row(scenario, dict(rows[i].point), motions)
    return Batch.of(batch.first, rows)


def scene_array(
    scenario: Scenario, points: Columns, length: int
) -> tuple[Floats, tuple[Floats, Floats]]:
    """Return the cases as the array of the orbit kernel, and their F_fk and F_fs [N]."""
    from drysim.core.orbit import SINES

    case = scenario.with_values(points)
    plant, law = case.oscillator.plant(), case.law()
    limits = NO_LIMITS if case.stroke is None else case.stroke.limits
    motion = case.excitation.motion()
    assert isinstance(motion, Sines), "only sines have orbits"
    sines = [column for sine in zip(*motion, strict=True) for column in sine]
    period = common_periods(case, motion.f, length)
    columns = [*plant, *law, *case.start.state(), period, *limits, *sines]
    scenes = np.empty((length, SINES + len(sines)))
    for k, column in enumerate(columns):
        scenes[:, k] = column
    check_first_suspect(scenario, points, case, scenes)
    return scenes, (np.full(length, law.F_fk, float), np.full(length, law.F_fs, float))


def common_periods(case: Scenario, frequencies: tuple[Any, ...], length: int) -> Floats:
    """Return the common period of base motion and normal force [s]; NaN where there is none."""
    friction = case.active_friction
    varied = friction.normal_variation if isinstance(friction, Coulomb) else None
    if varied is None and len(frequencies) == 1:
        return np.full(length, 1.0 / frequencies[0])
    columns = [np.full(length, frequency, float) for frequency in frequencies]
    if varied is not None:
        moves = np.full(length, varied.amplitude, float) != 0.0
        columns.append(np.where(moves, np.full(length, varied.frequency, float), np.nan))
    rows, inverse = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    periods = [common_period(f for f in row if f == f) for row in rows.tolist()]
    return np.array([np.nan if T is None else T for T in periods])[inverse.ravel()]


def check_first_suspect(
    scenario: Scenario, points: Columns, case: Scenario, scenes: Floats
) -> None:
    """Validate the first case that may break a rule, so that its own error is raised."""
    from drysim.core.forcing import F_FK, F_FS, K_X
    from drysim.core.orbit import DOWN, PERIOD, UP

    suspect = (scenes[:, F_FS] < scenes[:, F_FK]) | np.isnan(scenes[:, PERIOD])
    suspect |= (scenes[:, UP] <= 0.0) | (scenes[:, DOWN] <= 0.0)
    if case.oscillator.damping_ratio is not None:
        suspect |= scenes[:, K_X] == 0.0
    for i in np.flatnonzero(suspect)[:1].tolist():
        scenario.at({key: column[i].item() for key, column in points.items()})


ROW_STATUSES = {Status.NOT_SETTLED: NOT_SETTLED, Status.NOT_UNIQUE: NOT_UNIQUE}
"""Status of a row whose motion has no orbit but has not failed."""


def orbit_statuses(results: Floats) -> tuple[NDArray[np.int8], dict[int, str]]:
    """Return the status of each case, and a note for each that has no valid orbit."""
    from drysim.core import orbit as o

    codes = results[:, o.STATUS].astype(np.int64)
    status, notes = np.zeros(len(codes), dtype=np.int8), {}
    for i in np.flatnonzero(codes != Status.OK).tolist():
        code = Status(codes[i])
        notes[i] = code.sentence(t=float(results[i, o.TIME]))
        label = ROW_STATUSES.get(code, FAILED)
        status[i] = STATUSES.index(label)
    return status, notes


def orbit_metrics(
    scenes: Floats, results: Floats, status: NDArray[np.int8], names: Sequence[str] = ()
) -> dict[str, Floats]:
    """Return the metrics of all cases as columns, NaN where unknown; by default all metrics."""
    from drysim.core import orbit as o
    from drysim.core.forcing import F_FK, K_X, B, M

    scene, result = scenes.T.copy(), results.T.copy()
    limits, first = StrokeLimits(scene[o.UP], scene[o.DOWN]), result[o.T_FIRST]
    lowest, highest = np.minimum(result[o.LOWEST], 0.0), np.maximum(result[o.HIGHEST], 0.0)
    peak = np.maximum(abs(lowest), highest)
    measured = Measured(
        Plant(*scene[[M, K_X, B]]),
        scene[F_FK],
        result[o.MULTIPLE] * scene[o.PERIOD],
        Totals(*result[o.X2 : o.U2 + 1])._replace(violation=result[o.VIOLATION]),
        State(result[o.X_BEGIN], result[o.V_BEGIN]),
        State(result[o.X_END], result[o.V_END]),
        lowest=lowest,
        highest=highest,
        run_lowest=lowest,
        run_highest=highest,
        upcrossings=result[o.UPCROSSINGS],
        chatter=0.0 * peak,
        closure=result[o.CLOSURE],
        limits=limits if np.isfinite(limits.up).any() else None,
        limit_entries=result[o.ENTRIES],
        excursions=Excursions(
            result[o.EXCURSIONS_UP],
            result[o.EXCURSIONS_DOWN],
            np.where(first >= 0.0, first, np.nan),
            result[o.TIME_BEYOND],
        ),
        jacobian=(result[o.TRACE], result[o.DETERMINANT]),
    )
    with np.errstate(invalid="ignore"):
        evaluated = (
            {name: METRICS_BY_NAME[name].formula(measured) for name in names}
            if names
            else evaluate(measured)
        )
    metrics = {name: column for name, column in evaluated.items() if column is not None}
    lost = status != STATUSES.index(OK)
    if lost.any():
        failed = status == STATUSES.index(FAILED)
        for name, column in metrics.items():
            metrics[name] = np.where(failed if name == "closure" else lost, np.nan, column)
    return metrics
