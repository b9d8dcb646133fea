"""Psd: random base motion of a given power spectral density, joined log-log."""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise
from math import expm1, log
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import BeforeValidator, Field, field_validator

from drysim.core.motion import Samples
from drysim.excitation.generated import Drawn
from drysim.excitation.noise import Floats, Lines, lines, noise
from drysim.quantity import Frequency, Misfit, Quantity, shown
from drysim.wording import number

Density = Annotated[float, Quantity("(m/s²)²/Hz", above=0)]


def _pair(given: object) -> object:
    if not isinstance(given, list | tuple) or len(given) != 2:
        raise ValueError(f"must be a pair [frequency, PSD], not {shown(given)}")
    return given


Point = Annotated[tuple[Frequency, Density], BeforeValidator(_pair)]
"""A corner of a spectrum: frequency [Hz] and one-sided PSD [(m/s²)²/Hz]."""


class Psd(Drawn):
    """A shaker table that follows a random profile, given by the PSD of its acceleration.

    Not to be confused with a record: the signal is drawn, by its seed, as a sum of lines at
    whole multiples of 1/duration. Only their phases are random; it repeats after `duration`.
    """

    kind: Literal["psd"]
    """Random base motion of a given PSD."""
    also_called: ClassVar[tuple[str, ...]] = ("random", "noise", "spectrum")
    points: Annotated[tuple[Point, ...], Field(json_schema_extra={"minItems": 2})]
    """Corners [frequency, PSD] of the one-sided PSD of ü, in Hz and (m/s²)²/Hz (or `g²/Hz`),
    frequencies ascending. Straight lines in log-log axes join them; zero outside."""
    rms: Annotated[float, Quantity("m/s²", above=0)] | None = None
    """RMS value a_u of the base acceleration [m/s²]. When it is given the PSD is a shape only,
    and the signal is scaled to exactly this RMS over its whole duration."""

    @field_validator("points")
    @classmethod
    def _ascending(cls, points: tuple[Point, ...]) -> tuple[Point, ...]:
        if len(points) < 2:
            raise ValueError("must have two points at least, [frequency, PSD] each")
        for i, ((low, _), (high, _)) in enumerate(pairwise(points)):
            if not low < high:
                sentence = f"must be above the frequency before it, {low:g} Hz; not {high:g}"
                raise Misfit(sentence, i + 1, 0)
        return points

    @property
    def band(self) -> tuple[float, float]:
        """First and last frequency of the PSD [Hz]."""
        return self.points[0][0], self.points[-1][0]

    def told(self, varied: Collection[str] = ()) -> str:
        """Give its band."""
        if any(key.startswith("points") for key in varied):
            return ""
        low, high = self.band
        return f"{number(low)} to {number(high, 'Hz')}"

    def drawn(self, step: float) -> Samples:
        """Draw the base acceleration on a grid, and the displacement that goes with it."""
        return noise(lines_of(self.points, self.duration), step, self.seed, self.rms)


def lines_of(points: tuple[tuple[float, float], ...], T: float) -> Lines:
    """Give the lines of a log-log polygon in a signal with period T [s]."""
    f, G = (np.array(column) for column in zip(*points, strict=True))
    band = points[0][0], points[-1][0]
    return lines(lambda at: density(f, G, at), band, area(points), T)


def density(f: Floats, G: Floats, at: Floats) -> Floats:
    """Give the PSD at ascending frequencies within a log-log polygon of corners f, G."""
    found = np.empty(len(at))
    edges = np.searchsorted(at, f)
    edges[-1] = len(at)
    for i in range(len(f) - 1):
        part = slice(edges[i], edges[i + 1])
        p = log(G[i + 1] / G[i]) / log(f[i + 1] / f[i])
        found[part] = G[i] * (at[part] / f[i]) ** p
    return found


def area(points: tuple[tuple[float, float], ...]) -> float:
    """Give the integral of a log-log polygon, the mean square of the signal [m²/s⁴].

    Notes
    -----
    Of a segment: P1 f1/(p+1) [(f2/f1)^(p+1) - 1], and P1 f1 ln(f2/f1) at p = -1.
    """
    total = 0.0
    for (f_1, P_1), (f_2, P_2) in pairwise(points):
        octaves = log(f_2 / f_1)
        rise = log(P_2 / P_1) + octaves  # (p + 1) ln(f2/f1)
        total += P_1 * f_1 * octaves * (expm1(rise) / rise if rise else 1.0)
    return total
