"""The motion under a dynamic law, by Taylor series to a stated error."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from drysim.approach.events import Codes, Events, Floats
from drysim.approach.numerics import Numerics
from drysim.approach.points import Held, Points
from drysim.approach.response import Orbit, Response
from drysim.approach.scene import (
    core_of,
    first_u_dd,
    grid_points,
    joined,
    refuse_storm,
    waves_of,
)
from drysim.core.compiled import engine, held
from drysim.core.events import Log
from drysim.core.jet import ORDER, Jet
from drysim.core.means import mean_squares
from drysim.core.motion import Samples, Sines, base_acceleration, sample_squares
from drysim.core.plant import (
    AnyLaw,
    AnyState,
    Deflected,
    Dynamic,
    Plant,
    Totals,
)
from drysim.core.replay import integrate_series, read
from drysim.core.signal import largest
from drysim.core.trace import Steps, first_heading, trace
from drysim.core.waves import Waves

CAPACITY = 16_384
"""Steps that a kernel may take before it hands over, so that an interrupt is heard."""

LADDER = 1e3
"""How much coarser the second solution is from whose distance the error is stated."""

COARSEST = 1e-3
"""Greatest tolerance that a series makes sense with [-]."""

MOST_PERIODS = 2_000
"""Periods after which a motion counts as not settled."""

MOST_MULTIPLE = 8
"""Longest repetition that is looked for, in periods of the excitation."""

CLOSED = 1e-9
"""Scaled change of the state over a repetition that counts as none [-]."""

FAINT = 1e-9
"""Share of the speed that the base alone may give, from which on a motion is measured."""


@dataclass(frozen=True, eq=False)
class SeriesTrack:
    """A solution under a dynamic law: a series from each step to the next."""

    plant: Plant
    law: AnyLaw
    motion: Sines | Samples
    waves: Waves
    base: tuple[Floats, float]
    steps: Steps
    turns: Events
    end: float
    closest: float = math.inf

    def at(self, t: Floats) -> tuple[Floats, Floats, Floats, Floats, Codes]:
        """Give x_r, v_r, z, F_f and the direction at ascending times [s]."""
        columns = tuple(held(np.empty(len(t))) for _ in range(4))
        d = held(np.empty(len(t), dtype=np.int64))
        scene: tuple[Any, ...] = (*self._scene, held(t), *columns, d)
        read(*scene)
        x_r, v_r, z, F_f = map(np.asarray, columns)
        return x_r, v_r, z, F_f, np.asarray(d, dtype=np.int8)

    def state(self, t: float) -> Deflected:
        """Give the state at time t [s]."""
        x_r, v_r, z, _, _ = self.at(np.array([t]))
        return Deflected(float(x_r[0]), float(v_r[0]), float(z[0]))

    def chatter(self, begin: float, end: float) -> float:
        """Give 0: zeros of the velocity are located."""
        return 0.0

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]."""
        window: tuple[Any, ...] = (*self._scene, begin, end)
        x2, v2, x_dd2, power, rub, stuck = integrate_series(*window)
        sums = (x2, v2, x_dd2, power, rub, stuck)
        if isinstance(self.motion, Samples):
            return Totals(*sums, *sample_squares(self.motion, begin, end))
        u_dd2, u2 = mean_squares(self.waves, begin, end)
        return Totals(*sums, u_dd2 * (end - begin), u2 * (end - begin))

    @property
    def _scene(self) -> tuple[Any, ...]:
        """What every kernel wants first."""
        u_dd, dt = self.base
        steps = Steps(*map(held, self.steps))
        return self.plant, self.law, self.waves, held(u_dd), dt, empty_jet(), steps


def empty_jet() -> Jet:
    """Give a series to work in."""
    return Jet(*(held(np.zeros(ORDER + 2)) for _ in Jet._fields))


def empty_steps() -> Steps:
    """Give room for `CAPACITY` steps."""
    kinds = (np.int64, np.float64, np.float64, np.float64, np.float64, np.int64)
    return Steps(*(held(np.zeros(CAPACITY, dtype=kind)) for kind in kinds))


def empty_log() -> Log:
    """Give room for `CAPACITY` events."""
    kinds = (np.int64, np.float64, np.int64, np.float64, np.float64)
    return Log(*(held(np.zeros(CAPACITY, dtype=kind)) for kind in kinds))


def base_of(motion: Sines | Samples, duration: float) -> tuple[Floats, float, int, float]:
    """Give ü besides the waves, its step, the number of the last interval and its length."""
    if isinstance(motion, Sines):
        return np.zeros(2), duration, 0, duration
    dt = motion.dt
    last = min(grid_points(duration, dt), len(motion.u_dd)) - 2
    beyond = duration - (last + 1) * dt
    if beyond > dt * 1e-9 and last + 2 < len(motion.u_dd):
        return motion.u_dd[:], dt, last + 1, beyond
    return motion.u_dd[:], dt, last, dt


def quick(motion: Sines | Samples) -> float:
    """Give a speed that the base gives the mass at least, in order of magnitude [m/s]."""
    if isinstance(motion, Sines):
        swings = (abs(A) / (2.0 * math.pi * f) for A, f in zip(motion.A, motion.f, strict=True))
        return max(swings, default=0.0)
    return largest(motion.u_dd) * motion.dt


def follow(
    plant: Plant,
    law: Dynamic,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> SeriesTrack:
    """Solve a scene from t = 0 to `duration` [s], or to the end of the samples."""
    if duration is None:
        assert isinstance(motion, Samples), "sines need a duration"
        duration = (len(motion.u_dd) - 1) * motion.dt
    u_dd, dt, last, length = base_of(motion, duration)
    waves, jet = waves_of(motion), empty_jet()
    x_r, v_r, z = (*start, 0.0)[:3]
    scene = (plant, law, waves)
    slope = float(u_dd[1] - u_dd[0]) / dt
    d = first_heading(*scene, jet, float(u_dd[0]), slope, 0.0, x_r, v_r, z)
    F_L = plant.m * first_u_dd(motion) + plant.k_x * x_r
    parts, logs = [], [Log([0], [0.0], [d], [x_r], [F_L])]
    swing = math.sqrt(plant.k_x / plant.m) * abs(x_r)
    speed = max(FAINT * quick(motion), FAINT * swing, abs(v_r), np.finfo(float).tiny)
    at: tuple[Any, ...] = (0, 0.0)
    state: tuple[Any, ...] = (x_r, v_r, z, d)
    base = held(u_dd)
    while at[0] <= last:
        steps, log = empty_steps(), empty_log()
        room = (jet, steps, 0, log, 0, CAPACITY)
        rest: tuple[Any, ...] = (speed, *at, length, last, *state, *room)
        out = trace(plant, law, waves, base, dt, *rest)
        speed, n, s, *moved, used, count = out
        at, state = (n, s), tuple(moved)
        refuse_storm(count, n * dt + s, state)
        parts.append([np.array(column[:used]) for column in steps])
        logs.append(Log(*(column[:count].copy() for column in log)))
    steps = Steps(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
    found = joined(logs)
    turns = Events(found.n * dt + found.s, found.kind, found.x_r, found.F_L)
    return SeriesTrack(plant, law, motion, waves, (u_dd, dt), steps, turns, duration)


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
    t = np.arange(points, dtype=np.float64) * dt
    x_r, v_r, _, F_f, d = track.at(t)
    coarser = law._replace(tolerance=min(LADDER * law.tolerance, COARSEST))
    coarse = follow(plant, coarser, motion, start, duration).at(t)[0]
    error = float(np.abs(coarse - x_r).max() / (np.abs(x_r).max() or 1.0))
    u_dd = motion.u_dd[:points] if isinstance(motion, Samples) else base_acceleration(motion, t)
    how = Numerics(
        "stick-slip", *core_of(law, motion), engine(), points - 1, len(track.turns), error=error
    )
    grid = Held(dt, Points(u_dd, x_r, v_r, d, F_f))
    return Response(plant, law, motion, grid, track.turns, how, track)


def find_orbit(
    plant: Plant,
    law: Dynamic,
    motion: Sines,
    start: AnyState,
    period: float,
) -> Orbit:
    """Follow a start, period by period, to its periodic orbit."""
    state: AnyState = start
    past: list[Deflected] = []
    peak, scale, closure = 0.0, [0.0, 0.0, 0.0], math.inf
    for periods in range(1, MOST_PERIODS + 1):
        track = follow(plant, law, motion, state, period)
        state = track.state(period)
        peak = max(peak, float(np.abs(track.turns.x_r).max()))
        largest = [float(np.abs(c).max()) for c in track.steps[2:5]]
        scale = [max(new, 0.5 * old) for new, old in zip(largest, scale, strict=True)]
        past = [state, *past[:MOST_MULTIPLE]]
        changes = [
            max(abs(a - b) / (c or 1.0) for a, b, c in zip(state, old, scale, strict=True))
            for old in past[1:]
        ]
        closed = [i for i, change in enumerate(changes) if change <= CLOSED]
        if closed:
            closure, multiple = changes[closed[0]], closed[0] + 1
            return Orbit(state, multiple, closure, True, True, periods * period, peak)
        closure = min(changes, default=math.inf)
    return Orbit(state, 1, closure, False, True, MOST_PERIODS * period, peak)
