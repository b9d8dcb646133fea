"""What the rows of a text table are, and what the lines above them say.

Rows that are not samples are found by their form: statistics below the samples begin with a
word, the rows of several sensors in turn have a label that changes from row to row, and one
series that runs across the rows goes on from the end of a row to the beginning of the next.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice, pairwise
from typing import NamedTuple

import numpy as np

from drysim.errors import RecordError, WarningMessage
from drysim.records import SI
from drysim.records.clock import UNIT_BY_WORD
from drysim.records.columns import (
    Cell,
    Columns,
    Format,
    RecordFile,
    RowSelection,
    labelled_times,
    shorten_quote,
)
from drysim.records.options import Recorded
from drysim.records.text import (
    DECIMAL_MARK,
    GROUPED,
    LINES_SIZE,
    MAX_ROWS_EXAMINED,
    MISSING,
    TextTable,
    content_lines,
    end_of_rows,
    header_error,
    is_header,
    is_number,
    is_word,
    raw_lines,
    read_label,
    split_cells,
)
from drysim.units import is_common_unit
from drysim.yaml_document import dump

# Rows.


MAX_LISTED = 8
"""Labels or columns that a message lists."""

MAX_SENSORS = 32
"""Labels that may be those of sensors in turn."""

NAMES_OF_SENSORS = re.compile(
    r"(?i)(sensor|channel|chan|ch|node|device|axis|kanal|id|probe)([ _.-]?(id|no|nr|name))?"
)
"""Columns in which whole numbers may be labels of sensors."""


class Labels(NamedTuple):
    """0-based column with the labels of sensors that take turns, and the labels."""

    column: int
    labels: tuple[str, ...]


def sensors_in_turn(table: TextTable) -> Labels | None:
    """Return the labels of the sensors to which the rows belong in turn; None without any."""
    rows = [cells for _, cells in islice(table.rows(), MAX_ROWS_EXAMINED)]
    if not rows or any(len(cells) != table.width for cells in rows):
        return None
    for index, label in enumerate(table.labels):
        column = [cells[index] for cells in rows]
        texts = [cell.text for cell in column]
        labels = tuple(dict.fromkeys(texts))
        changes = sum(text != before for before, text in pairwise(texts))
        are_words = not any(map(is_number, column)) and not any(map(MISSING.fullmatch, labels))
        are_numbers = all(text.isdecimal() for text in labels)
        if (
            2 <= len(labels) <= min(MAX_SENSORS, len(texts) // 2)
            and changes >= len(texts) // 2
            and (are_words or (are_numbers and NAMES_OF_SENSORS.fullmatch(label.name)))
        ):
            return Labels(index, labels)
    return None


def describe_labels(
    table: TextTable, sensors: Labels, rows: Mapping[str, object] | None = None
) -> str:
    """Return what the labels say, and the key, with others, that selects one sensor."""
    name: str | int = table.labels[sensors.column].name or sensors.column + 1
    listed = ", ".join(sensors.labels[:MAX_LISTED]) + ", …" * (len(sensors.labels) > MAX_LISTED)
    others = "".join(f"{key}: {value}, " for key, value in (rows or {}).items())
    where = f"rows: {{{others}where: {{{dump({str(name): sensors.labels[0]}).strip()}}}}}"
    return (
        f"{table.describe_column(sensors.column)} is {listed} in turn: the rows belong to "
        f"{len(sensors.labels)} sensors; `{where}` selects one"
    )


class Foot(NamedTuple):
    """Rows below the samples: 1-based lines of the first and the last one, and their words."""

    first: int
    last: int
    texts: tuple[str, ...]


def find_foot(table: TextTable) -> Foot | None:
    """Return the rows below the samples that begin with words; None without any.

    Rows at the end that begin with an empty cell, unlike those above, are none of samples, too.
    """
    end = end_of_rows(table)
    tail = table.file.text[max(table.start, end - LINES_SIZE) : end].splitlines()
    cells = [split_cells(part.decode("utf-8", "replace"), table.delimiter) for part in tail]
    first = [row[0].text if row else "" for row in cells]
    foot: list[str] = []
    for word in reversed(first):
        if word and not is_word(word):
            break
        foot.insert(0, word)
    above = first[1 : len(first) - len(foot)]  # the first line may be cut
    if not foot or not (any(foot) or all(above)) or len(foot) == len(tail):
        return None
    lines = raw_lines(table.file, table.start, table.line)
    last = max(line for line, offset, _ in lines if offset < end)
    return Foot(last - len(foot) + 1, last, tuple(filter(None, foot)))


def runs_across_rows(table: TextTable) -> bool:
    """Return whether one series runs across the rows of a table without names.

    Notes
    -----
    Then the step from the end of a row to the beginning of the next one is as small as those
    within a row, while a column holds every n-th sample only and changes by more.
    """
    if table.header_line or table.width < MIN_ACROSS:
        return False
    rows_of_cells = islice((cells for _, cells in table.rows() if cells), MAX_ROWS_EXAMINED)
    rows = [
        cells
        for cells in rows_of_cells
        if len(cells) == table.width and all(map(is_number, cells))
    ]
    if len(rows) < MIN_ACROSS:
        return False
    x = np.array([[float(cell.text.replace(",", ".")) for cell in cells] for cells in rows])
    steps = np.diff(x.ravel(), append=np.nan)[:-1]
    by_place = [
        float(np.sqrt(np.mean(steps[i :: table.width] ** 2))) for i in range(table.width)
    ]
    down = float(np.sqrt(np.mean(np.diff(x, axis=0) ** 2)))
    return max(by_place) <= MAX_STEP_ACROSS * down or (down == 0.0 and max(by_place) > 0.0)


MIN_ACROSS = 3
"""Columns and rows from which a series across rows can be recognised."""

MAX_STEP_ACROSS = 0.5
"""Largest step between neighbours, in terms of that down a column, of a series across rows."""


def describe_across(table: TextTable, count: int) -> str:
    """Return that `count` samples run across the rows, and how to write one in each row."""
    skip = f", skiprows={table.line - 1}" if table.line > 1 else ""
    mark = f", delimiter={table.delimiter!r}" if table.delimiter else ""
    return (
        f"the rows look like one series of {count} samples, {table.width} in each; write one "
        f"sample per row, in Python: `numpy.savetxt('column.csv', "
        f"numpy.loadtxt(file{skip}{mark}).ravel())`"
    )


def row_warnings(record: Recorded, columns: Columns) -> Iterator[WarningMessage]:
    """Warn of rows that belong to several sensors, or hold one series together."""
    if not isinstance(columns, TextTable):
        return
    sentence = ""
    if not (record.rows and record.rows.where) and (sensors := sensors_in_turn(columns)):
        sentence = describe_labels(columns, sensors)
    elif runs_across_rows(columns):
        samples = sum(len(cells) for _, cells in columns.rows())
        sentence = describe_across(columns, samples)
    if sentence:
        yield WarningMessage("record-rows", f"{record.named}: {sentence}", {})


def find_rows(file: RecordFile, member: Format) -> tuple[RecordFile, Columns]:
    """Return a file with the rows skipped above the header, and its columns.

    Raises
    ------
    RecordError
        If no rows of numbers follow, or the file cannot be read for another reason.
    """
    attempts = list[RecordFile]()
    try:
        columns = member.columns(file)
        fault = _fault_of_rows(columns)
        if fault is None:
            return file, columns
        is_first = isinstance(columns, TextTable) and fault.problem.line <= columns.line
    except RecordError as error:
        fault, is_first = error, True
    if "skip" not in member.unused_keys:
        first = fault.problem.line + 1  # a row of words below a header
        attempts = [replace(file, rows=RowSelection(first))] * (is_first and first > 2)
        attempts += [replace(file, skip=skip) for skip in range(1, MAX_ROWS_EXAMINED)]
    for attempt in attempts:
        try:
            columns = member.columns(attempt)
        except RecordError:
            continue
        if _fault_of_rows(columns) is None and not (attempt.rows.start and _is_title(columns)):
            if attempt.skip and isinstance(columns, TextTable):  # empty rows, too
                if not columns.header_line and skips_samples(columns):
                    continue
                if not columns.header_line and (headed := _below_damage(file, member, columns)):
                    return headed
                attempt = replace(attempt, skip=(columns.header_line or columns.line) - 1)
            return attempt, columns
    raise fault


def _below_damage(
    file: RecordFile, member: Format, table: TextTable
) -> tuple[RecordFile, Columns] | None:
    """Return the file and columns of a table whose header is above a damaged row; or None."""
    header_line = table.line - 2
    attempt = replace(file, skip=max(header_line - 1, 0), rows=RowSelection(table.line))
    try:
        columns = member.columns(attempt)
    except RecordError:
        return None
    is_headed = isinstance(columns, TextTable) and columns.header_line == header_line > 0
    is_whole = all(label.text for label in columns.labels)
    return (attempt, columns) if is_headed and is_whole else None


def skips_samples(table: TextTable) -> bool:
    """Return whether a row above a table has a number in each of its columns."""
    top = table.file._replace(begin=0, line=1)
    above = islice(content_lines(top), (table.header_line or table.line) - 1)
    rows = (split_cells(text, table.delimiter) for _, _, text in above)
    return any(len(cells) == table.width and all(map(is_number, cells)) for cells in rows)


MAX_TORN = 0.1
"""Share of the rows examined that may be damaged in a table of samples."""

MIN_SAMPLES_ABOVE = 5
"""Samples above a row of words from which it is damage, or a repeated header. A row of words
below fewer rows of numbers is the header, unless a row above names units or times."""


def _fault_of_rows(columns: Columns) -> RecordError | None:
    """Return the error of a text table whose first rows are not samples, but for a few."""
    if not isinstance(columns, TextTable):
        return None
    foot = find_foot(columns)
    samples = ((line, x) for line, x in columns.rows() if not foot or line < foot.first)
    rows = [cells for _, cells in islice(samples, MAX_ROWS_EXAMINED) if cells]
    whole = [cells for cells in rows if len(cells) == columns.width]
    numeric = [
        index
        for index in range(columns.width)
        if 2 * sum(cells[index].text != "" and _may_be_number(cells[index]) for cells in whole)
        > len(whole)
    ]
    if not numeric:
        return columns.error("there are no rows of numbers")
    is_sample = [
        len(cells) == columns.width and all(_may_be_number(cells[index]) for index in numeric)
        for cells in rows
    ]
    units = any(label.unit for label in columns.labels)
    is_labelled = units or labelled_times(columns) is not None
    if (
        is_sample[0]
        and any(is_sample[-3:])
        and is_sample.count(False) <= MAX_TORN * len(rows)
        and (is_labelled or not any(map(_has_words, rows[:MIN_SAMPLES_ABOVE])))
    ):
        return None
    try:
        columns.numbers(numeric)
    except RecordError as error:
        return error
    return columns.error("there are no rows of numbers")


def _has_words(cells: Sequence[Cell]) -> bool:
    """Return whether a row has words and no numbers."""
    return is_header(cells) and not all(map(_may_be_number, cells))


def _may_be_number(cell: Cell) -> bool:
    """Return whether a cell contains a number, or stands for a missing one."""
    return is_number(cell) or MISSING.fullmatch(cell.text) is not None


def _is_title(columns: Columns) -> bool:
    """Whether the header is one cell of several, as a title filled up with delimiters is."""
    return columns.width > 1 and sum(label.text != "" for label in columns.labels) == 1


def lower_header_error(
    fault: RecordError, file: RecordFile, member: Format, skip: int
) -> RecordError | None:
    """Return the error that the header stands below the rows skipped; None if it does not.

    A fault among the samples has another cause. A row of words below samples is no header.
    """
    if fault.problem.line > MAX_ROWS_EXAMINED:
        return None
    try:
        readable, columns = find_rows(file, member)
    except RecordError:
        return None
    if not (isinstance(columns, TextTable) and columns.header_line and readable.skip > skip):
        return None
    top = columns.file._replace(begin=0, line=1)
    above = [
        split_cells(text, columns.delimiter)
        for line, _, text in islice(content_lines(top), columns.header_line)
        if line < columns.header_line
    ]
    below = above[1:]  # the header taken, or numbers such as a serial number
    if any(len(cells) == columns.width and all(map(is_number, cells)) for cells in below):
        return None
    return header_error(top, columns.header_line, skip + 1)


# The lines above the rows.


MAX_PREAMBLE_LINE = 500
"""Characters of a line above the rows that are searched."""

UNIT = r"(?:[kM]?Hz|[kM]?S/s|sps|[mµu]?s|m?sec)"

ASSIGNMENT = re.compile(
    rf"\W*(?P<key>[^\W\d][\w .,/-]*?)\s*(?:[(\[](?P<unit_of_key>{UNIT})[)\]])?\s*[:=\t;, ]\s*"
    rf"(?P<number>[+-]?\d+(?:[.,]\d+)*(?:[eE][+-]?\d+)?)\s*(?P<unit>{UNIT})?\s*\W*"
)
"""A line such as `Sampling rate: 100 Hz` or `SAMPLING_INTERVAL_S: 0.005`."""

KEYS_OF_RATE = re.compile(
    r"(?i).*(sampl|acqui|scan|abtast|data|logg|mess).*(rate|freq).*|fs|sps"
)
KEYS_OF_STEP = re.compile(
    r"(?i).*(sampl|acqui|scan|abtast|logg).*(interval|period|step|time|zeit).*|dt"
    r"|delta ?[xt]|time ?step|zeitschritt"
)
SENSITIVITY = re.compile(
    r"(?i)(?=.*\bmV\b(?!\s*(?:/|per)))"
    r".*?(?P<number>\d+(?:[.,]\d+)?)\s*mV\s*(?:/|per)\s*(?P<unit>g|\(?m/s(?:2|\^2|²)\)?)\W*"
)
"""The end of a line such as `unit mV, 100 mV/g`; without `unit mV` the samples may be in g."""

KEY_OF_UNIT = re.compile(r"(?i)\W*(?:units?|einheit(?:en)?)\W+(?P<unit>[^\s,;]+)\s*")


class Statement(NamedTuple):
    """A value that a line above the rows states, and the line as messages quote it.

    The value is empty where the line leaves it open.
    """

    value: str
    reason: str


def read_preamble(table: TextTable) -> dict[str, Statement]:
    """Return what the lines above the rows say: `rate` or `step`, `unit`, and units of columns.

    The value of `units` are those of all columns, separated by tabs; `sensitivity` is in mV per
    its unit, separated by a tab. A line may state several values between commas.
    """
    statements: dict[str, Statement] = {}
    decimal = table.decimal(table.series())
    above = raw_lines(table.file._replace(begin=0, line=1))
    for line, _, part in islice(above, min(table.line - 1, MAX_ROWS_EXAMINED)):
        text = part.decode("utf-8", "replace")[:MAX_PREAMBLE_LINE].strip()
        parts = [text, *re.split(r"[,;]\s+", text)[: 2 * MAX_LISTED]]
        parsed = (_parse_preamble_line(each, decimal) for each in parts)
        stated = [each for each in parsed if each[0]]
        cells = split_cells(text.lstrip("%#/ "), table.delimiter or ",")
        units = [read_label(cell.text).unit for cell in cells]
        if (
            not stated
            and line != table.header_line
            and len(units) == table.width > 1
            and all(units)
        ):
            stated = [("units", "\t".join(units), "")]
        for key, value, doubt in stated:
            statements[key] = Statement(value, f"row {line}: `{shorten_quote(text)}`{doubt}")
    return statements


def _parse_preamble_line(text: str, decimal: str) -> tuple[str, str, str]:
    """Return the key of a record that a line states, its value, and what is doubtful about it.

    All are empty for other lines; `decimal` is the decimal mark of the rows.
    """
    if named := KEY_OF_UNIT.fullmatch(text):
        unit = named["unit"]
        is_known = any(is_common_unit(unit, si) for si in SI.values())
        return ("unit", unit, "") if is_known else ("", "", "")
    if sensitivity := SENSITIVITY.fullmatch(text):
        values = _numbers_in(sensitivity["number"], decimal)
        unit = sensitivity["unit"].strip("()")
        if len(values) == 1 and values[0] > 0:
            return "sensitivity", f"{values[0]:.12g}\t{unit}", ""
    assignment = ASSIGNMENT.fullmatch(text)
    if assignment is None:
        return "", "", ""
    key_words = re.split(r"[\s_.]+", assignment["key"].strip())
    unit = (
        assignment["unit_of_key"]
        or assignment["unit"]
        or UNIT_BY_WORD.get(key_words[-1].lower(), "")
    )
    name = " ".join(key_words)
    key = "rate" if KEYS_OF_RATE.fullmatch(name) else ""
    key = key or ("step" if KEYS_OF_STEP.fullmatch(name) else "")
    numbers = [x for x in _numbers_in(assignment["number"], decimal) if x > 0]
    if not key or not numbers:
        return "", "", ""
    if len(numbers) > 1:
        return key, "", f": {numbers[0]:.12g} or {numbers[1]:.12g}?"
    if not unit and key == "step":
        return key, "", ", without a unit"
    doubt = "" if unit else ", without a unit: taken as Hz"
    unit = unit.replace("S/s", "Hz").replace("sps", "Hz") or "Hz"
    return key, f"{numbers[0]:.12g} {unit}", doubt


def _numbers_in(text: str, decimal: str) -> tuple[float, ...]:
    """Return the number that a text stands for, or two where its mark is ambiguous.

    A comma before three digits may be a decimal comma or stand between thousands, and so may a
    point if the rows have decimal commas.
    """
    marks = DECIMAL_MARK.findall(text)
    if GROUPED.fullmatch(text) and "," in (marks[0], decimal):
        return tuple(float(DECIMAL_MARK.sub(mark, text)) for mark in (".", ""))
    if len(marks) > 1:
        groups = marks[:-1] if marks[-1] != marks[0] else marks
        digits = re.split("[.,]", text)[1 : len(groups) + 1]
        if len(set(groups)) > 1 or any(len(group) != 3 for group in digits):
            return ()
        text = text.replace(groups[0], "")
    return (float(text.replace(",", ".")),)
