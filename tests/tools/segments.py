"""All segments of a motion over samples, for independent sums over them."""

from __future__ import annotations

from drysim.approach.buffers import empty_columns
from drysim.core.compile import as_engine_array
from drysim.core.events import Segments
from drysim.core.sampled import SampledMotion
from drysim.core.trajectory import SampledSolution, Solution, fill_segments


def every_segment(solution: SampledSolution) -> Solution:
    """Return all segments of a solution, one or more for each step."""
    scene, samples, rows = solution
    count = len(scene.u_dd) - 1
    segments = empty_columns(Segments, count + len(rows.n) + 1)
    rows = Segments(*map(as_engine_array, rows))
    samples = SampledMotion(*map(as_engine_array, samples))
    used = fill_segments(rows, samples, 0, (0, count), segments)
    return Solution(scene, Segments(*(column[:used] for column in segments)))
