"""Exact solution of Coulomb friction: event by event under sines, step by step over samples.

Under sines a motion is known from event to event, without a grid, and so are its periodic
orbits. Over samples it is marched block by block and known at every sample and every event
between: long ones keep a state for each block, from which it can be marched again.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.approach.scene import (
    LOG_LENGTH,
    PER_CALL,
    UnderSines,
    beginning,
    empty_log,
    grid_points,
    larger,
    last_needed,
    longer,
    numerics,
    put_first,
    refuse_storm,
    run_length,
    squares_of_base,
    wave_values,
    waves_of,
)
from drysim.approach.solution import (
    Codes,
    Events,
    Floats,
    Located,
    Numerics,
    Orbit,
    Points,
    Response,
    Sliding,
    Track,
)
from drysim.core import orbit
from drysim.core.compile import held
from drysim.core.events import ROOM, Log, direction
from drysim.core.forcing import REST, STRIDE, V_R, Waves
from drysim.core.march import leap, leap_off, leap_steps
from drysim.core.model import (
    BLOCK,
    KEPT,
    AnyState,
    Law,
    Plant,
    Samples,
    Sines,
    State,
    Totals,
    sample_squares,
)
from drysim.core.sampled import march
from drysim.core.trajectory import (
    PAIRS,
    integrals,
    integrate_leaps,
    integrate_steps,
    room,
    sample_leaps,
    state_within,
    step_forms,
    step_rows,
)


def solve(
    plant: Plant,
    law: Law,
    motion: Sines | Samples,
    start: AnyState,
    step: float,
    duration: float | None,
    whole: bool,
) -> Response:
    """Solve a scene, to be had on its grid.

    `whole` keeps the motion over samples at hand, however long it is.
    """
    if isinstance(motion, Sines):
        track = follow_sines(plant, law, motion, start, run_length(motion, duration))
        n = grid_points(track.end, step)
        how = partial(numerics, law, motion, n, track.turns, track.closest)
        grid = Leaps(track, step, n)
        response = Response(plant, law, motion, grid, track.turns, how, track)
    else:
        response = solve_samples(plant, law, motion, start, duration, whole)
    return response if law.F_fs > 0.0 else frictionless(response)


def follow(
    plant: Plant, law: Law, motion: Sines | Samples, start: AnyState, duration: float | None
) -> Track:
    """Solve a scene without a grid where it can."""
    if isinstance(motion, Sines):
        return follow_sines(plant, law, motion, start, run_length(motion, duration))
    response = solve_samples(plant, law, motion, start, duration, whole=False)
    assert response.track is not None, "samples are solved with their track"
    return response.track


def frictionless(response: Response) -> Response:
    """Give the response of a scene without dry friction: turning points are not events then."""
    events = response.events
    begin = Events(events.t[:1], np.sign(events.kind[:1]), events.x_r[:1], events.F_L[:1])
    grid, how = Sliding(response.grid), partial(viscous_numerics, response)
    return replace(response, grid=grid, events=begin, how=how)


def viscous_numerics(response: Response) -> Numerics:
    """Give how the numbers of a response were made, where there is no dry friction."""
    why = "no dry friction: the same flow, with turning points for the peaks only"
    return replace(
        response.numerics, approach="viscous", why=why, events=1, closest_decision=None
    )


# Under sines: from event to event, on any grid.


LEAPS = 1_000_000
"""Events that a kernel may find before it hands over, so that an interrupt is heard."""

FEW_EVENTS = 1024
"""Events that there is room for at first; room is doubled as it fills."""


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
        squares = squares_of_base(self.motion, waves, begin, end)
        return Totals(x2, v2, x_dd2, power, rub, stuck, *squares)


@dataclass(frozen=True, eq=False)
class Leaps(UnderSines):
    """The points of a `LeapTrack`."""

    def part(self, first: int, last: int) -> Points:
        """Give the points from number `first` to the one before `last`."""
        track, turns, n = self.track, self.track.turns, last - first
        out, d = held(np.empty((2, n))), held(np.empty(n, np.int8))
        sample_leaps(
            track.scene, held(turns.t), held(turns.kind), held(turns.x_r), first, self.dt,
            held(np.empty(room(track.size))), out, d,
        )  # fmt: skip
        x_r, v_r = np.asarray(out)
        return Points(x_r, v_r, np.asarray(d, dtype=np.int8))


# Periodic orbits under sines.


MOST_PERIODS = 5_000
"""Periods after which a scene counts as not settled."""


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
        The columns that `drysim.core.orbit.solve_orbits` names.

    Returns
    -------
    ndarray, shape (n, FOUND)
        The columns of its answers.
    """
    answers = held(np.full((len(scenes), orbit.FOUND), np.nan))
    room = (scenes.shape[1] - orbit.SINES) // 3 + 1
    orbit.solve_orbits(
        held(np.ascontiguousarray(scenes)), answers, held(np.zeros(STRIDE * room)), *pasts(),
        MOST_PERIODS, empty_log(LOG_LENGTH), LOG_LENGTH,
    )  # fmt: skip
    return np.asarray(answers)


def pasts() -> tuple[Any, Any]:
    """Give room for the states of the latest periods."""
    return held(np.zeros(orbit.MOST_MULTIPLE)), held(np.zeros(orbit.MOST_MULTIPLE))


# Over samples: known at every sample and at every event between.


PER_EVENT = 16
"""Samples for which room is made for one event at first; what is not written costs nothing."""

PIECE = 16_384
"""Steps integrated at a time: so few that no linear algebra starts threads for them."""

Numbers = NDArray[np.intp]

Mark = tuple[float, float, int, float]
"""x_r [m], v_r [m/s], direction and relative acceleration [m/s²] at the first sample of a
block. The acceleration matters where v_r is faint; NaN where x_r and v_r determine it."""


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


@dataclass(frozen=True, eq=False)
class Marched:
    """The points of a march, as a grid of some length."""

    march: March
    length: int

    @property
    def dt(self) -> float:
        """Distance of the points [s]."""
        return self.march.motion.dt

    def __len__(self) -> int:
        """Give their number."""
        return self.length

    def base(self, first: int, last: int) -> Floats:
        """Give ü [m/s²] from point number `first` to the one before `last`."""
        return self.march.motion.u_dd[first:last]

    def part(self, first: int, last: int) -> Points:
        """Give the points from number `first` to the one before `last`."""
        block = self.march.holding(first)
        if last - block.first <= len(block.d):
            points = Points(block.x_r, block.v_r, block.d)
            return points.cut(slice(first - block.first, last - block.first))
        n = last - first
        found = Points(np.empty(n), np.empty(n), np.empty(n, np.int8))
        for block in self.march.blocks(first, last):
            begin, end = max(first, block.first), min(last, block.first + len(block.d))
            here = slice(begin - first, end - first)
            there = slice(begin - block.first, end - block.first)
            found.x_r[here], found.v_r[here] = block.x_r[there], block.v_r[there]
            found.d[here] = block.d[there]
        return found


# The march over samples, block by block.


def march_samples(
    plant: Plant, law: Law, motion: Samples, start: AnyState, last: int, whole: bool
) -> tuple[March, Events, float]:
    """March to sample `last`; gives also the events and the tightest decision.

    `whole` keeps all of a march however long it is.
    """
    entry, closest = beginning(plant, law, motion, start)
    size = max(last, 1) if whole or last <= KEPT else BLOCK
    mark = (start.x_r, start.v_r, entry.kind, math.nan)
    made = March(plant, law, motion, waves_of(motion, law), last, size, [])
    turns = []
    for number in range(max(1, -(-last // size))):
        made.marks.append(mark)
        mark, tight = made.go(number)
        closest = min(closest, tight)
        block = made.latest[number]
        n, s, *rest = (column[number > 0 :] for column in block.log)
        t = np.add(n, float(block.first))
        t *= motion.dt
        t += s
        turns.append((t, *rest))
    joined = (np.concatenate(column) for column in zip(*turns, strict=True))
    t, kind, x_r, F_L = joined if len(turns) > 1 else turns[0]
    return made, Events(t, kind.astype(np.int8), x_r, F_L), closest


class Block(NamedTuple):
    """The solution from sample `first` on: one value a sample, shape (n,), and its events.

    The last sample is the first one of the next block. `log` counts from `first` and begins
    with the state there.
    """

    first: int
    u_dd: Floats
    x_r: Floats
    v_r: Floats
    d: Codes
    log: Log


@dataclass(frozen=True, eq=False)
class March:
    """A march to sample `last` that keeps a state for every block, and the latest block.

    Notes
    -----
    A block is a whole number of stretches of the core's march, so one that is marched again is
    the same to the last bit. What is to be kept whole is one block.
    """

    plant: Plant
    law: Law
    motion: Samples
    waves: Waves
    last: int
    size: int
    marks: list[Mark]
    latest: dict[int, Block] = field(default_factory=dict)

    def block(self, number: int) -> Block:
        """Give a block."""
        if number not in self.latest:
            self.go(number)
        return self.latest[number]

    def holding(self, n: int) -> Block:
        """Give the block of a sample, at best the one that it begins."""
        return self.block(min(n // self.size, len(self.marks) - 1))

    def blocks(self, first: int, last: int) -> Iterator[Block]:
        """Give the blocks that hold the steps from sample `first` to sample `last`."""
        numbers = range(first // self.size, min(-(-last // self.size), len(self.marks)))
        return map(self.block, numbers)

    def go(self, number: int) -> tuple[Mark, float]:
        """March through a block; gives the state at its end and the tightest decision."""
        first, state, closest = number * self.size, self.marks[number], math.inf
        last = min(first + self.size, self.last) - first
        u_dd = self.motion.u_dd[first : first + last + 1]
        # One piece of memory, so that the next march of this length finds it at hand again.
        x_r, v_r = held(np.empty((2, last + 1)))
        d = held(np.empty(last + 1, dtype=np.int8))
        x_r[0], v_r[0], d[0], _ = state
        given, n, count = held(u_dd), 0, 1
        log = empty_log(4 * ROOM + last // PER_EVENT)
        F_L = self.plant.m * float(u_dd[0]) + self.plant.k_x * state[0]
        put_first(log, (0, 0.0, state[2], state[0], F_L))
        while n < last:
            if count > len(log.n) - ROOM:
                log = larger(log, 2 * len(log.n))
            until, capacity = min(n + PER_CALL, last), len(log.n)
            plant, law, dt = self.plant, self.law, self.motion.dt
            out = x_r, v_r, d, log, count, capacity
            rest: tuple[Any, ...]
            if law.variation:
                rest = n, until, *state[:3], *out
                n, *end, count, tight = leap_steps(
                    plant, law, self.waves, first, given, dt, *rest
                )
                state = (*end, math.nan)
            else:
                rest = n, until, *state, *out
                n, *end, count, tight = march(plant, law, given, dt, *rest)
                state = tuple(end)
            closest = min(closest, tight)
            refuse_storm(count, (first + n) * self.motion.dt, state, self.motion.dt)
        series = (np.asarray(x_r), np.asarray(v_r), np.asarray(d, dtype=np.int8))
        self.latest.clear()
        self.latest[number] = Block(
            first, u_dd, *series, Log(*(np.asarray(column[:count]) for column in log))
        )
        return state, closest
