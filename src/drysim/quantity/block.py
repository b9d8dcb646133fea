"""What every block of a scenario shares: it is frozen, strict and documented in itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import BaseModel, ConfigDict, GetJsonSchemaHandler

if TYPE_CHECKING:
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema


class Block(BaseModel):
    """A block of a scenario: frozen, unknown keys refused, documented under its fields."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", use_attribute_docstrings=True, allow_inf_nan=False
    )

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which exactly one is given."""
    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which one may be given."""
    needs: ClassVar[dict[str, str]] = {}
    """Keys that make sense only beside another key."""

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Give the schema with the rules between the keys."""
        schema = handler.resolve_ref_schema(handler(core_schema))
        rules: list[JsonSchemaValue] = [
            {"oneOf": [{"required": [key]} for key in group]} for group in cls.one_of
        ]
        for group in cls.at_most_one_of:
            pairs = [[a, b] for i, a in enumerate(group) for b in group[i + 1 :]]
            rules.append({"not": {"anyOf": [{"required": pair} for pair in pairs]}})
        if rules:
            schema["allOf"] = rules
        if cls.needs:
            schema["dependentRequired"] = {key: [other] for key, other in cls.needs.items()}
        return schema


class Misfit(ValueError):
    """A sentence about two values that do not fit; `at` is the key of the one to blame."""

    def __init__(self, sentence: str, *at: str | int) -> None:
        super().__init__(sentence)
        self.at = at
