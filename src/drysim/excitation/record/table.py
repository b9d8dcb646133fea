"""Where the columns of a text file are: delimiter, header, names and units."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from drysim.errors import RecordError
from drysim.excitation.record.file import Cell, TextFile, fault
from drysim.excitation.record.lines import lines, name_and_unit, split
from drysim.quantity import NUMBER, near

DELIMITERS = "\t;,"
"""Tried in this order on the first row of numbers; a row with none is split at blanks."""

LISTED = 12
"""How many of a file's columns a message lists."""

NOT_A_NAME = re.compile(r"(?i)[+-]?(?:nan|inf|infinity|\d*[.,]\d.*|\d+e[+-]?\d+)", re.ASCII)
"""With bare numbers, what no header holds: so a damaged first row is a fault and no header."""

WORD_WITH_UNIT = re.compile(r"\S+\s*(?:\[[^\[\]]*\]|\([^()]*\))|\S+")


@dataclass(frozen=True)
class Table:
    """Columns of a text file; the numbers are still text.

    Attributes
    ----------
    file : TextFile
    delimiter : str
        One of tab, semicolon and comma, or nothing: blanks.
    decimal : str
        Point; or comma, in a file of semicolons or tabs whose rows hold commas and no points.
    header : tuple of Cell
        Empty when the file has none.
    width : int
        Number of columns.
    start, line : int
        Where the first row of numbers begins: its offset in the text, its 1-based line.
    header_line : int
        Line of the header, 0 when there is none.
    """

    file: TextFile
    delimiter: str
    decimal: str
    header: tuple[Cell, ...]
    width: int
    start: int
    line: int
    header_line: int

    def rows(self) -> Iterator[tuple[int, list[Cell]]]:
        """Give line and cells of every row of numbers; comments and blank ends are left out.

        A row is named by its line in the file, as an editor counts.
        """
        blank = 0
        for line, _, text in lines(self.file, self.start, self.line):
            if not text.strip():
                blank = blank or line
                continue
            if blank:
                raise fault(
                    self.file.shown, f"row {blank} is empty: the record has a gap", blank
                )
            yield line, split(text, self.delimiter)

    def called(self, index: int) -> str:
        """Give the column as messages name it."""
        name = self.header[index].quote if self.header else ""
        return f"column {index + 1}" + (f" (`{name}`)" if name else "")

    def names(self) -> str:
        """Give the columns there are as a list for messages."""
        if not self.header:
            return f"{self.width}, without names: the file has no header"
        listed = ", ".join(f"`{cell.quote}`" for cell in self.header[:LISTED])
        return listed + (f" and {self.width - LISTED} more" if self.width > LISTED else "")

    def find(self, wanted: str | int) -> int:
        """Give the 0-based column of a name, with or without its unit, or of a 1-based number.

        Raises
        ------
        RecordError
            When there is no such column, or more than one.
        """
        if isinstance(wanted, int):
            if wanted <= self.width:
                return wanted - 1
            raise self.fault(f"there is no column {wanted}; there are: {self.names()}")
        full = [cell.text for cell in self.header]
        bare = [name_and_unit(text)[0] for text in full]
        hits = [i for i, text in enumerate(full) if text == wanted.strip()]
        hits = hits or [i for i, text in enumerate(bare) if text == wanted.strip()]
        if len(hits) == 1:
            return hits[0]
        if hits:
            numbers = " and ".join(str(i + 1) for i in hits)
            raise self.fault(f"columns {numbers} are both `{wanted}`; give the column's number")
        nearest = near(wanted, filter(None, bare + full))
        guess = f" did you mean `{nearest}`?" if nearest else ""
        raise self.fault(f"there is no column `{wanted}`;{guess} there are: {self.names()}")

    def fault(self, sentence: str, index: int | None = None) -> RecordError:
        """Give the error for a fault of the header, or of one column's header."""
        cell = self.header[index] if index is not None and self.header else None
        return fault(self.file.shown, sentence, self.header_line or self.line, cell)


def tabulate(file: TextFile) -> Table:
    """Find header, delimiter and columns of a text file.

    Raises
    ------
    RecordError
        When there are no rows of numbers, the header is not UTF-8 or does not fit the rows.
    """
    content = ((n, at, text) for n, at, text in lines(file) if text.strip())
    line, start, text = next(content, (0, 0, ""))
    header_line, header_text = 0, ""
    if line and _is_header(split(text, _delimiter(text))):
        header_line, header_text = line, text
        if "\ufffd" in text:
            raise fault(file.shown, "the header is not UTF-8; save the record as UTF-8", line)
        line, start, text = next(content, (0, 0, ""))
    if not line:
        raise fault(file.shown, "the record holds no rows of numbers", header_line)
    delimiter = _delimiter(text)
    width = len(split(text, delimiter))
    header = _header(header_text, delimiter, width) if header_line else ()
    if header and len(header) != width:
        sentence = f"the header names {len(header)} columns, but row {line} has {width}"
        raise fault(file.shown, sentence, line)
    decimal = _decimal(file, start, delimiter)
    return Table(file, delimiter, decimal, tuple(header), width, start, line, header_line)


def _delimiter(text: str) -> str:
    return next((mark for mark in DELIMITERS if mark in text), "")


def _decimal(file: TextFile, start: int, delimiter: str) -> str:
    """Comma where it cannot be a delimiter and no point contradicts it."""
    commas = delimiter in ("\t", ";") and file.text.find(b",", start) >= 0
    return "," if commas and file.text.find(b".", start) < 0 else "."


def _is_header(cells: list[Cell]) -> bool:
    written = [cell.text for cell in cells if cell.text]
    return bool(written) and not any(
        NUMBER.fullmatch(text) or NOT_A_NAME.fullmatch(text) for text in written
    )


def _header(text: str, delimiter: str, width: int) -> list[Cell]:
    mark = delimiter or _delimiter(text)
    if mark:
        return split(text, mark)
    if width == 1:
        return [Cell(text.strip(), len(text) - len(text.lstrip()) + 1)]
    return [Cell(m.group(), m.start() + 1) for m in WORD_WITH_UNIT.finditer(text)]
