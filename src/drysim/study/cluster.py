"""Ranges of a sweep on the workers of a Dask cluster, local or already running.

Flow
    `connect` opens a connection to the scheduler and checks that all workers run the same
    versions; otherwise results may differ. It yields a `ClusterExecutor`, whose `solve` gives
    the workers several ranges at a time (`parallel.completed`). They compute them from a
    `Payload`, which holds everything that the sweep depends on.

Failures
    A task whose worker dies is computed again by another worker. Finished ranges are in the
    store, so `--resume` continues after any failure.
"""

from __future__ import annotations

import logging
import signal
import ssl
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache, lru_cache, partial
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, Self
from weakref import finalize

from drysim import system
from drysim.core import compile
from drysim.errors import ClusterError, DrysimError, UsageError
from drysim.forced_exit import at_forced_exit
from drysim.parallel import QUEUED_PER_WORKER, completed, work_on
from drysim.scenario.files import named_files
from drysim.scenario.load import load
from drysim.scenario.model import Scenario
from drysim.study.plan import Plan, approaches_of
from drysim.study.preparation import prepare
from drysim.study.statistics import Batch
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
) -> Iterator[ClusterExecutor]:
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
        yield ClusterExecutor(client, name, remedy, inform, warn)


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
    options = {"tls_ca_file": ca_file, "tls_client_cert": cert, "tls_client_key": key}
    given = {name: str(file) for name, file in options.items() if file}
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
        reported = next((error for error in chain if isinstance(error, ssl.SSLError)), None)
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


TASK_TIME = 0.5
"""Work of one task [s]; a task costs scheduler, worker and client about 6 ms in any case."""

POLL_INTERVAL = 2.0
"""Time between two checks of the number of workers [s]."""

NO_WORKER_DELAY = 10.0
"""Time without a worker after which a warning is shown, even with `--quiet` [s]."""

MIN_TASKS = 4
"""Tasks in flight while there is no worker yet."""

MAX_LISTED_RANGES = 3
"""Number of ranges that a message lists at most."""


class ClusterExecutor(Executor):
    """Workers of a scheduler.

    Dask's own executor (`Client.get_executor`) does not serve: a future whose result cannot be
    fetched is never done, errors of a worker cannot be told from those of the connection, and
    tasks are released by finalisers, in which Python discards an interrupt.
    """

    def __init__(
        self, client: Any, name: str, remedy: str, inform: MessageSink, warn: MessageSink
    ) -> None:
        self.client, self.name, self.remedy = client, name, remedy
        self.inform, self.warn = inform, warn
        self._threads, self._last_poll = 0, 0.0
        self._has_announced = self._has_warned = self._had_workers = False
        self._last_worker = time.monotonic()

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Submit a call; futures of Dask among its arguments become their results there."""
        # Not pure, which gives it a unique key: each attempt is a task of its own.
        task = self.client.submit(function, *args, **kwargs, pure=False)
        future: Future[Any] = Future()
        self.client.loop.add_callback(self._pass_on, task, future)
        return future

    async def _pass_on(self, task: Any, future: Future[Any]) -> None:
        """Pass the result of a task on; Dask computes it again if its worker died."""
        try:
            future.set_result(await task)
        except Exception as fault:
            is_of_worker = task.status == "error"
            future.set_exception(as_drysim_error(fault) if is_of_worker else self.lost_error())
        finally:
            task.release()

    def solve(
        self, payload: Payload, numbers: Sequence[int]
    ) -> Generator[tuple[int, Batch | None]]:
        """Yield ranges with their batches, in the order in which the workers finish them.

        A task whose worker dies is computed again by another worker. Ranges of a task after
        which several workers died are tried once more, one at a time, to find the one that is
        responsible.

        Parameters
        ----------
        payload : Payload
        numbers : sequence of int
            Ranges to compute.

        Yields
        ------
        tuple
            Number of a range, and its batch; None if a case is invalid.

        Raises
        ------
        ClusterError
            When the scheduler is lost, or, after all others, for ranges that end their workers.
        """
        from distributed import KilledWorker

        if not numbers:
            return
        shared = self._shared(payload)
        for task_time, most in (TASK_TIME, sys.maxsize), (0.0, 1):
            suspects: list[int] = []
            tasks = completed(
                lambda some: self.submit(compute, shared, some),
                numbers, partial(self.max_tasks, most), task_time, lost=KilledWorker,
            )  # fmt: skip
            for task in tasks:
                those = numbers[task.begin : task.begin + task.size]
                if task.results:
                    yield from zip(those, task.results, strict=True)
                else:
                    suspects += those
            numbers = suspects
        if suspects:
            listed = ", ".join(map(str, suspects[:MAX_LISTED_RANGES]))
            more = ", ..." * (len(suspects) > MAX_LISTED_RANGES)
            raise ClusterError(
                f"{len(suspects)} of the blocks crash every worker that computes them: "
                f"{listed}{more}; all others are finished",
                "give the workers more memory, or compute the rest by --resume without "
                "--cluster",
            )

    def _shared(self, payload: Payload) -> Any:
        """Return a payload as an argument of tasks; a large one is sent to each worker once.

        It is the result of a task of its own; the scheduler then prefers workers that have it.
        """
        if not payload.files:
            return payload
        with warnings.catch_warnings():
            # The size of a record cannot be reduced.
            warnings.filterwarnings("ignore", "Sending large graph", UserWarning)
            return self.client.submit(pass_through, payload, pure=False)

    def max_tasks(self, most: int = sys.maxsize) -> int:
        """Return the number of tasks that may be in flight, at most `most`."""
        if time.monotonic() - self._last_poll > POLL_INTERVAL:
            self.poll()
        return min(max(MIN_TASKS, QUEUED_PER_WORKER * self._threads), most)

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

        versions: dict[str, str | None] = {
            "Python": ".".join(platform.python_version_tuple()[:2])
        }
        for name in names:
            try:
                versions[name] = str(importlib.import_module(name).__version__)
            except Exception:
                versions[name] = None
        versions["source of drysim"] = None
        if versions["drysim"] is not None:
            home = pathlib.Path(str(importlib.import_module("drysim").__file__)).parent
            files = sorted(home.rglob("*.py"), key=lambda file: file.relative_to(home).parts)
            content = b"".join(file.read_bytes() for file in files)
            versions["source of drysim"] = hashlib.sha256(content).hexdigest()[:12]
        return versions

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
    pinned = " ".join(f"{name}=={here[name]}" for name in PACKAGES)
    return (
        f"install the same versions on all machines, pip install {pinned}, and restart the "
        "workers"
    )


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


# Code that runs on the workers.

SCENARIO_FILE = "scenario.yaml"

MAX_OPEN_SWEEPS = 2
"""Sweeps that a worker keeps open: the latest, and another one in parallel."""


@dataclass(frozen=True)
class Payload:
    """Scenario as text with the files that it names; no worker reads files of the client."""

    document: str
    """Resolved scenario as YAML, with the files named as below."""
    files: tuple[tuple[str, bytes], ...]
    """Names and contents."""
    versions: tuple[tuple[str, str | None], ...]
    """Versions of the client."""
    first: int
    """Number of the first case."""

    @classmethod
    def of(cls, scenario: Scenario, first: int = 0) -> Self:
        """Return the payload of a scenario."""
        document, files = scenario.resolved(), []
        for number, (keys, path) in enumerate(named_files(scenario)):
            name = f"{number}{path.suffix}"
            files.append((name, path.read_bytes()))
            block: Any = document
            for key in keys[:-1]:
                block = block[key]
            block[keys[-1]] = name
        return cls(dump(document), tuple(files), tuple(versions().items()), first)


@lru_cache(MAX_OPEN_SWEEPS)
def open_plan(payload: Payload) -> Plan:
    """Return the plan of a payload.

    A worker serves several sweeps, so it always chooses the compiled engine.
    """
    compile.choose_engine(compile.MAX_PLAIN_STEPS + 1)
    folder = Path(tempfile.mkdtemp(prefix="drysim-", dir=worker_folder()))
    with ExitStack() as cleanup:
        cleanup.callback(rmtree, folder, ignore_errors=True)
        (folder / SCENARIO_FILE).write_text(payload.document, encoding="utf-8")
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


def pass_through(payload: Payload) -> Payload:
    """Return the payload: the task that transfers it."""
    return payload


def compute(payload: Payload, numbers: Sequence[int]) -> tuple[list[Batch | None], float]:
    """Compute ranges; return their batches and the time of one [s].

    A range with an invalid case is None: the client computes it again for the error message.

    Raises
    ------
    ClusterError
        When this worker joined later, with other versions.
    """
    check_this_worker(dict(payload.versions))
    return work_on(partial(block_or_none, payload), numbers)


def block_or_none(payload: Payload, number: int) -> Batch | None:
    """Return the batch of a range; None if a case is invalid."""
    try:
        return open_plan(payload).block(number)
    except DrysimError:
        return None
