"""MAT files of version 4: a row of matrices, each behind five numbers and its name."""

from __future__ import annotations

from functools import partial

from drysim.excitation.record.file import File
from drysim.excitation.record.variable import Bytes, Variable

KINDS = ("f8", "f4", "i4", "i2", "u2", "u1")
"""Numbers, by the tens of a matrix's type."""

ORDERS = {"<": 0, ">": 1}
"""Byte order, as the thousands of the type say it."""

FULL = 0
"""The ones of the type; others are text and sparse matrices."""

HEAD = 20
"""Bytes of the five numbers: type, rows, columns, imaginary part, length of the name."""


def variables(file: File) -> list[Variable]:
    """Give the full real matrices.

    Raises
    ------
    RecordError
        When the file is damaged.
    """
    at, found = 0, []
    while at < len(file.reader):
        order = "<" if Bytes(file, file.reader, "<").whole(at) < 1000 else ">"
        given = Bytes(file, file.reader, order)
        kind, rows, wide, imaginary, named = (int(n) for n in given.numbers(at, 5, "u4"))
        number = kind // 10 % 100
        if kind // 1000 != ORDERS[order] or number >= len(KINDS):
            raise given.damaged(f"a matrix is of type {kind}")
        name, start = given.text(at + HEAD, named), at + HEAD + named
        count, of = rows * wide, KINDS[number]
        if kind % 10 == FULL and not imaginary:
            found.append(Variable(name, (rows, wide), partial(given.stored, start, count, of)))
        at = given.behind(start, count * (2 if imaginary else 1), of)
    return found
