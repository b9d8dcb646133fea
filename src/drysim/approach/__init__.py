"""Approaches: exact and fixed-step methods that compute the motion."""

from __future__ import annotations

from drysim.approach.fixed_step import Moreau, Signum, Smooth, Switch
from drysim.approach.stick_slip import StickSlip, Viscous

APPROACHES = (StickSlip, Switch, Moreau, Signum, Smooth, Viscous)

Approach = StickSlip | Switch | Moreau | Signum | Smooth | Viscous

APPROACHES_BY_NAME: dict[str, type[Approach]] = {
    member.model_fields["approach"].default: member for member in APPROACHES
}
"""Approaches by name."""

EXACT = StickSlip.model_fields["approach"].default
"""Name of the exact approach, which solves every friction law."""
