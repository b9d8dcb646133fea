"""From sound input to damaged: what disks, cables, editors and ill will do to it."""

from __future__ import annotations

import random

SIGNS = (
    b"\0", b"\xff", b"\xef\xbb\xbf", b"\xff\xfe", b"\r", b"\r\n", b"\n", b"\t", b" ",
    b"\x1b[31m", b"\xc2\x85", b"\xe2\x80\xa8", b"\xe2\x80\xae", b"\xed\xa0\x80",
    b"\xf0\x9f\x92\xa5", b"\x7f", b"9", b"-", b".", b",", b";", b":", b": ", b"- ", b"?",
    b"? ", b"#", b"%", b"|", b">", b"'", b'"', b"\\", b"{", b"}", b"[", b"]", b"&a ", b"*a",
    b"<<: ", b"!!float ", b"!", b"@", b"`", b"null", b"~", b"true", b".inf", b"-.inf",
    b".nan", b"nan", b"inf", b"1e400", b"1e-400", b"1e308", b"-0.0", b"0", b"1_000",
    b"1:30", b"0x10", b"2024-01-01", b"1e99999999999999999999", b"1e-99999999999999999999",
    b"9" * 25, b"9" * 5000, b"0." + b"3" * 5000, b"\xce\xa9", b"\xb2", b" mm", b" g", b" %",
    b" periods", b" deg", b"1/", b"m^9", b"../", b"/dev/zero", b"a.b.c", b" at ", b" and ",
    b"<=", b"==", b"excitation.frequency", b"sweep", b"from", b"to", b"count", b"step",
    b"x_r_peak", b"T_a", b"static_ratio", b"stick-slip", b"\n---\n", b"\n...\n",
)  # fmt: skip
"""What is put in: signs that readers trip over, and words that mean something somewhere."""


def damaged(seeds: list[bytes], dice: random.Random) -> bytes:
    """Return one of some inputs with a few faults in it."""
    part = bytearray(dice.choice(seeds))
    for _ in range(dice.choice((1, 1, 1, 2, 2, 3, 5))):
        KINDS[dice.randrange(len(KINDS))](part, seeds, dice)
    return bytes(part[:LONGEST])


LONGEST = 60_000
"""Bytes of an input; files of a megabyte are a test of their own."""


def _span(part: bytearray, dice: random.Random) -> slice:
    at = dice.randrange(len(part) + 1)
    return slice(at, at + dice.choice((1, 1, 2, 4, 8, 30, 200)))


def _cut(part: bytearray, seeds: list[bytes], dice: random.Random) -> None:
    del part[dice.randrange(len(part) + 1) :]


def _lose(part: bytearray, seeds: list[bytes], dice: random.Random) -> None:
    del part[_span(part, dice)]


def _scramble(part: bytearray, seeds: list[bytes], dice: random.Random) -> None:
    span = _span(part, dice)
    part[span] = dice.randbytes(len(part[span]))


def _flip(part: bytearray, seeds: list[bytes], dice: random.Random) -> None:
    if part:
        part[dice.randrange(len(part))] ^= 1 << dice.randrange(8)


def _put(part: bytearray, seeds: list[bytes], dice: random.Random) -> None:
    at = dice.randrange(len(part) + 1)
    part[at:at] = dice.choice(SIGNS) * dice.choice((1, 1, 1, 2, 50))


def _replace(part: bytearray, seeds: list[bytes], dice: random.Random) -> None:
    part[_span(part, dice)] = dice.choice(SIGNS)


def _repeat(part: bytearray, seeds: list[bytes], dice: random.Random) -> None:
    span = _span(part, dice)
    part[span] = part[span] * dice.choice((2, 3, 100))


def _splice(part: bytearray, seeds: list[bytes], dice: random.Random) -> None:
    other = dice.choice(seeds)
    start = dice.randrange(len(other) + 1)
    at = dice.randrange(len(part) + 1)
    part[at : at + dice.choice((0, 0, 40))] = other[
        start : start + dice.choice((5, 20, 80, 400))
    ]


def _line(part: bytearray, seeds: list[bytes], dice: random.Random) -> None:
    lines = part.split(b"\n")
    at, other = dice.randrange(len(lines)), dice.choice(dice.choice(seeds).split(b"\n"))
    lines[at : at + dice.choice((0, 1))] = [bytearray(other)] * dice.choice((0, 1, 1, 2))
    part[:] = b"\n".join(lines)


def _word(part: bytearray, seeds: list[bytes], dice: random.Random) -> None:
    words = part.split(b" ")
    words[dice.randrange(len(words))] = bytearray(dice.choice(SIGNS))
    part[:] = b" ".join(words)


KINDS = (
    _cut, _lose, _scramble, _flip, _flip, _put, _put, _replace, _repeat, _splice, _line, _word,
    _word,
)  # fmt: skip
"""The kinds of damage; some happen more often."""
