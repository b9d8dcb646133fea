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
from functools import partial
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

CHECK_INTERVAL = 1.0
"""Time between two checks of the workers while a result is awaited [s]: an executor does not
notice that one was killed while it handed over a large result."""

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
    sequence, done = items if isinstance(items, Sequence) else list(items), 0
    name = getattr(getattr(function, "func", function), "__qualname__", type(function).__name__)
    if name not in _durations:
        # These load the kernels that all need, and tell how long an item takes. A few long
        # ones are done by now: threads serve them as well.
        first = sequence[:workers]
        for result, duration in map_in_threads(partial(timed, function), first, workers):
            _durations[name] = max(duration, _durations.get(name, 0.0))
            yield result
        done = len(first)
    while (count := processes_for(name, len(sequence) - done, workers)) < 2:
        if done == len(sequence):
            return
        result, _durations[name] = timed(function, sequence[done])
        yield result
        done += 1
    try:
        executor = fork_workers(function, sequence, count)
    except (OSError, RuntimeError, NotImplementedError):  # no process, thread or semaphore
        yield from (function(sequence[number]) for number in range(done, len(sequence)))
        return
    most = -(-(len(sequence) - done) // (CHUNKS_PER_WORKER * count))
    size = 1

    def chunks() -> Iterator[range]:
        """Yield the numbers of the items that are handed out at a time."""
        end = done
        while end < len(sequence):
            begin, end = end, min(end + size, len(sequence))
            yield range(begin, end)

    handed_out = executor, work_on, chunks(), count, deque[Any]()
    with ending(executor):
        for results, duration in results_in_order(*handed_out, partial(require_workers, count)):
            _durations[name] = duration
            # Items may differ: chunks grow only as long as those that are done are short.
            enough = ceil(MIN_CHUNK_TIME / max(duration, 1e-9))
            size = max(min(2 * len(results), enough, most), 1)
            yield from results


_durations: dict[str, float] = {}
"""Time that the latest item took, by the name of the function [s]."""


def timed(function: Callable[[Item], Result], item: Item) -> tuple[Result, float]:
    """Return `function(item)` and the time that it takes [s]."""
    begin = time.monotonic()
    return function(item), time.monotonic() - begin


def processes_for(name: str, items: int, workers: int) -> int:
    """Return for how many processes so many items are enough work."""
    work = items * _durations.get(name, 0.0)
    return min(workers, items, int(work / MIN_TIME_PER_WORKER))


def map_in_threads(
    function: Callable[[Item], Result], items: Iterable[Item], threads: int
) -> Generator[Result, None, None]:
    """Yield `function(item)` for every item, in order; as `map_in_order`, but by threads."""
    if threads == 1:
        yield from map(function, items)
        return
    from concurrent.futures import ThreadPoolExecutor, wait

    executor, futures = ThreadPoolExecutor(threads), deque[Any]()
    try:
        yield from results_in_order(executor, function, items, threads, futures)
        executor.shutdown()
    finally:
        executor.shutdown(wait=False, cancel_futures=True)
        wait([one for one in futures if not one.done()], SHUTDOWN_TIMEOUT)


def results_in_order(
    executor: Executor,
    function: Callable[[Item], Result],
    items: Iterable[Item],
    workers: int,
    futures: deque[Future[Result]],
    check: Callable[[], None] = lambda: None,
) -> Generator[Result, None, None]:
    """Yield the results of an executor in the order of the items.

    `futures` holds those in progress, and `check` is called while one keeps waiting.
    """
    for item in items:
        futures.append(executor.submit(function, item))
        if len(futures) == QUEUED_PER_WORKER * workers:
            yield pop_first_result(futures, check)
    while futures:
        yield pop_first_result(futures, check)


def pop_first_result(futures: deque[Future[Result]], check: Callable[[], None]) -> Result:
    """Remove the first future and return its result; it stays in place if interrupted."""
    from concurrent.futures import wait

    while not wait([futures[0]], CHECK_INTERVAL).done:
        check()
    result = futures[0].result()
    futures.popleft()
    return result


# Worker processes.

_forks = False
"""Whether this process forks workers."""

_work: tuple[Callable[[Any], Any], Sequence[Any]]
"""Function and items of a worker process."""


def allow_processes() -> None:
    """Have `map_in_order` fork worker processes from now on, where that is safe.

    For a command: no thread of its own holds a lock when it forks. Frameworks of macOS do not
    survive a fork, and Windows has none.
    """
    global _forks
    _forks = sys.platform == "linux"


def forks_workers() -> bool:
    """Return whether `map_in_order` forks worker processes."""
    return _forks


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
    except BaseException:
        kill_workers()
        raise
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, signals)
    return executor


@contextmanager
def ending(executor: Executor) -> Iterator[None]:
    """End the workers after the block; kill them if it is left early."""
    from concurrent.futures.process import BrokenProcessPool

    try:
        yield
        executor.shutdown()
    except BrokenProcessPool as fault:
        raise SolverError(
            "a worker process ended early, perhaps for lack of memory",
            "use fewer workers, as by --workers 1, and --resume where the command has it",
        ) from fault
    finally:
        # Not cancelled: the executor fails on cancelled futures when its workers are gone.
        kill_workers()
        executor.shutdown(wait=False)


def require_workers(count: int) -> None:
    """Raise an error unless so many worker processes are alive."""
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import active_children

    if len(active_children()) < count:
        raise BrokenProcessPool


def kill_workers() -> None:
    """Kill all worker processes that are left."""
    from multiprocessing import active_children

    for worker in active_children():
        worker.kill()
        worker.join()


def begin_worker(function: Callable[[Item], Any], items: Sequence[Item], parent: int) -> None:
    """Prepare a worker process: it ends with its parent, and starts no further processes."""
    import ctypes

    if sys.platform == "win32":
        raise NotImplementedError
    global _forks, _work
    _forks, _work = False, (function, items)
    end_with_parent = 1  # PR_SET_PDEATHSIG
    ctypes.CDLL(None).prctl(end_with_parent, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def work_on(numbers: range) -> tuple[list[Any], float]:
    """Return the results of items by their numbers, and the time of one, in a worker."""
    (function, items), begin = _work, time.monotonic()
    results = [function(items[number]) for number in numbers]
    return results, (time.monotonic() - begin) / len(numbers)
