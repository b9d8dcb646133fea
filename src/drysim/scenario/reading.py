"""A document compared with the models: unknown, missing and clashing keys.

One mistake gives one error: a misspelled key is read as the closest key, and a block of unknown
kind is skipped.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any, get_args, get_origin

from pydantic.fields import FieldInfo

from drysim.block import field_descriptions
from drysim.errors import Problem
from drysim.messages import closest_match, did_you_mean, format_value, shorten
from drysim.scenario.keys import (
    Model,
    block_models,
    discriminator,
    fields_by_key,
    members_by_tag,
    numeric_keys,
)
from drysim.scenario.laws import LAW_KEY, excluded_keys, other_laws_hint
from drysim.scenario.validation import dotted_name, spoken_name, with_subject
from drysim.wording import join_words
from drysim.yaml_document import UNREAD_KEYS, Document, KeyPath

MAX_PROBLEMS = 100
"""Maximum number of errors shown per file."""


class TooManyProblems(Exception):
    """Raised after `MAX_PROBLEMS` errors to stop reading."""


class Reading:
    """A document read as a model, and the errors found.

    Adding an error may raise `TooManyProblems`; the errors up to then are kept.
    """

    def __init__(self, document: Document, model: Model) -> None:
        self.document = document
        self.model = model
        self.problems: list[Problem] = []
        self.moved: dict[KeyPath, KeyPath] = {}
        """Paths in the document of misspelled keys, and of the options of a block's own law, by
        the path they are read as."""
        self.reported: set[KeyPath] = set()
        """Paths with an error already; no further error is added there."""
        self.values: dict[str, Any] = {}

    def read(self, document: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values whose keys the model has, of the document as completed."""
        self.values = self.block(self.model, document, ())
        return self.values

    def fault(
        self, sentence: str, keys: KeyPath, at_key: bool = False, instead: KeyPath = ()
    ) -> None:
        """Add an error, unless there is one already at this path or above.

        Parameters
        ----------
        sentence : str
            Message.
        keys : tuple
            Path of the value.
        at_key : bool
            Whether to point at the key, not at the value.
        instead : tuple
            Path to point at if the whole block is missing.
        """
        if any(keys[: i + 1] in self.reported for i in range(len(keys))):
            return
        self.reported.add(keys)
        path = self._location(keys)
        remark = ""
        if instead and path[0] not in self.document.value:
            remark = f"there is no block `{path[0]}`" * (len(path) > 1)
            path, at_key = instead, False
        place = self.document.locate(path, at_key)
        place = place._replace(remark=remark or place.remark)
        self.problems.append(place.problem(sentence, dotted_name(keys)))
        if len(self.problems) > MAX_PROBLEMS:
            raise TooManyProblems

    def other_key_hint(self, keys: KeyPath) -> str:
        """Return a hint at the alternative of a key that a value with its unit fits."""
        entries = numeric_keys(self.model, self.values)
        entry = entries.get(dotted_name(keys))
        text = entry.block.get(str(keys[-1])) if entry else None
        if entry is None or entry.model is None or not isinstance(text, str):
            return ""
        groups = [group for group in entry.model.exclusive_groups() if keys[-1] in group]
        for name in dict.fromkeys(name for group in groups for name in group):
            other = entries.get(dotted_name((*keys[:-1], name)))
            with suppress(ValueError):
                if other is not None and other.read(text) is not None and name != keys[-1]:
                    return did_you_mean(name)
        return ""

    def report_value(self, sentence: str, keys: KeyPath, at_key: bool = False) -> None:
        """Add an error of a value; its key precedes the message."""
        self.fault(with_subject(keys, sentence), keys, at_key)

    @contextmanager
    def reporting(self, path: KeyPath) -> Iterator[None]:
        """Report a ValueError on the value at a path, or below it if the error says where."""
        try:
            yield
        except ValueError as fault:
            self.report_value(str(fault), (*path, *getattr(fault, "path", ())))

    def block(self, model: Model, block: Mapping[str, Any], path: KeyPath) -> dict[str, Any]:
        """Return the values of a block whose keys the model has."""
        fields, values = fields_by_key(model), {}
        for key, value in block.items():
            name = (
                key
                if key in fields or key == UNREAD_KEYS
                else self._resolve_unknown(key, model, block, path)
            )
            if name in fields and name not in values:
                if name != key:
                    self.moved[*path, name] = self._location((*path, key))
                values[name] = self._value(fields[name], value, (*path, name))
        if UNREAD_KEYS not in block:
            self._note_missing(model, values, path)
        self._note_clashes(model, values, path)
        return {name: value for name, value in values.items() if value is not None}

    def _value(self, field: FieldInfo, value: Any, path: KeyPath) -> Any:
        """Return a value with nested blocks read; None if it has an error."""
        models = block_models(field.annotation)
        if value is None:
            self.fault(f"{spoken_name(path)} has no value", path, at_key=True)
        elif isinstance(value, list) and (not models or allows_list(field.annotation)):
            return [self._value(field, entry, (*path, i)) for i, entry in enumerate(value)]
        elif models and isinstance(value, dict):
            value = _with_default_tag(models, value)
            model = self._choose_member(models, value, path)
            return self.block(model, self._hoist(model, value, path), path) if model else None
        elif isinstance(value, dict) and UNREAD_KEYS in value:
            self.reported.add(path)  # such as `mass: {{ mass }}`, reported by the parser
        return value

    def _choose_member(
        self, models: list[Model], block: Mapping[str, Any], path: KeyPath
    ) -> Model | None:
        """Return the model that the tag of a block selects; None if unknown."""
        tags = members_by_tag(models)
        tag = next((pair[0] for pair in map(discriminator, models) if pair), None)
        if tag is None:
            return models[0]
        mistyped = next((key for key in block if closest_match(key, [tag])), tag)
        word = block.get(tag, block.get(mistyped))
        if isinstance(word, str) and word in tags:
            return tags[word]
        if word is None:
            sentence = f"{spoken_name((*path, tag))} is required; use one of {', '.join(tags)}"
            self.fault(sentence, path, at_key=True)
        else:
            nearest = closest_member(word, tags) if isinstance(word, str) else None
            hint = did_you_mean(nearest) or f"; use one of {', '.join(tags)}"
            sentence = f"unknown {tag} {format_value(word)} in {spoken_name(path)}{hint}"
            self.fault(sentence, (*path, tag))
        self.reported.add(path)
        return None

    def _hoist(
        self, model: Model, block: Mapping[str, Any], path: KeyPath
    ) -> Mapping[str, Any]:
        """Return a law block with its own options moved to the block itself."""
        tag = discriminator(model)
        if (
            tag is None
            or tag[0] != LAW_KEY
            or not isinstance(options := block.get(tag[1]), dict)
        ):
            return block
        self.moved |= {(*path, key): self._location((*path, tag[1], key)) for key in options}
        less = {tag[1], *excluded_keys(tag[1], options)}
        return {key: value for key, value in block.items() if key not in less} | options

    def _location(self, keys: KeyPath) -> KeyPath:
        """Return the path of a value in the document."""
        for i in range(len(keys), 0, -1):
            if keys[:i] in self.moved:
                return (*self.moved[keys[:i]], *keys[i:])
        return keys

    def _resolve_unknown(
        self, key: str, model: Model, block: Mapping[str, Any], path: KeyPath
    ) -> str | None:
        """Report an unknown key; return the key meant, if it is not in use."""
        fields = fields_by_key(model)
        name, _, value = key.partition(" ")
        if name in fields.keys() - block.keys() and value and block[key] is None:
            sentence = f"a colon is missing: `{name}: {value}`"
            self.fault(shorten(sentence, 100), (*path, key), at_key=True)
            self.reported.add((*path, name))
            return name
        nearest = closest_match(key, fields.keys() - block.keys()) or closest_match(key, fields)
        where = f" in {spoken_name(path)}" if path else ""
        if tag := discriminator(model):
            where += f" of {tag[0]} {tag[1]}"
        # In a block within this one, such as the unit of a channel, or else elsewhere.
        home = [*blocks_with_key(model, key)] if path and not tag else []
        home = home or [
            name for name in blocks_with_key(self.model, key) if (name,) != path[:1]
        ]
        if 0 < len(home) < 4:
            nearest, hint = None, f"; it belongs in {join_words(home, 'or')}"
        elif tag and tag[0] == LAW_KEY and (hint := other_laws_hint(key)):
            nearest = None
        else:
            hint = did_you_mean(nearest) or _unknown_key_hint(key, block[key], fields)
        self.fault(f"unknown key {format_value(key)}{where}{hint}", (*path, key), at_key=True)
        return nearest if nearest not in block else None

    def _note_missing(self, model: Model, values: Mapping[str, Any], path: KeyPath) -> None:
        """Report missing keys of a block."""
        for name, entry in fields_by_key(model).items():
            if entry.is_required() and name not in values:
                self.report_missing(model, name, path)
        for group in (*model.one_of, *model.any_of):
            if not values.keys() & set(group):
                either = " or ".join((", ".join(group[:-1]), group[-1]))
                self.fault(
                    f"{spoken_name(path)} needs {either}", (*path, group[0]), at_key=True
                )

    def report_missing(self, model: Model, name: str, path: KeyPath) -> None:
        """Add the error of a required key that a block lacks."""
        description = _field_description(model, fields_by_key(model)[name])
        sentence = f"{spoken_name((*path, name))} is required{description}"
        self.fault(sentence, (*path, name), at_key=True)

    def _note_clashes(self, model: Model, values: Mapping[str, Any], path: KeyPath) -> None:
        """Report keys of a block that exclude each other."""
        for group in model.exclusive_groups():
            first, *rest = [name for name in values if name in group] or [""]
            for name in rest:
                sentence = (
                    f"{spoken_name(path)} has {first} already; give {name} or {first}, not both"
                )
                self.fault(sentence, (*path, name), at_key=True)
        missing = [group for group in model.one_of if not values.keys() & set(group)]
        for name, other in model.needs.items():
            reported = any(other in group for group in missing)
            if name in values and other not in values and not reported:
                groups = [group for group in model.any_of if other in group]
                given = next((key for group in groups for key in group if key in values), "")
                fault = f"requires {other}"
                if given:
                    fault = f"has no meaning with {given}, only with {other}; remove it"
                sentence = f"{spoken_name((*path, name))} {fault}"
                self.fault(sentence, (*path, name), at_key=True)


def _with_default_tag(models: list[Model], block: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a block with the tag of the default member if it has none."""
    default = next((model for model in models if getattr(model, "by_default", False)), None)
    tag = discriminator(default) if default else None
    if tag is None or any(key == tag[0] or closest_match(key, [tag[0]]) for key in block):
        return block
    return {tag[0]: tag[1], **block}


def _unknown_key_hint(key: str, value: object, fields: Mapping[str, FieldInfo]) -> str:
    """Return a hint for a key that resembles no other."""
    if key[:1].isdigit() and value is None:
        return "; use a decimal point, not a comma"
    return f"; use one of {', '.join(fields)}"


def _field_description(model: Model, field: FieldInfo) -> str:
    """Return the first clause of a field's description."""
    name = next(name for name, candidate in model.model_fields.items() if candidate is field)
    clause = " ".join(
        re.split(r"[;.](?:\s|$)", field_descriptions(model).get(name, ""))[0].split()
    )
    if clause[1:2].isupper():  # an abbreviation, such as RMS
        return f": {clause}"
    return f": {clause[0].lower()}{clause[1:]}" if clause else ""


def allows_list(annotation: Any) -> bool:
    """Return whether a field may hold a list."""
    return get_origin(annotation) in (list, tuple) or any(
        map(allows_list, get_args(annotation))
    )


def closest_member(word: str, tags: Mapping[str, Model]) -> str | None:
    """Return the member of a union that a word means, by synonym or spelling."""
    for tag, model in tags.items():
        if word.lower() in getattr(model, "also_called", ()):
            return tag
    return closest_match(word, tags)


def blocks_with_key(model: Model, key: str) -> Iterator[str]:
    """Yield the names of the blocks that have a key."""
    for name, entry in fields_by_key(model).items():
        if any(key in fields_by_key(block) for block in block_models(entry.annotation)):
            yield name
