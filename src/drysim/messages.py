"""Text of error messages: suggestions for misspelled names, and values as they are shown."""

from collections.abc import Collection, Iterable


def closest_match(name: str, candidates: Iterable[str]) -> str | None:
    """Return the candidate closest to a misspelled name, or None.

    It has the smallest edit distance, which is at most one third of the length of the name.
    Abbreviations of at least three letters match, too.

    `difflib.get_close_matches` finds as many misspelled keys of a scenario, but suggests a key
    for three times as many words that are none.
    """
    word, best = name.lower().replace("-", "_"), None
    for candidate in candidates:
        other = candidate.lower().replace("-", "_")
        distance = _edit_distance(word, other)
        if min(len(word), len(other)) >= 3 and (
            other.startswith(word) or word.startswith(other)
        ):
            distance = min(distance, 1)
        rank = (distance, abs(len(other) - len(word)), other[:1] != word[:1], candidate)
        forgiven = min(max(1, len(word) // 3), len(word) - 1)
        if distance <= forgiven and (best is None or rank < best):
            best = rank
    return best[-1] if best else None


def did_you_mean(nearest: str | None) -> str:
    """Return the suffix `; did you mean …?` of an error message; empty without a suggestion."""
    return f"; did you mean `{nearest}`?" if nearest else ""


def name_hint(name: str, names: Collection[str]) -> str:
    """Return the suffix that suggests the closest known name, or else lists all of them."""
    return did_you_mean(closest_match(name, names)) or f"; use one of {', '.join(names)}"


def _edit_distance(a: str, b: str) -> int:
    """Return the edit distance: substitutions, insertions, deletions and adjacent swaps."""
    if abs(len(a) - len(b)) > 4 or len(a) > 60:
        return 99
    # Rows of the dynamic programme: `row[j]` is the distance of a[: i + 1] to b[:j].
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, x in enumerate(a):
        last, before, row = before, row, [i + 1]
        for j, y in enumerate(b):
            row.append(min(before[j] + (x != y), before[j + 1] + 1, row[j] + 1))
            if i and j and x == b[j - 1] and y == a[i - 1]:
                row[-1] = min(row[-1], last[j - 1] + 1)
    return row[-1]


def format_value(value: object) -> str:
    """Return a value as error messages show it: text in backticks, blocks and lists by type."""
    match value:
        case None:
            return "nothing"
        case bool():
            return "true" if value else "false"
        case float():
            return repr(value).removesuffix(".0")
        case str():
            return f"`{shorten(value)}`"
        case dict():
            return "a block of keys"
        case list() | tuple():
            return "a list"
        case int() if abs(value) >= 10**1000:  # exceeds Python's limit for int to str
            return f"a whole number of {value.bit_length()} bits"
    return shorten(str(value))


def shorten(text: str, most: int = 40) -> str:
    """Return the text on one line, cut to at most `most` characters."""
    line = " ".join(text[: 8 * most].split())
    return line if len(line) <= most and len(text) <= 8 * most else line[: most - 1] + "…"
