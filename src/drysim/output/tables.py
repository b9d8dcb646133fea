"""Tables: CSV files of a run and of many cases, Parquet of many cases; their columns and units.

Numbers are the shortest text that reads back as the same number. Blocks of rows are written as
they come, their text made ahead in threads by a kernel, or in plain Python by the same rules.
Parquet has a file a block, for pandas, Polars, DuckDB and their like.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from drysim import system
from drysim.approach.solution import EVENT_NAMES, Events, Response
from drysim.core.compile import is_plain
from drysim.core.model import BLOCK, Stopped
from drysim.errors import UsageError
from drysim.metrics.table import BOUNDED, COMFORT
from drysim.metrics.table import UNITS as METRIC_UNITS
from drysim.study.statistics import COUNTED, HELD, STATUSES, Batch, Row, batches_of

if TYPE_CHECKING:
    from drysim.study.compare import Comparison
    from drysim.study.outcome import Outcome
    from drysim.study.table import Table


NUMBERS = (
    "stuck", "seeds", "checks", "passed", "samples", "repeats", "error_x_r", "error_T_a",
    "T_a_deviation", "T_a_deviation_half_width", "x_r_peak_deviation", "x_r_rms_deviation",
    "time_over_lfilter",
)  # fmt: skip
"""Columns of plain numbers that are no metrics."""

UNITS = {
    **METRIC_UNITS,
    **dict.fromkeys(NUMBERS, "-"),
    "t": "s", "t_first": "s", "time": "s", "step": "s", "time_per_sample": "ns",
    "u_dd": "m/s2", "x_dd": "m/s2", "x_r": "m", "v_r": "m/s",
    "F_f": "N", "F_stop": "N", "F_L": "N", "F_fk": "N", "F_fs": "N",
    "event": "", "law": "",
}  # fmt: skip
"""Every column of fixed name, with its unit; an empty one stands for words."""

RESPONSE = ("t", "u_dd", "x_r", "v_r", "x_dd", "F_f", "stuck")
EVENTS = ("t", "event", "x_r", "F_L")
STROKE = ("t_first", "x_r_peak", "t_beyond", "violations")
VIOLATION = ("t_first_violation", *STROKE[1:])
"""The columns of stroke_violations.csv, and the metrics in them."""

STUCK = ("0", "1")
CODES = sorted(EVENT_NAMES)


def response(outcome: Outcome, folder: Path) -> None:
    """Write response.csv: the motion on its grid, and where there are end stops their force."""
    motion = outcome.response
    stops = isinstance(motion.law, Stopped)
    blocks = (_motion(motion, part, stops) for part in motion.parts())
    columns = (*RESPONSE, "F_stop") if stops else RESPONSE
    write(folder / "response.csv", [*map(heading, columns)], rows(blocks, STUCK, 6))


def events(outcome: Outcome, folder: Path) -> None:
    """Write events.csv: stops, break-aways, reversals; the first row is the state at t = 0."""
    found = outcome.response.events
    names = [EVENT_NAMES[code] for code in CODES]
    starts = range(0, len(found), BLOCK)
    blocks = (_events(found, slice(start, start + BLOCK)) for start in starts)
    write(folder / "events.csv", [*map(heading, EVENTS)], rows(blocks, names, 1))


def stroke_violations(outcome: Outcome, folder: Path) -> None:
    """Write stroke_violations.csv, but only when the stroke limit was met."""
    found = dict(outcome.metrics)
    if not found["violations"]:
        return
    for caution in outcome.warnings:
        # The peak of the metrics is that of their window; the limit may be met before.
        if caution.slug == "stroke-violated":
            found |= caution.numbers
    cells = [[text(found[name])] for name in VIOLATION]
    write(folder / "stroke_violations.csv", [*map(heading, STROKE)], [joined(cells)])


def _motion(motion: Response, part: slice, stops: bool) -> Block:
    """Give one block of response.csv."""
    x_r, v_r, d, *_ = motion.points(part)
    t = np.arange(part.start, part.stop) * motion.dt
    u_dd, x_dd = motion.base(part), motion.acceleration(part)
    series = (t, u_dd, x_r, v_r, x_dd, motion.friction(part))
    return Block((*series, motion.stop(part)) if stops else series, d == 0)


def _events(found: Events, part: slice) -> Block:
    """Give one block of events.csv."""
    words = np.searchsorted(CODES, found.kind[part])
    return Block((found.t[part], found.x_r[part], found.F_L[part]), words)


def heading(name: str) -> str:
    """Give the header cell of a column, e.g. `x_r [m]`."""
    return f"{name} [{UNITS[name]}]" if UNITS[name] else name


# Many cases: a row for each case of each approach.


FORCES = ("F_fk", "F_fs")
METRICS = (
    "a_u", "a_x", "T_a", "T_x", "x_r_rms", "x_r_peak",
    "stroke_used", "stuck_share", "chatter_share", "violations", "closure",
)  # fmt: skip
MEANS = ("a_x", "T_a", "T_x", "x_r_rms", "x_r_peak", "stuck_share")
"""The metrics whose confidence interval is told, where they are means over many seeds."""


def transmissibility(table: Table, folder: Path) -> None:
    """Write transmissibility.csv: every case of a sweep, then those of its reference."""
    headings, felt = _headings(table), felt_of(table)
    if len(table.rows) <= HELD or _many(table):
        lines: Iterable[Text] = [joined(_columns(table))]
    else:
        keys = [axis.key for axis in table.axes]
        blocks = (_block(batch, keys, felt) for batch in batches_of(table.rows))
        lines = cases(blocks, STATUSES, len(headings) - len(felt) - 2)
    write(folder / "transmissibility.csv", headings, lines)


def comparison(made: Comparison, folder: Path) -> None:
    """Write comparison.csv: every case under every approach, and what it is off by."""
    found = [made.off(row) or (None, None) for row in made.table.rows]
    off = [[text(value) for value in column] for column in zip(*found, strict=True)]
    names = ["T_a_deviation", "T_a_deviation_half_width"]
    if not _many(made.table):
        del off[1], names[1]
    if made.of_laws:
        names.append("law")
        off.append([made.laws[row.approach] for row in made.table.rows])
    headings = [*_headings(made.table), *map(heading, names)]
    write(folder / "comparison.csv", headings, [joined([*_columns(made.table), *off])])


def stroke_violations_of_cases(table: Table, folder: Path) -> None:
    """Write stroke_violations.csv of a sweep, but only when the stroke limit was met.

    The reference is no seat that anybody would build, so it is left out.
    """
    own = next(iter(table.tallies.values()), None)
    if own is not None and own.beyond:
        headings = [*_keys(table), *map(heading, STROKE)]
        write(folder / "stroke_violations.csv", headings, _met(table, own.approach))


def _met(table: Table, approach: str) -> Iterator[Text]:
    """Give the rows of the cases that meet the limit, block by block."""
    for batch in batches_of(table.rows):
        if batch.approach == approach:
            rows = [row for row in batch if row.metrics.get("violations")]
            yield joined([*_points(table, rows), *known(rows, VIOLATION)])


def felt_of(table: Table) -> tuple[str, ...]:
    """Give the metrics that only a weighting or end stops add, behind all other columns."""
    felt = COMFORT if table.scenario.measure.weights else ()
    return felt if table.scenario.stops is None else (*felt, *BOUNDED)


def means_of(table: Table) -> tuple[str, ...]:
    """Give the metrics whose confidence interval is told; none without many seeds."""
    return (*MEANS, *felt_of(table)) if _many(table) else ()


def _many(table: Table) -> bool:
    """Tell whether any case is many seeds; columns behind all others tell of them then."""
    return any(tally.seeds for tally in table.tallies.values())


def _headings(table: Table) -> list[str]:
    """Give the header cells of a table of cases."""
    return [
        "approach",
        *_keys(table),
        *map(heading, (*FORCES, *METRICS)),
        "status",
        *map(heading, felt_of(table)),
        *_widths(table),
    ]


def _keys(table: Table) -> list[str]:
    """Give the header cells of the swept keys."""
    return [f"{axis.key} [{axis.unit or '-'}]" for axis in table.axes]


def _widths(table: Table) -> list[str]:
    """Give the header cells of what is known of means over many seeds."""
    names = means_of(table)
    units = [heading(name).removeprefix(name) for name in names]
    cells = [f"{name}_half_width{unit}" for name, unit in zip(names, units, strict=True)]
    return [heading("seeds"), *cells] if cells else []


def _columns(table: Table) -> list[Iterable[str]]:
    """Give the cells of a table of cases, column by column."""
    rows = table.rows
    return [
        [row.approach for row in rows],
        *_points(table, rows),
        [text(row.F_fk) for row in rows],
        [text(row.F_fs) for row in rows],
        *known(rows, METRICS),
        [row.status for row in rows],
        *known(rows, felt_of(table)),
        *_spread(table),
    ]


def _points(table: Table, rows: Sequence[Row]) -> list[list[str]]:
    return [[text(row.point.get(axis.key)) for row in rows] for axis in table.axes]


def known(rows: Sequence[Row], metrics: Sequence[str]) -> list[list[str]]:
    """Give the cells of some metrics, column by column."""
    return [[text(row.metrics.get(name)) for row in rows] for name in metrics]


def _spread(table: Table) -> list[list[str]]:
    """Give the cells of what is known of means over many seeds."""
    names, rows = means_of(table), table.rows
    if not names:
        return []
    widths = [[text(row.half_widths.get(name)) for row in rows] for name in names]
    return [[str(row.seeds) for row in rows], *widths]


def _block(batch: Batch, keys: Sequence[str], felt: Sequence[str]) -> Cases:
    """Give a block of cases as columns of numbers; a key that the approach lacks has none."""
    lacking = np.full(len(batch), np.nan)
    points = [batch.points.get(key, lacking) for key in keys]
    named = [batch.metrics[name] for name in (*METRICS, *felt)]
    whole = [column.dtype.kind == "i" for column in points]
    counts = [name in COUNTED for name in (*METRICS, *felt)]
    numbers = np.array([*points, batch.F_fk, batch.F_fs, *named], dtype=float)
    return Cases(batch.approach, numbers, [*whole, False, False, *counts], batch.status)


# The same as Parquet.


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


def transmissibility_parquet(table: Table, folder: Path) -> None:
    """Write the cases of a sweep as a dataset, with the columns of transmissibility.csv."""
    import pyarrow.parquet

    for batch in batches_of(table.rows):
        place = folder / FOLDER / f"approach={batch.approach}"
        place.mkdir(parents=True, exist_ok=True)
        file = place / f"{batch.first:012d}.parquet"
        pyarrow.parquet.write_table(_arrow(table, batch), file)


def _arrow(table: Table, batch: Batch) -> Any:
    """Give a block of cases as Arrow has them, the unit of each column in its metadata."""
    import pyarrow

    fields, columns = [], []
    means = means_of(table)

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
    for name in (*METRICS, *felt_of(table)):
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


# Rows of CSV.


WORKERS = 4
"""Most threads that make text; one more writes it down, and hardly a disk is faster."""

Text = bytes | memoryview
Given = TypeVar("Given")


class Block(NamedTuple):
    """Columns of numbers, and which word stands in each row; all of shape (n,)."""

    numbers: Sequence[NDArray[np.float64]]
    codes: NDArray[np.generic]


class Cases(NamedTuple):
    """Cases of one approach as columns of numbers, shape (columns, n); NaN for not known."""

    approach: str
    numbers: NDArray[np.float64]
    whole: Sequence[bool]
    status: NDArray[np.int8]


def write(file: Path, headings: Sequence[str], blocks: Iterable[Text]) -> None:
    """Write a header row and blocks of rows."""
    with file.open("wb") as out:
        out.write((",".join(headings) + "\n").encode())
        out.writelines(blocks)


def rows(blocks: Iterable[Block], words: Sequence[str], place: int) -> Iterator[Text]:
    """Give blocks as rows, in order; one of `words`, by code, stands behind `place` numbers."""
    if is_plain():
        return (_spoken(words, place, block) for block in blocks)
    return _ahead(partial(_printed, words, place), blocks)


def _spoken(words: Sequence[str], place: int, block: Block) -> bytes:
    """Give the rows of a block, in plain Python."""
    columns: list[Iterable[str]] = [texts(column) for column in block.numbers]
    columns.insert(place, map(words.__getitem__, block.codes.tolist()))
    return joined(columns)


def _printed(words: Sequence[str], place: int, block: Block) -> memoryview:
    """Give the rows of a block by the kernel."""
    from drysim.core.digits import WIDTH, put_rows

    numbers, table = np.stack(block.numbers), _table(words)
    longest = len(numbers) * (WIDTH + 1) + table.shape[1] + 1
    out = np.empty(len(block.codes) * longest, np.uint8)
    codes = block.codes.astype(np.int64)
    return out[: put_rows(numbers.view(np.uint64), codes, table, place, out)].data


def cases(blocks: Iterable[Cases], words: Sequence[str], place: int) -> Iterator[Text]:
    """Give blocks of cases as rows, in order; `words` and `place` are those of the status."""
    if is_plain():
        return (_listed(words, place, block) for block in blocks)
    return _ahead(partial(_put, words, place), blocks)


def _listed(words: Sequence[str], place: int, block: Cases) -> bytes:
    """Give the rows of a block of cases, in plain Python."""
    columns: list[Iterable[str]] = []
    for column, whole in zip(block.numbers.tolist(), block.whole, strict=True):
        kind = int if whole else float
        columns.append(["" if x != x else str(kind(x) + 0) for x in column])
    columns.insert(place, map(words.__getitem__, block.status.tolist()))
    return joined([[block.approach] * len(block.status), *columns])


def _put(words: Sequence[str], place: int, block: Cases) -> memoryview:
    """Give the rows of a block of cases by the kernel."""
    from drysim.core.digits import WIDTH, put_cases

    table = _table(words)
    name = np.frombuffer(block.approach.encode(), np.uint8)
    longest = len(block.numbers) * (WIDTH + 1) + table.shape[1] + len(name) + 2
    out = np.empty(len(block.status) * longest, np.uint8)
    whole, codes = np.array(block.whole), block.status.astype(np.int64)
    bits = np.ascontiguousarray(block.numbers).view(np.uint64)
    return out[: put_cases(bits, whole, name, codes, table, place, out)].data


def _table(words: Sequence[str]) -> NDArray[np.uint8]:
    """Give words as rows of letters, as the kernel wants them."""
    letters = np.array([word.encode() for word in words])
    return letters.view(np.uint8).reshape(len(words), -1)


def _ahead(make: Callable[[Given], memoryview], blocks: Iterable[Given]) -> Iterator[Text]:
    """Give the text of every block, in order; some are made ahead, in threads."""
    return system.in_order(make, blocks, min(system.processors(), WORKERS))


def texts(values: NDArray[np.float64]) -> Iterator[str]:
    """Give the shortest text that reads back as the same number; -0.0 becomes 0.0."""
    return map(repr, (values + 0.0).tolist())


def text(value: float | None) -> str:
    """Give the shortest text that reads back as the same number; nothing for not known."""
    return "" if value is None else str(value + 0)


def joined(columns: Iterable[Iterable[str]]) -> bytes:
    """Give columns of cells as rows."""
    return "".join(map("{}\n".format, map(",".join, zip(*columns, strict=True)))).encode()
