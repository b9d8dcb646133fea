"""Signal processing of a record: time grid, gaps, resampling, filters, differentiation, window.

The steps, in the order in which they are applied:

1. `fit_grid` fits an even time grid to printed times, or finds gaps or uneven times.
2. `fill_gaps` interpolates missing samples, and cuts the record at gaps outside the window.
3. `resample_onto` interpolates onto another grid, after a check for aliasing.
4. `remove` subtracts a trend and filters without phase shift.
5. `TO_ACCELERATION` differentiates velocity or displacement through splines; `displacements`
   integrates acceleration.
6. `window_range` and `cut_window` select a window.

Each step that the scenario requests yields a `CleaningReport`. Without a request nothing is
changed: a gap in the window or an uneven step is an error.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil, floor, inf, log10
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import Floats, Samples, Signal, mean_and_std
from drysim.errors import RecordError
from drysim.records.columns import (
    Columns,
    PrintedTimes,
    record_error,
    require_memory_to_load,
    slice_signal,
)
from drysim.records.level import measure_level
from drysim.records.options import Gaps, Interpolation, Removal, Resample, Trend, Window
from drysim.wording import format_count, join_words

METHODS = {"line": "linear interpolation", "spline": "cubic spline"}
"""Interpolation methods in messages."""

STEP_TOLERANCE = 1e-9
"""Relative tolerance for the equality of two times or steps: rounding."""

# Time grid.


MAX_JITTER = 1e-3
"""Accepted deviation of a sample from the even grid, in steps; it hardly changes ü."""

MAX_ROUNDING = 0.02
"""Accepted rounding of printed times, in steps: 256 Hz printed to 1e-4 s needs this much."""

LAST_DIGIT_ERROR = 0.6
"""Rounding error in units of the last printed digit: 0.5, and a margin for binary rounding."""

SINGLE_PRECISION = 2.0**-23
"""Relative rounding of times that were stored in single precision."""

MIN_STEP = 1e-300
"""Steps [s] below this would overflow the rate."""

MIN_GAP_STEPS = 1.5
"""A step longer than this many regular steps is a gap."""

POOR_TIMES_HINT = (
    "if only the printed times are inaccurate, set `rate` or `step` instead of `time`"
)
"""Hint for times that a recorder cannot have produced."""

MIN_FIRST_PART = 4
"""Rows before times that begin anew that are a record of their own, at least."""

MIN_CHANGES, MIN_LOST, LOST_SHARE = 4, 2.0, 0.2
"""Changes of a clock of few digits that show its rate, and the rows that a pause lacks: their
number, and their share of those between two changes, at least."""


class TimeGrid(NamedTuple):
    """Times of the samples."""

    dt: float
    """Time step [s]; for uneven times the mean without gaps."""
    first: float
    """First time [s]."""
    offsets: Floats | None = None
    """Sample positions [dt] from the first, shape (n,); None if no sample is missing. They are
    whole numbers unless the times are uneven or go on beside the grid after a gap."""
    spread: tuple[float, float] | None = None
    """Smallest and greatest step [s] of uneven times; None for an even grid."""
    column: int | None = None
    """0-based column of the times, for error messages."""

    def positions(self, n: int) -> Floats:
        """Return the positions [dt] of all n samples from the first."""
        return np.arange(float(n)) if self.offsets is None else self.offsets


class Series(NamedTuple):
    """Evenly spaced samples in SI, their time step [s] and first time [s]."""

    values: Signal
    dt: float
    first: float


def fit_grid(
    times: PrintedTimes,
    columns: Columns,
    index: int,
    may_jitter: bool = False,
    fill: str = "line",
) -> TimeGrid:
    """Fit a time grid to printed times.

    Parameters
    ----------
    columns, index
        The file and the 0-based column of the times, for error messages.
    may_jitter : bool, optional
        Whether uneven times are accepted, because the record is going to be resampled.
    fill : {'line', 'spline'}, optional
        Interpolation that the message about a gap proposes.

    Raises
    ------
    RecordError
        If times repeat, decrease, or are uneven; the error names the row.

    Notes
    -----
    Printed times are rounded. If a rate that is a whole number of samples per second agrees
    with the times within their rounding, it is used; otherwise the mean step.
    """
    t, second, digit = times
    steps, first = np.diff(t), float(t[0]) * second
    halt = np.flatnonzero(steps <= 0)
    if halt.size:
        row = int(halt[0]) + 1
        raise _backward_error(t, row, columns, index)
    dt = _even_step(t, np.arange(float(len(t))), digit, second)
    if dt is not None:
        return TimeGrid(dt, first)
    usual = float(np.median(steps))
    # Missing rows: assign each time to the nearest multiple of the median step.
    positions = np.concatenate(([0.0], np.cumsum(np.rint(steps / usual))))
    dt = _even_step(t, positions, digit, second) if positions[-1] >= len(t) else None
    if dt is not None:
        return TimeGrid(dt, first, positions)
    is_gap = steps > MIN_GAP_STEPS * usual
    if not may_jitter:
        grid = _fit_parts(t, is_gap, digit, second)
        if grid is None:
            raise _uneven_error(steps, is_gap, usual, second, columns, index, fill)
        return grid
    short = steps[~is_gap]
    # For uneven steps the mean estimates the rate; the median may differ by chance.
    mean, spread = float(short.mean()), (float(short.min()), float(short.max()))
    return TimeGrid(
        mean * second, first, (t - t[0]) / mean, (spread[0] * second, spread[1] * second)
    )


def _backward_error(t: Floats, row: int, columns: Columns, index: int) -> RecordError:
    """Return the error for a time that repeats or decreases at a 0-based row."""
    steps = np.diff(t)
    falls = np.flatnonzero(steps < 0) + 1
    is_reversed = len(falls) > np.count_nonzero(steps) / 2
    if is_reversed:
        row = int(falls[0])
    what = f"from {t[row - 1]:.12g} to {t[row]:.12g}"
    if t[row] == t[row - 1]:
        remedy = _describe_pause(t, columns) or POOR_TIMES_HINT
        return columns.error_at(row, index, f"time repeats: {what}; {remedy}")
    sentence, line = f"time decreases: {what}", columns.line_of(row)
    if len(falls) > 1:
        sentence += f", the first of {len(falls)} such rows"
    if not line:
        return columns.error_at(row, index, sentence)
    is_restart = t[row - 1] - t[row] > (t[row - 1] - t[0]) / 2
    if is_reversed or not is_restart or (row < MIN_FIRST_PART and len(falls) > 1):
        remedy = "sort the rows by time"
    elif row < MIN_FIRST_PART:
        remedy = f"`rows: {{from: {line}}}` leaves the rows above out"
    else:
        first = "" if len(falls) > 1 else f", `rows: {{from: {line}}}` the second one"
        remedy = (
            f"a second record begins here: `rows: {{to: {line - 1}}}` reads the first{first}"
        )
    return columns.error_at(row, index, f"{sentence}: {remedy}")


def _describe_pause(t: Floats, columns: Columns) -> str:
    """Return where a clock of few digits, whose times repeat, has the longest pause.

    Empty if each of its steps has about as many rows as it lasts.
    """
    changes = np.flatnonzero(np.diff(t)) + 1
    if len(changes) < MIN_CHANGES:
        return ""
    counts, steps = np.diff(changes), np.diff(t[changes])
    expected = steps * float(np.median(counts / steps))
    lost = expected - counts
    k = int(lost.argmax())
    if lost[k] <= max(MIN_LOST, LOST_SHARE * float(np.median(counts))):
        return ""
    row = int(changes[k + 1])
    line = columns.line_of(row)
    part = f", such as `rows: {{from: {line}}}`," if line else ""
    return (
        f"it goes from {t[row - 1]:.12g} to {t[row]:.12g} before "
        f"{columns.describe_row(row)}, where about "
        f"{format_count(round(float(lost[k])), 'sample')} are missing: read one part{part} "
        "with `rate` instead of `time`"
    )


def _fit_parts(
    t: Floats, is_gap: NDArray[np.bool_], digit: float, second: float
) -> TimeGrid | None:
    """Fit one step to times that are even between gaps, and start anew after each of them.

    Returns None without a gap, or if the times between gaps are uneven.
    """
    first = np.flatnonzero(np.concatenate(([True], is_gap)))
    lengths = np.diff(first, append=len(t))
    longest = int(lengths.argmax())
    part = t[first[longest] :][: lengths[longest]]
    if len(first) == 1 or len(part) < 2:
        return None
    dt = _even_step(part, np.arange(float(len(part))), digit, second)
    if dt is None:
        return None
    step = dt / second
    begin, count = np.repeat(first, lengths), np.arange(len(t)) - np.repeat(first, lengths)
    deviation = t - t[begin] - count * step
    width = np.maximum.reduceat(deviation, first) - np.minimum.reduceat(deviation, first)
    if float(width.max()) > 2 * MAX_ROUNDING * step:
        return None
    return TimeGrid(dt, float(t[0]) * second, (t[begin] - t[0]) / step + count)


def _even_step(t: Floats, positions: Floats, digit: float, second: float) -> float | None:
    """Return the step [s] of times at integer multiples of it; None if there is none.

    `digit` is the unit of the last printed digit.
    """
    dt = float(t[-1] - t[0]) / float(positions[-1])
    largest = float(np.abs(t[[0, -1]]).max())
    rounding = LAST_DIGIT_ERROR * digit + 4 * np.spacing(largest)
    slack = max(rounding, MAX_JITTER * dt, SINGLE_PRECISION * largest)
    # Prefer an integer rate [Hz] if the printed digits allow it.
    rate = round(1 / max(dt * second, MIN_STEP))
    if rate and _grid_deviation(t, positions, 1 / rate / second) <= min(
        rounding, MAX_ROUNDING * dt
    ):
        return 1 / rate
    # Round the step to 12 digits unless that changes the last time.
    neat = float(f"{dt:.12g}")
    if not abs(neat - dt) * (positions[-1] + 1) <= 4 * np.spacing(abs(t[-1])):
        neat = dt
    return (
        neat * second
        if _grid_deviation(t, positions, neat) <= min(slack, MAX_ROUNDING * dt)
        else None
    )


def _grid_deviation(t: Floats, positions: Floats, dt: float) -> float:
    """Return half the width of the band around the even grid that contains all times."""
    off = positions * -dt
    off += t
    return float(off.max() - off.min()) / 2


def _uneven_error(
    steps: Floats,
    is_gap: NDArray[np.bool_],
    usual: float,
    second: float,
    columns: Columns,
    index: int,
    fill: str,
) -> RecordError:
    """Return the error for uneven steps, at the first visible deviation that is no gap."""
    off, gaps, short = np.abs(steps - usual), steps[is_gap], steps[~is_gap]
    off[is_gap] = 0.0
    row = int(np.argmax(off > MAX_ROUNDING * usual)) + 1
    if off[row - 1] <= MAX_ROUNDING * usual:
        row = int(np.argmax(off)) + 1
    sentence = (
        f"the time steps are uneven: {steps[row - 1]:.6g} before this row, "
        f"usually {usual:.6g}, {short.min():.6g} to {short.max():.6g} "
        f"{'between gaps' if len(gaps) else 'overall'}; "
    )
    resample = resample_hint(float(short.mean()) * second)
    if len(gaps):
        first, longest = float(gaps[0]) * second, float(gaps.max()) * second
        sentence += (
            f"{format_count(len(gaps), 'gap')}, the first of {first:.6g} s; "
            f"`{gaps_hint(longest, fill)}` and {resample} together make them even"
        )
    else:
        sentence += f"{resample} makes them even"
    return columns.error_at(row, index, f"{sentence}; {POOR_TIMES_HINT}")


def mean_rate(dt: float) -> float:
    """Return the rate [Hz] to three digits, within the 1 % that need no low-pass."""
    return float(f"{1 / dt:.3g}")


def resample_hint(dt: float) -> str:
    """Return how to resample uneven times at their mean rate."""
    return f"`resample: {{rate: {mean_rate(dt):.6g} Hz, by: spline}}`"


def gaps_hint(longest: float, fill: str) -> str:
    """Return the key that fills gaps of up to `longest` [s], rounded up to three digits."""
    digit = 10.0 ** (floor(log10(longest)) - 2)
    needed = ceil(longest / digit * (1 - STEP_TOLERANCE)) * digit
    at_most = f"{needed:.3g} s" if needed >= 1.0 else f"{needed * 1e3:.3g} ms"
    return f"gaps: {{fill: {fill}, at_most: {at_most}}}"


# Reports.


NEGLIGIBLE_MEAN = 1e-12
"""Ratio of mean to RMS below which a mean is rounding."""


class CleaningReport(NamedTuple):
    """Report of one processing step, with RMS about the mean and mean of the samples in SI."""

    step: str
    """Key of the record that requested the step."""
    sentence: str
    """Description of the step."""
    rms_before: float
    rms_after: float
    mean_before: float
    mean_after: float
    numbers: Mapping[str, float]
    """Further results of the step, in SI."""

    def to_dict(self) -> dict[str, object]:
        """Return the report as stored in drysim.json."""
        return {**self._asdict(), "numbers": dict(self.numbers)}


def make_report(
    step: str,
    sentence: str,
    before: Floats,
    after: Floats,
    unit: str,
    numbers: Mapping[str, float],
) -> CleaningReport:
    """Return the report of a step. Its sentence is extended by the RMS before and after.

    The means have the decimal places of the RMS before: smaller ones do not matter.
    """
    (mean, rms), (mean_after, rms_after) = _mean_and_rms(before), _mean_and_rms(after)
    shown, shown_after = mean, mean_after
    if rms > 0.0:
        places = 3 - floor(log10(rms))
        shown, shown_after = round(mean, places) or 0.0, round(mean_after, places) or 0.0
    full_sentence = (
        f"{sentence}; RMS about the mean {rms:.4g} before, {rms_after:.4g} {unit} after; mean "
        f"{shown:.4g} before, {shown_after:.4g} {unit} after"
    )
    return CleaningReport(step, full_sentence, rms, rms_after, mean, mean_after, numbers)


def _mean_and_rms(values: Floats) -> tuple[float, float]:
    """Return mean and RMS about it; a mean within rounding counts as 0."""
    mean, rms = mean_and_std(values)
    return (0.0 if abs(mean) < NEGLIGIBLE_MEAN * rms else mean), rms


# Gaps.


class FilledRecord(NamedTuple):
    """Samples without gaps, their grid, and the number of those used, in the window.

    `reports` are those of the cut at gaps outside the window and of the gaps filled in it.
    """

    values: Floats
    grid: TimeGrid
    used: int
    reports: tuple[CleaningReport, ...] = ()


def fill_gaps(
    values: Floats,
    grid: TimeGrid,
    gaps: Gaps | None,
    window: Window | None,
    columns: Columns,
    index: int,
    unit: str,
) -> FilledRecord:
    """Fill gaps by interpolation; cut the record at longer ones that lie outside the window.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Samples in SI, NaN where one is missing.
    grid : TimeGrid
    gaps : Gaps or None
        None makes every gap in the window an error.
    window : Window or None
        The part that is going to be used.
    columns, index
        The file and the 0-based column of the samples, for error messages.
    unit : str
        SI unit of the samples.

    Raises
    ------
    RecordError
        If a gap in the window is longer than allowed, at an end of the record, or followed by
        times beside the grid; the error names the row.
    """
    there = ~np.isnan(values)
    if grid.offsets is None and there.all():
        return FilledRecord(values, grid, len(values))
    positions = grid.positions(len(values))
    places, rows, measured = positions[there], np.flatnonzero(there), values[there]
    steps = np.diff(places)
    holes = np.flatnonzero(steps > MIN_GAP_STEPS)
    is_long = steps[holes] * grid.dt > (
        0.0 if gaps is None else gaps.at_most * (1 + STEP_TOLERANCE)
    )
    if grid.spread is None:  # not going to be resampled
        is_long |= _is_off_grid(steps[holes])
    # The record is used between the last long gap before the window and the first one after it.
    ends = (-inf, inf) if window is None else window.ends
    low, high = ((end - grid.first) / grid.dt for end in ends)
    long, tolerance = holes[is_long], EDGE_TOLERANCE
    before, after = places[long + 1] <= low + tolerance, places[long] >= high - tolerance
    first = int(np.max(long[before] + 1, initial=0))
    last = int(np.min(long[after], initial=len(measured) - 1))
    ends_in_gap = len(measured) < 2 or not (
        (there[0] or low >= places[0] - tolerance)
        and (there[-1] or high <= places[-1] + tolerance)
    )
    in_window = long[~(before | after)]
    if ends_in_gap or len(in_window):
        hint = _window_hint(places, long, grid, float(positions[-1]))
        if ends_in_gap:
            row = 0 if not there[0] else len(values) - 1
            sentence = f"the record begins or ends with a gap; cut it off{hint and ': '}{hint}"
            raise columns.error_at(row, index, sentence)
        hole = int(in_window[0])
        sentence = _gap_message(places, hole, holes, grid, gaps, hint, unit)
        row, is_jump = int(rows[hole + 1]), rows[hole + 1] - rows[hole] == 1
        place = grid.column if is_jump and grid.column is not None else index
        raise columns.error_at(row, place, sentence)
    reports = []
    used = slice(first, last + 1)
    if last - first + 1 < len(measured) or not (there[0] and there[-1]):
        t = grid.first + places[[first, last]] * grid.dt
        range_of_times = f"from {t[0]:{TIME_FORMAT}} s to {t[1]:{TIME_FORMAT}} s"
        sentence = f"used {range_of_times}, between the gaps around the window"
        numbers = {"first": float(t[0]), "last": float(t[1])}
        reports.append(make_report("window", sentence, measured, measured[used], unit, numbers))
    places, measured = places[used], measured[used]
    filled = measured
    if gaps is not None:
        places, filled, report = _interpolate_gaps(
            places, measured, gaps, (low, high), grid.dt, unit
        )
        reports += [report] if report else []
    inside = int(((low - tolerance <= places) & (places <= high + tolerance)).sum())
    origin = grid.first + float(places[0]) * grid.dt
    is_even = grid.spread is None and len(filled) == len(measured)
    grid = grid._replace(first=origin, offsets=None if is_even else places - places[0])
    return FilledRecord(filled, grid, inside, tuple(reports))


def _interpolate_gaps(
    positions: Floats,
    measured: Floats,
    gaps: Gaps,
    window: tuple[float, float],
    dt: float,
    unit: str,
) -> tuple[Floats, Floats, CleaningReport | None]:
    """Return positions [dt] and samples without gaps, and the report on those in the window.

    `window` are the positions of its ends. The report is None if no gap is filled in it.
    """
    steps = np.diff(positions)
    holes = np.flatnonzero(steps > MIN_GAP_STEPS)
    missing = np.rint(steps[holes]).astype(int) - 1
    behind = np.repeat(holes, missing)
    share = np.concatenate([[], *(np.arange(1, n + 1) / (n + 1) for n in missing.tolist())])
    new = positions[behind] + share * steps[behind]
    if not len(new):
        return positions, measured, None
    filled = np.insert(measured, behind + 1, interpolate(positions, measured, new, gaps.fill))
    everywhere = np.insert(positions, behind + 1, new)
    is_used = (window[0] - EDGE_TOLERANCE <= new) & (new <= window[1] + EDGE_TOLERANCE)
    if not is_used.any():
        return everywhere, filled, None
    lengths = steps[np.unique(behind[is_used])]
    longest, count = float(lengths.max()) * dt, int(is_used.sum())
    numbers = {"gaps": len(lengths), "samples": count, "longest": longest}
    sentence = (
        f"{format_count(len(lengths), 'gap')} ({format_count(count, 'sample')}) "
        f"filled by {METHODS[gaps.fill]}, the longest of {longest:.4g} s"
    )
    return everywhere, filled, make_report("gaps", sentence, measured, filled, unit, numbers)


def _is_off_grid(steps: Floats) -> NDArray[np.bool_]:
    """Return which gaps [dt] are not followed by times on the grid before them."""
    return np.asarray(np.abs(steps - np.rint(steps)) > EDGE_TOLERANCE)


def _window_hint(positions: Floats, long: NDArray[np.intp], grid: TimeGrid, last: float) -> str:
    """Return the window of the longest part between long gaps; empty for single samples.

    `last` is the position [dt] of the last row. The ends are rounded inwards.
    """
    edges = np.concatenate(([-1], long, [len(positions) - 1]))
    if not len(positions) or np.diff(edges).max() < 2:
        return ""
    part = int(np.argmax(positions[edges[1:]] - positions[edges[:-1] + 1]))
    t = grid.first + positions[[edges[part] + 1, edges[part + 1]]] * grid.dt
    digits = 1 - floor(log10(grid.dt))
    margin = EDGE_TOLERANCE * grid.dt * 10.0**digits
    start = ceil(float(t[0]) * 10.0**digits - margin) / 10.0**digits
    end = floor(float(t[1]) * 10.0**digits + margin) / 10.0**digits
    keys = []
    if positions[edges[part] + 1] > 0:
        keys.append(f"from: {start:{TIME_FORMAT}} s")
    if positions[edges[part + 1]] < last:
        keys.append(f"to: {end:{TIME_FORMAT}} s")
    return f"`window: {{{', '.join(keys)}}}`"


def interpolate(positions: Floats, values: Floats, wanted: Floats, by: str) -> Floats:
    """Interpolate linearly (`line`) or with a C² cubic spline (`spline`)."""
    if by == "line":
        return np.interp(wanted, positions, values)
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(positions, values)(wanted), dtype=np.float64)


def _gap_message(
    positions: Floats,
    hole: int,
    holes: NDArray[np.intp],
    grid: TimeGrid,
    gaps: Gaps | None,
    window: str,
    unit: str,
) -> str:
    """Return the message for the gap behind sample `hole` among all gaps, with remedies."""
    steps, dt = np.diff(positions), grid.dt
    missing = max(round(float(steps[hole])) - 1, 1)
    count = f"{format_count(missing, 'sample')} {'is' if missing == 1 else 'are'}"
    more, them = (
        ("", "it") if len(holes) == 1 else (f" ({len(holes)} gaps in total)", "them all")
    )
    fill = f"`{gaps_hint(float(steps[holes].max()) * dt, 'spline' if unit == 'm' else 'line')}`"
    if grid.spread is None and _is_off_grid(steps[holes]).any():
        remedy = (
            f"the record has a gap, and its times start anew behind it: {fill} and "
            f"{resample_hint(dt)} together fill {them}"
        )
    elif gaps is None:
        remedy = f"the record has a gap; {fill} fills {them}"
    else:
        remedy = f"`gaps.at_most` allows {gaps.at_most:.6g} s; {fill} fills {them}"
    leave_out = f", {window} leaves {'it' if len(holes) == 1 else 'them'} out" if window else ""
    return (
        f"{count} missing before this row: a step of {float(steps[hole]) * dt:.6g} s, not "
        f"{dt:.6g} s{more}: {remedy}{leave_out}"
    )


# Resampling.


MAX_ALIAS_GAIN = 0.1
"""Largest gain of the low-pass at the new Nyquist frequency: -20 dB."""

UNEVEN_STEP_TOLERANCE = 1e-2
"""As `STEP_TOLERANCE`, for uneven steps, whose Nyquist frequency is not well defined."""


class ResamplingGrid(NamedTuple):
    """Target of a resampling: the requested step [s], a refinement of it, and the method.

    A record whose rate is reduced is filtered on a grid that is `refinement` times as fine, and
    then decimated.
    """

    step: float
    refinement: int
    by: Interpolation


def resampling_grid(
    wanted: Resample, removal: Removal, grid: TimeGrid, display_path: str
) -> ResamplingGrid:
    """Return the grid onto which a record is interpolated; it is at least as fine as its own.

    Raises
    ------
    RecordError
        If the rate is reduced without a sufficient low-pass in `removal` (aliasing).
    """
    step = wanted.step or 1 / (wanted.rate or 1.0)
    same = STEP_TOLERANCE if grid.spread is None else UNEVEN_STEP_TOLERANCE
    refinement = max(1, ceil(step / grid.dt * (1 - same)))
    if refinement > 1 and (low_pass := missing_low_pass(step, removal)):
        half = 1 / (2 * step)
        sentence = (
            f"resampling from {1 / grid.dt:.6g} to {2 * half:.6g} Hz aliases frequencies "
            f"above {half:.6g} Hz; add a low-pass with a gain of at most 0.1 there, "
            f"{low_pass} or lower"
        )
        raise record_error(display_path, sentence)
    return ResamplingGrid(step, refinement, wanted.by)


def missing_low_pass(step: float, removal: Removal) -> str:
    """Return the `remove` that a reduction to a step [s] needs; empty if it is sufficient."""
    half, order = 1 / (2 * step), removal.order
    if removal.above is not None and low_pass_gain(
        half, removal.above, order
    ) <= MAX_ALIAS_GAIN * (1 + STEP_TOLERANCE):
        return ""
    most = half * (1 / MAX_ALIAS_GAIN - 1) ** (-1 / (2 * order))
    # 1 % less remains sufficient after rounding to three digits.
    return f"`remove: {{above: {0.99 * most:.3g} Hz, order: {order}}}`"


def resample_onto(
    values: Floats, grid: TimeGrid, target: ResamplingGrid, unit: str, display_path: str
) -> tuple[Series, CleaningReport]:
    """Interpolate samples onto the refined grid, which ends where the record does."""
    fine, after = target.step / target.refinement, values
    if grid.offsets is not None or abs(fine / grid.dt - 1) > STEP_TOLERANCE:
        positions = grid.positions(len(values))
        length = float(positions[-1]) * grid.dt
        count = floor(length / fine * (1 + STEP_TOLERANCE)) + 1
        require_memory_to_load(display_path, 8 * count)
        if count < 2:
            sentence = f"the record lasts {length:.6g} s, less than one step of `resample`"
            raise record_error(display_path, sentence)
        places = np.minimum(np.arange(count) * (fine / grid.dt), length / grid.dt)
        after = interpolate(positions, values, places, target.by)
    numbers = {"step_before": grid.dt, "step_after": target.step}
    was = f"{1 / grid.dt:.6g} Hz"
    if grid.spread is not None:
        least, most = grid.spread
        numbers |= {"least_step": least, "greatest_step": most}
        was = f"uneven steps of {least:.4g} to {most:.4g} s (mean {grid.dt:.4g} s)"
    sentence = f"resampled from {was} to {1 / target.step:.6g} Hz by {METHODS[target.by]}"
    report = make_report("resample", sentence, values, after, unit, numbers)
    return Series(after, fine, grid.first), report


def decimate(series: Series, target: ResamplingGrid) -> Series:
    """Return the samples on the requested grid."""
    return series._replace(values=series.values[:: target.refinement].copy(), dt=target.step)


# Trends and filters.


Extension = Literal["even", "odd"]
"""Extension of the samples beyond the ends: symmetric (even) or antisymmetric (odd)."""


class Filtered(NamedTuple):
    """Result of `remove`; `before_high_pass` is None without a high-pass."""

    series: Series
    before_high_pass: Series | None
    report: CleaningReport


def remove(
    series: Series, wanted: Removal, unit: str, display_path: str, ends: Extension = "even"
) -> Filtered:
    """Subtract a trend and apply low-pass and high-pass; `ends` as in `high_pass`.

    Raises
    ------
    RecordError
        If a corner frequency has less than one period in the record, or exceeds the Nyquist
        frequency, or no end of the record shows the level at rest.
    """
    remaining, before_high_pass, removed_parts = series.values[:], None, []
    if wanted.trend != "nothing":
        if wanted.trend == "rest":
            remaining = remaining - _level_at_rest(remaining, display_path)
        else:
            remaining = remaining - fit_trend(remaining, wanted.trend)
        removed_parts.append(TREND_NAMES[wanted.trend])
    if wanted.above is not None:
        _check_corner(wanted.above, "above", series, display_path)
        remaining = low_pass(remaining, series.dt, wanted.above, wanted.order)
        removed_parts.append(f"frequencies above {wanted.above:g} Hz")
    if wanted.below is not None:
        _check_corner(wanted.below, "below", series, display_path)
        before_high_pass = series._replace(values=remaining)
        remaining = high_pass(remaining, series.dt, wanted.below, wanted.order, ends)
        removed_parts.append(f"frequencies below {wanted.below:g} Hz")
    by = f" (zero-phase Butterworth of order {wanted.order})" if wanted.has_filters else ""
    removed = series.values[:] - remaining
    mean, drift = float(removed.mean()), float(removed[-1] - removed[0])
    sentence = f"{join_words(removed_parts)} removed{by}"
    if wanted.trend == "line" or wanted.below is not None:
        sentence += (
            f"; the removed part changes by {drift:+.4g} {unit} from first to last sample"
        )
    if wanted.below is not None:
        edge = f"the first and the last {1 / wanted.below:.3g} s"
        sentence += f"; {edge} depend on how the record is continued beyond its ends"
    numbers = {"mean": mean, "drift": drift}
    report = make_report("remove", sentence, series.values[:], remaining, unit, numbers)
    return Filtered(series._replace(values=remaining), before_high_pass, report)


def _check_corner(frequency: float, side: str, series: Series, display_path: str) -> None:
    """Raise for a corner frequency outside the range of the record."""
    low, high = 1 / ((len(series.values) - 1) * series.dt), 1 / (2 * series.dt)
    if not low <= frequency < high:
        bounds = f"at least {low:.6g} Hz, one period in the record, and below {high:.6g} Hz"
        sentence = f"`remove.{side}` must be {bounds}, half its rate; not {frequency:.6g} Hz"
        raise record_error(display_path, sentence)


TREND_NAMES: Mapping[Trend, str] = {
    "rest": "the level at rest",
    "mean": "the mean",
    "line": "the linear trend",
}


def _level_at_rest(values: Floats, display_path: str) -> float:
    """Return the level of a quiet end of the samples; raise RecordError without one."""
    level = measure_level(values)
    if not level.is_at_rest:
        sentence = (
            "`remove: rest` needs a record that begins or ends at rest, but neither end is "
            "quiet; `remove: mean` removes the offset of a vibration"
        )
        raise record_error(display_path, sentence)
    return level.rest


def fit_trend(values: Floats, what: Literal["mean", "line"]) -> Floats:
    """Return the mean or the least-squares line of samples, shape (n,).

    Importing `scipy.signal.detrend` instead would take twice as long as a dry run without it.
    """
    n = len(values)
    if what == "mean":
        return np.broadcast_to(values.mean(), n)
    steps = np.arange(n) - (n - 1) / 2  # centred, so that mean and slope are independent
    return np.asarray(values.mean() + (steps @ values) / (steps @ steps) * steps)


def low_pass(values: Floats, dt: float, frequency: float, order: int) -> Floats:
    """Return the part below a frequency [Hz]; see `high_pass`."""
    return _filter_zero_phase(values, dt, frequency, order, "lowpass", "odd")


def low_pass_gain(frequency: float, corner: float, order: int) -> float:
    """Return the amplitude gain [-] of `low_pass` at a frequency."""
    return 1 / (1 + (frequency / corner) ** (2 * order))


def high_pass(
    values: Floats, dt: float, frequency: float, order: int, ends: Extension = "even"
) -> Floats:
    """Return the part above a frequency, by a zero-phase Butterworth filter.

    Parameters
    ----------
    values : ndarray, shape (n,)
    dt : float
        Time step [s].
    frequency : float
        Frequency at which the amplitude is halved [Hz].
    order : int
        Order in each direction. The filter is applied forwards and backwards, so the slope is
        12 dB per octave and order.
    ends : {'even', 'odd'}, optional
        Extension of each end by one period of the frequency.

    Returns
    -------
    ndarray, shape (n,)

    Notes
    -----
    The least-squares line is subtracted first. The even extension leaves the smallest remainder
    of low frequencies.
    """
    level = values - fit_trend(values, "line")
    return _filter_zero_phase(level, dt, frequency, order, "highpass", ends)


def _filter_zero_phase(
    values: Floats,
    dt: float,
    frequency: float,
    order: int,
    kind: Literal["highpass", "lowpass"],
    ends: Extension,
) -> Floats:
    from scipy.signal import butter, sosfiltfilt

    sections = butter(order, frequency, kind, fs=1 / dt, output="sos")
    period = int(min(len(values) - 1, 1 / (frequency * dt)))
    passed = sosfiltfilt(sections, values, padtype=ends, padlen=period)
    return np.asarray(passed, dtype=np.float64)


# Window, differentiation and integration.


EDGE_TOLERANCE = 1e-6
"""Accepted distance of a window edge from a sample, in steps: rounding of its time."""

TIME_FORMAT = ".15g"
"""Seconds since 1970 have ten digits before the decimal point."""


def window_range(series: Series, window: Window | None, display_path: str) -> tuple[int, int]:
    """Return the first and the last sample of a window, 0-based and inclusive.

    Raises
    ------
    RecordError
        If the window does not lie within the record, or contains fewer than two samples.
    """
    first, last = 0, len(series.values) - 1
    if window is None:
        return first, last
    if window.start is not None:
        first = ceil(_sample_number(window.start, series) - EDGE_TOLERANCE)
    if window.to is not None:
        # A record of 60 s has its last sample one step before 60 s.
        end = floor(_sample_number(window.to, series) + EDGE_TOLERANCE)
        last = last if end == last + 1 else end
    if 0 <= first < last < len(series.values):
        return first, last
    wrong, until = "", series.first + (len(series.values) - 1) * series.dt
    for key, t, sample in (("from", window.start, first), ("to", window.to, last)):
        if not wrong and not 0 <= sample < len(series.values):
            side = "before the beginning" if sample < 0 else "after the end"
            wrong = f"`window.{key}`, {t:{TIME_FORMAT}} s, is {side} of"
    sentence = (
        f"{wrong or 'the window must hold two samples of'} the record, which runs from "
        f"{series.first:{TIME_FORMAT}} s to {until:{TIME_FORMAT}} s in steps of "
        f"{series.dt:.6g} s"
    )
    raise record_error(display_path, sentence)


def _sample_number(t: float, series: Series) -> float:
    """Return the number of steps from the first sample to a time, bounded to 1e18."""
    return max(-1e18, min(1e18, (t - series.first) / series.dt))


def cut_window(motion: Samples, first: int, last: int, n: int) -> Samples:
    """Return the motion from the first to the last of the n samples of the record."""
    finer = (len(motion.u_dd) - 1) // (n - 1)
    part = first * finer, last * finer + 1
    u = None if motion.u is None else motion.u[slice(*part)]
    u_dd = slice_signal(motion.u_dd, *part)
    return motion._replace(u_dd=u_dd, u=u, goes_on=last < n - 1)


def from_acceleration(series: Series) -> Samples:
    """Return samples of acceleration unchanged, linear in between."""
    return Samples(series.values, series.dt)


def from_velocity(series: Series) -> Samples:
    """Return the derivative of the quadratic spline through samples of velocity.

    Notes
    -----
    The knots of the spline lie midway between the samples. Its derivative is linear between
    knots, so values at every half step represent it exactly.
    """
    from scipy.interpolate import make_interp_spline

    n = len(series.values)
    spline = make_interp_spline(np.arange(n), series.values[:], k=min(2, n - 1))
    u_dd = np.asarray(spline(np.arange(2 * n - 1) / 2, 1), dtype=np.float64) / series.dt
    return Samples(u_dd, series.dt / 2)


def from_displacement(series: Series) -> Samples:
    """Return the second derivative of the C² cubic spline through samples of displacement.

    Notes
    -----
    The spline has not-a-knot ends. Its second derivative is linear between samples, so the
    values at the samples represent it exactly.
    """
    from scipy.interpolate import CubicSpline

    u, steps = series.values[:], np.arange(len(series.values))
    u_dd = np.asarray(CubicSpline(steps, u)(steps, 2), dtype=np.float64) / series.dt**2
    return Samples(u_dd, series.dt, u)


TO_ACCELERATION = {
    "acceleration": from_acceleration,
    "velocity": from_velocity,
    "displacement": from_displacement,
}


def displacements(motion: Samples, frequency: float, order: int) -> tuple[Floats, Floats]:
    """Return the high-passed displacement of an acceleration, for two extensions of the ends.

    Parameters
    ----------
    motion : Samples
        Acceleration before a high-pass.
    frequency, order
        As in `high_pass`.

    Returns
    -------
    u : ndarray, shape (n,)
        Displacement [m].
    otherwise : ndarray, shape (n,)
        The same with the other extension of the ends [m]. The difference measures the
        uncertainty.

    Notes
    -----
    ü, linear between samples, is integrated exactly, the drift is subtracted, and the result is
    filtered. If ü were filtered before the integration, the remainder of low frequencies at the
    ends would grow to most of u. What is left depends on the extension within one period of
    either end. The odd extension suits records with low frequencies, the even one seat-test
    signals without any. The remainder adds to u, so the result with the smaller RMS is returned
    as u.
    """
    u_dd, dt = motion.u_dd[:] - fit_trend(motion.u_dd[:], "line"), motion.dt
    # Integrate piecewise linear ü exactly, and remove the drift after each integration.
    u_d = np.zeros_like(u_dd)
    np.cumsum((u_dd[1:] + u_dd[:-1]) * (dt / 2), out=u_d[1:])
    u_d -= u_d.mean()
    u = np.zeros_like(u_dd)
    np.cumsum(u_d[:-1] * dt + (2 * u_dd[:-1] + u_dd[1:]) * (dt * dt / 6), out=u[1:])
    span = np.linspace(-1.0, 1.0, len(u))
    # A linear error of the acceleration is a cubic drift of the displacement.
    u -= np.polynomial.Legendre.fit(span, u, min(3, len(u) - 1), domain=[-1, 1])(span)
    extensions: tuple[Extension, ...] = "odd", "even"
    filtered = [
        _filter_zero_phase(u, dt, frequency, order, "highpass", ends) for ends in extensions
    ]
    least, most = sorted(filtered, key=lambda values: float(values @ values))
    return least, most
