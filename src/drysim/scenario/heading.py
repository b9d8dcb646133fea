"""What a scenario file says about itself: the version of its format, and its name."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator

from drysim.quantity import shown

FORMAT = 1
"""Version of the file format."""

LONGEST = 100
"""Characters of a name, so that a folder can have it everywhere."""

NAME = re.compile(r"[^\W_]([\w .-]*[\w-])?")
"""What a name is written with."""

DEVICE = re.compile(r"(?i)(con|prn|aux|nul|com[1-9]|lpt[1-9])(\..*)?")
"""What no folder of Windows can be called, whatever stands behind the point."""


def _known(version: object) -> object:
    if version is True or version != FORMAT:
        reads = f"must be {FORMAT}, the file format that this drysim reads"
        raise ValueError(f"{reads}, not {shown(version)}")
    return FORMAT


def unfit(name: str) -> str:
    """Say why a name is none for a folder; nothing when it is."""
    if len(name) > LONGEST:
        return f"must have at most {LONGEST} characters, not {len(name)}"
    if name.endswith(".partial"):
        return f"must not end as a folder of unfinished work does, like {shown(name)}"
    if DEVICE.fullmatch(name):
        return f"must not be what Windows calls a device by, like {shown(name)}"
    if not NAME.fullmatch(name):
        return (
            "must be letters, digits, spaces, `.`, `_` and `-`, a letter or digit first and "
            f"no space or `.` last, not {shown(name)}"
        )
    return ""


def _of_a_folder(name: str) -> str:
    if reason := unfit(name):
        raise ValueError(f"{reason}; the output folder is named after it")
    return name


Format = Annotated[int, BeforeValidator(_known)]
"""A version of the file format that this drysim reads."""

FolderName = Annotated[str, AfterValidator(_of_a_folder)]
"""A name that the output folder can have."""
