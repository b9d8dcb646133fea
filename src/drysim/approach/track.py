"""The exact solution between grid points: under sines, and over samples."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drysim.approach.response import Codes, Events, Floats
from drysim.core.compiled import held
from drysim.core.integrals import integrate_leaps, integrate_steps, step_forms
from drysim.core.leap import state_within
from drysim.core.march import Log
from drysim.core.motion import Samples, Sines, mean_squares
from drysim.core.plant import Law, Plant, State, Totals
from drysim.core.slide import Waves

Numbers = NDArray[np.intp]

BLOCK = 65_536
"""Steps integrated at a time: a few megabytes."""

FOUR_NODES = ((0.0694318442029737, 0.1739274225687269), (0.3300094782075719, 0.3260725774312731))
"""Gauss-Legendre nodes and weights on 0..1 (mirrored): exact for the square of a cubic."""


def direction(kind: int) -> int:
    """Give the direction of sliding after an event of this kind, 0 for stuck."""
    return int(np.sign(kind))


@dataclass(frozen=True, eq=False)
class LeapTrack:
    """A solution under sines: known from event to event."""

    plant: Plant
    law: Law
    motion: Sines
    waves: Waves
    start: State
    turns: Events
    end: float

    def state(self, t: float) -> State:
        """Give the state at time t [s]."""
        i = int(np.searchsorted(self.turns.t, t, side="right")) - 1
        t_i, x_r = float(self.turns.t[i]), float(self.turns.x_r[i])
        v_r = self.start.v_r if i == 0 else 0.0
        d = direction(int(self.turns.kind[i]))
        found = state_within(
            self.plant, self.law, self.waves, 0.0, 0.0, t_i, x_r, v_r, d, t - t_i
        )
        return State(*found)

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]."""
        turns = self.turns
        sums = integrate_leaps(
            self.plant, self.law, self.waves, held(turns.t), held(turns.kind), held(turns.x_r),
            self.start.v_r, begin, end,
        )  # fmt: skip
        u_dd2, u2 = mean_squares(self.motion, begin, end)
        return Totals(*sums, u_dd2 * (end - begin), u2 * (end - begin))


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
                held(self.x_r), held(self.v_r), held(self.d), Log(*map(held, self.log)), begin, end,
            )
        )  # fmt: skip
        forms = step_forms(self.plant.b / self.plant.m, self.plant.k_x / self.plant.m, dt)
        for at in range(first, last, BLOCK):
            n = np.flatnonzero(whole[at - first : at - first + BLOCK]) + at
            sums += self._whole_steps(n, forms)
        u_dd2, u2 = sample_squares(self.motion, begin, end)
        return Totals(*sums.tolist(), u_dd2, u2)

    def _whole_steps(self, n: Numbers, forms: Floats) -> Floats:
        """Integrate whole steps: those of sliding by their quadratic forms."""
        dt, u_dd = self.motion.dt, self.motion.u_dd
        stuck, slip = n[self.d[n] == 0], n[self.d[n] != 0]
        x_r = self.x_r[slip]
        f = self.d[slip] * (self.law.F_fk / self.plant.m)
        columns = np.column_stack((x_r, self.v_r[slip], -u_dd[slip] - f, -u_dd[slip + 1] - f, f))
        sums = np.zeros(6)
        sums[:4] = np.einsum("kij,ij->k", forms, columns.T @ columns)
        sums[4] = np.abs(self.x_r[slip + 1] - x_r).sum()
        u_0, u_1 = u_dd[stuck], u_dd[stuck + 1]
        sums[0] += dt * np.square(self.x_r[stuck]).sum()
        sums[2] += dt / 3.0 * (u_0 * u_0 + u_0 * u_1 + u_1 * u_1).sum()
        sums[5] = dt * len(stuck)
        return sums


def sample_squares(motion: Samples, begin: float, end: float) -> tuple[float, float | None]:
    """Give the integrals of ü² and, where u is known, of u² over a window of sampled motion."""
    dt = motion.dt
    first, last = int(begin / dt), min(math.ceil(end / dt), len(motion.u_dd) - 1)
    u_dd2, u2 = 0.0, 0.0
    for at in range(first, last, BLOCK):
        n = np.arange(at, min(at + BLOCK, last))
        lo = np.maximum(begin / dt - n, 0.0)
        width = np.minimum(end / dt - n, 1.0) - lo
        a_0, a_1 = motion.u_dd[n], motion.u_dd[n + 1]
        for node, weight in FOUR_NODES:
            for place in (node, 1.0 - node):
                q = lo + width * place
                p = 1.0 - q
                u_dd2 += weight * dt * (width * np.square(p * a_0 + q * a_1)).sum()
                if motion.u is not None:
                    bulge = dt * dt / 6.0 * ((p**3 - p) * a_0 + (q**3 - q) * a_1)
                    u = p * motion.u[n] + q * motion.u[n + 1] + bulge
                    u2 += weight * dt * (width * np.square(u)).sum()
    return float(u_dd2), None if motion.u is None else float(u2)
