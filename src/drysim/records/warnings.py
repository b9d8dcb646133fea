"""Warnings about a record that may affect the results.

=====================  ===========================================================
record-clipped         peaks cut off at the largest or smallest value
record-frozen          a value repeated amid a motion
record-rises           samples that rise evenly, as times do
record-rows            rows of several sensors, or one series across the rows (in `layout`)
record-unit            a mean that is gravity in another unit
record-large           a vibration as strong as no floor has
record-still           samples that are all equal
record-mean            a mean as of gravity or of a sensor offset
record-filled          a large share of filled gaps
record-lost            RMS lost in resampling
record-interpolated    sampling too coarse for linear or spline interpolation
displacement-ends      displacement that depends on how the record is continued
=====================  ===========================================================

Each warning proposes a remedy in terms of scenario keys. A mean near 9.81 m/s² is an error
(`check_gravity`) unless the scenario keeps it.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import asin, ceil, pi, sqrt

import numpy as np

from drysim.core.model import BLOCK_SIZE, Floats, Samples, Signal, mean_and_std
from drysim.errors import WarningMessage
from drysim.records import SI
from drysim.records.artefacts import (
    MIN_CLIPPED_SAMPLES,
    clipped_peaks,
    extremes,
    frozen_stretches,
)
from drysim.records.clean import METHODS, STEP_TOLERANCE, CleaningReport
from drysim.records.columns import record_error
from drysim.records.level import GRAVITY, Level, is_gravity, measure_level
from drysim.records.options import (
    SUGGESTED_HIGH_PASS,
    TRENDS,
    Recorded,
    RecordedMotion,
)
from drysim.units import conversion_factor
from drysim.wording import format_deviation

STANDARD_GRAVITY = conversion_factor("g", "m/s²")
"""Acceleration of 1 g [m/s²]."""

MIN_SAMPLES = 16
"""With fewer samples, a record is taken as an intentionally piecewise linear motion."""

UNDERSAMPLED = "the sampling is too coarse for the high frequencies"

LINEAR_CORNER, SPLINE_CORNER = 0.05, 0.15
"""Shares of the sampling rate below which lines and splines preserve the RMS within 1 %.

A second-order low-pass with this corner leaves little above it.
"""

NOTABLE_SHARE = 0.01
"""Share of samples, or of the RMS, from which a change affects the results."""

NEGLIGIBLE_RMS = 1e-12
"""Ratio of RMS about the mean to mean below which the RMS is rounding."""

MAX_QUOTED_UNCERTAINTY = 0.5
"""Relative uncertainty from which a number would suggest more knowledge than there is."""


def artefact_warnings(
    record: Recorded, values: Signal, start: int, unit: str
) -> Iterator[WarningMessage]:
    """Warn of clipped peaks and frozen stretches; NaN is ignored.

    `start` is the number of samples of the record before `values`.
    """
    low, high = extremes(values)
    for limit, name in ((low, "smallest"), (high, "largest")):
        # Zeros before and after a shock are not clipped.
        peaks = clipped_peaks(values, limit) if low < high and limit else []
        if peaks:
            first, count = start + peaks[0].first + 1, sum(peak.length for peak in peaks)
            sentence = (
                f"{record.named}: {count} samples look clipped, the first is sample {first}: "
                f"runs of {MIN_CLIPPED_SAMPLES} or more equal the {name} value, {limit:.4g} "
                f"{unit}, which the signal reaches at full slope; measure with a wider range"
            )
            numbers = {"limit": limit, "sample": first, "samples": count}
            yield WarningMessage("record-clipped", sentence, numbers)
    stretches = frozen_stretches(values)
    if stretches:
        longest = max(stretches, key=lambda stretch: stretch.length)
        first, last = (start + longest.first + k for k in (1, longest.length))
        more = f", the longest of {len(stretches)} such stretches" if stretches[1:] else ""
        sentence = (
            f"{record.named}: samples {first} to {last} repeat one value, "
            f"{longest.value:.4g} {unit}, amid a motion{more}: a frozen sensor, a lost signal "
            "or a pause; `window` selects a part without it"
        )
        count = sum(stretch.length for stretch in stretches)
        numbers = {"sample": first, "samples": count, "value": longest.value}
        yield WarningMessage("record-frozen", sentence, numbers)


def rising_warnings(record: Recorded, values: Signal, column: str) -> Iterator[WarningMessage]:
    """Warn of an acceleration that rises evenly; of a long record only a block is read."""
    part = values[:BLOCK_SIZE]
    if len(part) < MIN_SAMPLES or not rises_evenly(part):
        return
    sentence = (
        f"{record.named}: {column} rises evenly from {part[0]:.6g} to {part[-1]:.6g} m/s²: it "
        "looks like times or sample numbers, not like acceleration; select another column"
    )
    yield WarningMessage("record-rises", sentence, {"first": part[0], "last": part[-1]})


def rises_evenly(x: Floats) -> bool:
    """Whether every sample is above the one before it, and most of them by the same step."""
    steps = np.diff(x)
    if not (len(steps) and (steps > 0).all()):
        return False
    usual = float(np.median(steps))
    return float(np.median(np.abs(steps - usual))) <= 0.25 * usual


def describe_wrong_unit(level: Level, unit: str | None) -> str | None:
    """Return why the unit of ü is suspected, and a remedy; None if it is not.

    The level is that before clean-up [m/s²]; `unit` is None if the file contains it.
    """
    for wrong, right, factor in (
        ("m/s2", "g", STANDARD_GRAVITY),
        ("g", "m/s2", 1 / STANDARD_GRAVITY),
    ):
        if level.scaled(factor).has_gravity and level.spread < abs(level.rest):
            is_stated = unit and conversion_factor(unit, "m/s²") == conversion_factor(
                wrong, "m/s²"
            )
            remedy = f"`unit: {right}`" if is_stated else f"`scale: {factor:.6g}`"
            return (
                f"the mean before clean-up is {level.mean:.4g} m/s², as of gravity in {right} "
                f"with the unit {wrong}: if the unit is wrong, {remedy} corrects it"
            )
    return None


def unit_warnings(record: RecordedMotion, level: Level) -> Iterator[WarningMessage]:
    """Warn of a mean before clean-up that is gravity in another unit."""
    if record.quantity == "acceleration" and record.scale == 1.0:
        suspicion = describe_wrong_unit(level, record.unit)
        if suspicion:
            numbers = {"mean": level.mean, "rms_about_mean": level.spread}
            yield WarningMessage("record-unit", f"{record.named}: {suspicion}", numbers)


def strength_warnings(
    record: Recorded, values: Signal, dt: float, level: Level
) -> Iterator[WarningMessage]:
    """Warn of an acceleration without motion, or as large as one in mm/s² read as m/s².

    Notes
    -----
    From the mean square ω² = RMS{dü/dt}² / RMS{ü}² follows RMS{u} >= RMS{ü} / ω², by Jensen's
    inequality. A strong vibration of machines has high frequencies, and a small u.
    """
    rms = level.spread
    if len(values) < MIN_SAMPLES:
        return
    if rms <= NEGLIGIBLE_RMS * abs(level.mean):
        sentence = (
            f"{record.named}: all its samples are {level.mean:.4g} m/s²: it has no motion"
        )
        yield WarningMessage("record-still", sentence, {"mean": level.mean})
    elif rms > LARGE_RMS:
        angle = sqrt(6 * max(1 - rms_share_of_lines(values, rms) ** 2, 1e-12))  # ω dt
        cycles, travel = len(values) * angle / (2 * pi), rms * (dt / angle) ** 2
        if cycles > MIN_CYCLES and travel > LARGE_TRAVEL:
            sentence = (
                f"{record.named}: the RMS about the mean, {rms:.4g} m/s² or "
                f"{rms / STANDARD_GRAVITY:.3g} g, is more than any floor or seat has: check "
                "unit and `scale` "
                f"(in mm instead of m it would be {rms / 1000:.4g} m/s²)"
            )
            yield WarningMessage("record-large", sentence, {"rms_about_mean": rms})


LARGE_RMS, LARGE_TRAVEL = 100.0, 0.01
"""RMS of ü [m/s²] and of u [m] that no seat or floor has at once: 10 g at 16 Hz."""

MIN_CYCLES = 10
"""Cycles of a vibration; a shock has fewer, and may be as strong."""


CUT_OFF = "cut these zeros off, with `rows` or in the file"
"""Remedy for a record that is padded with zeros."""


def check_gravity(record: RecordedMotion, level: Level) -> None:
    """Raise RecordError if ü at rest looks like gravity that is not to be kept."""
    rests = {level.rest, level.rest / (record.scale or 1.0)}  # before or after scaling
    if any(map(is_gravity, rests)) and record.gravity == "refuse":
        high_pass = record.remove.yaml_with(below=SUGGESTED_HIGH_PASS)
        if level.mean_is_offset:
            observation = f"the mean of ü is {level.mean:.4g} m/s²"
            removal = record.remove.yaml_with(trend=_trend_to_remove(record))
            remedy = f"remove it with {removal} or a high-pass, {high_pass}"
        elif level.padding_text:
            mean = f"the mean of ü without them is {level.rest:.4g} m/s²"
            observation = f"{level.padding_text}, and {mean}"
            remedy = f"{CUT_OFF} and remove it"
        else:
            observation = f"at rest ü is {level.rest:.4g} m/s²"
            removal = record.remove.yaml_with(trend="rest")
            remedy = f"remove it with {removal} or a high-pass, {high_pass}"
        sentence = (
            f"{observation}, which looks like gravity: {remedy}, or keep it with "
            "`gravity: keep`"
        )
        raise record_error(str(record.path), sentence)


def vertical_warnings(record: Recorded, mean: float) -> Iterator[WarningMessage]:
    """Warn of a mean of z̈ [m/s²] that changes the normal force by more than 1 %.

    Raises
    ------
    RecordError
        If it looks like gravity, which the normal force has already, or exceeds it.
    """
    remedy = f"{record.remove.yaml_with(trend='mean')} removes it"
    if is_gravity(mean):
        sentence = f"the mean of z̈ is {mean:.4g} m/s², which looks like gravity: {remedy}"
        raise record_error(str(record.path), f"{sentence}; F_N = m (g + z̈) has it already")
    if mean <= -GRAVITY:
        sentence = (
            f"the mean of z̈ is {mean:.4g} m/s², so that nothing presses the mass: {remedy}"
        )
        raise record_error(str(record.path), sentence)
    if abs(mean) > NOTABLE_SHARE * GRAVITY:
        change = f"{_percent(abs(mean) / GRAVITY)} {'above' if mean > 0.0 else 'below'}"
        sentence = (
            f"{record.named}: the mean of z̈ is {mean:.4g} m/s², so that the normal force is "
            f"{change} the weight on average; {remedy}"
        )
        yield WarningMessage("record-mean", sentence, {"mean": mean})


def _trend_to_remove(record: RecordedMotion) -> str:
    """Return the trend whose removal makes the mean of ü zero: a line for velocity."""
    return "line" if record.quantity == "velocity" else "mean"


def mean_warnings(
    record: RecordedMotion, motion: Samples, level: Level
) -> Iterator[WarningMessage]:
    """Warn of an offset of u where it is known, else of ü, whose level is given."""
    name, unit = "ü", "m/s²"
    if motion.u is not None and not any(level.padding):
        level, name, unit = measure_level(motion.u), "u", "m"
    if record.gravity == "refuse" and level.has_offset:
        mean, spread, rest = level.mean, level.spread, level.rest
        if level.mean_is_offset:
            observation = f"the mean of {name} is {mean:.4g} {unit}"
            remedy = _mean_remedy(record)
        elif level.padding_text:
            without = f"the mean of {name} without them is {rest:.4g} {unit}"
            observation = f"{level.padding_text}, and {without}"
            remedy = f"{CUT_OFF}, and remove the mean of the rest"
        else:
            observation = f"{name} at rest, at an end of the record, is {rest:.4g} {unit}"
            removal = _rest_remedy(record)
            remedy = f"the mean, {mean:.4g} {unit}, contains motion as well; {removal}"
        sentence = (
            f"{record.named}: {observation}, large compared with the RMS about the mean, "
            f"{spread:.4g} {unit}; {remedy}"
        )
        numbers = {"mean": mean, "rms_about_mean": spread, "rest": rest}
        yield WarningMessage("record-mean", sentence, numbers)


def _rest_remedy(record: RecordedMotion) -> str:
    """Return how to remove an offset that an end of the record shows."""
    if record.remove.any or record.quantity == "velocity":
        return "subtract this offset in the file"
    return f"{record.remove.yaml_with(trend='rest')} removes this offset"


def _mean_remedy(record: RecordedMotion) -> str:
    """Return how to remove a mean, given what is removed already."""
    trend, removed, below = _trend_to_remove(record), record.remove.trend, record.remove.below
    if below is not None:
        return (
            f"the high-pass at {below:g} Hz has removed the mean of the whole record; this "
            "one comes from its ends or from a short window"
        )
    if TRENDS.index(removed) < TRENDS.index(trend):
        remedy = record.remove.yaml_with(trend=trend)
        return f"{remedy} removes a sensor offset"
    return f"the {removed} of the whole record is removed already; this window has its own"


def filling_warnings(
    file: str, reports: tuple[CleaningReport, ...], n: int, unit: str
) -> Iterator[WarningMessage]:
    """Warn if more than 1 % of the n samples in the window were interpolated."""
    filled = sum(report.numbers.get("samples", 0) for report in reports)
    if (share := filled / n if n else 0.0) > NOTABLE_SHARE:
        change = ""
        before, after = reports[-1].rms_before, reports[-1].rms_after
        if abs(after - before) > NOTABLE_SHARE * before:
            change = f", which changed the RMS from {before:.4g} to {after:.4g} {unit}"
        sentence = (
            f"{file}: {_percent(share)} of the samples were interpolated, not measured"
            f"{change}; use a record without gaps, or a window without them"
        )
        yield WarningMessage("record-filled", sentence, {"share": share})


def _percent(share: float) -> str:
    """Return a share to two digits, never with an exponent."""
    return f"{float(f'{share * 100:.2g}'):g} %"


def resampling_warnings(
    record: Recorded, resampled: CleaningReport, rms: tuple[float, float]
) -> Iterator[WarningMessage]:
    """Warn if resampling changed the RMS about the mean by more than 1 %.

    `rms` is the low-passed RMS before and after.
    """
    before, after = rms
    rounding = NEGLIGIBLE_RMS * abs(resampled.mean_before)  # that of constant samples
    if abs(after - before) <= max(NOTABLE_SHARE * before, rounding):
        return
    by = record.resample.by if record.resample else ""
    remedy = "`by: spline` loses less; " if by == "line" else ""
    sentence = (
        f"{record.named}: resampling by {METHODS.get(by, by)} changed the RMS by "
        f"{format_deviation(after / before - 1, digits=2)}: {UNDERSAMPLED}; "
        f"{remedy}{_low_pass_hint(record, SPLINE_CORNER / resampled.numbers['step_before'])}"
    )
    yield WarningMessage("record-lost", sentence, {"rms_before": before, "rms_after": after})


def interpolation_warnings(
    record: RecordedMotion, motion: Samples, rms: float, file_spacing: float
) -> Iterator[WarningMessage]:
    """Warn if linear or spline interpolation loses more than 1 % of RMS{ü}.

    `rms` is that of the samples of ü about the mean [m/s²], `file_spacing` the time step of the
    file [s], the mean for uneven times.
    """
    if len(motion.u_dd) < MIN_SAMPLES:
        return
    if record.quantity == "acceleration":
        yield from _linear_interpolation_warnings(
            record, motion.u_dd, motion.dt, rms, NOTABLE_SHARE * rms
        )
        return
    by = record.resample.by if record.resample else "spline"
    kept = rms_share_of_differentiation(motion, record.quantity, file_spacing, by)
    if kept < 1 - NOTABLE_SHARE:
        sentence = (
            f"{record.named}: the spline through its samples of {record.quantity} loses "
            f"{_percent(1 - kept)} of the RMS of ü: {UNDERSAMPLED}; "
            f"{_low_pass_hint(record, SPLINE_CORNER / file_spacing)}"
        )
        numbers = {"kept": kept, "step": motion.dt}
        yield WarningMessage("record-interpolated", sentence, numbers)


def force_warnings(record: Recorded, forces: Floats, dt: float) -> Iterator[WarningMessage]:
    """Warn if linear interpolation of forces loses more than 1 % of their mean."""
    if len(forces) >= MIN_SAMPLES:
        mean, rms = mean_and_std(forces)
        yield from _linear_interpolation_warnings(
            record, forces, dt, rms, NOTABLE_SHARE * abs(mean)
        )


def _linear_interpolation_warnings(
    record: Recorded, values: Signal, dt: float, rms: float, tolerance: float
) -> Iterator[WarningMessage]:
    """Warn if linear interpolation loses more than `tolerance` of the RMS about the mean."""
    kept = rms_share_of_lines(values, rms)
    if (1 - kept) * rms > tolerance:
        low_pass = _low_pass_hint(record, LINEAR_CORNER / dt)
        resample = f"`resample: {{rate: {required_refinement(kept) / dt:.6g} Hz, by: spline}}`"
        if (lost := 1 - rms_share_of_spline(values)) <= NOTABLE_SHARE:
            remedy = f"{resample} preserves it; {low_pass}"
        else:
            corner = float(f"{SPLINE_CORNER / dt:.2g}")
            remedy = (
                f"a spline would lose {_percent(lost)}, too: {UNDERSAMPLED}; {low_pass}; "
                f"together with {resample} {corner:.6g} Hz is enough"
            )
        if (spike := _spike(values)) is not None:
            remedy = (
                f"most of it at one sample, {values[spike : spike + 1][0]:.6g} "
                f"{SI[record.quantity]} at {spike * dt:.6g} s; if that is a fault, empty its "
                f"cell and fill it with `gaps`; else {remedy}"
            )
        sentence = (
            f"{record.named}: linear interpolation reduces the RMS from {rms:.4g} to "
            f"{kept * rms:.4g} {SI[record.quantity]}, by {_percent(1 - kept)}: "
            f"{remedy}"
        )
        yield WarningMessage("record-interpolated", sentence, {"kept": kept, "step": dt})


def _spike(values: Signal) -> int | None:
    """Return the sample that makes most of the squared differences of a signal, if one does."""
    total, largest, index = 0.0, 0.0, 0
    for begin in range(0, len(values) - 2, BLOCK_SIZE):
        squares = np.square(np.diff(values[begin : begin + BLOCK_SIZE + 2]))
        total += float(squares[:BLOCK_SIZE].sum())
        beside = np.minimum(squares[1:], squares[:-1])
        if float(beside.max()) > largest:
            largest, index = float(beside.max()), begin + int(beside.argmax()) + 1
    return index if 4 * largest > total else None


def _low_pass_hint(record: Recorded, corner: float) -> str:
    """Return how to remove frequencies above a corner [Hz], given what is removed already."""
    below = record.remove.below
    if below is not None and below >= corner:
        return "record at a higher rate"
    remedy = record.remove.yaml_with(above=float(f"{corner:.2g}"))
    return f"a low-pass, {remedy} or lower, removes the high frequencies"


def displacement_warnings(
    record: RecordedMotion, u: Signal | None, u_other: Signal | None
) -> Iterator[WarningMessage]:
    """Warn if RMS{u} depends by more than 1 % on the extension of the record beyond its ends.

    `u_other` is u with the other extension. The difference is uncorrelated with u, so it
    contributes with its square.
    """
    if u is None or u_other is None or not record.remove.below:
        return
    squares, difference = float(u[:] @ u[:]), u[:] - u_other[:]
    share = 0.5 * float(difference @ difference) / squares if squares else 0.0
    if share > NOTABLE_SHARE:
        if share > MAX_QUOTED_UNCERTAINTY:
            state = "is not determined by this record: most of it comes from"
        else:
            state = f"is uncertain by about {_percent(share)}: it depends on"
        sentence = (
            f"{record.named}: RMS{{u}}, and with it T_x, {state} how the record is continued "
            "beyond its ends; exclude the first and the last "
            f"{1.0 / record.remove.below:.3g} s with `excitation.window`, or use a longer "
            "record or a higher `remove.below`"
        )
        yield WarningMessage("displacement-ends", sentence, {"share": share})


# Share of the RMS that interpolation preserves.


def rms_share_of_lines(values: Signal, rms: float) -> float:
    """Return the share of the RMS about the mean that linear interpolation preserves.

    Notes
    -----
    A signal sampled above twice its highest frequency has the RMS of its samples. Linear
    interpolation loses one sixth of the mean square of the differences between neighbours from
    the mean square; for a sine of frequency f this is the share 2/3 sin²(π f dt).
    """
    square, squared_differences = rms * rms, 0.0
    for begin in range(0, len(values) - 1, BLOCK_SIZE):
        squared_differences += float(
            np.square(np.diff(values[begin : begin + BLOCK_SIZE + 1])).sum()
        )
    lost = squared_differences / (len(values) - 1) / 6
    return sqrt(max(0.0, 1 - lost / square)) if square else 1.0


def required_refinement(kept: float) -> int:
    """Return the refinement of the grid at which linear interpolation loses 1 % of the RMS.

    The signal is treated as a sine at the frequency where lines preserve the share `kept`.
    """
    angles = [asin(sqrt(min(1.0, 1.5 * (1 - share**2)))) for share in (kept, 1 - NOTABLE_SHARE)]
    return ceil(angles[0] / angles[1] * (1 + STEP_TOLERANCE)) + 1


def rms_share_of_spline(values: Signal) -> float:
    """Return the share of the RMS about the mean that cubic spline interpolation preserves.

    Notes
    -----
    Computed from the power spectrum. For a sine with z = 2π f dt the mean square of the spline
    is B7/B3², with the spectra of the sampled B-splines of degree 7 and 3; see Unser, Splines:
    a perfect fit for signal and image processing (1999). Only the first block of a long signal
    is used.
    """
    z, power = _power_spectrum(values[:BLOCK_SIZE])
    degree_7 = 2416 + 2382 * np.cos(z) + 240 * np.cos(2 * z) + 2 * np.cos(3 * z)
    kept = power @ (degree_7 / 5040 * (3 / (2 + np.cos(z))) ** 2)
    return sqrt(kept / power.sum())


def rms_share_of_differentiation(
    motion: Samples, quantity: str, file_spacing: float, by: str
) -> float:
    """Return the share of RMS{ü} preserved by the spline through velocity or displacement.

    Parameters
    ----------
    motion : Samples
        Contains ü from the spline.
    quantity : {'velocity', 'displacement'}
    file_spacing : float
        Time step of the file [s]; a finer step in `motion` means that it was resampled.
    by : {'line', 'spline'}
        Interpolation of the resampling.

    Notes
    -----
    Computed from the power spectrum of ü and the frequency response of the spline for a sine
    with z = 2π f dt. Up to a quarter of the sampling rate the spline steepens a sine by as much
    as linear interpolation of its derivative loses. After resampling, content above the old
    Nyquist frequency is an image of the rest.
    """
    stride = 2 if quantity == "velocity" else 1  # the spline through velocity has knots midway
    dt = motion.dt * stride
    z, power = _power_spectrum(motion.u_dd[stride - 1 :: stride])
    if file_spacing > dt * (1 + STEP_TOLERANCE):
        z *= file_spacing / dt
        power, images, z = power[z < np.pi], power[z >= np.pi].sum(), z[z < np.pi]
        gain = np.sinc(z / 2 / np.pi) ** 2
        if by == "spline":
            gain *= gain * 3 / (2 + np.cos(z))
        kept = power.sum() + images
    else:
        if quantity == "displacement":
            gain = 6 * (1 - np.cos(z)) / (2 + np.cos(z)) / z**2
        else:
            gain = 8 * np.sin(z / 2) / (3 + np.cos(z)) / z
        kept = (power * (1 - 2 / 3 * np.sin(z / 2) ** 2)).sum()
    total = (power / gain**2).sum()
    return float(np.sqrt(kept / total)) if total else 1.0


def _power_spectrum(values: Floats) -> tuple[Floats, Floats]:
    """Return the angles z = 2π f dt above 0, and the power at each, shape (n // 2,)."""
    power = np.asarray(np.square(np.abs(np.fft.rfft(values)[1:])), dtype=np.float64)
    z = 2 * np.pi / len(values) * np.arange(1.0, len(power) + 1)
    return z, power
