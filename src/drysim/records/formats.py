"""File formats of records by suffix: text, MAT, WAV, MDF, TDMS, UFF and RPC III.

MAT (versions 4 to 7) and WAV are read here, not by `scipy.io`, for two reasons. Safety: the MAT
reader of scipy 1.17 ended 7 of 6,000 damaged files with a segmentation fault, and a check that
excludes this has to parse the same tags and sizes. Memory: long series stay in the file until
they are needed, as records may be larger than memory. Vibration recorders write WAV files
without a unit.

The other formats are read by optional packages (`drysim.records.packages`): asammdf (MDF 4,
automotive measurements, `drysim.records.mdf`), npTDMS (LabVIEW), pyuff (universal files, data
set 58), rpc3-file (RPC III, test rigs of MTS).
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import Floats
from drysim.errors import RecordError
from drysim.records import text
from drysim.records.columns import (
    FLOAT64_SIZE,
    KNOWN_STEP,
    KNOWN_TIMES,
    NO_FULL_SCALE,
    NOT_TEXT,
    USE_CHANNEL,
    USE_COLUMN,
    Channel,
    Channels,
    ColumnLabel,
    Format,
    LazySamples,
    Reader,
    RecordFile,
    make_channels,
    open_record,
    require_plausible_size,
    shorten_quote,
)
from drysim.records.mdf import MDF
from drysim.records.packages import (
    UNUSED_KEYS,
    call_package,
    import_package,
    label_of_samples,
    label_of_times,
)
from drysim.units import conversion_factor

# MAT: variables of MATLAB.


class MatVariable(NamedTuple):
    """A full array of real numbers, loaded on demand."""

    name: str
    shape: tuple[int, ...]
    load: Callable[[], Floats | LazySamples]


class ByteView(NamedTuple):
    """Bytes of a file, or decompressed bytes; `order` is the byte order, `<` or `>`."""

    file: RecordFile
    raw: Reader | bytes
    order: str

    def whole(self, offset: int) -> int:
        """Return an unsigned integer of four bytes."""
        return int(self.numbers(offset, 1, "u4")[0])

    def numbers(self, offset: int, count: int, kind: str) -> NDArray[np.generic]:
        """Return numbers of a type."""
        return np.frombuffer(
            self.raw[offset : self.end_of(offset, count, kind)], self.order + kind
        )

    def end_of(self, offset: int, count: int, kind: str) -> int:
        """Return the end offset of numbers of a type; raise if the file ends before."""
        end = offset + count * np.dtype(kind).itemsize
        if offset < 0 or end > len(self.raw):
            raise self.damaged("bytes are missing at its end")
        return end

    def text(self, offset: int, size: int) -> str:
        """Return text up to the first zero byte."""
        return self.numbers(offset, size, "u1").tobytes().split(b"\0")[0].decode("latin-1")

    def lazy(self, offset: int, count: int, kind: str) -> LazySamples:
        """Return numbers that are read on demand."""
        self.end_of(offset, count, kind)
        return LazySamples(partial(self._part, offset, kind), 0, count)

    def _part(self, offset: int, kind: str, first: int, last: int) -> Floats:
        start = self.end_of(offset, first, kind)
        return self.numbers(start, last - first, kind).astype(np.float64)

    def damaged(self, what: str) -> RecordError:
        """Return the error for a damaged file."""
        return self.file.error(f"the record is not a MAT file, or it is damaged: {what}")


MAT4_TYPES = ("f8", "f4", "i4", "i2", "u2", "u1")
"""Number types of version 4, by the tens digit of the matrix type."""

MAT4_HEADER_SIZE = 20
"""Size of the five integers: type, rows, columns, imaginary part, length of the name."""


def _read_mat4(file: RecordFile) -> list[MatVariable]:
    """Read version 4: matrices, each preceded by five integers and its name."""
    offset, variables = 0, []
    while offset < len(file.reader):
        order = "<" if ByteView(file, file.reader, "<").whole(offset) < 1000 else ">"
        view = ByteView(file, file.reader, order)
        kind, rows, wide, imaginary, named = (int(n) for n in view.numbers(offset, 5, "u4"))
        number = kind // 10 % 100
        if kind // 1000 != (order == ">") or number >= len(MAT4_TYPES):
            raise view.damaged(f"a matrix is of type {kind}")
        name, start = (
            view.text(offset + MAT4_HEADER_SIZE, named),
            offset + MAT4_HEADER_SIZE + named,
        )
        count, of = rows * wide, MAT4_TYPES[number]
        if kind % 10 == 0 and not imaginary:  # others are text and sparse matrices
            variables.append(
                MatVariable(name, (rows, wide), partial(view.lazy, start, count, of))
            )
        offset = view.end_of(start, count * (2 if imaginary else 1), of)
    return variables


MAT5_HEADER_SIZE = 128
"""Bytes before the first element; the last two contain the byte order."""

MAT5_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8"}
MAT5_TYPES |= {13: "u8"}
MATRIX, COMPRESSED = 14, 15
"""Element types."""

TAG_SIZE, CHECKED_MARGIN = 8, 64
"""Bytes of a tag, and of the margin read behind the numbers to detect truncated data."""

DECOMPRESSED_AT_ONCE = 1 << 20
"""Bytes decompressed at a time."""

VARIABLE_HEADER_SIZE = 1 << 12
"""Decompressed bytes that contain everything before the numbers: flags, shape and name."""


class Mat5Element(NamedTuple):
    """Type of an element, offset and size of its contents, and offset of the next element."""

    kind: int
    start: int
    size: int
    next: int


def _read_mat5(file: RecordFile) -> list[MatVariable]:
    """Read versions 5 to 7: tagged elements, each a variable, compressed or not."""
    order = {b"IM": "<", b"MI": ">"}.get(file.reader[MAT5_HEADER_SIZE - 2 : MAT5_HEADER_SIZE])
    view = ByteView(file, file.reader, order or "<")
    if order is None:
        raise view.damaged("its header is invalid")
    offset, variables = MAT5_HEADER_SIZE, []
    while offset < len(view.raw):
        element = _read_element(view, offset)
        end = element.start + element.size
        if end > len(view.raw):
            raise view.damaged(f"{end - len(view.raw)} bytes are missing at its end")
        if (variable := _read_variable(view, element)) is not None:
            variables.append(variable)
        offset = end if element.kind == COMPRESSED else element.next
    return variables


def _read_element(view: ByteView, offset: int) -> Mat5Element:
    """Return the element at an offset; short elements have 8 bytes including the tag."""
    kind = view.whole(offset)
    if kind >> 16:
        return Mat5Element(kind & 0xFFFF, offset + 4, kind >> 16, offset + 8)
    size = view.whole(offset + 4)
    return Mat5Element(kind, offset + 8, size, offset + 8 + size + -size % 8)


def _read_variable(view: ByteView, element: Mat5Element) -> MatVariable | None:
    """Return the variable of an element if it is a full array of real numbers."""
    if element.kind not in (MATRIX, COMPRESSED):
        return None
    inner = _first_bytes(view, element, VARIABLE_HEADER_SIZE)
    flags = _read_element(inner, 8)
    shape = _read_element(inner, flags.next)
    name = _read_element(inner, shape.next)
    marks = inner.whole(flags.start)
    # Accept full numeric arrays (classes 6 to 15) without imaginary part.
    if marks & 0xFF not in range(6, 16) or marks & 0x800:
        return None
    sizes = inner.numbers(shape.start, shape.size // 4, "u4").tolist()
    load = partial(_load_mat5, view, element, name.next, int(np.prod(sizes, dtype=object)))
    return MatVariable(inner.text(name.start, name.size), tuple(sizes), load)


def _first_bytes(view: ByteView, element: Mat5Element, most: int) -> ByteView:
    """Return at least the first `most` bytes of a variable, from its tag on."""
    if element.kind == MATRIX:
        begin = element.start - 8
        return view._replace(raw=view.raw[begin : min(begin + most, begin + 8 + element.size)])
    raw = b""
    for piece in _decompress(view, element):
        raw += piece
        if len(raw) >= most:
            break
    return view._replace(raw=raw)


def _decompress(view: ByteView, element: Mat5Element) -> Iterator[bytes]:
    """Yield the decompressed bytes of a variable in blocks."""
    offset, end, unpacker = element.start, element.start + element.size, zlib.decompressobj()
    packed = b""
    while not unpacker.eof:
        if not packed:
            packed = view.raw[offset : min(offset + DECOMPRESSED_AT_ONCE, end)]
            offset += len(packed)
        try:
            piece = unpacker.decompress(packed, DECOMPRESSED_AT_ONCE)
        except zlib.error:
            raise view.damaged("a variable cannot be decompressed") from None
        packed = unpacker.unconsumed_tail
        if not (piece or packed or offset < end or unpacker.eof):
            raise view.damaged("a compressed variable is truncated")
        yield piece


def _load_mat5(
    view: ByteView, element: Mat5Element, offset: int, count: int
) -> Floats | LazySamples:
    inner = _first_bytes(view, element, offset + TAG_SIZE)
    numbers = _read_element(inner, offset)
    kind = MAT5_TYPES.get(numbers.kind)
    if kind is None or numbers.size != count * np.dtype(kind).itemsize:
        raise view.damaged("the size of a variable does not match its shape")
    if element.kind == MATRIX:
        if numbers.start + numbers.size > 8 + element.size:
            raise view.damaged("the numbers of a variable exceed its size")
        return view.lazy(element.start - 8 + numbers.start, count, kind)
    return _read_compressed(view, element, numbers.start, count, kind)


def _read_compressed(
    view: ByteView, element: Mat5Element, skip: int, count: int, kind: str
) -> Floats:
    """Return the numbers of a compressed variable after `skip` decompressed bytes."""
    require_plausible_size(view.file, FLOAT64_SIZE * count)
    values, done, rest = np.empty(count), 0, b""
    for piece in _decompress(view, element):
        rest, skip = rest + piece[skip:], max(skip - len(piece), 0)
        if done == count and len(rest) > CHECKED_MARGIN:
            break
        whole = min(len(rest) // np.dtype(kind).itemsize, count - done)
        part = view._replace(raw=rest).numbers(0, whole, kind)
        values[done : done + whole] = part
        done, rest = done + whole, rest[part.nbytes :]
    if done < count:
        raise view.damaged("bytes are missing at its end")
    return values


def _mat_remedy(variables: list[MatVariable]) -> str:
    """Return how to save the columns of a matrix, or the fields of a structure, as vectors."""
    matrices = (variable for variable in variables if min(variable.shape) > 1)
    if (matrix := next(matrices, None)) is not None:
        shape, name = "x".join(map(str, matrix.shape)), shorten_quote(matrix.name)
        return (
            f": `{name}` is a matrix, {shape}; save its columns one by one, in MATLAB: "
            f"`a = {name}(:, 1); save('record.mat', 'a', '-v7')`"
        )
    return (
        "; save the fields of a structure or table one by one, in MATLAB: "
        "`a = s.a; save('record.mat', 'a', '-v7')`"
    )


def mat_columns(file: RecordFile) -> Channels:
    """Return the real vectors among the variables of a MAT file."""
    head = file.reader[:1024]
    if head[:10] == b"MATLAB 7.3" or b"\x89HDF\r\n\x1a\n" in head:
        sentence = (
            "the MAT file is of version 7.3, which is not supported; save it with `save -v7`"
        )
        raise file.error(sentence)
    # Version 5 begins with text; the first integer of version 4 contains a zero byte.
    variables = _read_mat4(file) if 0 in head[:4] else _read_mat5(file)
    vectors = [
        Channel(ColumnLabel(variable.name, variable.name), variable.load)
        for variable in variables
        if len(variable.shape) == 2 and min(variable.shape) == 1 < max(variable.shape)
    ]
    if not vectors:
        raise file.error(
            f"the MAT file contains no vector of real numbers{_mat_remedy(variables)}"
        )
    return make_channels(file, vectors, word="variable", key="column")


MAT = Format(
    "a MAT file",
    mat_columns,
    {**NOT_TEXT, "channel": USE_COLUMN, "full_scale": NO_FULL_SCALE},
)


# WAV: sound files.


PCM, FLOAT, EXTENSIBLE = 1, 3, 0xFFFE
"""Format codes; with the extensible format the code is stored further on."""

SAMPLE_TYPES = {
    (PCM, 8): "u1",
    (PCM, 16): "<i2",
    (PCM, 24): "u1",
    (PCM, 32): "<i4",
    (FLOAT, 32): "<f4",
    (FLOAT, 64): "<f8",
}
"""numpy type by format code and bits; 24-bit samples are read as three bytes."""


class WavFormat(NamedTuple):
    """Layout of the samples of a WAV file; `rate` is in Hz."""

    code: int
    bits: int
    channels: int
    rate: int


def wav_columns(file: RecordFile) -> Channels:
    """Return the channels of a WAV file."""
    form, start, size = _read_chunks(file)
    each = form.bits // 8 * form.channels
    if size < each:
        raise file.error("the WAV contains no samples")
    if size % each:
        raise _wav_error(file, "its last sample is incomplete")
    channels = []
    for number in range(form.channels):
        read = partial(_read_samples, file, start, form, number)
        load = partial(LazySamples, read, 0, size // each)
        channels.append(Channel(ColumnLabel(), load, 1 / form.rate))
    return make_channels(file, channels, normalised=form.code == PCM)


def _read_chunks(file: RecordFile) -> tuple[WavFormat, int, int]:
    """Return the layout of the samples, their offset and size."""
    raw, offset, form = file.reader, 12, None
    if raw[:4] in (b"RF64", b"RIFX"):
        kind = raw[:4].decode()
        raise file.error(f"the WAV is {kind}; only RIFF is supported: convert it")
    if raw[:4] != b"RIFF" or raw[8:12] != b"WAVE":
        raise file.error("the record is not a WAV file: it has no RIFF header")
    while offset + 8 <= len(raw):
        name, size = struct.unpack("<4sI", raw[offset : offset + 8])
        if offset + 8 + size > len(raw):
            missing = offset + 8 + size - len(raw)
            raise _wav_error(file, f"{missing} bytes are missing at its end")
        if name == b"fmt ":
            form = _parse_format_chunk(file, raw[offset + 8 : offset + 8 + size])
        if name == b"data":
            if form is None:
                raise _wav_error(file, "its samples precede their format")
            return form, offset + 8, size
        offset += 8 + size + size % 2
    raise _wav_error(file, "it has no samples")


def _parse_format_chunk(file: RecordFile, chunk: bytes) -> WavFormat:
    """Parse the `fmt ` chunk."""
    if len(chunk) < 16:
        raise _wav_error(file, "the format of its samples is too short")
    code, channels, rate, _, each, bits = struct.unpack_from("<HHIIHH", chunk)
    if code == EXTENSIBLE and len(chunk) >= 26:
        (code,) = struct.unpack_from("<H", chunk, 24)
    if (code, bits) not in SAMPLE_TYPES:
        kinds = "integers of 8, 16, 24, 32 bits and floating point of 32, 64"
        sentence = f"the WAV has samples of {bits} bits in format {code}; supported: {kinds}"
        raise file.error(sentence)
    if not channels or not rate:
        raise _wav_error(file, f"it has {channels} channels at {rate} Hz")
    if each != bits // 8 * channels:
        raise _wav_error(file, "its sample sizes are inconsistent")
    return WavFormat(code, bits, channels, rate)


def _read_samples(
    file: RecordFile, start: int, form: WavFormat, number: int, first: int, last: int
) -> Floats:
    """Return samples of a channel; integers are scaled to fractions of full scale."""
    code, bits, channels, _ = form
    each = bits // 8 * channels
    flat = np.frombuffer(
        file.reader[start + first * each : start + last * each], SAMPLE_TYPES[code, bits]
    )
    frames = flat.reshape(last - first, channels, -1)[:, number]
    if code == PCM and bits == 24:
        wide = np.zeros((len(frames), 4), np.uint8)
        wide[:, 1:] = frames
        return wide.view("<i4")[:, 0] / 2.0**31
    fractions = frames[:, 0].astype(np.float64)
    if code == FLOAT:
        return fractions
    if bits == 8:
        fractions -= 128.0
    fractions /= 2.0 ** (bits - 1)
    return fractions


def _wav_error(file: RecordFile, what: str) -> RecordError:
    return file.error(f"the WAV is truncated or damaged: {what}")


WAV = Format("a WAV", wav_columns, {**NOT_TEXT, "column": USE_CHANNEL, **KNOWN_STEP})


# Formats read by optional packages.
# TDMS.


UNIT_PROPERTIES = ("unit_string", "NI_UnitDescription")
"""Properties that may contain the unit of a channel."""


def tdms_columns(file: RecordFile) -> Channels:
    """Return the channels of all groups of a TDMS file."""
    nptdms = import_package("nptdms", "tdms", file)

    def read() -> list[Channel]:
        whole = nptdms.TdmsFile.read_metadata(BytesIO(file.raw))
        if whole.file_status.incomplete_final_segment:
            raise file.error("the TDMS file is truncated: its last segment is incomplete")
        return [
            _tdms_channel(nptdms, file, channel)
            for group in whole.groups()
            for channel in group.channels()
        ]

    channels = call_package(read, file, "the record is not a TDMS file, or it is damaged")
    if not channels:
        raise file.error("the TDMS file has no channels")
    return make_channels(file, channels)


def _tdms_channel(nptdms: Any, file: RecordFile, channel: Any) -> Channel:
    group, name, properties = channel.group_name, channel.name, channel.properties
    unit = next(
        (str(properties[key]).strip() for key in UNIT_PROPERTIES if properties.get(key)), ""
    )
    step = float(properties.get("wf_increment", 0.0))
    return Channel(
        ColumnLabel(f"{group}/{name}", name, unit, is_unit_certain=False),
        partial(_load_tdms, nptdms, file, group, name),
        step if step > 0 else None,
        float(properties.get("wf_start_offset", 0.0)),
    )


def _load_tdms(nptdms: Any, file: RecordFile, group: str, name: str) -> NDArray[np.generic]:
    def read() -> NDArray[np.generic]:
        with nptdms.TdmsFile.open(BytesIO(file.raw)) as whole:
            return np.asarray(whole[group][name][:])

    return call_package(read, file, f"channel `{shorten_quote(name)}` cannot be read")


TDMS = Format("a TDMS", tdms_columns, UNUSED_KEYS)


# UFF.


DATA_SET_DELIMITER = re.compile(rb"    -1(?= {74}|[\r\n]|\Z)")
"""The line that delimits data sets. After binary samples it does not start on a new line."""

NOT_UNIVERSAL = "the record is not a universal file, or it is damaged"

DIRECTIONS = ("", "+X", "+Y", "+Z", "+RX", "+RY", "+RZ", "-RZ", "-RY", "-RX", "-Z", "-Y", "-X")
"""By number; negative numbers count from the end."""


def uff_columns(file: RecordFile) -> Channels:
    """Return the time histories of a universal file, followed by their times."""
    pyuff = import_package("pyuff", "uff", file)
    if len(DATA_SET_DELIMITER.findall(file.raw)) % 2:
        raise file.error(f"{NOT_UNIVERSAL}: its last data set is not terminated")

    def read() -> list[tuple[Channel, Channel]]:
        """Return every time history with its times."""
        sets = pyuff.UFF(str(file.path))
        numbers = [n for n, kind in enumerate(sets.get_set_types()) if kind == 58]
        heads = [(n, sets.read_sets(n, header_only=True)) for n in numbers]
        # Function type 1 is a time response; data types 2 and 4 are real, others complex.
        return [
            _uff_channel(file, sets, n, head)
            for n, head in heads
            if head["func_type"] == 1 and head["ord_data_type"] in (2, 4)
        ]

    histories = call_package(read, file, NOT_UNIVERSAL)
    if not histories:
        sentence = "the record is not a universal file with a time history in a data set 58"
        raise file.error(sentence)
    series, times = [], list[Channel]()
    for channel, time_column in histories:
        if channel.dt is None:
            channel = channel._replace(time_column=len(histories) + len(times))
            times.append(time_column)
        series.append(channel)
    return make_channels(file, [*series, *times])


def _uff_channel(
    file: RecordFile, sets: Any, n: int, head: Mapping[str, Any]
) -> tuple[Channel, Channel]:
    """Return a time history and its times."""
    name = _header_text(head, "id1") or f"{head['rsp_node']}{DIRECTIONS[head['rsp_dir']]}"
    unit = _header_text(head, "ordinate_axis_units_lab")
    second = _header_text(head, "abscissa_axis_units_lab").lower()
    load = partial(_load_uff, file, sets, n, head["num_pts"])
    samples = Channel(label_of_samples(name, unit), partial(load, "data"))
    if head["abscissa_spacing"] == 1:
        try:
            factor = conversion_factor(second, "s") if second else 1.0
        except ValueError as error:
            raise file.error(f"the abscissa of a time history: {error}") from None
        samples = samples._replace(
            dt=head["abscissa_inc"] * factor, first=head["abscissa_min"] * factor
        )
    return samples, Channel(label_of_times(name, second), partial(load, "x"))


def _header_text(head: Mapping[str, Any], key: str) -> str:
    text = str(head[key]).strip()
    return "" if text.upper() == "NONE" else text


def _load_uff(
    file: RecordFile, sets: Any, n: int, count: int, what: str
) -> NDArray[np.generic]:
    where = f"data set {n + 1} cannot be read"
    values = call_package(lambda: np.asarray(sets.read_sets(n)[what]), file, where)
    if len(values) != count:
        sentence = f"data set {n + 1} is truncated or damaged"
        raise file.error(f"{sentence}: it has {len(values)} samples, not {count}")
    return values


UFF = Format("a universal file", uff_columns, {**UNUSED_KEYS, **KNOWN_TIMES})


# RPC III.


def rpc_columns(file: RecordFile) -> Channels:
    """Return the channels of an RPC III file.

    Integers are multiplied by the SCALE of their channel; INT_FULL_SCALE is not needed. A file
    without the number of SAMPLES ends with its last frame, including padding.
    """
    channels = _read_rpc(file, header_only=True)
    if not channels:
        raise file.error("the RPC III file has no channels")
    series = []
    for number, properties in enumerate(channels):
        name, unit = (
            str(text).strip().strip('"').strip() for text in (properties.name, properties.unit)
        )
        load = partial(_load_rpc, file, number)
        series.append(Channel(label_of_samples(name, unit), load, properties.dt))
    return make_channels(file, series)


def _load_rpc(file: RecordFile, number: int) -> NDArray[np.generic]:
    return np.asarray(_read_rpc(file, header_only=False)[number].data)


def _read_rpc(file: RecordFile, header_only: bool) -> Any:
    rpc3 = import_package("rpc3.rpc3", "rpc", file, "rpc3-file")

    def read() -> Any:
        rpc3.progressbar = False
        return rpc3.read(str(file.path), strip=False, header_only=header_only)[0]

    return call_package(
        read, file, "the record is not an RPC III time history, or it is damaged"
    )


RPC = Format("an RPC III file", rpc_columns, {**UNUSED_KEYS, **KNOWN_STEP})


# The registry of formats.


FORMATS_BY_SUFFIX = {
    ".csv": text.TEXT,
    ".tsv": text.TEXT,
    ".txt": text.TEXT,
    ".dat": text.TEXT,
    ".asc": text.TEXT,
    ".lvm": text.TEXT,
    ".wav": WAV,
    ".mat": MAT,
    ".at2": text.AT2,
    ".uff": UFF,
    ".unv": UFF,
    ".mf4": MDF,
    ".mdf": MDF,
    ".tdms": TDMS,
    ".rpc": RPC,
    ".rsp": RPC,
    ".tim": RPC,
    ".drv": RPC,
}
"""Format by lower-case suffix."""


def open_with_format(path: Path) -> tuple[RecordFile, Format]:
    """Return an opened record file and its format; raises like `open_record`."""
    return open_record(path, FORMATS_BY_SUFFIX), FORMATS_BY_SUFFIX[path.suffix.lower()]


def format_of(file: str | Path) -> Format | None:
    """Return the format for the suffix of a file, None if unsupported."""
    return FORMATS_BY_SUFFIX.get(Path(file).suffix.lower())
