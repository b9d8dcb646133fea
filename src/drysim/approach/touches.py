"""A motion over a spring contact under sines, on its grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from drysim.approach.events import Floats
from drysim.approach.points import Points
from drysim.approach.spans import base_of_waves
from drysim.core.compiled import held
from drysim.core.contacts.contact_grid import sample_contact
from drysim.core.table import room

if TYPE_CHECKING:
    from drysim.approach.traced import Traced


@dataclass(frozen=True, eq=False)
class Touches:
    """Such a solution on the grid n·dt, of `length` points."""

    track: Traced
    dt: float
    length: int

    def __len__(self) -> int:
        """Give the number of points."""
        return self.length

    def base(self, first: int, last: int) -> Floats:
        """Give ü [m/s²] from point number `first` to the one before `last`."""
        return base_of_waves(self.track.waves, first, last, self.dt)

    def part(self, first: int, last: int) -> Points:
        """Give the points from number `first` to the one before `last`."""
        plant, law, waves, _, _, trail = self.track.scene
        n, size = last - first, room(waves.size)
        x_r, v_r, F_f = (held(np.empty(n)) for _ in range(3))
        d, bare, sprung = held(np.empty(n, dtype=np.int8)), *map(held, np.empty((2, size)))
        sample_contact(plant, law, waves, trail, first, self.dt, bare, sprung, x_r, v_r, F_f, d)
        states = (np.asarray(x_r), np.asarray(v_r), np.asarray(d, dtype=np.int8))
        return Points(*states, np.asarray(F_f))
