"""Options of friction laws beside the one of the file: blocks of their own in its block.

They count where a comparison names their law. The models for that (a scenario, and every law
with a block for each other law) are made when a file first has such options, and for the schema
of all files.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, Literal, Union, cast

from pydantic import Field, create_model

from drysim.scenario import model
from drysim.scenario.reading import BY_NAME, LAWS
from drysim.units import Block


def with_options() -> type[model.Scenario]:
    """Give the scenario whose friction block may hold options of every other law."""
    return cast(type[model.Scenario], _models()["Scenario"])


def __getattr__(name: str) -> type[Block]:
    """Return a model that is made here by its name, as pickling looks it up."""
    if name.startswith("_") or name not in _models():
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _models()[name]


@cache
def _models() -> dict[str, type[Block]]:
    """Return all models that are made here by their names."""
    base = model.Scenario
    options = {name: _options(name, member) for name, member in LAWS.items()}
    members = tuple(_member(name, member, options) for name, member in LAWS.items())
    friction: Any = Union.__getitem__(members)
    scenario = create_model(
        base.__name__,
        __base__=base,
        __doc__=base.__doc__,
        friction=(friction | None, Field(None, discriminator=BY_NAME)),
    )
    made: tuple[Any, ...] = (scenario, *members, *options.values())
    return {one.__name__: one for one in made}


def _member(name: str, member: type[Block], options: Mapping[str, type[Block]]) -> type[Block]:
    """Give a law with a block for the options of each other law."""
    about = "Options of {}, any of its keys: they count where a comparison names it."
    fields: dict[str, Any] = {
        other: (block | None, Field(None, description=about.format(other)))
        for other, block in options.items()
        if other != name
    }
    return create_model(member.__name__, __base__=member, __doc__=member.__doc__, **fields)


def _options(name: str, member: type[Block]) -> type[Block]:
    """Give the keys of a law as a block in which each may be left out."""
    fields: dict[str, Any] = {}
    for key, field in member.model_fields.items():
        if field.default is not None:
            kind: Any = field.annotation
            bounded = Annotated[(kind, *field.metadata)] if field.metadata else kind
            fields[key] = (bounded | None, None)
    fields[BY_NAME] = (Literal[name], name)
    about = f"Options of {name}, which count where a comparison names it."
    made = create_model(f"{member.__name__}Options", __base__=member, __doc__=about, **fields)
    made.at_most_one_of = (*member.at_most_one_of, *member.one_of)
    made.one_of, made.needs = (), {}
    return made
