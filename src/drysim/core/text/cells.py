"""Rows of CSV of cases: numbers that may be missing or whole, and a word.

Compiled only: plain Python has `repr`.
"""

from __future__ import annotations

import numpy as np

from drysim.core.compiled import compiled
from drysim.core.text.decimal import EXPONENT, FRACTION, MANTISSA
from drysim.core.text.digits import put


@compiled
def put_word(out, at, word):
    """Write a word of ASCII, zeros left out; gives the place behind it."""
    for letter in word:
        if letter:
            out[at] = letter
            at += 1
    return at


@compiled
def put_cases(columns, whole, name, codes, words, place, out):
    """Write rows of CSV: a name, then columns of numbers, and one of words between them.

    Parameters
    ----------
    columns : array of uint64, shape (columns, rows)
        The bits of the numbers; nothing is written for NaN.
    whole : array of bool, shape (columns,)
        Which columns hold whole numbers, written without a point.
    name : array of uint8
        ASCII, the first cell of every row.
    codes, words, place, out
        As in `put_rows`.

    Returns
    -------
    int
        Bytes written.
    """
    at = 0
    for row in range(len(codes)):
        at = put_word(out, at, name)
        for column in range(len(columns) + 1):
            out[at] = 44
            at += 1
            if column == place:
                at = put_word(out, at, words[codes[row]])
                continue
            i = column - (column > place)
            bits = columns[i, row]
            if (bits >> MANTISSA) & EXPONENT == EXPONENT and bits & FRACTION != np.uint64(0):
                continue
            at = put(out, at, bits)
            if whole[i]:
                at -= 2
        out[at] = 10
        at += 1
    return at
