"""Gaps of a record: where samples are missing, and how short gaps are filled on request."""

from __future__ import annotations

from math import ceil, floor, log10
from typing import TYPE_CHECKING

import numpy as np

from drysim.excitation.record.columns import Columns, Floats, gap
from drysim.excitation.record.grid import HOLE, Grid
from drysim.excitation.record.reports import Report, report
from drysim.wording import several

if TYPE_CHECKING:
    from drysim.excitation.record.spoken import Gaps

ROUNDING = 1e-9
"""By which share a gap may be longer than asked for: rounding of its times."""


def closed(
    values: Floats, grid: Grid, gaps: Gaps | None, columns: Columns, index: int, unit: str
) -> tuple[Floats, Grid, Report | None]:
    """Give samples without gaps, where they are, and the report of what was filled.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Samples in SI; NaN where one is missing.
    grid : Grid
        Where they are.
    gaps : Gaps or None
        What the scenario says of gaps; with nothing said, each is a fault.
    columns : Columns
    index : int
        0-based column of the samples.
    unit : str
        SI unit of the samples.

    Raises
    ------
    RecordError
        When a gap is longer than asked for, or at an end; its row is named.
    """
    there = ~np.isnan(values)
    if grid.at is None and there.all():
        return values, grid, None
    at = (np.arange(float(len(values))) if grid.at is None else grid.at)[there]
    rows, known = np.flatnonzero(there), values[there]
    steps = np.diff(at)
    holes = np.flatnonzero(steps > HOLE)
    if len(known) < 2 or not (there[0] and there[-1]):
        row = 0 if not there[0] else len(values) - 1
        raise columns.at(row, index, "the record begins or ends with a gap; cut that away")
    if not len(holes):
        return known, grid._replace(at=at), None
    allowed = 0.0 if gaps is None else gaps.at_most * (1 + ROUNDING)
    long = holes[steps[holes] * grid.dt > allowed]
    if gaps is None or len(long):
        width, row = float(steps[long[0]]), int(rows[long[0] + 1])
        longest = float(steps[holes].max()) * grid.dt
        raise columns.at(row, index, _refusal(width, grid.dt, gaps, len(holes), longest))
    missing = np.rint(steps[holes]).astype(int) - 1
    after = np.repeat(holes, missing)
    share = np.concatenate([np.arange(1, n + 1) / (n + 1) for n in missing.tolist()])
    new = at[after] + share * steps[after]
    filled = np.insert(known, after + 1, between(at, known, new, gaps.fill))
    longest = float(steps[holes].max()) * grid.dt
    numbers = {"gaps": len(holes), "samples": int(missing.sum()), "longest": longest}
    sentence = (
        f"{several(len(holes), 'gap')} of {numbers['samples']} samples in all filled by "
        f"{gaps.fill}s, "
        f"the longest of {longest:.4g} s"
    )
    told = report("gaps", sentence, known, filled, unit, numbers)
    return filled, grid._replace(at=np.insert(at, after + 1, new)), told


def between(at: Floats, values: Floats, wanted: Floats, by: str) -> Floats:
    """Give values between samples: on the `line` or the C² cubic `spline` through them."""
    if by == "line":
        return np.interp(wanted, at, values)
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(at, values)(wanted), dtype=np.float64)


def _refusal(width: float, dt: float, gaps: Gaps | None, number: int, longest: float) -> str:
    """Say what is missing in a gap of so many steps, and what can be done about it."""
    missing = round(width) - 1
    count = f"{several(missing, 'sample')} {'is' if missing == 1 else 'are'}"
    more = f" ({several(number, 'gap')} in all)" if number > 1 else ""
    way = gap(_at_most(longest), "it" if number == 1 else "them all")
    if gaps is not None:
        way = f"`gaps.at_most` allows {gaps.at_most:.6g} s"
    return (
        f"{count} missing before this row: {width * dt:.6g} s to it, {dt:.6g} s as a rule"
        f"{more}: {way}"
    )


def _at_most(longest: float) -> str:
    """Give the `gaps.at_most` of three digits, rounded up, that a gap this long [s] needs."""
    digit = 10.0 ** (floor(log10(longest)) - 2)
    seconds = ceil(longest / digit * (1 - ROUNDING)) * digit
    return f"{seconds:.3g} s" if seconds >= 1.0 else f"{seconds * 1e3:.3g} ms"
