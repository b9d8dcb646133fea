"""How entries are timed: medians of interleaved repeats, so that all meet the same machine.

The clock counts the time of the processor, which other work on the machine disturbs little;
where the system counts that too coarsely, the time that passes. An entry is made ready on as
much of the work as patience allows, and what comes to no end is given up. Beside all entries a
filter is timed that everybody has, in turns with them.
"""

from __future__ import annotations

import gc
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from statistics import median
from time import get_clock_info, perf_counter, process_time
from typing import Any, NamedTuple, TypeVar

import numpy as np

from drysim.bench import scipy_ivp
from drysim.bench.score import Score
from drysim.bench.work import Answer, Entry, Peer, Run, Work
from drysim.core.compile import is_compiling
from drysim.errors import DrysimError, SolverError
from drysim.wording import format_number

Job = Callable[[], Any]
Given = TypeVar("Given")

CLOCK_RESOLUTION = 1e-6
"""Resolution [s] that a clock must have: the quickest jobs take some hundred of it."""

MIN_JOB_TIME = 1e-9
"""What a job is taken to last at least [s], where the clock says nothing."""

MIN_REPEATS = 3
"""Repeats of the slowest jobs: the least that has a median."""

MAX_POINTS = 2_000_000
"""Points that an entry with several a sample may compute in one run: some hundred megabytes."""

TRIAL_SAMPLES = 200
"""Samples of the stretch that tells how long a whole run would take."""

TIME_LIMIT = 30.0
"""Time [s] after which an entry has failed that was to run for the patience only."""

FILTER_COEFFICIENTS = ([1.0, 0.5, 0.2], [1.0, -1.8, 0.9])
"""The filter that is timed: a stable one of second order, as the oscillator is."""

clock = (
    process_time
    if get_clock_info("process_time").resolution <= CLOCK_RESOLUTION
    else perf_counter
)
"""Gives the time of the processor [s], counted from anywhere. How fine that is, is asked once:
the question would fall into the time of the job, some hundredths of the quickest."""


def time_once(job: Job) -> tuple[Any, float]:
    """Run a job once; give what it gives, and the time it took [s]."""
    begin = clock()
    made = job()
    return made, clock() - begin


def interleaved_medians(jobs: Sequence[Job], times: Sequence[int]) -> list[float]:
    """Give the median time of every job [s], each run so many times, in turns."""
    found: list[list[float]] = [[] for _ in jobs]
    with gc_disabled():
        for turn in range(max(times, default=0)):
            for job, wanted, times_of_job in zip(jobs, times, found, strict=True):
                if turn < wanted:
                    times_of_job.append(time_once(job)[1])
    return [median(times_of_job) for times_of_job in found]


def repeat_count(once: float, most: int, patience: float) -> int:
    """Give how often a job is run that takes so long [s]: slow ones fewer times."""
    return max(min(MIN_REPEATS, most), min(most, int(patience / once) if once > 0.0 else most))


@contextmanager
def gc_disabled() -> Iterator[None]:
    """Keep the collection of garbage from falling into the time of a job."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def try_within(work: Callable[[], Given], seconds: float) -> Given | str:
    """Give what some work gives within a time, or say how it fails: that is its verdict."""
    try:
        with time_limit(seconds):
            return work()
    except DrysimError as fault:
        return failure_reason(fault)
    except Exception as fault:  # whatever another program raises
        return f"{type(fault).__name__}: {fault}"


def failure_reason(fault: DrysimError) -> str:
    """Give why numbers cannot be had: the fault itself, or the problem behind it."""
    problems = getattr(fault, "problems", ())
    return problems[0].sentence if problems else fault.message


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Give up what lasts longer, as soon as a kernel hands over.

    Compiling is no part of the work and is never interrupted: the time begins afresh behind it.
    Where the system has no alarm, or outside the main thread, it is waited for to the end.

    Raises
    ------
    SolverError
        When the time is over.
    """
    here = threading.current_thread() is threading.main_thread()
    if not (here and hasattr(signal, "setitimer")):
        yield
        return

    def over(*_: object) -> None:
        if is_compiling():
            signal.setitimer(signal.ITIMER_REAL, seconds)
            return
        raise SolverError(f"given up after {format_number(seconds, 's')}")

    before = signal.signal(signal.SIGALRM, over)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


class BenchOptions(NamedTuple):
    """How a bench is held.

    Attributes
    ----------
    samples : int
        Samples of the work, at most.
    repeats : int
        Runs of an entry, at most.
    patience : float
        Time that one run may take [s]; slower entries run on a shorter stretch.
    peers : tuple of Peer
        Other programs that take part; the reference, which is scipy, always does.
    """

    samples: int = 24_000
    repeats: int = 15
    patience: float = 0.2
    peers: tuple[Peer, ...] = (scipy_ivp,)


@dataclass(frozen=True, eq=False)
class ReadyEntry:
    """A stretch of the work, what an entry runs on it, and its first answer, timed [s]."""

    work: Work
    run: Run
    answer: Answer
    once: float


def try_entry(entry: Entry, work: Work, options: BenchOptions) -> ReadyEntry | str:
    """Make an entry ready on as much of the work as patience allows; or say how it fails."""
    seconds = TIME_LIMIT + 3.0 * options.patience
    return try_within(lambda: prepare_entry(entry, work, options), seconds)


def prepare_entry(entry: Entry, work: Work, options: BenchOptions) -> ReadyEntry:
    """Make an entry ready, and let it run once in full."""
    most = MAX_POINTS // entry.points if entry.points > 1 else work.samples
    trial = work.first(max(1, min(TRIAL_SAMPLES, most)))
    run = entry.ready(trial)
    run()
    _, once = time_once(run)
    within = int(options.patience / max(once, MIN_JOB_TIME) * trial.samples)
    part = work.first(max(min(within, most), trial.samples))
    run = entry.ready(part)
    answer, once = time_once(run)
    return ReadyEntry(part, run, answer, once)


@dataclass(frozen=True, eq=False)
class TimedEntry:
    """What is to be timed, what it took once [s], and the score of its answer."""

    run: Job
    once: float
    score: Score


def time_entries(
    work: Work, tried: Sequence[TimedEntry], options: BenchOptions
) -> tuple[float, list[Score]]:
    """Give the time a sample of the filter [ns], and every score with its own time."""
    counts = [repeat_count(one.once, options.repeats, options.patience) for one in tried]
    jobs = [lfilter_job(work), *(one.run for one in tried)]
    lfilter_time, *took = interleaved_medians(jobs, [options.repeats, *counts])
    lfilter_time *= 1e9 / (work.samples + 1)
    scores = []
    for one, count, seconds in zip(tried, counts, took, strict=True):
        time = 1e9 * seconds / one.score.samples
        scores.append(replace(one.score, repeats=count, time=time, ratio=time / lfilter_time))
    return lfilter_time, scores


def lfilter_job(work: Work) -> Job:
    """Give the filter that all times are compared with, on a record of this length."""
    from scipy.signal import lfilter as filtered

    record = np.ascontiguousarray(work.u_dd)
    return lambda: filtered(*FILTER_COEFFICIENTS, record)
