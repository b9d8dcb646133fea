"""Record: measured base motion, from a column or channel of a file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from drysim.core.motion import Samples
from drysim.excitation.member import Member
from drysim.excitation.record.recorded import Recorded as Recorded
from drysim.excitation.record.spoken import SI


class Motion(Member):
    """What a record of base motion holds."""

    kind: Literal["record"]
    """Measured base motion."""
    quantity: Literal["acceleration", "velocity", "displacement"] = "acceleration"
    """What the samples are. Velocity and displacement become acceleration through splines."""
    gravity: Literal["refuse", "keep"] = "refuse"
    """What becomes of a mean of ü near 9.81 m/s²: `refuse`, the default, makes it a fault,
    `keep` leaves it in, so that the spring bears the weight of the mass."""


class Record(Recorded, Motion):
    """Base motion as it was measured: evenly spaced samples in a column or channel of a file.

    Not to be confused with a random excitation made from a spectrum: nothing is drawn here, and
    the motion ends at the record's last sample.
    """

    own_step: ClassVar[bool] = True
    own_end: ClassVar[bool] = True

    @property
    def measured(self) -> str:
        """What the samples are."""
        return self.quantity

    @classmethod
    def si_of(cls, words: Mapping[str, Any]) -> str | None:
        """Give the SI unit of the samples from the words read so far; None where unknown."""
        return SI.get(words.get("quantity", ""))

    def motion(self, step: float | None = None, end: float | None = None) -> Samples:
        """Read the record and give its base acceleration.

        Returns
        -------
        Samples
            On the grid of the record; of a velocity record on half its step, where the spline's
            derivative bends.

        Raises
        ------
        RecordError
            When the record cannot be used; names the file, the row and the column.
        """
        from drysim.excitation.record.reading import motion_of

        return motion_of(self)
