"""Tables: CSV files of a run and of many cases, Parquet of many cases; their columns and units.

Numbers are written as the shortest decimal that reads back as the same float. Rows are written
in blocks. Parquet has one file per block of cases.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby, repeat
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import orjson
from numpy.typing import NDArray

from drysim.approach.solution import EVENT_NAMES, Events, Response
from drysim.core.model import BLOCK_SIZE
from drysim.errors import UsageError
from drysim.metrics.table import LIMITS, METRICS, STOPS, WEIGHTING
from drysim.metrics.table import UNITS as METRIC_UNITS
from drysim.scenario.model import asks_for
from drysim.study.statistics import (
    COUNT_METRICS,
    MAX_CACHED_ROWS,
    STATUSES,
    Batch,
    Row,
    as_batches,
)

if TYPE_CHECKING:
    from drysim.scenario.model import Scenario
    from drysim.study.compare import Comparison
    from drysim.study.outcome import Outcome
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

RESPONSE_COLUMNS = ("t", "u_dd", "x_r", "v_r", "x_dd", "F_f", "stuck")
EVENT_COLUMNS = ("t", "event", "x_r", "F_L")
VIOLATION_COLUMNS = ("t_first", "x_r_peak", "t_beyond", "violations")
VIOLATION_METRICS = ("t_first_violation", *VIOLATION_COLUMNS[1:])
"""The columns of stroke_violations.csv, and the metrics in them."""

STUCK_TEXTS = ("0", "1")
EVENT_CODES = sorted(EVENT_NAMES)


def write_response_csv(outcome: Outcome, folder: Path) -> None:
    """Write response.csv: the motion on the output grid, with the force of end stops if any."""
    motion = outcome.response
    stops = motion.law.stops is not None
    blocks = (_response_block(motion, part, stops) for part in motion.parts())
    columns = (*RESPONSE_COLUMNS, "F_stop") if stops else RESPONSE_COLUMNS
    write_csv(
        folder / "response.csv",
        [*map(column_header, columns)],
        format_series(blocks, STUCK_TEXTS, 6),
    )


def write_events_csv(outcome: Outcome, folder: Path) -> None:
    """Write events.csv: stops, break-aways, reversals; the first row is the state at t = 0."""
    found = outcome.response.events
    names = [EVENT_NAMES[code] for code in EVENT_CODES]
    starts = range(0, len(found), BLOCK_SIZE)
    blocks = (_event_block(found, slice(start, start + BLOCK_SIZE)) for start in starts)
    write_csv(
        folder / "events.csv",
        [*map(column_header, EVENT_COLUMNS)],
        format_series(blocks, names, 1),
    )


def write_violations_csv(outcome: Outcome, folder: Path) -> None:
    """Write stroke_violations.csv, if the stroke limit was exceeded."""
    found = dict(outcome.metrics)
    if not found["violations"]:
        return
    for warning in outcome.warnings:
        # The metrics cover their window only; the limit may have been exceeded before it.
        if warning.slug == "stroke-violated":
            found |= warning.numbers
    cells = [[format_cell(found[name])] for name in VIOLATION_METRICS]
    write_csv(
        folder / "stroke_violations.csv",
        [*map(column_header, VIOLATION_COLUMNS)],
        [join_columns(cells)],
    )


def _response_block(motion: Response, part: slice, stops: bool) -> SeriesBlock:
    """Return one block of response.csv."""
    x_r, v_r, d, *_ = motion.points(part)
    t = np.arange(part.start, part.stop) * motion.dt
    u_dd, x_dd = motion.base(part), motion.acceleration(part)
    series = (t, u_dd, x_r, v_r, x_dd, motion.friction(part))
    return SeriesBlock((*series, motion.stop(part)) if stops else series, d == 0)


def _event_block(found: Events, part: slice) -> SeriesBlock:
    """Return one block of events.csv."""
    words = np.searchsorted(EVENT_CODES, found.kind[part])
    return SeriesBlock((found.t[part], found.x_r[part], found.F_L[part]), words)


def column_header(name: str) -> str:
    """Return the header of a column, e.g. `x_r [m]`."""
    return f"{name} [{COLUMN_UNITS[name]}]" if COLUMN_UNITS[name] else name


# Many cases: a row for each case of each approach.


FORCE_COLUMNS = ("F_fk", "F_fs")
METRIC_COLUMNS = (
    "a_u", "a_x", "T_a", "T_x", "x_r_rms", "x_r_peak",
    "stroke_used", "stuck_share", "chatter_share", "violations", "closure",
)  # fmt: skip
INTERVAL_METRICS = ("a_x", "T_a", "T_x", "x_r_rms", "x_r_peak", "stuck_share")
"""The metrics whose confidence interval is written, if they are means over several seeds."""


def write_transmissibility_csv(table: Table, folder: Path) -> None:
    """Write transmissibility.csv: every case of a sweep, then those of its reference."""
    headers, optional = _case_headers(table), optional_metrics(table)
    if len(table.rows) <= MAX_CACHED_ROWS or _has_ensembles(table):
        lines: Iterable[bytes] = [join_columns(_case_columns(table))]
    else:
        keys = [axis.key for axis in table.axes]
        blocks = (_case_block(batch, keys, optional) for batch in as_batches(table.rows))
        lines = format_cases(blocks, STATUSES, len(headers) - len(optional) - 2)
    write_csv(folder / "transmissibility.csv", headers, lines)


def write_comparison_csv(result: Comparison, folder: Path) -> None:
    """Write comparison.csv: every case with every approach, and its deviation."""
    found = [result.off(row) or (None, None) for row in result.table.rows]
    off = [[format_cell(value) for value in column] for column in zip(*found, strict=True)]
    names = ["T_a_deviation", "T_a_deviation_half_width"]
    if not _has_ensembles(result.table):
        del off[1], names[1]
    if result.of_laws:
        names.append("law")
        off.append([result.laws[row.approach] for row in result.table.rows])
    headers = [*_case_headers(result.table), *map(column_header, names)]
    write_csv(
        folder / "comparison.csv",
        headers,
        [join_columns([*_case_columns(result.table), *off])],
    )


def write_case_violations_csv(table: Table, folder: Path) -> None:
    """Write stroke_violations.csv of a sweep, if the stroke limit was exceeded.

    The viscous reference is left out: it is not the seat under test.
    """
    own = next(iter(table.tallies.values()), None)
    if own is not None and own.beyond:
        headers = [*_key_headers(table), *map(column_header, VIOLATION_COLUMNS)]
        write_csv(
            folder / "stroke_violations.csv", headers, _violation_rows(table, own.approach)
        )


def _violation_rows(table: Table, approach: str) -> Iterator[bytes]:
    """Yield the rows of the cases that exceed the limit, block by block."""
    for batch in as_batches(table.rows):
        if batch.approach == approach:
            rows = [row for row in batch if row.metrics.get("violations")]
            yield join_columns(
                [*_key_columns(table, rows), *metric_columns(rows, VIOLATION_METRICS)]
            )


def requested_metrics(scenario: Scenario) -> list[str]:
    """Return the metrics of a scenario, without those of what it does not have."""
    return [
        metric.name
        for metric in METRICS
        if all(need is LIMITS or asks_for(scenario, need) for need in metric.needs)
        and (scenario.has_sides or not metric.by_side)
    ]


def optional_metrics(table: Table) -> tuple[str, ...]:
    """Return the metrics of weighting, end stops and sides; they follow all others."""
    asked = requested_metrics(table.scenario)
    groups = (
        [metric.name for metric in METRICS if WEIGHTING in metric.needs],
        [metric.name for metric in METRICS if STOPS in metric.needs and not metric.by_side],
        [metric.name for metric in METRICS if metric.by_side],
    )
    return tuple(name for group in groups for name in group if name in asked)


def interval_metrics(table: Table) -> tuple[str, ...]:
    """Return the metrics whose confidence interval is written; none without several seeds."""
    return (*INTERVAL_METRICS, *optional_metrics(table)) if _has_ensembles(table) else ()


def _has_ensembles(table: Table) -> bool:
    """Whether any case is a mean over seeds; this adds columns at the end."""
    return any(tally.seeds for tally in table.tallies.values())


def _case_headers(table: Table) -> list[str]:
    """Return the headers of a table of cases."""
    return [
        "approach",
        *_key_headers(table),
        *map(column_header, (*FORCE_COLUMNS, *METRIC_COLUMNS)),
        "status",
        *map(column_header, optional_metrics(table)),
        *_interval_headers(table),
    ]


def _key_headers(table: Table) -> list[str]:
    """Return the headers of the swept keys."""
    return [f"{axis.key} [{axis.unit or '-'}]" for axis in table.axes]


def _interval_headers(table: Table) -> list[str]:
    """Return the headers of the confidence intervals."""
    names = interval_metrics(table)
    units = [column_header(name).removeprefix(name) for name in names]
    cells = [f"{name}_half_width{unit}" for name, unit in zip(names, units, strict=True)]
    return [column_header("seeds"), *cells] if cells else []


def _case_columns(table: Table) -> list[Iterable[str]]:
    """Return the cells of a table of cases by columns."""
    rows = table.rows
    return [
        [row.approach for row in rows],
        *_key_columns(table, rows),
        [format_cell(row.F_fk) for row in rows],
        [format_cell(row.F_fs) for row in rows],
        *metric_columns(rows, METRIC_COLUMNS),
        [row.status for row in rows],
        *metric_columns(rows, optional_metrics(table)),
        *_interval_columns(table),
    ]


def _key_columns(table: Table, rows: Sequence[Row]) -> list[list[str]]:
    return [[format_cell(row.point.get(axis.key)) for row in rows] for axis in table.axes]


def metric_columns(rows: Sequence[Row], metrics: Sequence[str]) -> list[list[str]]:
    """Return the cells of some metrics by columns."""
    return [[format_cell(row.metrics.get(name)) for row in rows] for name in metrics]


def _interval_columns(table: Table) -> list[list[str]]:
    """Return the cells of the confidence intervals by columns."""
    names, rows = interval_metrics(table), table.rows
    if not names:
        return []
    widths = [[format_cell(row.half_widths.get(name)) for row in rows] for name in names]
    return [[str(row.seeds) for row in rows], *widths]


def _case_block(batch: Batch, keys: Sequence[str], optional: Sequence[str]) -> CaseBlock:
    """Return a block of cases as columns of numbers; NaN for a key that the approach lacks."""
    lacking = np.full(len(batch), np.nan)
    points = [batch.points.get(key, lacking) for key in keys]
    named = [batch.metrics[name] for name in (*METRIC_COLUMNS, *optional)]
    whole = [column.dtype.kind == "i" for column in points]
    counts = [name in COUNT_METRICS for name in (*METRIC_COLUMNS, *optional)]
    numbers = np.array([*points, batch.F_fk, batch.F_fs, *named], dtype=float)
    return CaseBlock(batch.approach, numbers, [*whole, False, False, *counts], batch.status)


# Cases as Parquet.


PARQUET_FOLDER = "transmissibility"
"""The dataset: `approach=<name>/<number of the first case>.parquet` in it."""


def require_pyarrow() -> None:
    """Verify, before any work, that pyarrow is installed.

    Raises
    ------
    UsageError
        With the command that installs it.
    """
    try:
        import pyarrow  # noqa: F401 - only to see whether it is installed
    except ImportError:
        raise UsageError(
            "--format parquet needs the package pyarrow, which is not installed",
            'install it by pip install "drysim[parquet]", or omit --format',
        ) from None


def write_transmissibility_parquet(table: Table, folder: Path) -> None:
    """Write the cases of a sweep as a dataset, with the columns of transmissibility.csv."""
    import pyarrow.parquet

    for batch in as_batches(table.rows):
        place = folder / PARQUET_FOLDER / f"approach={batch.approach}"
        place.mkdir(parents=True, exist_ok=True)
        file = place / f"{batch.first:012d}.parquet"
        pyarrow.parquet.write_table(_arrow_table(table, batch), file)


def _arrow_table(table: Table, batch: Batch) -> Any:
    """Return a block of cases as an Arrow table, the unit of each column in its metadata."""
    import pyarrow

    fields, columns = [], []
    means = interval_metrics(table)

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
    for name in FORCE_COLUMNS:
        put(name, COLUMN_UNITS[name], getattr(batch, name), pyarrow.float64())
    for name in (*METRIC_COLUMNS, *optional_metrics(table)):
        values = batch.metrics[name]
        missing = np.isnan(values)
        if name in COUNT_METRICS:
            values = np.where(missing, 0, values).astype(np.int64)
        kind = pyarrow.int64() if name in COUNT_METRICS else pyarrow.float64()
        put(name, COLUMN_UNITS[name], values, kind, missing)
    words = [STATUSES[code] for code in batch.status.tolist()]
    put("status", "", words, pyarrow.string())
    known = [batch.over.get(i) for i in range(len(batch))] if means else []
    if means:
        put("seeds", "", [one.count if one else 1 for one in known], pyarrow.int64())
    for name in means:
        widths = [one.half_widths.get(name) if one else None for one in known]
        put(f"{name}_half_width", COLUMN_UNITS[name], widths, pyarrow.float64())
    return pyarrow.table(columns, schema=pyarrow.schema(fields))


# Rows of CSV.


class SeriesBlock(NamedTuple):
    """Columns of numbers, and the index of the text in each row; all of shape (n,)."""

    numbers: Sequence[NDArray[np.float64]]
    codes: NDArray[np.generic]


class CaseBlock(NamedTuple):
    """Cases of one approach as columns of numbers, shape (columns, n); NaN where missing."""

    approach: str
    numbers: NDArray[np.float64]
    whole: Sequence[bool]
    status: NDArray[np.int8]


def write_csv(file: Path, headers: Sequence[str], blocks: Iterable[bytes]) -> None:
    """Write a header row and blocks of rows."""
    with file.open("wb") as out:
        out.write((",".join(headers) + "\n").encode())
        out.writelines(blocks)


def format_series(
    blocks: Iterable[SeriesBlock], words: Sequence[str], place: int
) -> Iterator[bytes]:
    """Yield blocks as CSV rows, in order; a text of `words` follows `place` numbers."""
    for block in blocks:
        parts = [format_numbers(block.numbers[:place]), format_words(words, block.codes)]
        if block.numbers[place:]:
            parts.append(format_numbers(block.numbers[place:]))
        yield join_rows(parts)


def format_cases(
    blocks: Iterable[CaseBlock], words: Sequence[str], place: int
) -> Iterator[bytes]:
    """Yield blocks of cases as CSV rows, in order; `words` and `place` describe the status."""
    for block in blocks:
        columns = list(zip(block.numbers, block.whole, strict=True))
        yield join_rows(
            [
                repeat(block.approach.encode(), len(block.status)),
                *_format_columns(columns[:place]),
                format_words(words, block.status),
                *_format_columns(columns[place:]),
            ]
        )


def _format_columns(
    columns: Iterable[tuple[NDArray[np.float64], bool]],
) -> Iterator[list[bytes]]:
    """Yield the text of columns, each with whether it holds whole numbers, in order."""
    for whole, group in groupby(columns, key=itemgetter(1)):
        numbers = [values for values, _ in group]
        if whole:
            yield from map(format_counts, numbers)
        else:
            yield format_numbers(numbers)


def format_numbers(columns: Sequence[NDArray[np.float64]]) -> list[bytes]:
    """Return rows of numbers separated by commas.

    A number is the shortest decimal that reads back as the same float, -0.0 becomes 0.0, and a
    number that is not finite an empty cell.
    """
    table = np.column_stack(columns) + 0.0
    text = orjson.dumps(table, option=orjson.OPT_SERIALIZE_NUMPY)
    return text[2:-2].replace(b"null", b"").split(b"],[") if len(table) else []


def format_counts(values: NDArray[np.float64]) -> list[bytes]:
    """Return whole numbers as cells; NaN is an empty cell."""
    return [b"" if value != value else b"%d" % value for value in values.tolist()]


def format_words(words: Sequence[str], codes: NDArray[np.generic]) -> list[bytes]:
    """Return texts as cells, by their index."""
    cells = [word.encode() for word in words]
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


def join_columns(columns: Iterable[Iterable[str]]) -> bytes:
    """Return columns of cells as CSV rows."""
    return "".join(map("{}\n".format, map(",".join, zip(*columns, strict=True)))).encode()
