"""A recorded normal force: read like a record of base motion."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from functools import lru_cache
from typing import Any

from drysim import regular
from drysim.core.normal_force.normal import Pressure
from drysim.excitation.record.recorded import Recorded
from drysim.excitation.record.spoken import SI

KEPT = 4
"""Records of forces that are kept: neighbouring cases of a sweep share theirs."""


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
            stamp = regular.stamp_of(self.path)
        return _pressure(self, stamp)


@lru_cache(maxsize=KEPT)
def _pressure(record: NormalRecord, stamp: regular.Stamp | None) -> Pressure:
    from drysim.excitation.record.file import fault
    from drysim.excitation.record.reading import force_of

    values, dt, source, cautions, clean_up = force_of(record)
    mean = float(values.mean())
    if not mean > 0.0:
        sentence = (
            f"the mean of the normal force is {mean:.6g} N; of surfaces that are pressed "
            "together it is above 0 N: check its sign (`scale: -1` turns it)"
        )
        raise fault(str(record.path), sentence)
    return Pressure(values / mean, dt, mean, (source,), cautions, clean_up)
