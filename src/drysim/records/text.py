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
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from functools import partial
from io import StringIO
from itertools import islice, pairwise
from typing import NamedTuple

import numpy as np

from drysim.core.model import Signal
from drysim.errors import RecordError
from drysim.records import SI
from drysim.records.columns import (
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
    Floats,
    Format,
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
    for number, at, part in raw_lines(file, start, line):
        words = _decode_line(part)
        if not words.lstrip().startswith("#"):
            yield number, at, words


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
        words = quote[1].removesuffix("…")
        if any(words in line for line in secret) or words in whole:
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
    cells, at, parts, quotes = [], 0, list[str](), 0
    for part in text.split(delimiter):
        parts.append(part)
        quotes += part.count('"')
        if quotes % 2 == 0:
            whole, parts = delimiter.join(parts), []
            cells.append(_make_cell(whole, at))
            at += len(whole) + 1
    return [*cells, _make_cell(delimiter.join(parts), at)] if parts else cells


def _make_cell(part: str, at: int) -> Cell:
    stripped = part.strip()
    quoted = len(stripped) > 1 and stripped[0] == stripped[-1] == '"'
    text = stripped[1:-1].replace('""', '"').strip() if quoted else stripped
    return Cell(text, at + part.find(stripped) + 1 + quoted)


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
    words = (cell.text.strip("[]()") for cell in cells)
    return any(is_common_unit(word, si) for word in words for si in ("s", *SI.values()))


def find_header(file: TextFile) -> int:
    """Return the 1-based line of the first row with as many names as numbers below it.

    Returns 0 if there is none above the first two rows with equally many numbers.
    """
    content = islice((row for row in content_lines(file) if row[2].strip()), MAX_ROWS_EXAMINED)
    first = [(line, text) for line, _, text in content]
    top = first[0][0] if first else 0
    for at, ((line, text), (_, below)) in enumerate(pairwise(first)):
        mark = find_delimiter_below(text, below)
        row = split_cells(below, mark)
        head = header_cells(text, mark, len(row))
        if at + 2 < len(first) and is_unit_row(row, head):
            below = first[at + 2][1]
            mark = find_delimiter_below(text, below)
            row = split_cells(below, mark)
        if len(row) == len(head) and all(map(is_number, row)):
            if is_header(head):
                # If the top row is a header, words between it and the numbers are an error.
                cells = header_cells(first[0][1], mark, len(row))
                return top if len(cells) == len(row) > 1 and is_header(cells) else line
            if all(map(is_number, head)):
                return 0
    return 0


def is_number(cell: Cell) -> bool:
    """Return whether a cell contains a number, with a decimal point or comma."""
    return NUMBER_PATTERN.fullmatch(cell.text.replace(",", ".", 1)) is not None


# The table.


DECIMAL_MARK = re.compile("[.,]")
"""Decimal point or comma."""


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

    def rows(self) -> Iterator[tuple[int, list[Cell]]]:
        """Yield line and cells of every row of numbers, without comments and trailing blanks.

        An empty row has no cells.
        """
        blank: list[int] = []
        for line, _, text in content_lines(self.file, self.start, self.line):
            if not text.strip():
                blank.append(line)
                continue
            for empty in blank:
                yield empty, []
            blank.clear()
            yield line, split_cells(text, self.delimiter)

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
        decimal = self.decimal(wanted)
        found = _read_fast(self, wanted, decimal)
        if found is None:
            found = _read_by_cell(self, wanted, decimal, gap_column)
        return list[Signal](found)

    def printed_resolution(self, index: int) -> float:
        """Return the unit of the last digit with which the first rows are printed."""
        exponents = []
        for _, cells in islice(filter(lambda row: row[1], self.rows()), MAX_ROWS_EXAMINED):
            exponent = Decimal(cells[index].text.replace(",", ".")).as_tuple().exponent
            exponents.append(int(exponent))
        return float(10.0 ** min(*exponents, 0))

    def at(self, row: int, index: int, sentence: str) -> RecordError:
        """Return the error at a cell in the 0-based row of numbers."""
        line, cells = next(islice(self.rows(), row, None))
        where = f"row {line}, {self.describe_column(index)}"
        return self.file.error(f"{where}: {sentence}", line, cells[index] if cells else None)

    def ragged(self, line: int, cells: int) -> RecordError:
        """Return the error for a row with a wrong number of cells."""
        for number, _, text in content_lines(self.file, self.start, self.line):
            if number in (self.line, line):
                check_quotes(self.file, number, text)
            if number == line:
                break
        sentence = f"row {line} has {format_count(cells, 'cell')}, not {self.width}"
        return self.file.error(sentence, line)

    def error(self, sentence: str, index: int | None = None) -> RecordError:
        """Return the error for the header, or for the header cell of one column."""
        cell = self.header[index] if index is not None and self.header else None
        return self.file.error(sentence, self.header_line or self.line, cell)

    @property
    def skip_hint(self) -> str:
        """How to skip the header."""
        skip = f"`skip: {self.line - 1}` skips the header"
        return f"; {skip}; then select columns by number"

    def lower_header_hint(self, wanted: str) -> str:
        """Return how to skip rows above a header that has this name; empty if there is none."""
        for line, _, text in islice(content_lines(self.file), MAX_ROWS_EXAMINED):
            names = [cell.text.strip() for cell in split_cells(text, self.delimiter)]
            if line > self.header_line and len(names) > 1 and wanted.strip() in names:
                return f"; row {line} has this name: `skip: {line - 1}` skips the rows above it"
        return ""

    def series(self) -> list[int]:
        """Return the 0-based columns that may contain samples; unnamed ones do not."""
        named = [i for i, label in enumerate(self.labels) if label.text]
        return named or super().series()


def check_quotes(file: TextFile, line: int, text: str) -> None:
    """Raise for a row with an open quotation mark, behind which delimiters do not count."""
    if text.count('"') % 2:
        at = text.rfind('"')
        cell = Cell(text[at:], at + 1)
        sentence = f"row {line} has a quotation mark that is not closed: `{cell.quote}`"
        raise file.error(sentence, line, cell)


def detect_table(file: TextFile) -> TextTable:
    """Detect header, delimiter and columns of a text file.

    Raises
    ------
    RecordError
        If header and rows do not fit together, or there are no rows of numbers.
    """
    check_width(file)
    content = ((n, at, text) for n, at, text in content_lines(file) if text.strip())
    line, start, text = next(content, (0, 0, ""))
    if (likely := find_header(file)) > line:
        hint = f"`skip: {likely - 1}` skips the rows above it"
        raise file.error(f"row {likely} looks like the header, not row {line}: {hint}", likely)
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
    if not line:
        raise file.error("the record contains no rows of numbers", header_line)
    delimiter = find_delimiter_below(header_text, text)
    if not header_line and delimiter == "," and has_decimal_commas(file):
        delimiter = ""
    cells = split_cells(text, delimiter)
    width = len(cells)
    if header_line and is_header(cells):  # prose, not a header
        cell = next(cell for cell in cells if cell.text)
        raise file.error(f"row {line}: `{cell.quote}` is not a number", line, cell)
    header = header_cells(header_text, delimiter, width) if header_line else []
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

COMMENT_LINE = re.compile(rb"(?m)^[ \t]*#.*\n?")

MISSING = re.compile(r"(?i)|[+-]?nan|na|n/a|null")
"""Contents of a cell without a number."""

MISSING_TIME_HINT = "a missing time is not filled: delete the row, or set `rate` instead"
"""Hint for a row without a time; its sample becomes a gap, or is taken as evenly spaced."""

EMPTY_ROW_HINT = "the record has a gap; delete the row: the times show the gap"
"""Hint for an empty row of a table with times."""

TIME_OF_DAY = re.compile(
    r"(?:\d[-\d./]*[T ])?\d{1,2}:\d\d(?::\d\d(?:[.,]\d*)?)?[Z+\-:\d ]*", re.ASCII
)
"""A time of day, with or without date."""


def _read_fast(table: TextTable, wanted: list[int], decimal: str) -> list[Floats] | None:
    """Return columns of a table; None unless all rows are regular and all numbers finite."""
    text, at, last = table.file.text, table.start, end_of_rows(table)
    found = [array("d") for _ in wanted]
    while at < last:
        end = min(text.find(b"\n", min(at + PARSE_SIZE, last)) + 1 or last, last)
        rows = _parse_block(text[at:end], table, decimal)
        if rows is None or not np.isfinite(rows[:, wanted]).all():
            return None
        if not found[0]:  # estimate the size of all rows from the first ones
            count = len(rows) * (last - at) / (end - at)
            require_memory(table.display_path, count * FLOAT64_SIZE * len(found))
        for index, column in zip(wanted, found, strict=True):
            column.frombytes(rows[:, index].tobytes())
        at = end
    return [np.frombuffer(column) for column in found]


def end_of_rows(table: TextTable) -> int:
    """Return the offset where the last row ends, before trailing line endings."""
    text, end = table.file.text, len(table.file.text)
    while end > table.start:
        tail = text[max(table.start, end - PARSE_SIZE) : end]
        if kept := len(tail.rstrip(b"\r\n")):
            return end - len(tail) + kept
        end -= len(tail)
    return end


def _parse_block(block: bytes, table: TextTable, decimal: str) -> Floats | None:
    """Parse whole lines to numbers, shape (rows, columns); None unless all are regular."""
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
    rows = _parse_rows(block, table.delimiter)
    lines = block.count(b"\n") + 1  # more than there are rows if one is blank
    return rows if rows is not None and rows.shape == (lines, table.width) else None


def _parse_rows(text: bytes, delimiter: str) -> Floats | None:
    """Parse lines of equally many numbers; None if the text contains anything else."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # text that is blank
            lines = StringIO(text.decode("ascii"))
            return np.loadtxt(lines, delimiter=delimiter or None, comments=None, ndmin=2)
    except ValueError:
        return None


def _read_by_cell(
    table: TextTable, wanted: list[int], decimal: str, gap_column: int | None = None
) -> list[Floats]:
    """Return columns of a table, parsed cell by cell; raise at the first fault."""
    found = [array("d") for _ in wanted]
    for line, cells in table.rows():
        if not cells and wanted == [gap_column]:
            found[0].append(math.nan)
            continue
        if not cells:
            hint = EMPTY_ROW_HINT if len(wanted) > 1 else GAP_HINT
            raise table.file.error(f"row {line} is empty: {hint}", line)
        if len(cells) != table.width:
            raise table.ragged(line, len(cells))
        for index, column in zip(wanted, found, strict=True):
            lost = index == gap_column and MISSING.fullmatch(cells[index].text) is not None
            value = math.nan if lost else _parse_cell(cells[index], decimal)
            if not (lost or math.isfinite(value)):
                where = f"row {line}, {table.describe_column(index)}"
                hint = GAP_HINT if index == wanted[-1] else MISSING_TIME_HINT
                sentence = f"{where}: {_describe_fault(cells[index], decimal, hint)}"
                raise table.file.error(sentence, line, cells[index])
            column.append(value)
    return [np.array(column) for column in found]


def _parse_cell(cell: Cell, decimal: str) -> float:
    """Return the number in a cell with a given decimal mark; NaN for none."""
    text = cell.text
    if decimal == ",":
        text = text.replace(".", "?").replace(",", ".", 1)
    return float(text) if NUMBER_PATTERN.fullmatch(text) else math.nan


def _describe_fault(cell: Cell, decimal: str, hint: str) -> str:
    """Return what a cell contains instead of a number, and a remedy."""
    text = cell.text
    if not text:
        return f"the cell is empty: {hint}"
    if MISSING.fullmatch(text):
        return f"`{cell.quote}` is not a finite number: {hint}"
    if decimal == "," and "." in text and NUMBER_PATTERN.fullmatch(text):
        return f"`{cell.quote}` has a decimal point; write commas throughout"
    if text.lower().lstrip("+-") in ("inf", "infinity") or NUMBER_PATTERN.fullmatch(text):
        return f"`{cell.quote}` is not a finite number: {INFINITE_HINT}"
    if is_number(cell) and decimal == ".":
        return f"`{cell.quote}` has a decimal comma; write points throughout"
    if TIME_OF_DAY.fullmatch(text):
        instead = "set `rate` or `step` instead of `time`"
        return f"`{cell.quote}` is a time of day, which is not supported; {instead}"
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
    return text._replace(line=below[0], begin=below[1]) if below else text


def text_columns(file: RecordFile) -> TextTable:
    """Return the columns of a text file."""
    return detect_table(open_text(file))


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
        words = content[:MAX_HEADER_LINE_LENGTH]
        if line > MAX_HEADER_LINES:
            break
        if found := UNITS_OF.search(words):
            unit = found[1].lower()
        sizes = next(filter(None, (form.search(words) for form in NPTS_AND_DT)), None)
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
        "skip": NOT_TEXT,
        "column": ONE_SERIES,
        "channel": ONE_SERIES,
        "full_scale": NO_FULL_SCALE,
        **KNOWN_STEP,
    },
)
