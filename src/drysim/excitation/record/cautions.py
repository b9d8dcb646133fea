"""What a reader of the numbers should know about a record."""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drysim.core.motion import Samples
from drysim.core.signal import BLOCK, Signal, blocks
from drysim.errors import Caution
from drysim.excitation.record.reports import Report
from drysim.excitation.record.spoken import TRENDS

if TYPE_CHECKING:
    from drysim.excitation.record import Record

GRAVITY = 9.81
"""Standard gravity as the paper rounds it [m/s²]."""

NEAR_GRAVITY = 0.05
"""An accelerometer lying a little askew still shows gravity within this share."""

LARGE_MEAN = 0.1
"""Share of the RMS about the mean from which a mean shows in the numbers."""

MUCH = 0.01
"""Share of samples, or of the RMS, from which a clean-up shows in the numbers."""

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


def found(record: Record, motion: Samples) -> Iterator[Caution]:
    """Give what the samples themselves show: gravity left in, or a large mean."""
    file = record.named
    name, unit, values = (
        ("u", "m", motion.u) if motion.u is not None else ("ü", "m/s²", motion.u_dd)
    )
    mean, spread = moments(values)
    numbers = {"mean": mean, "rms_about_mean": spread}
    if name == "ü" and abs(abs(mean) - GRAVITY) <= NEAR_GRAVITY * GRAVITY:
        sentence = (
            f"{file}: the mean of ü is {mean:.4g} m/s², so gravity seems left in the record; "
            f"{_remedy(record, 'it')}"
        )
        yield Caution("record-gravity", sentence, numbers)
    elif abs(mean) > LARGE_MEAN * spread:
        sentence = (
            f"{file}: the mean of {name} is {mean:.4g} {unit}, large against the RMS about it, "
            f"{spread:.4g} {unit}; {_remedy(record, 'what is an offset of the sensor')}"
        )
        yield Caution("record-mean", sentence, numbers)


def _remedy(record: Record, what: str) -> str:
    """Say what takes a mean away: the mean of ü is that of a line of velocity."""
    trend = "line" if record.quantity == "velocity" else "mean"
    removed = record.remove.trend
    if TRENDS.index(removed) < TRENDS.index(trend):
        return f"`remove: {trend}` takes away {what}"
    return f"the {removed} of the whole record is removed, and this part has one of its own"


def extremes(values: Signal) -> tuple[float, float]:
    """Give the least and the greatest sample; NaN is neither."""
    ends = [(np.fmin.reduce(part), np.fmax.reduce(part)) for part in blocks(values)]
    low, high = zip(*ends, strict=True)
    return float(np.fmin.reduce(low)), float(np.fmax.reduce(high))


def places(values: Signal, wanted: float) -> NDArray[np.intp]:
    """Give the 0-based samples of one value."""
    found = [np.flatnonzero(part == wanted) for part in blocks(values)]
    return np.concatenate([at + number * BLOCK for number, at in enumerate(found)])


def moments(values: Signal) -> tuple[float, float]:
    """Give the mean of the samples and their RMS about it."""
    mean = sum(float(part.sum()) for part in blocks(values)) / len(values)
    squares = (float(np.square(part - mean).sum()) for part in blocks(values))
    return mean, sqrt(sum(squares) / len(values))


def much_filled(file: str, report: Report | None, n: int) -> Iterator[Caution]:
    """Say when more than a hundredth of the samples was filled in."""
    if report and (share := report.numbers["samples"] / n) > MUCH:
        sentence = (
            f"{file}: {share * 100:.2g} % of the samples were filled in, not measured; "
            "take a record without gaps, or a window without them"
        )
        yield Caution("record-filled", sentence, {"share": share})


def much_lost(file: str, report: Report | None) -> Iterator[Caution]:
    """Say when resampling changed the RMS by more than a hundredth."""
    if report is None:
        return
    before, after = report.rms_before, report.rms_after
    if abs(after - before) > MUCH * before:
        sentence = (
            f"{file}: resampling changed the RMS by {(after / before - 1) * 100:+.2g} %: "
            "between samples so far apart the record tells little of the motion"
        )
        yield Caution("record-lost", sentence, {"rms_before": before, "rms_after": after})
