"""Signals that ask a process to go: Ctrl-C, `kill`, a terminal that closes."""

from __future__ import annotations

import signal
from threading import Event
from types import FrameType

NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
"""Not every system knows all of them."""

OURS = (signal.SIG_DFL, signal.default_int_handler)
"""What Python sets; a signal that is ignored, as below `nohup`, stays so."""

ASKED = Event()
"""Set once we were asked to go: an import that this cuts short may fail with any exception."""


def tidy_up_first() -> None:
    """Let every such signal interrupt the work, which then leaves its files in order."""
    for number in filter(None, (getattr(signal, name, None) for name in NAMES)):
        if signal.getsignal(number) in OURS:
            signal.signal(number, _interrupt)


def if_asked() -> None:
    """Interrupt the work once more, in case that has been lost.

    Python passes over an exception in a finaliser or in a call of C, and the work went on.
    """
    if ASKED.is_set():
        raise KeyboardInterrupt


def _interrupt(number: int, frame: FrameType | None) -> None:
    ASKED.set()
    raise KeyboardInterrupt
