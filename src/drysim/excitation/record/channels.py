"""Columns of files that hold numbers, not text: loaded when asked for, finite or refused."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.signal import KEPT, Signal, blocks
from drysim.errors import RecordError
from drysim.excitation.record.columns import GAP, INFINITE, Columns, Label
from drysim.excitation.record.file import File, fault, room
from drysim.excitation.record.stored import Stored

SIZE = 8
"""Bytes of a number in memory."""


class Channel(NamedTuple):
    """One column of a file that holds numbers, not text; they are loaded when asked for.

    `dt` and `first` are step and first time [s] where the file knows them, `clock` is the
    0-based column of its times where it has such.
    """

    label: Label
    load: Callable[[], NDArray[np.generic] | Stored]
    dt: float | None = None
    first: float = 0.0
    clock: int | None = None


@dataclass(frozen=True, kw_only=True)
class Channels(Columns):
    """Columns of a file that holds numbers, not text."""

    channels: tuple[Channel, ...]
    place: str = "file"

    def numbers(self, wanted: list[int], gappy: int | None = None) -> list[Signal]:
        """Give columns as finite numbers, NaN where a sample of the `gappy` one is missing.

        Raises
        ------
        RecordError
            When a column is no series of real numbers, a sample is none, or lengths differ.
        """
        found = [self._series(index) for index in wanted]
        for index, column in zip(wanted, found, strict=True):
            if len(column) != len(found[0]):
                lengths = f"{len(column)} samples, {self.called(wanted[0])} {len(found[0])}"
                raise self.fault(f"{self.called(index)} has {lengths}")
            row = 0
            for block in blocks(column):
                good = np.isfinite(block)
                if index == gappy:
                    good |= np.isnan(block)
                if not good.all():
                    bad = int(np.argmin(good))
                    why = f"no number: {GAP}" if np.isnan(block[bad]) else INFINITE
                    raise self.at(row + bad, index, why)
                row += len(block)
        return found

    def _series(self, index: int) -> Signal:
        loaded = self.channels[index].load()
        if isinstance(loaded, Stored):
            if len(loaded) > KEPT:
                return loaded
            room(self.shown, len(loaded) * SIZE)
            return loaded[:]
        values = np.asarray(loaded)
        if values.ndim != 1 or values.dtype.kind not in "iufb":
            raise self.fault(f"{self.called(index)} is no series of real numbers")
        ours = values.dtype == np.float64 and values.flags.owndata and values.flags.writeable
        return values if ours else values.astype(np.float64)

    def last_digit(self, index: int) -> float:
        """Binary numbers are not rounded to digits."""
        return 0.0

    def at(self, row: int, index: int, sentence: str) -> RecordError:
        """Give the error at a 0-based sample of a column."""
        return self.fault(f"sample {row + 1}, {self.called(index)}: {sentence}")

    def fault(self, sentence: str, index: int | None = None) -> RecordError:
        """Give the error for a fault of the file; it has no lines to point at."""
        return fault(self.shown, sentence)

    def clock(self, index: int) -> int | None:
        """Give the 0-based column of the times that belong to a column, where there is one."""
        return self.channels[index].clock

    def own(self, index: int) -> tuple[float, float] | None:
        """Give the step and the first time [s] that the file itself knows of a column."""
        channel = self.channels[index]
        return None if channel.dt is None else (channel.dt, channel.first)

    def series(self) -> list[int]:
        """Give the 0-based columns that are no clocks."""
        clocks = {channel.clock for channel in self.channels}
        return [index for index in range(self.width) if index not in clocks]


def channels(
    file: File,
    found: Sequence[Channel],
    word: str = "channel",
    key: str = "channel",
    shares: bool = False,
) -> Channels:
    """Give the columns of a file that holds numbers, not text."""
    labels = tuple(channel.label for channel in found)
    return Channels(
        shown=file.shown,
        labels=labels if any(label.text or label.unit for label in labels) else (),
        width=len(found),
        word=word,
        key=key,
        shares=shares,
        channels=tuple(found),
    )
