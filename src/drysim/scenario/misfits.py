"""What keeps a friction law from acting in the block of another, in sentences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from pydantic import ValidationError

from drysim.quantity import Misfit
from drysim.scenario.laws import BY_NAME, LAWS, own_options, words_for
from drysim.scenario.sentences import worded
from drysim.scenario.shape import Model, keys_of
from drysim.scenario.sweep.numerals import numerals
from drysim.wording import listed

if TYPE_CHECKING:
    from drysim.friction import Friction


def lacking(friction: Friction, name: str) -> list[str]:
    """Give the keys, with their units, that a block must get before a law can act."""
    law, words = LAWS[name], words_for(friction, name)
    found = [
        key
        for key, field in keys_of(law).items()
        if field.is_required() and key not in words and key != BY_NAME
    ]
    either = [group[0] for group in law.one_of if not words.keys() & {*group}]
    return [f"friction.{name}.{key}{_unit(law, key)}" for key in (*either, *found)]


def _unit(law: Model, key: str) -> str:
    """Give the unit of a key in brackets; nothing for a key that is no number."""
    numeral = dict(numerals(law, {}))[key]
    return f" [{numeral.unit or '-'}]" if numeral else ""


def faults(friction: Friction | None, name: str) -> Iterator[tuple[str, str]]:
    """Give the dotted key and the sentence for everything that keeps a law from acting."""
    if friction is None or name in ("", friction.law):
        return
    if needed := lacking(friction, name):
        way = f"give them in a block `{name}` of friction"
        yield "friction", f"law {name} needs {listed(needed)}: {way}"
        return
    try:
        LAWS[name].model_validate(words_for(friction, name) | {BY_NAME: name})
    except ValidationError as fault:
        for error in fault.errors(include_url=False):
            cause = error.get("ctx", {}).get("error")
            at = [*error["loc"], *(cause.at if isinstance(cause, Misfit) else ())]
            told = str(cause) if cause is not None else worded(error)
            yield (
                key_of(friction, name, at),
                f"friction as {name}: {'.'.join(map(str, at))} {told}",
            )


def key_of(friction: Friction, name: str, at: list[str | int]) -> str:
    """Give the dotted key of a value of a law: in its own options, or shared."""
    own = bool(at) and at[0] in own_options(friction, name)
    return ".".join(map(str, ("friction", *([name] if own else []), *at)))
