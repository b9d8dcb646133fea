"""What every block of a scenario shares: it is frozen, strict and documented in itself."""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, ClassVar

from pydantic import BaseModel, ConfigDict, GetJsonSchemaHandler

if TYPE_CHECKING:
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema


class Block(BaseModel):
    """A block of a scenario: frozen, unknown keys refused, documented under its fields."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True
    )

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which exactly one is given."""
    any_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which one at least is given."""
    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which one may be given."""
    needs: ClassVar[dict[str, str]] = {}
    """Keys that make sense only beside another key."""

    @classmethod
    def exclusive(cls) -> tuple[tuple[str, ...], ...]:
        """Give the groups of keys of which no two go together."""
        return (*cls.one_of, *cls.at_most_one_of)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Give the schema with the texts under the fields and the rules between the keys."""
        schema = handler.resolve_ref_schema(handler(core_schema))
        for name, text in texts_of(cls).items():
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


def texts_of(model: type[BaseModel]) -> dict[str, str]:
    """Give the text under every field of a model, by the name of the field.

    It is read from the source when somebody asks: at import it would take a third of the
    time that loading a scenario takes.
    """
    texts: dict[str, str] = {}
    for cls in reversed(model.__mro__):
        if issubclass(cls, Block) and cls.__module__ in sys.modules:
            texts |= _texts_in(cls.__module__).get(cls.__name__, {})
    return {name: text for name, text in texts.items() if name in model.model_fields}


@cache
def _texts_in(module: str) -> dict[str, dict[str, str]]:
    """Give the texts under the annotated names of every class in a module."""
    try:
        tree = ast.parse(inspect.getsource(sys.modules[module]))
    except (OSError, TypeError):  # there is no source, as in a frozen program
        return {}
    classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    return {cls.name: dict(_texts_under(cls.body)) for cls in classes}


def _texts_under(body: list[ast.stmt]) -> Iterator[tuple[str, str]]:
    """Give name and text where a text stands under an annotated name."""
    for field, below in pairwise(body):
        match field, below:
            case (
                ast.AnnAssign(target=ast.Name(id=name)),
                ast.Expr(value=ast.Constant(value=str() as text)),
            ):
                yield name, inspect.cleandoc(text)


class Misfit(ValueError):
    """A sentence about two values that do not fit; `at` is the key of the one to blame."""

    def __init__(self, sentence: str, *at: str | int) -> None:
        super().__init__(sentence)
        self.at = at
