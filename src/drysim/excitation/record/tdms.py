"""TDMS: files of LabVIEW and its relatives; read by npTDMS."""

from __future__ import annotations

from functools import partial
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drysim.excitation.record.channels import Channel, Channels, channels
from drysim.excitation.record.columns import Label
from drysim.excitation.record.file import File, fault
from drysim.excitation.record.foreign import package, read_by
from drysim.excitation.record.format import AS_CHANNEL, NO_FULL_SCALE, NO_TABLE, Format

UNITS = ("unit_string", "NI_UnitDescription")
"""Properties that may hold the unit of a channel."""


def columns(file: File) -> Channels:
    """Give the channels of a TDMS file, of all its groups.

    Raises
    ------
    RecordError
        When it is damaged or has no channels; or npTDMS is not installed.
    """
    nptdms = package("nptdms", "tdms", file)
    found = read_by(lambda: _listed(file, nptdms), file, "the record is no TDMS, or damaged")
    if not found:
        raise fault(file.shown, "the TDMS file has no channels")
    return channels(file, found)


def _listed(file: File, nptdms: Any) -> list[Channel]:
    whole = nptdms.TdmsFile.read_metadata(BytesIO(file.raw))
    if whole.file_status.incomplete_final_segment:
        raise fault(file.shown, "the TDMS file is cut short: its last segment is not whole")
    return [_channel(file, channel) for group in whole.groups() for channel in group.channels()]


def _channel(file: File, channel: Any) -> Channel:
    group, name, told = channel.group_name, channel.name, channel.properties
    unit = next((str(told[key]).strip() for key in UNITS if told.get(key)), "")
    step = float(told.get("wf_increment", 0.0))
    return Channel(
        Label(f"{group}/{name}", name, unit, firm=False),
        partial(_load, file, group, name),
        step if step > 0 else None,
        float(told.get("wf_start_offset", 0.0)),
    )


def _load(file: File, group: str, name: str) -> NDArray[np.generic]:
    nptdms = package("nptdms", "tdms", file)

    def read() -> NDArray[np.generic]:
        with nptdms.TdmsFile.open(BytesIO(file.raw)) as whole:
            return np.asarray(whole[group][name][:])

    return read_by(read, file, f"channel `{Label(name, name).quote}` cannot be read")


FORMAT = Format(
    "a TDMS",
    columns,
    {"skip": NO_TABLE, "column": AS_CHANNEL, "full_scale": NO_FULL_SCALE},
)
