"""Flight: blocks on their way to the workers and back, few at a time."""

from __future__ import annotations

import warnings
from collections.abc import Generator, Iterable, Iterator
from concurrent.futures import CancelledError
from queue import SimpleQueue
from typing import Any

from drysim.errors import ClusterError
from drysim.study.cluster.link import Link
from drysim.study.cluster.parcel import Parcel, compute

DEADLY = 3
"""Blocks that a message names at most."""

Landed = tuple[int, bytes | None]


def computed(link: Link, parcel: Parcel, numbers: Iterable[int]) -> Generator[Landed]:
    """Give blocks, packed, as the workers finish them; None for one with a case at fault.

    A block under way when its worker dies is begun anew by another. One that was there when
    several died is tried once more alone, so that it is blamed for none but its own deeds.

    Parameters
    ----------
    link : Link
    parcel : Parcel
        What to compute.
    numbers : iterable of int
        Of the blocks that are wanted; taken up as there is room.

    Raises
    ------
    ClusterError
        When the scheduler is lost, or, after all others, for blocks that end their workers.
    """
    flight = Flight(link, parcel)
    yield from flight.through(numbers, None)
    yield from flight.through(flight.suspects(), 1)
    if deadly := flight.suspects():
        those = ", ".join(map(str, deadly[:DEADLY])) + ", ..." * (len(deadly) > DEADLY)
        raise ClusterError(
            f"{len(deadly)} of the blocks end every worker that computes them: {those}; all "
            "others are finished",
            "give the workers more memory, or compute the rest without --cluster by --resume",
        )


class Flight:
    """The blocks that are under way."""

    def __init__(self, link: Link, parcel: Parcel) -> None:
        self.link = link
        self.name = f"drysim-{parcel.digest[:16]}"
        self._held: dict[str, tuple[int, Any]] = {}
        self._landed: SimpleQueue[Any] = SimpleQueue()
        self._suspects: list[int] = []
        self._tries = 0
        with warnings.catch_warnings():
            # A record is as large as it is, and travels once.
            warnings.filterwarnings("ignore", "Sending large graph", UserWarning)
            self._parcel = link.client.submit(handed, parcel, key=self.name)

    def suspects(self) -> list[int]:
        """Give the blocks whose workers died, and forget them."""
        found, self._suspects = self._suspects, []
        return found

    def through(self, numbers: Iterable[int], most: int | None) -> Iterator[Landed]:
        """Give blocks as they come; at most so many are under way, else as many as fit."""
        waiting = iter(numbers)
        self._tries += 1
        while True:
            while len(self._held) < (most or self.link.room()):
                if (number := next(waiting, None)) is None:
                    break
                self._send(number)
            if not self._held:
                return
            yield from self._land()

    def _send(self, number: int) -> None:
        key = f"{self.name}-{number}-{self._tries}"
        future = self.link.client.submit(compute, self._parcel, number, key=key)
        self._held[key] = number, future
        future.add_done_callback(self._landed.put)

    def _land(self) -> Iterator[Landed]:
        """Give the next block that comes, unless its worker died."""
        from distributed import KilledWorker

        future = self.link.wait(self._landed)
        number, _ = self._held.pop(future.key)
        if future.status == "error":
            fault = future.exception()
            if not isinstance(fault, KilledWorker):
                raise told(fault)
            self._suspects.append(number)
            return
        try:
            words = future.result()
        except (CancelledError, OSError, TimeoutError) as fault:
            raise self.link.gone() from fault
        yield number, words


def handed(parcel: Parcel) -> Parcel:
    """Give a parcel as it is: as a task of its own it goes to every worker once."""
    return parcel


def told(fault: BaseException) -> BaseException:
    """Give what a worker has met as an error of ours; a bug stays what it is."""
    if isinstance(fault, ImportError | AttributeError):
        return ClusterError(
            f"a worker that came late cannot compute with this drysim: {fault}",
            "install the same on all machines, start the workers anew, and go on by --resume",
        )
    if isinstance(fault, OSError | MemoryError):
        return ClusterError(
            f"a worker cannot go on: {str(fault) or 'it has run out of memory'}",
            "see to its disk and memory, and go on by --resume",
        )
    return fault
