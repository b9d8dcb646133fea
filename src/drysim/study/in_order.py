"""Work in threads whose results come in the order in which it was asked for."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

Asked = TypeVar("Asked")
Given = TypeVar("Given")

AHEAD = 2
"""Pieces of work in hand for each thread: one under way and one waiting for it."""


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
    Whoever has seen enough closes the generator; work under way is waited for and dropped.
    """
    if threads == 1:
        yield from map(work, pieces)
        return
    hands, waiting = ThreadPoolExecutor(threads), deque[Future[Given]]()
    try:
        for piece in pieces:
            waiting.append(hands.submit(work, piece))
            if len(waiting) == AHEAD * threads:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        # An interrupt waits for the work under way, not for what is in the queue.
        hands.shutdown(cancel_futures=True)
