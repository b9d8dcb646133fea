"""What a friction law is besides its two forces, in words: its name and the keys of its own."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import chain
from typing import TYPE_CHECKING, get_args

from pydantic.fields import FieldInfo

from drysim.friction.coulomb import Coulomb
from drysim.quantity import Quantity
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.friction import Friction

UNTOLD = frozenset({*Coulomb.model_fields, "tolerance"})
"""Keys that are told as forces, and the tolerance, which is no part of a law."""


def terms(friction: Friction, swept: Collection[str] = ()) -> Iterator[str]:
    """Give the name of a law, then its own keys as `v_s 0.005 m/s`; nothing for Coulomb's.

    Defaults are left out, and keys that are swept.
    """
    if isinstance(friction, Coulomb):
        return
    yield f"law {friction.law}"
    for key, field in type(friction).model_fields.items():
        value = getattr(friction, key)
        if key in UNTOLD or f"friction.{key}" in swept or value == field.default:
            continue
        if isinstance(value, int | float):
            symbol = friction.symbols.get(key, key.replace("_", " "))
            yield f"{symbol} {number(value, _unit(field))}"


def _unit(field: FieldInfo) -> str:
    """Give the unit of a key, also where it may be left out."""
    inner = (getattr(kind, "__metadata__", ()) for kind in get_args(field.annotation))
    every = chain(field.metadata, *inner)
    return next((part.unit for part in every if isinstance(part, Quantity)), "")
