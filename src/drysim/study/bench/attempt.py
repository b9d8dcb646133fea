"""An attempt: an entry made ready on as much of the work as patience allows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from drysim.study.bench.clock import QUICKEST, timed
from drysim.study.bench.entry import Entry, Run
from drysim.study.bench.patience import tried
from drysim.study.bench.work import Answer, Work

MOST_POINTS = 2_000_000
"""Points that an entry with several a sample may compute in one run: some hundred megabytes."""

TASTE = 200
"""Samples of the stretch that tells how long a whole run would take."""

HOPELESS = 30.0
"""Time [s] after which an entry has failed that was to run for the patience only."""


class Terms(NamedTuple):
    """How a bench is held.

    Attributes
    ----------
    samples : int
        Samples of the work, at most.
    repeats : int
        Runs of an entry, at most.
    patience : float
        Time that one run may take [s]; slower entries run on a shorter stretch.
    peers : bool
        Whether the peers take part; the reference always does.
    """

    samples: int = 24_000
    repeats: int = 15
    patience: float = 0.2
    peers: bool = True


@dataclass(frozen=True, eq=False)
class Runner:
    """A stretch of the work, what an entry runs on it, and its first answer, timed [s]."""

    work: Work
    run: Run
    answer: Answer
    once: float


def attempt(entry: Entry, work: Work, terms: Terms) -> Runner | str:
    """Make an entry ready on as much of the work as patience allows; or say how it fails."""
    seconds = HOPELESS + 3.0 * terms.patience
    return tried(lambda: made_ready(entry, work, terms), seconds)


def made_ready(entry: Entry, work: Work, terms: Terms) -> Runner:
    """Make an entry ready, and let it run once in full."""
    most = MOST_POINTS // entry.points if entry.points > 1 else work.samples
    taste = work.first(max(1, min(TASTE, most)))
    run = entry.ready(taste)
    run()
    _, once = timed(run)
    within = int(terms.patience / max(once, QUICKEST) * taste.samples)
    part = work.first(max(min(within, most), taste.samples))
    run = entry.ready(part)
    answer, once = timed(run)
    return Runner(part, run, answer, once)
