"""Metrics of many sample series under one scene, such as its seeds, vectorised over the series.

`can_batch` checks a scene; `measure_batch` takes a `RecordBatch` and keeps integrals and peaks
only, not the motions.
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
"""Steps per row of the buffer of stops, and further rows; a series with more stops is solved by
itself."""


class BatchResult(NamedTuple):
    """Results of many series: columns of shape (records,).

    Attributes
    ----------
    found : ndarray of bool
        Whether the series was solved. Where not, the solution fails or has too many stops for
        the buffer; solved by itself, the series shows which. Its other values are undefined.
    totals : Totals
        Integrals over the window; `u2` is None where the base displacement is unknown.
    first, last : State
        State at both ends of the window.
    paths : tuple of ndarray
        For every series: x_r at both ends of the window and at every stop in it, in order [m].
    suffices : ndarray
        Largest |x_r| from the start to the end of the window [m].
    events : ndarray
        Number of events from the start to the end of the window.
    closest_decision : ndarray
        Smallest relative margin of a decision between stick and slip [-]; infinite for none.
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
    """Many sample series of one length and step.

    Attributes
    ----------
    u_dd : ndarray, shape (records, samples)
        Base acceleration [m/s²].
    dt : float
        Step of the samples [s].
    window : tuple of int
        Samples at which the window of the metrics begins and ends.
    u2 : ndarray, shape (records,), or None
        Integrals of the squared base displacement over the window [m² s], where it is known.
    """

    u_dd: Floats
    dt: float
    window: tuple[int, int]
    u2: Floats | None

    def motion(self, i: int) -> Samples:
        """Return the base acceleration of one series."""
        return Samples(self.u_dd[i], self.dt)


def make_batch(motions: Iterable[Samples], count: int, window: tuple[int, int]) -> RecordBatch:
    """Collect `count` sample series of one length and step in a batch.

    Each series is released before the next one is requested, so that its memory is reused.
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
    """Whether many series under a scene can be marched together.

    This requires Coulomb friction with constant limits, and a step short enough for the
    trapezoidal rule.
    """
    return type(law) is CoulombLaw and law.variation == 0.0 and lanes.is_accurate(plant, dt)


def measure_batch(
    plant: Plant, law: CoulombLaw, batch: RecordBatch, start: State
) -> BatchResult:
    """March many series and return their integrals and peaks.

    Parameters
    ----------
    plant : Plant
    law : CoulombLaw
        Plant, law and step must satisfy `can_batch`.
    batch : RecordBatch
    start : State
        Start of every series, at its first sample.

    Returns
    -------
    BatchResult

    Notes
    -----
    A call runs in one thread and releases the GIL, so batches may run in parallel. The result
    of a series does not depend on the others.
    """
    u_dd, dt, window, _ = batch
    answers = np.empty((len(u_dd), lanes.ANSWER_COLUMNS))
    stops: Floats = np.empty((len(u_dd), u_dd.shape[1] // STEPS_PER_STOP + EXTRA_STOPS))
    steps = slip_steps(plant, law, dt)
    rule = lanes.make_end_forms(plant.b / plant.m, plant.k_x / plant.m, dt)
    work_space = lanes.LaneBuffers(
        np.zeros(lanes.LANES_SIZE),
        np.zeros(lanes.READ_BUFFER_SIZE * lanes.LANES // lanes.WIDTH),
        np.zeros(lanes.QUEUE_SIZE), np.zeros(lanes.LANES, dtype=np.int64),
        np.zeros((lanes.LANES, lanes.RESULT_COUNT)), np.zeros(lanes.LANES, dtype=np.int64),
        empty_log(LOG_LENGTH),
    )  # fmt: skip
    lanes.measure_records(
        plant, law, steps, rule, u_dd, *window, start, work_space, stops, answers
    )
    with np.errstate(over="ignore", invalid="ignore"):  # such records are not `found`
        return unpack_answers(batch, start, stops, answers)


def unpack_answers(
    batch: RecordBatch, start: State, stops: Floats, answers: Floats
) -> BatchResult:
    """Return the columns of the kernel's answers by name."""
    column, u2 = answers.T, cast(Any, batch.u2)
    first = State(column[lanes.X_BEGIN], column[lanes.V_BEGIN])
    last = State(column[lanes.X_END], column[lanes.V_END])
    begins, ends = column[[lanes.BEGIN, lanes.STOP_COUNT]].astype(int)
    x2, v2, x_dd2, power, sliding_distance, stuck, u_dd2 = column[: lanes.INTEGRALS]
    ends_of = column[[lanes.X_BEGIN, lanes.X_END]].T
    paths = [
        np.concatenate((at[:1], row[b:e], at[1:]))
        for at, row, b, e in zip(ends_of, stops, begins, ends, strict=True)
    ]
    farthest = np.abs(column[[lanes.FARTHEST, lanes.X_BEGIN, lanes.X_END]]).max(axis=0)
    return BatchResult(
        np.isfinite(last.x_r + last.v_r) & (ends <= stops.shape[1]),
        Totals(x2, v2, x_dd2, power, sliding_distance, stuck, u_dd2, u2),
        first,
        last,
        tuple(paths),
        np.maximum(farthest, abs(start.x_r)),
        column[lanes.EVENTS],
        column[lanes.CLOSEST],
    )
