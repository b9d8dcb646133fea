"""The Welch segments of a case: their length, and whether the requested spectra exist."""

from __future__ import annotations

from math import pi, sqrt

from drysim.core.model import Samples
from drysim.study.case import LENGTH_TOLERANCE, Case
from drysim.wording import format_number

BANDWIDTHS_PER_RESONANCE = 3
"""Noise bandwidths of the Hann window within the half-power width of a resolved resonance."""


def check_spectra(case: Case) -> None:
    """Raise a ScenarioError if the requested spectra do not exist."""
    scenario, key = case.scenario, "measure.spectra"
    if not scenario.measure.spectra:
        return
    if not isinstance(case.motion, Samples):
        kind = scenario.excitation.kind
        sentence = f"does not apply to {kind}: spectra need random base motion or a record"
        raise scenario.error(f"{key} {sentence}", key)
    check_segment(case)


def check_segment(case: Case, segment: float | None = None) -> None:
    """Raise a ScenarioError if the segments are too short, or longer than the window.

    Their length is that of the scenario, or `segment` [s].
    """
    from drysim.metrics.spectra import MIN_SEGMENT_STEPS

    scenario, key = case.scenario, "measure.spectra"
    segment = segment_length(case) if segment is None else segment
    length = case.window[1] - case.window[0]
    minimum = MIN_SEGMENT_STEPS * case.step
    if segment < minimum * (1 - LENGTH_TOLERANCE):
        key = "measure.segment" if scenario.measure.segment else key
        sentence = (
            f"{key} needs segments of at least {format_number(minimum, 's')}, "
            f"{MIN_SEGMENT_STEPS} steps, not {format_number(segment, 's')}"
        )
        raise scenario.error(sentence, key)
    if segment > length * (1 + LENGTH_TOLERANCE):
        sentence = f"is longer than the window of {format_number(length, 's')}"
        raise scenario.error(f"measure.segment {sentence}", "measure.segment")


def segment_length(case: Case) -> float:
    """Return the length of the Welch segments [s]: the value of the scenario, or the default.

    The default is no longer than needed to resolve the resonance; a longer window then means
    more averages.
    """
    from drysim.metrics.spectra import (
        HANN_BANDWIDTH,
        MIN_SEGMENT_STEPS,
        MIN_SEGMENT_TIME,
        MIN_SEGMENTS,
        PERIODS_PER_SEGMENT,
    )

    if case.scenario.measure.segment:
        return case.scenario.measure.segment
    begin, end = case.window
    m, k_x, _ = case.plant
    enough = max(MIN_SEGMENT_TIME, MIN_SEGMENT_STEPS * case.step)
    if k_x:
        enough = max(enough, PERIODS_PER_SEGMENT * 2 * pi * sqrt(m / k_x))
    if width := resonance_width(case):
        enough = max(enough, BANDWIDTHS_PER_RESONANCE * HANN_BANDWIDTH / width)
    return min(enough, (end - begin) / MIN_SEGMENTS)


def resonance_width(case: Case) -> float:
    """Return the half-power width of the resonance [Hz]; 0 without spring or with friction."""
    m, k_x, b = case.plant
    return b / (2 * pi * m) if k_x and not case.law.F_fs else 0.0
