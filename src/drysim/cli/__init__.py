"""The command line: where a fault becomes a sentence and an exit code."""

from __future__ import annotations

import errno
import gc
import os
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress
from copy import copy
from typing import NoReturn

import typer

from drysim.cli import plugins
from drysim.cli.leave import ASKED, tidy_up_first
from drysim.cli.shelf import app
from drysim.cli.streams import REFUSALS, open_closed_streams, reader_may_leave, unheard
from drysim.errors import (
    EXIT_BUG,
    EXIT_INTERRUPTED,
    EXIT_NOTHING_COMPUTED,
    DrysimError,
    UsageError,
)

SELDOM = 1_000_000
"""New objects between two collections: a hundred megabytes, were they all garbage."""

COMPUTING = ("run", "sweep", "compare", "bench", "validate")
HELP = {"-h", "--help"}

BUG = """
This is a bug of drysim, not a fault of yours. Please report it on the project's page, with the
lines above, the scenario file and what `drysim doctor` prints."""


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
        asked = with_command(words[0] if words else "")
        code = int(asked(words, prog_name="drysim", obj=words, standalone_mode=False))
        with reader_may_leave():  # flushes what was said
            pass
    except typer.TyperException as fault:
        code = wrong_words(fault)
    except DrysimError as fault:
        code = dressed(fault)
    except MemoryError:
        code = out_of_memory()
    except KeyboardInterrupt:  # between two commands, so to speak
        code = EXIT_INTERRUPTED
    except Exception as fault:
        code = unforeseen(fault)
    return code


def with_command(name: str) -> typer.Typer:
    """Give the application with one command alone, where there is one of that name.

    Typer builds every command that it is given, with all its options, to run one of them.
    """
    commands = app.registered_commands
    found = [one for one in commands if one.callback and one.callback.__name__ == name]
    if not found:
        return app
    alone = copy(app)
    alone.registered_commands = found
    return alone


def load_numpy_first(words: Sequence[str]) -> None:
    """Load numpy for a command that computes, from as few frames as can be.

    Python 3.11 takes memory for frames in pieces of 16 KB and gives each back at once: of the
    many small calls of this import, 3000 may happen to run across the edge of one, for 20 ms.
    """
    if words and words[0] in COMPUTING and not HELP & {*words}:
        import numpy  # noqa: F401 - it is wanted later, from deeper


def command() -> NoReturn:
    """Be the command `drysim`: run it, and leave at once.

    A process of one command has little garbage to collect while it loads the compiler, and need
    not take that apart in order at its end: together these are a fifth of a small sweep.
    """
    gc.set_threshold(SELDOM, 20, 20)
    plugins.forgo()
    load_numpy_first(sys.argv[1:])
    tidy_up_first()
    code = main()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)


def wrong_words(fault: typer.TyperException) -> int:
    """Say what is wrong with the command line, and where its help is."""
    command = getattr(getattr(fault, "ctx", None), "command_path", "drysim")
    sentence = fault.format_message().replace("Value error, ", "")
    return dressed(UsageError(sentence, f"`{command} --help` shows what it takes"))


def out_of_memory() -> int:
    """Say that there is no more memory, and give the exit code."""
    print("error: this machine has run out of memory; take a shorter run", file=sys.stderr)
    return EXIT_NOTHING_COMPUTED


def unforeseen(fault: Exception) -> int:
    """Show what nobody foresaw: a stdout that cannot be written, or else a bug.

    Who was asked to go has no bug: an interrupted import fails with whatever comes to its mind.
    """
    if ASKED.is_set():
        return EXIT_INTERRUPTED
    if isinstance(fault, OSError) and fault.errno == errno.ENOMEM:
        return out_of_memory()
    # A stream that fails names no file; all files are written where that is foreseen.
    if isinstance(fault, OSError) and fault.filename is None and fault.errno in REFUSALS:
        return dressed(unheard(fault))
    with suppress(OSError):
        traceback.print_exc()
        print(BUG, file=sys.stderr)
    return EXIT_BUG


def dressed(fault: DrysimError) -> int:
    """Show a fault with its places and its hint, and give its exit code."""
    from drysim import console

    with suppress(SystemExit):  # rich leaves with SystemExit on a broken pipe
        console.show_fault(fault)
    return fault.exit_code
