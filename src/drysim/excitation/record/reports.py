"""What was done to a record on request, as words and numbers for every summary."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from drysim.excitation.record.columns import Floats


class Report(NamedTuple):
    """One step of a clean-up.

    Attributes
    ----------
    step : str
        Key of the record that asked for it.
    sentence : str
        What was done.
    rms_before, rms_after : float
        RMS of the samples in SI.
    numbers : mapping
        What else describes the step, in SI.
    """

    step: str
    sentence: str
    rms_before: float
    rms_after: float
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
    old, new = _rms(before), _rms(after)
    said = f"{sentence}; RMS {old:.4g} before, {new:.4g} {unit} after"
    return Report(step, said, old, new, numbers)


def _rms(values: Floats) -> float:
    return float(np.sqrt(values @ values / len(values)))
