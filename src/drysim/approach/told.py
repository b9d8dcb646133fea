"""The path over a spring contact, as its kernels tell it where it is asked for."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from drysim.approach.events import Codes, Floats
from drysim.approach.track import Path
from drysim.core.compiled import held

ROOM = 1024
"""Points that there is room for besides the beginnings of pieces, before there is more."""


def whole_pieces(begins: Floats, window: tuple[float, float]) -> Codes:
    """Tell of which pieces all is wanted: the last one, and those that a window cuts."""
    whole = np.zeros(len(begins), dtype=np.int8)
    whole[np.searchsorted(begins, window, "right") - 1] = 1
    whole[-1] = 1
    return whole


def all_told(
    kernel: Callable[..., Any],
    scene: tuple[Any, ...],
    whole: Codes,
    x_rM: float | None,
    at: tuple[Any, ...],
) -> Path:
    """Give the path that a kernel tells of a scene, from its beginning `at` on."""
    limit = math.inf if x_rM is None else x_rM
    parts, pieces, given = [], len(whole), held(whole)
    while at[0] < pieces:
        t, x_r = held(np.empty((2, ROOM + pieces)))
        at, count = kernel(*scene, given, limit, at, t, x_r)
        parts.append((np.asarray(t[:count]), np.asarray(x_r[:count])))
    columns = parts[0] if len(parts) == 1 else map(np.concatenate, zip(*parts, strict=True))
    return Path(*columns)
