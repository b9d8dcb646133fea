"""Terminal output: lines, paragraphs, tables and a progress bar on stdout and stderr.

A terminal gets colour, text wrapped to its width and ruled tables (by rich). Pipes and files
get plain text and aligned columns, without importing rich. The progress bar appears on stderr,
on a terminal that can draw it, once the work has lasted `PROGRESS_DELAY`.
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

from drysim.forced_exit import at_forced_exit
from drysim.wording import sanitise

if TYPE_CHECKING:
    from rich.console import Console

    AnyConsole: TypeAlias = "Console | PlainConsole"

DEFAULT_WIDTH = 80
"""Columns of a terminal of unknown width."""

TERMINAL_VARIABLES = ("FORCE_COLOR", "TTY_COMPATIBLE")
"""Environment variables that make any stream count as a terminal, as in rich."""

WORKFLOW_COMMAND = re.compile(r"\s*::")
"""Start of a line that GitHub Actions would execute as a workflow command."""

INLINE_WORKFLOW_COMMAND = re.compile(r"##(\[|vso\[)")
"""Commands that older GitHub runners and Azure Pipelines accept anywhere in a line."""

MIN_WIDTH, MAX_WIDTH = 50, 100
"""Least and greatest width that text is wrapped to [columns]; longer lines are hard to read."""

Styled = str | tuple[str, str]
"""Text, or text and its rich style."""

NO_VALUE = "–"
"""Table cell of a missing value."""

COLUMN_GAP = 3
"""Blank columns between two columns of a ruled table."""

Columns = Sequence[Sequence[str]]
"""Table by columns, header first."""

PROGRESS_DELAY = 1.0
"""Duration of work before the progress bar appears [s]."""

SPEED_PERIOD = 600.0
"""Time whose items tell the time left [s]: an item, as a step of a fit, may take minutes."""

Advance = Callable[..., None]


class PlainConsole:
    """A pipe or a file, with the part of rich's Console that is used here."""

    is_terminal = False
    is_dumb_terminal = True

    def __init__(self, file: TextIO) -> None:
        self.file = file

    @property
    def width(self) -> int:
        """Width of the screen on which the text is likely shown [columns]."""
        variable = os.environ.get("COLUMNS", "")
        if variable.isdigit():
            return int(variable)
        for stream in range(3):
            with suppress(OSError, ValueError):
                return os.get_terminal_size(stream).columns or DEFAULT_WIDTH
        return DEFAULT_WIDTH

    def print(self, text: str = "") -> None:
        """Write one line."""
        try:
            self.file.write(f"{text}\n")
        except UnicodeEncodeError:  # a stream with a small character set
            encoding = self.file.encoding
            self.file.write(text.encode(encoding, "replace").decode(encoding) + "\n")


def is_plain_stream(file: TextIO) -> bool:
    """Whether a stream is not a terminal and not to be treated as one."""
    return not (any(map(os.environ.get, TERMINAL_VARIABLES)) or file.isatty())


def stdout() -> AnyConsole:
    """Return the console of stdout."""
    return _open_console(to_stderr=False)


def stderr() -> AnyConsole:
    """Return the console of stderr."""
    return _open_console(to_stderr=True)


def _open_console(to_stderr: bool) -> AnyConsole:
    """Return a console."""
    stream = sys.stderr if to_stderr else sys.stdout
    if is_plain_stream(stream):
        return PlainConsole(stream)
    from rich.console import Console

    return Console(file=stream, highlight=False, markup=False, emoji=False, soft_wrap=True)


def print_line(console: AnyConsole, *texts: Styled) -> None:
    """Print one line, without wrapping.

    Parameters
    ----------
    console : AnyConsole
    *texts : str or (str, str)
        Text, or text and its style. Control characters are escaped, brackets are no markup.
    """
    parts = (piece if isinstance(piece, tuple) else (piece, "") for piece in texts)
    shown = [(_printable(text), style) for text, style in parts]
    if WORKFLOW_COMMAND.match("".join(text for text, _ in shown)):
        shown.insert(0, ("\\", ""))
    _print(
        console,
        [(INLINE_WORKFLOW_COMMAND.sub(r"# #\1", text), style) for text, style in shown],
    )


def print_workflow_command(console: AnyConsole, command: str) -> None:
    """Print one line that the runner of a workflow shall execute as a command."""
    _print(console, [(_printable(command), "")])


def print_stdout(text: str) -> None:
    """Print plain text on stdout, line by line."""
    for line in text.split("\n"):
        print_line(stdout(), line)


def print_stderr(text: str) -> None:
    """Print plain text on stderr, line by line."""
    for line in text.split("\n"):
        print_line(stderr(), line)


def _print(console: AnyConsole, parts: list[tuple[str, str]]) -> None:
    """Print a line; an error of stderr is ignored, because nothing is left to report it on."""
    try:
        if isinstance(console, PlainConsole):
            console.print("".join(text for text, _ in parts))
        else:
            from rich.text import Text

            console.print(Text.assemble(*parts))
    except OSError:
        if console.file is not sys.stderr:
            raise


def print_paragraph(console: AnyConsole, head: str, text: str, style: str = "") -> None:
    """Print wrapped text behind a label; further lines are indented by its width."""
    lines = wrap(console, text, len(head))
    print_line(console, (head, style), *lines[:1])
    for continuation in lines[1:]:
        print_line(console, " " * len(head), continuation)


NO_BREAK = "\N{NO-BREAK SPACE}"

BEFORE_UNIT = re.compile(
    r"(?<=\d) (?=(?:%|[ckmµ]?(?:Hz|rad|[mgsNJh])(?:[/·²^][^\s,;:)]*)?)(?![^\s,;:.)]))"
    r"|(?<=\d) (?=± \d)|(?<=±) (?=\d)"
)
"""Blanks at which no line ends: those before the unit of a number, and around ±."""


def wrap(console: AnyConsole, text: str, head: int) -> list[str]:
    """Return text wrapped to the console, less `head` columns for a label.

    A number stays with its unit.
    """
    width = max(min(max(console.width, MIN_WIDTH), MAX_WIDTH) - head, 20)
    text = BEFORE_UNIT.sub(NO_BREAK, sanitise(text))
    lines = textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False)
    return [line.replace(NO_BREAK, " ") for line in lines]


def _printable(text: str) -> str:
    """Return text on one line, control characters escaped; blanks stay for alignment."""
    return "".join(
        character if character.isprintable() else sanitise(character) or " "
        for character in text
    )


def print_table(
    console: AnyConsole,
    columns: Columns,
    left_aligned: Collection[str],
    optional: Sequence[str] = (),
) -> None:
    """Print a table.

    Parameters
    ----------
    console : AnyConsole
    columns : sequence of sequence of str
        Table by columns, header first.
    left_aligned : collection of str
        Headers of the left-aligned columns; the others are right-aligned.
    optional : sequence of str, optional
        Beginnings of the headers of columns that a narrow terminal omits, in this order.
    """
    if isinstance(console, PlainConsole):
        _print_plain_table(console, columns)
    else:
        _print_rich_table(console, _fit_columns(columns, console.width, optional), left_aligned)


def _print_rich_table(
    console: Console, columns: Columns, left_aligned: Collection[str]
) -> None:
    """Print a ruled table on a terminal."""
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
    """Return the columns that fit the width; the files contain them all."""
    for heading in optional:
        if sum(max(map(len, column)) + COLUMN_GAP for column in columns) <= width:
            break
        columns = [column for column in columns if not column[0].startswith(heading)]
    return columns


def _print_plain_table(console: PlainConsole, columns: Columns) -> None:
    """Print aligned columns, for pipes and files."""
    print_line(console)
    widths = [max(map(len, column)) for column in columns]
    for row in zip(*columns, strict=True):
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        print_line(console, "  ".join(cells).rstrip())


@contextmanager
def progress(total: int, label: str, quiet: bool = False, blocks: int = 0) -> Iterator[Advance]:
    """Show the progress of work while the block runs.

    Parameters
    ----------
    total : int
        Number of work items.
    label : str
        Their name, e.g. `cases`.
    quiet : bool, optional
        Show nothing.
    blocks : int, optional
        Number of blocks that the items are grouped in, one per call of `advance`; shown as
        well.

    Yields
    ------
    callable
        `advance(n=1)` counts finished items, from any thread. It does nothing where no bar is
        shown.
    """
    if quiet or not shows_progress():
        yield _ignore_advance
        return
    bar = _ProgressBar(total, label, blocks)
    try:
        with at_forced_exit(bar.stop, last=True):
            yield bar.advance
    finally:
        bar.stop()


def shows_progress() -> bool:
    """Return whether stderr is a terminal that can draw."""
    return sys.stderr.isatty() and not stderr().is_dumb_terminal


def _ignore_advance(n: int = 1) -> None:
    """Ignore finished items where no bar is shown."""


class _ProgressBar:
    """A progress bar that appears once the work has lasted for a while."""

    def __init__(self, total: int, label: str, blocks: int) -> None:
        self._total, self._label, self._done = total, label, 0
        self._blocks, self._blocks_done = blocks, 0
        self._begin, self._lock = time.monotonic(), Lock()
        self._shown: Any = None
        self._task: Any = None

    def advance(self, n: int = 1) -> None:
        """Count finished items; show the bar when it is due."""
        with self._lock:
            self._done += n
            self._blocks_done += 1
            is_due = time.monotonic() - self._begin > PROGRESS_DELAY
            if self._shown is None and is_due and self._done < self._total:
                self._show()
            if self._shown is not None:
                self._shown.update(self._task, completed=self._done, pace=self._describe_rate())

    def _describe_rate(self) -> str:
        """Return the rate, with the count of blocks if a block has more than one item."""
        if not self._blocks:
            return ""
        rate = self._done / (time.monotonic() - self._begin)
        each = f"{rate:,.0f}" if rate >= 10.0 else f"{rate:.2g}"
        blocks = f"{self._blocks_done}/{self._blocks} blocks, " * (self._blocks < self._total)
        return f"{blocks}{each} {self._label}/s"

    def _show(self) -> None:
        """Start the bar."""
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
        from rich.progress import TimeRemainingColumn as Remaining

        screen = stderr()
        assert not isinstance(screen, PlainConsole), "no progress bar on a pipe"
        pace = (TextColumn("{task.fields[pace]}"),) if self._blocks else ()
        columns = TextColumn(self._label), BarColumn(), MofNCompleteColumn(), *pace, Remaining()
        self._shown = Progress(
            *columns,
            console=screen,
            transient=True,
            redirect_stdout=False,
            redirect_stderr=False,
            speed_estimate_period=SPEED_PERIOD,
        )
        self._task = self._shown.add_task(
            "", total=self._total, completed=self._done, pace=self._describe_rate()
        )
        self._shown.start()

    def stop(self) -> None:
        """Remove the bar and show the cursor."""
        with self._lock:
            if self._shown is not None:
                self._shown.stop()
