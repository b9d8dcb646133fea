"""The files that a scenario names, and by which hashes they are known again."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from drysim import regular
from drysim.quantity import Block

AT_A_TIME = 1 << 20
"""Bytes that are read at a time."""


def named_files(block: Block, keys: tuple[str, ...] = ()) -> Iterator[tuple[Any, Path]]:
    """Give the files that a scenario names, with the way to the block that names each."""
    path = getattr(block, "path", None)
    if isinstance(path, Path):
        yield keys, path
    for name in type(block).model_fields:
        if isinstance(inner := getattr(block, name), Block):
            yield from named_files(inner, (*keys, name))


def hashes_of(scenario: Block) -> dict[str, str]:
    """Give the SHA-256 (hex) of the bytes of every file that a scenario names, by its key."""
    found = {}
    for keys, path in named_files(scenario):
        digest = hashlib.sha256()
        with regular.opened(path) as stream:
            while part := stream.read(AT_A_TIME):
                digest.update(part)
        found[".".join(keys)] = digest.hexdigest()
    return found
