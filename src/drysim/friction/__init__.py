"""Shelf 2: what the surfaces do. A friction law is one class and one name here.

What else belongs to one: its formula with its branch in the core, its scenario in the gallery
(`friction-<law>`, with the picture of its loop) and its row in the README. In words it is its
name and the keys of its own, beside its two forces.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import chain
from typing import get_args

from drysim.friction.laws import Coulomb, Dahl, Jenkins, Leuven, Lugre, PetrovEwins, Stribeck
from drysim.units import Quantity
from drysim.wording import number

FRICTIONS = (Coulomb, Stribeck, Jenkins, PetrovEwins, Dahl, Lugre, Leuven)

Friction = Coulomb | Stribeck | Jenkins | PetrovEwins | Dahl | Lugre | Leuven


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
            # Where a key may be left out its quantity is within its annotation.
            inner = (getattr(kind, "__metadata__", ()) for kind in get_args(field.annotation))
            every = chain(field.metadata, *inner)
            unit = next((part.unit for part in every if isinstance(part, Quantity)), "")
            yield f"{symbol} {number(value, unit)}"
