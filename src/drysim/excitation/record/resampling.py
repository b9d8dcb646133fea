"""A record on another grid, on request: between its samples by a stated way, never folded."""

from __future__ import annotations

from math import ceil, floor
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from drysim.errors import RecordError
from drysim.excitation.record.columns import Floats
from drysim.excitation.record.file import fault, fit
from drysim.excitation.record.filters import gain
from drysim.excitation.record.gaps import between
from drysim.excitation.record.grid import Grid
from drysim.excitation.record.reports import Report, report
from drysim.excitation.record.shape import Series

if TYPE_CHECKING:
    from drysim.excitation.record.spoken import Removal, Resample

ALIAS = 0.1
"""What a low-pass may leave of an amplitude at half the new rate: a tenth, 20 dB down."""

CLEAR = 0.99
"""Share of the highest frequency of such a low-pass that a message names in few digits."""

SAME = 1e-9
"""Two steps this close, relative to them, are one."""

SAME_UNEVEN = 1e-2
"""The same against the mean of uneven steps: their half rate is no sharper than that."""


class Onto(NamedTuple):
    """A grid that is `times` as fine as the one that was asked for, and that one's step [s].

    A record that loses rate is filtered in between, on the finer grid.
    """

    step: float
    times: int


def target(wanted: Resample, removal: Removal, grid: Grid, shown: str) -> Onto:
    """Give the grid to go by: as fine as the record's own, or finer.

    Raises
    ------
    RecordError
        When frequencies would fold, because no low-pass is stated that keeps them out.
    """
    step = wanted.step or 1 / (wanted.rate or 1.0)
    same = SAME if grid.spread is None else SAME_UNEVEN
    times = max(1, ceil(step / grid.dt * (1 - same)))
    if times > 1:
        half, order = 1 / (2 * step), removal.order
        if removal.above is None or gain(half, removal.above, order) > ALIAS * (1 + SAME):
            raise _folding(half, order, grid, shown)
    return Onto(step, times)


def _folding(half: float, order: int, grid: Grid, shown: str) -> RecordError:
    """Give the error for a loss of rate without the filter for it."""
    most = half * (1 / ALIAS - 1) ** (-1 / (2 * order))
    sentence = (
        f"resampling from {1 / grid.dt:.6g} to {2 * half:.6g} Hz would fold what is above "
        f"{half:.6g} Hz; state a low-pass that leaves a tenth of it or less there, "
        f"`remove: {{above: {CLEAR * most:.3g} Hz, order: {order}}}` or lower"
    )
    return fault(shown, sentence)


def onto(values: Floats, grid: Grid, wanted: Resample, goal: Onto, shown: str) -> Series:
    """Give samples on the grid to go by, which ends where the record does."""
    at, fine = grid.at, goal.step / goal.times
    n = len(values)
    length = (n - 1.0 if at is None else float(at[-1])) * grid.dt
    count = floor(length / fine * (1 + SAME)) + 1
    if at is None and abs(fine / grid.dt - 1) <= SAME:
        return Series(values, fine, grid.first)
    fit(shown, 8 * count)
    if count < 2:
        raise fault(shown, f"the record lasts {length:.6g} s, less than `resample` asks for")
    places = np.minimum(np.arange(count) * (fine / grid.dt), length / grid.dt)
    own = np.arange(float(n)) if at is None else at
    return Series(between(own, values, places, wanted.by), fine, grid.first)


def thinned(series: Series, goal: Onto) -> Series:
    """Give every sample that lies on the grid that was asked for."""
    return series._replace(values=series.values[:: goal.times].copy(), dt=goal.step)


def told(
    before: Floats, grid: Grid, after: Series, goal: Onto, wanted: Resample, unit: str
) -> Report:
    """Give the report of a resampling: samples as they were, and between them."""
    numbers = {"step_before": grid.dt, "step_after": goal.step}
    was = f"{1 / grid.dt:.6g} Hz"
    if grid.spread is not None:
        least, most = grid.spread
        numbers |= {"least_step": least, "greatest_step": most}
        was = f"uneven steps of {least:.4g} to {most:.4g} s, {grid.dt:.4g} s in the mean,"
    sentence = f"resampled from {was} to {1 / goal.step:.6g} Hz by {wanted.by}s"
    return report("resample", sentence, before, after.values[:], unit, numbers)
