"""What a scenario file says about itself: the version of its format, and its name."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator

from drysim.quantity import shown

FORMAT = 1
"""Version of the file format."""

NAME = re.compile(r"[^\W_][\w .-]{0,98}[\w-]|[^\W_]")
"""A name that is a good name for a folder everywhere."""


def _known(version: object) -> object:
    if version is True or version != FORMAT:
        reads = f"must be {FORMAT}, the file format that this drysim reads"
        raise ValueError(f"{reads}, not {shown(version)}")
    return FORMAT


def _of_a_folder(name: str) -> str:
    if not NAME.fullmatch(name) or name.endswith(".partial"):
        raise ValueError(
            "must be letters, digits, spaces, `.`, `_` and `-`, a letter or digit first, "
            f"as the output folder is named after it; not {shown(name)}"
        )
    return name


Format = Annotated[int, BeforeValidator(_known)]
"""A version of the file format that this drysim reads."""

FolderName = Annotated[str, AfterValidator(_of_a_folder)]
"""A name that the output folder can have."""
