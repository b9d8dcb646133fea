"""Where something stands in a file, as a problem tells it."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple

from drysim.errors import Problem

_LINE_END = re.compile("\r\n|[\n\r\x85\u2028\u2029]")
"""What YAML takes for the end of a line."""


class Place(NamedTuple):
    """A stretch of one line of a file; line and column count from 1, 0 is the whole file."""

    file: str
    line: int = 0
    column: int = 0
    width: int = 1
    source: str = ""

    def problem(self, sentence: str, key: str = "") -> Problem:
        """Give the problem that a sentence makes here."""
        return Problem(
            sentence, self.file, self.line, self.column, self.width, self.source, key
        )


Placer = Callable[[tuple[int, int], tuple[int, int]], Place]
"""Gives the place between two (line, column) that count from 0."""


class Unreadable(Exception):
    """A fault after which nothing more can be read from a file."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.sentence)
        self.problem = problem


def split_lines(text: str) -> list[str]:
    """Give the lines of a text as YAML counts them."""
    return _LINE_END.split(text)


def placer(file: str, text: str) -> Placer:
    """Give the function that finds places in a text."""
    lines = split_lines(text)

    def place(start: tuple[int, int], end: tuple[int, int]) -> Place:
        line, column = min(start[0], len(lines) - 1), start[1]
        source = lines[line]
        last = end[1] if end[0] == line else len(source.rstrip())
        return Place(file, line + 1, column + 1, max(1, last - column), source)

    return place
