"""What stands above the numbers of a text file: header, row of units, words of a logger."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import islice, pairwise

from drysim.excitation.record.columns import Label
from drysim.excitation.record.file import Cell, TextFile
from drysim.excitation.record.lines import DELIMITERS, lines, name_and_unit, split
from drysim.excitation.record.spoken import SI
from drysim.quantity import NUMBER, usual

LOOKED_AT = 100
"""Rows among which a header is looked for."""

MOST_COLUMNS = 16_384
"""As many as a spreadsheet has; with more of them samples stand beside one another."""

NOT_A_NAME = re.compile(
    r"(?i)[+\-\u2212]*(?:nan|inf|infinity|\d*[.,]\d.*|\d+(?:e[+-]?\d+)?)", re.ASCII
)
"""With bare numbers, what no header holds: so a damaged first row is a fault and no header."""

DECIMALS = re.compile(r"[+-]?\d+(?:,\d+)?", re.ASCII)
PADDED = re.compile(r",0\d", re.ASCII)
"""A number with a decimal comma; and what follows no comma that parts two whole numbers."""

WORD_WITH_UNIT = re.compile(r"\S+\s*(?:\[[^\[\]]*\]|\([^()]*\))|\S+")


def delimiter_of(text: str) -> str:
    """Give the delimiter of a row."""
    return next((mark for mark in DELIMITERS if mark in text), "")


def delimiter_below(header: str, row: str) -> str:
    """Give the delimiter of a row of numbers below a header, which may be empty.

    A comma is a decimal one where only then there are as many cells as the header has names.
    """
    mark = delimiter_of(row)
    if mark != "," or "," in header or not header:
        return mark
    cells = split(row, "")
    fits = len(header_cells(header, "", len(cells))) == len(cells)
    return "" if fits and all(map(_is_number, cells)) else mark


def decimal_commas(file: TextFile) -> bool:
    """Tell whether rows without a header are one column of numbers with decimal commas."""
    rows = [text.strip() for _, _, text in islice(lines(file), LOOKED_AT)]
    written = [text for text in rows if text]
    return all(map(DECIMALS.fullmatch, written)) and any(map(PADDED.search, written))


def wide(file: TextFile) -> tuple[int, int]:
    """Give line and width of a first row with more columns than a table has; zeros for none."""
    for line, _, text in islice(lines(file), LOOKED_AT):
        mark = delimiter_of(text)
        columns = text.count(mark) + 1 if mark else len(text.split())
        if columns > MOST_COLUMNS:
            return line, columns
    return 0, 0


def is_header(cells: Sequence[Cell]) -> bool:
    """Tell whether none of the cells of a row could be meant for a number."""
    written = [cell.text for cell in cells if cell.text]
    return bool(written) and not any(
        NUMBER.fullmatch(text) or NOT_A_NAME.fullmatch(text) for text in written
    )


def header_cells(text: str, delimiter: str, width: int) -> list[Cell]:
    """Give the cells of a header above rows of a delimiter and a number of columns."""
    mark = delimiter or delimiter_of(text)
    if mark:
        return split(text, mark)
    if width == 1:
        return [Cell(text.strip(), len(text) - len(text.lstrip()) + 1)]
    return [Cell(m.group(), m.start() + 1) for m in WORD_WITH_UNIT.finditer(text)]


def labels_of(header: Sequence[Cell], units: Sequence[Cell]) -> tuple[Label, ...]:
    """Give what header and row of units, where there is one, say of each column."""
    labels = tuple(Label(cell.text, *name_and_unit(cell.text)) for cell in header)
    if not units:
        return labels
    return tuple(
        Label(label.text, label.text, cell.text.strip("[]()").strip(), firm=False)
        for label, cell in zip(labels, units, strict=True)
    )


def is_units(cells: Sequence[Cell], header: Sequence[Cell]) -> bool:
    """Tell whether a row of words is one of units, below a header that has none of its own."""
    fits = len(cells) == len(header) and is_header(cells)
    if not fits or any(name_and_unit(cell.text)[1] for cell in header):
        return False
    words = (cell.text.strip("[]()") for cell in cells)
    return any(usual(word, si) for word in words for si in ("s", *SI.values()))


def likely_header(file: TextFile) -> int:
    """Give the line of the first row that names as many columns as there are numbers below it.

    Returns
    -------
    int
        1-based; 0 where there is none above the first two rows of as many numbers.
    """
    content = islice((row for row in lines(file) if row[2].strip()), LOOKED_AT)
    first = [(line, text) for line, _, text in content]
    top = first[0][0] if first else 0
    for at, ((line, text), (_, below)) in enumerate(pairwise(first)):
        mark = delimiter_below(text, below)
        row = split(below, mark)
        head = header_cells(text, mark, len(row))
        if at + 2 < len(first) and is_units(row, head):
            below = first[at + 2][1]
            mark = delimiter_below(text, below)
            row = split(below, mark)
        if len(row) == len(head) and all(map(_is_number, row)):
            if is_header(head):
                return top if _names(first[0][1], mark, len(row)) else line
            if all(map(_is_number, head)):
                return 0
    return 0


def _names(text: str, delimiter: str, width: int) -> bool:
    """Whether a row names some columns: then words between it and their numbers are a fault."""
    cells = header_cells(text, delimiter, width)
    return width > 1 and len(cells) == width and is_header(cells)


def _is_number(cell: Cell) -> bool:
    return NUMBER.fullmatch(cell.text.replace(",", ".", 1)) is not None
