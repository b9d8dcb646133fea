"""Keys that a scenario may have, and a document read against them.

1. Keys. They are derived from the models: a block is a model, a choice is a union of models
   distinguished by a tag (`kind`, `law`), and each numeric key has a unit (`numeric_keys`). A
   sweep may vary numeric keys only.
2. Friction laws. The parameters of any law are collected from a block of any other law, for
   comparisons; `law_faults` reports what is missing.
3. `Reading`. It compares a document with the models: unknown, missing and clashing keys. One
   mistake gives one error: a misspelled key is read as the closest key, and a block of unknown
   kind is skipped.
4. Messages for validation errors of pydantic.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from types import UnionType
from typing import Annotated, Any, NamedTuple, TypeVar, Union, get_args, get_origin

from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from drysim.block import Block, InvalidValue, field_descriptions
from drysim.direction import mean_of_directions
from drysim.errors import Problem
from drysim.friction import FRICTION_LAWS, Coulomb, Friction
from drysim.messages import closest_match, did_you_mean, format_value, shorten
from drysim.quantity import Quantity
from drysim.wording import join_words
from drysim.yaml_document import UNREAD_KEYS, Document, KeyPath

Model = type[Block]
Tagged = TypeVar("Tagged", bound=Block)

TAG_KEYS = ("kind", "law")
"""Keys whose value selects a member of a union of models."""


def fields_by_key(model: Model) -> dict[str, FieldInfo]:
    """Return the fields of a model by the key used in a file."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def block_models(annotation: Any) -> list[Model]:
    """Return the models a field may hold: alone, in a list or in a union."""
    if isinstance(annotation, type) and issubclass(annotation, Block):
        return [annotation]
    return [model for part in get_args(annotation) for model in block_models(part)]


def allows_list(annotation: Any) -> bool:
    """Return whether a field may hold a list."""
    return get_origin(annotation) in (list, tuple) or any(
        map(allows_list, get_args(annotation))
    )


def discriminator(model: Model) -> tuple[str, str] | None:
    """Return the tag key of a model in a union and its value; None if it has none."""
    for key in TAG_KEYS:
        field = model.model_fields.get(key)
        words = get_args(field.annotation) if field and field.is_required() else ()
        if len(words) == 1:
            return key, words[0]
    return None


def members_by_tag(models: Iterable[type[Tagged]]) -> dict[str, type[Tagged]]:
    """Return the members of a union by the value of their tag key."""
    return {tag[1]: model for model in models if (tag := discriminator(model))}


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


def get_block(words: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Return a block of a document; empty if there is none."""
    block = words.get(name)
    return block if isinstance(block, Mapping) else {}


# Numeric keys of a scenario, with their units

_ASCII_UNITS = str.maketrans({"²": "2", "³": "3", "·": "*"})


class NumericKey(NamedTuple):
    """A key with a numeric value."""

    quantity: Quantity | None
    """Unit and bounds of the value; None for an integer."""
    annotation: Any
    """Type of the value."""
    model: Model | None
    """Model of the block with this key; None in a list of numbers."""
    block: Mapping[str, Any]
    """Block with this key, as in the scenario."""
    present: bool
    """Whether the scenario has that block."""

    @property
    def unit(self) -> str:
        """Unit of the value as in scenarios."""
        return self.quantity.unit if self.quantity else ""

    @property
    def header(self) -> str:
        """Unit of the value as in table headers."""
        return self.unit.translate(_ASCII_UNITS) or "-"

    def read(self, value: object) -> float:
        """Return the number for a value; the ValueError message has no subject."""
        if self.quantity is not None:
            return self.quantity.read(value)
        try:
            return int(TypeAdapter(self.annotation).validate_python(value))
        except ValidationError as fault:
            raise ValueError(validation_message(fault.errors(include_url=False)[0])) from None

    def here(self, key: str) -> float | None:
        """Return the value in the scenario or its default; None if there is none."""
        name = key.rpartition(".")[2]
        field = fields_by_key(self.model).get(name) if self.model else None
        value = self.block.get(name, field.default if field else None)
        try:
            return None if value is None else self.read(value)
        except ValueError:  # reported elsewhere
            return None


KnownKeys = Mapping[str, NumericKey | None]
"""All dotted keys of a scenario; None for those that are not numeric."""


def numeric_keys(model: Model, words: Mapping[str, Any]) -> KnownKeys:
    """Return all dotted keys of a scenario with this model and these plain values.

    The tags among the values select the members of unions.
    """
    return {**dict(_block_keys(model, words, "", True)), "drysim": None}


def _block_keys(
    model: Model, block: Mapping[str, Any], at: str, present: bool
) -> Iterator[tuple[str, NumericKey | None]]:
    """Yield the dotted keys of a block and of nested blocks."""
    for name, entry in fields_by_key(model).items():
        annotation: Any = entry.annotation
        if entry.metadata:
            annotation = Annotated[(annotation, *entry.metadata)]
        value = block.get(name)
        found = None
        if not isinstance(value, dict):
            found = _as_numeric_key(annotation, model, block, present)
        yield f"{at}{name}", found
        if not isinstance(value, dict | list) and value == entry.default:
            value = None  # the default, such as `remove: nothing`
        if found is None and not (value is None and entry.is_required()):
            yield from _nested_keys(annotation, value, f"{at}{name}")


def _nested_keys(
    annotation: Any, value: Any, at: str
) -> Iterator[tuple[str, NumericKey | None]]:
    """Yield the dotted keys in a block or list."""
    kind, _ = _strip_annotation(annotation)
    if get_origin(kind) is tuple:
        for i, entry in enumerate(value if isinstance(value, list | tuple) else ()):
            types = get_args(kind)[0 if Ellipsis in get_args(kind) else i :]
            found = _as_numeric_key(types[0], None, {}, True) if types else None
            yield f"{at}.{i}", found
            if types and found is None:
                yield from _nested_keys(types[0], entry, f"{at}.{i}")
    elif isinstance(value, dict | None) and (models := block_models(annotation)):
        block = value or {}
        if chosen := _named_model(models, block):
            yield from _block_keys(chosen, block, f"{at}.", value is not None)


def _named_model(models: list[Model], block: Mapping[str, Any]) -> Model | None:
    """Return the model that the tag of a block selects, or the only model."""
    for model in models:
        tag = discriminator(model)
        if tag is None or block.get(tag[0]) == tag[1]:
            return model
    return None


def _as_numeric_key(
    annotation: Any, model: Model | None, block: Mapping[str, Any], present: bool
) -> NumericKey | None:
    """Return the numeric key for a field; None if it is not numeric."""
    kind, metadata = _strip_annotation(annotation)
    quantity = next((piece for piece in metadata if isinstance(piece, Quantity)), None)
    if quantity is None and kind is not int:
        return None
    return NumericKey(quantity, annotation, model, block, present)


def _strip_annotation(
    annotation: Any, metadata: tuple[Any, ...] = ()
) -> tuple[Any, tuple[Any, ...]]:
    """Return a type without metadata and None, and its metadata."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _strip_annotation(parts[0], (*metadata, *parts[1:]))
    some = [part for part in parts if part is not type(None)]
    if len(some) > 1:  # a number, or a block with one per direction
        some = [part for part in some if not block_models(part)]
    if origin in (Union, UnionType) and len(some) == 1:
        return _strip_annotation(some[0], metadata)
    return annotation, metadata


# Friction laws, and their parameters from a block of another law

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
    one = "one of these laws" if len(names) > 1 else "that law"
    hint = f"; it belongs to law {join_words(names, 'or')}: choose {one}"
    if key in Coulomb.model_fields:  # a force, given by other keys
        return hint
    return f"{hint}, or for comparisons write `{names[0]}: {{{key}: ...}}`"


def merge_law_keys(
    name: str, block: Mapping[str, Any], own: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the parameters of a law: its own options and shared keys of a block.

    An option replaces all keys of the block that it excludes, such as `mu_kinetic` for
    `kinetic`; keys that require a replaced key are dropped.
    """
    law = LAWS[name]
    known = law.model_fields.keys() - excluded_keys(name, own) - {LAW_KEY}
    words = {key: value for key, value in block.items() if key in known} | dict(own)
    for key, other in law.needs.items():
        if key in words and key not in own and other not in words:
            del words[key]
    return words


def excluded_keys(name: str, own: Collection[str]) -> set[str]:
    """Return the keys of a law excluded by some of its keys, including these."""
    groups = [{*group} for group in LAWS[name].exclusive_groups()]
    return set(own).union(*(group for group in groups if group & {*own}))


def law_arguments(friction: Friction, name: str) -> dict[str, Any]:
    """Return the parameters of a law from a block of any law, in SI."""
    shared = set_values(friction)
    if name != friction.law:
        shared = {key: mean_of_directions(value) for key, value in shared.items()}
    return merge_law_keys(name, shared, law_options(friction, name))


def friction_uses_key(friction: Friction, name: str, key: str) -> bool:
    """Return whether a law would use a key of the block of another law."""
    own = law_options(friction, name)
    return key not in own and key in merge_law_keys(
        name, set_values(friction) | {key: None}, own
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
    words: dict[str, Any] = law_arguments(friction, name) | {LAW_KEY: name}
    record = getattr(friction, "normal_record", None)
    if record is not None and "mu_kinetic" in words and "normal" in LAWS[name].model_fields:
        words.setdefault("normal", record.force_record().mean)
    return LAWS[name].model_construct(**words)


def _missing_keys(friction: Friction, name: str) -> list[str]:
    """Return the keys a law still needs, with their units."""
    law, words = LAWS[name], law_arguments(friction, name)
    found = [
        key
        for key, field in fields_by_key(law).items()
        if field.is_required() and key not in words and key != LAW_KEY
    ]
    either = [group[0] for group in law.one_of if not words.keys() & {*group}]
    known = numeric_keys(law, {})
    units = {key: f" [{numeral.unit or '-'}]" for key, numeral in known.items() if numeral}
    return [f"friction.{name}.{key}{units.get(key, '')}" for key in (*either, *found)]


def law_faults(friction: Friction | None, name: str) -> Iterator[tuple[str, str]]:
    """Yield the dotted key and message of everything that prevents using a law."""
    if not name or (friction is not None and friction.law == name):
        return
    if friction is None:
        yield "friction", f"law {name} needs a friction block; this scenario has none"
        return
    if needed := _missing_keys(friction, name):
        remedy = f"give them in a block `{name}` in friction"
        yield "friction", f"law {name} needs {join_words(needed)}: {remedy}"
        return
    try:
        LAWS[name].model_validate(law_arguments(friction, name) | {LAW_KEY: name})
    except ValidationError as fault:
        for error in fault.errors(include_url=False):
            at = (*error["loc"], *_blamed_path(error))
            own = bool(at) and at[0] in law_options(friction, name)
            keys = ("friction", *([name] if own else []), *at)
            message = validation_message(error)
            sentence = f"friction as {name}: {'.'.join(map(str, at))} {message}"
            yield ".".join(map(str, keys)), sentence


# The document compared with the models

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
        self.words: dict[str, Any] = {}

    def read(self, words: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values whose keys the model has, of the document as completed."""
        self.words = self.block(self.model, words, ())
        return self.words

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
        if instead and path[0] not in self.document.value:
            path, at_key = instead, False
        place = self.document.locate(path, at_key)
        self.problems.append(place.problem(sentence, dotted_name(keys)))
        if len(self.problems) > MAX_PROBLEMS:
            raise TooManyProblems

    def report_value(self, sentence: str, keys: KeyPath, at_key: bool = False) -> None:
        """Add an error of a value; its key precedes the message."""
        self.fault(with_subject(keys, sentence), keys, at_key)

    @contextmanager
    def reporting(self, at: KeyPath) -> Iterator[None]:
        """Report a ValueError on the value at a path, or below it if the error says where."""
        try:
            yield
        except ValueError as fault:
            self.report_value(str(fault), (*at, *getattr(fault, "at", ())))

    def block(self, model: Model, block: Mapping[str, Any], at: KeyPath) -> dict[str, Any]:
        """Return the values of a block whose keys the model has."""
        fields, words = fields_by_key(model), {}
        for key, value in block.items():
            name = (
                key
                if key in fields or key == UNREAD_KEYS
                else self._resolve_unknown(key, model, block, at)
            )
            if name in fields and name not in words:
                if name != key:
                    self.moved[*at, name] = self._location((*at, key))
                words[name] = self._value(fields[name], value, (*at, name))
        if UNREAD_KEYS not in block:
            self._note_missing(model, words, at)
        self._note_clashes(model, words, at)
        return {name: value for name, value in words.items() if value is not None}

    def _value(self, field: FieldInfo, value: Any, at: KeyPath) -> Any:
        """Return a value with nested blocks read; None if it has an error."""
        models = block_models(field.annotation)
        if value is None:
            self.fault(f"{dotted_name(at)} has no value", at, at_key=True)
        elif isinstance(value, list) and (not models or allows_list(field.annotation)):
            return [self._value(field, entry, (*at, i)) for i, entry in enumerate(value)]
        elif models and isinstance(value, dict):
            value = _with_default_tag(models, value)
            model = self._choose_member(models, value, at)
            return self.block(model, self._hoist(model, value, at), at) if model else None
        elif isinstance(value, dict) and UNREAD_KEYS in value:
            self.reported.add(at)  # such as `mass: {{ mass }}`, reported by the parser
        return value

    def _choose_member(
        self, models: list[Model], block: Mapping[str, Any], at: KeyPath
    ) -> Model | None:
        """Return the model that the tag of a block selects; None if unknown."""
        tags = members_by_tag(models)
        tag = next((found[0] for found in map(discriminator, models) if found), None)
        if tag is None:
            return models[0]
        mistyped = next((key for key in block if closest_match(key, [tag])), tag)
        word = block.get(tag, block.get(mistyped))
        if isinstance(word, str) and word in tags:
            return tags[word]
        if word is None:
            sentence = f"{dotted_name((*at, tag))} is required; use one of {', '.join(tags)}"
            self.fault(sentence, at, at_key=True)
        else:
            nearest = closest_member(word, tags) if isinstance(word, str) else None
            hint = did_you_mean(nearest) or f"; use one of {', '.join(tags)}"
            sentence = f"unknown {tag} {format_value(word)} in {dotted_name(at)}{hint}"
            self.fault(sentence, (*at, tag))
        self.reported.add(at)
        return None

    def _hoist(self, model: Model, block: Mapping[str, Any], at: KeyPath) -> Mapping[str, Any]:
        """Return a law block with its own options moved to the block itself."""
        tag = discriminator(model)
        if tag is None or tag[0] != LAW_KEY or not isinstance(own := block.get(tag[1]), dict):
            return block
        self.moved |= {(*at, key): self._location((*at, tag[1], key)) for key in own}
        less = {tag[1], *excluded_keys(tag[1], own)}
        return {key: value for key, value in block.items() if key not in less} | own

    def _location(self, keys: KeyPath) -> KeyPath:
        """Return the path of a value in the document."""
        for i in range(len(keys), 0, -1):
            if keys[:i] in self.moved:
                return (*self.moved[keys[:i]], *keys[i:])
        return keys

    def _resolve_unknown(
        self, key: str, model: Model, block: Mapping[str, Any], at: KeyPath
    ) -> str | None:
        """Report an unknown key; return the key meant, if it is not in use."""
        fields = fields_by_key(model)
        nearest = closest_match(key, fields.keys() - block.keys()) or closest_match(key, fields)
        home = [name for name in blocks_with_key(self.model, key) if (name,) != at[:1]]
        where = f" in {dotted_name(at)}" if at else ""
        if tag := discriminator(model):
            where += f" of {tag[0]} {tag[1]}"
        if 0 < len(home) < 3:
            nearest, hint = None, f"; it belongs in {' or '.join(home)}"
        elif tag and tag[0] == LAW_KEY and (hint := other_laws_hint(key)):
            nearest = None
        else:
            hint = did_you_mean(nearest) or _unknown_key_hint(key, block[key], fields)
        self.fault(f"unknown key {format_value(key)}{where}{hint}", (*at, key), at_key=True)
        return nearest if nearest not in block else None

    def _note_missing(self, model: Model, words: Mapping[str, Any], at: KeyPath) -> None:
        """Report missing keys of a block."""
        for name, entry in fields_by_key(model).items():
            if entry.is_required() and name not in words:
                sentence = (
                    f"{dotted_name((*at, name))} is required{_field_description(model, entry)}"
                )
                self.fault(sentence, (*at, name), at_key=True)
        for group in (*model.one_of, *model.any_of):
            if not words.keys() & set(group):
                either = " or ".join((", ".join(group[:-1]), group[-1]))
                self.fault(f"{dotted_name(at)} needs {either}", (*at, group[0]), at_key=True)

    def _note_clashes(self, model: Model, words: Mapping[str, Any], at: KeyPath) -> None:
        """Report keys of a block that exclude each other."""
        for group in model.exclusive_groups():
            first, *rest = [name for name in words if name in group] or [""]
            for name in rest:
                sentence = (
                    f"{dotted_name(at)} has {first} already; give {name} or {first}, not both"
                )
                self.fault(sentence, (*at, name), at_key=True)
        missing = [group for group in model.one_of if not words.keys() & set(group)]
        for name, other in model.needs.items():
            reported = any(other in group for group in missing)
            if name in words and other not in words and not reported:
                sentence = f"{dotted_name((*at, name))} requires {other}"
                self.fault(sentence, (*at, name), at_key=True)


def _with_default_tag(models: list[Model], block: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a block with the tag of the default member if it has none."""
    default = next((one for one in models if getattr(one, "by_default", False)), None)
    tag = discriminator(default) if default else None
    if tag is None or any(key == tag[0] or closest_match(key, [tag[0]]) for key in block):
        return block
    return {tag[0]: tag[1], **block}


def dotted_name(keys: KeyPath) -> str:
    """Return a key path in dotted form."""
    return ".".join(shorten(str(key)) for key in keys)


def _unknown_key_hint(key: str, value: object, fields: Mapping[str, FieldInfo]) -> str:
    """Return a hint for a key that resembles no other."""
    if key[:1].isdigit() and value is None:
        return "; use a decimal point, not a comma"
    return f"; use one of {', '.join(fields)}"


def _field_description(model: Model, field: FieldInfo) -> str:
    """Return the first clause of a field's description."""
    name = next(name for name, known in model.model_fields.items() if known is field)
    clause = " ".join(
        re.split(r"[;.](?:\s|$)", field_descriptions(model).get(name, ""))[0].split()
    )
    if clause[1:2].isupper():  # an abbreviation, such as RMS
        return f": {clause}"
    return f": {clause[0].lower()}{clause[1:]}" if clause else ""


# Messages for validation errors

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
    fault: ValidationError, words: Mapping[str, Any], at: KeyPath = ()
) -> Iterator[tuple[KeyPath, str]]:
    """Yield the key path and message of every validation error.

    `words` are the values that were validated, and `at` is the path of the block that was
    validated, if not the whole scenario.
    """
    for error in fault.errors(include_url=False):
        if error["type"] in ALREADY_REPORTED:
            continue
        keys = (*_without_tags((*at, *error["loc"]), words), *_blamed_path(error))
        yield keys, with_subject(keys, validation_message(error))


def with_subject(keys: KeyPath, text: str) -> str:
    """Return a message with the key as its subject."""
    return f"{dotted_name(keys)}{' ' if text.startswith(_PREDICATES) else ': '}{text}"


def _without_tags(loc: KeyPath, words: Any) -> KeyPath:
    """Return a pydantic location without the tags of unions in it."""
    keys: list[str | int] = [*loc[:1]]
    words = words.get(loc[0])
    for step in loc[1:]:
        inside = isinstance(words, dict) and step in words
        if inside or (isinstance(words, list) and isinstance(step, int)):
            keys.append(step)
            words = words[step]
    return tuple(keys)


def _blamed_path(error: ErrorDetails) -> KeyPath:
    """Return the path of the key that our exception blames, relative to its block."""
    cause = error.get("ctx", {}).get("error")
    return cause.at if isinstance(cause, InvalidValue) else ()


def validation_message(error: ErrorDetails) -> str:
    """Return the message for a pydantic error, without subject."""
    value, context = error["input"], error.get("ctx", {})
    if "error" in context:  # our exception
        return str(context["error"])
    if error["type"] == "literal_error":
        expected = str(context["expected"]).replace("'", "")
        words = expected.replace(" or ", ", ").split(", ")
        hint = did_you_mean(closest_match(value, words)) if isinstance(value, str) else ""
        return f"must be {expected}, not {format_value(value)}{hint}"
    form = _MESSAGES.get(error["type"])
    if form and isinstance(value, list | dict):
        form = form.removesuffix("; put it in quotes")  # which helps for scalars only
    return form.format(value=format_value(value), **context) if form else error["msg"]
