"""MAT files of versions 5 to 7: tagged elements, each a variable, packed or not."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from drysim.excitation.record.channels import SIZE
from drysim.excitation.record.columns import Floats
from drysim.excitation.record.file import File, fit
from drysim.excitation.record.stored import Stored
from drysim.excitation.record.variable import Bytes, Variable

HEAD = 128
"""Bytes before the first element; the last two tell the byte order."""

ORDERS = {b"IM": "<", b"MI": ">"}

NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8"}
NUMBERS |= {13: "u8"}
MATRIX, PACKED = 14, 15
"""Types of elements."""

REAL = range(6, 16)
"""Classes of full arrays of numbers, from double to 64-bit whole numbers."""

COMPLEX = 0x800
"""Mark of an array with an imaginary part."""

TAG, BEHIND = 8, 64
"""Bytes of a tag, and more behind the numbers than belong to them: whoever unpacks so far has
seen that nothing is missing."""

BLOCK = 1 << 20
"""Bytes unpacked at a time."""

PREFACE = 1 << 12
"""Unpacked bytes that hold what stands before the numbers: flags, shape and name."""


class Element(NamedTuple):
    """Where the content of an element begins, its type and size, and where the next begins."""

    kind: int
    start: int
    size: int
    next: int


def variables(file: File) -> list[Variable]:
    """Give the full real arrays.

    Raises
    ------
    RecordError
        When the file is damaged.
    """
    order = ORDERS.get(file.reader[HEAD - 2 : HEAD])
    given = Bytes(file, file.reader, order or "<")
    if order is None:
        raise given.damaged("its head is none")
    return list(_variables(given))


def _variables(given: Bytes) -> Iterator[Variable]:
    at = HEAD
    while at < len(given.raw):
        element = _element(given, at)
        end = element.start + element.size
        if end > len(given.raw):
            raise given.damaged(f"{end - len(given.raw)} bytes are missing at its end")
        variable = _variable(given, element)
        if variable is not None:
            yield variable
        at = end if element.kind == PACKED else element.next


def _element(given: Bytes, at: int) -> Element:
    """Give the element at an offset; short ones hold type, size and content in eight bytes."""
    kind = given.whole(at)
    if kind >> 16:
        return Element(kind & 0xFFFF, at + 4, kind >> 16, at + 8)
    size = given.whole(at + 4)
    return Element(kind, at + 8, size, at + 8 + size + -size % 8)


def _variable(given: Bytes, element: Element) -> Variable | None:
    if element.kind not in (MATRIX, PACKED):
        return None
    inner = _unpacked(given, element, PREFACE)
    flags = _element(inner, 8)
    shape = _element(inner, flags.next)
    name = _element(inner, shape.next)
    marks = inner.whole(flags.start)
    if marks & 0xFF not in REAL or marks & COMPLEX:
        return None
    sizes = inner.numbers(shape.start, shape.size // 4, "u4").tolist()
    load = partial(_load, given, element, name.next, int(np.prod(sizes, dtype=object)))
    return Variable(inner.text(name.start, name.size), tuple(sizes), load)


def _unpacked(given: Bytes, element: Element, most: int) -> Bytes:
    """Give the first bytes of a variable from its tag on, so many at least if it has them."""
    if element.kind == MATRIX:
        begin = element.start - 8
        return given._replace(
            raw=given.raw[begin : min(begin + most, begin + 8 + element.size)]
        )
    raw = b""
    for piece in _pieces(given, element):
        raw += piece
        if len(raw) >= most:
            break
    return given._replace(raw=raw)


def _pieces(given: Bytes, element: Element) -> Iterator[bytes]:
    """Unpack a variable, so many bytes at a time that they are few beside its numbers."""
    at, end, unpacker = element.start, element.start + element.size, zlib.decompressobj()
    packed = b""
    while not unpacker.eof:
        if not packed:
            packed = given.raw[at : min(at + BLOCK, end)]
            at += len(packed)
        try:
            piece = unpacker.decompress(packed, BLOCK)
        except zlib.error:
            raise given.damaged("a variable cannot be unpacked") from None
        packed = unpacker.unconsumed_tail
        if not (piece or packed or at < end or unpacker.eof):
            raise given.damaged("a variable is not packed whole")
        yield piece


def _load(given: Bytes, element: Element, at: int, count: int) -> Floats | Stored:
    inner = _unpacked(given, element, at + TAG)
    numbers = _element(inner, at)
    kind = NUMBERS.get(numbers.kind)
    if kind is None or numbers.size != count * np.dtype(kind).itemsize:
        raise given.damaged("the numbers of a variable do not fit its shape")
    if element.kind == MATRIX:
        if numbers.start + numbers.size > 8 + element.size:
            raise given.damaged("the numbers of a variable are longer than itself")
        return given.stored(element.start - 8 + numbers.start, count, kind)
    return _filled(given, element, numbers.start, count, kind)


def _filled(given: Bytes, element: Element, skip: int, count: int, kind: str) -> Floats:
    """Give the numbers of a packed variable behind some unpacked bytes."""
    fit(given.file.shown, SIZE * count)
    values, done, rest = np.empty(count), 0, b""
    for piece in _pieces(given, element):
        rest, skip = rest + piece[skip:], max(skip - len(piece), 0)
        if done == count and len(rest) > BEHIND:
            break
        whole = min(len(rest) // np.dtype(kind).itemsize, count - done)
        part = given._replace(raw=rest).numbers(0, whole, kind)
        values[done : done + whole] = part
        done, rest = done + whole, rest[part.nbytes :]
    if done < count:
        raise given.damaged("bytes are missing at its end")
    return values
