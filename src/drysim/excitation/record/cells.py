"""Cells to numbers: a quick pass over blocks of bytes, and a careful one that finds faults."""

from __future__ import annotations

import math
import re
import warnings
from array import array
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drysim.excitation.record.columns import GAP, INFINITE, Floats
from drysim.excitation.record.file import Cell, fault, room
from drysim.quantity import NUMBER

if TYPE_CHECKING:
    from drysim.excitation.record.table import Table

BLOCK = 1 << 20
"""Bytes parsed at a time: small beside the numbers, large beside the cost of a call."""

COMMENT = re.compile(rb"(?m)^[ \t]*#.*\n?")
BLANKS = b" \t\v\f"


MISSING = re.compile(r"(?i)|[+-]?nan|na|n/a|null")
"""What a cell without a number holds."""

CLOCK = re.compile(
    r"(?:\d[-\d./]*[T ])?\d{1,2}:\d\d(?::\d\d(?:[.,]\d*)?)?[Z+\-:\d ]*", re.ASCII
)
"""A time of day, with or without its date."""


def numbers(table: Table, wanted: list[int], gappy: int | None = None) -> list[Floats]:
    """Give columns of a table as numbers.

    Parameters
    ----------
    table : Table
    wanted : list of int
        0-based columns.
    gappy : int, optional
        The one of them in which numbers may be missing; they are NaN.

    Returns
    -------
    list of ndarray, shape (rows,)

    Raises
    ------
    RecordError
        At the first ragged row, and at the first wanted cell that is no finite number.
    """
    decimal = table.decimal(wanted)
    found = _quick(table, wanted, decimal)
    return _careful(table, wanted, decimal, gappy) if found is None else found


def _quick(table: Table, wanted: list[int], decimal: str) -> list[Floats] | None:
    text, at, last, done = table.file.text, table.start, _end(table), 0
    found: list[Floats] = [np.empty(0) for _ in wanted]
    while at < last:
        end = min(text.find(b"\n", min(at + BLOCK, last)) + 1 or last, last)
        rows = _block(text[at:end], table, decimal)
        if rows is None or not np.isfinite(rows[:, wanted]).all():
            return None
        if done + len(rows) > len(found[0]):
            # As many rows again as there are bytes for, and a little more.
            count = done + int(1.05 * len(rows) * (last - at) / (end - at)) + len(rows)
            room(table.shown, count * found[0].itemsize * len(found))
            for column in found:
                column.resize(count, refcheck=False)
        for index, column in zip(wanted, found, strict=True):
            column[done : done + len(rows)] = rows[:, index]
        at, done = end, done + len(rows)
    for column in found:
        column.resize(done, refcheck=False)
    return found


def _end(table: Table) -> int:
    """Give where the last row ends, before the line ends that close the file."""
    text, end = table.file.text, len(table.file.text)
    while end > table.start:
        tail = text[max(table.start, end - BLOCK) : end]
        if kept := len(tail.rstrip(b"\r\n")):
            return end - len(tail) + kept
        end -= len(tail)
    return end


def _block(block: bytes, table: Table, decimal: str) -> Floats | None:
    """Numbers of a block of whole lines, shape (rows, columns); None unless all is regular."""
    if b"\r" in block:
        block = block.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if b"#" in block:
        block = COMMENT.sub(b"", block)
    if decimal == "," and b"." in block:
        return None  # the careful pass knows in which columns
    block = block.removesuffix(b"\n")
    lines = block.count(b"\n") + 1
    if not block or not _regular(np.frombuffer(block, np.uint8), lines, table):
        return np.empty((0, table.width)) if not block else None
    if table.delimiter:
        comma = "." if decimal == "," else "?"
        given, plain = f",{table.delimiter}\n", f"{comma},,"  # of two the last counts
        block = block.translate(bytes.maketrans(given.encode(), plain.encode()))
    elif decimal == ",":
        block = block.replace(b",", b".")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", DeprecationWarning)  # what numpy 1 says, 2 raises
            found = np.fromstring(block, sep=" , " if table.delimiter else " ")
    except (ValueError, DeprecationWarning):
        return None
    return found.reshape(lines, -1) if found.size == lines * table.width else None


def _regular(codes: NDArray[np.uint8], lines: int, table: Table) -> bool:
    """Whether every line has exactly as many delimiters, or words, as the table has columns."""
    if table.delimiter:
        marks, each = np.flatnonzero(codes == ord(table.delimiter)), table.width - 1
    else:
        inside = ~np.isin(codes, np.frombuffer(BLANKS + b"\n", np.uint8))
        marks = np.flatnonzero(inside & ~np.concatenate(([False], inside[:-1])))
        each = table.width
    if marks.size != lines * each:
        return False
    ends = np.flatnonzero(codes == ord("\n"))
    per_line = marks.reshape(lines, each)
    return bool((per_line[:-1, -1] < ends).all() and (per_line[1:, 0] > ends).all())


def _careful(
    table: Table, wanted: list[int], decimal: str, gappy: int | None = None
) -> list[Floats]:
    found = [array("d") for _ in wanted]
    for line, cells in table.rows():
        if not cells and wanted == [gappy]:
            found[0].append(math.nan)
            continue
        if not cells:
            raise fault(table.file.shown, f"row {line} is empty: {GAP}", line)
        if len(cells) != table.width:
            raise table.ragged(line, len(cells))
        for index, column in zip(wanted, found, strict=True):
            lost = index == gappy and MISSING.fullmatch(cells[index].text) is not None
            value = math.nan if lost else _number(cells[index], decimal)
            if not (lost or math.isfinite(value)):
                where = f"row {line}, {table.called(index)}"
                sentence = f"{where}: {_complaint(cells[index], decimal)}"
                raise fault(table.file.shown, sentence, line, cells[index])
            column.append(value)
    return [np.array(column) for column in found]


def _number(cell: Cell, decimal: str) -> float:
    """Give the number in a cell with one decimal mark; NaN for none."""
    text = cell.text
    if decimal == ",":
        text = text.replace(".", "?").replace(",", ".", 1)
    return float(text) if NUMBER.fullmatch(text) else math.nan


def _complaint(cell: Cell, decimal: str) -> str:
    text = cell.text
    if not text:
        return f"the cell is empty: {GAP}"
    if MISSING.fullmatch(text):
        return f"`{cell.quote}` is not a finite number: {GAP}"
    if decimal == "," and "." in text and NUMBER.fullmatch(text):
        return f"`{cell.quote}` has a decimal point; write commas throughout"
    if text.lower().lstrip("+-") in ("inf", "infinity") or NUMBER.fullmatch(text):
        return f"`{cell.quote}` is not a finite number: {INFINITE}"
    if NUMBER.fullmatch(text.replace(",", ".", 1)) and decimal == ".":
        return f"`{cell.quote}` has a decimal comma; write points throughout"
    if CLOCK.fullmatch(text):
        instead = "give `rate` or `step` in place of `time`"
        return f"`{cell.quote}` is a time of day, which is not read; {instead}"
    return f"`{cell.quote}` is not a number"
