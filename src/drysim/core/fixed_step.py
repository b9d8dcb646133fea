"""Fixed-step methods for comparison: sign approximations, velocity band, Moreau-Jean.

Each march writes the motion at the end of every step and locates no event.

- `march_fixed_step` replaces the sign in Eq. (7) by a function of velocity, smooth or not, and
  therefore has no stick.
- `march_switch` lets the mass stick within a velocity band (Karnopp, J. Dyn. Syst. Meas.
  Control 107 (1985) 100).
- `march_moreau` solves each step for the set-valued sign (Acary and Brogliato, Numerical
  Methods for Nonsmooth Dynamical Systems, 2008).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compile import compiled
from drysim.core.events import sign

SIGN, ARCTAN, TANH, ERF, RATIONAL = 0, 1, 2, 3, 4
"""Forms of the sign function; all but the first are smooth, Eq. (8)."""

EULER, SEMI_IMPLICIT, HEUN, RK4 = 0, 1, 2, 3
"""Integrators of `march_fixed_step`."""


class BaseOnGrid(NamedTuple):
    """Base acceleration on the grid of a fixed-step method.

    Attributes
    ----------
    u_dd : array, shape (n,)
        Values at the grid points [m/s²].
    u_mid : array, shape (n - 1,)
        Values halfway between them [m/s²].
    dt : float
        Step [s].
    """

    u_dd: Any
    u_mid: Any
    dt: float


class MotionOnGrid(NamedTuple):
    """Motion at the grid points: arrays of shape (n,).

    Attributes
    ----------
    x_r, v_r : array
        Displacement [m] and velocity [m/s]; a march starts from the first values.
    F_f : array
        Friction force [N].
    d : array of int
        Direction of sliding, 0 where stuck.
    """

    x_r: Any
    v_r: Any
    F_f: Any
    d: Any


@compiled
def regularised_sign(form, sharpness, v_r):
    """Return the friction force relative to F_fk [-].

    Parameters
    ----------
    form : int
        `SIGN` (sign(0) = 0) or one of the smooth forms.
    sharpness : float
        Sharpness c of the smooth forms [s/m].
    v_r : float
        Relative velocity [m/s].
    """
    if form == SIGN:
        return 1.0 if v_r > 0.0 else (-1.0 if v_r < 0.0 else 0.0)
    if form == TANH:
        return math.tanh(sharpness * v_r)
    if form == ARCTAN:
        return 2.0 / math.pi * math.atan(sharpness * v_r)
    if form == ERF:
        return math.erf(sharpness * v_r)
    return sharpness * v_r / (1.0 + sharpness * abs(v_r))


@compiled
def acceleration(c, w, f, share, u_dd, x_r, v_r):
    """Return the relative acceleration [m/s²] of Eq. (7) with a regularised sign, `share`."""
    return -(u_dd + c * v_r + w * x_r + f * share)


@compiled
def march_fixed_step(plant, F_fk, form, sharpness, method, base, out):
    """Integrate Eq. (7) with a friction force that is a function of velocity.

    The mass never sticks: at rest its direction is 1.

    Parameters
    ----------
    plant : Plant
    F_fk : float
        Kinetic friction force [N].
    form, sharpness
        As in `regularised_sign`.
    method : int
        `EULER`, `SEMI_IMPLICIT`, `HEUN` or `RK4`.
    base, out : BaseOnGrid, MotionOnGrid
    """
    u_dd, u_mid, dt = base
    x_out, v_out, F_out, d_out = out
    c, w, f = plant.b / plant.m, plant.k_x / plant.m, F_fk / plant.m
    x, v = x_out[0], v_out[0]
    for n in range(len(u_dd)):
        share = regularised_sign(form, sharpness, v)
        x_out[n] = x
        v_out[n] = v
        F_out[n] = F_fk * share
        d_out[n] = -1 if v < 0.0 else 1
        if n == len(u_dd) - 1:
            return
        a = acceleration(c, w, f, share, u_dd[n], x, v)
        if method == EULER:
            x, v = x + dt * v, v + dt * a
        elif method == SEMI_IMPLICIT:
            v += dt * a
            x += dt * v
        elif method == HEUN:
            v_end = v + dt * a
            share = regularised_sign(form, sharpness, v_end)
            a_end = acceleration(c, w, f, share, u_dd[n + 1], x + dt * v, v_end)
            x, v = x + dt * (v + 0.5 * dt * a), v + 0.5 * dt * (a + a_end)
        else:
            h = 0.5 * dt
            v_2 = v + h * a
            share = regularised_sign(form, sharpness, v_2)
            a_2 = acceleration(c, w, f, share, u_mid[n], x + h * v, v_2)
            v_3 = v + h * a_2
            share = regularised_sign(form, sharpness, v_3)
            a_3 = acceleration(c, w, f, share, u_mid[n], x + h * v_2, v_3)
            v_4 = v + dt * a_3
            share = regularised_sign(form, sharpness, v_4)
            a_4 = acceleration(c, w, f, share, u_dd[n + 1], x + dt * v_3, v_4)
            x += dt / 6.0 * (v + 2.0 * v_2 + 2.0 * v_3 + v_4)
            v += dt / 6.0 * (a + 2.0 * a_2 + 2.0 * a_3 + a_4)


@compiled
def march_switch(plant, F_fk, F_fs, eps, base, out):
    """Integrate with the paper's velocity band, within which the mass may stick, Eq. (10).

    Parameters
    ----------
    plant, base, out
        As in `march_fixed_step`.
    F_fk, F_fs : float
        Kinetic friction force and static limit [N].
    eps : float
        Half width of the band [m/s], above 0.
    """
    m, k_x, b = plant
    u_dd, _, dt = base
    x_out, v_out, F_out, d_out = out
    x, v = x_out[0], v_out[0]
    for n in range(len(u_dd)):
        F_L = m * u_dd[n] + k_x * x
        if abs(v) >= eps:
            d = sign(v)
        elif abs(F_L) > F_fs:
            d = -sign(F_L)
        else:
            d = 0
            v = 0.0
        F = d * F_fk if d != 0 else -F_L
        x_out[n] = x
        v_out[n] = v
        F_out[n] = F
        d_out[n] = d
        if d != 0:  # semi-implicit Euler
            v -= dt * (u_dd[n] + (b * v + k_x * x + F) / m)
            x += dt * v


@compiled
def march_moreau(plant, F_fk, base, out):
    """Integrate by Moreau-Jean time stepping with θ = 1/2; parameters as in `march_switch`.

    Notes
    -----
    The friction impulse of a step is the point of [-F_fk dt, F_fk dt] that minimises the final
    speed; the mass sticks where this speed is zero. Acary and Brogliato (2008).
    """
    m, k_x, b = plant
    u_dd, _, dt = base
    c = b / m
    w = k_x / m
    # The trapezoidal rule for spring and damper gives a linear equation for the final velocity:
    # inertia·v_next = inertia·v_free - impulse/m. The impulse that minimises |v_next| follows
    # from clipping.
    inertia = 1.0 + 0.5 * dt * c + 0.25 * dt * dt * w
    impulse_limit = dt * F_fk / (m * inertia)
    x_out, v_out, F_out, d_out = out
    x, v = x_out[0], v_out[0]
    F_out[0] = sign(v) * F_fk
    d_out[0] = sign(v)
    for n in range(len(u_dd) - 1):
        mean_u_dd = 0.5 * (u_dd[n] + u_dd[n + 1])
        v_free = ((2.0 - inertia) * v - dt * (w * x + mean_u_dd)) / inertia
        if v_free > impulse_limit:
            v_next = v_free - impulse_limit
        elif v_free < -impulse_limit:
            v_next = v_free + impulse_limit
        else:
            v_next = 0.0
        x += 0.5 * dt * (v + v_next)
        v = v_next
        x_out[n + 1] = x
        v_out[n + 1] = v
        F_out[n + 1] = (v_free - v_next) * m * inertia / dt
        d_out[n + 1] = sign(v)
