"""Text: columns of numbers, as spreadsheets and most programs write them."""

from __future__ import annotations

from drysim.excitation.record.file import File, TextFile, fault
from drysim.excitation.record.format import NO_CHANNEL, NO_FULL_SCALE, Format
from drysim.excitation.record.table import Table, tabulate


def plain(file: File) -> TextFile:
    """Give the text of a file.

    Raises
    ------
    RecordError
        When it is binary, or text in another encoding.
    """
    raw = file.raw
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise fault(file.shown, "the record is UTF-16 text; save it as UTF-8")
    if b"\0" in raw:
        raise fault(
            file.shown, "the record is binary: it holds a zero byte, which text never does"
        )
    text = raw.removeprefix(b"\xef\xbb\xbf")
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return TextFile(file.shown, text)


def columns(file: File) -> Table:
    """Give the columns of a text file."""
    return tabulate(plain(file))


TEXT = Format(
    "a text file",
    (".csv", ".tsv", ".txt", ".dat"),
    columns,
    {"channel": NO_CHANNEL, "full_scale": NO_FULL_SCALE},
)
