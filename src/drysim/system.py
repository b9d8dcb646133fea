"""The machine: its memory and processors, its files, and threads that work in order.

Only regular files are read: no device is opened, no pipe waited for. Nothing here knows what is
in them, or what the threads work on.
"""

from __future__ import annotations

import os
import stat
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from io import BufferedReader
from numbers import Integral
from pathlib import Path
from typing import TypeVar

from drysim.errors import OutputError, UsageError
from drysim.units import shorten


def total_memory() -> float:
    """Give the memory of this machine [bytes]; infinity where the system does not tell."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return float("inf")


def processor_count() -> int:
    """Give the number of processors; 1 where the system does not tell."""
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
    """What stands at a path is no regular file; says what it is."""


def file_size(path: Path) -> int:
    """Give the size [bytes] of a regular file without opening it; links are followed.

    Raises
    ------
    Irregular
        When it is something else: to open a device may already do something.
    OSError, ValueError
        When there is nothing, or nothing that we may see.
    """
    status = path.stat()
    _require_regular_file(status)
    return status.st_size


def read_regular_file(path: Path, most: int) -> bytes:
    """Give what a regular file holds, at most so many bytes; errors as in `file_size`."""
    with open_regular_file(path) as stream:
        return stream.read(most)


@contextmanager
def open_regular_file(path: Path) -> Iterator[BufferedReader]:
    """Open a regular file to read its bytes; errors as in `file_size`."""
    with open(path, "rb", opener=_open_nonblocking) as stream:
        _require_regular_file(os.fstat(stream.fileno()))  # it may be another one by now
        yield stream


def file_signature(file: Path | int) -> FileSignature:
    """Give what tells a file, open or not, from another, and from itself before a change."""
    status = os.stat(file)
    return status.st_ino, status.st_size, status.st_mtime_ns


def _require_regular_file(status: os.stat_result) -> None:
    if not stat.S_ISREG(status.st_mode):
        kinds = (name for test, name in FILE_TYPES if test(status.st_mode))
        raise NotARegularFile(next(kinds, "no ordinary file"))


def _open_nonblocking(path: str, flags: int) -> int:
    """Open a file; a pipe that nobody writes to does not hold us up."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def removed_error(folder: Path) -> OutputError:
    """Return the error for a `<name>.partial` that lost files while it was in use."""
    return OutputError(
        f"{folder} was removed, in whole or in part, while drysim was writing it",
        "let nothing else write there, and run the command again",
    )


# Threads.


Item = TypeVar("Item")
Result = TypeVar("Result")

QUEUED_PER_THREAD = 2
"""Pieces of work in hand for each thread: one under way and one waiting for it."""

SHUTDOWN_TIMEOUT = 1.0
"""How long work under way is waited for that nobody needs any more [s]."""


def worker_count(workers: int | None) -> int:
    """Give the number of threads: as many as asked for, else one for each processor.

    Raises
    ------
    UsageError
        When it is no number of threads.
    """
    if workers is None:
        return processor_count()
    if isinstance(workers, bool) or not isinstance(workers, Integral) or workers < 1:
        given = shorten(repr(workers))
        raise UsageError(f"workers must be a whole number of at least 1, not {given}")
    return int(workers)


def map_in_order(
    function: Callable[[Item], Result], items: Iterable[Item], threads: int
) -> Generator[Result, None, None]:
    """Give the result of every piece of work, in order; few of them are held at a time.

    Parameters
    ----------
    work : callable
        Whatever it does, it does for one piece alone.
    pieces : iterable
        Taken up as threads become free.
    threads : int
        With a single one the work is done by whoever asks.

    Notes
    -----
    Whoever has seen enough closes the generator, or is interrupted. Work under way is dropped
    then, and waited for only so long that an endless kernel does not keep the process.
    """
    if threads == 1:
        yield from map(function, items)
        return
    executor, futures = ThreadPoolExecutor(threads), deque[Future[Result]]()
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
    """Remove the first future and return its result; one that is not done stays."""
    result = futures[0].result()
    futures.popleft()
    return result
