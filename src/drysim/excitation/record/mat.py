"""MAT: variables as MATLAB saves them, versions 4 to 7."""

from __future__ import annotations

from functools import partial
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drysim.excitation.record.channels import Channel, Channels, channels
from drysim.excitation.record.columns import Label
from drysim.excitation.record.file import File, fault
from drysim.excitation.record.foreign import read_by
from drysim.excitation.record.format import NO_CHANNEL, NO_FULL_SCALE, Format

REAL = {"double", "single"} | {f"{sign}int{n}" for sign in ("", "u") for n in (8, 16, 32, 64)}
"""Classes of variables that may hold samples."""


def columns(file: File) -> Channels:
    """Give the vectors among the variables of a MAT file.

    Raises
    ------
    RecordError
        When it is of version 7.3, damaged, or holds no vector of numbers.
    """
    if file.raw[:10] == b"MATLAB 7.3" or b"\x89HDF\r\n\x1a\n" in file.raw[:1024]:
        sentence = "the MAT file is of version 7.3, which is not read; save it by `save -v7`"
        raise fault(file.shown, sentence)
    from scipy.io import whosmat

    stream: Any = BytesIO(file.raw)
    listed = read_by(lambda: whosmat(stream), file, "the record is no MAT file, or damaged")
    vectors = [
        str(name)
        for name, shape, kind in listed
        if kind in REAL and len(shape) == 2 and min(shape) == 1 < max(shape)
    ]
    if not vectors:
        raise fault(file.shown, "the MAT file holds no vector of numbers")
    found = [Channel(Label(name, name), partial(_load, file, name)) for name in vectors]
    return channels(file, found, word="variable", key="column")


def _load(file: File, name: str) -> NDArray[np.generic]:
    from scipy.io import loadmat

    stream: Any = BytesIO(file.raw)
    what = f"variable `{Label(name, name).quote}` cannot be read"
    return read_by(
        lambda: np.asarray(loadmat(stream, variable_names=[name])[name]).ravel(), file, what
    )


MAT = Format(
    "a MAT file",
    (".mat",),
    columns,
    {"channel": NO_CHANNEL, "full_scale": NO_FULL_SCALE},
)
