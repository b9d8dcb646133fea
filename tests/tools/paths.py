"""Statistics of a path that is given as displacements in order, one a second."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drysim.core.compile import as_engine_array
from drysim.core.model import NO_LIMITS, StrokeLimits
from drysim.core.stroke import PathMeasures, measure_path


def measured_path(
    x_r: NDArray[np.float64], limits: StrokeLimits = NO_LIMITS
) -> tuple[PathMeasures, list[float]]:
    """Return what follows from a path, and the peaks of its half cycles."""
    end = len(x_r) - 1.0
    window, ends = (0.0, end, end), (float(x_r[0]), float(x_r[-1]), float(x_r[-1]))
    t, x_r, peaks = map(
        as_engine_array, (np.arange(len(x_r)) * 1.0, x_r, np.empty(len(x_r) + 2))
    )
    measures = measure_path(t, x_r, window, ends, limits, peaks)
    return measures, list(peaks[: measures.half_cycles])
