"""The numeric keys of a scenario: what may be swept, and in which unit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin

from pydantic import TypeAdapter, ValidationError

from drysim.quantity import Quantity
from drysim.scenario.sentences import worded
from drysim.scenario.shape import Model, keys_of, models_in, tag_of

_TABLE = str.maketrans({"²": "2", "³": "3", "·": "*"})


class Numeral(NamedTuple):
    """A key whose value is a number."""

    quantity: Quantity | None
    """What its value may be; None for a whole number."""
    annotation: Any
    """Type of its value."""
    model: Model | None
    """The block that it stands in; None in a list of numbers."""
    given: Mapping[str, Any]
    """What the scenario says in that block."""
    there: bool
    """Whether the scenario has that block."""

    @property
    def unit(self) -> str:
        """Unit of the value, as scenarios spell it."""
        return self.quantity.unit if self.quantity else ""

    @property
    def header(self) -> str:
        """Unit of the value, as tables spell it."""
        return self.unit.translate(_TABLE) or "-"

    def read(self, given: object) -> float:
        """Give the number that a value means; a ValueError is a sentence without subject."""
        if self.quantity is not None:
            return self.quantity.read(given)
        try:
            return int(TypeAdapter(self.annotation).validate_python(given))
        except ValidationError as fault:
            raise ValueError(worded(fault.errors(include_url=False)[0])) from None

    def here(self, key: str) -> float | None:
        """Give the value that the scenario itself has for a key; None where it has none."""
        name = key.rpartition(".")[2]
        field = keys_of(self.model).get(name) if self.model else None
        given = self.given.get(name, field.default if field else None)
        try:
            return None if given is None else self.read(given)
        except ValueError:  # a problem of its own
            return None


Known = Mapping[str, Numeral | None]
"""Every key of a scenario by its dotted name, the numeric ones with what is known of them."""


def numerals(model: Model, words: Mapping[str, Any]) -> Known:
    """Give every key of a scenario.

    Parameters
    ----------
    model : type
        Of the whole scenario.
    words : mapping
        What the scenario says; members of shelves are known by their tags.
    """
    return {**dict(_in_block(model, words, "", True)), "drysim": None}


def _in_block(
    model: Model, given: Mapping[str, Any], at: str, there: bool
) -> Iterator[tuple[str, Numeral | None]]:
    """Give the keys of a block and of the blocks within."""
    for name, field in keys_of(model).items():
        annotation: Any = field.annotation
        if field.metadata:
            annotation = Annotated[(annotation, *field.metadata)]
        found = _numeral(annotation, model, given, there)
        yield f"{at}{name}", found
        value = given.get(name)
        if not isinstance(value, dict | list) and value == field.default:
            value = None  # such as `remove: nothing`, which says no more than its absence
        if found is None and not (value is None and field.is_required()):
            yield from _within(annotation, value, f"{at}{name}")


def _within(annotation: Any, value: Any, at: str) -> Iterator[tuple[str, Numeral | None]]:
    """Give the keys in a value that is a block or a list."""
    kind, _ = _bare(annotation)
    if get_origin(kind) is tuple:
        for i, entry in enumerate(value if isinstance(value, list | tuple) else ()):
            types = get_args(kind)[0 if Ellipsis in get_args(kind) else i :]
            found = _numeral(types[0], None, {}, True) if types else None
            yield f"{at}.{i}", found
            if types and found is None:
                yield from _within(types[0], entry, f"{at}.{i}")
    elif isinstance(value, dict | None) and (models := models_in(kind)):
        given = value or {}
        if chosen := _chosen(models, given):
            yield from _in_block(chosen, given, f"{at}.", value is not None)


def _chosen(models: list[Model], given: Mapping[str, Any]) -> Model | None:
    """Give the member of a shelf that a block names, or the only model that there is."""
    for model in models:
        tag = tag_of(model)
        if tag is None or given.get(tag[0]) == tag[1]:
            return model
    return None


def _numeral(
    annotation: Any, model: Model | None, given: Mapping[str, Any], there: bool
) -> Numeral | None:
    """Give what is known of a number; None for a value that is none."""
    kind, metadata = _bare(annotation)
    quantity = next((piece for piece in metadata if isinstance(piece, Quantity)), None)
    if quantity is None and kind is not int:
        return None
    return Numeral(quantity, annotation, model, given, there)


def _bare(annotation: Any, metadata: tuple[Any, ...] = ()) -> tuple[Any, tuple[Any, ...]]:
    """Give a type without its metadata and the None that it may be; and its metadata."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _bare(parts[0], (*metadata, *parts[1:]))
    some = [part for part in parts if part is not type(None)]
    if origin in (Union, UnionType) and len(some) == 1:
        return _bare(some[0], metadata)
    return annotation, metadata
