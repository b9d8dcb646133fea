"""Exact solution of any piecewise-linear law, kept as the beginnings of its pieces.

Spring contacts, end stops and a normal force that varies: a kernel follows the motion from one
change of mode to the next and writes where each piece begins; others read and integrate it from
there, at any instant and on any grid. `elastic` and `stops` add what is theirs alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np

from drysim.approach.scene import (
    base_on_grid,
    empty,
    empty_log,
    first_u_dd,
    grid_points,
    larger,
    last_interval,
    numerics,
    put_first,
    refuse_crowd,
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
    of_log,
)
from drysim.core.compile import held
from drysim.core.events import REVERSAL, STICK, Pieces
from drysim.core.forcing import Waves, anchor, base_motion, normal_force
from drysim.core.march import bound, first_pressed, press, touch
from drysim.core.model import (
    AnyState,
    Deflected,
    Law,
    Plant,
    Pressed,
    Samples,
    Sines,
    Slider,
    Stopped,
    Totals,
)
from drysim.core.modes import Limits, first_bounds, first_contact, way_of
from drysim.core.trajectory import (
    integrate_bounded,
    integrate_contact,
    integrate_pressed,
    read_bounded,
    read_contact,
    read_pressed,
)

Kernel = Callable[..., Any]

AnyOther = Slider | Stopped | Pressed

Made = TypeVar("Made", bound="Traced")

CAPACITY = 16_384
"""Steps that a kernel may take before it hands over, so that an interrupt is heard."""

FEWEST = 1024
"""Steps that there is room for to begin with under sines; room is doubled as it fills."""

FEW_EVENTS = 1.2
"""Steps that a sample takes, its events included, where these are few."""

IN_FLIGHT = (1, -1, 3)
"""Kinds of event at which the mass goes on moving: no turns."""


def solve(
    plant: Plant,
    law: AnyOther,
    motion: Sines | Samples,
    start: AnyState,
    step: float,
    duration: float | None,
) -> Response:
    """Solve a scene and write it on its grid."""
    return on_grid(follow(plant, law, motion, start, duration), step)


def on_grid(track: Traced, step: float) -> Response:
    """Give a solution on a grid; samples have their own."""
    motion = track.motion
    dt = motion.dt if isinstance(motion, Samples) else step
    points = grid_points(track.end, dt)
    x_r, v_r, _, F_f, d = track.at(times(0, points, dt))
    grid = Held(dt, base_on_grid(motion, 0, points, dt), Points(x_r, v_r, d, F_f))
    return responding(track, grid)


def responding(track: Traced, grid: Grid) -> Response:
    """Give the response of a solution on a grid."""
    law, motion, events = track.law, track.motion, track.events
    how = partial(numerics, law, motion, len(grid), events, track.closest)
    return Response(track.plant, law, motion, grid, events, how, track)


def follow(
    plant: Plant,
    law: AnyOther,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> Traced:
    """Solve a scene from t = 0 to `duration` [s], or to the end of the samples."""
    return follow_as(Traced, plant, law, motion, start, duration)


def follow_as(
    made: type[Made],
    plant: Plant,
    law: AnyOther,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> Made:
    """Solve a scene as `follow` does, and give it as a track of some kind."""
    duration = run_length(motion, duration)
    dt, last, length = last_interval(motion, duration)
    u_dd = motion.u_dd[:] if isinstance(motion, Samples) else np.zeros(2)
    load = Law(law.F_fk, law.F_fk, law.variation, law.omega, law.phase)
    waves, base = waves_of(motion, load), held(u_dd)
    (walk, _, _), plain = kernels(law), numbers(law)
    slope = float(u_dd[1] - u_dd[0]) / dt
    state = first(plant, law, waves, float(u_dd[0]), slope, start)
    F_L = plant.m * first_u_dd(motion) + plant.k_x * start.x_r
    # Samples fill much room at once, and sines often little, as a period of many for an orbit.
    least = CAPACITY if last else FEWEST
    size = int(FEW_EVENTS * last) + least + 1
    log, count = empty_log(size), 1
    kind = way_of(state[3]) if isinstance(law, Stopped) else state[3]
    put_first(log, (0, 0.0, kind, start.x_r, F_L))
    trail, used = empty(Pieces, size), 0
    at: tuple[Any, ...] = (0, 0.0)
    while at[0] <= last:
        most = max(used, count)
        full = most + min(max(most, least), CAPACITY)
        if len(trail.n) < full:
            trail, log = larger(trail, 2 * full), larger(log, 2 * full)
        room = (trail, used, log, count, full)
        n, s, *moved, used, count = walk(
            plant, plain, waves, base, dt, *at, length, last, *state, *room
        )
        at, state = (n, s), tuple(moved)
        refuse_storm(count, n * dt + s, state)
        refuse_crowd(count, last, n * dt + s)
    trail = Pieces(*(np.asarray(column[:used]) for column in trail))
    events = of_log(log, count, dt)
    closest = tightest(law, events)
    return made(plant, law, motion, waves, (u_dd, dt), trail, events, duration, closest)


@dataclass(frozen=True, eq=False)
class Traced(Located):
    """A solution that is known from each step to the next.

    `events` holds every change of mode, `turns` those at which v_r is zero.
    """

    plant: Plant
    law: AnyOther
    motion: Sines | Samples
    waves: Waves
    base: tuple[Floats, float]
    trail: Pieces
    events: Events
    end: float
    closest: float = math.inf

    @cached_property
    def turns(self) -> Events:
        """The start and every zero of v_r: between two of them x_r is monotone."""
        return self.events.chosen(~np.isin(self.events.kind, IN_FLIGHT))

    def at(self, t: Floats) -> tuple[Floats, Floats, Floats, Floats, Codes]:
        """Give x_r, v_r, z, F_f and the direction at ascending times [s], or at none."""
        columns = tuple(held(np.empty(len(t))) for _ in range(4))
        d = held(np.empty(len(t), dtype=np.int64))
        *scene, trail = self.scene
        ends = t.min(initial=self.end), t.max(initial=0.0)
        first, last = np.searchsorted(self._begins, ends, "right")
        near = Pieces(*(column[max(first - 1, 0) : last] for column in trail))
        _, read, _ = kernels(self.law)
        read(*scene, near, held(t), *columns, d)
        x_r, v_r, z, F_f = map(np.asarray, columns)
        return x_r, v_r, z, F_f, np.asarray(d, dtype=np.int8)

    @property
    def series(self) -> tuple[Floats, ...]:
        """What each component of the state came to along the way."""
        return self.turns.x_r, self.trail.v_r, self.trail.z

    def state(self, t: float) -> AnyState:
        """Give the state at time t [s]."""
        x_r, v_r, z, _, _ = self.at(np.array([t]))
        return Deflected(float(x_r[0]), float(v_r[0]), float(z[0]))

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]."""
        _, _, integrate = kernels(self.law)
        x2, v2, x_dd2, power, rub, stuck, *hits = integrate(*self.scene, begin, end)
        squares = squares_of_base(self.motion, self.waves, begin, end)
        return Totals(x2, v2, x_dd2, power, rub, stuck, *squares, *hits)

    @property
    def scene(self) -> tuple[Any, ...]:
        """What every kernel wants first."""
        base, trail = self._held
        return self.plant, numbers(self.law), self.waves, base, self.base[1], trail

    @cached_property
    def _held(self) -> tuple[Any, Pieces]:
        """Base and trail as the engine takes them."""
        return held(self.base[0]), Pieces(*map(held, self.trail))

    @cached_property
    def _begins(self) -> Floats:
        """Where the pieces begin [s], as the kernel works it out."""
        return np.asarray(self.trail.n * self.base[1] + self.trail.s)


# What each law's kernels are, and want to begin with.


def kernels(law: AnyOther) -> tuple[Kernel, Kernel, Kernel]:
    """Give the kernels that follow a motion, and read and integrate it between its steps."""
    if isinstance(law, Stopped):
        return bound, read_bounded, integrate_bounded
    if isinstance(law, Slider):
        return touch, read_contact, integrate_contact
    return press, read_pressed, integrate_pressed


def numbers(law: AnyOther) -> Any:
    """Give a law as its kernels want it."""
    if not isinstance(law, Pressed):
        return law
    pressure = law.pressure
    if pressure is None:
        return Limits(*law[:5], held(np.ones(2)), 0.0)
    return Limits(*law[:5], pressure.given, pressure.step)


def first(
    plant: Plant,
    law: AnyOther,
    waves: Waves,
    u_0: float,
    slope: float,
    start: AnyState,
) -> tuple[Any, ...]:
    """Give x_r, v_r, the state of the contact and its mode at t = 0, for its kernel."""
    x_r, v_r = start[:2]
    if isinstance(law, Stopped):
        anchor(waves, plant, law, 0.0, 0)
        u_dd = base_motion(waves, u_0, slope, 0.0)[0]
        found: tuple[Any, ...] = first_bounds(
            plant, law, x_r, v_r, u_dd, normal_force(law, waves, 0.0)[0]
        )
        return found
    if isinstance(law, Pressed):
        return x_r, v_r, 0.0, first_pressed(plant, numbers(law), waves, u_0, slope, x_r, v_r)
    mode, x_0 = first_contact(law, x_r, v_r, start[2] if len(start) > 2 else x_r)
    return x_r, v_r, x_0, mode


def tightest(law: AnyOther, events: Events) -> float:
    """Give the smallest relative margin of a decision at a stop; infinity for none."""
    if not isinstance(law, Pressed):
        return math.inf
    F_fs, F_L = law.F_fs * law.load(events.t), np.abs(events.F_L)
    decided = np.isin(events.kind, (STICK, REVERSAL, -REVERSAL)) & (F_fs > 0.0)
    decided[0] = False
    larger = np.maximum(F_fs, F_L)[decided]
    return float((np.abs(F_L - F_fs)[decided] / larger).min(initial=math.inf))
