"""How a motion is computed, exactly or by fixed steps. An approach is a class with a name."""

from __future__ import annotations

from drysim.approach.fixed_step import Moreau, Signum, Smooth, Switch
from drysim.approach.stick_slip import StickSlip, Viscous

APPROACHES = (StickSlip, Switch, Moreau, Signum, Smooth, Viscous)

Approach = StickSlip | Switch | Moreau | Signum | Smooth | Viscous

APPROACHES_BY_NAME: dict[str, type[Approach]] = {
    member.model_fields["approach"].default: member for member in APPROACHES
}
"""The approaches by name."""

EXACT = StickSlip.model_fields["approach"].default
"""The name of the one that solves every law as well as it can be solved."""
