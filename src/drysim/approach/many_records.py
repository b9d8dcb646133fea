"""Many records of base motion under one scene, as those of its seeds: measured side by side.

`can_batch` tells whether `measure_batch` serves a scene; it takes what `make_batch` lays out, and
keeps nothing of the motions but what they come to.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from drysim.approach.scene import LOG_LENGTH, empty_log
from drysim.approach.solution import Floats
from drysim.core import lanes
from drysim.core.model import CoulombLaw, Plant, Samples, State, Totals, integrate_base_squares
from drysim.core.oscillator import slip_steps

STEPS_PER_STOP, EXTRA_STOPS = 8, 1024
"""There is room for a stop in so many steps, and for some more; a record with even more of
them is measured by itself."""


class BatchResult(NamedTuple):
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
    closest_decision: Floats


class RecordBatch(NamedTuple):
    """Many records of one length, as the kernel takes them.

    Attributes
    ----------
    u_dd : ndarray, shape (records, samples)
        Base acceleration [m/s²].
    dt : float
        Distance of the samples [s].
    window : tuple of int
        Samples at which the window of what is measured begins and ends.
    u2 : ndarray, shape (records,), or None
        Integrals over it of the squared base displacement [m² s], where that is known.
    """

    u_dd: Floats
    dt: float
    window: tuple[int, int]
    u2: Floats | None

    def motion(self, i: int) -> Samples:
        """Give the base acceleration of one record."""
        return Samples(self.u_dd[i], self.dt)


def make_batch(motions: Iterable[Samples], count: int, window: tuple[int, int]) -> RecordBatch:
    """Give so many motions of one length and one distance side by side.

    Each is let go before the next is asked for. One that is drawn then is worked on while it
    is near the processor, and the next takes its memory.
    """
    begin, end = window
    rows, squares, dt = np.empty((count, 0)), np.empty(count), 0.0
    for i, motion in enumerate(motions):
        if not i:
            rows, dt = np.empty((count, len(motion.u_dd))), motion.dt
        rows[i] = motion.u_dd[:]
        u2 = None
        if motion.u is not None:
            u2 = integrate_base_squares(motion, begin * dt, end * dt)[1]
        squares[i] = math.nan if u2 is None else u2
    return RecordBatch(rows, dt, window, None if np.isnan(squares).any() else squares)


def can_batch(plant: Plant, law: object, dt: float) -> bool:
    """Tell whether many records of one scene can be marched side by side.

    They can where friction is Coulomb's with limits that do not vary, and a step so short that
    the rule of trapezia serves it.
    """
    return type(law) is CoulombLaw and law.variation == 0.0 and lanes.served(plant, dt)


def measure_batch(
    plant: Plant, law: CoulombLaw, batch: RecordBatch, start: State
) -> BatchResult:
    """March many records and measure them, keeping nothing of the motion.

    Parameters
    ----------
    plant : Plant
    law : Law
        With `plant` and the distance of the samples as `can_batch` wants them.
    given : Abreast
    start : State
        Of every record, at its first sample.

    Returns
    -------
    Measured

    Notes
    -----
    One call runs in one thread and lets others run: batches may be given to several. What a
    record comes to does not depend on the others.
    """
    u_dd, dt, window, _ = batch
    answers = np.empty((len(u_dd), lanes.FOUND))
    turns: Floats = np.empty((len(u_dd), u_dd.shape[1] // STEPS_PER_STOP + EXTRA_STOPS))
    steps = slip_steps(plant, law, dt)
    rule = lanes.trapezia(plant.b / plant.m, plant.k_x / plant.m, dt)
    scratch = lanes.Side(
        np.zeros(lanes.SIZE), np.zeros(lanes.PLACES * lanes.LANES // lanes.WIDTH),
        np.zeros(lanes.QUEUE_SIZE), np.zeros(lanes.LANES, dtype=np.int64),
        np.zeros((lanes.LANES, lanes.KEPT)), np.zeros(lanes.LANES, dtype=np.int64),
        empty_log(LOG_LENGTH),
    )  # fmt: skip
    lanes.measure_records(
        plant, law, steps, rule, u_dd, *window, start, scratch, turns, answers
    )
    with np.errstate(over="ignore", invalid="ignore"):  # such records are not `found`
        return unpack_answers(batch, start, turns, answers)


def unpack_answers(
    batch: RecordBatch, start: State, turns: Floats, answers: Floats
) -> BatchResult:
    """Give what the kernel has answered by name."""
    column, u2 = answers.T, cast(Any, batch.u2)
    first = State(column[lanes.X_BEGIN], column[lanes.V_BEGIN])
    last = State(column[lanes.X_END], column[lanes.V_END])
    begins, ends = column[[lanes.BEGIN, lanes.TURNS]].astype(int)
    x2, v2, x_dd2, power, sliding_distance, stuck, u_dd2 = column[: lanes.INTEGRALS]
    ends_of = column[[lanes.X_BEGIN, lanes.X_END]].T
    paths = [
        np.concatenate((at[:1], row[b:e], at[1:]))
        for at, row, b, e in zip(ends_of, turns, begins, ends, strict=True)
    ]
    farthest = np.abs(column[[lanes.FAR, lanes.X_BEGIN, lanes.X_END]]).max(axis=0)
    return BatchResult(
        np.isfinite(last.x_r + last.v_r) & (ends <= turns.shape[1]),
        Totals(x2, v2, x_dd2, power, sliding_distance, stuck, u_dd2, u2),
        first,
        last,
        tuple(paths),
        np.maximum(farthest, abs(start.x_r)),
        column[lanes.EVENTS],
        column[lanes.TIGHT],
    )
