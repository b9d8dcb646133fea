"""What an unknown record file contains: proposed keys of a scenario, each with its reason.

A logger file rarely says all that a scenario must state. Where its header, its times and its
statistics show an answer, that is proposed together with the observation; a proposal that is
not certain is marked as such. Where they show none, the proposed key has no value: the user
has to decide, and validation of the scenario reports the key until then.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from itertools import islice
from math import ceil
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drysim.core.model import Floats
from drysim.errors import RecordError
from drysim.records import SI
from drysim.records.artefacts import missing_code
from drysim.records.clean import (
    MIN_GAP_STEPS,
    POOR_TIMES_HINT,
    TimeGrid,
    fit_grid,
    mean_rate,
)
from drysim.records.clock import is_time_name, is_unit, unit_in_name, unit_of_values
from drysim.records.columns import (
    ALL_ROWS,
    Cell,
    Columns,
    Format,
    PrintedTimes,
    RecordFile,
    shorten_quote,
    time_factor,
)
from drysim.records.formats import open_with_format
from drysim.records.layout import (
    MAX_LISTED,
    Statement,
    describe_across,
    describe_labels,
    find_foot,
    find_rows,
    read_preamble,
    runs_across_rows,
    sensors_in_turn,
    skips_samples,
)
from drysim.records.level import Level, measure_level
from drysim.records.options import LARGE_MEAN, SUGGESTED_HIGH_PASS
from drysim.records.text import MAX_ROWS_EXAMINED, NO_SAMPLE, TextTable, is_number
from drysim.records.warnings import describe_wrong_unit
from drysim.units import conversion_factor, is_common_unit
from drysim.wording import format_count, format_number

MAX_BYTES = 1 << 26
"""Bytes of a text file that are inspected; what follows is left to validation."""

NAMES_OF_FREQUENCY = re.compile(r"(?i)f|fn|f_?n|freq(uency|uenz)?([ _].*)?|hz")
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

MAX_RATE_ERROR = 2e-3
"""Largest relative uncertainty of a rate that follows from rounded times."""

MIN_WIDE = 16
"""Numbers in the only row of a file from which they are taken as one series."""

NO_TIMES = "the file does not contain the times"

SHORT_GAP = 0.05
"""Longest gap [s] whose interpolation is proposed without a question."""

PERIODS_OF_HIGH_PASS = 10
"""A high-pass is proposed for records of at least this many of its periods: within one period
of either end its output depends on how the record is continued."""

MIN_ROWS = 2
"""Rows from which a time step follows."""

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
    columns, rows = _find_columns(path)
    proposals, layout = [*rows], [_describe_layout(columns)]
    columns, is_whole = _first_part(columns)
    if not is_whole:
        layout.append(f"only the first {MAX_BYTES / 1e6:.0f} MB were inspected")
    _refuse_other_layouts(columns)
    clocks, turns = _clock_columns(columns), _label_columns(columns)
    values: dict[int, Floats] = {}
    codes: dict[int, float] = {}
    faults: dict[int, RecordError] = {}
    for index in columns.series():
        if index in clocks | turns:
            continue
        try:
            x = columns.numbers([index], index)[0][:]
            if not columns.normalised and (code := missing_code(x)) is not None:
                codes[index], x = code, np.where(x == code, np.nan, x)
            values[index] = x
        except RecordError as error:
            faults[index] = error
            layout.append(_describe_fault(columns, index, error))
    if not values:
        raise _no_samples(columns, faults, layout[1:])
    time, grid, of_time = _propose_times(columns, values, clocks)
    summaries = [_summarise(columns, i, x) for i, x in values.items() if i != time]
    if not summaries:
        raise _no_samples(columns, faults, layout[1:], " besides the time")
    count = max(len(values[summary.column]) for summary in summaries)
    rate = "" if grid is None else f" at {1 / grid.dt:.6g} Hz, {count * grid.dt:.4g} s"
    layout.insert(1, format_count(count, "sample") + rate)
    is_choice = len(columns.series()) > 1 + any(proposal.key == "time" for proposal in of_time)
    said = read_preamble(columns) if isinstance(columns, TextTable) else {}
    chosen, measured, of_column = _propose_column(columns, summaries, is_choice)
    if chosen is not None:
        of_column = _unit_in_preamble(of_column, columns, chosen.column, said)
    proposals += _rate_in_preamble(of_time, said) + of_column
    layout += (
        sentence for summary in summaries for sentence in _suspect_unit(columns, summary)
    )
    if chosen is not None:
        if (code := codes.get(chosen.column)) is not None:
            reason = f"{code:g} is far outside the range of all other samples: a code, not one"
            value = int(code) if code.is_integer() else code
            proposals.append(Proposal("missing", value, reason, False))
        x = values[chosen.column]
        if chosen.level.padding_text:
            proposals, chosen = _propose_without_padding(columns, proposals, x, chosen)
        if chosen.level.padding_text:
            reason = f"{chosen.level.padding_text}: cut these zeros off in the file"
            proposals.append(Proposal("remove", None, reason))
        else:
            proposals += _propose_clean_up(columns, x, grid, chosen, measured)
    return Inspection(tuple(layout), tuple(summaries), tuple(proposals))


def _begins_with_number(columns: Columns, index: int) -> bool:
    """Return whether the first row of a text table has a number in a column."""
    if not isinstance(columns, TextTable):
        return False
    return is_number(Cell(columns.end_texts(index)[0], 1))


def _describe_fault(columns: Columns, index: int, error: RecordError) -> str:
    """Return why a column is left out; the remedy for a damaged row is not for one of text."""
    name = columns.describe_column(index)
    fault = error.message.removeprefix(f"{name} ").replace(f", {name}:", ":", 1)
    if not _begins_with_number(columns, index):
        fault = fault.partition(NO_SAMPLE)[0]
    return f"{name} is left out: {fault}"


def _no_samples(
    columns: Columns, faults: Mapping[int, RecordError], layout: list[str], besides: str = ""
) -> RecordError:
    """Return the error of the first damaged row, or else that there is no series."""
    damaged = (error for i, error in faults.items() if _begins_with_number(columns, i))
    sentence = f"there is no {columns.word} of numbers{besides}"
    return next(damaged, columns.error("; ".join([sentence, *dict.fromkeys(layout)])))


def _find_columns(path: Path) -> tuple[Columns, list[Proposal]]:
    """Return the columns of the rows that are samples, and the keys that select these rows."""
    file, member = open_with_format(path)
    return _select_rows(*find_rows(file, member), member)


def _select_rows(
    file: RecordFile, columns: Columns, member: Format
) -> tuple[Columns, list[Proposal]]:
    """Return the columns of the rows that are samples, and the keys that select these rows."""
    proposals, rows, reasons = [], dict[str, object](), []
    if file.skip:
        reason, is_certain = "rows above the header or the first numbers", True
        if isinstance(columns, TextTable) and skips_samples(columns):
            reason, is_certain = "rows above the header, with numbers in all columns", False
        proposals.append(Proposal("skip", file.skip, reason, is_certain))
    if not isinstance(columns, TextTable):
        return columns, proposals
    if file.rows.start:
        rows["from"] = file.rows.start
        reasons.append(f"row {file.rows.start - 1} is no sample")
    if (foot := find_foot(columns)) is not None:
        rows["to"] = foot.first - 1
        listed = ", ".join(f"`{shorten_quote(word)}`" for word in foot.texts[:MAX_LISTED])
        which = f"rows {foot.first} to {foot.last}"
        which = which if foot.last > foot.first else f"row {foot.first}"
        reasons.append(
            f"{which} below the samples: {listed}"
            if listed
            else f"{which} at the end of the file: the first cell is empty"
        )
    if rows:
        file = replace(file, rows=file.rows._replace(to=foot.first - 1 if foot else None))
        columns = member.columns(file)
        proposals.append(Proposal("rows", rows, "; ".join(reasons), False))
    if isinstance(columns, TextTable) and (labels := sensors_in_turn(columns)) is not None:
        reason = describe_labels(columns, labels, rows)
        proposals = [proposal for proposal in proposals if proposal.key != "rows"]
        proposals.append(Proposal("rows", None, "; ".join([*reasons, reason])))
        where: dict[str | int, str | int] = {labels.column + 1: labels.labels[0]}
        columns = member.columns(replace(file, rows=file.rows._replace(where=where)))
    return columns, proposals


def _refuse_other_layouts(columns: Columns) -> None:
    """Raise for a table whose rows or columns are not series of samples."""
    if not isinstance(columns, TextTable):
        return
    count = sum(len(cells) for _, cells in islice(columns.rows(), MAX_ROWS_EXAMINED))
    is_one_row = MIN_WIDE <= columns.width == count
    if is_one_row or runs_across_rows(columns):
        samples = sum(len(cells) for _, cells in columns.rows())
        raise columns.file.error(describe_across(columns, samples), columns.line)
    label = columns.labels[0]
    if NAMES_OF_FREQUENCY.fullmatch(label.name) or is_common_unit(label.unit, "Hz"):
        sentence = "contains frequencies: this is a spectrum, not samples over time"
        raise columns.error(f"{columns.describe_column(0)} {sentence}", 0)


def _label_columns(columns: Columns) -> set[int]:
    """Return the columns with the labels of sensors, by which rows are selected."""
    rows = columns.file.rows if isinstance(columns, TextTable) else ALL_ROWS
    return {columns.find(key) for key in rows.where}


def _clock_columns(columns: Columns) -> set[int]:
    """Return the columns of dates and times of day."""
    if not isinstance(columns, TextTable):
        return set()
    clocks = {index for index in range(columns.width) if columns.clock(index) is not None}
    dates = {columns.date_column(index) for index in clocks}
    return clocks | {date[0] for date in dates if date is not None}


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
    clocks = _clock_columns(columns)
    series = [index for index in columns.series() if index not in clocks]
    comma = ", decimal commas" if columns.decimal(series) == "," else ""
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


def _propose_times(columns: Columns, values: dict[int, Floats], clocks: set[int]) -> Times:
    """Return what is known of the times."""
    for index in values:
        if (spacing := columns.file_spacing(index)) is not None:
            return Times(None, TimeGrid(*spacing), [])
        if (time_column := columns.time_column(index)) is not None:
            times, _ = columns.with_times(time_column, [])
            grid = fit_grid(times, columns, time_column, may_jitter=True)
            return Times(time_column, grid, _propose_resampling(grid))
    # The first column that can be used, else the first one.
    candidates = dict.fromkeys(_time_columns(columns, values, clocks))
    proposed = [_propose_time_column(columns, index) for index in candidates]
    usable = [times for times in proposed if times.grid is not None]
    if proposed:
        return (usable or proposed)[0]
    rising = next((i for i, x in values.items() if _always_rises(x)), None)
    if rising is None or columns.labels[rising].unit:
        return Times(None, None, [Proposal("rate", None, NO_TIMES)])
    if len(values) == 1:
        sentence = "rises from row to row, as times do, and there is no other column of numbers"
        raise columns.error(f"{columns.describe_column(rising)} {sentence}")
    return _propose_rising(columns, rising, values[rising])


def _time_columns(
    columns: Columns, values: dict[int, Floats], clocks: set[int]
) -> Iterator[int]:
    """Yield the columns of times: by unit, by contents, by name, by size."""
    there = [index for index, x in values.items() if not np.isnan(x).all()]
    units = {index: columns.labels[index].unit for index in there}
    yield from (index for index in there if units[index] and is_unit(units[index]))
    yield from (i for i in sorted(clocks) if _clock_of(columns, i))
    names = (index for index in there if not units[index])
    yield from (index for index in names if is_time_name(columns.labels[index].name))
    rising = (index for index in there if _always_rises(values[index]))
    yield from (index for index in rising if unit_of_values(values[index]))


def _clock_of(columns: Columns, index: int) -> bool:
    return isinstance(columns, TextTable) and columns.clock(index) is not None


def _propose_rising(columns: Columns, column: int, x: Floats) -> Times:
    """Return the keys for numbers that rise, but are not named as times are."""
    name, step = columns.describe_column(column), float(np.nanmedian(np.diff(x)))
    first, last = x[~np.isnan(x)][[0, -1]]
    if columns.labels[column].name or step > LONG_STEP:
        what = "sample numbers" if step == round(step) else "are these times?"
        key = _identify(columns, column)
        reason = (
            f"{name} rises from {first:.12g} to {last:.12g} in steps of {step:.6g}: {what}; if "
            f"these are times, set `time: {key}` and `time_unit` instead"
        )
        return Times(column, None, [Proposal("rate", None, reason)])
    return _propose_time_column(columns, column)


def _propose_time_column(columns: Columns, column: int) -> Times:
    """Return the keys for a column of times: `time`, or `rate` where it cannot be used."""
    name = columns.describe_column(column)
    try:
        times, _ = columns.with_times(column, [], column)
    except RecordError as error:
        return Times(column, None, [Proposal("rate", None, error.message)])
    t = times.t
    if np.isfinite(t).sum() < MIN_ROWS:
        return Times(column, None, [Proposal("rate", None, "there is only one row")])
    is_clock = _clock_of(columns, column)
    is_known = is_clock or time_factor(columns, column) is not None or unit_of_values(t) != ""
    step = float(np.nanmedian(np.diff(t)))
    key = _identify(columns, column)
    try:
        if np.isnan(t).any():
            raise columns.error_at(int(np.isnan(t).argmax()), column, "the time is missing")
        grid = fit_grid(times, columns, column, may_jitter=True)
    except RecordError as error:
        fault, rate = error.message.removesuffix(f"; {POOR_TIMES_HINT}"), _rate_of_rows(times)
        if not is_known and step > LONG_STEP:
            rate = None
        if rate is None and (np.diff(t) <= 0).any():  # which no rate can set right
            remedy = "" if fault == error.message else ": correct the row"
            unit = "" if is_known else " and `time_unit`"
            fault += f"{remedy}; then `time: {key}`{unit}"
            return Times(column, None, [Proposal("time", None, fault)])
        if rate is None:
            return Times(column, None, [Proposal("rate", None, fault)])
        reason = f"every printed time agrees with it; none of them can be `time`: {fault}"
        proposal = Proposal("rate", f"{rate:.6g} Hz", reason, False)
        return Times(column, TimeGrid(1 / rate, 0.0), [proposal])
    if not is_known and step > LONG_STEP:
        reason = f"{name} has no unit and advances by {step:.6g}: s, ms or us?"
        steps = np.diff(t)
        row = int(steps.argmax()) + 1
        if steps[row - 1] > MIN_GAP_STEPS * step:
            reason += f"; by {steps[row - 1]:.6g} before {columns.describe_row(row)}"
        proposals = [
            Proposal("time", key, f"{t[0]:.12g} to {t[-1]:.12g}"),
            Proposal("time_unit", None, reason),
        ]
        return Times(column, None, proposals)
    span = _describe_span(columns, column, times, is_clock)
    proposal = Proposal("time", key, span, is_known)
    return Times(column, grid, [proposal, *_propose_resampling(grid)])


def _describe_span(columns: Columns, column: int, times: PrintedTimes, is_clock: bool) -> str:
    """Return the first and the last time in words."""
    t, label = times.t, columns.labels[column]
    if isinstance(columns, TextTable) and is_clock:
        first, last = columns.end_texts(column)
        return f"{first} to {last}"
    unit, of_values = label.unit or unit_in_name(label.name), unit_of_values(t)
    if unit and of_values != unit:
        return f"{t[0]:.6g} to {t[-1]:.6g} {unit}"
    if of_values == "d":
        begin = datetime(1899, 12, 30) + timedelta(days=float(t[0]))
        return f"days as Excel counts them, from {begin:%Y-%m-%d %H:%M:%S}"
    if of_values:
        begin = datetime.fromtimestamp(float(t[0]) * times.second, UTC)
        return f"{of_values} since 1970, from {begin:%Y-%m-%d %H:%M:%S} UTC"
    return f"{t[0]:.6g} to {t[-1]:.6g} s, taken as seconds"


def _rate_of_rows(times: PrintedTimes) -> float | None:
    """Return the rate [Hz] of even rows with which all printed times agree; None without one.

    Times may be missing, or printed with few digits, such as whole seconds.
    """
    rows = np.flatnonzero(~np.isnan(times.t))
    t = times.t[rows]
    if len(rows) <= MIN_ROWS or not t[-1] > t[0]:
        return None
    digit = max(times.resolution, 4 * float(np.spacing(np.abs(t).max())))
    # Times of few digits repeat; the rows where they change show the step best.
    changes = np.flatnonzero(np.diff(t)) + 1
    first, last = int(changes[0]), int(changes[-1])
    if last == first:
        return None
    slope = float(t[last] - t[first]) / float(rows[last] - rows[first])
    for digits in (3, 4, 6, 12):
        rate = float(f"{1 / (slope * times.second):.{digits}g}") if slope > 0 else 0.0
        if not rate > 0:
            return None
        slack = digit * (1 + 1e-9) - float(np.ptp(t - rows / (rate * times.second)))
        if slack >= 0 and slack * rate * times.second < MAX_RATE_ERROR * (rows[-1] - rows[0]):
            return rate
    return None


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


def _always_rises(x: Floats) -> bool:
    """Whether every sample is above the one before it, as times are and motions are not."""
    there = x[~np.isnan(x)]
    return len(there) > max(MIN_ROWS, len(x) / 2) and bool((np.diff(there) > 0).all())


# What the lines above the rows say.


def _rate_in_preamble(
    proposals: list[Proposal], said: Mapping[str, Statement]
) -> list[Proposal]:
    """Return the rate or the step above the rows where the rows show no times."""
    if proposals != [Proposal("rate", None, NO_TIMES)]:
        return proposals
    for key in ("rate", "step"):
        if key in said:
            value, reason = said[key]
            return [Proposal(key, value or None, reason, False)]
    return proposals


def _unit_in_preamble(
    proposals: list[Proposal], columns: Columns, index: int, said: Mapping[str, Statement]
) -> list[Proposal]:
    """Return the unit of a column above the rows where its header has none."""
    if "sensitivity" in said and not columns.labels[index].unit:
        value, reason = said["sensitivity"]
        sensitivity, unit = value.split("\t")
        others = [each for each in proposals if each.key not in ("unit", "quantity")]
        scale = Proposal("scale", float(f"{1 / float(sensitivity):.12g}"), reason, False)
        return [*others, Proposal("unit", unit, reason, False), scale]
    if columns.labels[index].unit or not said.keys() & {"unit", "units"}:
        return proposals
    value, reason = said.get("units") or said["unit"]
    unit = value.split("\t")[index] if "units" in said else value
    for quantity in ("acceleration", "velocity", "displacement"):
        if is_common_unit(unit, SI[quantity]):
            of_unit = [Proposal("unit", unit, reason, False)]
            if quantity != "acceleration":
                of_unit.append(Proposal("quantity", quantity, f"from the unit `{unit}`"))
            return [
                proposal for proposal in proposals if proposal.key not in ("unit", "quantity")
            ] + of_unit
    of_unit = [Proposal("unit", None, f"{reason}: `{unit}` is no unit of a motion")]
    return [proposal for proposal in proposals if proposal.key != "unit"] + of_unit


# The column of the samples, and its unit.


def _propose_column(
    columns: Columns, summaries: list[ColumnSummary], is_choice: bool
) -> tuple[ColumnSummary | None, Measurement, list[Proposal]]:
    """Return the column that is most likely ü, what it measures, and keys that select it."""
    is_triaxial = len(summaries) == AXES and not any(summary.name for summary in summaries)
    measurements = {summary: _measure(summary, is_triaxial) for summary in summaries}

    def likelihood(summary: ColumnSummary) -> tuple[bool, ...]:
        quantity = measurements[summary].quantity
        return (
            quantity == "acceleration",
            bool(quantity),
            NAMES_OF_BASE.fullmatch(summary.name) is not None,
            measurements[summary].has_gravity,
            NAMES_OF_VERTICAL.fullmatch(summary.name) is not None,
        )

    best = max(summaries, key=likelihood)  # the first of equals
    ties = [summary for summary in summaries if likelihood(summary) == likelihood(best)]
    quantity, unit, has_gravity, is_unit_certain = measurements[best]
    proposals = []
    if is_choice:
        value: str | int | None = _identify(columns, best.column)
        if len(ties) > 1:
            listed = [
                _describe_level(_identify(columns, summary.column), summary) for summary in ties
            ]
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
        if _unit_in_name(best):
            reason = f"the name `{best.name}` ends in it"
        proposals.append(Proposal("unit", unit, reason, False))
    if quantity not in ("", "acceleration"):
        proposals.append(Proposal("quantity", quantity, f"from the unit `{unit}`"))
    return (best if len(ties) == 1 else None), measurements[best], proposals


def _describe_level(key: str | int, summary: ColumnSummary) -> str:
    """Return RMS and peak of a column, by which its motion may be told from noise."""
    peak = max(
        abs(summary.smallest - summary.level.mean), abs(summary.largest - summary.level.mean)
    )
    numbers = f"{format_number(summary.level.spread)} and {format_number(peak)}"
    return f"`{key}` {numbers} {summary.unit}".rstrip()


class Measurement(NamedTuple):
    """What a column measures; quantity and unit are empty where the file does not show them."""

    quantity: str = ""
    unit: str = ""
    has_gravity: bool = False
    is_unit_certain: bool = False


def _measure(summary: ColumnSummary, is_triaxial: bool = False) -> Measurement:
    """Return what a column measures, from its unit, or else from gravity and its name.

    `is_triaxial` tells that it may be one of three axes without names.
    """
    for quantity in ("acceleration", "velocity", "displacement"):
        if summary.unit and _is_unit_of(quantity, summary.unit):
            level = summary.level.scaled(conversion_factor(summary.unit, SI[quantity]))
            has_gravity = quantity == "acceleration" and level.has_gravity
            return Measurement(quantity, summary.unit, has_gravity, True)
    in_name = _unit_in_name(summary)
    if in_name:
        level = summary.level.scaled(conversion_factor(in_name, "m/s²"))
        return Measurement("acceleration", in_name, level.has_gravity, False)
    may_be_acceleration = (
        is_triaxial or NAMES_OF_ACCELERATION.fullmatch(summary.name) is not None
    )
    if (
        may_be_acceleration
        and not summary.unit
        and summary.level.spread < abs(summary.level.rest)
    ):
        for unit in ("m/s2", "g", "mg"):
            if summary.level.scaled(conversion_factor(unit, "m/s²")).has_gravity:
                return Measurement("acceleration", unit, True, False)
    return Measurement()


def _is_unit_of(quantity: str, unit: str) -> bool:
    """Return whether a unit is one of a quantity; rare ones, as `ft/s2`, of accelerations only.

    A comment such as `(in)` or `(C)` may be a rare unit of another quantity.
    """
    if is_common_unit(unit, SI[quantity]) or quantity != "acceleration":
        return is_common_unit(unit, SI[quantity])
    try:
        return conversion_factor(unit, SI[quantity]) > 0.0
    except ValueError:
        return False


def _unit_in_name(summary: ColumnSummary) -> str:
    """Return the unit at the end of the name of an acceleration, as in `acc_g`."""
    *before, last = re.split(r"[\s_]+", summary.name)
    is_named = bool(before) and NAMES_OF_ACCELERATION.fullmatch(before[0]) is not None
    return last if is_named and not summary.unit and is_common_unit(last, "m/s²") else ""


def _suspect_unit(columns: Columns, summary: ColumnSummary) -> Iterator[str]:
    """Yield a sentence if the mean of a column is gravity in another unit than its own."""
    measured = _measure(summary)
    if measured.quantity == "acceleration" and measured.is_unit_certain:
        factor = conversion_factor(measured.unit, "m/s²")
        suspicion = describe_wrong_unit(summary.level.scaled(factor), None)
        if suspicion:
            yield f"{columns.describe_column(summary.column)}: {suspicion}"


# Clean-up.


def _propose_without_padding(
    columns: Columns, proposals: list[Proposal], x: Floats, summary: ColumnSummary
) -> tuple[list[Proposal], ColumnSummary]:
    """Return the proposals with the rows between zeros at the ends, and the summary of these.

    Both stay as they are for files without rows, and where the rows are not known.
    """
    of_rows = next((proposal for proposal in proposals if proposal.key == "rows"), None)
    rows_proposed = {} if of_rows is None else of_rows.value
    if not isinstance(columns, TextTable) or not isinstance(rows_proposed, dict):
        return proposals, summary
    before, after = summary.level.padding
    there = np.flatnonzero(~np.isnan(x))
    first, last = int(there[before]), int(there[len(there) - 1 - after])
    rows = {"from": first} if before else {}
    rows |= {"to": last} if after else {}
    lines = {key: columns.line_of(row) for key, row in rows.items()}
    reason = (
        f"{summary.level.padding_text}, and the mean without them is "
        f"{summary.level.rest:.4g} {summary.unit}".rstrip()
    )
    if of_rows is not None:
        reason = f"{of_rows.reason}; {reason}"
    skip = [proposal for proposal in proposals if proposal.key == "skip"]
    others = [proposal for proposal in proposals if proposal.key not in ("skip", "rows")]
    merged = Proposal("rows", {**rows_proposed, **lines}, reason, False)
    return [*skip, merged, *others], _summarise(columns, summary.column, x[first : last + 1])


def _propose_clean_up(
    columns: Columns,
    x: Floats,
    grid: TimeGrid | None,
    summary: ColumnSummary,
    measured: Measurement,
) -> list[Proposal]:
    """Return the keys that fill gaps and remove gravity, offset and drift."""
    proposals, level = [], summary.level
    if grid is not None:
        rows = np.flatnonzero(~np.isnan(x))
        steps = np.diff(grid.positions(len(x))[rows])
        longest = float(steps.max(initial=0.0)) * grid.dt
        if longest > MIN_GAP_STEPS * grid.dt:
            at_most = ceil(min(longest, SHORT_GAP) * 1e3 * (1 - 1e-9))
            gaps = {"fill": "spline", "at_most": f"{at_most} ms"}
            row = columns.describe_row(int(rows[int(steps.argmax()) + 1]))
            reason = f"the longest gap, before {row}, lasts {format_number(longest, 's')}"
            if is_long := longest > SHORT_GAP:
                reason += (
                    "; longer than 50 ms is an error, whose message names a window without it"
                )
            proposals.append(Proposal("gaps", gaps, reason, not is_long))
        enough = PERIODS_OF_HIGH_PASS / SUGGESTED_HIGH_PASS
        is_fast = 2.0 * SUGGESTED_HIGH_PASS * grid.dt < 1.0
        is_large = abs(level.mean) > LARGE_MEAN * level.spread
        is_event = level.is_event or (is_large and not level.has_offset)
        is_long = len(x) * grid.dt >= enough
        if measured.quantity == "acceleration" and is_fast and is_long and not is_event:
            reason = "high-pass: removes gravity, offset and drift; T_x is known with it"
            below = {"below": f"{SUGGESTED_HIGH_PASS:g} Hz"}
            return [*proposals, Proposal("remove", below, reason, False)]
    if level.has_offset:
        what = "gravity" if measured.has_gravity else "an offset"
        trend = "line" if measured.quantity == "velocity" else "mean"
        reason = f"the mean of {level.mean:.4g} {summary.unit} looks like {what}"
        if level.is_at_rest:
            trend = "rest"
            reason = (
                f"at rest it shows {level.rest:.4g} {summary.unit}, which looks like {what}; "
                f"the mean of {level.mean:.4g} contains motion as well"
            )
        proposals.append(Proposal("remove", trend, reason.replace("  ", " "), False))
    return proposals
