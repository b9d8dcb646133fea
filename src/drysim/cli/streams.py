"""Stdout as it is: a pipe whose reader may leave early, a file on a full disk, or closed."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from drysim.errors import EXIT_CHECK_FAILED, OutputError

REFUSALS = {
    errno.EAGAIN, errno.EBADF, errno.ECONNRESET, errno.EDQUOT, errno.EFBIG, errno.EINVAL,
    errno.EIO, errno.ENOSPC, errno.ENXIO, errno.EPIPE,
}  # fmt: skip
"""What a stream may answer to a write; a library that cannot be loaded has no number."""


def open_closed_streams() -> None:
    """Let what is said to a closed stream, as in `drysim run seat.yaml >&-`, go nowhere."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 - open until the end


@contextmanager
def reader_may_leave(written: Path | None = None, code: int = 0) -> Iterator[None]:
    """Let a reader end early, as in `drysim run seat.yaml --json | head`: it is not a fault.

    The work is done by then, so its exit code stands; what was left to say goes nowhere.

    Parameters
    ----------
    written : Path, optional
        The folder that the results are in by now.
    code : int, optional
        The exit code of the work.

    Raises
    ------
    OutputError
        When stdout cannot be written for another reason. Its exit code is 2 where nothing was
        computed; with results in a folder it is that of the work, and 1 in place of 0, since
        somebody waits for words that never came.
    """
    try:
        yield
        sys.stdout.flush()
    except (BrokenPipeError, SystemExit):  # rich leaves with SystemExit on a broken pipe
        close_stdout()
    except OSError as fault:
        close_stdout()
        raise unheard(fault, written, code) from fault


def unheard(fault: OSError, written: Path | None = None, code: int = 0) -> OutputError:
    """Give the error for a stdout that cannot be written; parameters as above."""
    reason = (fault.strerror or str(fault)).lower()
    hint = f"the files are complete, in {written}" if written else ""
    error = OutputError(f"stdout cannot be written: {reason}", hint)
    if written:
        error.exit_code = code or EXIT_CHECK_FAILED
    return error


def close_stdout() -> None:
    """Send what is still buffered nowhere, lest Python's own farewell fail again."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
