"""The process of a command: signals, its streams, how it speaks, and what it goes without.

Ctrl-C, `kill` and a terminal that closes interrupt the work, which leaves its files in order.
Stdout may be a pipe whose reader leaves early, a file on a full disk, or closed; stderr as
well. A command speaks in words, by one JSON object, or not at all.
"""

from __future__ import annotations

import errno
import math
import os
import shlex
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from threading import Event, Thread
from time import monotonic, sleep
from types import FrameType, ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import typer

from drysim.errors import (
    EXIT_CHECK_FAILED,
    EXIT_INTERRUPTED,
    EXIT_OK,
    OutputError,
    WarningMessage,
)

if TYPE_CHECKING:
    from drysim.output.folder import LockedFolder


# Signals.

SIGNAL_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
"""Not every system knows all of them."""

DEFAULT_HANDLERS = (signal.SIG_DFL, signal.default_int_handler)
"""What Python sets; a signal that is ignored, as below `nohup`, stays so."""

INTERRUPT_REQUESTED = Event()
"""Set once we were asked to go: an import that this cuts short may fail with any exception."""

SIGNAL_TIMEOUT = 1.0
"""Time after a signal until the process ends in spite of a kernel that is still at work [s]."""

INTERRUPT_MESSAGE = b"interrupted in a long computation; no file is left half-written\n"

_last_handled = [-math.inf]
"""When Python last called the handler of a signal [s]."""


def install_signal_handlers() -> None:
    """Let every such signal interrupt the work, which then leaves its files in order.

    Python calls a handler between two of its own instructions, and a compiled kernel may run
    for hours. So a thread learns of signals as they come, and ends the process where none is
    handled: as safe as a kill at any other instant.
    """
    numbers = set(filter(None, (getattr(signal, name, None) for name in SIGNAL_NAMES)))
    handled = {number for number in numbers if signal.getsignal(number) in DEFAULT_HANDLERS}
    for number in handled:
        signal.signal(number, _handle_signal)
    read, write = os.pipe()
    os.set_blocking(write, False)
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    if hasattr(os, "register_at_fork"):  # a child would write into the pipe of its parent
        os.register_at_fork(after_in_child=lambda: signal.set_wakeup_fd(-1))
    Thread(target=_watch_signals, args=(read, handled), daemon=True).start()


def raise_if_interrupted() -> None:
    """Interrupt the work once more, in case that has been lost.

    Python passes over an exception in a finaliser or in a call of C, and the work went on.
    """
    if INTERRUPT_REQUESTED.is_set():
        raise KeyboardInterrupt


def _watch_signals(read: int, handled: set[int]) -> None:
    """End the process once a signal is not handled in time."""
    while True:
        received = handled.intersection(os.read(read, 64))
        received_at = monotonic()
        if received:
            sleep(SIGNAL_TIMEOUT)
            if _last_handled[0] < received_at - SIGNAL_TIMEOUT:
                os.write(2, INTERRUPT_MESSAGE)
                os._exit(EXIT_INTERRUPTED)


def _handle_signal(number: int, frame: FrameType | None) -> None:
    INTERRUPT_REQUESTED.set()
    _last_handled[0] = monotonic()
    raise KeyboardInterrupt


# Streams.

STREAM_ERRORS = {
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
def tolerate_closed_pipe(written: Path | None = None, code: int = 0) -> Iterator[None]:
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
        discard_stdout()
    except OSError as fault:
        discard_stdout()
        raise stdout_error(fault, written, code) from fault


def stdout_error(fault: OSError, written: Path | None = None, code: int = 0) -> OutputError:
    """Give the error for a stdout that cannot be written; parameters as above."""
    reason = (fault.strerror or str(fault)).lower()
    hint = f"the files are complete, in {written}" if written else ""
    error = OutputError(f"stdout cannot be written: {reason}", hint)
    if written:
        error.exit_code = code or EXIT_CHECK_FAILED
    return error


def discard_stdout() -> None:
    """Send what is still buffered nowhere, lest Python's own farewell fail again."""
    null_device = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null_device, sys.stdout.fileno())
    os.close(null_device)


# Words.


def command_line(context: typer.Context) -> str:
    """Give the command line, quoted as for a shell."""
    return shlex.join(["drysim", *context.obj])


class OutputMode(NamedTuple):
    """What `--json` and `--quiet` leave of the words; faults are shown in any case."""

    as_json: bool
    quiet: bool

    def report(
        self,
        fields: Mapping[str, Any],
        show: Callable[[], None],
        warnings: Sequence[WarningMessage],
        folder: Path | None = None,
        code: int = EXIT_OK,
    ) -> int:
        """Tell what came out, and give the exit code.

        Parameters
        ----------
        told : mapping
            What `--json` prints.
        show : callable
            Says it in words, warnings included.
        warnings : sequence of Caution
            Go to stderr beside the JSON.
        folder : Path, optional
            Where the results are by now; `code` is the exit code of the work.
        """
        from drysim import output
        from drysim.console import summaries

        with tolerate_closed_pipe(folder, code):
            if self.as_json:
                typer.echo(output.json_text(fields), nl=False)
            elif not self.quiet:
                show()
            elif code not in (EXIT_OK, EXIT_INTERRUPTED):  # of which more was said before
                self._explain_exit_code(fields, warnings)
            if self.as_json and not self.quiet:
                summaries.show_warnings(warnings)
        return code

    def _explain_exit_code(
        self, fields: Mapping[str, Any], warnings: Sequence[WarningMessage]
    ) -> None:
        """Say on stderr what makes the exit code, where nothing else is said."""
        from drysim.console import summaries, terminal

        checks = list(summaries.sidecar_checks(fields))
        failed = [words for passed, words in checks if passed is False]
        for words in failed:
            terminal.print_stderr(f"check failed: {words}")
        if failed:
            return
        for words in (words for passed, words in checks if passed is None):
            terminal.print_stderr(f"check not judged: {words}")
        summaries.show_warnings(warnings)

    def plan(
        self,
        fields: Mapping[str, Any],
        sentences: Sequence[str],
        warnings: Sequence[WarningMessage],
    ) -> int:
        """Tell what would be done, and that nothing was."""
        from drysim.console import summaries, terminal

        def show() -> None:
            terminal.print_stdout("\n".join(sentences))
            terminal.print_stdout(f"would be written to {fields['folder']}")
            terminal.print_stdout("dry run: nothing was computed, nothing was written")
            summaries.show_warnings(warnings)

        return self.report({"dry_run": True, **fields}, show, warnings)

    def print_status(self, sentence: str) -> None:
        """Say something on stderr while the work goes on."""
        if not self.quiet:
            from drysim.console import terminal

            terminal.print_stderr(sentence)

    @contextmanager
    def lock(self, folder: Path, resume: bool, what: str) -> Iterator[LockedFolder]:
        """Claim an output folder; say which finished work, `seeds` or `cases`, is given up."""
        from drysim import output

        discarding = not resume and output.is_resumable(folder)
        with output.lock_partial(folder, resume) as locked:
            if discarding:
                self.print_status(
                    f"beginning anew: the finished {what} in {folder}.partial are given up"
                )
            yield locked


# Pydantic without plug-ins: to look for them takes longer than to load a scenario.

PLUGIN_LOADER = "pydantic.plugin._loader"
"""The module that asks every installed package whether it is a plug-in of pydantic."""


class NoPlugins(ModuleType):
    """Stands where pydantic looks for plug-ins; anything else the real module answers."""

    @staticmethod
    def get_plugins() -> tuple[()]:
        """Give no plug-in: drysim has none."""
        return ()

    def __getattr__(self, name: str) -> Any:
        """Give what another pydantic may want of its module."""
        if name.startswith("__"):
            raise AttributeError(name)
        sys.modules.pop(PLUGIN_LOADER, None)
        return getattr(import_module(PLUGIN_LOADER), name)


def skip_pydantic_plugins() -> None:
    """Let this process do without, unless they were loaded already."""
    sys.modules.setdefault(PLUGIN_LOADER, NoPlugins(PLUGIN_LOADER))
