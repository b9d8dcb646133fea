"""Exact solution of any piecewise-linear friction law, stored as segments.

Problem
    Elastic contacts, end stops and a vanishing normal force make the oscillator a hybrid
    automaton: in each mode the equation of motion is linear with constant coefficients and
    known forcing, and a mode ends at the first root of an observable of the motion.

Method
    `march_modes` goes from one change of mode to the next and writes where each segment begins.
    Within a segment the motion is in closed form; other kernels evaluate and integrate it at
    any time, so that one solution serves any grid and window. Over samples the state at every
    sample is kept besides; long samples are marched block by block, and a block is marched
    again when it is needed (`PiecewiseMarch`).

Why no event is missed
    Kernels advance by steps that provably contain no root, or bracket the root; see
    `drysim.core.roots` and `drysim.core.modes`.

Source
    Jenkins, Brit. J. Appl. Phys. 13 (1962) 30. Petrov and Ewins, J. Turbomach. 125 (2003) 364.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.approach.base_motion import (
    base_square_integrals,
    initial_base_acceleration,
    last_interval,
    make_waves,
    run_duration,
)
from drysim.approach.buffers import (
    as_arrays,
    empty_columns,
    empty_log,
    empty_points,
    empty_samples,
    enlarge_columns,
    write_first_row,
)
from drysim.approach.grid import points_of_trajectory
from drysim.approach.progress import check_event_count, check_progress, count_intervals
from drysim.approach.solution import Events, ExactTrajectory, Impacts, Path
from drysim.core.compile import as_engine_array
from drysim.core.events import LIFT, EventLog, Segments
from drysim.core.forcing import Scene, Waves
from drysim.core.march import MODES, Course, MarchState, ModesLog, ModeSteps, march_modes
from drysim.core.measure import measure, total_of
from drysim.core.model import (
    BLOCK_SIZE,
    MAX_CACHED,
    MAX_STAGES,
    NO_LIMITS,
    AnyState,
    ContactState,
    CoulombLaw,
    EndStops,
    Floats,
    PiecewiseLaw,
    Plant,
    Points,
    Samples,
    Sines,
    State,
    Totals,
    limit_force,
)
from drysim.core.modes import (
    APART,
    ARRIVAL,
    FREE,
    KernelLaw,
    Mode,
    SegmentBase,
    Side,
    decode_mode,
    initial_piecewise_state,
    origin_of,
)
from drysim.core.oscillator import STEP_COLUMNS
from drysim.core.sampled import CHUNK, SampledMotion
from drysim.core.stroke import Crossings, crossing_times
from drysim.core.trajectory import (
    SampledSolution,
    Solution,
    evaluate_samples,
    evaluate_segments,
    fill_segments,
    integrate_segments,
    peak_bumper_force,
    state_in_step,
)
from drysim.core.variational import Deviations, propagate_deviations
from drysim.errors import SolverError, UsageError

ROWS_PER_CALL, STEPS_PER_CALL = 16_384, 1 << 18
"""Segments or events, and steps, per kernel call; between calls Python can handle an interrupt.
The steps are a multiple of those that a march may be interrupted at (`CHUNK`)."""

INITIAL_CAPACITY = 1024
"""Initial rows of the buffers under sines; doubled when they are full."""

STEPS_PER_ROW = 8
"""Samples per initial row of the buffers; rows that are not written take no memory."""

MAX_SEGMENTS = 20_000_000
"""Changes of mode that a block may have: 1 GB."""

STEPS_AT_A_TIME = BLOCK_SIZE
"""Steps that are evaluated at a time."""


def compute_trajectory(
    plant: Plant,
    law: PiecewiseLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
    whole: bool = False,
) -> PiecewiseTrajectory:
    """Solve a scene and return its trajectory; parameters as in `exact.solve`."""
    duration = run_duration(motion, duration)
    dt, last, length = last_interval(motion, duration)
    u_dd = motion.u_dd[:2] if isinstance(motion, Samples) else np.zeros(2)
    # A normal force that varies depends on time from the start.
    one_block = whole or law.varies or last < MAX_CACHED
    size, waves = last + 1 if one_block else BLOCK_SIZE, make_waves(motion, law)
    march = PiecewiseMarch(plant, law, motion, last + 1, size, [], waves, (dt, length))
    origin = SegmentBase(0.0, float(u_dd[0]), float(u_dd[1] - u_dd[0]) / dt)
    x_r, v_r = start[:2]
    x_0 = float(start[2]) if len(start) > 2 else x_r
    (mode, xi, v_r, x_0), closest = initial_piecewise_state(
        plant, march.kernel_law, waves, origin, x_r, v_r, x_0
    )
    begin = MarchState(0, 0.0, xi, v_r, math.nan, x_0, mode, 0, 1, math.inf)
    return follow(march, begin, closest, duration)


def follow(
    march: PiecewiseMarch, checkpoint: Any, closest: float, end: float
) -> PiecewiseTrajectory:
    """March to the end [s] and return the trajectory.

    `checkpoint` is the state at the start, as `march_block` needs it, and `closest` the margin
    of its mode [-].
    """
    events, turns, impacts, dt = [], [], [], march.interval[0]
    for number in range(march.count):
        march.checkpoints.append(checkpoint)
        checkpoint = march.march_block(number)
        block, closest = march.cached[number], min(closest, checkpoint.closest)
        n, s, *rest = (column[number > 0 :] for column in block.log)
        t = np.add(n, float(block.first))
        t *= dt
        t += s
        events.append((t, *rest))
        # Of a march that is in memory they follow when needed, without stops from the events.
        if march.count > 1 and not isinstance(march.law, CoulombLaw):
            turns.append(block.turning_points(dt))
            impacts.append(block.hits(dt))
    return PiecewiseTrajectory(
        plant=march.plant,
        law=march.law,
        motion=march.motion,
        events=Events(*joined(events)).until(end),
        end=end,
        closest_decision=closest,
        march=march,
        turns=Path(*joined(turns)).until(end) if turns else None,
        impacts=Impacts(*joined(impacts)) if impacts else None,
    )


def joined(parts: list[Any]) -> Any:
    """Return the columns of consecutive parts as one."""
    return parts[0] if len(parts) == 1 else map(np.concatenate, zip(*parts, strict=True))


NO_RECORD, NO_STOPS = np.ones(2), EndStops(NO_LIMITS)
"""A normal force without a record, and a mass without end stops, for kernels."""


def to_kernel(plant: Plant, law: PiecewiseLaw) -> KernelLaw:
    """Return a law, with the damper of the plant, as its kernels take it.

    Raises
    ------
    UsageError
        For a combination that is not modelled: an elastic contact would yield while its mass
        rests against a rigid stop.
    """
    if law.stops is not None and law.stops.rigid and law.is_elastic and law.varies:
        raise UsageError(
            "an elastic contact under a varying normal force does not go with rigid stops",
            "use bumpers",
        )
    record, step = as_engine_array(NO_RECORD), 0.0
    if law.force_record is not None:
        record, step = law.force_record.kernel_input, law.force_record.step
    stops = law.stops or NO_STOPS
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


@dataclass(frozen=True, eq=False)
class PiecewiseBlock:
    """Solution from a sample on, with the state at all samples and every change of mode.

    Attributes
    ----------
    first : int
        The sample from which all others count.
    u_dd : ndarray
        Base acceleration besides the sines at the samples [m/s²].
    samples : SampledMotion or None
        xi, v_r and direction of motion at the samples. None where every segment has a row, as
        under sines.
    rows : Segments
        Starts of the segments, except those that begin at a sample in the mode before.
    log : EventLog
        Its first row is the state at the first sample.
    scene : Scene
        As kernels take it.
    """

    first: int
    u_dd: Floats
    samples: SampledMotion | None
    rows: Segments
    log: EventLog
    scene: Scene

    def segments(self, first: int, last: int) -> tuple[Segments, int]:
        """Return the segments of steps `first` to `last` - 1, and their number.

        Where the block goes on, the start of the next segment follows.
        """
        if self.samples is None:
            # One step holds all of them.
            return self.rows, len(self.rows.n)
        begin, end = np.searchsorted(self.rows.n, (first, last)).tolist()
        out = empty_columns(Segments, last - first + 1 + end - begin)
        rows = Segments(*map(as_engine_array, self.rows))
        count = fill_segments(rows, self.samples, begin, (first, last), out)
        segments = Segments(*(np.asarray(column[:count]) for column in out))
        return segments, count - int(segments.n[-1] == last)

    @cached_property
    def solution(self) -> SampledSolution:
        """The block as kernels take it."""
        samples = empty_samples(2) if self.samples is None else self.samples
        return SampledSolution(self.scene, samples, self.rows)

    @cached_property
    def all_segments(self) -> Solution:
        """All of its segments, as kernels take them."""
        segments = self.segments(0, len(self.u_dd) - 1)[0]
        return Solution(self.scene, Segments(*map(as_engine_array, segments)))

    def turning_points(self, dt: float) -> Path:
        """Return the changes of mode with v_r = 0, and the start."""
        turns = (self.rows.v_r == 0.0) | (self.rows.d == ARRIVAL)
        turns[0] |= self.first == 0
        n, s, xi, v_r, _, codes = (column[turns] for column in self.rows)
        x_r, law = xi.copy(), self.scene.law
        if min(law.up.limit, law.down.limit) == math.inf:
            return Path((n + self.first) * dt + s, x_r)
        for code in np.flatnonzero(np.bincount(codes + 1)[1:]).tolist():
            if (origin := decoded(code).origin) != 0:
                x_r[codes == code] += origin_of(law, origin)
        # The velocity of an arrival has the sign of its stop.
        arrives = codes == ARRIVAL
        x_r[arrives] = np.where(np.signbit(v_r[arrives]), -law.down.limit, law.up.limit)
        return Path((n + self.first) * dt + s, x_r)

    def hits(self, dt: float) -> Impacts:
        """Return the contacts with a stop."""
        met = np.flatnonzero(self.rows.d == ARRIVAL)
        n, s, _, v_r, *_ = (column[met] for column in self.rows)
        return Impacts((n + self.first) * dt + s, v_r)


@dataclass(frozen=True, eq=False)
class PiecewiseMarch:
    """March over samples, block by block, or under sines, by the automaton of all modes.

    There is a checkpoint for every block, and the latest block is in memory; a march that is
    kept in memory is one block. Its subclasses march in a faster way.

    Attributes
    ----------
    plant, law, motion
        The scene.
    last : int
        Last sample.
    size : int
        Samples per block.
    checkpoints : list
        State at the first sample of every block, as `march_block` needs it.
    waves : Waves
        Sines of base and normal force.
    interval : (float, float)
        Length of the intervals of ü, and that of the last one [s].
    cached : dict
        Blocks in memory.
    """

    plant: Plant
    law: CoulombLaw | PiecewiseLaw
    motion: Sines | Samples
    last: int
    size: int
    checkpoints: list[Any]
    waves: Waves
    interval: tuple[float, float]
    cached: dict[int, PiecewiseBlock] = field(default_factory=dict)

    @cached_property
    def kernel_law(self) -> KernelLaw:
        """The law as kernels take it."""
        return to_kernel(self.plant, self.law.as_piecewise())

    @property
    def count(self) -> int:
        """Number of blocks."""
        return max(1, -(-self.last // self.size))

    def block(self, number: int) -> PiecewiseBlock:
        """Return a block by its number; it is marched again if it is not in memory."""
        if number not in self.cached:
            self.march_block(number)
        return self.cached[number]

    def block_at(self, n: int) -> PiecewiseBlock:
        """Return the block of sample n; at a boundary, the block that begins there."""
        return self.block(min(n // self.size, len(self.checkpoints) - 1))

    def blocks(self, first: int, last: int) -> Iterator[PiecewiseBlock]:
        """Return the blocks that contain the steps from sample `first` to sample `last`."""
        numbers = range(first // self.size, min(-(-last // self.size), len(self.checkpoints)))
        return map(self.block, numbers)

    def points(self, dt: float, first: int, last: int) -> Points | None:
        """Return points `first` to `last` - 1 of a grid with step dt [s]; samples have it.

        None where they are not known better than at any other times.
        """
        if isinstance(self.motion, Sines) or self.law.varies:
            return None
        parts: list[Any] = []
        while not parts or first < last:
            block = self.block_at(first)
            end = min(last, block.first + len(block.u_dd))
            points = empty_points(end - first)
            evaluate_samples(block.solution, (first - block.first, end - block.first), points)
            parts.append(as_arrays(points))
            first = end
        points = Points(*joined(parts))
        return points if self.law.stops is not None else points._replace(F_stop=None)

    def monodromy(self) -> Floats:
        """Return the derivative of the state at the end by that at the start, in one block."""
        block, deviations = self.block(0), Deviations(*map(as_engine_array, np.eye(3)))
        propagate_deviations(block.all_segments, deviations)
        n = 3 if self.law.is_elastic else 2
        return np.array(deviations)[:n, :n]

    def march_block(self, number: int) -> Any:
        """March through a block and keep it in memory; return the state at its end."""
        (dt, length), first = self.interval, number * self.size
        steps, u_dd = min(self.size, self.last - first), np.zeros(2)
        if isinstance(self.motion, Samples):
            u_dd = self.motion.u_dd[first : first + steps + 1]
        base = as_engine_array(u_dd)
        scene = Scene(self.plant, self.kernel_law, self.waves, base, dt)
        state: MarchState = self.checkpoints[number]
        samples = empty_samples(steps + 1)
        x_r = origin_of(self.kernel_law, state.mode.origin) + state.xi
        write_first_row(samples, (state.xi, state.v_r, state.mode.direction))
        size = INITIAL_CAPACITY + 1 + steps // STEPS_PER_ROW
        segments, log = empty_columns(Segments, size), empty_log(size)
        kind = LIFT if state.mode.contact == FREE else state.mode.contact
        u_first = initial_base_acceleration(self.motion) if first == 0 else float(u_dd[0])
        F_L = limit_force(self.plant, x_r, u_first)
        write_first_row(log, (0, 0.0, kind, x_r, F_L))
        sampled = isinstance(self.motion, Samples)
        work = mode_steps_table(first, 1 if self.waves.size else MODES)
        last = self.last - 1 - first
        duration = (self.last - 1) * dt + length
        intervals = count_intervals(self.plant, self.law, self.motion, duration)
        state = state._replace(n=0, s=0.0, used=0, events=1, closest=math.inf)
        while state.n < steps:
            most = max(state.used, state.events)
            full = most + min(max(most, INITIAL_CAPACITY), ROWS_PER_CALL)
            if len(segments.n) < full:
                segments = enlarge_columns(segments, 2 * full)
                log = enlarge_columns(log, 2 * full)
            until = min((state.n // STEPS_PER_CALL + 1) * STEPS_PER_CALL, steps)
            course = Course(last, length, until, until == steps, full)
            state = march_modes(scene, course, state, work, ModesLog(segments, log, samples))
            t = (first + state.n) * dt + state.s
            check_progress(state.events, t, (state.xi, state.v_r))
            check_event_count(state.events, intervals, t)
            if state.used > MAX_SEGMENTS:
                raise SolverError(
                    f"too many turning points: {state.used} by t = {t:.9g} s",
                    "use a shorter duration, or check the scene: a mass on a stiff contact "
                    "with little damping oscillates fast (reduce the tangential stiffness)",
                )
        rows = Segments(*(np.asarray(column[: state.used]) for column in segments))
        log = EventLog(*(np.asarray(column[: state.events]) for column in log))
        log = log._replace(kind=log.kind.astype(np.int8))
        kept = samples if sampled else None
        self.cached.clear()
        self.cached[number] = PiecewiseBlock(first, u_dd, kept, rows, log, scene)
        return state


def mode_steps_table(first: int, modes: int = MODES) -> ModeSteps:
    """Return empty work space of `march_modes` for samples that count from `first`."""
    rows = as_engine_array(np.zeros((modes, STEP_COLUMNS)))
    x_sums, v_sums = (as_engine_array(np.empty((modes, CHUNK))) for _ in range(2))
    begin, until = (as_engine_array(np.full(modes, -1)) for _ in range(2))
    return ModeSteps(first, rows, x_sums, v_sums, begin, until)


class Part(NamedTuple):
    """Some steps of a solution.

    Attributes
    ----------
    t : float
        Time from which those of the part count [s].
    last : int
        Its last step, of all.
    scene : Scene
    segments : Segments
    size : int
        Number of its segments; one more may follow, the start of the next step.
    """

    t: float
    last: int
    scene: Scene
    segments: Segments
    size: int

    def select(self, which: Any) -> Solution:
        """Return some segments as kernels take them."""
        columns = (as_engine_array(column[which]) for column in self.segments)
        return Solution(self.scene, Segments(*columns))

    def near(self, begin: float, end: float) -> Solution:
        """Return the segments that contain a window [s]."""
        n, s = self.segments.n[: self.size], self.segments.s[: self.size]
        starts = n * self.scene.dt + s
        first, last = np.searchsorted(starts, (begin, end), "right").tolist()
        return self.select(slice(max(first - 1, 0), last))


def points_in_part(part: Part, t: Floats) -> Points:
    """Return the motion at ascending times [s] in a part of it."""
    t, points = t - part.t, empty_points(len(t))
    near = part.near(float(t[0]), float(t[-1]))
    evaluate_segments(near, as_engine_array(t), points)
    return as_arrays(points)


@dataclass(frozen=True, eq=False, kw_only=True)
class PiecewiseTrajectory(ExactTrajectory):
    """Solution in closed form, over the blocks of a march.

    `turns` and `impacts` are the turning points of x_r and the contacts with a stop of a march
    that is not in memory as a whole.
    """

    law: CoulombLaw | PiecewiseLaw
    motion: Sines | Samples
    march: PiecewiseMarch
    turns: Path | None = None
    impacts: Impacts | None = None

    @property
    def without_stops(self) -> PiecewiseTrajectory:
        """The same motion in the scene without end stops, where it reaches none."""
        return replace(self, law=self.law.without_stops)

    @property
    def reaches_stops(self) -> bool:
        """Whether x_r reaches an end stop, at an extreme point of the path or at its end."""
        if self.law.stops is None:
            return False
        # At the end x_r may count from a stop, which the path then has.
        x_r = np.append(self.path.x_r, self.march.block(0).rows.x_r[-1])
        return bool(self.law.stops.limits.side(x_r).any())

    @cached_property
    def path(self) -> Path:
        """The start and every turning point of x_r."""
        if self.turns is not None:
            return self.turns
        if isinstance(self.law, CoulombLaw):
            return super().path
        return self.march.block(0).turning_points(self.dt).until(self.end)

    @property
    def dt(self) -> float:
        """Length of the intervals of ü [s]."""
        return self.march.interval[0]

    def step_at(self, t: float) -> int:
        """Return the step in which a time lies [s]."""
        n = int(t / self.dt)
        n += int((n + 1) * self.dt <= t) - int(n * self.dt > t)
        return min(max(n, 0), self.march.last - 1)

    def steps_at(self, t: Floats) -> NDArray[np.int64]:
        """Return the steps in which times lie [s]."""
        n = (t / self.dt).astype(np.int64)
        n += (n + 1) * self.dt <= t
        n -= n * self.dt > t
        steps: NDArray[np.int64] = np.clip(n, 0, self.march.last - 1)
        return steps

    def parts(self, begin: float, end: float) -> Iterator[Part]:
        """Yield the parts of the solution that contain a window [s]."""
        first, last = self.step_at(begin), self.step_at(end)
        for block in self.march.blocks(first, last + 1):
            lo = max(first - block.first, 0)
            hi = min(last + 1 - block.first, len(block.u_dd) - 1)
            scene = block.scene
            for start in range(lo, hi, STEPS_AT_A_TIME):
                stop = min(start + STEPS_AT_A_TIME, hi)
                rows, count = block.segments(start, stop)
                yield Part(block.first * self.dt, block.first + stop - 1, scene, rows, count)

    def at(self, t: Floats) -> Points:
        """Return the motion at ascending times [s]."""
        if not len(t):
            return as_arrays(empty_points(0))
        if isinstance(self.motion, Sines):
            return points_in_part(self.whole, t)
        points, steps, done = [], self.steps_at(t), 0
        for part in self.parts(float(t[0]), float(t[-1])):
            upto = int(np.searchsorted(steps, part.last, "right"))
            if upto > done:
                points.append(points_in_part(part, t[done:upto]))
            done = upto
        return Points(*joined(points))

    def points(self, dt: float, first: int, last: int) -> Points:
        """Return points `first` to `last` - 1 of a grid with step dt [s]; samples have it."""
        points = self.march.points(dt, first, last)
        return points_of_trajectory(self, dt, first, last) if points is None else points

    @cached_property
    def whole(self) -> Part:
        """A motion under sines as one part."""
        block = self.march.block(0)
        return Part(0.0, 0, block.scene, block.rows, len(block.rows.n))

    @property
    def solution(self) -> Solution:
        """The first block as kernels take it, which is all of a motion under sines."""
        return self.march.block(0).all_segments

    @property
    def series(self) -> tuple[Floats, ...]:
        """Values of each state component along the motion under sines."""
        x_r, rows = self.path.x_r, self.march.block(0).rows
        return (x_r, rows.v_r, rows.x_0) if self.law.is_elastic else (x_r, rows.v_r)

    def state(self, t: float) -> AnyState:
        """Return the state at time t [s]; at an impact, the state after it."""
        if t not in self.states:
            x_r, v_r, z = self._at_once(t)
            elastic = self.law.is_elastic
            self.states[t] = ContactState(x_r, v_r, z) if elastic else State(x_r, v_r)
        return self.states[t]

    def _at_once(self, t: float) -> tuple[float, float, float]:
        """Return x_r [m], v_r [m/s] and z [m] at one time [s]."""
        n, sample = self.step_at(t), round(t / self.dt)
        block = self.march.block_at(n)
        smooth = self.law.stops is None and not self.law.is_elastic
        if smooth and block.samples is not None and sample * self.dt == t:
            index = sample - block.first
            return float(block.samples.x_r[index]), float(block.samples.v_r[index]), 0.0
        t -= block.first * self.dt
        x_r, v_r, F_f = map(float, state_in_step(block.solution, n - block.first, t))
        k_t = self.march.kernel_law.k_t
        return x_r, v_r, x_r - F_f / k_t if k_t > 0.0 else 0.0

    @cached_property
    def states(self) -> dict[float, AnyState]:
        """States that are known: metrics ask many times for those at both ends of a window."""
        return {}

    def totals(self, begin: float, end: float) -> Totals:
        """Return the integrals over a window [s], impacts at its end included."""
        parts, peaks = [], [0.0]
        first, last = self.step_at(begin), self.step_at(end)
        for block in self.march.blocks(first, last + 1):
            t = block.first * self.dt
            window, count = (begin - t, end - t), len(block.u_dd) - 1
            if block.samples is None:
                segments = Segments(*map(as_engine_array, block.rows))
                sums, peak = integrate_segments(Solution(block.scene, segments), *window, 0.0)
            else:
                steps = max(first - block.first, 0), min(last + 1 - block.first, count)
                sums, peak = measure(block.solution, steps, window)
            parts.append(sums)
            peaks.append(peak)
        x2, v2, x_dd2, power, distance, stuck, stop_work, damper_work, violation = total_of(
            parts
        )
        has_peak = isinstance(self.motion, Samples) and not self.law.varies
        stops = self.law.stops
        if stops is not None and stops.rigid:
            hits = self.hits()
            struck = np.square(hits.v_r[(hits.t > begin) & (hits.t <= end)]).sum()
            stop_work += float(0.5 * self.plant.m * (1.0 - stops.e**2) * struck)
        squares = base_square_integrals(self.motion, self.march.waves, begin, end)
        law, totals = self.law, Totals(x2, v2, x_dd2, power, distance, stuck, *squares)
        totals = totals._replace(
            stop_work=stop_work, violation=violation, x_dd_peak=max(peaks) if has_peak else None
        )
        if law.compression is not None:
            loss = max(law.F_fk, law.compression[0]) * distance
            totals = totals._replace(friction_loss=loss)
        return totals if law.damping is None else totals._replace(damper_work=damper_work)

    def monodromy(self) -> Floats:
        """Return the derivative of the final state by the first one, shape (n, n).

        The state is x_r [m], v_r [m/s] and, with an elastic contact, the x_r at which that
        carries no force [m].
        """
        return self.march.monodromy()

    def crossing_times(self, crossings: Crossings) -> Floats:
        """Return the times of crossings of levels [s], block by block."""
        low, high, dt = crossings.low, crossings.high, self.dt
        times = np.full(len(low), np.nan)
        if not len(low):
            return times
        steps = int(low[0] / dt), min(int(high[-1] / dt) + 1, self.march.last)
        for block in self.march.blocks(*steps):
            begin, count = block.first * dt, len(block.u_dd) - 1
            # Those of earlier blocks are known by now, the last one perhaps not.
            first = int(np.searchsorted(high, begin))
            part = slice(first, int(np.searchsorted(low, begin + count * dt, "right")))
            here = Crossings(*(column[part] for column in crossings))
            here = here._replace(low=here.low - begin, high=here.high - begin)
            since_begin = as_engine_array(np.empty(len(here.low)))
            crossing_times(block.solution, Crossings(*map(as_engine_array, here)), since_begin)
            unknown = np.isnan(times[part])
            times[part][unknown] = begin + np.asarray(since_begin)[unknown]
        return np.where(np.isnan(times), high, times)

    def hits(self) -> Impacts:
        """Return the contacts with a stop."""
        if self.impacts is not None:
            return self.impacts
        return super().hits() if self.law.stops is None else self.march.block(0).hits(self.dt)

    def peak_bumper_force(self, begin: float, end: float) -> float:
        """Return the largest force of a bumper in a window [N]."""
        forces = [0.0]
        for part in self.parts(begin, end):
            n, codes = (column[: part.size] for column in (part.segments.n, part.segments.d))
            touches = np.zeros(int(n[-1]) + 1, dtype=bool)
            for kind in np.flatnonzero(np.bincount(codes + 1)).tolist():
                if kind - 1 != ARRIVAL and decoded(kind - 1).end_stop != APART:
                    touches[n[codes == kind - 1]] = True
            solution = part.select(np.flatnonzero(touches[n]))
            forces.append(peak_bumper_force(solution, begin - part.t, end - part.t))
        return max(forces)


@cache
def decoded(code: int) -> Mode:
    """Return an encoded mode."""
    mode: Mode = decode_mode(code)
    return mode
