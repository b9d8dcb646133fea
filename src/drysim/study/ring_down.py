"""Ring-down after the end of a base motion, and warnings for a motion that is cut.

Problem
    The largest response to a shock often comes after the shock. A record that ends with the
    shock, and a run that ends soon after it, hold only a part of the response: its peaks, the
    stroke and what is checked of them would be too small.

Method
    A base that is at rest at the end of its motion is taken to stay at rest, and the run goes
    on until a period has passed since the base last moved (`rest_steps`). Under a base at rest
    the energy only decreases, so that on either side the first turning point is the farthest,
    and one period of the free vibration passes both.

    The base is at rest at the end if its acceleration is small there for much longer than it is
    around the zeros of a vibration, or if the record ends with a pulse: few half cycles between
    rest and a last sample that is small. A vibration that is cut at a zero crossing is neither,
    and what a window leaves out of a longer record is not known to be at rest. Random records
    therefore end as they are. A single event (the record is shorter than a few natural periods,
    or nearly all of its energy is in the last few) that does not end at rest, and a window that
    ends before the ring-down, are reported (`cut_warnings`): what follows is not known, or not
    asked for.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, inf, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import BLOCK_SIZE, AnyLaw, Floats, Plant, Samples, Sines, State, max_abs
from drysim.errors import WarningMessage
from drysim.excitation.harmonic import Rest, Shock
from drysim.excitation.recorded import Record
from drysim.scenario.model import Scenario
from drysim.wording import format_number

REST_SHARE = 0.05
"""Acceleration, relative to the peak of the base, up to which the base is at rest [-]."""

BEGINS_SHARE = 0.2
"""Acceleration of the first sample, relative to the peak, from which an event is cut [-]."""

QUIET_HALF_CYCLES = 4.0
"""Mean half cycles of ü for which a vibration never stays below `REST_SHARE`."""

PULSE_HALF_CYCLES = 3
"""Half cycles up to which a motion from rest to a zero of ü is a pulse, not a vibration."""

EVENT_PERIODS = 3.0
"""Natural periods within which a base motion is a single event."""

EVENT_RATIO = 10.0
"""Ratio of the mean squares of ü in the last `EVENT_PERIODS` and before, from which the end is
an event of its own."""

STEP_TOLERANCE = 1e-9
"""Relative tolerance within which a time is a whole number of steps."""

MAX_DECAYS = 40.0
"""Decay times of a velocity after which nothing is left of it."""


class Ending(NamedTuple):
    """How a base motion ends."""

    quiet: float
    """Time since |ü| was last above `REST_SHARE` of its peak [s]."""
    at_rest: bool
    first: int | None
    """Sample from which the motion is a single event; None if it is none."""


def free_period(plant: Plant, law: AnyLaw, speed: float) -> float:
    """Return a time after which a free motion has passed its largest displacements [s].

    Parameters
    ----------
    plant : Plant
    law : AnyLaw
    speed : float
        Bound of the relative velocity [m/s], which matters without a spring only.

    Returns
    -------
    float
        The damped period, at most two natural periods; without a spring the time to a stop.
        Infinite if nothing stops the mass but the end stops.
    """
    m, k_x, b = plant
    b = max(b, *(law.damping or (b,)))
    if k_x == 0.0 and law.stops is not None:
        return inf
    if k_x == 0.0:
        sliding = m * speed / law.F_fk if law.F_fk else inf
        return min(sliding, MAX_DECAYS * m / b if b else inf)
    omega = sqrt(k_x / m)
    ratio = 0.5 * b / (m * omega)
    return 2.0 * pi / omega / max(sqrt(max(1.0 - ratio * ratio, 0.0)), 0.5)


def rest_steps(
    scenario: Scenario, scene: tuple[Plant, AnyLaw, Sines | Samples, State], step: float,
    end: float,
) -> int:  # fmt: skip
    """Return for how many steps a run goes on after its window, the base being at rest.

    Parameters
    ----------
    scenario : Scenario
    scene : tuple
        Plant, law, base motion and start.
    step : float
        Step of the grid [s].
    end : float
        End of the window [s].
    """
    plant, law, motion, start = scene
    if not isinstance(scenario.excitation, Record | Shock | Rest):
        return 0
    if isinstance(motion, Sines):
        # A mass that is released at rest is farthest at the start.
        quiet, speed = end if start.v_r else inf, abs(start.v_r)
    else:
        last = last_sample(motion, end)
        ending = ending_of(motion, last, plant)
        if not ends_record(motion, last) or not ending.at_rest:
            return 0
        quiet, speed = ending.quiet, abs(start.v_r) + base_speed(motion) * (plant.k_x == 0.0)
    left = free_period(plant, law, speed) - quiet
    return ceil(left / step) if 0.0 < left < inf else 0


def last_sample(motion: Samples, end: float) -> int:
    """Return the sample at the end of a window [s], or the next one."""
    return min(ceil(end / motion.dt * (1.0 - STEP_TOLERANCE)), len(motion.u_dd) - 1)


def ends_record(motion: Samples, last: int) -> bool:
    """Return whether nothing is known of the base after its sample `last`."""
    return last >= len(motion.u_dd) - 1 and not motion.goes_on


def base_speed(motion: Samples) -> float:
    """Return the largest change of the base velocity from the start [m/s]."""
    return float(np.abs(np.cumsum(motion.u_dd[:])).max()) * motion.dt


def ending_of(motion: Samples, last: int, plant: Plant) -> Ending:
    """Return how a base motion ends at its sample `last`."""
    u_dd, dt = motion.u_dd, motion.dt
    peak = max_abs(u_dd[: last + 1])
    if peak == 0.0:
        return Ending(last * dt, True, 0)
    quiet = (last - last_above(motion, last, REST_SHARE * peak)) * dt
    first = event_start(motion, last, plant)
    part = u_dd[first or 0 : last + 1]
    at_rest = quiet > 0.0 and ends_at_rest(part, REST_SHARE * peak)
    return Ending(quiet, at_rest, first)


def ends_at_rest(u_dd: Floats, level: float) -> bool:
    """Return whether a motion whose last sample is up to `level` [m/s²] is at rest there."""
    loud = np.flatnonzero(np.abs(u_dd) > level)
    if not len(loud):
        return True
    is_positive = u_dd[loud] > 0.0
    rest = QUIET_HALF_CYCLES * len(loud) / half_cycles(is_positive)
    if len(u_dd) - 1 - loud[-1] >= rest:
        return True
    pauses = np.flatnonzero(np.diff(loud) > rest)
    begin = int(pauses[-1]) + 1 if len(pauses) else 0
    starts_at_rest = loud[begin] > 0
    return half_cycles(is_positive[begin:]) <= (PULSE_HALF_CYCLES if starts_at_rest else 1)


def half_cycles(is_positive: NDArray[np.bool_]) -> int:
    """Return the number of half cycles of a motion by the sides of its samples."""
    return 1 + int(np.count_nonzero(is_positive[1:] != is_positive[:-1]))


def last_above(motion: Samples, last: int, level: float) -> int:
    """Return the last sample up to `last` with |ü| above a level that is reached [m/s²]."""
    end = last + 1
    while end > 0:
        begin = max(end - BLOCK_SIZE, 0)
        loud = np.flatnonzero(np.abs(motion.u_dd[begin:end]) > level)
        if len(loud):
            return begin + int(loud[-1])
        end = begin
    return 0


def event_start(motion: Samples, last: int, plant: Plant) -> int | None:
    """Return the sample from which a motion up to `last` is a single event for this plant.

    None if neither the motion nor its end is a single event.
    """
    if plant.k_x == 0.0:
        return None
    event = EVENT_PERIODS * 2.0 * pi * sqrt(plant.m / plant.k_x)
    first = last - ceil(event / motion.dt)
    if first <= 0:
        return 0
    before, at_end = (
        float(np.mean(np.square(part)))
        for part in (motion.u_dd[:first], motion.u_dd[first : last + 1])
    )
    return first if at_end > EVENT_RATIO * before else None


def cut_warnings(
    scenario: Scenario, plant: Plant, law: AnyLaw, motion: Sines | Samples, end: float
) -> Iterator[WarningMessage]:
    """Warn if the window of a record begins in a single event, or ends before its response.

    Parameters
    ----------
    scenario : Scenario
    plant, law, motion
        The scene.
    end : float
        End of the window [s].
    """
    if not isinstance(scenario.excitation, Record) or plant.k_x == 0.0:
        return
    assert isinstance(motion, Samples), "a record is sampled"
    last = last_sample(motion, end)
    ending, period = ending_of(motion, last, plant), free_period(plant, law, 0.0)
    is_whole = ends_record(motion, last)
    now, peak = (max_abs(motion.u_dd[first : last + 1]) for first in (last, 0))
    at_first = max_abs(motion.u_dd[:1])
    if ending.first == 0 and ending.at_rest and at_first > BEGINS_SHARE * peak:
        share = format_number(100.0 * at_first / peak, "%", 2)
        sentence = (
            f"{scenario.excitation.named}: the record begins at {share} of its peak, with the "
            "mass at rest: if the base moved before, peaks, stroke and their checks may be too "
            "small; use a record, or a window, that begins before the event"
        )
        yield WarningMessage("response-cut", sentence, {"period": period})
    if ending.first is None or ending.quiet >= period or (is_whole and ending.at_rest):
        return
    if ending.quiet:
        small = format_number(100.0 * REST_SHARE, "%")
        since = format_number(ending.quiet, "s")
        when = f"{since} after |ü| was last above {small} of its peak"
    else:
        when = (
            f"while the base moves, at {format_number(100.0 * now / peak, '%', 2)} of its peak"
        )
    ends, cure = "window ends", "use a longer measure.duration"
    if is_whole:
        ends, cure = "record ends", "use a record that lasts until the base is at rest"
    elif last == len(motion.u_dd) - 1:
        cure = "use a later excitation.window.to"
    sentence = (
        f"{scenario.excitation.named}: the {ends} at {format_number(end, 's')}, {when}, and a "
        f"free vibration takes {format_number(period, 's')}: the largest response may come "
        f"later, so that peaks, stroke and their checks may be too small; {cure}"
    )
    numbers = {"end": end, "quiet": ending.quiet, "period": period}
    yield WarningMessage("response-cut", sentence, numbers)
