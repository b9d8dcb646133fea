"""Solution of dynamic friction models by Taylor series: Stribeck, Dahl, LuGre, Leuven.

Problem
    Friction depends on the velocity, or on an internal state with a differential equation of
    its own (mean bristle deflection z), for Leuven with hysteresis. There is no closed form,
    but all functions are analytic between reversals.

Method
    `drysim.core.taylor` integrates with Taylor series of high order, whose step length follows
    from their last coefficients, and locates zeros of v_r within each step. The solution is
    stored as steps in blocks. The checkpoint at the beginning of each block holds the state and
    the hysteresis stack; a long motion keeps a limited number of blocks in memory and marches
    the others again when they are needed.

Error
    A second solution with a larger tolerance and half the hysteresis depth is computed. Its
    distance bounds the error of the first, which is smaller by orders of magnitude.

Source
    Jorba and Zou, A software package for the numerical integration of ODEs by means of
    high-order Taylor methods, Exp. Math. 14 (2005) 99.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from drysim.approach.scene import (
    base_acceleration_on_grid,
    base_square_integrals,
    check_progress,
    count_grid_points,
    describe_numerics,
    empty_log,
    empty_series_segments,
    grid_times,
    initial_base_acceleration,
    last_interval,
    make_waves,
    run_duration,
    speed_floor,
)
from drysim.approach.solution import (
    EventDriven,
    Events,
    Floats,
    Grid,
    Int8Array,
    Points,
    Response,
    StoredGrid,
)
from drysim.core.compile import as_engine_array
from drysim.core.dynamic_friction import COUNT, DIRECTION, drop_smallest_loop, update_branch
from drysim.core.events import EventLog, SeriesSegments
from drysim.core.forcing import Waves
from drysim.core.model import (
    BLOCK_SIZE,
    LEUVEN,
    MAX_CACHED,
    AnyState,
    ContactState,
    DynamicLaw,
    Plant,
    Samples,
    Sines,
    Totals,
)
from drysim.core.taylor import (
    ORDER,
    TaylorSeries,
    evaluate_series,
    integrate_series,
    march_taylor,
    motion_direction_at,
)

COARSENING_FACTOR = 1e3
"""Ratio of the tolerances of the second and the first solution, whose distance states the
error."""

MAX_TOLERANCE = 1e-3
"""Largest tolerance for which the series converge reasonably [-]."""


def solve(
    plant: Plant,
    law: DynamicLaw,
    motion: Sines | Samples,
    start: AnyState,
    step: float,
    duration: float | None,
) -> Response:
    """Solve a scene and return its response on a grid, with an error bound.

    Parameters as in `exact.solve`.
    """
    trajectory = compute_trajectory(plant, law, motion, start, duration)
    dt = motion.dt if isinstance(motion, Samples) else step
    points = count_grid_points(trajectory.end, dt)
    grid: Grid = TaylorGrid(trajectory, dt, points)
    if points <= MAX_CACHED:
        grid = StoredGrid(dt, grid.base(0, points), grid.part(0, points))
    error = relative_distance(
        grid, compute_trajectory(plant, coarsened_law(law), motion, start, duration)
    )
    compute_numerics = partial(
        describe_numerics, law, motion, points, trajectory.turning_points, math.inf, error
    )
    return Response(
        plant, law, motion, grid, trajectory.turning_points, compute_numerics, trajectory
    )


def coarsened_law(law: DynamicLaw) -> DynamicLaw:
    """Return the law with the tolerance and hysteresis depth of the second solution."""
    tolerance = min(COARSENING_FACTOR * law.tolerance, MAX_TOLERANCE)
    return law._replace(tolerance=tolerance, depth=law.depth // 2)


def relative_distance(grid: Grid, other: TaylorTrajectory) -> float:
    """Return the largest distance of another solution from a grid, relative to its peak [-]."""
    off, peak = 0.0, 0.0
    for first in range(0, len(grid), BLOCK_SIZE):
        last = min(first + BLOCK_SIZE, len(grid))
        x_r = grid.part(first, last).x_r
        coarse = other.at(grid_times(first, last, grid.dt))[0]
        off = max(off, float(np.abs(coarse - x_r).max()))
        peak = max(peak, float(np.abs(x_r).max()))
    return off / (peak or 1.0)


def compute_trajectory(
    plant: Plant,
    law: DynamicLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> TaylorTrajectory:
    """Solve a scene and return its trajectory; parameters as in `exact.solve`."""
    duration = run_duration(motion, duration)
    dt, last, length = last_interval(motion, duration)
    waves = make_waves(motion)
    base = motion.u_dd[:2] if isinstance(motion, Samples) else np.zeros(2)
    speed = speed_floor(plant, motion, start)
    checkpoint = initial_checkpoint(plant, law, waves, base, dt, start, speed)
    march = TaylorMarch(plant, law, motion, waves, dt, last, length, [checkpoint])
    log = march.follow()
    F_L = plant.m * initial_base_acceleration(motion) + plant.k_x * start.x_r
    columns = log.n * dt + log.s, log.kind.astype(np.int8), log.x_r, log.F_L
    # Bristles never stick: a mass at rest takes the direction in which it moves first.
    waits = checkpoint.state[3] == 0 and not law.can_stick
    first = log.kind[0] if waits and len(log.kind) else checkpoint.state[3]
    opening = 0.0, np.sign(first), start.x_r, F_L
    every = (
        np.append(np.array([a], b.dtype), b) for a, b in zip(opening, columns, strict=True)
    )
    return TaylorTrajectory(march, Events(*every), duration)


@dataclass(frozen=True, eq=False)
class TaylorTrajectory(EventDriven):
    """Solution by Taylor series, known at any time; a limited number of blocks is in memory.

    `turning_points` holds every change of mode and every zero of v_r.
    """

    march: TaylorMarch
    turning_points: Events
    end: float
    closest_decision: float = math.inf

    @property
    def plant(self) -> Plant:
        """Oscillator."""
        return self.march.plant

    @property
    def law(self) -> DynamicLaw:
        """Friction law."""
        return self.march.law

    @property
    def series(self) -> tuple[Floats, ...]:
        """Largest magnitude of each state component, block by block."""
        return tuple(np.array(column) for column in zip(*self.march.scales, strict=True))

    def at(self, t: Floats) -> tuple[Floats, Floats, Floats, Floats, Int8Array]:
        """Return x_r, v_r, z, F_f and the direction at ascending times [s], shape (n,) each."""
        march, done = self.march, 0
        rows, d = np.empty((4, len(t))), np.empty(len(t), dtype=np.int8)
        while done < len(t):
            number = march.block_index(float(t[done]))
            last = number == len(march.checkpoints) - 2
            ends = math.inf if last else march.block_starts[number + 1]
            part = slice(done, max(int(np.searchsorted(t, ends)), done + 1))
            rows[:, part], d[part] = march.read(number, t[part])
            done = part.stop
        return rows[0], rows[1], rows[2], rows[3], d

    def state(self, t: float) -> ContactState:
        """Return the state at time t [s], with the hysteresis stack of a Leuven law."""
        x_r, v_r, z, _, _ = self.at(np.array([t]))
        reversals = self.march.hysteresis_at(t) if self.law.kind == LEUVEN else ()
        return ContactState(float(x_r[0]), float(v_r[0]), float(z[0]), reversals)

    def totals(self, begin: float, end: float) -> Totals:
        """Return the integrals over a window [s]."""
        march, sums = self.march, np.zeros(6)
        for number in range(march.block_index(begin), march.block_index(end) + 1):
            sums += march.integrate(number, begin, min(end, march.block_starts[number + 1]))
        u_dd2, u2 = base_square_integrals(march.motion, march.waves, begin, end)
        x2, v2, x_dd2, power, sliding_distance, stuck = sums.tolist()
        return Totals(x2, v2, x_dd2, power, sliding_distance, stuck, u_dd2, u2)


@dataclass(frozen=True, eq=False)
class TaylorGrid:
    """Grid of `length` points, evaluated from the series on request."""

    trajectory: TaylorTrajectory
    dt: float
    length: int

    def __len__(self) -> int:
        """Number of points."""
        return self.length

    def base(self, first: int, last: int) -> Floats:
        """Return ü [m/s²] at points `first` to `last` - 1."""
        return base_acceleration_on_grid(self.trajectory.march.motion, first, last, self.dt)

    def part(self, first: int, last: int) -> Points:
        """Return points `first` to `last` - 1."""
        x_r, v_r, _, F_f, d = self.trajectory.at(grid_times(first, last, self.dt))
        return Points(x_r, v_r, d, F_f)


# March in blocks, each of which can be marched again from its checkpoint.


FIRST_BLOCK_STEPS, BLOCK_STEPS = 1_024, 16_384
"""Steps of the first block and of later ones. A short motion needs little memory; between
blocks Python can handle an interrupt."""

MAX_CACHED_BLOCKS = 64
"""Blocks kept in memory, about 80 MB; marching another one again takes about 1 µs per step."""


class TaylorBlock(NamedTuple):
    """Steps of a block: ü from its first sample on, the steps, and where each begins [s].

    Times under samples count from the first sample of the block, at `first` [s].
    """

    first: float
    u_dd: Any
    segments: SeriesSegments
    begins: Floats


@dataclass(frozen=True, eq=False)
class TaylorMarch:
    """March over intervals of ü as checkpoints, with the latest blocks in memory.

    Attributes
    ----------
    plant, law, motion, waves
        The scene.
    dt, length : float
        Length of an interval of ü and of the last one [s].
    last : int
        Index of the last interval.
    checkpoints : list of Checkpoint
        Beginning of each block, and the end of the last.
    block_starts : list of float
        Times at which the blocks begin and the last ends [s].
    scales : list of tuple
        Largest |x_r|, |v_r| and |z| of each block [m, m/s, m].
    cached : dict
        Blocks in memory, by number.
    hysteresis_cache : dict
        Hysteresis stacks computed before, by time.
    """

    plant: Plant
    law: DynamicLaw
    motion: Sines | Samples
    waves: Waves
    dt: float
    last: int
    length: float
    checkpoints: list[Checkpoint]
    block_starts: list[float] = field(default_factory=lambda: [0.0])
    scales: list[tuple[float, ...]] = field(default_factory=list)
    cached: dict[int, TaylorBlock] = field(default_factory=dict)
    hysteresis_cache: dict[float, tuple[float, ...]] = field(default_factory=dict)

    def follow(self) -> EventLog:
        """March to the end of the motion; return the events, counted from the start."""
        logs: list[EventLog] = []
        while self.checkpoints[-1].n <= self.last:
            checkpoint, log = self.march_block(len(self.checkpoints) - 1)
            self.checkpoints.append(checkpoint)
            self.block_starts.append(checkpoint.n * self.dt + checkpoint.s)
            logs.append(log)
        return EventLog(*(np.concatenate(column) for column in zip(*logs, strict=True)))

    def march_block(self, number: int) -> tuple[Checkpoint, EventLog]:
        """March through a block and keep it; return the final checkpoint and the events."""
        first = self.checkpoints[number].n
        checkpoint, log, segments, base = self.march_steps(number, self.last, self.length)
        arrays = [np.asarray(column) for column in segments]
        self.cache_block(
            number,
            TaylorBlock(first * self.dt, base, segments, arrays[0] * self.dt + arrays[1]),
        )
        if number == len(self.scales):
            self.scales.append(tuple(float(np.abs(column).max()) for column in arrays[2:5]))
        return checkpoint, log

    def march_steps(
        self, number: int, last: int, length: float
    ) -> tuple[Checkpoint, EventLog, SeriesSegments, Any]:
        """March through a block, at most to `length` [s] within interval `last`.

        Returns
        -------
        checkpoint : Checkpoint
            At the end of the block.
        log : EventLog
            Events of the block.
        segments : SeriesSegments
            Steps of the block.
        base : ndarray
            ü without the waves [m/s²].
        """
        checkpoint, size = (
            self.checkpoints[number],
            BLOCK_STEPS if number else FIRST_BLOCK_STEPS,
        )
        base = self.base(checkpoint.n, size)
        series = workspace(self.law, checkpoint.scale)
        series.reversals[: len(checkpoint.reversals)] = checkpoint.reversals
        series.branch[:] = checkpoint.branch
        segments, log = empty_series_segments(size), empty_log(size)
        n, s, x_r, v_r, z, d, steps, count = march_taylor(
            self.plant,
            self.law,
            self.waves,
            base,
            self.dt,
            0,
            checkpoint.s,
            length,
            last - checkpoint.n,
            *checkpoint.state,
            series,
            segments,
            0,
            log,
            0,
            size,
        )
        check_progress(count, (checkpoint.n + n) * self.dt + s, (x_r, v_r))
        found = EventLog(*(np.asarray(column[:count]) for column in log))
        found = found._replace(n=found.n + checkpoint.n)
        segments = SeriesSegments(*(column[:steps] for column in segments))
        return (
            make_checkpoint(checkpoint.n + n, s, (x_r, v_r, z, d), series),
            found,
            segments,
            base,
        )

    def hysteresis_at(self, t: float) -> tuple[float, ...]:
        """Return the hysteresis stack at time t [s]: the deflections at the reversals [m].

        Within a block it is found by marching from the checkpoint to that time.
        """
        if t >= self.block_starts[-1]:
            return self.checkpoints[-1].reversals
        if t not in self.hysteresis_cache:
            number, n = self.block_index(t), min(int(t / self.dt), self.last)
            checkpoint, within = self.checkpoints[number], t - n * self.dt
            if t > self.block_starts[number]:
                end = (n, within) if within > 0.0 else (n - 1, self.dt)
                checkpoint = self.march_steps(number, *end)[0]
            self.hysteresis_cache[t] = checkpoint.reversals
        return self.hysteresis_cache[t]

    def base(self, n: int, size: int) -> Any:
        """Return ü without the waves [m/s²] for `size` intervals from sample n on."""
        if isinstance(self.motion, Sines):
            return as_engine_array(np.zeros(2))
        return as_engine_array(self.motion.u_dd[n : min(n + size, self.last) + 2])

    def cache_block(self, number: int, block: TaylorBlock) -> None:
        """Keep a block in memory; drop the oldest one if there are too many."""
        if len(self.cached) >= MAX_CACHED_BLOCKS:
            del self.cached[next(iter(self.cached))]
        self.cached[number] = block

    def block_index(self, t: float) -> int:
        """Return the number of the block that contains time t [s]."""
        return min(max(bisect_right(self.block_starts, t) - 1, 0), len(self.checkpoints) - 2)

    def block(self, number: int) -> TaylorBlock:
        """Return a block; it is marched again if it is not in memory."""
        if number not in self.cached:
            self.march_block(number)
        return self.cached[number]

    def read(self, number: int, t: Floats) -> tuple[tuple[Any, ...], Any]:
        """Return x_r, v_r, z and F_f, and the direction, at ascending times of a block [s]."""
        block = self.block(number)
        within = t - block.first
        first, last = np.searchsorted(block.begins, (within[0], within[-1]), "right")
        steps = slice(max(int(first) - 1, 0), max(int(last), 1))
        segments = SeriesSegments(*(column[steps] for column in block.segments))
        columns = tuple(as_engine_array(np.empty(len(t))) for _ in range(4))
        d = as_engine_array(np.empty(len(t), dtype=np.int64))
        kernel: Any = evaluate_series
        kernel(*self.scene(block), segments, as_engine_array(within), *columns, d)
        return columns, d

    def integrate(self, number: int, begin: float, end: float) -> tuple[float, ...]:
        """Return the integrals over a window within a block [s]."""
        block = self.block(number)
        kernel: Any = integrate_series
        sums: tuple[float, ...] = kernel(
            *self.scene(block), block.segments, begin - block.first, end - block.first
        )
        return sums

    def scene(self, block: TaylorBlock) -> tuple[Any, ...]:
        """Return the leading arguments of the kernels that read a block."""
        return self.plant, self.law, self.waves, block.u_dd, self.dt, workspace(self.law, 0.0)


# Checkpoints: the state and the hysteresis stack at the beginning of a block.


class Checkpoint(NamedTuple):
    """Beginning of a block.

    Attributes
    ----------
    n : int
        Interval of ü.
    s : float
        Time within it [s].
    state : tuple
        x_r [m], v_r [m/s], z [m] and the direction.
    scale : float
        Largest speed so far [m/s].
    reversals, branch : tuple
        Hysteresis stack and branch, as in `TaylorSeries`.
    """

    n: int
    s: float
    state: tuple[float, float, float, int]
    scale: float
    reversals: tuple[float, ...]
    branch: tuple[int, ...]


def workspace(law: DynamicLaw, scale: float) -> TaylorSeries:
    """Return the arrays of the kernels; `scale` is a speed [m/s] typical of the motion."""
    short = {"scale": 1, "slope": 2, "reversals": law.depth if law.kind == LEUVEN else 0}
    values = {
        name: as_engine_array(np.zeros(short.get(name, ORDER + 2)))
        for name in TaylorSeries._fields
    }
    series = TaylorSeries(**values | {"branch": as_engine_array(np.zeros(3, dtype=np.int64))})
    series.scale[0] = scale
    return series


def make_checkpoint(
    n: int, s: float, state: tuple[Any, ...], series: TaylorSeries
) -> Checkpoint:
    """Return the checkpoint of a state and of the hysteresis in the workspace."""
    reversals = tuple(float(z) for z in series.reversals[: series.branch[COUNT]])
    branch = tuple(int(value) for value in series.branch)
    return Checkpoint(n, s, state, float(series.scale[0]), reversals, branch)


def initial_checkpoint(
    plant: Plant, law: DynamicLaw, waves: Waves, base: Floats, dt: float, start: AnyState,
    speed: float,
) -> Checkpoint:  # fmt: skip
    """Return the checkpoint at t = 0, from the first two values of ü without the waves."""
    x_r, v_r = start[:2]
    z = start[2] if len(start) > 2 else 0.0
    series, slope = workspace(law, speed), float(base[1] - base[0]) / dt
    d = motion_direction_at(plant, law, waves, series, float(base[0]), slope, 0.0, x_r, v_r, z)
    if law.kind == LEUVEN:
        restore_hysteresis(series, start[3] if len(start) > 3 else (), z)
        if d != 0:
            update_branch(law, series, int(np.sign(d)), v_r, z)
    return make_checkpoint(0, 0.0, (x_r, v_r, z, d), series)


def restore_hysteresis(series: TaylorSeries, reversals: tuple[float, ...], z: float) -> None:
    """Set the hysteresis stack and branch of a state at deflection z [m].

    The reversals alone determine the direction of the branch: the first one ended the virgin
    curve, which leads away from zero, and each further one reverses the direction. The
    deflection does not: up to rounding it may equal that of the last reversal.
    """
    for level in reversals:
        if series.branch[COUNT] == len(series.reversals):
            drop_smallest_loop(series)
        series.reversals[series.branch[COUNT]] = level
        series.branch[COUNT] += 1
    outwards = int(np.sign(reversals[0] if reversals else z))
    series.branch[DIRECTION] = -outwards if series.branch[COUNT] % 2 else outwards
