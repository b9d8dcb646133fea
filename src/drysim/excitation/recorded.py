"""Measured base motion from a column or channel of a file."""

from collections.abc import Collection, Sequence
from math import sqrt
from typing import Any, ClassVar, Literal

from drysim.core.model import (
    RecordSummary,
    Samples,
    integrate_base_squares,
    mean_and_std,
)
from drysim.excitation.base import ExcitationBase, describe_grid
from drysim.records.options import LARGE_MEAN, RecordedMotion
from drysim.wording import format_count, format_number, format_range, sanitise


class RecordKind(ExcitationBase):
    """Tag of a recorded base motion."""

    kind: Literal["record"]
    """Measured base motion."""


class Record(RecordedMotion, RecordKind):
    """Measured base motion: equidistant samples in a column or channel of a file.

    Not to be confused with random excitation generated from a spectrum. The motion ends at the
    last sample of the record; if it is at rest there, the base stays at rest for the ring-down.
    """

    has_own_step: ClassVar[bool] = True
    has_own_end: ClassVar[bool] = True

    def parameters(self, varied: Collection[str] = ()) -> str:
        """Return the file, and the factor on its samples."""
        file = "from several files" if "file" in varied else sanitise(self.named)
        has_factor = self.scale != 1.0 and "scale" not in varied
        return (file + f" times {format_number(self.scale)}" * has_factor).strip()

    def _describe_motion(self, motion: Any, level: bool) -> str:
        """Return the grid and the RMS, and the mean where that contributes to the RMS."""
        text = f", {describe_grid(motion)}"
        if not level:
            return text
        rms, mean = _rms(motion), mean_and_std(motion.u_dd)[0]
        spread = sqrt(max(0.0, rms**2 - mean**2))
        text += f", {format_number(rms, 'm/s² RMS')}, linear between samples"
        if abs(mean) > LARGE_MEAN * spread:
            text += (
                f"; mean {format_number(mean, 'm/s²')}, "
                f"{format_number(spread, 'm/s² RMS')} about it"
            )
        return text

    def _describe_records(
        self, records: Sequence[RecordSummary], varied: Collection[str]
    ) -> str:
        """Return number, durations and RMS of the records of a sweep."""
        text = f"{self.kind} {self.parameters(varied)}"
        text = text.replace("several files", format_count(len(records), "file"), 1)
        units = {"duration": "s"} | ({"rms": "m/s² RMS"} if {*varied} <= {"file"} else {})
        for name, unit in units.items():
            values = [getattr(record, name) for record in records]
            text += f", {format_range(min(values), max(values), unit)}"
        return text

    def summarise(self, motion: Samples) -> RecordSummary:
        """Return what is said of a record among several."""
        steps = motion.realised.get("clean_up", ())
        assert isinstance(steps, list | tuple)
        duration = (len(motion.u_dd) - 1) * motion.dt
        return RecordSummary(self.named, _rms(motion), duration, tuple(steps))

    def motion(self, step: float | None = None, end: float | None = None) -> Samples:
        """Read the record and return its base acceleration.

        Returns
        -------
        Samples
            On the grid of the record; for a velocity record on half its step, because the
            derivative of its spline has knots at midpoints.

        Raises
        ------
        RecordError
            If the record cannot be used; the message names file, row and column.
        """
        from drysim.records.record import read_motion

        return read_motion(self)


def _rms(motion: Samples) -> float:
    """Return the RMS of a base acceleration that is linear between samples [m/s²]."""
    end = (len(motion.u_dd) - 1) * motion.dt
    return sqrt(integrate_base_squares(motion._replace(u=None), 0.0, end)[0] / end)
