"""A spring contact of constant limit over samples: known at every sample and change of mode."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from drysim.approach.events import Codes, Events, Floats
from drysim.approach.scene import CONSTANT, waves_of
from drysim.approach.told import all_told, whole_pieces
from drysim.approach.track import Located, Path
from drysim.core.compiled import held
from drysim.core.contacts.contact import HOLD
from drysim.core.contacts.contact_replay import integrate_pieces, read_contact
from drysim.core.contacts.step_turns import tell_steps
from drysim.core.contacts.whole import whole_steps
from drysim.core.forms import step_forms, step_rows
from drysim.core.motion import Samples, sample_squares
from drysim.core.plant import Plant, Slider
from drysim.core.state import Deflected, Totals
from drysim.core.trail import Pieces

PIECE = 8_192
"""Steps integrated at a time: a dot product of more than 10,000 numbers would start threads,
which takes longer than all the rest."""


@dataclass(frozen=True, eq=False)
class Jointed(Located):
    """A solution over samples; `trail` holds where each mode of the contact begins.

    x_r and v_r are those at the samples, and d in which direction the contact yields there, 0
    where it holds.
    """

    plant: Plant
    law: Slider
    motion: Samples
    u_dd: Floats
    x_r: Floats
    v_r: Floats
    d: Codes
    trail: Pieces
    events: Events
    end: float
    closest: float = math.inf

    def path(self, window: tuple[float, float], x_rM: float | None) -> Path:
        """Give the points of x_r that tell all of its way in a window [s]."""
        plant, dt, trail = self.plant, self.motion.dt, self.trail
        sprung = whole_steps(Plant(plant.m, plant.k_x + self.law.k_t, plant.b), dt)
        held_trail, states = Pieces(*map(held, trail)), (held(self.x_r), held(self.v_r))
        scene = plant, self.law, sprung, self.base, *states, held_trail
        whole = whole_pieces(trail.n * dt + trail.s, window)
        path = all_told(tell_steps, scene, whole, x_rM, (0, -1, 0.0, 0.0, 0.0))
        # The march goes on to the next sample, wherever the run ends before.
        count = int(np.searchsorted(path.t, self.end, "right"))
        return Path(path.t[:count], path.x_r[:count])

    @cached_property
    def base(self) -> Any:
        """Base acceleration as the kernels want it [m/s²]."""
        return held(self.u_dd)

    @cached_property
    def x_0(self) -> Floats:
        """Where the contact carries no force at each sample, should it hold [m]."""
        first = np.append(self.trail.n + (self.trail.s > 0.0), len(self.x_r))
        return np.repeat(self.trail.z, np.diff(np.minimum(first, len(self.x_r))))

    def state(self, t: float) -> Deflected:
        """Give the state at time t [s]."""
        dt, last = self.motion.dt, len(self.x_r) - 1
        n = min(int(t / dt), last)
        n += (n + 1) * dt <= t and n + 1 <= last
        if n * dt >= t:
            x_r, d = float(self.x_r[n]), int(self.d[n])
            x_0 = float(self.x_0[n])
            z = x_r - d * self.law.F_fk / self.law.k_t if d else x_0
            return Deflected(x_r, float(self.v_r[n]), z)
        pieces = self.pieces(np.array([n]))
        columns = tuple(held(np.empty(1)) for _ in range(4))
        written = held(np.array([t])), *columns, held(np.zeros(1, dtype=np.int64))
        read_contact(*self._scene(pieces), *written)
        x, v, z, _ = columns
        return Deflected(float(x[0]), float(v[0]), float(z[0]))

    def pieces(self, steps: Any) -> Pieces:
        """Give where each piece of some steps begins, in the order of time."""
        inside = np.isin(self.trail.n, steps) & (self.trail.s > 0.0)
        mode = np.where(self.d[steps] == 0, HOLD, self.d[steps])
        starts = (
            steps, np.zeros(len(steps)), self.x_r[steps], self.v_r[steps],
            self.x_0[steps], mode,
        )  # fmt: skip
        both = [np.concatenate((a, b[inside])) for a, b in zip(starts, self.trail, strict=True)]
        order = np.lexsort((both[1], both[0]))
        return Pieces(*(column[order] for column in both))

    def _scene(self, pieces: Pieces) -> tuple[Any, ...]:
        """What every kernel wants first."""
        waves = waves_of(self.motion, CONSTANT)
        trail = Pieces(*map(held, pieces))
        return self.plant, self.law, waves, self.base, self.motion.dt, trail

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]."""
        dt = self.motion.dt
        lo, hi = int(begin / dt), min(math.ceil(end / dt), len(self.x_r) - 1)
        whole = np.ones(hi - lo, dtype=bool)
        n = self.trail.n
        whole[n[(n >= lo) & (n < hi)] - lo] = False
        whole[0] &= begin <= lo * dt
        whole[-1] &= end >= hi * dt
        sums = self._odd_steps(np.flatnonzero(~whole) + lo, begin, end)
        m, k_x, b = self.plant
        forms = [step_forms(b / m, (k_x + k_t) / m, dt) for k_t in (0.0, self.law.k_t)]
        for at in range(lo, hi, PIECE):
            n = np.flatnonzero(whole[at - lo : at - lo + PIECE]) + at
            sums += self._whole_steps(n[self.d[n] != 0], forms[0])
            sums += self._whole_steps(n[self.d[n] == 0], forms[1])
        u_dd2, u2 = sample_squares(self.motion, begin, end)
        x2, v2, x_dd2, power, rub = sums.tolist()
        return Totals(x2, v2, x_dd2, power, rub, 0.0, u_dd2, u2)

    def _odd_steps(self, steps: Any, begin: float, end: float) -> Floats:
        """Integrate steps that hold a change of mode or an end of the window."""
        pieces = self.pieces(steps)
        last = np.append(np.diff(pieces.n) > 0, True)
        lengths = np.where(last, self.motion.dt, np.roll(pieces.s, -1)) - pieces.s
        rest: tuple[Any, ...] = (held(lengths), begin, end)
        found = integrate_pieces(*(*self._scene(pieces), *rest))
        return np.array(found)

    def _whole_steps(self, n: Any, forms: tuple[Floats, Floats]) -> Floats:
        """Integrate whole steps, all of a yielding contact or all of one that holds."""
        (m, k_x, b), F_fk, k_t = self.plant, self.law.F_fk, self.law.k_t
        squares, way = forms
        x_r, x_0, d = self.x_r[n], self.x_0[n], self.d[n]
        holds = not d.any()
        w, f = ((k_x + k_t) / m, -k_t / m * x_0) if holds else (k_x / m, d * (F_fk / m))
        rows = step_rows(b / m, w, f, x_r, self.v_r[n], self.u_dd[n], self.u_dd[n + 1])
        sums = np.zeros(5)
        sums[:4] = np.einsum("kij,ij->k", squares, rows @ rows.T)
        sums[:3] = np.maximum(sums[:3], 0.0)  # squares, whatever rounding says
        slid = way @ rows
        sums[4] = k_t / F_fk * ((x_r - x_0 + 0.5 * slid) @ slid) if holds else d @ slid
        return sums
