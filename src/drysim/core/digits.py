"""Shortest decimal representation of floats as bytes, identical to `repr`.

Compiled only: plain Python uses `repr`. The result is the shortest decimal that reads back as
the same float, and of these the closest one, computed in 64-bit integers (R. Giulietti, "The
Schubfach way to render doubles", 2020).
"""

from __future__ import annotations

import numpy as np

from drysim.core.compile import compiled

WIDTH = 24
"""Characters of the longest number, -2.2250738585072014e-308."""

# Compiled code makes a floating-point number of a signed and an unsigned one: so no bare ints.
ONE, TWO, FOUR, TEN, FORTY = (np.uint64(value) for value in (1, 2, 4, 10, 40))
HUNDRED, MYRIAD, EIGHT, SIXTEEN = (np.uint64(10**digits) for digits in (2, 4, 8, 16))
FRACTION, HIDDEN, EXPONENT = (np.uint64(bits) for bits in (2**52 - 1, 2**52, 2**11 - 1))
LOW, HALF, MANTISSA, SIGN = np.uint64(2**32 - 1), np.uint64(32), np.uint64(52), np.uint64(63)

TENS, ONES = np.arange(100, dtype=np.uint8) // 10 + 48, np.arange(100, dtype=np.uint8) % 10 + 48
"""Both digits of every number below 100."""


# Rows of CSV.


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
                at = put_word(out, at, words[codes[row]])
            else:
                at = put(out, at, columns[column - (column > place), row])
            out[at] = 44
            at += 1
        out[at - 1] = 10
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


@compiled
def put_word(out, at, word):
    """Write a word of ASCII, zeros left out; gives the place behind it."""
    for letter in word:
        if letter:
            out[at] = letter
            at += 1
    return at


# A number as `repr` writes it.


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
def put_digits(out, at, s):
    """Write the 17 digits of s from a place on."""
    top = s // SIXTEEN
    s -= top * SIXTEEN
    upper = s // EIGHT
    out[at] = ONES[top]
    put_eight(out, at + 1, upper)
    put_eight(out, at + 9, s - upper * EIGHT)


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


# The shortest decimal.


FIRST, LAST = -292, 324
"""Powers of ten that a double may need."""


def powers_of_ten() -> tuple[np.ndarray, np.ndarray]:
    """Return 10^k as 128 bits rounded up, upper and lower half; the first bit is set."""
    found = np.empty((2, LAST - FIRST + 1), np.uint64)
    for k in range(FIRST, LAST + 1):
        shift = ((k * 1741647) >> 19) - 127  # the first: whole part of log2(10^k)
        over, under = 10 ** max(k, 0) << max(-shift, 0), 10 ** max(-k, 0) << max(shift, 0)
        power = -(-over // under)
        found[:, k - FIRST] = power >> 64, power & (2**64 - 1)
    return found[0], found[1]


UPPER, LOWER = powers_of_ten()


@compiled
def shortest(bits):
    """Return s and k of the shortest, then closest, decimal s·10^k of a finite double."""
    fraction = bits & FRACTION
    exponent = np.int64((bits >> MANTISSA) & EXPONENT)
    c, q = fraction | HIDDEN, exponent - 1075 + np.int64(exponent == 0)
    if exponent == 0:
        c = fraction
    elif -53 < q <= 0 and (c & ((ONE << np.uint64(-q)) - ONE)) == 0:
        return c >> np.uint64(-q), 0
    # Below a power of two the next double is half as far.
    closer = np.uint64(fraction == 0 and exponent > 1)
    k = (q * 1262611 - (524031 if closer else 0)) >> 22
    h = np.uint64(q + ((-k * 1741647) >> 19) + 1)
    upper, lower = UPPER[-k - FIRST], LOWER[-k - FIRST]
    odd = c & ONE  # the ends of its interval round to an even double only
    low = scaled(upper, lower, (FOUR * c - TWO + closer) << h) + odd
    middle = scaled(upper, lower, (FOUR * c) << h)
    high = scaled(upper, lower, (FOUR * c + TWO) << h) - odd
    s = middle >> TWO
    tenth = s // TEN
    below, above = low <= FORTY * tenth, FORTY * tenth + FORTY <= high
    if s >= TEN and below != above:
        return tenth + np.uint64(above), k + 1
    below, above = low <= FOUR * s, FOUR * s + FOUR <= high
    if below != above:
        return s + np.uint64(above), k
    half = FOUR * s + TWO
    return s + np.uint64(middle > half or (middle == half and (s & ONE) == ONE)), k


@compiled
def scaled(upper, lower, c):
    """Return c times a power of ten; the last bit is set if a remainder was cut off."""
    carry, _ = product(lower, c)
    whole, rest = product(upper, c)
    rest += carry
    if rest < carry:
        whole += ONE
    return whole | np.uint64(rest > ONE)


@compiled
def product(a, b):
    """Return the upper and the lower 64 bits of a product."""
    a_1, a_0, b_1, b_0 = a >> HALF, a & LOW, b >> HALF, b & LOW
    low, left, right = a_0 * b_0, a_0 * b_1, a_1 * b_0
    middle = (low >> HALF) + (left & LOW) + (right & LOW)
    upper = a_1 * b_1 + (left >> HALF) + (right >> HALF) + (middle >> HALF)
    return upper, (low & LOW) | (middle << HALF)
