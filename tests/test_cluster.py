"""Sweeps on a cluster: the very same tables, and a sentence for whatever is wrong with it."""

from __future__ import annotations

import asyncio
import dataclasses
import gc
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections import Counter
from contextlib import closing, nullcontext
from pathlib import Path

import pytest
from cluster_scenes import ALL, QUIET, blocks_in, pem, table, written

from drysim.console import terminal
from drysim.errors import UsageError
from drysim.scenario.load import load
from drysim.study import cluster as study_cluster

pytest.importorskip("dask")
study_cluster.require_dask()
distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def address():
    """Return the address of a scheduler with two workers, all in this process."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
    ) as cluster:
        yield cluster.scheduler_address


@pytest.fixture
def swept(tmp_path):
    """Write every scenario, and the record of one of them."""
    return written(tmp_path)


@pytest.fixture
def orbits(swept):
    """Return what the workers of a cluster are sent of a sweep."""
    return study_cluster.Payload.of(load(swept / "orbits.yaml"))


def joined(address):
    """Return a context: the client of a cluster."""
    return study_cluster.connect(address, None, print, print)


@pytest.mark.parametrize("name", ALL)
def test_table_of_a_cluster_is_that_of_threads(drysim, swept, address, name):
    for workers in (1, 2):
        words = ("sweep", f"{name}.yaml", *QUIET, "-o", f"w{workers}")
        assert drysim(*words, "--workers", workers).code == 0
    done = drysim("sweep", f"{name}.yaml", *QUIET, "-o", "far", "--cluster", address)
    assert done == (0, "", "")
    assert table(swept / "w1") == table(swept / "w2") == table(swept / "far")


def interrupted_after(monkeypatch, blocks):
    """Interrupt a sweep after a number of reported blocks."""
    left = [blocks]

    def progress(*_):
        def advance(n):
            left[0] -= 1
            if left[0] == 0:
                raise KeyboardInterrupt

        return nullcontext(advance)

    monkeypatch.setattr(terminal, "progress", progress)


@pytest.mark.parametrize("began", ["threads", "cluster"])
def test_sweep_goes_on_where_another_engine_was_interrupted(
    drysim, swept, address, began, monkeypatch
):
    far = ("--cluster", address)
    first, then = ((), far) if began == "threads" else (far, ())
    words = ("sweep", "seeds.yaml", *QUIET)
    assert drysim(*words, "-o", "whole").code == 0
    with monkeypatch.context() as patched:
        interrupted_after(patched, 5)
        done = drysim(*words, "-o", "parts", *first)
    assert done.code == 130
    kept = blocks_in(swept / "parts.partial")
    assert f"{kept} finished cases are kept" in done.err
    assert kept >= 5
    assert drysim(*words, "-o", "parts", "--resume", *then).code == 0
    assert table(swept / "parts") == table(swept / "whole")
    assert not (swept / "parts.partial").exists()


@pytest.mark.parametrize("began", ["threads", "cluster"])
def test_record_that_has_changed_is_not_gone_on_with(
    drysim, swept, address, began, monkeypatch
):
    far = ("--cluster", address)
    words = ("sweep", "record.yaml", *QUIET, "-o", "parts")
    with monkeypatch.context() as patched:
        interrupted_after(patched, 2)
        assert drysim(*words, *(far if began == "cluster" else ())).code == 130
    file = swept / "data/road.csv"
    sound = file.read_text()
    file.write_text(sound.replace("1", "2", 1))
    for engine in ((), far):
        done = drysim(*words, "--resume", *engine)
        assert done.code == 2
        assert "another scenario, record or version" in done.err
    file.write_text(sound)
    assert drysim(*words, "--resume").code == 0


def test_case_at_fault_is_told_as_without_a_cluster(drysim, swept, address):
    words = ("sweep", "orbits.yaml", *QUIET, "--set", "friction.static=20")
    near = drysim(*words)
    assert near.code == 2
    assert "friction.static" in near.err
    assert drysim(*words, "--cluster", address) == near


def test_parcel_holds_the_very_scenario(swept):
    for name in ALL:
        scenario = load(swept / f"{name}.yaml")
        again = study_cluster.open_plan(study_cluster.Payload.of(scenario)).ranges.scenarios[0]
        words = again.resolved()
        if name == "record":
            assert words["excitation"]["file"] == "0.csv"
            words["excitation"]["file"] = "data/road.csv"
        assert words == scenario.resolved()


def test_wrong_address_is_told(refused, swept, monkeypatch):
    monkeypatch.setattr(study_cluster, "CONNECT_TIMEOUT", 0.3)
    for address in ("tcp://127.0.0.1:9", "nowhere", "gopher://a:1"):
        error = refused("sweep", "orbits.yaml", *QUIET, "--cluster", address)
        assert f"no Dask scheduler answers at {address}" in error
        assert "dask scheduler" in error


def test_workers_of_a_cluster_are_not_ours_to_count(drysim, swept, address):
    done = drysim("sweep", "orbits.yaml", *QUIET, "--cluster", address, "--workers", 2)
    assert done.code == 2
    assert "--workers cannot be combined" in done.err


@pytest.mark.parametrize(
    ("module", "told"), [("dask", ""), ("cryptography", "needs the package cryptography")]
)
def test_missing_extra_is_named(refused, swept, monkeypatch, module, told):
    monkeypatch.setitem(sys.modules, module, None)
    error = refused("sweep", "orbits.yaml", *QUIET, "--cluster", "local")
    assert told in error
    assert 'pip install "drysim[cluster]"' in error


def test_worker_with_another_drysim_is_named(drysim, swept, address, monkeypatch):
    others = {**study_cluster.versions(), "drysim": "0.0.1"}
    monkeypatch.setattr(study_cluster, "versions", lambda: others)
    done = drysim("sweep", "orbits.yaml", *QUIET, "--cluster", address)
    assert done.code == 2
    assert "the worker inproc://" in done.err
    assert "but the client has 0.0.1" in done.err
    assert "pip install drysim==0.0.1" in done.err


def test_worker_without_drysim_is_named(monkeypatch):
    nothing = dict.fromkeys(study_cluster.versions())
    ours = study_cluster.versions()
    assert "has no Python" in study_cluster.version_difference(nothing, ours)
    with pytest.raises(Exception, match="does not report its versions: no"):
        study_cluster.check_all_workers({"tcp://a:1": OSError("no")})


def test_worker_that_comes_late_with_another_drysim_is_named(
    drysim, swept, address, monkeypatch
):
    made = study_cluster.Payload.of
    others = tuple({**study_cluster.versions(), "drysim": "0.0.1"}.items())

    def other(*words):
        return dataclasses.replace(made(*words), versions=others)

    monkeypatch.setattr(study_cluster.Payload, "of", other)
    done = drysim("sweep", "orbits.yaml", *QUIET, "--cluster", address)
    assert done.code == 3
    assert "which joined later" in done.err
    assert "--resume continues" in done.err


def test_sweep_of_threads_loads_neither_dask_nor_pyarrow(swept):
    words = ["sweep", "seeds.yaml", *QUIET]
    code = (
        f"import sys; from drysim.cli import main; assert main({words!r}) == 0; "
        "assert not {'dask', 'distributed', 'pyarrow', 'drysim.study.cluster'} & {*sys.modules}"
    )
    subprocess.run([sys.executable, "-c", code], cwd=swept, check=True)


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (ModuleNotFoundError("No module named 'drysim'"), "has an incompatible drysim"),
        (OSError(28, "No space left on device"), "a worker failed: [Errno 28] No space left"),
        (MemoryError(), "a worker failed: out of memory"),
    ],
)
def test_worker_in_trouble_is_told_in_a_sentence(fault, words):
    told = study_cluster.as_drysim_error(fault)
    assert told.exit_code == 3
    assert words in str(told)
    assert "--resume" in told.hint
    bug = ZeroDivisionError("a bug")
    assert study_cluster.as_drysim_error(bug) is bug


def test_blocks_are_taken_up_as_there_is_room(orbits, address, monkeypatch):
    def computed(payload, numbers):
        return [f"{number}" for number in numbers], 0.1

    submitted = []

    def submit(self, function, payload, numbers):
        submitted.extend(numbers)
        return sent(self, function, payload, numbers)

    sent = study_cluster.ClusterExecutor.submit
    monkeypatch.setattr(study_cluster, "compute", computed)
    monkeypatch.setattr(study_cluster.ClusterExecutor, "submit", submit)
    with joined(address) as client:
        max_tasks = client.max_tasks()
        with closing(client.solve(orbits, range(10**12))) as found:
            some = [next(found) for _ in range(40)]
    assert all(words == f"{k}" for k, words in some)
    assert max_tasks == 2 * 2
    assert len(submitted) <= 5 * max_tasks + len(some)  # 5 blocks are half a second of work


def test_clients_of_the_same_sweep_get_the_blocks_that_each_has_asked_for(
    orbits, address, monkeypatch
):
    def computed(payload, numbers):
        time.sleep(0.1)
        return [f"{number}" for number in numbers], 0.1

    monkeypatch.setattr(study_cluster, "compute", computed)
    with joined(address) as one, joined(address) as other:
        first, second = one.solve(orbits, [3, 4]), other.solve(orbits, [3, 7])
        begun = next(first)
        found = sorted([begun, *first]), sorted(second)
    assert found == ([(3, "3"), (4, "4")], [(3, "3"), (7, "7")])


def test_first_blocks_go_to_all_workers(orbits, address, monkeypatch):
    def computed(payload, numbers):
        time.sleep(0.1)
        return [distributed.get_worker().address for _ in numbers], 1.0

    monkeypatch.setattr(study_cluster, "compute", computed)
    with joined(address) as client:
        found = [worker for _, worker in client.solve(orbits, range(4))]
    assert sorted(Counter(found).values()) == [2, 2]


def test_no_future_of_dask_is_released_by_a_finaliser(orbits, address, monkeypatch):
    """An interrupt in a finaliser is lost."""
    from distributed.client import Future

    cleared, ended = [], Future.__del__

    def last(future):
        # Futures of other tests may be released here, too.
        cleared.append((future._client, future._cleared))
        ended(future)

    monkeypatch.setattr(Future, "__del__", last)
    with joined(address) as executor:
        assert len(list(executor.solve(orbits, range(3)))) == 3
        gc.collect()
        assert [done for client, done in cleared if client is executor.client] == [True] * 3


def test_result_that_cannot_be_fetched_is_an_error_of_the_connection(address, monkeypatch):
    async def refused(*_, **__):
        raise OSError("connection refused")

    with joined(address) as executor:
        monkeypatch.setattr(executor.client, "_gather", refused)
        fault = executor.submit(pow, 2, 5).exception(timeout=60)
    assert fault.exit_code == 3
    assert f"the connection to the scheduler at {address} is lost" in str(fault)


def test_error_of_a_worker_is_told_from_one_of_the_connection(address):
    def full():
        raise OSError(28, "No space left on device")

    with joined(address) as executor:
        fault = executor.submit(full).exception(timeout=60)
    assert "a worker failed: [Errno 28] No space left" in str(fault)


@pytest.mark.parametrize("name", ["orbits", "record"])
def test_folder_of_a_parcel_stays_as_long_as_its_files_are_read(swept, monkeypatch, name):
    monkeypatch.setattr(tempfile, "tempdir", str(swept))
    made = study_cluster.Payload.of(load(swept / f"{name}.yaml"))
    study_cluster.open_plan.cache_clear()  # other tests may have opened the same one
    plan = study_cluster.open_plan(made)
    assert len(list(swept.glob("drysim-*/*.csv"))) == len(made.files)
    assert len(list(swept.glob("drysim-*"))) == len(made.files)
    study_cluster.open_plan.cache_clear()
    del plan
    gc.collect()
    assert not list(swept.glob("drysim-*"))


def test_files_of_a_parcel_lie_in_the_folder_of_the_worker(address):
    with distributed.Client(address, set_as_default=False) as client:
        found = client.submit(study_cluster.worker_folder, pure=False).result()
    assert "worker-" in found
    assert study_cluster.worker_folder() is None


def test_scheduler_without_a_worker_is_waited_for_and_said(orbits, monkeypatch):
    monkeypatch.setattr(study_cluster, "POLL_INTERVAL", 0.1)
    said = []
    with distributed.LocalCluster(
        n_workers=0, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
    ) as cluster:

        def say(sentence):
            said.append(sentence)
            cluster.scale(1)

        with study_cluster.connect(cluster.scheduler_address, None, say, say) as executor:
            assert [number for number, _ in executor.solve(orbits, [1])] == [1]
    assert len(said) == 1
    assert "has no worker; waiting for one (`dask worker inproc://" in said[0]


@pytest.fixture(scope="module")
def secret():
    """Return credentials for one cluster."""
    pytest.importorskip("cryptography")
    return distributed.Security.temporary()


@pytest.fixture(scope="module")
def guarded(secret):
    """Return the address of a scheduler that asks for certificates, in this process."""
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0",
        protocol="tls://", security=secret,
    ) as cluster:  # fmt: skip
        yield cluster.scheduler_address


def test_table_over_tls_is_that_of_threads(drysim, swept, guarded, secret):
    words = ("sweep", "seeds.yaml", *QUIET)
    assert drysim(*words, "-o", "near").code == 0
    done = drysim(*words, "-o", "far", "--cluster", guarded, *pem(swept, secret))
    assert done == (0, "", "")
    assert table(swept / "far") == table(swept / "near")


def test_certificates_of_the_settings_of_dask_are_taken(drysim, swept, guarded, secret):
    import dask

    pem(swept, secret)
    files = {"ca-file": "ca.pem", "client.cert": "cert.pem", "client.key": "key.pem"}
    known = {f"distributed.comm.tls.{key}": str(swept / name) for key, name in files.items()}
    with dask.config.set(known):
        assert drysim("sweep", "orbits.yaml", *QUIET, "--cluster", guarded).code == 0


def test_client_with_other_certificates_is_refused(drysim, swept, guarded, monkeypatch):
    monkeypatch.setattr(study_cluster, "CONNECT_TIMEOUT", 1.0)
    others = pem(swept, distributed.Security.temporary())
    done = drysim("sweep", "orbits.yaml", *QUIET, "--cluster", guarded, *others)
    assert done.code == 2
    assert f"no Dask scheduler at {guarded} accepts these certificates" in done.err
    assert "certificates of one authority" in done.err


@pytest.mark.parametrize(
    ("where", "words", "said"),
    [
        ("tls://127.0.0.1:9", (), "that begins with tls:// needs certificates"),
        ("tls://127.0.0.1:9", ("--tls-ca-file", "no.pem"), "no such file or directory: no.pem"),
        ("tls://127.0.0.1:9", ("--tls-key", "."), "cannot be read: is a directory: ."),
        ("tls://127.0.0.1:9", ("--tls-ca-file", "orbits.yaml"), "needs certificates"),
        ("tcp://127.0.0.1:9", ("--tls-key", "key.pem"), "cannot be used with --cluster tcp://"),
        ("local", ("--tls-key", "key.pem"), "cannot be used with --cluster local"),
        (None, ("--tls-key", "key.pem"), "the --tls options need a cluster"),
    ],
)
def test_certificates_that_are_missing_or_of_no_use_are_told(
    refused, swept, where, words, said
):
    cluster = ("--cluster", where) if where else ()
    assert said in refused("sweep", "orbits.yaml", *QUIET, *cluster, *words)


@pytest.mark.parametrize("trap", ["ca.pem", "cert.pem", "key.pem"])
def test_file_that_is_no_certificate_is_told(refused, swept, secret, trap):
    words = pem(swept, secret)
    (swept / trap).write_text("-----BEGIN")
    where = ("--cluster", "tls://127.0.0.1:9")
    error = refused("sweep", "orbits.yaml", *QUIET, *where, *words)
    assert "the certificates cannot be read" in error


@pytest.fixture(scope="module")
def own(secret):
    """Return a client of a local cluster, with a worker that is a process."""
    with study_cluster.local_cluster(1) as client:
        yield client


def test_local_cluster_obeys_nobody_without_its_key(own, secret):
    assert own.submit(pow, 2, 5).result() == 32
    workers = own.scheduler_info()["workers"]
    nannies = [one["nanny"] for one in workers.values()]
    every = [own.scheduler.address, *workers, *nannies]
    assert len(every) == 3
    for address in every:
        assert address.startswith("tls://127.0.0.1:")
        assert asyncio.run(asked(address, own.security))["type"]
        for stranger in (secret, None):
            way = address if stranger else address.replace("tls://", "tcp://")
            with pytest.raises(OSError, match=r"(?i)timed out|comm|ssl|fail"):
                asyncio.run(asked(way, stranger))


async def asked(address, security):
    """Ask a scheduler or a worker for its identity, as every stranger may."""
    context = security.get_connection_args("client") if security else {}
    async with distributed.rpc(address, connection_args=context, timeout=1) as server:
        return await server.identity()


def test_a_local_cluster_listens_for_its_own_processes_alone(own):
    (info,) = own.scheduler_info()["workers"].values()
    pages = own.dashboard_link, f"http://127.0.0.1:{info['services']['dashboard']}/"
    for page in pages:
        with pytest.raises(urllib.error.URLError, match="refused"):
            urllib.request.urlopen(page, timeout=5)


def test_a_local_cluster_leaves_no_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with study_cluster.local_cluster(1) as client:
        assert client.submit(pow, 2, 5).result() == 32
        assert [path.name.startswith("drysim-") for path in tmp_path.iterdir()] == [True]
    assert not list(tmp_path.iterdir())


def test_local_cluster_without_a_temporary_folder_says_what_to_do(monkeypatch):
    def gettempdir():
        raise FileNotFoundError(2, "No usable temporary directory found")

    monkeypatch.setattr(study_cluster.tempfile, "gettempdir", gettempdir)
    with pytest.raises(UsageError, match="temporary folder"), study_cluster.local_cluster(1):
        pass


def test_files_of_a_local_cluster_are_for_the_user_alone(own):
    (info,) = own.scheduler_info()["workers"].values()
    folder = Path(info["local_directory"]).parents[1]
    assert folder.name.startswith("drysim-")
    assert folder.stat().st_mode & 0o777 == 0o700


class Client:
    """A client that sees so many threads of workers, look by look."""

    def __init__(self, threads):
        self.threads = iter(threads)

    def nthreads(self):
        return {"tcp://a:1": next(self.threads)}


LEFT = "it has no worker left; a block may have crashed them; waiting for one (dask worker it)"
NONE = "it has no worker; waiting for one (dask worker it)"
STILL = "it has had no worker for 10 s; waiting for one (dask worker it)"


@pytest.mark.parametrize(
    ("threads", "clock", "said", "warned"),
    [
        ([2, 0, 0, 0, 0, 1, 0, 0], [1, 5, 7, 14, 60, 61, 62, 75], [], [LEFT] * 2),
        ([0] * 5, [1, 3, 9, 11, 60], [NONE], [STILL]),
    ],
)
def test_nobody_waits_in_silence_for_a_worker(monkeypatch, threads, clock, said, warned):
    now, told, warnings = [0.0], [], []
    monkeypatch.setattr(study_cluster.time, "monotonic", lambda: now[0])
    executor = study_cluster.ClusterExecutor(
        Client(threads), "it", "dask worker it", told.append, warnings.append
    )
    for seconds in clock:
        now[0] = float(seconds)
        executor.poll()
    assert (told, warnings) == (said, warned)
