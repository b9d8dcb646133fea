"""The spectra that a scenario asks for: whether they can be had, and how good they will be."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, sqrt
from typing import TYPE_CHECKING

from drysim.core.motion import Samples
from drysim.errors import Caution
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.approach.response import Response
    from drysim.spectra import Spectra
    from drysim.study.case import Case

ROUNDING = 1e-9
"""Share by which a length may miss a bound that it was meant to meet."""

FEW = 8
"""Half-overlapping segments below which PSD and coherence are hardly estimates."""

LINES = 3
"""Noise bandwidths of the window within the width of a resonance that is resolved."""


def segment_of(case: Case) -> float:
    """Return the length of a segment [s]: the one asked for, or the default.

    Notes
    -----
    The default is no longer than it takes to resolve the resonance: what a long window has
    beyond that goes into the number of averages.
    """
    from drysim.spectra import FEWEST_STEPS, PERIODS, SEGMENTS, SHORTEST, WIDTH

    if case.scenario.measure.segment:
        return case.scenario.measure.segment
    begin, end = case.window
    m, k_x, _ = case.plant
    enough = max(SHORTEST, FEWEST_STEPS * case.step)
    if k_x:
        enough = max(enough, PERIODS * 2 * pi * sqrt(m / k_x))
    if width := _width(case):
        enough = max(enough, LINES * WIDTH / width)
    return min(enough, (end - begin) / SEGMENTS)


def _width(case: Case) -> float:
    """Return the width of the resonance [Hz]; 0 where friction or nothing limits it."""
    m, k_x, b = case.plant
    return b / (2 * pi * m) if k_x and not case.law.F_fs else 0.0


def refusal(case: Case) -> tuple[str, str] | None:
    """Give the sentence and the key when the spectra that are asked for cannot be had."""
    from drysim.spectra import FEWEST_STEPS

    if not case.scenario.measure.spectra:
        return None
    if not isinstance(case.motion, Samples):
        kind = case.scenario.excitation.kind
        sentence = f"has no use for {kind}: spectra need random base motion or a record"
        return f"measure.spectra {sentence}", "measure.spectra"
    segment, length = segment_of(case), case.window[1] - case.window[0]
    least = FEWEST_STEPS * case.step
    if segment < least * (1 - ROUNDING):
        key = "segment" if case.scenario.measure.segment else "spectra"
        sentence = f"needs segments of {number(least, 's')} at least, {FEWEST_STEPS} steps"
        return f"measure.{key} {sentence}; here they have {number(segment, 's')}", (
            f"measure.{key}"
        )
    if segment > length * (1 + ROUNDING):
        sentence = f"is longer than the window of {number(length, 's')}"
        return f"measure.segment {sentence}", "measure.segment"
    return None


def run_only(case: Case) -> Iterator[Caution]:
    """Say that only a run gives spectra, where many cases are asked for them."""
    if case.scenario.measure.spectra:
        sentence = "measure.spectra has no use here: only `drysim run` gives spectra"
        yield Caution("spectra-left-out", sentence)


def spectra_of(
    case: Case, response: Response, window: tuple[float, float]
) -> tuple[Spectra | None, tuple[Caution, ...]]:
    """Give the spectra of a response, where they are asked for, and what to say of them."""
    if not case.scenario.measure.spectra:
        return None, ()
    from drysim.spectra import spectra

    found = spectra(response, window, segment_of(case))
    return found, tuple(doubts(case, found))


def doubts(case: Case, found: Spectra) -> Iterator[Caution]:
    """Say when the segments are too few, or too short for the resonance."""
    from drysim.spectra import WIDTH

    if found.segments < FEW:
        sentence = (
            f"the spectra are means over {found.segments} segments, fewer than {FEW}: their "
            "lines scatter widely and the coherence is too high; take a longer window or a "
            "shorter measure.segment"
        )
        yield Caution("few-segments", sentence, {"segments": found.segments})
    width, lines = _width(case), WIDTH / found.segment
    if 0 < width < lines:
        sentence = (
            f"the spectra resolve {number(lines, 'Hz')}, the resonance is "
            f"{number(width, 'Hz')} wide: its peak is flattened; "
            f"measure.segment: {number(LINES * WIDTH / width, 's', 2)} would show it"
        )
        yield Caution("coarse-spectra", sentence, {"resolution": lines, "width": width})
