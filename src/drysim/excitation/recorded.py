"""Measured base motion from a column or channel of a file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from drysim.core.model import Samples
from drysim.excitation.base import ExcitationBase
from drysim.records import SI
from drysim.records.options import RecordedMotion


class RecordKind(ExcitationBase):
    """Tag of a recorded base motion."""

    kind: Literal["record"]
    """Measured base motion."""


class Record(RecordedMotion, RecordKind):
    """Measured base motion: equidistant samples in a column or channel of a file.

    Not to be confused with random excitation generated from a spectrum. The motion ends at the
    last sample of the record.
    """

    has_own_step: ClassVar[bool] = True
    has_own_end: ClassVar[bool] = True

    @property
    def measured(self) -> str:
        """Measured quantity."""
        return self.quantity

    @classmethod
    def si_of(cls, words: Mapping[str, Any]) -> str | None:
        """Return the SI unit of the samples; None if it is not known yet."""
        return SI.get(words.get("quantity", ""))

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
