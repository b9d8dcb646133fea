"""Timing of benchmark entries: medians of interleaved repeats.

All entries and scipy's lfilter run in turns, so that load and clock rate of the machine affect
them equally. The clock is CPU time, which other processes hardly disturb, or wall time where
the system counts CPU time too coarsely. An entry runs on as many samples as fit into its time,
and is stopped at a time limit.
"""

from __future__ import annotations

import _thread
import gc
import signal
import sys
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
"""Required resolution of the clock [s]: the fastest jobs take about 100 µs."""

MIN_JOB_TIME = 1e-9
"""Lower bound of a measured time [s], which may be zero."""

MIN_REPEATS = 3
"""Repeats of the slowest jobs: the least number with a median."""

MAX_POINTS = 2_000_000
"""Maximum number of points per run of an entry with several per sample: a few 100 MB."""

TRIAL_SAMPLES = 200
"""Samples of the trial run from which the time of a full run is estimated."""

TIME_LIMIT = 30.0
"""Time after which an entry fails, in addition to its regular runs [s]."""

FILTER_COEFFICIENTS = ([1.0, 0.5, 0.2], [1.0, -1.8, 0.9])
"""Coefficients of the timed filter: stable and of second order, like the oscillator."""

clock = (
    process_time
    if get_clock_info("process_time").resolution <= CLOCK_RESOLUTION
    else perf_counter
)
"""CPU time from an arbitrary origin [s]. The choice is made once, at import: the look-up takes
a few per cent of the fastest job."""


def time_once(job: Job) -> tuple[Any, float]:
    """Run a job once; return its result and its time [s]."""
    begin = clock()
    made = job()
    return made, clock() - begin


def interleaved_medians(jobs: Sequence[Job], times: Sequence[int]) -> list[float]:
    """Return the median time of every job [s].

    Parameters
    ----------
    jobs : sequence of callable
    times : sequence of int
        Number of runs of each job; the jobs run in turns.
    """
    times_of_jobs: list[list[float]] = [[] for _ in jobs]
    with gc_disabled():
        for turn in range(max(times, default=0)):
            for job, wanted, times_of_job in zip(jobs, times, times_of_jobs, strict=True):
                if turn < wanted:
                    times_of_job.append(time_once(job)[1])
    return [median(times_of_job) for times_of_job in times_of_jobs]


def repeat_count(once: float, most: int, patience: float) -> int:
    """Return the number of runs of a job that takes `once` [s], at most `most`."""
    return max(min(MIN_REPEATS, most), min(most, int(patience / once) if once > 0.0 else most))


@contextmanager
def gc_disabled() -> Iterator[None]:
    """Disable garbage collection, which would count in the time of a job."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def try_within(work: Callable[[], Given], seconds: float) -> Given | str:
    """Return the result of `work`, or the reason of its failure within a time limit [s]."""
    try:
        with time_limit(seconds):
            return work()
    except DrysimError as fault:
        problems = getattr(fault, "problems", ())
        return problems[0].sentence if problems else fault.message
    except Exception as fault:  # other programs may raise anything
        return f"{type(fault).__name__}: {fault}"


if sys.platform == "win32":
    TIMER_SIGNAL = signal.SIGABRT
else:
    TIMER_SIGNAL = signal.SIGALRM
"""Signal whose handler ends a block at its time limit. A thread asks Python to call it, so that
every system has such a timer."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Limit the time of a block [s]; a running kernel is not interrupted.

    Compilation does not count: the time starts again after it. There is no limit outside the
    main thread, where Python handles no signals.

    Raises
    ------
    SolverError
        After the time limit.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def start() -> threading.Timer:
        timer = threading.Timer(seconds, _thread.interrupt_main, (TIMER_SIGNAL,))
        timer.daemon = True
        timer.start()
        return timer

    def over(*_: object) -> None:
        if ended:
            return
        if is_compiling():
            timers.append(start())
            return
        raise SolverError(f"time limit of {format_number(seconds, 's')} exceeded")

    before = signal.signal(TIMER_SIGNAL, over)
    ended = False
    timers: list[threading.Timer] = []
    try:
        timers.append(start())
        yield
    finally:
        ended = True
        for timer in timers:
            timer.cancel()
            timer.join()
        signal.signal(TIMER_SIGNAL, before)


class BenchOptions(NamedTuple):
    """Options of a benchmark.

    Attributes
    ----------
    samples : int
        Maximum number of samples of the work.
    repeats : int
        Maximum number of runs of an entry.
    patience : float
        Time of one run [s]; slower entries run on fewer samples.
    peers : tuple of Peer
        Other programs to include. The reference, scipy, is always included.
    """

    samples: int = 24_000
    repeats: int = 15
    patience: float = 0.2
    peers: tuple[Peer, ...] = (scipy_ivp,)


@dataclass(frozen=True, eq=False)
class ReadyEntry:
    """First samples of a work, the timed part of an entry, its first answer and time [s]."""

    work: Work
    run: Run
    answer: Answer
    once: float


def try_entry(entry: Entry, work: Work, options: BenchOptions) -> ReadyEntry | str:
    """Prepare an entry within the time limit; return the reason if it fails."""
    seconds = TIME_LIMIT + 3.0 * options.patience
    return try_within(lambda: prepare_entry(entry, work, options), seconds)


def prepare_entry(entry: Entry, work: Work, options: BenchOptions) -> ReadyEntry:
    """Prepare an entry for as many samples as fit into `options.patience`, and run it once."""
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
    """A job to be timed, the time of one run [s], and the score of its answer."""

    run: Job
    once: float
    score: Score


def time_entries(
    work: Work, tried: Sequence[TimedEntry], options: BenchOptions
) -> tuple[float, list[Score]]:
    """Time all entries and the filter.

    Parameters
    ----------
    work : Work
    tried : sequence of TimedEntry
    options : BenchOptions

    Returns
    -------
    float
        Time per sample of the filter [ns].
    list of Score
        The scores, with their times.
    """
    counts = [repeat_count(entry.once, options.repeats, options.patience) for entry in tried]
    jobs = [lfilter_job(work), *(entry.run for entry in tried)]
    lfilter_time, *took = interleaved_medians(jobs, [options.repeats, *counts])
    lfilter_time *= 1e9 / (work.samples + 1)
    scores = []
    for entry, count, seconds in zip(tried, counts, took, strict=True):
        time = 1e9 * seconds / entry.score.samples
        scores.append(replace(entry.score, repeats=count, time=time, ratio=time / lfilter_time))
    return lfilter_time, scores


def lfilter_job(work: Work) -> Job:
    """Return the reference job: scipy's lfilter on a record of the length of the work."""
    from scipy.signal import lfilter as filtered

    record = np.ascontiguousarray(work.u_dd)
    return lambda: filtered(*FILTER_COEFFICIENTS, record)
