"""The exact solution over samples: known at every sample and at every event between."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drysim.approach.events import Codes, Events, Floats
from drysim.approach.response import Response
from drysim.approach.scene import (
    LOG_LENGTH,
    core_of,
    empty_log,
    first_entry,
    grid_points,
    joined,
    mode_at_start,
    numerics,
    refuse_storm,
    waves_of,
)
from drysim.core.compiled import held
from drysim.core.events import Log, direction
from drysim.core.forms import step_forms
from drysim.core.grid import state_within
from drysim.core.integrals import integrate_steps
from drysim.core.leap import leap_steps
from drysim.core.march import march
from drysim.core.motion import Samples, sample_squares
from drysim.core.plant import Law, Plant, State, Totals
from drysim.core.slide import Waves

Numbers = NDArray[np.intp]

BLOCK = 65_536
"""Steps integrated at a time: a few megabytes."""

STRIDE = 4_000_000
"""Samples that a kernel may march before it hands over, so that an interrupt is heard."""


@dataclass(frozen=True, eq=False)
class StepTrack:
    """A solution over samples: known at every sample and at every event between.

    `x_r`, `v_r` and `d` hold one value a sample, shape (n,); `log` holds the events.
    """

    plant: Plant
    law: Law
    motion: Samples
    waves: Waves
    log: Log
    turns: Events
    end: float
    x_r: Floats
    v_r: Floats
    d: Codes
    closest: float

    def state(self, t: float) -> State:
        """Give the state at time t [s]."""
        dt, u_dd = self.motion.dt, self.motion.u_dd
        n = min(int(t / dt), len(self.x_r) - 1)
        n += (n + 1) * dt <= t and n + 1 < len(self.x_r)
        start, x_r, v_r, d = 0.0, float(self.x_r[n]), float(self.v_r[n]), int(self.d[n])
        if n * dt >= t:
            return State(x_r, v_r)
        i = int(np.searchsorted(self.turns.t, t, side="right")) - 1
        if self.turns.t[i] > n * dt:
            start, x_r, v_r = float(self.turns.t[i]) - n * dt, float(self.turns.x_r[i]), 0.0
            d = direction(int(self.turns.kind[i]))
        slope = (float(u_dd[n + 1]) - float(u_dd[n])) / dt
        u_0 = float(u_dd[n]) + slope * start
        found = state_within(
            self.plant, self.law, self.waves, u_0, slope, n * dt + start, x_r, v_r, d,
            t - n * dt - start,
        )  # fmt: skip
        return State(*found)

    def chatter(self, begin: float, end: float) -> float:
        """Give 0: located stops leave nothing to flip with the step."""
        return 0.0

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]."""
        dt = self.motion.dt
        first, last = int(begin / dt), min(math.ceil(end / dt), len(self.motion.u_dd) - 1)
        whole = np.ones(last - first, dtype=bool)
        if self.law.variation:
            whole[:] = False
        numbers = np.asarray(self.log.n)
        numbers = numbers[(numbers >= first) & (numbers < last)]
        whole[numbers - first] = False
        whole[0] &= begin <= first * dt
        whole[-1] &= end >= last * dt
        odd = np.flatnonzero(~whole) + first
        sums = np.array(
            integrate_steps(
                self.plant, self.law, self.waves, held(self.motion.u_dd), dt, held(odd),
                held(self.x_r), held(self.v_r), held(self.d), Log(*map(held, self.log)),
                begin, end,
            )
        )  # fmt: skip
        forms = step_forms(self.plant.b / self.plant.m, self.plant.k_x / self.plant.m, dt)
        for at in range(first, last, BLOCK):
            n = np.flatnonzero(whole[at - first : at - first + BLOCK]) + at
            sums += self._whole_steps(n, forms)
        u_dd2, u2 = sample_squares(self.motion, begin, end)
        x2, v2, x_dd2, power, rub, stuck = sums.tolist()
        return Totals(x2, v2, x_dd2, power, rub, stuck, u_dd2, u2)

    def _whole_steps(self, n: Numbers, forms: Floats) -> Floats:
        """Integrate whole steps: those of sliding by their quadratic forms."""
        dt, u_dd = self.motion.dt, self.motion.u_dd
        stuck, slip = n[self.d[n] == 0], n[self.d[n] != 0]
        x_r = self.x_r[slip]
        f = self.d[slip] * (self.law.F_fk / self.plant.m)
        columns = np.column_stack(
            (x_r, self.v_r[slip], -u_dd[slip] - f, -u_dd[slip + 1] - f, f)
        )
        sums = np.zeros(6)
        sums[:4] = np.einsum("kij,ij->k", forms, columns.T @ columns)
        sums[4] = np.abs(self.x_r[slip + 1] - x_r).sum()
        u_0, u_1 = u_dd[stuck], u_dd[stuck + 1]
        sums[0] += dt * np.square(self.x_r[stuck]).sum()
        sums[2] += dt / 3.0 * (u_0 * u_0 + u_0 * u_1 + u_1 * u_1).sum()
        sums[5] = dt * len(stuck)
        return sums


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
        plant, law, motion, waves_of(motion, law), Log(*(column[1:] for column in found)),
        turns, end_time, x_r, v_r, d, closest,
    )  # fmt: skip
    how = numerics(*core_of(law, motion), n_end + 1, turns, closest)
    part = slice(0, n_end + 1)
    grid = (motion.dt, motion.u_dd[part], x_r[part], v_r[part], d[part])
    return Response(plant, law, motion, *grid, turns, how, track)


def march_samples(
    plant: Plant, law: Law, motion: Samples, start: State, last: int
) -> tuple[Log, Floats, Floats, Codes, float]:
    """March to sample `last`; gives events, x_r, v_r, direction and the tightest decision."""
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
            out = leap_steps(plant, law, waves, u_dd, motion.dt, n, until, *rest)
        else:
            out = march(plant, law, u_dd, motion.dt, n, until, *rest)
        n, state, count, closest = out[0], out[1:4], out[4], min(closest, out[5])
        refuse_storm(count, n * motion.dt, state)
        logs.append(Log(*(column[:count].copy() for column in log)))
    arrays = (np.asarray(x_r), np.asarray(v_r), np.asarray(d, dtype=np.int8))
    return (joined(logs), *arrays, closest)
