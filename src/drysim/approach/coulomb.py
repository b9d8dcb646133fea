"""Exact solution of Coulomb friction with constant or sinusoidal friction limits.

Problem
    m x_r'' + b v_r + k_x x_r + d F_fk = -m ü while sliding in direction d; x_r is constant
    while stuck. Between events the equation is linear with constant coefficients.

Method
    Under sines the kernels march from event to event: the motion between two events is the sum
    of a free response and one steady response per sine, both in closed form. No grid is
    involved; any grid, integral or periodic orbit is evaluated from the events afterwards. Over
    samples ü is linear in each step, so a step without events is one affine map, and a step
    with events is divided at them. Long sample series are marched block by block, and only the
    state at the beginning of each block is kept (`Checkpoint`): a block is marched again, to
    the same last bit, when its points are needed.

Why no event is missed
    Events are first roots of functions in closed form, bracketed between their extrema or
    approached by steps with a bounded remainder; see `drysim.core.roots` and
    `drysim.core.sampled`.

Source
    Eqs. (4), (7) and (9) of the paper. Den Hartog, Phil. Mag. 11 (1931) 801.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from drysim.approach.base_motion import (
    initial_base_acceleration,
    last_sample_indices,
    make_waves,
    run_duration,
    wave_values,
)
from drysim.approach.buffers import (
    as_arrays,
    empty_log,
    empty_samples,
    enlarge_column,
    enlarge_columns,
    write_first_row,
)
from drysim.approach.grid import grid_times
from drysim.approach.piecewise import (
    PiecewiseBlock,
    PiecewiseMarch,
    PiecewiseTrajectory,
    to_kernel,
)
from drysim.approach.progress import check_event_count, check_progress, count_intervals
from drysim.approach.solution import (
    BlockwiseMarch,
    Events,
    Floats,
    Int8Array,
    MarchedTrajectory,
)
from drysim.core.compile import as_engine_array, python_of
from drysim.core.events import MAX_EVENTS_PER_STEP, EventLog, Segments, initial_direction
from drysim.core.forcing import SCENE_COLUMNS, WAVE_COLUMNS, Scene, Waves
from drysim.core.march import (
    Interval,
    MarchState,
    SlipState,
    march_sines,
    march_sines_from_start,
    march_varying_limits,
)
from drysim.core.measure import measure, total_of
from drysim.core.model import (
    BLOCK_SIZE,
    MAX_CACHED,
    AnyState,
    CoulombLaw,
    PiecewiseLaw,
    Plant,
    Points,
    Samples,
    Sines,
    State,
    Totals,
    integrate_base_squares,
    limit_force,
)
from drysim.core.modes import APART, REGULAR, Mode, encode_mode
from drysim.core.orbit import SineMarch
from drysim.core.sampled import (
    SampledMotion,
    SampledState,
    accelerations_at_samples,
    empty_base_sums,
    march,
)
from drysim.core.stroke import Crossings
from drysim.core.trajectory import (
    SampledSolution,
    sample_coulomb_grid,
    state_in_step,
    table_shape,
)
from drysim.core.variational import event_monodromy


def compute_trajectory(
    plant: Plant,
    law: CoulombLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
    whole: bool = False,
) -> SlipTrajectory | SampledTrajectory:
    """Solve a scene and return its trajectory; parameters as in `exact.solve`.

    Under sines no grid is involved.
    """
    if isinstance(motion, Sines):
        return sine_trajectory(plant, law, motion, start, duration)
    end = run_duration(motion, duration)
    last = last_sample_indices(motion, end)[1]
    march, events, closest_decision = march_blocks(plant, law, motion, start, last, whole)
    return SampledTrajectory(march, events.until(end), end, closest_decision)


# Sines: from event to event, on any grid.


EVENTS_PER_CALL = 1_000_000
"""Events per kernel call; between calls Python can handle an interrupt."""

INITIAL_EVENT_CAPACITY = 1024
"""Initial rows of the event log; doubled when it is full."""


def sine_trajectory(
    plant: Plant,
    law: CoulombLaw | PiecewiseLaw,
    motion: Sines,
    start: AnyState,
    duration: float | None,
) -> SlipTrajectory:
    """Solve a scene under sines from event to event, without a grid.

    The contact is that of Coulomb friction. End stops of the law do not act: the motion is a
    solution only where it does not reach them.
    """
    duration = run_duration(motion, duration)
    (x_0, v_0), contact = start[:2], law.without_stops
    assert isinstance(contact, CoulombLaw), "else `piecewise` solves it"
    scene = np.array([*plant, *contact, x_0, v_0, *wave_values(motion, contact)])
    scene = as_engine_array(scene)
    log, kind = (
        as_engine_array(np.empty((4, INITIAL_EVENT_CAPACITY))),
        as_engine_array(np.empty(INITIAL_EVENT_CAPACITY, np.int8)),
    )
    state = march_sines_from_start(scene, duration, log, kind)
    begin, x_r, v_r, _, count, closest_decision = state
    check_progress(count, begin, (x_r, v_r))
    periods = count_intervals(plant, law, motion, duration)
    while begin < duration:
        check_event_count(count, periods, begin)
        size = min(2 * len(kind), count + EVENTS_PER_CALL)
        log, kind = (
            as_engine_array(np.hstack((log, np.empty((4, size - len(kind)))))),
            enlarge_column(kind, size),
        )
        interval, waves = Interval(0, 0.0, duration, 0.0, 0.0), make_waves(motion, contact)
        columns = EventLog(log[0], log[1], kind, log[2], log[3])
        state = march_sines(plant, contact, waves, interval, state, columns)
        begin, x_r, v_r, _, count, closest_decision = state
        check_progress(count, begin, (x_r, v_r))
    # Rows by index: unpacking the array row by row takes as long as some tens of events.
    log, kind = np.asarray(log), np.asarray(kind[:count], dtype=np.int8)
    events = Events(log[1, :count], kind, log[2, :count], log[3, :count])
    size = (len(scene) - SCENE_COLUMNS) // WAVE_COLUMNS
    waves, steps = Waves(scene[SCENE_COLUMNS:], size, len(motion.A)), (duration, duration)
    march = SlipMarch(plant, law, motion, 1, 1, [(v_0, events, state)], waves, steps)
    return SlipTrajectory(march, events, None, None, duration, closest_decision)


@dataclass(frozen=True, eq=False)
class SlipMarch(PiecewiseMarch):
    """March with Coulomb friction under sines, whose events are known.

    Its checkpoint holds the velocity at the start [m/s], the events, and the `SlipState` at the
    end.
    """

    def march_block(self, number: int) -> MarchState:
        """Write the motion as segments and keep it in memory; return the state at its end."""
        v_0, events, end = self.checkpoints[number]
        t, kind, x, F_L = events.t, events.kind, events.x_r, events.F_L
        count, u_dd = len(t), np.zeros(2)
        n, (s, x_r, v_r, x_0) = np.zeros(count + 1, np.int64), np.zeros((4, count + 1))
        s[:count], x_r[:count], v_r[0] = t, x, v_0
        s[count], x_r[count], v_r[count], d, _, closest = end
        codes = np.full(count + 1, CODES[d])
        codes[:count] = CODES[np.sign(kind)]
        rows, log = Segments(n, s, x_r, v_r, x_0, codes), EventLog(n[:count], t, kind, x, F_L)
        scene = Scene(self.plant, self.kernel_law, self.waves, as_engine_array(u_dd), end.s)
        self.cached[number] = PiecewiseBlock(0, u_dd, None, rows, log, scene)
        mode, x, v = Mode(d, d, APART, 0, 0, REGULAR), end.x_r, end.v_r
        return MarchState(1, 0.0, x, v, math.nan, x, mode, count + 1, count, closest)


@dataclass(frozen=True, eq=False)
class SlipTrajectory(PiecewiseTrajectory):
    """Solution with Coulomb friction under sines."""

    def points(self, dt: float, first: int, last: int) -> Points:
        """Return points `first` to `last` - 1 of a grid with step dt [s]."""
        v_0, events, _ = self.march.checkpoints[0]
        contact, waves = self.law.without_stops, self.march.waves
        columns = map(as_engine_array, (events.t, events.kind, events.x_r))
        x_r, v_r, x_dd = as_engine_array(np.empty((3, last - first)))
        points = Points(x_r, v_r, as_engine_array(np.empty(last - first, np.int8)), x_dd)
        table = as_engine_array(np.empty(table_shape(waves.size)))
        scene = self.plant, contact, waves
        sample_coulomb_grid(scene, (*columns, v_0), first, dt, table, points[:4])
        return as_arrays(points)

    def monodromy(self) -> Floats:
        """Return the derivative of x_r [m] and v_r [m/s] at the end by the first ones.

        To the last bit that of the same orbit in a block.
        """
        log = EventLog(*map(as_engine_array, self.march.block(0).log))
        scene = SineMarch(self.plant, self.law.without_stops, self.march.waves, log)
        # The first event is the state at the start.
        d, count = log.kind[0], len(log.kind)
        return np.array(event_monodromy(scene, self.end, 1.0, d, 1, count)).reshape(2, 2)


# Samples: known at every sample and at every event between samples.


SAMPLES_PER_EVENT = 16
"""Samples per initial row of the event log; rows that are not written take no memory."""

Checkpoint = tuple[float, float, int, float]
"""x_r [m], v_r [m/s], direction and relative acceleration [m/s²] at the first sample of a
block. The acceleration decides where v_r is close to rounding; NaN where x_r and v_r
determine it."""


@dataclass(frozen=True, eq=False)
class SampledTrajectory(MarchedTrajectory):
    """Solution over samples: known at every sample and at every event between."""

    march: CoulombMarch

    def points(self, dt: float, first: int, last: int) -> Points:
        """Return the points at samples `first` to `last` - 1, dt [s] apart."""
        law, motion, n = self.law, self.march.samples(first, last), last - first
        x_dd, u_dd = as_engine_array(np.empty(n)), as_engine_array(self.motion.u_dd[first:last])
        columns = SampledMotion(*map(as_engine_array, motion))
        accelerations_at_samples(self.plant, law.F_fk, columns, u_dd, x_dd)
        points = Points(*motion, np.asarray(x_dd))
        if law.variation:
            swing = law.variation * np.sin(law.omega * grid_times(dt, first, last) + law.phase)
            points.x_dd[:] -= motion.d * (law.F_fk / self.plant.m) * swing
        return points

    def state(self, t: float) -> State:
        """Return the state at time t [s]."""
        dt, last = self.march.motion.dt, self.march.last
        # t / dt may round down to the sample before.
        n = min(int(t / dt), last)
        n += (n + 1) * dt <= t and n + 1 <= last
        block = self.march.block_at(n)
        at = n - block.first
        if n * dt >= t:
            return State(float(block.x_r[at]), float(block.v_r[at]))
        first = block.first * dt
        return State(*state_in_step(block.solution, at, t - first)[:2])

    def crossing_times(self, crossings: Crossings) -> Floats:
        """Return the times of crossings of levels [s]."""
        return self.march.crossing_times(self.march.motion.dt, crossings)

    def totals(self, begin: float, end: float) -> Totals:
        """Return the integrals over a window [s]."""
        motion = self.march.motion
        first, last = int(begin / motion.dt), math.ceil(end / motion.dt)
        parts, peak = [], 0.0
        for block in self.march.blocks(first, min(last, len(motion.u_dd) - 1)):
            steps = max(first - block.first, 0), min(last - block.first, len(block.d) - 1)
            t = block.first * motion.dt
            sums, highest = measure(block.solution, steps, (begin - t, end - t))
            parts.append(sums)
            peak = max(peak, highest)
        squares = integrate_base_squares(motion, begin, end)
        x2, v2, x_dd2, power, sliding_distance, stuck, _, _, violation = total_of(parts)
        totals = Totals(x2, v2, x_dd2, power, sliding_distance, stuck, *squares)
        x_dd_peak = None if self.law.variation else peak
        return totals._replace(violation=violation, x_dd_peak=x_dd_peak)


SAMPLES_PER_CALL = 4_000_000
"""Samples per kernel call; between calls Python can handle an interrupt."""


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


# March over samples, block by block.


def march_blocks(
    plant: Plant, law: CoulombLaw, motion: Samples, start: AnyState, last: int, whole: bool
) -> tuple[CoulombMarch, Events, float]:
    """March to sample `last`; return the march, its events and the closest decision [-].

    `whole` keeps all of it in memory as one block.
    """
    entry, closest_decision = initial_event(plant, law, motion, start)
    size = max(last, 1) if whole or last <= MAX_CACHED else BLOCK_SIZE
    checkpoint = (start.x_r, start.v_r, entry.kind, math.nan)
    made = CoulombMarch(plant, law, motion, last, size, [], make_waves(motion, law))
    turning_points = []
    for number in range(made.count):
        made.checkpoints.append(checkpoint)
        checkpoint, tight = made.march_block(number)
        closest_decision = min(closest_decision, tight)
        block = made.cached[number]
        n, s, *rest = (column[number > 0 :] for column in block.log)
        t = np.add(n, float(block.first))
        t *= motion.dt
        t += s
        turning_points.append((t, *rest))
    joined = (np.concatenate(column) for column in zip(*turning_points, strict=True))
    t, kind, x_r, F_L = joined if len(turning_points) > 1 else turning_points[0]
    return made, Events(t, kind.astype(np.int8), x_r, F_L), closest_decision


CODES = np.array([python_of(encode_mode)(Mode(d, d, APART, 0, 0, REGULAR)) for d in (0, 1, -1)])
"""Encoded modes by direction of sliding, which serves as index."""


@dataclass(frozen=True, eq=False)
class SampleBlock:
    """Solution from sample `first` on: one value per sample, shape (n,), and the events.

    The last sample is the first one of the next block. Step numbers of `log` count from
    `first`, and its first row is the state there.
    """

    plant: Plant
    law: CoulombLaw
    motion: Samples
    first: int
    u_dd: Floats
    x_r: Floats
    v_r: Floats
    d: Int8Array
    log: EventLog

    @cached_property
    def solution(self) -> SampledSolution:
        """The block as kernels take it; time counts from its first sample."""
        dt, law, log = self.motion.dt, self.law, self.log
        phase = law.phase + math.tau * (law.omega * self.first * dt / math.tau % 1.0)
        law = law._replace(phase=phase)
        waves, base = make_waves(self.motion, law), as_engine_array(self.u_dd)
        scene = Scene(self.plant, to_kernel(self.plant, law.as_piecewise()), waves, base, dt)
        v_r, x_0 = np.zeros((2, len(log.n)))
        v_r[0] = self.v_r[0]
        rows = Segments(log.n, log.s, log.x_r, v_r, x_0, CODES[np.sign(log.kind)])
        return SampledSolution(scene, SampledMotion(self.x_r, self.v_r, self.d), rows)


@dataclass(frozen=True, eq=False)
class CoulombMarch(BlockwiseMarch):
    """March with Coulomb friction.

    A block is a whole number of chunks of the kernel's march, so marching it again gives the
    same result to the last bit.
    """

    waves: Waves

    def samples(self, first: int, last: int) -> SampledMotion:
        """Return the motion at samples `first` to `last` - 1."""
        block = self.block_at(first)
        if last - block.first <= len(block.d):
            part = slice(first - block.first, last - block.first)
            return SampledMotion(block.x_r[part], block.v_r[part], block.d[part])
        n = last - first
        motion = SampledMotion(np.empty(n), np.empty(n), np.empty(n, np.int8))
        for block in self.blocks(first, last):
            begin, end = max(first, block.first), min(last, block.first + len(block.d))
            here = slice(begin - first, end - first)
            there = slice(begin - block.first, end - block.first)
            motion.x_r[here], motion.v_r[here] = block.x_r[there], block.v_r[there]
            motion.d[here] = block.d[there]
        return motion

    def march_block(self, number: int) -> tuple[Checkpoint, float]:
        """March through a block; return the state at its end and the closest decision [-]."""
        first, dt = number * self.size, self.motion.dt
        last = min(first + self.size, self.last) - first
        u_dd = self.motion.u_dd[first : first + last + 1]
        out = empty_samples(last + 1)
        checkpoint: Checkpoint = self.checkpoints[number]
        state = SampledState(0, *checkpoint, 1, math.inf)
        write_first_row(out, (state.x_r, state.v_r, state.d))
        log = empty_log(4 * MAX_EVENTS_PER_STEP + last // SAMPLES_PER_EVENT)
        F_L = limit_force(self.plant, state.x_r, float(u_dd[0]))
        write_first_row(log, (0, 0.0, state.d, state.x_r, F_L))
        scene = Scene(self.plant, self.law, self.waves, as_engine_array(u_dd), dt)
        base_sums = empty_base_sums()
        while state.n < last:
            if state.events > len(log.n) - MAX_EVENTS_PER_STEP:
                log = enlarge_columns(log, 2 * len(log.n))
            end = min(state.n + SAMPLES_PER_CALL, last)
            if self.law.variation:
                n, x_r, v_r, d, _, count, closest = state
                here = SlipState(0.0, x_r, v_r, d, count, closest)
                n, here = march_varying_limits(scene, first, n, end, here, out, log)
                _, x_r, v_r, d, count, closest = here
                state = SampledState(n, x_r, v_r, d, math.nan, count, closest)
            else:
                state = march(scene, state, out, log, end, base_sums)
            check_progress(state.events, (first + state.n) * dt, (state.x_r, state.v_r), dt)
        points = np.asarray(out.x_r), np.asarray(out.v_r), np.asarray(out.d, dtype=np.int8)
        log = EventLog(*(np.asarray(column[: state.events]) for column in log))
        self.cached.clear()
        self.cached[number] = SampleBlock(
            self.plant, self.law, self.motion, first, u_dd, *points, log
        )
        return (state.x_r, state.v_r, state.d, state.a), state.closest
