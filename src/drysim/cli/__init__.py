"""The command `drysim`: its application, and where a fault becomes a sentence and an exit code.

A command is a function of `commands`, its options are in `options`; `process` has the signals
and the streams.
"""

from __future__ import annotations

import errno
import gc
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from copy import copy
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup

from drysim.cli import commands, options, process
from drysim.cli.manual import explain, manual
from drysim.cli.process import (
    INTERRUPT_REQUESTED,
    STREAM_ERRORS,
    install_signal_handlers,
    open_closed_streams,
    stdout_error,
    tolerate_closed_pipe,
)
from drysim.errors import (
    EXIT_BUG,
    EXIT_INTERRUPTED,
    EXIT_NOTHING_COMPUTED,
    DrysimError,
    UsageError,
)

COMMANDS: tuple[Callable[..., int], ...] = (
    commands.init, commands.run, commands.sweep, commands.compare, commands.validate,
    commands.summarise, commands.bench, commands.schema, commands.doctor,
    manual, explain,
)  # fmt: skip
"""As somebody new may need them, and as the help lists them."""

COMPUTING_COMMANDS, HELP_OPTIONS = (
    ("run", "sweep", "compare", "bench", "validate"),
    {"-h", "--help"},
)

GC_THRESHOLD = 1_000_000
"""New objects between two collections: a hundred megabytes, were they all garbage."""

BUG_NOTICE = """
This is a bug of drysim, not a fault of yours. Please report it on the project's page, with the
lines above, the scenario file and what `drysim doctor` prints."""


class InterruptibleGroup(TyperGroup):
    """The commands; one that is interrupted without a word of its own gets one here."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was asked for."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            from drysim.console import terminal

            terminal.print_stderr("interrupted; no file is left half-written")
            raise


app = typer.Typer(
    cls=InterruptibleGroup,
    help="Vibration isolation with viscous and dry-friction damping, from a YAML scenario.",
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


@app.callback(invoke_without_command=True)
def no_command(context: typer.Context, version: options.Version = False) -> int:
    """Show the help when no command is named."""
    if context.invoked_subcommand is None:
        from drysim.console import terminal

        terminal.print_stderr(context.get_help())
    return EXIT_NOTHING_COMPUTED


for one_command in COMMANDS:
    app.command()(one_command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and give the exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        Words after `drysim`; default: those of this process.

    Returns
    -------
    int
        0 done, 1 a check failed, 2 nothing computed, 3 the numerics failed, 70 a bug,
        130 interrupted.
    """
    open_closed_streams()
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        application = single_command_app(words[0] if words else "")
        code = int(application(words, prog_name="drysim", obj=words, standalone_mode=False))
        with tolerate_closed_pipe():  # flushes what was said
            pass
    except typer.TyperException as fault:
        code = report_usage_error(fault)
    except DrysimError as fault:
        code = report_error(fault)
    except MemoryError:
        code = report_out_of_memory()
    except KeyboardInterrupt:  # between two commands, so to speak
        code = EXIT_INTERRUPTED
    except Exception as fault:
        code = report_unexpected(fault)
    return code


def single_command_app(name: str) -> typer.Typer:
    """Give the application with one command alone, where there is one of that name.

    Typer builds every command that it is given, with all its options, to run one of them.
    """
    known = app.registered_commands
    found = [one for one in known if one.callback and one.callback.__name__ == name]
    if not found:
        return app
    reduced = copy(app)
    reduced.registered_commands = found
    return reduced


def preload_numpy(words: Sequence[str]) -> None:
    """Load numpy for a command that computes, from as few frames as can be.

    Python 3.11 takes memory for frames in pieces of 16 KB and gives each back at once: of the
    many small calls of this import, 3000 may happen to run across the edge of one, for 20 ms.
    """
    if words and words[0] in COMPUTING_COMMANDS and not HELP_OPTIONS & {*words}:
        import numpy  # noqa: F401 - it is wanted later, from deeper


def command() -> NoReturn:
    """Be the command `drysim`: run it, and leave at once.

    A process of one command has little garbage to collect while it loads the compiler, and need
    not take that apart in order at its end: together these are a fifth of a small sweep.
    """
    gc.set_threshold(GC_THRESHOLD, 20, 20)
    process.skip_pydantic_plugins()
    preload_numpy(sys.argv[1:])
    install_signal_handlers()
    code = main()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)


def report_usage_error(fault: typer.TyperException) -> int:
    """Say what is wrong with the command line, and where its help is."""
    command = getattr(getattr(fault, "ctx", None), "command_path", "drysim")
    sentence = fault.format_message().replace("Value error, ", "")
    return report_error(UsageError(sentence, f"`{command} --help` shows what it takes"))


def report_out_of_memory() -> int:
    """Say that there is no more memory, and give the exit code."""
    print("error: this machine has run out of memory; take a shorter run", file=sys.stderr)
    return EXIT_NOTHING_COMPUTED


def report_unexpected(fault: Exception) -> int:
    """Show what nobody foresaw: a stdout that cannot be written, or else a bug.

    Who was asked to go has no bug: an interrupted import fails with whatever comes to its mind.
    """
    if INTERRUPT_REQUESTED.is_set():
        return EXIT_INTERRUPTED
    if isinstance(fault, OSError) and fault.errno == errno.ENOMEM:
        return report_out_of_memory()
    # A stream that fails names no file; all files are written where that is foreseen.
    if isinstance(fault, OSError) and fault.filename is None and fault.errno in STREAM_ERRORS:
        return report_error(stdout_error(fault))
    with suppress(OSError):
        traceback.print_exc()
        print(BUG_NOTICE, file=sys.stderr)
    return EXIT_BUG


def report_error(fault: DrysimError) -> int:
    """Show a fault with its places and its hint, and give its exit code."""
    from drysim.console import problems

    with suppress(SystemExit):  # rich leaves with SystemExit on a broken pipe
        problems.show_error(fault)
    return fault.exit_code
