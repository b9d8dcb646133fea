"""Arrays that kernels write to: segments, events, samples, points."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from drysim.core.compile import as_engine_array
from drysim.core.events import MAX_EVENTS_PER_STEP, EventLog
from drysim.core.model import Points
from drysim.core.sampled import SampledMotion

INTEGER_COLUMNS = ("n", "d", "terms")
"""Columns of integers in a table of segments."""

LOG_LENGTH = 4 * MAX_EVENTS_PER_STEP
"""Rows of an event log that a kernel may fill before it returns."""


def empty_columns(kind: Any, size: int) -> Any:
    """Return a table of segments of some kind with uninitialised columns."""
    kinds = (np.int64 if name in INTEGER_COLUMNS else np.float64 for name in kind._fields)
    return kind(*[as_engine_array(np.empty(size, numbers)) for numbers in kinds])


def empty_points(n: int) -> Points:
    """Return uninitialised points of a motion at n times."""
    x_r, v_r, x_dd, F_f, F_stop, z = as_engine_array(np.empty((6, n)))
    return Points(x_r, v_r, as_engine_array(np.empty(n, np.int8)), x_dd, F_f, F_stop, z)


def as_arrays(points: Points) -> Points:
    """Return points that a kernel has written as arrays of numpy."""
    columns: Any = (None if column is None else np.asarray(column) for column in points)
    arrays = Points(*columns)
    return arrays._replace(d=arrays.d.astype(np.int8, copy=False))


def empty_samples(n: int) -> SampledMotion:
    """Return an uninitialised motion at n samples."""
    # One allocation, which the allocator reuses for the next block of this length.
    x_r, v_r = as_engine_array(np.empty((2, n)))
    return SampledMotion(x_r, v_r, as_engine_array(np.empty(n, dtype=np.int8)))


def empty_log(size: int) -> EventLog:
    """Return an uninitialised event log."""
    n, kind = (
        as_engine_array(np.empty(size, np.int64)),
        as_engine_array(np.empty(size, np.int8)),
    )
    s, x_r, F_L = as_engine_array(np.empty((3, size)))
    return EventLog(n, s, kind, x_r, F_L)


def write_first_row(columns: Any, values: Iterable[Any]) -> None:
    """Write the first row of a table."""
    for column, value in zip(columns, values, strict=True):
        column[0] = value


def enlarge_columns(columns: Any, size: int) -> Any:
    """Return a table with more rows and the same values."""
    return type(columns)(*(enlarge_column(column, size) for column in columns))


def enlarge_column(column: Any, size: int) -> Any:
    """Return a column with more rows and the same values."""
    if isinstance(column, list):
        return column + [0] * (size - len(column))
    wider = np.empty(size, column.dtype)
    wider[: len(column)] = column
    return wider
