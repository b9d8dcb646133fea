"""Room that kernels write trails and events into."""

from __future__ import annotations

from typing import Any

import numpy as np

from drysim.core.compiled import held
from drysim.core.events import Log
from drysim.core.trail import Trail

WHOLE = ("n", "d", "kind", "terms")
"""Columns of whole numbers."""


def empty(kind: Any, size: int) -> Any:
    """Give room for a trail, for pieces or for a log of events."""
    return kind(
        *[
            held(np.empty(size, np.int64 if name in WHOLE else np.float64))
            for name in kind._fields
        ]
    )


def empty_trail(size: int) -> Trail:
    """Give room for a trail."""
    trail: Trail = empty(Trail, size)
    return trail


def empty_log(size: int) -> Log:
    """Give room for events."""
    log: Log = empty(Log, size)
    return log


def larger(room: Any, size: int) -> Any:
    """Give the same values with more room."""
    wider = empty(type(room), size)
    for column, before in zip(wider, room, strict=True):
        column[: len(before)] = before
    return wider
