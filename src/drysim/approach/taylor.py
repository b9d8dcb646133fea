"""Exact solution of laws with a rate or a state of their own, by Taylor series.

A motion is followed leg by leg. Each can be followed again from the mark at its beginning, so a
long motion holds no more than some legs; within a leg it is read and integrated between its
steps. The error is stated from the distance of a coarser solution.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from drysim.approach.scene import (
    base_on_grid,
    empty_log,
    empty_trail,
    faint_speed,
    first_u_dd,
    grid_points,
    last_interval,
    numerics,
    refuse_storm,
    run_length,
    squares_of_base,
    times,
    waves_of,
)
from drysim.approach.solution import (
    Codes,
    Events,
    Floats,
    Grid,
    Held,
    Located,
    Points,
    Response,
)
from drysim.core.compile import held
from drysim.core.dynamic_friction import COUNT, WAY, forget, head
from drysim.core.events import Log, Trail
from drysim.core.forcing import Waves
from drysim.core.model import (
    BLOCK,
    KEPT,
    LEUVEN,
    AnyState,
    Deflected,
    Dynamic,
    Plant,
    Samples,
    Sines,
    Totals,
)
from drysim.core.taylor import ORDER, Jet, first_heading, integrate_series, read, trace

LADDER = 1e3
"""How much coarser the second solution is from whose distance the error is stated."""

COARSEST = 1e-3
"""Greatest tolerance that a series makes sense with [-]."""


def solve(
    plant: Plant,
    law: Dynamic,
    motion: Sines | Samples,
    start: AnyState,
    step: float,
    duration: float | None,
) -> Response:
    """Solve a scene and write it on its grid; the error is stated from a coarser solution."""
    track = follow(plant, law, motion, start, duration)
    dt = motion.dt if isinstance(motion, Samples) else step
    points = grid_points(track.end, dt)
    grid: Grid = Read(track, dt, points)
    if points <= KEPT:
        grid = Held(dt, grid.base(0, points), grid.part(0, points))
    error = distance(grid, follow(plant, coarser(law), motion, start, duration))
    how = partial(numerics, law, motion, points, track.turns, math.inf, error)
    return Response(plant, law, motion, grid, track.turns, how, track)


def coarser(law: Dynamic) -> Dynamic:
    """Give the law with the tolerance, and the memory, of the second solution."""
    tolerance = min(LADDER * law.tolerance, COARSEST)
    return law._replace(tolerance=tolerance, depth=law.depth // 2)


def distance(grid: Grid, other: Series) -> float:
    """Give how far another solution is from a grid at most, relative to its peak [-]."""
    off, peak = 0.0, 0.0
    for first in range(0, len(grid), BLOCK):
        last = min(first + BLOCK, len(grid))
        x_r = grid.part(first, last).x_r
        coarse = other.at(times(first, last, grid.dt))[0]
        off = max(off, float(np.abs(coarse - x_r).max()))
        peak = max(peak, float(np.abs(x_r).max()))
    return off / (peak or 1.0)


def follow(
    plant: Plant,
    law: Dynamic,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> Series:
    """Solve a scene from t = 0 to `duration` [s], or to the end of the samples."""
    duration = run_length(motion, duration)
    dt, last, length = last_interval(motion, duration)
    waves = waves_of(motion)
    base = motion.u_dd[:2] if isinstance(motion, Samples) else np.zeros(2)
    speed = faint_speed(plant, motion, start)
    mark = first_mark(plant, law, waves, base, dt, start, speed)
    course = Course(plant, law, motion, waves, dt, last, length, [mark])
    log = course.follow()
    F_L = plant.m * first_u_dd(motion) + plant.k_x * start.x_r
    columns = log.n * dt + log.s, log.kind.astype(np.int8), log.x_r, log.F_L
    # Bristles never stick: a mass at rest on them counts as going where it will go first.
    waits = mark.state[3] == 0 and not law.sticks
    first = log.kind[0] if waits and len(log.kind) else mark.state[3]
    opening = 0.0, np.sign(first), start.x_r, F_L
    every = (
        np.append(np.array([a], b.dtype), b) for a, b in zip(opening, columns, strict=True)
    )
    return Series(course, Events(*every), duration)


@dataclass(frozen=True, eq=False)
class Series(Located):
    """A solution by series: known between its steps, too; no more than some legs are held.

    `turns` holds every change of mode and every zero of v_r.
    """

    course: Course
    turns: Events
    end: float
    closest: float = math.inf

    @property
    def plant(self) -> Plant:
        """The oscillator."""
        return self.course.plant

    @property
    def law(self) -> Dynamic:
        """Its friction."""
        return self.course.law

    @property
    def series(self) -> tuple[Floats, ...]:
        """What each component of the state came to along the way, leg by leg."""
        return tuple(np.array(column) for column in zip(*self.course.scales, strict=True))

    def at(self, t: Floats) -> tuple[Floats, Floats, Floats, Floats, Codes]:
        """Give x_r, v_r, z, F_f and the direction at ascending times [s]."""
        course, done = self.course, 0
        rows, d = np.empty((4, len(t))), np.empty(len(t), dtype=np.int8)
        while done < len(t):
            number = course.number_at(float(t[done]))
            last = number == len(course.marks) - 2
            ends = math.inf if last else course.starts[number + 1]
            part = slice(done, max(int(np.searchsorted(t, ends)), done + 1))
            rows[:, part], d[part] = course.read(number, t[part])
            done = part.stop
        return rows[0], rows[1], rows[2], rows[3], d

    def state(self, t: float) -> Deflected:
        """Give the state at time t [s], with the memory of bristles that have one."""
        x_r, v_r, z, _, _ = self.at(np.array([t]))
        turned = self.course.recalled(t) if self.law.kind == LEUVEN else ()
        return Deflected(float(x_r[0]), float(v_r[0]), float(z[0]), turned)

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]."""
        course, sums = self.course, np.zeros(6)
        for number in range(course.number_at(begin), course.number_at(end) + 1):
            sums += course.integrate(number, begin, min(end, course.starts[number + 1]))
        u_dd2, u2 = squares_of_base(course.motion, course.waves, begin, end)
        x2, v2, x_dd2, power, rub, stuck = sums.tolist()
        return Totals(x2, v2, x_dd2, power, rub, stuck, u_dd2, u2)


@dataclass(frozen=True, eq=False)
class Read:
    """The points of a solution by series, read where they are asked for."""

    track: Series
    dt: float
    length: int

    def __len__(self) -> int:
        """Give their number."""
        return self.length

    def base(self, first: int, last: int) -> Floats:
        """Give ü [m/s²] from point number `first` to the one before `last`."""
        return base_on_grid(self.track.course.motion, first, last, self.dt)

    def part(self, first: int, last: int) -> Points:
        """Give the points from number `first` to the one before `last`."""
        x_r, v_r, _, F_f, d = self.track.at(times(first, last, self.dt))
        return Points(x_r, v_r, d, F_f)


# A motion leg by leg: each can be followed again from its first state.


FIRST_LEG, LEG = 1_024, 16_384
"""Steps in the first leg and in a later one: a short motion takes little room, and at the end
of each a kernel hands over, so that an interrupt is heard."""

MOST_KEPT = 64
"""Legs that are kept, some 80 MB; of a longer motion a leg is followed anew when it is asked
for, which costs a microsecond a step."""


class Leg(NamedTuple):
    """One leg: the samples from its first on, its steps, and where each begins [s].

    Times under samples count from the first of the leg, `first` s after the start.
    """

    first: float
    u_dd: Any
    trail: Trail
    begins: Floats


@dataclass(frozen=True, eq=False)
class Course:
    """A motion over intervals of ü to the end of the last, as marks and the latest legs.

    `dt` is the length of an interval [s] and `length` that of the last; `starts` is where the
    legs begin and the last ends [s], `scales` the greatest |x_r|, |v_r| and |z| of each leg
    [m, m/s, m], `memories` what was asked for of what bristles recalled, by time.
    """

    plant: Plant
    law: Dynamic
    motion: Sines | Samples
    waves: Waves
    dt: float
    last: int
    length: float
    marks: list[Mark]
    starts: list[float] = field(default_factory=lambda: [0.0])
    scales: list[tuple[float, ...]] = field(default_factory=list)
    kept: dict[int, Leg] = field(default_factory=dict)
    memories: dict[float, tuple[float, ...]] = field(default_factory=dict)

    def follow(self) -> Log:
        """Follow the motion to its end; gives the events, counted from the start."""
        logs: list[Log] = []
        while self.marks[-1].n <= self.last:
            mark, log = self.go(len(self.marks) - 1)
            self.marks.append(mark)
            self.starts.append(mark.n * self.dt + mark.s)
            logs.append(log)
        return Log(*(np.concatenate(column) for column in zip(*logs, strict=True)))

    def go(self, number: int) -> tuple[Mark, Log]:
        """Follow a leg and keep it; gives the mark at its end and its events."""
        first = self.marks[number].n
        mark, log, trail, base = self.traced(number, self.last, self.length)
        arrays = [np.asarray(column) for column in trail]
        self.keep(number, Leg(first * self.dt, base, trail, arrays[0] * self.dt + arrays[1]))
        if number == len(self.scales):
            self.scales.append(tuple(float(np.abs(column).max()) for column in arrays[2:5]))
        return mark, log

    def traced(self, number: int, last: int, length: float) -> tuple[Mark, Log, Trail, Any]:
        """Follow a leg, at most for `length` [s] of interval `last`; gives what comes of it.

        That is the mark at the end, the events, the steps, and ü besides the waves [m/s²].
        """
        mark, size = self.marks[number], LEG if number else FIRST_LEG
        base = self.base(mark.n, size)
        jet = work(self.law, mark.scale)
        jet.turned[: len(mark.turned)] = mark.turned
        jet.branch[:] = mark.branch
        trail, log = empty_trail(size), empty_log(size)
        n, s, x_r, v_r, z, d, steps, count = trace(
            self.plant, self.law, self.waves, base, self.dt, 0, mark.s, length,
            last - mark.n, *mark.state, jet, trail, 0, log, 0, size,
        )  # fmt: skip
        refuse_storm(count, (mark.n + n) * self.dt + s, (x_r, v_r))
        found = Log(*(np.asarray(column[:count]) for column in log))
        found = found._replace(n=found.n + mark.n)
        trail = Trail(*(column[:steps] for column in trail))
        return marked(mark.n + n, s, (x_r, v_r, z, d), jet), found, trail, base

    def recalled(self, t: float) -> tuple[float, ...]:
        """Give the turns that the bristles remember at time t [s], as deflections [m].

        Within a leg they are found by following it once more as far as that.
        """
        if t >= self.starts[-1]:
            return self.marks[-1].turned
        if t not in self.memories:
            number, n = self.number_at(t), min(int(t / self.dt), self.last)
            mark, within = self.marks[number], t - n * self.dt
            if t > self.starts[number]:
                end = (n, within) if within > 0.0 else (n - 1, self.dt)
                mark = self.traced(number, *end)[0]
            self.memories[t] = mark.turned
        return self.memories[t]

    def base(self, n: int, size: int) -> Any:
        """Give ü besides the waves [m/s²], from sample n on as far as a leg may come."""
        if isinstance(self.motion, Sines):
            return held(np.zeros(2))
        return held(self.motion.u_dd[n : min(n + size, self.last) + 2])

    def keep(self, number: int, leg: Leg) -> None:
        """Keep a leg, in place of another where there are too many."""
        if len(self.kept) >= MOST_KEPT:
            del self.kept[next(iter(self.kept))]
        self.kept[number] = leg

    def number_at(self, t: float) -> int:
        """Give the number of the leg that holds time t [s], at best the one that it begins."""
        return min(max(bisect_right(self.starts, t) - 1, 0), len(self.marks) - 2)

    def leg(self, number: int) -> Leg:
        """Give a leg."""
        if number not in self.kept:
            self.go(number)
        return self.kept[number]

    def read(self, number: int, t: Floats) -> tuple[tuple[Any, ...], Any]:
        """Give x_r, v_r, z and F_f, and the direction, at ascending times of a leg [s]."""
        leg = self.leg(number)
        within = t - leg.first
        first, last = np.searchsorted(leg.begins, (within[0], within[-1]), "right")
        steps = slice(max(int(first) - 1, 0), max(int(last), 1))
        trail = Trail(*(column[steps] for column in leg.trail))
        columns = tuple(held(np.empty(len(t))) for _ in range(4))
        d = held(np.empty(len(t), dtype=np.int64))
        kernel: Any = read
        kernel(*self.scene(leg), trail, held(within), *columns, d)
        return columns, d

    def integrate(self, number: int, begin: float, end: float) -> tuple[float, ...]:
        """Give the integrals over a window of a leg [s]."""
        leg = self.leg(number)
        kernel: Any = integrate_series
        sums: tuple[float, ...] = kernel(
            *self.scene(leg), leg.trail, begin - leg.first, end - leg.first
        )
        return sums

    def scene(self, leg: Leg) -> tuple[Any, ...]:
        """Give what kernels want first to read a leg."""
        return self.plant, self.law, self.waves, leg.u_dd, self.dt, work(self.law, 0.0)


# Where a leg begins: the state, and what the law recalls.


class Mark(NamedTuple):
    """Where a leg begins: sample and time within it, the state, and what the law recalls.

    `state` is x_r [m], v_r [m/s], z [m] and the direction; `scale` the greatest speed so far
    [m/s]; `turned` and `branch` as in `Jet`.
    """

    n: int
    s: float
    state: tuple[float, float, float, int]
    scale: float
    turned: tuple[float, ...]
    branch: tuple[int, ...]


def work(law: Dynamic, scale: float) -> Jet:
    """Give what the kernels work in; a speed [m/s] to measure the motion by."""
    short = {"scale": 1, "slope": 2, "turned": law.depth if law.kind == LEUVEN else 0}
    values = {name: held(np.zeros(short.get(name, ORDER + 2))) for name in Jet._fields}
    jet = Jet(**values | {"branch": held(np.zeros(3, dtype=np.int64))})
    jet.scale[0] = scale
    return jet


def marked(n: int, s: float, state: tuple[Any, ...], jet: Jet) -> Mark:
    """Give the mark of a state and of what the law recalls there."""
    turned = tuple(float(z) for z in jet.turned[: jet.branch[COUNT]])
    branch = tuple(int(value) for value in jet.branch)
    return Mark(n, s, state, float(jet.scale[0]), turned, branch)


def first_mark(
    plant: Plant, law: Dynamic, waves: Waves, base: Floats, dt: float, start: AnyState,
    speed: float,
) -> Mark:  # fmt: skip
    """Give the mark at t = 0, from the first two values of ü besides the waves."""
    x_r, v_r = start[:2]
    z = start[2] if len(start) > 2 else 0.0
    jet, slope = work(law, speed), float(base[1] - base[0]) / dt
    d = first_heading(plant, law, waves, jet, float(base[0]), slope, 0.0, x_r, v_r, z)
    if law.kind == LEUVEN:
        recall(jet, start[3] if len(start) > 3 else (), z)
        if d != 0:
            head(law, jet, int(np.sign(d)), v_r, z)
    return marked(0, 0.0, (x_r, v_r, z, d), jet)


def recall(jet: Jet, turned: tuple[float, ...], z: float) -> None:
    """Set the turns of a state at deflection z [m], and the branch that they lead to.

    The direction of the branch follows from the turns alone: the first one ended the virgin
    curve, which leads away from zero, and each one reverses the direction. The deflection does
    not tell it: it may be that of the last turn to rounding.
    """
    for level in turned:
        if jet.branch[COUNT] == len(jet.turned):
            forget(jet)
        jet.turned[jet.branch[COUNT]] = level
        jet.branch[COUNT] += 1
    outwards = int(np.sign(turned[0] if turned else z))
    jet.branch[WAY] = -outwards if jet.branch[COUNT] % 2 else outwards
