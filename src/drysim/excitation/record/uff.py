"""UFF58: universal files with functions at nodal degrees of freedom; read by pyuff."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drysim.excitation.record.channels import Channel, Channels, channels
from drysim.excitation.record.columns import Label
from drysim.excitation.record.file import File, fault
from drysim.excitation.record.foreign import package, read_by
from drysim.excitation.record.format import AS_CHANNEL, NO_FULL_SCALE, NO_TABLE, NO_TIME, Format
from drysim.quantity import factor

FUNCTIONS = 58
"""Number of the data set that holds samples."""

TIME_RESPONSE = 1
"""Type of a function that is a time history."""

REAL = (2, 4)
"""Single and double precision; the others are complex."""

MARK = re.compile(rb"    -1(?= {74}|[\r\n]|\Z)")
"""The line before and behind every data set; behind binary samples it has no beginning."""

NOT_ONE = "the record is no universal file, or damaged"

DIRECTIONS = ("", "+X", "+Y", "+Z", "+RX", "+RY", "+RZ", "-RZ", "-RY", "-RX", "-Z", "-Y", "-X")
"""By number; those below zero count from the end."""


def columns(file: File) -> Channels:
    """Give the time histories of a universal file, in their order.

    Raises
    ------
    RecordError
        When it is damaged, or holds no time history; or pyuff is not installed.
    """
    pyuff = package("pyuff", "uff", file)
    if len(MARK.findall(file.raw)) % 2:
        raise fault(file.shown, f"{NOT_ONE}: its last data set does not end")
    found = read_by(lambda: _histories(file, pyuff), file, NOT_ONE)
    if not found:
        sentence = "the record is no universal file with a time history in a data set 58"
        raise fault(file.shown, sentence)
    clocks = [at for at, (channel, _) in enumerate(found) if channel.dt is None]
    times = [found[at][1] for at in clocks]
    series = [
        channel._replace(clock=len(found) + clocks.index(at)) if at in clocks else channel
        for at, (channel, _) in enumerate(found)
    ]
    return channels(file, [*series, *times])


def _histories(file: File, pyuff: Any) -> list[tuple[Channel, Channel]]:
    """Give every time history and its times."""
    sets = pyuff.UFF(str(file.path))
    numbers = [n for n, kind in enumerate(sets.get_set_types()) if kind == FUNCTIONS]
    heads = [(n, sets.read_sets(n, header_only=True)) for n in numbers]
    return [
        _channel(file, sets, n, head)
        for n, head in heads
        if head["func_type"] == TIME_RESPONSE and head["ord_data_type"] in REAL
    ]


def _channel(file: File, sets: Any, n: int, head: Mapping[str, Any]) -> tuple[Channel, Channel]:
    """Give a time history and its times."""
    name = _said(head, "id1") or f"{head['rsp_node']}{DIRECTIONS[head['rsp_dir']]}"
    unit = _said(head, "ordinate_axis_units_lab")
    second = _said(head, "abscissa_axis_units_lab").lower()
    even = head["abscissa_spacing"] == 1
    step = head["abscissa_inc"] * _seconds(file, second) if even else None
    first = head["abscissa_min"] * _seconds(file, second) if even else 0.0
    load, clock = partial(_load, file, sets, n, head["num_pts"]), f"time of {name}"
    samples = Channel(Label(name, name, unit, firm=False), partial(load, "data"), step, first)
    return samples, Channel(Label(clock, clock, second), partial(load, "x"))


def _said(head: Mapping[str, Any], key: str) -> str:
    text = str(head[key]).strip()
    return "" if text.upper() == "NONE" else text


def _seconds(file: File, unit: str) -> float:
    try:
        return factor(unit, "s") if unit else 1.0
    except ValueError as error:
        raise fault(file.shown, f"the abscissa of a time history: {error}") from None


def _load(file: File, sets: Any, n: int, count: int, what: str) -> NDArray[np.generic]:
    where = f"data set {n + 1} cannot be read"
    values = read_by(lambda: np.asarray(sets.read_sets(n)[what]), file, where)
    if len(values) != count:
        sentence = f"data set {n + 1} is cut short or damaged"
        raise fault(file.shown, f"{sentence}: it has {len(values)} samples, not {count}")
    return values


FORMAT = Format(
    "a universal file",
    columns,
    {"skip": NO_TABLE, "column": AS_CHANNEL, "time": NO_TIME, "full_scale": NO_FULL_SCALE},
)
