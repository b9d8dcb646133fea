"""Commands that are asked to end while a kernel is running, which nothing can interrupt."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading

import pytest
from seat import SEAT

from drysim import forced_exit, output
from drysim.cli import process

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="the lock of the C library is Linux's"
)
NOISE = "excitation={kind: psd, points: [[1, 1], [4, 1]], duration: 9, seeds: 9}"
ONE_NOISE = NOISE.replace("seeds: 9", "seed: 1")
SWEEP = "sweep.oscillator.mass={from: 50, to: 90, count: 8}"
NO_WINDOW = ("--set", "measure=null")

PROGRAM = """
import contextlib, ctypes, importlib, itertools, os, sys
from drysim import cli

def endless(*_, **__):
    libc, lock = ctypes.CDLL(None), ctypes.create_string_buffer(256)
    while True:
        with contextlib.suppress(KeyboardInterrupt):  # if it came just before
            os.write(1, b"endless\\n")  # at once, as several threads may come here
            while True:
                libc.pthread_mutex_lock(lock)  # without the interpreter lock, like a kernel

def patch(place, after):
    module, name = place.rsplit(".", 1)
    module = importlib.import_module(module)
    whole, calls = getattr(module, name), itertools.count()
    def patched(*words, **options):
        return (whole if next(calls) < after else endless)(*words, **options)
    setattr(module, name, patched)

{setup}
sys.argv = ["drysim", *sys.argv[1:]]
cli.command()
"""
"""A command in which functions never return once they have been called a number of times."""


def reset_signals():
    """Handle signals by default: below nohup, a process inherits that SIGHUP is ignored."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def interrupted(folder, setup, *words, number=signal.SIGINT, times=1):
    """Start a command, signal it in an endless kernel, and return its stderr."""
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM.format(setup=setup), *words, "--no-plots"],
        cwd=folder,
        env=os.environ | {"DRYSIM_ENGINE": "plain"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=reset_signals,
    ) as running:
        try:
            begun = running.stdout.readline()
            for _ in range(times):
                running.send_signal(number)
            _, stderr = running.communicate(timeout=60)
        finally:
            running.kill()
    assert begun == "endless\n", stderr
    assert running.returncode == 130
    assert "Traceback" not in stderr
    assert stderr.count("interrupted") == 1
    return stderr


def files(folder):
    """Return the files in a folder, but for the scenario beside it."""
    found = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    return sorted(path.as_posix() for path in found if path.name != "seat.yaml")


def completed(folder, *words):
    """Run a command to its end; return its output folder."""
    command = [sys.executable, "-m", "drysim", *words, "--no-plots", "--quiet"]
    environment = os.environ | {"DRYSIM_ENGINE": "plain"}
    subprocess.run(command, cwd=folder, env=environment, check=True)
    return folder / "out/seat"


@pytest.fixture
def folder(tmp_path):
    """Return a folder with a scenario."""
    (tmp_path / "seat.yaml").write_text(SEAT)
    return tmp_path


NOTHING_KEPT = {
    "the motion": ("patch('drysim.study.run.march_from_start', 0)", ("run", "seat.yaml")),
    "metrics": ("patch('drysim.study.run.observe', 0)", ("run", "seat.yaml")),
    "noise in threads": (
        "import drysim.excitation.random as noise; noise.MAX_CACHED = 0; "
        "patch('numpy.fft.irfft', 0)",
        ("run", "seat.yaml", "--set", ONE_NOISE, *NO_WINDOW),
    ),
    "writing": ("patch('drysim.output.folder.file_sha256', 0)", ("run", "seat.yaml")),
    "writing later": ("patch('drysim.output.folder.file_sha256', 2)", ("run", "seat.yaml")),
    "the first cases": (
        "patch('drysim.study.plan.solve_row', 0)",
        ("sweep", "seat.yaml", "--set", SWEEP, "--workers", "1"),
    ),
    "the first cases in threads": (
        "patch('drysim.study.plan.solve_row', 0)",
        ("sweep", "seat.yaml", "--set", SWEEP, "--workers", "2"),
    ),
    "the first seeds": (
        "patch('drysim.study.plan.solve_seeds', 0)",
        ("run", "seat.yaml", "--set", NOISE, *NO_WINDOW),
    ),
    "a comparison": (
        "patch('drysim.study.run.measure_motion', 1)",
        ("compare", "signum", "vs", "stick-slip", "-s", "seat.yaml", "--workers", "2"),
    ),
}
"""What never returns, by the stage of a command, and the command."""


@pytest.mark.parametrize("stage", NOTHING_KEPT)
def test_command_ends_in_an_endless_kernel_and_leaves_no_file(folder, stage):
    setup, words = NOTHING_KEPT[stage]
    number = signal.SIGTERM if "threads" in stage else signal.SIGINT
    interrupted(folder, setup, *words, number=number)
    assert files(folder) == []
    assert {path.name for path in folder.iterdir()} <= {"seat.yaml", "out"}


def test_old_result_stays_when_its_successor_ends_in_an_endless_kernel(folder):
    old = completed(folder, "run", "seat.yaml")
    before = {path: path.read_bytes() for path in old.iterdir()}
    interrupted(folder, "patch('drysim.output.folder.file_sha256', 1)", "run", "seat.yaml")
    assert {path: path.read_bytes() for path in old.iterdir()} == before
    assert [path.name for path in (folder / "out").iterdir()] == ["seat"]


RESUMED = {
    "cases": ("patch('drysim.study.plan.solve_row', 2)", ("--workers", "1")),
    "cases in threads": ("patch('drysim.study.plan.solve_row', 2)", ("--workers", "2")),
    "table": (
        "patch('drysim.study.plan.solve_row', 2)\npatch('drysim.output.folder.file_sha256', 1)",
        ("--workers", "2"),
    ),
}
"""What never returns once the first cases of a sweep are finished, and options."""


@pytest.mark.parametrize("stage", RESUMED)
def test_sweep_in_an_endless_kernel_keeps_its_cases(folder, stage):
    setup, options = RESUMED[stage]
    words = ("sweep", "seat.yaml", "--set", SWEEP)
    whole = completed(folder, *words).rename(folder / "whole")
    stderr = interrupted(folder, setup, *words, *options, times=3)
    assert "--resume" in stderr
    partial = folder / "out/seat.partial"
    assert output.resumable_parts(folder / "out/seat")
    assert (partial / "drysim.json").exists()
    if stage != "cases in threads":  # whose table is written
        assert not list(partial.glob("*.csv"))
        assert not list(partial.glob("*.yaml"))
    again = completed(folder, *words, "--resume") / "transmissibility.csv"
    assert again.read_bytes() == (whole / "transmissibility.csv").read_bytes()
    assert not partial.exists()


@pytest.mark.parametrize("place", ["solve_seeds", "one_case.solve"])
def test_run_in_an_endless_kernel_keeps_its_seeds(folder, place):
    words = ("run", "seat.yaml", "--set", NOISE, *NO_WINDOW)
    whole = completed(folder, *words).rename(folder / "whole")
    setup = "patch('drysim.study.plan.solve_seeds', 3)"
    if place != "solve_seeds":  # the seed shown of those that are finished
        setup = (
            "import time, drysim.study.ensemble as ensemble, drysim.study.plan as plan\n"
            "one_case = ensemble.one_case = type(sys)('one_case')\n"
            "one_case.solve = endless\n"
            "def row(*_, whole=plan.solve_seeds, left=iter(range(3))):\n"
            "    if next(left, None) is None:\n"
            "        cli.process.signal.raise_signal(cli.process.signal.SIGINT)\n"
            "    return whole(*_)\n"
            "plan.solve_seeds = row\n"
        )
    # One worker: another one is killed, and the command itself ends in order.
    stderr = interrupted(folder, setup, *words, "--workers", "1")
    assert "--resume" in stderr
    partial = folder / "out/seat.partial"
    assert [path for path in files(partial) if path.endswith(".csv")] == []
    again = completed(folder, *words, "--resume") / "ensemble.csv"
    assert again.read_bytes() == (whole / "ensemble.csv").read_bytes()
    assert not partial.exists()


@pytest.mark.slow
@pytest.mark.by_hand
def test_compiled_kernel_that_would_run_for_hours_ends(folder):
    setup = (
        "os.environ['DRYSIM_ENGINE'] = 'compiled'\n"
        "import drysim.orbits.coulomb as coulomb\n"
        "from drysim.core.forcing import B\n"
        "def long(scenes, whole=coulomb.solve_orbits):\n"
        "    damped = scenes[:1].copy()\n"
        "    damped[:, B] = 1e3\n"
        "    whole(damped)  # compiles the kernel\n"
        "    os.write(1, b'endless\\n')\n"
        "    return whole(scenes)\n"
        "coulomb.solve_orbits = long\n"
    )
    pair = "[{frequency: 1, rms: 1}, {frequency: 1.001, rms: 1}]"
    changes = (
        "oscillator.damping=0",
        "friction.kinetic=0",
        f"excitation={{kind: sines, components: {pair}}}",
        SWEEP.replace("count: 8", "count: 500"),
        "measure={steady: true}",
    )
    words = [word for one in changes for word in ("--set", one)]
    interrupted(folder, setup, "sweep", "seat.yaml", *words, "--workers", "1")
    assert files(folder) == []


@pytest.fixture
def exit_lock(monkeypatch):
    """Return a lock of this test in place of the one that a forced exit keeps."""
    lock = threading.Lock()
    monkeypatch.setattr(forced_exit, "_exit_lock", lock)
    return lock


def test_clean_ups_run_latest_first_and_only_within_their_block(exit_lock):
    def fail():
        raise OSError

    calls = []
    with (
        forced_exit.at_forced_exit(lambda: calls.append(1) or "kept"),
        forced_exit.at_forced_exit(fail),
    ):
        with forced_exit.at_forced_exit(lambda: calls.append(2)):
            pass
        with forced_exit.at_forced_exit(lambda: calls.append(3)):
            assert forced_exit.clean_up() == "kept"
    assert calls == [3, 1]


def test_forced_exit_waits_for_what_it_must_not_divide(exit_lock):
    cleaned = threading.Event()
    with forced_exit.no_forced_exit():
        leaving = threading.Thread(target=lambda: forced_exit.clean_up() or cleaned.set())
        leaving.start()
        assert not cleaned.wait(0.05)
    leaving.join(60)
    assert cleaned.is_set()
    assert exit_lock.locked()  # what comes later must not begin


def test_a_second_signal_does_not_interrupt_the_clean_up(monkeypatch):
    monkeypatch.setattr(process, "INTERRUPT_REQUESTED", threading.Event())
    monkeypatch.setattr(sys, "unraisablehook", None)
    with pytest.raises(KeyboardInterrupt):
        process._handle_signal(signal.SIGINT, None)
    process._handle_signal(signal.SIGINT, None)
