"""PathSim: a block diagram, integrated in Python, with smoothed friction."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import tanh
from typing import Any

import numpy as np

from drysim.bench.scipy_ivp import has_static_excess, motion_scale, smoothed_answer
from drysim.bench.work import Answer, Entry, Run, Work
from drysim.wording import format_number

PACKAGE = "pathsim"

SETTINGS = ((1e-6, 1e3),)
"""Relative tolerance and sharpness [s/m]."""


def entries(work: Work) -> Iterator[Entry]:
    """Yield PathSim with its adaptive Runge-Kutta method."""
    for tolerance, c in SETTINGS:
        words = f"RKCK54, {format_number(tolerance)}, tanh c {format_number(c)}"
        yield Entry(
            "PathSim tanh",
            words,
            on_smoothed_law(tolerance, c),
            other_law=has_static_excess(work),
        )


def on_smoothed_law(tolerance: float, c: float) -> Callable[[Work], Run]:
    """Return the preparation of an entry with tanh(c v_r) for sign(v_r)."""

    def ready(work: Work) -> Run:
        from pathsim import Connection, Simulation
        from pathsim.blocks import ODE, Scope
        from pathsim.solvers import RKCK54

        m, k_x, b = work.plant
        F_fk, base = work.law.F_fk, work.base
        grid = work.grid

        def rates(y: Any, u: Any, t: float) -> Any:
            x_r, v_r = y
            F_f = F_fk * tanh(c * v_r)
            return np.array([v_r, -base(t) - (k_x * x_r + b * v_r + F_f) / m])

        def run() -> Answer:
            plant, scope = ODE(rates, initial_value=np.array(work.start)), Scope()
            wires = [Connection(plant[at], scope[at]) for at in (0, 1)]
            simulation = Simulation(
                [plant, scope], wires, dt=work.step, Solver=RKCK54, log=False,
                dt_max=work.step, tolerance_lte_rel=tolerance,
                tolerance_lte_abs=tolerance * float(motion_scale(work).min()),
            )  # fmt: skip
            simulation.run(work.end)
            t, (x_r, v_r) = scope.read()
            return smoothed_answer(work, np.interp(grid, t, x_r), np.interp(grid, t, v_r), c)

        return run

    return ready
