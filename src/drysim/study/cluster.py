"""Blocks of a sweep on the workers of a Dask cluster: one that runs already, or one of our own.

`connect` connects to a scheduler and makes sure that all workers run what runs here, else their
numbers might differ. `solve_ranges` then gives the cases in order: workers compute the blocks from a
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
from drysim.study.plan import CaseRange, Plan, approaches_of
from drysim.study.statistics import Batch
from drysim.study.store import Store, pack
from drysim.yaml_document import dump

MessageSink = Callable[[str], None]

TLS_SCHEME = "tls://"
"""What the address of a scheduler begins with that asks for certificates."""

LOCAL = "local"
"""The word for processes on this machine in place of the address of a scheduler."""

CONNECT_TIMEOUT = 10.0
"""Time that a scheduler may take to answer [s]."""

INSTALL_HINT = 'install what it needs by pip install "drysim[cluster]", or leave --cluster out'
CERTIFICATES_HINT = "name three files (PEM) by --tls-ca-file, --tls-cert and --tls-key"
DASK_LOGGERS = (
    "asyncio", "bokeh", "distributed", "distributed.client", "tornado", "tornado.application"
)  # fmt: skip

QUIET_LOGGING = dict.fromkeys(DASK_LOGGERS, "critical")
"""What Dask would log: whatever matters of it we say ourselves."""

LOCAL_CLUSTER_CONFIG = {
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


NO_CERTIFICATES = Certificates()


@contextmanager
def connect(
    where: str,
    workers: int | None,
    inform: MessageSink,
    warn: MessageSink,
    certificates: Certificates = NO_CERTIFICATES,
) -> Iterator[ClusterClient]:
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
    require_dask()
    import distributed

    if any(certificates) and not where.startswith(TLS_SCHEME):
        raise UsageError(
            f"certificates have no meaning beside --cluster {where}",
            f"give the {TLS_SCHEME} address of a scheduler that knows them; `local` makes its own",
        )

    with ExitStack() as stack:
        if where == LOCAL:
            client, name = stack.enter_context(local_cluster(workers)), "the local cluster"
            remedy = "Ctrl-C ends it, and --resume goes on"
        else:
            security = make_security(certificates) if where.startswith(TLS_SCHEME) else None
            try:
                client = distributed.Client(
                    where, timeout=CONNECT_TIMEOUT, set_as_default=False, security=security
                )
            except (OSError, ValueError, TimeoutError) as fault:
                raise no_scheduler_error(where, fault) from fault
            stack.callback(client.close, CONNECT_TIMEOUT)
            name = f"the scheduler at {where}"
            remedy = f"dask worker {where}"
        check_all_workers(client.run(version_reader(), on_error="return"))
        yield ClusterClient(client, name, remedy, inform, warn)


def require_dask() -> None:
    """Raise a UsageError with the command that installs it unless Dask is there."""
    try:
        import dask

        with dask.config.set(logging=QUIET_LOGGING):  # which it reads when it is loaded
            import distributed  # noqa: F401 - only whether it is there
    except ImportError:
        raise UsageError(
            "--cluster needs the packages dask and distributed, which are not installed",
            INSTALL_HINT,
        ) from None


def make_security(certificates: Certificates) -> Any:
    """Return what Dask needs to know a scheduler, and to be known by it.

    A UsageError says when certificates are missing, or cannot be read.
    """
    from distributed.security import Security

    ca_file, cert, key = certificates
    words = {"tls_ca_file": ca_file, "tls_client_cert": cert, "tls_client_key": key}
    given = {name: str(file) for name, file in words.items() if file}
    try:
        for file in given.values():
            system.read_regular_file(Path(file), 1)
        security = Security(**given, require_encryption=True)
        context = security.get_connection_args("client")["ssl_context"]
    except (OSError, ValueError, system.NotARegularFile) as fault:
        reason = (getattr(fault, "strerror", None) or str(fault)).lower()
        name = getattr(fault, "filename", None) or " or ".join(given.values())
        raise UsageError(
            f"the certificates cannot be read: {reason}: {name}", CERTIFICATES_HINT
        ) from fault
    if context is None:
        raise UsageError(
            f"an address that begins with {TLS_SCHEME} needs certificates", CERTIFICATES_HINT
        )
    return security


def no_scheduler_error(where: str, fault: Exception) -> UsageError:
    """Return the error for a scheduler that does not answer, or not to us."""
    if where.startswith(TLS_SCHEME):
        chain = (fault, fault.__cause__, getattr(fault.__cause__, "__cause__", None))
        reported = next((one for one in chain if isinstance(one, ssl.SSLError)), None)
        because = f" ({reported.reason or reported})" if reported else ""
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
def local_cluster(workers: int | None) -> Iterator[Any]:
    """Start a scheduler and some workers on this machine, each a process with one thread.

    Whoever may talk to one of them has it run any code. So they take words from those alone who
    have the key that is made here and kept in memory, and no files from a folder of others.
    """
    import dask
    import distributed
    from distributed.security import Security

    with (
        TemporaryDirectory(prefix="drysim-", ignore_cleanup_errors=True) as folder,
        dask.config.set({"logging": QUIET_LOGGING} | LOCAL_CLUSTER_CONFIG),
        distributed.LocalCluster(
            n_workers=workers or system.processor_count(),
            threads_per_worker=1,
            processes=True,
            security=temporary_security(Security),
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


def temporary_security(security: Any) -> Any:
    """Return credentials for one cluster, made by Dask's Security, on no disk."""
    try:
        return security.temporary()
    except ImportError:
        raise UsageError(
            "--cluster local needs the package cryptography, which is not installed",
            INSTALL_HINT,
        ) from None


POLL_INTERVAL = 2.0
"""Time between two looks at how many workers there are [s]."""

TASKS_PER_THREAD = 2
"""Loads under way for each thread of a worker: one at work, the other waiting or coming."""

NO_WORKER_DELAY = 10.0
"""Time without a worker after which that is said, even by a quiet command [s]."""

MIN_TASKS = 4
"""Loads under way while there is no worker yet."""


class ClusterClient:
    """A connection to the workers behind a scheduler."""

    def __init__(
        self, client: Any, name: str, remedy: str, inform: MessageSink, warn: MessageSink
    ) -> None:
        self.client, self.name, self.remedy = client, name, remedy
        self.inform, self.warn = inform, warn
        self._threads, self._last_poll = 0, 0.0
        self._has_announced = self._has_warned = self._had_workers = False
        self._last_worker = time.monotonic()

    def max_tasks(self) -> int:
        """Give how many loads of blocks may be under way."""
        if time.monotonic() - self._last_poll > POLL_INTERVAL:
            self.poll()
        return max(MIN_TASKS, TASKS_PER_THREAD * self._threads)

    def poll(self) -> None:
        """See how many workers there are; say so where there is none, as that may last.

        Of workers that die, others may take the place: that is waited for. A ClusterError says
        when the scheduler has left us.
        """
        try:
            self._threads = sum(self.client.nthreads().values())
        except (OSError, TimeoutError) as fault:
            raise self.lost_error() from fault
        self._last_poll = time.monotonic()
        if self._threads:
            self._had_workers, self._has_warned, self._last_worker = (
                True,
                False,
                self._last_poll,
            )
        elif not self._had_workers and not self._has_announced:
            self._has_announced = True
            self.inform(f"{self.name} has no worker; waiting for one: {self.remedy}")
        if self._last_poll - self._last_worker >= NO_WORKER_DELAY and not self._has_warned:
            self._has_warned = True
            none = (
                "no worker left"
                if self._had_workers
                else f"had no worker for {NO_WORKER_DELAY:.0f} s"
            )
            why = "; a block may have ended them" * self._had_workers
            self.warn(f"{self.name} has {none}{why}; waiting for one: {self.remedy}")

    def wait(self, completed: SimpleQueue[Any]) -> Any:
        """Give what lands next."""
        while True:
            try:
                return completed.get(timeout=POLL_INTERVAL)
            except Empty:
                self.poll()

    def result(self, future: Any) -> Any:
        """Give what a task has come to; it is computed again where its worker died before."""
        patience = POLL_INTERVAL
        while True:
            try:
                return future.result(timeout=patience)
            except TimeoutError:
                self.poll()
                patience *= 2.0  # what comes slowly begins anew each time

    def lost_error(self) -> ClusterError:
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


def version_reader() -> Callable[[], dict[str, str | None]]:
    """Give a function that tells the versions of everything that numbers depend on.

    It carries all that it needs, so that it also runs where there is no drysim, or another.
    """
    names = PACKAGES

    def reported() -> dict[str, str | None]:
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

    return reported


@cache
def versions() -> Versions:
    """Give the versions of what runs here."""
    return version_reader()()


def check_all_workers(there: Mapping[str, Any]) -> None:
    """Raise a UsageError unless all workers, by address, tell what runs here.

    In place of what it runs, a worker may tell an exception.
    """
    for worker, reported in there.items():
        if isinstance(reported, BaseException):
            raise UsageError(
                f"the worker {worker} cannot be asked: {reported}", version_hint(versions())
            )
        if other := version_difference(reported, versions()):
            raise UsageError(f"the worker {worker} {other}", version_hint(versions()))


def check_this_worker(asked: Versions) -> None:
    """Raise a ClusterError unless this worker runs what runs where its work comes from."""
    if other := version_difference(versions(), asked):
        from distributed import get_worker

        worker = f"the worker {get_worker().address}, which has come late,"
        raise ClusterError(f"{worker} {other}", f"{version_hint(asked)}; --resume goes on")


def version_difference(there: Versions, here: Versions) -> str:
    """Say what is other there; empty where nothing is."""
    for name, version in here.items():
        if there.get(name) != version:
            has = f"has {name} {there[name]}" if there.get(name) else f"has no {name}"
            return f"{has}, here is {version}"
    return ""


def version_hint(here: Versions) -> str:
    """Say how to make all machines alike."""
    words = " ".join(f"{name}=={here[name]}" for name in PACKAGES)
    return f"install the same on all machines, pip install {words}, and start the workers anew"


# Blocks on their way to the workers and back, few of them at a time.


def solve_ranges(
    plan: Plan,
    scenario: Scenario,
    link: ClusterClient,
    store: Store,
    finished: Callable[[Batch], None],
) -> Iterator[tuple[CaseRange, Batch]]:
    """Give the cases of every piece in order, as `study.sweep.solve_ranges` does.

    A block is kept as soon as it comes, whatever its turn: whoever is killed here loses no more
    than is under way. In its turn it is read again, so that none is held meanwhile.
    """
    wanted = (k for k, case_range in enumerate(plan.ranges) if not store.has(case_range))
    newly_stored: set[int] = set()
    payload = Payload.of(scenario, store.sweep)
    with closing(compute_remotely(link, payload, wanted, len(plan.ranges))) as in_flight:
        for index, case_range in enumerate(plan.ranges):
            while (batch := store.read(case_range)) is None:
                # A fault of a case is met again here, where its file and line are known.
                number, words = next(in_flight, (index, None))
                store.write_packed(
                    plan.ranges[number], words or pack(plan.block(number), store.sweep)
                )
                newly_stored.add(number)
            if index in newly_stored:
                newly_stored.remove(index)
                finished(batch)
            yield case_range, batch


MAX_LISTED_RANGES = 3
"""Blocks that a message names at most."""

NumberedResult = tuple[int, bytes | None]


def compute_remotely(
    link: ClusterClient, payload: Payload, numbers: Iterable[int], count: int
) -> Generator[NumberedResult]:
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
    in_flight = InFlight(link, payload)
    yield from in_flight.process(numbers, TaskSize(count))
    yield from in_flight.process(in_flight.take_suspects(), None)
    if failed := in_flight.take_suspects():
        those = ", ".join(map(str, failed[:MAX_LISTED_RANGES])) + ", ..." * (
            len(failed) > MAX_LISTED_RANGES
        )
        raise ClusterError(
            f"{len(failed)} of the blocks end every worker that computes them: {those}; all "
            "others are finished",
            "give the workers more memory, or compute the rest without --cluster by --resume",
        )


class InFlight:
    """The blocks that are under way."""

    def __init__(self, link: ClusterClient, payload: Payload) -> None:
        self.link, self.name = link, f"drysim-{payload.digest[:16]}"
        self._futures: dict[str, tuple[list[int], Any]] = {}
        self._completed: SimpleQueue[Any] = SimpleQueue()
        self._suspects: list[int] = []
        self._attempt = 0
        self._payload = self._submit_payload(payload) if payload.files else payload

    def _submit_payload(self, payload: Payload) -> Any:
        """Give a parcel that is too large to go with every load: as a task of its own.

        So it goes to every worker once; but a scheduler prefers those that have it already.
        """
        with warnings.catch_warnings():
            # A record is as large as it is.
            warnings.filterwarnings("ignore", "Sending large graph", UserWarning)
            return self.link.client.submit(pass_through, payload, key=f"parcel-of-{self.name}")

    def take_suspects(self) -> list[int]:
        """Give the blocks whose workers died, and forget them."""
        found, self._suspects = self._suspects, []
        return found

    def process(
        self, numbers: Iterable[int], load: TaskSize | None
    ) -> Iterator[NumberedResult]:
        """Give blocks as they come: as many under way as fit, or without a load one alone."""
        waiting = iter(numbers)
        self._attempt += 1
        while True:
            while len(self._futures) < (max_tasks := self.link.max_tasks() if load else 1):
                if not (some := list(islice(waiting, load.blocks(max_tasks) if load else 1))):
                    break
                self._submit(some)
                if load:
                    load.record_sent(some)
            if not self._futures:
                return
            yield from self._receive(load)

    def _submit(self, numbers: list[int]) -> None:
        # Never the key of another client of the same sweep, whose load may hold other blocks.
        key = f"{self.name}-{uuid4().hex[:12]}-{numbers[0]}-{self._attempt}"
        future = self.link.client.submit(compute, self._payload, numbers, key=key)
        self._futures[key] = numbers, future
        future.add_done_callback(self._completed.put)

    def _receive(self, load: TaskSize | None) -> Iterator[NumberedResult]:
        """Give the blocks that come next, unless their worker died."""
        from distributed import KilledWorker

        future = self.link.wait(self._completed)
        numbers, _ = self._futures.pop(future.key)
        try:
            if future.status == "error":
                fault = future.exception()
                if not isinstance(fault, KilledWorker):
                    raise as_drysim_error(fault)
                self._suspects.extend(numbers)
                return
            blocks, took = self.link.result(future)
        except (CancelledError, OSError, TimeoutError) as fault:
            raise self.link.lost_error() from fault
        finally:
            with suppress(RuntimeError):  # of a loop that is closed
                future.release()  # here: an interrupt is lost in what Python does by itself
        if load:
            load.took(blocks, took)
        yield from zip(numbers, blocks, strict=True)


def pass_through(payload: Payload) -> Payload:
    """Give a parcel as it is."""
    return payload


def as_drysim_error(fault: BaseException) -> BaseException:
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


SECONDS_PER_TASK = 0.5
"""Work that goes together [s]: a task of its own costs scheduler, worker and client some 6 ms
of processor time, however little there is in it."""

MAX_TASK_BYTES = 16_000_000
"""Bytes that come back together at most: a scheduler passes them on whole."""


class TaskSize:
    """How many blocks go to a worker together; what has come tells of what is to come.

    The first go one by one: nobody knows yet what they take. The last go one by one, too, so
    that no worker is left with many of them while others have none.
    """

    def __init__(self, count: int) -> None:
        self._count = self._left = count  # with those that nobody wants any more
        self._blocks_per_task = 1

    def blocks(self, max_tasks: int) -> int:
        """Give how many go together now, where so many tasks may be under way."""
        return max(1, min(self._blocks_per_task, self._left // max_tasks))

    def record_sent(self, numbers: Sequence[int]) -> None:
        """Note which blocks are on their way."""
        self._left = self._count - numbers[-1] - 1

    def took(self, blocks: Sequence[bytes | None], seconds: float) -> None:
        """Note how long some blocks took."""
        size = sum(map(len, filter(None, blocks)))
        share = max(seconds / SECONDS_PER_TASK, size / MAX_TASK_BYTES, 1e-9)
        self._blocks_per_task = max(1, int(len(blocks) / share))


# What a worker does: a parcel, which travels once, holds all that it needs for any block.

SCENARIO_FILE = "scenario.yaml"

MAX_OPEN_SWEEPS = 2
"""Sweeps that a worker keeps open: the latest, and one that is worked at beside it."""


@dataclass(frozen=True)
class Payload:
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


@lru_cache(MAX_OPEN_SWEEPS)
def open_plan(payload: Payload) -> Plan:
    """Give the plan that a parcel holds.

    A worker lives longer than a sweep, so it compiles: a small one may not settle for plain.
    """
    compile.choose_engine(compile.MAX_PLAIN_STEPS + 1)
    folder = Path(tempfile.mkdtemp(prefix="drysim-", dir=worker_folder()))
    with ExitStack() as cleanup:
        cleanup.callback(rmtree, folder, ignore_errors=True)
        (folder / SCENARIO_FILE).write_text(payload.words, encoding="utf-8")
        for file, content in payload.files:
            (folder / file).write_bytes(content)
        case = prepare(load(folder / SCENARIO_FILE))
        plan = Plan.of(approaches_of(case.scenario), case)
        if payload.files:  # long samples stay in their file
            finalize(plan, cleanup.pop_all().close)
    return plan


def worker_folder() -> str | None:
    """Give the folder of this worker, None outside of one.

    When a worker was killed, the next one on its machine removes what it has left there.
    """
    from distributed import get_worker

    try:
        return str(get_worker().local_directory)
    except ValueError:
        return None


def compute(payload: Payload, numbers: Sequence[int]) -> tuple[list[bytes | None], float]:
    """Give blocks, packed, and the processor time that they took [s].

    A block with a case at fault is None, as whoever asks can say better what is wrong.

    Raises
    ------
    ClusterError
        When this worker, which has come late, runs something else.
    """
    check_this_worker(dict(payload.versions))
    began = time.thread_time()
    return [_compute_one(payload, number) for number in numbers], time.thread_time() - began


def _compute_one(payload: Payload, number: int) -> bytes | None:
    """Give a block, packed; None where a case is at fault."""
    try:
        return pack(open_plan(payload).block(number), payload.sweep)
    except DrysimError:
        return None
