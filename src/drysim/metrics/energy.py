"""Energy that a state stores: in spring and mass, in bumpers, and in the friction contact.

What a contact stores it gives back; only the rest of the work done on it is dissipated
(`core.dynamic_friction.dissipated_power`, `core.trajectory.integrate_panel`). The two add up to
the work for any split. The one taken is that of the model behind each law:

- an elastic contact stores F²/(2 k_t) in its spring;
- bristles (Dahl, LuGre) store σ_0 z²/2;
- Leuven's hysteresis is stated by Masing's rule for the force alone, from which no energy
  follows. Iwan's model obeys the same rule: springs in series with sliders, side by side. It
  stores what these springs store, and its sliders never return anything.

Reference: W. D. Iwan, J. Appl. Mech. 33 (1966) 893.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

from drysim.core.model import (
    LEUVEN,
    STRIBECK,
    TWELVE_NODES,
    TWELVE_WEIGHTS,
    AnyLaw,
    AnyState,
    ContactState,
    DynamicLaw,
    Plant,
)


def mechanical_energy(plant: Plant, state: AnyState) -> Any:
    """Return the elastic and kinetic energy of a relative motion [J]."""
    v_r, x_r = state.v_r, state.x_r
    return 0.5 * (plant.m * (v_r * v_r) + plant.k_x * (x_r * x_r))


def bumper_energy(law: AnyLaw, state: AnyState) -> float:
    """Return the elastic energy of the bumper in a state [J]; 0 without contact."""
    if law.stops is None:
        return 0.0
    force, energy = law.stops.elastic_force_and_energy(state.x_r)
    outward = state.v_r * math.copysign(1.0, state.x_r)
    return energy if force + law.stops.b_s * outward > 0.0 else 0.0


def contact_energy(law: AnyLaw, state: AnyState) -> float:
    """Return the energy that springs or bristles of the friction contact store [J]."""
    if not isinstance(state, ContactState):
        return 0.0
    if not isinstance(law, DynamicLaw):
        k_t = law.as_piecewise().k_t
        return 0.5 * k_t * (state.x_r - state.z) ** 2
    if law.kind == STRIBECK:
        return 0.0
    if law.kind == LEUVEN:
        return hysteresis_energy(law, state.z, state.reversals)
    return 0.5 * law.sigma_0 * state.z**2


def hysteresis_energy(law: DynamicLaw, z: float, reversals: tuple[float, ...]) -> float:
    """Return the energy of Iwan's model of a hysteresis at deflection z [J].

    Notes
    -----
    Lengths are relative to F_h/σ_0. The sliders that yield at a deflection y of their springs
    have the stiffness exp(-y) dy. The branch from one reversal to the next, over a distance 2 y
    of travel, moves those below y to their limit and all others by 2 y. So the springs of the
    sliders between two successive y are deflected by ±y plus the travel since.
    """
    length = law.F_h / law.sigma_0
    turns = (0.0, *reversals, z)
    # How far each branch reaches, and its travel; the virgin curve goes half as far for it.
    branches = []
    for i, (begin, end) in enumerate(pairwise(turns)):
        ways = 2.0 if i else 1.0
        if abs(end - begin) >= ways * length:  # never reached, except by a wrong motion
            return math.inf
        reach = -math.log1p(-abs(end - begin) / (ways * length))
        branches.append((reach, math.copysign(1.0, end - begin), ways))
    energy, low, travel = 0.0, 0.0, 0.0
    for reach, side, ways in reversed(branches):
        for node, weight in zip(TWELVE_NODES, TWELVE_WEIGHTS, strict=True):
            y = low + (reach - low) * node
            stretch = side * y + travel
            energy += (reach - low) * weight * math.exp(-y) * stretch * stretch
        low, travel = reach, travel + side * ways * reach
    energy += math.exp(-low) * travel * travel
    return 0.5 * law.sigma_0 * length * length * energy
