"""Exact solution of elastic friction contacts: Jenkins and Petrov-Ewins elements.

Problem
    A spring k_t in series with a slider. While the contact holds, f = k_t (x_r - x_0); it
    yields at |f| = mu F_N(t), and x_0 then moves with the mass. F_N(t) may vary as a sine and
    may vanish. In each mode the equation of motion is linear with constant coefficients.

Method
    Under sines, or with a varying normal force, the motion is marched from mode to mode (see
    `piecewise`). Turning points while the contact holds are no change of mode; kernels find
    them when a path is requested. Over samples with a constant friction limit, x_r and v_r are
    stored at every sample and the modes at every change; integrals over steps without a change
    are quadratic forms of the values at the samples.

Why no event is missed
    A change of mode is the first root of a linear observable of the motion, found by
    `drysim.core.roots`.

Source
    Jenkins, Brit. J. Appl. Phys. 13 (1962) 30. Petrov and Ewins, J. Turbomach. 125 (2003) 364.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from drysim.approach import piecewise
from drysim.approach.scene import (
    CONSTANT_FRICTION,
    SAMPLES_PER_CALL,
    check_progress,
    count_grid_points,
    describe_numerics,
    empty_columns,
    empty_log,
    empty_motion,
    enlarge_columns,
    last_sample_indices,
    make_waves,
    run_duration,
    write_first_row,
)
from drysim.approach.solution import (
    EventDriven,
    Events,
    Floats,
    Int8Array,
    Path,
    Points,
    Response,
    StoredGrid,
    events_from_log,
)
from drysim.core.compile import as_engine_array
from drysim.core.events import MAX_EVENTS_PER_STEP, Segments
from drysim.core.model import (
    AnyState,
    ContactState,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
    StrokeLimits,
    Totals,
    integrate_base_squares,
)
from drysim.core.modes import HOLD, initial_piecewise_mode
from drysim.core.oscillator import oscillator_steps
from drysim.core.sampled import contact_code, march_elastic_samples
from drysim.core.trajectory import (
    Solution,
    evaluate_segments,
    integrate_segments,
    step_quadratic_forms,
    step_variables,
    whole_step_forms,
    write_sampled_turning_points,
)


def solve(
    plant: Plant,
    law: PiecewiseLaw,
    motion: Sines | Samples,
    start: AnyState,
    step: float,
    duration: float | None,
) -> Response:
    """Solve a scene and return its response on a grid; parameters as in `exact.solve`."""
    trajectory = compute_trajectory(plant, law, motion, start, duration)
    if isinstance(trajectory, SampledElasticTrajectory):
        return response_on_samples(trajectory)
    return piecewise.response_on_grid(trajectory, step)


def compute_trajectory(
    plant: Plant,
    law: PiecewiseLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> piecewise.PiecewiseTrajectory | SampledElasticTrajectory:
    """Solve a scene and return its trajectory; parameters as in `exact.solve`."""
    if isinstance(motion, Samples) and has_constant_limit(law):
        return sampled_elastic_trajectory(plant, law, motion, start, duration)
    return piecewise.compute_trajectory(plant, law, motion, start, duration)


def has_constant_limit(law: PiecewiseLaw) -> bool:
    """Return whether nothing but the contact depends on time or direction."""
    return not law.variation and law.force_record is None and law.damping is None


# Samples and a constant limit: known at every sample and at every change of mode.


STEPS_PER_CHUNK = 8_192
"""Steps integrated at a time. Linear algebra libraries start threads for dot products of more
than 10,000 numbers, which takes longer than the sums themselves."""

EVENTS_PER_SAMPLE = 0.1
"""Initial rows of the event log per sample."""


@dataclass(frozen=True, eq=False)
class SampledElasticTrajectory(EventDriven):
    """Solution over samples; `segments` are the beginnings of the contact's modes.

    `x_r` and `v_r` are values at the samples; `d` is the direction in which the contact yields
    there, 0 where it holds.
    """

    plant: Plant
    law: PiecewiseLaw
    motion: Samples
    u_dd: Floats
    x_r: Floats
    v_r: Floats
    d: Int8Array
    segments: Segments
    events: Events
    end: float
    closest_decision: float = math.inf

    def path(self, window: tuple[float, float], limits: StrokeLimits | None) -> Path:
        """Return the extreme points of x_r from the start to the end of a window [s]."""
        plant, dt, segments = self.plant, self.motion.dt, self.segments
        sprung = oscillator_steps(Plant(plant.m, plant.k_x + self.law.k_t, plant.b), dt)
        held_trail, states = (
            Segments(*map(as_engine_array, segments)),
            (as_engine_array(self.x_r), as_engine_array(self.v_r)),
        )
        scene = (
            plant,
            piecewise.to_kernel(self.plant, self.law),
            sprung,
            self.base,
            *states,
            held_trail,
        )
        whole = piecewise.requested_segments(segments.n * dt + segments.s, window)
        path = piecewise.collect_path(
            write_sampled_turning_points, scene, whole, limits, (0, -1, 0.0, 0.0, 0.0)
        )
        # The march ends at a sample, which may lie beyond the end of the run.
        count = int(np.searchsorted(path.t, self.end, "right"))
        return Path(path.t[:count], path.x_r[:count])

    @cached_property
    def base(self) -> Any:
        """Base acceleration [m/s²] as an array of the engine."""
        return as_engine_array(self.u_dd)

    @cached_property
    def x_0(self) -> Floats:
        """Position [m] of zero contact force at each sample, for a contact that holds."""
        first = np.append(self.segments.n + (self.segments.s > 0.0), len(self.x_r))
        return np.repeat(self.segments.z, np.diff(np.minimum(first, len(self.x_r))))

    def state(self, t: float) -> ContactState:
        """Return the state at time t [s]."""
        dt, last = self.motion.dt, len(self.x_r) - 1
        # t / dt may round down to the sample before.
        n = min(int(t / dt), last)
        n += (n + 1) * dt <= t and n + 1 <= last
        if n * dt >= t or n == last:
            x_r, d = float(self.x_r[n]), int(self.d[n])
            x_0 = float(self.x_0[n])
            z = x_r - d * self.law.F_fk / self.law.k_t if d else x_0
            return ContactState(x_r, float(self.v_r[n]), z)
        out = empty_motion(1)
        evaluate_segments(
            self._solution(self.step_segments(np.array([n]))),
            as_engine_array(np.array([t])),
            out,
        )
        return ContactState(float(out.x_r[0]), float(out.v_r[0]), float(out.z[0]))

    def step_segments(self, steps: Any) -> Segments:
        """Return the beginnings of all segments of some steps, in order of time."""
        # A step begins one segment, and each change of mode within it another.
        inside = np.isin(self.segments.n, steps) & (self.segments.s > 0.0)
        mode = contact_code(HOLD) + self.d[steps].astype(np.int64)
        starts = (
            steps, np.zeros(len(steps)), self.x_r[steps], self.v_r[steps],
            self.x_0[steps], mode,
        )  # fmt: skip
        both = [
            np.concatenate((a, b[inside])) for a, b in zip(starts, self.segments, strict=True)
        ]
        order = np.lexsort((both[1], both[0]))
        return Segments(*(column[order] for column in both))

    def _solution(self, step_segments: Segments) -> Solution:
        """Return some segments as kernels take them."""
        waves = make_waves(self.motion, CONSTANT_FRICTION)
        segments = Segments(*map(as_engine_array, step_segments))
        law = piecewise.to_kernel(self.plant, self.law)
        return Solution(self.plant, law, waves, self.base, self.motion.dt, segments)

    def totals(self, begin: float, end: float) -> Totals:
        """Return the integrals over a window [s]."""
        dt = self.motion.dt
        lo, hi = int(begin / dt), min(math.ceil(end / dt), len(self.x_r) - 1)
        whole = np.ones(hi - lo, dtype=bool)
        n = self.segments.n
        whole[n[(n >= lo) & (n < hi)] - lo] = False
        whole[0] &= begin <= lo * dt
        whole[-1] &= end >= hi * dt
        sums = self._event_steps(np.flatnonzero(~whole) + lo, begin, end)
        m, k_x, b = self.plant
        forms = [
            step_quadratic_forms(b / m, (k_x + k_t) / m, dt) for k_t in (0.0, self.law.k_t)
        ]
        for at in range(lo, hi, STEPS_PER_CHUNK):
            n = np.flatnonzero(whole[at - lo : at - lo + STEPS_PER_CHUNK]) + at
            sums += self._eventless_steps(n[self.d[n] != 0], forms[0])
            sums += self._eventless_steps(n[self.d[n] == 0], forms[1])
        u_dd2, u2 = integrate_base_squares(self.motion, begin, end)
        x2, v2, x_dd2, power, sliding_distance = sums.tolist()
        return Totals(x2, v2, x_dd2, power, sliding_distance, 0.0, u_dd2, u2)

    def _event_steps(self, steps: Any, begin: float, end: float) -> Floats:
        """Integrate steps with a change of mode or an end of the window."""
        step_segments = self.step_segments(steps)
        last = np.append(np.diff(step_segments.n) > 0, True)
        lengths = np.where(last, self.motion.dt, np.roll(step_segments.s, -1)) - step_segments.s
        solution = self._solution(step_segments)
        forms = as_engine_array(whole_step_forms(self.plant, solution.law, self.motion.dt))
        found = integrate_segments(solution, forms, as_engine_array(lengths), begin, end)
        return np.array(found[:5])

    def _eventless_steps(self, n: Any, forms: tuple[Floats, Floats]) -> Floats:
        """Integrate whole steps in which the contact holds, or yields, throughout."""
        (m, k_x, b), F_fk, k_t = self.plant, self.law.F_fk, self.law.k_t
        squares, displacement = forms
        x_r, x_0, d = self.x_r[n], self.x_0[n], self.d[n]
        holds = not d.any()
        w, f = ((k_x + k_t) / m, -k_t / m * x_0) if holds else (k_x / m, d * (F_fk / m))
        rows = step_variables(b / m, w, f, x_r, self.v_r[n], self.u_dd[n], self.u_dd[n + 1])
        sums = np.zeros(5)
        sums[:4] = np.einsum("kij,ij->k", squares, rows @ rows.T)
        sums[:3] = np.maximum(sums[:3], 0.0)  # squares, whatever rounding says
        slid = displacement @ rows
        sums[4] = k_t / F_fk * ((x_r - x_0 + 0.5 * slid) @ slid) if holds else d @ slid
        return sums


def sampled_elastic_trajectory(
    plant: Plant,
    law: PiecewiseLaw,
    motion: Samples,
    start: AnyState,
    duration: float | None,
) -> SampledElasticTrajectory:
    """Solve a scene with a constant friction limit over samples."""
    end = run_duration(motion, duration)
    _, last = last_sample_indices(motion, end)
    u_dd = motion.u_dd[: last + 1]
    x_r, v_r = as_engine_array(np.empty((2, last + 1)))
    d = as_engine_array(np.empty(last + 1, dtype=np.int8))
    x_0 = start[2] if len(start) > 2 else start.x_r
    kernel_law = piecewise.to_kernel(plant, law)
    slope = float(u_dd[1] - u_dd[0]) / motion.dt
    waves = make_waves(motion, CONSTANT_FRICTION)
    _, x_0, first = initial_piecewise_mode(
        plant, kernel_law, waves, float(u_dd[0]), slope, start.x_r, start.v_r, x_0
    )
    mode = first.contact
    x_r[0], v_r[0], d[0] = start.x_r, start.v_r, mode
    capacity = int(EVENTS_PER_SAMPLE * last) + 4 * MAX_EVENTS_PER_STEP
    segments, log = empty_columns(Segments, capacity), empty_log(capacity)
    write_first_row(segments, (0, 0.0, start.x_r, start.v_r, x_0, contact_code(mode)))
    F_L = plant.m * float(u_dd[0]) + plant.k_x * start.x_r
    write_first_row(log, (0, 0.0, mode, start.x_r, F_L))
    kernel_input, n, used, count = as_engine_array(u_dd), 0, 1, 1
    state: tuple[Any, ...] = (start.x_r, start.v_r, x_0, mode)
    while n < last:
        if max(used, count) > len(segments.n) - MAX_EVENTS_PER_STEP:
            segments, log = (
                enlarge_columns(kept, 2 * len(kept[0])) for kept in (segments, log)
            )
        until, written = (
            min(n + SAMPLES_PER_CALL, last),
            (x_r, v_r, d, segments, used, log, count),
        )
        rest: tuple[Any, ...] = (n, until, *state, *written)
        n, *moved, used, count = march_elastic_samples(
            plant, law, kernel_input, motion.dt, *rest
        )
        state = tuple(moved)
        check_progress(count, n * motion.dt, state)
    segments = Segments(*(np.asarray(column[:used]) for column in segments))
    events = events_from_log(log, count, motion.dt).until(end)
    series = np.asarray(x_r), np.asarray(v_r), np.asarray(d, dtype=np.int8)
    return SampledElasticTrajectory(plant, law, motion, u_dd, *series, segments, events, end)


def response_on_samples(trajectory: SampledElasticTrajectory) -> Response:
    """Return the response of a solution over samples on their own grid."""
    plant, law, motion = trajectory.plant, trajectory.law, trajectory.motion
    n = count_grid_points(trajectory.end, motion.dt)
    x_r, v_r, d = trajectory.x_r[:n], trajectory.v_r[:n], trajectory.d[:n]
    F_f = law.k_t * (x_r - trajectory.x_0[:n])
    np.multiply(d, law.F_fk, out=F_f, where=d != 0)
    slip_direction = np.where(v_r < 0.0, np.int8(-1), np.int8(1))
    compute_numerics = partial(describe_numerics, law, motion, n, trajectory.events, math.inf)
    grid = StoredGrid(motion.dt, trajectory.u_dd[:n], Points(x_r, v_r, slip_direction, F_f))
    return Response(plant, law, motion, grid, trajectory.events, compute_numerics, trajectory)
