"""The kernels that follow a law beyond Coulomb's, and what they want to begin with."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from drysim.core.bounded import bound, first_bounds
from drysim.core.bounded_replay import integrate_bounded, read_bounded
from drysim.core.bumper import way_of
from drysim.core.compiled import held
from drysim.core.contact import first_contact, touch
from drysim.core.contact_replay import integrate_contact, read_contact
from drysim.core.jet import ORDER, Jet
from drysim.core.memory import COUNT, head
from drysim.core.plant import LEUVEN, AnyState, Dynamic, Law, Plant, Slider, Stopped
from drysim.core.replay import integrate_series
from drysim.core.replay import read as read_series
from drysim.core.trace import first_heading, trace
from drysim.core.waves import Waves, anchor, base_motion, normal_force

Kernel = Callable[..., Any]
AnyOther = Dynamic | Slider | Stopped


def walk(law: AnyOther) -> Kernel:
    """Give the kernel that follows the motion."""
    if isinstance(law, Stopped):
        return bound
    return trace if isinstance(law, Dynamic) else touch


def read(law: AnyOther) -> Kernel:
    """Give the kernel that reads it between its steps."""
    if isinstance(law, Stopped):
        return read_bounded
    return read_series if isinstance(law, Dynamic) else read_contact


def integrate(law: AnyOther) -> Kernel:
    """Give the kernel that integrates it."""
    if isinstance(law, Stopped):
        return integrate_bounded
    return integrate_series if isinstance(law, Dynamic) else integrate_contact


def work(law: AnyOther, speed: float) -> tuple[Any, ...]:
    """Give what the kernels of a law work in; a speed [m/s] to measure the motion by."""
    if not isinstance(law, Dynamic):
        return ()
    short = {"scale": 1, "slope": 2, "turned": law.depth if law.kind == LEUVEN else 0}
    values = {name: held(np.zeros(short.get(name, ORDER + 2))) for name in Jet._fields}
    jet = Jet(**values | {"branch": held(np.zeros(3, dtype=np.int64))})
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
    """Give x_r, v_r, the state of the contact and its mode at t = 0, for its kernel."""
    x_r, v_r = start[:2]
    if isinstance(law, Stopped):
        anchor(waves, plant, law, 0.0, 0)
        u_dd = base_motion(waves, u_0, slope, 0.0)[0]
        found: tuple[Any, ...] = first_bounds(
            plant, law, x_r, v_r, u_dd, normal_force(law, waves, 0.0)[0]
        )
        return found
    if isinstance(law, Slider):
        mode, x_0 = first_contact(law, x_r)
        return x_r, v_r, start[2] if len(start) > 2 and mode == 0 else x_0, mode
    z = start[2] if len(start) > 2 else 0.0
    scene: tuple[Any, ...] = (plant, law, waves, *work, u_0, slope, 0.0, x_r, v_r, z)
    d = first_heading(*scene)
    if law.kind == LEUVEN:
        recall(law, work[0], start[3] if len(start) > 3 else (), d or 1, v_r, z)
    return x_r, v_r, z, d


def recall(
    law: Dynamic, jet: Jet, turned: tuple[float, ...], d: int, v: float, z: float
) -> None:
    """Let bristles remember where they turned, the latest of it as far as there is room."""
    latest = turned[-len(jet.turned) :]
    jet.branch[COUNT] = len(latest)
    jet.turned[: len(latest)] = latest
    head(law, jet, d, v, z)


def remembered(work: tuple[Any, ...]) -> tuple[float, ...]:
    """Give the deflections [m] that a contact remembers to have turned at, the oldest first."""
    if not work:
        return ()
    jet = work[0]
    return tuple(float(z) for z in jet.turned[: jet.branch[COUNT]])


def heading(law: AnyOther, mode: int) -> int:
    """Give the kind of event that stands for the mode at t = 0."""
    return way_of(mode) if isinstance(law, Stopped) else mode
