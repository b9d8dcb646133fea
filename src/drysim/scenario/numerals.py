"""The numeric keys of a scenario: what may be swept, in which unit, and what excludes it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin

from pydantic import TypeAdapter, ValidationError

from drysim.quantity import Quantity, near, shown
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

    def here(self, key: str) -> float | None:
        """Give the value that the scenario itself has for a key; None where it has none."""
        name = key.rpartition(".")[2]
        field = keys_of(self.model).get(name) if self.model else None
        given = self.given.get(name, field.default if field else None)
        try:
            return None if given is None else self.read(given)
        except ValueError:
            return None

    def read(self, given: object) -> float:
        """Give the number that a value means; a ValueError is a sentence without subject."""
        if self.quantity is not None:
            return self.quantity.read(given)
        try:
            return int(TypeAdapter(self.annotation).validate_python(given))
        except ValidationError as fault:
            raise ValueError(worded(fault.errors(include_url=False)[0])) from None


def numerals(model: Model, words: Mapping[str, Any]) -> dict[str, Numeral | None]:
    """Give every key of a scenario, the numeric ones with what is known of them.

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
        value = given.get(name)
        found = _numeral(annotation, model, given, there)
        yield f"{at}{name}", found
        if found is None:
            yield from _within(annotation, value, f"{at}{name}", field.is_required())


def _within(
    annotation: Any, value: Any, at: str, required: bool
) -> Iterator[tuple[str, Numeral | None]]:
    """Give the keys in a value that is a block or a list."""
    kind, _ = _bare(annotation)
    if get_origin(kind) is tuple:
        for i, entry in enumerate(value if isinstance(value, list | tuple) else ()):
            inner = get_args(kind)[0 if Ellipsis in get_args(kind) else i :]
            found = _numeral(inner[0], None, {}, True) if inner else None
            yield f"{at}.{i}", found
            if inner and found is None:
                yield from _within(inner[0], entry, f"{at}.{i}", True)
        return
    models = models_in(kind)
    if not models or (value is None and required) or not isinstance(value, dict | None):
        return
    given = {} if value is None else value
    chosen = _chosen(models, given)
    if chosen is not None:
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


def meant(key: str, known: Mapping[str, Numeral | None]) -> str | None:
    """Give the numeric key that was probably meant by one that is not there."""
    steps, best = key.split("."), None
    for candidate in (name for name, numeral in known.items() if numeral):
        parts = candidate.split(".")
        if len(steps) == 1:
            alike = near(key, [parts[-1]]) is not None
        else:
            alike = len(parts) == len(steps) and all(
                a == b or near(a, [b]) for a, b in zip(steps, parts, strict=True)
            )
        same = sum(a == b for a, b in zip(reversed(steps), reversed(parts), strict=False))
        if alike and (best is None or same > best[0]):
            best = (same, candidate)
    return best[1] if best else None


def hindrance(key: str, numeral: Numeral, others: set[str]) -> str | None:
    """Say which key of its block keeps a key from being set; None when nothing does.

    Parameters
    ----------
    key : str
        Dotted key.
    numeral : Numeral
    others : set of str
        Keys of the same block that are swept, too.
    """
    model, name = numeral.model, key.rpartition(".")[2]
    if model is None:
        return None
    block = key.rpartition(".")[0]
    for group in (*getattr(model, "one_of", ()), *getattr(model, "at_most_one_of", ())):
        other = next(
            (o for o in group if name in group and o != name and o in numeral.given), ""
        )
        if other:
            return f"is not used: {block} says {other}; sweep {block}.{other}, or give {name}"
        other = next((o for o in group if name in group and o != name and o in others), "")
        if other:
            return f"and {block}.{other} exclude each other; sweep one of them"
    needed = getattr(model, "needs", {}).get(name)
    if needed and needed not in numeral.given:
        return f"has a meaning only beside {block}.{needed}, which is not given"
    lacking = [
        other
        for other, field in keys_of(model).items()
        if field.is_required() and other != name
    ]
    if lacking and not numeral.there:
        return f"has no block: give {block} with {' and '.join(lacking)} first"
    return None


def no_number(key: str, known: Mapping[str, Numeral | None]) -> str:
    """Say why a key cannot be swept."""
    if key in known:
        inner = next(
            (n for n, numeral in known.items() if numeral and n.startswith(f"{key}.")), ""
        )
        hint = f"; write its dotted key, such as `{inner}`" if inner else ""
        return f"{shown(key)} is not a number, so it cannot vary{hint}"
    nearest = meant(key, known)
    hint = f"; did you mean `{nearest}`?" if nearest else ""
    top = key.partition(".")[0]
    if not hint and not any(name.startswith(f"{top}.") for name in known) and top in known:
        hint = f": this scenario has no {top} block"
    return f"unknown key {shown(key)}{hint}"
