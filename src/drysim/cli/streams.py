"""Stdout as it is: a pipe whose reader may leave early, a file on a full disk, or closed."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from drysim.errors import OutputError


def open_closed_streams() -> None:
    """Let what is said to a closed stream, as in `drysim run seat.yaml >&-`, go nowhere."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 - open until the end


@contextmanager
def reader_may_leave() -> Iterator[None]:
    """Let a reader end early, as in `drysim run seat.yaml --json | head`: it is not a fault.

    The work is done by then, so its exit code stands; what was left to say goes nowhere.

    Raises
    ------
    OutputError
        When stdout cannot be written for another reason.
    """
    try:
        yield
        sys.stdout.flush()
    except (BrokenPipeError, SystemExit):  # rich leaves with SystemExit on a broken pipe
        close_stdout()
    except OSError as fault:
        close_stdout()
        raise OutputError(f"stdout cannot be written: {fault.strerror}") from fault


def close_stdout() -> None:
    """Send what is still buffered nowhere, lest Python's own farewell fail again."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
