"""Exact algorithms, and the scenes that each one solves: the table `SOLVERS`.

A new algorithm is one more row, and a module of this package with a function
`compute_trajectory` that returns an `ExactTrajectory`, such as that of `coulomb`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from drysim.core.model import (
    LEUVEN,
    AnyLaw,
    CoulombLaw,
    DynamicLaw,
    PiecewiseLaw,
    Samples,
    Sines,
)


class Solver(NamedTuple):
    """Exact algorithm.

    Attributes
    ----------
    core : str
        Its name in results.
    why : str
        Why it is exact for the scenes that it solves; stated in results.
    module : str
        Module of this package that computes the motion. It is imported on first use, with its
        kernels.
    reference : str
        Source of the method.
    applies_to : callable
        Whether it solves the scenes of a law and a base motion that no earlier row solves.
    """

    core: str
    why: str
    module: str
    reference: str
    applies_to: Callable[[AnyLaw, Sines | Samples], bool]


STICK_SLIP = "Eqs. (4), (7) and (9) of the paper"
DEN_HARTOG = "J. P. Den Hartog, Phil. Mag. 11 (1931) 801"
SHAW_HOLMES = "S. W. Shaw and P. J. Holmes, J. Sound Vib. 90 (1983) 129"
PETROV_EWINS = "E. P. Petrov and D. J. Ewins, J. Turbomach. 125 (2003) 364"
JORBA_ZOU = "À. Jorba and M. Zou, Exp. Math. 14 (2005) 99"

SOLVERS = (
    Solver(
        "leap",
        "sines: closed form from event to event",
        "coulomb",
        DEN_HARTOG,
        lambda law, motion: isinstance(law, CoulombLaw) and isinstance(motion, Sines),
    ),
    Solver(
        "leap",
        "samples and varying friction limits: closed form in each step, events located",
        "coulomb",
        STICK_SLIP,
        lambda law, _: isinstance(law, CoulombLaw) and law.variation != 0.0,
    ),
    Solver(
        "march",
        "samples, linear in between: closed form in each step, events located",
        "coulomb",
        STICK_SLIP,
        lambda law, _: isinstance(law, CoulombLaw),
    ),
    Solver(
        "bounded",
        "end stops: closed form from event to event",
        "piecewise",
        SHAW_HOLMES,
        lambda law, _: law.stops is not None,
    ),
    Solver(
        "contact",
        "elastic contact: closed form in each mode",
        "piecewise",
        PETROV_EWINS,
        lambda law, _: law.is_elastic,
    ),
    Solver(
        "directed",
        "friction or damping by direction: closed form in each mode",
        "piecewise",
        STICK_SLIP,
        lambda law, _: law.is_directed,
    ),
    Solver(
        "pressed",
        "recorded normal force: closed form in each mode",
        "piecewise",
        PETROV_EWINS,
        lambda law, _: law.may_separate and law.force_record is not None,
    ),
    Solver(
        "pressed",
        "vanishing normal force: closed form in each mode",
        "piecewise",
        PETROV_EWINS,
        lambda law, _: law.may_separate,
    ),
    Solver(
        "pressed",
        "rigid contact: closed form in each mode",
        "piecewise",
        STICK_SLIP,
        lambda law, _: isinstance(law, PiecewiseLaw),
    ),
    Solver(
        "series",
        "friction that depends on speed: Taylor series, zeros of v_r located",
        "taylor",
        JORBA_ZOU,
        lambda law, _: isinstance(law, DynamicLaw) and law.can_stick,
    ),
    Solver(
        "series",
        "bristles with hysteresis: Taylor series, zeros of v_r located",
        "taylor",
        JORBA_ZOU,
        lambda law, _: isinstance(law, DynamicLaw) and law.kind == LEUVEN,
    ),
    Solver(
        "series",
        "bristles: Taylor series, zeros of v_r located",
        "taylor",
        JORBA_ZOU,
        lambda law, _: isinstance(law, DynamicLaw),
    ),
)
"""The exact algorithms, the smallest first. The first one that applies to a scene solves it."""


def solver_of(law: AnyLaw, motion: Sines | Samples) -> Solver:
    """Return the smallest algorithm that is exact for a scene."""
    return next(solver for solver in SOLVERS if solver.applies_to(law, motion))
