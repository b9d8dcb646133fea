"""From what a file offers to the series that a record chooses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drysim.excitation.record.choice import conversion, data_column, missing_spacing, seconds
from drysim.excitation.record.columns import Columns
from drysim.excitation.record.grid import spacing
from drysim.excitation.record.shape import Series

if TYPE_CHECKING:
    from drysim.excitation.record import Record


def series_of(record: Record, columns: Columns) -> Series:
    """Give the samples that a record chooses in SI, their step and the time of the first.

    Raises
    ------
    RecordError
        When choice and file do not fit, or the samples are no even series of finite numbers.
    """
    time = None if record.time is None else columns.find(record.time)
    index = data_column(columns, record.column or record.channel, time)
    time, own = _clock(record, columns, index, time)
    unit = conversion(columns, index, record.unit, record.full_scale, record.quantity)
    second = 1.0 if time is None else seconds(columns, time)
    *times, values = columns.numbers([index] if time is None else [time, index])
    if len(values) < 2:
        raise columns.fault("the record has one sample only; motion needs two or more")
    values *= unit * record.scale
    if times and time is not None:
        step = spacing(times[0], second, columns, time)
        return Series(values, step, float(times[0][0]) * second)
    return Series(values, *own)


def _clock(
    record: Record, columns: Columns, index: int, time: int | None
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
