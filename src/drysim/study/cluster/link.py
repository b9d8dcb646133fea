"""Link: a client of a Dask scheduler, one that runs already or one of our own."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from queue import Empty, SimpleQueue
from typing import Any

from drysim import machine
from drysim.errors import ClusterError, UsageError
from drysim.study.cluster import deaf
from drysim.study.cluster.alike import refuse_others, teller

LOCAL = "local"
"""The word for processes on this machine in place of the address of a scheduler."""

CONNECT = 10.0
"""Time that a scheduler may take to answer [s]."""

LOOK = 2.0
"""Time between two looks at how many workers there are [s]."""

AHEAD = 2
"""Loads under way for each thread of a worker: one at work, the other waiting or coming."""

LEAST = 4
"""Loads under way while there is no worker yet."""

SPEAKERS = ("distributed", "distributed.client", "bokeh", "tornado", "tornado.application")
QUIET = dict.fromkeys(SPEAKERS, "critical")
"""What Dask would log: whatever matters of it we say ourselves."""

UNWATCHED = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.system-monitor.interval": "5s",
}
"""What workers of our own need not do beside their work: nobody looks at their profiles."""

Say = Callable[[str], None]


class Link:
    """A connection to the workers behind a scheduler."""

    def __init__(self, client: Any, name: str, say: Say) -> None:
        self.client = client
        self.name = name
        self.say = say
        self._threads, self._looked, self._told = 0, 0.0, False

    def room(self) -> int:
        """Give how many loads of blocks may be under way."""
        if time.monotonic() - self._looked > LOOK:
            self.look()
        return max(LEAST, AHEAD * self._threads)

    def look(self) -> None:
        """See how many workers there are; say so where there is none, as that may last.

        Raises
        ------
        ClusterError
            When the scheduler has left us.
        """
        try:
            self._threads = sum(self.client.nthreads().values())
        except (OSError, TimeoutError) as fault:
            raise self.gone() from fault
        self._looked = time.monotonic()
        if not self._threads and not self._told:
            self._told = True
            self.say(
                f"{self.name} has no worker; waiting for one: dask worker "
                f"{self.client.scheduler.address}"
            )

    def wait(self, landed: SimpleQueue[Any]) -> Any:
        """Give what lands next."""
        while True:
            try:
                return landed.get(timeout=LOOK)
            except Empty:
                self.look()

    def gone(self) -> ClusterError:
        """Give the error for a scheduler that has left us."""
        return ClusterError(
            f"{self.name} is gone; finished blocks are kept",
            "start it again, and the same command with --resume goes on; so does one without "
            "--cluster",
        )


def require() -> None:
    """Make sure that Dask is there.

    Raises
    ------
    UsageError
        With the command that installs it.
    """
    try:
        import dask

        with dask.config.set(logging=QUIET):  # which it reads when it is loaded
            import distributed  # noqa: F401 - only whether it is there
    except ImportError:
        raise UsageError(
            "--cluster needs the packages dask and distributed, which are not installed",
            'install them by pip install "drysim[cluster]", or leave --cluster out',
        ) from None


@contextmanager
def joined(where: str, workers: int | None, say: Say) -> Iterator[Link]:
    """Connect to the workers of a scheduler for as long as the block.

    Parameters
    ----------
    where : str
        Address of a scheduler, or `local` for processes of our own.
    workers : int, optional
        How many of them; default: one for each processor.
    say : callable
        Takes a sentence for the user.

    Raises
    ------
    UsageError
        When there is no scheduler at the address, or a worker runs something else.
    """
    require()
    import distributed

    with ExitStack() as stack:
        if where == LOCAL:
            client, name = stack.enter_context(own(workers)), "the local cluster"
        else:
            try:
                client = distributed.Client(where, timeout=CONNECT, set_as_default=False)
            except (OSError, ValueError, TimeoutError) as fault:
                raise UsageError(
                    f"no Dask scheduler answers at {where}",
                    "start one, `dask scheduler`, and give the address that it prints, such as "
                    "tcp://10.0.0.1:8786",
                ) from fault
            stack.callback(client.close, CONNECT)
            name = f"the scheduler at {where}"
        refuse_others(client.run(teller(), on_error="return"))
        yield Link(client, name, say)


@contextmanager
def own(workers: int | None) -> Iterator[Any]:
    """Start a scheduler and some workers on this machine, each a process with one thread."""
    import dask
    import distributed

    with (
        dask.config.set({"logging": QUIET} | UNWATCHED),
        distributed.LocalCluster(
            n_workers=workers or machine.processors(),
            threads_per_worker=1,
            processes=True,
            memory_limit=0,
            dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL,
            preload=[deaf.__name__],
        ) as cluster,
        distributed.Client(cluster, set_as_default=False, direct_to_workers=True) as client,
    ):
        yield client
