"""Messages for validation errors of pydantic, with the path of the key to blame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from drysim.block import InvalidValue
from drysim.messages import closest_match, did_you_mean, format_value, shorten
from drysim.yaml_document import KeyPath

ALREADY_REPORTED = {"missing", "extra_forbidden", "union_tag_invalid", "union_tag_not_found"}
"""Error types about keys, which `Reading` has reported."""

_PREDICATES = ("must ", "needs ", "has ", "is ", "requires ", "asks ", "gives ", "stands ")

_MESSAGES = {
    "string_type": "must be text, not {value}; put it in quotes",
    "string_too_short": "must not be empty",
    "bool_type": "must be true or false, not {value}",
    "int_type": "must be a whole number, not {value}",
    "int_parsing": "must be a whole number, not {value}",
    "int_from_float": "must be a whole number, not {value}",
    "float_type": "must be a number, not {value}",
    "float_parsing": "must be a number, not {value}",
    "tuple_type": "must be a list, not {value}",
    "list_type": "must be a list, not {value}",
    "model_type": "must be a block of keys, not {value}",
    "model_attributes_type": "must be a block of keys, not {value}",
    "dict_type": "must be a block of keys, not {value}",
    "too_short": "must have at least {min_length} entry",
    "too_long": "must have at most {max_length} entries, not {actual_length}",
    "greater_than": "must be above {gt}, not {value}",
    "greater_than_equal": "must be at least {ge}, not {value}",
    "less_than": "must be below {lt}, not {value}",
    "less_than_equal": "must be at most {le}, not {value}",
}


def validation_faults(
    fault: ValidationError, values: Mapping[str, Any], path: KeyPath = ()
) -> Iterator[tuple[KeyPath, str]]:
    """Yield the key path and message of every validation error.

    `values` are the values that were validated, and `path` is the path of the block that was
    validated, if not the whole scenario.
    """
    for error in fault.errors(include_url=False):
        if error["type"] in ALREADY_REPORTED or _counts_valid_entries(error):
            continue
        keys = (*_without_tags((*path, *error["loc"]), values), *blamed_path(error))
        yield keys, with_subject(keys, validation_message(error))


def _counts_valid_entries(error: ErrorDetails) -> bool:
    """Return whether a list is too short only without its faulty entries, reported before."""
    entries = error["input"]
    is_list = error["type"] == "too_short" and isinstance(entries, list | tuple)
    return is_list and len(entries) >= error.get("ctx", {})["min_length"]


def with_subject(keys: KeyPath, text: str) -> str:
    """Return a message with the key as its subject."""
    return f"{spoken_name(keys)}{' ' if text.startswith(_PREDICATES) else ': '}{text}"


def _without_tags(loc: KeyPath, values: Any) -> KeyPath:
    """Return a pydantic location without the tags of unions in it."""
    keys: list[str | int] = [*loc[:1]]
    values = values.get(loc[0])
    for step in loc[1:]:
        inside = isinstance(values, dict) and step in values
        if inside or (isinstance(values, list) and isinstance(step, int)):
            keys.append(step)
            values = values[step]
    return tuple(keys)


def blamed_path(error: ErrorDetails) -> KeyPath:
    """Return the path of the key that our exception blames, relative to its block."""
    cause = error.get("ctx", {}).get("error")
    return cause.path if isinstance(cause, InvalidValue) else ()


def validation_message(error: ErrorDetails) -> str:
    """Return the message for a pydantic error, without subject."""
    value, context = error["input"], error.get("ctx", {})
    if "error" in context:  # our exception
        return str(context["error"])
    if error["type"] == "literal_error":
        expected = str(context["expected"]).replace("'", "")
        choices = expected.replace(" or ", ", ").split(", ")
        hint = did_you_mean(closest_match(value, choices)) if isinstance(value, str) else ""
        return f"must be {expected}, not {format_value(value)}{hint}"
    form = _MESSAGES.get(error["type"])
    if form and isinstance(value, list | dict):
        form = form.removesuffix("; put it in quotes")  # which helps for scalars only
    return form.format(value=format_value(value), **context) if form else error["msg"]


def dotted_name(keys: KeyPath) -> str:
    """Return a key path in dotted form, for programs: entries of lists count from 0."""
    return ".".join(shorten(str(key)) for key in keys)


def spoken_name(keys: KeyPath) -> str:
    """Return a key path in a sentence, such as `checks #2` for the second entry of a list.

    The first value of a list that is such an entry is `points #2, value 1`.
    """
    name = ""
    for before, key in zip(("", *keys), keys, strict=False):
        if isinstance(key, int):
            name += f", value {key + 1}" if isinstance(before, int) else f" #{key + 1}"
        else:
            name += f".{shorten(str(key))}"
    return name.removeprefix(".")
