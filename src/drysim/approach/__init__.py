"""Shelf 3: how the motion is computed. An approach is one file and one name here."""

from drysim.approach.moreau import Moreau
from drysim.approach.signum import Signum
from drysim.approach.smooth import Smooth
from drysim.approach.stick_slip import StickSlip
from drysim.approach.switch import Switch
from drysim.approach.viscous import Viscous

APPROACHES = (StickSlip, Switch, Moreau, Signum, Smooth, Viscous)

Approach = StickSlip | Switch | Moreau | Signum | Smooth | Viscous

SHELF: dict[str, type[Approach]] = {
    member.model_fields["approach"].default: member for member in APPROACHES
}
"""The approaches by name."""

EXACT = StickSlip.model_fields["approach"].default
"""The name of the one that solves every law as well as it can be solved."""
