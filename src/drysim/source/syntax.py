"""What a YAML parser complains about, in words that help."""

from __future__ import annotations

import re

import yaml

from drysim.errors import Problem
from drysim.quantity import short
from drysim.source.place import Placer, split_lines

_GLUED = re.compile(r"(\s*(?:- +)?)([A-Za-z_][\w.]*):([^\s:/\\][^:]*)$")
"""A key whose colon has no space behind it."""


def explained(fault: yaml.MarkedYAMLError, text: str, place: Placer) -> Problem:
    """Give the located sentence for a fault of a YAML parser."""
    mark, context = fault.problem_mark or fault.context_mark, fault.context_mark
    at = (mark.line, mark.column) if mark else (0, 0)
    lines = split_lines(text)
    line = lines[at[0]] if at[0] < len(lines) else ""
    what = f"{fault.problem or ''} {fault.context or ''}"
    start = (context.line, context.column) if context else at

    def here(sentence: str, at: tuple[int, int] = at, width: int = 1) -> Problem:
        return place(at, (at[0], at[1] + width)).problem(sentence)

    if "mapping values" in what or "expected ':'" in what:
        for number in range(at[0], max(-1, at[0] - 3), -1):
            if glued := _GLUED.match(lines[number] if number < len(lines) else ""):
                words = f"`{short(glued[2])}: {short(glued[3])}`"
                spot = (number, len(glued[1]))
                return here(f"a space is missing after the colon: {words}", spot, len(glued[2]))
        if ": " in line[: at[1]]:
            return here("a second `: ` in one value; put the value in quotes")
        number = next((n for n in reversed(range(at[0])) if lines[n].strip()), at[0])
        before = lines[number]
        if ":" not in before:
            spot = (number, _indent(before))
            return here("a colon is missing behind this key", spot, len(before.strip()))
        sentence = "this line is indented deeper than the one before it allows"
        return here(sentence, *_head(at, line))
    if "cannot start any token" in what:
        sign = line[at[1] : at[1] + 1]
        if sign == "\t":
            return here("a tab cannot indent in YAML; use spaces")
        return here(f"a value cannot start with `{sign}`; put it in quotes")
    if "expected ',' or" in what:
        opening, closing = ("{", "}") if "mapping" in what else ("[", "]")
        if at[0] > start[0]:
            return here(f"this `{opening}` is not closed by `{closing}`", start)
        return here(f"`,` or `{closing}` is missing before this")
    if "end of stream" in what and "quoted" in what:
        return here("this quote is not closed", start)
    if "escape" in what:
        return here("unknown escape in double quotes; use single quotes", start)
    if re.search(r"expected (key|<block end>|'-' indicator)", what):
        if line[: at[1]].strip():
            return here("nothing may follow the value in its line")
        return here("this line fits no block above it; check its indentation", *_head(at, line))
    if line.startswith("%"):
        return here("this directive is not understood; remove it", width=len(line.rstrip()))
    if "node content" in what:
        sign = line[at[1] : at[1] + 1]
        return here(f"a value is missing before {f'`{sign}`' if sign else 'the end'}")
    return here(f"this is not YAML: {short(str(fault.problem), 200)}")


def _head(at: tuple[int, int], line: str) -> tuple[tuple[int, int], int]:
    """Give where a line begins to speak, and how long its first word is."""
    return (at[0], _indent(line)), len((line.split() or [""])[0])


def _indent(line: str) -> int:
    """Give how many spaces a line starts with."""
    return len(line) - len(line.lstrip(" "))
