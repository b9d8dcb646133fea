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
    state at the beginning of each block is kept: a block is marched again, to
    the same last bit, when its points are needed.

Why no event is missed
    Events are first roots of functions in closed form, bracketed between their extrema or
    approached by steps with a bounded remainder; see `drysim.core.roots` and
    `drysim.core.sampled`.

Source
    Eqs. (4), (7) and (9) of the paper. Den Hartog, Phil. Mag. (7) 9, no. 59 suppl. (May
    1930) 801.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

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
    empty_columns,
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
    follow,
    joined,
    to_kernel,
)
from drysim.approach.progress import check_event_count, check_progress, count_intervals
from drysim.approach.solution import Events
from drysim.core.compile import as_engine_array, python_of
from drysim.core.events import MAX_EVENTS_PER_STEP, EventLog, Segments, initial_direction
from drysim.core.forcing import SCENE_COLUMNS, WAVE_COLUMNS, Scene, Waves
from drysim.core.march import (
    Interval,
    march_sines,
    march_sines_from_start,
    march_varying_limits,
    write_slip_segments,
)
from drysim.core.model import (
    BLOCK_SIZE,
    MAX_CACHED,
    AnyState,
    CoulombLaw,
    Floats,
    PiecewiseLaw,
    Plant,
    Points,
    Samples,
    Sines,
    limit_force,
)
from drysim.core.modes import APART, REGULAR, Mode, encode_mode
from drysim.core.orbit import SineMarch
from drysim.core.sampled import (
    SampledMotion,
    SlipState,
    accelerations_at_samples,
    empty_base_sums,
    march,
)
from drysim.core.trajectory import (
    sample_coulomb_grid,
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
) -> PiecewiseTrajectory:
    """Solve a scene and return its trajectory; parameters as in `exact.solve`.

    Under sines no grid is involved.
    """
    if isinstance(motion, Sines):
        return sine_trajectory(plant, law, motion, start, duration)
    end, dt = run_duration(motion, duration), motion.dt
    last = last_sample_indices(motion, end)[1]
    size = max(last, 1) if whole or last <= MAX_CACHED else BLOCK_SIZE
    waves = make_waves(motion, law)
    march = CoulombMarch(plant, law, motion, last, size, [], waves, (dt, dt))
    u_dd = initial_base_acceleration(motion)
    d, _, margin = initial_direction(plant, law, start.x_r, start.v_r, u_dd)
    # The margin is infinite where no force acts.
    state = SlipState(0, 0.0, start.x_r, start.v_r, d, math.nan, 1, math.inf)
    return follow(march, state, margin, end)


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
) -> PiecewiseTrajectory:
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
    count = state.events
    check_progress(count, state.s, (state.x_r, state.v_r))
    periods = count_intervals(plant, law, motion, duration)
    while state.s < duration:
        check_event_count(count, periods, state.s)
        size = min(2 * len(kind), count + EVENTS_PER_CALL)
        log, kind = (
            as_engine_array(np.hstack((log, np.empty((4, size - len(kind)))))),
            enlarge_column(kind, size),
        )
        interval, waves = Interval(0, 0.0, duration, 0.0, 0.0), make_waves(motion, contact)
        columns = EventLog(log[0], log[1], kind, log[2], log[3])
        state = march_sines(plant, contact, waves, interval, state, columns)
        count = state.events
        check_progress(count, state.s, (state.x_r, state.v_r))
    # Rows by index: unpacking the array row by row takes as long as some tens of events.
    log, kind = np.asarray(log), np.asarray(kind[:count], dtype=np.int8)
    events = Events(log[1, :count], kind, log[2, :count], log[3, :count])
    size = (len(scene) - SCENE_COLUMNS) // WAVE_COLUMNS
    waves, steps = Waves(scene[SCENE_COLUMNS:], size, len(motion.A)), (duration, duration)
    march = SlipMarch(plant, law, motion, 1, 1, [(v_0, events, state)], waves, steps)
    return PiecewiseTrajectory(
        plant=plant,
        law=law,
        motion=motion,
        events=events,
        end=duration,
        closest_decision=state.closest,
        march=march,
    )


@dataclass(frozen=True, eq=False)
class SlipMarch(PiecewiseMarch):
    """March with Coulomb friction under sines, whose events are known.

    Its checkpoint holds the velocity at the start [m/s], the events, and the `SlipState` at the
    end.
    """

    def march_block(self, number: int) -> SlipState:
        """Write the motion as segments and keep it in memory; return the state at its end."""
        end: SlipState
        v_0, events, end = self.checkpoints[number]
        count, u_dd = len(events), np.zeros(2)
        n = np.zeros(count, np.int64)
        log = EventLog(n, events.t, events.kind, events.x_r, events.F_L)
        segments = empty_columns(Segments, count + 1)
        write_slip_segments(EventLog(*map(as_engine_array, log)), v_0, end, segments)
        rows = Segments(*map(np.asarray, segments))
        scene = Scene(self.plant, self.kernel_law, self.waves, as_engine_array(u_dd), end.s)
        self.cached[number] = PiecewiseBlock(0, u_dd, None, rows, log, scene)
        return end

    def points(self, dt: float, first: int, last: int) -> Points:
        """Return points `first` to `last` - 1 of a grid with step dt [s]."""
        v_0, events, _ = self.checkpoints[0]
        contact, waves = self.law.without_stops, self.waves
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
        log = EventLog(*map(as_engine_array, self.block(0).log))
        scene = SineMarch(self.plant, self.law.without_stops, self.waves, log)
        # The first event is the state at the start.
        d, count, end = log.kind[0], len(log.kind), self.interval[1]
        return np.array(event_monodromy(scene, end, 1.0, d, 1, count)).reshape(2, 2)


# Samples: known at every sample and at every event between samples.


SAMPLES_PER_EVENT = 16
"""Samples per initial row of the event log; rows that are not written take no memory."""

SAMPLES_PER_CALL = 4_000_000
"""Samples per kernel call; between calls Python can handle an interrupt."""


CODES = np.array([python_of(encode_mode)(Mode(d, d, APART, 0, 0, REGULAR)) for d in (0, 1, -1)])
"""Encoded modes by direction of sliding, which serves as index."""


@dataclass(frozen=True, eq=False)
class CoulombMarch(PiecewiseMarch):
    """March with Coulomb friction over samples.

    A checkpoint is the `SlipState`. A block is a whole number of chunks of the kernel's
    march, so marching it again gives the same result to the last bit.
    """

    law: CoulombLaw
    motion: Samples

    def points(self, dt: float, first: int, last: int) -> Points:
        """Return the points at samples `first` to `last` - 1, dt [s] apart."""
        law, motion, n = self.law, self.samples(first, last), last - first
        x_dd, u_dd = as_engine_array(np.empty(n)), as_engine_array(self.motion.u_dd[first:last])
        columns = SampledMotion(*map(as_engine_array, motion))
        accelerations_at_samples(self.plant, law.F_fk, columns, u_dd, x_dd)
        points = Points(*motion, np.asarray(x_dd))
        if law.variation:
            swing = law.variation * np.sin(law.omega * grid_times(dt, first, last) + law.phase)
            points.x_dd[:] -= motion.d * (law.F_fk / self.plant.m) * swing
        return points

    def samples(self, first: int, last: int) -> SampledMotion:
        """Return the motion at samples `first` to `last` - 1."""
        parts: list[Any] = []
        while not parts or first < last:
            block = self.block_at(first)
            end = min(last, block.first + len(block.u_dd))
            part = slice(first - block.first, end - block.first)
            parts.append(tuple(column[part] for column in block.solution.samples))
            first = end
        return SampledMotion(*joined(parts))

    def march_block(self, number: int) -> SlipState:
        """March through a block and keep it in memory; return the state at its end."""
        first, dt = number * self.size, self.motion.dt
        last = min(first + self.size, self.last) - first
        u_dd = self.motion.u_dd[first : first + last + 1]
        out = empty_samples(last + 1)
        state: SlipState = self.checkpoints[number]._replace(n=0, events=1, closest=math.inf)
        write_first_row(out, (state.x_r, state.v_r, state.d))
        log, v_0 = empty_log(4 * MAX_EVENTS_PER_STEP + last // SAMPLES_PER_EVENT), state.v_r
        F_L = limit_force(self.plant, state.x_r, float(u_dd[0]))
        write_first_row(log, (0, 0.0, state.d, state.x_r, F_L))
        base = as_engine_array(u_dd)
        scene, base_sums = Scene(self.plant, self.law, self.waves, base, dt), empty_base_sums()
        while state.n < last:
            if state.events > len(log.n) - MAX_EVENTS_PER_STEP:
                log = enlarge_columns(log, 2 * len(log.n))
            end = min(state.n + SAMPLES_PER_CALL, last)
            if self.law.variation:
                state = march_varying_limits(scene, first, end, state, out, log)
            else:
                state = march(scene, state, out, log, end, base_sums)
            check_progress(state.events, (first + state.n) * dt, (state.x_r, state.v_r), dt)
        samples = SampledMotion(*map(np.asarray, out))
        samples = samples._replace(d=samples.d.astype(np.int8, copy=False))
        log = EventLog(*(np.asarray(column[: state.events]) for column in log))
        log = log._replace(kind=log.kind.astype(np.int8, copy=False))
        speeds, anchors = np.zeros((2, len(log.n)))
        speeds[0] = v_0
        modes = CODES[np.sign(log.kind)]
        rows = Segments(log.n, log.s, log.x_r, speeds, anchors, modes)
        self.cached.clear()
        self.cached[number] = PiecewiseBlock(
            first, u_dd, samples, rows, log, self.scene_from(first, base)
        )
        return state

    def scene_from(self, first: int, base: Any) -> Scene:
        """Return the scene as kernels take it, with time counting from sample `first`."""
        law, dt = self.law, self.motion.dt
        phase = law.phase + math.tau * (law.omega * first * dt / math.tau % 1.0)
        law = law._replace(phase=phase)
        waves = make_waves(self.motion, law)
        return Scene(self.plant, to_kernel(self.plant, law.as_piecewise()), waves, base, dt)
