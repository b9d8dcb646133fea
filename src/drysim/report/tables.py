"""CSV files; owns the column names and their units."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drysim.approach.events import EVENT_NAMES
from drysim.core.plant import Stopped
from drysim.core.signal import BLOCK
from drysim.metrics import UNITS as METRIC_UNITS
from drysim.report.cells import Block, Text, joined, rows, text

if TYPE_CHECKING:
    from drysim.approach.events import Events
    from drysim.approach.response import Response
    from drysim.study.outcome import Outcome

NUMBERS = (
    "stuck", "seeds", "checks", "passed", "samples", "repeats", "error_x_r", "error_T_a",
    "T_a_deviation", "T_a_deviation_half_width", "x_r_peak_deviation", "x_r_rms_deviation",
    "time_over_lfilter",
)  # fmt: skip
"""Columns of plain numbers that are no metrics."""

UNITS = {
    **METRIC_UNITS,
    **dict.fromkeys(NUMBERS, "-"),
    "t": "s", "t_first": "s", "time": "s", "step": "s", "time_per_sample": "ns",
    "u_dd": "m/s2", "x_dd": "m/s2", "x_r": "m", "v_r": "m/s",
    "F_f": "N", "F_stop": "N", "F_L": "N", "F_fk": "N", "F_fs": "N",
    "event": "", "law": "",
}  # fmt: skip
"""Every column of fixed name, with its unit; an empty one stands for words."""

RESPONSE = ("t", "u_dd", "x_r", "v_r", "x_dd", "F_f", "stuck")
EVENTS = ("t", "event", "x_r", "F_L")
STROKE = ("t_first", "x_r_peak", "t_beyond", "violations")
VIOLATION = ("t_first_violation", *STROKE[1:])
"""The columns of stroke_violations.csv, and the metrics in them."""

STUCK = ("0", "1")
CODES = sorted(EVENT_NAMES)


def response(outcome: Outcome, folder: Path) -> None:
    """Write response.csv: the motion on its grid; where there are end stops, their force too.

    Parameters
    ----------
    outcome : Outcome
    folder : Path
        Where to write.
    """
    motion = outcome.response
    stops = isinstance(motion.law, Stopped)
    blocks = (_motion(motion, part, stops) for part in motion.parts())
    columns = (*RESPONSE, "F_stop") if stops else RESPONSE
    write(folder / "response.csv", [*map(heading, columns)], rows(blocks, STUCK, 6))


def events(outcome: Outcome, folder: Path) -> None:
    """Write events.csv: stops, break-aways, reversals; the first row is the state at t = 0."""
    found = outcome.response.events
    names = [EVENT_NAMES[code] for code in CODES]
    starts = range(0, len(found), BLOCK)
    blocks = (_events(found, slice(start, start + BLOCK)) for start in starts)
    write(folder / "events.csv", [*map(heading, EVENTS)], rows(blocks, names, 1))


def stroke_violations(outcome: Outcome, folder: Path) -> None:
    """Write stroke_violations.csv, but only when the stroke limit was met."""
    found = dict(outcome.metrics)
    if not found["violations"]:
        return
    for caution in outcome.warnings:
        # The peak of the metrics is that of their window; the limit may be met before.
        if caution.slug == "stroke-violated":
            found |= caution.numbers
    cells = [[text(found[name])] for name in VIOLATION]
    write(folder / "stroke_violations.csv", [*map(heading, STROKE)], [joined(cells)])


def _motion(motion: Response, part: slice, stops: bool) -> Block:
    """Give one block of response.csv."""
    x_r, v_r, d, *_ = motion.points(part)
    t = np.arange(part.start, part.stop) * motion.dt
    u_dd, x_dd = motion.base(part), motion.acceleration(part)
    series = (t, u_dd, x_r, v_r, x_dd, motion.friction(part))
    return Block((*series, motion.stop(part)) if stops else series, d == 0)


def _events(found: Events, part: slice) -> Block:
    """Give one block of events.csv."""
    words = np.searchsorted(CODES, found.kind[part])
    return Block((found.t[part], found.x_r[part], found.F_L[part]), words)


def write(file: Path, headings: Sequence[str], blocks: Iterable[Text]) -> None:
    """Write a header row and blocks of rows."""
    with file.open("wb") as out:
        out.write((",".join(headings) + "\n").encode())
        out.writelines(blocks)


def heading(name: str) -> str:
    """Give the header cell of a column, e.g. `x_r [m]`."""
    return f"{name} [{UNITS[name]}]" if UNITS[name] else name
