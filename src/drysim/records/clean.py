"""From the numbers of a record as a file gives them to ü on an even grid, cleaned on request.

In the order in which a record goes through them: `fit_grid` finds from printed times where the
samples lie, on an even grid, with holes in it, or unevenly; `fill_gaps` fills gaps; `resampling_grid` and
`resample_onto` put the samples onto another grid, between them by a stated way and never folded;
`remove` takes away a trend and what is outside a band, by filters without phase shift;
`TO_ACCELERATION` make acceleration of velocity and displacement, `displacements` the reverse; `window_range`
and `cut_window` keep a window. Each step that was asked for leaves a `CleaningReport`, words and numbers that
every summary tells. Without a request nothing is changed: a gap or an uneven step is a fault.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil, floor, log10
from typing import Literal, NamedTuple

import numpy as np

from drysim.core.model import Samples, Signal, mean_and_std
from drysim.errors import RecordError
from drysim.records.columns import (
    Columns,
    Floats,
    gap_hint,
    record_error,
    require_memory_to_load,
    slice_signal,
)
from drysim.records.options import Gaps, Removal, Resample, Window
from drysim.wording import format_count, join_words

STEP_TOLERANCE = 1e-9
"""Two times or two steps this close, relative to them, are one: rounding of times."""

# The grid.


MAX_JITTER = 1e-3
"""Share of a step by which any sample may leave the even grid: ü hardly changes within it."""

MAX_ROUNDING = 0.02
"""Share of a step that the rounding of printed times may take: enough for 256 Hz to 1e-4 s."""

LAST_DIGIT_ERROR = 0.6
"""Units of the last printed digit: rounding takes a half, the rest is binary."""

SINGLE_PRECISION = 2.0**-23
"""Relative rounding of times that once were single precision."""

MIN_STEP = 1e-300
"""Below this step [s] its rate would overflow."""

MIN_GAP_STEPS = 1.5
"""From this many usual steps on, a step is a hole in which samples are missing."""

POOR_TIMES_HINT = (
    "give `rate` or `step` in place of `time` where only the printed times are poor"
)
"""What to say of times that samples cannot have had."""


class TimeGrid(NamedTuple):
    """Where samples lie."""

    dt: float
    """Their distance; of uneven times the mean one, holes left out [s]."""
    first: float
    """Time of the first [s]."""
    at: Floats | None = None
    """Steps of `dt` from the first sample to each; None where none is missing."""
    spread: tuple[float, float] | None = None
    """Least and greatest step [s] of uneven times; None where all lie on the grid."""


class Series(NamedTuple):
    """Evenly spaced samples in SI, their distance and the time of the first [s]."""

    values: Signal
    dt: float
    first: float


def fit_grid(
    t: Floats, second: float, columns: Columns, index: int, may_jitter: bool = False
) -> TimeGrid:
    """Give where the samples of printed times lie.

    `second` is the unit of the times [s], `index` their 0-based column. Uneven times may stand
    where the record is to be resampled.

    Raises
    ------
    RecordError
        When time stands still, runs backwards, or its steps are uneven; the row is named.

    Notes
    -----
    The times may be rounded: a whole number of samples in a unit of time is preferred where the
    printed digits allow it, else the mean step counts.
    """
    steps = np.diff(t)
    halt = np.flatnonzero(steps <= 0)
    if halt.size:
        row = int(halt[0]) + 1
        what = "runs backwards" if steps[row - 1] < 0 else "stands still"
        sentence = f"time {what}: from {t[row - 1]:.12g} to {t[row]:.12g}"
        raise columns.at(
            row, index, sentence + ("" if steps[row - 1] < 0 else f"; {POOR_TIMES_HINT}")
        )
    digit, first = columns.printed_resolution(index), float(t[0]) * second
    dt = _even_step(t, np.arange(float(len(t))), digit, second)
    if dt is not None:
        return TimeGrid(dt, first)
    usual = float(np.median(steps))
    at = np.concatenate(([0.0], np.cumsum(np.rint(steps / usual))))
    dt = _even_step(t, at, digit, second) if at[-1] >= len(t) else None
    if dt is not None:
        return TimeGrid(dt, first, at)
    if not may_jitter:
        raise _uneven_error(steps, usual, columns, index)
    short = steps[steps <= MIN_GAP_STEPS * usual]
    # Of uneven steps the mean tells the rate, where the median may lie off it by chance.
    mean, spread = float(short.mean()), (float(short.min()), float(short.max()))
    return TimeGrid(
        mean * second, first, (t - t[0]) / mean, (spread[0] * second, spread[1] * second)
    )


def _even_step(t: Floats, at: Floats, digit: float, second: float) -> float | None:
    """Give the step [s] of times that lie at whole numbers of it; None where they do not.

    `digit` is the unit of the last one that they are printed with.
    """
    dt = float(t[-1] - t[0]) / float(at[-1])
    largest = float(np.abs(t[[0, -1]]).max())
    rounding = LAST_DIGIT_ERROR * digit + 4 * np.spacing(largest)
    slack = max(rounding, MAX_JITTER * dt, SINGLE_PRECISION * largest)
    rate = round(1 / max(dt * second, MIN_STEP))
    if rate and _grid_deviation(t, at, 1 / rate / second) <= min(rounding, MAX_ROUNDING * dt):
        return 1 / rate
    # The step has 12 digits where the last time cannot tell the difference.
    neat = float(f"{dt:.12g}")
    if not abs(neat - dt) * (at[-1] + 1) <= 4 * np.spacing(abs(t[-1])):
        neat = dt
    return (
        neat * second if _grid_deviation(t, at, neat) <= min(slack, MAX_ROUNDING * dt) else None
    )


def _grid_deviation(t: Floats, at: Floats, dt: float) -> float:
    """Half the width of the band around the even grid that holds all times."""
    off = at * -dt
    off += t
    return float(off.max() - off.min()) / 2


def _uneven_error(steps: Floats, usual: float, columns: Columns, index: int) -> RecordError:
    """Give the error for steps that differ, at the first that does so visibly."""
    row = int(np.argmax(np.abs(steps - usual) > MAX_ROUNDING * usual)) + 1
    if abs(steps[row - 1] - usual) <= MAX_ROUNDING * usual:
        row = int(np.argmax(np.abs(steps - usual))) + 1
    sentence = (
        f"the time steps are uneven: {steps[row - 1]:.6g} to this row, {usual:.6g} as a rule, "
        f"{steps.min():.6g} to {steps.max():.6g} in all; `resample` puts the record onto an "
        f"even grid; or {POOR_TIMES_HINT}"
    )
    return columns.at(row, index, sentence)


# Reports.


NEGLIGIBLE_MEAN = 1e-12
"""A mean below this share of the RMS is what rounding leaves of none."""


class CleaningReport(NamedTuple):
    """One step of a clean-up: RMS and mean of the samples, in SI, the RMS about that mean."""

    step: str
    """Key of the record that asked for it."""
    sentence: str
    """What was done."""
    rms_before: float
    rms_after: float
    mean_before: float
    mean_after: float
    numbers: Mapping[str, float]
    """What else describes the step, in SI."""

    def to_dict(self) -> dict[str, object]:
        """Give the report as drysim.json holds it."""
        return {**self._asdict(), "numbers": dict(self.numbers)}


def make_report(
    step: str,
    sentence: str,
    before: Floats,
    after: Floats,
    unit: str,
    numbers: Mapping[str, float],
) -> CleaningReport:
    """Give the report of a step from its samples; the RMS values are added to its sentence."""
    (mean, rms), (mean_after, rms_after) = _mean_and_rms(before), _mean_and_rms(after)
    full_sentence = (
        f"{sentence}; RMS {rms:.4g} before, {rms_after:.4g} {unit} after, of the samples about "
        f"means of {mean:.4g} and {mean_after:.4g} {unit}"
    )
    return CleaningReport(step, full_sentence, rms, rms_after, mean, mean_after, numbers)


def _mean_and_rms(values: Floats) -> tuple[float, float]:
    """Return mean and RMS about it; a mean that is rounding of the samples counts as 0."""
    mean, rms = mean_and_std(values)
    return (0.0 if abs(mean) < NEGLIGIBLE_MEAN * rms else mean), rms


# Gaps.


def fill_gaps(
    values: Floats, grid: TimeGrid, gaps: Gaps | None, columns: Columns, index: int, unit: str
) -> tuple[Floats, TimeGrid, CleaningReport | None]:
    """Give samples without gaps, where they are, and the report of what was filled.

    The samples are in SI, NaN where one is missing; where nothing is said of gaps, each is a
    fault. `index` is the 0-based column of the samples, `unit` their SI unit.

    Raises
    ------
    RecordError
        When a gap is longer than asked for, or at an end; its row is named.
    """
    there = ~np.isnan(values)
    if grid.at is None and there.all():
        return values, grid, None
    at = (np.arange(float(len(values))) if grid.at is None else grid.at)[there]
    rows, known = np.flatnonzero(there), values[there]
    steps = np.diff(at)
    holes = np.flatnonzero(steps > MIN_GAP_STEPS)
    if len(known) < 2 or not (there[0] and there[-1]):
        row = 0 if not there[0] else len(values) - 1
        raise columns.at(row, index, "the record begins or ends with a gap; cut that away")
    if not len(holes):
        return known, grid._replace(at=at), None
    allowed = 0.0 if gaps is None else gaps.at_most * (1 + STEP_TOLERANCE)
    long = holes[steps[holes] * grid.dt > allowed]
    longest = float(steps[holes].max()) * grid.dt
    if gaps is None or len(long):
        width, row = float(steps[long[0]]), int(rows[long[0] + 1])
        raise columns.at(row, index, _gap_message(width, grid.dt, gaps, len(holes), longest))
    missing = np.rint(steps[holes]).astype(int) - 1
    after = np.repeat(holes, missing)
    share = np.concatenate([np.arange(1, n + 1) / (n + 1) for n in missing.tolist()])
    new = at[after] + share * steps[after]
    filled = np.insert(known, after + 1, interpolate(at, known, new, gaps.fill))
    numbers = {"gaps": len(holes), "samples": int(missing.sum()), "longest": longest}
    sentence = (
        f"{format_count(len(holes), 'gap')} of {numbers['samples']} samples in all filled by "
        f"{gaps.fill}s, the longest of {longest:.4g} s"
    )
    report = make_report("gaps", sentence, known, filled, unit, numbers)
    return filled, grid._replace(at=np.insert(at, after + 1, new)), report


def interpolate(at: Floats, values: Floats, wanted: Floats, by: str) -> Floats:
    """Give values between samples: on the `line` or the C² cubic `spline` through them."""
    if by == "line":
        return np.interp(wanted, at, values)
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(at, values)(wanted), dtype=np.float64)


def _gap_message(
    width: float, dt: float, gaps: Gaps | None, number: int, longest: float
) -> str:
    """Say what is missing in a gap of so many steps, and what can be done about it."""
    missing = round(width) - 1
    count = f"{format_count(missing, 'sample')} {'is' if missing == 1 else 'are'}"
    more = f" ({format_count(number, 'gap')} in all)" if number > 1 else ""
    if gaps is None:
        # The `gaps.at_most` of three digits, rounded up, that the longest gap needs.
        digit = 10.0 ** (floor(log10(longest)) - 2)
        needed = ceil(longest / digit * (1 - STEP_TOLERANCE)) * digit
        at_most = f"{needed:.3g} s" if needed >= 1.0 else f"{needed * 1e3:.3g} ms"
        way = gap_hint(at_most, "it" if number == 1 else "them all")
    else:
        way = f"`gaps.at_most` allows {gaps.at_most:.6g} s"
    return (
        f"{count} missing before this row: {width * dt:.6g} s to it, {dt:.6g} s as a rule"
        f"{more}: {way}"
    )


# Another grid.


MAX_ALIAS_GAIN = 0.1
"""What a low-pass may leave of an amplitude at half the new rate: a tenth, 20 dB down."""

UNEVEN_STEP_TOLERANCE = 1e-2
"""As `STEP_TOLERANCE`, against the mean of uneven steps: their half rate is no sharper than that."""


class ResamplingGrid(NamedTuple):
    """A grid that is `refinement` as fine as the one that was asked for, and that one's step [s].

    A record that loses rate is filtered in between, on the finer grid.
    """

    step: float
    refinement: int


def resampling_grid(
    wanted: Resample, removal: Removal, grid: TimeGrid, display_path: str
) -> ResamplingGrid:
    """Give the grid to go by: as fine as the record's own, or finer.

    Raises
    ------
    RecordError
        When frequencies would fold, because no low-pass is stated that keeps them out.
    """
    step = wanted.step or 1 / (wanted.rate or 1.0)
    same = STEP_TOLERANCE if grid.spread is None else UNEVEN_STEP_TOLERANCE
    refinement = max(1, ceil(step / grid.dt * (1 - same)))
    if refinement > 1:
        half, order = 1 / (2 * step), removal.order
        if removal.above is None or low_pass_gain(
            half, removal.above, order
        ) > MAX_ALIAS_GAIN * (1 + STEP_TOLERANCE):
            most = half * (1 / MAX_ALIAS_GAIN - 1) ** (-1 / (2 * order))
            # A hundredth less is clear of it in few digits, too.
            sentence = (
                f"resampling from {1 / grid.dt:.6g} to {2 * half:.6g} Hz would fold what is "
                f"above {half:.6g} Hz; state a low-pass that leaves a tenth of it or less "
                f"there, `remove: {{above: {0.99 * most:.3g} Hz, order: {order}}}` or lower"
            )
            raise record_error(display_path, sentence)
    return ResamplingGrid(step, refinement)


def resample_onto(
    values: Floats,
    grid: TimeGrid,
    wanted: Resample,
    target_grid: ResamplingGrid,
    display_path: str,
) -> Series:
    """Give samples on the grid to go by, which ends where the record does."""
    at, fine = grid.at, target_grid.step / target_grid.refinement
    n = len(values)
    length = (n - 1.0 if at is None else float(at[-1])) * grid.dt
    count = floor(length / fine * (1 + STEP_TOLERANCE)) + 1
    if at is None and abs(fine / grid.dt - 1) <= STEP_TOLERANCE:
        return Series(values, fine, grid.first)
    require_memory_to_load(display_path, 8 * count)
    if count < 2:
        raise record_error(
            display_path, f"the record lasts {length:.6g} s, less than `resample` asks for"
        )
    places = np.minimum(np.arange(count) * (fine / grid.dt), length / grid.dt)
    own = np.arange(float(n)) if at is None else at
    return Series(interpolate(own, values, places, wanted.by), fine, grid.first)


def decimate(series: Series, target_grid: ResamplingGrid) -> Series:
    """Give every sample that lies on the grid that was asked for."""
    return series._replace(
        values=series.values[:: target_grid.refinement].copy(), dt=target_grid.step
    )


def resampling_report(
    before: Floats,
    grid: TimeGrid,
    after: Series,
    target_grid: ResamplingGrid,
    wanted: Resample,
    unit: str,
) -> CleaningReport:
    """Give the report of a resampling: samples as they were, and between them."""
    numbers = {"step_before": grid.dt, "step_after": target_grid.step}
    was = f"{1 / grid.dt:.6g} Hz"
    if grid.spread is not None:
        least, most = grid.spread
        numbers |= {"least_step": least, "greatest_step": most}
        was = f"uneven steps of {least:.4g} to {most:.4g} s, {grid.dt:.4g} s in the mean,"
    sentence = f"resampled from {was} to {1 / target_grid.step:.6g} Hz by {wanted.by}s"
    return make_report("resample", sentence, before, after.values[:], unit, numbers)


# What is removed: trends, and what is outside a band.


Extension = Literal["even", "odd"]
"""How a filter continues the ends of samples: mirrored, without or with a change of sign."""


class Filtered(NamedTuple):
    """What a removal leaves; `before_high_pass` is that before a high-pass, None where there is none."""

    series: Series
    before_high_pass: Series | None
    report: CleaningReport


def remove(
    series: Series, wanted: Removal, unit: str, display_path: str, ends: Extension = "even"
) -> Filtered:
    """Give a series without its trend and what is outside a band, and the report of that.

    `unit` is the SI unit of the samples; `ends` is that of `high_pass`.

    Raises
    ------
    RecordError
        When a frequency has less than one period in the record, or is above half its rate.
    """
    remaining, before_high_pass, words = series.values[:], None, []
    if wanted.trend != "nothing":
        remaining = remaining - fit_trend(remaining, wanted.trend)
        words.append(f"the {wanted.trend}")
    if wanted.above is not None:
        _check_corner(wanted.above, "above", series, display_path)
        remaining = low_pass(remaining, series.dt, wanted.above, wanted.order)
        words.append(f"what is above {wanted.above:g} Hz")
    if wanted.below is not None:
        _check_corner(wanted.below, "below", series, display_path)
        before_high_pass = series._replace(values=remaining)
        remaining = high_pass(remaining, series.dt, wanted.below, wanted.order, ends)
        words.append(f"what is below {wanted.below:g} Hz")
    by = f" (Butterworth of order {wanted.order}, both ways)" if wanted.has_filters else ""
    removed = series.values[:] - remaining
    mean, drift = float(removed.mean()), float(removed[-1] - removed[0])
    sentence = (
        f"{join_words(words)} removed{by}: mean {mean:.4g} {unit}, from first to last sample "
        f"{drift:+.4g} {unit}"
    )
    if wanted.below is not None:
        sentence += f"; the first and the last {1 / wanted.below:.3g} s hang on its ends"
    numbers = {"mean": mean, "drift": drift}
    report = make_report("remove", sentence, series.values[:], remaining, unit, numbers)
    return Filtered(series._replace(values=remaining), before_high_pass, report)


def _check_corner(frequency: float, side: str, series: Series, display_path: str) -> None:
    """Make sure that a filter has something to work on."""
    low, high = 1 / ((len(series.values) - 1) * series.dt), 1 / (2 * series.dt)
    if not low <= frequency < high:
        bounds = f"at least {low:.6g} Hz, one period in the record, and below {high:.6g} Hz"
        sentence = f"`remove.{side}` must be {bounds}, half its rate; not {frequency:.6g} Hz"
        raise record_error(display_path, sentence)


def fit_trend(values: Floats, what: str) -> Floats:
    """Give the `mean` or the `line` (least squares) of samples, as many values."""
    n = len(values)
    if what == "mean":
        return np.broadcast_to(values.mean(), n)
    steps = np.arange(n) - (n - 1) / 2  # from the middle, mean and slope do not mix
    return np.asarray(values.mean() + (steps @ values) / (steps @ steps) * steps)


def low_pass(values: Floats, dt: float, frequency: float, order: int) -> Floats:
    """Give what is slower than a frequency [Hz]; see `high_pass`."""
    return _filter_zero_phase(values, dt, frequency, order, "lowpass", "odd")


def low_pass_gain(frequency: float, corner: float, order: int) -> float:
    """Give what `low_pass` leaves of an amplitude at a frequency [-]."""
    return 1 / (1 + (frequency / corner) ** (2 * order))


def high_pass(
    values: Floats, dt: float, frequency: float, order: int, ends: Extension = "even"
) -> Floats:
    """Give what is faster than a frequency, by a Butterworth filter run forwards and backwards.

    Parameters
    ----------
    values : ndarray, shape (n,)
    dt : float
        Their distance [s].
    frequency : float
        Where half the amplitude is left [Hz].
    order : int
        In each direction; both together fall by 12 dB an octave and order.
    ends : str
        How each end is continued by one period of the frequency: mirrored as it is (`even`), or
        about its last sample (`odd`).

    Notes
    -----
    The line of least squares goes first: it is slow. Ends that are mirrored as they are leave
    the least of slow parts behind.
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


# The window; splines from samples to ü, and displacements from it.


EDGE_TOLERANCE = 1e-6
"""Share of a step by which the edge of a window may miss a sample: rounding of its time."""

TIME_FORMAT = ".15g"
"""Format of a time: seconds since 1970 have ten digits before the point."""


def window_range(series: Series, window: Window | None, display_path: str) -> tuple[int, int]:
    """Give the first and the last sample of a window, 0-based.

    Raises
    ------
    RecordError
        When the window does not lie in the record, or holds fewer than two samples.
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
    for key, t, at in (("from", window.start, first), ("to", window.to, last)):
        if not wrong and not 0 <= at < len(series.values):
            side = "before the beginning" if at < 0 else "behind the end"
            wrong = f"`window.{key}`, {t:{TIME_FORMAT}} s, is {side} of"
    sentence = (
        f"{wrong or 'the window must hold two samples of'} the record, which runs from "
        f"{series.first:{TIME_FORMAT}} s to {until:{TIME_FORMAT}} s in steps of {series.dt:.6g} s"
    )
    raise record_error(display_path, sentence)


def _sample_number(t: float, series: Series) -> float:
    """Steps from the first sample to a time, within what a whole number can be made of."""
    return max(-1e18, min(1e18, (t - series.first) / series.dt))


def cut_window(motion: Samples, first: int, last: int, n: int) -> Samples:
    """Give the motion from the first to the last of n samples of the record."""
    finer = (len(motion.u_dd) - 1) // (n - 1)
    part = first * finer, last * finer + 1
    u = None if motion.u is None else motion.u[slice(*part)]
    return motion._replace(u_dd=slice_signal(motion.u_dd, *part), u=u)


def from_acceleration(series: Series) -> Samples:
    """Give samples of acceleration as they are, linear between them."""
    return Samples(series.values, series.dt)


def from_velocity(series: Series) -> Samples:
    """Give the derivative of the quadratic spline through samples of velocity.

    Notes
    -----
    The spline's pieces meet midway between samples, where its derivative bends. So ü is given
    at every half step, which holds each bend: linear between those, it is the spline's
    derivative exactly.
    """
    from scipy.interpolate import make_interp_spline

    n = len(series.values)
    spline = make_interp_spline(np.arange(n), series.values[:], k=min(2, n - 1))
    u_dd = np.asarray(spline(np.arange(2 * n - 1) / 2, 1), dtype=np.float64) / series.dt
    return Samples(u_dd, series.dt / 2)


def from_displacement(series: Series) -> Samples:
    """Give the second derivative of the C² cubic spline through samples of displacement.

    Notes
    -----
    Not-a-knot at the ends. The second derivative is linear between the samples.
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
    """Return the part of the displacement of samples that is faster than a frequency, twice.

    Parameters
    ----------
    motion : Samples
        With its slow parts.
    frequency, order
        As in `high_pass`.

    Returns
    -------
    u : ndarray, shape (n,)
        Displacement [m].
    otherwise : ndarray, shape (n,)
        The same with another continuation of the ends: what both differ by is uncertain.

    Notes
    -----
    The double integral of ü, linear between its samples, less its drift, through the filter.
    Filtered before the integration, what an end leaves of slow parts would grow to be most of
    u. What is left lies within a period of either end, where u depends on how it is continued:
    mirrored about its last sample, which suits slow parts, or mirrored as it is, which suits a
    seat-test signal without any. What a continuation leaves of slow parts adds to u, so the
    one with the smaller RMS is u.
    """
    u_dd, dt = motion.u_dd[:] - fit_trend(motion.u_dd[:], "line"), motion.dt
    u_d = np.zeros_like(u_dd)
    np.cumsum((u_dd[1:] + u_dd[:-1]) * (dt / 2), out=u_d[1:])
    u_d -= u_d.mean()
    u = np.zeros_like(u_dd)
    np.cumsum(u_d[:-1] * dt + (2 * u_dd[:-1] + u_dd[1:]) * (dt * dt / 6), out=u[1:])
    span = np.linspace(-1.0, 1.0, len(u))
    # An acceleration that is off by a line drifts by a cubic.
    u -= np.polynomial.Legendre.fit(span, u, min(3, len(u) - 1), domain=[-1, 1])(span)
    extensions: tuple[Extension, ...] = "odd", "even"
    found = [
        _filter_zero_phase(u, dt, frequency, order, "highpass", ends) for ends in extensions
    ]
    least, most = sorted(found, key=lambda values: float(values @ values))
    return least, most
