"""The file behind a record: read once, hashed as read, and faults that point into it.

Only a regular file of a known suffix that memory has room for is read. Its bytes are not kept:
a `Reader` gives slices of them and refuses every access once the file was written to, cut or
replaced, so that what is computed belongs to the hash that is told.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim import system
from drysim.core.model import KEPT, Signal, blocks
from drysim.errors import Problem, RecordError
from drysim.records import SI
from drysim.units import convert, factor, meant, near, shown, usual

WINDOW = 1 << 20
"""Bytes read at a time: small beside the numbers, large beside the cost of a call."""

LEAST = 0.25
"""Bytes held for a byte of any file, at least: a number of 8 for 32 characters."""

LONGEST_QUOTE = 40
"""Characters of a cell that a message may quote, so that no message retells a file."""

LOOKED_AT = 1000
"""Files of a folder among which a near name is looked for."""


@dataclass(frozen=True, eq=False)
class Reader:
    """The bytes of a file, as slices; the latest part that was read is kept.

    Raises
    ------
    RecordError
        By every access, when the file was written to, cut or replaced in the meantime.
    """

    path: Path
    size: int
    stamp: system.Stamp
    latest: dict[int, bytes] = field(default_factory=dict)

    def __len__(self) -> int:
        """Give how many there are."""
        return self.size

    def __getitem__(self, part: slice) -> bytes:
        """Give some neighbouring bytes."""
        first, last, _ = part.indices(self.size)
        for at, kept in self.latest.items():
            if at <= first and last <= at + len(kept):
                return kept[first - at : last - at]
        if last - first > WINDOW:
            return self._read(first, last - first)
        self.latest.clear()
        kept = self._read(first, WINDOW)
        self.latest[first] = kept
        return kept[: max(last - first, 0)]

    def find(self, wanted: bytes, first: int = 0) -> int:
        """Give where one byte stands from a place on, -1 for nowhere."""
        for at in range(first, self.size, WINDOW // 4):
            found = self[at : at + WINDOW // 4].find(wanted)
            if found >= 0:
                return at + found
        return -1

    def _read(self, at: int, count: int) -> bytes:
        try:
            with system.opened(self.path) as stream:
                stream.seek(at)
                found, stamp = stream.read(count), system.stamp_of(stream.fileno())
        except (OSError, system.Irregular):
            raise changed(self.path) from None
        if stamp != self.stamp:
            raise changed(self.path)
        return found


class Cell(NamedTuple):
    """Text between two delimiters, and the 1-based column of its first character."""

    text: str
    column: int

    @property
    def quote(self) -> str:
        """The text as messages quote it, shortened."""
        text = printable(self.text)
        return text if len(text) <= LONGEST_QUOTE else text[: LONGEST_QUOTE - 1] + "…"


def printable(text: str) -> str:
    """Return a text with a question mark for each character that has no glyph."""
    return "".join(c if c.isprintable() else "?" for c in text)


@dataclass(frozen=True, eq=False)
class File:
    """A record as it was read first: its SHA-256; `shown` is the path as messages name it.

    `skip` is the number of rows at its top that do not count.
    """

    shown: str
    path: Path
    reader: Reader
    sha256: str
    skip: int = 0

    @cached_property
    def raw(self) -> bytes:
        """All bytes at once, where memory has room for them and what is made of them."""
        fit(self.shown, len(self.reader))
        return self.reader[:]


class TextFile(NamedTuple):
    """Text of a record, which begins at an offset: the one of a line counted from 1."""

    shown: str
    text: Reader | bytes
    begin: int = 0
    line: int = 1


def read(path: Path, suffixes: Collection[str]) -> File:
    """Read the file of a record once, if its suffix is one of those that are read.

    Raises
    ------
    RecordError
        When the file is missing, empty, not a regular file, of a kind that is not read, or
        larger than the machine's memory allows.
    """
    try:
        size = _size(path, suffixes)
        room(str(path), size * LEAST)
        reader, sha256, filled = examine(path)
    except system.Irregular as other:
        raise fault(str(path), f"the record is {other}; only a regular file is read") from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise fault(str(path), f"the record cannot be read: {why}") from None
    if not size or not filled:
        raise fault(str(path), "the record is empty")
    if size != len(reader):
        raise changed(path)
    return File(str(path), path, reader, sha256)


def _size(path: Path, suffixes: Collection[str]) -> int:
    """Give the size of a record; a file below /proc, which claims to have none, has none."""
    try:
        size = system.size(path)
    except FileNotFoundError:
        raise fault(str(path), f"the record is not there{_neighbour(path, suffixes)}") from None
    if path.suffix.lower() not in suffixes:
        kinds = ", ".join(suffixes)
        suffix = f"from `{path.suffix}`" if path.suffix else "without a suffix"
        raise fault(str(path), f"a record {suffix} cannot be read; what is read: {kinds}")
    return size


def _neighbour(path: Path, suffixes: Collection[str]) -> str:
    if not path.parent.is_dir():
        return f": there is no folder `{path.parent}`"
    if path.is_symlink():
        return ": it is a link that leads nowhere"
    files = islice(path.parent.iterdir(), LOOKED_AT)
    names = (file.name for file in files if file.suffix.lower() in suffixes)
    return meant(near(path.name, names))


def examine(path: Path) -> tuple[Reader, str, bool]:
    """Read a file once; gives its reader, its SHA-256 (hex) and whether it holds anything.

    Raises
    ------
    RecordError
        When the file changes meanwhile.
    """
    digest, filled = hashlib.sha256(), False
    with system.opened(path) as stream:
        stamp = system.stamp_of(stream.fileno())
        while block := stream.read(WINDOW):
            digest.update(block)
            filled = filled or bool(block.strip())
        if system.stamp_of(stream.fileno()) != stamp:
            raise changed(path)
    return Reader(path, stamp[1], stamp), digest.hexdigest(), filled


def changed(path: Path) -> RecordError:
    """Give the error for a file that is no longer the one that was looked at first."""
    sentence = "the record changed while it was read; wait until it is whole"
    return RecordError(Problem(sentence, str(path), 0))


def fault(shown: str, sentence: str, line: int = 0, cell: Cell | None = None) -> RecordError:
    """Give the error for one fault; its source line shows the faulty cell among blanks."""
    if cell is None:
        return RecordError(Problem(sentence, shown, line))
    quote = cell.quote
    # Far to the right, a source line of blanks and one cell helps nobody.
    source = " " * (cell.column - 1) + quote if cell.column <= 100 else ""
    return RecordError(
        Problem(sentence, shown, line, cell.column, max(1, len(quote)), source=source)
    )


def fit(shown: str, size: int) -> None:
    """Make sure that a record of some bytes, packed or not, can be read into memory.

    There must be room for three: the file, what is made of its bytes, and the numbers.

    Raises
    ------
    RecordError
        When the machine has too little.
    """
    room(shown, size * 3)


def room(shown: str, need: float) -> None:
    """Make sure that the machine has so many bytes for a record; errors as in `fit`."""
    have = system.memory()
    if need > have:
        sentence = f"the record needs {need / 1e9:.3g} GB of memory"
        raise fault(shown, f"{sentence}, this machine has {have / 1e9:.3g} GB")


# What a file offers, whatever its format: columns of numbers, by name and by number.
#
# `Columns` is what every format implements, `Channels` the one of files that hold numbers and
# not text: they are loaded when asked for, finite or refused, or `Stored`, which leaves them in
# their file and reads each stretch when it is needed. `data_column`, `conversion` and `seconds`
# say which column counts and in which unit, by file and scenario together. `Format` is what the
# registry of formats holds.


Floats = NDArray[np.float64]


def gap(at_most: str = "50 ms", which: str = "short ones") -> str:
    """Say what to do about samples that are missing."""
    way = f"`gaps: {{fill: line, at_most: {at_most}}}`"
    return f"the record has a gap; {way} fills {which}"


GAP = gap()
"""What to say of a sample that is missing, where the length of the gap is not known yet."""

INFINITE = "an infinite sample is no gap that could be filled; export the record anew"
"""What to say of a sample that overflowed."""

LISTED = 12
"""How many of a file's columns a message lists."""


class Label(NamedTuple):
    """What a file says of a column: the text as written, and name and unit that it holds.

    `firm` is false where the unit may be a remark, as in `acc (filtered)`.
    """

    text: str
    name: str
    unit: str = ""
    firm: bool = True

    @property
    def quote(self) -> str:
        """The text as messages quote it, shortened."""
        return Cell(self.text, 0).quote


@dataclass(frozen=True, kw_only=True)
class Columns:
    """Columns of numbers in a file; each implementation knows where its numbers are."""

    shown: str
    """The file as messages name it."""
    labels: tuple[Label, ...]
    """What the file says of each column; empty when nothing has a name."""
    width: int
    """Number of columns."""
    word: str = "column"
    """What a column is called."""
    key: str = "column"
    """The key of a record that chooses it."""
    place: str = "header"
    """Where a unit stands: header or file."""
    shares: bool = False
    """Whether the numbers are shares of a full scale that the file does not know."""

    def numbers(self, wanted: list[int], gappy: int | None = None) -> list[Signal]:
        """Give columns as finite numbers, NaN where a sample of the `gappy` one is missing."""
        raise NotImplementedError

    def last_digit(self, index: int) -> float:
        """Give the unit of the last digit that a column's numbers are written with."""
        raise NotImplementedError

    def at(self, row: int, index: int, sentence: str) -> RecordError:
        """Give the error at a 0-based row of a column."""
        raise NotImplementedError

    def fault(self, sentence: str, index: int | None = None) -> RecordError:
        """Give the error for a fault of the whole file, or of one column."""
        raise NotImplementedError

    def clock(self, index: int) -> int | None:
        """Give the 0-based column of the times that belong to a column, where there is one."""
        return None

    def own(self, index: int) -> tuple[float, float] | None:
        """Give the step and the first time [s] that the file itself knows of a column."""
        return None

    def series(self) -> list[int]:
        """Give the 0-based columns that may be samples."""
        return list(range(self.width))

    @property
    def way_round(self) -> str:
        """How to pass over what the file says of its columns, where it can be."""
        return ""

    def called(self, index: int) -> str:
        """Give a column as messages name it."""
        name = self.labels[index].quote if self.labels else ""
        return f"{self.word} {index + 1}" + (f" (`{name}`)" if name else "")

    def names(self) -> str:
        """Give the columns there are as a list for messages."""
        if not any(label.text for label in self.labels):
            return f"{self.width}, without names" + (
                ": the file has no header" if self.place == "header" else ""
            )
        series = self.series()
        listed = ", ".join(f"`{self.labels[i].quote}`" for i in series[:LISTED])
        return listed + (f" and {len(series) - LISTED} more" if len(series) > LISTED else "")

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
            raise self.fault(
                f"there is no {self.word} {shown(wanted)}; there are: {self.names()}"
            )
        full = [label.text for label in self.labels]
        bare = [label.name for label in self.labels]
        hits = [i for i, text in enumerate(full) if text == wanted.strip()]
        hits = hits or [i for i, text in enumerate(bare) if text == wanted.strip()]
        if len(hits) == 1:
            return hits[0]
        if hits:
            numbers = " and ".join(str(i + 1) for i in hits[:LISTED])
            both = f"{self.word}s {numbers} are both {shown(wanted)}"
            raise self.fault(f"{both}; give the {self.word}'s number")
        nearest = near(wanted, filter(None, bare + full))
        guess = f" did you mean {shown(nearest)}?" if nearest else ""
        raise self.fault(
            f"there is no {self.word} {shown(wanted)};{guess} there are: {self.names()}"
        )


# Signals in memory or in their file.


@dataclass(frozen=True)
class Stored:
    """Samples in a file, from number `first` to the one before `last`, times a factor.

    `read` gives those from one number to the one before another.
    """

    read: Callable[[int, int], Floats]
    first: int
    last: int
    factor: float = 1.0

    def __len__(self) -> int:
        """Give how many there are."""
        return self.last - self.first

    def __getitem__(self, part: slice, /) -> Floats:
        """Read a stretch of them."""
        first, last, every = part.indices(len(self))
        values = self.read(self.first + first, self.first + max(first, last))
        values *= self.factor
        return values[::every]


def scaled(signal: Signal, factor: float) -> Signal:
    """Give a signal times a factor; an array is changed in place."""
    if isinstance(signal, Stored):
        return replace(signal, factor=signal.factor * factor)
    values = signal[:]
    values *= factor
    return values


def stretch(signal: Signal, first: int, last: int) -> Signal:
    """Give a signal from one number to the one before another."""
    if isinstance(signal, Stored):
        return replace(signal, first=signal.first + first, last=signal.first + last)
    return signal[first:last]


# Files that hold numbers, not text.


SIZE = 8
"""Bytes of a number in memory."""


class Channel(NamedTuple):
    """One column of a file that holds numbers, not text; they are loaded when asked for.

    `dt` and `first` are step and first time [s] where the file knows them, `clock` is the
    0-based column of its times where it has such.
    """

    label: Label
    load: Callable[[], NDArray[np.generic] | Stored]
    dt: float | None = None
    first: float = 0.0
    clock: int | None = None


@dataclass(frozen=True, kw_only=True)
class Channels(Columns):
    """Columns of a file that holds numbers, not text."""

    channels: tuple[Channel, ...]
    place: str = "file"

    def numbers(self, wanted: list[int], gappy: int | None = None) -> list[Signal]:
        """Give columns as finite numbers, NaN where a sample of the `gappy` one is missing.

        Raises
        ------
        RecordError
            When a column is no series of real numbers, a sample is none, or lengths differ.
        """
        found = [self._series(index) for index in wanted]
        for index, column in zip(wanted, found, strict=True):
            if len(column) != len(found[0]):
                lengths = f"{len(column)} samples, {self.called(wanted[0])} {len(found[0])}"
                raise self.fault(f"{self.called(index)} has {lengths}")
            row = 0
            for block in blocks(column):
                good = np.isfinite(block)
                if index == gappy:
                    good |= np.isnan(block)
                if not good.all():
                    bad = int(np.argmin(good))
                    why = f"no number: {GAP}" if np.isnan(block[bad]) else INFINITE
                    raise self.at(row + bad, index, why)
                row += len(block)
        return found

    def _series(self, index: int) -> Signal:
        loaded = self.channels[index].load()
        if isinstance(loaded, Stored):
            if len(loaded) > KEPT:
                return loaded
            room(self.shown, len(loaded) * SIZE)
            return loaded[:]
        values = np.asarray(loaded)
        if values.ndim != 1 or values.dtype.kind not in "iufb":
            raise self.fault(f"{self.called(index)} is no series of real numbers")
        ours = values.dtype == np.float64 and values.flags.owndata and values.flags.writeable
        return values if ours else values.astype(np.float64)

    def last_digit(self, index: int) -> float:
        """Binary numbers are not rounded to digits."""
        return 0.0

    def at(self, row: int, index: int, sentence: str) -> RecordError:
        """Give the error at a 0-based sample of a column."""
        return self.fault(f"sample {row + 1}, {self.called(index)}: {sentence}")

    def fault(self, sentence: str, index: int | None = None) -> RecordError:
        """Give the error for a fault of the file; it has no lines to point at."""
        return fault(self.shown, sentence)

    def clock(self, index: int) -> int | None:
        """Give the 0-based column of the times that belong to a column, where there is one."""
        return self.channels[index].clock

    def own(self, index: int) -> tuple[float, float] | None:
        """Give the step and the first time [s] that the file itself knows of a column."""
        channel = self.channels[index]
        return None if channel.dt is None else (channel.dt, channel.first)

    def series(self) -> list[int]:
        """Give the 0-based columns that are no clocks."""
        clocks = {channel.clock for channel in self.channels}
        return [index for index in range(self.width) if index not in clocks]


def channels(
    file: File,
    found: Sequence[Channel],
    word: str = "channel",
    key: str = "channel",
    shares: bool = False,
) -> Channels:
    """Give the columns of a file that holds numbers, not text."""
    labels = tuple(channel.label for channel in found)
    return Channels(
        shown=file.shown,
        labels=labels if any(label.text or label.unit for label in labels) else (),
        width=len(found),
        word=word,
        key=key,
        shares=shares,
        channels=tuple(found),
    )


# Which column counts, and its unit.


def data_column(columns: Columns, wanted: str | int | None, time: int | None) -> int:
    """Give the 0-based column of the samples.

    Raises
    ------
    RecordError
        When the column is not there, or none is named and there is more than one.
    """
    if wanted is not None:
        return columns.find(wanted)
    others = [i for i in columns.series() if i != time]
    if len(others) == 1:
        return others[0]
    if not others:
        raise columns.fault(f"there is no {columns.word} besides the time")
    way = "its name or number" if columns.labels else "its number"
    raise columns.fault(f"give `{columns.key}`, {way}; there are: {columns.names()}")


def conversion(
    columns: Columns, index: int, unit: str | None, full_scale: str | None, quantity: str
) -> float:
    """Give what one of a column's numbers is in SI, from the file, the scenario, or both.

    Raises
    ------
    RecordError
        When the unit is missing, unknown, of another quantity, or two are given that differ.
    """
    si, block = SI[quantity], "friction.normal_record" if quantity == "force" else "excitation"
    place = f"in the scenario's `{block}` block"
    if columns.shares:
        if full_scale is None:
            instead = " in place of `unit`" if unit else ""
            sentence = "the samples are whole numbers, shares of a full scale without a unit"
            way = f"give `full_scale: 50 {si}`, say{instead}, {place}"
            raise columns.fault(f"{sentence}; {way}")
        return convert(full_scale, si)
    if full_scale is not None:
        sentence = "the samples are no shares of a full scale but floating-point numbers"
        raise columns.fault(f"{sentence}; give their `unit` in place of `full_scale`")
    return _unit(columns, index, unit, si, place)


def _unit(columns: Columns, index: int, unit: str | None, si: str, place: str) -> float:
    """Give what one of a column's numbers is in SI by its unit, whoever says it."""
    label = columns.labels[index] if columns.labels else None
    wanted = None if unit is None else _factor(columns, index, unit, si)
    if label is None or not label.unit:
        if wanted is not None:
            return wanted
        header = f", or `[{si}]` into the header" if columns.place == "header" else ""
        sentence = f"has no unit; write `unit: {si}` {place}{header}"
        raise columns.fault(f"{columns.called(index)} {sentence}", index)
    try:
        told = _factor(columns, index, label.unit, si)
    except RecordError as error:
        if label.firm or wanted is None:
            raise columns.fault(f"{error.message}{columns.way_round}", index) from None
        return wanted  # it may be a remark, as in `acc (filtered)`
    if wanted is not None and wanted != told:
        sentence = f"the {columns.place} says `{label.unit}`, the scenario says `unit: {unit}`"
        hint = f"; correct one of them{columns.way_round}"
        raise columns.fault(f"{columns.called(index)}: {sentence}{hint}", index)
    return told


def seconds(columns: Columns, index: int) -> float:
    """Give the unit of a column of times [s]; seconds when the file has none."""
    written = columns.labels[index].unit if columns.labels else ""
    return _factor(columns, index, written, "s") if written else 1.0


def missing_spacing(columns: Columns) -> RecordError:
    """Give the error for a record of which nobody said how its samples are spaced."""
    sentence = (
        "nothing says how the samples are spaced: "
        f"give `time` (a {columns.word}), `rate` or `step`"
    )
    for label in columns.labels:
        # It holds times by its unit, or by its name where it has no unit.
        if usual(label.unit, "s") if label.unit else label.name.lower() in ("t", "time"):
            where = f"the {columns.place} has `{label.quote}`"
            sentence += f"; `time: {label.name}` is what is missing, as {where}"
            break
    return columns.fault(sentence)


def _factor(columns: Columns, index: int, written: str, si: str) -> float:
    try:
        return factor(written, si)
    except ValueError as error:
        raise columns.fault(f"{columns.called(index)}: {error}", index) from None


# Formats; and what their files have no use for, by key of a record.


OWN_STEP = dict.fromkeys(
    ("time", "rate", "step"), "knows the step of its samples; remove `{key}`"
)
NO_TIME = "knows the times of its samples; remove `{key}`"
AS_CHANNEL = "has channels; write `channel` in place of `column`"
NO_CHANNEL = "has no channels; write `column` in place of `channel`"
ONE_SERIES = "has one series only; remove `{key}`"
NO_TABLE = "is no table of text; remove `skip`"
NO_FULL_SCALE = "needs no full scale; remove `full_scale`, and give `unit` if it has none"


class Format(NamedTuple):
    """One format: its name with its article, as sentences have it, and its keys."""

    name: str
    columns: Callable[[File], Columns]
    """Gives the columns of a file, or raises the RecordError of a file that is no such one, is
    damaged or holds no samples, or whose package is not installed."""
    idle: Mapping[str, str]
    """Keys of a record that mean nothing here, and what a sentence says of each."""
