"""Regular files alone are read: no device is opened, no pipe waited for. Knows no format."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path

Stamp = tuple[int, int, int]

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
