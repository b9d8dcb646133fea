"""The base class of the blocks of a scenario.

`Block` is a frozen, strict pydantic model, whose fields are described by the strings below
them. `PlainOrBlock` is the type of a field that is a plain value or a block in its place.
"""

import ast
import inspect
import sys
from collections.abc import Mapping
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar, TypeVar

from pydantic import BaseModel, ConfigDict, Discriminator, GetJsonSchemaHandler, Tag
from pydantic_core import CoreSchema

if TYPE_CHECKING:
    from pydantic.json_schema import JsonSchemaValue


class Block(BaseModel):
    """Base class of the blocks of a scenario.

    Blocks are frozen, reject unknown keys, and take the description of each field from the
    string below it. Modules of blocks have no `from __future__ import annotations`: pydantic
    evaluates annotations that are text for each class again, a tenth of the time of `validate`.
    """

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True
    )

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which exactly one must be set."""
    any_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which at least one must be set."""
    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which at most one may be set."""
    needs: ClassVar[dict[str, str]] = {}
    """Keys that require another key."""

    @classmethod
    def exclusive_groups(cls) -> tuple[tuple[str, ...], ...]:
        """Return the groups of mutually exclusive keys."""
        return (*cls.one_of, *cls.at_most_one_of)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> "JsonSchemaValue":
        """Return the JSON schema with field descriptions and the constraints between keys."""
        schema = handler.resolve_ref_schema(handler(core_schema))
        for name, text in field_descriptions(cls).items():
            schema["properties"][cls.model_fields[name].alias or name]["description"] = text
        rules: list[JsonSchemaValue] = [
            {"oneOf": [{"required": [key]} for key in group]} for group in cls.one_of
        ]
        rules += [{"anyOf": [{"required": [key]} for key in group]} for group in cls.any_of]
        for group in cls.at_most_one_of:
            pairs = [[a, b] for i, a in enumerate(group) for b in group[i + 1 :]]
            rules.append({"not": {"anyOf": [{"required": pair} for pair in pairs]}})
        if rules:
            schema["allOf"] = rules
        if cls.needs:
            schema["dependentRequired"] = {key: [other] for key, other in cls.needs.items()}
        return schema


def field_descriptions(model: type[BaseModel]) -> dict[str, str]:
    """Return the description of every field of a model, by field name.

    Notes
    -----
    Descriptions are parsed from the source on demand. Doing so at import would take a third of
    the time needed to load a scenario.
    """
    texts: dict[str, str] = {}
    for cls in reversed(model.__mro__):
        if issubclass(cls, Block) and cls.__module__ in sys.modules:
            texts |= _descriptions_in(cls.__module__).get(cls.__name__, {})
    return {name: text for name, text in texts.items() if name in model.model_fields}


@cache
def _descriptions_in(module: str) -> dict[str, dict[str, str]]:
    """Return the strings below the annotated names of every class in a module."""
    try:
        tree = ast.parse(inspect.getsource(sys.modules[module]))
    except (OSError, TypeError):  # no source, e.g. in a frozen program
        return {}
    texts: dict[str, dict[str, str]] = {}
    for cls in (node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)):
        under = texts[cls.name] = {}
        for field, below in pairwise(cls.body):
            match field, below:
                case (
                    ast.AnnAssign(target=ast.Name(id=name)),
                    ast.Expr(value=ast.Constant(value=str() as text)),
                ):
                    under[name] = inspect.cleandoc(text)
    return texts


class InvalidValue(ValueError):
    """An error that concerns two values which contradict each other.

    `at` is the path of the key to blame, relative to the block.
    """

    def __init__(self, sentence: str, *path: str | int) -> None:
        super().__init__(sentence)
        self.path = path


def _plain_or_block(value: object) -> str:
    """Return the tag of the type that validates a value: a plain value, or a block."""
    return "block" if isinstance(value, Mapping | Block) else "plain"


Plain = TypeVar("Plain")
Nested = TypeVar("Nested")

PlainOrBlock = Annotated[
    Annotated[Plain, Tag("plain")] | Annotated[Nested, Tag("block")],
    Discriminator(_plain_or_block),
]
"""A plain value, or a block in its place; messages concern the one that is written."""
