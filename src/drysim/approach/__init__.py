"""Shelf 3: how the motion is computed. An approach is one file and one name here.

Those that follow a motion exactly hand it to `exact`, which knows the module for its law and
its base: `under_sines` and `over_samples` for Coulomb's friction, `over_joints` and `touched`
for spring contacts, `by_series` for laws with a rate or a state, `traced` for normal forces
that may vanish, `bounded` for end stops. Each gives a Track, known at any instant, and with a
grid a Response. All others march by fixed steps and share `stepped`.
"""

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
