"""From a record in a scenario to base motion, or to a normal force: samples in SI.

The file is read here and nowhere else. What it offers and what the scenario says of it give the
column of the samples, their unit and their clock; the series is cleaned as the record asks for,
cut to its window and, where it is a velocity or a displacement, made acceleration. Samples of
acceleration that count as they are stay in their file, however many they are.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drysim.core.model import Input, Pressure, Samples, Signal, blocks, moments
from drysim.errors import Caution, RecordError
from drysim.records import SI
from drysim.records.clean import (
    SPLINES,
    Ends,
    Grid,
    Report,
    Series,
    closed,
    cut,
    displacements,
    grid_of,
    low_pass,
    onto,
    span,
    target,
    thinned,
    told,
    without,
)
from drysim.records.columns import (
    Columns,
    Floats,
    TextFile,
    conversion,
    data_column,
    fault,
    missing_spacing,
    read,
    scaled,
    seconds,
)
from drysim.records.formats import SUFFIXES, format_of
from drysim.records.options import Recorded, RecordedMotion, Removal
from drysim.records.text import unquoted
from drysim.records.warnings import (
    clipped,
    ends_of_u,
    found,
    gravity_left,
    interpolated,
    interpolated_force,
    much_filled,
    much_lost,
)
from drysim.units import GREATEST, LEAST


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


def motion_of(record: RecordedMotion, ends: Ends = "even") -> Samples:
    """Give the base acceleration of a record; see `Record.motion` and `high_pass`."""
    shown, spline = str(record.path), SPLINES[record.quantity]
    with np.errstate(all="ignore"):  # what overflows is found by `_finite`
        (series, slow, reports, seen, own), source = _read(record, ends)
        _finite(series.values, series.dt, shown)
        first, last = span(series, record.window, shown)
        motion = spline(series)
        if slow and record.remove.below and motion.u is None:
            band = record.remove.below, record.remove.order
            u, other = displacements(spline(slow), *band)
            otherwise = cut(motion._replace(u=other), first, last, len(series.values)).u
            motion = motion._replace(u=u)
        else:
            otherwise = None
        motion = cut(motion, first, last, len(series.values))
        _finite(motion.u_dd, motion.dt, shown)
        level = moments(motion.u_dd)
        for sentence in gravity_left(record, level[0]):
            raise fault(shown, sentence)
        cautions = (
            *seen,
            *found(record, motion, level),
            *interpolated(record, motion, level[1], own),
            *ends_of_u(record, motion.u, otherwise),
        )
    realised: dict[str, object] = {} if record.scale == 1.0 else {"scale": record.scale}
    if reports:
        realised["clean_up"] = [one.told() for one in reports]
    return motion._replace(inputs=(source,), cautions=cautions, realised=realised)


def pressure_of(record: Recorded) -> Pressure:
    """Give the normal force of a record, relative to its mean.

    Raises
    ------
    RecordError
        When the record cannot be used, or its mean is not above zero.
    """
    shown = str(record.path)
    with np.errstate(all="ignore"):
        (series, _, reports, seen, _), source = _read(record)
        _finite(series.values, series.dt, shown, "the force")
        first, last = span(series, record.window, shown)
    values = np.array(series.values[first : last + 1])
    cautions = (*seen, *interpolated_force(record, values, series.dt))
    mean = float(values.mean())
    if not mean > 0.0:
        sentence = (
            f"the mean of the normal force is {mean:.6g} N; of surfaces that are pressed "
            "together it is above 0 N: check its sign (`scale: -1` turns it)"
        )
        raise fault(shown, sentence)
    told = tuple(one.told() for one in reports)
    return Pressure(values / mean, series.dt, mean, (source,), cautions, told)


def _finite(values: Signal, dt: float, shown: str, name: str = "ü") -> None:
    """Refuse numbers out of range; a NaN compares as false and is refused, too."""
    within = all(part.min() >= -GREATEST and part.max() <= GREATEST for part in blocks(values))
    if not (within and LEAST <= dt <= GREATEST):
        raise fault(shown, f"{name} is out of range: check unit, `scale` and time step")


def _read(record: Recorded, ends: Ends = "even") -> tuple[Cleaned, Input]:
    """The whole record; its bytes are let go before anything is made of the numbers."""
    file = read(record.path, SUFFIXES)
    source = Input(record.named, file.sha256, len(file.reader))
    member = format_of(record.file)
    assert member is not None  # `read` has made sure
    text = TextFile(file.shown, file.reader)
    try:
        columns = member.columns(replace(file, skip=record.skip))
        del file
        return _series(record, columns, ends), source
    except RecordError as error:
        if record.path.is_symlink():
            raise unquoted(error, text) from None
        raise


def _series(record: Recorded, columns: Columns, ends: Ends) -> Cleaned:
    """Give the samples that a record chooses in SI, on an even grid, cleaned as it asks for."""
    signal, grid, index = _read_series(record, columns)
    unit, shown = SI[record.measured], columns.shown
    cautions = list(clipped(record.named, signal, unit))
    asked = record.gaps or record.resample or record.remove.any
    if not asked and grid.at is None and record.measured == "acceleration":
        # The samples count as they are, so that they may stay in their file.
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
        rms = _rms(values, grid, before_filters, record.remove)
        cautions += much_lost(record, resampled, rms)
    reports = tuple(report for report in (filled, resampled, removed) if report)
    return Cleaned(series, slow, reports, tuple(cautions), grid.dt)


def _rms(values: Floats, grid: Grid, series: Series, removal: Removal) -> tuple[float, float]:
    """Return the RMS about the mean before and after resampling, behind a low-pass if any."""
    above, half = removal.above, 0.5 / max(grid.dt, series.dt)
    if above is None or grid.at is not None or not 1 / (len(values) * grid.dt) <= above < half:
        return float(values.std()), float(np.std(series.values[:]))
    before = low_pass(values, grid.dt, above, removal.order)
    after = low_pass(series.values[:], series.dt, above, removal.order)
    return float(before.std()), float(after.std())


def _read_series(record: Recorded, columns: Columns) -> tuple[Signal, Grid, int]:
    """The samples in SI, NaN where one is missing; where they lie, and their 0-based column."""
    time = None if record.time is None else columns.find(record.time)
    said = record.time or record.rate or record.step
    own = (columns.own(i) or columns.clock(i) is not None for i in columns.series())
    if not (said or any(own)):
        raise missing_spacing(columns)
    index = data_column(columns, record.column or record.channel, time)
    time, spacing = _clock(record, columns, index, time)
    unit = conversion(columns, index, record.unit, record.full_scale, record.measured)
    second = 1.0 if time is None else seconds(columns, time)
    wanted = [index] if time is None else [time, index]
    *times, values = columns.numbers(wanted, None if record.gaps is None else index)
    if len(values) < 2:
        raise columns.fault("the record has one sample only; motion needs two or more")
    values = scaled(values, unit * record.scale)
    if not times or time is None:
        return values, Grid(*spacing), index
    grid = grid_of(times[0][:], second, columns, time, may_jitter=record.resample is not None)
    return values, grid, index


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
