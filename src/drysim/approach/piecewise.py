"""Exact solution of any piecewise-linear friction law, stored as segments.

Problem
    Elastic contacts, end stops and a vanishing normal force make the oscillator a hybrid
    automaton: in each mode the equation of motion is linear with constant coefficients and
    known forcing, and a mode ends at the first root of an observable of the motion.

Method
    `march` goes from one change of mode to the next and writes where each segment begins.
    Within a segment the motion is in closed form; other kernels evaluate and integrate it at
    any time, so that one solution serves any grid and window.

Why no event is missed
    Kernels advance by steps that provably contain no root, or bracket the root; see
    `drysim.core.roots` and `drysim.core.modes`.

Source
    Jenkins, Brit. J. Appl. Phys. 13 (1962) 30. Petrov and Ewins, J. Turbomach. 125 (2003) 364.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from drysim.approach.scene import (
    base_square_integrals,
    check_event_count,
    check_progress,
    count_grid_points,
    count_intervals,
    empty_columns,
    empty_log,
    empty_motion,
    enlarge_columns,
    exact_response,
    initial_base_acceleration,
    last_interval,
    make_waves,
    points_of_trajectory,
    run_duration,
    write_first_row,
)
from drysim.approach.solution import (
    EventDriven,
    Events,
    Floats,
    Impacts,
    Path,
    Response,
    events_from_log,
)
from drysim.core.compile import as_engine_array
from drysim.core.events import CONTACT, LIFT, RELEASE, REVERSAL, SLIP, STICK, Segments
from drysim.core.forcing import Waves
from drysim.core.march import MarchState, Scene, march_modes
from drysim.core.model import (
    MAX_STAGES,
    NO_LIMITS,
    AnyState,
    ContactState,
    CoulombLaw,
    EndStops,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
    State,
    Totals,
    has_friction,
    limit_force,
)
from drysim.core.modes import (
    APART,
    ARRIVAL,
    AT_REST,
    FREE,
    HOLD,
    KernelLaw,
    SegmentBase,
    Side,
    decode_mode,
    initial_piecewise_state,
)
from drysim.core.trajectory import (
    Columns,
    SegmentSums,
    Solution,
    WholeSteps,
    evaluate_segments,
    integrate_segments,
    integrate_whole_steps,
    peak_bumper_force,
)
from drysim.errors import SolverError, UsageError

STEPS_PER_CALL = 16_384
"""Steps per kernel call; between calls Python can handle an interrupt."""

INITIAL_STEP_CAPACITY = 1024
"""Initial rows of the buffers under sines; doubled when they are full."""

STEPS_PER_SAMPLE = 1.2
"""Initial rows per sample: one step, and events where these are few."""

MAX_SEGMENTS = 20_000_000
"""Segments besides those of the samples that one solution may have: 1 GB."""

NON_TURNING_EVENTS = (SLIP, -SLIP, LIFT, CONTACT, -CONTACT, RELEASE, -RELEASE)
"""Kinds of event at which x_r has no extremum of its own."""


def response_on_grid(trajectory: PiecewiseTrajectory, step: float) -> Response:
    """Return the response of a solution on a grid; samples have their own step."""
    motion, law, events = trajectory.motion, trajectory.law, trajectory.events
    dt = motion.dt if isinstance(motion, Samples) else step
    points = count_grid_points(trajectory.end, dt)
    part = partial(points_of_trajectory, trajectory, dt)
    approach = "stick-slip"
    if law.stops is not None and not has_friction(law):
        # As without stops, turning points are no events here; rest at a stop is one.
        kind, at_stop = np.abs(events.kind), law.stops.limits.side(events.x_r) != 0
        stays = (kind >= CONTACT) | (at_stop & (kind <= SLIP))
        events, approach = events.select(stays), "viscous"
    return exact_response(trajectory, dt, points, part, events, approach=approach)


def compute_trajectory(
    plant: Plant,
    law: PiecewiseLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> PiecewiseTrajectory:
    """Solve a scene and return its trajectory; parameters as in `exact.solve`."""
    duration = run_duration(motion, duration)
    dt, last, length = last_interval(motion, duration)
    u_dd = motion.u_dd[:] if isinstance(motion, Samples) else np.zeros(2)
    load = CoulombLaw(law.F_fk, law.F_fk, law.variation, law.omega, law.phase)
    waves, base = make_waves(motion, load), as_engine_array(u_dd)
    kernel_law = to_kernel(plant, law)
    scene = Scene(plant, kernel_law, waves, base, dt)
    origin = SegmentBase(0.0, float(u_dd[0]), float(u_dd[1] - u_dd[0]) / dt)
    x_r, v_r = start[:2]
    x_0 = float(start[2]) if len(start) > 2 else x_r
    mode, xi, v_r, x_0 = initial_piecewise_state(
        plant, kernel_law, waves, origin, x_r, v_r, x_0
    )
    F_L = limit_force(plant, x_r, initial_base_acceleration(motion))
    # Samples fill large buffers; sines often need little, such as one period of an orbit.
    least = STEPS_PER_CALL if last else INITIAL_STEP_CAPACITY
    size = int(STEPS_PER_SAMPLE * last) + least + 1
    segments, log = empty_columns(Segments, size), empty_log(size)
    write_first_row(log, (0, 0.0, LIFT if mode.contact == FREE else mode.contact, x_r, F_L))
    state = MarchState(0, 0.0, xi, v_r, math.nan, x_0, mode, 0, 1, math.inf)
    intervals = count_intervals(plant, law, motion, duration)
    while state.n <= last:
        most = max(state.used, state.events)
        full = most + min(max(most, least), STEPS_PER_CALL)
        if len(segments.n) < full:
            segments, log = enlarge_columns(segments, 2 * full), enlarge_columns(log, 2 * full)
        state = march_modes(scene, last, length, state, segments, log, full)
        t = state.n * dt + state.s
        check_progress(state.events, t, (state.xi, state.v_r))
        check_event_count(state.events, intervals, t)
        if state.used - last > MAX_SEGMENTS:
            raise SolverError(
                f"too many turning points: {state.used} by t = {t:.9g} s",
                "use a shorter duration, or check the scene: a mass on a stiff contact with "
                "little damping oscillates fast (reduce the tangential stiffness)",
            )
    segments = Segments(*(np.asarray(column[: state.used]) for column in segments))
    events = events_from_log(log, state.events, dt)
    return PiecewiseTrajectory(
        plant, law, motion, waves, (u_dd, dt), segments, events, duration,
        min(state.closest, smallest_margin(law, events, float(start[1]))),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class PiecewiseTrajectory(EventDriven):
    """Solution stored as segments.

    `events` are all changes of mode; `turning_points` are those at which v_r is zero under a
    rigid contact.
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

    @cached_property
    def path(self) -> Path:
        """The start and every turning point of x_r: each begins a segment."""
        turns = (self.segments.v_r == 0.0) | (self.segments.d == ARRIVAL)
        turns[0] = True
        t = self._starts[turns]
        return Path(t, self.at(t).x_r).until(self.end)

    def at(self, t: Floats) -> Columns:
        """Return the motion at ascending times [s]."""
        out = empty_motion(len(t))
        ends = t.min(initial=self.end), t.max(initial=0.0)
        first, last = np.searchsorted(self._starts, ends, "right")
        segments = self.solution.segments
        near = Segments(*(column[max(first - 1, 0) : last] for column in segments))
        if len(t):
            evaluate_segments(self.solution._replace(segments=near), as_engine_array(t), out)
        columns = Columns(*map(np.asarray, out))
        return columns._replace(d=columns.d.astype(np.int8))

    @property
    def series(self) -> tuple[Floats, ...]:
        """Values of each state component along the motion."""
        x_r = self.path.x_r
        if self.law.stops is not None and not self.law.is_elastic:
            return x_r, self.segments.v_r
        return x_r, self.segments.v_r, self.segments.x_0

    def state(self, t: float) -> AnyState:
        """Return the state at time t [s]; at an impact, the state after it."""
        found = self.at(np.array([t]))
        x_r, v_r = float(found.x_r[0]), float(found.v_r[0])
        if self.law.stops is not None and not self.law.is_elastic:
            return State(x_r, v_r)
        return ContactState(x_r, v_r, float(found.z[0]))

    def totals(self, begin: float, end: float) -> Totals:
        """Return the integrals over a window [s], impacts at its end included."""
        others, sums = self._integrate_whole_steps(begin, end)
        columns = (as_engine_array(column[others]) for column in self.segments)
        divided = self.solution._replace(segments=Segments(*columns))
        more = SegmentSums(*integrate_segments(divided, begin, end))
        violation = max(float(sums[-1]), more.violation)
        sums += more
        x2, v2, x_dd2, power, distance, stuck, stop_work, damper_work, _ = sums.tolist()
        stops = self.law.stops
        if stops is not None and stops.rigid:
            t, v_r = self.hits()
            struck = np.square(v_r[(t > begin) & (t <= end)]).sum()
            stop_work += float(0.5 * self.plant.m * (1.0 - stops.e**2) * struck)
        squares = base_square_integrals(self.motion, self.waves, begin, end)
        law, totals = self.law, Totals(x2, v2, x_dd2, power, distance, stuck, *squares)
        totals = totals._replace(stop_work=stop_work, violation=violation)
        if law.compression is not None:
            loss = max(law.F_fk, law.compression[0]) * distance
            totals = totals._replace(friction_loss=loss)
        return totals if law.damping is None else totals._replace(damper_work=damper_work)

    def hits(self) -> Impacts:
        """Return the contacts with a stop."""
        met = np.flatnonzero(self.segments.d == ARRIVAL)
        return Impacts(self._starts[met], self.segments.v_r[met])

    def peak_bumper_force(self, begin: float, end: float) -> float:
        """Return the largest force of a bumper in a window [N]."""
        force: float = peak_bumper_force(self.solution, begin, end)
        return force

    @cached_property
    def solution(self) -> Solution:
        """The solution as kernels take it."""
        base, dt = self.base
        segments = Segments(*map(as_engine_array, self.segments))
        law = to_kernel(self.plant, self.law)
        return Solution(Scene(self.plant, law, self.waves, as_engine_array(base), dt), segments)

    @cached_property
    def _starts(self) -> Floats:
        """Times at which the segments begin [s], computed as in the kernels."""
        return np.asarray(self.segments.n * self.base[1] + self.segments.s)

    def _integrate_whole_steps(self, begin: float, end: float) -> tuple[Any, Floats]:
        """Integrate segments in motion that are whole steps within a window [s].

        Their integrals are quadratic forms of the states at their ends. There are none under
        sines, in contact with a stop, and under a normal force that varies.

        Returns
        -------
        others : ndarray of int
            Numbers of the other segments.
        sums : ndarray, shape (9,)
            `SegmentSums` of the whole steps.
        """
        n, s, xi, v_r, x_0, codes = self.segments
        sums = np.zeros(9)
        if isinstance(self.motion, Sines) or self.law.varies:
            return np.arange(len(n)), sums
        (u_dd, dt), law, (m, k_x, _) = self.base, self.solution.scene.law, self.plant
        reference = max(law.up.F_fk, law.down.F_fk)
        # A step with two segments is divided even where the first of them takes no time: alone
        # among the others, that one would last the whole step. A whole step ends where the next
        # segment begins.
        begins = np.append(True, n[1:] != n[:-1])
        whole, v_end = (s == 0.0) & begins & np.append(begins[1:], False), np.append(v_r[1:], 0)
        whole &= (self._starts >= begin) & (end - self._starts >= dt)
        done = np.zeros(len(n), dtype=bool)
        for code in np.flatnonzero(np.bincount(codes + 1)).tolist():
            mode = decode_mode(code - 1)
            if code - 1 == ARRIVAL or mode.direction == AT_REST or mode.end_stop != APART:
                continue
            if mode.contact != (mode.direction if law.k_t == 0.0 or mode.contact else HOLD):
                continue
            at = np.flatnonzero(whole & (codes == code - 1))
            x_r = xi[at] + (0.0, law.up.limit, -law.down.limit)[mode.origin]
            k_t, share = 0.0, np.full(len(at), float(mode.contact))
            if mode.contact == HOLD:
                k_t, share = law.k_t, law.k_t / reference * (x_r - x_0[at])
                size = reference + law.k_t * (np.abs(x_r) + np.abs(x_0[at]))
                excess = reference * (np.abs(share) - 1.0) / size
                sums[8] = excess.max(initial=sums[8])
            elif reference > 0.0:
                share *= (law.up if mode.contact > 0 else law.down).F_fk / reference
            b = (law.up if mode.direction > 0 else law.down).b
            starts, d = (x_r, v_r[at], share, u_dd[n[at]]), np.full(len(at), mode.direction)
            steps = WholeSteps(*starts, v_end[at], u_dd[n[at] + 1], d)
            found, turning = integrate_whole_steps(Plant(m, k_x, b), k_t, dt, steps, reference)
            sums[:5] += found
            sums[7] += b * found[1]
            done[at] = True
            done[at[turning]] = False
        return np.flatnonzero(~done), sums


# Laws as kernels take them, and what follows from events.


def to_kernel(plant: Plant, law: PiecewiseLaw) -> KernelLaw:
    """Return a law, with the damper of the plant, as its kernels take it.

    Raises
    ------
    UsageError
        For a combination that is not modelled: an elastic contact would yield while its mass
        rests against a rigid stop.
    """
    if law.is_elastic and law.varies and law.stops is not None and law.stops.rigid:
        raise UsageError(
            "an elastic contact under a varying normal force does not go with rigid stops",
            "use bumpers",
        )
    record, step = as_engine_array(np.ones(2)), 0.0
    if law.force_record is not None:
        record, step = law.force_record.kernel_input, law.force_record.step
    stops = law.stops or EndStops(NO_LIMITS)
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


def smallest_margin(law: PiecewiseLaw, events: Events, v_r: float) -> float:
    """Return the smallest relative margin of a stop, as to whether the mass sticks [-].

    `v_r` is that at the start [m/s]; a mass at rest there is decided about, too, unless no
    force acts on it.
    """
    if law.is_elastic or not has_friction(law):
        return math.inf
    # F_L above zero pushes the mass towards v_r < 0.
    limit = law.F_fs if law.compression is None else law.compression[1]
    F_fs = np.where(events.F_L > 0.0, limit, law.F_fs) * law.load(events.t)
    F_L = np.abs(events.F_L)
    decided = np.isin(events.kind, (STICK, REVERSAL, -REVERSAL))
    decided[0] = v_r == 0.0 and F_L[0] != 0.0
    decided &= F_fs > 0.0
    if law.stops is not None and law.stops.rigid:
        decided &= law.stops.limits.side(events.x_r) == 0
    larger = np.maximum(F_fs, F_L)[decided]
    return float((np.abs(F_L - F_fs)[decided] / larger).min(initial=math.inf))
