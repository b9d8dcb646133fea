"""Motions under laws with a rate or a state of their own, by series: on any grid."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from drysim.approach.events import Codes, Events, Floats
from drysim.approach.legs import Course
from drysim.approach.marks import first_mark
from drysim.approach.points import Grid, Held, Points
from drysim.approach.response import Response
from drysim.approach.scene import first_u_dd, grid_points, numerics, waves_of
from drysim.approach.spans import (
    base_on_grid,
    faint_speed,
    last_interval,
    run_length,
    squares_of_base,
    times,
)
from drysim.approach.track import Located
from drysim.core.motion import Samples, Sines
from drysim.core.plant import LEUVEN, Dynamic, Plant
from drysim.core.signal import BLOCK, KEPT
from drysim.core.state import AnyState, Deflected, Totals

LADDER = 1e3
"""How much coarser the second solution is from whose distance the error is stated."""

COARSEST = 1e-3
"""Greatest tolerance that a series makes sense with [-]."""


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
