"""Where a motion is at one instant, and what it adds up to, as plain numbers."""

from __future__ import annotations

from typing import NamedTuple


class State(NamedTuple):
    """Relative displacement [m] and velocity [m/s] at one instant."""

    x_r: float
    v_r: float


class Deflected(NamedTuple):
    """A state with what a contact remembers.

    Attributes
    ----------
    x_r, v_r, z : float
        Relative displacement [m] and velocity [m/s], deflection of the bristles [m]; of a
        spring contact the x_r at which it carries no force [m].
    turned : tuple of float
        Deflections at which it turned and to which it returns [m], the oldest first.
    """

    x_r: float
    v_r: float
    z: float
    turned: tuple[float, ...] = ()


AnyState = State | Deflected
"""Where a motion may start."""


class Totals(NamedTuple):
    """Integrals over a window of time.

    Attributes
    ----------
    x2, v2, x_dd2 : float
        Integrals of x_r² [m²s], v_r² [m²/s] and x_dd² [m²/s³].
    power : float
        Integral of ü v_r [m²/s²]: minus the work of the base per mass.
    rub : float
        Integral of |v_r| times the relative normal force [m].
    stuck : float
        Time without relative motion [s]; 0 under laws that never stick.
    u_dd2 : float
        Integral of ü² [m²/s³].
    u2 : float or None
        Integral of u² [m²s]; None where u is not known.
    hits : float
        Work that the mass did on end stops [J].
    """

    x2: float
    v2: float
    x_dd2: float
    power: float
    rub: float
    stuck: float
    u_dd2: float
    u2: float | None
    hits: float = 0.0
