"""Parallel work gives the results of serial work, and leaves no process behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future
from pathlib import Path

import pytest

from drysim import parallel
from drysim.errors import UsageError

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are forked on Linux")

HEADER = """
import os, signal, sys, time
from drysim import parallel
parallel.allow_processes()

def alive(pids):
    return [pid for pid in pids if os.path.exists(f"/proc/{pid}")]

def begin(n):
    # The first item takes so long that the others are shared.
    if n == 0:
        time.sleep(0.15)
    return os.getpid()

def square(n):
    return n * n, begin(n)

def endless(n):
    while n > 3:
        os.write(1, f"{os.getpid()}\\n".encode())
        time.sleep(600)
    return begin(n)
"""


def program(body, **options):
    """Run a program that may fork workers; return its stdout."""
    done = subprocess.run(
        [sys.executable, "-c", HEADER + body], capture_output=True, text=True, timeout=120
    )
    assert (done.returncode, done.stderr) == (options.get("code", 0), ""), done.stderr
    return done.stdout


@pytest.mark.parametrize("items", ["range(40)", "list(range(40))", "iter(range(40))"])
@pytest.mark.parametrize("workers", [1, 2, 5])
def test_results_are_those_of_the_items_in_order_whoever_finds_them(items, workers):
    said = program(f"""
found = list(parallel.map_in_order(square, {items}, {workers}))
print([n for n, _ in found] == [n * n for n in range(40)])
others = {{pid for _, pid in found[{workers}:]}}
print(len(others) <= {workers}, (os.getpid() in others) == ({workers} == 1))
print(alive(others - {{os.getpid()}}))
""")
    assert said == "True\nTrue True\n[]\n"


def test_short_work_is_done_without_workers():
    said = program("""
found = list(parallel.map_in_order(square, range(1, 9), 3))
print({pid for _, pid in found} == {os.getpid()})
""")
    assert said == "True\n"


def test_many_short_items_are_each_worked_on_once():
    said = program("""
def short(n):
    time.sleep(1e-3)
    return n, os.getpid()
found = list(parallel.map_in_order(short, range(601), 3))
print([n for n, _ in found] == list(range(601)), len({pid for _, pid in found}) <= 4)
""")
    assert said == "True True\n"


@pytest.mark.parametrize("workers", [2, 3])
def test_few_long_items_are_worked_on_at_the_same_time(workers):
    said = program(f"""
import threading
together = threading.Barrier({workers})
def waits(n):
    together.wait(60)
    return n
print(list(parallel.map_in_order(waits, range({workers}), {workers})))
""")
    assert said == f"{list(range(workers))}\n"


def test_worker_that_is_killed_while_it_hands_over_a_large_result_is_noticed():
    said = program("""
from drysim.errors import SolverError
class Large:
    def __reduce__(self):
        threading.Timer(0.03, os.kill, (os.getpid(), signal.SIGKILL)).start()
        return bytes, (b"x" * 50_000_000,)
import threading
def large(n):
    begin(n)
    return Large() if n > 3 else n
try:
    print(len(list(parallel.map_in_order(large, range(12), 2))))
except SolverError as fault:
    print(fault, flush=True)
os._exit(0)
""")
    assert said == "a worker process ended early, perhaps for lack of memory\n"


def test_work_within_a_worker_starts_no_further_processes():
    said = program("""
def outer(n):
    inner = list(parallel.map_in_order(square, range(3), 2))
    return {pid for _, pid in inner} == {begin(n)}
found = list(parallel.map_in_order(outer, range(4), 2))
print(found[2:])
""")
    assert said == "[True, True]\n"


def test_work_within_threads_starts_no_processes():
    said = program("""
def outer(n):
    return [pid == os.getpid() for _, pid in parallel.map_in_order(square, range(12), 3)]
found = list(parallel.map_in_order(outer, range(3), 6))
print(all(map(all, found)), len(found))
""")
    assert said == "True 3\n"


@pytest.mark.parametrize(
    "lacks",
    [
        "sys.modules['multiprocessing.synchronize'] = None",
        "os.fork = lambda: (_ for _ in ()).throw(BlockingIOError(11, 'no more processes'))",
    ],
)
def test_without_processes_threads_do_the_work(lacks):
    said = program(f"""
{lacks}
found = list(parallel.map_in_order(square, range(9), 3))
print(found == [(n * n, os.getpid()) for n in range(9)])
""")
    assert said == "True\n"


def test_error_of_an_item_is_raised_and_the_workers_end():
    said = program("""
from drysim.errors import RecordError, Problem
def fails(n):
    if n == 3:
        raise RecordError(Problem("bad cell", "a.csv", 7), "look there")
    return begin(n)
pids = []
try:
    for pid in parallel.map_in_order(fails, range(9), 2):
        pids.append(pid)
except RecordError as fault:
    print(fault.problem, fault.hint, len(pids), alive(pids[2:]))
""")
    assert said == "a.csv:7: bad cell look there 3 []\n"


def test_workers_are_kept_from_series_to_series():
    said = program("""
offset = {"value": 1}
def add(offset, n):
    time.sleep(0.05)
    return offset["value"] + n, os.getpid()
from functools import partial
def series(pool, function, numbers):
    found = list(pool.map_in_order(function, numbers, (offset,)))
    used, workers = {pid for _, pid in found[2:]}, {one.pid for one in pool._processes}
    return [value for value, _ in found], workers, used <= workers
with parallel.WorkerPool(2) as pool:
    first, pids, by_workers = series(pool, partial(add, offset), range(9))
    print(first == [*range(1, 10)], len(pids), by_workers)
    offset["value"] = 5  # shared: the workers keep what they had
    second, again, by_workers = series(pool, partial(add, offset), range(9))
    print(second == first, again == pids, by_workers)
    third, again, _ = series(pool, partial(add, {"value": 3}), [2, 7])  # copied
    print(third, again == pids)
    values, again, _ = series(pool, partial(add, offset), [])
    print(values, again == pids)
    # What cannot be copied is known to new workers.
    fourth, others, by_workers = series(pool, lambda n: add({"value": 4}, n), range(9))
    print(fourth == [*range(4, 13)], others & pids, by_workers)
    # One item, or short ones, are not worth it.
    parallel._durations["square"] = 1e-6
    print([pid == os.getpid() for _, pid in pool.map_in_order(square, [1, 2, 3])][:1])
    print([pid == os.getpid() for _, pid in pool.map_in_order(partial(add, offset), [1])])
print(alive(pids | others))
""")
    assert said.splitlines() == [
        "True 2 True",
        "True True True",
        "[5, 10] True",
        "[] True",
        "True set() True",
        "[True]",
        "[True]",
        "[]",
    ]


def test_series_after_one_that_failed_or_was_left_has_new_workers():
    said = program("""
def fails(n):
    if n == 5:
        raise ValueError("five")
    return square(n)
with parallel.WorkerPool(2) as pool:
    pids = {pid for _, pid in list(pool.map_in_order(square, range(9)))[2:]}
    try:
        list(pool.map_in_order(fails, range(9)))
    except ValueError as fault:
        print(fault, alive(pids))
    found = list(pool.map_in_order(square, range(9)))
    print([n for n, _ in found] == [n * n for n in range(9)])
    left = pool.map_in_order(square, range(1, 90))
    pids = {next(left)[1]}
    left.close()
    print(alive(pids - {os.getpid()}))
    print([n for n, _ in pool.map_in_order(square, range(4))])
""")
    assert said == "five []\nTrue\n[]\n[0, 1, 4, 9]\n"


@pytest.mark.parametrize("n", [2, 5])
def test_worker_that_is_killed_is_an_error_that_says_so(n):
    said = program(f"""
from drysim.errors import SolverError
def dies(n):
    if n == {n}:
        os.kill(os.getpid(), signal.SIGKILL)
    return begin(n)
pids = []
try:
    for pid in parallel.map_in_order(dies, range(9), 2):
        pids.append(pid)
except SolverError as fault:
    print(fault, fault.hint, len(pids) <= {n}, alive(pids[2:]))
""")
    words = "a worker process ended early, perhaps for lack of memory"
    hint = "use fewer workers, as by --workers 1, and --resume where the command has it"
    assert said == f"{words} {hint} True []\n"


def test_results_that_are_no_longer_needed_end_the_workers():
    said = program("""
found = parallel.map_in_order(endless, range(9), 2)
pids = [next(found) for _ in range(4)]
found.close()
print("closed", alive(pids[2:]))
""")
    assert said.endswith("closed []\n")


def ended(pid):
    """Return whether a process has ended, within a while."""
    end = time.monotonic() + 30
    while time.monotonic() < end:
        try:
            if Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
                return True
        except OSError:
            return True
        time.sleep(0.02)
    return False


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_workers_end_with_the_process_that_forked_them(number):
    body = """
try:
    list(parallel.map_in_order(endless, [0, 1, 4, 5, 6], 2))
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    with subprocess.Popen(
        [sys.executable, "-c", HEADER + body],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as running:
        pids = [int(running.stdout.readline()) for _ in range(2)]
        send = os.killpg if number == signal.SIGINT else os.kill  # as the terminal does
        send(running.pid, number)
        assert all(map(ended, pids))
        _, stderr = running.communicate(timeout=60)
    assert stderr == ""
    assert running.returncode == (0 if number == signal.SIGINT else -number)


def test_session_of_python_forks_no_process():
    assert not parallel._forks
    found = parallel.map_in_order(lambda n: (n, os.getpid()), range(5), 2)
    assert list(found) == [(n, os.getpid()) for n in range(5)]


def sizes_of_chunks(items, duration, workers):
    """Return the sizes of chunks of half a second, by an executor that does them at once."""
    sizes = []

    def submit(some):
        sizes.append(len(some))
        future = Future()
        future.set_result((list(some), duration))
        return future

    chunks = list(parallel.completed(submit, range(items), lambda: workers, 0.5))
    assert sorted(item for chunk in chunks for item in chunk.results) == [*range(items)]
    return sizes


def test_chunks_grow_as_long_as_they_are_short_and_shrink_towards_the_end():
    assert sizes_of_chunks(40, 0.1, 1) == [1, 2, 4, 5, 5, 5, 5, 5, 5, 3]
    assert sizes_of_chunks(9, 1.0, 2) == [1] * 9
    sizes = sizes_of_chunks(1000, 1e-6, 4)
    assert sizes[:4] == sizes[-4:] == [1] * 4
    assert len(sizes) < 70
    assert all(size <= max(1, (1000 - sum(sizes[:k])) // 4) for k, size in enumerate(sizes))


def test_first_item_that_fails_decides_whichever_fails_first():
    futures = []

    def submit(some):
        futures.append(Future())
        return futures[-1]

    def capacity():
        # They end one by one, the last one first.
        number = [future.done() for future in futures].count(False) - 1
        if number > 0:
            futures[number].set_exception(ValueError(number))
        elif number == 0:
            futures[0].set_result((["zero"], 0.1))
        return 3

    chunks, results = parallel.completed(submit, range(9), capacity), []
    with pytest.raises(ValueError, match="1"):
        results.extend(chunk.results for chunk in chunks)
    assert results == [["zero"]]
    assert len(futures) == 3


@pytest.mark.parametrize("workers", [0, -1, 1.5, True, "2"])
def test_workers_are_counted_in_whole_numbers(workers):
    with pytest.raises(UsageError, match="workers must be a whole number of at least 1"):
        parallel.worker_count(workers)
