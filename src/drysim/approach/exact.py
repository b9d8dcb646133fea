"""The exact solution of a scene: picks the smallest core that is exact for it, and says which and why."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from drysim.approach.response import Codes, Events, Floats, Numerics, Orbit, Response
from drysim.approach.track import LeapTrack, StepTrack
from drysim.core import leap, orbit
from drysim.core.compiled import engine, held
from drysim.core.march import ROOM, Log, first_mode, march
from drysim.core.motion import Samples, Sines
from drysim.core.plant import Law, Plant, State
from drysim.core.slide import Waves
from drysim.errors import SolverError, UsageError

LOG_LENGTH = 4 * ROOM
"""Events that a kernel may write before it hands over."""

STRIDE = 4_000_000
"""Samples that a kernel may march before it hands over, so that an interrupt is heard."""

MOST_PERIODS = 5_000
"""Periods after which a scene counts as not settled."""

ON_GRID = 1e-9
"""A duration this close to a whole number of steps, relative to one step, is that number."""


def waves_of(motion: Sines | Samples, law: Law) -> Waves:
    """Give the sines of a scene as the kernels want them; varying friction is one more."""
    A, f, phase = motion if isinstance(motion, Sines) else ((), (), ())
    base = len(A)
    if law.variation:
        A, f, phase = (*A, 0.0), (*f, law.omega / (2.0 * math.pi)), (*phase, law.phase)
    omega = tuple(2.0 * math.pi * value for value in f)
    columns = [held(np.array(column, dtype=float)) for column in (A, f, omega, phase)]
    return Waves(*columns, held(np.zeros(len(A))), base)


def mode_at_start(plant: Plant, law: Law, motion: Sines | Samples, start: State) -> int:
    """Give the direction of sliding at t = 0, 0 for stuck."""
    load = 1.0 + law.variation * math.sin(law.phase)
    limits = law._replace(F_fk=law.F_fk * load, F_fs=law.F_fs * load)
    d: int = first_mode(plant, limits, start.x_r, start.v_r, first_u_dd(motion))
    return d


def first_u_dd(motion: Sines | Samples) -> float:
    """Give ü at t = 0 [m/s²]."""
    if isinstance(motion, Samples):
        return float(motion.u_dd[0])
    return sum(A * math.sin(phase) for A, _, phase in zip(*motion, strict=True))


def empty_log() -> Log:
    """Give an empty log of `LOG_LENGTH` events."""
    whole, real = np.zeros(LOG_LENGTH, dtype=np.int64), np.zeros(LOG_LENGTH)
    return Log(*(held(column.copy()) for column in (whole, real, whole, real, real)))


def joined(logs: list[Log]) -> Log:
    """Give several logs as one log of arrays."""
    kinds = (np.int64, np.float64, np.int8, np.float64, np.float64)
    return Log(
        *(
            np.concatenate([np.asarray(column, dtype=kind) for column in columns])
            for kind, columns in zip(kinds, zip(*logs, strict=True), strict=True)
        )
    )


def first_entry(plant: Plant, motion: Sines | Samples, start: State, d: int) -> Log:
    """Give the log of the state at t = 0."""
    F_L = plant.m * first_u_dd(motion) + plant.k_x * start.x_r
    return Log([0], [0.0], [d], [start.x_r], [F_L])


def grid_points(duration: float, step: float) -> int:
    """Give the number of grid points n·step from 0 to the duration, both ends included."""
    steps = duration / step
    whole = round(steps)
    return (whole if abs(steps - whole) <= ON_GRID * max(1.0, whole) else int(steps)) + 1


def solve_sines(
    plant: Plant, law: Law, motion: Sines, start: State, step: float, duration: float
) -> Response:
    """Solve a scene under sines from event to event, then write it on the grid n·step."""
    waves = waves_of(motion, law)
    d = mode_at_start(plant, law, motion, start)
    logs, log = [first_entry(plant, motion, start, d)], empty_log()
    begin, state, closest = 0.0, (start.x_r, start.v_r, d), math.inf
    while begin < duration:
        begin, *now, count, tight = leap.leap(
            plant, law, waves, 0.0, 0.0, 0, 0.0, duration, begin, *state, log, 0, LOG_LENGTH
        )
        refuse_storm(count, begin, now)
        state, closest = (now[0], now[1], now[2]), min(closest, tight)
        logs.append(Log(*(column[:count].copy() for column in log)))
    found = joined(logs)
    turns = Events(found.s, found.kind, found.x_r, found.F_L)
    track = LeapTrack(plant, law, motion, waves, start, turns, duration)
    n = grid_points(duration, step)
    x_r, v_r, modes = held(np.zeros(n)), held(np.zeros(n)), held(np.zeros(n, dtype=np.int8))
    columns = (held(turns.t), held(turns.kind), held(turns.x_r))
    leap.sample_leaps(plant, law, waves, *columns, start.v_r, step, x_r, v_r, modes)
    u_dd = np.zeros(n)
    for A, f, phase in zip(*motion, strict=True):
        u_dd += A * np.sin(2.0 * np.pi * ((f * step * np.arange(n)) % 1.0) + phase)
    numerics = note("leap", "sines are used analytically: from event to event", n, turns, closest)
    grid = (step, u_dd, np.asarray(x_r), np.asarray(v_r), np.asarray(modes, dtype=np.int8))
    return Response(plant, law, motion, *grid, turns, numerics, track)


def solve_samples(
    plant: Plant, law: Law, motion: Samples, start: State, duration: float | None
) -> Response:
    """Solve a scene under samples on their own grid."""
    last = len(motion.u_dd) - 1
    end_time = last * motion.dt if duration is None else duration
    n_end = min(last, grid_points(end_time, motion.dt) - 1)
    beyond = min(last, n_end + (end_time > n_end * motion.dt * (1.0 + 1e-12)))
    found, x_r, v_r, d, closest = march_samples(plant, law, motion, start, beyond)
    t = found.n * motion.dt + found.s
    keep = t <= end_time
    turns = Events(t[keep], found.kind[keep], found.x_r[keep], found.F_L[keep])
    track = StepTrack(
        plant, law, motion, waves_of(motion, law), Log(*(column[1:] for column in found)), turns,
        end_time, x_r, v_r, d,
    )  # fmt: skip
    why = "samples are linear in between: one affine map a step, events located"
    if law.variation:
        why = "samples with friction limits that vary: one leap a step"
    numerics = note("leap" if law.variation else "march", why, n_end + 1, turns, closest)
    part = slice(0, n_end + 1)
    grid = (motion.dt, motion.u_dd[part], x_r[part], v_r[part], d[part])
    return Response(plant, law, motion, *grid, turns, numerics, track)


def march_samples(
    plant: Plant, law: Law, motion: Samples, start: State, last: int
) -> tuple[Log, Floats, Floats, Codes, float]:
    """March to sample `last`; gives the events, x_r, v_r, direction, and the tightest decision."""
    u_dd = held(motion.u_dd)
    x_r, v_r = held(np.empty(last + 1)), held(np.empty(last + 1))
    d = held(np.empty(last + 1, dtype=np.int8))
    mode = mode_at_start(plant, law, motion, start)
    x_r[0], v_r[0], d[0] = start.x_r, start.v_r, mode
    logs, log = [first_entry(plant, motion, start, mode)], empty_log()
    n, state, closest = 0, (start.x_r, start.v_r, mode), math.inf
    while n < last:
        until = min(n + STRIDE, last)
        rest: tuple[Any, ...] = (*state, x_r, v_r, d, log, 0, LOG_LENGTH)
        if law.variation:
            waves = waves_of(motion, law)
            out = leap.leap_steps(plant, law, waves, u_dd, motion.dt, n, until, *rest)
        else:
            out = march(plant, law, u_dd, motion.dt, n, until, *rest)
        n, state, count, closest = out[0], out[1:4], out[4], min(closest, out[5])
        refuse_storm(count, n * motion.dt, state)
        logs.append(Log(*(column[:count].copy() for column in log)))
    arrays = (np.asarray(x_r), np.asarray(v_r), np.asarray(d, dtype=np.int8))
    return (joined(logs), *arrays, closest)


def find_orbit(plant: Plant, law: Law, motion: Sines, start: State, period: float) -> Orbit:
    """Follow a start to its periodic orbit."""
    d = mode_at_start(plant, law, motion, start)
    past = held(np.zeros(orbit.MOST_MULTIPLE)), held(np.zeros(orbit.MOST_MULTIPLE))
    x_r, v_r, _, multiple, closure, periods, peak = orbit.settle(
        plant, law, waves_of(motion, law), period, start.x_r, start.v_r, d, MOST_PERIODS,
        *past, empty_log(), LOG_LENGTH,
    )  # fmt: skip
    refuse_storm(multiple, periods * period, (x_r, v_r))
    settled = multiple > 0
    return Orbit(State(x_r, v_r), max(multiple, 1), closure, settled, periods * period, peak)


def note(core: str, why: str, points: int, turns: Events, closest: float) -> Numerics:
    """Give what is to be said of how the numbers were made."""
    decision = None if math.isinf(closest) else closest
    return Numerics("stick-slip", core, why, engine(), points - 1, len(turns), decision)


def frictionless(response: Response) -> Response:
    """Give the response of a scene without dry friction: turning points are not events then."""
    whole = np.ones(len(response.x_r), dtype=np.int8)
    events = response.events
    begin = Events(events.t[:1], np.sign(events.kind[:1]), events.x_r[:1], events.F_L[:1])
    why = "no dry friction: the same flow, with turning points for the peaks only"
    numerics = replace(
        response.numerics, approach="viscous", why=why, events=1, closest_decision=None
    )
    return replace(response, d=whole, events=begin, numerics=numerics)


def refuse_storm(count: int, t: float, state: Any) -> None:
    """Raise where events follow each other without end, or the state has left the numbers."""
    if count < 0:
        raise SolverError(
            f"at t = {t:.9g} s events follow each other without progress in time",
            "check friction and stiffness for values at the end of double precision",
        )
    if not all(math.isfinite(value) for value in state[:2]):
        raise SolverError(
            f"by t = {t:.9g} s the motion is beyond the numbers that a computer holds",
            "check the units of the base motion and of the oscillator",
        )



def solve(
    plant: Plant,
    law: Law,
    motion: Sines | Samples,
    start: State,
    step: float,
    duration: float | None,
) -> Response:
    """Solve a scene with the core that fits its base motion."""
    if isinstance(motion, Samples):
        return solve_samples(plant, law, motion, start, duration)
    if duration is None:
        raise UsageError("base motion by sines has no end of its own", "say how long to run")
    return solve_sines(plant, law, motion, start, step, duration)
