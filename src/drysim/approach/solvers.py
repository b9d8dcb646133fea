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
        Its name in `drysim.json`.
    why : str
        How it solves its scenes; said on screen, in the report and in `drysim.json`.
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
DEN_HARTOG = "J. P. Den Hartog, Phil. Mag. (7) 9, no. 59 suppl. (May 1930) 801"
SHAW_HOLMES = "S. W. Shaw and P. J. Holmes, J. Sound Vib. 90 (1983) 129"
PETROV_EWINS = "E. P. Petrov and D. J. Ewins, J. Turbomach. 125 (2003) 364"
JORBA_ZOU = "À. Jorba and M. Zou, Exp. Math. 14 (2005) 99"

SOLVERS = (
    Solver(
        "event-to-event",
        "closed form from event to event under sines",
        "coulomb",
        DEN_HARTOG,
        lambda law, motion: isinstance(law, CoulombLaw) and isinstance(motion, Sines),
    ),
    Solver(
        "event-to-event",
        "closed form between samples under varying friction limits, events located",
        "coulomb",
        STICK_SLIP,
        lambda law, _: isinstance(law, CoulombLaw) and law.variation != 0.0,
    ),
    Solver(
        "sample-to-sample",
        "closed form between samples, events located",
        "coulomb",
        STICK_SLIP,
        lambda law, _: isinstance(law, CoulombLaw),
    ),
    Solver(
        "end-stops",
        "closed form from event to event with end stops",
        "piecewise",
        SHAW_HOLMES,
        lambda law, _: law.stops is not None,
    ),
    Solver(
        "elastic-contact",
        "closed form in each mode of an elastic contact",
        "piecewise",
        PETROV_EWINS,
        lambda law, _: law.is_elastic,
    ),
    Solver(
        "by-direction",
        "closed form in each mode under friction or damping by direction",
        "piecewise",
        STICK_SLIP,
        lambda law, _: law.is_directed,
    ),
    Solver(
        "rigid-contact",
        "closed form in each mode under a recorded normal force",
        "piecewise",
        PETROV_EWINS,
        lambda law, _: law.may_separate and law.force_record is not None,
    ),
    Solver(
        "rigid-contact",
        "closed form in each mode under a vanishing normal force",
        "piecewise",
        PETROV_EWINS,
        lambda law, _: law.may_separate,
    ),
    Solver(
        "rigid-contact",
        "closed form in each mode of a rigid contact",
        "piecewise",
        STICK_SLIP,
        lambda law, _: isinstance(law, PiecewiseLaw),
    ),
    Solver(
        "taylor-series",
        "Taylor series for friction that depends on speed, zeros of v_r located",
        "taylor",
        JORBA_ZOU,
        lambda law, _: isinstance(law, DynamicLaw) and law.can_stick,
    ),
    Solver(
        "taylor-series",
        "Taylor series for bristles with hysteresis, zeros of v_r located",
        "taylor",
        JORBA_ZOU,
        lambda law, _: isinstance(law, DynamicLaw) and law.kind == LEUVEN,
    ),
    Solver(
        "taylor-series",
        "Taylor series for bristles, zeros of v_r located",
        "taylor",
        JORBA_ZOU,
        lambda law, _: isinstance(law, DynamicLaw),
    ),
)
"""The exact algorithms, the smallest first. The first one that applies to a scene solves it."""


def solver_of(law: AnyLaw, motion: Sines | Samples) -> Solver:
    """Return the smallest algorithm that is exact for a scene."""
    return next(solver for solver in SOLVERS if solver.applies_to(law, motion))
