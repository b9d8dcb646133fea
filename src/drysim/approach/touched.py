"""A spring contact under sines, or with a normal force that swings: known from mode to mode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drysim.approach import traced
from drysim.approach.events import Floats
from drysim.approach.response import Response
from drysim.approach.scene import grid_points
from drysim.approach.told import all_told, whole_pieces
from drysim.approach.touches import Touches
from drysim.approach.track import Path
from drysim.core.compiled import held
from drysim.core.contacts.telling import tell
from drysim.core.motion import Samples, Sines
from drysim.core.plant import Plant, Slider
from drysim.core.state import AnyState


@dataclass(frozen=True, eq=False)
class Touched(traced.Traced):
    """A solution over a spring contact; how it turns within a mode is found where asked for."""

    law: Slider

    def path(self, window: tuple[float, float], x_rM: float | None) -> Path:
        """Give the points of x_r that tell all of its way in a window [s]."""
        begins = self._begins
        lengths = held(np.append(np.diff(begins), self.end - begins[-1]))
        at = (0, 0.0, 0.0, 0.0, 0.0)
        return all_told(tell, (*self.scene, lengths), whole_pieces(begins, window), x_rM, at)

    @property
    def series(self) -> tuple[Floats, ...]:
        """What each component of the state came to along the way."""
        return self.path((0.0, self.end), None).x_r, self.trail.v_r, self.trail.z


def follow(
    plant: Plant,
    law: Slider,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> Touched:
    """Solve a scene from t = 0 to `duration` [s], or to the end of the samples."""
    return traced.follow_as(Touched, plant, law, motion, start, duration)


def solve(
    plant: Plant,
    law: Slider,
    motion: Sines | Samples,
    start: AnyState,
    step: float,
    duration: float | None,
) -> Response:
    """Solve a scene and write it on its grid."""
    track = follow(plant, law, motion, start, duration)
    if isinstance(motion, Samples):
        return traced.on_grid(track, step)
    return traced.responding(track, Touches(track, step, grid_points(track.end, step)))
