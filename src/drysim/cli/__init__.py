"""The command line: the application and the exit code of every outcome.

The commands are functions in `commands`, their options are in `options`; `process` handles
signals and streams. `main` runs one command and turns exceptions into an error message and an
exit code.
"""

from __future__ import annotations

import errno
import gc
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, NoReturn

import typer
from typer.core import TyperArgument, TyperCommand, TyperGroup

from drysim.cli import commands, options, process
from drysim.cli.manual import explain, manual
from drysim.cli.process import (
    INTERRUPT_REQUESTED,
    STREAM_ERRORS,
    install_signal_handlers,
    prepare_streams,
    stdout_error,
    tolerate_closed_pipe,
)
from drysim.core.compile import AUTO, ENGINE_VARIABLE, before_compiling
from drysim.errors import (
    EXIT_BUG,
    EXIT_INTERRUPTED,
    EXIT_NOTHING_COMPUTED,
    DrysimError,
    UsageError,
)
from drysim.parallel import allow_processes

COMMANDS: tuple[Callable[..., int], ...] = (
    commands.init, commands.run, commands.sweep, commands.compare, commands.fit,
    commands.assess, commands.design, commands.branches, commands.regime_map,
    commands.validate, commands.summarise, commands.report, commands.bench, commands.schema,
    commands.doctor, manual, explain,
)  # fmt: skip
"""In the order of the help: what a new user needs first comes first."""

GC_THRESHOLD = 1_000_000
"""Allocations between two garbage collections; at most about 100 MB of garbage."""

BUG_NOTICE = """
This is a bug in drysim. Please report it on the project's page, with the lines above, the
scenario file and the output of `drysim doctor`."""


class InterruptibleGroup(TyperGroup):
    """Command group that prints a message when an interrupt was not handled by the command."""

    def invoke(self, ctx: Any) -> Any:
        """Run the selected command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            from drysim.console import terminal

            terminal.print_stderr(process.INTERRUPT_MESSAGE)
            raise


COMPILING_MESSAGE = "compiling the solver: up to a minute, once on this machine"


def announce_compilation() -> None:
    """Print at a terminal that kernels are being compiled."""
    from drysim.console import terminal

    if terminal.shows_progress():
        terminal.print_stderr(COMPILING_MESSAGE)


class MetavarCommand(TyperCommand):
    """Command that says, unless it is quiet, that it compiles kernels.

    Its help shows an argument as its metavar: `FILE`, not `{FILE} <str>`.
    """

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        if not ctx.params.get("quiet"):
            before_compiling(announce_compilation)
        return super().invoke(ctx)

    def get_params(self, ctx: Any) -> Any:
        """Return the parameters, without the types of arguments in the help."""
        parameters = super().get_params(ctx)
        for parameter in parameters:
            if isinstance(parameter, TyperArgument):  # typer has no option for this
                vars(parameter)["display_type_rich"] = lambda ctx: None
        return parameters

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return the words that follow the name of the command in its usage line."""
        arguments = [
            argument for argument in self.get_params(ctx) if isinstance(argument, TyperArgument)
        ]
        names = [str(argument.metavar or argument.name) for argument in arguments]
        return ["[OPTIONS]"] + [
            name if argument.required else f"[{name}]"
            for name, argument in zip(names, arguments, strict=True)
        ]


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


for each_command in COMMANDS:
    # `explain --resume` explains the option.
    settings = {"ignore_unknown_options": each_command is explain}
    end = options.help_end(each_command.__name__)
    app.command(cls=MetavarCommand, context_settings=settings, epilog=end)(each_command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        Command-line arguments after `drysim`; default: those of this process.

    Returns
    -------
    int
        0 done, 1 a check failed, 2 nothing computed, 3 the numerics failed, 70 a bug,
        130 interrupted.
    """
    prepare_streams()
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    try:
        code = int(app(arguments, prog_name="drysim", obj=arguments, standalone_mode=False))
        with tolerate_closed_pipe():  # flush here, where a failure can still be reported
            pass
    except typer.TyperException as fault:
        code = report_usage_error(fault)
    except DrysimError as fault:
        code = report_error(fault)
    except MemoryError:
        code = report_out_of_memory()
    except KeyboardInterrupt:  # before or after the command itself
        code = EXIT_INTERRUPTED
    except Exception as fault:
        code = report_unexpected(fault)
    return code


def command() -> NoReturn:
    """Run the command `drysim` and end the process.

    A process of one command has little garbage to collect while it loads the compiler, and
    needs no orderly teardown at its end: skipping both saves a fifth of the time of a small
    sweep.
    """
    os.environ.setdefault(ENGINE_VARIABLE, AUTO)
    process.set_environment()
    process.keep_memory()
    gc.set_threshold(GC_THRESHOLD, 20, 20)
    install_signal_handlers()
    allow_processes()
    code = main()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)


def report_usage_error(fault: typer.TyperException) -> int:
    """Show what is wrong with the command line; return the exit code."""
    command = getattr(getattr(fault, "ctx", None), "command_path", "drysim")
    sentence = fault.format_message().replace("Value error, ", "")
    return report_error(UsageError(sentence, f"see `{command} --help`"))


def report_out_of_memory() -> int:
    """Show that memory is exhausted; return the exit code."""
    print("error: out of memory; shorten the run", file=sys.stderr)
    return EXIT_NOTHING_COMPUTED


def report_unexpected(fault: Exception) -> int:
    """Show an unexpected exception (no stdout, no memory, or a bug); return the exit code.

    After an interrupt it is not reported: an interrupted import may fail with any exception.
    """
    if INTERRUPT_REQUESTED.is_set():
        print(process.INTERRUPT_MESSAGE, file=sys.stderr)
        return EXIT_INTERRUPTED
    if isinstance(fault, OSError) and fault.errno == errno.ENOMEM:
        return report_out_of_memory()
    # An error of a stream has no file name; those of files are handled elsewhere.
    if isinstance(fault, OSError) and fault.filename is None and fault.errno in STREAM_ERRORS:
        return report_error(stdout_error(fault))
    with suppress(OSError):
        traceback.print_exc()
        print(BUG_NOTICE, file=sys.stderr)
    return EXIT_BUG


def report_error(fault: DrysimError) -> int:
    """Show an error with its locations and its hint; return its exit code."""
    from drysim.console import problems

    with suppress(SystemExit):  # rich leaves with SystemExit on a broken pipe
        problems.show_error(fault)
    return fault.exit_code
