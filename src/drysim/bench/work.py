"""The work that all entries of a bench do: the first samples of one scene, from its start.

An entry is one approach with one setting, ready to be timed; a peer gives entries of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import pi, sin, tau
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from drysim.core.model import Samples, Sines, base_acceleration
from drysim.study.case import prepare
from drysim.study.statistics import unused_seeds_warnings

if TYPE_CHECKING:
    from drysim.approach.solution import Floats, Response, Trajectory
    from drysim.core.model import AnyLaw, Plant, State
    from drysim.errors import WarningMessage
    from drysim.scenario.model import Scenario


POINTS_PER_PERIOD = 64
"""Points in a period of the fastest sine among which the extrema of ü are looked for."""

MAX_EXTREMUM_POINTS = 4_000_000
"""How many there are at most: as many as periods of a sine that the grid does not resolve."""

BISECTIONS = 50
"""Bisections after which the instant of an extremum is known to rounding."""


class Answer(NamedTuple):
    """What an entry gives on the grid of the work.

    Attributes
    ----------
    x_r, v_r : ndarray, shape (n + 1,)
        Relative displacement [m] and velocity [m/s].
    friction : callable
        Gives F_f [N], shape (n + 1,); called when the clock has stopped.
    response : Response or None
        The whole of it, from an entry of drysim's own.
    stops : int or None
        How many times the mass came to a stop, where the entry counts that.
    """

    x_r: Floats
    v_r: Floats
    friction: Callable[[], Floats]
    response: Response | None = None
    stops: int | None = None

    @property
    def trajectory(self) -> Trajectory | None:
        """The solution between the samples, where the entry keeps one."""
        return None if self.response is None else self.response.trajectory

    @property
    def error(self) -> float | None:
        """Bound of the error of x_r relative to its peak [-], where the entry states one."""
        return None if self.response is None else self.response.numerics.error


@dataclass(frozen=True, eq=False)
class Work:
    """A scene with its base motion, cut to a number of samples.

    Attributes
    ----------
    scenario : Scenario
        Where it came from.
    plant, law, motion, start
        The scene; its law is the full one, which not every approach can use.
    step : float
        Distance of the samples [s].
    samples : int
        Steps from t = 0 on.
    cautions : tuple of Caution
        What is to be said about the scene.
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
        """Last instant [s]."""
        return self.samples * self.step

    @cached_property
    def grid(self) -> Floats:
        """Instants of the samples [s], shape (samples + 1,)."""
        return np.arange(self.samples + 1, dtype=np.float64) * self.step

    @cached_property
    def u_dd(self) -> Floats:
        """Base acceleration on the grid [m/s²], shape (samples + 1,)."""
        if isinstance(self.motion, Samples):
            return self.motion.u_dd[: self.samples + 1]
        return base_acceleration(self.motion, self.grid)

    @cached_property
    def extrema(self) -> tuple[Floats, Floats]:
        """Instants [s] between which ü is monotone, and ü there [m/s²].

        Those of the samples, or the extrema of the sines and both ends.
        """
        if isinstance(self.motion, Samples):
            return self.grid, self.u_dd
        A, f, phase = self.motion
        # A cosine is a sine a quarter of a period ahead.
        rate = Sines(
            tuple(tau * one * of for one, of in zip(A, f, strict=True)),
            f,
            tuple(0.5 * pi + one for one in phase),
        )
        points = int(min(self.end * max(f) * POINTS_PER_PERIOD, MAX_EXTREMUM_POINTS))
        t = np.linspace(0.0, self.end, points + 2)
        rises = base_acceleration(rate, t) > 0.0
        turns = np.flatnonzero(rises[1:] != rises[:-1])
        low, high, rose = t[turns], t[turns + 1], rises[turns]
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
        """Give the base acceleration at one instant [m/s²]."""
        if isinstance(self.motion, Sines):
            total = 0.0
            for A, omega, phase in self.sines:
                total += A * sin(omega * t + phase)
            return total
        n = min(int(t / self.step), len(self.motion.u_dd) - 2)
        share, u_dd = t / self.step - n, self.motion.u_dd[n : n + 2]
        return float((1.0 - share) * u_dd[0] + share * u_dd[1])

    def first(self, samples: int) -> Work:
        """Give the same work cut to fewer samples."""
        if samples >= self.samples:
            return self
        return replace(self, samples=samples, motion=truncate(self.motion, samples))

    def acceleration(self, answer: Answer) -> Floats:
        """Give the absolute acceleration of an answer [m/s²], shape (n + 1,)."""
        m, k_x, b = self.plant
        x_dd: Floats = -(k_x * answer.x_r + b * answer.v_r + answer.friction()) / m
        return x_dd


def make_work(scenario: Scenario, samples: int) -> Work:
    """Give the work of a scenario: its motion from the start, at most so many samples.

    Raises
    ------
    ScenarioError, RecordError, UsageError
        As `drysim.study.case.prepare` does.
    """
    case = prepare(scenario, compared=True)
    if isinstance(case.motion, Samples):
        samples = min(samples, len(case.motion.u_dd) - 1)
    scene = (case.plant, case.law, truncate(case.motion, samples), case.start)
    all_warnings = (*case.warnings, *unused_seeds_warnings(case.scenario))
    return Work(case.scenario, *scene, case.step, samples, all_warnings)


def truncate(motion: Sines | Samples, samples: int) -> Sines | Samples:
    """Give the beginning of a motion; of samples without u, which no entry is asked about."""
    if isinstance(motion, Sines):
        return motion
    return Samples(np.ascontiguousarray(motion.u_dd[: samples + 1]), motion.dt)


Run = Callable[[], Answer]
"""The timed part: everything that can be made beforehand has been made."""


@dataclass(frozen=True, eq=False)
class Entry:
    """One approach with one setting.

    Attributes
    ----------
    approach : str
        Name on the shelf, or of the peer.
    setting : str
        What sets this entry apart from others of its approach.
    ready : callable
        Gives the timed part for a work: compiles, allocates and cuts beforehand.
    step : float or None
        Step of its march [s]; None where it chooses its own.
    points : int
        Points that it computes for a sample.
    own : bool
        Whether it stands on drysim's shelf.
    lacks : tuple of str
        What of the scene it leaves out.
    """

    approach: str
    setting: str
    ready: Callable[[Work], Run]
    step: float | None = None
    points: int = 1
    own: bool = False
    omitted: tuple[str, ...] = ()


class Peer(Protocol):
    """Another program on the same work, e.g. a module: what people would take else."""

    def entries(self, work: Work) -> Iterator[Entry]:
        """Give its entries on a work, each with one setting."""
