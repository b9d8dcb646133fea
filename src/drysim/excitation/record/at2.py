"""AT2: accelerograms of the PEER ground motion database; text behind a header of four lines."""

from __future__ import annotations

import re
import warnings
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.errors import RecordError
from drysim.excitation.record.channels import Channel, Channels, channels
from drysim.excitation.record.columns import Label
from drysim.excitation.record.file import Cell, File, TextFile, fault, fit
from drysim.excitation.record.format import (
    NO_FULL_SCALE,
    NO_TABLE,
    ONE_SERIES,
    OWN_STEP,
    Format,
)
from drysim.excitation.record.lines import behind, lines
from drysim.excitation.record.text import plain
from drysim.quantity import NUMBER

HEADER = 10
"""Lines among which the header ends; it has four, or a remark more."""

LONGEST = 500
"""Characters of a line of the header."""

SIZE = r"[\d.e+-]{1,20}(?![\d.e+-])"
"""A number of the header as it is written, whole or not."""

SIZES = (
    re.compile(rf"(?i)\bNPTS\s*=\s*(?P<n>{SIZE}).{{0,20}}?\bDT\s*=\s*(?P<dt>{SIZE})"),
    re.compile(rf"(?i)(?<!\S)(?P<n>{SIZE})\s+(?P<dt>{SIZE})\s+NPTS\b.*\bDT\b"),
)
"""`NPTS= 4000, DT= .0050 SEC` of today, `4000 0.0050 NPTS, DT` of the older files."""

UNITS = re.compile(r"(?i)\bUNITS? OF ([a-z/*^0-9]{1,20})")


class Header(NamedTuple):
    """What the header tells: samples, their step [s] and unit, and where it ends."""

    n: int
    dt: float
    unit: str
    line: int
    end: int


def columns(file: File) -> Channels:
    """Give the one series of an AT2 file.

    Raises
    ------
    RecordError
        When its header does not say NPTS and DT, or the samples are not as many.
    """
    fit(file.shown, len(file.reader))
    text = plain(file)
    header = _header(text)
    label = Label("", "", header.unit)
    series = Channel(label, partial(_values, text, header), header.dt)
    return channels(file, [series], word="series")


def _header(text: TextFile) -> Header:
    unit = ""
    for line, start, content in lines(text):
        words = content[:LONGEST]
        if line > HEADER:
            break
        if found := UNITS.search(words):
            unit = found[1].lower()
        sizes = next(filter(None, (form.search(words) for form in SIZES)), None)
        if sizes:
            n, dt = sizes["n"], sizes["dt"]
            if not n.isdecimal() or int(n) < 1:
                raise _at(text, line, "NPTS must be a whole number above 0", sizes[0])
            if not NUMBER.fullmatch(dt) or not 0 < float(dt) < np.inf:
                raise _at(text, line, "DT must be a number above 0", sizes[0])
            return Header(int(n), float(dt), unit, line, behind(text, start))
    raise fault(
        text.shown,
        f"the record is no AT2: none of its first {HEADER} lines says NPTS and DT, as in "
        "`NPTS= 4000, DT= .0050 SEC`",
    )


def _values(text: TextFile, header: Header) -> NDArray[np.float64]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", DeprecationWarning)  # what numpy 1 says, 2 raises
            values = np.fromstring(text.text[header.end :], sep=" ")
    except (ValueError, DeprecationWarning):
        raise _not_a_number(text, header) from None
    if len(values) != header.n:
        more = "less: it is cut short" if len(values) < header.n else "more"
        sentence = f"the header says NPTS= {header.n}, but there are {len(values)} samples"
        raise _at(text, header.line, f"{sentence}, {more}")
    return values


def _not_a_number(text: TextFile, header: Header) -> RecordError:
    for line, _, content in lines(text, header.end, header.line + 1):
        for word in re.finditer(r"\S+", content):
            if not NUMBER.fullmatch(word[0]):
                cell = Cell(word[0], word.start() + 1)
                sentence = f"row {line}: `{cell.quote}` is not a number"
                return fault(text.shown, sentence, line, cell)
    return fault(text.shown, "the record holds no rows of numbers")


def _at(text: TextFile, line: int, sentence: str, quoted: str = "") -> RecordError:
    return fault(text.shown, sentence + (f", not `{quoted.strip()}`" if quoted else ""), line)


FORMAT = Format(
    "an AT2",
    columns,
    {
        "skip": NO_TABLE,
        "column": ONE_SERIES,
        "channel": ONE_SERIES,
        "time": OWN_STEP,
        "rate": OWN_STEP,
        "step": OWN_STEP,
        "full_scale": NO_FULL_SCALE,
    },
)
