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
    `TaylorTrajectory.error` computes a second solution with a larger tolerance and half the
    hysteresis depth. Its distance at the points of the grid estimates the error of the first.
    As a rule that is smaller by orders of magnitude, but both round, so that the estimate is no
    bound where it is as small as rounding.

Source
    Jorba and Zou, A software package for the numerical integration of ODEs by means of
    high-order Taylor methods, Exp. Math. 14 (2005) 99.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from drysim.approach.base_motion import (
    base_square_integrals,
    initial_base_acceleration,
    last_interval,
    make_waves,
    run_duration,
)
from drysim.approach.buffers import as_arrays, empty_columns, empty_log, empty_points
from drysim.approach.grid import grid_times, points_of_trajectory
from drysim.approach.progress import check_progress
from drysim.approach.solution import Events, ExactTrajectory, Grid, events_from_log
from drysim.core.compile import as_engine_array
from drysim.core.dynamic_friction import COUNT, DIRECTION, drop_smallest_loop, update_branch
from drysim.core.events import EventLog, SeriesSegments, decision_margin
from drysim.core.forcing import Scene
from drysim.core.model import (
    BLOCK_SIZE,
    LEUVEN,
    AnyState,
    ContactState,
    DynamicLaw,
    Floats,
    Plant,
    Points,
    Samples,
    Sines,
    Totals,
    limit_force,
    max_abs,
)
from drysim.core.taylor import (
    ORDER,
    SeriesState,
    TaylorSeries,
    evaluate_series,
    integrate_series,
    march_taylor,
    motion_direction_at,
    set_forcing,
)
from drysim.core.trajectory import Solution

COARSENING_FACTOR = 1e3
"""Ratio of the tolerances of the second and the first solution, whose distance states the
error."""

MAX_TOLERANCE = 1e-3
"""Largest tolerance for which the series converge reasonably [-]."""


def coarsened_law(law: DynamicLaw) -> DynamicLaw:
    """Return the law with the tolerance and hysteresis depth of the second solution."""
    tolerance = min(COARSENING_FACTOR * law.tolerance, MAX_TOLERANCE)
    return law._replace(tolerance=tolerance, depth=law.depth // 2)


def compute_trajectory(
    plant: Plant,
    law: DynamicLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
    whole: bool = False,
) -> TaylorTrajectory:
    """Solve a scene and return its trajectory; parameters as in `exact.solve`.

    A limited number of blocks is in memory even where `whole` allows all.
    """
    duration = run_duration(motion, duration)
    dt, last, length = last_interval(motion, duration)
    base = motion.u_dd[:2] if isinstance(motion, Samples) else np.zeros(2)
    scene = Scene(plant, law, make_waves(motion), as_engine_array(base), dt)
    checkpoint = initial_checkpoint(scene, start, speed_floor(plant, motion, start))
    march = TaylorMarch(plant, law, motion, scene, (last, length), [checkpoint])
    events = march.follow()
    # Bristles never stick: a mass at rest takes the direction in which it moves first.
    waits = checkpoint.state.d == 0 and not law.can_stick
    d = events.kind[0] if waits and len(events) else checkpoint.state.d
    F_L = limit_force(plant, start.x_r, initial_base_acceleration(motion))
    t, kind = np.append(0.0, events.t), np.append(np.sign(d), events.kind).astype(np.int8)
    x_r, every_F_L = np.append(start.x_r, events.x_r), np.append(F_L, events.F_L)
    closest = march.checkpoints[-1].state.closest
    return TaylorTrajectory(
        plant=plant,
        law=law,
        motion=motion,
        events=Events(t, kind, x_r, every_F_L),
        end=duration,
        closest_decision=closest,
        march=march,
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class TaylorTrajectory(ExactTrajectory):
    """Solution by Taylor series, known at any time; a limited number of blocks is in memory.

    `events` holds every event and every zero of v_r.
    """

    march: TaylorMarch

    @property
    def series(self) -> tuple[Floats, ...]:
        """Largest magnitude of each state component, block by block."""
        return tuple(np.array(column) for column in zip(*self.march.scales, strict=True))

    def at(self, t: Floats) -> Points:
        """Return the motion at ascending times [s]."""
        march, parts = self.march, [as_arrays(empty_points(0))]
        while len(t):
            number = march.block_index(float(t[0]))
            last = number == len(march.checkpoints) - 2
            ends = math.inf if last else march.block_starts[number + 1]
            count = max(int(np.searchsorted(t, ends)), 1)
            parts.append(march.read(number, t[:count]))
            t = t[count:]
        return Points(*map(np.concatenate, zip(*parts, strict=True)))

    def points(self, dt: float, first: int, last: int) -> Points:
        """Return points `first` to `last` - 1 of a grid with step dt [s]."""
        return points_of_trajectory(self, dt, first, last)

    def error(self, grid: Grid) -> float:
        """Return the largest distance of a coarser solution on a grid, relative to the peak."""
        start, law = self.state(0.0), coarsened_law(self.law)
        coarse = compute_trajectory(self.plant, law, self.motion, start, self.end)
        off, peak = 0.0, 0.0
        for first in range(0, len(grid), BLOCK_SIZE):
            last = min(first + BLOCK_SIZE, len(grid))
            x_r = grid.points(first, last).x_r
            distances = np.abs(coarse.at(grid_times(grid.dt, first, last)).x_r - x_r)
            off, peak = max(off, float(distances.max())), max(peak, float(np.abs(x_r).max()))
        return off / (peak or 1.0)

    def state(self, t: float) -> ContactState:
        """Return the state at time t [s], with the hysteresis stack of a Leuven law."""
        points = self.at(np.array([t]))
        x_r, v_r, z = (float(column[0]) for column in (points.x_r, points.v_r, points.z))
        return ContactState(x_r, v_r, z, self.march.hysteresis_at(t))

    def totals(self, begin: float, end: float) -> Totals:
        """Return the integrals over a window [s]."""
        march, sums, violation = self.march, np.zeros(6), 0.0
        for number in range(march.block_index(begin), march.block_index(end) + 1):
            until = min(end, march.block_starts[number + 1])
            *more, worst = march.integrate(number, begin, until)
            sums, violation = sums + more, max(violation, worst)
        squares = base_square_integrals(self.motion, march.scene.waves, begin, end)
        x2, v2, x_dd2, power, sliding_distance, stuck = sums.tolist()
        totals = Totals(x2, v2, x_dd2, power, sliding_distance, stuck, *squares)
        return totals._replace(violation=violation)


# March in blocks, each of which can be marched again from its checkpoint.


FIRST_BLOCK_STEPS, BLOCK_STEPS = 1_024, 16_384
"""Steps of the first block and of later ones. A short motion needs little memory; between
blocks Python can handle an interrupt."""

MAX_CACHED_BLOCKS = 64
"""Blocks kept in memory, about 80 MB; marching another one again takes about 1 µs per step."""


class SeriesCheckpoint(NamedTuple):
    """Beginning of a block.

    Attributes
    ----------
    state : SeriesState
        State there; its interval of ü counts from the start of the motion.
    scale : float
        Largest speed so far [m/s].
    reversals, branch : tuple
        Hysteresis stack and branch, as in `TaylorSeries`.
    """

    state: SeriesState
    scale: float
    reversals: tuple[float, ...]
    branch: tuple[int, ...]


class TaylorBlock(NamedTuple):
    """Steps of a block: the solution as kernels take it, and where each step begins [s].

    Times and indices of samples count from the first sample of the block, at `first` [s].
    """

    first: float
    solution: Solution
    begins: Floats


@dataclass(frozen=True, eq=False)
class TaylorMarch:
    """March over intervals of ü as checkpoints, with the latest blocks in memory.

    Attributes
    ----------
    plant, law, motion
        The scene.
    scene : Scene
        The scene as kernels take it, with the first two values of ü without the waves.
    until : tuple of (int, float)
        Last interval, and time within it at which the motion ends [s].
    checkpoints : list of SeriesCheckpoint
        Beginning of each block, and the end of the last.
    block_starts : list of float
        Times at which the blocks begin and the last ends [s].
    scales : list of tuple
        Largest |x_r|, |v_r| and |z| at the starts of the series of each block [m, m/s, m].
    cached : dict
        Blocks in memory, by number.
    hysteresis_cache : dict
        Hysteresis stacks computed before, by time.
    """

    plant: Plant
    law: DynamicLaw
    motion: Sines | Samples
    scene: Scene
    until: tuple[int, float]
    checkpoints: list[SeriesCheckpoint]
    block_starts: list[float] = field(default_factory=lambda: [0.0])
    scales: list[tuple[float, ...]] = field(default_factory=list)
    cached: dict[int, TaylorBlock] = field(default_factory=dict)
    hysteresis_cache: dict[float, tuple[float, ...]] = field(default_factory=dict)

    def follow(self) -> Events:
        """March to the end of the motion; return the events after the start."""
        logs: list[EventLog] = []
        while self.checkpoints[-1].state.n <= self.until[0]:
            number = len(logs)
            checkpoint, block, log = self.march_block(number, self.until)
            self.cache_block(number, block)
            self.checkpoints.append(checkpoint)
            self.block_starts.append(self.scene.dt * checkpoint.state.n + checkpoint.state.s)
            segments = block.solution.segments
            self.scales.append(tuple(float(np.abs(column).max()) for column in segments[2:5]))
            logs.append(log)
        every = EventLog(*(np.concatenate(column) for column in zip(*logs, strict=True)))
        return events_from_log(every, len(every.n), self.scene.dt)

    def march_block(
        self, number: int, until: tuple[int, float]
    ) -> tuple[SeriesCheckpoint, TaylorBlock, EventLog]:
        """March through a block; return the checkpoint at its end, its steps and its events.

        `until` is the last interval, and the time [s] within it to which to march.
        """
        checkpoint = self.checkpoints[number]
        size = BLOCK_STEPS if number else FIRST_BLOCK_STEPS
        first, scene, dt, (end, h) = checkpoint.state.n, self.scene, self.scene.dt, until
        if isinstance(self.motion, Samples):
            u_dd = self.motion.u_dd[first : min(first + size, end) + 2]
            scene, end = scene._replace(u_dd=as_engine_array(u_dd)), end - first
        series = workspace(self.law, checkpoint.scale)
        series.reversals[: len(checkpoint.reversals)] = checkpoint.reversals
        series.branch[:] = checkpoint.branch
        segments, log = empty_columns(SeriesSegments, size), empty_log(size)
        state = march_taylor(
            scene, (end, h), checkpoint.state._replace(n=0), series, segments, log
        )
        used, count = state.used, state.events
        state = state._replace(n=first + state.n, used=0, events=0)
        check_progress(count, state.n * dt + state.s, (state.x_r, state.v_r))
        log = EventLog(*(np.asarray(column[:count]) for column in log))
        segments = SeriesSegments(*(column[:used] for column in segments))
        begins = np.asarray(segments.n) * dt + np.asarray(segments.s)
        solution = Solution(scene, segments)
        return (
            make_checkpoint(state, series),
            TaylorBlock(first * dt, solution, begins),
            log._replace(n=log.n + first),
        )

    def hysteresis_at(self, t: float) -> tuple[float, ...]:
        """Return the hysteresis stack at time t [s]: the deflections at the reversals [m].

        Within a block it is found by marching from the checkpoint to that time.
        """
        if self.law.kind != LEUVEN or t >= self.block_starts[-1]:
            return self.checkpoints[-1].reversals
        if t not in self.hysteresis_cache:
            dt, number = self.scene.dt, self.block_index(t)
            n, checkpoint = min(int(t / dt), self.until[0]), self.checkpoints[number]
            if t > self.block_starts[number]:
                within = t - n * dt
                end, h = (n, within) if within > 0.0 else (n - 1, dt)
                checkpoint, *_ = self.march_block(number, (end, h))
            self.hysteresis_cache[t] = checkpoint.reversals
        return self.hysteresis_cache[t]

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
            self.cache_block(number, self.march_block(number, self.until)[1])
        return self.cached[number]

    def read(self, number: int, t: Floats) -> Points:
        """Return the motion at ascending times of a block [s]."""
        first, solution, begins = self.block(number)
        t = t - first
        low, high = np.searchsorted(begins, (t[0], t[-1]), "right")
        steps = slice(max(int(low) - 1, 0), max(int(high), 1))
        near = SeriesSegments(*(column[steps] for column in solution.segments))
        solution, out = solution._replace(segments=near), empty_points(len(t))
        evaluate_series(solution, workspace(self.law), as_engine_array(t), out)
        return as_arrays(out)

    def integrate(self, number: int, begin: float, end: float) -> tuple[float, ...]:
        """Return the integrals and the violation over a window within a block [s]."""
        first, solution, _ = self.block(number)
        work = workspace(self.law)
        sums: tuple[float, ...] = integrate_series(solution, work, begin - first, end - first)
        return sums


SPEED_FLOOR_RATIO = 1e-9
"""Lower bound of the velocity scale relative to the speed that the scene can produce [-]."""


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


# Work space of the kernels, and the checkpoint at the start.


def workspace(law: DynamicLaw, scale: float = 0.0) -> TaylorSeries:
    """Return the arrays of the kernels; `scale` is a speed [m/s] typical of the motion."""
    short = {"scale": 1, "slope": 2, "reversals": law.depth if law.kind == LEUVEN else 0}
    values = {
        name: as_engine_array(np.zeros(short.get(name, ORDER + 2)))
        for name in TaylorSeries._fields
    }
    series = TaylorSeries(**values | {"branch": as_engine_array(np.zeros(3, dtype=np.int64))})
    series.scale[0] = scale
    return series


def make_checkpoint(state: SeriesState, series: TaylorSeries) -> SeriesCheckpoint:
    """Return the checkpoint of a state and of the hysteresis in the workspace."""
    reversals = tuple(float(z) for z in series.reversals[: series.branch[COUNT]])
    branch = tuple(int(value) for value in series.branch)
    return SeriesCheckpoint(state, float(series.scale[0]), reversals, branch)


def initial_checkpoint(scene: Scene, start: AnyState, speed: float) -> SeriesCheckpoint:
    """Return the checkpoint at t = 0; `speed` is one [m/s] typical of the motion."""
    plant, law, waves, u_dd, dt = scene
    x_r, v_r = start[:2]
    z = start[2] if len(start) > 2 else 0.0
    series = workspace(law, speed)
    set_forcing(series, waves, float(u_dd[0]), float(u_dd[1] - u_dd[0]) / dt, 0.0)
    d = motion_direction_at(plant, law, series, x_r, v_r, z)
    if law.kind == LEUVEN:
        restore_hysteresis(series, start[3] if len(start) > 3 else (), z)
        if d != 0:
            update_branch(law, series, int(np.sign(d)), v_r, z)
    closest = math.inf
    if law.can_stick and v_r == 0.0:
        closest = decision_margin(limit_force(plant, x_r, float(series.u[0])), law.F_fs)
    return make_checkpoint(SeriesState(0, 0.0, x_r, v_r, z, d, 0, 0, closest), series)


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
