"""Base motion as solvers take it: waves, samples, duration, values on a grid."""

from __future__ import annotations

import math

import numpy as np

from drysim.core.compile import as_engine_array
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
    CoulombLaw,
    Floats,
    PiecewiseLaw,
    Samples,
    Sines,
    integrate_base_squares,
    recall_for,
)
from drysim.errors import UsageError

CONSTANT_FRICTION = CoulombLaw(0.0, 0.0)
"""Law with constant friction limits, to build waves without a varying limit."""

BASE_AT_REST = Sines((), (), ())
"""Base motion without waves."""

GRID_TOLERANCE = 1e-9
"""Tolerance within which a duration counts as a whole number of steps, relative to one step."""

SAMPLE_TIME_TOLERANCE = 1e-12
"""Relative tolerance within which a time counts as that of a sample."""


def make_waves(
    motion: Sines | Samples, law: CoulombLaw | PiecewiseLaw = CONSTANT_FRICTION
) -> Waves:
    """Return the sines of a scene as kernel arrays; a varying friction limit is one more."""
    values = wave_values(motion if isinstance(motion, Sines) else BASE_AT_REST, law)
    size = len(values) // WAVE_COLUMNS
    return Waves(as_engine_array(np.array(values)), size, size - bool(law.variation))


def wave_values(motion: Sines, law: CoulombLaw | PiecewiseLaw) -> list[float]:
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


def base_square_integrals(
    motion: Sines | Samples, waves: Waves, begin: float, end: float
) -> tuple[float, float | None]:
    """Return the integrals of ü² and u² over a window [s]; None where u is unknown."""
    if isinstance(motion, Samples):
        return recall_for(motion, integrate_base_squares, begin, end)
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
