"""The operating system: memory, processors, regular files and an ordered thread pool.

Only regular files are read. Opening a device can have side effects, and reading a pipe can
block forever.
"""

from __future__ import annotations

import os
import stat
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from io import BufferedReader
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from drysim.errors import OutputError, UsageError
from drysim.units import shorten

if TYPE_CHECKING:
    from concurrent.futures import Future


def total_memory() -> float:
    """Return the physical memory [bytes]; infinity where the system does not report it."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return float("inf")


def processor_count() -> int:
    """Return the number of processors; 1 where the system does not report it."""
    return os.cpu_count() or 1


# Files.


FileSignature = tuple[int, int, int]
"""Inode, size [bytes] and time of the last change [ns] of a file."""

FILE_TYPES = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


class NotARegularFile(Exception):
    """A path that is no regular file; the message names its type."""


def file_size(path: Path) -> int:
    """Return the size [bytes] of a regular file without opening it; links are followed.

    Parameters
    ----------
    path : Path

    Raises
    ------
    NotARegularFile
        If the path is a folder, pipe, socket or device. Opening a device can have side effects.
    OSError, ValueError
        If the path does not exist or is not accessible.
    """
    status = path.stat()
    _require_regular_file(status)
    return status.st_size


def read_regular_file(path: Path, max_bytes: int) -> bytes:
    """Return at most `max_bytes` bytes of a regular file; raises like `file_size`."""
    with open_regular_file(path) as stream:
        return stream.read(max_bytes)


@contextmanager
def open_regular_file(path: Path) -> Iterator[BufferedReader]:
    """Open a regular file for reading bytes; raises like `file_size`."""
    with open(path, "rb", opener=_open_nonblocking) as stream:
        _require_regular_file(os.fstat(stream.fileno()))  # it may have been replaced since
        yield stream


def file_signature(file: Path | int) -> FileSignature:
    """Return a signature that differs between two files and changes when a file is modified.

    Parameters
    ----------
    file : Path or int
        A path, or the descriptor of an open file.
    """
    status = os.stat(file)
    return status.st_ino, status.st_size, status.st_mtime_ns


def _require_regular_file(status: os.stat_result) -> None:
    """Raise `NotARegularFile` unless the file is regular."""
    if not stat.S_ISREG(status.st_mode):
        kinds = (name for test, name in FILE_TYPES if test(status.st_mode))
        raise NotARegularFile(next(kinds, "a special file"))


def _open_nonblocking(path: str, flags: int) -> int:
    """Open a file without blocking on a pipe that has no writer."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def removed_error(folder: Path) -> OutputError:
    """Return the error for a `<name>.partial` folder that lost files while in use."""
    return OutputError(
        f"{folder} was removed, in whole or in part, while drysim was writing it",
        "make sure that no other process writes there, and run the command again",
    )


# Threads.


Item = TypeVar("Item")
Result = TypeVar("Result")

QUEUED_PER_THREAD = 2
"""Submitted items per thread: one in progress and one queued, so that no thread runs idle."""

SHUTDOWN_TIMEOUT = 0.25
"""Longest wait for running items after the results are no longer needed [s]."""


def worker_count(workers: int | None) -> int:
    """Return the number of threads; by default one per processor.

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
        received = shorten(repr(workers))
        raise UsageError(f"workers must be a whole number of at least 1, not {received}")
    return int(workers)


def map_in_order(
    function: Callable[[Item], Result], items: Iterable[Item], threads: int
) -> Generator[Result, None, None]:
    """Yield `function(item)` for every item, in order, with few items in progress at a time.

    Parameters
    ----------
    function : callable
        Must be safe to call from several threads.
    items : iterable
        Consumed as threads become free.
    threads : int
        With 1 the function is called in the thread of the consumer.

    Yields
    ------
    object
        The results, in the order of the items.

    Notes
    -----
    Closing the generator cancels the queued items. Running items are waited for at most
    `SHUTDOWN_TIMEOUT`, so that a kernel that does not return cannot keep the process alive.
    """
    if threads == 1:
        yield from map(function, items)
        return
    from concurrent.futures import ThreadPoolExecutor, wait

    executor = ThreadPoolExecutor(threads)
    futures: deque[Future[Result]] = deque()
    try:
        for item in items:
            futures.append(executor.submit(function, item))
            if len(futures) == QUEUED_PER_THREAD * threads:
                yield pop_first_result(futures)
        while futures:
            yield pop_first_result(futures)
    finally:
        executor.shutdown(wait=False, cancel_futures=True)
        wait([one for one in futures if not one.done()], SHUTDOWN_TIMEOUT)


def pop_first_result(futures: deque[Future[Result]]) -> Result:
    """Remove the first future and return its result; it stays in place if interrupted."""
    result = futures[0].result()
    futures.popleft()
    return result
