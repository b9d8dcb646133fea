"""What the validation of a model complains about, in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from drysim.quantity import Misfit, meant, near, shown
from drysim.scenario.reading import Reading, dotted
from drysim.source import Keys

READ_BEFORE = {"missing", "extra_forbidden", "union_tag_invalid", "union_tag_not_found"}
"""Complaints about keys, which the reading of the file has made already."""

_VERBS = ("must ", "needs ", "has ", "is ", "asks ", "gives ", "stands ")

_WORDED = {
    "string_type": "must be text, not {given}; put it in quotes",
    "string_too_short": "must not be empty",
    "bool_type": "must be true or false, not {given}",
    "int_type": "must be a whole number, not {given}",
    "int_parsing": "must be a whole number, not {given}",
    "int_from_float": "must be a whole number, not {given}",
    "float_type": "must be a number, not {given}",
    "float_parsing": "must be a number, not {given}",
    "tuple_type": "must be a list, not {given}",
    "list_type": "must be a list, not {given}",
    "model_type": "must be a block of keys, not {given}",
    "model_attributes_type": "must be a block of keys, not {given}",
    "dict_type": "must be a block of keys, not {given}",
    "too_short": "must have {min_length} entry at least",
    "greater_than": "must be above {gt}, not {given}",
    "greater_than_equal": "must be at least {ge}, not {given}",
    "less_than": "must be below {lt}, not {given}",
    "less_than_equal": "must be at most {le}, not {given}",
}


def sentences(
    fault: ValidationError, words: Mapping[str, Any], at: Keys = ()
) -> Iterator[tuple[Keys, str]]:
    """Give the keys to blame and the sentence for every complaint.

    `at` are the keys of the block that was validated, if it was not the whole scenario.
    """
    for error in fault.errors(include_url=False):
        if error["type"] in READ_BEFORE:
            continue
        keys = _keys((*at, *error["loc"]), words)
        cause = error.get("ctx", {}).get("error")
        if isinstance(cause, Misfit):
            keys = (*keys, *cause.at)
        text = str(cause) if cause is not None else worded(error)
        yield keys, about(keys, text)


def refuse(reading: Reading, sentence: str, keys: Keys, at_key: bool = False) -> None:
    """Note a problem of a value, whose name begins the sentence."""
    reading.fault(about(keys, sentence), keys, at_key)


def about(keys: Keys, text: str) -> str:
    """Give the sentence about a value from its key and what is said of it."""
    return f"{dotted(keys)}{' ' if text.startswith(_VERBS) else ': '}{text}"


def _keys(loc: Keys, words: Any) -> Keys:
    """Give a location without the tags of shelves that stand in it."""
    keys: list[str | int] = [*loc[:1]]
    words = words.get(loc[0])
    for step in loc[1:]:
        inside = isinstance(words, dict) and step in words
        if inside or (isinstance(words, list) and isinstance(step, int)):
            keys.append(step)
            words = words[step]
    return tuple(keys)


def worded(error: ErrorDetails) -> str:
    """Give the sentence for a complaint of the validation library, without its subject."""
    given, context = error["input"], error.get("ctx", {})
    if error["type"] == "literal_error":
        expected = str(context["expected"]).replace("'", "")
        words = expected.replace(" or ", ", ").split(", ")
        hint = meant(near(given, words)) if isinstance(given, str) else ""
        return f"must be {expected}, not {shown(given)}{hint}"
    form = _WORDED.get(error["type"])
    if form and isinstance(given, list | dict):
        form = form.removesuffix("; put it in quotes")  # which makes text of a number only
    return form.format(given=shown(given), **context) if form else error["msg"]
