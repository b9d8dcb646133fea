"""Which column counts and in which unit, as file and scenario say together."""

from __future__ import annotations

from drysim.errors import RecordError
from drysim.excitation.record.columns import Columns, Label
from drysim.excitation.record.spoken import SI
from drysim.quantity import convert, factor, usual

TIME_NAMES = ("t", "time")

BLOCKS = {"force": "friction.normal_record"}
"""Where a scenario describes a record of a quantity; one of base motion in `excitation`."""


def data_column(columns: Columns, wanted: str | int | None, time: int | None) -> int:
    """Give the 0-based column of the samples.

    Raises
    ------
    RecordError
        When the column is not there, or none is named and there is more than one.
    """
    if wanted is not None:
        return columns.find(wanted)
    others = [i for i in columns.series() if i != time]
    if len(others) == 1:
        return others[0]
    if not others:
        raise columns.fault(f"there is no {columns.word} besides the time")
    way = "its name or number" if columns.labels else "its number"
    raise columns.fault(f"give `{columns.key}`, {way}; there are: {columns.names()}")


def conversion(
    columns: Columns, index: int, unit: str | None, full_scale: str | None, quantity: str
) -> float:
    """Give what one of a column's numbers is in SI, from the file, the scenario, or both.

    Raises
    ------
    RecordError
        When the unit is missing, unknown, of another quantity, or two are given that differ.
    """
    si, block = SI[quantity], BLOCKS.get(quantity, "excitation")
    place = f"in the scenario's `{block}` block"
    if columns.shares:
        if full_scale is None:
            instead = " in place of `unit`" if unit else ""
            sentence = "the samples are whole numbers, shares of a full scale without a unit"
            way = f"give `full_scale: 50 {si}`, say{instead}, {place}"
            raise columns.fault(f"{sentence}; {way}")
        return convert(full_scale, si)
    if full_scale is not None:
        sentence = "the samples are no shares of a full scale but floating-point numbers"
        raise columns.fault(f"{sentence}; give their `unit` in place of `full_scale`")
    return _unit(columns, index, unit, si, place)


def _unit(columns: Columns, index: int, unit: str | None, si: str, place: str) -> float:
    label = columns.labels[index] if columns.labels else None
    wanted = None if unit is None else _factor(columns, index, unit, si)
    if label is None or not label.unit:
        if wanted is not None:
            return wanted
        header = f", or `[{si}]` into the header" if columns.place == "header" else ""
        sentence = f"has no unit; write `unit: {si}` {place}{header}"
        raise columns.fault(f"{columns.called(index)} {sentence}", index)
    try:
        told = _factor(columns, index, label.unit, si)
    except RecordError as error:
        if label.firm or wanted is None:
            raise columns.fault(f"{error.message}{columns.way_round}", index) from None
        return wanted  # it may be a remark, as in `acc (filtered)`
    if wanted is not None and wanted != told:
        sentence = f"the {columns.place} says `{label.unit}`, the scenario says `unit: {unit}`"
        hint = f"; correct one of them{columns.way_round}"
        raise columns.fault(f"{columns.called(index)}: {sentence}{hint}", index)
    return told


def seconds(columns: Columns, index: int) -> float:
    """Give the unit of a column of times [s]; seconds when the file has none."""
    written = columns.labels[index].unit if columns.labels else ""
    return _factor(columns, index, written, "s") if written else 1.0


def missing_spacing(columns: Columns) -> RecordError:
    """Give the error for a record of which nobody said how its samples are spaced."""
    sentence = (
        "nothing says how the samples are spaced: "
        f"give `time` (a {columns.word}), `rate` or `step`"
    )
    for label in columns.labels:
        if _is_time(label):
            where = f"the {columns.place} has `{label.quote}`"
            sentence += f"; `time: {label.name}` is what is missing, as {where}"
            break
    return columns.fault(sentence)


def _is_time(label: Label) -> bool:
    """Tell whether a column holds times, by its unit, or by its name where it has no unit."""
    return usual(label.unit, "s") if label.unit else label.name.lower() in TIME_NAMES


def _factor(columns: Columns, index: int, written: str, si: str) -> float:
    try:
        return factor(written, si)
    except ValueError as error:
        raise columns.fault(f"{columns.called(index)}: {error}", index) from None
