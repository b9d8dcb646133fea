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

from drysim.approach.stick_slip import Exact
from drysim.core.model import Plant, Sines, State, Totals
from drysim.errors import ScenarioError
from drysim.excitation.harmonic import Harmonic, SineSum
from drysim.friction import Coulomb
from drysim.metrics.table import energies, means
from drysim.scenario.axes import columns_of, size
from drysim.scenario.model import Columns, Scenario, columned, common_period
from drysim.scenario.sampling import Lazy
from drysim.study.case import Case, sha256_together
from drysim.study.ensemble import rows_of, threads
from drysim.study.run import ONE_OF_MANY, Job, Motions, row_of, unsettled
from drysim.study.statistics import (
    FAILED,
    NAMES,
    NOT_SETTLED,
    NOT_UNIQUE,
    OK,
    STATUSES,
    Batch,
    OverSeeds,
    Row,
    most,
    narrow,
    statistics,
    until_of,
)

TOGETHER = ((1 << 17, 512), (1 << 27, 4096), (None, 65_536))
"""Up to so many cases, so many orbits to a call of the kernel: 10 ms of work, beside which the
rest of a call is a tenth; of more cases longer calls, lest there be too many blocks."""

MOST_BLOCKS, MOST_ALONE = 4096, 64
"""Blocks that cases which are solved one by one are cut into, and cases of one at most."""


class Crew(NamedTuple):
    """Who works at a case: how many seeds at a time, and whether anybody still waits for it."""

    seeds: int
    given_up: Callable[[], bool]

    @classmethod
    def at(cls, case: Case, workers: int, count: int, given_up: Callable[[], bool]) -> Self:
        """Give those of so many cases: where threads are left over, seeds go side by side."""
        return cls(max(1, threads(case, workers) // count), given_up)


ALONE = Crew(1, lambda: False)
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

    pieces: Pieces
    motions: Motions = field(default_factory=Motions)

    @classmethod
    def of(cls, scenarios: Sequence[Scenario], case: Case) -> Self:
        """Give the plan of the approaches to a case whose base motion is known."""
        return cls(Pieces(scenarios), Motions.beginning_with(case))

    def block(self, number: int, crew: Crew = ALONE) -> Batch:
        """Give a block of cases by its number; errors as in `sweep`."""
        return solve_piece(self.pieces[number], self.motions, crew)


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


class Piece(NamedTuple):
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


class Pieces(Lazy[Piece]):
    """The pieces of every scenario, in order; each is made from its number when asked for."""

    def __init__(self, scenarios: Sequence[Scenario]) -> None:
        self.scenarios = tuple(scenarios)
        self.cases = [size(scenario.sweep) for scenario in scenarios]
        together = map(are_orbits, scenarios)
        self._steps = [length_of(*one) for one in zip(self.cases, together, strict=True)]
        self._counts = [-(-n // step) for n, step in zip(self.cases, self._steps, strict=True)]
        self._ends = list(accumulate(self._counts))

    def __len__(self) -> int:
        """Give the number of pieces."""
        return self._ends[-1]

    def one(self, number: int) -> Piece:
        """Give one piece."""
        i = bisect_right(self._ends, number)
        begin = (number - self._ends[i] + self._counts[i]) * self._steps[i]
        end = min(begin + self._steps[i], self.cases[i])
        return Piece(self.scenarios[i], sum(self.cases[:i]) + begin, begin, end)


def length_of(cases: int, together: bool) -> int:
    """Give the length of the pieces of so many cases; the same on every machine."""
    if together:
        return next(step for most, step in TOGETHER if most is None or cases <= most)
    return min(max(1, cases // MOST_BLOCKS), MOST_ALONE)


def solve_piece(piece: Piece, motions: Motions, crew: Crew = ALONE) -> Batch:
    """Give the cases of a piece, solved; errors as in `sweep`."""
    scenario, first, begin, end = piece
    if are_orbits(scenario):
        return solve_orbits(scenario, first, begin, end)
    points = columns_of(scenario.sweep, begin, end)
    rows = [
        row_over_seeds(Job(first + i, scenario, point), motions, crew)
        for i in range(end - begin)
        for point in [{key: column[i].item() for key, column in points.items()}]
    ]
    return Batch.of(first, rows)


# A case that is many seeds: its row holds means, and how well they are known.


def row_over_seeds(job: Job, motions: Motions, crew: Crew) -> Row:
    """Give the row of a case, of one seed or of many."""
    if most(job.scenario) == 1 and "excitation.seeds" not in job.point:
        return row_of(job, motions)
    scenario, rows = job.scenario.at(job.point), []
    for row in rows_of(scenario, crew.seeds, motion_of=motions.of):
        if crew.given_up():
            raise CancelledError
        rows.append(row)
    return join_rows(scenario, job.point, rows)


def join_rows(scenario: Scenario, point: Mapping[str, float], rows: Sequence[Row]) -> Row:
    """Give the rows of all seeds of a case as one; one that fails lets the case fail."""
    first, lost = rows[0], [row for row in rows if row.status != OK]
    case = Row(point, first.approach, first.F_fk, first.F_fs, {}, over=OverSeeds(len(rows)))
    if lost:
        which = f"{len(lost)} of {len(rows)} seeds, the first {lost[0].seed}"
        return replace(case, status=FAILED, note=f"{which}: {lost[0].note}")
    found = statistics(rows)
    until = until_of(scenario)
    over = OverSeeds(
        len(rows),
        {name: one.half_width for name, one in found.items() if one},
        tuple(row.metrics.get("T_a") for row in rows),
        sha256_together(row.sha256 for row in rows),
        until is None or narrow(scenario, rows),
    )
    means = {name: one and one.mean for name, one in found.items()}
    return replace(case, metrics=means, over=over)


# Periodic orbits: one call of the kernel solves a block of them.

Floats = NDArray[np.float64]


def are_orbits(scenario: Scenario) -> bool:
    """Tell whether the cases of a sweep are orbits that one call of the kernel can solve."""
    friction, measure = scenario.acting, scenario.measure
    return (
        measure.steady
        and measure.weights is None
        and scenario.stops is None
        and isinstance(scenario.solver.member(), Exact)
        and isinstance(scenario.excitation, Harmonic | SineSum)
        and (friction is None or (isinstance(friction, Coulomb) and not _lifts(scenario)))
    )


def _lifts(scenario: Scenario) -> bool:
    """Tell whether the normal force of any case may be zero; a recorded one has no orbits."""
    varied = getattr(scenario.acting, "normal_variation", None)
    key = "friction.normal_variation.amplitude"
    swept = (axis for axis in scenario.sweep if axis.key == key)
    most = max((max(axis.values) for axis in swept), default=0.0)
    return max(most, varied.amplitude if varied else 0.0) >= 1.0


def solve_orbits(scenario: Scenario, first: int, begin: int, end: int) -> Batch:
    """Give the cases from number `begin` to the one before `end` of a scenario's grid.

    The first of them is number `first` among the cases of all approaches.

    Raises
    ------
    ScenarioError
        When the values of a case do not go together.
    """
    from drysim.approach.coulomb import solve_orbits
    from drysim.core.orbit import CROWDED, STATUS

    points = columns_of(scenario.sweep, begin, end)
    scenes, forces = scenes_of(scenario, points, end - begin)
    answers = solve_orbits(scenes)
    status, notes = orbit_statuses(answers)
    metrics = orbit_metrics(scenes, answers, status)
    batch = Batch(first, scenario.word, points, *forces, metrics, status, notes)
    crowded = answers[:, STATUS] == CROWDED
    return alone(scenario, batch, crowded) if crowded.any() else batch


def alone(scenario: Scenario, batch: Batch, which: NDArray[np.bool_]) -> Batch:
    """Give a batch in which some cases are solved one by one: their events fill the log."""
    rows, motions = list(batch), Motions()
    for i in np.flatnonzero(which).tolist():
        rows[i] = row_of(Job(batch.first + i, scenario, dict(rows[i].point)), motions)
    return Batch.of(batch.first, rows)


def scenes_of(
    scenario: Scenario, points: Columns, length: int
) -> tuple[Floats, tuple[Floats, Floats]]:
    """Give cases as the kernel wants them, and their F_fk and F_fs [N]."""
    from drysim.core.orbit import SINES

    case = columned(scenario, points)
    plant, law = case.oscillator.plant(), case.law()
    limit = np.inf if case.stroke is None else case.stroke.limit
    motion = case.excitation.motion()
    assert isinstance(motion, Sines), "only sines have orbits"
    sines = [column for sine in zip(*motion, strict=True) for column in sine]
    period = periods_of(case, motion.f, length)
    columns = [*plant, *law, *case.start.state(), period, limit, *sines]
    scenes = np.empty((length, SINES + len(sines)))
    for k, column in enumerate(columns):
        scenes[:, k] = column
    refuse_odd(scenario, points, case, scenes)
    return scenes, (full(law.F_fk, length), full(law.F_fs, length))


def full(value: Any, length: int) -> Floats:
    """Give a column, also of a value that all cases share."""
    return np.broadcast_to(np.asarray(value, dtype=float), (length,)).copy()


def periods_of(case: Scenario, frequencies: tuple[Any, ...], length: int) -> Floats:
    """Give the common period of base motion and normal force [s]; NaN where there is none."""
    friction = case.acting
    varied = friction.normal_variation if isinstance(friction, Coulomb) else None
    if varied is None and len(frequencies) == 1:
        return full(1.0 / frequencies[0], length)
    columns = [full(frequency, length) for frequency in frequencies]
    if varied is not None:
        moves = full(varied.amplitude, length) != 0.0
        columns.append(np.where(moves, full(varied.frequency, length), np.nan))
    rows, at = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    found = [common_period(f for f in row if f == f) for row in rows.tolist()]
    return np.array([np.nan if period is None else period for period in found])[at.ravel()]


def refuse_odd(scenario: Scenario, points: Columns, case: Scenario, scenes: Floats) -> None:
    """Let the first case that may break a rule be checked by itself."""
    from drysim.core.forcing import F_FK, F_FS, K_X
    from drysim.core.orbit import PERIOD

    odd = (scenes[:, F_FS] < scenes[:, F_FK]) | np.isnan(scenes[:, PERIOD])
    if case.oscillator.damping_ratio is not None:
        odd |= scenes[:, K_X] == 0.0
    for i in np.flatnonzero(odd)[:1].tolist():
        scenario.at({key: column[i].item() for key, column in points.items()})


def orbit_statuses(answers: Floats) -> tuple[NDArray[np.int8], dict[int, str]]:
    """Give what became of every case, and what is to be said where that is no orbit."""
    from drysim.approach.scene import overflow, storm
    from drysim.core import orbit as o

    codes = answers[:, o.STATUS].astype(np.int64)
    status, notes = np.zeros(len(codes), dtype=np.int8), {}
    for i in np.flatnonzero(codes != o.SETTLED).tolist():
        code, at = int(codes[i]), float(answers[i, o.TIME])
        if code == o.NOT_SETTLED:
            word, notes[i] = NOT_SETTLED, unsettled(at)
        elif code == o.NOT_UNIQUE:
            word, notes[i] = NOT_UNIQUE, ONE_OF_MANY
        else:
            word, notes[i] = FAILED, str(storm(at) if code == o.STORM else overflow(at))
        status[i] = STATUSES.index(word)
    return status, notes


def orbit_metrics(
    scenes: Floats, answers: Floats, status: NDArray[np.int8]
) -> dict[str, Floats]:
    """Give every metric of every case; NaN where it is not known."""
    from drysim.core import orbit as o
    from drysim.core.forcing import F_FK, K_X, B, M

    scene, answer = scenes.T, answers.T
    length = answer[o.MULTIPLE] * scene[o.PERIOD]
    totals = Totals(*answer[o.X2 : o.U2 + 1])
    plant = Plant(*scene[[M, K_X, B]])
    ends = State(answer[o.X_BEGIN], answer[o.V_BEGIN]), State(answer[o.X_END], answer[o.V_END])
    with np.errstate(invalid="ignore"):
        found = means(totals, length) | energies(plant, scene[F_FK], totals, *ends)
    peak = answer[o.PEAK]
    found |= {"x_r_peak": peak, "stroke_suffices": peak, "chatter_share": 0.0 * peak}
    found["crossing_rate"] = answer[o.UPCROSSINGS] / length
    limited, none = np.isfinite(scene[o.X_RM]), np.full(len(peak), np.nan)
    first = answer[o.T_FIRST]
    found["stroke_used"] = np.where(limited, peak / scene[o.X_RM], np.nan)
    found["limit_rate"] = np.where(limited, answer[o.ENTRIES] / length, np.nan)
    found["violations"] = np.where(limited, answer[o.TIMES], np.nan)
    found["t_beyond"] = np.where(limited, answer[o.T_BEYOND], np.nan)
    found["t_first_violation"] = np.where(limited & (first >= 0.0), first, np.nan)
    lost = status != STATUSES.index(OK)
    for column in found.values():
        column[lost] = np.nan
    failed = status == STATUSES.index(FAILED)
    found["closure"] = np.where(failed, np.nan, answer[o.CLOSURE])
    return {name: found.get(name, none) for name in NAMES}
