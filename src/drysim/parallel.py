"""Parallel work: a function applied to items in order, by worker processes or by threads.

Kernels run without the interpreter lock. What is done between them needs it, so that threads
use few processors: hardly two for the seeds of a short motion. A command on Linux therefore
forks worker processes, which share what it has loaded and prepared. Threads serve where no
process is forked: in a Python session, which may have threads of its own, on other systems, and
for work on shared arrays. The results are the same.
"""

from __future__ import annotations

import os
import reprlib
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager
from math import ceil
from numbers import Integral
from typing import TYPE_CHECKING, Any, TypeVar

from drysim.errors import SolverError, UsageError
from drysim.system import processor_count

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future

Item = TypeVar("Item")
Result = TypeVar("Result")

QUEUED_PER_WORKER = 2
"""Submitted items per worker: one in progress and one queued, so that no worker runs idle."""

SHUTDOWN_TIMEOUT = 0.25
"""Longest wait for running items after the results are no longer needed [s]."""

MIN_TIME_PER_WORKER = 0.03
"""Least work for which a process is forked [s]. That takes 4 ms, and the process spends some
20 ms on copies of memory that it shares at first."""

MIN_CHUNK_TIME = 0.01
"""Work that is handed out at a time [s], beside which handing it out takes little time."""

CHUNKS_PER_WORKER = 4
"""Least number of chunks for each worker, so that none waits long for the last one."""


def worker_count(workers: int | None) -> int:
    """Return the number of workers; by default one per processor.

    Parameters
    ----------
    workers : int or None
        The requested number, None for the default.

    Raises
    ------
    UsageError
        If `workers` is not an integer of at least 1.
    """
    if workers is None:
        return processor_count()
    if isinstance(workers, bool) or not isinstance(workers, Integral) or workers < 1:
        received = reprlib.repr(workers)
        raise UsageError(f"workers must be a whole number of at least 1, not {received}")
    return int(workers)


def map_in_order(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    workers: int,
) -> Generator[Result, None, None]:
    """Yield `function(item)` for every item, in order, with few items in progress at a time.

    Parameters
    ----------
    function : callable
        Must be safe to call from several threads, and not rely on what other calls change.
    items : iterable
        Consumed as threads become free, or at once.
    workers : int
        With 1 the function is called in the thread of the consumer.

    Yields
    ------
    object
        The results, in the order of the items.

    Raises
    ------
    SolverError
        When a worker process ended early, as for lack of memory.

    Notes
    -----
    Closing the generator cancels the queued items. Running items in threads are waited for at
    most `SHUTDOWN_TIMEOUT`, so that a kernel that does not return cannot keep the process
    alive; worker processes are killed.
    """
    if workers == 1:
        yield from map(function, items)
        return
    if not _forks:
        yield from map_in_threads(function, items, workers)
        return
    known = items if isinstance(items, Sequence) else list(items)
    name, done = getattr(function, "func", function).__qualname__, 0
    # The first item of all tells how long one takes, and loads the kernels that all need.
    while (count := processes_for(name, len(known) - done, workers)) < 2:
        if done == len(known):
            return
        begin = time.monotonic()
        result = function(known[done])
        _durations[name] = time.monotonic() - begin
        yield result
        done += 1
    most = -(-(len(known) - done) // (CHUNKS_PER_WORKER * count))
    size = min(max(ceil(MIN_CHUNK_TIME / max(_durations[name], 1e-9)), 1), most)
    firsts = range(done, len(known), size)
    chunks = (range(at, min(at + size, len(known))) for at in firsts)
    try:
        executor = fork_workers(function, known, count)
    except (OSError, NotImplementedError):
        yield from map_in_threads(function, known[done:], workers)
        return
    with ending(executor):
        for results, duration in results_in_order(executor, work_on, chunks, count):
            _durations[name] = duration
            yield from results


_durations: dict[str, float] = {}
"""Time that the latest item took, by the name of the function [s]."""


def processes_for(name: str, items: int, workers: int) -> int:
    """Return for how many processes there is enough work; 0 if it is not known."""
    work = items * _durations.get(name, 0.0)
    return min(workers, items, int(work / MIN_TIME_PER_WORKER))


def map_in_threads(
    function: Callable[[Item], Result], items: Iterable[Item], threads: int
) -> Generator[Result, None, None]:
    """Yield `function(item)` for every item, in order; as `map_in_order`, but by threads."""
    if threads == 1:
        yield from map(function, items)
        return
    from concurrent.futures import ThreadPoolExecutor

    executor = ThreadPoolExecutor(threads)
    try:
        yield from results_in_order(executor, function, items, threads)
    finally:
        executor.shutdown(wait=False, cancel_futures=True)


def results_in_order(
    executor: Executor, function: Callable[[Item], Result], items: Iterable[Item], workers: int
) -> Generator[Result, None, None]:
    """Yield the results of an executor in the order of the items."""
    from concurrent.futures import wait

    futures: deque[Future[Result]] = deque()
    try:
        for item in items:
            futures.append(executor.submit(function, item))
            if len(futures) == QUEUED_PER_WORKER * workers:
                yield pop_first_result(futures)
        while futures:
            yield pop_first_result(futures)
    finally:
        for future in futures:
            future.cancel()
        wait([one for one in futures if not one.done()], SHUTDOWN_TIMEOUT)


def pop_first_result(futures: deque[Future[Result]]) -> Result:
    """Remove the first future and return its result; it stays in place if interrupted."""
    result = futures[0].result()
    futures.popleft()
    return result


# Worker processes.

_forks = False
"""Whether this process forks workers."""

_work: Callable[[int], Any] = lambda number: None  # noqa: E731 - replaced in each worker
"""What a worker process does for the item with a number."""


def allow_processes() -> None:
    """Have `map_in_order` fork worker processes from now on, where that is safe.

    For a command: no thread of its own holds a lock when it forks. Frameworks of macOS do not
    survive a fork, and Windows has none.
    """
    global _forks
    _forks = sys.platform == "linux"


def fork_workers(
    function: Callable[[Item], Any], items: Sequence[Item], workers: int
) -> Executor:
    """Return an executor of worker processes, which know function and items.

    Raises
    ------
    OSError, NotImplementedError
        When the system forks no more processes, or has no semaphores.
    """
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    if sys.platform == "win32":
        raise NotImplementedError
    executor = ProcessPoolExecutor(
        workers,
        mp_context=get_context("fork"),
        initializer=begin_worker,
        initargs=(function, items, os.getpid()),
    )
    # Signals reach this process only.
    signals = signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
    try:
        executor.submit(os.getpid)  # all workers are forked by the first submission
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, signals)
    return executor


@contextmanager
def ending(executor: Executor) -> Iterator[None]:
    """End the workers after the block; kill them if it is left early."""
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import active_children

    try:
        yield
        executor.shutdown()
    except BrokenProcessPool as fault:
        raise SolverError(
            "a worker process ended early, perhaps for lack of memory",
            "use fewer workers, as by --workers 1",
        ) from fault
    finally:
        for worker in active_children():
            worker.kill()
        executor.shutdown(cancel_futures=True)


def begin_worker(function: Callable[[Item], Any], items: Sequence[Item], parent: int) -> None:
    """Prepare a worker process: it ends with its parent, and starts no further processes."""
    import ctypes

    if sys.platform == "win32":
        raise NotImplementedError
    global _forks, _work
    _forks = False
    _work = lambda number: function(items[number])  # noqa: E731 - a closure
    end_with_parent = 1  # PR_SET_PDEATHSIG
    ctypes.CDLL(None).prctl(end_with_parent, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def work_on(numbers: range) -> tuple[list[Any], float]:
    """Return the results of items by their numbers, and the time of one, in a worker."""
    begin = time.monotonic()
    results = [_work(number) for number in numbers]
    return results, (time.monotonic() - begin) / len(numbers)
