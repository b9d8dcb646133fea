"""The kernels that follow contacts and end stops, and what they want to begin with."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from drysim.approach.events import Events
from drysim.core.compiled import held
from drysim.core.contacts.contact import first_contact
from drysim.core.contacts.contact_replay import integrate_contact, read_contact
from drysim.core.contacts.touch import touch
from drysim.core.events import REVERSAL, STICK
from drysim.core.normal_force.load import Limits
from drysim.core.normal_force.normal import Pressed
from drysim.core.normal_force.pressed import first_pressed, press
from drysim.core.normal_force.pressed_replay import integrate_pressed, read_pressed
from drysim.core.plant import Law, Plant, Slider, Stopped
from drysim.core.state import AnyState
from drysim.core.stops.bounded import bound
from drysim.core.stops.bounded_replay import integrate_bounded, read_bounded
from drysim.core.stops.bumper import way_of
from drysim.core.stops.rest import first_bounds
from drysim.core.waves import Waves, anchor, base_motion, normal_force

Kernel = Callable[..., Any]
AnyOther = Slider | Stopped | Pressed


def walk(law: AnyOther) -> Kernel:
    """Give the kernel that follows the motion."""
    return _ways(law)[0]


def read(law: AnyOther) -> Kernel:
    """Give the kernel that reads it between its steps."""
    return _ways(law)[1]


def integrate(law: AnyOther) -> Kernel:
    """Give the kernel that integrates it."""
    return _ways(law)[2]


def _ways(law: AnyOther) -> tuple[Kernel, Kernel, Kernel]:
    """Give the kernels that follow, read and integrate the motion."""
    if isinstance(law, Stopped):
        return bound, read_bounded, integrate_bounded
    if isinstance(law, Slider):
        return touch, read_contact, integrate_contact
    return press, read_pressed, integrate_pressed


def numbers(law: AnyOther) -> Any:
    """Give a law as its kernels want it."""
    if not isinstance(law, Pressed):
        return law
    pressure = law.pressure
    if pressure is None:
        return Limits(*law[:5], held(np.ones(2)), 0.0)
    return Limits(*law[:5], pressure.given, pressure.step)


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
    if isinstance(law, Pressed):
        return x_r, v_r, 0.0, first_pressed(plant, numbers(law), waves, u_0, slope, x_r, v_r)
    mode, x_0 = first_contact(law, x_r, v_r, start[2] if len(start) > 2 else x_r)
    return x_r, v_r, x_0, mode


def heading(law: AnyOther, mode: int) -> int:
    """Give the kind of event that stands for the mode at t = 0."""
    return way_of(mode) if isinstance(law, Stopped) else mode


def tightest(law: AnyOther, events: Events) -> float:
    """Give the smallest relative margin of a decision at a stop; infinity for none."""
    if not isinstance(law, Pressed):
        return math.inf
    F_fs, F_L = law.F_fs * law.load(events.t), np.abs(events.F_L)
    decided = np.isin(events.kind, (STICK, REVERSAL, -REVERSAL)) & (F_fs > 0.0)
    decided[0] = False
    larger = np.maximum(F_fs, F_L)[decided]
    return float((np.abs(F_L - F_fs)[decided] / larger).min(initial=math.inf))
