"""Parallel work: a function applied to items by threads, processes or other machines.

`completed` hands items to any executor in chunks, and takes the results as they come. A
`WorkerPool` has the workers of this machine; `study.cluster` has those of others.

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
from collections.abc import Callable, Collection, Generator, Iterable, Sequence
from contextlib import closing
from functools import lru_cache
from io import BytesIO
from math import ceil
from numbers import Integral
from threading import current_thread, main_thread
from typing import TYPE_CHECKING, Any, NamedTuple, Self, TypeVar

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
"""Submitted chunks per worker: one in progress and one queued, so that no worker runs idle."""

SHUTDOWN_TIMEOUT = 0.25
"""Longest wait for running items after the results are no longer needed [s]."""

MIN_TIME_PER_WORKER = 0.03
"""Least work for which a process is forked [s]. That takes 4 ms, and the process spends some
20 ms on copies of memory that it shares at first."""

MIN_CHUNK_TIME = 0.01
"""Work that is handed to a process at a time [s], beside which handing it out takes little
time."""

MAX_EARLY = 64
"""Chunks whose results may wait for those of earlier items: they take memory."""

CHECK_INTERVAL = 1.0
"""Longest time between two checks of the workers [s]: an executor does not notice that one was
killed while it handed over a large result."""


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
            Consumed at once by several workers. Those of a later series must be such that
            `pickle` can copy them.
        shared : sequence of object
            Objects that the functions of all series refer to. Each worker process has its own
            from the start; all else is copied to it with every chunk of a later series.

        Yields
        ------
        object
            The results, in the order of the items.

        Raises
        ------
        Exception
            That of the first item that fails; the results of items that were handed out with
            it are lost.
        SolverError
            When a worker process ended early, as for lack of memory.

        Notes
        -----
        Closing the generator cancels the queued items. Running items in threads are waited for
        at most `SHUTDOWN_TIMEOUT`, so that a kernel that does not return cannot keep the
        process alive; worker processes are killed, and the next series has new ones.
        """
        early: dict[int, list[Result]] = {}
        with closing(self._completed(function, as_sequence(items), shared, early)) as chunks:
            yield from in_order(chunks, early)

    def map_unordered(
        self,
        function: Callable[[Item], Result],
        items: Iterable[Item],
        shared: Sequence[object] = (),
    ) -> Generator[tuple[Item, Result], None, None]:
        """Yield every item with `function(item)` as they are done; see `map_in_order`."""
        sequence = as_sequence(items)
        with closing(self._completed(function, sequence, shared)) as chunks:
            for chunk in chunks:
                done = sequence[chunk.begin : chunk.begin + len(chunk.results)]
                yield from zip(done, chunk.results, strict=True)

    def _completed(
        self,
        function: Callable[[Any], Any],
        items: Sequence[Any],
        shared: Sequence[object],
        early: Collection[object] = (),
    ) -> Generator[Chunk, None, None]:
        """Yield chunks of items with their results, as they are done."""
        # A fork copies the locks that other threads hold: work within a thread starts none.
        if self.workers == 1 or not _forks or current_thread() is not main_thread():
            yield from completed_in_threads(function, items, self.workers, early)
            return
        done = 0
        name = getattr(
            getattr(function, "func", function), "__qualname__", type(function).__name__
        )
        if name not in _durations and self._executor is None:
            # These load the kernels that all need, and tell how long an item takes. A few long
            # ones are done by now: threads serve them as well.
            done = min(self.workers, MAX_FIRST_ITEMS, len(items))
            for chunk in completed_in_threads(function, items[:done], done):
                _durations[name] = max(chunk.duration, _durations.get(name, 0.0))
                yield chunk
        while (count := self._processes_for(name, len(items) - done)) < 2:
            if done == len(items):
                return
            for chunk in completed_here(function, items, range(done, done + 1)):
                _durations[name] = chunk.duration
                yield chunk
            done += 1
        pickled = self._pickled(function)
        if self._executor is None:
            try:
                self._fork(lambda number: function(items[number]), count, shared)
            except (OSError, RuntimeError, NotImplementedError):
                # No process, thread or semaphore.
                self._kill()
                yield from completed_here(function, items, range(done, len(items)))
                return
        # The first series is known to the workers, its items by their numbers.
        handed_out = range(len(items)) if pickled is None else items
        yield from self._in_processes(name, pickled, handed_out, done, early)

    def _in_processes(
        self,
        name: str,
        pickled: bytes | None,
        items: Sequence[Any],
        done: int,
        early: Collection[object],
    ) -> Generator[Chunk, None, None]:
        """Yield chunks of the items that are not done."""
        from concurrent.futures.process import BrokenProcessPool

        assert self._executor is not None, "processes were forked"
        submit = self._executor.submit
        chunks = completed(
            lambda some: submit(work_in_process, pickled, some),
            items, self._capacity, MIN_CHUNK_TIME, done, early=early,
        )  # fmt: skip
        try:
            for chunk in chunks:
                _durations[name] = chunk.duration
                done += len(chunk.results)
                yield chunk
        except BrokenProcessPool as fault:
            raise SolverError(
                "a worker process ended early, perhaps for lack of memory",
                "use fewer workers, as by --workers 1, and --resume where the command has it",
            ) from fault
        finally:
            if done < len(items):
                self._kill()

    def _capacity(self) -> int:
        """Return how many chunks may be in progress.

        Raises
        ------
        BrokenProcessPool
            Unless all worker processes are alive.
        """
        from concurrent.futures.process import BrokenProcessPool

        if not all(process.is_alive() for process in self._processes):
            raise BrokenProcessPool
        return QUEUED_PER_WORKER * len(self._processes)

    def _processes_for(self, name: str, items: int) -> int:
        """Return for how many processes so many items are enough work."""
        least = MIN_TIME_PER_WORKER if self._executor is None else MIN_CHUNK_TIME
        return min(self.workers, items, int(items * _durations.get(name, least) / least))

    def _pickled(self, function: Callable[[Any], Any]) -> bytes | None:
        """Return a function as workers read it; None if they are to be forked."""
        if self._executor is None:
            return None
        places = {id(shared): place for place, shared in enumerate(self._shared)}
        file = BytesIO()

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
            self._processes = [child for child in active_children() if child not in others]
            signal.pthread_sigmask(signal.SIG_SETMASK, signals)

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


# Chunks of items, and their results.


class Chunk(NamedTuple):
    """Consecutive items that were worked on at once."""

    begin: int
    """Number of the first item."""
    size: int
    results: list[Any]
    """Of every item; empty if the workers were lost."""
    duration: float
    """Time that an item took [s]."""


def completed(
    submit: Callable[[Sequence[Item]], Future[tuple[list[Any], float]]],
    items: Sequence[Item],
    capacity: Callable[[], int],
    chunk_time: float = 0.0,
    begin: int = 0,
    *,
    lost: type[Exception] | tuple[()] = (),
    in_progress: dict[Any, range] | None = None,
    early: Collection[object] = (),
) -> Generator[Chunk, None, None]:
    """Yield chunks of items with their results, in the order in which an executor does them.

    Parameters
    ----------
    submit : callable
        Submits consecutive items to an executor; their result is as that of `work_on`.
    items : sequence
    capacity : callable
        Returns how many chunks may be in progress now; raises an error if the workers are
        lost. It is called at least once in `CHECK_INTERVAL`.
    chunk_time : float, optional
        Work of a chunk that is large enough [s].
    begin : int, optional
        Number of the first item to submit.
    lost : type of Exception, optional
        What is raised where workers died: the chunk is yielded without results.
    in_progress : dict, optional
        Holds the futures of submitted chunks, with the numbers of their items.
    early : collection, optional
        Results that wait for earlier ones; nothing is submitted while there are `MAX_EARLY`.

    Raises
    ------
    Exception
        That of the first item that fails, when all chunks before it are done.
    """
    from concurrent.futures import FIRST_COMPLETED, wait

    in_progress = {} if in_progress is None else in_progress
    size, end, fault = 1, len(items), None
    while begin < end or min((each.start for each in in_progress.values()), default=end) < end:
        most = capacity() if len(early) < MAX_EARLY else 0
        while begin < end and len(in_progress) < most:
            # Towards the end chunks are small, so that no worker waits long for the last one.
            numbers = range(begin, begin + max(min(size, (end - begin) // most), 1))
            in_progress[submit(items[begin : numbers.stop])] = numbers
            begin = numbers.stop
        for future in wait(in_progress, CHECK_INTERVAL, FIRST_COMPLETED).done:
            numbers = in_progress.pop(future)
            try:
                results, duration = future.result()
            except lost:
                yield Chunk(numbers.start, len(numbers), [], 0.0)
            except Exception as error:
                if numbers.start < end:
                    end, fault = numbers.start, error
            else:
                # Items may differ: chunks grow only as long as those that are done are short.
                size = min(2 * len(numbers), ceil(chunk_time / max(duration, 1e-9)))
                yield Chunk(numbers.start, len(numbers), results, duration)
    if fault is not None:
        raise fault


def completed_here(
    function: Callable[[Item], Any], items: Sequence[Item], numbers: range
) -> Generator[Chunk, None, None]:
    """Yield items with their results, done in the thread of the consumer."""
    for number in numbers:
        yield Chunk(number, 1, *work_on(function, items[number : number + 1]))


def completed_in_threads(
    function: Callable[[Item], Any],
    items: Sequence[Item],
    threads: int,
    early: Collection[object] = (),
) -> Generator[Chunk, None, None]:
    """Yield the items with their results, as threads do them; `early` as `completed`."""
    if threads <= 1:
        yield from completed_here(function, items, range(len(items)))
        return
    from concurrent.futures import Future, ThreadPoolExecutor, wait

    executor, in_progress = ThreadPoolExecutor(threads), dict[Future[Any], range]()
    try:
        yield from completed(
            lambda some: executor.submit(work_on, function, some),
            items, lambda: QUEUED_PER_WORKER * threads, in_progress=in_progress, early=early,
        )  # fmt: skip
        executor.shutdown()
    finally:
        executor.shutdown(wait=False, cancel_futures=True)
        wait([future for future in in_progress if not future.done()], SHUTDOWN_TIMEOUT)


def in_order(
    chunks: Iterable[Chunk], early: dict[int, list[Any]]
) -> Generator[Any, None, None]:
    """Yield the results of all items in order; `early` holds those that wait for others."""
    due = 0
    for chunk in chunks:
        early[chunk.begin] = chunk.results
        while due in early:
            results = early.pop(due)
            yield from results
            due += len(results)


def as_sequence(items: Iterable[Item]) -> Sequence[Item]:
    """Return the items as a sequence."""
    return items if isinstance(items, Sequence) else list(items)


def work_on(
    function: Callable[[Item], Result], items: Sequence[Item]
) -> tuple[list[Result], float]:
    """Return the results of some items, and the time of one [s]."""
    begin = time.monotonic()
    results = [function(item) for item in items]
    return results, (time.monotonic() - begin) / len(items)


# Worker processes.

_forks = False
"""Whether this process forks workers."""

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


def work_in_process(pickled: bytes | None, items: Sequence[Any]) -> tuple[list[Any], float]:
    """Return what `work_on` does in a worker process; the first function is not pickled."""
    return work_on(_forked[0] if pickled is None else read_function(pickled), items)


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
