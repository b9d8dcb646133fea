"""Options of friction laws beside the one of the file: blocks of their own in its block."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, Literal, cast

from pydantic import Field, create_model
from pydantic.fields import FieldInfo

from drysim.scenario import model
from drysim.scenario.model import shelf
from drysim.scenario.reading import BY_NAME, DEFAULT_LAW, LAWS
from drysim.units import Block

ABOUT = "Options of {name}, any of its keys: they count where a comparison names it."


def model_for(words: Mapping[str, Any]) -> type[model.Scenario]:
    """Give the model that the words of a file are read as.

    A key that the law of the file has not got is an option of another law, or nearly so.
    """
    friction = words.get("friction")
    law = friction.get(BY_NAME, DEFAULT_LAW) if isinstance(friction, Mapping) else None
    if not isinstance(friction, Mapping) or not isinstance(law, str) or law not in LAWS:
        return model.Scenario
    plain = friction.keys() <= LAWS[law].model_fields.keys()
    return model.Scenario if plain else with_options()


def __getattr__(name: str) -> type[Block]:
    """Return a model that is made here by its name, as pickling looks it up."""
    if name.startswith("_") or name not in _models():
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _models()[name]


def with_options() -> type[model.Scenario]:
    """Give the scenario whose friction block may hold options of every other law."""
    made: Any = _models()["Scenario"]
    return cast(type[model.Scenario], made)


@cache
def _models() -> dict[str, type[Block]]:
    """Return all models that are made here by their names."""
    base = model.Scenario
    options = {name: _options(name, member) for name, member in LAWS.items()}
    members = tuple(_member(name, member, options) for name, member in LAWS.items())
    friction: Any = shelf(members, BY_NAME) | None
    default = base.model_fields["friction"].default
    scenario = create_model(
        base.__name__, __base__=base, __doc__=base.__doc__, friction=(friction, default)
    )
    made: tuple[Any, ...] = (scenario, *members, *options.values())
    return {one.__name__: one for one in made}


def _member(name: str, member: type[Block], options: Mapping[str, type[Block]]) -> type[Block]:
    """Give a law with a block for the options of each other law."""
    fields: dict[str, Any] = {
        other: (block | None, Field(None, description=ABOUT.format(name=other)))
        for other, block in options.items()
        if other != name
    }
    return create_model(member.__name__, __base__=member, __doc__=member.__doc__, **fields)


def _options(name: str, member: type[Block]) -> type[Block]:
    """Give the keys of a law as a block in which each may be left out."""
    fields: dict[str, Any] = {
        key: (_bare(field) | None, None)
        for key, field in member.model_fields.items()
        if field.default is not None
    }
    fields[BY_NAME] = (Literal[name], name)
    about = f"Options of {name}, which count where a comparison names it."
    made = create_model(f"{member.__name__}Options", __base__=member, __doc__=about, **fields)
    made.at_most_one_of = (*member.at_most_one_of, *member.one_of)
    made.one_of, made.needs = (), {}
    return made


def _bare(field: FieldInfo) -> Any:
    """Give the type of a key with what is known of its numbers."""
    kind: Any = field.annotation
    return Annotated[(kind, *field.metadata)] if field.metadata else kind
