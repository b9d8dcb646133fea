"""Values and words as they may leave the machine: no absolute path, nothing but JSON."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping
from math import isfinite
from pathlib import PurePath
from typing import Any

import numpy as np

ABSOLUTE = re.compile(
    r"(?<![\w.)\]/~:-])(?:~\w*|[A-Za-z]:)?[\\/](?:[^\\/\s'\"`:;,=]+[\\/])*(?=\w)"
)
"""The folders of an absolute path within a sentence."""

LEADING = re.compile(r"(^|=)(?:~\w*|[A-Za-z]:)?[\\/](?:.*[\\/])?(?=.)")
"""The folders of an absolute path that is a word of a command, spaces and all."""


def bare_name(file: str) -> str:
    """Give the name of a file as it was given, but without the folders of an absolute one."""
    return LEADING.sub("", file, count=1)


def bare_command(command: str) -> str:
    """Give a command line, without the folders of absolute paths."""
    try:
        words = shlex.split(command)
    except ValueError:
        return command
    return shlex.join(LEADING.sub(r"\1", word) for word in words)


def plain(value: Any) -> Any:
    """Give a value as JSON knows it: finite numbers, no absolute path, nothing of numpy."""
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, str):
        return ABSOLUTE.sub("", value).encode(errors="replace").decode()
    return str(value) if isinstance(value, PurePath) else value
