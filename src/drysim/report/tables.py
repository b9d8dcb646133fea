"""CSV files; owns the column names and their units."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from drysim.approach.events import Floats
    from drysim.approach.response import Response
    from drysim.study.outcome import Outcome

UNITS = {
    "t": "s",
    "u_dd": "m/s2",
    "x_r": "m",
    "v_r": "m/s",
    "x_dd": "m/s2",
    "F_f": "N",
    "F_L": "N",
    "stuck": "-",
    "event": "",
    "t_first": "s",
    "x_r_peak": "m",
    "t_beyond": "s",
    "violations": "-",
    "F_fk": "N",
    "F_fs": "N",
    "a_u": "m/s2",
    "a_x": "m/s2",
    "T_a": "-",
    "T_x": "-",
    "x_r_rms": "m",
    "stroke_used": "-",
    "stuck_share": "-",
    "chatter_share": "-",
    "closure": "-",
    "T_a_deviation": "-",
    "x_r_peak_deviation": "-",
    "x_r_rms_deviation": "-",
    "checks": "-",
    "passed": "-",
    "time": "s",
    "step": "s",
    "time_per_sample": "ns",
    "error_x_r": "-",
    "error_T_a": "-",
    "energy_residual": "-",
    "time_over_lfilter": "-",
    "samples": "-",
    "repeats": "-",
    "a_w": "m/s2",
    "SEAT": "-",
    "VDV": "m/s^1.75",
    "SEAT_VDV": "-",
    "MTVV": "m/s2",
    "crest_factor": "-",
}
"""Every column of fixed name, with its unit; an empty one stands for words."""

RESPONSE = ("t", "u_dd", "x_r", "v_r", "x_dd", "F_f", "stuck")
EVENTS = ("t", "event", "x_r", "F_L")
COMFORT = ("a_w", "SEAT", "VDV", "SEAT_VDV", "MTVV", "crest_factor")
STROKE = ("t_first", "x_r_peak", "t_beyond", "violations")

BLOCK = 65_536
"""Rows made at a time: a block of text is some 10 MB, however long the response is."""


def response(outcome: Outcome, folder: Path) -> None:
    """Write response.csv: the motion on its grid.

    Parameters
    ----------
    outcome : Outcome
    folder : Path
        Where to write.
    """
    motion = outcome.response
    blocks = (_motion(motion, part) for part in _parts(len(motion.x_r)))
    write(folder / "response.csv", [*map(heading, RESPONSE)], blocks)


def events(outcome: Outcome, folder: Path) -> None:
    """Write events.csv: stops, break-aways, reversals; the first row is the state at t = 0."""
    found = outcome.response.events
    names = found.names
    blocks = (
        [texts(found.t[part]), names[part], texts(found.x_r[part]), texts(found.F_L[part])]
        for part in _parts(len(found))
    )
    write(folder / "events.csv", [*map(heading, EVENTS)], blocks)


def stroke_violations(outcome: Outcome, folder: Path) -> None:
    """Write stroke_violations.csv, but only when the stroke limit was met."""
    found = dict(outcome.metrics)
    if not found["violations"]:
        return
    for caution in outcome.warnings:
        # The peak of the metrics is that of their window; the limit may be met before.
        if caution.slug == "stroke-violated":
            found |= caution.numbers
    row = (found[name] for name in ("t_first_violation", "x_r_peak", "t_beyond", "violations"))
    cells = [["" if value is None else str(value)] for value in row]
    write(folder / "stroke_violations.csv", [*map(heading, STROKE)], [cells])


def _motion(motion: Response, part: slice) -> list[Iterable[str]]:
    """Give one block of response.csv, column by column."""
    t = np.arange(part.start, part.stop) * motion.dt
    series = (
        t,
        motion.u_dd[part],
        motion.x_r[part],
        motion.v_r[part],
        motion.acceleration(part),
        motion.friction(part),
    )
    return [*map(texts, series), map("01".__getitem__, (motion.d[part] == 0).tolist())]


def texts(values: Floats) -> Iterator[str]:
    """Give the shortest text that reads back as the same number; -0.0 becomes 0.0."""
    return map(repr, (values + 0.0).tolist())


def _parts(length: int) -> Iterator[slice]:
    """Cut a length into blocks."""
    return (slice(at, min(at + BLOCK, length)) for at in range(0, length, BLOCK))


def write(
    file: Path, headings: Sequence[str], blocks: Iterable[Sequence[Iterable[str]]]
) -> None:
    """Write a header row and blocks of columns."""
    with file.open("w", encoding="utf-8", newline="\n") as out:
        out.write(",".join(headings) + "\n")
        for block in blocks:
            out.writelines(map("{}\n".format, map(",".join, zip(*block, strict=True))))


def heading(name: str) -> str:
    """Give the header cell of a column, e.g. `x_r [m]`."""
    return f"{name} [{UNITS[name]}]" if UNITS[name] else name
