"""The oscillator and its friction as plain numbers."""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.normal_force.normal import Pressed

STRIBECK, BRISTLE, LEUVEN = 0, 1, 2
"""Kinds of dynamic law; that of bristles serves Dahl's, too."""


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

    @property
    def sticks(self) -> bool:
        """Whether a contact under this law can hold still."""
        return True


class Dynamic(NamedTuple):
    """A friction force that depends on the speed or on a deflection z before sliding.

    Attributes
    ----------
    F_fk, F_fs : float
        Kinetic friction force [N], above 0, and static limit [N], at least that.
    kind : int
        `STRIBECK`, `BRISTLE` or `LEUVEN`.
    v_s : float
        Stribeck velocity [m/s], above 0; of no account where F_fs = F_fk.
    exponent : float
        Of |v/v_s| in the Stribeck curve, above 0; 2 for all kinds but `STRIBECK`.
    sigma_0, sigma_1, sigma_2 : float
        Stiffness [N/m] and damping [N·s/m] of the bristles, viscous friction [N·s/m].
    F_h : float
        Force that the hysteresis of `LEUVEN` would come to [N], above `F_fs`.
    power : float
        Of the approach to sliding under `LEUVEN`, above 0.
    depth : int
        How many turns the bristles of `LEUVEN` remember at most.
    tolerance : float
        Share of the motion that one step of the solution may neglect [-].
    """

    F_fk: float
    F_fs: float
    kind: int
    v_s: float = 1.0
    exponent: float = 2.0
    sigma_0: float = 0.0
    sigma_1: float = 0.0
    sigma_2: float = 0.0
    F_h: float = math.inf
    power: float = 1.0
    depth: int = 128
    tolerance: float = 1e-12

    @property
    def variation(self) -> float:
        """Give 0: the limits of these laws are constant."""
        return 0.0

    @property
    def sticks(self) -> bool:
        """Whether a contact under this law can hold still; bristles always give a little."""
        return self.kind == STRIBECK


class Slider(NamedTuple):
    """A contact that is a spring until it yields; its normal force may vary as a sine.

    The limit at time t is `F_fk` times 1 + variation·sin(omega·t + phase); where that is below
    zero the surfaces have parted and there is no force.

    Attributes
    ----------
    F_fk : float
        Limit of the contact force [N], above 0.
    k_t : float
        Tangential stiffness [N/m], above 0.
    variation : float
        Relative amplitude of the normal force [-], at least 0.
    omega, phase : float
        Angular frequency of the variation [rad/s] and its phase at t = 0 [rad].
    """

    F_fk: float
    k_t: float
    variation: float = 0.0
    omega: float = 0.0
    phase: float = 0.0

    @property
    def F_fs(self) -> float:
        """Give F_fk [N]: one limit serves both."""
        return self.F_fk

    @property
    def sticks(self) -> bool:
        """Give False: the contact yields a little before it slides."""
        return False


class Stopped(NamedTuple):
    """Coulomb's dry friction on a stroke that ends at a stop on either side.

    A stop is a bumper where `k_s` is above 0, and rigid where it is 0.

    Attributes
    ----------
    F_fk, F_fs : float
        Kinetic friction force [N], at least 0, and static limit [N], at least that.
    x_rM : float
        Where the stops are [m]: at |x_r| = x_rM, above 0.
    k_s, b_s : float
        Stiffness [N/m] and damping [N·s/m] of a bumper, at least 0.
    e : float
        Restitution of a rigid stop [-], 0 to 1.
    variation, omega, phase : float
        Of the normal force, as in `Law`.
    """

    F_fk: float
    F_fs: float
    x_rM: float
    k_s: float = 0.0
    b_s: float = 0.0
    e: float = 0.0
    variation: float = 0.0
    omega: float = 0.0
    phase: float = 0.0

    @property
    def sticks(self) -> bool:
        """Whether a contact under this law can hold still."""
        return True

    @property
    def rigid(self) -> bool:
        """Whether the stops give way to nothing."""
        return self.k_s == 0.0

    @property
    def coulomb(self) -> Law:
        """The same friction without the stops."""
        return Law(self.F_fk, self.F_fs, self.variation, self.omega, self.phase)


AnyLaw = Law | Dynamic | Slider | Stopped | Pressed
"""What a scene may rub with, and run against."""
