"""How a motion that is followed period by period closes on itself."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from drysim.approach.events import Floats
    from drysim.core.state import AnyState

MOST_MULTIPLE, USUAL = 64, 8
"""Longest repetition that is looked for, in periods of the excitation; and the longest by which
changes may be summed."""

CHANGES = 4
"""Changes that a sum is made of: one more than a state has numbers."""

DYING = 1e-2
"""Change below which a motion is taken to die away [-]."""

BETTER = 0.5
"""Share of the change before to which a sum must bring it: a motion that grows for ever changes
as much wherever it is put, and less only beside its own size."""

NOISE = 1e-8
"""Changes this much smaller than the others tell nothing [-]."""

ROUNDING = 1e-15
"""Of a change [-]: where changes fall so slowly that it adds up to more than the change itself,
their sum is a guess."""


class Closing:
    """The ends of the last periods, and where they lead to.

    Changes that die away like geometric series have a sum, to which the motion is moved on
    (reduced rank extrapolation; Sidi, Vector Extrapolation Methods, SIAM 2017). From there it
    is followed as before: an orbit is always followed, never extrapolated. `summed` tells
    whether that was done and kept.

    Parameters
    ----------
    closed : float
        Scaled change over a repetition that counts as none [-].
    quiet : float, optional
        Repetitions without events that a sum asks for; infinite for no sums at all.
    """

    def __init__(self, closed: float, quiet: float = 0.0) -> None:
        self.closed = closed
        self.wanted, self.summed = quiet, False
        self.quiet = 0
        self.ends: list[AnyState] = []
        self.scale: Sequence[float] = ()
        self.gain = 1.0
        self.before: tuple[float, AnyState] | None = None
        self.promised = 1.0

    def add(self, end: AnyState, largest: Sequence[float], events: int = 0) -> bool:
        """Add the state at the end of a period, and the largest of each number on the way.

        Gives whether it counts. The period after a sum shows whether that led to where the
        motion changes less, in the scale from before. If not, the period is forgotten: the
        motion goes on from where it was.
        """
        if self.before is not None:
            (least, last), self.before = self.before, None
            if self.distance(end, self.ends[0]) > max(BETTER * least, self.closed):
                self.ends = [last]
                return False
            self.gain, self.summed = self.promised, True
        self.quiet = 0 if events else self.quiet + 1
        before = self.scale or (0.0,) * len(largest)
        self.scale = [max(new, 0.5 * old) for new, old in zip(largest, before, strict=True)]
        self.ends = [end, *self.ends[:MOST_MULTIPLE]]
        return True

    def repetition(self) -> tuple[float, int]:
        """Give the scaled change over a repetition [-], and of how many periods that is.

        The shortest that is closed; where none is, the usual one that is closest to it. One
        that is longer is none where the motion hardly changes over a usual one: it dies away.
        """
        if len(self.ends) < 2:
            return math.inf, 1
        ends = self.scaled(self.ends)
        changes = np.abs(ends[1:] - ends[0]).max(axis=1)
        least = int(changes[:USUAL].argmin())
        closed = np.flatnonzero(changes <= self.closed)
        if closed.size and (closed[0] < USUAL or changes[least] > NOISE):
            least = int(closed[0])
        return float(changes[least]), least + 1

    def distance(self, one: AnyState, other: AnyState) -> float:
        """Give how far two states are apart, scaled [-]."""
        ends = self.scaled((one, other))
        return float(np.abs(ends[0] - ends[1]).max())

    def scaled(self, states: Sequence[AnyState]) -> Floats:
        """Return the numbers of states in units of their scale [-], a row each."""
        return np.array([state[:3] for state in states]) / [size or 1.0 for size in self.scale]

    def onwards(self) -> AnyState:
        """Give where to follow the motion from: its end, or where its changes add up to."""
        change, periods = self.repetition()
        end = self.ends[0]
        ends = self.ends[: CHANGES * periods + 1 : periods]
        early = change > DYING or len(ends) <= CHANGES
        early |= self.quiet < self.wanted * periods
        if early or getattr(end, "turned", False):
            return end
        total = self.sum_of(self.scaled(ends[::-1]))
        if total is not None:
            self.before = change, end
            sizes = [size or 1.0 for size in self.scale]
            self.ends = [type(end)(*(total * sizes).tolist())]
        return self.ends[0]

    def sum_of(self, ends: Floats) -> Floats | None:
        """Give where the changes between some ends add up to; None where they do not die away.

        Parameters
        ----------
        ends : ndarray, shape (changes + 1, numbers)
        """
        changes = np.diff(ends, axis=0)
        sizes = np.abs(changes).max(axis=1)
        if not sizes[-1] < sizes[0]:
            return None
        last = changes[-1]
        shares = np.linalg.lstsq((changes[:-1] - last).T, -last, rcond=NOISE)[0]
        total: Floats = ends[-1] + shares @ (ends[1:-1] - ends[-1])
        gain = max(1.0, float(np.abs(total - ends[-1]).max() / sizes[-1]))
        if gain * ROUNDING > sizes[-1]:
            return None
        self.promised = gain
        return total

    def left(self, change: float) -> float:
        """Give how far the state may still be from the orbit, scaled [-]."""
        return change * self.gain
