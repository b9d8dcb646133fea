"""Kill -9 at any instant of what is written."""

from __future__ import annotations

import json
import os
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

Act = Callable[[], object]


def kills(act: Act) -> Iterator[int]:
    """Kill a process that does `act` once in every state of the disk on the way.

    Between two lines of output/ that leave the disk as it is, a kill leaves the same, so the
    first of them stands for both. Yields the number of lines passed before each kill, while
    the disk is as the dead process has left it.
    """
    for step in steps(act):
        assert ended(act, until(lambda n, step=step: n == step and os._exit(9))) == 9
        yield step


def steps(act: Act) -> list[int]:
    """Return the lines of output/ before which `act` has changed the disk; the last ends it."""
    seen: list[tuple[int, object]] = []
    read, write = os.pipe()

    def look(number: int) -> None:
        if not seen or seen[-1][1] != disk():
            seen.append((number, disk()))

    def whole() -> None:
        act()
        sys.settrace(None)
        os.write(write, json.dumps([number for number, _ in seen]).encode())

    assert ended(whole, until(look)) == 0
    os.close(write)
    with os.fdopen(read) as told:
        return json.load(told)


def until(at: Callable[[int], object]) -> Callable[..., object]:
    """Return a tracer that calls `at` before every line of output/, with its number."""
    passed = 0

    def trace(frame, event, _):
        nonlocal passed
        if "/output/" not in frame.f_code.co_filename:
            return None
        if event == "line":
            at(passed)
            passed += 1
        return trace

    return trace


def ended(act: Act, trace: Callable[..., object]) -> int:
    """Do `act` in a process of its own under a tracer; give its exit code."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        code = 70
        try:
            sys.settrace(trace)
            act()
            code = 0
        except BaseException:
            sys.settrace(None)
            traceback.print_exc()
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def disk() -> list[tuple[str, int, bytes]]:
    """Return every path below here with its identity and content."""
    paths = sorted(Path().rglob("*"))
    return [(str(p), p.stat().st_ino, p.read_bytes() if p.is_file() else b"") for p in paths]
