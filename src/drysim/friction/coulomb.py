"""Coulomb's law: a force that does not depend on the speed, and a limit for sticking.

Its normal force may vary as a sine, or be a record, read like one of base motion.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from functools import lru_cache
from math import pi
from typing import Annotated, Any, ClassVar, Literal

from drysim import system
from drysim.core.model import Law, Pressed, Pressure
from drysim.friction.base import Limits
from drysim.records import SI
from drysim.records.options import Recorded
from drysim.units import Angle, Block, Frequency, Quantity


class NormalRecord(Recorded):
    """The normal force as it was measured: evenly spaced samples of a file, linear in between.

    Where it is zero or below, the surfaces have parted and there is no friction.
    """

    @property
    def measured(self) -> str:
        """What the samples are."""
        return "force"

    @classmethod
    def si_of(cls, words: Mapping[str, Any]) -> str | None:
        """Give the SI unit of the samples."""
        return SI["force"]

    def pressure(self) -> Pressure:
        """Read the record, once while its file stays what it is.

        Raises
        ------
        RecordError
            When the record cannot be used, or its mean is not above zero.
        """
        stamp = None
        with suppress(OSError):
            stamp = system.stamp_of(self.path)
        return _pressure(self, stamp)


@lru_cache(maxsize=4)  # neighbouring cases of a sweep share their record
def _pressure(record: NormalRecord, stamp: system.Stamp | None) -> Pressure:
    from drysim.records.record import pressure_of

    return pressure_of(record)


class NormalVariation(Block):
    """A varying normal force: both limits times 1 + amplitude·sin(2πft + phase)."""

    amplitude: Annotated[float, Quantity("", at_least=0)]
    """Relative amplitude [-]; above 1 the surfaces part for a while in each period, and there
    is no friction then."""
    frequency: Frequency
    """Frequency [Hz]."""
    phase: Angle = 0.0
    """Phase at t = 0 [rad]."""


class Coulomb(Limits):
    """Dry surfaces pressed together: a constant force against sliding, a limit for sticking.

    Not to be confused with viscous damping, which vanishes with the speed.

    Notes
    -----
    F_f = F_fk sgn(v_r) while it slides; while it sticks F_f = -F_L, at most F_fs = μ_s F_N in
    size, with F_L = m d²u/dt² + k_x x_r. Coulomb, Théorie des machines simples (1785), as Eqs.
    (3), (4), (7) and (9) of the paper have it.
    """

    by_default: ClassVar[bool] = True

    law: Literal["coulomb"]
    """Dry friction of Coulomb's kind, the law of a block that names none."""
    normal_variation: NormalVariation | None = None
    """Normal force that varies as a sine; default: it is constant."""

    normal_record: NormalRecord | None = None
    """Normal force [N] as it was recorded, in place of `normal`; with it F_fk and F_fs stand
    for its mean. Needs `mu_kinetic`."""

    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = (
        *Limits.at_most_one_of,
        ("normal", "normal_record"),
        ("normal_variation", "normal_record"),
    )
    needs: ClassVar[dict[str, str]] = {**Limits.needs, "normal_record": "mu_kinetic"}

    @property
    def frequencies(self) -> tuple[float, ...]:
        """The frequencies of a normal force that varies periodically [Hz]."""
        varied = self.normal_variation
        return (varied.frequency,) if varied and varied.amplitude else ()

    def forced(self, mu: float, m: float) -> float:
        """Give the force [N] behind a coefficient; of a recorded one the mean counts."""
        record = self.normal_record
        return super().forced(mu, m) if record is None else mu * record.pressure().mean

    def spelled_out(self, m: float) -> dict[str, Any]:
        """Give the words of the block with every default in them."""
        words = super().spelled_out(m)
        if self.normal_record is not None:
            words.pop("normal", None)
        return words

    def limits(self, m: float) -> Law | Pressed:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        F_fk, F_fs = self.kinetic_force(m), self.static_force(m)
        varied = self.normal_variation
        if self.normal_record is not None:
            return Pressed(F_fk, F_fs, pressure=self.normal_record.pressure())
        if varied is None:
            return Law(F_fk, F_fs)
        wave = varied.amplitude, 2 * pi * varied.frequency, varied.phase
        # Of many cases at once the amplitudes are a column, all of them below 1.
        lifts = isinstance(varied.amplitude, float) and varied.amplitude >= 1.0
        return Pressed(F_fk, F_fs, *wave) if lifts else Law(F_fk, F_fs, *wave)
