"""Road: the vertical profile of a road of ISO 8608 under a wheel at constant speed."""

from __future__ import annotations

from collections.abc import Collection
from math import pi
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from drysim.core.motion import Samples
from drysim.errors import Caution
from drysim.excitation.generated import Drawn
from drysim.excitation.noise import noise
from drysim.excitation.psd import lines_of
from drysim.quantity import Block, Misfit, Quantity
from drysim.wording import number

N_0 = 0.1
"""Reference wave number n0 [cycle/m]."""

OMEGA_0 = 1.0
"""Reference angular wave number Ω0 [rad/m]."""

CLASSES = {name: 16e-6 * 4.0**i for i, name in enumerate("ABCDEFGH")}
"""Geometric means G_d(n0) of the classes [m³]; their limits are half and twice that."""

RECALLED = "EFGH"
"""Classes whose value is recalled, not checked against the text of the standard."""

WaveNumber = Annotated[float, Quantity("1/m", above=0)]


class Band(Block):
    """The wave numbers that a road has."""

    low: Annotated[WaveNumber, Field(alias="from")] = 0.011
    """Lowest wave number [1/m], cycles a metre."""
    high: Annotated[WaveNumber, Field(alias="to")] = 2.83
    """Highest wave number [1/m], cycles a metre."""

    @model_validator(mode="after")
    def _upwards(self) -> Self:
        if not self.low < self.high:
            raise Misfit(f"must be above `from`, {self.low:g} 1/m; not {self.high:g} 1/m", "to")
        return self


class Road(Drawn):
    """A wheel that follows a rough road at constant speed, without losing contact.

    Not to be confused with the floor of a vehicle: nothing of tyre and suspension is in it. Of
    two public readings of a roughness one is 16 times the other: the reference is named.
    """

    kind: Literal["road"]
    """The profile of a road, driven over."""
    grade: Annotated[
        Literal["A", "B", "C", "D", "E", "F", "G", "H"] | None, Field(alias="class")
    ] = None
    """Class of ISO 8608, A (smooth) to H; its geometric mean, G_d(n0) = 16e-6 m³ for A and four
    times as much a class."""
    reference: Literal["n0", "Omega0"] | None = None
    """What `roughness` refers to: n0, per cycle/m at 0.1 cycle/m; Omega0, per rad/m at 1 rad/m.
    """
    roughness: Annotated[float, Quantity("m³", above=0)] | None = None
    """PSD of the profile's height at the reference [m³], in place of `class`."""
    speed: Annotated[float, Quantity("m/s", above=0)]
    """Speed V [m/s]."""
    wave_numbers: Band = Field({}, validate_default=True)
    """The road's wave numbers [1/m]; none outside. Default: where the standard is valid."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("class", "roughness"),)
    needs: ClassVar[dict[str, str]] = {"reference": "roughness"}

    @field_validator("roughness")
    @classmethod
    def _refers(cls, roughness: float | None, info: ValidationInfo) -> float | None:
        said = {"grade", "reference"} & {key for key, word in info.data.items() if word}
        if roughness is not None and not said and "reference" in info.data:
            raise ValueError(
                "needs its reference: `reference: n0` for a PSD per cycle/m at 0.1 cycle/m, "
                "`reference: Omega0` for one per rad/m at 1 rad/m, 16 times as much road"
            )
        return roughness

    def told(self, varied: Collection[str] = ()) -> str:
        """Give how rough it is, and the speed."""
        words: str = self.grade or ""
        if self.roughness is not None and "roughness" not in varied:
            words = f"of {number(self.roughness, 'm³')} ({self.reference})"
        speed = "" if "speed" in varied else f"at {number(self.speed, 'm/s')}"
        return f"{words} {speed}".strip()

    @property
    def G_d(self) -> float:
        """PSD of the height at n0 [m³]."""
        if self.roughness is None:
            return CLASSES[self.grade or "A"]
        if self.reference == "n0":
            return self.roughness
        # Per cycle there is 2π times as much as per radian, and it falls with n².
        return self.roughness * 2 * pi * (OMEGA_0 / (2 * pi * N_0)) ** 2

    @property
    def band(self) -> tuple[float, float]:
        """First and last frequency [Hz]."""
        return self.speed * self.wave_numbers.low, self.speed * self.wave_numbers.high

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Give the PSD of ü by its ends [Hz, (m/s²)²/Hz]: 16 π⁴ n0² G_d(n0) V f²."""
        rise = 16 * pi**4 * N_0**2 * self.G_d * self.speed
        return tuple((f, rise * f**2) for f in self.band)

    def drawn(self, step: float) -> Samples:
        """Draw the base acceleration on a grid, and the height of the road at its points."""
        motion = noise(lines_of(self.corners(), self.duration), step, self.seed)
        told = [recalled(self.grade)] if self.grade and self.grade in RECALLED else []
        return motion._replace(cautions=(*motion.cautions, *told))


def recalled(grade: str) -> Caution:
    """Say that the value of a class is recalled."""
    sentence = (
        f"the roughness of class {grade}, {CLASSES[grade]:g} m³ at 0.1 cycle/m, is recalled "
        "and was not checked against the text of ISO 8608; `roughness` takes another value"
    )
    return Caution("recalled", sentence, {"roughness": CLASSES[grade]})
