"""The shelf of formats: one file, and one line here for each suffix."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from drysim.excitation.record.format import Format

SUFFIXES = {
    ".csv": "text",
    ".tsv": "text",
    ".txt": "text",
    ".dat": "text",
    ".wav": "wav",
    ".mat": "mat",
    ".at2": "at2",
    ".uff": "uff",
    ".unv": "uff",
    ".mf4": "mdf",
    ".mdf": "mdf",
    ".tdms": "tdms",
    ".rpc": "rpc",
    ".rsp": "rpc",
    ".tim": "rpc",
    ".drv": "rpc",
}
"""What is read, and the module whose `FORMAT` reads it; loaded when a file asks for it."""


def format_of(file: str | Path) -> Format | None:
    """Give the format that the suffix of a file tells."""
    module = SUFFIXES.get(Path(file).suffix.lower())
    if module is None:
        return None
    found: Format = import_module(f"drysim.excitation.record.{module}").FORMAT
    return found
