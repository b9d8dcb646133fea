"""Rate of break-aways from sticking under random base motion, over the plane of two keys.

Problem
    Under noise there is no steady motion whose kind changes at a line: a mass that sticks
    breaks away whenever |ü| happens to exceed F_fs/m. What changes over the plane is how often.

Method
    The motion is solved at every node of a grid and its break-aways are counted. Beside it
    stands Rice's formula: a Gaussian ü leaves a band of ±F_fs/m
    2 ν exp(−(F_fs/m)²/(2 a_u²)) times a second, with its RMS a_u and the rate ν of its upward
    zero crossings. It holds for a mass that sticks most of the time, and with its spring hardly
    loaded: a force s of the spring leaves F_fs − s and F_fs + s, and raises the rate by
    cosh(s F_fs/(m a_u)²) exp(−s²/(2 m² a_u²)). It is given only there (`rice_refusal`). Lines
    of equal rate follow by interpolation of the logarithm along the edges of the grid.

References
----------
.. [1] Rice, Mathematical analysis of random noise, Bell System Technical Journal 24 (1945),
   section 3.3.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from math import exp, log, pi, sqrt
from typing import NamedTuple

import numpy as np

from drysim.approach.solution import Events
from drysim.core.model import Floats, Samples
from drysim.parallel import WorkerPool
from drysim.scenario.axes import KeyRange
from drysim.scenario.model import Scenario
from drysim.study.boundaries import REGIME, Crossing, Crossings, Integers
from drysim.study.case import Case
from drysim.study.preparation import assemble
from drysim.study.run import MotionCache, trajectory_of
from drysim.study.statistics import seed_range, with_seed
from drysim.wording import format_number, format_percent

RICE = "rice"
"""Field of the rate by Rice's formula; the counted rate is the field `REGIME`."""

LEVELS = (0.001, 0.01, 0.1, 1.0, 10.0, 100.0)
"""Rates [1/s] at which lines are drawn, as far as the window has time for one break-away."""

FIRST = 2_000_000
"""Label of rates below the first of the levels; each level adds 1."""


MIN_STUCK_SHARE, MAX_SPRING_LOAD = 0.5, 0.5
"""Where Rice's formula is given: least share of the time that the mass sticks, and largest
s F_fs/(m a_u)² with the RMS s of the spring force while it sticks [-]. Counted rates of random
scenes are then 0.7 to 1.4 times as large, and up to 12 times elsewhere."""


class Rates(NamedTuple):
    """Break-aways per second."""

    counted: float
    """Rate in the motion [1/s]."""
    rice: float | None
    """Rate by Rice's formula [1/s]; None where it does not apply."""
    reason: str = ""
    """Why it does not apply, as a clause; else empty."""

    def __str__(self) -> str:
        """Return both rates as text."""
        counted = f"breaks away {format_number(self.counted, digits=3)} times a second"
        if self.rice is None:
            return f"{counted}; Rice's formula does not apply, as {self.reason}"
        return f"{counted}, {format_number(self.rice, digits=3)} by Rice's formula"


def count_break_aways(events: Events, begin: float, end: float) -> int:
    """Return how often sticking ends in a window [s]."""
    ends = (events.kind[1:] != 0) & (events.kind[:-1] == 0)
    inside = (events.t[1:] >= begin) & (events.t[1:] < end)
    return int(np.count_nonzero(ends & inside))


def rice_rate(motion: Samples, threshold: float) -> float:
    """Return how often |ü| exceeds a threshold per second if it is Gaussian.

    Parameters
    ----------
    motion : Samples
    threshold : float
        F_fs/m [m/s²].

    Returns
    -------
    float
        Rate [1/s]; ν is the RMS of the jerk over 2π a_u.
    """
    u_dd = np.asarray(motion.u_dd)
    first, second = u_dd[:-1], u_dd[1:]
    square = float(np.mean(first * first + first * second + second * second)) / 3.0
    if square == 0.0:
        return 0.0
    nu = sqrt(float(np.mean(np.square(second - first))) / square) / (2.0 * pi * motion.dt)
    return 2.0 * nu * exp(-threshold * threshold / (2.0 * square))


class StuckTime(NamedTuple):
    """Time that a mass sticks [s], and the integral of x_r² over it [m²s]."""

    time: float
    x2: float


def stuck_time(events: Events, begin: float, end: float) -> StuckTime:
    """Return how long a mass sticks in a window [s], and where."""
    from drysim.core.events import STICK  # loads kernels: after the choice of the engine

    ends = np.append(events.t[1:], end)
    times = np.clip(ends, begin, end) - np.clip(events.t, begin, end)
    times = np.where(events.kind == STICK, times, 0.0)
    return StuckTime(float(times.sum()), float(times @ np.square(events.x_r)))


def rice_refusal(case: Case, stuck: StuckTime, length: float) -> str:
    """Return why Rice's formula does not apply to a motion of this length [s]; else nothing."""
    assert isinstance(case.motion, Samples), "only random base motion has rates"
    if stuck.time < MIN_STUCK_SHARE * length:
        return f"the mass sticks only {format_percent(stuck.time / length)} of the time"
    square = float(np.mean(np.square(np.asarray(case.motion.u_dd)))) * case.plant.m**2
    force = case.plant.k_x * sqrt(stuck.x2 / stuck.time)
    if force * case.law.F_fs > MAX_SPRING_LOAD * square:
        return (
            f"the spring bears {format_number(force, 'N', digits=2)} RMS while the mass sticks"
        )
    return ""


def measure_rates(scenario: Scenario, motions: MotionCache) -> Rates:
    """Return the rates of break-aways of a scenario, means over its seeds."""
    counted, length, rice, reasons = 0, 0.0, [], []
    for seed in seed_range(scenario):
        case = assemble(seeded := with_seed(scenario, seed), motions.of(seeded))
        assert isinstance(case.motion, Samples), "only random base motion has rates"
        trajectory = trajectory_of(case, case.start, case.step, case.window[1])
        events = trajectory.events
        counted += count_break_aways(events, *case.window)
        duration = case.window[1] - case.window[0]
        length += duration
        rice.append(rice_rate(case.motion, case.law.F_fs / case.plant.m))
        reasons.append(rice_refusal(case, stuck_time(events, *case.window), duration))
    if reason := next(filter(None, reasons), ""):
        return Rates(counted / length, None, reason)
    return Rates(counted / length, sum(rice) / len(rice))


def describe_label(label: int) -> str:
    """Return the rates with this label as text."""
    number = label - FIRST
    if number == len(LEVELS):
        return f"above {LEVELS[-1]:g} break-aways a second"
    begins = f"{LEVELS[number - 1]:g} to" if number else "up to"
    return f"{begins} {describe_level((label, label + 1))}"


def level_between(labels: tuple[int, int]) -> float:
    """Return the rate at the line between neighbouring labels [1/s]."""
    return LEVELS[max(labels) - FIRST - 1]


def describe_level(labels: tuple[int, int]) -> str:
    """Return the rate at the line between neighbouring labels as text."""
    rate = level_between(labels)
    return f"{rate:g} break-away{'s' * (rate != 1.0)} a second"


class RatePlane:
    """Counts break-aways at points of the plane.

    Parameters
    ----------
    case : Case
        Under random base motion, with Coulomb friction.
    axes : sequence of KeyRange
        Both axes.
    pool : WorkerPool
    advance : callable
        Called with the number of solved nodes of the grid.

    Attributes
    ----------
    cases : int
        Number of points solved so far.
    """

    fields = (REGIME, RICE)

    def __init__(
        self,
        case: Case,
        axes: Sequence[KeyRange],
        pool: WorkerPool,
        advance: Callable[[int], None],
    ) -> None:
        self.scenario = case.scenario.copy_with({"sweep": (), "reference": None})
        self.axes, self.pool, self.advance = axes, pool, advance
        self.motions = MotionCache.starting_with(case)
        self.cases = 0
        begin, end = case.window
        self.once = 1.0 / ((end - begin) * len(seed_range(case.scenario)))

    def net(self, points: Floats, edges: Integers, counted: bool = False) -> RateNet:
        """Return points of shape (n, 2), as shares of the axes, with their rates."""
        values = [axis.value(points[:, i]).tolist() for i, axis in enumerate(self.axes)]
        keys = [axis.key for axis in self.axes]
        scenarios = (
            self.scenario.at(dict(zip(keys, point, strict=True)))
            for point in zip(*values, strict=True)
        )
        solved = []
        solve = partial(measure_rates, motions=self.motions)
        for rates in self.pool.map_in_order(solve, [*scenarios], (self.motions,)):
            solved.append(rates)
            self.advance(int(counted))
        self.cases += len(points)
        return RateNet(points, edges, solved, self.once)


class RateNet:
    """Nodes with their rates, and the edges between them.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Nodes, as shares of the axes.
    edges : ndarray, shape (m, 2)
        Numbers of the nodes at both ends.
    rates : sequence of Rates
        Of each node.
    once : float
        Rate of one break-away in the window [1/s]; no lines are drawn below it.
    """

    def __init__(
        self, points: Floats, edges: Integers, rates: Sequence[Rates], once: float
    ) -> None:
        self.points, self.edges, self.rates_of_nodes = points, edges, rates
        columns = [[node.counted for node in rates], [node.rice for node in rates]]
        self.rates = dict(zip((REGIME, RICE), np.array(columns, dtype=float), strict=True))
        lowest = int(np.searchsorted(LEVELS, once))
        self.labels: Mapping[str, Integers] = {
            field: FIRST + np.maximum(np.searchsorted(LEVELS, column, "right"), lowest)
            for field, column in self.rates.items()
        }
        self.least = 0.5 * once  # stands for none in the window: the logarithm needs a number

    def crossings(self, field: str) -> Crossings:
        """Return the lines of equal rate on all edges both ends of which have one."""
        labels, logarithms = (
            self.labels[field],
            np.log(np.maximum(self.rates[field], self.least)),
        )
        a, b = self.edges.T
        both = np.isfinite(logarithms[a]) & np.isfinite(logarithms[b])
        differ = np.flatnonzero((labels[a] != labels[b]) & both)
        return {
            edge: list(crossings_between(logarithms[ends].tolist(), labels[ends].tolist()))
            for edge, ends in zip(differ.tolist(), self.edges[differ], strict=True)
        }


def crossings_between(
    logarithms: tuple[float, float], labels: tuple[int, int]
) -> Iterator[Crossing]:
    """Yield the levels between two nodes, in order."""
    begin, end = logarithms
    step = 1 if end > begin else -1
    for before in range(*labels, step):
        level = log(level_between((before, before + step)))
        yield Crossing((level - begin) / (end - begin), before, before + step, 0.0)
