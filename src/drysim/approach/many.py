"""Many records of one length under one scene: their integrals and turns, and nothing else."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.approach.events import Floats
from drysim.approach.room import empty_log
from drysim.approach.scene import LOG_LENGTH, waves_of
from drysim.core import records
from drysim.core.forms import step_forms
from drysim.core.march import STRETCH
from drysim.core.motion import Sines
from drysim.core.pieces import PIECE, Forms, Piece
from drysim.core.plant import Law, Plant, State, Totals
from drysim.core.steps import steps_of


class Measured(NamedTuple):
    """What many records come to: columns, shape (records,).

    Attributes
    ----------
    found : ndarray of bool
        Whether the record was measured. Where not, the numerics fail or events are too many
        for a batch: solved by itself, the record says which. The rest holds nothing then.
    totals : Totals
        Integrals over the window; `u2` holds 0 where the base displacement is not known.
    first, last : State
        At both ends of the window.
    peak, suffices : ndarray
        Greatest |x_r| in the window, and from the start to its end [m].
    upcrossings, entries : ndarray
        How often x_r passes zero upwards, and |x_r| reaches the stroke limit anew.
    events : ndarray
        Events from the start to the end of the window.
    closest : ndarray
        Tightest stop decision [-]; infinite for none.
    heights : tuple of ndarray
        Of every record: the greatest |x_r| between every two passages of zero [m].
    """

    found: NDArray[np.bool_]
    totals: Totals
    first: State
    last: State
    peak: Floats
    suffices: Floats
    upcrossings: Floats
    entries: Floats
    events: Floats
    closest: Floats
    heights: tuple[Floats, ...]


def measure_many(
    plant: Plant,
    law: Law,
    u_dd: Floats,
    dt: float,
    start: State,
    window: tuple[int, int],
    x_rM: float | None = None,
    u: Floats | None = None,
) -> Measured:
    """March many records and measure them, keeping nothing of the motion.

    Parameters
    ----------
    plant : Plant
    law : Law
        Constant limits only.
    u_dd : ndarray, shape (records, samples)
        Base acceleration [m/s²], linear between samples.
    dt : float
        Distance of the samples [s].
    start : State
        Of every record, at its first sample.
    window : tuple of int
        Samples at which the window begins and ends.
    x_rM : float or None
        Stroke limit [m].
    u : ndarray, shape (records, samples), or None
        Base displacement [m], where it is known.

    Returns
    -------
    Measured

    Notes
    -----
    One call runs in one thread and lets others run: batches may be given to several. Memory
    does not grow with the length of the records.
    """
    limit = np.inf if x_rM is None else x_rM
    answers = np.empty((len(u_dd), records.FOUND))
    heights: Floats = np.empty(u_dd.shape)
    records.measure_records(
        plant, law, steps_of(plant, law, dt), forms_of(plant, dt), waves_of(Sines((), (), ())),
        rows(u_dd), np.empty((len(u_dd), 0)) if u is None else rows(u), *window, start, limit,
        empty_piece(), empty_log(LOG_LENGTH), LOG_LENGTH, heights, answers,
    )  # fmt: skip
    column = answers.T
    cycles = column[records.HEIGHTS].astype(int)
    return Measured(
        (column[records.STATUS] == records.MEASURED) & (cycles <= u_dd.shape[1]),
        Totals(*column[records.X2 : records.U2 + 1]),
        State(column[records.X_BEGIN], column[records.V_BEGIN]),
        State(column[records.X_END], column[records.V_END]),
        column[records.PEAK],
        column[records.SUFFICES],
        column[records.UPCROSSINGS],
        column[records.ENTRIES],
        column[records.EVENTS],
        column[records.CLOSEST],
        tuple(row[:n] for row, n in zip(heights, cycles.tolist(), strict=True)),
    )


def rows(values: Floats) -> Floats:
    """Give rows of numbers as the kernel reads them."""
    return np.ascontiguousarray(values, dtype=float)


def forms_of(plant: Plant, dt: float) -> Forms:
    """Give the forms of whole steps, the terms that are not zero."""
    squares, way = step_forms(plant.b / plant.m, plant.k_x / plant.m, dt)
    x2, v2, x_dd2, power = squares

    def terms(square: Floats, used: list[int]) -> Floats:
        part = square[np.ix_(used, used)]
        both = part + np.triu(part.T, 1)
        found: Floats = both[np.triu_indices(len(used))]
        return found

    return Forms(
        terms(x2, [0, 1, 2, 3]), terms(v2, [1, 2, 3]), terms(x_dd2, [1, 3, 4, 5]),
        power[np.ix_([3, 4], [1, 2, 3])].ravel(), way[1:4].copy(),
    )  # fmt: skip


def empty_piece() -> Piece:
    """Give room for one piece of a march."""
    x_r, v_r = np.zeros((2, PIECE + 1))
    return Piece(
        x_r, v_r, np.zeros(PIECE + 1, dtype=np.int8), *np.zeros((4, PIECE)),
        *np.zeros((2, STRETCH)),
    )  # fmt: skip
