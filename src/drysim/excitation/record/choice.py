"""Which column counts and in which unit, as file and scenario say together."""

from __future__ import annotations

from drysim.errors import RecordError
from drysim.excitation.record.lines import name_and_unit
from drysim.excitation.record.table import Table
from drysim.quantity import factor

SI = {"acceleration": "m/s²", "velocity": "m/s", "displacement": "m"}
"""The unit of ü, u̇ and u."""

TIME_NAMES = ("t", "time")


def data_column(table: Table, wanted: str | int | None, time: int | None) -> int:
    """Give the 0-based column of the samples.

    Raises
    ------
    RecordError
        When the column is not there, or none is named and there is more than one.
    """
    if wanted is not None:
        return table.find(wanted)
    others = [i for i in range(table.width) if i != time]
    if len(others) == 1:
        return others[0]
    if not others:
        raise table.fault("there is no column besides the time")
    way = "its name or number" if table.header else "its number"
    raise table.fault(f"give `column`, {way}; there are: {table.names()}")


def conversion(table: Table, index: int, unit: str | None, quantity: str) -> float:
    """Give what one of a column's unit is in SI, from the header, the scenario, or both.

    Raises
    ------
    RecordError
        When the unit is missing, unknown, of another quantity, or two are given that differ.
    """
    si = SI[quantity]
    written, square = _unit(table, index)
    wanted = None if unit is None else _factor(table, index, unit, si)
    if not written:
        if wanted is not None:
            return wanted
        sentence = (
            f"has no unit; write `unit: {si}` in the scenario or `[{si}]` into the header"
        )
        raise table.fault(f"{table.called(index)} {sentence}", index)
    try:
        told = _factor(table, index, written, si)
    except RecordError:
        if square or wanted is None:
            raise
        return wanted  # round brackets may hold a remark: `acc (filtered)`
    if wanted is not None and wanted != told:
        sentence = f"the header says `{written}`, the scenario says `unit: {unit}`"
        raise table.fault(f"{table.called(index)}: {sentence}; correct one of them", index)
    return told


def seconds(table: Table, index: int) -> float:
    """Give the unit of a time column [s]; seconds when its header has none."""
    written, _ = _unit(table, index)
    return _factor(table, index, written, "s") if written else 1.0


def missing_spacing(table: Table) -> RecordError:
    """Give the error for a record of which nobody said how its samples are spaced."""
    sentence = (
        "nothing says how the samples are spaced: give `time` (a column), `rate` or `step`"
    )
    for cell in table.header:
        name, unit, _ = name_and_unit(cell.text)
        if name.lower() in TIME_NAMES and unit in ("", "s"):
            sentence += f"; `time: {name}` is what is missing, as the header has `{cell.quote}`"
            break
    return table.fault(sentence)


def _unit(table: Table, index: int) -> tuple[str, bool]:
    """The unit in a column's header, and whether it stands in square brackets."""
    return name_and_unit(table.header[index].text)[1:] if table.header else ("", False)


def _factor(table: Table, index: int, written: str, si: str) -> float:
    try:
        return factor(written, si)
    except ValueError as error:
        raise table.fault(f"{table.called(index)}: {error}", index) from None
