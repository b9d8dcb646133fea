"""The kernels that follow a law beyond Coulomb's, and what they want to begin with."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from drysim.core.compiled import held
from drysim.core.contact import first_contact, touch
from drysim.core.contact_replay import integrate_contact, read_contact
from drysim.core.jet import ORDER, Jet
from drysim.core.plant import AnyState, Dynamic, Law, Plant, Slider
from drysim.core.replay import integrate_series
from drysim.core.replay import read as read_series
from drysim.core.trace import first_heading, trace
from drysim.core.waves import Waves

Kernel = Callable[..., Any]
AnyOther = Dynamic | Slider


def walk(law: AnyOther) -> Kernel:
    """Give the kernel that follows the motion."""
    return trace if isinstance(law, Dynamic) else touch


def read(law: AnyOther) -> Kernel:
    """Give the kernel that reads it between its steps."""
    return read_series if isinstance(law, Dynamic) else read_contact


def integrate(law: AnyOther) -> Kernel:
    """Give the kernel that integrates it."""
    return integrate_series if isinstance(law, Dynamic) else integrate_contact


def work(law: AnyOther, speed: float) -> tuple[Any, ...]:
    """Give what the kernels of a law work in; a speed [m/s] to measure the motion by."""
    if isinstance(law, Slider):
        return ()
    jet = Jet(*(held(np.zeros(ORDER + 2)) for _ in Jet._fields))
    jet.scale[0] = speed
    return (jet,)


def waving(law: AnyOther) -> Law:
    """Give a law whose normal force varies as this one's."""
    if isinstance(law, Dynamic):
        return Law(0.0, 0.0)
    return Law(law.F_fk, law.F_fk, law.variation, law.omega, law.phase)


def first(
    plant: Plant,
    law: AnyOther,
    waves: Waves,
    work: tuple[Any, ...],
    u_0: float,
    slope: float,
    start: AnyState,
) -> tuple[Any, ...]:
    """Give x_r, v_r, the state of the contact and its mode at t = 0."""
    x_r, v_r = start[:2]
    if isinstance(law, Slider):
        mode, x_0 = first_contact(law, x_r)
        return x_r, v_r, start[2] if len(start) > 2 and mode == 0 else x_0, mode
    z = start[2] if len(start) > 2 else 0.0
    scene: tuple[Any, ...] = (plant, law, waves, *work, u_0, slope, 0.0, x_r, v_r, z)
    return x_r, v_r, z, first_heading(*scene)
