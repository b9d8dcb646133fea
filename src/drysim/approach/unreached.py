"""A motion that never reaches its end stops: solved without them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drysim.approach.events import Floats
from drysim.approach.track import Located, Path, Track
from drysim.core.plant import Plant, Stopped
from drysim.core.state import AnyState, Totals


class Hits(NamedTuple):
    """When the mass came to a stop, and how fast: arrays of shape (hits,).

    Attributes
    ----------
    t : ndarray
        Time [s].
    v_r : ndarray
        Velocity just before [m/s]; its sign is the side of the stop.
    """

    t: Floats
    v_r: Floats


@dataclass(frozen=True, eq=False)
class Unreached(Located):
    """A solution of a scene with end stops that never reaches one."""

    law: Stopped
    bare: Track

    @property
    def plant(self) -> Plant:
        """The oscillator."""
        return self.bare.plant

    @property
    def closest(self) -> float:
        """Smallest relative margin of a stop decision; infinite for none."""
        return self.bare.closest

    def path(self, window: tuple[float, float], x_rM: float | None) -> Path:
        """Give the points of x_r that tell all of its way in a window [s]."""
        return self.bare.path(window, x_rM)

    @property
    def end(self) -> float:
        """Last instant [s]."""
        return self.bare.end

    def state(self, t: float) -> AnyState:
        """Give the state at time t [s]."""
        return self.bare.state(t)

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]."""
        return self.bare.totals(begin, end)

    def hits(self) -> Hits:
        """Give no hits."""
        return Hits(np.empty(0), np.empty(0))

    def hardest_push(self, begin: float, end: float) -> float:
        """Give no force."""
        return 0.0
