"""Batch: a block of cases of one approach, as columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from drysim.metrics import UNITS
from drysim.study.sweeps.table import FAILED, NOT_SETTLED, NOT_UNIQUE, OK, OverSeeds, Row

STATUSES = (OK, NOT_SETTLED, NOT_UNIQUE, FAILED)
"""What a case may come to, by its code."""

COUNTED = frozenset({"violations", "contacts"})
"""Metrics that are whole numbers, unless they are means over many seeds."""

NAMES = tuple(UNITS)

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Batch:
    """Cases of one approach that follow each other in the order of the sweep.

    Attributes
    ----------
    first : int
        Number of the first case among those of all approaches.
    approach : str
        Name on the shelf.
    points : mapping
        Column of every swept key, shape (n,); whole numbers where the key takes no others.
    F_fk, F_fs : ndarray, shape (n,)
        Friction forces [N].
    metrics : mapping
        Column of every metric of `METRICS`, shape (n,); NaN where it is not known.
    status : ndarray of int8, shape (n,)
        Index into `STATUSES`.
    notes : mapping
        What is to be said about cases without numbers, by their place in the batch.
    over : mapping
        What is known of cases that are many seeds, by their place in the batch.
    """

    first: int
    approach: str
    points: Mapping[str, NDArray[Any]]
    F_fk: Floats
    F_fs: Floats
    metrics: Mapping[str, Floats]
    status: NDArray[np.int8]
    notes: Mapping[int, str] = field(default_factory=dict)
    over: Mapping[int, OverSeeds] = field(default_factory=dict)

    def __len__(self) -> int:
        """Give the number of cases."""
        return len(self.status)

    def __iter__(self) -> Iterator[Row]:
        """Give the cases as rows."""
        keys = tuple(self.points)
        columns = (column.tolist() for column in self.points.values())
        points = list(zip(*columns, strict=True)) or [()] * len(self)
        values = zip(*(_known(name, self.metrics[name]) for name in NAMES), strict=True)
        forces = zip(self.F_fk.tolist(), self.F_fs.tolist(), strict=True)
        codes = self.status.tolist()
        every = zip(points, values, forces, codes, strict=True)
        for i, (point, row, force, code) in enumerate(every):
            yield Row(
                dict(zip(keys, point, strict=True)), self.approach, *force,
                dict(zip(NAMES, row, strict=True)), STATUSES[code], self.notes.get(i, ""),
                over=self.over.get(i),
            )  # fmt: skip

    def row(self, i: int) -> Row:
        """Give one case as a row."""
        return Row(
            {key: column[i].item() for key, column in self.points.items()},
            self.approach,
            float(self.F_fk[i]),
            float(self.F_fs[i]),
            {name: _value(name, self.metrics[name][i].item()) for name in NAMES},
            STATUSES[self.status[i]],
            self.notes.get(i, ""),
            over=self.over.get(i),
        )

    @classmethod
    def of(cls, first: int, rows: Sequence[Row]) -> Self:
        """Give rows of one approach as a batch."""
        keys = tuple(rows[0].point)
        return cls(
            first,
            rows[0].approach,
            {key: np.array([row.point[key] for row in rows]) for key in keys},
            np.array([row.F_fk for row in rows]),
            np.array([row.F_fs for row in rows]),
            {name: _column([row.metrics.get(name) for row in rows]) for name in NAMES},
            np.array([STATUSES.index(row.status) for row in rows], dtype=np.int8),
            {i: row.note for i, row in enumerate(rows) if row.note},
            {i: row.over for i, row in enumerate(rows) if row.over},
        )


def _column(values: Sequence[float | None]) -> Floats:
    """Give values as a column, NaN for not known."""
    return np.array([np.nan if value is None else value for value in values], dtype=float)


def _value(name: str, value: float) -> float | int | None:
    """Give the value of a metric, None for not known; a mean of counts stays what it is."""
    if value != value:
        return None
    return int(value) if name in COUNTED and value.is_integer() else value


def _known(name: str, column: Floats) -> list[float | int | None]:
    """Give a column as values, None for not known."""
    if name in COUNTED:
        return [_value(name, value) for value in column.tolist()]
    if np.isnan(column).any():
        return [None if value != value else value for value in column.tolist()]
    values: list[float | int | None] = column.tolist()
    return values
