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
from drysim.units import short


def memory() -> float:
    """Give the memory of this machine [bytes]; infinity where the system does not tell."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return float("inf")


def processors() -> int:
    """Give the number of processors; 1 where the system does not tell."""
    return os.cpu_count() or 1


# Files.


Stamp = tuple[int, int, int]
"""Inode, size [bytes] and time of the last change [ns] of a file."""

KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


class Irregular(Exception):
    """What stands at a path is no regular file; says what it is."""


def size(path: Path) -> int:
    """Give the size [bytes] of a regular file without opening it; links are followed.

    Raises
    ------
    Irregular
        When it is something else: to open a device may already do something.
    OSError, ValueError
        When there is nothing, or nothing that we may see.
    """
    about = path.stat()
    _refuse_others(about)
    return about.st_size


def content(path: Path, most: int) -> bytes:
    """Give what a regular file holds, at most so many bytes; errors as in `size`."""
    with opened(path) as stream:
        return stream.read(most)


@contextmanager
def opened(path: Path) -> Iterator[BufferedReader]:
    """Open a regular file to read its bytes; errors as in `size`."""
    with open(path, "rb", opener=_without_waiting) as stream:
        _refuse_others(os.fstat(stream.fileno()))  # it may be another one by now
        yield stream


def stamp_of(file: Path | int) -> Stamp:
    """Give what tells a file, open or not, from another, and from itself before a change."""
    about = os.stat(file)
    return about.st_ino, about.st_size, about.st_mtime_ns


def _refuse_others(about: os.stat_result) -> None:
    if not stat.S_ISREG(about.st_mode):
        kinds = (name for test, name in KINDS if test(about.st_mode))
        raise Irregular(next(kinds, "no ordinary file"))


def _without_waiting(path: str, flags: int) -> int:
    """Open a file; a pipe that nobody writes to does not hold us up."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def removed(folder: Path) -> OutputError:
    """Return the error for a `<name>.partial` that lost files while it was in use."""
    return OutputError(
        f"{folder} was removed, in whole or in part, while drysim was writing it",
        "let nothing else write there, and run the command again",
    )


# Threads.


Asked = TypeVar("Asked")
Given = TypeVar("Given")

AHEAD = 2
"""Pieces of work in hand for each thread: one under way and one waiting for it."""

PATIENCE = 1.0
"""How long work under way is waited for that nobody needs any more [s]."""


def hands(workers: int | None) -> int:
    """Give the number of threads: as many as asked for, else one for each processor.

    Raises
    ------
    UsageError
        When it is no number of threads.
    """
    if workers is None:
        return processors()
    if isinstance(workers, bool) or not isinstance(workers, Integral) or workers < 1:
        given = short(repr(workers))
        raise UsageError(f"workers must be a whole number of at least 1, not {given}")
    return int(workers)


def in_order(
    work: Callable[[Asked], Given], pieces: Iterable[Asked], threads: int
) -> Generator[Given, None, None]:
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
        yield from map(work, pieces)
        return
    hands, waiting = ThreadPoolExecutor(threads), deque[Future[Given]]()
    try:
        for piece in pieces:
            waiting.append(hands.submit(work, piece))
            if len(waiting) == AHEAD * threads:
                yield first(waiting)
        while waiting:
            yield first(waiting)
    finally:
        hands.shutdown(wait=False, cancel_futures=True)
        wait([one for one in waiting if not one.done()], PATIENCE)


def first(waiting: deque[Future[Given]]) -> Given:
    """Remove the first future and return its result; one that is not done stays."""
    given = waiting[0].result()
    waiting.popleft()
    return given
