"""Paper that is no terminal: words as they are, without the weight of colours."""

from __future__ import annotations

import os
from contextlib import suppress
from typing import TextIO

USUAL = 80
"""Columns of a terminal that tells nothing."""

ASKED = ("FORCE_COLOR", "TTY_COMPATIBLE")
"""Words of the environment that make a terminal of any stream, as rich has it."""


class Plain:
    """A pipe or a file."""

    is_terminal = False
    is_dumb_terminal = True

    def __init__(self, file: TextIO) -> None:
        self.file = file

    @property
    def width(self) -> int:
        """Columns of the screen that the words may end on."""
        told = os.environ.get("COLUMNS", "")
        if told.isdigit():
            return int(told)
        for stream in range(3):
            with suppress(OSError, ValueError):
                return os.get_terminal_size(stream).columns or USUAL
        return USUAL

    def print(self, words: str = "") -> None:
        """Set one line."""
        self.file.write(f"{words}\n")


def is_plain(file: TextIO) -> bool:
    """Whether a stream is no terminal, and is not to be taken for one."""
    return not (any(map(os.environ.get, ASKED)) or file.isatty())
