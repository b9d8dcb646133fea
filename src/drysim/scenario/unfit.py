"""Approaches where they err: what a reader should know before one of them is trusted."""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from typing import TYPE_CHECKING

from drysim.core.motion import Samples, Sines
from drysim.core.signal import blocks
from drysim.errors import Caution
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.scenario.model import Scenario

STIFF = 2.5
"""F_fk c Δt/m [-] beyond which rk4 on a smooth sign comes close to instability, at 2.8."""

CHATTERING = 0.5
"""F_fk/(m a_u) [-] beyond which the bare sign gives an acceleration that is mostly chatter."""


def unfit(scenario: Scenario, motion: Sines | Samples) -> Iterator[Caution]:
    """Say when the approach of a scenario is known to err in its scene."""
    F_fk, m = scenario.law().F_fk, scenario.oscillator.mass
    member = scenario.solver.member()
    step = motion.dt if isinstance(motion, Samples) else scenario.solver.step
    if member.approach == "smooth" and member.method == "rk4" and step is not None:
        stiffness = F_fk * member.sharpness * step / m
        if stiffness > STIFF:
            enough = STIFF * m / (F_fk * step)
            yield Caution(
                "smooth-stiff",
                f"F_fk c Δt/m is {number(stiffness, digits=3)}, and smooth by rk4 is unstable "
                f"from about 2.8 up: take a sharpness of {number(enough, 's/m', 2)} or less, a "
                "smaller step, or another method",
                {"stiffness": stiffness},
            )
    if member.approach == "signum" and (a_u := _rms(motion)) > 0:
        share = F_fk / (m * a_u)
        if share > CHATTERING:
            yield Caution(
                "signum-chatters",
                f"F_fk/(m a_u) is {number(share, digits=3)}: where the mass should stick, "
                "signum gives it accelerations of about ±F_fk/m, however small the step, and "
                "where it should stick all the time T_a tends to this number; stick-slip has "
                "no such error",
                {"share": share},
            )


def _rms(motion: Sines | Samples) -> float:
    """Give the RMS of ü [m/s²], of sines without regard to their phases."""
    if isinstance(motion, Samples):
        return sqrt(sum(float(part @ part) for part in blocks(motion.u_dd)) / len(motion.u_dd))
    return sqrt(sum(A * A for A in motion.A) / 2)
