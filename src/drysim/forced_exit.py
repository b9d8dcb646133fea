"""Forced exit: a process is to end while a kernel is running, which nothing can interrupt.

A thread of its own calls `clean_up`, and then ends the process. Until then the other threads go
on, so a clean-up must expect that files change while it runs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from threading import Lock

CleanUp = Callable[[], str | None]

_clean_ups: list[CleanUp] = []
"""What to do before a forced exit; each may return a message."""

_exit_lock = Lock()
"""Held by a forced exit until the process ends, and by work that it must not divide."""


@contextmanager
def at_forced_exit(action: CleanUp, last: bool = False) -> Iterator[None]:
    """Call a function before a forced exit that comes while the block runs.

    `last` is for what may block, such as a terminal: all others are called before.
    """
    _clean_ups.insert(0 if last else len(_clean_ups), action)
    try:
        yield
    finally:
        _clean_ups.remove(action)


@contextmanager
def no_forced_exit() -> Iterator[None]:
    """Delay a forced exit until the block has run; if it has begun, wait here for the end."""
    with _exit_lock:
        yield


def clean_up() -> str:
    """Run the clean-ups, the latest first; return their message. The process must end then."""
    _exit_lock.acquire()
    messages = []
    for action in reversed(_clean_ups):
        with suppress(Exception):
            messages.append(action() or "")
    return "".join(messages)
