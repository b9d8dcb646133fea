"""Flight: blocks on their way to the workers and back, few of them at a time."""

from __future__ import annotations

import warnings
from collections.abc import Generator, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import suppress
from itertools import islice
from queue import SimpleQueue
from typing import Any
from uuid import uuid4

from drysim.errors import ClusterError
from drysim.study.cluster.link import Link
from drysim.study.cluster.load import Load
from drysim.study.cluster.parcel import Parcel, compute

DEADLY = 3
"""Blocks that a message names at most."""

Landed = tuple[int, bytes | None]


def computed(
    link: Link, parcel: Parcel, numbers: Iterable[int], count: int
) -> Generator[Landed]:
    """Give blocks, packed, as the workers finish them; None for one with a case at fault.

    A block under way when its worker dies is begun anew by another. One that was there when
    several died is tried once more alone, so that it is blamed for none but its own deeds.

    Parameters
    ----------
    link : Link
    parcel : Parcel
        What to compute.
    numbers : iterable of int
        Of the blocks that are wanted, ascending; taken up as there is room.
    count : int
        How many blocks there are, wanted or not: towards the end fewer go together.

    Raises
    ------
    ClusterError
        When the scheduler is lost, or, after all others, for blocks that end their workers.
    """
    flight = Flight(link, parcel)
    yield from flight.through(numbers, Load(count))
    yield from flight.through(flight.suspects(), None)
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
        self._held: dict[str, tuple[list[int], Any]] = {}
        self._landed: SimpleQueue[Any] = SimpleQueue()
        self._suspects: list[int] = []
        self._tries = 0
        self._parcel = self._shared(parcel) if parcel.files else parcel

    def _shared(self, parcel: Parcel) -> Any:
        """Give a parcel that is too large to go with every load: as a task of its own.

        So it goes to every worker once; but a scheduler prefers those that have it already.
        """
        with warnings.catch_warnings():
            # A record is as large as it is.
            warnings.filterwarnings("ignore", "Sending large graph", UserWarning)
            return self.link.client.submit(handed, parcel, key=f"parcel-of-{self.name}")

    def suspects(self) -> list[int]:
        """Give the blocks whose workers died, and forget them."""
        found, self._suspects = self._suspects, []
        return found

    def through(self, numbers: Iterable[int], load: Load | None) -> Iterator[Landed]:
        """Give blocks as they come: as many under way as fit, or without a load one alone."""
        waiting = iter(numbers)
        self._tries += 1
        while True:
            while len(self._held) < (room := self.link.room() if load else 1):
                if not (some := list(islice(waiting, load.blocks(room) if load else 1))):
                    break
                self._send(some)
                if load:
                    load.sent(some)
            if not self._held:
                return
            yield from self._land(load)

    def _send(self, numbers: list[int]) -> None:
        # Never the key of another client of the same sweep, whose load may hold other blocks.
        key = f"{self.name}-{uuid4().hex[:12]}-{numbers[0]}-{self._tries}"
        future = self.link.client.submit(compute, self._parcel, numbers, key=key)
        self._held[key] = numbers, future
        future.add_done_callback(self._landed.put)

    def _land(self, load: Load | None) -> Iterator[Landed]:
        """Give the blocks that come next, unless their worker died."""
        from distributed import KilledWorker

        future = self.link.wait(self._landed)
        numbers, _ = self._held.pop(future.key)
        try:
            if future.status == "error":
                fault = future.exception()
                if not isinstance(fault, KilledWorker):
                    raise told(fault)
                self._suspects.extend(numbers)
                return
            blocks, took = self.link.result(future)
        except (CancelledError, OSError, TimeoutError) as fault:
            raise self.link.gone() from fault
        finally:
            with suppress(RuntimeError):  # of a loop that is closed
                future.release()  # here: an interrupt is lost in what Python does by itself
        if load:
            load.took(blocks, took)
        yield from zip(numbers, blocks, strict=True)


def handed(parcel: Parcel) -> Parcel:
    """Give a parcel as it is."""
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
