"""The two streams as paper: lines with a little colour where the terminal takes it.

Words are wrapped to its width and tables ruled; pipes and files get words as they are, in
aligned columns. A progress bar stands on stderr, at a terminal that can draw it and for work
that lasts.
"""

from __future__ import annotations

import os
import re
import sys
import textwrap
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from threading import Lock
from typing import TYPE_CHECKING, Any, Literal, TextIO, TypeAlias

from drysim.wording import sanitise

if TYPE_CHECKING:
    from rich.console import Console

    AnyConsole: TypeAlias = "Console | Plain"

DEFAULT_WIDTH = 80
"""Columns of a terminal that tells nothing."""

TERMINAL_VARIABLES = ("FORCE_COLOR", "TTY_COMPATIBLE")
"""Words of the environment that make a terminal of any stream, as rich has it."""

WORKFLOW_COMMAND = re.compile(r"\s*::")
"""The beginning of a line that the runner of a workflow on GitHub would obey."""

INLINE_WORKFLOW_COMMAND = re.compile(r"##(\[|vso\[)")
"""What others obey anywhere in a line: GitHub of old, and Azure."""

MIN_WIDTH, MAX_WIDTH = 50, 100
"""Fewest and most columns that words are set in; a narrower terminal breaks lines itself."""

Styled = str | tuple[str, str]
"""Words, or words and their style."""

NO_VALUE = "–"
"""What stands where there is nothing to say."""

COLUMN_GAP = 3
"""Columns between two columns of a ruled table."""

Columns = Sequence[Sequence[str]]
"""Column by column, headings first."""

PROGRESS_DELAY = 1.0
"""Time that work may take before a bar appears [s]."""

Advance = Callable[..., None]


class Plain:
    """A pipe or a file."""

    is_terminal = False
    is_dumb_terminal = True

    def __init__(self, file: TextIO) -> None:
        self.file = file

    @property
    def width(self) -> int:
        """Columns of the screen that the words may end on."""
        variable = os.environ.get("COLUMNS", "")
        if variable.isdigit():
            return int(variable)
        for stream in range(3):
            with suppress(OSError, ValueError):
                return os.get_terminal_size(stream).columns or DEFAULT_WIDTH
        return DEFAULT_WIDTH

    def print(self, words: str = "") -> None:
        """Set one line."""
        self.file.write(f"{words}\n")


def is_plain_stream(file: TextIO) -> bool:
    """Whether a stream is no terminal, and is not to be taken for one."""
    return not (any(map(os.environ.get, TERMINAL_VARIABLES)) or file.isatty())


def stdout() -> AnyConsole:
    """Give stdout."""
    return _open_console(to_stderr=False)


def stderr() -> AnyConsole:
    """Give stderr."""
    return _open_console(to_stderr=True)


def _open_console(to_stderr: bool) -> AnyConsole:
    """Give a stream; a sign that it cannot encode becomes a question mark, not a crash."""
    stream = sys.stderr if to_stderr else sys.stdout
    reconfigure = getattr(stream, "reconfigure", None)
    if reconfigure is not None:
        reconfigure(errors="replace")
    if is_plain_stream(stream):
        return Plain(stream)
    from rich.console import Console

    return Console(file=stream, highlight=False, markup=False, emoji=False, soft_wrap=True)


def print_line(console: AnyConsole, *texts: Styled) -> None:
    """Set one line of pieces, however long it is.

    Parameters
    ----------
    paper : Paper
    *pieces : str or (str, str)
        Words with or without a style; control characters are spelled out, brackets stay.
    """
    parts = (piece if isinstance(piece, tuple) else (piece, "") for piece in texts)
    shown = [(_printable(words), style) for words, style in parts]
    if WORKFLOW_COMMAND.match("".join(words for words, _ in shown)):
        shown.insert(0, ("\\", ""))
    _print(
        console,
        [(INLINE_WORKFLOW_COMMAND.sub(r"# #\1", words), style) for words, style in shown],
    )


def print_workflow_command(console: AnyConsole, words: str) -> None:
    """Set one line that is meant to be a command to who runs a workflow."""
    _print(console, [(_printable(words), "")])


def print_stdout(text: str) -> None:
    """Say on stdout, line by line, what has no style."""
    for words in text.split("\n"):
        print_line(stdout(), words)


def print_stderr(text: str) -> None:
    """Say it on stderr."""
    for words in text.split("\n"):
        print_line(stderr(), words)


def _print(console: AnyConsole, parts: list[tuple[str, str]]) -> None:
    """Print a line; where stderr cannot be written, there is nobody left to tell."""
    try:
        if isinstance(console, Plain):
            console.print("".join(words for words, _ in parts))
        else:
            from rich.text import Text

            console.print(Text.assemble(*parts))
    except OSError:
        if console.file is not sys.stderr:
            raise


def print_paragraph(console: AnyConsole, head: str, words: str, style: str = "") -> None:
    """Set a sentence behind its head, its further lines below its first word."""
    lines = wrap(console, words, len(head))
    print_line(console, (head, style), *lines[:1])
    for continuation in lines[1:]:
        print_line(console, " " * len(head), continuation)


def wrap(console: AnyConsole, words: str, head: int) -> list[str]:
    """Give a sentence in lines that fit behind a head of so many columns."""
    width = max(min(max(console.width, MIN_WIDTH), MAX_WIDTH) - head, 20)
    return textwrap.wrap(sanitise(words), width, break_long_words=False, break_on_hyphens=False)


def _printable(words: str) -> str:
    """Give words on one line; runs of spaces stay, for they align."""
    return "".join(
        character if character.isprintable() else sanitise(character) or " "
        for character in words
    )


def print_table(
    console: AnyConsole,
    columns: Columns,
    left_aligned: Collection[str],
    optional: Sequence[str] = (),
) -> None:
    """Show a table.

    Parameters
    ----------
    paper : Paper
    given : sequence of sequence of str
        Column by column, headings first.
    left : collection of str
        Headings of the columns that are set to the left.
    spared : sequence of str, optional
        How the headings begin of what a narrow terminal does without, in this order.
    """
    if isinstance(console, Plain):
        _print_plain_table(console, columns)
    else:
        _print_rich_table(console, _fit_columns(columns, console.width, optional), left_aligned)


def _print_rich_table(
    console: Console, columns: Columns, left_aligned: Collection[str]
) -> None:
    """Show a table at a terminal."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    table = Table(box=SIMPLE_HEAD, pad_edge=False, header_style="bold")
    for heading, *_ in columns:
        side: Literal["left", "right"] = "left" if heading in left_aligned else "right"
        table.add_column(Text(heading), justify=side, no_wrap=True)
    for row in list(zip(*columns, strict=True))[1:]:
        table.add_row(*map(Text, row))
    console.print(table, soft_wrap=False)


def _fit_columns(columns: Columns, width: int, optional: Sequence[str]) -> Columns:
    """Give the columns that a terminal has room for; the files hold them all."""
    for heading in optional:
        if sum(max(map(len, column)) + COLUMN_GAP for column in columns) <= width:
            break
        columns = [column for column in columns if not column[0].startswith(heading)]
    return columns


def _print_plain_table(console: Plain, columns: Columns) -> None:
    """Show a table in aligned columns, for pipes and files."""
    print_line(console)
    widths = [max(map(len, column)) for column in columns]
    for row in zip(*columns, strict=True):
        words = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        print_line(console, "  ".join(words).rstrip())


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
        yield _ignore_advance
        return
    bar = _ProgressBar(total, label, blocks)
    try:
        yield bar.advance
    finally:
        bar.stop()


def _ignore_advance(n: int = 1) -> None:
    """Take note of nothing."""


class _ProgressBar:
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
            is_due = time.monotonic() - self._begin > PROGRESS_DELAY
            if self._shown is None and is_due and self._done < self._total:
                self._show()
            if self._shown is not None:
                self._shown.update(self._task, completed=self._done, pace=self._describe_rate())

    def _describe_rate(self) -> str:
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
            "", total=self._total, completed=self._done, pace=self._describe_rate()
        )
        self._shown.start()

    def stop(self) -> None:
        """Take the bar off the terminal."""
        with self._lock:
            if self._shown is not None:
                self._shown.stop()
