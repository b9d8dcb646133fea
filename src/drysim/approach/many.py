"""Many records of one length under one scene: their integrals and turns, and nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.approach.events import Floats
from drysim.approach.room import empty_log
from drysim.approach.scene import LOG_LENGTH, waves_of
from drysim.core.many import queue, records
from drysim.core.many.lanes import LANES, PLACES, SIZE, WIDTH
from drysim.core.many.settle import KEPT, Side
from drysim.core.many.trapezia import INTEGRALS, trapezia
from drysim.core.motion import Samples, Sines, sample_squares
from drysim.core.plant import Law, Plant
from drysim.core.samples.steps import steps_of
from drysim.core.state import State, Totals

STEPS_A_STOP, FEW_STOPS = 8, 1024
"""There is room for a stop in so many steps, and for some more; a record with even more of
them is measured by itself."""


class Measured(NamedTuple):
    """What many records come to: columns, shape (records,).

    Attributes
    ----------
    found : ndarray of bool
        Whether the record was measured. Where not, the numerics fail or stops are too many
        for a batch: solved by itself, the record says which. The rest holds nothing then.
    totals : Totals
        Integrals over the window; `u2` is None where the base displacement is not known.
    first, last : State
        At both ends of the window.
    paths : tuple of ndarray
        Of every record: x_r at both ends of the window and at every stop in it, in order [m].
    suffices : ndarray
        Greatest |x_r| from the start to the end of the window [m].
    events : ndarray
        Events from the start to the end of the window.
    closest : ndarray
        Tightest stop decision [-]; infinite for none.
    """

    found: NDArray[np.bool_]
    totals: Totals
    first: State
    last: State
    paths: tuple[Floats, ...]
    suffices: Floats
    events: Floats
    closest: Floats


def measurable(plant: Plant, law: object, dt: float) -> bool:
    """Tell whether many records of one scene can be marched side by side.

    They can where friction is Coulomb's with limits that do not vary, and a step so short that
    it holds one extremum of v_r at most.
    """
    return type(law) is Law and law.variation == 0.0 and bool(steps_of(plant, law, dt).fine)


def measure_many(
    plant: Plant,
    law: Law,
    motions: Sequence[Samples],
    start: State,
    window: tuple[int, int],
) -> Measured:
    """March many records and measure them, keeping nothing of the motion.

    Parameters
    ----------
    plant : Plant
    law : Law
        With `plant` and the distance of the samples as `measurable` wants them.
    motions : sequence of Samples
        Of one length and one distance.
    start : State
        Of every record, at its first sample.
    window : tuple of int
        Samples at which the window begins and ends.

    Returns
    -------
    Measured

    Notes
    -----
    One call runs in one thread and lets others run: batches may be given to several. What a
    record comes to does not depend on the others.
    """
    u_dd, dt = np.array([motion.u_dd[:] for motion in motions]), motions[0].dt
    answers = np.empty((len(u_dd), records.FOUND))
    turns: Floats = np.empty((len(u_dd), u_dd.shape[1] // STEPS_A_STOP + FEW_STOPS))
    rule = trapezia(plant.b / plant.m, plant.k_x / plant.m, dt)
    records.measure_records(
        plant, law, steps_of(plant, law, dt), rule, waves_of(Sines((), (), ())), u_dd, *window,
        start, empty_side(), turns, answers,
    )  # fmt: skip
    with np.errstate(over="ignore", invalid="ignore"):  # such records are not `found`
        return answered(plant, motions, start, window, turns, answers)


def answered(
    plant: Plant,
    motions: Sequence[Samples],
    start: State,
    window: tuple[int, int],
    turns: Floats,
    answers: Floats,
) -> Measured:
    """Give what the kernel has answered by name."""
    column, dt = answers.T, motions[0].dt
    first = State(column[records.X_BEGIN], column[records.V_BEGIN])
    last = State(column[records.X_END], column[records.V_END])
    begins, ends = column[[records.BEGIN, records.TURNS]].astype(int)
    u2: Any = None
    if motions[0].u is not None:
        u2 = np.array([sample_squares(each, *(n * dt for n in window))[1] for each in motions])
    x2, v2, x_dd2, power, rub, stuck, u_dd2 = column[:INTEGRALS]
    ends_of = column[[records.X_BEGIN, records.X_END]].T
    paths = [
        np.concatenate((at[:1], row[b:e], at[1:]))
        for at, row, b, e in zip(ends_of, turns, begins, ends, strict=True)
    ]
    farthest = np.abs(column[[records.FAR, records.X_BEGIN, records.X_END]]).max(axis=0)
    return Measured(
        np.isfinite(last.x_r + last.v_r) & (ends <= turns.shape[1]),
        Totals(x2, v2, x_dd2, power, rub, stuck, u_dd2, u2),
        first,
        last,
        tuple(paths),
        np.maximum(farthest, abs(start.x_r)),
        column[records.COUNT],
        column[records.TIGHT],
    )


def empty_side() -> Side:
    """Give the scratch of a march side by side."""
    return Side(
        np.zeros(SIZE), np.zeros(PLACES * LANES // WIDTH), np.zeros(queue.SIZE),
        np.zeros(LANES, dtype=np.int64), np.zeros((LANES, KEPT)),
        np.zeros(LANES, dtype=np.int64), empty_log(LOG_LENGTH),
    )  # fmt: skip
