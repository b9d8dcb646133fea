"""Track: the continuous solution behind a response, whatever found it. Knows no grid."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from drysim.approach.events import Events, Floats
from drysim.core.plant import AnyLaw, Plant
from drysim.core.state import AnyState, Totals


class Path(NamedTuple):
    """Where the mass came by: arrays of shape (points,), in the order of time.

    Attributes
    ----------
    t : ndarray
        Time [s].
    x_r : ndarray
        Relative displacement [m].
    """

    t: Floats
    x_r: Floats


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
    def end(self) -> float:
        """Last instant [s]."""

    def state(self, t: float) -> AnyState:
        """Give the state at time t [s]."""

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]."""

    def path(self, window: tuple[float, float], x_rM: float | None) -> Path:
        """Give the points of x_r that tell all of its way in a window [s], from the start on.

        Between two of them x_r passes zero and a stroke limit x_rM [m] once at most, and goes
        no farther from zero than at some of them in the same half cycle.
        """

    def chatter(self, begin: float, end: float) -> float:
        """Give the share of a window in which v_r flips twice within four steps [-]."""


class Turning(Protocol):
    """A track that knows where it turns."""

    @property
    def turns(self) -> Events:
        """The start and every zero of v_r: between two of them x_r is monotone."""


class Located:
    """A track whose stops are located: nothing is left to flip with a step."""

    def path(self: Turning, window: tuple[float, float], x_rM: float | None) -> Path:
        """Give the start and every zero of v_r: between two of them x_r is monotone."""
        return Path(self.turns.t, self.turns.x_r)

    def chatter(self, begin: float, end: float) -> float:
        """Give 0."""
        return 0.0
