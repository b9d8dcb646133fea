"""Sweeps on processes of their own: the very same tables, whoever is killed on the way."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
from collections import Counter
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from cluster_scenes import ORBITS, QUIET, blocks_in, pem, table, written
from machines import PATIENCE, Machines, command

from drysim.cli.process import INTERRUPT_MESSAGE

pytest.importorskip("distributed")
pytestmark = [pytest.mark.slow, pytest.mark.by_hand]

LONG = ORBITS.replace("count: 300", "count: 10000")
BLOCKS = 79
"""Of them: 59 of orbits, 20 of the reference, which has no friction to vary."""

LONGER = ORBITS.replace("count: 300", "count: 60000")
"""So much that it is not done before anybody can interrupt it."""

HEARD = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
"""A test session in the background hands an ignored signal down to its children."""

DISASTERS, SEED = 32, 20
"""How many, and by which seed their kind, instant and measure are drawn."""


@pytest.fixture(scope="module")
def far(tmp_path_factory):
    """Return a scheduler with two workers."""
    with Machines(tmp_path_factory.mktemp("machines")) as machines:
        yield machines


@pytest.fixture
def swept(tmp_path):
    """Write every scenario."""
    return written(tmp_path)


def answer(folder, *words):
    """Return exit code and stderr of a command."""
    done = subprocess.run(
        command(*words, *QUIET), cwd=folder, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stderr


@pytest.mark.parametrize("name", ["orbits", "seeds"])
def test_table_is_the_same_from_threads_processes_and_machines(swept, far, name):
    ways = {
        "one": ("--workers", 1),
        "two": ("--workers", 2),
        "processes": ("--cluster", "local", "--workers", 2),
        "machines": ("--cluster", far.address),
    }
    far.mend()
    for out, way in ways.items():
        assert answer(swept, "sweep", f"{name}.yaml", "-o", out, *way) == (0, "")
        assert table(swept / out) == table(swept / "one")


@pytest.mark.parametrize("name", ["orbits", "seeds"])
def test_dataset_is_the_same_from_threads_processes_and_machines(swept, far, name):
    pytest.importorskip("pyarrow")
    from pyarrow import dataset

    far.mend()
    found = {}
    for way in ("", "local", far.address):
        words = ("sweep", f"{name}.yaml", "--format", "parquet")
        assert answer(swept, *words, *(["--cluster", way] if way else [])) == (0, "")
        folder = swept / "out" / name / "transmissibility"
        found[way] = dataset.dataset(folder, partitioning="hive").to_table()
        shutil.rmtree(swept / "out")
    assert found[""].num_rows
    assert found["local"].equals(found[""])
    assert found[far.address].equals(found[""])


@pytest.fixture
def disk(tmp_path):
    """Return a folder, and a function that gives its disk some size [kB]; root alone may."""
    folder = tmp_path / "disk"
    folder.mkdir()

    def sized(size):
        given = "remount," * os.path.ismount(folder) + f"size={size}k"
        words = ["mount", "-t", "tmpfs", "-o", given, "tmpfs", str(folder)]
        return shutil.which("mount") and not subprocess.run(words, check=False).returncode

    yield folder, sized
    while os.path.ismount(folder):
        subprocess.run(["umount", str(folder)], check=True)


def test_whoever_is_killed_nothing_is_lost_and_nothing_doubled(tmp_path, far, disk):
    folder, sized = disk
    (tmp_path / "long.yaml").write_text(LONG)
    words = ("sweep", tmp_path / "long.yaml")
    assert answer(tmp_path, *words, "-o", "whole")[0] == 0
    whole = table(tmp_path / "whole")
    cluster = ("--cluster", far.address)
    rng = np.random.Generator(np.random.PCG64(SEED))
    kinds = ["worker", "nanny", "scheduler", "client"] + ["disk"] * bool(sized(64))
    seen: Counter[str] = Counter()
    for number in range(DISASTERS):
        kind = kinds[number % len(kinds)]
        far.mend()
        if kind == "disk":
            assert sized(int(rng.integers(100, 6000)))
        out = (folder if kind == "disk" else tmp_path) / "out"
        running = subprocess.Popen(
            command(*words, *QUIET, "-o", out, *cluster), stderr=subprocess.PIPE, text=True
        )
        if kind != "disk":
            reached(out, int(rng.integers(0, BLOCKS + 1)), running)
            strike(kind, far, running)
        said = running.communicate(timeout=PATIENCE)[1]
        kept = blocks_in(out.with_name("out.partial"))
        seen[f"{kind} {running.returncode}"] += 1
        seen["kept"] += kept
        assert SAID[kind].get(running.returncode, "no such code") in said
        assert "Traceback" not in said
        if running.returncode:
            assert sized(64_000) or kind != "disk"
            far.mend()
            engine = cluster if rng.random() < 0.5 else ()
            assert answer(tmp_path, *words, "-o", out, "--resume", *engine) == (0, "")
        assert table(out) == whole
        assert not out.with_name("out.partial").exists()
        shutil.rmtree(out)
    print(dict(seen))
    assert min(seen[name] for name in ("scheduler 3", "client -9", "kept")) > 0


SAID = {
    "worker": {0: ""},
    "nanny": {0: ""},
    "scheduler": {0: "", 2: "no Dask scheduler answers at", 3: "is lost; finished blocks"},
    "client": {0: "", -9: ""},
    "disk": {0: "", 2: "no space left on device"},
}
"""What may come of each disaster: exit codes, and what is said with them."""


def reached(out, blocks, client):
    """Wait until so many blocks are kept, or the client has gone on to write its files."""
    late = time.monotonic() + PATIENCE
    partial = out.with_name("out.partial")
    while client.poll() is None and time.monotonic() < late:
        written = out.exists() or (partial / "transmissibility.csv").exists()
        if written or blocks_in(partial) >= blocks:
            return
        time.sleep(0.003)


def strike(kind, far, client):
    """Kill somebody."""
    if kind == "client":
        client.kill()
    elif kind == "scheduler":
        far.kill("scheduler")
    elif kind == "nanny":
        far.kill("one")
    else:
        far.kill_worker("two")


@pytest.mark.parametrize("kind", ["worker", "nanny", "scheduler"])
def test_whoever_is_killed_over_tls_nothing_is_lost(tmp_path, kind):
    pytest.importorskip("cryptography")
    from distributed.security import Security

    (tmp_path / "longer.yaml").write_text(LONGER)
    words = ("sweep", "longer.yaml", *QUIET, "-o", "out")
    certificates = pem(tmp_path, Security.temporary())
    with Machines(tmp_path, certificates) as far:
        way = ("--cluster", far.address, *certificates)
        running = subprocess.Popen(
            command(*words, *way), cwd=tmp_path, stderr=subprocess.PIPE, text=True
        )
        reached(tmp_path / "out", 3, running)
        strike(kind, far, running)
        said = running.communicate(timeout=PATIENCE)[1]
    assert "Traceback" not in said
    if kind == "scheduler":
        assert running.returncode == 3
        assert f"the scheduler at {far.address} is lost; finished blocks are kept" in said
        assert blocks_in(tmp_path / "out.partial") >= 3
        assert answer(tmp_path, *words, "--resume") == (0, "")
    assert (running.returncode, said) == (0, "") or kind == "scheduler"
    assert answer(tmp_path, "sweep", "longer.yaml", "-o", "whole") == (0, "")
    assert table(tmp_path / "out") == table(tmp_path / "whole")


def test_worker_of_a_local_cluster_that_is_killed_costs_nothing(tmp_path):
    pytest.importorskip("cryptography")
    (tmp_path / "longer.yaml").write_text(LONGER)
    way = ("--cluster", "local", "--workers", 2)
    running = subprocess.Popen(
        command("sweep", "longer.yaml", *QUIET, "-o", "out", *way), cwd=tmp_path,
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    reached(tmp_path / "out", 3, running)
    tasks = Path(f"/proc/{running.pid}/task").glob("*/children")
    workers = [
        child for task in tasks for child in task.read_text().split()
        if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()
    ]  # fmt: skip
    assert workers
    os.kill(int(workers[0]), signal.SIGKILL)
    said = running.communicate(timeout=PATIENCE)[1]
    assert (running.returncode, said) == (0, "")
    assert answer(tmp_path, "sweep", "longer.yaml", "-o", "whole") == (0, "")
    assert table(tmp_path / "out") == table(tmp_path / "whole")


@pytest.fixture
def deadly(tmp_path, monkeypatch):
    """Write a sweep with a block that ends its worker, and let the workers begin so."""
    words = ORBITS.replace("reference: viscous\n", "").replace("count: 300", "count: 1000")
    (tmp_path / "deadly.yaml").write_text(words)
    (tmp_path / "deadly.py").write_text(DEADLY)
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}")
    monkeypatch.setenv("DASK_DISTRIBUTED__WORKER__PRELOAD", "deadly")
    return ("sweep", "deadly.yaml", "-o", "out")


def test_block_that_ends_the_last_worker_is_said_even_in_quiet(tmp_path, deadly):
    with Machines(tmp_path, nanny=False) as far:
        running = subprocess.Popen(
            command(*deadly, *QUIET, "--cluster", far.address),
            cwd=tmp_path, stderr=subprocess.PIPE, text=True, preexec_fn=HEARD,
        )  # fmt: skip
        said = running.stderr.readline()
        running.send_signal(signal.SIGINT)
        last = running.communicate(timeout=PATIENCE)[1]
    assert f"the scheduler at {far.address} has no worker left" in said
    assert f"dask worker {far.address}" in said
    assert running.returncode == 130
    assert "interrupted" in last
    assert "Traceback" not in last


def test_interrupted_client_leaves_what_can_be_resumed(tmp_path, far):
    (tmp_path / "longer.yaml").write_text(LONGER)
    far.mend()
    for way in (far.address, "local"):
        words = ("sweep", "longer.yaml", *QUIET, "-o", "out", "--cluster", way)
        running = subprocess.Popen(
            command(*words), cwd=tmp_path, stderr=subprocess.PIPE, text=True,
            start_new_session=True, preexec_fn=HEARD,
        )  # fmt: skip
        late = time.monotonic() + PATIENCE
        while blocks_in(tmp_path / "out.partial") < 3 and time.monotonic() < late:
            time.sleep(0.02)
        os.killpg(running.pid, signal.SIGINT)  # as a terminal does, to all of its processes
        said = running.communicate(timeout=PATIENCE)[1]
        assert running.returncode == 130
        # On a busy machine the exit is forced: Python may then report the semaphores that it
        # removes, and the work is ended in general words, after or before it says what it kept.
        lines = [line for line in said.splitlines() if "resource_tracker" not in line]
        assert lines
        assert all("kept in out.partial" in line or line == INTERRUPT_MESSAGE for line in lines)
        assert answer(tmp_path, "sweep", "longer.yaml", "-o", "out", "--resume") == (0, "")
        shutil.rmtree(tmp_path / "out")


def test_block_that_ends_its_workers_is_named_and_all_others_are_finished(
    tmp_path, deadly, monkeypatch
):
    with Machines(tmp_path) as far:
        code, said = answer(tmp_path, *deadly, "--cluster", far.address)
    assert code == 3
    assert "1 of the blocks crash every worker that computes them: 2" in said
    assert blocks_in(tmp_path / "out.partial") == 5
    monkeypatch.undo()
    assert answer(tmp_path, *deadly, "--resume") == (0, "")


DEADLY = """
import os
from drysim.study import plan

whole = plan.Plan.block

def deadly(self, number, *rest):
    if number == 2:
        os._exit(9)
    return whole(self, number, *rest)

def dask_setup(worker):
    plan.Plan.block = deadly
"""
