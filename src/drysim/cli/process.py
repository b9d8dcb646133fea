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

from drysim.errors import EXIT_CHECK_FAILED, EXIT_INTERRUPTED, EXIT_OK, Caution, OutputError

if TYPE_CHECKING:
    from drysim.output.folder import Claim


# Signals.

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


# Streams.

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


# Words.


def typed(context: typer.Context) -> str:
    """Give the command line, quoted as for a shell."""
    return shlex.join(["drysim", *context.obj])


class Voice(NamedTuple):
    """What `--json` and `--quiet` leave of the words; faults are shown in any case."""

    as_json: bool
    quiet: bool

    def answer(
        self,
        told: Mapping[str, Any],
        show: Callable[[], None],
        warnings: Sequence[Caution],
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

        with reader_may_leave(folder, code):
            if self.as_json:
                typer.echo(output.json_text(told), nl=False)
            elif not self.quiet:
                show()
            elif code not in (EXIT_OK, EXIT_INTERRUPTED):  # of which more was said before
                self._excuse(told, warnings)
            if self.as_json and not self.quiet:
                summaries.show_warnings(warnings)
        return code

    def _excuse(self, told: Mapping[str, Any], warnings: Sequence[Caution]) -> None:
        """Say on stderr what makes the exit code, where nothing else is said."""
        from drysim.console import summaries, terminal

        checks = list(summaries.told_checks(told))
        failed = [words for passed, words in checks if passed is False]
        for words in failed:
            terminal.remark(f"check failed: {words}")
        if failed:
            return
        for words in (words for passed, words in checks if passed is None):
            terminal.remark(f"check not judged: {words}")
        summaries.show_warnings(warnings)

    def plan(
        self, fields: Mapping[str, Any], sentences: Sequence[str], cautions: Sequence[Caution]
    ) -> int:
        """Tell what would be done, and that nothing was."""
        from drysim.console import summaries, terminal

        def show() -> None:
            terminal.say("\n".join(sentences))
            terminal.say(f"would be written to {fields['folder']}")
            terminal.say("dry run: nothing was computed, nothing was written")
            summaries.show_warnings(cautions)

        return self.answer({"dry_run": True, **fields}, show, cautions)

    def remark(self, sentence: str) -> None:
        """Say something on stderr while the work goes on."""
        if not self.quiet:
            from drysim.console import terminal

            terminal.remark(sentence)

    @contextmanager
    def claimed(self, folder: Path, resume: bool, what: str) -> Iterator[Claim]:
        """Claim an output folder; say which finished work, `seeds` or `cases`, is given up."""
        from drysim import output

        anew = not resume and output.resumable(folder)
        with output.claim_partial(folder, resume) as claim:
            if anew:
                self.remark(
                    f"beginning anew: the finished {what} in {folder}.partial are given up"
                )
            yield claim


# Pydantic without plug-ins: to look for them takes longer than to load a scenario.

LOADER = "pydantic.plugin._loader"
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
        sys.modules.pop(LOADER, None)
        return getattr(import_module(LOADER), name)


def forgo() -> None:
    """Let this process do without, unless they were loaded already."""
    sys.modules.setdefault(LOADER, NoPlugins(LOADER))
