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
from drysim.core.model import MAX_KEPT, Signal, blocks
from drysim.errors import Problem, RecordError
from drysim.records import SI
from drysim.units import (
    closest_match,
    conversion_factor,
    convert,
    did_you_mean,
    format_value,
    is_common_unit,
)

READ_SIZE = 1 << 20
"""Bytes read at a time: small beside the numbers, large beside the cost of a call."""

MEMORY_PER_FILE_BYTE = 0.25
"""Bytes held for a byte of any file, at least: a number of 8 for 32 characters."""

MAX_QUOTE_LENGTH = 40
"""Characters of a cell that a message may quote, so that no message retells a file."""

MAX_FILES_EXAMINED = 1000
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
    signature: system.FileSignature
    cached: dict[int, bytes] = field(default_factory=dict)

    def __len__(self) -> int:
        """Give how many there are."""
        return self.size

    def __getitem__(self, part: slice) -> bytes:
        """Give some neighbouring bytes."""
        first, last, _ = part.indices(self.size)
        for at, kept in self.cached.items():
            if at <= first and last <= at + len(kept):
                return kept[first - at : last - at]
        if last - first > READ_SIZE:
            return self._read(first, last - first)
        self.cached.clear()
        kept = self._read(first, READ_SIZE)
        self.cached[first] = kept
        return kept[: max(last - first, 0)]

    def find(self, wanted: bytes, first: int = 0) -> int:
        """Give where one byte stands from a place on, -1 for nowhere."""
        for at in range(first, self.size, READ_SIZE // 4):
            found = self[at : at + READ_SIZE // 4].find(wanted)
            if found >= 0:
                return at + found
        return -1

    def _read(self, at: int, count: int) -> bytes:
        try:
            with system.open_regular_file(self.path) as stream:
                stream.seek(at)
                found, signature = stream.read(count), system.file_signature(stream.fileno())
        except (OSError, system.NotARegularFile):
            raise changed_error(self.path) from None
        if signature != self.signature:
            raise changed_error(self.path)
        return found


class Cell(NamedTuple):
    """Text between two delimiters, and the 1-based column of its first character."""

    text: str
    column: int

    @property
    def quote(self) -> str:
        """The text as messages quote it, shortened."""
        text = printable(self.text)
        return text if len(text) <= MAX_QUOTE_LENGTH else text[: MAX_QUOTE_LENGTH - 1] + "…"


def printable(text: str) -> str:
    """Return a text with a question mark for each character that has no glyph."""
    return "".join(c if c.isprintable() else "?" for c in text)


@dataclass(frozen=True, eq=False)
class RecordFile:
    """A record as it was read first: its SHA-256; `format_value` is the path as messages name it.

    `skip` is the number of rows at its top that do not count.
    """

    display_path: str
    path: Path
    reader: Reader
    sha256: str
    skip: int = 0

    @cached_property
    def raw(self) -> bytes:
        """All bytes at once, where memory has room for them and what is made of them."""
        require_memory_to_load(self.display_path, len(self.reader))
        return self.reader[:]


class TextFile(NamedTuple):
    """Text of a record, which begins at an offset: the one of a line counted from 1."""

    display_path: str
    text: Reader | bytes
    begin: int = 0
    line: int = 1


def open_record(path: Path, suffixes: Collection[str]) -> RecordFile:
    """Read the file of a record once, if its suffix is one of those that are read.

    Raises
    ------
    RecordError
        When the file is missing, empty, not a regular file, of a kind that is not read, or
        larger than the machine's memory allows.
    """
    try:
        size = _record_size(path, suffixes)
        require_memory(str(path), size * MEMORY_PER_FILE_BYTE)
        reader, sha256, filled = hash_file(path)
    except system.NotARegularFile as other:
        raise record_error(
            str(path), f"the record is {other}; only a regular file is read"
        ) from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise record_error(str(path), f"the record cannot be read: {why}") from None
    if not size or not filled:
        raise record_error(str(path), "the record is empty")
    if size != len(reader):
        raise changed_error(path)
    return RecordFile(str(path), path, reader, sha256)


def _record_size(path: Path, suffixes: Collection[str]) -> int:
    """Give the size of a record; a file below /proc, which claims to have none, has none."""
    try:
        size = system.file_size(path)
    except FileNotFoundError:
        raise record_error(
            str(path), f"the record is not there{_missing_file_hint(path, suffixes)}"
        ) from None
    if path.suffix.lower() not in suffixes:
        kinds = ", ".join(suffixes)
        suffix = f"from `{path.suffix}`" if path.suffix else "without a suffix"
        raise record_error(
            str(path), f"a record {suffix} cannot be read; what is read: {kinds}"
        )
    return size


def _missing_file_hint(path: Path, suffixes: Collection[str]) -> str:
    if not path.parent.is_dir():
        return f": there is no folder `{path.parent}`"
    if path.is_symlink():
        return ": it is a link that leads nowhere"
    files = islice(path.parent.iterdir(), MAX_FILES_EXAMINED)
    names = (file.name for file in files if file.suffix.lower() in suffixes)
    return did_you_mean(closest_match(path.name, names))


def hash_file(path: Path) -> tuple[Reader, str, bool]:
    """Read a file once; gives its reader, its SHA-256 (hex) and whether it holds anything.

    Raises
    ------
    RecordError
        When the file changes meanwhile.
    """
    digest, filled = hashlib.sha256(), False
    with system.open_regular_file(path) as stream:
        signature = system.file_signature(stream.fileno())
        while block := stream.read(READ_SIZE):
            digest.update(block)
            filled = filled or bool(block.strip())
        if system.file_signature(stream.fileno()) != signature:
            raise changed_error(path)
    return Reader(path, signature[1], signature), digest.hexdigest(), filled


def changed_error(path: Path) -> RecordError:
    """Give the error for a file that is no longer the one that was looked at first."""
    sentence = "the record changed while it was read; wait until it is whole"
    return RecordError(Problem(sentence, str(path), 0))


def record_error(
    display_path: str, sentence: str, line: int = 0, cell: Cell | None = None
) -> RecordError:
    """Give the error for one fault; its source line shows the faulty cell among blanks."""
    if cell is None:
        return RecordError(Problem(sentence, display_path, line))
    quote = cell.quote
    # Far to the right, a source line of blanks and one cell helps nobody.
    source = " " * (cell.column - 1) + quote if cell.column <= 100 else ""
    return RecordError(
        Problem(sentence, display_path, line, cell.column, max(1, len(quote)), source=source)
    )


def require_memory_to_load(display_path: str, size: int) -> None:
    """Make sure that a record of some bytes, packed or not, can be read into memory.

    There must be room for three: the file, what is made of its bytes, and the numbers.

    Raises
    ------
    RecordError
        When the machine has too little.
    """
    require_memory(display_path, size * 3)


def require_memory(display_path: str, need: float) -> None:
    """Make sure that the machine has so many bytes for a record; errors as in `require_memory_to_load`."""
    have = system.total_memory()
    if need > have:
        sentence = f"the record needs {need / 1e9:.3g} GB of memory"
        raise record_error(display_path, f"{sentence}, this machine has {have / 1e9:.3g} GB")


# What a file offers, whatever its format: columns of numbers, by name and by number.
#
# `Columns` is what every format implements, `Channels` the one of files that hold numbers and
# not text: they are loaded when asked for, finite or refused, or `LazySamples`, which leaves them in
# their file and reads each stretch when it is needed. `data_column`, `column_factor` and `time_factor`
# say which column counts and in which unit, by file and scenario together. `Format` is what the
# registry of formats holds.


Floats = NDArray[np.float64]


def gap_hint(at_most: str = "50 ms", which: str = "short ones") -> str:
    """Say what to do about samples that are missing."""
    way = f"`gaps: {{fill: line, at_most: {at_most}}}`"
    return f"the record has a gap; {way} fills {which}"


GAP_HINT = gap_hint()
"""What to say of a sample that is missing, where the length of the gap is not known yet."""

INFINITE_HINT = "an infinite sample is no gap that could be filled; export the record anew"
"""What to say of a sample that overflowed."""

MAX_LISTED_COLUMNS = 12
"""How many of a file's columns a message lists."""


class ColumnLabel(NamedTuple):
    """What a file says of a column: the text as written, and name and unit that it holds.

    `is_unit_certain` is false where the unit may be a remark, as in `acc (filtered)`.
    """

    text: str
    name: str
    unit: str = ""
    is_unit_certain: bool = True

    @property
    def quote(self) -> str:
        """The text as messages quote it, shortened."""
        return Cell(self.text, 0).quote


@dataclass(frozen=True, kw_only=True)
class Columns:
    """Columns of numbers in a file; each implementation knows where its numbers are."""

    display_path: str
    """The file as messages name it."""
    labels: tuple[ColumnLabel, ...]
    """What the file says of each column; empty when nothing has a name."""
    width: int
    """Number of columns."""
    word: str = "column"
    """What a column is called."""
    key: str = "column"
    """The key of a record that chooses it."""
    place: str = "header"
    """Where a unit stands: header or file."""
    normalised: bool = False
    """Whether the numbers are shares of a full scale that the file does not know."""

    def numbers(self, wanted: list[int], gap_column: int | None = None) -> list[Signal]:
        """Give columns as finite numbers, NaN where a sample of the `gap_column` one is missing."""
        raise NotImplementedError

    def printed_resolution(self, index: int) -> float:
        """Give the unit of the last digit that a column's numbers are written with."""
        raise NotImplementedError

    def at(self, row: int, index: int, sentence: str) -> RecordError:
        """Give the error at a 0-based row of a column."""
        raise NotImplementedError

    def error(self, sentence: str, index: int | None = None) -> RecordError:
        """Give the error for a fault of the whole file, or of one column."""
        raise NotImplementedError

    def time_column(self, index: int) -> int | None:
        """Give the 0-based column of the times that belong to a column, where there is one."""
        return None

    def file_spacing(self, index: int) -> tuple[float, float] | None:
        """Give the step and the first time [s] that the file itself knows of a column."""
        return None

    def series(self) -> list[int]:
        """Give the 0-based columns that may be samples."""
        return list(range(self.width))

    @property
    def skip_hint(self) -> str:
        """How to pass over what the file says of its columns, where it can be."""
        return ""

    def describe_column(self, index: int) -> str:
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
        listed = ", ".join(f"`{self.labels[i].quote}`" for i in series[:MAX_LISTED_COLUMNS])
        return listed + (
            f" and {len(series) - MAX_LISTED_COLUMNS} more"
            if len(series) > MAX_LISTED_COLUMNS
            else ""
        )

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
            raise self.error(
                f"there is no {self.word} {format_value(wanted)}; there are: {self.names()}"
            )
        full = [label.text for label in self.labels]
        names_only = [label.name for label in self.labels]
        hits = [i for i, text in enumerate(full) if text == wanted.strip()]
        hits = hits or [i for i, text in enumerate(names_only) if text == wanted.strip()]
        if len(hits) == 1:
            return hits[0]
        if hits:
            numbers = " and ".join(str(i + 1) for i in hits[:MAX_LISTED_COLUMNS])
            both = f"{self.word}s {numbers} are both {format_value(wanted)}"
            raise self.error(f"{both}; give the {self.word}'s number")
        nearest = closest_match(wanted, filter(None, names_only + full))
        guess = f" did you mean {format_value(nearest)}?" if nearest else ""
        raise self.error(
            f"there is no {self.word} {format_value(wanted)};{guess} there are: {self.names()}"
        )


# Signals in memory or in their file.


@dataclass(frozen=True)
class LazySamples:
    """Samples in a file, from number `first` to the one before `last`, times a factor.

    `open_record` gives those from one number to the one before another.
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
    if isinstance(signal, LazySamples):
        return replace(signal, factor=signal.factor * factor)
    values = signal[:]
    values *= factor
    return values


def slice_signal(signal: Signal, first: int, last: int) -> Signal:
    """Give a signal from one number to the one before another."""
    if isinstance(signal, LazySamples):
        return replace(signal, first=signal.first + first, last=signal.first + last)
    return signal[first:last]


# Files that hold numbers, not text.


FLOAT64_SIZE = 8
"""Bytes of a number in memory."""


class Channel(NamedTuple):
    """One column of a file that holds numbers, not text; they are loaded when asked for.

    `dt` and `first` are step and first time [s] where the file knows them, `time_column` is the
    0-based column of its times where it has such.
    """

    label: ColumnLabel
    load: Callable[[], NDArray[np.generic] | LazySamples]
    dt: float | None = None
    first: float = 0.0
    time_column: int | None = None


@dataclass(frozen=True, kw_only=True)
class Channels(Columns):
    """Columns of a file that holds numbers, not text."""

    channels: tuple[Channel, ...]
    place: str = "file"

    def numbers(self, wanted: list[int], gap_column: int | None = None) -> list[Signal]:
        """Give columns as finite numbers, NaN where a sample of the `gap_column` one is missing.

        Raises
        ------
        RecordError
            When a column is no series of real numbers, a sample is none, or lengths differ.
        """
        found = [self._series(index) for index in wanted]
        for index, column in zip(wanted, found, strict=True):
            if len(column) != len(found[0]):
                lengths = (
                    f"{len(column)} samples, {self.describe_column(wanted[0])} {len(found[0])}"
                )
                raise self.error(f"{self.describe_column(index)} has {lengths}")
            row = 0
            for block in blocks(column):
                good = np.isfinite(block)
                if index == gap_column:
                    good |= np.isnan(block)
                if not good.all():
                    bad = int(np.argmin(good))
                    why = f"no number: {GAP_HINT}" if np.isnan(block[bad]) else INFINITE_HINT
                    raise self.at(row + bad, index, why)
                row += len(block)
        return found

    def _series(self, index: int) -> Signal:
        loaded = self.channels[index].load()
        if isinstance(loaded, LazySamples):
            if len(loaded) > MAX_KEPT:
                return loaded
            require_memory(self.display_path, len(loaded) * FLOAT64_SIZE)
            return loaded[:]
        values = np.asarray(loaded)
        if values.ndim != 1 or values.dtype.kind not in "iufb":
            raise self.error(f"{self.describe_column(index)} is no series of real numbers")
        ours = values.dtype == np.float64 and values.flags.owndata and values.flags.writeable
        return values if ours else values.astype(np.float64)

    def printed_resolution(self, index: int) -> float:
        """Binary numbers are not rounded to digits."""
        return 0.0

    def at(self, row: int, index: int, sentence: str) -> RecordError:
        """Give the error at a 0-based sample of a column."""
        return self.error(f"sample {row + 1}, {self.describe_column(index)}: {sentence}")

    def error(self, sentence: str, index: int | None = None) -> RecordError:
        """Give the error for a fault of the file; it has no lines to point at."""
        return record_error(self.display_path, sentence)

    def time_column(self, index: int) -> int | None:
        """Give the 0-based column of the times that belong to a column, where there is one."""
        return self.channels[index].time_column

    def file_spacing(self, index: int) -> tuple[float, float] | None:
        """Give the step and the first time [s] that the file itself knows of a column."""
        channel = self.channels[index]
        return None if channel.dt is None else (channel.dt, channel.first)

    def series(self) -> list[int]:
        """Give the 0-based columns that are no clocks."""
        clocks = {channel.time_column for channel in self.channels}
        return [index for index in range(self.width) if index not in clocks]


def make_channels(
    file: RecordFile,
    found: Sequence[Channel],
    word: str = "channel",
    key: str = "channel",
    normalised: bool = False,
) -> Channels:
    """Give the columns of a file that holds numbers, not text."""
    labels = tuple(channel.label for channel in found)
    return Channels(
        display_path=file.display_path,
        labels=labels if any(label.text or label.unit for label in labels) else (),
        width=len(found),
        word=word,
        key=key,
        normalised=normalised,
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
        raise columns.error(f"there is no {columns.word} besides the time")
    way = "its name or number" if columns.labels else "its number"
    raise columns.error(f"give `{columns.key}`, {way}; there are: {columns.names()}")


def column_factor(
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
    if columns.normalised:
        if full_scale is None:
            instead = " in place of `unit`" if unit else ""
            sentence = "the samples are whole numbers, shares of a full scale without a unit"
            way = f"give `full_scale: 50 {si}`, say{instead}, {place}"
            raise columns.error(f"{sentence}; {way}")
        return convert(full_scale, si)
    if full_scale is not None:
        sentence = "the samples are no shares of a full scale but floating-point numbers"
        raise columns.error(f"{sentence}; give their `unit` in place of `full_scale`")
    return _unit_factor(columns, index, unit, si, place)


def _unit_factor(columns: Columns, index: int, unit: str | None, si: str, place: str) -> float:
    """Give what one of a column's numbers is in SI by its unit, whoever says it."""
    label = columns.labels[index] if columns.labels else None
    wanted = None if unit is None else _parse_unit(columns, index, unit, si)
    if label is None or not label.unit:
        if wanted is not None:
            return wanted
        header = f", or `[{si}]` into the header" if columns.place == "header" else ""
        sentence = f"has no unit; write `unit: {si}` {place}{header}"
        raise columns.error(f"{columns.describe_column(index)} {sentence}", index)
    try:
        file_factor = _parse_unit(columns, index, label.unit, si)
    except RecordError as error:
        if label.is_unit_certain or wanted is None:
            raise columns.error(f"{error.message}{columns.skip_hint}", index) from None
        return wanted  # it may be a remark, as in `acc (filtered)`
    if wanted is not None and wanted != file_factor:
        sentence = f"the {columns.place} says `{label.unit}`, the scenario says `unit: {unit}`"
        hint = f"; correct one of them{columns.skip_hint}"
        raise columns.error(f"{columns.describe_column(index)}: {sentence}{hint}", index)
    return file_factor


def time_factor(columns: Columns, index: int) -> float:
    """Give the unit of a column of times [s]; seconds when the file has none."""
    written = columns.labels[index].unit if columns.labels else ""
    return _parse_unit(columns, index, written, "s") if written else 1.0


def missing_spacing_error(columns: Columns) -> RecordError:
    """Give the error for a record of which nobody said how its samples are spaced."""
    sentence = (
        "nothing says how the samples are spaced: "
        f"give `time` (a {columns.word}), `rate` or `step`"
    )
    for label in columns.labels:
        # It holds times by its unit, or by its name where it has no unit.
        if (
            is_common_unit(label.unit, "s")
            if label.unit
            else label.name.lower() in ("t", "time")
        ):
            where = f"the {columns.place} has `{label.quote}`"
            sentence += f"; `time: {label.name}` is what is missing, as {where}"
            break
    return columns.error(sentence)


def _parse_unit(columns: Columns, index: int, written: str, si: str) -> float:
    try:
        return conversion_factor(written, si)
    except ValueError as error:
        raise columns.error(f"{columns.describe_column(index)}: {error}", index) from None


# Formats; and what their files have no use for, by key of a record.


KNOWN_STEP = dict.fromkeys(
    ("time", "rate", "step"), "knows the step of its samples; remove `{key}`"
)
KNOWN_TIMES = "knows the times of its samples; remove `{key}`"
USE_CHANNEL = "has channels; write `channel` in place of `column`"
USE_COLUMN = "has no channels; write `column` in place of `channel`"
ONE_SERIES = "has one series only; remove `{key}`"
NOT_TEXT = "is no table of text; remove `skip`"
NO_FULL_SCALE = "needs no full scale; remove `full_scale`, and give `unit` if it has none"


class Format(NamedTuple):
    """One format: its name with its article, as sentences have it, and its keys."""

    name: str
    columns: Callable[[RecordFile], Columns]
    """Gives the columns of a file, or raises the RecordError of a file that is no such one, is
    damaged or holds no samples, or whose package is not installed."""
    unused_keys: Mapping[str, str]
    """Keys of a record that mean nothing here, and what a sentence says of each."""
