"""Friction laws by name, and what each of them is by the words of another."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

from drysim.friction import FRICTIONS
from drysim.friction.coulomb import Coulomb
from drysim.quantity import Block
from drysim.scenario.shape import is_default, tag_of
from drysim.wording import listed

if TYPE_CHECKING:
    from drysim.friction import Friction

LAWS: dict[str, type[Friction]] = {
    tag[1]: member for member in FRICTIONS if (tag := tag_of(member))
}
"""The friction laws by name."""

BY_NAME = "law"
"""The key by which a block says of which law it is."""

DEFAULT = next(name for name, law in LAWS.items() if is_default(law))
"""The law of a block that names none."""


def of_other_laws(key: str) -> str:
    """Say which laws know a key that another law has not got; empty where none does."""
    names = [name for name, law in LAWS.items() if key in law.model_fields]
    if not names:
        return ""
    one = "such a" if len(names) > 1 else "that"
    hint = f"; it belongs to law {listed(names, 'or')}: choose {one} law"
    if key in Coulomb.model_fields:  # a force, which the block has in other words
        return hint
    return f"{hint}, or for comparisons write `{names[0]}: {{{key}: ...}}`"


def together(name: str, block: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """Give the words of a law: its own options, and what it shares with a block.

    An option stands for every key of the block that it excludes, such as `mu_kinetic` for
    `kinetic`; what is left there without the key that it needs is left out.
    """
    law = LAWS[name]
    known = law.model_fields.keys() - excluded(name, own) - {BY_NAME}
    words = {key: value for key, value in block.items() if key in known} | dict(own)
    for key, other in law.needs.items():
        if key in words and key not in own and other not in words:
            del words[key]
    return words


def excluded(name: str, own: Collection[str]) -> set[str]:
    """Give the keys of a law that do not go together with some of its keys, these included."""
    groups = [{*group} for group in LAWS[name].exclusive()]
    return set(own).union(*(group for group in groups if group & {*own}))


def words_for(friction: Friction, name: str) -> dict[str, Any]:
    """Give the words of a law as a block of any law has them, in SI."""
    return together(name, given(friction), own_options(friction, name))


def has_use(friction: Friction, name: str, key: str) -> bool:
    """Whether a law would use a key of the block of another, whoever gives it there."""
    own = own_options(friction, name)
    return key not in own and key in together(name, given(friction) | {key: None}, own)


def own_options(friction: Friction, name: str) -> dict[str, Any]:
    """Give the options of a law in the block of another, in SI."""
    options = getattr(friction, name, None)
    return {} if options is None else given(options)


def given(block: Block) -> dict[str, Any]:
    """Give what a block says."""
    return {key: value for key, value in block if value is not None and key != BY_NAME}


def acting(friction: Friction, name: str) -> Friction:
    """Give the friction of a law as a block of any law has it, which `faults` has checked.

    Nothing is checked anew, so columns of values may stand in place of numbers.
    """
    if friction.law == name:
        return friction
    words: dict[str, Any] = words_for(friction, name) | {BY_NAME: name}
    record = getattr(friction, "normal_record", None)
    if record is not None and "mu_kinetic" in words and "normal" in LAWS[name].model_fields:
        words.setdefault("normal", record.pressure().mean)
    return LAWS[name].model_construct(**words)
