"""The oscillator, its friction, its state and its integrals as plain numbers."""

from __future__ import annotations

from typing import NamedTuple


class Plant(NamedTuple):
    """Mass on spring and damper.

    Attributes
    ----------
    m : float
        Sprung mass [kg], above 0.
    k_x : float
        Spring stiffness [N/m], at least 0.
    b : float
        Viscous damping [N·s/m], at least 0.
    """

    m: float
    k_x: float
    b: float


class Law(NamedTuple):
    """Coulomb's dry friction; both limits may follow a normal force that varies as a sine.

    The limits at time t are `F_fk` and `F_fs` times 1 + variation·sin(omega·t + phase).

    Attributes
    ----------
    F_fk : float
        Kinetic friction force [N], at least 0.
    F_fs : float
        Static limit [N], at least `F_fk`.
    variation : float
        Relative amplitude of the normal force [-], 0 to below 1; 0 means constant.
    omega : float
        Angular frequency of the variation [rad/s].
    phase : float
        Phase of the variation at t = 0 [rad].
    """

    F_fk: float
    F_fs: float
    variation: float = 0.0
    omega: float = 0.0
    phase: float = 0.0


class State(NamedTuple):
    """Relative displacement [m] and velocity [m/s] at one instant."""

    x_r: float
    v_r: float


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
        Time without relative motion [s].
    u_dd2 : float
        Integral of ü² [m²/s³].
    u2 : float or None
        Integral of u² [m²s]; None where u is not known.
    """

    x2: float
    v2: float
    x_dd2: float
    power: float
    rub: float
    stuck: float
    u_dd2: float
    u2: float | None
