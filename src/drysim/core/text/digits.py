"""Numbers written as text, character by character what `repr` gives; and rows of CSV of them.

Compiled only: plain Python has `repr`.
"""

from __future__ import annotations

import numpy as np

from drysim.core.compiled import compiled
from drysim.core.text.decimal import EXPONENT, FRACTION, MANTISSA, ONE, TEN, shortest

SIGN = np.uint64(63)
HUNDRED, MYRIAD, EIGHT, SIXTEEN = (np.uint64(10**digits) for digits in (2, 4, 8, 16))

TENS, ONES = np.arange(100, dtype=np.uint8) // 10 + 48, np.arange(100, dtype=np.uint8) % 10 + 48
"""Both digits of every number below 100."""

WIDTH = 24
"""Characters of the longest number, -2.2250738585072014e-308."""


@compiled
def put_eight(out, at, value):
    """Write the 8 digits of a number from a place on."""
    upper = value // MYRIAD
    lower = value - upper * MYRIAD
    a, c = upper // HUNDRED, lower // HUNDRED
    out[at], out[at + 1] = TENS[a], ONES[a]
    out[at + 4], out[at + 5] = TENS[c], ONES[c]
    b, d = upper - a * HUNDRED, lower - c * HUNDRED
    out[at + 2], out[at + 3] = TENS[b], ONES[b]
    out[at + 6], out[at + 7] = TENS[d], ONES[d]


@compiled
def put_digits(out, at, s):
    """Write the 17 digits of s from a place on."""
    top = s // SIXTEEN
    s -= top * SIXTEEN
    upper = s // EIGHT
    out[at] = ONES[top]
    put_eight(out, at + 1, upper)
    put_eight(out, at + 9, s - upper * EIGHT)


@compiled
def put_exponent(out, at, exponent):
    """Write an exponent of two digits at least; gives the place behind it."""
    out[at], out[at + 1] = 101, 45 if exponent < 0 else 43
    hundreds, rest = divmod(abs(exponent), 100)
    at += 2
    if hundreds:
        out[at] = ONES[hundreds]
        at += 1
    out[at], out[at + 1] = TENS[rest], ONES[rest]
    return at + 2


@compiled
def put(out, at, bits):
    """Write a double from a place on, -0.0 as 0.0; gives the place behind it."""
    if bits << ONE == 0:
        out[at], out[at + 1], out[at + 2] = 48, 46, 48
        return at + 3
    if (bits >> MANTISSA) & EXPONENT == EXPONENT:
        word = (110, 97, 110) if bits & FRACTION else (105, 110, 102)
        if bits >> SIGN and not bits & FRACTION:
            out[at] = 45
            at += 1
        out[at], out[at + 1], out[at + 2] = word
        return at + 3
    if bits >> SIGN:
        out[at] = 45
        at += 1
    s, k = shortest(bits)
    while s < SIXTEEN:
        s *= TEN
        k -= 1
    point = k + 17  # digits before the decimal point
    leading = 1 - point if -4 < point <= 0 else 0
    first = at + 1 + leading
    put_digits(out, first, s)
    count = 17
    while out[first + count - 1] == 48:
        count -= 1
    if leading:
        for i in range(at, first):
            out[i] = 48
        out[at + 1] = 46
        return first + count
    if 0 < point <= 16:
        for i in range(at, at + point):
            out[i] = out[i + 1]
        out[at + point] = 46
        return at + 1 + max(count, point + 1)
    out[at], out[at + 1] = out[first], 46
    return put_exponent(out, at + 1 + count if count > 1 else at + 1, point - 1)


@compiled
def put_rows(columns, codes, words, place, out):
    """Write rows of CSV: columns of numbers, and one of words between them.

    Parameters
    ----------
    columns : array of uint64, shape (columns, rows)
        The bits of the numbers.
    codes : array of int, shape (rows,)
        Number of the word in each row.
    words : array of uint8, shape (words, longest)
        ASCII, with zeros behind.
    place : int
        Columns of numbers before the words.
    out : array of uint8
        Written; a row may take `WIDTH` + 1 a number and the longest word + 1.

    Returns
    -------
    int
        Bytes written.
    """
    at = 0
    for row in range(len(codes)):
        for column in range(len(columns) + 1):
            if column == place:
                for letter in words[codes[row]]:
                    if letter:
                        out[at] = letter
                        at += 1
            else:
                at = put(out, at, columns[column - (column > place), row])
            out[at] = 44
            at += 1
        out[at - 1] = 10
    return at
