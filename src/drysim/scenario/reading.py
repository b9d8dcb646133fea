"""What keys a scenario may have, and the words of a file read against them.

The keys are those of the models, so nothing here names one: a block is a model, a shelf a union
of models told apart by a tag (`kind`, `law`), and each number knows its unit (`numeric_keys`: what
a sweep may vary). Friction laws may stand in each other's place, so their words are put
together here from those of a block of any law, and what keeps a law from acting is told.

`Reading` holds what is written against that: unknown, missing and clashing keys. One slip is
one fault: a mistyped key is read on as the key that was meant, and a block of an unknown kind
is left alone. Last stand the sentences for what the validation of a model complains about.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from types import UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from drysim.errors import Problem
from drysim.friction import FRICTION_LAWS, Coulomb, Friction
from drysim.units import (
    Block,
    InvalidValue,
    Quantity,
    closest_match,
    did_you_mean,
    field_descriptions,
    format_value,
    shorten,
)
from drysim.wording import join_words
from drysim.yaml_document import UNREAD_KEYS, Document, KeyPath

Model = type[Block]


def fields_by_key(model: Model) -> dict[str, FieldInfo]:
    """Give the fields of a model by the key that a file uses."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def block_models(annotation: Any) -> list[Model]:
    """Give the blocks that a field may hold, alone, in a list or as one of several."""
    if isinstance(annotation, type) and issubclass(annotation, Block):
        return [annotation]
    return [model for part in get_args(annotation) for model in block_models(part)]


def allows_list(annotation: Any) -> bool:
    """Tell whether a field may hold a list."""
    return get_origin(annotation) in (list, tuple) or any(
        map(allows_list, get_args(annotation))
    )


def discriminator(model: Model) -> tuple[str, str] | None:
    """Give the key by which a shelf tells its members apart, and this member's word."""
    for key, field in fields_by_key(model).items():
        if field.is_required() and get_origin(field.annotation) is Literal:
            words = get_args(field.annotation)
            if len(words) == 1:
                return key, words[0]
    return None


def closest_member(word: str, tags: Mapping[str, Model]) -> str | None:
    """Give the member of a shelf that a word means: by another name of it, or by a slip."""
    for tag, model in tags.items():
        if word.lower() in getattr(model, "also_called", ()):
            return tag
    return closest_match(word, tags)


def blocks_with_key(model: Model, key: str) -> Iterator[str]:
    """Give the names of the blocks that know a key."""
    for name, entry in fields_by_key(model).items():
        if any(key in fields_by_key(block) for block in block_models(entry.annotation)):
            yield name


def get_block(words: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Give a block of the words of a file, empty where there is none."""
    block = words.get(name)
    return block if isinstance(block, Mapping) else {}


# The numeric keys of a scenario: what may be swept, and in which unit.

_ASCII_UNITS = str.maketrans({"²": "2", "³": "3", "·": "*"})


class NumericKey(NamedTuple):
    """A key whose value is a number."""

    quantity: Quantity | None
    """What its value may be; None for a whole number."""
    annotation: Any
    """Type of its value."""
    model: Model | None
    """The block that it stands in; None in a list of numbers."""
    block: Mapping[str, Any]
    """What the scenario says in that block."""
    present: bool
    """Whether the scenario has that block."""

    @property
    def unit(self) -> str:
        """Unit of the value, as scenarios spell it."""
        return self.quantity.unit if self.quantity else ""

    @property
    def header(self) -> str:
        """Unit of the value, as tables spell it."""
        return self.unit.translate(_ASCII_UNITS) or "-"

    def read(self, value: object) -> float:
        """Give the number that a value means; a ValueError is a sentence without subject."""
        if self.quantity is not None:
            return self.quantity.read(value)
        try:
            return int(TypeAdapter(self.annotation).validate_python(value))
        except ValidationError as fault:
            raise ValueError(validation_message(fault.errors(include_url=False)[0])) from None

    def here(self, key: str) -> float | None:
        """Give the value that the scenario itself has for a key; None where it has none."""
        name = key.rpartition(".")[2]
        field = fields_by_key(self.model).get(name) if self.model else None
        value = self.block.get(name, field.default if field else None)
        try:
            return None if value is None else self.read(value)
        except ValueError:  # a problem of its own
            return None


KnownKeys = Mapping[str, NumericKey | None]
"""Every key of a scenario by its dotted name, the numeric ones with what is known of them."""


def numeric_keys(model: Model, words: Mapping[str, Any]) -> KnownKeys:
    """Give every key of a scenario.

    Parameters
    ----------
    model : type
        Of the whole scenario.
    words : mapping
        What the scenario says; members of shelves are known by their tags.
    """
    return {**dict(_block_keys(model, words, "", True)), "drysim": None}


def _block_keys(
    model: Model, block: Mapping[str, Any], at: str, present: bool
) -> Iterator[tuple[str, NumericKey | None]]:
    """Give the keys of a block and of the blocks within."""
    for name, entry in fields_by_key(model).items():
        annotation: Any = entry.annotation
        if entry.metadata:
            annotation = Annotated[(annotation, *entry.metadata)]
        found = _as_numeric_key(annotation, model, block, present)
        yield f"{at}{name}", found
        value = block.get(name)
        if not isinstance(value, dict | list) and value == entry.default:
            value = None  # such as `remove: nothing`, which says no more than its absence
        if found is None and not (value is None and entry.is_required()):
            yield from _nested_keys(annotation, value, f"{at}{name}")


def _nested_keys(
    annotation: Any, value: Any, at: str
) -> Iterator[tuple[str, NumericKey | None]]:
    """Give the keys in a value that is a block or a list."""
    kind, _ = _strip_annotation(annotation)
    if get_origin(kind) is tuple:
        for i, entry in enumerate(value if isinstance(value, list | tuple) else ()):
            types = get_args(kind)[0 if Ellipsis in get_args(kind) else i :]
            found = _as_numeric_key(types[0], None, {}, True) if types else None
            yield f"{at}.{i}", found
            if types and found is None:
                yield from _nested_keys(types[0], entry, f"{at}.{i}")
    elif isinstance(value, dict | None) and (models := block_models(kind)):
        block = value or {}
        if chosen := _named_model(models, block):
            yield from _block_keys(chosen, block, f"{at}.", value is not None)


def _named_model(models: list[Model], block: Mapping[str, Any]) -> Model | None:
    """Give the member of a shelf that a block names, or the only model that there is."""
    for model in models:
        tag = discriminator(model)
        if tag is None or block.get(tag[0]) == tag[1]:
            return model
    return None


def _as_numeric_key(
    annotation: Any, model: Model | None, block: Mapping[str, Any], present: bool
) -> NumericKey | None:
    """Give what is known of a number; None for a value that is none."""
    kind, metadata = _strip_annotation(annotation)
    quantity = next((piece for piece in metadata if isinstance(piece, Quantity)), None)
    if quantity is None and kind is not int:
        return None
    return NumericKey(quantity, annotation, model, block, present)


def _strip_annotation(
    annotation: Any, metadata: tuple[Any, ...] = ()
) -> tuple[Any, tuple[Any, ...]]:
    """Give a type without its metadata and the None that it may be; and its metadata."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _strip_annotation(parts[0], (*metadata, *parts[1:]))
    some = [part for part in parts if part is not type(None)]
    if origin in (Union, UnionType) and len(some) == 1:
        return _strip_annotation(some[0], metadata)
    return annotation, metadata


# Friction laws by name, and what each of them is by the words of another.

LAWS: dict[str, type[Friction]] = {
    tag[1]: member for member in FRICTION_LAWS if (tag := discriminator(member))
}
"""The friction laws by name."""

LAW_KEY = "law"
"""The key by which a block says of which law it is."""

DEFAULT_LAW = next(name for name, law in LAWS.items() if getattr(law, "by_default", False))
"""The law of a block that names none."""


def other_laws_hint(key: str) -> str:
    """Say which laws know a key that another law has not got; empty where none does."""
    names = [name for name, law in LAWS.items() if key in law.model_fields]
    if not names:
        return ""
    one = "such a" if len(names) > 1 else "that"
    hint = f"; it belongs to law {join_words(names, 'or')}: choose {one} law"
    if key in Coulomb.model_fields:  # a force, which the block has in other words
        return hint
    return f"{hint}, or for comparisons write `{names[0]}: {{{key}: ...}}`"


def merge_law_keys(
    name: str, block: Mapping[str, Any], own: Mapping[str, Any]
) -> dict[str, Any]:
    """Give the words of a law: its own options, and what it shares with a block.

    An option stands for every key of the block that it excludes, such as `mu_kinetic` for
    `kinetic`; what is left there without the key that it needs is left out.
    """
    law = LAWS[name]
    known = law.model_fields.keys() - excluded_keys(name, own) - {LAW_KEY}
    words = {key: value for key, value in block.items() if key in known} | dict(own)
    for key, other in law.needs.items():
        if key in words and key not in own and other not in words:
            del words[key]
    return words


def excluded_keys(name: str, own: Collection[str]) -> set[str]:
    """Give the keys of a law that do not go together with some of its keys, these included."""
    groups = [{*group} for group in LAWS[name].exclusive_groups()]
    return set(own).union(*(group for group in groups if group & {*own}))


def law_arguments(friction: Friction, name: str) -> dict[str, Any]:
    """Give the words of a law as a block of any law has them, in SI."""
    return merge_law_keys(name, set_values(friction), law_options(friction, name))


def friction_uses_key(friction: Friction, name: str, key: str) -> bool:
    """Whether a law would use a key of the block of another, whoever gives it there."""
    own = law_options(friction, name)
    return key not in own and key in merge_law_keys(
        name, set_values(friction) | {key: None}, own
    )


def law_options(friction: Friction, name: str) -> dict[str, Any]:
    """Give the options of a law in the block of another, in SI."""
    options = getattr(friction, name, None)
    return {} if options is None else set_values(options)


def set_values(block: Block) -> dict[str, Any]:
    """Give what a block says."""
    return {key: value for key, value in block if value is not None and key != LAW_KEY}


def friction_under_law(friction: Friction, name: str) -> Friction:
    """Give the friction of a law as a block of any law has it, which `law_faults` has checked.

    Nothing is checked anew, so columns of values may stand in place of numbers.
    """
    if friction.law == name:
        return friction
    words: dict[str, Any] = law_arguments(friction, name) | {LAW_KEY: name}
    record = getattr(friction, "normal_record", None)
    if record is not None and "mu_kinetic" in words and "normal" in LAWS[name].model_fields:
        words.setdefault("normal", record.force_record().mean)
    return LAWS[name].model_construct(**words)


def _missing_keys(friction: Friction, name: str) -> list[str]:
    """Give the keys, with their units, that a block must get before a law can act."""
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
    """Give the dotted key and the sentence for everything that keeps a law from acting."""
    if friction is None or name in ("", friction.law):
        return
    if needed := _missing_keys(friction, name):
        way = f"give them in a block `{name}` of friction"
        yield "friction", f"law {name} needs {join_words(needed)}: {way}"
        return
    try:
        LAWS[name].model_validate(law_arguments(friction, name) | {LAW_KEY: name})
    except ValidationError as fault:
        for error in fault.errors(include_url=False):
            cause = error.get("ctx", {}).get("error")
            at = [*error["loc"], *(cause.at if isinstance(cause, InvalidValue) else ())]
            message = str(cause) if cause is not None else validation_message(error)
            own = bool(at) and at[0] in law_options(friction, name)
            keys = ("friction", *([name] if own else []), *at)
            sentence = f"friction as {name}: {'.'.join(map(str, at))} {message}"
            yield ".".join(map(str, keys)), sentence


# What is written, held against what a scenario may say.

MAX_PROBLEMS = 100
"""Problems of a file that are told; whoever has more mends these first."""


class TooManyProblems(Exception):
    """There are more problems than anybody reads; no more are looked for."""


class Reading:
    """A document as far as it can be read as a model, and the problems of doing so.

    Every note of a problem may raise `TooManyProblems`; those noted by then are kept.
    """

    def __init__(self, document: Document, model: Model) -> None:
        self.document = document
        self.model = model
        self.problems: list[Problem] = []
        self.spelling: dict[KeyPath, str] = {}
        """Keys as the document spells them, by what they were taken for."""
        self.hoisted: dict[KeyPath, KeyPath] = {}
        """Where the options of a block's own law stand, by the keys that they are read as."""
        self.reported: set[KeyPath] = set()
        """Values with a fault of their own, about which no more is to be said."""
        self.words: dict[str, Any] = {}

    def read(self) -> dict[str, Any]:
        """Give the words of the document that its model knows."""
        self.words = self.block(self.model, self.document.value, ())
        return self.words

    def fault(
        self, sentence: str, keys: KeyPath, at_key: bool = False, instead: KeyPath = ()
    ) -> None:
        """Note a problem, unless its place or a block around it has one already.

        `instead` is the value to show when the whole block is missing.
        """
        if any(keys[: i + 1] in self.reported for i in range(len(keys))):
            return
        self.reported.add(keys)
        spelling = tuple(self.spelling.get(keys[: i + 1], key) for i, key in enumerate(keys))
        if instead and spelling[0] not in self.document.value:
            spelling, at_key = instead, False
        place = self.document.locate(self._location(spelling), at_key)
        self.problems.append(place.problem(sentence, dotted_name(keys)))
        if len(self.problems) > MAX_PROBLEMS:
            raise TooManyProblems

    def block(self, model: Model, block: Mapping[str, Any], at: KeyPath) -> dict[str, Any]:
        """Give a block with the keys that its model knows."""
        fields, words = fields_by_key(model), {}
        for key, value in block.items():
            name = (
                key
                if key in fields or key == UNREAD_KEYS
                else self._resolve_unknown(key, model, block, at)
            )
            if name in fields and name not in words:
                if name != key:
                    self.spelling[*at, name] = key
                words[name] = self._value(fields[name], value, (*at, name))
        if UNREAD_KEYS not in block:
            self._note_missing(model, words, at)
        self._note_clashes(model, words, at)
        return {name: value for name, value in words.items() if value is not None}

    def _value(self, field: FieldInfo, value: Any, at: KeyPath) -> Any:
        """Give a value, the blocks in it read in their turn; None where there is a fault."""
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
            self.reported.add(at)  # such as `mass: {{ mass }}`, which has its problem already
        return value

    def _choose_member(
        self, models: list[Model], block: Mapping[str, Any], at: KeyPath
    ) -> Model | None:
        """Give the member of a shelf that a block names by its tag."""
        tagged = [(discriminator(model), model) for model in models]
        tags = {found[1]: model for found, model in tagged if found}
        tag = next((found[0] for found, _ in tagged if found), None)
        if tag is None:
            return models[0]
        mistyped = next((key for key in block if closest_match(key, [tag])), tag)
        word = block.get(tag, block.get(mistyped))
        if isinstance(word, str) and word in tags:
            return tags[word]
        if word is None:
            sentence = f"{dotted_name((*at, tag))} is required; known are {', '.join(tags)}"
            self.fault(sentence, at, at_key=True)
        else:
            nearest = closest_member(word, tags) if isinstance(word, str) else None
            hint = did_you_mean(nearest) or f"; known are {', '.join(tags)}"
            sentence = f"unknown {tag} {format_value(word)} in {dotted_name(at)}{hint}"
            self.fault(sentence, (*at, tag))
        self.reported.add(at)
        return None

    def _hoist(self, model: Model, block: Mapping[str, Any], at: KeyPath) -> Mapping[str, Any]:
        """Give the block of a law with its own options as keys of the block itself."""
        tag = discriminator(model)
        if tag is None or tag[0] != LAW_KEY or not isinstance(own := block.get(tag[1]), dict):
            return block
        self.hoisted |= {(*at, key): (*at, tag[1], key) for key in own}
        less = {tag[1], *excluded_keys(tag[1], own)}
        return {key: value for key, value in block.items() if key not in less} | own

    def _location(self, keys: KeyPath) -> KeyPath:
        """Give where a value stands in the document."""
        for i in range(len(keys), 0, -1):
            if keys[:i] in self.hoisted:
                return (*self.hoisted[keys[:i]], *keys[i:])
        return keys

    def _resolve_unknown(
        self, key: str, model: Model, block: Mapping[str, Any], at: KeyPath
    ) -> str | None:
        """Note an unknown key; give the key that was meant, unless that stands there too."""
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
        """Note the keys that a block needs."""
        for name, entry in fields_by_key(model).items():
            if entry.is_required() and name not in words:
                sentence = (
                    f"{dotted_name((*at, name))} is required{_field_description(model, entry)}"
                )
                self.fault(sentence, (*at, name), at_key=True)
        for group in (*model.one_of, *model.any_of):
            if not words.keys() & set(group):
                either = " or ".join(group)
                self.fault(f"{dotted_name(at)} needs {either}", (*at, group[0]), at_key=True)

    def _note_clashes(self, model: Model, words: Mapping[str, Any], at: KeyPath) -> None:
        """Note the keys of a block that do not go together."""
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
                sentence = f"{dotted_name((*at, name))} has a meaning only beside {other}"
                self.fault(sentence, (*at, name), at_key=True)


def _with_default_tag(models: list[Model], block: Mapping[str, Any]) -> Mapping[str, Any]:
    """Give a block that names no member of a shelf with the name of the default one, if any."""
    default = next((one for one in models if getattr(one, "by_default", False)), None)
    tag = discriminator(default) if default else None
    if tag is None or any(key == tag[0] or closest_match(key, [tag[0]]) for key in block):
        return block
    return {tag[0]: tag[1], **block}


def dotted_name(keys: KeyPath) -> str:
    """Give the name of a value in sentences."""
    return ".".join(shorten(str(key)) for key in keys)


def _unknown_key_hint(key: str, value: object, fields: Mapping[str, FieldInfo]) -> str:
    """Say what to do about a key that resembles nothing."""
    if key[:1].isdigit() and value is None:
        return "; write decimals with a point, not with a comma"
    return f"; known are {', '.join(fields)}"


def _field_description(model: Model, field: FieldInfo) -> str:
    """Give the first clause of the text under a field."""
    name = next(name for name, known in model.model_fields.items() if known is field)
    clause = " ".join(
        re.split(r"[;.](?:\s|$)", field_descriptions(model).get(name, ""))[0].split()
    )
    return f": {clause[0].lower()}{clause[1:]}" if clause else ""


# What the validation of a model complains about, in sentences.

ALREADY_REPORTED = {"missing", "extra_forbidden", "union_tag_invalid", "union_tag_not_found"}
"""Complaints about keys, which the reading of the file has made already."""

_PREDICATES = ("must ", "needs ", "has ", "is ", "asks ", "gives ", "stands ")

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
    "too_short": "must have {min_length} entry at least",
    "greater_than": "must be above {gt}, not {value}",
    "greater_than_equal": "must be at least {ge}, not {value}",
    "less_than": "must be below {lt}, not {value}",
    "less_than_equal": "must be at most {le}, not {value}",
}


def validation_faults(
    fault: ValidationError, words: Mapping[str, Any], at: KeyPath = ()
) -> Iterator[tuple[KeyPath, str]]:
    """Give the keys to blame and the sentence for every complaint.

    `at` are the keys of the block that was validated, if it was not the whole scenario.
    """
    for error in fault.errors(include_url=False):
        if error["type"] in ALREADY_REPORTED:
            continue
        keys = _without_tags((*at, *error["loc"]), words)
        cause = error.get("ctx", {}).get("error")
        if isinstance(cause, InvalidValue):
            keys = (*keys, *cause.at)
        text = str(cause) if cause is not None else validation_message(error)
        yield keys, with_subject(keys, text)


def report_value(reading: Reading, sentence: str, keys: KeyPath, at_key: bool = False) -> None:
    """Note a problem of a value, whose name begins the sentence."""
    reading.fault(with_subject(keys, sentence), keys, at_key)


def with_subject(keys: KeyPath, text: str) -> str:
    """Give the sentence about a value from its key and what is said of it."""
    return f"{dotted_name(keys)}{' ' if text.startswith(_PREDICATES) else ': '}{text}"


def _without_tags(loc: KeyPath, words: Any) -> KeyPath:
    """Give a location without the tags of shelves that stand in it."""
    keys: list[str | int] = [*loc[:1]]
    words = words.get(loc[0])
    for step in loc[1:]:
        inside = isinstance(words, dict) and step in words
        if inside or (isinstance(words, list) and isinstance(step, int)):
            keys.append(step)
            words = words[step]
    return tuple(keys)


def validation_message(error: ErrorDetails) -> str:
    """Give the sentence for a complaint of the validation library, without its subject."""
    value, context = error["input"], error.get("ctx", {})
    if error["type"] == "literal_error":
        expected = str(context["expected"]).replace("'", "")
        words = expected.replace(" or ", ", ").split(", ")
        hint = did_you_mean(closest_match(value, words)) if isinstance(value, str) else ""
        return f"must be {expected}, not {format_value(value)}{hint}"
    form = _MESSAGES.get(error["type"])
    if form and isinstance(value, list | dict):
        form = form.removesuffix("; put it in quotes")  # which makes text of a number only
    return form.format(value=format_value(value), **context) if form else error["msg"]
