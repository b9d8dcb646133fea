"""Why a key cannot be swept, in sentences."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import takewhile
from typing import Any

from drysim.quantity import meant, near, shown
from drysim.scenario.laws import LAWS
from drysim.scenario.rules import KINDS, broken
from drysim.scenario.seeds import beside_seeds
from drysim.scenario.shape import block_in, keys_of, tag_of
from drysim.scenario.sweep.numerals import Known, Numeral

STEADY = {kind for kind, member in KINDS.items() if member.steady_by_default}
"""Kinds of excitation that are measured over the periodic orbit when nothing else is said."""


def refusal(words: Mapping[str, Any], key: str, known: Known) -> str | None:
    """Say why a key cannot be swept; None when it can.

    Parameters
    ----------
    words : mapping
        The scenario; `sweep` in it by its dotted keys.
    key : str
        One of those.
    known : mapping
        Every key of the scenario.
    """
    numeral = known.get(key)
    if numeral is None:
        return _no_number(key, known)
    block, _, name = key.rpartition(".")
    before = takewhile(lambda other: other != key, words["sweep"])
    beside = {other.rpartition(".")[2] for other in before if other.rpartition(".")[0] == block}
    if sentence := _excluded(block, name, numeral, beside) or beside_seeds(words, key):
        return sentence
    if block == "measure" and not _windowed(words):
        return f"{key} has no use here: metrics cover the periodic orbit; give it in measure"
    known_faults = {sentence for _, sentence in broken(words)}
    faults = (sentence for _, sentence in broken(_with(words, block, name)))
    return next((sentence for sentence in faults if sentence not in known_faults), None)


def _no_number(key: str, known: Known) -> str:
    """Say what is wrong with a key that is no numeric key of the scenario."""
    inner = next((k for k, numeral in known.items() if numeral and k.startswith(f"{key}.")), "")
    if inner:
        return f"{key} is a block; write a dotted key, such as `{inner}`"
    if key in known:
        return f"{key} is not a number, so it cannot be swept"
    top = key.partition(".")[0]
    if nearest := _nearest(key, known):
        hint = meant(nearest)
    elif top in known and not any(other.startswith(f"{top}.") for other in known):
        hint = f"; this scenario has no {top} block"
    else:
        hint = _instead(top, known)
    return f"unknown key {shown(key)} in sweep{hint}"


def _instead(top: str, known: Known) -> str:
    """Give the keys that a block has, and the member of a shelf that it is."""
    inside = {
        key: numeral
        for key, numeral in known.items()
        if numeral and key.startswith(f"{top}.") and key.split(".")[1] not in LAWS
    }
    if not inside:
        return ""
    model = next(iter(inside.values())).model
    tag = tag_of(model) if model else None
    kind = f" of {' '.join(tag)}" if tag else ""
    return f"; known in {top}{kind} are {', '.join(key.partition('.')[2] for key in inside)}"


def _nearest(key: str, known: Known) -> str | None:
    """Give the numeric key that was probably meant by one that is not there."""
    steps, best, found = key.split("."), (0, False, 0), None
    if len(steps) == 3 and steps[1] in LAWS and known.get(without := f"{steps[0]}.{steps[2]}"):
        return without  # an option of the file's own law, which is a key of the block
    for candidate, numeral in known.items():
        parts = candidate.split(".")
        ours = parts[-1:] if len(steps) == 1 else parts
        if numeral is None or len(ours) != len(steps):
            continue
        if all(a == b or near(a, [b]) for a, b in zip(steps, ours, strict=True)):
            same = sum(a == b for a, b in zip(steps, ours, strict=True))
            rank = (same, numeral.there, -len(parts))
            if found is None or rank > best:
                best, found = rank, candidate
    return found


def _excluded(block: str, name: str, numeral: Numeral, beside: set[str]) -> str | None:
    """Say which key of its block keeps a key from being set."""
    model, given = numeral.model, numeral.given
    if model is None:
        return None
    for group in model.exclusive():
        others = [other for other in group if name in group and other != name]
        if other := next((other for other in others if other in given), ""):
            instead = f"sweep {block}.{other}, or give {name} in its place"
            return f"{block}.{name} has no use here: {block} has {other}; {instead}"
        if other := next((other for other in others if other in beside), ""):
            return f"sweep {block}.{name} or {block}.{other}, not both"
    beside_which = model.needs.get(name)
    if beside_which and beside_which not in given:
        which = f"{block}.{beside_which}, which is not given"
        return f"{block}.{name} has a meaning only beside {which}"
    needed = [k for k, field in keys_of(model).items() if field.is_required() and k != name]
    if needed and not numeral.there:
        return f"{block}.{name} needs its block: give {block} with {' and '.join(needed)}"
    return None


def _windowed(words: Mapping[str, Any]) -> bool:
    """Whether the metrics are taken over a window, not over the periodic orbit."""
    measure, kind = block_in(words, "measure"), block_in(words, "excitation").get("kind")
    return kind not in STEADY or bool({"settle", "duration"} & measure.keys())


def _with(words: Mapping[str, Any], block: str, name: str) -> Mapping[str, Any]:
    """Give the words with some number at a key of a block that is not within another."""
    return words if "." in block else {**words, block: {**block_in(words, block), name: 1.0}}
