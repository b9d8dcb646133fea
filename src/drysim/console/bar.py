"""A progress bar on stderr: at a terminal that can draw it, and for work that lasts."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any

from drysim.console.paper import stderr
from drysim.console.plain import Plain

PATIENCE = 1.0
"""Time that work may take before a bar appears [s]."""

Advance = Callable[..., None]


@contextmanager
def progress(total: int, label: str, quiet: bool = False, blocks: int = 0) -> Iterator[Advance]:
    """Give a function that tells how many more pieces of work are done.

    Parameters
    ----------
    total : int
        Pieces of work.
    label : str
        What they are, e.g. `cases`.
    quiet : bool, optional
        Show nothing.
    blocks : int, optional
        Into how many blocks the pieces are gathered, one for each call of `advance`; they are
        shown, too.

    Yields
    ------
    callable
        `advance(n=1)`, from any thread. Where nobody watches it does nothing and costs nothing.
    """
    if quiet or not sys.stderr.isatty() or stderr().is_dumb_terminal:
        yield _nothing
        return
    bar = _Bar(total, label, blocks)
    try:
        yield bar.advance
    finally:
        bar.stop()


def _nothing(n: int = 1) -> None:
    """Take note of nothing."""


class _Bar:
    """A bar that appears when the work has lasted for a while."""

    def __init__(self, total: int, label: str, blocks: int) -> None:
        self._total, self._label, self._done = total, label, 0
        self._blocks, self._blocks_done = blocks, 0
        self._begin, self._lock = time.monotonic(), Lock()
        self._shown: Any = None
        self._task: Any = None

    def advance(self, n: int = 1) -> None:
        """Count finished pieces; show the bar once the work has lasted."""
        with self._lock:
            self._done += n
            self._blocks_done += 1
            late = time.monotonic() - self._begin > PATIENCE
            if self._shown is None and late and self._done < self._total:
                self._show()
            if self._shown is not None:
                self._shown.update(self._task, completed=self._done, pace=self._pace())

    def _pace(self) -> str:
        """Give the rate, and the blocks that are done where a block is more than one piece."""
        if not self._blocks:
            return ""
        rate = self._done / (time.monotonic() - self._begin)
        each = f"{rate:,.0f}" if rate >= 10.0 else f"{rate:.2g}"
        blocks = f"{self._blocks_done}/{self._blocks} blocks, " * (self._blocks < self._total)
        return f"{blocks}{each} {self._label}/s"

    def _show(self) -> None:
        """Put the bar on the terminal."""
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
        from rich.progress import TimeRemainingColumn as Remaining

        screen = stderr()
        assert not isinstance(screen, Plain), "no bar is begun on a pipe"
        pace = (TextColumn("{task.fields[pace]}"),) if self._blocks else ()
        columns = TextColumn(self._label), BarColumn(), MofNCompleteColumn(), *pace, Remaining()
        self._shown = Progress(
            *columns,
            console=screen,
            transient=True,
            redirect_stdout=False,
            redirect_stderr=False,
        )
        self._task = self._shown.add_task(
            "", total=self._total, completed=self._done, pace=self._pace()
        )
        self._shown.start()

    def stop(self) -> None:
        """Take the bar off the terminal."""
        with self._lock:
            if self._shown is not None:
                self._shown.stop()
