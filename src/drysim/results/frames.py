"""Tables of a result as data frames of pandas, with the columns of their CSV files."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from drysim.errors import UsageError
from drysim.messages import name_hint
from drysim.results import kind_of
from drysim.results.tables import require_package

if TYPE_CHECKING:
    from drysim.results.kind import File
    from drysim.results.tables import Column
    from drysim.study.outcome import AnyResult
    from drysim.study.statistics import Batch

HEADER = re.compile(r"(?P<name>[^\[]+?)(?: \[(?P<unit>[^\]]*)\])?")
"""Header of a column: its name and, of numbers, its unit."""


def to_frame(result: AnyResult, table: str | None = None) -> Any:
    """Return a table of a result as a DataFrame of pandas; see `Result.to_frame`."""
    require_package("pandas", "pandas", "to_frame")
    kind = kind_of(result)
    files = {Path(file.name).stem: file for file in kind.files if file.name.endswith(".csv")}
    name = next(iter(files)) if table is None else str(table)
    if name not in files:
        raise UsageError(f"there is no table `{name}` of {kind.what}{name_hint(name, files)}")
    if (cases := files[name].cases) is not None:
        return frame_of_cases(*cases(result))
    with TemporaryDirectory(prefix="drysim-") as folder:
        path = Path(folder, files[name].name)
        files[name].write(result, path)
        if not path.exists():
            raise UsageError(f"there is nothing for the table `{name}` in this result")
        return read_table(path, files[name])


def frame_of_cases(columns: Sequence[Column], batches: Iterable[Batch]) -> Any:
    """Return the columns of many cases as a DataFrame, as `read_table` does from their file."""
    import pandas as pd

    parts = [[column.values(batch) for column in columns] for batch in batches]
    frame = pd.DataFrame(
        {
            column.name: texts_of(values)
            if isinstance(values[0], list)
            else numbers_of(np.concatenate(values), column.whole)
            for column, values in zip(columns, zip(*parts, strict=True), strict=True)
        }
    )
    frame.attrs["units"] = {column.name: column.unit for column in columns if column.unit}
    return frame


def texts_of(parts: Iterable[Iterable[bytes]]) -> list[str]:
    """Return the texts of cells of a CSV file."""
    cells = (cell.decode() for part in parts for cell in part)
    return ["".join(row) for row in csv.reader(cells)]


def numbers_of(values: NDArray[Any], is_whole: bool) -> NDArray[Any]:
    """Return numbers as their cells read back: counts as integers, infinity as missing."""
    if values.dtype.kind == "i" or (is_whole and (values % 1 == 0).all()):
        return values.astype(np.int64)
    return np.where(np.isfinite(values), values, np.nan) + 0.0


def read_table(path: Path, file: File) -> Any:
    """Return a CSV file of a result as a DataFrame, the units of its numbers in `attrs`."""
    import pandas as pd

    with path.open(encoding="utf-8", newline="") as lines:
        headers, *rows = csv.reader(lines)
    columns = [match.groups() for match in map(HEADER.fullmatch, headers) if match]
    cells = zip(*rows, strict=True) if rows else [()] * len(columns)
    frame = pd.DataFrame(
        {
            name: to_numbers(column) if unit or name in file.numbers else column
            for (name, unit), column in zip(columns, cells, strict=True)
        }
    )
    frame.attrs["units"] = {name: unit for name, unit in columns if unit}
    return frame


def to_numbers(cells: Sequence[str]) -> NDArray[Any] | list[int]:
    """Return the numbers of cells, NaN where one is empty; integers if all are whole."""
    # The readers of pandas round the last digit, unless by an option that is deprecated.
    if cells and all(cell.lstrip("-").isdigit() for cell in cells):
        return [int(cell) for cell in cells]
    return np.array([cell or "nan" for cell in cells], dtype=str).astype(float)
