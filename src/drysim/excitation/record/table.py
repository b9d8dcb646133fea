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
from drysim.excitation.record.columns import Columns
from drysim.excitation.record.file import Cell, TextFile, fault
from drysim.excitation.record.heads import (
    LOOKED_AT,
    MOST_COLUMNS,
    decimal_commas,
    delimiter_below,
    delimiter_of,
    header_cells,
    is_header,
    is_units,
    labels_of,
    likely_header,
    wide,
)
from drysim.excitation.record.lines import left_open, lines, split
from drysim.wording import several

MARK = re.compile("[.,]")
"""What may part the decimals of a number."""


@dataclass(frozen=True, kw_only=True)
class Table(Columns):
    """Columns of a text file; the numbers are still text.

    Attributes
    ----------
    file : TextFile
    delimiter : str
        One of tab, semicolon and comma, or nothing: blanks.
    header : tuple of Cell
        Empty when the file has none.
    start, line : int
        Where the first row of numbers begins: its offset in the text, its 1-based line.
    header_line : int
        Line of the header, 0 when there is none.
    """

    file: TextFile
    delimiter: str
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

    def decimal(self, wanted: list[int]) -> str:
        """Give the decimal mark of some columns, a comma only where it parts no cells.

        Where there are points as well, as in dates, the first mark in these columns decides.
        """
        text = self.file.text
        if self.delimiter == "," or text.find(b",", self.start) < 0:
            return "."
        if text.find(b".", self.start) < 0:
            return ","
        used = (cells[i].text for _, cells in self.rows() for i in wanted if i < len(cells))
        return next((mark[0] for mark in map(MARK.search, used) if mark), ".")

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

    def ragged(self, line: int, cells: int) -> RecordError:
        """Give the error for a row that has not as many cells as the first one."""
        for number, _, text in lines(self.file, self.start, self.line):
            if number in (self.line, line):
                refuse_open_quote(self.shown, number, text)
            if number == line:
                break
        sentence = f"row {line} has {several(cells, 'cell')}, not {self.width}"
        return fault(self.shown, sentence, line)

    def fault(self, sentence: str, index: int | None = None) -> RecordError:
        """Give the error for a fault of the header, or of one column's header."""
        cell = self.header[index] if index is not None and self.header else None
        return fault(self.file.shown, sentence, self.header_line or self.line, cell)

    @property
    def way_round(self) -> str:
        """How to pass over the header."""
        skip = f"`skip: {self.line - 1}` passes over the header"
        return f"; {skip}, and columns have numbers then"

    def series(self) -> list[int]:
        """Give the 0-based columns that may be samples: one without a name is none of them."""
        named = [i for i, label in enumerate(self.labels) if label.text]
        return named or super().series()


def refuse_open_quote(shown: str, line: int, text: str) -> None:
    """Make sure that a row closes its quotation marks; no delimiter counts behind one."""
    if cell := left_open(text):
        sentence = f"row {line} has a quotation mark that is not closed: `{cell.quote}`"
        raise fault(shown, sentence, line, cell)


def tabulate(file: TextFile) -> Table:
    """Find header, delimiter and columns of a text file.

    Raises
    ------
    RecordError
        When there are no rows of numbers or too many columns, the header is not UTF-8 or does
        not fit the rows.
    """
    line, width = wide(file)
    if line:
        sentence = f"row {line} has {width} columns, more than {MOST_COLUMNS}"
        raise fault(file.shown, f"{sentence}: write one sample a row", line)
    content = ((n, at, text) for n, at, text in lines(file) if text.strip())
    line, start, text = next(content, (0, 0, ""))
    if (likely := likely_header(file)) > line:
        hint = f"`skip: {likely - 1}` passes over the rows above it"
        raise fault(
            file.shown, f"row {likely} looks like the header, not row {line}: {hint}", likely
        )
    header_line, header_text, units = 0, "", list[Cell]()
    if line and is_header(split(text, delimiter_of(text))):
        header_line, header_text = line, text
        if "\ufffd" in text:
            raise fault(file.shown, "the header is not UTF-8; save the record as UTF-8", line)
        line, start, text = next(content, (0, 0, ""))
        below = split(text, delimiter_of(text))
        if line and is_units(below, header_cells(header_text, delimiter_of(text), len(below))):
            units = below
            line, start, text = next(content, (0, 0, ""))
    if not line:
        raise fault(file.shown, "the record holds no rows of numbers", header_line)
    delimiter = delimiter_below(header_text, text)
    if not header_line and delimiter == "," and decimal_commas(file):
        delimiter = ""
    cells = split(text, delimiter)
    width = len(cells)
    if header_line and is_header(cells):  # a text: none of its words are names of columns
        cell = next(cell for cell in cells if cell.text)
        raise fault(file.shown, f"row {line}: `{cell.quote}` is not a number", line, cell)
    header = header_cells(header_text, delimiter, width) if header_line else []
    if header and len(header) != width:
        refuse_open_quote(file.shown, header_line, header_text)
        refuse_open_quote(file.shown, line, text)
        names = several(len(header), "column")
        sentence = f"the header names {names}, but row {line} has {width}"
        if delimiter == "," and width == 2 * len(header):
            sentence += (
                "; commas seem to part columns and decimals alike: write decimals with points, "
                "or columns with semicolons"
            )
        raise fault(file.shown, sentence, line)
    return Table(
        shown=file.shown,
        labels=labels_of(header, units),
        width=width,
        file=file,
        delimiter=delimiter,
        header=tuple(header),
        start=start,
        line=line,
        header_line=header_line,
    )
