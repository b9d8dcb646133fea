"""Room that kernels write trails and events into."""

from __future__ import annotations

from typing import Any

import numpy as np

from drysim.core.compiled import held
from drysim.core.events import Log
from drysim.core.trail import Trail


def empty_trail(size: int) -> Trail:
    """Give room for a trail."""
    whole = ("n", "d", "terms")
    kinds = (np.int64 if name in whole else np.float64 for name in Trail._fields)
    return Trail(*(held(np.empty(size, dtype=kind)) for kind in kinds))


def empty_log(size: int) -> Log:
    """Give room for events."""
    kinds = (np.int64, np.float64, np.int64, np.float64, np.float64)
    return Log(*(held(np.empty(size, dtype=kind)) for kind in kinds))


def larger(room: Any, size: int) -> Any:
    """Give the same values with more room."""
    wider = empty_trail(size) if isinstance(room, Trail) else empty_log(size)
    for column, before in zip(wider, room, strict=True):
        column[: len(before)] = before
    return wider
