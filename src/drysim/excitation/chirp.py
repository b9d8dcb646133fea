"""Chirp: a sine sweep, whose frequency changes with time."""

from __future__ import annotations

from collections.abc import Collection
from math import log, pi, sqrt
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from drysim.core.motion import Samples
from drysim.excitation.generated import Ending
from drysim.excitation.harmonic import Level
from drysim.excitation.noise import Floats, coarse
from drysim.quantity import Frequency
from drysim.wording import number


class Chirp(Ending):
    """A shaker table on a sine sweep: a sine of constant acceleration and moving frequency.

    Not to be confused with the `sweep` block, which runs a scenario once for every value: this
    is one run through all frequencies, and what it shows at each still swings from before.
    """

    kind: Literal["sweep"]
    """A sine sweep."""
    also_called: ClassVar[tuple[str, ...]] = ("chirp", "sine sweep", "swept sine")
    first: Annotated[Frequency, Field(alias="from")]
    """Frequency at the beginning [Hz]."""
    last: Annotated[Frequency, Field(alias="to")]
    """Frequency at the end [Hz], above or below `from`."""
    scale: Literal["linear", "log"] = "linear"
    """How the frequency changes: `linear`, by equal steps, or `log`, by equal ratios, in equal
    times."""
    rms: Level | None = None
    """RMS value of the sine [m/s²]."""
    amplitude: Level | None = None
    """Amplitude of the sine [m/s²], in place of `rms` and √2 times it."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("rms", "amplitude"),)

    @property
    def A(self) -> float:
        """Amplitude of the base acceleration [m/s²]."""
        return sqrt(2) * (self.rms or 0.0) if self.amplitude is None else self.amplitude

    @property
    def highest(self) -> float:
        """Highest frequency [Hz]."""
        return max(self.first, self.last)

    def told(self, varied: Collection[str] = ()) -> str:
        """Give between which frequencies it goes, and how."""
        band = f"{number(self.first)} to {number(self.last, 'Hz')}, "
        return ("" if {"from", "to"} & {*varied} else band) + self.scale

    def cycles(self, share: Floats) -> Floats:
        """Give the phase, in cycles, when a share of the duration has passed.

        Notes
        -----
        The integral of the frequency in closed form: with r = f1/f0 and s = t/T it is
        f0 T s + (f1 - f0) T s²/2 for a linear and f0 T (r^s - 1)/ln r for a logarithmic sweep.
        """
        T, f_0, f_1 = self.duration, self.first, self.last
        octaves = log(f_1 / f_0)
        if self.scale == "linear" or octaves == 0.0:
            return share * (f_0 * T + 0.5 * (f_1 - f_0) * T * share)
        return np.asarray(f_0 * T / octaves * np.expm1(octaves * share))

    def drawn(self, step: float) -> Samples:
        """Sample the sweep, which begins at zero; its phase is exact at every sample."""
        n = round(self.duration / step)
        cycles = self.cycles(np.arange(n + 1) / n)
        u_dd = self.A * np.sin(2 * pi * (cycles % 1.0))
        left, right = u_dd[:-1], u_dd[1:]
        square = float((left @ left + left @ right + right @ right) / (3 * n))
        realised = {
            "rms_asked": self.A / sqrt(2),
            "rms": sqrt(square),
            "cycles": float(cycles[-1]),
        }
        # A sine of frequency f loses sinc² of f times the step to the straight lines.
        kept = float(np.sinc(self.highest * step) ** 2)
        told = tuple(coarse(kept, step, f"amplitude at {self.highest:g} Hz than asked for"))
        return Samples(u_dd, step, None, (), told, realised)
