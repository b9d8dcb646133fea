"""Hashes by which two results are seen to stand on the same files and base motions."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from drysim import regular
from drysim.core.signal import Signal, blocks
from drysim.quantity import Block


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
        with regular.opened(path) as stream:
            found[".".join(keys)] = hashlib.file_digest(stream, "sha256").hexdigest()
    return found


def sha256_of(signal: Signal) -> str:
    """Give the SHA-256 (hex) of a signal as little-endian doubles."""
    digest = hashlib.sha256()
    for part in blocks(signal):
        digest.update(np.ascontiguousarray(part, dtype="<f8").data)
    return digest.hexdigest()


def sha256_together(hashes: Iterable[str]) -> str:
    """Give the SHA-256 (hex) of hashes, one a line, in order."""
    return hashlib.sha256("\n".join(hashes).encode()).hexdigest()
