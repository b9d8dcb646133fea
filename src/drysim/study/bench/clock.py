"""The clock: medians of interleaved repeats, so that all entries meet the same machine.

It counts the time of the processor, which other work on the machine disturbs little; where the
system counts that too coarsely, the time that passes.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from statistics import median
from time import get_clock_info, perf_counter, process_time
from typing import Any

Job = Callable[[], Any]

FINE = 1e-6
"""Resolution [s] that a clock must have: the quickest jobs take some hundred of it."""

QUICKEST = 1e-9
"""What a job is taken to last at least [s], where the clock says nothing."""

FEWEST = 3
"""Repeats of the slowest jobs: the least that has a median."""

seconds = process_time if get_clock_info("process_time").resolution <= FINE else perf_counter
"""Gives the time of the processor [s], counted from anywhere. How fine that is, is asked once:
the question would fall into the time of the job, some hundredths of the quickest."""


def timed(job: Job) -> tuple[Any, float]:
    """Run a job once; give what it gives, and the time it took [s]."""
    begin = seconds()
    made = job()
    return made, seconds() - begin


def interleaved(jobs: Sequence[Job], times: Sequence[int]) -> list[float]:
    """Give the median time of every job [s], each run so many times, in turns."""
    found: list[list[float]] = [[] for _ in jobs]
    with undisturbed():
        for turn in range(max(times, default=0)):
            for job, wanted, kept in zip(jobs, times, found, strict=True):
                if turn < wanted:
                    kept.append(timed(job)[1])
    return [median(kept) for kept in found]


def repeats(once: float, most: int, patience: float) -> int:
    """Give how often a job is run that takes so long [s]: slow ones fewer times."""
    return max(min(FEWEST, most), min(most, int(patience / once) if once > 0.0 else most))


@contextmanager
def undisturbed() -> Iterator[None]:
    """Keep the collection of garbage from falling into the time of a job."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()
