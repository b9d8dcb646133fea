"""Work in threads whose results come in the order in which it was asked for."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import TypeVar

Asked = TypeVar("Asked")
Given = TypeVar("Given")

AHEAD = 2
"""Pieces of work in hand for each thread: one under way and one waiting for it."""

PATIENCE = 1.0
"""How long work under way is waited for that nobody needs any more [s]."""


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
