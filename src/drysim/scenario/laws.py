"""Friction laws by name, and their parameters from the block of another law.

A comparison collects the parameters of a law from the friction block of the file, which may be
that of any other law; `law_faults` reports what is missing.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from drysim.block import Block
from drysim.direction import mean_of_directions
from drysim.friction import FRICTION_LAWS, Coulomb, Friction
from drysim.scenario.keys import fields_by_key, members_by_tag, numeric_keys
from drysim.scenario.validation import blamed_path, spoken_name, validation_message
from drysim.wording import join_words

LAWS: dict[str, type[Friction]] = members_by_tag(FRICTION_LAWS)
"""Friction laws by name."""

LAW_KEY = "law"
"""Tag key of the friction block."""

DEFAULT_LAW = next(name for name, law in LAWS.items() if law.by_default)
"""Law of a friction block without tag."""


def other_laws_hint(key: str) -> str:
    """Return a hint on the laws that have a key; empty if there is none."""
    names = [name for name, law in LAWS.items() if key in law.model_fields]
    if not names:
        return ""
    which = "one of these laws" if len(names) > 1 else "that law"
    hint = f"; it belongs to law {join_words(names, 'or')}: choose {which}"
    if key in Coulomb.model_fields:  # a force, given by other keys
        return hint
    return f"{hint}, or for comparisons write `{names[0]}: {{{key}: ...}}`"


def merge_law_keys(
    name: str, block: Mapping[str, Any], options: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the parameters of a law: its own options and shared keys of a block.

    An option replaces all keys of the block that it excludes, such as `mu_kinetic` for
    `kinetic`; keys that require a replaced key are dropped.
    """
    law = LAWS[name]
    shared = law.model_fields.keys() - excluded_keys(name, options) - {LAW_KEY}
    arguments = {key: value for key, value in block.items() if key in shared} | dict(options)
    for key, other in law.needs.items():
        if key in arguments and key not in options and other not in arguments:
            del arguments[key]
    return arguments


def excluded_keys(name: str, options: Collection[str]) -> set[str]:
    """Return the keys of a law excluded by some of its keys, including these."""
    groups = [{*group} for group in LAWS[name].exclusive_groups()]
    return set(options).union(*(group for group in groups if group & {*options}))


def law_arguments(friction: Friction, name: str) -> dict[str, Any]:
    """Return the parameters of a law from a block of any law, in SI."""
    shared = set_values(friction)
    if name != friction.law:
        shared = {key: mean_of_directions(value) for key, value in shared.items()}
    return merge_law_keys(name, shared, law_options(friction, name))


def friction_uses_key(friction: Friction, name: str, key: str) -> bool:
    """Return whether a law would use a key of the block of another law."""
    options = law_options(friction, name)
    return key not in options and key in merge_law_keys(
        name, set_values(friction) | {key: None}, options
    )


def law_options(friction: Friction, name: str) -> dict[str, Any]:
    """Return the options of a law in the block of another law, in SI."""
    options = getattr(friction, name, None)
    return {} if options is None else set_values(options)


def set_values(block: Block) -> dict[str, Any]:
    """Return the values set in a block."""
    return {key: value for key, value in block if value is not None and key != LAW_KEY}


def friction_under_law(friction: Friction, name: str) -> Friction:
    """Return the friction block of another law, which `law_faults` has checked.

    Nothing is validated, so values may be columns.
    """
    if friction.law == name:
        return friction
    arguments: dict[str, Any] = law_arguments(friction, name) | {LAW_KEY: name}
    if "mu_kinetic" in arguments and "normal" in LAWS[name].model_fields:
        mean = getattr(friction, "mean_normal_force", None)
        arguments |= {} if mean is None else {"normal": mean}
    return LAWS[name].model_construct(**arguments)


def _missing_keys(friction: Friction, name: str) -> list[str]:
    """Return the keys a law still needs, with their units."""
    law, arguments = LAWS[name], law_arguments(friction, name)
    required = [
        key
        for key, field in fields_by_key(law).items()
        if field.is_required() and key not in arguments and key != LAW_KEY
    ]
    either = [group[0] for group in law.one_of if not arguments.keys() & {*group}]
    keys = numeric_keys(law, {})
    units = {key: f" [{numeral.unit or '-'}]" for key, numeral in keys.items() if numeral}
    return [f"friction.{name}.{key}{units.get(key, '')}" for key in (*either, *required)]


def law_faults(friction: Friction | None, name: str) -> Iterator[tuple[str, str]]:
    """Yield the dotted key and message of everything that prevents using a law."""
    if not name or (friction is not None and friction.law == name):
        return
    if friction is None:
        yield "friction", f"law {name} needs a friction block; this scenario has none"
        return
    if needed := _missing_keys(friction, name):
        remedy = f"give {'it' if len(needed) == 1 else 'them'} in a block `{name}` in friction"
        yield "friction", f"law {name} needs {join_words(needed)}: {remedy}"
        return
    try:
        LAWS[name].model_validate(law_arguments(friction, name) | {LAW_KEY: name})
    except ValidationError as fault:
        for error in fault.errors(include_url=False):
            path = (*error["loc"], *blamed_path(error))
            is_option = bool(path) and path[0] in law_options(friction, name)
            keys = ("friction", *([name] if is_option else []), *path)
            message = validation_message(error)
            sentence = f"friction as {name}: {spoken_name(path)} {message}"
            yield ".".join(map(str, keys)), sentence
