"""Where a leg of a motion by series begins: the state, and what the law recalls."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from drysim.approach.events import Floats
from drysim.core.compiled import held
from drysim.core.dynamic_laws.jet import ORDER, Jet
from drysim.core.dynamic_laws.memory import COUNT, WAY, forget, head
from drysim.core.dynamic_laws.trace import first_heading
from drysim.core.plant import LEUVEN, Dynamic, Plant
from drysim.core.state import AnyState
from drysim.core.waves import Waves


class Mark(NamedTuple):
    """Where a leg begins: sample and time within it, the state, and what the law recalls.

    `state` is x_r [m], v_r [m/s], z [m] and the direction; `scale` the greatest speed so far
    [m/s]; `turned` and `branch` as in `Jet`.
    """

    n: int
    s: float
    state: tuple[float, float, float, int]
    scale: float
    turned: tuple[float, ...]
    branch: tuple[int, ...]


def work(law: Dynamic, scale: float) -> Jet:
    """Give what the kernels work in; a speed [m/s] to measure the motion by."""
    short = {"scale": 1, "slope": 2, "turned": law.depth if law.kind == LEUVEN else 0}
    values = {name: held(np.zeros(short.get(name, ORDER + 2))) for name in Jet._fields}
    jet = Jet(**values | {"branch": held(np.zeros(3, dtype=np.int64))})
    jet.scale[0] = scale
    return jet


def marked(n: int, s: float, state: tuple[Any, ...], jet: Jet) -> Mark:
    """Give the mark of a state and of what the law recalls there."""
    turned = tuple(float(z) for z in jet.turned[: jet.branch[COUNT]])
    branch = tuple(int(value) for value in jet.branch)
    return Mark(n, s, state, float(jet.scale[0]), turned, branch)


def first_mark(
    plant: Plant, law: Dynamic, waves: Waves, base: Floats, dt: float, start: AnyState,
    speed: float,
) -> Mark:  # fmt: skip
    """Give the mark at t = 0, from the first two values of ü besides the waves."""
    x_r, v_r = start[:2]
    z = start[2] if len(start) > 2 else 0.0
    jet, slope = work(law, speed), float(base[1] - base[0]) / dt
    d = first_heading(plant, law, waves, jet, float(base[0]), slope, 0.0, x_r, v_r, z)
    if law.kind == LEUVEN:
        recall(jet, start[3] if len(start) > 3 else (), z)
        if d != 0:
            head(law, jet, int(np.sign(d)), v_r, z)
    return marked(0, 0.0, (x_r, v_r, z, d), jet)


def recall(jet: Jet, turned: tuple[float, ...], z: float) -> None:
    """Set the turns of a state at deflection z [m], and the branch that they lead to.

    The direction of the branch follows from the turns alone: the first one ended the virgin
    curve, which leads away from zero, and each one reverses the direction. The deflection does
    not tell it: it may be that of the last turn to rounding.
    """
    for level in turned:
        if jet.branch[COUNT] == len(jet.turned):
            forget(jet)
        jet.turned[jet.branch[COUNT]] = level
        jet.branch[COUNT] += 1
    outwards = int(np.sign(turned[0] if turned else z))
    jet.branch[WAY] = -outwards if jet.branch[COUNT] % 2 else outwards
