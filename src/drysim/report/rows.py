"""CSV files of many cases: a row for each case of each approach."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drysim.metrics import BOUNDED, COMFORT
from drysim.report.cells import Cases, Text, cases, joined, text
from drysim.report.tables import STROKE, VIOLATION, heading, write
from drysim.study.sweeps.batch import COUNTED, STATUSES
from drysim.study.sweeps.rows import HELD, batches_of

if TYPE_CHECKING:
    from drysim.study.comparisons.comparison import Comparison
    from drysim.study.sweeps.batch import Batch
    from drysim.study.sweeps.table import Row, Table

FORCES = ("F_fk", "F_fs")
METRICS = (
    "a_u", "a_x", "T_a", "T_x", "x_r_rms", "x_r_peak",
    "stroke_used", "stuck_share", "chatter_share", "violations", "closure",
)  # fmt: skip
MEANS = ("a_x", "T_a", "T_x", "x_r_rms", "x_r_peak", "stuck_share")
"""The metrics whose confidence interval is told, where they are means over many seeds."""


def transmissibility(table: Table, folder: Path) -> None:
    """Write transmissibility.csv: every case of a sweep, then those of its reference.

    Parameters
    ----------
    table : Table
    folder : Path
        Where to write.
    """
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


def stroke_violations(table: Table, folder: Path) -> None:
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


def _block(batch: Batch, keys: Sequence[str], felt: Sequence[str]) -> Cases:
    """Give a block of cases as columns of numbers; a key that the approach lacks has none."""
    lacking = np.full(len(batch), np.nan)
    points = [batch.points.get(key, lacking) for key in keys]
    named = [batch.metrics[name] for name in (*METRICS, *felt)]
    whole = [column.dtype.kind == "i" for column in points]
    counts = [name in COUNTED for name in (*METRICS, *felt)]
    numbers = np.array([*points, batch.F_fk, batch.F_fs, *named], dtype=float)
    return Cases(batch.approach, numbers, [*whole, False, False, *counts], batch.status)


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


def _widths(table: Table) -> list[str]:
    """Give the header cells of what is known of means over many seeds."""
    names = means_of(table)
    units = [heading(name).removeprefix(name) for name in names]
    cells = [f"{name}_half_width{unit}" for name, unit in zip(names, units, strict=True)]
    return [heading("seeds"), *cells] if cells else []


def _spread(table: Table) -> list[list[str]]:
    """Give the cells of what is known of means over many seeds."""
    names, rows = means_of(table), table.rows
    if not names:
        return []
    widths = [[text(row.half_widths.get(name)) for row in rows] for name in names]
    return [[str(row.seeds) for row in rows], *widths]


def _keys(table: Table) -> list[str]:
    """Give the header cells of the swept keys."""
    return [f"{axis.key} [{axis.unit or '-'}]" for axis in table.axes]


def _points(table: Table, rows: Sequence[Row]) -> list[list[str]]:
    return [[text(row.point.get(axis.key)) for row in rows] for axis in table.axes]


def known(rows: Sequence[Row], metrics: Sequence[str]) -> list[list[str]]:
    """Give the cells of some metrics, column by column."""
    return [[text(row.metrics.get(name)) for row in rows] for name in metrics]
