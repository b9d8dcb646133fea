"""The step of the output grid: its default, whether a file must state it, and a proposal.

Base motion that is sampled on the grid, and approaches that march by fixed steps, need a step
from the user, because the motion depends on it. Under sines and at rest an exact approach only
writes its output on the grid, which then has a default.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import ceil

from drysim.approach import APPROACHES_BY_NAME
from drysim.approach.stick_slip import ExactApproach
from drysim.block import InvalidValue
from drysim.excitation import Excitation
from drysim.excitation.base import ExcitationBase, GeneratedMotion
from drysim.excitation.harmonic import Shock
from drysim.scenario.window import common_period
from drysim.wording import format_number

STEPS_PER_PERIOD = 100
"""Steps of the default grid in the shortest period, and of a proposal for fixed steps."""

STEPS_AT_REST = 1000
"""Steps of the default grid where nothing oscillates."""

MAX_FREQUENCY_RATIO = 10.0
"""Natural frequency over the highest one of the base motion beyond which the grid does not
become finer."""

WEIGHTED_STEP = 2.5e-3
"""Longest default step with a frequency weighting [s]: five steps in a period of 80 Hz, the
highest third octave of ISO 2631-1."""

ROUNDING = 1e-9
"""Tolerance of a number of steps."""

SAMPLED_STEPS, PULSE_STEPS = 20, 100
"""Steps of a proposal in the shortest period of a sampled base motion, and in a pulse."""

LEADING_DIGITS = (5.0, 2.0, 1.0)
"""A proposal is such a number times a power of ten."""

DECADES = 3
"""Powers of ten that are tried for a proposal that divides all times into whole steps."""


def default_step(
    frequencies: tuple[float, ...], f_0: float, duration: float | None, is_weighted: bool
) -> float:
    """Return the default step for motion in closed form [s].

    Parameters
    ----------
    frequencies : tuple of float
        Frequencies of base motion and normal force [Hz]; empty at rest.
    f_0 : float
        Natural frequency [Hz].
    duration : float, optional
        Length of the window [s], given unless the motion is periodic.
    is_weighted : bool
        Whether accelerations are frequency-weighted.

    Returns
    -------
    float
        A whole part of the common period, if there is one.
    """
    highest = max(frequencies, default=0.0)
    fastest = max(highest, min(f_0, MAX_FREQUENCY_RATIO * highest) if highest else f_0)
    if fastest == 0.0:
        return (duration or 1.0) / STEPS_AT_REST
    longest = 1.0 / (STEPS_PER_PERIOD * fastest)
    if is_weighted:
        longest = min(longest, WEIGHTED_STEP)
    period = common_period(frequencies) or 1.0 / fastest
    return period / ceil(period / longest - ROUNDING)


def needs_step(excitation: type[ExcitationBase], approaches: Iterable[str]) -> bool:
    """Return whether the step must be stated, as the motion depends on it."""
    if excitation.has_own_step:
        return False
    members = (APPROACHES_BY_NAME.get(name, ExactApproach) for name in approaches)
    exact = all(issubclass(member, ExactApproach) for member in members)
    return issubclass(excitation, GeneratedMotion) or not exact


def proposed_step(
    excitation: Excitation, frequencies: tuple[float, ...], f_0: float
) -> float | None:
    """Return a step that suits base motion and oscillator [s]; None if there is none."""
    fastest = max(f_0, *frequencies, getattr(excitation, "highest_frequency", 0.0))
    steps = SAMPLED_STEPS if isinstance(excitation, GeneratedMotion) else STEPS_PER_PERIOD
    bounds = [1.0 / (steps * fastest)] if fastest else []
    if isinstance(excitation, Shock):
        bounds.append(excitation.duration / PULSE_STEPS)
    if not bounds:
        return None
    power = len(f"{1.0 / min(bounds):.0f}") - 1
    for exponent in range(power, power + DECADES):
        for digit in LEADING_DIGITS:
            step = float(f"{digit:g}e-{exponent + 1}")
            if step <= min(bounds) and suits(excitation, step):
                return step
    return None


def suits(excitation: Excitation, step: float) -> bool:
    """Return whether base motion can be sampled with a step."""
    if isinstance(excitation, GeneratedMotion):
        try:
            excitation.check_step(step)
        except InvalidValue:
            return False
    return True


def step_required(proposal: float | None, approach: str = "") -> str:
    """Return the message where a step must be stated."""
    sentence = f"solver.step is required{approach}: time step of base motion and output [s]"
    if proposal is None:
        return sentence
    return f"{sentence}, such as {format_number(proposal, 's')}"
