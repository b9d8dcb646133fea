"""What an unknown record file contains: proposed keys of a scenario, each with its reason.

A logger file rarely says all that a scenario must state. Where its header, its times and its
statistics show an answer, that is proposed together with the observation; a proposal that is
not certain is marked as such. Where they show none, the proposed key has no value: the user
has to decide, and validation of the scenario reports the key until then.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime
from itertools import islice
from math import ceil
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drysim.errors import RecordError
from drysim.records import SI
from drysim.records.clean import MIN_GAP_STEPS, TimeGrid, fit_grid, mean_rate
from drysim.records.columns import Columns, Floats, time_factor
from drysim.records.formats import open_with_format
from drysim.records.level import Level, measure_level
from drysim.records.options import LARGE_MEAN, SUGGESTED_HIGH_PASS
from drysim.records.text import (
    MAX_ROWS_EXAMINED,
    MISSING,
    TIME_OF_DAY,
    TextTable,
    end_of_rows,
    is_number,
    split_cells,
)
from drysim.records.warnings import describe_wrong_unit
from drysim.units import conversion_factor, is_common_unit
from drysim.wording import format_count, format_number

MAX_BYTES = 1 << 26
"""Bytes of a text file that are inspected; what follows is left to validation."""

NAMES_OF_TIME = re.compile(
    r"(?i)(t|time(stamp)?|elapsed|seconds?|sec|zeit|temps|tiempo|tempo)(?![a-z]).*"
)
NAMES_OF_BASE = re.compile(r"(?i).*(base|floor|ground|platform|chassis|boden|plancher).*")
NAMES_OF_VERTICAL = re.compile(r"(?i).*(?<![a-z])((a|acc)?_?z|vert[a-z]*)(?![a-z]).*")

NAMES_OF_ACCELERATION = re.compile(
    r"(?i).*(acc|beschl|accél|g-?force|u_dd|ü).*|(a|lin)?[ _-]?[axyz]([ _-](axis|achse))?"
)
"""Names that make a mean of 9.81, 1 or 1000 gravity; a mean alone does not."""

AXES = 3
"""Columns without names that may be the axes of an accelerometer."""

LONG_STEP = 0.1
"""Times without a unit that advance by more than this [s] are not taken as seconds: vibration
is not recorded at less than 10 Hz."""

SHORT_GAP = 0.05
"""Longest gap [s] whose interpolation is proposed without a question."""

PERIODS_OF_HIGH_PASS = 10
"""A high-pass is proposed for records of at least this many of its periods: within one period
of either end its output depends on how the record is continued."""

MAX_LISTED = 8
"""Columns that a reason names."""

MIN_ROWS = 2
"""Rows from which a time step follows."""

MAX_LINE = 10_000
"""Bytes at the end of a file in which its last row is looked for."""

DELIMITERS = {"\t": "tabs", ";": "semicolons", ",": "commas", "": "blanks"}


class Proposal(NamedTuple):
    """A key of the excitation block; without a value where the file shows no answer.

    `is_certain` is false for a guess.
    """

    key: str
    value: object
    reason: str
    is_certain: bool = True


class ColumnSummary(NamedTuple):
    """0-based number, label and unit of a column, and its statistics in that unit."""

    column: int
    name: str
    unit: str
    level: Level
    smallest: float
    largest: float
    missing: int


class Inspection(NamedTuple):
    """What was found: the layout in words, the columns of samples, and the proposals."""

    layout: tuple[str, ...]
    columns: tuple[ColumnSummary, ...]
    proposals: tuple[Proposal, ...]


@np.errstate(all="ignore")  # overflow shows in the statistics
def inspect_record(path: Path) -> Inspection:
    """Return what a record file contains, and the keys that a scenario needs to read it.

    Raises
    ------
    RecordError
        If the file cannot be read, or contains no rows or channels of numbers.
    """
    skip, columns = _find_columns(path)
    proposals, layout = [], [_describe_layout(columns)]
    if skip:
        proposals.append(Proposal("skip", skip, "rows above the header or the first numbers"))
    columns, is_whole = _first_part(columns)
    if not is_whole:
        layout.append(f"only the first {MAX_BYTES / 1e6:.0f} MB were inspected")
    values: dict[int, Floats] = {}
    for index in columns.series():
        try:
            values[index] = columns.numbers([index], index)[0][:]
        except RecordError as error:
            layout.append(f"left out: {error.message}")
    if not values:
        raise columns.error("; ".join([f"there is no {columns.word} of numbers", *layout[1:]]))
    time, grid, of_time = _propose_times(columns, values)
    summaries = [_summarise(columns, i, x) for i, x in values.items() if i != time]
    if not summaries:
        raise columns.error(f"there is no {columns.word} of numbers besides the time")
    count = max(len(values[one.column]) for one in summaries)
    rate = "" if grid is None else f" at {1 / grid.dt:.6g} Hz, {count * grid.dt:.4g} s"
    layout.insert(1, format_count(count, "sample") + rate)
    is_choice = len(columns.series()) > 1 + any(one.key == "time" for one in of_time)
    chosen, measured, of_column = _propose_column(columns, summaries, is_choice)
    proposals += of_time + of_column
    layout += (sentence for one in summaries for sentence in _suspect_unit(columns, one))
    if chosen is not None:
        proposals += _propose_clean_up(values[chosen.column], grid, chosen, measured)
    return Inspection(tuple(layout), tuple(summaries), tuple(proposals))


def _find_columns(path: Path) -> tuple[int, Columns]:
    """Return the rows to skip, and the columns below them."""
    file, member = open_with_format(path)
    try:
        columns = member.columns(file)
        fault = None if _has_numbers(columns) else columns.error("there are no rows of numbers")
    except RecordError as error:
        fault = error
    if fault is None:
        return 0, columns
    if "skip" not in member.unused_keys:
        for skip in range(1, MAX_ROWS_EXAMINED):
            try:
                columns = member.columns(replace(file, skip=skip))
            except RecordError:
                continue
            if _has_numbers(columns):
                return skip, columns
    raise fault


def _has_numbers(columns: Columns) -> bool:
    """Whether the first rows of a text table have numbers in the same columns throughout."""
    if not isinstance(columns, TextTable):
        return True
    rows = [cells for _, cells in islice(columns.rows(), MAX_ROWS_EXAMINED) if cells]
    if not rows or any(len(cells) != columns.width for cells in rows):
        return False
    first, last = (
        {i for i, cell in enumerate(cells) if is_number(cell) or MISSING.fullmatch(cell.text)}
        for cells in (rows[0], rows[-1])
    )
    return bool(last) and last <= first


def _first_part(columns: Columns) -> tuple[Columns, bool]:
    """Return the columns of the first rows of a large text file, and whether it is whole."""
    if not isinstance(columns, TextTable) or len(columns.file.text) <= MAX_BYTES:
        return columns, True
    part = columns.file.text[:MAX_BYTES]
    part = part[: part.rfind(b"\n") + 1]
    return replace(columns, file=columns.file._replace(text=part)), False


def _describe_layout(columns: Columns) -> str:
    """Return how the file is laid out."""
    if not isinstance(columns, TextTable):
        return format_count(columns.width, columns.word)
    comma = ", decimal commas" if columns.decimal(columns.series()) == "," else ""
    header = f"header in row {columns.header_line}" if columns.header_line else "no header"
    delimiter = f"delimited by {DELIMITERS[columns.delimiter]}{comma}"
    return f"{format_count(columns.width, 'column')} {delimiter}, {header}"


def _summarise(columns: Columns, index: int, x: Floats) -> ColumnSummary:
    """Return the statistics of a column."""
    there = x[~np.isnan(x)]
    level = measure_level(there) if len(there) else Level(np.nan, np.nan, np.nan)
    return ColumnSummary(
        index,
        columns.labels[index].name,
        columns.labels[index].unit,
        level,
        float(there.min(initial=np.inf)),
        float(there.max(initial=-np.inf)),
        len(x) - len(there),
    )


def _identify(columns: Columns, index: int) -> str | int:
    """Return the name of a column, or its number from 1 if that alone is unique."""
    names = [label.name for label in columns.labels]
    name = names[index]
    return name if name and names.count(name) == 1 else index + 1


# Times.


class Times(NamedTuple):
    """Column of the times and their grid, None where unknown, and the keys that state them."""

    column: int | None
    grid: TimeGrid | None
    proposals: list[Proposal]


def _propose_times(columns: Columns, values: dict[int, Floats]) -> Times:
    """Return what is known of the times."""
    for index in values:
        if (spacing := columns.file_spacing(index)) is not None:
            return Times(None, TimeGrid(*spacing), [])
        if (found := columns.time_column(index)) is not None:
            times, second = columns.numbers([found])[0][:], time_factor(columns, found)
            grid = fit_grid(times, second, columns, found, may_jitter=True)
            return Times(found, grid, _propose_resampling(grid))
    column = _find_times(columns, values)
    if column is not None:
        return _propose_time_column(columns, column, values[column])
    span, reason = _time_of_day_span(columns)
    steps = max(map(len, values.values())) - 1
    if span <= 0 or steps < 1:
        return Times(None, None, [Proposal("rate", None, reason)])
    rate = Proposal("rate", f"{steps / span:.4g} Hz", reason, False)
    return Times(None, TimeGrid(span / steps, 0.0), [rate])


def _propose_time_column(columns: Columns, column: int, t: Floats) -> Times:
    """Return the keys for a column of times: `time`, or `rate` where it cannot be used."""
    name, unit = columns.describe_column(column), columns.labels[column].unit
    if len(t) < MIN_ROWS:
        return Times(column, None, [Proposal("rate", None, "there is only one row")])
    step = float(np.nanmedian(np.diff(t)))
    if not unit and step > LONG_STEP:
        counts = f"{name} advances by {step:.6g}"
        if step == 1.0 and np.nanstd(np.diff(t)) == 0.0:
            reason = f"{counts}: sample numbers, or milliseconds (then 1000 Hz)"
            return Times(column, None, [Proposal("rate", None, reason)])
        rate = Proposal(
            "rate", f"{1e3 / step:.6g} Hz", f"{counts}, taken as milliseconds", False
        )
        return Times(column, TimeGrid(step * 1e-3, 0.0), [rate])
    second = time_factor(columns, column)
    try:
        if np.isnan(t).any():
            row = int(np.isnan(t).argmax())
            raise columns.at(row, column, "the time is missing")
        grid = fit_grid(t, second, columns, column, may_jitter=True)
    except RecordError as error:
        there = np.flatnonzero(~np.isnan(t))
        first, last = int(there[0]), int(there[-1])
        mean = float(t[last] - t[first]) * second / max(last - first, 1)
        if not mean > 0:
            return Times(column, None, [Proposal("rate", None, error.message)])
        reason = f"mean rate; the times cannot be used: {error.message}"
        rate = Proposal("rate", f"{1 / mean:.6g} Hz", reason, False)
        return Times(column, TimeGrid(mean, 0.0), [rate])
    span = f"{t[0]:.6g} to {t[-1]:.6g} {unit or 's'}{'' if unit else ', taken as seconds'}"
    proposal = Proposal("time", _identify(columns, column), span, bool(unit))
    return Times(column, grid, [proposal, *_propose_resampling(grid)])


def _propose_resampling(grid: TimeGrid) -> list[Proposal]:
    """Return the key that makes uneven times even."""
    if grid.spread is None:
        return []
    low, high = grid.spread
    reason = f"steps vary from {low * 1e3:.4g} to {high * 1e3:.4g} ms; the mean rate, rounded"
    if f"{low:.4g}" == f"{high:.4g}":
        reason = "the times start anew beside the grid behind a gap; the rate of the rest"
    resample = {"rate": f"{mean_rate(grid.dt):.6g} Hz", "by": "spline"}
    return [Proposal("resample", resample, reason)]


def _find_times(columns: Columns, values: dict[int, Floats]) -> int | None:
    """Return the column whose unit or name is one of time; else the first that always rises."""
    for index in values:
        label = columns.labels[index]
        if label.unit:
            of_time = is_common_unit(label.unit, "s")
        else:
            of_time = NAMES_OF_TIME.fullmatch(label.name) is not None
        if of_time and not np.isnan(values[index]).all():
            return index
    rising = (index for index, x in values.items() if len(values) > 1 and _always_rises(x))
    return next(rising, None)


def _always_rises(x: Floats) -> bool:
    """Whether every sample is above the one before it, as times are and motions are not."""
    there = x[~np.isnan(x)]
    return len(there) > max(MIN_ROWS, len(x) / 2) and bool((np.diff(there) > 0).all())


def _time_of_day_span(columns: Columns) -> tuple[float, str]:
    """Return the seconds from the first to the last row by times of day, 0 if unknown."""
    unknown = 0.0, "the file does not contain the times"
    if not isinstance(columns, TextTable):
        return unknown
    text, last_byte = columns.file.text, end_of_rows(columns)
    tail = text[max(0, last_byte - MAX_LINE) : last_byte].rstrip().splitlines()
    first = next(cells for _, cells in columns.rows() if cells)
    last = split_cells(tail[-1].decode(errors="replace"), columns.delimiter) if tail else []
    for index, (begin, end) in enumerate(zip(first, last, strict=False)):
        if TIME_OF_DAY.fullmatch(begin.text) and TIME_OF_DAY.fullmatch(end.text):
            where = f"the times of day in {columns.describe_column(index)}"
            span = _seconds_between(begin.text, end.text)
            return span, f"mean rate of {where}" if span > 0 else f"{where} do not advance"
    return unknown


def _seconds_between(begin: str, end: str) -> float:
    """Return the time between two times of day [s]; without dates, less than a day."""
    try:
        dates = [datetime.fromisoformat(text.replace(",", ".")) for text in (begin, end)]
        return (dates[1] - dates[0]).total_seconds()
    except (ValueError, TypeError):  # no date, or another form of it
        return (_seconds_of_day(end) - _seconds_of_day(begin)) % 86400.0


def _seconds_of_day(text: str) -> float:
    """Return the last group `h:m:s` of a time of day in seconds."""
    clock = re.findall(r"\d{1,2}(?::\d\d){1,2}(?:[.,]\d*)?", text)[-1].replace(",", ".")
    hours, minutes, *seconds = (float(part) for part in clock.split(":"))
    return 3600.0 * hours + 60.0 * minutes + sum(seconds)


# The column of the samples, and its unit.


def _propose_column(
    columns: Columns, summaries: list[ColumnSummary], is_choice: bool
) -> tuple[ColumnSummary | None, Measurement, list[Proposal]]:
    """Return the column that is most likely ü, what it measures, and keys that select it."""
    is_triaxial = len(summaries) == AXES and not any(one.name for one in summaries)
    known = {one: _measure(one, is_triaxial) for one in summaries}

    def likelihood(one: ColumnSummary) -> tuple[bool, ...]:
        quantity = known[one].quantity
        return (
            quantity == "acceleration",
            bool(quantity),
            NAMES_OF_BASE.fullmatch(one.name) is not None,
            known[one].has_gravity,
            NAMES_OF_VERTICAL.fullmatch(one.name) is not None,
        )

    best = max(summaries, key=likelihood)  # the first of equals
    ties = [one for one in summaries if likelihood(one) == likelihood(best)]
    quantity, unit, has_gravity, is_unit_certain = known[best]
    proposals = []
    if is_choice:
        value: str | int | None = _identify(columns, best.column)
        if len(ties) > 1:
            listed = [_describe_level(_identify(columns, one.column), one) for one in ties]
            names = "; ".join(listed[:MAX_LISTED] + ["…"] * (len(listed) > MAX_LISTED))
            value, reason = (
                None,
                f"which is the motion of the base? RMS and peak about the mean: {names}",
            )
        elif len(summaries) == 1:
            reason = f"the only {columns.word} of numbers besides the time"
        elif NAMES_OF_BASE.fullmatch(best.name):
            reason = "by its name"
        elif has_gravity:
            reason = "its mean is gravity: the vertical direction"
        elif NAMES_OF_VERTICAL.fullmatch(best.name):
            reason = "by its name"
        else:
            reason = f"the only one with a unit of {quantity}"
        proposals.append(Proposal(columns.key, value, reason, len(summaries) == 1))
    if columns.normalised:
        reason = "integer samples are fractions of a full scale, e.g. 50 m/s2"
        proposals.append(Proposal("full_scale", None, reason))
    elif not quantity:
        proposals.append(Proposal("unit", None, "the file does not contain it; e.g. m/s2 or g"))
    elif not is_unit_certain:
        reason = (
            f"no unit in the file; the mean of {best.level.mean:.4g} looks like gravity in "
            f"{unit}"
        )
        proposals.append(Proposal("unit", unit, reason, False))
    if quantity not in ("", "acceleration"):
        proposals.append(Proposal("quantity", quantity, f"from the unit `{unit}`"))
    return (best if len(ties) == 1 else None), known[best], proposals


def _describe_level(key: str | int, one: ColumnSummary) -> str:
    """Return RMS and peak of a column, by which its motion may be told from noise."""
    peak = max(abs(one.smallest - one.level.mean), abs(one.largest - one.level.mean))
    numbers = f"{format_number(one.level.spread)} and {format_number(peak)}"
    return f"`{key}` {numbers} {one.unit}".rstrip()


class Measurement(NamedTuple):
    """What a column measures; quantity and unit are empty where the file does not show them."""

    quantity: str = ""
    unit: str = ""
    has_gravity: bool = False
    is_unit_certain: bool = False


def _measure(one: ColumnSummary, is_triaxial: bool = False) -> Measurement:
    """Return what a column measures, from its unit, or else from gravity and its name.

    `is_triaxial` tells that it may be one of three axes without names.
    """
    for quantity in ("acceleration", "velocity", "displacement"):
        if one.unit and is_common_unit(one.unit, SI[quantity]):
            level = one.level.scaled(conversion_factor(one.unit, SI[quantity]))
            has_gravity = quantity == "acceleration" and level.has_gravity
            return Measurement(quantity, one.unit, has_gravity, True)
    may_be_acceleration = is_triaxial or NAMES_OF_ACCELERATION.fullmatch(one.name) is not None
    if may_be_acceleration and not one.unit and one.level.spread < abs(one.level.rest):
        for unit in ("m/s2", "g", "mg"):
            if one.level.scaled(conversion_factor(unit, "m/s²")).has_gravity:
                return Measurement("acceleration", unit, True, False)
    return Measurement()


def _suspect_unit(columns: Columns, one: ColumnSummary) -> Iterator[str]:
    """Yield a sentence if the mean of a column is gravity in another unit than its own."""
    measured = _measure(one)
    if measured.quantity == "acceleration" and measured.is_unit_certain:
        factor = conversion_factor(measured.unit, "m/s²")
        found = describe_wrong_unit(one.level.scaled(factor), None)
        if found:
            yield f"{columns.describe_column(one.column)}: {found}"


# Clean-up.


def _propose_clean_up(
    x: Floats, grid: TimeGrid | None, summary: ColumnSummary, measured: Measurement
) -> list[Proposal]:
    """Return the keys that fill gaps and remove gravity, offset and drift."""
    proposals, level = [], summary.level
    if grid is not None:
        at = grid.positions(len(x))[~np.isnan(x)]
        longest = float(np.diff(at).max(initial=0.0)) * grid.dt
        if longest > MIN_GAP_STEPS * grid.dt:
            at_most = ceil(min(longest, SHORT_GAP) * 1e3 * (1 - 1e-9))
            gaps = {"fill": "spline", "at_most": f"{at_most} ms"}
            reason = f"the longest gap lasts {format_number(longest, 's')}"
            if is_long := longest > SHORT_GAP:
                reason += (
                    "; longer than 50 ms is an error, whose message names a window without it"
                )
            proposals.append(Proposal("gaps", gaps, reason, not is_long))
        enough = PERIODS_OF_HIGH_PASS / SUGGESTED_HIGH_PASS
        is_fast = 2.0 * SUGGESTED_HIGH_PASS * grid.dt < 1.0
        is_event = abs(level.mean) > LARGE_MEAN * level.spread and not level.has_offset
        is_long = len(x) * grid.dt >= enough
        if measured.quantity == "acceleration" and is_fast and is_long and not is_event:
            reason = "high-pass: removes gravity, offset and drift; T_x is known with it"
            below = {"below": f"{SUGGESTED_HIGH_PASS:g} Hz"}
            return [*proposals, Proposal("remove", below, reason, False)]
    if level.has_offset:
        what = "gravity" if measured.has_gravity else "an offset"
        trend: str | None = "line" if measured.quantity == "velocity" else "mean"
        reason = f"the mean of {level.mean:.4g} {summary.unit} looks like {what}"
        if not level.mean_is_offset:
            trend = None
            reason = (
                f"at rest it shows {level.rest:.4g} {summary.unit}, which looks like {what}: "
                f"subtract it in the file; the mean of {level.mean:.4g} contains motion as well"
            )
        proposals.append(Proposal("remove", trend, reason.replace("  ", " "), False))
    return proposals
