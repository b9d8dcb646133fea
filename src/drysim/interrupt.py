"""Interrupts held back while modules are loaded.

An import that Ctrl-C ends in the middle leaves half a module behind: numpy, for one, cannot be
imported again in the same session. The interrupt is therefore raised after the import.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def deferred_interrupt() -> Iterator[None]:
    """Raise a KeyboardInterrupt that arrives during the context at its end.

    It applies to the main thread of a Python session. A program with a handler of its own for
    SIGINT, such as the command, keeps it.
    """
    handler = signal.default_int_handler
    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or signal.getsignal(signal.SIGINT) is not handler:
        yield
        return
    received: list[Any] = []
    signal.signal(signal.SIGINT, lambda *arguments: received.append(arguments))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if received:
            raise KeyboardInterrupt
