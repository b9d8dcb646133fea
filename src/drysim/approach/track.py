"""Track: the continuous solution behind a response, whatever found it. Knows no grid."""

from __future__ import annotations

from typing import Protocol

from drysim.approach.events import Events
from drysim.core.plant import AnyLaw, Plant
from drysim.core.state import AnyState, Totals


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


class Located:
    """A track whose stops are located: nothing is left to flip with a step."""

    def chatter(self, begin: float, end: float) -> float:
        """Give 0."""
        return 0.0
