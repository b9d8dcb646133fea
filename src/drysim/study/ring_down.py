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

    The base is at rest at the end if its acceleration is small there, and either stays so for
    much longer than a random signal does around its zeros, or is small most of the time, or
    belongs to a single event: the record is shorter than a few natural periods, or nearly all
    of its energy is in the last few. Random records therefore end as they are. A single event
    that does not end at rest, and a window that ends before the ring-down, are reported
    (`cut_warnings`): what follows is not known, or not asked for.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, inf, pi, sqrt
from typing import NamedTuple

import numpy as np

from drysim.core.model import BLOCK_SIZE, AnyLaw, Plant, Samples, Sines, State, max_abs
from drysim.errors import WarningMessage
from drysim.excitation.harmonic import Rest, Shock
from drysim.excitation.recorded import Record
from drysim.scenario.model import Scenario
from drysim.wording import format_number

REST_SHARE = 0.05
"""Acceleration, relative to the peak of the base, up to which the base is at rest [-]."""

QUIET_CROSSINGS = 4.0
"""Mean times between zeros of ü for which a random signal never stays below `REST_SHARE`."""

QUIET_RECORD = 0.5
"""Share of samples below `REST_SHARE` from which a record is a train of events [-]: a third of
that in random signals."""

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
    """Time since the base last moved [s]; 0 if it moves at the end."""
    at_rest: bool
    is_event: bool
    """Whether the motion, or its end, is a single event."""


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
        if last < len(motion.u_dd) - 1 or not ending.at_rest:
            return 0
        quiet, speed = ending.quiet, abs(start.v_r) + base_speed(motion) * (plant.k_x == 0.0)
    left = free_period(plant, law, speed) - quiet
    return ceil(left / step) if 0.0 < left < inf else 0


def last_sample(motion: Samples, end: float) -> int:
    """Return the sample at the end of a window [s], or the next one."""
    return min(ceil(end / motion.dt * (1.0 - STEP_TOLERANCE)), len(motion.u_dd) - 1)


def base_speed(motion: Samples) -> float:
    """Return the largest change of the base velocity from the start [m/s]."""
    return float(np.abs(np.cumsum(motion.u_dd[:])).max()) * motion.dt


def ending_of(motion: Samples, last: int, plant: Plant) -> Ending:
    """Return how a base motion ends at its sample `last`."""
    u_dd, dt = motion.u_dd, motion.dt
    peak = max_abs(u_dd[: last + 1])
    if peak == 0.0:
        return Ending(last * dt, True, True)
    quiet = (last - last_above(motion, last, REST_SHARE * peak)) * dt
    is_event = ends_in_event(motion, last, plant)
    if quiet == 0.0 or is_event:
        return Ending(quiet, quiet > 0.0, is_event)
    whole = u_dd[: last + 1]
    crossings = int(np.count_nonzero(np.signbit(whole[1:]) != np.signbit(whole[:-1])))
    stays = quiet * (crossings + 1) >= QUIET_CROSSINGS * last * dt
    silence = float(np.mean(np.abs(whole) <= REST_SHARE * peak))
    return Ending(quiet, stays or silence > QUIET_RECORD, False)


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


def ends_in_event(motion: Samples, last: int, plant: Plant) -> bool:
    """Return whether a base motion, or its end, is a single event for this plant."""
    if plant.k_x == 0.0:
        return False
    event = EVENT_PERIODS * 2.0 * pi * sqrt(plant.m / plant.k_x)
    first = last - ceil(event / motion.dt)
    if first <= 0:
        return True
    before, at_end = (
        float(np.mean(np.square(part)))
        for part in (motion.u_dd[:first], motion.u_dd[first : last + 1])
    )
    return at_end > EVENT_RATIO * before


def cut_warnings(
    scenario: Scenario, plant: Plant, law: AnyLaw, motion: Sines | Samples, end: float
) -> Iterator[WarningMessage]:
    """Warn if the window of a record ends before the response to a single event.

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
    is_whole = last >= len(motion.u_dd) - 1
    if not ending.is_event or ending.quiet >= period or (is_whole and ending.at_rest):
        return
    ends = "record ends" if is_whole else "window ends"
    if ending.at_rest:
        when = f"{format_number(ending.quiet, 's')} after the base last moved"
        cure = "use a longer measure.duration"
    else:
        now, peak = (max_abs(motion.u_dd[first : last + 1]) for first in (last, 0))
        when = (
            f"while the base moves, at {format_number(100.0 * now / peak, '%', 2)} of its peak"
        )
        cure = "use a record that lasts until the base is at rest"
        if not is_whole:
            cure = "use a longer measure.duration"
    sentence = (
        f"{scenario.excitation.named}: the {ends} at {format_number(end, 's')}, {when}, and a "
        f"free vibration takes {format_number(period, 's')}: the largest response may come "
        f"later, so that peaks, stroke and their checks are too small; {cure}"
    )
    numbers = {"end": end, "quiet": ending.quiet, "period": period}
    yield WarningMessage("response-cut", sentence, numbers)
