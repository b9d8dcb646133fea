"""A motion by series, leg by leg: each can be followed again from its first state."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from drysim.approach.events import Floats
from drysim.approach.marks import Mark, marked, work
from drysim.approach.room import empty_log, empty_trail
from drysim.approach.scene import refuse_storm
from drysim.core.compiled import held
from drysim.core.dynamic_laws.trace import trace
from drysim.core.events import Log
from drysim.core.motion import Samples, Sines
from drysim.core.plant import Dynamic, Plant
from drysim.core.replay import integrate_series, read
from drysim.core.trail import Trail
from drysim.core.waves import Waves

FIRST_LEG, LEG = 1_024, 16_384
"""Steps in the first leg and in a later one: a short motion takes little room, and at the end
of each a kernel hands over, so that an interrupt is heard."""

MOST_KEPT = 64
"""Legs that are kept, some 80 MB; of a longer motion a leg is followed anew when it is asked
for, which costs a microsecond a step."""


class Leg(NamedTuple):
    """One leg: the samples from its first on, its steps, and where each begins [s].

    Times under samples count from the first of the leg, `first` s after the start.
    """

    first: float
    u_dd: Any
    trail: Trail
    begins: Floats


@dataclass(frozen=True, eq=False)
class Course:
    """A motion over intervals of ü to the end of the last, as marks and the latest legs.

    `dt` is the length of an interval [s] and `length` that of the last; `starts` is where the
    legs begin and the last ends [s], `scales` the greatest |x_r|, |v_r| and |z| of each leg
    [m, m/s, m], `memories` what was asked for of what bristles recalled, by time.
    """

    plant: Plant
    law: Dynamic
    motion: Sines | Samples
    waves: Waves
    dt: float
    last: int
    length: float
    marks: list[Mark]
    starts: list[float] = field(default_factory=lambda: [0.0])
    scales: list[tuple[float, ...]] = field(default_factory=list)
    kept: dict[int, Leg] = field(default_factory=dict)
    memories: dict[float, tuple[float, ...]] = field(default_factory=dict)

    def follow(self) -> Log:
        """Follow the motion to its end; gives the events, counted from the start."""
        logs: list[Log] = []
        while self.marks[-1].n <= self.last:
            mark, log = self.go(len(self.marks) - 1)
            self.marks.append(mark)
            self.starts.append(mark.n * self.dt + mark.s)
            logs.append(log)
        return Log(*(np.concatenate(column) for column in zip(*logs, strict=True)))

    def go(self, number: int) -> tuple[Mark, Log]:
        """Follow a leg and keep it; gives the mark at its end and its events."""
        first = self.marks[number].n
        mark, log, trail, base = self.traced(number, self.last, self.length)
        arrays = [np.asarray(column) for column in trail]
        self.keep(number, Leg(first * self.dt, base, trail, arrays[0] * self.dt + arrays[1]))
        if number == len(self.scales):
            self.scales.append(tuple(float(np.abs(column).max()) for column in arrays[2:5]))
        return mark, log

    def traced(self, number: int, last: int, length: float) -> tuple[Mark, Log, Trail, Any]:
        """Follow a leg, at most for `length` [s] of interval `last`; gives what comes of it.

        That is the mark at the end, the events, the steps, and ü besides the waves [m/s²].
        """
        mark, size = self.marks[number], LEG if number else FIRST_LEG
        base = self.base(mark.n, size)
        jet = work(self.law, mark.scale)
        jet.turned[: len(mark.turned)] = mark.turned
        jet.branch[:] = mark.branch
        trail, log = empty_trail(size), empty_log(size)
        n, s, x_r, v_r, z, d, steps, count = trace(
            self.plant, self.law, self.waves, base, self.dt, 0, mark.s, length,
            last - mark.n, *mark.state, jet, trail, 0, log, 0, size,
        )  # fmt: skip
        refuse_storm(count, (mark.n + n) * self.dt + s, (x_r, v_r))
        found = Log(*(np.asarray(column[:count]) for column in log))
        found = found._replace(n=found.n + mark.n)
        trail = Trail(*(column[:steps] for column in trail))
        return marked(mark.n + n, s, (x_r, v_r, z, d), jet), found, trail, base

    def recalled(self, t: float) -> tuple[float, ...]:
        """Give the turns that the bristles remember at time t [s], as deflections [m].

        Within a leg they are found by following it once more as far as that.
        """
        if t >= self.starts[-1]:
            return self.marks[-1].turned
        if t not in self.memories:
            number, n = self.number_at(t), min(int(t / self.dt), self.last)
            mark, within = self.marks[number], t - n * self.dt
            if t > self.starts[number]:
                end = (n, within) if within > 0.0 else (n - 1, self.dt)
                mark = self.traced(number, *end)[0]
            self.memories[t] = mark.turned
        return self.memories[t]

    def base(self, n: int, size: int) -> Any:
        """Give ü besides the waves [m/s²], from sample n on as far as a leg may come."""
        if isinstance(self.motion, Sines):
            return held(np.zeros(2))
        return held(self.motion.u_dd[n : min(n + size, self.last) + 2])

    def keep(self, number: int, leg: Leg) -> None:
        """Keep a leg, in place of another where there are too many."""
        if len(self.kept) >= MOST_KEPT:
            del self.kept[next(iter(self.kept))]
        self.kept[number] = leg

    def number_at(self, t: float) -> int:
        """Give the number of the leg that holds time t [s], at best the one that it begins."""
        return min(max(bisect_right(self.starts, t) - 1, 0), len(self.marks) - 2)

    def leg(self, number: int) -> Leg:
        """Give a leg."""
        if number not in self.kept:
            self.go(number)
        return self.kept[number]

    def read(self, number: int, t: Floats) -> tuple[tuple[Any, ...], Any]:
        """Give x_r, v_r, z and F_f, and the direction, at ascending times of a leg [s]."""
        leg = self.leg(number)
        within = t - leg.first
        first, last = np.searchsorted(leg.begins, (within[0], within[-1]), "right")
        steps = slice(max(int(first) - 1, 0), max(int(last), 1))
        trail = Trail(*(column[steps] for column in leg.trail))
        columns = tuple(held(np.empty(len(t))) for _ in range(4))
        d = held(np.empty(len(t), dtype=np.int64))
        kernel: Any = read
        kernel(*self.scene(leg), trail, held(within), *columns, d)
        return columns, d

    def integrate(self, number: int, begin: float, end: float) -> tuple[float, ...]:
        """Give the integrals over a window of a leg [s]."""
        leg = self.leg(number)
        kernel: Any = integrate_series
        sums: tuple[float, ...] = kernel(
            *self.scene(leg), leg.trail, begin - leg.first, end - leg.first
        )
        return sums

    def scene(self, leg: Leg) -> tuple[Any, ...]:
        """Give what kernels want first to read a leg."""
        return self.plant, self.law, self.waves, leg.u_dd, self.dt, work(self.law, 0.0)
