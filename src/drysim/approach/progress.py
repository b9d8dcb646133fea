"""Checks of a march: it advances, stays finite, and its events fit in memory."""

from __future__ import annotations

import math
from typing import Any

from drysim.core.events import MAX_EVENTS_PER_STEP
from drysim.core.model import CoulombLaw, PiecewiseLaw, Plant, Samples, Sines
from drysim.core.status import Status

MAX_EVENTS, MAX_EVENTS_PER_INTERVAL = 1_000_000, 10
"""Events allowed in one solution, plus those allowed per sample, or per period under sines.
More would fill the memory."""


def check_progress(count: int, t: float, state: Any, step: float = math.inf) -> None:
    """Raise SolverError for a `Status` in place of a count of events, or a state not finite.

    `step` is that of the samples [s].
    """
    if count >= 0 and not (math.isfinite(state[0]) and math.isfinite(state[1])):
        count = Status.OVERFLOW
    if count < 0:
        raise Status(count).error(t=t, step=step, count=MAX_EVENTS_PER_STEP)


def count_intervals(
    plant: Plant, law: CoulombLaw | PiecewiseLaw, motion: Sines | Samples, duration: float
) -> float:
    """Return the number of samples, or of periods of base, normal force and oscillator."""
    if isinstance(motion, Samples):
        return duration / motion.dt
    natural = math.sqrt(plant.k_x / plant.m) / math.tau
    return duration * (max(motion.f, default=0.0) + law.omega / math.tau + natural)


def check_event_count(count: int, intervals: float, t: float) -> None:
    """Raise SolverError where events are too many for the memory."""
    if count > MAX_EVENTS + MAX_EVENTS_PER_INTERVAL * intervals:
        raise Status.MANY_EVENTS.error(t=t, count=count)
