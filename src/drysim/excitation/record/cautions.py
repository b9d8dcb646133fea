"""What a reader of the numbers should know about a record."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drysim.core.motion import Samples
from drysim.errors import Caution
from drysim.excitation.record.columns import Floats
from drysim.excitation.record.shape import Series

GRAVITY = 9.81
"""Standard gravity as the paper rounds it [m/s²]."""

NEAR_GRAVITY = 0.05
"""An accelerometer lying a little askew still shows gravity within this share."""

LARGE_MEAN = 0.1
"""Share of the RMS about the mean from which a mean shows in the numbers."""

FLAT = 4
"""This many equal samples on end, at an extreme, are a clipped peak and no chance."""


def clipped(file: str, values: Floats, unit: str) -> Iterator[Caution]:
    """Say where the samples stand still at their largest or smallest value."""
    low, high = float(values.min()), float(values.max())
    for limit, name in ((low, "smallest"), (high, "largest")):
        at = np.flatnonzero(values == limit)
        starts = np.flatnonzero(at[FLAT - 1 :] - at[: max(0, len(at) - FLAT + 1)] == FLAT - 1)
        # Rest before and after a shock is no peak.
        if low < high and limit != 0 and starts.size:
            first = int(at[starts[0]]) + 1
            sentence = (
                f"{file}: the samples look clipped: from sample {first} on, {FLAT} or more on "
                f"end are the {name} of all, {limit:.4g} {unit}; measure with a wider range"
            )
            yield Caution("record-clipped", sentence, {"limit": limit, "sample": first})


def found(file: str, motion: Samples) -> Iterator[Caution]:
    """Give what the samples themselves show: gravity left in, or a large mean."""
    name, unit, values = (
        ("u", "m", motion.u) if motion.u is not None else ("ü", "m/s²", motion.u_dd)
    )
    mean, spread = float(values.mean()), float(values.std())
    numbers = {"mean": mean, "rms_about_mean": spread}
    if name == "ü" and abs(abs(mean) - GRAVITY) <= NEAR_GRAVITY * GRAVITY:
        sentence = (
            f"{file}: the mean of ü is {mean:.4g} m/s², so gravity seems left in the record; "
            "`remove: mean` takes it away"
        )
        yield Caution("record-gravity", sentence, numbers)
    elif abs(mean) > LARGE_MEAN * spread:
        sentence = (
            f"{file}: the mean of {name} is {mean:.4g} {unit}, large against the RMS about it, "
            f"{spread:.4g} {unit}; `remove: mean` takes away what is an offset of the sensor"
        )
        yield Caution("record-mean", sentence, numbers)


def removed(file: str, what: str, taken: Series, unit: str) -> Caution:
    """Report what `remove` took away."""
    values = taken.values
    mean, rms = float(values.mean()), float(np.sqrt(np.mean(values**2)))
    change = float(values[-1] - values[0])
    sentence = (
        f"{file}: {what} was removed: mean {mean:.4g} {unit}, RMS {rms:.4g} {unit}, "
        f"from first to last sample {change:+.4g} {unit}"
    )
    return Caution("record-removed", sentence, {"mean": mean, "rms": rms, "change": change})
