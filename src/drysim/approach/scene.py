"""What all exact solutions share: waves, the start, the length of a run, room, and numerics."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from drysim.approach.solution import Events, Floats, Numerics
from drysim.core.compile import as_engine_array, engine
from drysim.core.events import MAX_EVENTS_PER_STEP, EventLog, SeriesSegments, initial_mode
from drysim.core.forcing import UNSET_COLUMNS, WAVE_COLUMNS, Waves, mean_squares
from drysim.core.model import (
    LEUVEN,
    AnyLaw,
    AnyState,
    CoulombLaw,
    DynamicLaw,
    ElasticContactLaw,
    EndStopLaw,
    NormalForceLaw,
    Plant,
    Samples,
    Sines,
    base_acceleration,
    integrate_base_squares,
    max_abs,
)
from drysim.core.trajectory import sample_base_grid, table_size
from drysim.errors import SolverError, UsageError

CONSTANT_FRICTION = CoulombLaw(0.0, 0.0)
"""Friction without a wave of its own."""

BASE_AT_REST = Sines((), (), ())
"""A base without waves."""

SAMPLES_PER_CALL = 4_000_000
"""Samples that a kernel may march before it hands over, so that an interrupt is heard."""

MAX_EVENTS, MAX_EVENTS_PER_INTERVAL = 1_000_000, 10
"""Events of a motion that is followed step by step: that many, and that many more a step."""

GRID_TOLERANCE = 1e-9
"""A duration this close to a whole number of steps, relative to one step, is that number."""

SAMPLE_TIME_TOLERANCE = 1e-12
"""What an instant may be beyond a sample and still be that sample's, relative to it."""

SPEED_FLOOR_RATIO = 1e-9
"""Share of the speed that the scene may give, from which on a motion is measured."""

INTEGER_COLUMNS = ("n", "d", "terms")
"""Columns of whole numbers."""


# The base motion: its waves, its values on a grid, how long and how fast it is.


def make_waves(motion: Sines | Samples, law: CoulombLaw = CONSTANT_FRICTION) -> Waves:
    """Give the sines of a scene as the kernels want them; varying friction is one more."""
    values = wave_values(motion if isinstance(motion, Sines) else BASE_AT_REST, law)
    size = len(values) // WAVE_COLUMNS
    return Waves(as_engine_array(np.array(values)), size, size - bool(law.variation))


def wave_values(motion: Sines, law: CoulombLaw) -> list[float]:
    """Give what `Waves` hold of a scene, until they are anchored."""
    values: list[float] = []
    for i, A in enumerate(motion.A):
        f = motion.f[i]
        values += A, f, math.tau * f, motion.phase[i], *UNSET_COLUMNS
    if law.variation:
        values += 0.0, law.omega / math.tau, law.omega, law.phase, *UNSET_COLUMNS
    return values


def initial_base_acceleration(motion: Sines | Samples) -> float:
    """Give ü at t = 0 [m/s²]."""
    if isinstance(motion, Samples):
        return float(motion.u_dd[:1][0])
    return sum(A * math.sin(phase) for A, _, phase in zip(*motion, strict=True))


def grid_times(first: int, last: int, dt: float) -> Floats:
    """Give the times [s] of points of a grid, from number `first` to the one before `last`."""
    return np.arange(first, last, dtype=np.float64) * dt


def base_acceleration_on_grid(
    motion: Sines | Samples, first: int, last: int, dt: float
) -> Floats:
    """Give ü [m/s²] at these points; samples own their grid."""
    if isinstance(motion, Samples):
        return motion.u_dd[first:last]
    return base_acceleration(motion, grid_times(first, last, dt))


def tabulated_base_acceleration(waves: Waves, first: int, last: int, dt: float) -> Floats:
    """Give ü [m/s²] at these points from a table of its sines: a long grid in less time."""
    u_dd, table = (
        as_engine_array(np.empty(last - first)),
        as_engine_array(np.empty(table_size(waves.size))),
    )
    sample_base_grid(waves, first, dt, table, u_dd)
    return np.asarray(u_dd)


@dataclass(frozen=True, eq=False)
class SineGrid:
    """A solution under sines on the grid n·dt, of `length` points; kinds add their `part`."""

    trajectory: Any
    dt: float
    length: int

    def __len__(self) -> int:
        """Give the number of points."""
        return self.length

    def base(self, first: int, last: int) -> Floats:
        """Give ü [m/s²] from point number `first` to the one before `last`."""
        return tabulated_base_acceleration(self.trajectory.waves, first, last, self.dt)


def base_square_integrals(
    motion: Sines | Samples, waves: Waves, begin: float, end: float
) -> tuple[float, float | None]:
    """Give the integrals of ü² and of u² over a window [s]; None where u is not known."""
    if isinstance(motion, Samples):
        return integrate_base_squares(motion, begin, end)
    u_dd2, u2 = mean_squares(waves, begin, end)
    return u_dd2 * (end - begin), u2 * (end - begin)


def run_duration(motion: Sines | Samples, duration: float | None) -> float:
    """Give how long to run [s]: as long as is said, or to the end of the samples."""
    if duration is not None:
        return duration
    if isinstance(motion, Sines):
        raise UsageError("base motion by sines has no end of its own", "say how long to run")
    return (len(motion.u_dd) - 1) * motion.dt


def count_grid_points(duration: float, step: float) -> int:
    """Give the number of grid points n·step from 0 to the duration, both ends included."""
    steps = duration / step
    return int(steps + min(GRID_TOLERANCE * max(1.0, steps), 0.5)) + 1


def last_sample_indices(motion: Samples, end: float) -> tuple[int, int]:
    """Give the last sample up to an instant [s], and the last that the way there needs."""
    last = len(motion.u_dd) - 1
    point = min(last, count_grid_points(end, motion.dt) - 1)
    return point, min(last, point + (end > point * motion.dt * (1.0 + SAMPLE_TIME_TOLERANCE)))


def last_interval(motion: Sines | Samples, duration: float) -> tuple[float, int, float]:
    """Give the intervals of ü [s], the number of the last one and its length [s]."""
    if isinstance(motion, Sines):
        return duration, 0, duration
    dt = motion.dt
    last = min(count_grid_points(duration, dt), len(motion.u_dd)) - 2
    beyond = duration - (last + 1) * dt
    if beyond > dt * GRID_TOLERANCE and last + 2 < len(motion.u_dd):
        return dt, last + 1, beyond
    return dt, last, dt


def speed_floor(plant: Plant, motion: Sines | Samples, start: AnyState) -> float:
    """Give a speed [m/s] far below what the scene will show, but above nothing."""
    if isinstance(motion, Sines):
        swings = (abs(A) / (2.0 * math.pi * f) for A, f in zip(motion.A, motion.f, strict=True))
        base = max(swings, default=0.0)
    else:
        base = max_abs(motion.u_dd) * motion.dt
    free = math.sqrt(plant.k_x / plant.m) * abs(start.x_r)
    return max(
        SPEED_FLOOR_RATIO * base, SPEED_FLOOR_RATIO * free, abs(start.v_r), np.finfo(float).tiny
    )


# Room that kernels write trails and events into.


LOG_LENGTH = 4 * MAX_EVENTS_PER_STEP
"""Events that a kernel may write before it hands over."""


def initial_event(
    plant: Plant, law: CoulombLaw, motion: Sines | Samples, start: AnyState
) -> tuple[EventLog, float]:
    """Give the state at t = 0 as an entry of a log, and how near its mode is to the other [-].

    The margin is infinite where nothing pulls.
    """
    d, F_L, margin = initial_mode(
        plant, law, start.x_r, start.v_r, initial_base_acceleration(motion)
    )
    return EventLog(0, 0.0, d, start.x_r, F_L), margin


def empty_columns(kind: Any, size: int) -> Any:
    """Give room for a trail or for pieces."""
    kinds = (np.int64 if name in INTEGER_COLUMNS else np.float64 for name in kind._fields)
    return kind(*[as_engine_array(np.empty(size, numbers)) for numbers in kinds])


def empty_series_segments(size: int) -> SeriesSegments:
    """Give room for a trail."""
    trail: SeriesSegments = empty_columns(SeriesSegments, size)
    return trail


def empty_log(size: int) -> EventLog:
    """Give room for events."""
    n, kind = (
        as_engine_array(np.empty(size, np.int64)),
        as_engine_array(np.empty(size, np.int8)),
    )
    s, x_r, F_L = as_engine_array(np.empty((3, size)))
    return EventLog(n, s, kind, x_r, F_L)


def write_first_row(room: Any, values: Iterable[Any]) -> None:
    """Put a value into the first place of every column."""
    for column, value in zip(room, values, strict=True):
        column[0] = value


def enlarge_columns(room: Any, size: int) -> Any:
    """Give the same values with more room."""
    return type(room)(*(enlarge_column(column, size) for column in room))


def enlarge_column(column: Any, size: int) -> Any:
    """Give a column with more room behind its values."""
    if isinstance(column, list):
        return column + [0] * (size - len(column))
    wider = np.empty(size, column.dtype)
    wider[: len(column)] = column
    return wider


# What is to be said of a solution, and what refuses one.


def describe_numerics(
    law: AnyLaw,
    motion: Sines | Samples,
    points: int,
    turning_points: Events,
    closest_decision: float,
    error: float | None = None,
    approach: str = "stick-slip",
) -> Numerics:
    """Give what is to be said of how the numbers were made."""
    core, why = core_and_reason(law, motion)
    decision = None if math.isinf(closest_decision) else closest_decision
    counts = points - 1, len(turning_points)
    return Numerics(approach, core, why, engine(), *counts, decision, error=error)


def core_and_reason(law: AnyLaw, motion: Sines | Samples) -> tuple[str, str]:
    """Give the smallest core that is exact for a scene, and why it is."""
    if isinstance(law, EndStopLaw):
        return (
            "bounded",
            "end stops: closed form by modes, from one event to the next; a motion that never "
            "reaches them is solved without them",
        )
    if isinstance(law, ElasticContactLaw):
        return (
            "contact",
            "the contact is a spring until it yields: closed form by modes",
        )
    if isinstance(law, NormalForceLaw):
        kind = "is recorded" if law.force_record else "lifts off"
        return "pressed", f"the normal force {kind}: closed form from change to change"
    if isinstance(law, DynamicLaw):
        kind = "a force that depends on the speed" if law.can_stick else "bristles with a state"
        kind = "bristles with a memory" if law.kind == LEUVEN else kind
        return "series", f"{kind}: Taylor series of the motion, zeros of v_r located"
    if isinstance(motion, Sines):
        return "leap", "sines are used analytically: from event to event"
    if law.variation:
        return "leap", "samples with friction limits that vary: one leap a step"
    return "march", "samples are linear in between: one affine map a step, events located"


def check_progress(count: int, t: float, state: Any, step: float | None = None) -> None:
    """Raise where there are too many events in a step, or the state has left the numbers."""
    if count < 0 and step is None:
        raise no_progress_error(t)
    if count < 0:
        raise SolverError(
            f"at t = {t:.9g} s more than {MAX_EVENTS_PER_STEP} events fall within a step of {step:.9g} s",
            "take a shorter step, or check mass, stiffness and friction: the mass turns and "
            "turns again within a step",
        )
    if not (math.isfinite(state[0]) and math.isfinite(state[1])):
        raise overflow_error(t)


def check_event_count(count: int, steps: int, t: float) -> None:
    """Raise where events are so many that they would fill the memory."""
    if count > MAX_EVENTS + MAX_EVENTS_PER_INTERVAL * steps:
        raise SolverError(
            f"by t = {t:.9g} s there are {count} events, more than anybody reads",
            "a mass that loses next to nothing at a rigid stop chatters there: take a "
            "restitution further below 1, or bumpers; a normal force that vanishes parts the "
            "surfaces in every period: check its frequency; or take a shorter duration",
        )


def no_progress_error(t: float) -> SolverError:
    """Give the error of events that follow each other without end."""
    return SolverError(
        f"at t = {t:.9g} s events follow each other without progress in time",
        "check friction and stiffness for values at the end of double precision",
    )


def overflow_error(t: float) -> SolverError:
    """Give the error of a state that has left the numbers."""
    return SolverError(
        f"by t = {t:.9g} s the motion is beyond the numbers that a computer holds",
        "check the units of the base motion and of the oscillator",
    )
