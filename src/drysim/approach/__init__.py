"""Shelf 3: how the motion is computed. An approach is one file and one name here."""

from drysim.approach.stick_slip import StickSlip
from drysim.approach.viscous import Viscous

APPROACHES = (StickSlip, Viscous)

Approach = StickSlip | Viscous
