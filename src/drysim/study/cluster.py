"""Ranges of a sweep on the workers of a Dask cluster, local or already running.

Flow
    `connect` opens a connection to the scheduler and checks that all workers run the same
    versions; otherwise results may differ. `solve_ranges` yields the ranges in order. Workers
    compute them from a `Payload`, which holds everything that the sweep depends on; results
    are stored and reported by the client. Several ranges form one task, so that scheduling
    costs little (`TaskSize`).

Failures
    A task whose worker dies is computed again by another worker. Finished ranges are in the
    store, so `--resume` continues after any failure.
"""

from __future__ import annotations

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
from functools import cache, lru_cache, partial
from itertools import islice
from pathlib import Path
from queue import Empty, SimpleQueue
from shutil import rmtree
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, Self
from weakref import finalize

from drysim import system
from drysim.core import compile
from drysim.errors import ClusterError, DrysimError, UsageError
from drysim.forced_exit import at_forced_exit
from drysim.scenario.load import load
from drysim.scenario.model import Scenario
from drysim.study.case import named_files, prepare
from drysim.study.plan import CaseRange, Plan, approaches_of
from drysim.study.statistics import Batch
from drysim.study.store import Store, pack
from drysim.yaml_document import dump

MessageSink = Callable[[str], None]

TLS_SCHEME = "tls://"
"""Prefix of the address of a scheduler that requires certificates."""

LOCAL = "local"
"""Value of `--cluster` for processes on this machine."""

CONNECT_TIMEOUT = 10.0
"""Longest wait for an answer of the scheduler [s]."""

INSTALL_HINT = 'install them by pip install "drysim[cluster]", or omit --cluster'
CERTIFICATES_HINT = "give three files (PEM) by --tls-ca-file, --tls-cert and --tls-key"
DASK_LOGGERS = (
    "asyncio", "bokeh", "distributed", "distributed.client", "tornado", "tornado.application"
)  # fmt: skip

QUIET_LOGGING = dict.fromkeys(DASK_LOGGERS, "critical")
"""Dask's own messages are suppressed; this module reports what matters."""

LOCAL_CLUSTER_CONFIG = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}
"""Services of Dask that a local cluster does not need."""


class Certificates(NamedTuple):
    """Files (PEM) by which a scheduler and its clients authenticate each other."""

    ca_file: Path | None = None
    """Certificate of the authority that all of them trust."""
    cert: Path | None = None
    key: Path | None = None
    """Certificate and key of this client; one file may hold both."""


NO_CERTIFICATES = Certificates()


@contextmanager
def connect(
    where: str,
    workers: int | None,
    inform: MessageSink,
    warn: MessageSink,
    certificates: Certificates = NO_CERTIFICATES,
) -> Iterator[ClusterClient]:
    """Connect to the workers of a scheduler for the duration of the context.

    Parameters
    ----------
    where : str
        Address of a scheduler, or `local` for processes on this machine.
    workers : int, optional
        Number of local processes; default: one per processor.
    inform, warn : callable
        Take a sentence for the user; `warn` also with `--quiet`.
    certificates : Certificates, optional
        For an address that begins with `tls://`; missing files are taken from the configuration
        of Dask.

    Raises
    ------
    UsageError
        When no scheduler answers at the address, authentication fails, or a worker runs other
        versions.
    """
    require_dask()
    import distributed

    if any(certificates) and not where.startswith(TLS_SCHEME):
        raise UsageError(
            f"certificates cannot be used with --cluster {where}",
            f"give the {TLS_SCHEME} address of a scheduler that accepts them; `local` creates "
            "its own",
        )

    with ExitStack() as stack:
        if where == LOCAL:
            client, name = stack.enter_context(local_cluster(workers)), "the local cluster"
            remedy = "Ctrl-C ends it; --resume continues"
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
            remedy = f"`dask worker {where}` starts one"
        check_all_workers(client.run(version_reader(), on_error="return"))
        yield ClusterClient(client, name, remedy, inform, warn)


def require_dask() -> None:
    """Raise a UsageError with the command to install Dask if it is missing."""
    try:
        import dask

        with dask.config.set(logging=QUIET_LOGGING):  # read on import
            import distributed  # noqa: F401 - test for presence
    except ImportError:
        raise UsageError(
            "--cluster needs the packages dask and distributed, which are not installed",
            INSTALL_HINT,
        ) from None


def make_security(certificates: Certificates) -> Any:
    """Return Dask's `Security` for these certificates.

    Raises
    ------
    UsageError
        When certificates are missing or unreadable.
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
    """Return the error for a scheduler that does not answer, or rejects the certificates."""
    if where.startswith(TLS_SCHEME):
        chain = (fault, fault.__cause__, getattr(fault.__cause__, "__cause__", None))
        reported = next((one for one in chain if isinstance(one, ssl.SSLError)), None)
        because = f" ({reported.reason or reported})" if reported else ""
        return UsageError(
            f"no Dask scheduler at {where} accepts these certificates{because}",
            "scheduler, workers and client need certificates of one authority: "
            "--tls-ca-file, --tls-cert, --tls-key",
        )
    return UsageError(
        f"no Dask scheduler answers at {where}",
        "start one by `dask scheduler` and give the address that it prints, such as "
        "tcp://10.0.0.1:8786",
    )


@contextmanager
def local_cluster(workers: int | None) -> Iterator[Any]:
    """Start a scheduler and single-threaded worker processes on this machine.

    Anyone who can connect to a worker can run code on it. The processes therefore accept only
    connections with a key that is created here and kept in memory, they have no page, and their
    folder is private.
    """
    import dask
    import distributed
    from distributed.security import Security

    try:
        tempfile.gettempdir()
    except FileNotFoundError:
        raise UsageError(
            "--cluster local needs a temporary folder, and none can be written to",
            "name one in the variable TMPDIR, or leave --cluster out",
        ) from None
    with (
        TemporaryDirectory(prefix="drysim-", ignore_cleanup_errors=True) as folder,
        at_forced_exit(partial(rmtree, folder, ignore_errors=True), last=True),
        dask.config.set(
            {"logging": QUIET_LOGGING, "temporary-directory": folder} | LOCAL_CLUSTER_CONFIG
        ),
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
        cluster.scheduler.http_server.stop()  # Dask always opens one
        yield client


def dask_setup(worker: Any) -> None:
    """Make a local worker ignore Ctrl-C in the terminal, and close its page.

    It ends with the client. Dask calls this function in every worker that preloads this module.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    worker.http_server.stop()


def temporary_security(security: Any) -> Any:
    """Return temporary credentials for one cluster, which are not written to disk."""
    try:
        return security.temporary()
    except ImportError:
        raise UsageError(
            "--cluster local needs the package cryptography, which is not installed",
            INSTALL_HINT,
        ) from None


POLL_INTERVAL = 2.0
"""Time between two checks of the number of workers [s]."""

TASKS_PER_THREAD = 2
"""Tasks in flight per thread of a worker: one running, one waiting or in transfer."""

NO_WORKER_DELAY = 10.0
"""Time without a worker after which a warning is shown, even with `--quiet` [s]."""

MIN_TASKS = 4
"""Tasks in flight while there is no worker yet."""


class ClusterClient:
    """Connection to the workers of a scheduler."""

    def __init__(
        self, client: Any, name: str, remedy: str, inform: MessageSink, warn: MessageSink
    ) -> None:
        self.client, self.name, self.remedy = client, name, remedy
        self.inform, self.warn = inform, warn
        self._threads, self._last_poll = 0, 0.0
        self._has_announced = self._has_warned = self._had_workers = False
        self._last_worker = time.monotonic()

    def max_tasks(self) -> int:
        """Return the number of tasks that may be in flight."""
        if time.monotonic() - self._last_poll > POLL_INTERVAL:
            self.poll()
        return max(MIN_TASKS, TASKS_PER_THREAD * self._threads)

    def poll(self) -> None:
        """Check the number of workers, and inform the user if there is none.

        Dead workers may be replaced, so this is no error.

        Raises
        ------
        ClusterError
            When the connection to the scheduler is lost.
        """
        try:
            self._threads = sum(self.client.nthreads().values())
        except (OSError, TimeoutError) as fault:
            raise self.lost_error() from fault
        self._last_poll = time.monotonic()
        if self._threads:
            self._had_workers, self._has_warned = True, False
            self._last_worker = self._last_poll
        elif not self._had_workers and not self._has_announced:
            self._has_announced = True
            self.inform(f"{self.name} has no worker; waiting for one ({self.remedy})")
        if self._last_poll - self._last_worker >= NO_WORKER_DELAY and not self._has_warned:
            self._has_warned = True
            none = (
                "no worker left"
                if self._had_workers
                else f"had no worker for {NO_WORKER_DELAY:.0f} s"
            )
            why = "; a block may have crashed them" * self._had_workers
            self.warn(f"{self.name} has {none}{why}; waiting for one ({self.remedy})")

    def wait(self, completed: SimpleQueue[Any]) -> Any:
        """Return the next completed future."""
        while True:
            try:
                return completed.get(timeout=POLL_INTERVAL)
            except Empty:
                self.poll()

    def result(self, future: Any) -> Any:
        """Return the result of a task; Dask computes it again if its worker died."""
        patience = POLL_INTERVAL
        while True:
            try:
                return future.result(timeout=patience)
            except TimeoutError:
                self.poll()
                patience *= 2.0  # a timeout restarts the transfer

    def lost_error(self) -> ClusterError:
        """Return the error for a lost connection to the scheduler."""
        return ClusterError(
            f"the connection to {self.name} is lost; finished blocks are kept",
            "start it again and repeat the command with --resume, or resume without --cluster",
        )


# Versions of client and workers: with other versions results may differ.

Versions = Mapping[str, str | None]
"""Version of Python and of each package; None for a missing package."""

PACKAGES = ("drysim", "numpy", "scipy", "numba", "distributed")
"""Packages whose version may affect the results."""


def version_reader() -> Callable[[], dict[str, str | None]]:
    """Return a function that reads the versions of all packages that affect results.

    The function is self-contained, so that it runs on workers without drysim, or with another
    version of it.
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
    """Return the versions of this process."""
    return version_reader()()


def check_all_workers(there: Mapping[str, Any]) -> None:
    """Raise a UsageError unless all workers have the versions of this process.

    `there` has, by address, the versions of a worker or the exception that it raised.
    """
    for worker, reported in there.items():
        if isinstance(reported, BaseException):
            raise UsageError(
                f"the worker {worker} does not report its versions: {reported}",
                version_hint(versions()),
            )
        if other := version_difference(reported, versions()):
            raise UsageError(f"the worker {worker} {other}", version_hint(versions()))


def check_this_worker(asked: Versions) -> None:
    """Raise a ClusterError unless this worker has the versions of the client."""
    if other := version_difference(versions(), asked):
        from distributed import get_worker

        worker = f"the worker {get_worker().address}, which joined later,"
        raise ClusterError(f"{worker} {other}", f"{version_hint(asked)}; --resume continues")


def version_difference(there: Versions, here: Versions) -> str:
    """Return the first difference in words; "" if there is none."""
    for name, version in here.items():
        if there.get(name) != version:
            has = f"has {name} {there[name]}" if there.get(name) else f"has no {name}"
            return f"{has}, but the client has {version}"
    return ""


def version_hint(here: Versions) -> str:
    """Return how to install the same versions on all machines."""
    words = " ".join(f"{name}=={here[name]}" for name in PACKAGES)
    return (
        f"install the same versions on all machines, pip install {words}, and restart the "
        "workers"
    )


# Distribution of ranges to the workers.


def solve_ranges(
    plan: Plan,
    scenario: Scenario,
    link: ClusterClient,
    store: Store,
    finished: Callable[[Batch], None],
) -> Iterator[tuple[CaseRange, Batch]]:
    """Yield each range with its batch, in order, as `study.sweep.solve_ranges` does.

    A batch is stored as soon as it arrives, in any order, so an interruption loses only tasks
    in flight. It is read back when its range is due, so that memory stays small.
    """
    wanted = (k for k, case_range in enumerate(plan.ranges) if not store.has(case_range))
    newly_stored: set[int] = set()
    payload = Payload.of(scenario, store.sweep, plan.ranges.first)
    with closing(compute_remotely(link, payload, wanted, len(plan.ranges))) as in_flight:
        for index, case_range in enumerate(plan.ranges):
            while (batch := store.read(case_range)) is None:
                # An invalid case raises its error here, where file and line are known.
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
"""Number of ranges that a message lists at most."""

NumberedResult = tuple[int, bytes | None]
"""Number of a range, and its packed batch; None if a case is invalid."""


def compute_remotely(
    link: ClusterClient, payload: Payload, numbers: Iterable[int], count: int
) -> Generator[NumberedResult]:
    """Yield packed batches in the order in which the workers finish them.

    A task whose worker dies is computed again by another worker. Ranges of a task after which
    several workers died are tried once more, one at a time, to find the one that is
    responsible.

    Parameters
    ----------
    link : ClusterClient
    payload : Payload
    numbers : iterable of int
        Ranges to compute, ascending; consumed as there is capacity.
    count : int
        Number of all ranges of the sweep. Towards the end fewer form a task.

    Raises
    ------
    ClusterError
        When the scheduler is lost, or, after all others, for ranges that end their workers.
    """
    in_flight = InFlight(link, payload)
    yield from in_flight.process(numbers, TaskSize(count))
    yield from in_flight.process(in_flight.take_suspects(), None)
    if failed := in_flight.take_suspects():
        those = ", ".join(map(str, failed[:MAX_LISTED_RANGES])) + ", ..." * (
            len(failed) > MAX_LISTED_RANGES
        )
        raise ClusterError(
            f"{len(failed)} of the blocks crash every worker that computes them: {those}; all "
            "others are finished",
            "give the workers more memory, or compute the rest by --resume without --cluster",
        )


class InFlight:
    """Tasks that are being computed."""

    def __init__(self, link: ClusterClient, payload: Payload) -> None:
        self.link = link
        self._futures: dict[str, tuple[list[int], Any]] = {}
        self._completed: SimpleQueue[Any] = SimpleQueue()
        self._suspects: list[int] = []
        self._payload = self._submit_payload(payload) if payload.files else payload

    def _submit_payload(self, payload: Payload) -> Any:
        """Submit a large payload once, as a task of its own on which the others depend.

        It is sent to each worker once; the scheduler then prefers workers that have it.
        """
        with warnings.catch_warnings():
            # The size of a record cannot be reduced.
            warnings.filterwarnings("ignore", "Sending large graph", UserWarning)
            return self.link.client.submit(pass_through, payload, pure=False)

    def take_suspects(self) -> list[int]:
        """Return the ranges whose workers died, and clear the list."""
        found, self._suspects = self._suspects, []
        return found

    def process(
        self, numbers: Iterable[int], load: TaskSize | None
    ) -> Iterator[NumberedResult]:
        """Yield results as they arrive; without `load`, one range at a time."""
        waiting = iter(numbers)
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
        # Not pure, which gives it a unique key: each attempt is a task of its own.
        future = self.link.client.submit(compute, self._payload, numbers, pure=False)
        self._futures[future.key] = numbers, future
        future.add_done_callback(self._completed.put)

    def _receive(self, load: TaskSize | None) -> Iterator[NumberedResult]:
        """Yield the results of the next completed task, unless its worker died."""
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
            with suppress(RuntimeError):  # the event loop is closed
                future.release()  # explicitly: an interrupt during __del__ is lost
        if load:
            load.took(blocks, took)
        yield from zip(numbers, blocks, strict=True)


def pass_through(payload: Payload) -> Payload:
    """Return the payload: the task that transfers it."""
    return payload


def as_drysim_error(fault: BaseException) -> BaseException:
    """Convert an exception of a worker to a ClusterError, except programming errors."""
    if isinstance(fault, ImportError | AttributeError):
        return ClusterError(
            f"a worker that joined later has an incompatible drysim: {fault}",
            "install the same versions on all machines, restart the workers and use --resume",
        )
    if isinstance(fault, OSError | MemoryError):
        return ClusterError(
            f"a worker failed: {str(fault) or 'out of memory'}",
            "check its disk and memory, and continue by --resume",
        )
    return fault


SECONDS_PER_TASK = 0.5
"""Work of one task [s]; a task costs scheduler, worker and client about 6 ms in any case."""

MAX_TASK_BYTES = 16_000_000
"""Largest result of a task [bytes]; a scheduler transfers it in one piece."""


class TaskSize:
    """Number of ranges per task, estimated from the completed ones.

    The first tasks hold one range, as the cost is unknown; the last ones too, to balance the
    load.
    """

    def __init__(self, count: int) -> None:
        self._count = self._left = count  # including stored ranges
        self._blocks_per_task = 1

    def blocks(self, max_tasks: int) -> int:
        """Return the number of ranges of the next task, with at most `max_tasks` in flight."""
        return max(1, min(self._blocks_per_task, self._left // max_tasks))

    def record_sent(self, numbers: Sequence[int]) -> None:
        """Record which ranges were submitted."""
        self._left = self._count - numbers[-1] - 1

    def took(self, blocks: Sequence[bytes | None], seconds: float) -> None:
        """Record the time and size of completed ranges."""
        size = sum(map(len, filter(None, blocks)))
        share = max(seconds / SECONDS_PER_TASK, size / MAX_TASK_BYTES, 1e-9)
        self._blocks_per_task = max(1, int(len(blocks) / share))


# Code that runs on the workers.

SCENARIO_FILE = "scenario.yaml"

MAX_OPEN_SWEEPS = 2
"""Sweeps that a worker keeps open: the latest, and another one in parallel."""


@dataclass(frozen=True)
class Payload:
    """Scenario as text with the files that it names; no worker reads files of the client."""

    words: str
    """Resolved scenario as YAML, with the files named as below."""
    files: tuple[tuple[str, bytes], ...]
    """Names and contents."""
    versions: tuple[tuple[str, str | None], ...]
    """Versions of the client."""
    sweep: str
    """Digest of the sweep, which its batches carry."""
    first: int
    """Number of the first case."""

    @classmethod
    def of(cls, scenario: Scenario, sweep: str, first: int = 0) -> Self:
        """Return the payload of a scenario."""
        words, files = scenario.resolved(), []
        for number, (keys, path) in enumerate(named_files(scenario)):
            name = f"{number}{path.suffix}"
            files.append((name, path.read_bytes()))
            block: Any = words
            for key in keys[:-1]:
                block = block[key]
            block[keys[-1]] = name
        return cls(dump(words), tuple(files), tuple(versions().items()), sweep, first)


@lru_cache(MAX_OPEN_SWEEPS)
def open_plan(payload: Payload) -> Plan:
    """Return the plan of a payload.

    A worker serves several sweeps, so it always chooses the compiled engine.
    """
    compile.choose_engine(compile.MAX_PLAIN_STEPS + 1)
    folder = Path(tempfile.mkdtemp(prefix="drysim-", dir=worker_folder()))
    with ExitStack() as cleanup:
        cleanup.callback(rmtree, folder, ignore_errors=True)
        (folder / SCENARIO_FILE).write_text(payload.words, encoding="utf-8")
        for file, content in payload.files:
            (folder / file).write_bytes(content)
        case = prepare(load(folder / SCENARIO_FILE))
        plan = Plan.of(approaches_of(case.scenario), case, payload.first)
        if payload.files:  # long records are read from their file on demand
            finalize(plan, cleanup.pop_all().close)
    return plan


def worker_folder() -> str | None:
    """Return the folder of this worker; None in any other process.

    Dask removes the folder of a killed worker when the next one starts on that machine.
    """
    from distributed import get_worker

    try:
        return str(get_worker().local_directory)
    except ValueError:
        return None


def compute(payload: Payload, numbers: Sequence[int]) -> tuple[list[bytes | None], float]:
    """Compute ranges; return the packed batches and the processor time [s].

    A range with an invalid case is None: the client computes it again for the error message.

    Raises
    ------
    ClusterError
        When this worker joined later, with other versions.
    """
    check_this_worker(dict(payload.versions))
    began = time.thread_time()
    return [_compute_one(payload, number) for number in numbers], time.thread_time() - began


def _compute_one(payload: Payload, number: int) -> bytes | None:
    """Return the packed batch of a range; None if a case is invalid."""
    try:
        return pack(open_plan(payload).block(number), payload.sweep)
    except DrysimError:
        return None
