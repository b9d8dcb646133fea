"""Why a key of a scenario cannot be varied."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from itertools import takewhile
from typing import Any

from drysim.messages import closest_match, did_you_mean, format_value
from drysim.scenario.axes import (
    DIRECTION_KEY,
    FROM_FIT_KEY,
    SWEEP_KEY,
)
from drysim.scenario.blocks import SEED_KEY
from drysim.scenario.keys import (
    KnownKeys,
    NumericKey,
    discriminator,
    fields_by_key,
    get_block,
)
from drysim.scenario.laws import LAWS
from drysim.scenario.rules import EXCITATIONS_BY_KIND, key_faults


def sweep_fault(
    document: Mapping[str, Any],
    key: str,
    keys: KnownKeys,
    varied: Collection[str] = (),
    block_name: str = SWEEP_KEY,
) -> str | None:
    """Return why a key cannot be varied; None if it can.

    `document` is the scenario as plain values, whose `sweep` has dotted keys, and `keys` are
    its keys from `numeric_keys`. `varied` are all keys that are varied together in the block
    `block_name`, by default those of the sweep; draws of a fit are of the block `from_fit`.
    """
    numeral = keys.get(key)
    if numeral is None:
        return _not_numeric_fault(key, keys, block_name)
    block, _, name = key.rpartition(".")
    earlier = takewhile(lambda other: other != key, varied or document[SWEEP_KEY])
    swept = {other.rpartition(".")[2] for other in earlier if other.rpartition(".")[0] == block}
    drawn = block_name == FROM_FIT_KEY
    if sentence := _exclusion_fault(block, name, numeral, swept, drawn):
        return sentence
    seed_keys = {"seeds", "until"} & get_block(document, "excitation").keys()
    if key == SEED_KEY and seed_keys:
        return (
            f"{SEED_KEY} cannot be swept with excitation.{min(seed_keys)}: every case uses the "
            "same seeds"
        )
    if key in ("measure.settle", "measure.duration") and not _has_window(document):
        return f"{key} is not used: metrics cover the steady state; set it in measure as well"
    known_faults = {sentence for _, sentence in key_faults(document)}
    if "." not in block:  # rules concern top-level blocks: try a number
        document = {**document, block: {**get_block(document, block), name: 1.0}}
    faults = (sentence for _, sentence in key_faults(document))
    return next((sentence for sentence in faults if sentence not in known_faults), None)


def _not_numeric_fault(key: str, keys: KnownKeys, block_name: str) -> str:
    """Return the message for a key that is not numeric or unknown."""
    inner = next((k for k, numeral in keys.items() if numeral and k.startswith(f"{key}.")), "")
    if inner:
        return f"{key} is a block; write a dotted key, such as `{inner}`"
    if key in keys:
        return f"{key} is not a number, so it cannot be varied"
    top = key.partition(".")[0]
    nearest = _closest_key(key, keys)
    if block_name == SWEEP_KEY and nearest is None:
        nearest = closest_match(key, [DIRECTION_KEY])
    if nearest:
        hint = did_you_mean(nearest)
    elif top in keys and not any(other.startswith(f"{top}.") for other in keys):
        hint = f"; this scenario has no {top} block"
    else:
        hint = _known_keys_hint(top, keys)
    return f"unknown key {format_value(key)} in {block_name}{hint}"


def _known_keys_hint(top: str, keys: KnownKeys) -> str:
    """Return a hint with the numeric keys of a block."""
    inside = {
        key: numeral
        for key, numeral in keys.items()
        if numeral and key.startswith(f"{top}.") and key.split(".")[1] not in LAWS
    }
    if not inside:
        return ""
    model = next(iter(inside.values())).model
    tag = discriminator(model) if model else None
    kind = f" of {' '.join(tag)}" if tag else ""
    return f"; known in {top}{kind} are {', '.join(key.partition('.')[2] for key in inside)}"


def _closest_key(key: str, keys: KnownKeys) -> str | None:
    """Return the numeric key closest to an unknown one; None if none is close."""
    steps, best, closest = key.split("."), (0, False, 0), None
    if len(steps) == 3 and steps[1] in LAWS and keys.get(without := f"{steps[0]}.{steps[2]}"):
        return without  # options of the file's own law are keys of the block
    for candidate, numeral in keys.items():
        parts = candidate.split(".")
        ours = parts[-1:] if len(steps) == 1 else parts
        if numeral is None or len(ours) != len(steps):
            continue
        if all(a == b or closest_match(a, [b]) for a, b in zip(steps, ours, strict=True)):
            same = sum(a == b for a, b in zip(steps, ours, strict=True))
            rank = (same, numeral.present, -len(parts))
            if closest is None or rank > best:
                best, closest = rank, candidate
    return closest


def _exclusion_fault(
    block: str, name: str, numeral: NumericKey, swept: set[str], drawn: bool
) -> str | None:
    """Return why other keys of its block exclude a key; None if none does.

    The keys of the draws of a fit are given, so that only the block can change.
    """
    model, values = numeral.model, numeral.block
    if model is None:
        return None
    for group in model.exclusive_groups():
        others = [other for other in group if name in group and other != name]
        if other := next((other for other in others if other in values), ""):
            instead = f"vary {block}.{other}, or give {name} instead"
            if drawn:
                instead = f"give {name} instead, which the draws have"
            return f"{block}.{name} is not used: {block} has {other}; {instead}"
        if other := next((other for other in others if other in swept), ""):
            return f"vary {block}.{name} or {block}.{other}, not both"
    required = model.needs.get(name)
    if required and required not in values:
        which = f"{block}.{required}, which is not given"
        return f"{block}.{name} requires {which}"
    needed = [
        k for k, field in fields_by_key(model).items() if field.is_required() and k != name
    ]
    if needed and not numeral.present:
        return f"{block}.{name} needs its block: give {block} with {' and '.join(needed)}"
    return None


def _has_window(document: Mapping[str, Any]) -> bool:
    """Return whether the metrics cover a time window, not the steady state."""
    member = EXCITATIONS_BY_KIND.get(get_block(document, "excitation").get("kind", ""))
    times = {"settle", "duration"} & get_block(document, "measure").keys()
    return member is None or not member.steady_by_default or bool(times)
