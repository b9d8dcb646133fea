"""MDF 4 measurements, read by asammdf; conversions to physical values are applied here.

An MDF file may state the conversion of a channel as a formula, i.e. as text that asammdf hands
to `eval` through numexpr or sympy: to read such a channel would run a program from the file.
Therefore asammdf returns raw values only, without its conversions, which are taken away from
every channel as soon as the file is open, that of the times included. Linear, rational and
table conversions are computed here, formulas are refused. Neither attachments nor bus messages
are decoded, for which asammdf would read other files.

asammdf follows the links between blocks without end and unpacks them without limit; both are
checked before.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from io import BytesIO
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import Floats
from drysim.records.columns import (
    KNOWN_TIMES,
    Channel,
    Channels,
    Format,
    RecordFile,
    make_channels,
    require_plausible_size,
    shorten_quote,
)
from drysim.records.packages import (
    UNUSED_KEYS,
    call_package,
    import_package,
    label_of_samples,
    label_of_times,
)

NOT_MDF = "the record is not an MDF file, or it is damaged"

MAX_PACKED_ROW_SIZE = 1 << 20
"""Bytes of a row of samples that a small compressed file may contain."""


class MdfChannel(NamedTuple):
    """Numbers of a group and of a channel in it, name and unit."""

    group: int
    number: int
    name: str
    unit: str


def mdf_columns(file: RecordFile) -> Channels:
    """Return the channels of all groups of an MDF file, followed by their times."""
    asammdf = import_package("asammdf", "mdf", file)
    _check_version(file)
    _check_blocks(file)

    def read() -> list[MdfChannel]:
        """Return every channel of samples that is no time axis."""
        with _open_raw(asammdf, file) as (whole, _):
            return [
                MdfChannel(group, index, str(channel.name), str(channel.unit or "").strip())
                for group, content in enumerate(whole.groups)
                for index, channel in enumerate(content.channels)
                if whole.masters_db.get(group) != index
            ]

    channels = call_package(read, file, NOT_MDF)
    if not channels:
        raise file.error("the MDF file has no channels")
    series = [
        Channel(
            label_of_samples(channel.name, channel.unit),
            partial(_load_samples, asammdf, file, channel),
            time_column=len(channels) + number,
        )
        for number, channel in enumerate(channels)
    ]
    times = [
        Channel(label_of_times(channel.name, "s"), partial(_load_times, asammdf, file, channel))
        for channel in channels
    ]
    return make_channels(file, [*series, *times])


def _check_version(file: RecordFile) -> None:
    """Require version 4, whose conversions are known here."""
    identification, version = file.raw[:8], file.raw[8:16]
    if identification not in (b"MDF     ", b"UnFinMF "):
        raise file.error(f"{NOT_MDF}: its header is invalid")
    number = version.decode("latin-1").strip(" \0")
    if not number.startswith("4."):
        sentence = f"the MDF file is of version {shorten_quote(number)}; only version 4 is"
        raise file.error(f"{sentence} supported: export the measurement as MF4")


# Raw values.


@contextmanager
def _open_raw(asammdf: Any, file: RecordFile) -> Iterator[tuple[Any, dict[int, Any]]]:
    """Open a file without its conversions, which are yielded by the `id` of their channel."""
    with asammdf.MDF(BytesIO(file.raw), process_bus_logging=False) as whole:
        conversions = {}
        for group in whole.groups:
            for channel in group.channels:
                conversions[id(channel)] = channel.conversion
                channel.conversion = None
        yield whole, conversions


def _load_samples(asammdf: Any, file: RecordFile, wanted: MdfChannel) -> NDArray[np.generic]:
    """Load physical values of a channel, without those marked as invalid."""

    def read() -> NDArray[np.generic]:
        with _open_raw(asammdf, file) as (whole, conversions):
            samples = np.asarray(_raw_signal(whole, file, wanted).samples)
            channel = whole.groups[wanted.group].channels[wanted.number]
            return _to_physical(
                file, f"`{shorten_quote(wanted.name)}`", samples, conversions[id(channel)]
            )

    return call_package(read, file, _cannot_be_read(wanted))


def _load_times(asammdf: Any, file: RecordFile, wanted: MdfChannel) -> NDArray[np.generic]:
    """Load the times of a channel, without those of invalid samples."""

    def read() -> NDArray[np.generic]:
        with _open_raw(asammdf, file) as (whole, conversions):
            signal = _raw_signal(whole, file, wanted)
            # 1 is time; other values are angle or distance.
            if signal.master_metadata[1] != 1:
                raise file.error(f"`{shorten_quote(signal.name)}` is not sampled over time")
            times, master = np.asarray(signal.timestamps), _master(whole, wanted.group)
            conversion = None if master is None else conversions[id(master.channel)]
            return _to_physical(
                file, f"the time of `{shorten_quote(wanted.name)}`", times, conversion
            )

    return call_package(read, file, _cannot_be_read(wanted))


def _cannot_be_read(channel: MdfChannel) -> str:
    return f"channel {channel.number} of group {channel.group + 1} cannot be read"


def _raw_signal(whole: Any, file: RecordFile, wanted: MdfChannel) -> Any:
    """Return raw samples and raw times of a channel."""
    group = whole.groups[wanted.group]
    if group.channel_dependencies[wanted.number]:
        raise file.error(
            f"`{shorten_quote(wanted.name)}` is an array or a structure, not a series of "
            "numbers"
        )
    # Reject implausible sizes before the package allocates memory for them.
    about = group.channel_group
    size = about.samples_byte_nr + about.invalidation_bytes_nr
    if size > max(len(file.raw), MAX_PACKED_ROW_SIZE):
        raise file.error(f"{NOT_MDF}: one row of {size} bytes")
    require_plausible_size(file, size * about.cycles_nr)
    _require_numbers_in_rows(whole, file, wanted.group, group.channels[wanted.number])
    if (master := _master(whole, wanted.group)) is not None:
        _require_numbers_in_rows(whole, file, master.group, master.channel)
    return whole.get(group=wanted.group, index=wanted.number, raw=True)


class Master(NamedTuple):
    """The channel with the times of a group, and the number of the group that it belongs to."""

    group: int
    channel: Any


def _master(whole: Any, group: int) -> Master | None:
    """Return the channel with the times of a group, which may belong to another group."""
    other = whole.groups[group].channel_group.cg_master_index
    group = group if other is None else other
    index = whole.masters_db.get(group)
    return None if index is None else Master(group, whole.groups[group].channels[index])


NUMBERS, COMPUTED = range(6), (3, 6)
"""Types of data that are numbers, and types of channels that count rows and store nothing."""

VALUE, MASTER, SYNCHRONISED = 0, 2, 4
"""Types of channels that are stored in the rows of their group."""


def _require_numbers_in_rows(whole: Any, file: RecordFile, group: int, channel: Any) -> None:
    """Raise unless a channel is stored as numbers within its rows; asammdf reads beyond."""
    if channel.channel_type in COMPUTED:
        return
    if channel.channel_type not in (VALUE, MASTER, SYNCHRONISED) or (
        channel.data_type not in NUMBERS
    ):
        raise file.error(f"`{shorten_quote(channel.name)}` is not a series of numbers")
    bits = 8 * channel.byte_offset + channel.bit_offset + channel.bit_count
    if bits > 8 * whole.groups[group].channel_group.samples_byte_nr:
        raise file.error(f"{NOT_MDF}: `{shorten_quote(channel.name)}` lies outside its rows")


# Conversions to physical values.


LINEAR, RATIONAL, FORMULA, INTERPOLATED_TABLE, TABLE, RANGES = range(1, 7)
VALUES_TO_TEXT, RANGES_TO_TEXT = 7, 8
"""Types of conversions; those of a higher number begin or end with text."""

CAN_BE_COMPUTED = "linear, rational and table conversions can be read"


def _to_physical(
    file: RecordFile, name: str, raw: NDArray[np.generic], conversion: Any
) -> NDArray[np.generic]:
    """Return physical values; `name` is that of the channel in messages.

    Raises
    ------
    RecordError
        If the conversion is a formula, or yields text.
    """
    if conversion is None or conversion.conversion_type == 0:
        return raw
    if raw.ndim != 1 or raw.dtype.kind not in "iufb":
        raise file.error(f"{name} is not a series of numbers")
    values = _convert(file, name, raw.astype(np.float64), conversion)
    if len(values) and np.isnan(values).all():
        raise file.error(f"{name} is converted to text; {CAN_BE_COMPUTED}")
    return values


def _convert(file: RecordFile, name: str, x: Floats, conversion: Any) -> Floats:
    """Return converted values, NaN where a value stands for text."""
    kind = conversion.conversion_type
    if kind == 0:
        return x
    if kind == LINEAR:
        return np.asarray(conversion.a * x + conversion.b)
    if kind == RATIONAL:
        p1, p2, p3, p4, p5, p6 = (conversion[f"P{k}"] for k in range(1, 7))
        return np.asarray(((p1 * x + p2) * x + p3) / ((p4 * x + p5) * x + p6))
    if kind in (INTERPOLATED_TABLE, TABLE):
        pairs = range(conversion.val_param_nr // 2)
        keys, values = (
            np.array([conversion[f"{word}_{k}"] for k in pairs]) for word in ("raw", "phys")
        )
        if kind == INTERPOLATED_TABLE:
            return np.asarray(np.interp(x, keys, values))
        # The nearest key counts, halfway between two of them the smaller one.
        nearest = np.searchsorted((keys[1:] + keys[:-1]) / 2, x)
        return np.asarray(np.where(np.isnan(x), x, values[nearest]))
    if kind == RANGES:
        values = np.where(np.isnan(x), x, conversion.default)
        for k in range((conversion.val_param_nr - 1) // 3):
            values[_in_range(x, conversion, k)] = conversion[f"phys_{k}"]
        return values
    if kind in (VALUES_TO_TEXT, RANGES_TO_TEXT):
        return _convert_in_parts(file, name, x, conversion)
    if kind == FORMULA:
        formula = shorten_quote(str(conversion.formula))
        why = f"is converted by the formula `{formula}`, which is not evaluated: a file could"
        raise file.error(
            f"{name} {why} run a program with it; {CAN_BE_COMPUTED}: export the channel with "
            "one of them, or with its physical values"
        )
    raise file.error(f"{name} is converted to or from text; {CAN_BE_COMPUTED}")


def _in_range(x: Floats, conversion: Any, k: int) -> NDArray[np.bool_]:
    """Return which values are in range number k.

    A range of whole numbers includes its end. If other numbers have the end of a range in
    common with the next one, that one counts: it is assigned later.
    """
    return np.asarray((conversion[f"lower_{k}"] <= x) & (x <= conversion[f"upper_{k}"]))


def _convert_in_parts(file: RecordFile, name: str, x: Floats, conversion: Any) -> Floats:
    """Return values of which some stand for text, such as `not available`, and give NaN."""
    targets = conversion.referenced_blocks
    by_value = conversion.conversion_type == VALUES_TO_TEXT
    numbers = range(conversion.ref_param_nr - 1)
    selected = np.full(len(x), -1)
    for k in numbers:
        selected[x == conversion[f"val_{k}"] if by_value else _in_range(x, conversion, k)] = k
    values = np.full(len(x), np.nan)
    for k, target in zip((*numbers, -1), (*targets.values(),), strict=True):
        if hasattr(target, "conversion_type"):  # a formula is refused even if none selects it
            values[selected == k] = _convert(file, name, x[selected == k], target)
    return values


# Links between blocks, and their size.


class MdfBlock(NamedTuple):
    """Type of a block, and the offsets of the blocks that it links to."""

    kind: bytes
    links: tuple[int, ...]


REQUIRED = {
    b"HD": {0: b"DG", 1: b"FH"},
    b"DG": {0: b"DG", 1: b"CG"},
    b"CG": {0: b"CG", 1: b"CN"},
    b"CN": {0: b"CN"},
    b"FH": {0: b"FH"},
}
"""Type that a link leads to if it is not 0, by type of block and number of the link."""

OTHERS = {b"HD": (2, 3, 4), b"DG": (2,), b"CN": (1, 5), b"CH": (0, 1)}
"""Further links that lead on, by type of block; of all other blocks the first."""

CHAINED = {b"DG", b"CG", b"CN", b"CA", b"CH", b"FH", b"AT", b"EV", b"DL", b"LD", b"HL"}
"""Types of blocks of which each belongs to one chain."""

HEADER_OFFSET, LINKS_OFFSET = 64, 24
"""Offset of the first block in the file, and of the links in a block."""

MAX_NESTED = 10_000
"""Conversions that one conversion may refer to, directly and indirectly."""

MAX_DEPTH = 100
"""Levels to which conversions may be nested."""

CONVERSION_LINK = 4
"""Number of the link from a channel to its conversion."""


def _check_blocks(file: RecordFile) -> None:
    """Raise if links form a loop, or compressed blocks unpack beyond what they state."""
    seen, nested = set[int](), dict[int, int]()
    pending = [HEADER_OFFSET]
    while pending:
        offset = pending.pop()
        block = _read_block(file.raw, offset)
        if offset in seen:
            raise file.error(f"{NOT_MDF}: its blocks form a loop")
        seen.add(offset)
        required = REQUIRED.get(block.kind, {})
        for k in {*required, *OTHERS.get(block.kind, () if required else (0,))}:
            to = block.links[k] if k < len(block.links) else 0
            kind = _read_block(file.raw, to).kind
            if to and kind != required.get(k, kind):
                raise file.error(f"{NOT_MDF}: a link leads to no block of its type")
            # The signal data of a channel may be another group, whose turn comes anyway.
            if kind in CHAINED and not (block.kind == b"CN" and kind == b"CG"):
                pending.append(to)
        if block.kind == b"CN" and len(block.links) > CONVERSION_LINK:
            _count_nested(file, nested, block.links[CONVERSION_LINK])
    _check_compressed(file)


def _read_block(raw: bytes, offset: int) -> MdfBlock:
    """Return the block at an offset; without type and links if there is none."""
    if not 0 < offset <= len(raw) - LINKS_OFFSET or raw[offset : offset + 2] != b"##":
        return MdfBlock(b"", ())
    (count,) = struct.unpack_from("<Q", raw, offset + 16)
    count = min(count, (len(raw) - offset - LINKS_OFFSET) // 8)
    return MdfBlock(
        raw[offset + 2 : offset + 4],
        struct.unpack_from(f"<{count}Q", raw, offset + LINKS_OFFSET),
    )


def _count_nested(file: RecordFile, nested: dict[int, int], offset: int, depth: int = 0) -> int:
    """Return the number of conversions that a conversion consists of; raise for loops."""
    if depth > MAX_DEPTH:
        raise file.error(f"{NOT_MDF}: its conversions are nested too deeply")
    if offset not in nested:
        nested[offset] = MAX_NESTED  # what a loop finds
        block = _read_block(file.raw, offset)
        inner = block.links[4:] if block.kind == b"CC" else ()
        parts = [to for to in inner if _read_block(file.raw, to).kind == b"CC"]
        nested[offset] = 1 + sum(_count_nested(file, nested, to, depth + 1) for to in parts)
        if nested[offset] > MAX_NESTED:
            raise file.error(f"{NOT_MDF}: its conversions refer to one another without end")
    return nested[offset]


def _check_compressed(file: RecordFile) -> None:
    """Raise if the compressed blocks are larger than they state, or implausibly large."""
    raw, offset, total = file.raw, file.raw.find(b"##DZ"), 0
    while offset >= 0:
        head = raw[offset + LINKS_OFFSET : offset + 48]
        if len(head) == 24:
            kind, size, packed = struct.unpack("<2xB5xQQ", head)
            total += size
            require_plausible_size(file, total)
            if kind < 2 and _unpacks_beyond(raw[offset + 48 : offset + 48 + packed], size):
                raise file.error(f"{NOT_MDF}: a compressed block is larger than it states")
        offset = raw.find(b"##DZ", offset + 4)


def _unpacks_beyond(packed: bytes, size: int) -> bool:
    """Whether deflated bytes unpack to more than a size."""
    try:
        return len(zlib.decompressobj().decompress(packed, size + 1)) > size
    except zlib.error:
        return False  # damaged, which asammdf reports where the block is read


MDF = Format("an MDF", mdf_columns, {**UNUSED_KEYS, **KNOWN_TIMES})
