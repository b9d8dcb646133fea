"""What a format of record files is: its name, its keys, and how its columns are found."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from drysim.excitation.record.columns import Columns
from drysim.excitation.record.file import File

OWN_STEP = "knows the step of its samples; remove `{key}`"
NO_TIME = "knows the times of its samples; remove `{key}`"
AS_CHANNEL = "has channels; write `channel` in place of `column`"
NO_CHANNEL = "has no channels; write `column` in place of `channel`"
ONE_SERIES = "has one series only; remove `{key}`"
NO_TABLE = "is no table of text; remove `skip`"
NO_FULL_SCALE = "needs no full scale; remove `full_scale`, and give `unit` if it has none"


class Format(NamedTuple):
    """One format.

    Attributes
    ----------
    name : str
        As sentences have it, with its article.
    columns : callable
        Gives the columns of a file.
    idle : mapping
        Keys of a record that mean nothing here, and what a sentence says of each.
    """

    name: str
    columns: Callable[[File], Columns]
    idle: Mapping[str, str]
