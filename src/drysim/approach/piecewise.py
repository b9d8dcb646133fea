"""Exact solution of any piecewise-linear friction law, stored as segments.

Problem
    Elastic contacts, end stops and a vanishing normal force make the oscillator a hybrid
    automaton: in each mode the equation of motion is linear with constant coefficients and
    known forcing, and a mode ends at the first root of an observable of the motion.

Method
    A kernel per law (`march_elastic`, `march_stops`, `march_normal_force`) marches from one
    change of mode to the next and writes where each segment begins. Within a segment the motion
    is in closed form; other kernels evaluate and integrate it at any time, so that one solution
    serves any grid and window. `elastic` and `end_stops` extend this module.

Why no event is missed
    Kernels advance by steps that provably contain no root, or bracket the root; see
    `drysim.core.roots` and `drysim.core.modes`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np

from drysim.approach.scene import (
    base_acceleration_on_grid,
    base_square_integrals,
    check_event_count,
    check_progress,
    count_grid_points,
    describe_numerics,
    empty_columns,
    empty_log,
    enlarge_columns,
    grid_times,
    initial_base_acceleration,
    last_interval,
    make_waves,
    run_duration,
    write_first_row,
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
    events_from_log,
)
from drysim.core.compile import as_engine_array
from drysim.core.events import REVERSAL, STICK, Segments
from drysim.core.forcing import Waves, base_motion, relative_normal_force, set_phases
from drysim.core.march import (
    initial_normal_force_mode,
    march_elastic,
    march_normal_force,
    march_stops,
)
from drysim.core.model import (
    AnyState,
    ContactState,
    CoulombLaw,
    ElasticContactLaw,
    EndStopLaw,
    NormalForceLaw,
    Plant,
    Samples,
    Sines,
    Totals,
)
from drysim.core.modes import (
    NormalForceArrays,
    decode_direction,
    initial_contact_mode,
    initial_stop_mode,
)
from drysim.core.trajectory import (
    evaluate_elastic,
    evaluate_normal_force,
    evaluate_stops,
    integrate_elastic,
    integrate_normal_force,
    integrate_stops,
)

Kernel = Callable[..., Any]

PiecewiseLaw = ElasticContactLaw | EndStopLaw | NormalForceLaw

TrajectoryT = TypeVar("TrajectoryT", bound="PiecewiseTrajectory")

STEPS_PER_CALL = 16_384
"""Steps per kernel call; between calls Python can handle an interrupt."""

INITIAL_STEP_CAPACITY = 1024
"""Initial rows of the buffers under sines; doubled when they are full."""

STEPS_PER_SAMPLE = 1.2
"""Initial rows per sample: one step, and events where these are few."""

NON_TURNING_EVENTS = (1, -1, 3)
"""Kinds of event at which the velocity is not zero: x_r has no extremum there."""


def solve(
    plant: Plant,
    law: PiecewiseLaw,
    motion: Sines | Samples,
    start: AnyState,
    step: float,
    duration: float | None,
) -> Response:
    """Solve a scene and return its response on a grid; parameters as in `exact.solve`."""
    return response_on_grid(compute_trajectory(plant, law, motion, start, duration), step)


def response_on_grid(trajectory: PiecewiseTrajectory, step: float) -> Response:
    """Return the response of a solution on a grid; samples have their own step."""
    motion = trajectory.motion
    dt = motion.dt if isinstance(motion, Samples) else step
    points = count_grid_points(trajectory.end, dt)
    x_r, v_r, _, F_f, d = trajectory.at(grid_times(0, points, dt))
    grid = StoredGrid(
        dt, base_acceleration_on_grid(motion, 0, points, dt), Points(x_r, v_r, d, F_f)
    )
    return make_response(trajectory, grid)


def make_response(trajectory: PiecewiseTrajectory, grid: Grid) -> Response:
    """Return the response of a solution on a grid."""
    law, motion, events = trajectory.law, trajectory.motion, trajectory.events
    compute_numerics = partial(
        describe_numerics, law, motion, len(grid), events, trajectory.closest_decision
    )
    return Response(trajectory.plant, law, motion, grid, events, compute_numerics, trajectory)


def compute_trajectory(
    plant: Plant,
    law: PiecewiseLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> PiecewiseTrajectory:
    """Solve a scene and return its trajectory; parameters as in `exact.solve`."""
    return compute_trajectory_as(PiecewiseTrajectory, plant, law, motion, start, duration)


def compute_trajectory_as(
    made: type[TrajectoryT],
    plant: Plant,
    law: PiecewiseLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> TrajectoryT:
    """Solve a scene as `compute_trajectory` does; `made` is the class of the trajectory."""
    duration = run_duration(motion, duration)
    dt, last, length = last_interval(motion, duration)
    u_dd = motion.u_dd[:] if isinstance(motion, Samples) else np.zeros(2)
    load = CoulombLaw(law.F_fk, law.F_fk, law.variation, law.omega, law.phase)
    waves, base = make_waves(motion, load), as_engine_array(u_dd)
    (march_kernel, _, _), law_numbers = kernels(law), kernel_law(law)
    slope = float(u_dd[1] - u_dd[0]) / dt
    state = initial_state(plant, law, waves, float(u_dd[0]), slope, start)
    F_L = plant.m * initial_base_acceleration(motion) + plant.k_x * start.x_r
    # Samples fill large buffers; sines often need little, such as one period of an orbit.
    least = STEPS_PER_CALL if last else INITIAL_STEP_CAPACITY
    size = int(STEPS_PER_SAMPLE * last) + least + 1
    log, count = empty_log(size), 1
    kind = decode_direction(state[3]) if isinstance(law, EndStopLaw) else state[3]
    write_first_row(log, (0, 0.0, kind, start.x_r, F_L))
    segments, used = empty_columns(Segments, size), 0
    at: tuple[Any, ...] = (0, 0.0)
    while at[0] <= last:
        most = max(used, count)
        full = most + min(max(most, least), STEPS_PER_CALL)
        if len(segments.n) < full:
            segments, log = enlarge_columns(segments, 2 * full), enlarge_columns(log, 2 * full)
        buffers = (segments, used, log, count, full)
        n, s, *moved, used, count = march_kernel(
            plant, law_numbers, waves, base, dt, *at, length, last, *state, *buffers
        )
        at, state = (n, s), tuple(moved)
        check_progress(count, n * dt + s, state)
        check_event_count(count, last, n * dt + s)
    segments = Segments(*(np.asarray(column[:used]) for column in segments))
    events = events_from_log(log, count, dt)
    closest_decision = smallest_margin(law, events)
    return made(
        plant, law, motion, waves, (u_dd, dt), segments, events, duration, closest_decision
    )


@dataclass(frozen=True, eq=False)
class PiecewiseTrajectory(EventDriven):
    """Solution stored as segments.

    `events` are all changes of mode; `turning_points` are those with zero velocity.
    """

    plant: Plant
    law: PiecewiseLaw
    motion: Sines | Samples
    waves: Waves
    base: tuple[Floats, float]
    segments: Segments
    events: Events
    end: float
    closest_decision: float = math.inf

    @cached_property
    def turning_points(self) -> Events:
        """The start and every zero of v_r: x_r is monotone between neighbours."""
        return self.events.select(~np.isin(self.events.kind, NON_TURNING_EVENTS))

    def at(self, t: Floats) -> tuple[Floats, Floats, Floats, Floats, Int8Array]:
        """Return x_r, v_r, z, F_f and the direction at ascending times [s], shape (n,) each."""
        columns = tuple(as_engine_array(np.empty(len(t))) for _ in range(4))
        d = as_engine_array(np.empty(len(t), dtype=np.int64))
        *scene, segments = self.scene
        ends = t.min(initial=self.end), t.max(initial=0.0)
        first, last = np.searchsorted(self._segment_starts, ends, "right")
        near = Segments(*(column[max(first - 1, 0) : last] for column in segments))
        _, read, _ = kernels(self.law)
        read(*scene, near, as_engine_array(t), *columns, d)
        x_r, v_r, z, F_f = map(np.asarray, columns)
        return x_r, v_r, z, F_f, np.asarray(d, dtype=np.int8)

    @property
    def series(self) -> tuple[Floats, ...]:
        """Values of each state component along the motion."""
        return self.turning_points.x_r, self.segments.v_r, self.segments.z

    def state(self, t: float) -> AnyState:
        """Return the state at time t [s]."""
        x_r, v_r, z, _, _ = self.at(np.array([t]))
        return ContactState(float(x_r[0]), float(v_r[0]), float(z[0]))

    def totals(self, begin: float, end: float) -> Totals:
        """Return the integrals over a window [s]."""
        _, _, integrate = kernels(self.law)
        x2, v2, x_dd2, power, sliding_distance, stuck, *stop_work = integrate(
            *self.scene, begin, end
        )
        squares = base_square_integrals(self.motion, self.waves, begin, end)
        return Totals(x2, v2, x_dd2, power, sliding_distance, stuck, *squares, *stop_work)

    @property
    def scene(self) -> tuple[Any, ...]:
        """Leading arguments of every kernel."""
        base, segments = self._kernel_arrays
        return self.plant, kernel_law(self.law), self.waves, base, self.base[1], segments

    @cached_property
    def _kernel_arrays(self) -> tuple[Any, Segments]:
        """Base acceleration and segments as arrays of the engine."""
        return as_engine_array(self.base[0]), Segments(*map(as_engine_array, self.segments))

    @cached_property
    def _segment_starts(self) -> Floats:
        """Times at which the segments begin [s], computed as in the kernels."""
        return np.asarray(self.segments.n * self.base[1] + self.segments.s)


# Kernels of each law and their arguments.


def kernels(law: PiecewiseLaw) -> tuple[Kernel, Kernel, Kernel]:
    """Return the kernels that march, evaluate and integrate the motion under a law."""
    if isinstance(law, EndStopLaw):
        return march_stops, evaluate_stops, integrate_stops
    if isinstance(law, ElasticContactLaw):
        return march_elastic, evaluate_elastic, integrate_elastic
    return march_normal_force, evaluate_normal_force, integrate_normal_force


def kernel_law(law: PiecewiseLaw) -> Any:
    """Return a law as its kernels take it."""
    if not isinstance(law, NormalForceLaw):
        return law
    force_record = law.force_record
    if force_record is None:
        return NormalForceArrays(*law[:5], as_engine_array(np.ones(2)), 0.0)
    return NormalForceArrays(*law[:5], force_record.kernel_input, force_record.step)


def initial_state(
    plant: Plant,
    law: PiecewiseLaw,
    waves: Waves,
    u_0: float,
    slope: float,
    start: AnyState,
) -> tuple[Any, ...]:
    """Return x_r, v_r, the state of the contact and its mode at t = 0."""
    x_r, v_r = start[:2]
    if isinstance(law, EndStopLaw):
        set_phases(waves, plant, law, 0.0, 0)
        u_dd = base_motion(waves, u_0, slope, 0.0)[0]
        found: tuple[Any, ...] = initial_stop_mode(
            plant, law, x_r, v_r, u_dd, relative_normal_force(law, waves, 0.0)[0]
        )
        return found
    if isinstance(law, NormalForceLaw):
        return (
            x_r,
            v_r,
            0.0,
            initial_normal_force_mode(plant, kernel_law(law), waves, u_0, slope, x_r, v_r),
        )
    mode, x_0 = initial_contact_mode(law, x_r, v_r, start[2] if len(start) > 2 else x_r)
    return x_r, v_r, x_0, mode


def smallest_margin(law: PiecewiseLaw, events: Events) -> float:
    """Return the smallest relative margin of a decision between stick and slip [-]."""
    if not isinstance(law, NormalForceLaw):
        return math.inf
    F_fs, F_L = law.F_fs * law.load(events.t), np.abs(events.F_L)
    decided = np.isin(events.kind, (STICK, REVERSAL, -REVERSAL)) & (F_fs > 0.0)
    decided[0] = False
    larger = np.maximum(F_fs, F_L)[decided]
    return float((np.abs(F_L - F_fs)[decided] / larger).min(initial=math.inf))
