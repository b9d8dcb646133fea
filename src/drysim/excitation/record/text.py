"""Text: columns of numbers, as spreadsheets and most programs write them."""

from __future__ import annotations

import re
from itertools import islice

from drysim.excitation.record.file import File, TextFile, fault
from drysim.excitation.record.format import NO_CHANNEL, NO_FULL_SCALE, Format
from drysim.excitation.record.lines import rows
from drysim.excitation.record.table import Table, tabulate

MARK = b"\xef\xbb\xbf"
"""The byte order mark, which some programs write before UTF-8."""

SEPARATOR = re.compile(rb'"?sep=.?"?\s*', re.IGNORECASE)
"""The row by which files tell Excel their delimiter; it is found in the numbers themselves."""


def plain(file: File) -> TextFile:
    """Give the text of a file below the rows that do not count; it is still to be read.

    Raises
    ------
    RecordError
        When it is binary, text in UTF-16, or has no more rows than do not count.
    """
    head = file.reader[: len(MARK)]
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise fault(file.shown, "the record is UTF-16 text; save it as UTF-8")
    if file.reader.find(b"\0") >= 0:
        raise fault(
            file.shown, "the record is binary: it holds a zero byte, which text never does"
        )
    text = TextFile(file.shown, file.reader, len(MARK) if head == MARK else 0)
    first = next((part for _, _, part in rows(text)), b"")
    skip = file.skip or int(SEPARATOR.fullmatch(first) is not None)
    below = next(islice(rows(text), skip, None), None)
    if below is None and file.skip:
        raise fault(
            file.shown, f"`skip` passes over {file.skip} rows, and the file has no more"
        )
    return text._replace(line=below[0], begin=below[1]) if below else text


def columns(file: File) -> Table:
    """Give the columns of a text file."""
    return tabulate(plain(file))


FORMAT = Format(
    "a text file",
    columns,
    {"channel": NO_CHANNEL, "full_scale": NO_FULL_SCALE},
)
