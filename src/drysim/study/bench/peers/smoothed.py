"""What peers on the smoothed law share: tanh(c v) stands for the sign of v, Eq. (8)."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from drysim.study.bench.work import Answer, Work

if TYPE_CHECKING:
    from drysim.approach.events import Floats


def smoothed(work: Work, x_r: Floats, v_r: Floats, c: float) -> Answer:
    """Give the answer of a peer on the smoothed law of sharpness c [s/m]."""
    return Answer(x_r, v_r, lambda: work.law.F_fk * np.tanh(c * v_r))


def lacks(work: Work) -> tuple[str, ...]:
    """Give what of a scene a peer leaves out that knows one friction force only."""
    return ("a static limit above kinetic friction",) if work.law.F_fs > work.law.F_fk else ()


def swing(work: Work) -> Floats:
    """Give the size of x_r [m] and v_r [m/s] to which absolute tolerances are relative.

    A person knows about how far the mass moves: as far as the base pulls a block in half the
    natural period, or in a tenth of a second where there is no spring.
    """
    m, k_x, _ = work.plant
    time = sqrt(m / k_x) if k_x else 0.1
    a = float(np.abs(work.u_dd).max())
    v = a * time + abs(work.start.v_r)
    return np.array([(v * time + abs(work.start.x_r)) or 1.0, v or 1.0])
