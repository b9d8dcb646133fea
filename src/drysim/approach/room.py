"""Room that kernels write trails and events into."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from drysim.core.compiled import held
from drysim.core.events import Log
from drysim.core.trail import Trail

WHOLE = ("n", "d", "terms")
"""Columns of whole numbers."""


def empty(kind: Any, size: int) -> Any:
    """Give room for a trail or for pieces."""
    kinds = (np.int64 if name in WHOLE else np.float64 for name in kind._fields)
    return kind(*[held(np.empty(size, numbers)) for numbers in kinds])


def empty_trail(size: int) -> Trail:
    """Give room for a trail."""
    trail: Trail = empty(Trail, size)
    return trail


def empty_log(size: int) -> Log:
    """Give room for events."""
    n, kind = held(np.empty(size, np.int64)), held(np.empty(size, np.int8))
    s, x_r, F_L = held(np.empty((3, size)))
    return Log(n, s, kind, x_r, F_L)


def put_first(room: Any, values: Iterable[Any]) -> None:
    """Put a value into the first place of every column."""
    for column, value in zip(room, values, strict=True):
        column[0] = value


def larger(room: Any, size: int) -> Any:
    """Give the same values with more room."""
    return type(room)(*(longer(column, size) for column in room))


def longer(column: Any, size: int) -> Any:
    """Give a column with more room behind its values."""
    if isinstance(column, list):
        return column + [0] * (size - len(column))
    wider = np.empty(size, column.dtype)
    wider[: len(column)] = column
    return wider
