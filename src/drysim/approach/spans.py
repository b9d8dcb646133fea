"""What is asked of a base motion before a scene is followed: how long, how fast."""

from __future__ import annotations

import math

import numpy as np

from drysim.approach.events import Floats
from drysim.approach.scene import ON_GRID, grid_points
from drysim.core.base import sample_base
from drysim.core.compiled import held
from drysim.core.means import mean_squares
from drysim.core.motion import Samples, Sines, base_acceleration, sample_squares
from drysim.core.plant import Plant
from drysim.core.signal import largest
from drysim.core.state import AnyState
from drysim.core.table import room
from drysim.core.waves import Waves
from drysim.errors import UsageError

ROUNDING = 1e-12
"""What an instant may be beyond a sample and still be that sample's, relative to it."""

FAINT = 1e-9
"""Share of the speed that the scene may give, from which on a motion is measured."""


def run_length(motion: Sines | Samples, duration: float | None) -> float:
    """Give how long to run [s]: as long as is said, or to the end of the samples."""
    if duration is not None:
        return duration
    if isinstance(motion, Sines):
        raise UsageError("base motion by sines has no end of its own", "say how long to run")
    return (len(motion.u_dd) - 1) * motion.dt


def times(first: int, last: int, dt: float) -> Floats:
    """Give the times [s] of points of a grid, from number `first` to the one before `last`."""
    return np.arange(first, last, dtype=np.float64) * dt


def base_on_grid(motion: Sines | Samples, first: int, last: int, dt: float) -> Floats:
    """Give ü [m/s²] at these points; samples own their grid."""
    if isinstance(motion, Samples):
        return motion.u_dd[first:last]
    return base_acceleration(motion, times(first, last, dt))


def base_of_waves(waves: Waves, first: int, last: int, dt: float) -> Floats:
    """Give ü [m/s²] at these points from a table of its sines: a long grid in less time."""
    u_dd, table = held(np.empty(last - first)), held(np.empty(room(waves.size)))
    sample_base(waves, first, dt, table, u_dd)
    return np.asarray(u_dd)


def last_interval(motion: Sines | Samples, duration: float) -> tuple[float, int, float]:
    """Give the intervals of ü [s], the number of the last one and its length [s]."""
    if isinstance(motion, Sines):
        return duration, 0, duration
    dt = motion.dt
    last = min(grid_points(duration, dt), len(motion.u_dd)) - 2
    beyond = duration - (last + 1) * dt
    if beyond > dt * ON_GRID and last + 2 < len(motion.u_dd):
        return dt, last + 1, beyond
    return dt, last, dt


def last_needed(motion: Samples, end: float) -> tuple[int, int]:
    """Give the last sample up to an instant [s], and the last that the way there needs."""
    last = len(motion.u_dd) - 1
    point = min(last, grid_points(end, motion.dt) - 1)
    return point, min(last, point + (end > point * motion.dt * (1.0 + ROUNDING)))


def faint_speed(plant: Plant, motion: Sines | Samples, start: AnyState) -> float:
    """Give a speed [m/s] far below what the scene will show, but above nothing."""
    if isinstance(motion, Sines):
        swings = (abs(A) / (2.0 * math.pi * f) for A, f in zip(motion.A, motion.f, strict=True))
        base = max(swings, default=0.0)
    else:
        base = largest(motion.u_dd) * motion.dt
    free = math.sqrt(plant.k_x / plant.m) * abs(start.x_r)
    return max(FAINT * base, FAINT * free, abs(start.v_r), np.finfo(float).tiny)


def squares_of_base(
    motion: Sines | Samples, waves: Waves, begin: float, end: float
) -> tuple[float, float | None]:
    """Give the integrals of ü² and of u² over a window [s]; None where u is not known."""
    if isinstance(motion, Samples):
        return sample_squares(motion, begin, end)
    u_dd2, u2 = mean_squares(waves, begin, end)
    return u_dd2 * (end - begin), u2 * (end - begin)
