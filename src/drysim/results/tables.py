"""Tables: CSV files of a run and of many cases, Parquet of many cases; their columns and units.

Numbers are written as the shortest decimal that reads back as the same float. Rows are written
in blocks. Parquet has one file per block of cases.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from importlib import import_module
from itertools import compress, groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import orjson
from numpy.typing import NDArray

from drysim.errors import UsageError
from drysim.metrics.table import LIMITS, METRICS, ORBIT, STOPS, WEIGHTING
from drysim.metrics.table import UNITS as METRIC_UNITS
from drysim.scenario.axes import TEXT_KEYS
from drysim.scenario.blocks import SEED_KEY
from drysim.scenario.model import provides, shows_peak_acceleration
from drysim.study.statistics import (
    COUNT_METRICS,
    MAX_CACHED_ROWS,
    STATUSES,
    Batch,
    Row,
    as_batches,
    group_batches,
)
from drysim.units import NUMBER_PATTERN
from drysim.wording import sanitise

if TYPE_CHECKING:
    from drysim.scenario.axes import Axis
    from drysim.scenario.model import Scenario
    from drysim.study.table import Table


DIMENSIONLESS_COLUMNS = (
    "stuck", "seeds", "checks", "passed", "samples", "repeats", "error_x_r", "error_T_a",
    "T_a_deviation", "T_a_deviation_half_width", "x_r_peak_deviation", "x_r_rms_deviation",
    "time_over_lfilter",
)  # fmt: skip
"""Dimensionless columns that are not metrics."""

COLUMN_UNITS = {
    **METRIC_UNITS,
    **dict.fromkeys(DIMENSIONLESS_COLUMNS, "-"),
    "t": "s", "t_first": "s", "time": "s", "step": "s", "time_per_sample": "ns",
    "u_dd": "m/s2", "x_dd": "m/s2", "x_r": "m", "v_r": "m/s",
    "F_f": "N", "F_stop": "N", "F_L": "N", "F_fk": "N", "F_fs": "N",
    "event": "", "law": "",
}  # fmt: skip
"""Unit of every column of fixed name; empty for text."""

VIOLATION_COLUMNS = ("t_first", "x_r_peak", "t_beyond", "violations")
VIOLATION_METRICS = ("t_first_violation", *VIOLATION_COLUMNS[1:])
"""The columns of stroke_violations.csv, and the metrics in them."""

FLAGS = ("0", "1")
"""Cells of a truth value."""


def column_header(name: str, unit: str | None = None) -> str:
    """Return the header of a column, e.g. `x_r [m]`; its unit is known for fixed names."""
    unit = COLUMN_UNITS[name] if unit is None else unit
    return f"{name} [{unit}]" if unit else name


# Many cases: a row for each case of each approach, written batch by batch.


class Column(NamedTuple):
    """A column of a table of cases."""

    name: str
    unit: str
    """Empty for text."""
    values: Callable[[Batch], Values]
    """Returns the column for a batch: numbers (NaN where missing), or text as bytes."""
    whole: bool = False
    """Whether the numbers are counts."""

    @property
    def header(self) -> str:
        """Header in a CSV file."""
        return column_header(self.name, self.unit)


def case_columns(table: Table) -> list[Column]:
    """Return the columns of the cases of a sweep or a comparison."""
    return columns_of(table.scenario, table.axes, has_means(table))


def columns_of(scenario: Scenario, axes: Sequence[Axis], has_means: bool) -> list[Column]:
    """Return the columns of the cases of a scenario, which may be means over seeds."""
    optional = optional_metrics(scenario)
    means = interval_metrics(scenario) if has_means else ()
    return [
        Column("approach", "", lambda batch: [batch.approach.encode()] * len(batch)),
        *(key_column(axis.key, axis.unit) for axis in axes),
        Column("F_fk", "N", lambda batch: batch.F_fk),
        Column("F_fs", "N", lambda batch: batch.F_fs),
        *(metric_column(metric.name) for metric in METRICS if metric.in_tables),
        STATUS_COLUMN,
        *map(metric_column, optional),
        *([SEEDS_COLUMN] if means else []),
        *map(interval_column, means),
    ]


def key_column(key: str, unit: str) -> Column:
    """Return the column of a swept key; missing for cases whose approach lacks the key."""
    if key in TEXT_KEYS:

        def texts_of(batch: Batch) -> Values:
            texts = batch.points[key] if key in batch.points else [""] * len(batch)
            return [_csv_text(text) for text in texts]

        return Column(key, "", texts_of)
    return Column(
        key, unit or "-", lambda batch: batch.points.get(key, np.full(len(batch), np.nan))
    )


def _csv_text(text: str) -> bytes:
    """Return the cell of a text in a CSV file, quoted where necessary."""
    text = _as_text(sanitise(text))
    return ('"' + text.replace('"', '""') + '"' if set(text) & set(',"') else text).encode()


def metric_column(metric: str, name: str = "") -> Column:
    """Return the column of a metric, under its own name or another one."""
    whole = metric in COUNT_METRICS
    return Column(
        name or metric, METRIC_UNITS[metric], lambda batch: batch.metrics[metric], whole
    )


def interval_column(metric: str) -> Column:
    """Return the column of the half-width of a metric that is a mean over seeds."""

    def values(batch: Batch) -> Values:
        summaries = (batch.over.get(i) for i in range(len(batch)))
        return np.array(
            [summary and summary.half_widths.get(metric) for summary in summaries], dtype=float
        )

    return Column(f"{metric}_half_width", METRIC_UNITS[metric], values)


SEED_COLUMN = key_column(SEED_KEY, "-")
STATUS_COLUMN = Column("status", "", lambda batch: format_words(STATUSES, batch.status))
SEEDS_COLUMN = Column(
    "seeds",
    "-",
    lambda batch: np.array(
        [batch.over[i].count if i in batch.over else 1 for i in range(len(batch))]
    ),
)


def requested_metrics(scenario: Scenario) -> list[str]:
    """Return the metrics of a scenario, without those of what it does not have."""
    return [
        metric.name
        for metric in METRICS
        if all(need is LIMITS or provides(scenario, need) for need in metric.needs)
        and (scenario.has_sides or not metric.by_side)
    ]


def optional_metrics(scenario: Scenario) -> tuple[str, ...]:
    """Return the metrics of orbits, weighting, end stops, sides and shocks; they come last."""
    asked = requested_metrics(scenario)
    groups = (
        [metric.name for metric in METRICS if ORBIT in metric.needs],
        [metric.name for metric in METRICS if WEIGHTING in metric.needs],
        [metric.name for metric in METRICS if STOPS in metric.needs and not metric.by_side],
        [metric.name for metric in METRICS if metric.by_side],
        ["x_dd_peak"] * shows_peak_acceleration(scenario),
    )
    return tuple(name for group in groups for name in group if name in asked)


def interval_metrics(scenario: Scenario) -> tuple[str, ...]:
    """Return the metrics whose confidence interval is written, of means over seeds."""
    names = (metric.name for metric in METRICS if metric.with_interval)
    return (*names, *optional_metrics(scenario))


def has_means(table: Table) -> bool:
    """Whether any case is a mean over seeds; this adds columns at the end."""
    return any(tally.seeds for tally in table.tallies.values())


def write_violations(
    file: Path, keys: Sequence[Column], rows: Sequence[Row], approach: str
) -> None:
    """Write stroke_violations.csv: the rows of one approach that exceed the stroke limit."""
    names = zip(VIOLATION_METRICS, VIOLATION_COLUMNS, strict=True)
    columns = [*keys, *(metric_column(metric, name) for metric, name in names)]
    write_cases(
        file,
        columns,
        rows,
        lambda batch: (batch.metrics["violations"] > 0) & (batch.approach == approach),
    )


def write_cases(
    file: Path,
    columns: Sequence[Column],
    rows: Sequence[Row],
    selected: Callable[[Batch], NDArray[np.bool_]] | None = None,
) -> None:
    """Write columns of many cases as CSV; of all cases, or of those that are selected."""

    def blocks() -> Iterator[bytes]:
        for batch in batches_to_format(rows):
            part = slice(None) if selected is None else selected(batch)
            yield format_cases(columns, batch, part)

    write_csv(file, [column.header for column in columns], blocks())


def batches_to_format(rows: Sequence[Row]) -> Iterable[Batch]:
    """Return rows as batches of many."""
    # The batches of a small table may hold a single case each; its rows are cached.
    return as_batches(rows) if len(rows) > MAX_CACHED_ROWS else group_batches(rows)


def format_cases(
    columns: Sequence[Column], batch: Batch, part: slice | NDArray[np.bool_] = slice(None)
) -> bytes:
    """Return the cases of a batch, or some of them, as CSV rows."""
    return format_rows([_case_cells(column, batch, part) for column in columns])


def _case_cells(column: Column, batch: Batch, part: slice | NDArray[np.bool_]) -> Values:
    values = column.values(batch)
    if not isinstance(values, np.ndarray):
        if isinstance(part, slice):
            return values[part]
        return list(compress(values, part))
    whole = column.whole or values.dtype.kind == "i"
    return format_counts(values[part]) if whole else values[part]


# Cases as Parquet.


# Benches.


def quote_cell(text: str) -> str:
    """Return text as a CSV cell on one line, quoted if it has a comma or a quote."""
    text = _as_text(sanitise(" ".join(text.split())))
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"') else text


FORMULA_STARTS = "=", "+", "-", "@"
"""First characters of a cell that spreadsheets evaluate."""


def _as_text(cell: str) -> str:
    """Return text that no spreadsheet takes for a formula; numbers and lone signs stay."""
    is_plain = len(cell) == 1 or NUMBER_PATTERN.fullmatch(cell)
    is_formula = cell.startswith(FORMULA_STARTS) and not is_plain
    return f"'{cell}" if is_formula else cell


# Rows of CSV.


Values = NDArray[Any] | list[bytes]
"""A column: numbers, or text as cells."""


def write_csv(file: Path, headers: Sequence[str], blocks: Iterable[bytes]) -> None:
    """Write a header row and blocks of rows."""
    with file.open("wb") as out:
        out.write((",".join(headers) + "\n").encode())
        out.writelines(blocks)


def format_rows(columns: Iterable[Values]) -> bytes:
    """Return columns of floats and of cells as CSV rows."""
    parts: list[Iterable[bytes]] = []
    for is_number, group in groupby(columns, key=lambda column: isinstance(column, np.ndarray)):
        neighbours: list[Any] = [*group]
        parts += [format_numbers(neighbours)] if is_number else neighbours
    return join_rows(parts)


def format_numbers(columns: Sequence[NDArray[np.float64]]) -> list[bytes]:
    """Return rows of numbers separated by commas.

    A number is the shortest decimal that reads back as the same float, -0.0 becomes 0.0, and a
    number that is not finite an empty cell.
    """
    table = np.column_stack(columns) + 0.0
    text = orjson.dumps(table, option=orjson.OPT_SERIALIZE_NUMPY)
    return text[2:-2].replace(b"null", b"").split(b"],[") if len(table) else []


def format_counts(values: NDArray[Any]) -> list[bytes]:
    """Return counts as cells; NaN is an empty cell, and a mean of counts may have decimals."""
    if np.isnan(values).all():
        return [b""] * len(values)
    return [
        b"" if value != value else format_cell(value).encode() if value % 1 else b"%d" % value
        for value in values.tolist()
    ]


def format_words(texts: Sequence[str], codes: NDArray[np.generic]) -> list[bytes]:
    """Return texts as cells, by their index."""
    cells = [word.encode() for word in texts]
    return [cells[code] for code in codes.tolist()]


def join_rows(parts: Iterable[Iterable[bytes]]) -> bytes:
    """Return rows from the texts of their parts."""
    rows = b"\n".join(map(b",".join, zip(*parts, strict=True)))
    return rows + b"\n" if rows else b""


def format_cell(value: float | None) -> str:
    """Return the shortest decimal that reads back as the same float; empty where not finite."""
    if value is None or not np.isfinite(value):
        return ""
    return orjson.dumps(value + 0, option=orjson.OPT_SERIALIZE_NUMPY).decode()


def join_cells(rows: Iterable[Iterable[str]]) -> bytes:
    """Return rows of cells as CSV rows."""
    return "".join(f"{','.join(row)}\n" for row in rows).encode()


def require_package(package: str, extra: str, purpose: str, instead: str = "") -> None:
    """Verify that an optional package is installed.

    Parameters
    ----------
    package : str
        Its name.
    extra : str
        The extra of drysim that installs it.
    purpose : str
        What needs it.
    instead : str, optional
        What else to do.

    Raises
    ------
    UsageError
        With the command that installs it.
    """
    try:
        import_module(package)
    except ImportError:
        raise UsageError(
            f"{purpose} needs the package {package}, which is not installed",
            f'install it by pip install "drysim[{extra}]"{instead}',
        ) from None
