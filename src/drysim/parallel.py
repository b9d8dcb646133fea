"""Parallel work: a function applied to items in order, by worker processes or by threads.

Kernels run without the interpreter lock. What is done between them needs it, so that threads
use few processors: hardly two for the seeds of a short motion. A command on Linux therefore
forks worker processes, which share what it has loaded and prepared. Threads serve where no
process is forked: in a Python session, which may have threads of its own, on other systems, and
for work on shared arrays. The results are the same.
"""

from __future__ import annotations

import os
import pickle
import reprlib
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from functools import lru_cache, partial
from io import BytesIO
from math import ceil
from numbers import Integral
from threading import current_thread, main_thread
from typing import TYPE_CHECKING, Any, Self, TypeVar

from drysim.errors import SolverError, UsageError
from drysim.system import processor_count

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future
    from multiprocessing.process import BaseProcess

Item = TypeVar("Item")
Result = TypeVar("Result")

MAX_FIRST_ITEMS = 4
"""Most items that are worked on by threads before processes are forked: more threads would
wait for the interpreter lock."""

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

    Parameters and results as in `WorkerPool.map_in_order`.
    """
    with WorkerPool(workers) as pool:
        yield from pool.map_in_order(function, items)


class WorkerPool:
    """Workers that are kept for several series of items, one series at a time.

    Parameters
    ----------
    workers : int
        With 1 all work is done in the thread of the consumer.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._executor: Executor | None = None
        self._processes: list[BaseProcess] = []
        self._shared: Sequence[object] = ()

    def __enter__(self) -> Self:
        """Return the pool; it is closed after the block."""
        return self

    def __exit__(self, *fault: object) -> None:
        """End the worker processes; kill them if the block is left early."""
        try:
            if self._executor is not None and fault == (None, None, None):
                self._executor.shutdown()
        finally:
            self._kill()

    def map_in_order(
        self,
        function: Callable[[Item], Result],
        items: Iterable[Item],
        shared: Sequence[object] = (),
    ) -> Generator[Result, None, None]:
        """Yield `function(item)` for every item, in order, with few in progress at a time.

        Parameters
        ----------
        function : callable
            Must be safe to call from several threads, and not rely on what other calls change.
        items : iterable
            Consumed as threads become free, or at once. Those of a later series must be such
            that `pickle` can copy them.
        shared : sequence of object
            Objects that the functions of all series refer to. Each worker process has its own
            from the start; all else is copied to it with every chunk of a later series.

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
        Closing the generator cancels the queued items. Running items in threads are waited for
        at most `SHUTDOWN_TIMEOUT`, so that a kernel that does not return cannot keep the
        process alive; worker processes are killed, and the next series has new ones.
        """
        if self.workers == 1:
            yield from map(function, items)
            return
        # A fork copies the locks that other threads hold: work within a thread starts none.
        if not _forks or current_thread() is not main_thread():
            yield from map_in_threads(function, items, self.workers)
            return
        sequence, done = items if isinstance(items, Sequence) else list(items), 0
        name = getattr(
            getattr(function, "func", function), "__qualname__", type(function).__name__
        )
        if name not in _durations and self._executor is None:
            # These load the kernels that all need, and tell how long an item takes. A few long
            # ones are done by now: threads serve them as well.
            first = sequence[: min(self.workers, MAX_FIRST_ITEMS)]
            for result, duration in map_in_threads(
                partial(timed, function), first, len(first) or 1
            ):
                _durations[name] = max(duration, _durations.get(name, 0.0))
                yield result
            done = len(first)
        while (count := self._processes_for(name, len(sequence) - done)) < 2:
            if done == len(sequence):
                return
            result, _durations[name] = timed(function, sequence[done])
            yield result
            done += 1
        later = self._pickled(function)
        if self._executor is None:
            try:
                self._fork(lambda number: function(sequence[number]), count, shared)
            except (OSError, RuntimeError, NotImplementedError):
                # No process, thread or semaphore.
                self._kill()
                yield from (function(sequence[k]) for k in range(done, len(sequence)))
                return
        # The first series is known to the workers, its items by their numbers.
        known = range(len(sequence)) if later is None else sequence
        yield from self._in_processes(name, known, done, later)

    def _in_processes(
        self, name: str, items: Sequence[Any], done: int, later: bytes | None
    ) -> Generator[Any, None, None]:
        """Yield the results of the items that are not done."""
        from concurrent.futures.process import BrokenProcessPool

        executor, count, size = self._executor, len(self._processes), 1
        assert executor is not None, "processes were forked"
        most = -(-(len(items) - done) // (CHUNKS_PER_WORKER * count))

        def chunks(end: int) -> Iterator[Chunk]:
            """Yield what is handed out at a time."""
            while end < len(items):
                begin, end = end, min(end + size, len(items))
                yield items[begin:end], later

        handed_out = work_on, chunks(done), count, deque[Any]()
        try:
            for results, duration in results_in_order(
                executor, *handed_out, self._require_workers
            ):
                _durations[name] = duration
                # Items may differ: chunks grow only as long as those that are done are short.
                enough = ceil(MIN_CHUNK_TIME / max(duration, 1e-9))
                size = max(min(2 * len(results), enough, most), 1)
                done += len(results)
                yield from results
        except BrokenProcessPool as fault:
            raise SolverError(
                "a worker process ended early, perhaps for lack of memory",
                "use fewer workers, as by --workers 1, and --resume where the command has it",
            ) from fault
        finally:
            if done < len(items):
                self._kill()

    def _processes_for(self, name: str, items: int) -> int:
        """Return for how many processes so many items are enough work."""
        least = MIN_TIME_PER_WORKER if self._executor is None else MIN_CHUNK_TIME
        return min(self.workers, items, int(items * _durations.get(name, least) / least))

    def _pickled(self, function: Callable[[Any], Any]) -> bytes | None:
        """Return a function as workers read it; None if they are to be forked."""
        if self._executor is None:
            return None
        places, file = {id(one): place for place, one in enumerate(self._shared)}, BytesIO()

        class Pickler(pickle.Pickler):
            """Writes the place of a shared object instead of the object."""

            def persistent_id(self, any_object: object) -> int | None:
                """Return the place of a shared object."""
                return places.get(id(any_object))

        try:
            Pickler(file).dump(function)
        except (pickle.PicklingError, AttributeError, TypeError):
            self._kill()  # new processes know it
            return None
        return file.getvalue()

    def _fork(
        self, function: Callable[[int], Any], count: int, shared: Sequence[object]
    ) -> None:
        """Fork worker processes, which know the first function and the shared objects.

        Raises
        ------
        OSError, RuntimeError, NotImplementedError
            When the system forks no more processes, or has no threads or semaphores.
        """
        from concurrent.futures import ProcessPoolExecutor
        from multiprocessing import active_children, get_context

        if sys.platform == "win32":
            raise NotImplementedError
        others = active_children()
        self._shared = shared
        self._executor = ProcessPoolExecutor(
            count,
            mp_context=get_context("fork"),
            initializer=begin_worker,
            initargs=(function, shared, os.getpid()),
        )
        # Signals reach this process only.
        signals = signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        try:
            self._executor.submit(os.getpid)  # all are forked by the first submission
        finally:
            self._processes = [one for one in active_children() if one not in others]
            signal.pthread_sigmask(signal.SIG_SETMASK, signals)

    def _require_workers(self) -> None:
        """Raise an error unless all worker processes are alive."""
        from concurrent.futures.process import BrokenProcessPool

        if not all(process.is_alive() for process in self._processes):
            raise BrokenProcessPool

    def _kill(self) -> None:
        """Kill the worker processes that are left."""
        executor, self._executor = self._executor, None
        for process in self._processes:
            process.kill()
            process.join()
        self._processes = []
        if executor is not None:
            # Not cancelled: it fails on cancelled futures when its workers are gone.
            executor.shutdown(wait=False)


_durations: dict[str, float] = {}
"""Time that the latest item took, by the name of the function [s]."""


def timed(function: Callable[[Item], Result], item: Item) -> tuple[Result, float]:
    """Return `function(item)` and the time that it takes [s]."""
    begin = time.monotonic()
    return function(item), time.monotonic() - begin


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

Chunk = tuple[Sequence[Any], bytes | None]
"""Items, and the pickled function; None for the first one."""

_forked: tuple[Callable[[int], Any], Sequence[object]]
"""In a worker process: the first function, and the shared objects."""


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


def begin_worker(function: Callable[[int], Any], shared: Sequence[object], parent: int) -> None:
    """Prepare a worker process: it ends with its parent, and starts no further processes."""
    import ctypes

    if sys.platform == "win32":
        raise NotImplementedError
    global _forks, _forked
    _forks, _forked = False, (function, shared)
    end_with_parent = 1  # PR_SET_PDEATHSIG
    ctypes.CDLL(None).prctl(end_with_parent, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def work_on(chunk: Chunk) -> tuple[list[Any], float]:
    """Return the results of some items, and the time of one, in a worker."""
    items, later = chunk
    function = _forked[0] if later is None else read_function(later)
    begin = time.monotonic()
    results = [function(item) for item in items]
    return results, (time.monotonic() - begin) / len(items)


@lru_cache(maxsize=1)
def read_function(pickled: bytes) -> Callable[[Any], Any]:
    """Return the function of a later series, in a worker."""

    class Unpickler(pickle.Unpickler):
        """Takes shared objects by their places."""

        def persistent_load(self, place: int) -> object:
            """Return a shared object."""
            return _forked[1][place]

    function: Callable[[Any], Any] = Unpickler(BytesIO(pickled)).load()
    return function
