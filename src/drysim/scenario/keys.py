"""Keys that a scenario may have, derived from its models.

A block is a model, a choice is a union of models distinguished by a tag (`kind`, `law`), and
each numeric key has a unit (`numeric_keys`). A sweep may vary numeric keys only.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import inf
from types import UnionType
from typing import Annotated, Any, NamedTuple, TypeVar, Union, get_args, get_origin

from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from drysim.block import Block
from drysim.quantity import Quantity
from drysim.scenario.validation import validation_message

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


def discriminator(model: Model) -> tuple[str, str] | None:
    """Return the tag key of a model in a union and its value; None if it has none."""
    for key in TAG_KEYS:
        field = model.model_fields.get(key)
        tags = get_args(field.annotation) if field and field.is_required() else ()
        if len(tags) == 1:
            return key, tags[0]
    return None


def members_by_tag(models: Iterable[type[Tagged]]) -> dict[str, type[Tagged]]:
    """Return the members of a union by the value of their tag key."""
    return {tag[1]: model for model in models if (tag := discriminator(model))}


def get_block(document: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Return a block of a document; empty if there is none."""
    block = document.get(name)
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

    @property
    def bounds(self) -> tuple[float, float]:
        """The least and the greatest accepted value; infinite where there is no bound."""
        return self.quantity.ends if self.quantity else (-inf, inf)

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


def numeric_keys(model: Model, document: Mapping[str, Any]) -> KnownKeys:
    """Return all dotted keys of a scenario with this model and these plain values.

    The tags among the values select the members of unions.
    """
    return {**dict(_block_keys(model, document, "", True)), "drysim": None}


def _block_keys(
    model: Model, block: Mapping[str, Any], prefix: str, present: bool
) -> Iterator[tuple[str, NumericKey | None]]:
    """Yield the dotted keys of a block and of nested blocks."""
    for name, entry in fields_by_key(model).items():
        annotation: Any = entry.annotation
        if entry.metadata:
            annotation = Annotated[(annotation, *entry.metadata)]
        value = block.get(name)
        numeric_key = None
        if not isinstance(value, dict):
            numeric_key = _as_numeric_key(annotation, model, block, present)
        yield f"{prefix}{name}", numeric_key
        if not isinstance(value, dict | list) and value == entry.default:
            value = None  # the default, such as `remove: nothing`
        if numeric_key is None and not (value is None and entry.is_required()):
            yield from _nested_keys(annotation, value, f"{prefix}{name}")


def _nested_keys(
    annotation: Any, value: Any, key: str
) -> Iterator[tuple[str, NumericKey | None]]:
    """Yield the dotted keys in a block or list."""
    kind, _ = _strip_annotation(annotation)
    if get_origin(kind) is tuple:
        for i, entry in enumerate(value if isinstance(value, list | tuple) else ()):
            types = get_args(kind)[0 if Ellipsis in get_args(kind) else i :]
            numeric_key = _as_numeric_key(types[0], None, {}, True) if types else None
            yield f"{key}.{i}", numeric_key
            if types and numeric_key is None:
                yield from _nested_keys(types[0], entry, f"{key}.{i}")
    elif isinstance(value, dict | None) and (models := block_models(annotation)):
        block = value or {}
        if chosen := _named_model(models, block):
            yield from _block_keys(chosen, block, f"{key}.", value is not None)


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
