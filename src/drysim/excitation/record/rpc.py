"""RPC III: time histories of test rigs, as MTS lays them down; read by rpc3-file."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drysim.excitation.record.channels import Channel, Channels, channels
from drysim.excitation.record.columns import Label
from drysim.excitation.record.file import File, fault
from drysim.excitation.record.foreign import package, read_by
from drysim.excitation.record.format import (
    AS_CHANNEL,
    NO_FULL_SCALE,
    NO_TABLE,
    OWN_STEP,
    Format,
)

DAMAGED = "the record is no RPC III time history, or damaged"


def columns(file: File) -> Channels:
    """Give the channels of an RPC III file.

    Raises
    ------
    RecordError
        When it is damaged or has no channels; or rpc3-file is not installed.

    Notes
    -----
    Whole numbers are multiplied by the SCALE of their channel; INT_FULL_SCALE is not needed for
    that. A file that does not say its number of SAMPLES ends with its last frame, filled up.
    """
    found = _read(file, header_only=True)
    if not found:
        raise fault(file.shown, "the RPC III file has no channels")
    return channels(file, [_channel(file, at, told) for at, told in enumerate(found)])


def _channel(file: File, at: int, told: Any) -> Channel:
    name, unit = (str(text).strip().strip('"').strip() for text in (told.name, told.unit))
    return Channel(Label(name, name, unit, firm=False), partial(_load, file, at), told.dt)


def _load(file: File, at: int) -> NDArray[np.generic]:
    return np.asarray(_read(file, header_only=False)[at].data)


def _read(file: File, header_only: bool) -> Any:
    rpc3 = package("rpc3.rpc3", "rpc", file, "rpc3-file")

    def read() -> Any:
        rpc3.progressbar = False
        return rpc3.read(str(file.path), strip=False, header_only=header_only)[0]

    return read_by(read, file, DAMAGED)


FORMAT = Format(
    "an RPC III file",
    columns,
    {
        "skip": NO_TABLE,
        "column": AS_CHANNEL,
        "time": OWN_STEP,
        "rate": OWN_STEP,
        "step": OWN_STEP,
        "full_scale": NO_FULL_SCALE,
    },
)
