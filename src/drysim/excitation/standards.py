"""Standard: the input spectra of laboratory tests of vehicle seats, by their class."""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field, field_validator

from drysim.core.motion import Samples
from drysim.errors import Caution
from drysim.excitation.generated import Drawn
from drysim.excitation.noise import Floats, lines, noise
from drysim.quantity import meant, near, shown

FINE = 100_000
"""Points of the midpoint rule for the integral of a spectrum: nine digits."""

RESOLUTION = 0.5
"""Width [Hz] of the bands over which the realised PSD is told."""

A = (0.89, 11.22)
B = (0.89, 17.78)
"""The bands of the stated RMS values [Hz]: third octaves from 1 Hz to 10 and to 16 Hz."""


class Spectrum(NamedTuple):
    """G0 |HP|² |LP|² of Butterworth filters: order and corner [Hz], G0, stated RMS [m/s²]."""

    high_pass: tuple[int, float]
    low_pass: tuple[int, float]
    G0: float
    rms: float
    band: tuple[float, float]
    recalled: bool = False
    """Whether the stated RMS is recalled, not checked against the text of the standard."""

    def density(self, f: Floats) -> Floats:
        """Give the PSD of ü [(m/s²)²/Hz]."""
        (n, f_h), (p, f_l) = self.high_pass, self.low_pass
        high = (f / f_h) ** (2 * n)
        return self.G0 * high / (1 + high) / (1 + (f / f_l) ** (2 * p))

    def square(self) -> float:
        """Give the integral of the PSD over the band [m²/s⁴]."""
        low, high = self.band
        share = (np.arange(FINE, dtype=np.float64) + 0.5) / FINE
        return float(self.density(low + share * (high - low)).mean() * (high - low))


CLASSES = {
    "EM1": Spectrum((4, 1.5), (4, 2.5), 2.82, 1.71, A),
    "EM2": Spectrum((4, 1.5), (4, 3.0), 2.72, 2.05, A),
    "EM3": Spectrum((4, 1.5), (4, 3.0), 1.93, 1.73, A),
    "EM4": Spectrum((4, 1.5), (4, 3.0), 0.60, 0.96, A),
    "EM5": Spectrum((4, 1.5), (1, 3.5), 1.11, 1.94, B),
    "EM6": Spectrum((2, 6.5), (2, 9.0), 0.79, 1.65, B),
    "EM7": Spectrum((8, 3.0), (8, 3.5), 9.25, 2.25, A, recalled=True),
    "EM8": Spectrum((4, 3.0), (2, 3.0), 1.45, 1.05, B),
    "EM9": Spectrum((4, 3.5), (2, 4.0), 2.10, 1.63, B),
    "IT1": Spectrum((4, 4.5), (2, 5.0), 1.66, 1.58, B),
    "IT2": Spectrum((4, 3.0), (2, 3.0), 1.45, 1.05, B),
    "IT3": Spectrum((4, 1.5), (4, 3.0), 0.60, 0.96, A),
    "IT4": Spectrum((4, 1.5), (4, 3.0), 1.64, 1.59, B),
    "AG1": Spectrum((8, 3.0), (8, 3.5), 9.25, 2.26, A),
    "AG2": Spectrum((8, 2.1), (8, 2.6), 7.22, 1.94, A),
    "AG3": Spectrum((8, 1.95), (8, 2.45), 5.85, 1.74, A),
}
"""EM: earth-moving machines, EN ISO 7096. IT: industrial trucks, EN 13490. AG: agricultural
tractors, ISO 5007."""


class Standard(Drawn):
    """The vertical base motion of a seat test, by the class of its machine.

    Not to be confused with a record of the machine: the spectrum is the standard's, and the
    signal is drawn from it, between the limits of the class's band and nowhere else.
    """

    kind: Literal["standard"]
    """The base motion of a seat test."""
    machine: Annotated[str, Field(alias="class", json_schema_extra={"enum": list(CLASSES)})]
    """Class: EM1 to EM9 (earth-moving machines), IT1 to IT4 (industrial trucks), AG1 to AG3
    (agricultural tractors)."""
    scale: Literal["to definition", "nothing"] = "to definition"
    """Whether the signal is scaled to exactly the RMS value that the standard states, or left
    with that of its spectrum, which differs by up to 1 %."""

    @field_validator("machine")
    @classmethod
    def _known(cls, name: str) -> str:
        if name not in CLASSES:
            hint = meant(near(name, CLASSES))
            raise ValueError(
                f"must be EM1 to EM9, IT1 to IT4 or AG1 to AG3, not {shown(name)}{hint}"
            )
        return name

    def told(self, varied: Collection[str] = ()) -> str:
        """Give its class."""
        return self.machine

    @property
    def band(self) -> tuple[float, float]:
        """The band of the stated RMS [Hz]."""
        spectrum = CLASSES.get(self.machine)
        return spectrum.band if spectrum else A

    def drawn(self, step: float) -> Samples:
        """Draw the base acceleration on a grid, and prove it against its definition."""
        spectrum = CLASSES[self.machine]
        wanted = lines(spectrum.density, spectrum.band, spectrum.square(), self.duration)
        scaled = self.scale == "to definition"
        motion = noise(wanted, step, self.seed, spectrum.rms if scaled else None)
        bands = proof(spectrum, motion)
        worst = max(abs(band["found"] - band["asked"]) for band in bands)
        peak = float(spectrum.density(np.linspace(*spectrum.band, 1000)).max())
        realised: dict[str, object] = {"class": self.machine, "rms_asked": spectrum.rms}
        realised |= {"psd_error": worst / peak, "psd": bands}
        cautions = (*motion.cautions, *([recalled(self.machine)] if spectrum.recalled else []))
        return motion._replace(realised={**motion.realised, **realised}, cautions=cautions)


def proof(spectrum: Spectrum, motion: Samples) -> tuple[dict[str, float], ...]:
    """Give the PSD of the samples beside its definition, in bands.

    Returns
    -------
    tuple of dict
        `from` and `to` of a band [Hz]; `asked` and `found`, the means of both PSDs at the lines
        in it [(m/s²)²/Hz].
    """
    n = len(motion.u_dd) - 1
    f = np.arange(n // 2 + 1) / (n * motion.dt)
    found = 2 * n * motion.dt * np.square(np.abs(np.fft.rfft(motion.u_dd[:-1], norm="forward")))
    asked = spectrum.density(f)
    low, high = spectrum.band
    edges = np.linspace(low, high, round((high - low) / RESOLUTION) + 1)
    bands = []
    for left, right in pairwise(edges.tolist()):
        at = (f >= left) & (f < right)
        if at.any():
            means = {"asked": float(asked[at].mean()), "found": float(found[at].mean())}
            bands.append({"from": left, "to": right, **means})
    return tuple(bands)


def recalled(machine: str) -> Caution:
    """Say that a stated value is recalled."""
    sentence = (
        f"the RMS that the standard states for {machine}, {CLASSES[machine].rms:g} m/s², is "
        "recalled and was not checked against its text; `scale: nothing` does without it"
    )
    return Caution("recalled", sentence, {"rms": CLASSES[machine].rms})
