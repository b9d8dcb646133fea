"""The same scene under another approach, and what that approach leaves out."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from drysim.approach import SHELF
from drysim.core.normal_force.normal import Pressed
from drysim.core.plant import Law, Stopped
from drysim.friction.coulomb import Coulomb
from drysim.scenario.blocks import on_the_shelf
from drysim.scenario.laws import LAWS
from drysim.scenario.rules import STATIC

if TYPE_CHECKING:
    from drysim.friction import Friction
    from drysim.scenario.model import Scenario

_STATIC = tuple(f"friction.{key}" for key in STATIC)
_VARIATIONS = ("friction.normal_variation.", "friction.normal_record.")
_STOPS = "stroke.stops."
EQUAL = {"static": None, "mu_static": None, "static_ratio": 1.0}
"""A static limit as an approach takes it that knows none above kinetic friction."""


def solved_by(scenario: Scenario, name: str) -> Scenario:
    """Give the scene solved by an approach; what it cannot use is gone, swept keys included.

    Raises
    ------
    ValueError
        When there is no such approach.
    """
    member, friction = SHELF[on_the_shelf(name)], scenario.friction
    if friction is not None and not member.use_friction:
        friction = None
    if friction is not None and not isinstance(friction, Coulomb) and not member.use_dynamic:
        friction = as_coulomb(friction)
    if friction is not None:
        less: dict[str, Any] = {}
        if not member.use_static and friction.static_given:
            less |= EQUAL
        if isinstance(friction, Coulomb) and not member.use_variation:
            less |= steady_load(friction)
        friction = friction.model_copy(update=less)
    changed: dict[str, Any] = {
        "solver": scenario.solver.model_copy(update={"approach": name}),
        "friction": friction,
        "sweep": tuple(axis for axis in scenario.sweep if has_use(name, axis.key)),
        "reference": None,
    }
    if scenario.stroke is not None and not member.use_stops:
        changed["stroke"] = scenario.stroke.model_copy(update={"stops": None})
    return scenario.copied(changed)


def steady_load(friction: Coulomb) -> dict[str, Any]:
    """Give what makes the normal force constant, at its mean."""
    record = friction.normal_record
    mean = {} if record is None else {"normal": record.pressure().mean, "normal_record": None}
    return {"normal_variation": None, **mean}


def as_coulomb(friction: Friction) -> Coulomb:
    """Give the forces of any law as Coulomb's."""
    words = friction.model_dump(exclude_none=True, include=set(Coulomb.model_fields))
    return Coulomb(**words | {"law": "coulomb"})


def has_use(name: str, key: str) -> bool:
    """Whether an approach has a use for a key of the scenario."""
    member = SHELF[name]
    if key.startswith("friction.") and not member.use_friction:
        return False
    if key.startswith(_STOPS) and not member.use_stops:
        return False
    if _is_option(key) or (key in _STATIC and not member.use_static):
        return False
    if _is_of_law(key) and not member.use_dynamic:
        return False
    if key.startswith(_VARIATIONS) and not member.use_variation:
        return False
    block, option, *rest = key.split(".")
    return not (block == "solver" and rest) or option == name


def _is_of_law(key: str) -> bool:
    """Whether a key belongs to a friction law and not to Coulomb's."""
    block, option, *_ = key.split(".")
    return block == "friction" and option not in Coulomb.model_fields


def _is_option(key: str) -> bool:
    """Whether a key belongs to a law that a block only has options for."""
    block, option, *_ = key.split(".")
    return block == "friction" and option in LAWS


def left_out(scenario: Scenario, name: str) -> Iterator[str]:
    """Give a sentence for everything in the scene that an approach leaves out."""
    member, law = SHELF[on_the_shelf(name)], scenario.law()
    if scenario.stops is not None and not member.use_stops:
        yield f"{name} knows no end stops and lets the mass move on beyond the stroke limit"
    swept = {axis.key for axis in scenario.sweep}
    rubs = law.F_fk > 0 or any(key.startswith("friction.") for key in swept)
    if not member.use_friction:
        if rubs:
            yield f"{name} leaves the dry friction out"
        return
    if not member.use_static and (law.F_fs > law.F_fk or swept & set(_STATIC)):
        yield f"{name} knows no static limit above kinetic friction and takes F_fs = F_fk"
    if not isinstance(law, Law | Stopped | Pressed) and not member.use_dynamic:
        yield f"{name} knows Coulomb's friction only and takes the forces of the law as such"
    varies = isinstance(law, Pressed) or law.variation
    varies = varies or any(key.startswith(_VARIATIONS) for key in swept)
    if not member.use_variation and varies:
        yield f"{name} knows no varying normal force and takes it as constant"
