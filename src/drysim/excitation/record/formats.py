"""The shelf of formats: one file and one name here for each."""

from __future__ import annotations

from pathlib import Path

from drysim.excitation.record.at2 import AT2
from drysim.excitation.record.format import Format
from drysim.excitation.record.mat import MAT
from drysim.excitation.record.mdf import MDF
from drysim.excitation.record.rpc import RPC
from drysim.excitation.record.tdms import TDMS
from drysim.excitation.record.text import TEXT
from drysim.excitation.record.uff import UFF
from drysim.excitation.record.wav import WAV

FORMATS = (TEXT, WAV, MAT, AT2, UFF, MDF, TDMS, RPC)

SUFFIXES = tuple(suffix for member in FORMATS for suffix in member.suffixes)
"""What is read."""


def format_of(file: str | Path) -> Format | None:
    """Give the format that the suffix of a file tells."""
    suffix = Path(file).suffix.lower()
    return next((member for member in FORMATS if suffix in member.suffixes), None)
