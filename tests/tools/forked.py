"""Tests of a source in a folder, run in a fork of a process that has loaded what they need."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import mpmath  # noqa: F401
import numpy  # noqa: F401
import pydantic  # noqa: F401
import rich.console  # noqa: F401
import scipy.signal  # noqa: F401, TID253
import typer.main  # noqa: F401
import yaml  # noqa: F401

# What the tests load and no change touches: forks have it at once.


def forked(folder: Path, job: Callable[[], int], limit: int) -> bool:
    """Whether a job on the source in a folder ends well within a limit [s], in a process."""
    child = os.fork()
    if child == 0:
        os.setsid()
        signal.alarm(limit)
        os.chdir(folder.parent)
        with said(folder).open("w") as words:
            os.dup2(words.fileno(), 1)
            os.dup2(words.fileno(), 2)
        sys.path.insert(0, str(folder))
        os.environ |= {
            "PYTHONPATH": str(folder), "DRYSIM_ENGINE": "plain",
            "XDG_CACHE_HOME": str(folder.parent / "cache"),
        }  # fmt: skip
        os._exit(int(job()))
    try:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(
                child, signal.SIGKILL
            )  # it, when interrupted; what its tests have started


def said(folder: Path) -> Path:
    """Where the words of the last job on the source in a folder are."""
    return folder.parent / "said"
