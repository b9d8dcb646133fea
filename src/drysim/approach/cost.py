"""Cost of a step under each approach, law and base motion, by which an engine is chosen."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from drysim.approach.stick_slip import ExactApproach
from drysim.core.model import AnyLaw, CoulombLaw, DynamicLaw, PiecewiseLaw, Samples, Sines

if TYPE_CHECKING:
    from drysim.approach import Approach


class StepCost(NamedTuple):
    """Cost of a step without events, and the kernels that it needs."""

    steps: int
    """In steps of sampled motion under Coulomb friction (2 µs)."""
    kernels: str
    """Kernels compiled only for this law, as `compile.choose_engine` takes them."""


FIXED_STEP_COST = StepCost(
    1, "fixed_step.march_fixed_step fixed_step.march_switch fixed_step.march_moreau"
)
STEP_COSTS = {
    (CoulombLaw, Samples): StepCost(1, "sampled.march"),
    (CoulombLaw, Sines): StepCost(1, "march.march_sines_from_start"),
    (DynamicLaw, Samples): StepCost(100, "taylor.march_taylor"),
    (DynamicLaw, Sines): StepCost(30, "taylor.march_taylor"),
    (PiecewiseLaw, Samples): StepCost(30, "march.march_modes"),
    (PiecewiseLaw, Sines): StepCost(6, "march.march_modes"),
}
"""By law and base motion. Measured: 120 to 240 µs for laws solved by series, 80 µs for a
varying normal force, 40 µs between end stops."""


def step_cost(approach: Approach, law: AnyLaw, motion: Sines | Samples) -> StepCost:
    """Return the cost of a step; fixed steps cost the same under every law."""
    is_exact = isinstance(approach, ExactApproach)
    return STEP_COSTS[type(law), type(motion)] if is_exact else FIXED_STEP_COST
