"""What was done to a record on request, as words and numbers for every summary."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from drysim.core.signal import moments
from drysim.excitation.record.columns import Floats

ROUNDING = 1e-12
"""A mean below this share of the RMS is what rounding leaves of none."""


class Report(NamedTuple):
    """One step of a clean-up.

    Attributes
    ----------
    step : str
        Key of the record that asked for it.
    sentence : str
        What was done.
    rms_before, rms_after : float
        RMS of the samples about their mean, in SI.
    mean_before, mean_after : float
        That mean.
    numbers : mapping
        What else describes the step, in SI.
    """

    step: str
    sentence: str
    rms_before: float
    rms_after: float
    mean_before: float
    mean_after: float
    numbers: Mapping[str, float]

    def told(self) -> dict[str, object]:
        """Give the report as drysim.json holds it."""
        return {**self._asdict(), "numbers": dict(self.numbers)}


def report(
    step: str,
    sentence: str,
    before: Floats,
    after: Floats,
    unit: str,
    numbers: Mapping[str, float],
) -> Report:
    """Give the report of a step from its samples; the RMS values are added to its sentence."""
    (mean, rms), (mean_after, rms_after) = _moments(before), _moments(after)
    said = (
        f"{sentence}; RMS {rms:.4g} before, {rms_after:.4g} {unit} after, of the samples about "
        f"means of {mean:.4g} and {mean_after:.4g} {unit}"
    )
    return Report(step, said, rms, rms_after, mean, mean_after, numbers)


def _moments(values: Floats) -> tuple[float, float]:
    """Return mean and RMS about it; a mean that is rounding of the samples counts as 0."""
    mean, rms = moments(values)
    return (0.0 if abs(mean) < ROUNDING * rms else mean), rms
