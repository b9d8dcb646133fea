"""What a reader of the numbers should know of a record.

Samples that look clipped; a mean that gravity or an offset of the sensor left; much that was
filled in, or lost by resampling; samples too far apart for the lines or splines between them;
and a displacement that depends on how the record is continued beyond its ends. Each warning
says what to do about it, in the words of the scenario and beside what it asks for already.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import asin, ceil, sqrt

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import BLOCK, Samples, Signal, blocks, moments
from drysim.errors import Caution
from drysim.records import SI
from drysim.records.clean import SAME, Report
from drysim.records.columns import Floats
from drysim.records.options import HIGH_PASS, TRENDS, Recorded, RecordedMotion

GRAVITY = 9.81
"""Standard gravity as the paper rounds it [m/s²]."""

NEAR_GRAVITY = 0.05
"""An accelerometer lying a little askew still shows gravity within this share."""

FEWEST = 16
"""Fewer samples are the corners of a motion that is meant to be linear between them."""

TOO_FAR = "the samples are too far apart for what is fast"

KEPT_BY_LINES, KEPT_BY_SPLINES = 0.05, 0.15
"""Shares of the rate below which lines and splines keep the RMS to a hundredth, and a low-pass
of second order at such a frequency leaves little above it."""

LARGE_MEAN = 0.1
"""Share of the RMS about the mean from which a mean shows in the numbers."""

MUCH = 0.01
"""Share of samples, or of the RMS, from which a clean-up, or what straight lines between
samples take, shows in the numbers."""

FLAT = 4
"""This many equal samples on end, at an extreme, are a clipped peak and no chance."""


def clipped(file: str, values: Signal, unit: str) -> Iterator[Caution]:
    """Say where the samples stand still at their largest or smallest value; NaN is none."""
    low, high = extremes(values)
    for limit, name in ((low, "smallest"), (high, "largest")):
        # Rest before and after a shock is no peak.
        if not low < high or limit == 0:
            continue
        at = places(values, limit)
        first = np.flatnonzero(np.diff(at, prepend=-2) > 1)
        lengths = np.diff(first, append=len(at))
        peaks = lengths >= FLAT
        if peaks.any():
            start, count = int(at[first[peaks][0]]) + 1, int(lengths[peaks].sum())
            sentence = (
                f"{file}: {count} samples look clipped, the first of them sample {start}: "
                f"{FLAT} or more on end are the {name} of all, {limit:.4g} {unit}; measure "
                "with a wider range"
            )
            numbers = {"limit": limit, "sample": start, "samples": count}
            yield Caution("record-clipped", sentence, numbers)


def extremes(values: Signal) -> tuple[float, float]:
    """Give the least and the greatest sample; NaN is neither."""
    ends = [(np.fmin.reduce(part), np.fmax.reduce(part)) for part in blocks(values)]
    low, high = zip(*ends, strict=True)
    return float(np.fmin.reduce(low)), float(np.fmax.reduce(high))


def places(values: Signal, wanted: float) -> NDArray[np.intp]:
    """Give the 0-based samples of one value."""
    found = [np.flatnonzero(part == wanted) for part in blocks(values)]
    return np.concatenate([at + number * BLOCK for number, at in enumerate(found)])


def gravity_left(record: RecordedMotion, mean: float) -> Iterator[str]:
    """Say that gravity seems left in ü, by its mean, unless the scenario keeps it."""
    means = {mean, mean / record.scale if record.scale else mean}  # a factor may come on top
    near = any(abs(abs(one) - GRAVITY) <= NEAR_GRAVITY * GRAVITY for one in means)
    if near and record.gravity == "refuse":
        trend = _trend(record)
        yield (
            f"the mean of ü is {mean:.4g} m/s², so gravity seems left in the record: "
            f"{record.remove.with_too(trend=trend)} takes it away, or a high-pass, "
            f"{record.remove.with_too(below=HIGH_PASS)}; `gravity: keep` states that it is to "
            "stay"
        )


def _trend(record: RecordedMotion) -> str:
    """Return the trend that takes a mean away: the mean of ü is that of a line of velocity."""
    return "line" if record.quantity == "velocity" else "mean"


def found(
    record: RecordedMotion, motion: Samples, level: tuple[float, float]
) -> Iterator[Caution]:
    """Warn of a large mean of u where it is known, else of ü, whose mean and RMS is `level`."""
    (mean, spread), name, unit = level, "ü", "m/s²"
    if motion.u is not None:
        (mean, spread), name, unit = moments(motion.u), "u", "m"
    if record.gravity == "refuse" and abs(mean) > LARGE_MEAN * spread:
        sentence = (
            f"{record.named}: the mean of {name} is {mean:.4g} {unit}, large against the RMS "
            f"about it, {spread:.4g} {unit}; {_remedy(record)}"
        )
        yield Caution("record-mean", sentence, {"mean": mean, "rms_about_mean": spread})


def _remedy(record: RecordedMotion) -> str:
    """Say what takes away a mean that is an offset of the sensor, beside what is removed."""
    trend, removed, below = _trend(record), record.remove.trend, record.remove.below
    if below is not None:
        return (
            f"the high-pass at {below:g} Hz has taken away that of the whole record: this one "
            "is of its ends or of a short window"
        )
    if TRENDS.index(removed) < TRENDS.index(trend):
        way = record.remove.with_too(trend=trend)
        return f"{way} takes away what is an offset of the sensor"
    return f"the {removed} of the whole record is removed, and this part has one of its own"


def much_filled(file: str, report: Report | None, n: int) -> Iterator[Caution]:
    """Say when more than a hundredth of the samples was filled in."""
    if report and (share := report.numbers["samples"] / n) > MUCH:
        sentence = (
            f"{file}: {share * 100:.2g} % of the samples were filled in, not measured; "
            "take a record without gaps, or a window without them"
        )
        yield Caution("record-filled", sentence, {"share": share})


def much_lost(
    record: Recorded, resampled: Report, rms: tuple[float, float]
) -> Iterator[Caution]:
    """Warn when resampling changed the RMS about the mean by more than a hundredth.

    `rms` are those before and after, of what a low-pass leaves.
    """
    before, after = rms
    if abs(after - before) <= MUCH * before:
        return
    by = record.resample.by if record.resample else ""
    way = "`by: spline` loses less; " if by == "line" else ""
    sentence = (
        f"{record.named}: resampling by {by}s changed the RMS by "
        f"{(after / before - 1) * 100:+.2g} %: {TOO_FAR}; "
        f"{way}{_low_pass(record, KEPT_BY_SPLINES / resampled.numbers['step_before'])}"
    )
    yield Caution("record-lost", sentence, {"rms_before": before, "rms_after": after})


def interpolated(
    record: RecordedMotion, motion: Samples, rms: float, own: float
) -> Iterator[Caution]:
    """Warn when linear interpolation, or the spline, takes more than a hundredth of RMS{ü}.

    `rms` is that of ü at its samples, about the mean [m/s²]; `own` is the step of the samples
    in the file, the mean one where they are uneven [s].
    """
    if len(motion.u_dd) < FEWEST:
        return
    if record.quantity == "acceleration":
        yield from _joined(record, motion.u_dd, motion.dt, rms, MUCH * rms)
        return
    by = record.resample.by if record.resample else "spline"
    kept = kept_by_splines(motion, record.quantity, own, by)
    if kept < 1 - MUCH:
        sentence = (
            f"{record.named}: the spline through its samples of {record.quantity} loses "
            f"{(1 - kept) * 100:.2g} % of the RMS of ü: {TOO_FAR}; "
            f"{_low_pass(record, KEPT_BY_SPLINES / own)}"
        )
        numbers = {"kept": kept, "step": motion.dt}
        yield Caution("record-interpolated", sentence, numbers)


def interpolated_force(record: Recorded, forces: Floats, dt: float) -> Iterator[Caution]:
    """Warn when linear interpolation of forces takes more than a hundredth of their mean."""
    if len(forces) >= FEWEST:
        mean, rms = moments(forces)
        yield from _joined(record, forces, dt, rms, MUCH * abs(mean))


def _joined(
    record: Recorded, values: Signal, dt: float, rms: float, much: float
) -> Iterator[Caution]:
    """Warn when lines between samples take more than `much` of their RMS about the mean."""
    kept = kept_by_lines(values, rms)
    if (1 - kept) * rms > much:
        low_pass = _low_pass(record, KEPT_BY_LINES / dt)
        resample = f"`resample: {{rate: {finer(kept) / dt:.6g} Hz, by: spline}}`"
        if (lost := 1 - kept_by_spline(values)) <= MUCH:
            way = f"{resample} keeps it; {low_pass}"
        else:
            corner = float(f"{KEPT_BY_SPLINES / dt:.2g}")
            way = (
                f"a spline would lose {lost * 100:.2g} %, too, as {TOO_FAR}; {low_pass}, and "
                f"beside {resample} {corner:.6g} Hz will do"
            )
        sentence = (
            f"{record.named}: linear interpolation leaves {kept * rms:.4g} of {rms:.4g} "
            f"{SI[record.measured]} RMS, {(1 - kept) * 100:.2g} % less than at the samples: "
            f"{way}"
        )
        yield Caution("record-interpolated", sentence, {"kept": kept, "step": dt})


def _low_pass(record: Recorded, corner: float) -> str:
    """Say how to take away what is fast, beside what is removed already [Hz]."""
    below = record.remove.below
    if below is not None and below >= corner:
        return "record it at a higher rate"
    way = record.remove.with_too(above=float(f"{corner:.2g}"))
    return f"a low-pass, {way} or lower, takes it away"


def ends_of_u(
    record: RecordedMotion, u: NDArray[np.float64] | None, otherwise: NDArray[np.float64] | None
) -> Iterator[Caution]:
    """Warn when RMS{u} depends by more than a hundredth on what is beyond the record's ends.

    `otherwise` is u above the high-pass with another continuation of the record. What it adds
    to u or takes away is not related to u, so it counts by its square.
    """
    if u is None or otherwise is None or not record.remove.below:
        return
    squares, apart = float(u @ u), u - otherwise
    share = 0.5 * float(apart @ apart) / squares if squares else 0.0
    if share > MUCH:
        sentence = (
            f"{record.named}: RMS{{u}}, and with it T_x, depends on how the record is "
            f"continued beyond its ends, by about {share * 100:.2g} %; leave out the first and "
            f"the last {1.0 / record.remove.below:.3g} s by `excitation.window`, take a longer "
            "record or a higher `remove.below`"
        )
        yield Caution("displacement-ends", sentence, {"share": share})


# What is kept between samples.


def kept_by_lines(values: Signal, rms: float) -> float:
    """Return the share of the RMS of samples about their mean that linear interpolation keeps.

    Notes
    -----
    A signal sampled above twice its highest frequency has the RMS of its samples. Of the mean
    square, straight lines lose a sixth of that of the steps from sample to sample: of a sine of
    frequency f, the share 2/3 sin²(π f dt).
    """
    square, steps = rms * rms, 0.0
    for at in range(0, len(values) - 1, BLOCK):
        steps += float(np.square(np.diff(values[at : at + BLOCK + 1])).sum())
    lost = steps / (len(values) - 1) / 6
    return sqrt(max(0.0, 1 - lost / square)) if square else 1.0


def finer(kept: float) -> int:
    """Return how many times finer a grid must be so that straight lines lose a hundredth.

    The samples count as a sine of the frequency at which lines keep this share of the RMS.
    """
    half_turns = [asin(sqrt(min(1.0, 1.5 * (1 - share**2)))) for share in (kept, 1 - MUCH)]
    return ceil(half_turns[0] / half_turns[1] * (1 + SAME)) + 1


def kept_by_spline(values: Signal) -> float:
    """Return the share of the RMS about the mean that a cubic spline through samples keeps.

    Notes
    -----
    By their power spectrum: of a sine sampled with z = 2π f dt the spline has the mean square
    B7/B3², with the spectra of the sampled B-splines of degree 7 and 3; see Unser, Splines: a
    perfect fit for signal and image processing (1999). Of a long signal the beginning counts.
    """
    z, power = _spectrum(values[:BLOCK])
    seventh = 2416 + 2382 * np.cos(z) + 240 * np.cos(2 * z) + 2 * np.cos(3 * z)
    kept = power @ (seventh / 5040 * (3 / (2 + np.cos(z))) ** 2)
    return sqrt(kept / power.sum())


def kept_by_splines(motion: Samples, quantity: str, own: float, by: str) -> float:
    """Return the share of RMS{ü} that is left of a record of velocity or displacement.

    `motion` has ü from the spline of its quantity, `own` is the step of the samples in the file
    [s]; where their step in `motion` is a finer one they were resampled, as `by` says.

    Notes
    -----
    By the power spectrum of ü and the gain of splines through a sine of z = 2π f dt. Up to a
    quarter of the rate, a spline steepens a sine by as much as the lines between the knots of
    its derivative lose. Resampled, what is above half of the old rate is an image of the rest.
    """
    every = 2 if quantity == "velocity" else 1  # ü bends between the samples of velocity
    dt = motion.dt * every
    z, power = _spectrum(motion.u_dd[every - 1 :: every])
    if own > dt * (1 + SAME):
        z *= own / dt
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
    whole = (power / gain**2).sum()
    return float(np.sqrt(kept / whole)) if whole else 1.0


def _spectrum(values: Floats) -> tuple[Floats, Floats]:
    """Return the angles z = 2π f dt above 0, and the power of samples at each."""
    power = np.asarray(np.square(np.abs(np.fft.rfft(values)[1:])), dtype=np.float64)
    z = 2 * np.pi / len(values) * np.arange(1.0, len(power) + 1)
    return z, power
