"""The task of all entries of a benchmark: the first samples of a scene, from its start.

An entry is an approach with one setting. A peer is another program that yields entries.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import pi, sin, tau
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from drysim.core.model import Samples, Sines, base_acceleration
from drysim.study.preparation import prepare
from drysim.study.statistics import unused_seeds_warnings

if TYPE_CHECKING:
    from drysim.approach.solution import Response, Trajectory
    from drysim.core.model import AnyLaw, Floats, Plant, State
    from drysim.errors import WarningMessage
    from drysim.scenario.model import Scenario


POINTS_PER_PERIOD = 64
"""Points per period of the highest frequency, between which extrema of ü are bracketed."""

MAX_EXTREMUM_POINTS = 4_000_000
"""Maximum number of these points, for sines that the grid does not resolve."""

BISECTIONS = 50
"""Bisections that locate an extremum to rounding."""


class Answer(NamedTuple):
    """Solution of an entry on the grid of the work.

    Attributes
    ----------
    x_r, v_r : ndarray, shape (n + 1,)
        Relative displacement [m] and velocity [m/s].
    friction : callable
        Returns F_f [N], shape (n + 1,); called outside the timing.
    response : Response or None
        Full response, from drysim's own entries.
    stops : int or None
        Number of times v_r reached zero, if the entry counts them.
    """

    x_r: Floats
    v_r: Floats
    friction: Callable[[], Floats]
    response: Response | None = None
    stops: int | None = None

    @property
    def trajectory(self) -> Trajectory | None:
        """Solution between the samples, if the entry has one."""
        return None if self.response is None else self.response.trajectory

    @property
    def error(self) -> float | None:
        """Estimated error of x_r relative to its peak [-], if the entry has one."""
        return None if self.response is None else self.response.numerics.error


@dataclass(frozen=True, eq=False)
class Work:
    """A scene with its base motion, truncated to a number of samples.

    Attributes
    ----------
    scenario : Scenario
        The scenario of the scene.
    plant, law, motion, start
        The scene, with its full law; some approaches support only a part of it.
    step : float
        Sampling interval [s].
    samples : int
        Number of steps from t = 0 on.
    warnings : tuple of WarningMessage
        Warnings about the scene.
    """

    scenario: Scenario
    plant: Plant
    law: AnyLaw
    motion: Sines | Samples
    start: State
    step: float
    samples: int
    warnings: tuple[WarningMessage, ...] = ()

    @property
    def end(self) -> float:
        """Time of the last sample [s]."""
        return self.samples * self.step

    @cached_property
    def grid(self) -> Floats:
        """Times of the samples [s], shape (samples + 1,)."""
        return np.arange(self.samples + 1, dtype=np.float64) * self.step

    @cached_property
    def u_dd(self) -> Floats:
        """Base acceleration on the grid [m/s²], shape (samples + 1,)."""
        if isinstance(self.motion, Samples):
            return self.motion.u_dd[: self.samples + 1]
        return base_acceleration(self.motion, self.grid)

    @cached_property
    def extrema(self) -> tuple[Floats, Floats]:
        """Times [s] between which ü is monotone, and ü at these times [m/s²].

        The samples of a record; of sines the extrema and both ends.
        """
        if isinstance(self.motion, Samples):
            return self.grid, self.u_dd
        A, f, phase = self.motion
        # The derivative of a sine is a sine a quarter of a period ahead.
        rate = Sines(
            tuple(tau * value * of for value, of in zip(A, f, strict=True)),
            f,
            tuple(0.5 * pi + value for value in phase),
        )
        points = int(min(self.end * max(f) * POINTS_PER_PERIOD, MAX_EXTREMUM_POINTS))
        t = np.linspace(0.0, self.end, points + 2)
        rises = base_acceleration(rate, t) > 0.0
        changes = np.flatnonzero(rises[1:] != rises[:-1])
        low, high, rose = t[changes], t[changes + 1], rises[changes]
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            before = (base_acceleration(rate, middle) > 0.0) == rose
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        t = np.concatenate(([0.0], high, [self.end]))
        return t, base_acceleration(self.motion, t)

    @cached_property
    def sines(self) -> tuple[tuple[float, float, float], ...]:
        """Amplitude [m/s²], angular frequency [rad/s] and phase of every sine."""
        if not isinstance(self.motion, Sines):
            return ()
        return tuple((A, tau * f, phase) for A, f, phase in zip(*self.motion, strict=True))

    def base(self, t: float) -> float:
        """Return the base acceleration at a time [m/s²]."""
        if isinstance(self.motion, Sines):
            total = 0.0
            for A, omega, phase in self.sines:
                total += A * sin(omega * t + phase)
            return total
        n = min(int(t / self.step), len(self.motion.u_dd) - 2)
        share, u_dd = t / self.step - n, self.motion.u_dd[n : n + 2]
        return float((1.0 - share) * u_dd[0] + share * u_dd[1])

    def first(self, samples: int) -> Work:
        """Return the work truncated to fewer samples."""
        if samples >= self.samples:
            return self
        return replace(self, samples=samples, motion=truncate(self.motion, samples))

    def acceleration(self, answer: Answer) -> Floats:
        """Return the absolute acceleration of an answer [m/s²], shape (n + 1,)."""
        m, k_x, b = self.plant
        x_dd: Floats = -(k_x * answer.x_r + b * answer.v_r + answer.friction()) / m
        return x_dd


def make_work(scenario: Scenario, samples: int) -> Work:
    """Return the work of a scenario with at most `samples` samples from the start.

    Raises
    ------
    ScenarioError, RecordError, UsageError
        From `drysim.study.preparation.prepare`.
    """
    case = prepare(scenario, compared=True)
    if isinstance(case.motion, Samples):
        samples = min(samples, len(case.motion.u_dd) - 1)
    scene = (case.plant, case.law, truncate(case.motion, samples), case.start)
    all_warnings = (*case.warnings, *unused_seeds_warnings(case.scenario))
    return Work(case.scenario, *scene, case.step, samples, all_warnings)


def truncate(motion: Sines | Samples, samples: int) -> Sines | Samples:
    """Return the first samples of a motion; of a record without u, which no entry needs."""
    if isinstance(motion, Sines):
        return motion
    return Samples(np.ascontiguousarray(motion.u_dd[: samples + 1]), motion.dt)


Run = Callable[[], Answer]
"""The timed part of an entry, without preparation."""


@dataclass(frozen=True, eq=False)
class Entry:
    """An approach with one setting.

    Attributes
    ----------
    approach : str
        Name of the approach or of the peer.
    setting : str
        Setting that distinguishes entries of the same approach.
    ready : callable
        Prepares a work (compiles, allocates, refines the grid) and returns the timed part.
    step : float or None
        Time step [s]; None if adaptive.
    points : int
        Number of computed points per sample.
    by_drysim : bool
        Whether it is an approach of drysim.
    other_law : bool
        Whether it solves another law than that of the scene.
    """

    approach: str
    setting: str
    ready: Callable[[Work], Run]
    step: float | None = None
    points: int = 1
    by_drysim: bool = False
    other_law: bool = False


class Peer(Protocol):
    """Another program on the same work, for example a module with a function `entries`."""

    def entries(self, work: Work) -> Iterator[Entry]:
        """Yield the entries of this program on a work."""
