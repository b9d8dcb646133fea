"""MAT files of versions 5 to 7: tagged elements, each a variable, packed or not."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.excitation.record.file import File, fit
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

ROOM = 64
"""Bytes beside the numbers: their tag, and what tells that nothing is missing behind them."""

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
    order = ORDERS.get(file.raw[HEAD - 2 : HEAD])
    given = Bytes(file, file.raw, order or "<")
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
    """Give the bytes of a variable from its tag on, at most so many where it is packed."""
    end = element.start + element.size
    if element.kind == MATRIX:
        return given._replace(raw=given.raw[element.start - 8 : end])
    packed, unpacker = given.raw[element.start : end], zlib.decompressobj()
    try:
        raw = unpacker.decompress(packed, most)
    except zlib.error:
        raise given.damaged("a variable cannot be unpacked") from None
    if len(raw) < most and not unpacker.eof:
        raise given.damaged("a variable is not packed whole")
    return given._replace(raw=raw)


def _load(given: Bytes, element: Element, at: int, count: int) -> NDArray[np.generic]:
    fit(given.file.shown, 8 * count)
    inner = _unpacked(given, element, at + ROOM + 8 * count)
    numbers = _element(inner, at)
    kind = NUMBERS.get(numbers.kind)
    if kind is None or numbers.size != count * np.dtype(kind).itemsize:
        raise given.damaged("the numbers of a variable do not fit its shape")
    return inner.numbers(numbers.start, count, kind)
