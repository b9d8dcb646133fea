"""Patience: an end to work that does not come to one by itself."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from drysim.core.compiled import compiling
from drysim.errors import DrysimError, SolverError
from drysim.wording import number

Given = TypeVar("Given")


def tried(work: Callable[[], Given], seconds: float) -> Given | str:
    """Give what some work gives within a time, or say how it fails: that is its verdict."""
    try:
        with at_most(seconds):
            return work()
    except DrysimError as fault:
        return reason(fault)
    except Exception as fault:  # whatever another program raises
        return f"{type(fault).__name__}: {fault}"


def reason(fault: DrysimError) -> str:
    """Give why numbers cannot be had: the fault itself, or the problem behind it."""
    problems = getattr(fault, "problems", ())
    return problems[0].sentence if problems else fault.message


@contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """Give up what lasts longer, as soon as a kernel hands over.

    Compiling is no part of the work and is never interrupted: the time begins afresh behind it.
    Where the system has no alarm, or outside the main thread, it is waited for to the end.

    Raises
    ------
    SolverError
        When the time is over.
    """
    here = threading.current_thread() is threading.main_thread()
    if not (here and hasattr(signal, "setitimer")):
        yield
        return

    def over(*_: object) -> None:
        if compiling():
            signal.setitimer(signal.ITIMER_REAL, seconds)
            return
        raise SolverError(f"given up after {number(seconds, 's')}")

    before = signal.signal(signal.SIGALRM, over)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
