"""The exact solution over samples: known at every sample and at every event between."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from drysim.approach.events import Events, Floats
from drysim.approach.march import Block, March, Marched, march_samples
from drysim.approach.response import Response
from drysim.approach.scene import numerics
from drysim.approach.spans import last_needed, run_length
from drysim.approach.track import Located
from drysim.core.compiled import held
from drysim.core.events import Log, direction
from drysim.core.forms import PAIRS, integrals, step_forms, step_rows
from drysim.core.grid import state_within
from drysim.core.integrals import integrate_steps
from drysim.core.motion import Samples, sample_squares
from drysim.core.plant import Law, Plant
from drysim.core.state import AnyState, State, Totals

Numbers = NDArray[np.intp]

PIECE = 16_384
"""Steps integrated at a time: so few that no linear algebra starts threads for them."""


@dataclass(frozen=True, eq=False)
class StepTrack(Located):
    """A solution over samples: known at every sample and at every event between."""

    march: March
    turns: Events
    end: float
    closest: float

    @property
    def plant(self) -> Plant:
        """The oscillator."""
        return self.march.plant

    @property
    def law(self) -> Law:
        """Its friction."""
        return self.march.law

    def state(self, t: float) -> State:
        """Give the state at time t [s]."""
        dt, last = self.march.motion.dt, self.march.last
        n = min(int(t / dt), last)
        n += (n + 1) * dt <= t and n + 1 <= last
        block = self.march.holding(n)
        at = n - block.first
        start, x_r, v_r, d = 0.0, float(block.x_r[at]), float(block.v_r[at]), int(block.d[at])
        if n * dt >= t:
            return State(x_r, v_r)
        i = int(np.searchsorted(self.turns.t, t, side="right")) - 1
        if self.turns.t[i] > n * dt:
            start, x_r, v_r = float(self.turns.t[i]) - n * dt, float(self.turns.x_r[i]), 0.0
            d = direction(int(self.turns.kind[i]))
        slope = (float(block.u_dd[at + 1]) - float(block.u_dd[at])) / dt
        u_0 = float(block.u_dd[at]) + slope * start
        found = state_within(
            self.plant, self.law, self.march.waves, u_0, slope, n * dt + start, x_r, v_r, d,
            t - n * dt - start,
        )  # fmt: skip
        return State(*found)

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]."""
        motion = self.march.motion
        first, last = int(begin / motion.dt), math.ceil(end / motion.dt)
        sums = np.zeros(6)
        for block in self.march.blocks(first, min(last, len(motion.u_dd) - 1)):
            part = max(first - block.first, 0), min(last - block.first, len(block.d) - 1)
            sums += self._steps(block, *part, begin, end)
        u_dd2, u2 = sample_squares(motion, begin, end)
        x2, v2, x_dd2, power, rub, stuck = sums.tolist()
        return Totals(x2, v2, x_dd2, power, rub, stuck, u_dd2, u2)

    def _steps(self, block: Block, lo: int, hi: int, begin: float, end: float) -> Floats:
        """Integrate the steps from sample lo to sample hi of a block, within a window [s]."""
        dt, plant = self.march.motion.dt, self.plant
        log = Log(*(column[1:] for column in block.log))
        whole = np.full(hi - lo, not self.law.variation)
        numbers = log.n[(log.n >= lo) & (log.n < hi)]
        whole[numbers - lo] = False
        whole[0] &= begin <= (block.first + lo) * dt
        whole[-1] &= end >= (block.first + hi) * dt
        odd = np.flatnonzero(~whole) + lo
        sums = np.array(
            integrate_steps(
                plant, self.law, self.march.waves, held(block.u_dd), dt, block.first, held(odd),
                held(block.x_r), held(block.v_r), held(block.d), Log(*map(held, log)),
                begin, end,
            )
        )  # fmt: skip
        parts = [
            self._whole_steps(block, np.flatnonzero(whole[at - lo : at - lo + PIECE]) + at)
            for at in range(lo, hi, PIECE)
        ]
        products, way, stuck = (np.sum(part, axis=0) for part in zip(*parts, strict=True))
        sums += integrals(step_forms(plant.b / plant.m, plant.k_x / plant.m, dt), products, way)
        sums[[0, 2, 5]] += dt * stuck
        return sums

    def _whole_steps(self, block: Block, n: Numbers) -> tuple[Floats, Floats, Floats]:
        """Sum up whole steps: products and way of sliding; x_r², ü² and number of the rest."""
        (m, k_x, b), u_dd = self.plant, block.u_dd
        stuck, slip = n[block.d[n] == 0], n[block.d[n] != 0]
        d = block.d[slip]
        rows = step_rows(
            b / m, k_x / m, d * (self.law.F_fk / m), block.x_r[slip], block.v_r[slip],
            u_dd[slip], u_dd[slip + 1],
        )  # fmt: skip
        first, second = zip(*PAIRS, strict=True)
        u_0, u_1 = u_dd[stuck], u_dd[stuck + 1]
        x2, u2 = np.square(block.x_r[stuck]).sum(), (u_0 * u_0 + u_0 * u_1 + u_1 * u_1).sum()
        still = np.array([x2, u2 / 3.0, len(stuck)])
        return (rows @ rows.T)[first, second], np.einsum("ij,j->i", rows[1:4], d), still


def solve_samples(
    plant: Plant,
    law: Law,
    motion: Samples,
    start: AnyState,
    duration: float | None,
    whole: bool,
) -> Response:
    """Solve a scene under samples on their own grid; `whole` keeps all of it at hand."""
    end = run_length(motion, duration)
    point, last = last_needed(motion, end)
    march, found, closest = march_samples(plant, law, motion, start, last, whole)
    turns = found.until(end)
    track = StepTrack(march, turns, end, closest)
    how = partial(numerics, law, motion, point + 1, turns, closest)
    return Response(plant, law, motion, Marched(march, point + 1), turns, how, track)
