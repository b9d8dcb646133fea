"""The shortest decimal that reads back as the same double, as `repr` has it.

Schubfach (Giulietti, "The Schubfach way to render doubles", 2020): the interval of all
decimals that round to a double, and the shortest one in it, in whole numbers of 64 bits.
Compiled only: plain Python has `repr`.
"""

from __future__ import annotations

import numpy as np

from drysim.core.compiled import compiled

FIRST, LAST = -292, 324
"""Powers of ten that a double may need."""

# Compiled code makes a floating-point number of a signed and an unsigned one: so no bare ints.
ONE, TWO, FOUR, TEN, FORTY = (np.uint64(value) for value in (1, 2, 4, 10, 40))
FRACTION, HIDDEN, EXPONENT = (np.uint64(bits) for bits in (2**52 - 1, 2**52, 2**11 - 1))
LOW, HALF, MANTISSA = np.uint64(2**32 - 1), np.uint64(32), np.uint64(52)


def log2_of_power(k: int) -> int:
    """Give the whole part of log2(10^k)."""
    return (k * 1741647) >> 19


def powers_of_ten() -> tuple[np.ndarray, np.ndarray]:
    """Give 10^k as 128 bits rounded up, upper and lower half; the first bit is set."""
    found = np.empty((2, LAST - FIRST + 1), np.uint64)
    for k in range(FIRST, LAST + 1):
        shift = log2_of_power(k) - 127
        over, under = 10 ** max(k, 0) << max(-shift, 0), 10 ** max(-k, 0) << max(shift, 0)
        power = -(-over // under)
        found[:, k - FIRST] = power >> 64, power & (2**64 - 1)
    return found[0], found[1]


UPPER, LOWER = powers_of_ten()


@compiled
def product(a, b):
    """Give the upper and the lower 64 bits of a product."""
    a_1, a_0, b_1, b_0 = a >> HALF, a & LOW, b >> HALF, b & LOW
    low, left, right = a_0 * b_0, a_0 * b_1, a_1 * b_0
    middle = (low >> HALF) + (left & LOW) + (right & LOW)
    upper = a_1 * b_1 + (left >> HALF) + (right >> HALF) + (middle >> HALF)
    return upper, (low & LOW) | (middle << HALF)


@compiled
def scaled(upper, lower, c):
    """Give c times a power of ten, its last bit set when anything was cut off."""
    carry, _ = product(lower, c)
    whole, rest = product(upper, c)
    rest += carry
    if rest < carry:
        whole += ONE
    return whole | np.uint64(rest > ONE)


@compiled
def shortest(bits):
    """Give s and k of the shortest decimal s·10^k within a finite double, and the closest."""
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
