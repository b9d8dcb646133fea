"""Text records: delimited tables (CSV and similar), and AT2 accelerograms.

A table has one row per sample, with cells delimited by tabs, semicolons, commas or blanks and
with decimal points or commas. A preamble (skipped by `skip`), a header with names and units, or
a row of units may precede the numbers. Delimiter, header and units are detected from the rows.

Reading is done in two passes. The fast pass parses blocks of bytes with `numpy.loadtxt` and
accepts only perfectly regular blocks. If it fails, a second pass goes through the cells one by
one and reports the first fault by row and column.

The `csv` module is not used. Its reader does not tell in which column a cell begins, and its
sniffer names a wrong delimiter for columns apart by blanks and for single columns.

An AT2 file is an accelerogram of the PEER ground motion database: a header of four lines with
NPTS and DT, followed by one series of numbers.
"""

from __future__ import annotations

import math
import re
import warnings
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from decimal import Decimal, InvalidOperation
from functools import cached_property, partial
from io import StringIO
from itertools import islice, pairwise
from typing import NamedTuple

import numpy as np

from drysim.core.model import Floats, Signal
from drysim.errors import RecordError
from drysim.records import SI
from drysim.records.clock import (
    DAY,
    HOUR_AND_MINUTE,
    Clock,
    across_midnight,
    clock_resolution,
    find_clock,
    find_dates,
    is_time_name,
)
from drysim.records.columns import (
    CONVERT_SEISMIC,
    FLOAT64_SIZE,
    GAP_HINT,
    INFINITE_HINT,
    KNOWN_STEP,
    NO_FULL_SCALE,
    NOT_TEXT,
    ONE_SERIES,
    USE_COLUMN,
    Cell,
    Channel,
    Channels,
    ColumnLabel,
    Columns,
    Format,
    PrintedTimes,
    RecordFile,
    TextFile,
    make_channels,
    printable,
    require_memory,
    require_memory_to_load,
)
from drysim.units import NUMBER_PATTERN, is_common_unit
from drysim.wording import format_count

# Lines and cells.


NAME_WITH_UNIT = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))"
)

QUOTED = re.compile("`([^`]+)`")

DELIMITERS = "\t;,"
"""Tried in this order on the first row of numbers; a row without any is split at blanks."""

LINES_SIZE = 1 << 16
"""Bytes split into lines at a time; often only the first lines of a file are needed."""

SPREADSHEET_ERROR = re.compile(
    r"#(?:N/A|NV|DIV/0!|VALUE!|WERT!|REF!|BEZUG!|NUM!|ZAHL!|NULL!|NAME\?)"
)
"""A cell of a spreadsheet without a value; a line that begins with it is no comment."""

MAX_QUOTED_LINES = 100
"""Lines at the top of a file that messages may quote besides the faulty one."""

MAX_NAME_LENGTH = 200
"""Characters of a header cell that may still be a name with a unit."""


def content_lines(
    file: TextFile, start: int = 0, line: int = 0
) -> Iterator[tuple[int, int, str]]:
    """Yield line number, offset and text of every line that is not a comment.

    The first line begins at offset `start`, by default where the text begins; `line` is its
    1-based number.
    """
    for number, offset, part in raw_lines(file, start, line):
        text = _decode_line(part)
        if not text.lstrip().startswith("#") or SPREADSHEET_ERROR.match(text.lstrip()):
            yield number, offset, text


def raw_lines(
    file: TextFile, start: int = 0, line: int = 0
) -> Iterator[tuple[int, int, bytes]]:
    """Yield line number, offset and bytes of every line; parameters as in `content_lines`."""
    text, start, line = file.text, max(start, file.begin), line or file.line
    while start < len(text):
        end = start + text[start : start + LINES_SIZE].rfind(b"\n") + 1
        if end == start:  # one long line, or the last one
            end = text.find(b"\n", start) + 1 or len(text)
        for part in text[start:end].splitlines(keepends=True):
            yield line, start, part.rstrip(b"\r\n")
            start, line = start + len(part), line + 1


def _decode_line(part: bytes) -> str:
    """Decode a line as UTF-8, or else as cp1252, which spreadsheets under Windows write."""
    try:
        return part.decode("utf-8")
    except UnicodeDecodeError:
        return part.decode("cp1252", "replace")


def redact_quotes(error: RecordError, text: TextFile) -> RecordError:
    """Return the error for a symbolic link without the lines that it quotes.

    The target of a link may be any file, such as a private key. Whole lines and parts of lines
    without a delimiter are replaced; a faulty cell of another line stays.
    """
    problem = error.problem
    head = islice(raw_lines(text), MAX_QUOTED_LINES)
    faulty = islice((row for row in raw_lines(text) if row[0] == problem.line), 1)
    parts = [printable(_decode_line(part)).strip() for _, _, part in (*head, *faulty)]
    whole = [line for line in parts if line]
    secret = [line for line in whole if not any(mark in line for mark in DELIMITERS)]

    def hidden(quote: re.Match[str]) -> str:
        quoted = quote[1].removesuffix("…")
        if any(quoted in line for line in secret) or quoted in whole:
            return "`…`"
        return quote[0]

    sentence = QUOTED.sub(hidden, problem.sentence)
    if any("`" in line for line in whole):  # a quoted cell may contain a backtick itself
        sentence = f"row {problem.line} is not a valid row of a record"
    if sentence == problem.sentence:
        return error
    return RecordError(replace(problem, sentence=sentence, column=0, source=""), error.hint)


def split_cells(text: str, delimiter: str) -> list[Cell]:
    """Split a line into cells; delimiters within quotation marks do not count."""
    if not delimiter:
        return [Cell(m.group(), m.start() + 1) for m in re.finditer(r"\S+", text)]
    cells, offset, parts, quotes = [], 0, list[str](), 0
    for part in text.split(delimiter):
        parts.append(part)
        quotes += part.count('"')
        if quotes % 2 == 0:
            whole, parts = delimiter.join(parts), []
            cells.append(_make_cell(whole, offset))
            offset += len(whole) + 1
    return [*cells, _make_cell(delimiter.join(parts), offset)] if parts else cells


def _make_cell(part: str, offset: int) -> Cell:
    stripped = part.strip()
    quoted = len(stripped) > 1 and stripped[0] == stripped[-1] == '"'
    text = stripped[1:-1].replace('""', '"').strip() if quoted else stripped
    return Cell(text, offset + part.find(stripped) + 1 + quoted)


def read_label(text: str) -> ColumnLabel:
    """Return a header cell as a label; only a unit in square brackets is certain."""
    match = NAME_WITH_UNIT.fullmatch(text) if len(text) <= MAX_NAME_LENGTH else None
    if not match:
        return ColumnLabel(text, text)
    square = match["square"] is not None
    unit = match["square"] if square else match["round"]
    return ColumnLabel(text, match["name"], unit.strip(), square)


# Header and row of units.


MAX_ROWS_EXAMINED = 100
"""Rows examined to detect the header."""

MOST_COLUMNS = 16_384
"""Limit of spreadsheets; a wider file has its samples in one row."""

NUMBER_LIKE = re.compile(
    r"(?i)[+\-\u2212]*(?:nan|inf|infinity|\d*[.,]\d.*|\d+(?:e[+-]?\d+)?)", re.ASCII
)
"""Text that is no column name, so that a damaged first row is a fault and not a header."""

DECIMAL_COMMA = re.compile(r"[+-]?\d+(?:,\d+)?", re.ASCII)
ZERO_AFTER_COMMA = re.compile(r",0\d", re.ASCII)
"""Together with `DECIMAL_COMMA`: digits that only a decimal comma can precede."""

WORD_WITH_UNIT = re.compile(r"\S+\s*(?:\[[^\[\]]*\]|\([^()]*\))|\S+")


def find_delimiter(text: str) -> str:
    """Return the delimiter of a row; empty for blanks."""
    return next((mark for mark in DELIMITERS if mark in text), "")


def find_delimiter_below(header: str, row: str) -> str:
    """Return the delimiter of a row of numbers below a header, which may be empty.

    A comma is a decimal comma if only then the number of cells equals that of the header.
    """
    mark = find_delimiter(row)
    if mark != "," or "," in header or not header:
        return mark
    cells = split_cells(row, "")
    fits = len(header_cells(header, "", len(cells))) == len(cells)
    return "" if fits and all(map(is_number, cells)) else mark


def has_decimal_commas(file: TextFile) -> bool:
    """Return whether rows without a header are one column of numbers with decimal commas."""
    rows = [text.strip() for _, _, text in islice(content_lines(file), MAX_ROWS_EXAMINED)]
    written = [text for text in rows if text]
    return all(map(DECIMAL_COMMA.fullmatch, written)) and any(
        map(ZERO_AFTER_COMMA.search, written)
    )


def check_width(file: TextFile) -> None:
    """Raise for a row with more columns than a spreadsheet has."""
    for line, _, text in islice(content_lines(file), MAX_ROWS_EXAMINED):
        mark = find_delimiter(text)
        columns = text.count(mark) + 1 if mark else len(text.split())
        if columns > MOST_COLUMNS:
            sentence = f"row {line} has {columns} columns, more than {MOST_COLUMNS}"
            raise file.error(f"{sentence}: write one sample per row", line)


def is_header(cells: Sequence[Cell]) -> bool:
    """Return whether no cell of a row looks like a number."""
    written = [cell.text for cell in cells if cell.text]
    return bool(written) and not any(
        NUMBER_PATTERN.fullmatch(text) or NUMBER_LIKE.fullmatch(text) for text in written
    )


def header_cells(text: str, delimiter: str, width: int) -> list[Cell]:
    """Split a header above rows with a given delimiter and number of columns."""
    mark = delimiter or find_delimiter(text)
    if mark:
        return split_cells(text, mark)
    if width == 1:
        return [Cell(text.strip(), len(text) - len(text.lstrip()) + 1)]
    return [Cell(m.group(), m.start() + 1) for m in WORD_WITH_UNIT.finditer(text)]


def is_unit_row(cells: Sequence[Cell], header: Sequence[Cell]) -> bool:
    """Return whether a row of words contains units, below a header without any."""
    fits = len(cells) == len(header) and is_header(cells)
    if not fits or any(read_label(cell.text).unit for cell in header):
        return False
    texts = (cell.text.strip("[]()") for cell in cells)
    return any(is_common_unit(word, si) for word in texts for si in ("s", *SI.values()))


def _is_of_units(header: Sequence[Cell]) -> bool:
    """Return whether a header names units only, of times first, as in `s;m/s²`."""
    first, *others = (cell.text for cell in header if cell.text) if header else ("",)
    motion = [si for quantity, si in SI.items() if quantity != "force"]
    return (
        bool(others)
        and is_common_unit(first, "s")
        and all(any(is_common_unit(text, si) for si in motion) for text in others)
    )


def find_header(file: TextFile) -> int:
    """Return the 1-based line of the first row with as many names as numbers below it.

    Returns 0 if there is none above the first two rows with equally many numbers.
    """
    content = islice((row for row in content_lines(file) if row[2].strip()), MAX_ROWS_EXAMINED)
    first = [(line, text) for line, _, text in content]
    top = first[0][0] if first else 0
    for number, ((line, text), (_, below)) in enumerate(pairwise(first)):
        mark = find_delimiter_below(text, below)
        row = split_cells(below, mark)
        head = header_cells(text, mark, len(row))
        if number + 2 < len(first) and is_unit_row(row, head):
            below = first[number + 2][1]
            mark = find_delimiter_below(text, below)
            row = split_cells(below, mark)
        if len(row) == len(head) and all(map(is_number, row)):
            if is_header(head):
                # If the top row is a header, words between it and the numbers are an error. A
                # title that a spreadsheet filled up with delimiters is none.
                cells = header_cells(first[0][1], mark, len(row))
                several = sum(cell.text != "" for cell in cells) > 1
                return top if several and len(cells) == len(row) and is_header(cells) else line
            if all(map(is_number, head)):
                return 0
    return 0


def is_number(cell: Cell) -> bool:
    """Return whether a cell contains a number, with a decimal point or comma."""
    text = NumberForm(".").plain(cell.text)
    return NUMBER_PATTERN.fullmatch(text.replace(",", ".", 1)) is not None


# The table.


DECIMAL_MARK = re.compile("[.,]")
"""Decimal point or comma."""

FIXED_DIGITS = 1000
"""So many rows with a mark in each are numbers printed with three decimal digits."""

GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}", re.ASCII)
"""A number whose mark may be one between thousands."""

GROUPED_FRACTION = re.compile(r"[+-]?[1-9]\d{0,2}(?:(?:\.\d{3})+,|(?:,\d{3})+\.)\d+", re.ASCII)
"""A number with marks between thousands that cannot be decimal marks, as in `1.234,5`."""

MARKED_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:[\s'’.,]\d{3})+(?:[.,]\d*)?")
"""A number with marks between thousands, which may be blanks or apostrophes."""

Reading = Callable[[str], float]
"""The number that the text of a cell stands for; NaN for none."""


Readings = Mapping[int | str, Reading]
"""How the cells of some 0-based columns are read; all others contain numbers."""

NO_READINGS: Readings = {}
"""All columns contain numbers."""


class NumberForm(NamedTuple):
    """Decimal mark of a column, and the mark between its thousands, empty without one."""

    decimal: str
    grouping: str = ""

    def plain(self, text: str) -> str:
        """Return a number with a decimal point and without marks between thousands."""
        if self.grouping:
            whole, mark, fraction = text.partition(self.decimal)
            first, *groups = whole.split(self.grouping)
            if groups and len(first.lstrip("+-")) <= 3 and {3} == set(map(len, groups)):
                text = "".join([first, *groups, mark, fraction])
        elif "." in text and "," in text and GROUPED_FRACTION.fullmatch(text):
            text = text.replace("," if text.rfind(".") > text.rfind(",") else ".", "")
        return text if self.decimal == "." else text.replace(".", "?").replace(",", ".", 1)

    def number(self, text: str) -> float:
        """Return the number in a cell; NaN for none."""
        text = self.plain(text)
        return float(text) if NUMBER_PATTERN.fullmatch(text) else math.nan


def _may_be_grouped(values: Floats) -> bool:
    """Return whether numbers read with decimal points may have points between thousands."""
    for part in (values[:MAX_ROWS_EXAMINED], values):  # a few rows show it for most records
        size = np.abs(part)
        if ((size < 1.0) & (size > 0.0)).any():
            return False
    thousands = size * 1e3
    return bool((size != np.rint(size)).any() and np.allclose(thousands, np.rint(thousands)))


@dataclass(frozen=True, kw_only=True)
class TextTable(Columns):
    """Columns of a text file; the numbers are parsed on demand."""

    file: TextFile
    delimiter: str
    """Tab, semicolon or comma; empty for blanks."""
    header: tuple[Cell, ...]
    """Empty if the file has none."""
    start: int
    """Offset of the first row of numbers."""
    line: int
    """1-based line of that row."""
    header_line: int
    """1-based line of the header, 0 if there is none."""
    spacing: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    """Time step and first time [s] of the columns of which the file contains them."""

    def rows(self) -> Iterator[tuple[int, list[Cell]]]:
        """Yield line and cells of every row of numbers, without comments and trailing blanks.

        An empty row has no cells. Rows that the scenario leaves out are not among them.
        """
        blank: list[int] = []
        last, where = self.file.rows.to, self._selected_cells
        for line, _, text in content_lines(self.file, self.start, self.line):
            if last is not None and line > last:
                break
            if not text.strip():
                blank.append(line)
                continue
            cells = split_cells(text, self.delimiter)
            if where:
                if len(cells) == self.width and any(cells[i].text != x for i, x in where):
                    continue
                blank.clear()
            for empty in blank:
                yield empty, []
            blank.clear()
            yield line, cells

    @cached_property
    def _selected_cells(self) -> list[tuple[int, str]]:
        """0-based columns, and the text in each of them that makes a row a sample."""
        return [(self.find(key), str(text)) for key, text in self.file.rows.where.items()]

    def clock(self, index: int) -> Clock | None:
        """Return how the clock readings of a column are written; None if it has none."""
        first, last = ([*cells[index : index + 1]] for cells in self._end_rows)
        return find_clock(first[0].text, last[0].text if last else "") if first else None

    def date_column(self, time: int) -> tuple[int, Clock] | None:
        """Return the column with the dates of times of day, and their form."""
        first, last = self._end_rows
        for index, (begin, end) in enumerate(zip(first, last, strict=False)):
            is_date = not is_number(begin) or is_time_name(self.labels[index].name)
            if index != time and is_date and (dates := find_dates(begin.text, end.text)):
                return index, dates
        return None

    def end_texts(self, index: int) -> tuple[str, str]:
        """Return the contents of a column in the first and in the last row."""
        first, last = self._end_rows
        return first[index].text, last[index].text if index < len(last) else ""

    @cached_property
    def _end_rows(self) -> tuple[list[Cell], list[Cell]]:
        """Cells of the first and of the last row."""
        first = next((cells for _, cells in self.rows() if cells), [])
        end = end_of_rows(self)
        tail = self.file.text[max(self.start, end - LINES_SIZE) : end].rstrip().splitlines()
        last = split_cells(_decode_line(tail[-1]), self.delimiter) if tail else []
        return first, last

    def with_times(
        self, time: int, wanted: list[int], gap_column: int | None = None, unit: str = ""
    ) -> tuple[PrintedTimes, list[Signal]]:
        """Return the times in one column, numbers or clock readings, and other columns."""
        form = self.clock(time)
        if form is None:
            return super().with_times(time, wanted, gap_column, unit)
        if unit:
            sentence = "contains dates or times of day; remove `time_unit`"
            raise self.error(f"{self.describe_column(time)} {sentence}", time)
        readings: dict[int | str, Reading] = {time: form.seconds}
        dates = None if form.date_format else self.date_column(time)
        days = [] if dates is None else [dates[0]]
        if dates is not None:
            readings[dates[0]] = dates[1].days
        columns = [time, *wanted]
        t, *samples = self._read([*columns, *days], gap_column, readings)
        seconds = np.array(t[:])
        if days:
            seconds += DAY * samples.pop()[:]
        elif not form.date_format:
            seconds = across_midnight(seconds)
        examined = islice((cells for _, cells in self.rows() if cells), MAX_ROWS_EXAMINED)
        texts = [cells[time].text for cells in examined if time < len(cells)]
        return PrintedTimes(seconds, 1.0, clock_resolution(texts)), samples

    def file_spacing(self, index: int) -> tuple[float, float] | None:
        """Return time step and first time [s] of a column if the file contains them."""
        return self.spacing.get(index)

    def decimal(self, wanted: list[int]) -> str:
        """Return the decimal mark of some columns; a comma only where it is not the delimiter.

        If both marks occur, as with dates, the first one in these columns decides.
        """
        text = self.file.text
        if self.delimiter == "," or text.find(b",", self.start) < 0:
            return "."
        if text.find(b".", self.start) < 0:
            return ","
        used = (cells[i].text for _, cells in self.rows() for i in wanted if i < len(cells))
        return next((mark[0] for mark in map(DECIMAL_MARK.search, used) if mark), ".")

    def numbers(self, wanted: list[int], gap_column: int | None = None) -> list[Signal]:
        """Return columns as finite numbers, NaN where a sample of `gap_column` is missing.

        Raises
        ------
        RecordError
            At the first row with a wrong number of cells, or at the first cell without a finite
            number.
        """
        return self._read(wanted, gap_column, {})

    def _read(
        self, wanted: list[int], gap_column: int | None, readings: Readings
    ) -> list[Signal]:
        decimal = self.decimal(wanted)
        columns = _read_fast(self, wanted, decimal, readings)
        if columns is None or any(
            index not in readings and _may_be_grouped(x) and self.number_form(index).grouping
            for index, x in zip(wanted, columns, strict=True)
        ):
            columns = _read_by_cell(self, wanted, gap_column, readings)
        return list[Signal](columns)

    def printed_resolution(self, index: int) -> float:
        """Return the unit of the last digit with which the first rows are printed."""
        exponents, form = [0], self.number_form(index)
        for _, cells in islice(filter(lambda row: row[1], self.rows()), MAX_ROWS_EXAMINED):
            if NUMBER_PATTERN.fullmatch(text := form.plain(cells[index].text)):
                with suppress(InvalidOperation):  # an exponent of more than eighteen digits
                    exponents.append(int(Decimal(text).as_tuple().exponent))
        return float(10.0 ** min(exponents))

    def number_form(self, index: int) -> NumberForm:
        """Return the decimal mark of a column, and the mark between its thousands.

        Marks before groups of three digits only are those of thousands if numbers below one
        thousand have none, as in `980`, `990`, `1.000`.
        """
        if self.delimiter == ",":
            return NumberForm(".")
        mark, has_small = "", False
        for count, (_, cells) in enumerate(self.rows()):
            if count > FIXED_DIGITS and mark and not has_small:
                break
            text = cells[index].text if index < len(cells) else ""
            marks = DECIMAL_MARK.findall(text)
            if len(marks) > 1 and not MARKED_THOUSANDS.fullmatch(text):
                continue  # a damaged number
            if len(set(marks)) > 1:
                return NumberForm(marks[-1], marks[0])
            if len(marks) > 1:
                return NumberForm("," if marks[0] == "." else ".", marks[0])
            if marks and not GROUPED.fullmatch(text):
                return NumberForm(marks[0])
            mark = marks[0] if marks else mark
            has_small |= text.lstrip("+-").isdecimal() and text.strip("+-0") != ""
            if len(text.lstrip("+-")) > 3 and text.lstrip("+-").isdecimal():
                return NumberForm(self.decimal([index]))
        if mark and has_small:
            return NumberForm("," if mark == "." else ".", mark)
        return NumberForm(mark or ".")

    def error_at(self, row: int, index: int, sentence: str) -> RecordError:
        """Return the error at a cell in the 0-based row of numbers."""
        line, cells = next(islice(self.rows(), row, None))
        where = f"row {line}, {self.describe_column(index)}"
        return self.file.error(f"{where}: {sentence}", line, cells[index] if cells else None)

    def line_of(self, row: int) -> int:
        """Return the 1-based line of a 0-based row of numbers."""
        return next(islice(self.rows(), row, None))[0]

    def texts(self, index: int) -> Iterator[str]:
        """Yield the text in each row of numbers of a column; empty in an empty row."""
        for _, cells in self.rows():
            yield cells[index].quote if cells else ""

    def ragged(self, line: int, cells: int) -> RecordError:
        """Return the error for a row with a wrong number of cells."""
        for number, _, text in content_lines(self.file, self.start, self.line):
            if number in (self.line, line):
                check_quotes(self.file, number, text)
            if number == line:
                break
        sentence = f"row {line} has {format_count(cells, 'cell')}, not {self.width}"
        return self.file.error(sentence + _row_remedy(self, line), line)

    def error(self, sentence: str, index: int | None = None) -> RecordError:
        """Return the error for the header, or for the header cell of one column."""
        cell = self.header[index] if index is not None and self.header else None
        return self.file.error(sentence, self.header_line or self.line, cell)

    @property
    def skip_hint(self) -> str:
        """How to skip the header."""
        skip = f"`skip: {self.line - 1}` skips the header"
        return f"; {skip}; then select columns by number"

    def series(self) -> list[int]:
        """Return the 0-based columns that may contain samples; unnamed ones do not."""
        named = [i for i, label in enumerate(self.labels) if label.text]
        return named or super().series()[: self.width - self.ends_in_delimiter]

    @cached_property
    def end(self) -> int:
        """Offset where the rows end that are samples."""
        last, size = self.file.rows.to, len(self.file.text)
        lines = raw_lines(self.file, self.start, self.line) if last else iter(())
        return next((offset for line, offset, _ in lines if line > (last or 0)), size)

    @cached_property
    def ends_in_delimiter(self) -> bool:
        """Whether the last cell of the first row is empty, as behind a trailing delimiter."""
        first = self._end_rows[0]
        return bool(self.delimiter and len(first) > 1 and not first[-1].text)

    @cached_property
    def begins_with_delimiter(self) -> bool:
        """Whether the first cell of the first row is empty."""
        first = self._end_rows[0]
        return bool(self.delimiter and len(first) > 1 and not first[0].text)


def check_quotes(file: TextFile, line: int, text: str) -> None:
    """Raise for a row with an open quotation mark, behind which delimiters do not count."""
    if text.count('"') % 2:
        place = text.rfind('"')
        cell = Cell(text[place:], place + 1)
        sentence = f"row {line} has a quotation mark that is not closed: `{cell.quote}`"
        raise file.error(sentence, line, cell)


def header_error(file: TextFile, likely: int, line: int) -> RecordError:
    """Return the error that a lower row looks like the header than the one taken for it."""
    hint = f"`skip: {likely - 1}` skips the rows above it"
    return file.error(f"row {likely} looks like the header, not row {line}: {hint}", likely)


def detect_table(file: TextFile) -> TextTable:
    """Detect header, delimiter and columns of a text file.

    Raises
    ------
    RecordError
        If header and rows do not fit together, or there are no rows of numbers.
    """
    check_width(file)
    content = ((n, offset, text) for n, offset, text in content_lines(file) if text.strip())
    line, start, text = next(content, (0, 0, ""))
    if (likely := find_header(file)) > line:
        raise header_error(file, likely, line)
    header_line, header_text, units = 0, "", list[Cell]()
    if line and is_header(split_cells(text, find_delimiter(text))):
        header_line, header_text = line, text
        if "\ufffd" in text:
            raise file.error("the header is not UTF-8; save the record as UTF-8", line)
        line, start, text = next(content, (0, 0, ""))
        below = split_cells(text, find_delimiter(text))
        if line and is_unit_row(
            below, header_cells(header_text, find_delimiter(text), len(below))
        ):
            units = below
            line, start, text = next(content, (0, 0, ""))
    while line and line < (file.rows.start or 1):
        line, start, text = next(content, (0, 0, ""))
    if not line:
        raise file.error("the record contains no rows of numbers", header_line)
    delimiter = find_delimiter_below(header_text, text)
    if not header_line and delimiter == "," and has_decimal_commas(file):
        delimiter = ""
    cells = split_cells(text, delimiter)
    width = len(cells)
    if header_line and is_header(cells):  # prose, not a header
        cell = next(cell for cell in cells if cell.text)
        sentence = f"row {line}: `{cell.quote}` is not a number"
        raise file.error(sentence, line, cell)
    header = header_cells(header_text, delimiter, width) if header_line else []
    if delimiter and len(header) == width - 1 and not cells[-1].text:
        header.append(Cell("", len(header_text) + 1))  # behind a trailing delimiter
    if header and len(header) != width:
        check_quotes(file, header_line, header_text)
        check_quotes(file, line, text)
        names = format_count(len(header), "column")
        sentence = f"the header names {names}, but row {line} has {width}"
        if delimiter == "," and width == 2 * len(header):
            sentence += (
                "; commas seem to be both delimiter and decimal mark: use decimal points, or "
                "semicolons as delimiter"
            )
        raise file.error(sentence, line)
    labels = tuple(read_label(cell.text) for cell in header) or (ColumnLabel(),) * width
    if not any(label.unit for label in labels) and _is_of_units(header):
        units = header
    if units:
        labels = tuple(
            ColumnLabel(
                label.text, label.text, cell.text.strip("[]()").strip(), is_unit_certain=False
            )
            for label, cell in zip(labels, units, strict=True)
        )
    return TextTable(
        display_path=file.display_path,
        labels=labels,
        file=file,
        delimiter=delimiter,
        header=tuple(header),
        start=start,
        line=line,
        header_line=header_line,
    )


# Cells to numbers.


PARSE_SIZE = 1 << 20
"""Bytes parsed at a time: small compared with the numbers, large compared with overhead."""

COMMENT_LINE = re.compile(rb"(?m)^[ \t]*#(?!%s).*\n?" % SPREADSHEET_ERROR.pattern[1:].encode())

OVERLOAD = re.compile(r"(?i)[+-]?(?:ol|ovl|ovr|o\.l\.|over|overload|overrange|overflow)")
"""Contents of a cell whose sample was beyond the range."""

MISSING = re.compile(
    rf"(?i)|-+|[+-]?nan|na|n/a|n\.a\.|null|none|missing"
    rf"|{SPREADSHEET_ERROR.pattern}|{OVERLOAD.pattern[4:]}"
)
"""Contents of a cell without a number."""

MISSING_TIME_HINT = "a missing time is not filled: delete the row, or set `rate` instead"
"""Hint for a row without a time; its sample becomes a gap, or is taken as evenly spaced."""

EMPTY_ROW_HINT = "the record has a gap; delete the row: the times show the gap"
"""Hint for an empty row of a table with times."""


def _read_fast(
    table: TextTable,
    wanted: list[int],
    decimal: str,
    readings: Readings = NO_READINGS,
) -> list[Floats] | None:
    """Return columns of a table; None unless all rows are regular and all numbers finite."""
    if table.file.rows.where:
        return None
    text, offset, last = table.file.text, table.start, end_of_rows(table)
    columns = [array("d") for _ in wanted]
    outer = (
        table.begins_with_delimiter and 0 not in wanted,
        (table.ends_in_delimiter and table.width - 1 not in wanted),
    )
    while offset < last:
        end = min(text.find(b"\n", min(offset + PARSE_SIZE, last)) + 1 or last, last)
        rows = _parse_block(text[offset:end], table, decimal, readings, outer)
        if rows is None or not np.isfinite(rows[:, wanted]).all():
            return None
        if not columns[0]:  # estimate the size of all rows from the first ones
            count = len(rows) * (last - offset) / (end - offset)
            require_memory(table.display_path, count * FLOAT64_SIZE * len(columns))
        for index, column in zip(wanted, columns, strict=True):
            column.frombytes(rows[:, index].tobytes())
        offset = end
    return [np.frombuffer(column) for column in columns]


def end_of_rows(table: TextTable) -> int:
    """Return the offset where the last row ends, before trailing line endings."""
    text, end = table.file.text, table.end
    while end > table.start:
        tail = text[max(table.start, end - PARSE_SIZE) : end]
        if kept := len(tail.rstrip(b"\r\n")):
            return end - len(tail) + kept
        end -= len(tail)
    return end


def _parse_block(
    block: bytes,
    table: TextTable,
    decimal: str,
    readings: Readings,
    outer: tuple[bool, bool],
) -> Floats | None:
    """Parse whole lines to numbers, shape (rows, columns); None unless all are regular.

    `outer` says whether the empty cells before the first delimiter, and behind the last one,
    count as 0.
    """
    if b"\r" in block:
        block = block.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if b"#" in block:
        block = COMMENT_LINE.sub(b"", block)
    if decimal == ",":
        if b"." in block:
            return None  # the slow pass determines in which columns
        block = block.replace(b",", b".")
    block = block.removesuffix(b"\n")
    if not block:
        return np.empty((0, table.width))
    mark = table.delimiter.encode()
    if outer[0]:
        block = (b"\n" + block).replace(b"\n" + mark, b"\n0" + mark)[1:]
    if outer[1]:
        block = (block + b"\n").replace(mark + b"\n", mark + b"0\n")[:-1]
    rows = _parse_rows(block, table.delimiter, readings)
    lines = block.count(b"\n") + 1  # more than there are rows if one is blank
    return rows if rows is not None and rows.shape == (lines, table.width) else None


def _parse_rows(text: bytes, delimiter: str, readings: Readings = NO_READINGS) -> Floats | None:
    """Parse lines of equally many numbers; None if the text contains anything else."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # text that is blank
            lines = StringIO(text.decode("ascii"))
            return np.loadtxt(
                lines,
                delimiter=delimiter or None,
                comments=None,
                converters=dict(readings) or None,
                ndmin=2,
                encoding=None,
            )
    except ValueError:
        return None


def _read_by_cell(
    table: TextTable,
    wanted: list[int],
    gap_column: int | None = None,
    readings: Readings = NO_READINGS,
) -> list[Floats]:
    """Return columns of a table, parsed cell by cell; raise at the first fault."""
    columns = [array("d") for _ in wanted]
    numbers = {index: readings.get(index, float) for index in wanted}
    forms = dict[int, NumberForm]()
    is_labelled = 0 not in wanted and _begins_with_number(table)
    for line, cells in table.rows():
        if not cells and wanted == [gap_column]:
            columns[0].append(math.nan)
            continue
        if not cells:
            hint = EMPTY_ROW_HINT if len(wanted) > 1 else GAP_HINT
            raise table.file.error(f"row {line} is empty: {hint}", line)
        if len(cells) != table.width:
            raise table.ragged(line, len(cells))
        if is_labelled and is_word(cells[0].text):
            fault = f"`{cells[0].quote}` is not a number"
            raise _not_a_sample(table, line, 0, cells[0], fault)
        for index, column in zip(wanted, columns, strict=True):
            text = cells[index].text
            if index == gap_column and MISSING.fullmatch(text):
                column.append(math.nan)
                continue
            if index not in readings and index not in forms and DECIMAL_MARK.search(text):
                forms[index] = table.number_form(index)
                numbers[index] = forms[index].number
            value = _parse(numbers[index], text)
            if not math.isfinite(value):
                hint = GAP_HINT if index == wanted[-1] else MISSING_TIME_HINT
                form = forms.get(index, NumberForm("."))
                fault = _describe_fault(cells[index], form, hint, index in readings)
                raise _not_a_sample(table, line, index, cells[index], fault)
            column.append(value)
    return [np.array(column) for column in columns]


def _parse(number: Reading, text: str) -> float:
    if number is float and not NUMBER_PATTERN.fullmatch(text):
        return math.nan
    return number(text)


def _begins_with_number(table: TextTable) -> bool:
    """Return whether the first cell of the first row begins as a number or time does."""
    first = next((cells for _, cells in table.rows() if cells), [])
    return bool(first) and BEGIN_OF_NUMBER.match(first[0].text) is not None


def is_word(text: str) -> bool:
    """Return whether a cell begins with a word that stands for no number."""
    return BEGIN_OF_WORD.match(text) is not None and MISSING.fullmatch(text) is None


BEGIN_OF_NUMBER, BEGIN_OF_WORD = re.compile(r"[+-]?[.,]?\d"), re.compile(r"[^\W\d_]{3}")
"""A word has three letters: `A0` may be a hexadecimal number."""


def _not_a_sample(
    table: TextTable, line: int, index: int, cell: Cell, fault: str
) -> RecordError:
    """Return the error for a cell without a number, with a remedy if its row is no sample."""
    sentence = f"row {line}, {table.describe_column(index)}: {fault}"
    is_name = any(cell.text == name.text for name in table.header)
    if is_name or (is_word(cell.text) and not fault.endswith(INFINITE_HINT)):
        sentence += _row_remedy(table, line)
    return table.file.error(sentence, line, cell)


def _row_remedy(table: TextTable, line: int) -> str:
    """Return how to leave out a row that is no sample; empty if many rows below are like it."""
    if line <= table.line:
        return ""
    rows_below = (cells for number, cells in table.rows() if number > line)
    below = list(islice(rows_below, MAX_ROWS_EXAMINED))
    samples = sum(len(x) == table.width and not is_word(x[0].text) for x in below)
    if not any(cells and is_number(cells[0]) for cells in below):
        return f"{NO_SAMPLE}`rows: {{to: {line - 1}}}` leaves it out"
    if len(below) > 1 and table.width not in (widths := {len(cells) for cells in below}):
        above = f"`rows: {{from: {line}}}` leaves out what is above"
        return f", and so have the rows below: {above}" if len(widths) == 1 else ""
    if 2 * samples < len(below):
        return ""
    return (
        f"{NO_SAMPLE}delete it; if it was a sample, `gaps` fills it: delete it, or with `rate` "
        f"or `step` leave it empty; `rows: {{to: {line - 1}}}` reads the rows above it"
    )


NO_SAMPLE = "; if it is no sample, "
"""Begin of the remedy for a damaged row."""


def _describe_fault(cell: Cell, form: NumberForm, hint: str, is_clock: bool) -> str:
    """Return what a cell contains instead of a number, and a remedy."""
    text = cell.text
    if not text:
        return f"the cell is empty: {hint}"
    if OVERLOAD.fullmatch(text):
        return f"`{cell.quote}` is an overload, not a number: {hint}"
    if MISSING.fullmatch(text):
        return f"`{cell.quote}` is not a finite number: {hint}"
    if is_clock:
        return f"`{cell.quote}` is not a time as in the first row"
    if form.decimal == "," and "." in text and NUMBER_PATTERN.fullmatch(text):
        return f"`{cell.quote}` has a decimal point; write commas throughout"
    if text.lower().lstrip("+-") in ("inf", "infinity") or NUMBER_PATTERN.fullmatch(text):
        return f"`{cell.quote}` is not a finite number: {INFINITE_HINT}"
    if is_number(cell) and form.decimal == ".":
        return f"`{cell.quote}` has a decimal comma; write points throughout"
    if MARKED_THOUSANDS.fullmatch(text):
        return f"`{cell.quote}` has marks between thousands; remove them"
    if HOUR_AND_MINUTE.fullmatch(text):
        either = "hours and minutes, or minutes and seconds"
        return f"`{cell.quote}` may be {either}; set `rate` or `step` instead of `time`"
    if find_clock(text, text) is not None:
        return f"`{cell.quote}` is a time of day, no sample"
    return f"`{cell.quote}` is not a number"


# The file.


BYTE_ORDER_MARK = b"\xef\xbb\xbf"
"""Written by some programs at the beginning of UTF-8 text."""

SEPARATOR_ROW = re.compile(rb'"?sep=.?"?\s*', re.IGNORECASE)
"""Row that declares the delimiter to Excel; it is detected from the numbers instead."""


def open_text(file: RecordFile) -> TextFile:
    """Return the text of a file without skipped rows and byte order mark.

    Raises
    ------
    RecordError
        If the file is binary or UTF-16, or has no rows left.
    """
    head = file.reader[: len(BYTE_ORDER_MARK)]
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise file.error("the record is UTF-16 text; save it as UTF-8")
    if file.reader.find(b"\0") >= 0:
        raise file.error("the record is binary: it contains a zero byte")
    text = TextFile(
        file.display_path, file.reader, len(BYTE_ORDER_MARK) if head == BYTE_ORDER_MARK else 0
    )
    first = next((part for _, _, part in raw_lines(text)), b"")
    skip = file.skip or int(SEPARATOR_ROW.fullmatch(first) is not None)
    below = next(islice(raw_lines(text), skip, None), None)
    if below is None and file.skip:
        raise file.error(f"`skip` skips {file.skip} rows, and the file has no more")
    text = text._replace(rows=file.rows)
    return text._replace(line=below[0], begin=below[1]) if below else text


FOREIGN = {
    "a K-NET": re.compile(r"Origin Time\s"),
    "a COSMOS": re.compile(r"(?i)(?:un|re)?corrected accelerogram|.*\bCOSMOS\b"),
}
"""First lines of seismic records whose series run across the rows."""


def text_columns(file: RecordFile) -> TextTable:
    """Return the columns of a text file."""
    text = open_text(file)
    top = text._replace(begin=0, line=1)
    first = next(
        (content.strip() for _, _, content in content_lines(top) if content.strip()), ""
    )
    for name, begin in FOREIGN.items():
        if begin.match(first[:MAX_HEADER_LINE_LENGTH]):
            sentence = f"this is {name} record, which is not read; {CONVERT_SEISMIC}"
            raise text.error(sentence, 1)
    is_lvm = first.startswith(LVM_BEGIN) and not file.skip
    return _lvm_table(text) if is_lvm else detect_table(text)


# LVM.


LVM_BEGIN = "LabVIEW Measurement"
LVM_END = "***End_of_Header***"
"""First line of a LabVIEW measurement file, and last line of either of its two headers."""


def _lvm_table(file: TextFile) -> TextTable:
    """Return the columns of a LabVIEW measurement file, with units and time steps."""
    keys: dict[str, list[str]] = {}
    ends, names, names_line, delimiter, start = 0, list[Cell](), 0, "", 0
    for line, offset, text in islice(content_lines(file), MAX_ROWS_EXAMINED):
        delimiter = find_delimiter(text)
        cells = split_cells(text, delimiter)
        first, *others = (cell.text for cell in cells)
        if ends == 2 and not names:
            names, names_line = cells, line
        elif names:
            start = offset
            break
        elif first == LVM_END:
            ends += 1
        elif first:
            keys[first] = others
    else:
        raise file.error(f"the LabVIEW file has no rows of numbers below its `{LVM_END}`")
    named = [cell.text for cell in names[: len(cells)]]
    channels = [i for i, name in enumerate(named) if name not in ("X_Value", "Comment")]
    units, labels = dict(zip(channels, keys.get("Y_Unit_Label", ()), strict=False)), []
    is_time = "Time" in keys.get("X_Dimension", ["Time"])
    has_times = keys.get("X_Columns", ["No"])[0] != "No"
    for index, name in enumerate(named):
        unit = units.get(index, "")
        if name == "X_Value":
            name, unit = (name, "s" if is_time else "") if has_times else ("", "")
        labels.append(ColumnLabel("" if name == "Comment" else name, name, unit))
    spacing = dict[int, tuple[float, float]]()
    for index, *numbers in zip(
        channels, keys.get("Delta_X", ()), keys.get("X0") or ["0"] * len(channels), strict=False
    ):
        step, begin = (_parse(float, text.replace(",", ".")) for text in numbers)
        if is_time and step > 0 and not has_times:
            spacing[index] = step, begin if math.isfinite(begin) else 0.0
    return TextTable(
        display_path=file.display_path,
        labels=tuple(labels),
        file=file,
        delimiter=delimiter,
        header=tuple(names[: len(cells)]),
        start=start,
        line=line,
        header_line=names_line,
        spacing=spacing,
    )


TEXT = Format("a text file", text_columns, {"channel": USE_COLUMN, "full_scale": NO_FULL_SCALE})


# AT2.


MAX_HEADER_LINES = 10
"""Lines searched for the end of the header, which has four, or more with comments."""

MAX_HEADER_LINE_LENGTH = 500
"""Characters of a header line that are searched."""

HEADER_NUMBER = r"[\d.e+-]{1,20}(?![\d.e+-])"
"""Regular expression of a number in the header."""

NPTS_AND_DT = (
    re.compile(
        rf"(?i)\bNPTS\s*=\s*(?P<n>{HEADER_NUMBER}).{{0,20}}?\bDT\s*=\s*(?P<dt>{HEADER_NUMBER})"
    ),
    re.compile(
        rf"(?i)(?<!\S)(?P<n>{HEADER_NUMBER})\s+(?P<dt>{HEADER_NUMBER})\s+NPTS\b.*\bDT\b"
    ),
)
"""`NPTS= 4000, DT= .0050 SEC` in recent files, `4000 0.0050 NPTS, DT` in older ones."""

UNITS_OF = re.compile(r"(?i)\bUNITS? OF ([a-z/*^0-9]{1,20})")


class At2Header(NamedTuple):
    """Header of an AT2 file: sample count, time step [s], unit, last line and its end."""

    n: int
    dt: float
    unit: str
    line: int
    end: int


def at2_columns(file: RecordFile) -> Channels:
    """Return the series of an AT2 file."""
    require_memory_to_load(file.display_path, len(file.reader))
    text = open_text(file)
    header = _read_at2_header(text)
    label = ColumnLabel(unit=header.unit)
    series = Channel(label, partial(_read_at2_samples, text, header), header.dt)
    return make_channels(file, [series], word="series")


def _read_at2_header(text: TextFile) -> At2Header:
    """Find the header line with NPTS and DT."""
    unit = ""
    for line, start, content in content_lines(text):
        content_start = content[:MAX_HEADER_LINE_LENGTH]
        if line > MAX_HEADER_LINES:
            break
        if units := UNITS_OF.search(content_start):
            unit = units[1].lower()
        sizes = next(filter(None, (form.search(content_start) for form in NPTS_AND_DT)), None)
        if sizes:
            n, dt, quoted = sizes["n"], sizes["dt"], f"`{sizes[0].strip()}`"
            if not n.isdecimal() or int(n) < 1:
                raise text.error(f"NPTS must be a whole number above 0, not {quoted}", line)
            if not NUMBER_PATTERN.fullmatch(dt) or not 0 < float(dt) < np.inf:
                raise text.error(f"DT must be a number above 0, not {quoted}", line)
            below = next(islice(raw_lines(text, start, line), 1, None), None)
            end = below[1] if below else len(text.text)
            return At2Header(int(n), float(dt), unit, line, end)
    raise text.error(
        f"the record is not an AT2 file: none of its first {MAX_HEADER_LINES} lines contains "
        "NPTS and DT, as in `NPTS= 4000, DT= .0050 SEC`"
    )


def _read_at2_samples(text: TextFile, header: At2Header) -> Floats:
    """Return all numbers below the header."""
    rows = _parse_rows(b" ".join(text.text[header.end :].split()), " ")
    if rows is None:
        for line, _, content in content_lines(text, header.end, header.line + 1):
            for word in re.finditer(r"\S+", content):
                if not NUMBER_PATTERN.fullmatch(word[0]):
                    cell = Cell(word[0], word.start() + 1)
                    sentence = f"row {line}: `{cell.quote}` is not a number"
                    raise text.error(sentence, line, cell)
        raise text.error("the record contains no rows of numbers")
    if rows.size != header.n:
        more = "fewer: the file is truncated" if rows.size < header.n else "more"
        sentence = f"the header says NPTS= {header.n}, but there are {rows.size} samples"
        raise text.error(f"{sentence}, {more}", header.line)
    return rows.ravel()


AT2 = Format(
    "an AT2",
    at2_columns,
    {
        **NOT_TEXT,
        "column": ONE_SERIES,
        "channel": ONE_SERIES,
        "full_scale": NO_FULL_SCALE,
        **KNOWN_STEP,
    },
)
