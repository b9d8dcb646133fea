"""What a model's fields look like from outside: keys, blocks within, tags."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from drysim.quantity import Block, near

Model = type[Block]


def keys_of(model: Model) -> dict[str, FieldInfo]:
    """Give the fields of a model by the key that a file uses."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def models_in(annotation: Any) -> list[Model]:
    """Give the blocks that a field may hold, alone, in a list or as one of several."""
    if isinstance(annotation, type) and issubclass(annotation, Block):
        return [annotation]
    return [model for part in get_args(annotation) for model in models_in(part)]


def may_list(annotation: Any) -> bool:
    """Tell whether a field may hold a list."""
    return get_origin(annotation) in (list, tuple) or any(map(may_list, get_args(annotation)))


def tag_of(model: Model) -> tuple[str, str] | None:
    """Give the key by which a shelf tells its members apart, and this member's word."""
    for key, field in keys_of(model).items():
        if field.is_required() and get_origin(field.annotation) is Literal:
            words = get_args(field.annotation)
            if len(words) == 1:
                return key, words[0]
    return None


def is_default(model: Model) -> bool:
    """Tell whether a block that names no member of the shelf is this one."""
    return bool(getattr(model, "by_default", False))


def member_meant(word: str, tags: Mapping[str, Model]) -> str | None:
    """Give the member of a shelf that a word means: by another name of it, or by a slip."""
    for tag, model in tags.items():
        if word.lower() in getattr(model, "also_called", ()):
            return tag
    return near(word, tags)


def homes(model: Model, key: str) -> Iterator[str]:
    """Give the names of the blocks that know a key."""
    for name, field in keys_of(model).items():
        if any(key in keys_of(block) for block in models_in(field.annotation)):
            yield name


def block_in(words: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Give a block of the words of a file, empty where there is none."""
    block = words.get(name)
    return block if isinstance(block, Mapping) else {}
