"""Exact solution of elastic contacts: Jenkins and Petrov-Ewins elements.

The contact is a spring until it yields. Under sines, or with a normal force that swings, a
motion is followed as `piecewise` does; how it turns while the contact holds is told by kernels
where it is asked for, and its grid is made of tables. Over samples a contact of constant limit
is known at every sample and change of mode, and whole steps are integrated by forms.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from drysim.approach import piecewise
from drysim.approach.scene import (
    CONSTANT,
    PER_CALL,
    UnderSines,
    empty,
    empty_log,
    grid_points,
    larger,
    last_needed,
    numerics,
    put_first,
    refuse_storm,
    run_length,
    waves_of,
)
from drysim.approach.solution import (
    Codes,
    Events,
    Floats,
    Held,
    Located,
    Path,
    Points,
    Response,
    of_log,
)
from drysim.core.compile import held
from drysim.core.events import ROOM, Pieces
from drysim.core.model import (
    AnyState,
    Deflected,
    Plant,
    Samples,
    Sines,
    Slider,
    Totals,
    sample_squares,
)
from drysim.core.modes import HOLD, first_contact
from drysim.core.oscillator import whole_steps
from drysim.core.sampled import march_joint
from drysim.core.trajectory import (
    integrate_pieces,
    read_contact,
    room,
    sample_contact,
    step_forms,
    step_rows,
    tell,
    tell_steps,
)


def solve(
    plant: Plant,
    law: Slider,
    motion: Sines | Samples,
    start: AnyState,
    step: float,
    duration: float | None,
) -> Response:
    """Solve a scene and write it on its grid."""
    track = follow(plant, law, motion, start, duration)
    if isinstance(track, Jointed):
        return on_samples(track)
    if isinstance(motion, Samples):
        return piecewise.on_grid(track, step)
    return piecewise.responding(track, Touches(track, step, grid_points(track.end, step)))


def follow(
    plant: Plant,
    law: Slider,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> Touched | Jointed:
    """Solve a scene from t = 0 to `duration` [s], or to the end of the samples."""
    if isinstance(motion, Samples) and not law.variation:
        return follow_joints(plant, law, motion, start, duration)
    return piecewise.follow_as(Touched, plant, law, motion, start, duration)


# Under sines, or with a normal force that swings: known from mode to mode.


@dataclass(frozen=True, eq=False)
class Touched(piecewise.Traced):
    """A solution known from mode to mode; how it turns within one is found where asked for."""

    law: Slider

    def path(self, window: tuple[float, float], x_rM: float | None) -> Path:
        """Give the points of x_r that tell all of its way in a window [s]."""
        begins = self._begins
        lengths = held(np.append(np.diff(begins), self.end - begins[-1]))
        at = (0, 0.0, 0.0, 0.0, 0.0)
        return all_told(tell, (*self.scene, lengths), whole_pieces(begins, window), x_rM, at)

    @property
    def series(self) -> tuple[Floats, ...]:
        """What each component of the state came to along the way."""
        return self.path((0.0, self.end), None).x_r, self.trail.v_r, self.trail.z


@dataclass(frozen=True, eq=False)
class Touches(UnderSines):
    """The points of such a solution under sines."""

    def part(self, first: int, last: int) -> Points:
        """Give the points from number `first` to the one before `last`."""
        plant, law, waves, _, _, trail = self.track.scene
        n, size = last - first, room(waves.size)
        x_r, v_r, F_f = (held(np.empty(n)) for _ in range(3))
        d, bare, sprung = held(np.empty(n, dtype=np.int8)), *map(held, np.empty((2, size)))
        sample_contact(plant, law, waves, trail, first, self.dt, bare, sprung, x_r, v_r, F_f, d)
        states = (np.asarray(x_r), np.asarray(v_r), np.asarray(d, dtype=np.int8))
        return Points(*states, np.asarray(F_f))


# A contact of constant limit over samples: known at every sample and change of mode.


PIECE = 8_192
"""Steps integrated at a time: a dot product of more than 10,000 numbers would start threads,
which takes longer than all the rest."""

FEW_EVENTS = 0.1
"""Events a sample that there is room for at first."""


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


def follow_joints(
    plant: Plant, law: Slider, motion: Samples, start: AnyState, duration: float | None
) -> Jointed:
    """Solve a scene as `follow` does, of constant limit and over samples."""
    end = run_length(motion, duration)
    _, last = last_needed(motion, end)
    u_dd = motion.u_dd[: last + 1]
    x_r, v_r = held(np.empty((2, last + 1)))
    d = held(np.empty(last + 1, dtype=np.int8))
    x_0 = start[2] if len(start) > 2 else start.x_r
    mode, x_0 = first_contact(law, start.x_r, start.v_r, x_0)
    x_r[0], v_r[0], d[0] = start.x_r, start.v_r, mode
    room = int(FEW_EVENTS * last) + 4 * ROOM
    trail, log = empty(Pieces, room), empty_log(room)
    put_first(trail, (0, 0.0, start.x_r, start.v_r, x_0, mode))
    F_L = plant.m * float(u_dd[0]) + plant.k_x * start.x_r
    put_first(log, (0, 0.0, mode, start.x_r, F_L))
    given, n, used, count = held(u_dd), 0, 1, 1
    state: tuple[Any, ...] = (start.x_r, start.v_r, x_0, mode)
    while n < last:
        if max(used, count) > len(trail.n) - ROOM:
            trail, log = (larger(kept, 2 * len(kept[0])) for kept in (trail, log))
        until, written = min(n + PER_CALL, last), (x_r, v_r, d, trail, used, log, count)
        rest: tuple[Any, ...] = (n, until, *state, *written)
        n, *moved, used, count = march_joint(plant, law, given, motion.dt, *rest)
        state = tuple(moved)
        refuse_storm(count, n * motion.dt, state)
    trail = Pieces(*(np.asarray(column[:used]) for column in trail))
    events = of_log(log, count, motion.dt).until(end)
    series = np.asarray(x_r), np.asarray(v_r), np.asarray(d, dtype=np.int8)
    return Jointed(plant, law, motion, u_dd, *series, trail, events, end)


def on_samples(track: Jointed) -> Response:
    """Give a solution over samples on their own grid, whatever the step."""
    plant, law, motion = track.plant, track.law, track.motion
    n = grid_points(track.end, motion.dt)
    x_r, v_r, d = track.x_r[:n], track.v_r[:n], track.d[:n]
    F_f = law.k_t * (x_r - track.x_0[:n])
    np.multiply(d, law.F_fk, out=F_f, where=d != 0)
    heading = np.where(v_r < 0.0, np.int8(-1), np.int8(1))
    how = partial(numerics, law, motion, n, track.events, math.inf)
    grid = Held(motion.dt, track.u_dd[:n], Points(x_r, v_r, heading, F_f))
    return Response(plant, law, motion, grid, track.events, how, track)


# The path, as kernels tell it where it is asked for.


EVENT_ROOM = 1024
"""Points that there is room for besides the beginnings of pieces, before there is more."""


def all_told(
    kernel: Callable[..., Any],
    scene: tuple[Any, ...],
    whole: Codes,
    x_rM: float | None,
    at: tuple[Any, ...],
) -> Path:
    """Give the path that a kernel tells of a scene, from its beginning `at` on."""
    limit = math.inf if x_rM is None else x_rM
    parts, pieces, given = [], len(whole), held(whole)
    while at[0] < pieces:
        t, x_r = held(np.empty((2, EVENT_ROOM + pieces)))
        at, count = kernel(*scene, given, limit, at, t, x_r)
        parts.append((np.asarray(t[:count]), np.asarray(x_r[:count])))
    columns = parts[0] if len(parts) == 1 else map(np.concatenate, zip(*parts, strict=True))
    return Path(*columns)


def whole_pieces(begins: Floats, window: tuple[float, float]) -> Codes:
    """Tell of which pieces all is wanted: the last one, and those that a window cuts."""
    whole = np.zeros(len(begins), dtype=np.int8)
    whole[np.searchsorted(begins, window, "right") - 1] = 1
    whole[-1] = 1
    return whole
