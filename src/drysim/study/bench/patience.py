"""Patience: an end to work that does not come to one by itself."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from drysim.core.compiled import compiling
from drysim.errors import SolverError
from drysim.wording import number


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
