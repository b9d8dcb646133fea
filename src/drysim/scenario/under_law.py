"""The same scene under another friction law, and what that law leaves out."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from drysim.approach import EXACT
from drysim.errors import Problem, ScenarioError
from drysim.scenario import laws, others
from drysim.scenario.misfits import faults
from drysim.scenario.rules import STATIC
from drysim.scenario.sweep.points import in_conflict
from drysim.wording import several

if TYPE_CHECKING:
    from drysim.friction import Friction
    from drysim.scenario.model import Scenario

COULOMB = "coulomb"
"""The law beside which a mass may have end stops."""

LOAD = "normal_"
"""Beginning of the keys about a normal force that varies: of the scene, whatever the law."""


def acted_by(scenario: Scenario, name: str) -> Scenario:
    """Give the scene under a friction law; swept keys that the law has no use for are gone.

    Raises
    ------
    ScenarioError
        When a key of the law is missing, or its keys do not go together.
    """
    found = [*_faults(scenario, name)]
    if not found:
        solver = scenario.solver.model_copy(update={"approach": EXACT})
        axes = tuple(axis for axis in scenario.sweep if has_use(scenario, name, axis.key))
        changed: dict[str, Any] = {"solver": solver, "sweep": axes, "reference": None}
        if scenario.stroke is not None and name != COULOMB:
            changed["stroke"] = scenario.stroke.model_copy(update={"stops": None})
        scene = scenario.copied(changed, law=name)
        found = in_conflict(scene)
        if not found:
            return scene
    file, count = scenario.origin["file"] or scenario.name, several(len(found), "problem")
    sentence = f"{file} is not a scenario for law {name} yet: {count}"
    raise ScenarioError(sentence, tuple(found))


def _faults(scenario: Scenario, name: str) -> Iterator[Problem]:
    """Give the located problem of everything that keeps a law from acting in a scene."""
    if scenario.friction is None:
        sentence = f"law {name} needs a friction block, which this scenario has not"
        yield scenario.problem(sentence, "friction")
        return
    for key, sentence in faults(scenario.friction, name):
        yield scenario.problem(sentence, key)


def has_use(scenario: Scenario, name: str, key: str) -> bool:
    """Whether a law has a use for a key of the scenario."""
    block, option, *_ = key.split(".")
    friction = scenario.friction
    if key.startswith("stroke.stops.") and name != COULOMB:
        return False
    if block != "friction" or friction is None or friction.law == name:
        return others.has_use(EXACT, key)
    return option == name or laws.has_use(friction, name, option)


def left_out(scenario: Scenario, name: str) -> Iterator[str]:
    """Give a sentence for everything in the scene that a law leaves out.

    The keys that make another law what it is are not meant: nobody expects them to count.
    """
    friction = scenario.friction
    if scenario.stops is not None and name != COULOMB:
        yield f"{name} knows no end stops and lets the mass move on beyond the stroke limit"
    if friction is None or friction.law == name:
        return
    known = laws.LAWS[name].model_fields
    for key in sorted(_said(scenario, friction)):
        if key.startswith(LOAD) and key not in known:
            way = "takes its mean" if key == "normal_record" else "leaves it out"
            yield f"{name} has no use for friction.{key} and {way}"
    law, acting = scenario.law(), scenario.with_law(name).law()
    if not known.keys() & {*STATIC} and law.F_fs > law.F_fk and acting.F_fs == acting.F_fk:
        yield f"{name} knows no static limit above kinetic friction and takes F_fs = F_fk"


def _said(scenario: Scenario, friction: Friction) -> set[str]:
    """Give the keys of the friction block that count, given or swept."""
    swept = {
        axis.key.split(".")[1] for axis in scenario.sweep if axis.key.startswith("friction.")
    }
    return swept | {key for key, value in friction if value is not None}
