"""CVODE of SUNDIALS, from scikit-sundae: implicit multistep, with smoothed friction."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import tanh
from typing import TYPE_CHECKING

import numpy as np

from drysim.bench.scipy_ivp import has_static_excess, motion_scale, smoothed_answer
from drysim.bench.work import Answer, Entry, Run, Work
from drysim.errors import SolverError
from drysim.wording import format_number

if TYPE_CHECKING:
    from drysim.core.model import Floats


PACKAGE = "sksundae"

SETTINGS = ((1e-6, 1e4), (1e-9, 1e6))
"""Relative tolerances and sharpnesses [s/m]."""

MAX_STEPS = 100_000
"""Maximum number of steps between two samples."""


def entries(work: Work) -> Iterator[Entry]:
    """Yield CVODE at several tolerances."""
    for tolerance, c in SETTINGS:
        words = f"BDF, {format_number(tolerance)}, tanh c {format_number(c)}"
        yield Entry(
            "CVODE tanh",
            words,
            on_smoothed_law(tolerance, c),
            other_law=has_static_excess(work),
        )


def on_smoothed_law(tolerance: float, c: float) -> Callable[[Work], Run]:
    """Return the preparation of an entry with tanh(c v_r) for sign(v_r), in a single call."""

    def ready(work: Work) -> Run:
        from sksundae.cvode import CVODE

        m, k_x, b = work.plant
        F_fk, base, grid = work.law.F_fk, work.base, work.grid

        def rates(t: float, y: Floats, y_d: Floats) -> None:
            x_r, v_r = y.tolist()
            y_d[0] = v_r
            y_d[1] = -base(t) - (k_x * x_r + b * v_r + F_fk * tanh(c * v_r)) / m

        solver = CVODE(
            rates, rtol=tolerance, atol=tolerance * motion_scale(work),
            max_step=10 * work.step, max_num_steps=MAX_STEPS,
        )  # fmt: skip

        def run() -> Answer:
            found = solver.solve(grid, np.array(work.start))
            if not found.success:
                raise SolverError(f"CVODE: {found.message}")
            return smoothed_answer(work, found.y[:, 0].copy(), found.y[:, 1].copy(), c)

        return run

    return ready
