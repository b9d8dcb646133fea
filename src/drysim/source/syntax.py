"""What a YAML parser complains about, in words that help."""

from __future__ import annotations

import re
from typing import NamedTuple

import yaml

from drysim.errors import Problem
from drysim.quantity import short
from drysim.source.place import Placer, split_lines

_GLUED = re.compile(r"(\s*(?:- +)?)([A-Za-z_][\w.]*):([{\[].*|[^\s:/\\][^:]*)$")
"""A key whose colon has no space behind it."""

Mark = tuple[int, int]
"""Line and column, from 0."""


class _Spot(NamedTuple):
    """Where a parser gave up, and where what it was reading began; lines count from 0."""

    lines: list[str]
    at: Mark
    start: Mark
    place: Placer

    @property
    def line(self) -> str:
        """The line at which it gave up."""
        return self.lines[self.at[0]] if self.at[0] < len(self.lines) else ""

    @property
    def sign(self) -> str:
        """The sign at which it did; empty at the end of the line."""
        return self.line[self.at[1] : self.at[1] + 1]

    def here(self, sentence: str, at: Mark | None = None, width: int = 1) -> Problem:
        """Give the problem that a sentence makes there, or at another place."""
        line, column = at or self.at
        return self.place((line, column), (line, column + width)).problem(sentence)


def explained(fault: yaml.MarkedYAMLError, text: str, place: Placer) -> Problem:
    """Give the located sentence for a fault of a YAML parser."""
    mark, context = fault.problem_mark or fault.context_mark, fault.context_mark
    at = (mark.line, mark.column) if mark else (0, 0)
    start = (context.line, context.column) if context else at
    spot = _Spot(split_lines(text), at, start, place)
    what = f"{fault.problem or ''} {fault.context or ''}"
    if "mapping values" in what or "expected ':'" in what:
        return _about_a_colon(spot)
    if "cannot start any token" in what:
        if spot.sign == "\t":
            return spot.here("a tab cannot indent in YAML; use spaces")
        return spot.here(f"a value cannot start with `{spot.sign}`; put it in quotes")
    if "expected ',' or" in what:
        opening, closing = ("{", "}") if "mapping" in what else ("[", "]")
        if at[0] > start[0]:
            return spot.here(f"this `{opening}` is not closed by `{closing}`", start)
        return spot.here(f"`,` or `{closing}` is missing before this")
    if "end of stream" in what and "quoted" in what:
        return spot.here("this quote is not closed", start)
    if "escape" in what:
        return spot.here("unknown escape in double quotes; use single quotes", start)
    if re.search(r"expected (key|<block end>|'-' indicator)", what):
        return _about_a_block(spot)
    if spot.line.startswith("%"):
        sentence = "this directive is not understood; remove it"
        return spot.here(sentence, width=len(spot.line.rstrip()))
    if "node content" in what:
        behind = f"`{spot.sign}`" if spot.sign else "the end"
        return spot.here(f"a value is missing before {behind}")
    return spot.here(f"this is not YAML: {short(str(fault.problem), 200)}")


def _about_a_colon(spot: _Spot) -> Problem:
    """Say what is wrong where a colon is one too many, or one too few."""
    lines, last = spot.lines, spot.at[0]
    for number in range(last, max(-1, last - 3), -1):
        if glued := _GLUED.match(lines[number] if number < len(lines) else ""):
            words = f"`{short(glued[2])}: {short(glued[3])}`"
            sentence = f"a space is missing after the colon: {words}"
            return spot.here(sentence, (number, len(glued[1])), len(glued[2]))
    if ": " in spot.line[: spot.at[1]]:
        return spot.here("a second `: ` in one value; put the value in quotes")
    number = next((n for n in reversed(range(last)) if lines[n].strip()), last)
    before = lines[number]
    if ":" not in before:
        sentence = "a colon is missing behind this key"
        return spot.here(sentence, (number, _indent(before)), len(before.strip()))
    sentence = "this line is indented deeper than the one before it allows"
    return spot.here(sentence, *_head(spot))


def _about_a_block(spot: _Spot) -> Problem:
    """Say what is wrong where a block should go on or end."""
    if spot.line[: spot.at[1]].strip():
        return spot.here("nothing may follow the value in its line")
    return spot.here("this line fits no block above it; check its indentation", *_head(spot))


def _head(spot: _Spot) -> tuple[Mark, int]:
    """Give where the line begins to speak, and how long its first word is."""
    return (spot.at[0], _indent(spot.line)), len((spot.line.split() or [""])[0])


def _indent(line: str) -> int:
    """Give how many spaces a line starts with."""
    return len(line) - len(line.lstrip(" "))
