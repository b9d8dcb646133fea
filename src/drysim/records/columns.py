"""The file of a record, and the columns of numbers in it.

The bytes of a record are not kept in memory: a `Reader` reads slices on demand and raises if
the file was modified in the meantime, so that results always belong to the SHA-256. That is
computed last: a file without rows of numbers is refused at its first line, however large. Only
regular files with a known suffix that fit into memory are accepted.

`Columns` is the interface that every file format implements; `Channels` implements it for
binary formats. `data_column`, `column_factor` and `time_factor` determine the column of the
samples and the units from file and scenario together. `Format` is an entry of the format
registry.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim import system
from drysim.core.model import MAX_CACHED, Floats, Signal, blocks
from drysim.errors import Problem, RecordError
from drysim.messages import closest_match, did_you_mean, format_value
from drysim.records import SI, clock
from drysim.units import conversion_factor, convert, is_common_unit, is_known_unit

READ_SIZE = 1 << 20
"""Bytes read at a time: small compared with the samples, large compared with overhead."""

MEMORY_PER_FILE_BYTE = 0.25
"""Lower bound of memory per byte of file: 8 bytes for a number printed with 32 characters."""

MAX_QUOTE_LENGTH = 40
"""Characters of a cell that messages quote."""

MAX_FILES_EXAMINED = 1000
"""Files of a folder searched for a similar name."""

CONVERT_SEISMIC = (
    "convert it to one acceleration per row, in Python with ObsPy: "
    "`numpy.savetxt('record.csv', obspy.read(file)[0].data)`, scaled to its unit"
)
"""Remedy for a seismic record that is not read."""

SEISMIC = (".sac", ".mseed", ".msd", ".seed", ".sgy", ".segy", ".gcf", ".smc", ".v1", ".v2")
SEISMIC_OF_JAPAN = (".ns", ".ew", ".ud", ".ns1", ".ew1", ".ud1", ".ns2", ".ew2", ".ud2")

REMEDIES = {
    (".xls", ".xlsx", ".xlsm", ".xlsb", ".ods", ".numbers"): ": save the sheet as CSV",
    (".h5", ".hdf5", ".hdf", ".npy", ".npz", ".parquet", ".feather", ".pkl"): (
        ": write times and samples as columns of a CSV file"
    ),
    SEISMIC + SEISMIC_OF_JAPAN: f", as of seismic formats: {CONVERT_SEISMIC}",
    (".zip", ".gz", ".7z", ".rar", ".bz2", ".xz"): ": unpack it",
    (".blf", ".dbc", ".pti", ".d7d", ".dxd", ".bin", ".sie"): (
        ": export it with the program of the logger as CSV, MDF or UFF"
    ),
}
"""Remedies for files of other formats, by suffix."""


@dataclass(frozen=True, eq=False)
class Reader:
    """The bytes of a file, read slice by slice; the last block is cached.

    Raises
    ------
    RecordError
        On access, if the file was modified since it was opened.
    """

    path: Path
    signature: system.FileSignature
    """State of the file when it was opened."""
    cached: dict[int, bytes] = field(default_factory=dict)

    def __len__(self) -> int:
        """Return the size [bytes]."""
        return self.signature[1]

    def __getitem__(self, part: slice) -> bytes:
        """Return a contiguous slice."""
        first, last, _ = part.indices(len(self))
        for offset, kept in self.cached.items():
            if offset <= first and last <= offset + len(kept):
                return kept[first - offset : last - offset]
        if last - first > READ_SIZE:
            return self._read(first, last - first)
        self.cached.clear()
        kept = self._read(first, READ_SIZE)
        self.cached[first] = kept
        return kept[: max(last - first, 0)]

    def find(self, wanted: bytes, first: int = 0) -> int:
        """Return the offset of the first occurrence of a byte, -1 if there is none."""
        for offset in range(first, len(self), READ_SIZE // 4):
            place = self[offset : offset + READ_SIZE // 4].find(wanted)
            if place >= 0:
                return offset + place
        return -1

    def _read(self, offset: int, count: int) -> bytes:
        try:
            with system.open_regular_file(self.path) as stream:
                stream.seek(offset)
                content, signature = stream.read(count), system.file_signature(stream.fileno())
        except (OSError, system.NotARegularFile):
            raise changed_error(self.path) from None
        if signature != self.signature:
            raise changed_error(self.path)
        return content


class Cell(NamedTuple):
    """Text between two delimiters, and the 1-based column of its first character."""

    text: str
    column: int

    @property
    def quote(self) -> str:
        """The text as messages quote it."""
        return shorten_quote(self.text)


def shorten_quote(text: str) -> str:
    """Return text as messages quote it, printable and shortened."""
    text = printable(text)
    return text if len(text) <= MAX_QUOTE_LENGTH else text[: MAX_QUOTE_LENGTH - 1] + "…"


def printable(text: str) -> str:
    """Return the text with unprintable characters replaced by question marks."""
    return "".join(c if c.isprintable() else "?" for c in text)


class RowSelection(NamedTuple):
    """The rows of a text table that are samples; by default all of them."""

    start: int | None = None
    """First row, by its 1-based line in the file."""
    to: int | None = None
    """Last row."""
    where: Mapping[str | int, str | int] = {}
    """Column, by name or number, and the contents of its cell in each of the rows."""


ALL_ROWS = RowSelection()


@dataclass(frozen=True, eq=False)
class RecordFile:
    """A record file with its SHA-256."""

    display_path: str
    """Path as messages show it."""
    path: Path
    reader: Reader
    skip: int = 0
    """Rows to skip at the top of a text file."""
    rows: RowSelection = ALL_ROWS
    """Rows of a text file that are samples."""

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the file, in hex."""
        digest = hashlib.sha256()
        for offset in range(0, len(self.reader), READ_SIZE):
            digest.update(self.reader[offset : offset + READ_SIZE])
        return digest.hexdigest()

    @cached_property
    def raw(self) -> bytes:
        """All bytes, if there is enough memory for them and the numbers in them."""
        require_memory_to_load(self.display_path, len(self.reader))
        return self.reader[:]

    def error(self, sentence: str) -> RecordError:
        """Return the error for the whole file."""
        return record_error(self.display_path, sentence)


class TextFile(NamedTuple):
    """Text of a record from offset `begin`, where line `line` (1-based) starts."""

    display_path: str
    text: Reader | bytes
    begin: int = 0
    line: int = 1
    rows: RowSelection = ALL_ROWS

    def error(self, sentence: str, line: int = 0, cell: Cell | None = None) -> RecordError:
        """Return the error for a line, or for one of its cells; line 0 is the whole file."""
        return record_error(self.display_path, sentence, line, cell)


def open_record(path: Path, suffixes: Collection[str]) -> RecordFile:
    """Return a record file with a supported suffix, to be read on demand.

    Raises
    ------
    RecordError
        If the file is missing, empty, not regular, of an unsupported type, or too large for the
        memory of the machine.
    """
    try:
        size = _record_size(path, suffixes)
        require_memory(str(path), size * MEMORY_PER_FILE_BYTE)
        with system.open_regular_file(path) as stream:
            reader = Reader(path, system.file_signature(stream.fileno()))
    except system.NotARegularFile as other:
        raise record_error(
            str(path), f"the record is {other}; only regular files are supported"
        ) from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise record_error(str(path), f"the record cannot be read: {why}") from None
    if size != len(reader):
        raise changed_error(path)
    parts = (reader[offset : offset + READ_SIZE] for offset in range(0, size, READ_SIZE))
    if not any(part.strip() for part in parts):  # the first part decides, as a rule
        raise record_error(str(path), "the record is empty")
    return RecordFile(str(path), path, reader)


def _record_size(path: Path, suffixes: Collection[str]) -> int:
    """Return the size of a record file. Files below /proc report a size of 0."""
    try:
        size = system.file_size(path)
    except FileNotFoundError:
        raise record_error(
            str(path), f"the record does not exist{_missing_file_hint(path, suffixes)}"
        ) from None
    if path.suffix.lower() not in suffixes:
        kinds = ", ".join(suffixes)
        suffix = f"of type `{path.suffix}`" if path.suffix else "without an extension"
        remedy = next(
            (what for ends, what in REMEDIES.items() if path.suffix.lower() in ends), ""
        )
        raise record_error(
            str(path), f"a record {suffix} is not supported{remedy}; supported: {kinds}"
        )
    return size


def _missing_file_hint(path: Path, suffixes: Collection[str]) -> str:
    """Return why a file may be missing, or a similar name."""
    if not path.parent.is_dir():
        return f": there is no folder `{path.parent}`"
    if path.is_symlink():
        return ": broken symbolic link"
    files = islice(path.parent.iterdir(), MAX_FILES_EXAMINED)
    names = (file.name for file in files if file.suffix.lower() in suffixes)
    return did_you_mean(closest_match(path.name, names))


def changed_error(path: Path) -> RecordError:
    """Return the error for a file that was modified after it was opened."""
    sentence = "the record changed while it was read; wait until it is complete"
    return record_error(str(path), sentence)


def record_error(
    display_path: str, sentence: str, line: int = 0, cell: Cell | None = None
) -> RecordError:
    """Return a RecordError; with a cell, its source line shows the cell at its column."""
    if cell is None:
        return RecordError(Problem(sentence, display_path, line))
    quote = cell.quote
    # A source line of more than 100 blanks would not be readable.
    before = f"{'…':<{cell.column - 1}}" if cell.column > 1 else ""
    source = before + quote if cell.column <= 100 else ""
    return RecordError(
        Problem(sentence, display_path, line, cell.column, max(1, len(quote)), source=source)
    )


def require_memory_to_load(display_path: str, size: int) -> None:
    """Raise unless a record of `size` bytes can be loaded.

    Memory is needed three times: for the file, for its decoded contents and for the numbers.

    Raises
    ------
    RecordError
        If the machine has too little memory.
    """
    require_memory(display_path, size * 3)


def require_memory(display_path: str, need: float) -> None:
    """Raise unless the machine has `need` bytes; raises like `require_memory_to_load`."""
    have = system.total_memory()
    if need > have:
        sentence = f"the record needs {need / 1e9:.3g} GB of memory"
        raise record_error(display_path, f"{sentence}, this machine has {have / 1e9:.3g} GB")


MAX_EXPANSION, ALWAYS_PLAUSIBLE = 100, 1 << 26
"""Largest ratio of unpacked samples to the size of their file, beyond a size [bytes] that every
machine has. Measured samples contain noise, which compresses tenfold at best."""


def require_plausible_size(file: RecordFile, size: int) -> None:
    """Raise unless a file may contain `size` bytes of samples, and the machine can load them.

    Raises
    ------
    RecordError
        If the samples are far larger than their file, or than the memory.
    """
    require_memory_to_load(file.display_path, size)
    if size > max(ALWAYS_PLAUSIBLE, MAX_EXPANSION * len(file.reader)):
        stated, room = (f"{count / 1e6:.3g} MB" for count in (size, len(file.reader)))
        sentence = f"it states {stated} of samples in {room}"
        raise file.error(f"{sentence}: such a file is damaged, or made to exhaust the memory")


# Columns of numbers.


GAP_HINT = "the record has a gap; `gaps: {fill: line, at_most: 50 ms}` fills short ones"
"""Hint for a missing sample where the length of the gap is not yet known."""

INFINITE_HINT = "an infinite sample cannot be interpolated; export the record again"
"""Hint for an infinite sample."""

MAX_LISTED_COLUMNS = 12
"""Columns of a file that a message lists."""


class ColumnLabel(NamedTuple):
    """Label of a column in a file: the text as written, and the name and unit in it.

    All are empty for a column without a label. `is_unit_certain` is false where the unit may be
    a comment, as in `acc (filtered)`.
    """

    text: str = ""
    name: str = ""
    unit: str = ""
    is_unit_certain: bool = True

    @property
    def quote(self) -> str:
        """The text as messages quote it."""
        return shorten_quote(self.text)


class PrintedTimes(NamedTuple):
    """Times of the samples as the file has them."""

    t: Floats
    """Times in their unit, shape (n,)."""
    second: float = 1.0
    """Their unit [s]."""
    resolution: float = 0.0
    """Unit of the last printed digit; 0 for binary numbers."""


@dataclass(frozen=True, kw_only=True)
class Columns:
    """Columns of numbers in a file; implemented by every format."""

    display_path: str
    """Path of the file as messages show it."""
    labels: tuple[ColumnLabel, ...]
    """Label of each column."""
    word: str = "column"
    """Noun for a column in messages."""
    key: str = "column"
    """Key of the scenario that selects a column."""
    place: str = "header"
    """Where units are given: header or file."""
    normalised: bool = False
    """Whether samples are fractions of a full scale that the file does not contain."""

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self.labels)

    def numbers(self, wanted: list[int], gap_column: int | None = None) -> list[Signal]:
        """Return columns as finite numbers, NaN where a sample of `gap_column` is missing."""
        raise NotImplementedError

    def with_times(
        self, time: int, wanted: list[int], gap_column: int | None = None, unit: str = ""
    ) -> tuple[PrintedTimes, list[Signal]]:
        """Return the times in one column, and other columns as `numbers` does.

        `unit` is that of the times in the scenario, empty without one.
        """
        second = time_factor(self, time, unit)
        t, *samples = self.numbers([time, *wanted], gap_column)
        if second is None:
            second = UNIT_OF_VALUES[clock.unit_of_values(t[:])]
        return PrintedTimes(t[:], second, self.printed_resolution(time)), samples

    def printed_resolution(self, index: int) -> float:
        """Return the unit of the last digit with which a column is printed."""
        raise NotImplementedError

    def error_at(self, row: int, index: int, sentence: str) -> RecordError:
        """Return the error at a 0-based row of a column."""
        raise NotImplementedError

    def line_of(self, row: int) -> int:
        """Return the 1-based line of a 0-based row of a text file; 0 in other files."""
        return 0

    def texts(self, index: int) -> Iterator[str]:
        """Yield the text in each row of a column of a text file; nothing of other files."""
        yield from ()

    def describe_row(self, row: int) -> str:
        """Return a 0-based row as messages show it."""
        line = self.line_of(row)
        return f"row {line}" if line else f"sample {row + 1}"

    def error(self, sentence: str, index: int | None = None) -> RecordError:
        """Return the error for the whole file, or for one column."""
        raise NotImplementedError

    def time_column(self, index: int) -> int | None:
        """Return the 0-based column with the times of a column, None if there is none."""
        return None

    def file_spacing(self, index: int) -> tuple[float, float] | None:
        """Return time step and first time [s] of a column if the file contains them."""
        return None

    def series(self) -> list[int]:
        """Return the 0-based columns that may contain samples."""
        return list(range(self.width))

    def has_unit(self, label: ColumnLabel) -> bool:
        """Whether the unit of a label is none of a comment: a column has a unit of its own."""
        return False

    @property
    def skip_hint(self) -> str:
        """How to skip the header, where that is possible."""
        return ""

    def describe_column(self, index: int) -> str:
        """Return a column as messages show it."""
        name = self.labels[index].quote
        return f"{self.word} {index + 1}" + (f" (`{name}`)" if name else "")

    @property
    def has_names(self) -> bool:
        """Whether any column has a label."""
        return any(label.text for label in self.labels)

    def names(self) -> str:
        """Return the list of columns for messages."""
        if not self.has_names:
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
        """Return the 0-based column of a name, with or without unit, or of a 1-based number.

        Raises
        ------
        RecordError
            If there is no such column, or more than one.
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
            raise self.error(f"{both}; use the {self.word} number")
        nearest = closest_match(wanted, filter(None, names_only + full))
        guess = f" did you mean {format_value(nearest)}?" if nearest else ""
        raise self.error(
            f"there is no {self.word} {format_value(wanted)};{guess} there are: {self.names()}"
        )


# Samples in memory or in their file.


@dataclass(frozen=True)
class LazySamples:
    """Samples that stay in their file until they are needed."""

    read: Callable[[int, int], Floats]
    """`read(first, last)` returns samples `first` to `last - 1`."""
    first: int
    last: int
    """Range of the samples, `last` excluded."""
    factor: float = 1.0
    """Factor on the samples."""

    def __len__(self) -> int:
        """Return the number of samples."""
        return self.last - self.first

    def __getitem__(self, part: slice, /) -> Floats:
        """Read a slice of the samples."""
        first, last, every = part.indices(len(self))
        values = self.read(self.first + first, self.first + max(first, last))
        values *= self.factor
        return values[::every]


def scaled(signal: Signal, factor: float) -> Signal:
    """Return a signal times a factor; an array is changed in place."""
    if isinstance(signal, LazySamples):
        return replace(signal, factor=signal.factor * factor)
    values = signal[:]
    values *= factor
    return values


def slice_signal(signal: Signal, first: int, last: int) -> Signal:
    """Return samples `first` to `last - 1` of a signal."""
    if isinstance(signal, LazySamples):
        return replace(signal, first=signal.first + first, last=signal.first + last)
    return signal[first:last]


# Binary files.


FLOAT64_SIZE = 8
"""Bytes of a sample in memory."""


class Channel(NamedTuple):
    """One column of a binary file, loaded on demand."""

    label: ColumnLabel
    load: Callable[[], NDArray[np.generic] | LazySamples]
    """Returns the samples."""
    dt: float | None = None
    """Time step [s], if the file contains it."""
    first: float = 0.0
    """First time [s]."""
    time_column: int | None = None
    """0-based column of the times, if there is one."""


@dataclass(frozen=True, kw_only=True)
class Channels(Columns):
    """Columns of a binary file."""

    channels: tuple[Channel, ...]
    place: str = "file"

    def numbers(self, wanted: list[int], gap_column: int | None = None) -> list[Signal]:
        """Return columns as finite numbers, NaN where a sample of `gap_column` is missing.

        Raises
        ------
        RecordError
            If a column is not a series of real numbers, a sample is not finite, or lengths
            differ.
        """
        series = [self._series(index) for index in wanted]
        for index, column in zip(wanted, series, strict=True):
            if len(column) != len(series[0]):
                lengths = (
                    f"{len(column)} samples, {self.describe_column(wanted[0])} {len(series[0])}"
                )
                raise self.error(f"{self.describe_column(index)} has {lengths}")
            row = 0
            for block in blocks(column):
                good = np.isfinite(block)
                if index == gap_column:
                    good |= np.isnan(block)
                if not good.all():
                    bad = int(np.argmin(good))
                    why = f"not a number: {GAP_HINT}" if np.isnan(block[bad]) else INFINITE_HINT
                    raise self.error_at(row + bad, index, why)
                row += len(block)
        return series

    def _series(self, index: int) -> Signal:
        loaded = self.channels[index].load()
        if not len(loaded):
            raise self.error(f"{self.describe_column(index)} has no samples")
        if isinstance(loaded, LazySamples):
            if len(loaded) > MAX_CACHED:
                return loaded
            require_memory(self.display_path, len(loaded) * FLOAT64_SIZE)
            return loaded[:]
        values = np.asarray(loaded)
        if values.ndim != 1 or values.dtype.kind not in "iufb":
            raise self.error(f"{self.describe_column(index)} is not a series of real numbers")
        ours = values.dtype == np.float64 and values.flags.owndata and values.flags.writeable
        return values if ours else values.astype(np.float64)

    def printed_resolution(self, index: int) -> float:
        """Return 0: binary numbers are not rounded to decimal digits."""
        return 0.0

    def error_at(self, row: int, index: int, sentence: str) -> RecordError:
        """Return the error at a 0-based sample of a column."""
        return self.error(f"sample {row + 1}, {self.describe_column(index)}: {sentence}")

    def error(self, sentence: str, index: int | None = None) -> RecordError:
        """Return the error for the file; a binary file has no lines."""
        return record_error(self.display_path, sentence)

    def time_column(self, index: int) -> int | None:
        """Return the 0-based column with the times of a column, None if there is none."""
        return self.channels[index].time_column

    def file_spacing(self, index: int) -> tuple[float, float] | None:
        """Return time step and first time [s] of a column if the file contains them."""
        channel = self.channels[index]
        return None if channel.dt is None else (channel.dt, channel.first)

    def has_unit(self, label: ColumnLabel) -> bool:
        """Whether a channel has a unit of any quantity; a word such as `raw` is none."""
        return is_known_unit(label.unit)

    def series(self) -> list[int]:
        """Return the 0-based columns that are not times."""
        clocks = {channel.time_column for channel in self.channels}
        return [index for index in range(self.width) if index not in clocks]


def make_channels(
    file: RecordFile,
    channels: Sequence[Channel],
    word: str = "channel",
    key: str = "channel",
    normalised: bool = False,
) -> Channels:
    """Return the columns of a binary file."""
    return Channels(
        display_path=file.display_path,
        labels=tuple(channel.label for channel in channels),
        word=word,
        key=key,
        normalised=normalised,
        channels=tuple(channels),
    )


# Selection of the column, and its unit.


def data_column(columns: Columns, wanted: str | int | None, time: int | None) -> int:
    """Return the 0-based column of the samples.

    Parameters
    ----------
    wanted : str, int or None
        Name or 1-based number; None where the file has only one.
    time : int or None
        0-based column of the times.

    Raises
    ------
    RecordError
        If the column does not exist, or none is selected and there is more than one.
    """
    if wanted is not None:
        return columns.find(wanted)
    others = [i for i in columns.series() if i != time]
    if len(others) == 1:
        return others[0]
    if not others:
        raise columns.error(f"there is no {columns.word} besides the time")
    remedy = "its name or number" if columns.has_names else "its number"
    raise columns.error(f"set `{columns.key}`, {remedy}; there are: {columns.names()}")


def column_factor(
    columns: Columns,
    index: int,
    unit: str | None,
    full_scale: str | None,
    quantity: str,
    block: str,
) -> float:
    """Return the factor from a column to SI, from the file, the scenario, or both.

    Parameters
    ----------
    unit, full_scale : str or None
        As in the scenario.
    quantity : str
        A key of `SI`.
    block : str
        Block of the scenario, for messages.

    Raises
    ------
    RecordError
        If the unit is missing, unknown, of another quantity, or file and scenario disagree.
    """
    si = SI[quantity]
    place = f"in the scenario's `{block}` block"
    if columns.normalised:
        if full_scale is None:
            instead = " instead of `unit`" if unit else ""
            sentence = "the samples are integers, fractions of a full scale without a unit"
            remedy = f"set `full_scale`, e.g. `full_scale: 50 {si}`,{instead} {place}"
            raise columns.error(f"{sentence}; {remedy}")
        return convert(full_scale, si)
    if full_scale is not None:
        sentence = "the samples are floating-point numbers, not fractions of full scale"
        raise columns.error(f"{sentence}; set `unit` instead of `full_scale`")
    return unit_factor(columns, index, unit, si, place)


def unit_factor(columns: Columns, index: int, unit: str | None, si: str, place: str) -> float:
    """Return the factor from a column to SI, for samples with a unit."""
    label = columns.labels[index]
    wanted = None if unit is None else _parse_unit(columns, index, unit, si)
    if not label.unit:
        if wanted is not None:
            return wanted
        header = f", or `[{si}]` into the header" if columns.place == "header" else ""
        sentence = f"has no unit; write `unit: {si}` {place}{header}"
        raise columns.error(f"{columns.describe_column(index)} {sentence}", index)
    try:
        file_factor = _parse_unit(columns, index, label.unit, si)
    except RecordError as error:
        if label.is_unit_certain or wanted is None or columns.has_unit(label):
            remedy = _remedy_for_unit(columns, label.unit, si, place)
            raise columns.error(f"{error.message}{remedy}", index) from None
        return wanted  # it may be a comment, as in `acc (filtered)`
    if wanted is not None and wanted != file_factor:
        sentence = f"the {columns.place} says `{label.unit}`, the scenario says `unit: {unit}`"
        hint = f"; correct one of them{columns.skip_hint}"
        raise columns.error(f"{columns.describe_column(index)}: {sentence}{hint}", index)
    return file_factor


def _remedy_for_unit(columns: Columns, unit: str, si: str, place: str) -> str:
    """Return what to do about a column whose unit is of another quantity, or unknown."""
    motion = (name for name in SI if name != "force" and SI[name] != si)
    quantity = next((name for name in motion if is_common_unit(unit, SI[name])), "")
    if quantity and "`excitation`" in place:
        return f"; `quantity: {quantity}` {place} reads it as such"
    if is_known_unit(unit) and columns.width > 1:
        remedy = f"; select another {columns.word}"
        return remedy + columns.skip_hint.replace("; ", "; or, if the unit is wrong, ", 1)
    return columns.skip_hint


UNIT_OF_VALUES = {"": 1.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "d": clock.DAY}
"""Seconds of the units by which times without a unit identify themselves."""


def time_factor(columns: Columns, index: int, unit: str = "") -> float | None:
    """Return the factor from a column of times to seconds; None without a unit.

    `unit` is that in the scenario, empty without one.

    Raises
    ------
    RecordError
        If the unit is unknown or none of time, or the header has another one.
    """
    label = columns.labels[index]
    stated = _parse_unit(columns, index, unit, "s") if unit else None
    if label.unit:
        written = _parse_unit(columns, index, label.unit, "s")
        if stated not in (None, written):
            sentence = f"the {columns.place} says `{label.unit}`, the scenario says `{unit}`"
            raise columns.error(f"{columns.describe_column(index)}: {sentence}", index)
        return written
    if stated is None and (named := clock.unit_in_name(label.name)):
        return _parse_unit(columns, index, named, "s")
    return stated


def missing_spacing_error(columns: Columns) -> RecordError:
    """Return the error for a record without time step."""
    sentence = f"the time step is unknown: set `time` (a {columns.word}), `rate` or `step`"
    if (index := labelled_times(columns)) is not None:
        label = columns.labels[index]
        where = f"the {columns.place} has `{label.quote}`"
        sentence += f"; `time: {shorten_quote(label.name)}` fits, as {where}"
    return columns.error(sentence)


def labelled_times(columns: Columns) -> int | None:
    """Return the first 0-based column whose unit is one of time, or whose name without one."""
    for index, label in enumerate(columns.labels):
        if clock.is_unit(label.unit) if label.unit else clock.is_time_name(label.name):
            return index
    return None


def _parse_unit(columns: Columns, index: int, written: str, si: str) -> float:
    try:
        return conversion_factor(written, si)
    except ValueError as error:
        raise columns.error(f"{columns.describe_column(index)}: {error}", index) from None


# Formats, and the sentences that reject keys without meaning for them.


KNOWN_STEP = dict.fromkeys(
    ("time", "time_unit", "rate", "step"), "contains its time step; remove `{key}`"
)
KNOWN_TIMES = dict.fromkeys(("time", "time_unit"), "contains its times; remove `{key}`")
USE_CHANNEL = "has channels; write `channel` instead of `column`"
USE_COLUMN = "has no channels; write `column` instead of `channel`"
ONE_SERIES = "has one series only; remove `{key}`"
NOT_TEXT = dict.fromkeys(("skip", "rows"), "is not a text table; remove `{key}`")
NO_FULL_SCALE = "needs no full scale; remove `full_scale`, and set `unit` if the file has none"


class Format(NamedTuple):
    """A file format of records; `name` includes the article, e.g. `a WAV`."""

    name: str
    columns: Callable[[RecordFile], Columns]
    """Returns the columns of a file.

    Raises RecordError if the file has another format, is damaged or empty, or if the required
    package is not installed.
    """
    unused_keys: Mapping[str, str]
    """Keys of a record without meaning for this format, and the sentence that rejects each."""
