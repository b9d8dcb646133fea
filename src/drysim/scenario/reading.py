"""What is written, held against what a scenario may say: unknown, missing and clashing keys.

One slip is one fault: a mistyped key is read on as the key that was meant, and a block of an
unknown kind is left alone.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from pydantic.fields import FieldInfo

from drysim.errors import Problem
from drysim.quantity import meant, near, short, shown, texts_of
from drysim.scenario.laws import BY_NAME, excluded, of_other_laws
from drysim.scenario.shape import (
    Model,
    homes,
    is_default,
    keys_of,
    may_list,
    member_meant,
    models_in,
    tag_of,
)
from drysim.source import LOST, Document, Keys

MOST_PROBLEMS = 100
"""Problems of a file that are told; whoever has more mends these first."""


class Enough(Exception):
    """There are more problems than anybody reads; no more are looked for."""


class Reading:
    """A document as far as it can be read as a model, and the problems of doing so.

    Every note of a problem may raise `Enough`; those noted by then are kept.
    """

    def __init__(self, document: Document, model: Model) -> None:
        self.document = document
        self.model = model
        self.problems: list[Problem] = []
        self.spelt: dict[Keys, str] = {}
        """Keys as the document spells them, by what they were taken for."""
        self.lifted: dict[Keys, Keys] = {}
        """Where the options of a block's own law stand, by the keys that they are read as."""
        self.closed: set[Keys] = set()
        """Values with a fault of their own, about which no more is to be said."""
        self.words: dict[str, Any] = {}

    def read(self) -> dict[str, Any]:
        """Give the words of the document that its model knows."""
        self.words = self.block(self.model, self.document.value, ())
        return self.words

    def fault(
        self, sentence: str, keys: Keys, at_key: bool = False, instead: Keys = ()
    ) -> None:
        """Note a problem, unless its place or a block around it has one already.

        `instead` is the value to show when the whole block is missing.
        """
        if any(keys[: i + 1] in self.closed for i in range(len(keys))):
            return
        self.closed.add(keys)
        spelt = tuple(self.spelt.get(keys[: i + 1], key) for i, key in enumerate(keys))
        if instead and spelt[0] not in self.document.value:
            spelt, at_key = instead, False
        place = self.document.locate(self._home(spelt), at_key)
        self.problems.append(place.problem(sentence, dotted(keys)))
        if len(self.problems) > MOST_PROBLEMS:
            raise Enough

    def block(self, model: Model, given: Mapping[str, Any], at: Keys) -> dict[str, Any]:
        """Give a block with the keys that its model knows."""
        fields, words = keys_of(model), {}
        for key, value in given.items():
            name = key if key in fields or key == LOST else self._meant(key, model, given, at)
            if name in fields and name not in words:
                if name != key:
                    self.spelt[*at, name] = key
                words[name] = self._value(fields[name], value, (*at, name))
        if LOST not in given:
            self._missing(model, words, at)
        self._clashing(model, words, at)
        return {name: value for name, value in words.items() if value is not None}

    def _value(self, field: FieldInfo, value: Any, at: Keys) -> Any:
        """Give a value, the blocks in it read in their turn; None where there is a fault."""
        models = models_in(field.annotation)
        if value is None:
            self.fault(f"{dotted(at)} has no value", at, at_key=True)
        elif isinstance(value, list) and (not models or may_list(field.annotation)):
            return [self._value(field, entry, (*at, i)) for i, entry in enumerate(value)]
        elif models and isinstance(value, dict):
            value = _with_default(models, value)
            model = self._chosen(models, value, at)
            return self.block(model, self._lift(model, value, at), at) if model else None
        elif isinstance(value, dict) and LOST in value:
            self.closed.add(at)  # such as `mass: {{ mass }}`, which has its problem already
        return value

    def _chosen(self, models: list[Model], given: Mapping[str, Any], at: Keys) -> Model | None:
        """Give the member of a shelf that a block names by its tag."""
        tagged = [(tag_of(model), model) for model in models]
        tags = {found[1]: model for found, model in tagged if found}
        tag = next((found[0] for found, _ in tagged if found), None)
        if tag is None:
            return models[0]
        mistyped = next((key for key in given if near(key, [tag])), tag)
        word = given.get(tag, given.get(mistyped))
        if isinstance(word, str) and word in tags:
            return tags[word]
        if word is None:
            sentence = f"{dotted((*at, tag))} is required; known are {', '.join(tags)}"
            self.fault(sentence, at, at_key=True)
        else:
            nearest = member_meant(word, tags) if isinstance(word, str) else None
            hint = meant(nearest) or f"; known are {', '.join(tags)}"
            sentence = f"unknown {tag} {shown(word)} in {dotted(at)}{hint}"
            self.fault(sentence, (*at, tag))
        self.closed.add(at)
        return None

    def _lift(self, model: Model, given: Mapping[str, Any], at: Keys) -> Mapping[str, Any]:
        """Give the block of a law with its own options as keys of the block itself."""
        tag = tag_of(model)
        if tag is None or tag[0] != BY_NAME or not isinstance(own := given.get(tag[1]), dict):
            return given
        self.lifted |= {(*at, key): (*at, tag[1], key) for key in own}
        less = {tag[1], *excluded(tag[1], own)}
        return {key: value for key, value in given.items() if key not in less} | own

    def _home(self, keys: Keys) -> Keys:
        """Give where a value stands in the document."""
        for i in range(len(keys), 0, -1):
            if keys[:i] in self.lifted:
                return (*self.lifted[keys[:i]], *keys[i:])
        return keys

    def _meant(self, key: str, model: Model, given: Mapping[str, Any], at: Keys) -> str | None:
        """Note an unknown key; give the key that was meant, unless that stands there too."""
        fields = keys_of(model)
        nearest = near(key, fields.keys() - given.keys()) or near(key, fields)
        home = [name for name in homes(self.model, key) if (name,) != at[:1]]
        where = f" in {dotted(at)}" if at else ""
        if tag := tag_of(model):
            where += f" of {tag[0]} {tag[1]}"
        if 0 < len(home) < 3:
            nearest, hint = None, f"; it belongs in {' or '.join(home)}"
        elif tag and tag[0] == BY_NAME and (hint := of_other_laws(key)):
            nearest = None
        else:
            hint = meant(nearest) or _instead(key, given[key], fields)
        self.fault(f"unknown key {shown(key)}{where}{hint}", (*at, key), at_key=True)
        return nearest if nearest not in given else None

    def _missing(self, model: Model, words: Mapping[str, Any], at: Keys) -> None:
        """Note the keys that a block needs."""
        for name, field in keys_of(model).items():
            if field.is_required() and name not in words:
                sentence = f"{dotted((*at, name))} is required{_about(model, field)}"
                self.fault(sentence, (*at, name), at_key=True)
        for group in (*model.one_of, *model.any_of):
            if not words.keys() & set(group):
                either = " or ".join(group)
                self.fault(f"{dotted(at)} needs {either}", (*at, group[0]), at_key=True)

    def _clashing(self, model: Model, words: Mapping[str, Any], at: Keys) -> None:
        """Note the keys of a block that do not go together."""
        for group in model.exclusive():
            first, *rest = [name for name in words if name in group] or [""]
            for name in rest:
                sentence = f"{dotted(at)} has {first} already; give {name} or {first}, not both"
                self.fault(sentence, (*at, name), at_key=True)
        missing = [group for group in model.one_of if not words.keys() & set(group)]
        for name, other in model.needs.items():
            said = any(other in group for group in missing)
            if name in words and other not in words and not said:
                sentence = f"{dotted((*at, name))} has a meaning only beside {other}"
                self.fault(sentence, (*at, name), at_key=True)


def _with_default(models: list[Model], given: Mapping[str, Any]) -> Mapping[str, Any]:
    """Give a block that names no member of a shelf with the name of the default one, if any."""
    default = next(filter(is_default, models), None)
    tag = tag_of(default) if default else None
    if tag is None or any(key == tag[0] or near(key, [tag[0]]) for key in given):
        return given
    return {tag[0]: tag[1], **given}


def dotted(keys: Keys) -> str:
    """Give the name of a value in sentences."""
    return ".".join(short(str(key)) for key in keys)


def _instead(key: str, value: object, fields: Mapping[str, FieldInfo]) -> str:
    """Say what to do about a key that resembles nothing."""
    if key[:1].isdigit() and value is None:
        return "; write decimals with a point, not with a comma"
    return f"; known are {', '.join(fields)}"


def _about(model: Model, field: FieldInfo) -> str:
    """Give the first clause of the text under a field."""
    name = next(name for name, known in model.model_fields.items() if known is field)
    clause = " ".join(re.split(r"[;.](?:\s|$)", texts_of(model).get(name, ""))[0].split())
    return f": {clause[0].lower()}{clause[1:]}" if clause else ""
