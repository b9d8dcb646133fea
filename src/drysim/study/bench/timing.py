"""What entries take beside a filter that everybody has: medians, all of them in turns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drysim.study.bench.attempt import Terms
from drysim.study.bench.clock import Job, interleaved, repeats
from drysim.study.bench.scores import Score
from drysim.study.bench.work import Work

RECURSION = ([1.0, 0.5, 0.2], [1.0, -1.8, 0.9])
"""The filter that is timed: a stable one of second order, as the oscillator is."""


@dataclass(frozen=True, eq=False)
class Tried:
    """What is to be timed, what it took once [s], and the score of its answer."""

    run: Job
    once: float
    score: Score


def clocked(work: Work, tried: Sequence[Tried], terms: Terms) -> tuple[float, list[Score]]:
    """Give the time a sample of the filter [ns], and every score with its own time."""
    counts = [repeats(one.once, terms.repeats, terms.patience) for one in tried]
    jobs = [lfilter(work), *(one.run for one in tried)]
    plain, *took = interleaved(jobs, [terms.repeats, *counts])
    plain *= 1e9 / (work.samples + 1)
    scores = []
    for one, count, seconds in zip(tried, counts, took, strict=True):
        time = 1e9 * seconds / one.score.samples
        scores.append(replace(one.score, repeats=count, time=time, ratio=time / plain))
    return plain, scores


def lfilter(work: Work) -> Job:
    """Give the filter that all times are compared with, on a record of this length."""
    from scipy.signal import lfilter as filtered

    record = np.ascontiguousarray(work.u_dd)
    return lambda: filtered(*RECURSION, record)
