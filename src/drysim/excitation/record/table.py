"""Where the columns of a text file are: delimiter, header, names and units."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Decimal
from itertools import islice

from drysim.core.signal import Signal
from drysim.errors import RecordError
from drysim.excitation.record.cells import numbers
from drysim.excitation.record.columns import Columns, Label
from drysim.excitation.record.file import Cell, TextFile, fault
from drysim.excitation.record.lines import lines, name_and_unit, split
from drysim.quantity import NUMBER

DELIMITERS = "\t;,"
"""Tried in this order on the first row of numbers; a row with none is split at blanks."""

LOOKED_AT = 100
"""Rows whose printed digits are counted."""

NOT_A_NAME = re.compile(r"(?i)[+-]?(?:nan|inf|infinity|\d*[.,]\d.*|\d+e[+-]?\d+)", re.ASCII)
"""With bare numbers, what no header holds: so a damaged first row is a fault and no header."""

WORD_WITH_UNIT = re.compile(r"\S+\s*(?:\[[^\[\]]*\]|\([^()]*\))|\S+")


@dataclass(frozen=True, kw_only=True)
class Table(Columns):
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
    start, line : int
        Where the first row of numbers begins: its offset in the text, its 1-based line.
    header_line : int
        Line of the header, 0 when there is none.
    """

    file: TextFile
    delimiter: str
    decimal: str
    header: tuple[Cell, ...]
    start: int
    line: int
    header_line: int

    def rows(self) -> Iterator[tuple[int, list[Cell]]]:
        """Give line and cells of every row of numbers; comments and blank ends are left out.

        A row is named by its line in the file, as an editor counts. One that is empty has no
        cells.
        """
        blank: list[int] = []
        for line, _, text in lines(self.file, self.start, self.line):
            if not text.strip():
                blank.append(line)
                continue
            for empty in blank:
                yield empty, []
            blank.clear()
            yield line, split(text, self.delimiter)

    def numbers(self, wanted: list[int], gappy: int | None = None) -> list[Signal]:
        """Give columns as finite numbers, NaN where a sample of the `gappy` one is missing."""
        return list[Signal](numbers(self, wanted, gappy))

    def last_digit(self, index: int) -> float:
        """Give the unit of the last digit that the first rows print."""
        exponents = []
        for _, cells in islice(filter(lambda row: row[1], self.rows()), LOOKED_AT):
            exponent = Decimal(cells[index].text.replace(",", ".")).as_tuple().exponent
            exponents.append(int(exponent))
        return float(10.0 ** min(*exponents, 0))

    def at(self, row: int, index: int, sentence: str) -> RecordError:
        """Give the error at a cell in the 0-based row of numbers."""
        line, cells = next(islice(self.rows(), row, None))
        where = f"row {line}, {self.called(index)}"
        return fault(self.shown, f"{where}: {sentence}", line, cells[index] if cells else None)

    def fault(self, sentence: str, index: int | None = None) -> RecordError:
        """Give the error for a fault of the header, or of one column's header."""
        cell = self.header[index] if index is not None and self.header else None
        return fault(self.file.shown, sentence, self.header_line or self.line, cell)

    def elsewhere(self, wanted: str) -> str:
        """Say which row names the column, where words of a logger above it look like names."""
        for line, _, text in islice(lines(self.file), LOOKED_AT):
            named = [name_and_unit(cell.text)[0] for cell in split(text, _delimiter(text))]
            if line != self.header_line and wanted.strip() in named:
                taken = f", and row {self.header_line} was taken for the header"
                hint = "begin the rows above with # or cut them away"
                return f"; row {line} names it{taken if self.header_line else ''}: {hint}"
        return ""


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
    cells = split(text, delimiter)
    width = len(cells)
    if header_line and _is_header(cells):  # a text: none of its words are names of columns
        cell = next(cell for cell in cells if cell.text)
        raise fault(file.shown, f"row {line}: `{cell.quote}` is not a number", line, cell)
    header = _header(header_text, delimiter, width) if header_line else ()
    if header and len(header) != width:
        sentence = f"the header names {len(header)} columns, but row {line} has {width}"
        raise fault(file.shown, sentence, line)
    decimal = _decimal(file, start, delimiter)
    return Table(
        shown=file.shown,
        labels=tuple(Label(cell.text, *name_and_unit(cell.text)) for cell in header),
        width=width,
        file=file,
        delimiter=delimiter,
        decimal=decimal,
        header=tuple(header),
        start=start,
        line=line,
        header_line=header_line,
    )


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
