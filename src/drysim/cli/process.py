"""The process of a command: signals, standard streams, output mode.

Ctrl-C, SIGTERM and SIGHUP interrupt the work, which then leaves its files in order. Stdout may
be a pipe whose reader ends early, a file on a full disk, or closed; the same holds for stderr.
The output of a command is text, one JSON object (`--json`), or nothing (`--quiet`).
"""

from __future__ import annotations

import errno
import os
import shlex
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from io import TextIOWrapper
from pathlib import Path
from threading import Event, Thread
from time import sleep
from types import FrameType
from typing import TYPE_CHECKING, Any, NamedTuple

import typer

from drysim import forced_exit
from drysim.errors import (
    EXIT_CHECK_FAILED,
    EXIT_INTERRUPTED,
    EXIT_OK,
    OutputError,
    WarningMessage,
)
from drysim.system import private_folder

if TYPE_CHECKING:
    from drysim.output.folder import LockedFolder
    from drysim.study.outcome import AnyResult
    from drysim.study.summary import Judgement


# Signals.

SIGNAL_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
"""Signals that interrupt. Windows lacks SIGHUP; it alone has SIGBREAK, of Ctrl-Break and of a
window that is closed."""

DEFAULT_HANDLERS = (signal.SIG_DFL, signal.default_int_handler)
"""The handlers that Python sets; an ignored signal, as under `nohup`, stays ignored."""

INTERRUPT_REQUESTED = Event()
"""Set on the first signal. An import that is cut short may then fail with any exception."""

SIGNAL_TIMEOUT, CLEAN_UP_TIMEOUT = 1.25, 0.5
"""Time that the work has to end after a signal, and the clean-up of a forced exit after that
[s]."""

INTERRUPT_MESSAGE = "interrupted; no file is left half-written"


def install_signal_handlers() -> None:
    """Turn the signals into KeyboardInterrupt, so that the work leaves its files in order.

    Python calls a handler only between two of its own instructions. A compiled kernel may run
    for hours, and so may the clean-up that waits for one in another thread. A thread therefore
    reads the signals from the wake-up pipe, and ends the process if the work has not ended
    within `SIGNAL_TIMEOUT`.
    """
    numbers = set(filter(None, (getattr(signal, name, None) for name in SIGNAL_NAMES)))
    handled = {number for number in numbers if signal.getsignal(number) in DEFAULT_HANDLERS}
    for number in handled:
        signal.signal(number, _handle_signal)
    read, write = os.pipe()
    if sys.platform != "win32":  # where Python before 3.12 has no pipe that does not block
        os.set_blocking(write, False)
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    if hasattr(os, "register_at_fork"):  # a child process would write to the pipe of its parent
        os.register_at_fork(after_in_child=lambda: signal.set_wakeup_fd(-1))
    Thread(target=_watch_signals, args=(read, handled), daemon=True).start()


def raise_if_interrupted() -> None:
    """Raise KeyboardInterrupt once more after a signal.

    Python discards an exception raised in a finaliser or in a callback from C, and work
    continues.
    """
    if INTERRUPT_REQUESTED.is_set():
        raise KeyboardInterrupt


def _watch_signals(read: int, handled: set[int]) -> None:
    """End the process after the first signal, whatever the other threads do."""
    while not handled.intersection(os.read(read, 64)):
        pass
    sleep(SIGNAL_TIMEOUT)
    leaving = Thread(target=_force_exit, daemon=True)  # a disk or a terminal may not respond
    leaving.start()
    leaving.join(CLEAN_UP_TIMEOUT)
    os._exit(EXIT_INTERRUPTED)


def _force_exit() -> None:
    """Leave files and terminal in order while the work is still running; say what is kept."""
    message = forced_exit.clean_up() or INTERRUPT_MESSAGE
    os.write(2, f"{message}\n".encode(errors="replace"))  # the work may hold sys.stderr


def _handle_signal(number: int, frame: FrameType | None) -> None:
    """Interrupt the work on the first signal; a further one would interrupt its clean-up."""
    if not INTERRUPT_REQUESTED.is_set():
        INTERRUPT_REQUESTED.set()
        sys.unraisablehook = lambda _: None  # destructors of what was cut short may fail
        raise KeyboardInterrupt


# Streams.

STREAM_ERRORS = {
    errno.EAGAIN, errno.EBADF, errno.ECONNRESET, errno.EDQUOT, errno.EFBIG, errno.EINVAL,
    errno.EIO, errno.ENOSPC, errno.ENXIO, errno.EPIPE,
}  # fmt: skip
"""Errors of a write to a stream; the OSError of a failed library load has no number."""


def prepare_streams() -> None:
    """Make the standard streams take any text.

    A closed one, as in `drysim run x.yaml >&-`, is replaced by the null device. Characters that
    the encoding of a console lacks are shown as `?`.
    """
    for name in ("stdout", "stderr"):
        if (stream := getattr(sys, name)) is None:
            null_device = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - stays open
            setattr(sys, name, null_device)
        elif isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")


@contextmanager
def tolerate_closed_pipe(written: Path | None = None, code: int = 0) -> Iterator[None]:
    """Ignore that the reader of stdout ended early, as in `drysim run seat.yaml --json | head`.

    The work is done by then, so its exit code stands; the rest of the output is discarded.

    Parameters
    ----------
    written : Path, optional
        The folder that already holds the results.
    code : int, optional
        The exit code of the work.

    Raises
    ------
    OutputError
        When stdout cannot be written for another reason. Its exit code is 2 if nothing was
        computed. With results in a folder it is that of the work, but 1 in place of 0, because
        the expected output is missing.
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
    """Return the error for an unwritable stdout; parameters as in `tolerate_closed_pipe`."""
    reason = (fault.strerror or str(fault)).lower()
    hint = f"the files in {written} are complete" if written else ""
    error = OutputError(f"cannot write to stdout: {reason}", hint)
    if written:
        error.exit_code = code or EXIT_CHECK_FAILED
    return error


def discard_stdout() -> None:
    """Redirect stdout to the null device so that the flush at exit cannot fail."""
    null_device = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null_device, sys.stdout.fileno())
    os.close(null_device)


# Settings of libraries.


def set_environment() -> None:
    """Make the libraries independent of the user's settings; started processes inherit it.

    Pictures are drawn with Agg. The list of fonts is kept: where matplotlib cannot write into
    the home folder, it would scan all fonts in every process and leave a folder behind.
    Plugins of pydantic are not looked for among all installed packages.
    DRYSIM_ENGINE alone chooses the engine: the variable of numba overrides .numba_config.yaml.
    The workers of a command share its cases; threads that OpenBLAS starts for products of small
    matrices would wait for each other, for as long as a fit computes.
    """
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    os.environ["MPLBACKEND"] = "agg"
    if (folder := private_folder("matplotlib")) is not None:
        os.environ["MPLCONFIGDIR"] = str(folder.path)
    os.environ["NUMBA_DISABLE_JIT"] = "0"
    os.environ["PYDANTIC_DISABLE_PLUGINS"] = "__all__"


KEPT_MEMORY, LARGE_ARRAY = 1 << 27, 1 << 25
"""Free memory that is kept for reuse, and size of arrays that are given back when freed
[bytes]."""


def keep_memory() -> None:
    """Keep freed memory for reuse, where the C library can.

    By default glibc gives back the arrays of each seed, and the kernel clears as many pages for
    the next one: a fifth of the time of a design study by several workers.
    """
    import ctypes

    trim_threshold, map_threshold = -1, -3  # M_TRIM_THRESHOLD and M_MMAP_THRESHOLD of malloc.h
    with suppress(AttributeError, OSError, TypeError):  # another library, or Windows
        mallopt = ctypes.CDLL(None).mallopt
        mallopt(trim_threshold, KEPT_MEMORY)
        mallopt(map_threshold, LARGE_ARRAY)


# Output.


def command_line(context: typer.Context) -> str:
    """Return the command line, quoted for a shell."""
    return shlex.join(["drysim", *context.obj])


class Plan(NamedTuple):
    """What a dry run shows."""

    fields: dict[str, Any]
    """For `--json`; `folder` is the output folder."""
    sentences: Sequence[str]
    warnings: Sequence[WarningMessage]


class Done(NamedTuple):
    """A job that was carried out."""

    result: AnyResult
    fields: dict[str, Any]
    """The content of drysim.json."""
    folder: Path
    """Holds the files."""
    code: int
    """The exit code."""


class OutputMode(NamedTuple):
    """The effect of `--json` and `--quiet`; errors are shown in any case."""

    as_json: bool
    quiet: bool

    def report(self, done: Done, name: str = "") -> None:
        """Show a result in this mode.

        Parameters
        ----------
        done : Done
        name : str, optional
            What it is called among several results, each of which has a line; `--json` prints
            them all at the end.
        """
        from drysim.console.summary import show_brief, show_summary, show_warnings
        from drysim.results import kind_of

        result, code = done.result, done.code
        warnings = name_warnings(result.warnings, name)
        with tolerate_closed_pipe(done.folder, code):
            if self.as_json:
                if not name:
                    self._print_json(done.fields, warnings)
                elif not self.quiet:
                    show_warnings(warnings)
                return
            summary = kind_of(result).summary(result)
            if self.quiet:
                if code not in (EXIT_OK, EXIT_INTERRUPTED):  # already reported
                    explain_exit_code(summary.checks, warnings, name)
            elif name and code != EXIT_INTERRUPTED:
                show_brief(name, summary, done.folder, warnings, code)
            elif code != EXIT_INTERRUPTED:
                show_summary(summary, done.folder, warnings)
            elif getattr(result, "rows", True):
                show_summary(summary, None, warnings)

    def print_json(self, fields: Mapping[str, Any], code: int) -> None:
        """Print the fields of several results, whose warnings were printed, as JSON."""
        with tolerate_closed_pipe(Path(), code):
            self._print_json(fields, ())

    def _print_json(
        self, fields: Mapping[str, Any], warnings: Sequence[WarningMessage]
    ) -> None:
        """Print fields as JSON, and the warnings on stderr."""
        from drysim.console.summary import show_warnings
        from drysim.results.fields import json_text

        typer.echo(json_text(fields), nl=False)
        if not self.quiet:
            show_warnings(warnings)

    def plan(self, plans: Sequence[Plan]) -> int:
        """Show what a dry run would do, and that nothing was done."""
        from drysim.console.summary import show_warnings
        from drysim.console.terminal import print_stdout
        from drysim.study.doctor import describe_engine_limits

        limits = describe_engine_limits()
        warnings = [warning for plan in plans for warning in plan.warnings]
        with tolerate_closed_pipe():
            if self.as_json:
                several = {"plans": [plan.fields for plan in plans]}
                fields = plans[0].fields if len(plans) == 1 else several
                self._print_json({"dry_run": True, **fields}, warnings)
            elif not self.quiet:
                for plan in plans:
                    print_stdout("\n".join(plan.sentences))
                    print_stdout(f"output folder: {plan.fields['folder']}")
                if limits:
                    print_stdout(f"engine: {limits}")
                print_stdout("dry run: nothing computed, nothing written")
                show_warnings(warnings)
        return EXIT_OK

    def print_status(self, sentence: str) -> None:
        """Print a status message on stderr, except in quiet mode."""
        if not self.quiet:
            from drysim.console import terminal

            terminal.print_stderr(sentence)

    def print_loss(self, sentence: str) -> None:
        """Print on stderr what an earlier command left and this one discards."""
        from drysim.console import terminal

        terminal.print_stderr(sentence)

    @contextmanager
    def lock(
        self, folder: Path, resume: bool, what: str, check: Callable[[Path], object]
    ) -> Iterator[LockedFolder]:
        """Lock an output folder, as `lock_partial`; report which work is discarded."""
        from drysim import output

        held = output.resumable_parts(folder)
        with output.lock_partial(folder, resume, check) as locked:
            for parts in held:
                if not (resume and parts == what):
                    command = output.STORES[parts]
                    remedy = "--resume" if parts == what else f"drysim {command} --resume"
                    self.print_loss(
                        f"starting over: finished {parts} in {folder}.partial are discarded "
                        f"(`{remedy}` keeps them)"
                    )
            yield locked

    def print_discarded(self, folder: Path, resume: bool) -> None:
        """Print on stderr which finished work a command would discard."""
        from drysim import output

        for parts in () if resume else output.resumable_parts(folder):
            self.print_loss(
                f"finished {parts} in {folder}.partial would be discarded without --resume"
            )


def name_warnings(warnings: Sequence[WarningMessage], name: str) -> list[WarningMessage]:
    """Return warnings that begin with the name of their result, if it has one."""
    if not name:
        return list(warnings)
    return [replace(each, sentence=f"{name}: {each.sentence}") for each in warnings]


def explain_exit_code(
    checks: Sequence[Judgement], warnings: Sequence[WarningMessage], name: str = ""
) -> None:
    """Print on stderr the reason for a nonzero exit code, in quiet mode.

    `name` is that of the result among several.
    """
    from drysim.console.summary import show_warnings
    from drysim.console.terminal import print_stderr

    where = f"{name}: " if name else ""
    failed = [check.sentence for check in checks if check.passed is False]
    for sentence in failed:
        print_stderr(f"check failed: {where}{sentence}")
    if failed:
        return
    for check in checks:
        if check.passed is None:
            print_stderr(f"check skipped: {where}{check.sentence}")
    show_warnings(warnings)
