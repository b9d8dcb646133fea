"""Faults while working: signals, full disks and dying workers, at random instants."""

from __future__ import annotations

import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from seat import SEAT

from drysim import output
from drysim.cli import main

GRID = "sweep: {excitation.frequency: {from: 0.5, to: 5, count: 100}}\n"
SCENARIO = SEAT.replace("duration: 2", "duration: 9") + GRID
COMMANDS = {
    "run": ("run", "seat.yaml"),
    "sweep": ("sweep", "seat.yaml"),
    "compare": ("compare", "signum", "vs", "stick-slip", "-s", "seat.yaml",
                "--set", "sweep.excitation.frequency={from: 1, to: 5, count: 6}"),
}  # fmt: skip
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
KILLS = 4
"""Random instants of each command under each signal."""


def hears():
    """Take every signal as a terminal does; a session begun by nohup hands down deaf ones."""
    for number in SIGNALS[1:]:
        signal.signal(number, signal.SIG_DFL)


def started(folder, *words, **options):
    """Begin a command whose results are the same each time."""
    options = {"preexec_fn": hears} | options
    environment = os.environ | {"SOURCE_DATE_EPOCH": "0", "DRYSIM_ENGINE": "plain"}
    return subprocess.Popen(
        [sys.executable, "-m", "drysim", *words, "--no-plots", "--quiet", "--out", "out"],
        cwd=folder, env=environment, stderr=subprocess.PIPE, text=True, **options,
    )  # fmt: skip


def finished(folder, *words, **options):
    """Run it to its end; give exit code and stderr."""
    running = started(folder, *words, **options)
    _, said = running.communicate(timeout=120)
    return running.returncode, said


def held(folder):
    """Return the content of an output folder; None where there is none."""
    return (
        {file.name: file.read_bytes() for file in folder.iterdir()} if folder.exists() else None
    )


@pytest.mark.slow
@pytest.mark.by_hand
@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("number", SIGNALS, ids=[number.name for number in SIGNALS])
def test_signal_at_any_instant_leaves_the_old_the_new_or_a_partial(tmp_path, name, number):
    (tmp_path / "seat.yaml").write_text(SCENARIO)
    words = COMMANDS[name]
    assert finished(tmp_path, *words, "--set", "oscillator.mass=70") == (0, "")
    old = held(tmp_path / "out")
    shutil.copytree(tmp_path / "out", tmp_path / "kept")
    began = time.perf_counter()
    assert finished(tmp_path, *words) == (0, "")
    takes, new = time.perf_counter() - began, held(tmp_path / "out")
    assert new != old
    dice, ends = np.random.default_rng(int(number)), []
    for _ in range(KILLS):
        shutil.rmtree(tmp_path / "out")
        shutil.copytree(tmp_path / "kept", tmp_path / "out")
        running = started(tmp_path, *words)
        time.sleep(dice.uniform(0.05, 1.0) * takes)
        running.send_signal(number)
        _, said = running.communicate(timeout=60)
        ends.append(running.returncode)
        assert running.returncode in (0, 130, -number)
        assert "Traceback" not in said or running.returncode != 130
        # A kill between two renames leaves the old folder beside the new one.
        names = {path.name for path in tmp_path.iterdir()}
        assert names <= {"seat.yaml", "kept", "out", "out.partial", "out.replaced"}
        assert held(tmp_path / ("out" if "out" in names else "out.replaced")) in (old, new)
        again = [*words, "--resume"] if name == "sweep" else words
        assert finished(tmp_path, *again)[0] == 0
        assert held(tmp_path / "out").keys() == new.keys()
        for file in set(new) - {"drysim.json"}:
            assert held(tmp_path / "out")[file] == new[file]
        assert {path.name for path in tmp_path.iterdir()} == {"seat.yaml", "kept", "out"}
    assert set(ends) != {0}


def limited(size):
    """Limit the size of files, as a full disk does; Python ignores the signal."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


@pytest.mark.slow
@pytest.mark.by_hand
@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("size", [0, 200, 3000, 15_000])
def test_file_that_cannot_grow_leaves_the_old_folder_and_says_why(tmp_path, name, size):
    (tmp_path / "seat.yaml").write_text(SCENARIO)
    words = COMMANDS[name]
    assert finished(tmp_path, *words, "--set", "oscillator.mass=70") == (0, "")
    old = held(tmp_path / "out")
    code, said = finished(tmp_path, *words, preexec_fn=limited(size))
    assert code == 2
    assert said.startswith("error: cannot write out: file too large\n")
    assert held(tmp_path / "out") == old
    assert finished(tmp_path, *words, *(["--resume"] if name == "sweep" else []))[0] == 0
    assert not (tmp_path / "out.partial").exists()


@pytest.fixture
def small_disk(tmp_path):
    """Return a function that mounts a disk of some size [kB]; root alone may."""
    disk = tmp_path / "disk"
    disk.mkdir()

    def mounted(size):
        words = ["mount", "-t", "tmpfs", "-o", f"size={size}k", "tmpfs", str(disk)]
        if (
            shutil.which("mount") is None
            or subprocess.run(words, capture_output=True).returncode
        ):
            pytest.skip("mounting a disk needs root")
        return disk

    yield mounted
    subprocess.run(["umount", str(disk)], capture_output=True)


@pytest.mark.slow
@pytest.mark.by_hand
@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("size", [8, 16, 40, 100])
def test_full_disk_leaves_nothing_but_what_can_be_resumed(small_disk, name, size):
    disk = small_disk(size)
    (disk / "seat.yaml").write_text(SCENARIO)
    code, said = finished(disk, *COMMANDS[name])
    assert code == 0 or re.match(
        r"error: cannot write out: (no space left on device|it needs .+ and .+ are free)$",
        said.splitlines()[0],
    )
    assert code in (0, 2)
    assert (disk / "out").exists() == (code == 0)
    left = {path.name for path in disk.iterdir()} - {"seat.yaml", "out"}
    assert left <= ({"out.partial"} if name == "sweep" else set())
    if code:
        assert "free disk space" in said


@pytest.mark.parametrize("death", [MemoryError(), RuntimeError("a bug")])
def test_worker_that_dies_loses_no_finished_case(seat, monkeypatch, capsys, death):
    seat.write_text(SEAT + "sweep: {excitation.frequency: {from: 1, to: 5, count: 90}}\n")
    monkeypatch.chdir(seat.parent)
    words = ["sweep", "seat.yaml", "--no-plots", "--quiet", "--workers", "3", "--out"]
    assert main([*words, "whole"]) == 0
    from drysim.study.plan import Plan

    whole = Plan.block

    def mortal(plan, number):
        if number > 45:
            raise death
        return whole(plan, number)

    monkeypatch.setattr(Plan, "block", mortal)
    assert main([*words, "out"]) in (2, 70)
    assert not Path("out").exists()
    assert output.resumable_parts(Path("out"))
    monkeypatch.setattr(Plan, "block", whole)
    assert main([*words, "out", "--resume"]) == 0
    table = Path("out/transmissibility.csv").read_bytes()
    assert table == Path("whole/transmissibility.csv").read_bytes()


@pytest.mark.parametrize("clock", [-1e9, 0.0, 4e9])
def test_clock_that_is_set_back_changes_nothing_but_the_date(seat, drysim, monkeypatch, clock):
    assert drysim("run", seat, "--no-plots").code == 0
    now = held(seat.parent / "out/seat")
    monkeypatch.setattr(time, "time", lambda: clock)
    assert drysim("run", seat, "--no-plots").code == 0
    then = held(seat.parent / "out/seat")
    assert {name for name in now if now[name] != then[name]} == {"drysim.json"}


@pytest.mark.slow
@pytest.mark.by_hand
def test_tables_are_the_same_bytes_whatever_workers_run_and_engine(tmp_path):
    (tmp_path / "seat.yaml").write_text(SCENARIO + "reference: viscous\n")
    tables = set()
    for engine in ("plain", "compiled"):
        for workers in ("1", "2", "5"):
            words = f"-m drysim sweep seat.yaml --no-plots -q -o out --workers {workers}"
            environment = os.environ | {"DRYSIM_ENGINE": engine}
            command = [sys.executable, *words.split()]
            subprocess.run(command, cwd=tmp_path, env=environment, check=True)
            tables.add((tmp_path / "out/transmissibility.csv").read_bytes())
    assert len(tables) == 1
