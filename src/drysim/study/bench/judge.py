"""The judge: errors of an answer against the exact one, and a verdict in a few words."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING, Self

import numpy as np

from drysim.approach.stick_slip import StickSlip
from drysim.approach.viscous import Viscous
from drysim.core.motion import Samples
from drysim.errors import SolverError
from drysim.study.bench.scores import EXACT
from drysim.wording import number

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from drysim.approach.events import Floats
    from drysim.study.bench.work import Answer, Work

CLOSE, FINE, COARSE = 1e-4, 1e-2, 1e-1
"""Errors [-] up to which an answer counts as close, fine and coarse: what no measurement tells
apart, what nobody minds, what misleads nobody."""

SATURATED, MOSTLY = 0.99, 0.5
"""Share of F_fk [-] that counts as all of it, and of the time that counts as most of it."""

STOPS = (0, 2, -2)
"""Kinds of events at which the mass comes to a stop: it sticks or turns."""

Errors = tuple[float | None, float | None]
"""Of x_r and of T_a [-]."""


@dataclass(frozen=True, eq=False)
class Yardstick:
    """The exact answer on the whole work, and what errors are relative to.

    Attributes
    ----------
    x_r, x_dd : ndarray, shape (samples + 1,)
        Relative displacement [m], absolute acceleration [m/s²].
    stuck : ndarray of bool, shape (samples + 1,)
    scale : float
        Greatest |x_r| [m], or where the mass never moves that without dry friction.
    stops : ndarray
        Instants at which the mass comes to a stop [s].
    """

    x_r: Floats
    x_dd: Floats
    stuck: NDArray[np.bool_]
    scale: float
    stops: Floats

    @classmethod
    def of(cls, work: Work) -> Self:
        """Give the exact answer to a work."""
        scene = (work.motion, work.start, work.step)
        duration = None if isinstance(work.motion, Samples) else work.end
        exact = StickSlip().solve(work.plant, work.law, *scene, duration)
        scale = float(np.abs(exact.x_r).max())
        if not scale:
            free = Viscous().solve(work.plant, work.law, *scene, duration)
            scale = float(np.abs(free.x_r).max())
        stops = exact.events.t[1:][np.isin(exact.events.kind[1:], STOPS)]
        return cls(exact.x_r, exact.x_dd, exact.stuck, scale or 1.0, stops)

    def errors(self, work: Work, answer: Answer) -> Errors:
        """Give the errors of an answer on a stretch of the work.

        Raises
        ------
        SolverError
            When the answer is no row of numbers of the right length.
        """
        points = work.samples + 1
        if answer.x_r.shape != (points,) or not np.isfinite(answer.x_r).all():
            raise SolverError("the answer is not a finite number at every sample")
        off = float(np.abs(answer.x_r - self.x_r[:points]).max()) / self.scale
        own, exact = _rms(work.acceleration(answer)), _rms(self.x_dd[:points])
        return off, own / exact - 1.0 if exact else None

    def apart(self, one: Answer, other: Answer) -> float:
        """Return how far x_r of two answers is apart at most [-], relative as errors are."""
        return float(np.abs(one.x_r - other.x_r).max()) / self.scale

    def symptoms(self, work: Work, answer: Answer) -> tuple[bool, bool]:
        """Tell whether an answer chatters, and whether it moves, where the mass should stick.

        Friction balances what pulls there. It is as large as it can be only where it drives
        the mass to and fro.
        """
        stuck = self.stuck[: work.samples + 1]
        if not stuck.any():
            return False, False
        full = np.abs(answer.friction()[stuck]) > SATURATED * work.law.F_fk
        chatters = work.law.F_fk > 0.0 and float(full.mean()) > MOSTLY
        return chatters, bool((answer.v_r[stuck] != 0.0).any())


def verdict(errors: Errors, symptoms: tuple[bool, bool], lacks: bool) -> str:
    """Give the verdict on an answer in a few words.

    Parameters
    ----------
    errors : tuple
        Of x_r and T_a [-]; None where there is none.
    symptoms : tuple of bool
        Whether it chatters, and moves, where the mass should stick.
    lacks : bool
        Whether it leaves something of the scene out.
    """
    off, T_a = errors[0] or 0.0, errors[1] or 0.0
    worst = max(off, abs(T_a))
    for limit, word in ((EXACT, "exact"), (CLOSE, "close"), (FINE, "fine")):
        if worst <= limit:
            return word
    how = f"T_a {100 * T_a:+.2g} %" if abs(T_a) >= off else f"x_r {number(100 * off, '%', 2)}"
    chatters, moves = symptoms
    if chatters:
        return f"chatters, {how}"
    if lacks:
        return f"another law, {how}"
    if moves:
        return f"creeps, {how}"
    return f"{'coarse' if worst <= COARSE else 'wrong'}, {how}"


def _rms(series: Floats) -> float:
    return sqrt(float(np.dot(series, series)) / len(series)) if len(series) else 0.0
