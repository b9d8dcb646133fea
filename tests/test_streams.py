"""Streams that are full, closed or know few letters, and signals that ask to go."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import nullcontext, suppress
from functools import partial

import pytest
from cluster_scenes import blocks_in
from seat import tree

from drysim.cli import process
from drysim.console import summary, terminal
from drysim.parallel import map_in_order

FULL = pytest.mark.skipif(
    not os.path.exists("/dev/full"), reason="needs a device that is always full"
)
MASSES = "oscillator.mass: {from: 50, to: 90, count: 2000}"
DAMPERS = "oscillator.damping: {from: 100, to: 900, count: 1000}"
SWEEP = ("--set", f"sweep={{{MASSES}, {DAMPERS}}}", "--no-plots")
PLAIN_C = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


def shell(folder, words, **environment):
    """Run drysim in a shell that redirects its streams."""
    return subprocess.run(
        ["bash", "-c", f"{sys.executable} -m drysim {words}"],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
    )


@FULL
@pytest.mark.parametrize("words", ["", "--json", "--set 'checks=[T_a < 9]'"])
def test_results_that_cannot_be_told_are_written_and_end_with_1(seat, words):
    done = shell(seat.parent, f"run seat.yaml --no-plots {words} > /dev/full")
    assert done.returncode == 1
    assert done.stderr == (
        "error: cannot write to stdout: no space left on device\n\n"
        "the files in out/seat are complete\n"
    )
    assert (seat.parent / "out/seat/drysim.json").exists()


@FULL
@pytest.mark.parametrize(
    "words", ["--help", "--version", "run --help", "schema", "init --list"]
)
def test_words_alone_that_cannot_be_told_end_with_2(seat, words):
    done = shell(seat.parent, f"{words} > /dev/full")
    assert done.returncode == 2
    assert done.stderr == "error: cannot write to stdout: no space left on device\n"


@FULL
@pytest.mark.parametrize(("words", "code"), [("", 0), ("--set mass=1", 2), ("--frob", 2)])
def test_full_stderr_changes_nothing_but_what_is_heard(seat, words, code):
    done = shell(seat.parent, f"run seat.yaml --no-plots {words} 2> /dev/full")
    assert done.returncode == code
    assert (seat.parent / "out/seat").exists() == (code == 0)


WORDS = [
    ("run seat.yaml --no-plots", 0),
    ("run seat.yaml --dry-run", 0),
    ("run seat.yaml --set oscillator.mäss=1", 2),
    ("run größe.yaml --no-plots", 2),  # there is no folder of that name here
    ("validate seat.yaml größe.yaml", 0),
    ("validate seat.yaml --format json", 0),
    ("run --help", 0),
    ("schema", 0),
    ("init --list", 0),
    ("frobö", 2),
]


@pytest.mark.slow
@pytest.mark.parametrize(("words", "code"), WORDS)
@pytest.mark.parametrize("encoding", ["", "ascii:strict"])
def test_locale_without_letters_shows_question_marks_and_no_traceback(
    seat, words, code, encoding
):
    text = seat.read_text() + 'about: "ü, x² in Ω"\n'
    seat.write_text(text, encoding="utf-8")
    seat.with_name("größe.yaml").write_text(text.replace("name: seat", "name: größe"), "utf-8")
    done = shell(seat.parent, words, **PLAIN_C, PYTHONIOENCODING=encoding)
    assert done.returncode == code
    assert done.stdout + done.stderr
    assert "Traceback" not in done.stderr


def test_no_home_and_no_cache_are_nothing_to_tell(seat):
    nowhere = {"HOME": "/proc/nowhere", "XDG_CACHE_HOME": "/proc/nowhere", "PATH": "/usr/bin"}
    done = shell(seat.parent, "run seat.yaml --quiet", **nowhere)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGINT"])
def test_sweep_that_is_asked_to_go_says_so_once_and_keeps_its_cases(seat, name):
    words = [sys.executable, "-m", "drysim", "sweep", "seat.yaml", *SWEEP]
    # A test session that nohup started hands an ignored signal down to its children.
    heard = partial(signal.signal, getattr(signal, name), signal.SIG_DFL)
    piped = {"stderr": subprocess.PIPE, "text": True, "preexec_fn": heard}
    running = subprocess.Popen(words, cwd=seat.parent, **piped)
    until = time.monotonic() + 240
    while not blocks_in(seat.parent / "out/seat.partial"):
        assert time.monotonic() < until
        time.sleep(0.01)
    running.send_signal(getattr(signal, name))
    _, said = running.communicate(timeout=60)
    assert running.returncode == 130
    assert said.count("interrupted") == 1
    assert "--resume" in said
    assert not (seat.parent / "out/seat").exists()


def test_fault_that_comes_of_an_interruption_is_no_bug(drysim, seat, monkeypatch):
    def cut_short(_):
        process.INTERRUPT_REQUESTED.set()
        raise AttributeError("partially initialised module")

    monkeypatch.setattr(process, "INTERRUPT_REQUESTED", threading.Event())
    monkeypatch.setattr("drysim.cli.INTERRUPT_REQUESTED", process.INTERRUPT_REQUESTED)
    monkeypatch.setattr("drysim.study.run.solve", cut_short)
    answer = drysim("run", seat)
    assert answer.code == 130
    assert "Traceback" not in answer.err


NOISE = "{kind: psd, points: [[1, 1], [4, 1]], duration: 1, seeds: 30}"
MANY = {
    "cases": ("sweep", "--set", f"sweep={{{MASSES}, {DAMPERS}}}"),
    "seeds": ("run", "--set", f"excitation={NOISE}", "--set", "measure=null"),
}


@pytest.mark.parametrize("kind", MANY)
@pytest.mark.parametrize("finished", [0, 2])
def test_interruption_is_told_before_the_summary_of_what_is_finished(
    drysim, seat, monkeypatch, kind, finished
):
    told = []

    def advance(number=1, left=iter(range(finished))):  # noqa: B008 - one for all calls
        if next(left, None) is None:
            raise KeyboardInterrupt

    monkeypatch.setattr(terminal, "progress", lambda *_: nullcontext(advance))
    for name in ("show_interrupted", "show_summary"):
        monkeypatch.setattr(summary, name, lambda *_, name=name, **__: told.append(name))
    command, *words = MANY[kind]
    quick = ("--workers", 1, "--no-plots", "--set", "checks=[T_a < 1e-3]")
    assert drysim(command, seat, *words, *quick).code == 130
    assert told == ["show_interrupted", "show_summary"]


def test_interruption_in_quiet_is_told_in_one_line(drysim, seat, monkeypatch):
    def advance(number=1):
        raise KeyboardInterrupt

    monkeypatch.setattr(terminal, "progress", lambda *_: nullcontext(advance))
    quiet = ("-q", "--no-plots", "--set", "checks=[T_a < 1e-3]")
    done = drysim("sweep", seat, *SWEEP, *quiet)
    assert (done.code, done.out) == (130, "")
    assert done.err.startswith("interrupted: ")
    assert done.err.count("\n") == 1


LLVM = "Could not find/load shared object file 'libllvmlite.so' from resource location: 'x'."


@pytest.mark.parametrize(
    ("fault", "code", "sentence"),
    [
        (OSError(LLVM), 70, "Traceback"),
        (OSError(errno.ENOMEM, "Cannot allocate memory"), 2, "error: out of memory"),
    ],
)
def test_fault_that_names_no_file_is_not_blamed_on_stdout(
    drysim, seat, monkeypatch, fault, code, sentence
):
    def fail(_):
        raise fault

    monkeypatch.setattr("drysim.study.run.solve", fail)
    done = drysim("run", seat)
    assert (done.code, done.out) == (code, "")
    assert done.err.startswith(sentence)
    assert "cannot write to stdout" not in done.err


@pytest.mark.parametrize("kind", MANY)
def test_interrupt_that_python_passes_over_ends_the_work_soon(drysim, seat, monkeypatch, kind):
    class Finalised:
        def __del__(self):
            process.INTERRUPT_REQUESTED.set()  # the exception is printed only

    def progress(*_):
        return nullcontext(lambda number=1: Finalised() and None)

    monkeypatch.setattr(process, "INTERRUPT_REQUESTED", threading.Event())
    monkeypatch.setattr(terminal, "progress", progress)
    done = drysim(*MANY[kind][:1], seat, *MANY[kind][1:], "--workers", 1, "--no-plots", "-q")
    assert done.code == 130
    assert kind[:-1] in done.err
    assert "kept in out/seat.partial; the same command with --resume" in done.err


DEAF = """
import ctypes, signal
from drysim.cli.process import install_signal_handlers
for name in "SIGINT", "SIGTERM", "SIGHUP":  # which may be ignored here
    signal.signal(getattr(signal, name), signal.default_int_handler)
install_signal_handlers()
libc, lock = ctypes.CDLL(None), ctypes.create_string_buffer(256)
libc.pthread_mutex_lock(lock)
try:
    print("deaf", flush=True)
    libc.pthread_mutex_lock(lock)
except KeyboardInterrupt:  # which came before it was deaf
    libc.pthread_mutex_lock(lock)
"""
"""Waits for itself in C, for ever, without the lock of the interpreter: as in a kernel."""


@pytest.mark.skipif(sys.platform != "linux", reason="the lock of the C library is Linux's")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_process_deep_in_a_kernel_obeys_a_signal(name):
    running = subprocess.Popen(
        [sys.executable, "-c", DEAF], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert running.stdout.readline() == "deaf\n"
    while running.poll() is None:
        running.send_signal(getattr(signal, name))
        with suppress(subprocess.TimeoutExpired):
            running.wait(3.0 * process.SIGNAL_TIMEOUT)
    assert running.returncode == 130
    assert running.communicate()[1] == process.INTERRUPT_MESSAGE + "\n"


@pytest.mark.parametrize("threads", [2, 3])
def test_endless_work_of_a_thread_does_not_keep_who_is_interrupted(threads):
    free, begun = threading.Event(), threading.Event()

    def work(piece):
        if piece == 1:
            begun.set()
            free.wait()
        return piece

    found = map_in_order(work, range(9), threads)
    assert next(found) == 0
    assert begun.wait(60)
    found.close()
    assert not free.is_set()
    free.set()


def test_signal_that_is_ignored_stays_so(seat):
    program = (
        "import signal, sys\n"
        "signal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
        "from drysim.cli.process import install_signal_handlers\n"
        "install_signal_handlers()\n"
        "print(signal.getsignal(signal.SIGHUP) == signal.SIG_IGN,\n"
        "      callable(signal.getsignal(signal.SIGTERM)))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout == "True True\n"


def test_what_runners_of_workflows_obey_is_shown_and_not_obeyed(drysim, seat):
    evil = '"::add-mask::x ##[group]y ##vso[task.setvariable]z\\n::error::w"'
    seat.write_text(seat.read_text() + f"about: {evil}\nchecks: ['T_a < 9']\n")
    said = drysim("run", seat, "--no-plots").out
    assert "\\::add-mask::x # #[group]y # #vso[task" in said
    assert not any(line.lstrip().startswith("::") for line in said.splitlines())
    assert "##" not in said


def test_annotations_of_github_are_one_line_whatever_the_file_says(drysim, seat):
    seat.write_text(seat.read_text() + '"a\\n::error::b\\e[31m\\u0085%0A": 1\n')
    said = drysim("validate", seat, "--format", "github").out
    assert said.startswith("::error file=")
    assert said.count("\n") == 1
    assert all(sign.isprintable() for sign in said.rstrip("\n"))
    assert tree(seat.parent).keys() == {"seat.yaml"}
