"""Tables: CSV files of a run and of many cases, Parquet of many cases; their columns and units.

Numbers are written as the shortest decimal that reads back as the same float. Rows are written
in blocks. Parquet has one file per block of cases.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import compress, groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import orjson
from numpy.typing import NDArray

from drysim.approach.solution import EVENT_NAMES, Response
from drysim.core.model import BLOCK_SIZE
from drysim.errors import UsageError
from drysim.metrics.table import LIMITS, METRICS, ORBIT, STOPS, WEIGHTING
from drysim.metrics.table import UNITS as METRIC_UNITS
from drysim.scenario.axes import TEXT_KEYS
from drysim.scenario.blocks import SEED_KEY
from drysim.scenario.model import asks_for, asks_for_peak_acceleration
from drysim.study.statistics import (
    COUNT_METRICS,
    MAX_CACHED_ROWS,
    STATUSES,
    Batch,
    Row,
    as_batches,
    averages_seeds,
    group_batches,
)
from drysim.units import NUMBER_PATTERN
from drysim.wording import sanitise

if TYPE_CHECKING:
    from drysim.bench.hard_cases import HardCases
    from drysim.bench.score import Bench
    from drysim.scenario.axes import Axis
    from drysim.scenario.model import Scenario
    from drysim.study.branches import BranchesResult
    from drysim.study.compare import Comparison
    from drysim.study.design import DesignResult
    from drysim.study.ensemble import Ensemble
    from drysim.study.fit import FitResult
    from drysim.study.outcome import Outcome
    from drysim.study.plan import AsText
    from drysim.study.regimes import RegimeMap
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
    names = (*RESPONSE_COLUMNS, "F_stop") if stops else RESPONSE_COLUMNS
    rows = (format_rows(_response_block(motion, part, stops)) for part in motion.parts())
    write_csv(folder / "response.csv", [*map(column_header, names)], rows)


def _response_block(motion: Response, part: slice, stops: bool) -> list[Values]:
    """Return one block of response.csv by columns."""
    x_r, v_r, d, *_ = motion.points(part)
    t = np.arange(part.start, part.stop) * motion.dt
    stuck = format_words(STUCK_TEXTS, d == 0)
    series = [t, motion.base(part), x_r, v_r, motion.acceleration(part), motion.friction(part)]
    return [*series, stuck, motion.stop(part)] if stops else [*series, stuck]


def write_events_csv(outcome: Outcome, folder: Path) -> None:
    """Write events.csv: stops, break-aways, reversals; the first row is the state at t = 0."""
    found = outcome.response.events
    names = [EVENT_NAMES[code] for code in EVENT_CODES]

    def rows() -> Iterator[bytes]:
        for start in range(0, len(found), BLOCK_SIZE):
            part = slice(start, start + BLOCK_SIZE)
            kinds = format_words(names, np.searchsorted(EVENT_CODES, found.kind[part]))
            yield format_rows([found.t[part], kinds, found.x_r[part], found.F_L[part]])

    write_csv(folder / "events.csv", [*map(column_header, EVENT_COLUMNS)], rows())


def write_violations_csv(outcome: Outcome, folder: Path) -> None:
    """Write stroke_violations.csv, if the stroke limit was exceeded."""
    found = dict(outcome.metrics)
    if not found["violations"]:
        return
    for warning in outcome.warnings:
        # The metrics cover their window only; the limit may have been exceeded before it.
        if warning.slug == "stroke-violated":
            found |= warning.numbers
    cells = [format_cell(found[name]) for name in VIOLATION_METRICS]
    headers = [*map(column_header, VIOLATION_COLUMNS)]
    write_csv(folder / "stroke_violations.csv", headers, [join_cells([cells])])


def column_header(name: str, unit: str | None = None) -> str:
    """Return the header of a column, e.g. `x_r [m]`; its unit is known for fixed names."""
    unit = COLUMN_UNITS[name] if unit is None else unit
    return f"{name} [{unit}]" if unit else name


def write_spectra_csv(outcome: Outcome, folder: Path) -> None:
    """Write spectra.csv, if spectra were requested."""
    found = outcome.spectra
    if found is None:
        return
    columns = {
        "f [Hz]": found.f,
        "G_u [(m/s2)2/Hz]": found.G_u,
        "G_x [(m/s2)2/Hz]": found.G_x,
        "H1 [-]": np.abs(found.H1),
        "phase [rad]": np.angle(found.H1),
        "coherence [-]": found.coherence,
    }
    write_csv(folder / "spectra.csv", list(columns), [format_rows(columns.values())])


def write_bands_csv(outcome: Outcome, folder: Path) -> None:
    """Write bands.csv, if one-third-octave bands were requested."""
    if outcome.spectra is None or outcome.spectra.bands is None:
        return
    from drysim.metrics.spectra import BANDS

    a_u, a_x, a_wu, a_w = outcome.spectra.bands
    columns = {"f [Hz]": np.array(BANDS), "a_u [m/s2]": a_u, "a_x [m/s2]": a_x}
    if a_wu is not None and a_w is not None:
        columns |= {"a_wu [m/s2]": a_wu, "a_w [m/s2]": a_w}
    write_csv(folder / "bands.csv", list(columns), [format_rows(columns.values())])


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
    return columns_of(table.scenario, table.axes, _has_means(table))


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

        def texts(batch: Batch) -> Values:
            return [_csv_text(text) for text in batch.points.get(key, [""] * len(batch))]

        return Column(key, "", texts)
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
        found = (batch.over.get(i) for i in range(len(batch)))
        return np.array([one and one.half_widths.get(metric) for one in found], dtype=float)

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


BRANCH_METRICS = ("T_a", "T_x", "x_r_peak", "stuck_share")
"""Metrics of the points of a branch."""


def write_branches_csv(result: BranchesResult, folder: Path) -> None:
    """Write branches.csv: every point of every branch, in the order along it."""
    headers = [
        "branch [-]",
        column_header(result.axis.key, result.axis.unit),
        *map(column_header, BRANCH_METRICS),
        "stops_per_period [-]",
        "symmetric [-]",
        "periods [-]",
        "stable [-]",
        *(f"multiplier_{i}{part}" for i in (1, 2) for part in (" [-]", "_phase [rad]")),
        "contacts_per_period [-]",
        "residual [-]",
        "multiplier_error [-]",
    ]

    def blocks() -> Iterator[bytes]:
        for one in result.branches:
            count = len(one.values)

            def same(value: float, count: int = count) -> NDArray[np.float64]:
                return np.full(count, float(value))

            parts = [
                part
                for i in (0, 1)
                for part in (abs(one.multipliers[:, i]), np.angle(one.multipliers[:, i]))
            ]
            yield format_rows(
                [
                    same(one.number),
                    one.values,
                    *(one.metrics[name] for name in BRANCH_METRICS),
                    one.stops,
                    same(one.symmetric),
                    same(one.periods),
                    one.stable.astype(float),
                    *parts,
                    one.contacts,
                    one.residual,
                    one.multiplier_error,
                ]
            )

    write_csv(folder / "branches.csv", headers, blocks())


def write_bifurcations_csv(result: BranchesResult, folder: Path) -> None:
    """Write bifurcations.csv: where motions appear, vanish or change, by value of the key."""
    headers = [
        "bifurcation",
        "branch [-]",
        column_header(result.axis.key, result.axis.unit),
        "stops_before [-]",
        "stops_after [-]",
        "x_r_peak [m]",
        "contacts_before [-]",
        "contacts_after [-]",
    ]
    found = result.bifurcations
    numbers = np.array(
        [(one.branch, one.value, *one.stops, one.x_r_peak, *one.contacts) for one in found]
    ).reshape(-1, 7)
    columns: list[Values] = [[one.kind.encode() for one in found], *numbers.T.copy()]
    write_csv(folder / "bifurcations.csv", headers, [format_rows(columns)] if found else [])


def requested_metrics(scenario: Scenario) -> list[str]:
    """Return the metrics of a scenario, without those of what it does not have."""
    return [
        metric.name
        for metric in METRICS
        if all(need is LIMITS or asks_for(scenario, need) for need in metric.needs)
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
        ["x_dd_peak"] * asks_for_peak_acceleration(scenario),
    )
    return tuple(name for group in groups for name in group if name in asked)


def interval_metrics(scenario: Scenario) -> tuple[str, ...]:
    """Return the metrics whose confidence interval is written, of means over seeds."""
    known = (metric.name for metric in METRICS if metric.with_interval)
    return (*known, *optional_metrics(scenario))


def _has_means(table: Table) -> bool:
    """Whether any case is a mean over seeds; this adds columns at the end."""
    return any(tally.seeds for tally in table.tallies.values())


FIT_COLUMNS = (
    "key", "unit", "value", "deviation", "low", "high", "profile_low", "profile_high", "note",
)  # fmt: skip
"""Columns of fit.csv; each row has a unit of its own."""


def write_fit_csv(result: FitResult, folder: Path) -> None:
    """Write fit.csv: the fitted values with their 95 % intervals."""
    rows = [
        [quote_cell(one.key), quote_cell(one.unit)]
        + [format_cell(value) for value in one[2:8]]
        + [quote_cell(one.note)]
        for one in result.parameters
    ]
    write_csv(folder / "fit.csv", FIT_COLUMNS, [join_cells(rows)])


def write_residuals_csv(result: FitResult, folder: Path) -> None:
    """Write residuals.csv: each channel as measured and as fitted, and which samples count."""
    measurement, columns = result.measurement, {"t [s]": result.measurement.t}
    for channel in result.channels:
        name, unit = channel.name, COLUMN_UNITS[channel.name]
        measured = measurement.channels[name]
        fitted = result.prediction.channels[name] + (channel.offset or 0.0)
        columns[f"{name} [{unit}]"] = measured
        columns[f"{name}_fitted [{unit}]"] = fitted
        columns[f"{name}_residual [{unit}]"] = measured - fitted
    selected = np.zeros(len(measurement.t), dtype=bool)
    selected[: len(result.selected)] = result.selected
    held_out = np.arange(len(measurement.t)) >= len(result.selected)
    cells = [format_words(STUCK_TEXTS, flags) for flags in (selected, held_out)]
    rows = format_rows([*columns.values(), *cells])
    write_csv(folder / "residuals.csv", [*columns, "selected [-]", "held_out [-]"], [rows])


def transmissibility_text(scenario: Scenario) -> AsText | None:
    """Return what formats the cases of a large sweep in the workers; None for a small one.

    The rows of a small table are formatted together: its batches may hold a single case each.
    """
    from drysim.study.plan import approaches_of
    from drysim.study.run import count_cases

    if count_cases(approaches_of(scenario)) <= MAX_CACHED_ROWS:
        return None
    columns = columns_of(scenario, scenario.sweep, averages_seeds(scenario))
    return partial(format_cases, columns)


def write_transmissibility_csv(table: Table, folder: Path) -> None:
    """Write transmissibility.csv: every case of a sweep, then those of its reference."""
    from drysim.study.store import StoredBatches

    columns, batches = case_columns(table), batches_to_format(table.rows)
    as_text = partial(format_cases, columns)
    blocks: Iterator[bytes] = map(as_text, batches)
    if isinstance(batches, StoredBatches):
        blocks = batches.texts(as_text)
    write_csv(folder / "transmissibility.csv", [one.header for one in columns], blocks)


OBJECTIVE_COLUMNS = ("objective", "second_objective")
"""Columns of the objectives of a design over all its conditions, each in its own unit."""


def write_design_csv(result: DesignResult, folder: Path) -> None:
    """Write design.csv: every evaluated design, under each of its conditions."""
    from drysim.study.design import EVERY_SEED, limited_value

    rows = [row for one in result.candidates for row in one.rows]
    designs = [one for one in result.candidates for _ in one.rows]
    asked = {*requested_metrics(result.source)}
    named = dict.fromkeys((*result.design.minimise, *(one.metric for one in result.limits)))
    names = [*named, *(m.name for m in METRICS if m.in_tables and m.name in asked)]

    def of_design(name: str, unit: str, values: list[Any], whole: bool = False) -> Column:
        column = np.array(values, dtype=float)
        return Column(name, unit, lambda batch: column[batch.first :][: len(batch)], whole)

    keys = {key: unit for one in result.design.vary for key, unit in [(one.key, one.unit)]}
    columns = [
        of_design("design", "-", [one.number for one in designs], whole=True),
        *(key_column(key, unit) for key, unit in keys.items()),
        *(key_column(axis.key, axis.unit) for axis in result.case.scenario.sweep),
        *(
            of_design(name, METRIC_UNITS[metric], [one.objectives[i] for one in designs])
            for i, (name, metric) in enumerate(
                zip(OBJECTIVE_COLUMNS, result.design.minimise, strict=False)
            )
        ),
        of_design("excess", "-", [max(one.excess, default=0.0) for one in designs]),
        of_design("admissible", "-", [one.is_admissible for one in designs], whole=True),
        of_design("on_front", "-", [one in result.front for one in designs], whole=True),
        *map(metric_column, dict.fromkeys(names)),
        STATUS_COLUMN,
    ]
    if EVERY_SEED in result.limits:
        most = [limited_value(EVERY_SEED, row) for row in rows]
        columns.append(of_design("stroke_used_max", "-", most))
    if rows[0].over:
        columns += [SEEDS_COLUMN, *map(interval_column, named)]
    write_cases(folder / "design.csv", columns, rows)


def write_map_csv(result: RegimeMap, folder: Path) -> None:
    """Write map.csv: the points of each traced boundary, in order along its lines."""
    lines, numbers = result.boundaries, Counter[str]()
    names, counts, points = list[bytes](), list[bytes](), [np.empty((0, 2))]
    for line in lines:
        numbers[line.name] += 1
        names += [quote_cell(line.name).encode()] * len(line.points)
        counts += [b"%d" % numbers[line.name]] * len(line.points)
        points.append(line.points)
    rows = format_rows([names, counts, *np.concatenate(points).T])
    keys = [column_header(axis.key, axis.unit) for axis in result.axes]
    write_csv(folder / "map.csv", ["boundary", "line [-]", *keys], [rows])


def write_comparison_csv(result: Comparison, folder: Path) -> None:
    """Write comparison.csv: every case with every approach, and its deviation."""
    table = result.table
    found = [result.off(row) or (None, None) for row in table.rows]
    off = np.array(found, dtype=float).reshape(-1, 2)

    def deviation(name: str, at: int) -> Column:
        return Column(name, "-", lambda batch: off[batch.first :][: len(batch), at])

    columns = [*case_columns(table), deviation("T_a_deviation", 0)]
    if _has_means(table):
        columns.append(deviation("T_a_deviation_half_width", 1))
    if result.of_laws:
        laws = {name: law.encode() for name, law in result.laws.items()}
        columns.append(Column("law", "", lambda batch: [laws[batch.approach]] * len(batch)))
    write_cases(folder / "comparison.csv", columns, table.rows)


def write_case_violations_csv(table: Table, folder: Path) -> None:
    """Write stroke_violations.csv of a sweep, if the stroke limit was exceeded.

    The viscous reference is left out: it is not the seat under test.
    """
    own = table.own_tally
    if own is not None and own.beyond:
        keys = [key_column(axis.key, axis.unit) for axis in table.axes]
        _write_violations(folder, keys, table.rows, own.approach)


def write_ensemble_csv(result: Ensemble, folder: Path) -> None:
    """Write ensemble.csv: all metrics of every seed."""
    names = [name for name in requested_metrics(result.scenario) if name != "closure"]
    columns = [SEED_COLUMN, *map(metric_column, names), STATUS_COLUMN]
    write_cases(folder / "ensemble.csv", columns, result.rows)


def write_seed_violations_csv(result: Ensemble, folder: Path) -> None:
    """Write stroke_violations.csv: the seeds that exceed the stroke limit, if any."""
    if any(row.metrics.get("violations") for row in result.rows):
        _write_violations(folder, [SEED_COLUMN], result.rows, result.scenario.label)


def _write_violations(
    folder: Path, keys: Sequence[Column], rows: Sequence[Row], approach: str
) -> None:
    """Write stroke_violations.csv: the rows of one approach that exceed the stroke limit."""
    names = zip(VIOLATION_METRICS, VIOLATION_COLUMNS, strict=True)
    columns = [*keys, *(metric_column(metric, name) for metric, name in names)]
    write_cases(
        folder / "stroke_violations.csv",
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

    columns = case_columns(table)[1:]  # the approach is in the path
    if _has_means(table):  # a mean of counts may have decimals
        columns = [one._replace(whole=one.whole and _is_whole(one, table)) for one in columns]
    for batch in as_batches(table.rows):
        place = folder / PARQUET_FOLDER / f"approach={batch.approach}"
        place.mkdir(parents=True, exist_ok=True)
        file = place / f"{batch.first:012d}.parquet"
        pyarrow.parquet.write_table(_arrow_table(columns, batch), file)


def _is_whole(column: Column, table: Table) -> bool:
    """Whether all known numbers of a column are whole."""
    parts = (np.asarray(column.values(batch)) for batch in as_batches(table.rows))
    return all(bool(((part % 1 == 0) | np.isnan(part)).all()) for part in parts)


def _arrow_table(columns: Sequence[Column], batch: Batch) -> Any:
    """Return a batch as an Arrow table, the unit of each column in its metadata."""
    import pyarrow

    fields, arrays = [], []
    for name, unit, values_of, whole in columns:
        values, kind, missing = values_of(batch), pyarrow.string(), None
        if isinstance(values, np.ndarray):
            kind, missing = pyarrow.float64(), np.isnan(values)
            if whole or values.dtype.kind == "i":
                kind, values = pyarrow.int64(), np.where(missing, 0, values).astype(np.int64)
        fields.append(pyarrow.field(name, kind, metadata={"unit": unit or "-"}))
        arrays.append(pyarrow.array(values, kind, mask=missing))
    return pyarrow.table(arrays, schema=pyarrow.schema(fields))


# Benches.


BENCH_COLUMNS = ("step", "time_per_sample", "error_x_r", "error_T_a", "energy_residual")
LAST_BENCH_COLUMNS = ("time_over_lfilter", "samples", "repeats")
"""Columns of numbers, before and after the verdict."""


def write_speed_error_csv(bench: Bench, folder: Path) -> None:
    """Write speed_error.csv: a row per entry and case."""
    headers = [
        "approach", "setting", *map(column_header, BENCH_COLUMNS), "verdict",
        "case", *map(column_header, LAST_BENCH_COLUMNS),
    ]  # fmt: skip
    rows = []
    for panel in bench.cases:
        for one in panel.scores:
            before = (one.step, one.time, one.error_x_r, one.error_T_a, one.energy_residual)
            rows.append(
                [
                    one.approach,
                    quote_cell(one.setting),
                    *map(format_cell, before),
                    quote_cell(one.verdict),
                    panel.scenario.name,
                    *map(format_cell, (one.ratio, one.samples, one.repeats)),
                ]
            )
    write_csv(folder / "speed_error.csv", headers, [join_cells(rows)])


def write_hard_cases_csv(result: HardCases, folder: Path) -> None:
    """Write hard_cases.csv: a row per approach and case."""
    from drysim.bench.hard_cases import COMPARED_METRICS

    deviations = [f"{metric}_deviation" for metric in COMPARED_METRICS]
    numbers = [*deviations, "checks", "passed", "time"]
    headers = ["case", "approach", "verdict", "how", *map(column_header, numbers)]
    rows = []
    for case in result.cases:
        for one in case.results:
            off = [format_cell(one.deviations.get(metric)) for metric in COMPARED_METRICS]
            counts = [str(one.checks), str(one.passed), str(one.time)]
            words = [case.scenario.name, one.approach, one.verdict, quote_cell(one.reason)]
            rows.append([*words, *off, *counts])
    write_csv(folder / "hard_cases.csv", headers, [join_cells(rows)])


def quote_cell(words: str) -> str:
    """Return text as a CSV cell on one line, quoted if it has a comma or a quote."""
    words = _as_text(sanitise(" ".join(words.split())))
    return '"' + words.replace('"', '""') + '"' if set(words) & set(',"') else words


FORMULA_STARTS = "=", "+", "-", "@"
"""First characters of a cell that spreadsheets evaluate."""


def _as_text(cell: str) -> str:
    """Return text that no spreadsheet takes for a formula; a number stays as it is."""
    is_formula = cell.startswith(FORMULA_STARTS) and not NUMBER_PATTERN.fullmatch(cell)
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


def join_cells(rows: Iterable[Iterable[str]]) -> bytes:
    """Return rows of cells as CSV rows."""
    return "".join(f"{','.join(row)}\n" for row in rows).encode()
