"""MDF: measurements of vehicles, as ASAM lays them down; version 4, read by asammdf."""

from __future__ import annotations

from functools import partial
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drysim.excitation.record.channels import Channel, Channels, channels
from drysim.excitation.record.columns import Label
from drysim.excitation.record.file import File, fault, fit
from drysim.excitation.record.foreign import package, read_by
from drysim.excitation.record.format import AS_CHANNEL, NO_FULL_SCALE, NO_TABLE, NO_TIME, Format

LONGEST = 1 << 20
"""Bytes of a row of samples that a small packed file may still hold."""

SYNCHRONOUS = 1
"""What a master channel counts: time, and not angle or distance."""


def columns(file: File) -> Channels:
    """Give the channels of an MDF file, of all its groups, and behind them their times.

    Raises
    ------
    RecordError
        When it is damaged or has no channels; or asammdf is not installed.
    """
    found = _listed(file)
    if not found:
        raise fault(file.shown, "the MDF file has no channels")
    series = [
        Channel(
            Label(name, name, unit, firm=False),
            partial(_load, file, group, at, "samples"),
            clock=len(found) + number,
        )
        for number, (group, at, name, unit) in enumerate(found)
    ]
    clocks = [(group, at, f"time of {name}") for group, at, name, _ in found]
    times = [
        Channel(Label(clock, clock, "s"), partial(_load, file, group, at, "timestamps"))
        for group, at, clock in clocks
    ]
    return channels(file, [*series, *times])


def _listed(file: File) -> list[tuple[int, int, str, str]]:
    """Give group, number in it, name and unit of every channel that is no master."""
    asammdf = package("asammdf", "mdf", file)

    def read() -> list[tuple[int, int, str, str]]:
        with asammdf.MDF(BytesIO(file.raw)) as whole:
            return [
                (group, at, str(channel.name), str(channel.unit or "").strip())
                for group, content in enumerate(whole.groups)
                for at, channel in enumerate(content.channels)
                if whole.masters_db.get(group) != at
            ]

    return read_by(read, file, "the record is no MDF, or damaged")


def _check(file: File, about: Any) -> None:
    """Refuse sizes that the file cannot mean, before the package makes room for them."""
    size = about.samples_byte_nr + about.invalidation_bytes_nr
    if size > max(len(file.raw), LONGEST):
        raise fault(file.shown, f"the record is no MDF, or damaged: one row of {size} bytes")
    fit(file.shown, size * about.cycles_nr)


def _load(file: File, group: int, at: int, what: str) -> NDArray[np.generic]:
    """Samples that the logger marks as invalid are not given, nor are their times."""
    asammdf = package("asammdf", "mdf", file)

    def read() -> NDArray[np.generic]:
        with asammdf.MDF(BytesIO(file.raw)) as whole:
            _check(file, whole.groups[group].channel_group)
            signal = whole.get(group=group, index=at)
        if what == "timestamps" and signal.master_metadata[1] != SYNCHRONOUS:
            raise fault(file.shown, f"`{signal.name}` is not sampled over time")
        return np.asarray(getattr(signal, what))

    return read_by(read, file, f"channel {at} of group {group + 1} cannot be read")


FORMAT = Format(
    "an MDF",
    columns,
    {"skip": NO_TABLE, "column": AS_CHANNEL, "time": NO_TIME, "full_scale": NO_FULL_SCALE},
)
