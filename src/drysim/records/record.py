"""From a record of a scenario to base motion or normal force: samples in SI on an even grid.

File and scenario together determine the column of the samples, its unit and the time step. The
samples are cleaned as requested, cut to the window, and velocity or displacement is
differentiated. Unprocessed acceleration samples stay in the file and are read block by block,
so that a record may be larger than memory.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from math import ceil, floor
from typing import NamedTuple

import numpy as np

from drysim.core.model import Floats, Input, NormalForceRecord, Samples, Signal, blocks
from drysim.errors import RecordError, WarningMessage
from drysim.quantity import MAX_MAGNITUDE, MIN_MAGNITUDE
from drysim.records import SI
from drysim.records.artefacts import indices_of, missing_code
from drysim.records.clean import (
    TO_ACCELERATION,
    CleaningReport,
    Extension,
    Series,
    TimeGrid,
    cut_window,
    decimate,
    displacements,
    fill_gaps,
    fit_grid,
    low_pass,
    remove,
    resample_onto,
    resampling_grid,
    window_range,
)
from drysim.records.columns import (
    ALL_ROWS,
    Columns,
    RecordFile,
    RowSelection,
    TextFile,
    column_factor,
    data_column,
    missing_spacing_error,
    record_error,
    scaled,
    slice_signal,
    unit_factor,
)
from drysim.records.formats import open_with_format
from drysim.records.layout import lower_header_error, row_warnings
from drysim.records.level import GRAVITY, Level, measure_level
from drysim.records.options import (
    NOTHING,
    RatioTable,
    Recorded,
    RecordedMotion,
    Removal,
    Window,
)
from drysim.records.text import EMPTY_ROW_HINT, MISSING_TIME_HINT, NO_SAMPLE, redact_quotes
from drysim.records.warnings import (
    artefact_warnings,
    check_gravity,
    displacement_warnings,
    filling_warnings,
    force_warnings,
    interpolation_warnings,
    mean_warnings,
    resampling_warnings,
    rising_warnings,
    strength_warnings,
    unit_warnings,
    vertical_warnings,
)
from drysim.wording import format_count


class CleanedRecord(NamedTuple):
    """A cleaned record with reports and warnings.

    `before_high_pass` is the series before a high-pass, None without one. `file_spacing` is the
    time step of the file [s]. `level` is that before the clean-up; None if nothing was cleaned.
    """

    series: Series
    before_high_pass: Series | None
    reports: tuple[CleaningReport, ...]
    warnings: tuple[WarningMessage, ...]
    file_spacing: float
    level: Level | None = None


def read_motion(record: RecordedMotion, ends: Extension = "even") -> Samples:
    """Return the base acceleration of a record; `ends` as in `high_pass`.

    It has displacement, reports and warnings where there are any.

    Raises
    ------
    RecordError
        If the file cannot be read, or its samples cannot be used.
    """
    display_path, spline = str(record.path), TO_ACCELERATION[record.quantity]
    with np.errstate(all="ignore"):  # `_check_range` detects overflow
        cleaned, source = _read_record(record, ends)
        series, before_high_pass, reports, seen, file_spacing, level_before = cleaned
        _check_range(series.values, series.dt, display_path)
        first, last = window_range(series, record.window, display_path)
        motion = spline(series)
        if before_high_pass and record.remove.below and motion.u is None:
            band = record.remove.below, record.remove.order
            u, other = displacements(spline(before_high_pass), *band)
            otherwise = cut_window(motion._replace(u=other), first, last, len(series.values)).u
            motion = motion._replace(u=u)
        else:
            otherwise = None
        whole = motion.u_dd
        motion = cut_window(motion, first, last, len(series.values))
        _check_range(motion.u_dd, motion.dt, display_path)
        level = measure_level(motion.u_dd, whole)
        check_gravity(record, level)
        rms = level.spread
        is_of_acceleration = record.quantity == "acceleration" and not record.window
        if level_before and any(level_before.padding) and is_of_acceleration:
            level = level_before  # a trend and a filter make the edge of the zeros a motion
        wrong_unit = tuple(unit_warnings(record, level_before or level))
        warnings = (
            *seen,
            *(wrong_unit or mean_warnings(record, motion, level)),
            *strength_warnings(record, motion.u_dd, motion.dt, level),
            *interpolation_warnings(record, motion, rms, file_spacing),
            *displacement_warnings(record, motion.u, otherwise),
        )
    realised: dict[str, object] = {} if record.scale == 1.0 else {"scale": record.scale}
    if reports:
        realised["clean_up"] = [report.to_dict() for report in reports]
    return motion._replace(inputs=(source,), warnings=warnings, realised=realised)


def read_normal_force(record: Recorded) -> NormalForceRecord:
    """Read the normal force of a record: of forces, relative to their mean.

    That of a vertical acceleration z̈ is 1 + z̈/g, relative to the weight of the mass.

    Raises
    ------
    RecordError
        If the record cannot be used, the mean of forces is not above zero, or an acceleration
        contains gravity.
    """
    display_path = str(record.path)
    is_force = record.quantity == "force"
    cleaned, source = _read_window(record, "the force" if is_force else "z̈")
    values, dt = cleaned.series.values[:], cleaned.series.dt
    warnings, mean = cleaned.warnings, float(values.mean())
    if not is_force:
        warnings += (*vertical_warnings(record, mean),)
        values = GRAVITY + values
    warnings += (*force_warnings(record, values, dt),)
    clean_up = tuple(report.to_dict() for report in cleaned.reports)
    if not is_force:
        return NormalForceRecord(values / GRAVITY, dt, None, (source,), warnings, clean_up)
    if not mean > 0.0:
        sentence = (
            f"the mean of the normal force is {mean:.6g} N; it must be "
            "positive (compression): check the sign (`scale: -1` reverses it)"
        )
        raise record_error(display_path, sentence)
    return NormalForceRecord(values / mean, dt, mean, (source,), warnings, clean_up)


def read_series(record: Recorded) -> tuple[CleanedRecord, Input]:
    """Read a record as measured: samples of its window in SI, not differentiated.

    Returns
    -------
    cleaned : CleanedRecord
        The first time of its series is that of the first sample in the window.
    source : Input

    Raises
    ------
    RecordError
        If the record cannot be used.
    """
    cleaned, source = _read_window(record, "a sample")
    series, warnings = cleaned.series, cleaned.warnings
    if record.quantity == "acceleration":
        level = measure_level(series.values)
        warnings += (*strength_warnings(record, series.values, series.dt, level),)
    return cleaned._replace(warnings=warnings), source


def _read_window(record: Recorded, name: str) -> tuple[CleanedRecord, Input]:
    """Return a record cut to its window; `name` is that of a sample in messages."""
    display_path = str(record.path)
    with np.errstate(all="ignore"):
        cleaned, source = _read_record(record)
        series = cleaned.series
        _check_range(series.values, series.dt, display_path, name)
        first, last = window_range(series, record.window, display_path)
    values = np.array(series.values[first : last + 1])
    window = Series(values, series.dt, series.first + first * series.dt)
    return cleaned._replace(series=window), source


def read_samples(record: Recorded) -> tuple[Floats, Floats]:
    """Return times [s] and samples in SI as they stand in the file, evenly spaced or not.

    Samples that are missing or outside the window are left out; nothing is resampled.

    Raises
    ------
    RecordError
        If the record cannot be used.
    """
    with np.errstate(all="ignore"), _open_columns(record) as (columns, _):
        signal, grid, _ = _read_series(record, columns)
        values = np.array(signal[:], dtype=np.float64)
    t = grid.first + grid.dt * grid.positions(len(values))
    low, high = (-np.inf, np.inf) if record.window is None else record.window.ends
    used = np.isfinite(values) & (t >= low) & (t <= high)
    _check_range(values[used], grid.dt, str(record.path), "a sample")
    return t[used], values[used]


class Ratios(NamedTuple):
    """A column of ratios over frequency: the rows that have both."""

    frequency: Floats
    """Frequencies [Hz], as in the file."""
    values: Floats
    """Ratios [-]."""
    resolution: float
    """Unit of the last printed digit [-]; 0 for binary numbers."""
    column: int
    """0-based column of the file."""


def read_ratios(
    table: RatioTable, names: Sequence[str | int]
) -> tuple[tuple[Ratios, ...], Input]:
    """Read columns of ratios over frequency; rows with an empty cell are left out.

    Raises
    ------
    RecordError
        If the file cannot be read, a ratio is text, or it or a frequency is not above zero.
    """
    ratios = []
    with _open_columns(table) as (columns, file):
        f = columns.find(table.frequency)
        hertz = unit_factor(columns, f, None if columns.labels[f].unit else "Hz", "Hz", "")
        for name in names:
            index = columns.find(name)
            if index == f:
                sentence = f"{columns.describe_column(index)} is both frequency and ratio"
                raise columns.error(f"{sentence}; there are: {columns.names()}")
            if columns.labels[index].unit == "dB":
                sentence = "is in dB: write the ratio, 10^(dB/20)"
                raise columns.error(f"{columns.describe_column(index)} {sentence}", index)
            unit = None if columns.labels[index].unit else "-"
            scale = unit_factor(columns, index, unit, "", "")
            try:
                frequency, values = (series[:] for series in columns.numbers([f, index], index))
            except RecordError as error:
                raise _row_to_delete(error) from None
            used = np.isfinite(values)
            for row, text in enumerate(() if used.all() else columns.texts(index)):
                if text and not used[row]:
                    sentence = f"`{text}` is not a number; leave the cell empty if it has none"
                    raise columns.error_at(row, index, sentence)
            for column, series in ((f, frequency), (index, values)):
                for row in np.flatnonzero(used & ~(series > 0.0))[:1].tolist():
                    what = "a frequency" if column == f else "a ratio of RMS values"
                    hint = "" if column == f else "; of values in dB write 10^(dB/20)"
                    if column != f and series[row] == 0.0:
                        hint = "; leave the cell empty where the mass sticks"
                    sentence = f"{what} must be above 0, not {float(series[row]):.6g}{hint}"
                    raise columns.error_at(row, column, sentence)
            resolution = scale * columns.printed_resolution(index)
            ratios.append(
                Ratios(hertz * frequency[used], scale * values[used], resolution, index)
            )
        return tuple(ratios), Input(table.named, file.sha256, len(file.reader))


def _row_to_delete(error: RecordError) -> RecordError:
    """Return the error of a damaged row with the remedy of a table: it has no gaps to fill."""
    for remedy in (NO_SAMPLE, f": {MISSING_TIME_HINT}", f": {EMPTY_ROW_HINT}"):
        fault, mark, _ = error.message.partition(remedy)
        if mark:
            return RecordError(replace(error.problem, sentence=f"{fault}; delete the row"))
    return error


def _check_range(values: Signal, dt: float, display_path: str, name: str = "ü") -> None:
    """Raise for samples out of range; NaN fails the comparison, too."""
    within = all(
        part.min() >= -MAX_MAGNITUDE and part.max() <= MAX_MAGNITUDE for part in blocks(values)
    )
    if not (within and MIN_MAGNITUDE <= dt <= MAX_MAGNITUDE):
        raise record_error(
            display_path, f"{name} is out of range: check unit, `scale` and time step"
        )


def find_column(record: Recorded) -> tuple[int, str]:
    """Return the 0-based column of a record in its file, and its number with its name.

    Raises
    ------
    RecordError
        If the file cannot be read, or has no such column.
    """
    with _open_columns(record) as (columns, _):
        index = _find_columns(record, columns)[0]
        return index, columns.describe_column(index)


@contextmanager
def _open_columns(record: Recorded | RatioTable) -> Iterator[tuple[Columns, RecordFile]]:
    """Open the file of a record; errors about a symbolic link quote no line of its target."""
    file, member = open_with_format(record.path)
    try:
        wanted = record.rows
        rows = RowSelection(wanted.start, wanted.to, wanted.where) if wanted else ALL_ROWS
        yield member.columns(replace(file, skip=record.skip, rows=rows)), file
    except RecordError as error:
        if lower_header := lower_header_error(error, file, member, record.skip):
            raise lower_header from None
        if not record.path.is_symlink():
            raise
        raise redact_quotes(error, TextFile(file.display_path, file.reader)) from None


def _read_record(record: Recorded, ends: Extension = "even") -> tuple[CleanedRecord, Input]:
    """Read and clean the whole record."""
    with _open_columns(record) as (columns, file):
        cleaned = _clean_series(record, columns, ends)
        return cleaned, Input(record.named, file.sha256, len(file.reader))


def _clean_series(record: Recorded, columns: Columns, ends: Extension) -> CleanedRecord:
    """Return the samples of the selected column in SI, evenly spaced, cleaned as requested."""
    signal, grid, index = _read_series(record, columns)
    unit, display_path = SI[record.quantity], columns.display_path
    used = _used(signal, grid, record.window)
    part = slice_signal(signal, *used)
    warnings = [*row_warnings(record, columns)]
    if len(part):
        warnings += artefact_warnings(record, part, used[0], unit)
    if record.quantity == "acceleration":
        warnings += rising_warnings(record, signal, columns.describe_column(index))
    may_miss = record.gaps or record.missing not in (None, NOTHING)
    requested = may_miss or record.resample or record.remove.any
    is_plain = not requested and grid.offsets is None and record.quantity == "acceleration"
    if is_plain and not (
        record.window and any(np.isnan(part).any() for part in blocks(signal))
    ):
        # Unprocessed samples can stay in the file.
        return CleanedRecord(
            Series(signal, grid.dt, grid.first), None, (), tuple(warnings), grid.dt
        )
    target = record.resample and resampling_grid(
        record.resample, record.remove, grid, display_path
    )
    values, grid, count, reports = fill_gaps(
        signal[:], grid, record.gaps, record.window, columns, index, unit
    )
    warnings += filling_warnings(record.named, reports, count, unit)
    series, before_high_pass = Series(values, grid.dt, grid.first), None
    if target:
        series, report = resample_onto(values, grid, target, unit, display_path)
        reports = (*reports, report)
        rms = _rms_before_and_after(values, grid, series, record.remove)
        warnings += resampling_warnings(record, report, rms)
    if record.remove.any:
        series, before_high_pass, report = remove(
            series, record.remove, unit, display_path, ends
        )
        reports = (*reports, report)
    if target:
        series = decimate(series, target)
        before_high_pass = before_high_pass and decimate(before_high_pass, target)
    level = measure_level(values)
    return CleanedRecord(series, before_high_pass, reports, tuple(warnings), grid.dt, level)


def _used(signal: Signal, grid: TimeGrid, window: Window | None) -> tuple[int, int]:
    """Return the range of the samples in the window, the last one excluded."""
    if window is None:
        return 0, len(signal)
    if grid.offsets is None:
        steps = ((end - grid.first) / grid.dt for end in window.ends)
        first, last = (min(max(end, 0.0), float(len(signal))) for end in steps)
        return ceil(first), min(floor(last) + 1, len(signal))
    low, high = ((end - grid.first) / grid.dt for end in window.ends)
    return int(np.searchsorted(grid.offsets, low)), int(
        np.searchsorted(grid.offsets, high, "right")
    )


def _rms_before_and_after(
    values: Floats, grid: TimeGrid, series: Series, removal: Removal
) -> tuple[float, float]:
    """Return the RMS about the mean before and after resampling, low-passed if requested."""
    above, half = removal.above, 0.5 / max(grid.dt, series.dt)
    if (
        above is None
        or grid.offsets is not None
        or not 1 / (len(values) * grid.dt) <= above < half
    ):
        return float(values.std()), float(np.std(series.values[:]))
    before = low_pass(values, grid.dt, above, removal.order)
    after = low_pass(series.values[:], series.dt, above, removal.order)
    return float(before.std()), float(after.std())


def _read_series(record: Recorded, columns: Columns) -> tuple[Signal, TimeGrid, int]:
    """Return samples in SI (NaN where missing), their time grid and the 0-based column."""
    spacing_key = record.time or record.rate or record.step
    file_spacing = (
        columns.file_spacing(i) or columns.time_column(i) is not None for i in columns.series()
    )
    if not (spacing_key or any(file_spacing)):
        raise missing_spacing_error(columns)
    index, time = _find_columns(record, columns)
    time, spacing = _sample_times(record, columns, index, time)
    options = record.unit, record.full_scale, record.quantity, record.block
    unit = column_factor(columns, index, *options)
    # Gaps outside the window are no fault; `fill_gaps` reports those in it.
    may_miss = record.gaps is not None or record.window is not None
    gap_column, times = index if may_miss else None, None
    if time is None:
        [values] = columns.numbers([index], gap_column)
    else:
        stated = record.time_unit or ""
        times, [values] = columns.with_times(time, [index], gap_column, stated)
    if len(values) < 2:
        raise columns.error("the record has one sample only; motion needs two or more")
    values = _without_codes(record, columns, index, values)
    values = scaled(values, unit * record.scale)
    if times is None or time is None:
        return values, TimeGrid(*spacing), index
    may_jitter, fill = record.resample is not None, "line"
    if record.quantity == "displacement":
        fill = "spline"
    grid = fit_grid(times, columns, time, may_jitter, fill)
    if index == time:
        sentence = f"{columns.describe_column(index)} is both `time` and `{columns.key}`"
        raise columns.error(f"{sentence}: select the samples; there are: {columns.names()}")
    return values, grid._replace(column=time), index


def _find_columns(record: Recorded, columns: Columns) -> tuple[int, int | None]:
    """Return the 0-based columns of the samples and, if the record names it, of the times."""
    time = None if record.time is None else columns.find(record.time)
    return data_column(columns, record.column or record.channel, time), time


def _without_codes(record: Recorded, columns: Columns, index: int, values: Signal) -> Signal:
    """Return samples without those that stand for missing ones, which become NaN.

    Raises
    ------
    RecordError
        If there are such samples, and the scenario does not say what they are.
    """
    if record.missing == NOTHING or columns.normalised:
        return values
    if isinstance(record.missing, float):
        samples = np.array(values[:])
        samples[samples == record.missing] = np.nan
        return samples
    code = missing_code(values)
    if code is None:
        return values
    rows = indices_of(values, code)
    raise columns.error_at(
        int(rows[0]),
        index,
        f"{code:g}, as in {format_count(len(rows), 'row')}, is far outside the range of all "
        f"other samples and looks like the code of a missing one: `missing: {code:g}` leaves "
        "it out (`gaps` then fills it), `missing: nothing` takes it as a sample",
    )


def _sample_times(
    record: Recorded, columns: Columns, index: int, time: int | None
) -> tuple[int | None, tuple[float, float]]:
    """Return the column of the times, or else time step and first time [s]."""
    file_spacing = columns.file_spacing(index)
    spacing_key = next((key for key in ("time", "rate", "step") if getattr(record, key)), None)
    if file_spacing is not None:
        if spacing_key is not None:
            sentence = f"{columns.describe_column(index)} has a time step of its own"
            raise columns.error(f"{sentence}, {file_spacing[0]:.6g} s; remove `{spacing_key}`")
        return None, file_spacing
    if spacing_key is None:
        time = columns.time_column(index)
        if time is None:
            raise missing_spacing_error(columns)
    return time, (record.step or 1 / (record.rate or 1.0), 0.0)
