"""Response: what every approach gives. Plain values; knows no file and no metric."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from drysim.approach.events import Codes, Events, Floats
from drysim.core.motion import Samples, Sines
from drysim.core.plant import AnyLaw, AnyState, Law, Plant, Totals

FIXED_STEP = "step"
"""The core of the approaches that locate no event."""


@dataclass(frozen=True)
class Numerics:
    """How the numbers were made.

    Attributes
    ----------
    approach : str
        Name on the shelf.
    core : str
        Which core solved the scene.
    why : str
        Why that core: a sentence.
    engine : str
        `plain` or `compiled`.
    steps : int
        Steps of the output grid.
    events : int
        Number of events, the state at t = 0 included.
    closest_decision : float or None
        Smallest relative distance ||F_L| - F_fs|/max(|F_L|, F_fs) of all decisions at a stop
        [-].
    closure : float or None
        Largest change of the scaled state over one repetition of a periodic orbit [-].
    period_multiple : int or None
        Excitation periods in one repetition of the orbit.
    error : float or None
        Bound of the error of x_r relative to its peak [-], where the core has one to state.
    """

    approach: str
    core: str
    why: str
    engine: str
    steps: int
    events: int
    closest_decision: float | None = None
    closure: float | None = None
    period_multiple: int | None = None
    error: float | None = None


class Track(Protocol):
    """The continuous solution behind a response: any instant, any window."""

    @property
    def plant(self) -> Plant:
        """The oscillator."""

    @property
    def law(self) -> AnyLaw:
        """Its friction."""

    @property
    def closest(self) -> float:
        """Smallest relative margin of a stop decision; infinite for none."""

    @property
    def turns(self) -> Events:
        """The start and every zero of v_r: between two of them x_r is monotone."""

    @property
    def end(self) -> float:
        """Last instant [s]."""

    def state(self, t: float) -> AnyState:
        """Give the state at time t [s]."""

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]."""

    def chatter(self, begin: float, end: float) -> float:
        """Give the share of a window in which v_r flips twice within four steps [-]."""


@dataclass(frozen=True, eq=False)
class Response:
    """Relative motion on an equidistant grid, with the events between its points.

    x_dd, F_f, t and stuck follow from the rest and are made when first asked for.

    Attributes
    ----------
    plant, law, motion
        The scene.
    dt : float
        Distance of the grid points [s].
    u_dd, x_r, v_r : ndarray, shape (n,)
        Base acceleration [m/s²], relative displacement [m] and velocity [m/s].
    d : ndarray of int8, shape (n,)
        Direction of sliding: -1, +1, or 0 where stuck.
    events : Events
    numerics : Numerics
    track : Track or None
        The solution between the grid points; None where only the motion was asked for.
    force : ndarray, shape (n,), or None
        Friction force as the approach had it [N]; None where the mode and the law give it.
    """

    plant: Plant
    law: AnyLaw
    motion: Sines | Samples
    dt: float
    u_dd: Floats
    x_r: Floats
    v_r: Floats
    d: Codes
    events: Events
    numerics: Numerics
    track: Track | None = None
    force: Floats | None = None

    @cached_property
    def t(self) -> Floats:
        """Time of the grid points [s], shape (n,)."""
        t: Floats = np.arange(len(self.x_r), dtype=np.float64) * self.dt
        return t

    @cached_property
    def stuck(self) -> NDArray[np.bool_]:
        """Whether the mass sticks to the base, shape (n,)."""
        stuck: NDArray[np.bool_] = self.d == 0
        return stuck

    @cached_property
    def F_f(self) -> Floats:
        """Friction force as it acts on the mass [N], shape (n,); balances F_L while stuck."""
        return self.friction(slice(None))

    @cached_property
    def x_dd(self) -> Floats:
        """Absolute acceleration of the mass [m/s²], shape (n,); equals ü while stuck."""
        return self.acceleration(slice(None))

    def friction(self, part: slice) -> Floats:
        """Give F_f [N] on a part of the grid, so that long responses need not hold it whole."""
        if self.force is not None:
            return self.force[part]
        kinetic = self.d[part] * self.law.F_fk
        if isinstance(self.law, Law) and self.law.variation:
            t = np.arange(len(self.x_r))[part] * self.dt
            kinetic = kinetic * (
                1 + self.law.variation * np.sin(self.law.omega * t + self.law.phase)
            )
        limit_force = self.plant.m * self.u_dd[part] + self.plant.k_x * self.x_r[part]
        return np.where(self.d[part] == 0, -limit_force, kinetic)

    def acceleration(self, part: slice) -> Floats:
        """Give x_dd [m/s²] on a part of the grid."""
        m, k_x, b = self.plant
        pull = k_x * self.x_r[part] + b * self.v_r[part] + self.friction(part)
        stuck = self.stuck[part] if self.force is None else False
        return np.where(stuck, self.u_dd[part], -pull / m)


class Orbit(NamedTuple):
    """The periodic orbit that a start leads to.

    Attributes
    ----------
    state : State or Deflected
        At the beginning of the repetition.
    periods : int
        Excitation periods in the repetition.
    closure : float
        Largest scaled change of the state over the repetition [-].
    settled : bool
        Whether the scene closed at all.
    unique : bool
        Whether neighbours are drawn to it; false for one of a continuum of orbits.
    run_up : float
        Time from the start to the beginning of the repetition [s].
    run_up_peak : float
        Largest |x_r| on the way [m].
    """

    state: AnyState
    periods: int
    closure: float
    settled: bool
    unique: bool
    run_up: float
    run_up_peak: float
