"""Signals that ask a process to go: Ctrl-C, `kill`, a terminal that closes."""

from __future__ import annotations

import math
import os
import signal
from threading import Event, Thread
from time import monotonic, sleep
from types import FrameType

from drysim.errors import EXIT_INTERRUPTED

NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
"""Not every system knows all of them."""

OURS = (signal.SIG_DFL, signal.default_int_handler)
"""What Python sets; a signal that is ignored, as below `nohup`, stays so."""

ASKED = Event()
"""Set once we were asked to go: an import that this cuts short may fail with any exception."""


PATIENCE = 1.0
"""Time after a signal until the process ends in spite of a kernel that is still at work [s]."""

GOODBYE = b"interrupted in a long computation; no file is left half-written\n"

_heard = [-math.inf]
"""When Python last called the handler of a signal [s]."""


def tidy_up_first() -> None:
    """Let every such signal interrupt the work, which then leaves its files in order.

    Python calls a handler between two of its own instructions, and a compiled kernel may run
    for hours. So a thread learns of signals as they come, and ends the process where none is
    handled: as safe as a kill at any other instant.
    """
    numbers = set(filter(None, (getattr(signal, name, None) for name in NAMES)))
    ours = {number for number in numbers if signal.getsignal(number) in OURS}
    for number in ours:
        signal.signal(number, _interrupt)
    read, write = os.pipe()
    os.set_blocking(write, False)
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    if hasattr(os, "register_at_fork"):  # a child would write into the pipe of its parent
        os.register_at_fork(after_in_child=lambda: signal.set_wakeup_fd(-1))
    Thread(target=_end_unheard, args=(read, ours), daemon=True).start()


def if_asked() -> None:
    """Interrupt the work once more, in case that has been lost.

    Python passes over an exception in a finaliser or in a call of C, and the work went on.
    """
    if ASKED.is_set():
        raise KeyboardInterrupt


def _end_unheard(read: int, ours: set[int]) -> None:
    """End the process once a signal is not handled in time."""
    while True:
        asked = ours.intersection(os.read(read, 64))
        came = monotonic()
        if asked:
            sleep(PATIENCE)
            if _heard[0] < came - PATIENCE:
                os.write(2, GOODBYE)
                os._exit(EXIT_INTERRUPTED)


def _interrupt(number: int, frame: FrameType | None) -> None:
    ASKED.set()
    _heard[0] = monotonic()
    raise KeyboardInterrupt
