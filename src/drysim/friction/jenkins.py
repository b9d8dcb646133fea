"""Jenkins: a spring in series with a slider."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from drysim.core.plant import Slider
from drysim.friction.rubbing import Rubbing
from drysim.quantity import Quantity


class Jenkins(Rubbing):
    """A contact that is a linear spring until it yields, as joints and bushings are.

    Not to be confused with `dahl`, whose spring softens all the way.

    Notes
    -----
    While it holds f = f_0 + k_t (x_r - x_0), it yields at |f| = F_fk, and holds again as v_r
    turns; piecewise linear, so solved in closed form. Known as Jenkins' element and as the
    elastic slider. Jenkins, Brit. J. Appl. Phys. 13 (1962) 30.
    """

    law: Literal["jenkins"]
    """Dry friction behind a spring."""
    tangential_stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Stiffness k_t [N/m], above 0, of the contact while it holds."""

    symbols: ClassVar[dict[str, str]] = {"tangential_stiffness": "k_t"}

    def limits(self, m: float) -> Slider:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        return Slider(self.kinetic_force(m), self.tangential_stiffness)
