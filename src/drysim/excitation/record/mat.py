"""MAT: variables as MATLAB saves them, versions 4 to 7.

Read here and not by scipy, whose reader a damaged file can bring to a segmentation fault.
"""

from __future__ import annotations

from drysim.excitation.record.channels import Channel, Channels, channels
from drysim.excitation.record.columns import Label
from drysim.excitation.record.file import File, fault
from drysim.excitation.record.format import NO_CHANNEL, NO_FULL_SCALE, NO_TABLE, Format
from drysim.excitation.record.mat4 import variables as variables_of_4
from drysim.excitation.record.mat5 import variables as variables_of_5


def columns(file: File) -> Channels:
    """Give the vectors among the variables of a MAT file.

    Raises
    ------
    RecordError
        When it is of version 7.3, damaged, or holds no vector of real numbers.
    """
    head = file.reader[:1024]
    if head[:10] == b"MATLAB 7.3" or b"\x89HDF\r\n\x1a\n" in head:
        sentence = "the MAT file is of version 7.3, which is not read; save it by `save -v7`"
        raise fault(file.shown, sentence)
    # Text begins version 5; the first number of version 4 has a zero byte.
    found = variables_of_4(file) if 0 in head[:4] else variables_of_5(file)
    vectors = [
        Channel(Label(variable.name, variable.name), variable.load)
        for variable in found
        if len(variable.shape) == 2 and min(variable.shape) == 1 < max(variable.shape)
    ]
    if not vectors:
        raise fault(file.shown, "the MAT file holds no vector of real numbers")
    return channels(file, vectors, word="variable", key="column")


FORMAT = Format(
    "a MAT file",
    columns,
    {"skip": NO_TABLE, "channel": NO_CHANNEL, "full_scale": NO_FULL_SCALE},
)
