"""Near names, and how a sentence shows a value."""

from __future__ import annotations

from collections.abc import Collection, Iterable

LONG_WHOLE = 10**1000
"""From here on the digits of a whole number are no longer told."""


def near(name: str, candidates: Iterable[str]) -> str | None:
    """Give the candidate that was probably meant, or None.

    One slip for each three letters is forgiven: a letter wrong, missing, too many, or two
    swapped; of a single letter nothing would be left. An abbreviation of at least three letters
    is understood.
    """
    word, best = name.lower().replace("-", "_"), None
    for candidate in candidates:
        other = candidate.lower().replace("-", "_")
        slips = _slips(word, other)
        if min(len(word), len(other)) >= 3 and (
            other.startswith(word) or word.startswith(other)
        ):
            slips = min(slips, 1)
        rank = (slips, abs(len(other) - len(word)), other[:1] != word[:1], candidate)
        forgiven = min(max(1, len(word) // 3), len(word) - 1)
        if slips <= forgiven and (best is None or rank < best):
            best = rank
    return best[-1] if best else None


def meant(nearest: str | None) -> str:
    """Ask behind a sentence for what was probably meant; nothing where none comes near."""
    return f"; did you mean `{nearest}`?" if nearest else ""


def meant_or_known(name: str, known: Collection[str]) -> str:
    """Ask for the known name that was probably meant, or else list them all."""
    return meant(near(name, known)) or f"; known are {', '.join(known)}"


def _slips(a: str, b: str) -> int:
    """Give how many letters to change, drop, add or swap with their neighbour."""
    if abs(len(a) - len(b)) > 4 or len(a) > 60:
        return 99
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, x in enumerate(a):
        last, before, row = before, row, [i + 1]
        for j, y in enumerate(b):
            row.append(min(before[j] + (x != y), before[j + 1] + 1, row[j] + 1))
            if i and j and x == b[j - 1] and y == a[i - 1]:
                row[-1] = min(row[-1], last[j - 1] + 1)
    return row[-1]


def shown(value: object) -> str:
    """Give a value as a sentence names it: words in backticks, blocks by their kind."""
    match value:
        case None:
            return "nothing"
        case bool():
            return "true" if value else "false"
        case float():
            return repr(value).removesuffix(".0")
        case str():
            return f"`{short(value)}`"
        case dict():
            return "a block of keys"
        case list() | tuple():
            return "a list"
        case int() if abs(value) >= LONG_WHOLE:
            return f"a whole number of {value.bit_length()} bits"  # Python prints no such
    return short(str(value))


def short(text: str, most: int = 40) -> str:
    """Give the text in one line of at most so many characters."""
    line = " ".join(text[: 8 * most].split())
    return line if len(line) <= most and len(text) <= 8 * most else line[: most - 1] + "…"
