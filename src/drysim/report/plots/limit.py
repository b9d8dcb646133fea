"""Where a motion meets its stroke limit, as a picture needs it; draws nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from drysim.approach.response import Response


def excursions(response: Response, limit: float) -> list[tuple[float, float]]:
    """Give time [s] and x_r [m] at the largest |x_r| of every excursion to a limit [m]."""
    found: list[tuple[float, float]] = []
    goes_on = False
    for part in response.parts():
        x_r = response.points(part).x_r
        size = np.abs(x_r)
        steps = np.flatnonzero(np.diff(size >= limit, prepend=False, append=False))
        for a, b in zip(steps[::2].tolist(), steps[1::2].tolist(), strict=True):
            at = a + int(size[a:b].argmax())
            peak = (part.start + at) * response.dt, float(x_r[at])
            if not (goes_on and a == 0):
                found.append(peak)
            elif size[at] > abs(found[-1][1]):
                found[-1] = peak
        goes_on = bool(size[-1] >= limit)
    return found
