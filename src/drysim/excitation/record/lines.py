"""Lines of a text file, and the cells of a line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

from drysim.errors import RecordError
from drysim.excitation.record.file import Cell, TextFile, printable

UNIT = re.compile(r"(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))")

QUOTE = re.compile("`([^`]+)`")

DELIMITERS = "\t;,"
"""Tried in this order on the first row of numbers; a row with none is split at blanks."""

LINES_QUOTED = 100
"""Lines at the top of a file that messages quote besides the faulty one: its header."""

LONGEST_NAME = 200
"""Characters of a header cell that may still be a name with a unit."""


def lines(file: TextFile, start: int = 0, line: int = 0) -> Iterator[tuple[int, int, str]]:
    """Give line number, offset and text of every line that is not a comment.

    The first is where the text begins, or at an offset that is that of a line number.
    """
    for number, at, part in rows(file, start, line):
        words = _decoded(part)
        if not words.lstrip().startswith("#"):
            yield number, at, words


def rows(file: TextFile, start: int = 0, line: int = 0) -> Iterator[tuple[int, int, bytes]]:
    """Give line number, offset and bytes of every line, from where `lines` begins."""
    text, start, line = file.text, max(start, file.begin), line or file.line
    while start < len(text):
        end = text.find(b"\n", start)
        end = end if end >= 0 else len(text)
        for part in text[start:end].removesuffix(b"\r").split(b"\r"):
            yield line, start, part
            start, line = start + len(part) + 1, line + 1
        start = end + 1


def _decoded(part: bytes) -> str:
    """Give the text of a line: UTF-8, or else what spreadsheets under Windows write."""
    try:
        return part.decode("utf-8")
    except UnicodeDecodeError:
        return part.decode("cp1252", "replace")


def unquoted(error: RecordError, text: TextFile) -> RecordError:
    """Return the error of a record that is a link, without the lines that it quotes.

    The target of a link may be any file, such as a private key. Quotes from a line without a
    delimiter are left out, as are whole lines; the faulty cell of other lines stays.
    """
    problem = error.problem
    head = islice(rows(text), LINES_QUOTED)
    faulty = islice((row for row in rows(text) if row[0] == problem.line), 1)
    parts = [printable(_decoded(part)).strip() for _, _, part in (*head, *faulty)]
    whole = [line for line in parts if line]
    secret = [line for line in whole if not any(mark in line for mark in DELIMITERS)]

    def hidden(quote: re.Match[str]) -> str:
        words = quote[1].removesuffix("…")
        if any(words in line for line in secret) or words in whole:
            return "`…`"
        return quote[0]

    sentence = QUOTE.sub(hidden, problem.sentence)
    if any("`" in line for line in whole):  # a quote may end within the text that it holds
        sentence = f"row {problem.line} is not what a record holds there"
    if sentence == problem.sentence:
        return error
    return RecordError(replace(problem, sentence=sentence, column=0, source=""), error.hint)


def behind(file: TextFile, start: int) -> int:
    """Give where the line after the one that begins at an offset begins."""
    ends = [at for at in (file.text.find(mark, start) for mark in (b"\n", b"\r")) if at >= 0]
    end = min(ends, default=len(file.text))
    return end + 1 + (file.text[end : end + 2] == b"\r\n")


def split(text: str, delimiter: str) -> list[Cell]:
    """Give the cells of a line; a delimiter between quotation marks does not count."""
    if not delimiter:
        return [Cell(m.group(), m.start() + 1) for m in re.finditer(r"\S+", text)]
    cells, at, parts, quotes = [], 0, list[str](), 0
    for part in text.split(delimiter):
        parts.append(part)
        quotes += part.count('"')
        if quotes % 2 == 0:
            whole, parts = delimiter.join(parts), []
            cells.append(_cell(whole, at))
            at += len(whole) + 1
    return [*cells, _cell(delimiter.join(parts), at)] if parts else cells


def left_open(text: str) -> Cell | None:
    """Give a line from the quotation mark on that it does not close; None where all are."""
    at = text.rfind('"') if text.count('"') % 2 else -1
    return None if at < 0 else Cell(text[at:], at + 1)


def _cell(part: str, at: int) -> Cell:
    bare = part.strip()
    quoted = len(bare) > 1 and bare[0] == bare[-1] == '"'
    text = bare[1:-1].replace('""', '"').strip() if quoted else bare
    return Cell(text, at + part.find(bare) + 1 + quoted)


def name_and_unit(text: str) -> tuple[str, str, bool]:
    """Give name and unit of a header cell, and whether the unit is in square brackets."""
    match = UNIT.fullmatch(text) if len(text) <= LONGEST_NAME else None
    if not match:
        return text, "", False
    square = match["square"] is not None
    return match["name"], (match["square"] if square else match["round"]).strip(), square
