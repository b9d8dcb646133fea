"""Many records of one length under one scene: their integrals and turns, and nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.approach.events import Floats
from drysim.approach.room import empty_log
from drysim.approach.scene import LOG_LENGTH, waves_of
from drysim.core.forms import integrals, step_forms
from drysim.core.many import abreast, records
from drysim.core.many.lanes import FETCHED, LANES, SIZE
from drysim.core.many.lockstep import KEPT, Side
from drysim.core.many.products import STUCK, STUCK_U2, WAY
from drysim.core.motion import Samples, Sines, sample_squares
from drysim.core.plant import Law, Plant
from drysim.core.samples.steps import steps_of
from drysim.core.state import State, Totals


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
    """Tell whether many records of one scene can be marched in lockstep.

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
    turns: Floats = np.empty(u_dd.shape)
    records.measure_records(
        plant, law, steps_of(plant, law, dt), waves_of(Sines((), (), ())), u_dd, *window, start,
        empty_side(), turns, answers,
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
    squares = [sample_squares(motion, *(n * dt for n in window)) for motion in motions]
    u_dd2: Any = np.array([one for one, _ in squares])
    u2: Any = None if motions[0].u is None else np.array([other for _, other in squares])
    x2, v2, x_dd2, power, rub, stuck = integrated(plant, dt, column)
    ends_of = column[[records.X_BEGIN, records.X_END]].T
    paths = [
        np.concatenate((at[:1], row[b:e], at[1:]))
        for at, row, b, e in zip(ends_of, turns, begins, ends, strict=True)
    ]
    before = [np.abs(row[:b]).max(initial=0.0) for row, b in zip(turns, begins, strict=True)]
    within = [np.abs(path).max() for path in paths]
    return Measured(
        np.isfinite(last.x_r + last.v_r) & (ends <= turns.shape[1]),
        Totals(x2, v2, x_dd2, power, rub, stuck, u_dd2, u2),
        first,
        last,
        tuple(paths),
        np.maximum(np.maximum(before, within), abs(start.x_r)),
        column[records.COUNT],
        column[records.TIGHT],
    )


def integrated(plant: Plant, dt: float, column: Floats) -> Floats:
    """Give the integrals, those over whole steps from their products, as in `Totals`."""
    forms = step_forms(plant.b / plant.m, plant.k_x / plant.m, dt)
    sums: Floats = integrals(forms, column[:WAY], column[WAY : WAY + 3])
    sums[2] += dt / 3.0 * column[STUCK_U2]
    sums[5] = dt * column[STUCK]
    sums += column[records.X2 : records.STUCK_TIME + 1]
    return sums


def empty_side() -> Side:
    """Give the scratch of a march in lockstep."""
    return Side(
        np.zeros(SIZE), np.zeros((FETCHED + 1) * LANES), np.zeros(abreast.ROWS * LANES),
        np.zeros(LANES), np.zeros(LANES, dtype=np.int64), np.zeros((LANES, KEPT)),
        np.zeros(LANES, dtype=np.int64), empty_log(LOG_LENGTH), LOG_LENGTH,
    )  # fmt: skip
