"""Blocks of a sweep on the workers of a Dask cluster: one that runs already, or one of our own.

`joined` connects to a scheduler and makes sure that all workers run what runs here, else their
numbers might differ. `solved` then gives the cases in order: workers compute the blocks from a
parcel with all that the sweep stands on, while they are kept and told here. Several blocks go
together, so that handing them out costs little; one under way when its worker dies is begun
anew by another. Whatever is lost, finished blocks are kept, and the same command goes on.
"""

from __future__ import annotations

import hashlib
import logging
import signal
import ssl
import tempfile
import time
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import islice
from pathlib import Path
from queue import Empty, SimpleQueue
from shutil import rmtree
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, Self
from uuid import uuid4
from weakref import finalize

from drysim import system
from drysim.core import compile
from drysim.errors import ClusterError, DrysimError, UsageError
from drysim.scenario.load import load
from drysim.scenario.model import Scenario
from drysim.study.case import named_files, prepare
from drysim.study.plan import Piece, Plan, approaches_of
from drysim.study.statistics import Batch
from drysim.study.store import Store, packed
from drysim.yaml_document import dump

Say = Callable[[str], None]

TLS = "tls://"
"""What the address of a scheduler begins with that asks for certificates."""

LOCAL = "local"
"""The word for processes on this machine in place of the address of a scheduler."""

CONNECT = 10.0
"""Time that a scheduler may take to answer [s]."""

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


NONE = Certificates()


@contextmanager
def joined(
    where: str, workers: int | None, say: Say, warn: Say, certificates: Certificates = NONE
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


def require() -> None:
    """Raise a UsageError with the command that installs it unless Dask is there."""
    try:
        import dask

        with dask.config.set(logging=QUIET):  # which it reads when it is loaded
            import distributed  # noqa: F401 - only whether it is there
    except ImportError:
        raise UsageError(
            "--cluster needs the packages dask and distributed, which are not installed",
            INSTALL,
        ) from None


def trusted(certificates: Certificates) -> Any:
    """Return what Dask needs to know a scheduler, and to be known by it.

    A UsageError says when certificates are missing, or cannot be read.
    """
    from distributed.security import Security

    ca_file, cert, key = certificates
    words = {"tls_ca_file": ca_file, "tls_client_cert": cert, "tls_client_key": key}
    given = {name: str(file) for name, file in words.items() if file}
    try:
        for file in given.values():
            system.content(Path(file), 1)
        security = Security(**given, require_encryption=True)
        context = security.get_connection_args("client")["ssl_context"]
    except (OSError, ValueError, system.Irregular) as fault:
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
            n_workers=workers or system.processors(),
            threads_per_worker=1,
            processes=True,
            security=secret(Security),
            local_directory=folder,
            memory_limit=0,
            dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL,
            preload=[__name__],
        ) as cluster,
        distributed.Client(cluster, set_as_default=False, direct_to_workers=True) as client,
    ):
        yield client


def dask_setup(worker: object) -> None:
    """Make a worker of our own ignore Ctrl-C at the terminal: it ends when we do.

    Dask calls it in every worker, which preloads this module.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def secret(security: Any) -> Any:
    """Return credentials for one cluster, made by Dask's Security, on no disk."""
    try:
        return security.temporary()
    except ImportError:
        raise UsageError(
            "--cluster local needs the package cryptography, which is not installed", INSTALL
        ) from None


LOOK = 2.0
"""Time between two looks at how many workers there are [s]."""

AHEAD = 2
"""Loads under way for each thread of a worker: one at work, the other waiting or coming."""

LONELY = 10.0
"""Time without a worker after which that is said, even by a quiet command [s]."""

LEAST = 4
"""Loads under way while there is no worker yet."""


class Link:
    """A connection to the workers behind a scheduler."""

    def __init__(self, client: Any, name: str, remedy: str, say: Say, warn: Say) -> None:
        self.client, self.name, self.remedy = client, name, remedy
        self.say, self.warn = say, warn
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

        Of workers that die, others may take the place: that is waited for. A ClusterError says
        when the scheduler has left us.
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


# Whether the workers run what runs here: else their numbers might differ.

Versions = Mapping[str, str | None]

PACKAGES = ("drysim", "numpy", "scipy", "numba", "distributed")
"""Whatever a number or its way may depend on."""


def teller() -> Callable[[], dict[str, str | None]]:
    """Give a function that tells the versions of everything that numbers depend on.

    It carries all that it needs, so that it also runs where there is no drysim, or another.
    """
    names = PACKAGES

    def told() -> dict[str, str | None]:
        import hashlib
        import importlib
        import pathlib
        import platform

        found: dict[str, str | None] = {"Python": ".".join(platform.python_version_tuple()[:2])}
        for name in names:
            try:
                found[name] = str(importlib.import_module(name).__version__)
            except Exception:
                found[name] = None
        found["source of drysim"] = None
        if found["drysim"] is not None:
            home = pathlib.Path(str(importlib.import_module("drysim").__file__)).parent
            files = sorted(home.rglob("*.py"), key=lambda file: file.relative_to(home).parts)
            content = b"".join(file.read_bytes() for file in files)
            found["source of drysim"] = hashlib.sha256(content).hexdigest()[:12]
        return found

    return told


@cache
def versions() -> Versions:
    """Give the versions of what runs here."""
    return teller()()


def refuse_others(there: Mapping[str, Any]) -> None:
    """Raise a UsageError unless all workers, by address, tell what runs here.

    In place of what it runs, a worker may tell an exception.
    """
    for worker, told in there.items():
        if isinstance(told, BaseException):
            raise UsageError(f"the worker {worker} cannot be asked: {told}", remedy(versions()))
        if other := difference(told, versions()):
            raise UsageError(f"the worker {worker} {other}", remedy(versions()))


def refuse_late(asked: Versions) -> None:
    """Raise a ClusterError unless this worker runs what runs where its work comes from."""
    if other := difference(versions(), asked):
        from distributed import get_worker

        worker = f"the worker {get_worker().address}, which has come late,"
        raise ClusterError(f"{worker} {other}", f"{remedy(asked)}; --resume goes on")


def difference(there: Versions, here: Versions) -> str:
    """Say what is other there; empty where nothing is."""
    for name, version in here.items():
        if there.get(name) != version:
            has = f"has {name} {there[name]}" if there.get(name) else f"has no {name}"
            return f"{has}, here is {version}"
    return ""


def remedy(here: Versions) -> str:
    """Say how to make all machines alike."""
    words = " ".join(f"{name}=={here[name]}" for name in PACKAGES)
    return f"install the same on all machines, pip install {words}, and start the workers anew"


# Blocks on their way to the workers and back, few of them at a time.


def solved(
    plan: Plan, scenario: Scenario, link: Link, store: Store, finished: Callable[[Batch], None]
) -> Iterator[tuple[Piece, Batch]]:
    """Give the cases of every piece in order, as `study.sweep.solved` does.

    A block is kept as soon as it comes, whatever its turn: whoever is killed here loses no more
    than is under way. In its turn it is read again, so that none is held meanwhile.
    """
    wanted = (k for k, piece in enumerate(plan.pieces) if not store.holds(piece))
    come: set[int] = set()
    parcel = Parcel.of(scenario, store.sweep)
    with closing(computed(link, parcel, wanted, len(plan.pieces))) as flight:
        for turn, piece in enumerate(plan.pieces):
            while (batch := store.read(piece)) is None:
                # A fault of a case is met again here, where its file and line are known.
                number, words = next(flight, (turn, None))
                store.keep(
                    plan.pieces[number], words or packed(plan.block(number), store.sweep)
                )
                come.add(number)
            if turn in come:
                come.remove(turn)
                finished(batch)
            yield piece, batch


DEADLY = 3
"""Blocks that a message names at most."""

Landed = tuple[int, bytes | None]


def computed(
    link: Link, parcel: Parcel, numbers: Iterable[int], count: int
) -> Generator[Landed]:
    """Give blocks, packed, as the workers finish them; None for one with a case at fault.

    A block under way when its worker dies is begun anew by another. One that was there when
    several died is tried once more alone, so that it is blamed for none but its own deeds.
    The numbers of those wanted ascend, and are taken up as there is room; of all blocks there
    are `count`, wanted or not: towards the end fewer go together.

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
        self.link, self.name = link, f"drysim-{parcel.digest[:16]}"
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


WORK = 0.5
"""Work that goes together [s]: a task of its own costs scheduler, worker and client some 6 ms
of processor time, however little there is in it."""

MOST_BYTES = 16_000_000
"""Bytes that come back together at most: a scheduler passes them on whole."""


class Load:
    """How many blocks go to a worker together; what has come tells of what is to come.

    The first go one by one: nobody knows yet what they take. The last go one by one, too, so
    that no worker is left with many of them while others have none.
    """

    def __init__(self, count: int) -> None:
        self._count = self._left = count  # with those that nobody wants any more
        self._fit = 1

    def blocks(self, room: int) -> int:
        """Give how many go together now, where so many tasks may be under way."""
        return max(1, min(self._fit, self._left // room))

    def sent(self, numbers: Sequence[int]) -> None:
        """Note which blocks are on their way."""
        self._left = self._count - numbers[-1] - 1

    def took(self, blocks: Sequence[bytes | None], seconds: float) -> None:
        """Note how long some blocks took."""
        size = sum(map(len, filter(None, blocks)))
        share = max(seconds / WORK, size / MOST_BYTES, 1e-9)
        self._fit = max(1, int(len(blocks) / share))


# What a worker does: a parcel, which travels once, holds all that it needs for any block.

SCENARIO = "scenario.yaml"

SWEEPS_KEPT = 2
"""Sweeps that a worker keeps open: the latest, and one that is worked at beside it."""


@dataclass(frozen=True)
class Parcel:
    """A scenario as words, and the files that it names; no worker reads another disk.

    Attributes
    ----------
    words : str
        The resolved scenario as YAML, its files named as they are here.
    files : tuple of (str, bytes)
        Names and contents.
    versions : tuple of (str, str)
        What runs where the parcel was made up.
    sweep : str
        Digest of the sweep, which its blocks bear.
    """

    words: str
    files: tuple[tuple[str, bytes], ...]
    versions: tuple[tuple[str, str | None], ...]
    sweep: str

    @classmethod
    def of(cls, scenario: Scenario, sweep: str) -> Self:
        """Give the parcel of a scenario whose files are there."""
        words, files = scenario.resolved(), []
        for number, (keys, path) in enumerate(named_files(scenario)):
            name = f"{number}{path.suffix}"
            files.append((name, path.read_bytes()))
            block: Any = words
            for key in keys:
                block = block[key]
            block["file"] = name
        return cls(dump(words), tuple(files), tuple(versions().items()), sweep)

    @property
    def digest(self) -> str:
        """The SHA-256 (hex) of everything in it."""
        digest = hashlib.sha256(f"{self.sweep}\0{self.words}".encode())
        for name, content in self.files:
            digest.update(f"\0{name}\0{len(content)}\0".encode())
            digest.update(content)
        return digest.hexdigest()


@lru_cache(SWEEPS_KEPT)
def opened(parcel: Parcel) -> Plan:
    """Give the plan that a parcel holds.

    A worker lives longer than a sweep, so it compiles: a small one may not settle for plain.
    """
    compile.settle(compile.PLAIN_STEPS + 1)
    folder = Path(tempfile.mkdtemp(prefix="drysim-", dir=own_folder()))
    with ExitStack() as leave:
        leave.callback(rmtree, folder, ignore_errors=True)
        (folder / SCENARIO).write_text(parcel.words, encoding="utf-8")
        for file, content in parcel.files:
            (folder / file).write_bytes(content)
        case = prepare(load(folder / SCENARIO))
        plan = Plan.of(approaches_of(case.scenario), case)
        if parcel.files:  # long samples stay in their file
            finalize(plan, leave.pop_all().close)
    return plan


def own_folder() -> str | None:
    """Give the folder of this worker, None outside of one.

    When a worker was killed, the next one on its machine removes what it has left there.
    """
    from distributed import get_worker

    try:
        return str(get_worker().local_directory)
    except ValueError:
        return None


def compute(parcel: Parcel, numbers: Sequence[int]) -> tuple[list[bytes | None], float]:
    """Give blocks, packed, and the processor time that they took [s].

    A block with a case at fault is None, as whoever asks can say better what is wrong.

    Raises
    ------
    ClusterError
        When this worker, which has come late, runs something else.
    """
    refuse_late(dict(parcel.versions))
    began = time.thread_time()
    return [_block(parcel, number) for number in numbers], time.thread_time() - began


def _block(parcel: Parcel, number: int) -> bytes | None:
    """Give a block, packed; None where a case is at fault."""
    try:
        return packed(opened(parcel).block(number), parcel.sweep)
    except DrysimError:
        return None
