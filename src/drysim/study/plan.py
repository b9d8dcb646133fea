"""Plan: a sweep as pieces, blocks of cases that follow each other, and how a piece is solved.

What a piece holds depends on the scenario and its number alone, so threads, processes and
other machines compute the same. Periodic orbits under Coulomb friction are solved many at
once, by one call of the kernel; every other case is solved by itself, and over its seeds where
it has many.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass, field, replace
from itertools import accumulate
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from drysim.approach.stick_slip import ExactApproach
from drysim.core.model import Plant, Sines, State, Totals
from drysim.errors import ScenarioError
from drysim.excitation.harmonic import Harmonic, SineSum
from drysim.friction import Coulomb
from drysim.metrics.table import energy_metrics, mean_metrics
from drysim.scenario.axes import count_points, point_columns
from drysim.scenario.model import Columns, Scenario, common_period, with_columns
from drysim.scenario.sampling import LazySequence
from drysim.study.case import Case, combined_sha256
from drysim.study.ensemble import solve_seeds, thread_count
from drysim.study.run import NOT_UNIQUE_NOTE, Job, MotionCache, not_settled_note, solve_row
from drysim.study.statistics import (
    FAILED,
    METRIC_NAMES,
    NOT_SETTLED,
    NOT_UNIQUE,
    OK,
    STATUSES,
    Batch,
    OverSeeds,
    Row,
    is_narrow,
    max_seeds,
    statistics,
    stopping_rule,
)

ORBITS_PER_RANGE = ((1 << 17, 512), (1 << 27, 4096), (None, 65_536))
"""Up to so many cases, so many orbits to a call of the kernel: 10 ms of work, beside which the
rest of a call is a tenth; of more cases longer calls, lest there be too many blocks."""

MAX_RANGES, MAX_CASES_PER_RANGE = 4096, 64
"""Blocks that cases which are solved one by one are cut into, and cases of one at most."""


class Workers(NamedTuple):
    """Who works at a case: how many seeds at a time, and whether anybody still waits for it."""

    seeds: int
    is_cancelled: Callable[[], bool]

    @classmethod
    def at(cls, case: Case, workers: int, count: int, is_cancelled: Callable[[], bool]) -> Self:
        """Give those of so many cases: where threads are left over, seeds go side by side."""
        return cls(max(1, thread_count(case, workers) // count), is_cancelled)


SINGLE_THREAD = Workers(1, lambda: False)
"""One thread, which nothing interrupts but the end of the process."""


@dataclass(frozen=True, eq=False)
class Plan:
    """The blocks of a sweep, which threads, processes and other machines compute alike.

    Attributes
    ----------
    pieces : Pieces
        Which cases each block holds.
    motions : Motions
        Base motions that blocks have in common: kept, not part of what a block depends on.
    """

    ranges: CaseRanges
    motions: MotionCache = field(default_factory=MotionCache)

    @classmethod
    def of(cls, scenarios: Sequence[Scenario], case: Case) -> Self:
        """Give the plan of the approaches to a case whose base motion is known."""
        return cls(CaseRanges(scenarios), MotionCache.starting_with(case))

    def block(self, number: int, case_workers: Workers = SINGLE_THREAD) -> Batch:
        """Give a block of cases by its number; errors as in `sweep`."""
        return solve_range(self.ranges[number], self.motions, case_workers)


def approaches_of(scenario: Scenario) -> tuple[Scenario, ...]:
    """Give the scenario, and its reference where one is asked for.

    Raises
    ------
    ScenarioError
        When it has no sweep block.
    """
    if not scenario.sweep:
        problem = scenario.problem(
            "sweep is required: which keys to vary, and over what", "sweep"
        )
        raise ScenarioError(f"{scenario.name} has nothing to sweep: 1 problem", (problem,))
    reference = scenario.reference
    return (scenario, scenario.with_approach(reference)) if reference else (scenario,)


class CaseRange(NamedTuple):
    """Cases of one approach that are solved at a time.

    Attributes
    ----------
    scenario : Scenario
        Of the approach, with its sweep block.
    first : int
        Number of the first case among those of all approaches.
    begin, end : int
        Numbers of the first case and of the one after the last in the approach's own grid.
    """

    scenario: Scenario
    first: int
    begin: int
    end: int


class CaseRanges(LazySequence[CaseRange]):
    """The pieces of every scenario, in order; each is made from its number when asked for."""

    def __init__(self, scenarios: Sequence[Scenario]) -> None:
        self.scenarios = tuple(scenarios)
        self.cases = [count_points(scenario.sweep) for scenario in scenarios]
        together = map(can_solve_together, scenarios)
        self._lengths = [range_length(*one) for one in zip(self.cases, together, strict=True)]
        self._counts = [
            -(-n // step) for n, step in zip(self.cases, self._lengths, strict=True)
        ]
        self._ends = list(accumulate(self._counts))

    def __len__(self) -> int:
        """Give the number of pieces."""
        return self._ends[-1]

    def one(self, number: int) -> CaseRange:
        """Give one piece."""
        i = bisect_right(self._ends, number)
        begin = (number - self._ends[i] + self._counts[i]) * self._lengths[i]
        end = min(begin + self._lengths[i], self.cases[i])
        return CaseRange(self.scenarios[i], sum(self.cases[:i]) + begin, begin, end)


def range_length(cases: int, together: bool) -> int:
    """Give the length of the pieces of so many cases; the same on every machine."""
    if together:
        return next(step for most, step in ORBITS_PER_RANGE if most is None or cases <= most)
    return min(max(1, cases // MAX_RANGES), MAX_CASES_PER_RANGE)


def solve_range(
    case_range: CaseRange, motions: MotionCache, case_workers: Workers = SINGLE_THREAD
) -> Batch:
    """Give the cases of a piece, solved; errors as in `sweep`."""
    scenario, first, begin, end = case_range
    if can_solve_together(scenario):
        return solve_orbit_range(scenario, first, begin, end)
    points = point_columns(scenario.sweep, begin, end)
    rows = [
        solve_case(Job(first + i, scenario, point), motions, case_workers)
        for i in range(end - begin)
        for point in [{key: column[i].item() for key, column in points.items()}]
    ]
    return Batch.of(first, rows)


# A case that is many seeds: its row holds means, and how well they are known.


def solve_case(job: Job, motions: MotionCache, case_workers: Workers) -> Row:
    """Give the row of a case, of one seed or of many."""
    if max_seeds(job.scenario) == 1 and "excitation.seeds" not in job.point:
        return solve_row(job, motions)
    scenario, rows = job.scenario.at(job.point), []
    for row in solve_seeds(scenario, case_workers.seeds, motion_of=motions.of):
        if case_workers.is_cancelled():
            raise CancelledError
        rows.append(row)
    return mean_row(scenario, job.point, rows)


def mean_row(scenario: Scenario, point: Mapping[str, float], rows: Sequence[Row]) -> Row:
    """Give the rows of all seeds of a case as one; one that fails lets the case fail."""
    first, lost = rows[0], [row for row in rows if row.status != OK]
    case = Row(point, first.approach, first.F_fk, first.F_fs, {}, over=OverSeeds(len(rows)))
    if lost:
        which = f"{len(lost)} of {len(rows)} seeds, the first {lost[0].seed}"
        return replace(case, status=FAILED, note=f"{which}: {lost[0].note}")
    found = statistics(rows)
    until = stopping_rule(scenario)
    over = OverSeeds(
        len(rows),
        {name: one.half_width for name, one in found.items() if one},
        tuple(row.metrics.get("T_a") for row in rows),
        combined_sha256(row.sha256 for row in rows),
        until is None or is_narrow(scenario, rows),
    )
    means = {name: one and one.mean for name, one in found.items()}
    return replace(case, metrics=means, over=over)


# Periodic orbits: one call of the kernel solves a block of them.

Floats = NDArray[np.float64]


def can_solve_together(scenario: Scenario) -> bool:
    """Tell whether the cases of a sweep are orbits that one call of the kernel can solve."""
    friction, measure = scenario.active_friction, scenario.measure
    return (
        measure.steady
        and measure.weights is None
        and scenario.stops is None
        and isinstance(scenario.solver.member(), ExactApproach)
        and isinstance(scenario.excitation, Harmonic | SineSum)
        and (
            friction is None or (isinstance(friction, Coulomb) and not _may_lift_off(scenario))
        )
    )


def _may_lift_off(scenario: Scenario) -> bool:
    """Tell whether the normal force of any case may be zero; a recorded one has no orbits."""
    varied = getattr(scenario.active_friction, "normal_variation", None)
    key = "friction.normal_variation.amplitude"
    swept = (axis for axis in scenario.sweep if axis.key == key)
    most = max((max(axis.values) for axis in swept), default=0.0)
    return max(most, varied.amplitude if varied else 0.0) >= 1.0


def solve_orbit_range(scenario: Scenario, first: int, begin: int, end: int) -> Batch:
    """Give the cases from number `begin` to the one before `end` of a scenario's grid.

    The first of them is number `first` among the cases of all approaches.

    Raises
    ------
    ScenarioError
        When the values of a case do not go together.
    """
    from drysim.approach.coulomb import solve_orbits
    from drysim.core.orbit import LOG_FULL, STATUS

    points = point_columns(scenario.sweep, begin, end)
    scenes, forces = scene_array(scenario, points, end - begin)
    results = solve_orbits(scenes)
    status, notes = orbit_statuses(results)
    metrics = orbit_metrics(scenes, results, status)
    batch = Batch(first, scenario.label, points, *forces, metrics, status, notes)
    crowded = results[:, STATUS] == LOG_FULL
    return solve_individually(scenario, batch, crowded) if crowded.any() else batch


def solve_individually(scenario: Scenario, batch: Batch, which: NDArray[np.bool_]) -> Batch:
    """Give a batch in which some cases are solved one by one: their events fill the log."""
    rows, motions = list(batch), MotionCache()
    for i in np.flatnonzero(which).tolist():
        rows[i] = solve_row(Job(batch.first + i, scenario, dict(rows[i].point)), motions)
    return Batch.of(batch.first, rows)


def scene_array(
    scenario: Scenario, points: Columns, length: int
) -> tuple[Floats, tuple[Floats, Floats]]:
    """Give cases as the kernel wants them, and their F_fk and F_fs [N]."""
    from drysim.core.orbit import SINES

    case = with_columns(scenario, points)
    plant, law = case.oscillator.plant(), case.law()
    limit = np.inf if case.stroke is None else case.stroke.limit
    motion = case.excitation.motion()
    assert isinstance(motion, Sines), "only sines have orbits"
    sines = [column for sine in zip(*motion, strict=True) for column in sine]
    period = common_periods(case, motion.f, length)
    columns = [*plant, *law, *case.start.state(), period, limit, *sines]
    scenes = np.empty((length, SINES + len(sines)))
    for k, column in enumerate(columns):
        scenes[:, k] = column
    check_first_suspect(scenario, points, case, scenes)
    return scenes, (full_column(law.F_fk, length), full_column(law.F_fs, length))


def full_column(value: Any, length: int) -> Floats:
    """Give a column, also of a value that all cases share."""
    return np.broadcast_to(np.asarray(value, dtype=float), (length,)).copy()


def common_periods(case: Scenario, frequencies: tuple[Any, ...], length: int) -> Floats:
    """Give the common period of base motion and normal force [s]; NaN where there is none."""
    friction = case.active_friction
    varied = friction.normal_variation if isinstance(friction, Coulomb) else None
    if varied is None and len(frequencies) == 1:
        return full_column(1.0 / frequencies[0], length)
    columns = [full_column(frequency, length) for frequency in frequencies]
    if varied is not None:
        moves = full_column(varied.amplitude, length) != 0.0
        columns.append(np.where(moves, full_column(varied.frequency, length), np.nan))
    rows, at = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    found = [common_period(f for f in row if f == f) for row in rows.tolist()]
    return np.array([np.nan if period is None else period for period in found])[at.ravel()]


def check_first_suspect(
    scenario: Scenario, points: Columns, case: Scenario, scenes: Floats
) -> None:
    """Let the first case that may break a rule be checked by itself."""
    from drysim.core.forcing import F_FK, F_FS, K_X
    from drysim.core.orbit import PERIOD

    suspect = (scenes[:, F_FS] < scenes[:, F_FK]) | np.isnan(scenes[:, PERIOD])
    if case.oscillator.damping_ratio is not None:
        suspect |= scenes[:, K_X] == 0.0
    for i in np.flatnonzero(suspect)[:1].tolist():
        scenario.at({key: column[i].item() for key, column in points.items()})


def orbit_statuses(results: Floats) -> tuple[NDArray[np.int8], dict[int, str]]:
    """Give what became of every case, and what is to be said where that is no orbit."""
    from drysim.approach.scene import no_progress_error, overflow_error
    from drysim.core import orbit as o

    codes = results[:, o.STATUS].astype(np.int64)
    status, notes = np.zeros(len(codes), dtype=np.int8), {}
    for i in np.flatnonzero(codes != o.CONVERGED).tolist():
        code, at = int(codes[i]), float(results[i, o.TIME])
        if code == o.NOT_CONVERGED:
            label, notes[i] = NOT_SETTLED, not_settled_note(at)
        elif code == o.NOT_UNIQUE:
            label, notes[i] = NOT_UNIQUE, NOT_UNIQUE_NOTE
        else:
            label, notes[i] = (
                FAILED,
                str(no_progress_error(at) if code == o.ENDLESS_EVENTS else overflow_error(at)),
            )
        status[i] = STATUSES.index(label)
    return status, notes


def orbit_metrics(
    scenes: Floats, results: Floats, status: NDArray[np.int8]
) -> dict[str, Floats]:
    """Give every metric of every case; NaN where it is not known."""
    from drysim.core import orbit as o
    from drysim.core.forcing import F_FK, K_X, B, M

    scene, result = scenes.T, results.T
    length = result[o.MULTIPLE] * scene[o.PERIOD]
    totals = Totals(*result[o.X2 : o.U2 + 1])
    plant = Plant(*scene[[M, K_X, B]])
    ends = State(result[o.X_BEGIN], result[o.V_BEGIN]), State(result[o.X_END], result[o.V_END])
    with np.errstate(invalid="ignore"):
        found = mean_metrics(totals, length) | energy_metrics(plant, scene[F_FK], totals, *ends)
    peak = result[o.PEAK]
    found |= {"x_r_peak": peak, "stroke_suffices": peak, "chatter_share": 0.0 * peak}
    found["crossing_rate"] = result[o.UPCROSSINGS] / length
    limited, none = np.isfinite(scene[o.X_RM]), np.full(len(peak), np.nan)
    first = result[o.T_FIRST]
    found["stroke_used"] = np.where(limited, peak / scene[o.X_RM], np.nan)
    found["limit_rate"] = np.where(limited, result[o.ENTRIES] / length, np.nan)
    found["violations"] = np.where(limited, result[o.EXCURSIONS], np.nan)
    found["t_beyond"] = np.where(limited, result[o.TIME_BEYOND], np.nan)
    found["t_first_violation"] = np.where(limited & (first >= 0.0), first, np.nan)
    lost = status != STATUSES.index(OK)
    for column in found.values():
        column[lost] = np.nan
    failed = status == STATUSES.index(FAILED)
    found["closure"] = np.where(failed, np.nan, result[o.CLOSURE])
    return {name: found.get(name, none) for name in METRIC_NAMES}
