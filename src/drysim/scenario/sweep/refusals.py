"""Why a key cannot be swept, in sentences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drysim.excitation import EXCITATIONS
from drysim.quantity import near
from drysim.scenario.rules import broken
from drysim.scenario.shape import keys_of, tag_of
from drysim.scenario.sweep.numerals import Known, Numeral

STEADY = {
    tag[1]
    for member in EXCITATIONS
    if (tag := tag_of(member)) and getattr(member, "steady_by_default", False)
}
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
    swept = [other.rpartition(".") for other in words["sweep"] if other != key]
    beside = {other for where, _, other in swept if where == block}
    if sentence := _excluded(block, name, numeral, beside):
        return sentence
    if block == "measure" and not _windowed(words):
        return f"{key} has no use here: the metrics cover the periodic orbit; give {key} first"
    before = set(broken(words))
    return next((s for k, s in broken(_with(words, block, name)) if (k, s) not in before), None)


def _no_number(key: str, known: Known) -> str:
    """Say what is wrong with a key that is no numeric key of the scenario."""
    inner = next((k for k, numeral in known.items() if numeral and k.startswith(f"{key}.")), "")
    if inner:
        return f"{key} is a block; write a dotted key, such as `{inner}`"
    if key in known:
        return f"{key} is not a number, so it cannot be swept"
    top = key.partition(".")[0]
    if nearest := _meant(key, known):
        hint = f"; did you mean `{nearest}`?"
    elif top in known and not any(other.startswith(f"{top}.") for other in known):
        hint = f"; this scenario has no {top} block"
    else:
        others = [k.removeprefix(f"{top}.") for k in known if known[k] and k.startswith(top)]
        hint = f"; in {top}, known are {', '.join(others)}" if others else ""
    return f"unknown key `{key}` in sweep{hint}"


def _meant(key: str, known: Known) -> str | None:
    """Give the numeric key that was probably meant by one that is not there."""
    steps, alike = key.split("."), []
    for candidate in (name for name, numeral in known.items() if numeral):
        parts = candidate.split(".")
        ours = parts[-1:] if len(steps) == 1 else parts
        if len(ours) == len(steps) and all(
            a == b or near(a, [b]) for a, b in zip(steps, ours, strict=True)
        ):
            same = sum(a == b for a, b in zip(steps, ours, strict=True))
            alike.append((same, candidate))
    return max(alike, key=lambda found: found[0])[1] if alike else None


def _excluded(block: str, name: str, numeral: Numeral, beside: set[str]) -> str | None:
    """Say which key of its block keeps a key from being set."""
    model, given = numeral.model, numeral.given
    if model is None:
        return None
    for group in (*getattr(model, "one_of", ()), *getattr(model, "at_most_one_of", ())):
        others = [other for other in group if name in group and other != name]
        if other := next((other for other in others if other in given), ""):
            instead = f"sweep {block}.{other}, or give {name} in its place"
            return f"{block}.{name} has no use here: {block} has {other}; {instead}"
        if other := next((other for other in others if other in beside), ""):
            return f"sweep {block}.{name} or {block}.{other}, not both"
    needed = getattr(model, "needs", {}).get(name)
    if needed and needed not in given:
        return f"{block}.{name} has a meaning only beside {block}.{needed}, which is not given"
    needed = [k for k, field in keys_of(model).items() if field.is_required() and k != name]
    if needed and not numeral.there:
        return f"{block}.{name} needs its block: give {block} with {' and '.join(needed)}"
    return None


def _windowed(words: Mapping[str, Any]) -> bool:
    """Whether the metrics are taken over a window, not over the periodic orbit."""
    measure, kind = _block(words, "measure"), _block(words, "excitation").get("kind")
    return kind not in STEADY or bool({"settle", "duration"} & measure.keys())


def _with(words: Mapping[str, Any], block: str, name: str) -> Mapping[str, Any]:
    """Give the words with some number at a key of a block that is not within another."""
    return words if "." in block else {**words, block: {**_block(words, block), name: 1.0}}


def _block(words: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Give a block, empty where there is none."""
    block = words.get(name)
    return block if isinstance(block, Mapping) else {}
