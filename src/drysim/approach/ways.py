"""The kernels that follow contacts and end stops, and what they want to begin with."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from drysim.core.bounded import bound, first_bounds
from drysim.core.bounded_replay import integrate_bounded, read_bounded
from drysim.core.bumper import way_of
from drysim.core.contact import first_contact, touch
from drysim.core.contact_replay import integrate_contact, read_contact
from drysim.core.plant import AnyState, Law, Plant, Slider, Stopped
from drysim.core.waves import Waves, anchor, base_motion, normal_force

Kernel = Callable[..., Any]
AnyOther = Slider | Stopped


def walk(law: AnyOther) -> Kernel:
    """Give the kernel that follows the motion."""
    if isinstance(law, Stopped):
        return bound
    return touch


def read(law: AnyOther) -> Kernel:
    """Give the kernel that reads it between its steps."""
    if isinstance(law, Stopped):
        return read_bounded
    return read_contact


def integrate(law: AnyOther) -> Kernel:
    """Give the kernel that integrates it."""
    if isinstance(law, Stopped):
        return integrate_bounded
    return integrate_contact


def waving(law: AnyOther) -> Law:
    """Give a law whose normal force varies as this one's."""
    return Law(law.F_fk, law.F_fk, law.variation, law.omega, law.phase)


def first(
    plant: Plant,
    law: AnyOther,
    waves: Waves,
    u_0: float,
    slope: float,
    start: AnyState,
) -> tuple[Any, ...]:
    """Give x_r, v_r, the state of the contact and its mode at t = 0, for its kernel."""
    x_r, v_r = start[:2]
    if isinstance(law, Stopped):
        anchor(waves, plant, law, 0.0, 0)
        u_dd = base_motion(waves, u_0, slope, 0.0)[0]
        found: tuple[Any, ...] = first_bounds(
            plant, law, x_r, v_r, u_dd, normal_force(law, waves, 0.0)[0]
        )
        return found
    mode, x_0 = first_contact(law, x_r)
    return x_r, v_r, start[2] if len(start) > 2 and mode == 0 else x_0, mode


def heading(law: AnyOther, mode: int) -> int:
    """Give the kind of event that stands for the mode at t = 0."""
    return way_of(mode) if isinstance(law, Stopped) else mode
