"""Functions shared by the solvers: forcing, grids, buffers, reports, checks.

A scene is an oscillator, a friction law, a base motion and a start state. This module converts
it to the arrays of the kernels, allocates the buffers that they write to, describes the chosen
algorithm, and raises errors where a solution stalls or overflows.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from drysim.approach.solution import Floats
from drysim.core.compile import as_engine_array
from drysim.core.events import (
    MAX_EVENTS_PER_STEP,
    EventLog,
    initial_direction,
)
from drysim.core.forcing import (
    GRID_COLUMNS,
    TURN_ROWS,
    UNSET_COLUMNS,
    WAVE_COLUMNS,
    Waves,
    fill_turns,
    mean_squares,
    sample_base,
)
from drysim.core.model import (
    MAX_STAGES,
    NO_LIMITS,
    AnyState,
    CoulombLaw,
    EndStops,
    PiecewiseLaw,
    Plant,
    Points,
    Samples,
    Sines,
    integrate_base_squares,
    max_abs,
)
from drysim.core.modes import KernelLaw, Side
from drysim.core.sampled import SampledMotion
from drysim.core.status import Status
from drysim.errors import UsageError

CONSTANT_FRICTION = CoulombLaw(0.0, 0.0)
"""Law with constant friction limits, to build waves without a varying limit."""

BASE_AT_REST = Sines((), (), ())
"""Base motion without waves."""

SAMPLES_PER_CALL = 4_000_000
"""Samples per kernel call; between calls Python can handle an interrupt."""

MAX_EVENTS, MAX_EVENTS_PER_INTERVAL = 1_000_000, 10
"""Events allowed in one solution, plus those allowed per sample, or per period under sines.
More would fill the memory."""

GRID_TOLERANCE = 1e-9
"""Tolerance within which a duration counts as a whole number of steps, relative to one step."""

SAMPLE_TIME_TOLERANCE = 1e-12
"""Relative tolerance within which a time counts as that of a sample."""

SPEED_FLOOR_RATIO = 1e-9
"""Lower bound of the velocity scale relative to the speed that the scene can produce [-]."""

INTEGER_COLUMNS = ("n", "d", "terms")
"""Columns of integers in a table of segments."""


# Base motion: waves, values on a grid, duration and speed.


def make_waves(motion: Sines | Samples, law: CoulombLaw = CONSTANT_FRICTION) -> Waves:
    """Return the sines of a scene as kernel arrays; a varying friction limit is one more."""
    values = wave_values(motion if isinstance(motion, Sines) else BASE_AT_REST, law)
    size = len(values) // WAVE_COLUMNS
    return Waves(as_engine_array(np.array(values)), size, size - bool(law.variation))


def wave_values(motion: Sines, law: CoulombLaw) -> list[float]:
    """Return the columns of `Waves` before their phases are set."""
    values: list[float] = []
    for i, A in enumerate(motion.A):
        f = motion.f[i]
        values += A, f, math.tau * f, motion.phase[i], *UNSET_COLUMNS
    if law.variation:
        values += 0.0, law.omega / math.tau, law.omega, law.phase, *UNSET_COLUMNS
    return values


def initial_base_acceleration(motion: Sines | Samples) -> float:
    """Return ü at t = 0 [m/s²]."""
    if isinstance(motion, Samples):
        return float(motion.u_dd[:1][0])
    return sum(A * math.sin(phase) for A, _, phase in zip(*motion, strict=True))


def grid_times(dt: float, first: int, last: int) -> Floats:
    """Return the times [s] of the grid points `first` to `last` - 1."""
    return np.arange(first, last, dtype=np.float64) * dt


def base_acceleration_on_grid(
    motion: Sines | Samples, dt: float, first: int, last: int
) -> Floats:
    """Return ü [m/s²] at grid points `first` to `last` - 1; samples have their own grid."""
    if isinstance(motion, Samples):
        return motion.u_dd[first:last]
    waves, u_dd = make_waves(motion), as_engine_array(np.empty(last - first))
    table = as_engine_array(np.empty((TURN_ROWS * waves.size, GRID_COLUMNS)))
    fill_turns(waves, dt, table)
    sample_base(waves, (first, last), dt, table, first, u_dd)
    return np.asarray(u_dd)


def points_of_trajectory(trajectory: Any, dt: float, first: int, last: int) -> Points:
    """Return grid points `first` to `last` - 1 of a trajectory that is known at any time."""
    points: Points = trajectory.at(grid_times(dt, first, last))
    rest = np.flatnonzero(points.d == 0)
    if len(rest):
        points.x_dd[rest] = base_acceleration_on_grid(trajectory.motion, dt, first, last)[rest]
    return points if trajectory.law.stops is not None else points._replace(F_stop=None)


def base_square_integrals(
    motion: Sines | Samples, waves: Waves, begin: float, end: float
) -> tuple[float, float | None]:
    """Return the integrals of ü² and u² over a window [s]; None where u is unknown."""
    if isinstance(motion, Samples):
        return integrate_base_squares(motion, begin, end)
    u_dd2, u2 = mean_squares(waves, begin, end)
    return u_dd2 * (end - begin), u2 * (end - begin)


def run_duration(motion: Sines | Samples, duration: float | None) -> float:
    """Return the duration of a run [s]: the given one, or the length of the samples."""
    if duration is not None:
        return duration
    if isinstance(motion, Sines):
        raise UsageError("a run under sines needs a duration", "give a duration")
    return (len(motion.u_dd) - 1) * motion.dt


def count_grid_points(duration: float, step: float) -> int:
    """Return the number of grid points n·step from 0 to the duration, both ends included."""
    steps = duration / step
    return int(steps + min(GRID_TOLERANCE * max(1.0, steps), 0.5)) + 1


def last_sample_indices(motion: Samples, end: float) -> tuple[int, int]:
    """Return the index of the last sample up to a time [s], and of the last one to march to."""
    last = len(motion.u_dd) - 1
    point = min(last, count_grid_points(end, motion.dt) - 1)
    return point, min(last, point + (end > point * motion.dt * (1.0 + SAMPLE_TIME_TOLERANCE)))


def last_interval(motion: Sines | Samples, duration: float) -> tuple[float, int, float]:
    """Return length of the intervals of ü [s], index of the last one, and its length [s]."""
    if isinstance(motion, Sines):
        return duration, 0, duration
    dt = motion.dt
    last = min(count_grid_points(duration, dt), len(motion.u_dd)) - 2
    beyond = duration - (last + 1) * dt
    if beyond > dt * GRID_TOLERANCE and last + 2 < len(motion.u_dd):
        return dt, last + 1, beyond
    return dt, last, dt


def speed_floor(plant: Plant, motion: Sines | Samples, start: AnyState) -> float:
    """Return a lower bound on the speed to which tolerances refer [m/s]."""
    if isinstance(motion, Sines):
        swings = (abs(A) / (2.0 * math.pi * f) for A, f in zip(motion.A, motion.f, strict=True))
        base = max(swings, default=0.0)
    else:
        base = max_abs(motion.u_dd) * motion.dt
    free = math.sqrt(plant.k_x / plant.m) * abs(start.x_r)
    return max(
        SPEED_FLOOR_RATIO * base, SPEED_FLOOR_RATIO * free, abs(start.v_r), np.finfo(float).tiny
    )


# The law as kernels take it.


NO_RECORD, NO_STOPS = np.ones(2), EndStops(NO_LIMITS)
"""A normal force without a record, and a mass without end stops, for kernels."""


def to_kernel(plant: Plant, law: PiecewiseLaw) -> KernelLaw:
    """Return a law, with the damper of the plant, as its kernels take it.

    Raises
    ------
    UsageError
        For a combination that is not modelled: an elastic contact would yield while its mass
        rests against a rigid stop.
    """
    if law.stops is not None and law.stops.rigid and law.is_elastic and law.varies:
        raise UsageError(
            "an elastic contact under a varying normal force does not go with rigid stops",
            "use bumpers",
        )
    record, step = as_engine_array(NO_RECORD), 0.0
    if law.force_record is not None:
        record, step = law.force_record.kernel_input, law.force_record.step
    stops = law.stops or NO_STOPS
    stages = [*stops.stages, *[(math.inf, 0.0)] * (MAX_STAGES - len(stops.stages))]
    if not stops.stages:
        stages[0] = 0.0, 0.0
    (a_1, k_1), (a_2, k_2), (a_3, k_3) = stages
    b_up, b_down = law.damping or (plant.b, plant.b)
    up = Side(law.F_fk, law.F_fs, b_up, stops.limits.up)
    down = Side(*(law.compression or (law.F_fk, law.F_fs)), b_down, stops.limits.down)
    wave = law.variation, law.omega, law.phase
    k_s, begins = (k_1, k_2, k_3), (a_1, a_2, a_3)
    return KernelLaw(up, down, law.k_t, *wave, record, step, k_s, begins, stops.b_s, stops.e)


# Buffers for segments and events.


LOG_LENGTH = 4 * MAX_EVENTS_PER_STEP
"""Rows of an event log that a kernel may fill before it returns."""


def initial_event(
    plant: Plant, law: CoulombLaw, motion: Sines | Samples, start: AnyState
) -> tuple[EventLog, float]:
    """Return the state at t = 0 as a row of an event log, and the margin of its mode [-].

    The margin is infinite where no force acts.
    """
    d, F_L, margin = initial_direction(
        plant, law, start.x_r, start.v_r, initial_base_acceleration(motion)
    )
    return EventLog(0, 0.0, d, start.x_r, F_L), margin


def empty_columns(kind: Any, size: int) -> Any:
    """Return a table of segments of some kind with uninitialised columns."""
    kinds = (np.int64 if name in INTEGER_COLUMNS else np.float64 for name in kind._fields)
    return kind(*[as_engine_array(np.empty(size, numbers)) for numbers in kinds])


def empty_points(n: int) -> Points:
    """Return uninitialised points of a motion at n times."""
    x_r, v_r, x_dd, F_f, F_stop, z = as_engine_array(np.empty((6, n)))
    return Points(x_r, v_r, as_engine_array(np.empty(n, np.int8)), x_dd, F_f, F_stop, z)


def as_arrays(points: Points) -> Points:
    """Return points that a kernel has written as arrays of numpy."""
    columns: Any = (None if column is None else np.asarray(column) for column in points)
    arrays = Points(*columns)
    return arrays._replace(d=arrays.d.astype(np.int8, copy=False))


def empty_samples(n: int) -> SampledMotion:
    """Return an uninitialised motion at n samples."""
    # One allocation, which the allocator reuses for the next block of this length.
    x_r, v_r = as_engine_array(np.empty((2, n)))
    return SampledMotion(x_r, v_r, as_engine_array(np.empty(n, dtype=np.int8)))


def empty_log(size: int) -> EventLog:
    """Return an uninitialised event log."""
    n, kind = (
        as_engine_array(np.empty(size, np.int64)),
        as_engine_array(np.empty(size, np.int8)),
    )
    s, x_r, F_L = as_engine_array(np.empty((3, size)))
    return EventLog(n, s, kind, x_r, F_L)


def write_first_row(columns: Any, values: Iterable[Any]) -> None:
    """Write the first row of a table."""
    for column, value in zip(columns, values, strict=True):
        column[0] = value


def enlarge_columns(columns: Any, size: int) -> Any:
    """Return a table with more rows and the same values."""
    return type(columns)(*(enlarge_column(column, size) for column in columns))


def enlarge_column(column: Any, size: int) -> Any:
    """Return a column with more rows and the same values."""
    if isinstance(column, list):
        return column + [0] * (size - len(column))
    wider = np.empty(size, column.dtype)
    wider[: len(column)] = column
    return wider


# Report on a solution, and its checks.


def check_progress(count: int, t: float, state: Any, step: float = math.inf) -> None:
    """Raise SolverError for a `Status` in place of a count of events, or a state not finite.

    `step` is that of the samples [s].
    """
    if count >= 0 and not (math.isfinite(state[0]) and math.isfinite(state[1])):
        count = Status.OVERFLOW
    if count < 0:
        raise Status(count).error(t=t, step=step, count=MAX_EVENTS_PER_STEP)


def count_intervals(
    plant: Plant, law: CoulombLaw | PiecewiseLaw, motion: Sines | Samples, duration: float
) -> float:
    """Return the number of samples, or of periods of base, normal force and oscillator."""
    if isinstance(motion, Samples):
        return duration / motion.dt
    natural = math.sqrt(plant.k_x / plant.m) / math.tau
    return duration * (max(motion.f, default=0.0) + law.omega / math.tau + natural)


def check_event_count(count: int, intervals: float, t: float) -> None:
    """Raise SolverError where events are too many for the memory."""
    if count > MAX_EVENTS + MAX_EVENTS_PER_INTERVAL * intervals:
        raise Status.MANY_EVENTS.error(t=t, count=count)
