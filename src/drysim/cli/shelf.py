"""The commands on one shelf: a command is a function of a module here, and its name below."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import typer
from typer.core import TyperGroup

from drysim.cli import options
from drysim.cli.bench import bench
from drysim.cli.commands import doctor, init, run, schema, validate
from drysim.cli.studies import compare, sweep
from drysim.cli.summaries import summarise
from drysim.errors import EXIT_NOTHING_COMPUTED

COMMANDS: tuple[Callable[..., int], ...] = (
    init, run, sweep, compare, validate, summarise, bench, schema, doctor
)  # fmt: skip
"""As somebody new may need them, and as the help lists them."""


class Interruptible(TyperGroup):
    """The commands; one that is interrupted without a word of its own gets one here."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was asked for."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            from drysim import console

            console.remark("interrupted; no file is left half-written")
            raise


app = typer.Typer(
    cls=Interruptible,
    help="Vibration isolation with viscous and dry-friction damping, from a YAML scenario.",
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


@app.callback(invoke_without_command=True)
def no_command(context: typer.Context, version: options.Version = False) -> int:
    """Show the help when no command is named."""
    if context.invoked_subcommand is None:
        from drysim import console

        console.remark(context.get_help())
    return EXIT_NOTHING_COMPUTED


for command in COMMANDS:
    app.command()(command)
