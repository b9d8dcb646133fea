"""The exact solution under sines: from event to event, on any grid, and its periodic orbit."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from drysim.approach.events import Events, Floats
from drysim.approach.orbit import Orbit
from drysim.approach.points import Points
from drysim.approach.response import Response
from drysim.approach.room import empty_log, longer
from drysim.approach.scene import (
    LOG_LENGTH,
    grid_points,
    numerics,
    refuse_storm,
    wave_values,
    waves_of,
)
from drysim.approach.spans import base_of_waves
from drysim.approach.track import Located
from drysim.core.compiled import held
from drysim.core.events import Log, direction
from drysim.core.grid import sample_leaps, state_within
from drysim.core.integrals import integrate_leaps
from drysim.core.means import mean_squares
from drysim.core.motion import Sines
from drysim.core.plant import Law, Plant
from drysim.core.sines import orbit, orbits
from drysim.core.sines.leap import leap, leap_off
from drysim.core.sines.scene import REST, V_R
from drysim.core.state import AnyState, State, Totals
from drysim.core.table import room
from drysim.core.waves import STRIDE, Waves

LEAPS = 1_000_000
"""Events that a kernel may find before it hands over, so that an interrupt is heard."""

FEW_EVENTS = 1024
"""Events that there is room for at first; room is doubled as it fills."""

MOST_PERIODS = 5_000
"""Periods after which a scene counts as not settled."""


@dataclass(frozen=True, eq=False)
class LeapTrack(Located):
    """A solution under sines: known from event to event; `scene` as kernels read it."""

    plant: Plant
    law: Law
    motion: Sines
    scene: Any
    turns: Events
    end: float
    closest: float

    @property
    def waves(self) -> Waves:
        """The waves of the scene."""
        return Waves(self.scene[REST:], self.size, len(self.motion.A))

    @property
    def size(self) -> int:
        """Their number."""
        return (len(self.scene) - REST) // STRIDE

    def state(self, t: float) -> State:
        """Give the state at time t [s]."""
        i = int(np.searchsorted(self.turns.t, t, side="right")) - 1
        t_i, x_r = float(self.turns.t[i]), float(self.turns.x_r[i])
        v_r = self.scene[V_R] if i == 0 else 0.0
        d = direction(int(self.turns.kind[i]))
        found = state_within(
            self.plant, self.law, self.waves, 0.0, 0.0, t_i, x_r, v_r, d, t - t_i
        )
        return State(*found)

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]."""
        turns, waves = self.turns, self.waves
        x2, v2, x_dd2, power, rub, stuck = integrate_leaps(
            self.plant, self.law, waves, held(turns.t), held(turns.kind), held(turns.x_r),
            self.scene[V_R], begin, end,
        )  # fmt: skip
        length = end - begin
        u_dd2, u2 = mean_squares(waves, begin, end)
        return Totals(x2, v2, x_dd2, power, rub, stuck, u_dd2 * length, u2 * length)


def follow_sines(
    plant: Plant, law: Law, motion: Sines, start: AnyState, duration: float
) -> LeapTrack:
    """Solve a scene under sines from event to event; no grid takes part."""
    x_r, v_r = start[:2]
    scene = held(np.array([*plant, *law, x_r, v_r, *wave_values(motion, law)]))
    log, kind = held(np.empty((4, FEW_EVENTS))), held(np.empty(FEW_EVENTS, np.int8))
    begin, x_r, v_r, d, count, closest = leap_off(scene, duration, log, kind)
    refuse_storm(count, begin, (x_r, v_r))
    while begin < duration:
        size = min(2 * len(kind), count + LEAPS)
        log, kind = held(np.hstack((log, np.empty((4, size - len(kind)))))), longer(kind, size)
        begin, x_r, v_r, d, count, tight = leap(
            plant, law, waves_of(motion, law), 0.0, 0.0, 0, 0.0, duration, begin, x_r, v_r, d,
            Log(log[0], log[1], kind, log[2], log[3]), count, size,
        )  # fmt: skip
        refuse_storm(count, begin, (x_r, v_r))
        closest = min(closest, tight)
    # One row by its number: to take rows apart in turn costs as much as some tens of events.
    log, kind = np.asarray(log), np.asarray(kind[:count], dtype=np.int8)
    turns = Events(log[1, :count], kind, log[2, :count], log[3, :count])
    return LeapTrack(plant, law, motion, scene, turns, duration, closest)


@dataclass(frozen=True, eq=False)
class Leaps:
    """A solution under sines on the grid n·dt, of `length` points."""

    track: LeapTrack
    dt: float
    length: int

    def __len__(self) -> int:
        """Give the number of points."""
        return self.length

    def base(self, first: int, last: int) -> Floats:
        """Give ü [m/s²] from point number `first` to the one before `last`."""
        return base_of_waves(self.track.waves, first, last, self.dt)

    def part(self, first: int, last: int) -> Points:
        """Give the points from number `first` to the one before `last`."""
        track, n = self.track, last - first
        turns = track.turns
        out, d = held(np.empty((2, n))), held(np.empty(n, np.int8))
        sample_leaps(
            track.scene, held(turns.t), held(turns.kind), held(turns.x_r), first, self.dt,
            held(np.empty(room(track.size))), out, d,
        )  # fmt: skip
        x_r, v_r = np.asarray(out)
        return Points(x_r, v_r, np.asarray(d, dtype=np.int8))


def on_grid(track: LeapTrack, step: float) -> Response:
    """Give a solution on the grid n·step."""
    plant, law, motion, turns = track.plant, track.law, track.motion, track.turns
    n = grid_points(track.end, step)
    how = partial(numerics, law, motion, n, turns, track.closest)
    return Response(plant, law, motion, Leaps(track, step, n), turns, how, track)


def find_orbit(plant: Plant, law: Law, motion: Sines, start: AnyState, period: float) -> Orbit:
    """Follow a start to its periodic orbit."""
    x_r, v_r, multiple, closure, periods, peak, unique = orbit.find(
        plant, law, waves_of(motion, law), period, *start[:2], MOST_PERIODS, *pasts(),
        empty_log(LOG_LENGTH), LOG_LENGTH,
    )  # fmt: skip
    refuse_storm(multiple, periods * period, (x_r, v_r))
    return Orbit(
        State(x_r, v_r), max(multiple, 1), closure, multiple > 0, unique,
        periods * period, peak,
    )  # fmt: skip


def solve_orbits(scenes: Floats) -> Floats:
    """Find and measure the periodic orbits of many scenes.

    Parameters
    ----------
    scenes : ndarray, shape (n, SINES + 3 sines)
        The columns that `drysim.core.sines.orbits` names.

    Returns
    -------
    ndarray, shape (n, FOUND)
        The columns of its answers.
    """
    answers = held(np.full((len(scenes), orbits.FOUND), np.nan))
    room = (scenes.shape[1] - orbits.SINES) // 3 + 1
    orbits.solve_orbits(
        held(np.ascontiguousarray(scenes)), answers, held(np.zeros(STRIDE * room)), *pasts(),
        MOST_PERIODS, empty_log(LOG_LENGTH), LOG_LENGTH,
    )  # fmt: skip
    return np.asarray(answers)


def pasts() -> tuple[Any, Any]:
    """Give room for the states of the latest periods."""
    return held(np.zeros(orbit.MOST_MULTIPLE)), held(np.zeros(orbit.MOST_MULTIPLE))
