"""Link: a client of a Dask scheduler, one that runs already or one of our own."""

from __future__ import annotations

import logging
import ssl
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from queue import Empty, SimpleQueue
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from drysim import machine, regular
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

LONELY = 10.0
"""Time without a worker after which that is said, even by a quiet command [s]."""

LEAST = 4
"""Loads under way while there is no worker yet."""

INSTALL = 'install what it needs by pip install "drysim[cluster]", or leave --cluster out'
WAY = "name three files (PEM) by --tls-ca-file, --tls-cert and --tls-key"

SPEAKERS = (
    "asyncio", "bokeh", "distributed", "distributed.client", "tornado", "tornado.application"
)  # fmt: skip
QUIET = dict.fromkeys(SPEAKERS, "critical")
"""What Dask would log: whatever matters of it we say ourselves."""

UNWATCHED = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}
"""What a cluster of our own need not do beside its work: nobody looks at its pages."""

TLS = "tls://"
"""What the address of a scheduler begins with that asks for certificates."""

Say = Callable[[str], None]


class Certificates(NamedTuple):
    """Files (PEM) by which a scheduler and its clients know each other.

    Attributes
    ----------
    ca_file : Path or None
        Of the authority that all of them trust.
    cert, key : Path or None
        Our own; the key may be in the same file as the certificate.
    """

    ca_file: Path | None = None
    cert: Path | None = None
    key: Path | None = None


class Link:
    """A connection to the workers behind a scheduler."""

    def __init__(self, client: Any, name: str, remedy: str, say: Say, warn: Say) -> None:
        self.client = client
        self.name = name
        self.remedy = remedy
        self.say = say
        self.warn = warn
        self._threads, self._looked = 0, 0.0
        self._said = self._warned = self._had = False
        self._lonely = time.monotonic()

    def room(self) -> int:
        """Give how many loads of blocks may be under way."""
        if time.monotonic() - self._looked > LOOK:
            self.look()
        return max(LEAST, AHEAD * self._threads)

    def look(self) -> None:
        """See how many workers there are; say so where there is none, as that may last.

        Of workers that die, others may take the place: that is waited for.

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
        if self._threads:
            self._had, self._warned, self._lonely = True, False, self._looked
        elif not self._had and not self._said:
            self._said = True
            self.say(f"{self.name} has no worker; waiting for one: {self.remedy}")
        if self._looked - self._lonely >= LONELY and not self._warned:
            self._warned = True
            none = "no worker left" if self._had else f"had no worker for {LONELY:.0f} s"
            why = "; a block may have ended them" * self._had
            self.warn(f"{self.name} has {none}{why}; waiting for one: {self.remedy}")

    def wait(self, landed: SimpleQueue[Any]) -> Any:
        """Give what lands next."""
        while True:
            try:
                return landed.get(timeout=LOOK)
            except Empty:
                self.look()

    def result(self, future: Any) -> Any:
        """Give what a task has come to; it is computed again where its worker died before."""
        patience = LOOK
        while True:
            try:
                return future.result(timeout=patience)
            except TimeoutError:
                self.look()
                patience *= 2.0  # what comes slowly begins anew each time

    def gone(self) -> ClusterError:
        """Give the error for a scheduler that has left us."""
        return ClusterError(
            f"{self.name} is gone; finished blocks are kept",
            "start it again, and the same command with --resume goes on; so does one without "
            "--cluster",
        )


NONE = Certificates()


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
            INSTALL,
        ) from None


@contextmanager
def joined(
    where: str,
    workers: int | None,
    say: Say,
    warn: Say,
    certificates: Certificates = NONE,
) -> Iterator[Link]:
    """Connect to the workers of a scheduler for as long as the block.

    Parameters
    ----------
    where : str
        Address of a scheduler, or `local` for processes of our own.
    workers : int, optional
        How many of them; default: one for each processor.
    say, warn : callable
        Take a sentence for the user; the latter also where he asked for quiet.
    certificates : Certificates, optional
        For an address that begins with `tls://`; what is left out is taken from the settings
        of Dask.

    Raises
    ------
    UsageError
        When there is no scheduler at the address, it does not trust us or we not it, or a
        worker runs something else.
    """
    require()
    import distributed

    if any(certificates) and not where.startswith(TLS):
        raise UsageError(
            f"certificates have no meaning beside --cluster {where}",
            f"give the {TLS} address of a scheduler that knows them; `local` makes its own",
        )

    with ExitStack() as stack:
        if where == LOCAL:
            client, name = stack.enter_context(own(workers)), "the local cluster"
            remedy = "Ctrl-C ends it, and --resume goes on"
        else:
            security = trusted(certificates) if where.startswith(TLS) else None
            try:
                client = distributed.Client(
                    where, timeout=CONNECT, set_as_default=False, security=security
                )
            except (OSError, ValueError, TimeoutError) as fault:
                raise unanswered(where, fault) from fault
            stack.callback(client.close, CONNECT)
            name = f"the scheduler at {where}"
            remedy = f"dask worker {where}"
        refuse_others(client.run(teller(), on_error="return"))
        yield Link(client, name, remedy, say, warn)


def trusted(certificates: Certificates) -> Any:
    """Return what Dask needs to know a scheduler, and to be known by it.

    Raises
    ------
    UsageError
        When certificates are missing, or cannot be read.
    """
    from distributed.security import Security

    ca_file, cert, key = certificates
    words = {"tls_ca_file": ca_file, "tls_client_cert": cert, "tls_client_key": key}
    given = {name: str(file) for name, file in words.items() if file}
    try:
        for file in given.values():
            regular.content(Path(file), 1)
        security = Security(**given, require_encryption=True)
        context = security.get_connection_args("client")["ssl_context"]
    except (OSError, ValueError, regular.Irregular) as fault:
        reason = (getattr(fault, "strerror", None) or str(fault)).lower()
        name = getattr(fault, "filename", None) or " or ".join(given.values())
        raise UsageError(f"the certificates cannot be read: {reason}: {name}", WAY) from fault
    if context is None:
        raise UsageError(f"an address that begins with {TLS} needs certificates", WAY)
    return security


def unanswered(where: str, fault: Exception) -> UsageError:
    """Return the error for a scheduler that does not answer, or not to us."""
    if where.startswith(TLS):
        chain = (fault, fault.__cause__, getattr(fault.__cause__, "__cause__", None))
        told = next((one for one in chain if isinstance(one, ssl.SSLError)), None)
        because = f" ({told.reason or told})" if told else ""
        return UsageError(
            f"no Dask scheduler answers at {where} to these certificates{because}",
            "scheduler, workers and client need certificates of one authority: "
            "--tls-ca-file, --tls-cert, --tls-key",
        )
    return UsageError(
        f"no Dask scheduler answers at {where}",
        "start one, `dask scheduler`, and give the address that it prints, such as "
        "tcp://10.0.0.1:8786",
    )


@contextmanager
def own(workers: int | None) -> Iterator[Any]:
    """Start a scheduler and some workers on this machine, each a process with one thread.

    Whoever may talk to one of them has it run any code. So they take words from those alone who
    have the key that is made here and kept in memory, and no files from a folder of others.
    """
    import dask
    import distributed
    from distributed.security import Security

    with (
        TemporaryDirectory(prefix="drysim-", ignore_cleanup_errors=True) as folder,
        dask.config.set({"logging": QUIET} | UNWATCHED),
        distributed.LocalCluster(
            n_workers=workers or machine.processors(),
            threads_per_worker=1,
            processes=True,
            security=secret(Security),
            local_directory=folder,
            memory_limit=0,
            dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL,
            preload=[deaf.__name__],
        ) as cluster,
        distributed.Client(cluster, set_as_default=False, direct_to_workers=True) as client,
    ):
        yield client


def secret(security: Any) -> Any:
    """Return credentials for one cluster, made by Dask's Security, on no disk.

    Raises
    ------
    UsageError
        When the package is missing that makes them.
    """
    try:
        return security.temporary()
    except ImportError:
        raise UsageError(
            "--cluster local needs the package cryptography, which is not installed", INSTALL
        ) from None
