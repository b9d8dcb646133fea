"""Parquet of many cases: a file a block, for pandas, Polars, DuckDB and their like."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim.errors import UsageError
from drysim.report.rows import FORCES, METRICS, felt_of, means_of
from drysim.report.tables import UNITS
from drysim.study.sweeps.batch import COUNTED, STATUSES
from drysim.study.sweeps.rows import batches_of

if TYPE_CHECKING:
    from drysim.study.sweeps.batch import Batch
    from drysim.study.sweeps.table import Table

Names = tuple[str, ...]

FOLDER = "transmissibility"
"""The dataset: `approach=<name>/<number of the first case>.parquet` within it."""


def require() -> None:
    """Make sure, before any work, that there is what writes Parquet.

    Raises
    ------
    UsageError
        With the command that installs it.
    """
    try:
        import pyarrow  # noqa: F401 - only whether it is there
    except ImportError:
        raise UsageError(
            "--format parquet needs the package pyarrow, which is not installed",
            'install it by pip install "drysim[parquet]", or leave --format out',
        ) from None


def transmissibility(table: Table, folder: Path) -> None:
    """Write the cases of a sweep as a dataset; its columns are those of transmissibility.csv.

    Parameters
    ----------
    table : Table
    folder : Path
        Where to write.
    """
    import pyarrow.parquet

    felt, means = felt_of(table), means_of(table)
    for batch in batches_of(table.rows):
        place = folder / FOLDER / f"approach={batch.approach}"
        place.mkdir(parents=True, exist_ok=True)
        file = place / f"{batch.first:012d}.parquet"
        pyarrow.parquet.write_table(_arrow(table, batch, felt, means), file)


def _arrow(table: Table, batch: Batch, felt: Names, means: Names) -> Any:
    """Give a block of cases as Arrow has them, the unit of each column in its metadata."""
    import pyarrow

    fields, columns = [], []

    def put(name: str, unit: str, values: Any, kind: Any, missing: Any = None) -> None:
        fields.append(pyarrow.field(name, kind, metadata={"unit": unit or "-"}))
        columns.append(pyarrow.array(values, kind, mask=missing))

    for axis in table.axes:
        column = batch.points.get(axis.key)
        whole = column is not None and column.dtype.kind == "i"
        kind = pyarrow.int64() if whole else pyarrow.float64()
        lacking = np.ones(len(batch), dtype=bool) if column is None else None
        values = np.zeros(len(batch)) if column is None else column
        put(axis.key, axis.unit, values, kind, lacking)
    for name in FORCES:
        put(name, UNITS[name], getattr(batch, name), pyarrow.float64())
    for name in (*METRICS, *felt):
        values = batch.metrics[name]
        missing = np.isnan(values)
        if name in COUNTED:
            values = np.where(missing, 0, values).astype(np.int64)
        kind = pyarrow.int64() if name in COUNTED else pyarrow.float64()
        put(name, UNITS[name], values, kind, missing)
    words = [STATUSES[code] for code in batch.status.tolist()]
    put("status", "", words, pyarrow.string())
    known = [batch.over.get(i) for i in range(len(batch))] if means else []
    if means:
        put("seeds", "", [one.count if one else 1 for one in known], pyarrow.int64())
    for name in means:
        widths = [one.half_widths.get(name) if one else None for one in known]
        put(f"{name}_half_width", UNITS[name], widths, pyarrow.float64())
    return pyarrow.table(columns, schema=pyarrow.schema(fields))
