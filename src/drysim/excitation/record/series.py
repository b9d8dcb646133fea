"""From what a file offers to the even series that a record chooses, cleaned as it asks for."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from drysim.core.signal import Signal
from drysim.errors import Caution
from drysim.excitation.record.cautions import clipped, much_filled, much_lost
from drysim.excitation.record.choice import (
    conversion,
    data_column,
    missing_spacing,
    seconds,
)
from drysim.excitation.record.columns import Columns, Floats
from drysim.excitation.record.filters import Ends, low_pass
from drysim.excitation.record.gaps import closed
from drysim.excitation.record.grid import Grid, grid_of
from drysim.excitation.record.removal import without
from drysim.excitation.record.reports import Report
from drysim.excitation.record.resampling import onto, target, thinned, told
from drysim.excitation.record.shape import Series
from drysim.excitation.record.spoken import SI, Removal
from drysim.excitation.record.stored import scaled

if TYPE_CHECKING:
    from drysim.excitation.record.recorded import Recorded


class Cleaned(NamedTuple):
    """A series, what was done to it on request, and what is to be warned of.

    `slow` is the series before a high-pass, None where there is none; `own` is the step of the
    samples in the file [s].
    """

    series: Series
    slow: Series | None
    reports: tuple[Report, ...]
    cautions: tuple[Caution, ...]
    own: float


def series_of(record: Recorded, columns: Columns, ends: Ends = "even") -> Cleaned:
    """Give the samples that a record chooses in SI, on an even grid, cleaned as it asks for.

    Raises
    ------
    RecordError
        When choice and file do not fit, or the samples are no even series of finite numbers and
        the record does not say what to do about that.
    """
    signal, grid, index = _read(record, columns)
    unit, shown = SI[record.measured], columns.shown
    cautions = list(clipped(record.named, signal, unit))
    if as_read(record, grid):
        return Cleaned(Series(signal, grid.dt, grid.first), None, (), tuple(cautions), grid.dt)
    goal = record.resample and target(record.resample, record.remove, grid, shown)
    values, grid, filled = closed(signal[:], grid, record.gaps, columns, index, unit)
    series, resampled = Series(values, grid.dt, grid.first), None
    if record.resample and goal:
        series = onto(values, grid, record.resample, goal, shown)
        resampled = told(values, grid, series, goal, record.resample, unit)
    before_filters, slow, removed = series, None, None
    if record.remove.any:
        series, slow, removed = without(series, record.remove, unit, shown, ends)
    if goal:
        series, slow = thinned(series, goal), slow and thinned(slow, goal)
    cautions += much_filled(record.named, filled, len(values))
    if resampled:
        rms = rms_of(values, grid, before_filters, record.remove)
        cautions += much_lost(record, resampled, rms)
    reports = tuple(report for report in (filled, resampled, removed) if report)
    return Cleaned(series, slow, reports, tuple(cautions), grid.dt)


def rms_of(values: Floats, grid: Grid, series: Series, removal: Removal) -> tuple[float, float]:
    """Return the RMS about the mean before and after resampling, behind a low-pass if any."""
    above, half = removal.above, 0.5 / max(grid.dt, series.dt)
    if above is None or grid.at is not None or not 1 / (len(values) * grid.dt) <= above < half:
        return float(values.std()), float(np.std(series.values[:]))
    before = low_pass(values, grid.dt, above, removal.order)
    after = low_pass(series.values[:], series.dt, above, removal.order)
    return float(before.std()), float(after.std())


def as_read(record: Recorded, grid: Grid) -> bool:
    """Tell whether samples count as they are, so that they may stay in their file."""
    asked = record.gaps or record.resample or record.remove.any
    return not asked and grid.at is None and record.measured == "acceleration"


def _read(record: Recorded, columns: Columns) -> tuple[Signal, Grid, int]:
    """The samples in SI, NaN where one is missing; where they lie, and their 0-based column."""
    time = None if record.time is None else columns.find(record.time)
    if not _spaced(record, columns):
        raise missing_spacing(columns)
    index = data_column(columns, record.column or record.channel, time)
    time, own = _clock(record, columns, index, time)
    unit = conversion(columns, index, record.unit, record.full_scale, record.measured)
    second = 1.0 if time is None else seconds(columns, time)
    wanted = [index] if time is None else [time, index]
    *times, values = columns.numbers(wanted, None if record.gaps is None else index)
    if len(values) < 2:
        raise columns.fault("the record has one sample only; motion needs two or more")
    values = scaled(values, unit * record.scale)
    if not times or time is None:
        return values, Grid(*own), index
    grid = grid_of(times[0][:], second, columns, time, may_jitter=record.resample is not None)
    return values, grid, index


def _spaced(record: Recorded, columns: Columns) -> bool:
    """Whether scenario or file says how the samples of any column are spaced."""
    said = record.time or record.rate or record.step
    own = (columns.own(i) or columns.clock(i) is not None for i in columns.series())
    return bool(said) or any(own)


def _clock(
    record: Recorded, columns: Columns, index: int, time: int | None
) -> tuple[int | None, tuple[float, float]]:
    """The column of the times, or else the step and the first time [s]."""
    own = columns.own(index)
    said = next((key for key in ("time", "rate", "step") if getattr(record, key)), None)
    if own is not None:
        if said is not None:
            sentence = f"{columns.called(index)} knows the step of its samples"
            raise columns.fault(f"{sentence}, {own[0]:.6g} s; remove `{said}`")
        return None, own
    if said is None:
        time = columns.clock(index)
        if time is None:
            raise missing_spacing(columns)
    return time, (record.step or 1 / (record.rate or 1.0), 0.0)
