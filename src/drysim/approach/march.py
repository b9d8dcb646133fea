"""The march over samples, block by block: each can be marched again from its first state."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from drysim.approach.events import Codes, Events, Floats
from drysim.approach.points import Points
from drysim.approach.room import empty_log, larger, put_first
from drysim.approach.scene import PER_CALL, beginning, refuse_storm, waves_of
from drysim.core.compiled import held
from drysim.core.events import ROOM, Log
from drysim.core.motion import Samples
from drysim.core.plant import Law, Plant
from drysim.core.samples.march import march
from drysim.core.signal import BLOCK, KEPT
from drysim.core.sines.leap import leap_steps
from drysim.core.state import AnyState
from drysim.core.waves import Waves

PER_EVENT = 16
"""Samples for which room is made for one event at first; what is not written costs nothing."""

Mark = tuple[float, float, int, float]
"""x_r [m], v_r [m/s], direction and relative acceleration [m/s²] at the first sample of a
block. The acceleration matters where v_r is faint; NaN where x_r and v_r determine it."""


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
