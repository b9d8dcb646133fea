"""Means and energies from integrals over a window: of one case, or of columns of many."""

from __future__ import annotations

from typing import Any

from drysim.core.plant import Plant
from drysim.core.state import AnyState, Totals
from drysim.quantity.arithmetic import chosen, greatest, ratio, root

Values = dict[str, Any]

NOTHING = 1e-9
"""Share of force times displacement that counts as no energy: rounding comes to 1e-15."""

FAINT = 1e-292
"""What is less counts as no energy [J]: rounding of it is below the least normal number."""


def means(totals: Totals, length: Any) -> Values:
    """Give RMS values, their ratios and the stuck share from the integrals over a window.

    Parameters
    ----------
    totals : Totals
        Of numbers, or of arrays of one shape; then so is what comes out, NaN for not known.
    length : float or ndarray
        Of the window [s].
    """
    a_u = root(totals.u_dd2 / length)
    # A mass that never moves has the base's motion to the last bit, not to rounding.
    a_x = chosen(totals.stuck >= length, a_u, root(totals.x_dd2 / length))
    x_r = root(totals.x2 / length)
    u = None if totals.u2 is None else root(totals.u2 / length)
    return {
        "a_u": a_u,
        "a_x": a_x,
        "T_a": ratio(a_x, a_u),
        "T_x": ratio(x_r, u),
        "x_r_rms": x_r,
        "v_r_rms": root(totals.v2 / length),
        "u_rms": u,
        "stuck_share": totals.stuck / length,
    }


def energies(
    plant: Plant,
    F_fk: Any,
    totals: Totals,
    first: AnyState,
    last: AnyState,
    bumpers: tuple[float, float] = (0.0, 0.0),
) -> Values:
    """Give the energy balance of a window, audited; numbers or arrays as in `means`.

    `bumpers` is what end stops hold as springs at both ends [J].

    Notes
    -----
    Each term is integrated on its own, so what the balance leaves certifies the solution. It is
    relative to the largest term, or to m·RMS{ü}·RMS{v_r}·t: what base and mass may exchange;
    at least to the share `NOTHING` of F_fk |x_r|, lest rounding be held against a contact that
    rests away from the middle, and at least to `FAINT`.
    """
    work = -plant.m * totals.power
    begin = held_energy(plant, first) + bumpers[0]
    stored = held_energy(plant, last) + bumpers[1] - begin
    stops = totals.hits - (bumpers[1] - bumpers[0])
    viscous = plant.b * totals.v2
    friction = F_fk * totals.rub
    exchanged = plant.m * root(totals.u_dd2 * totals.v2)
    least = NOTHING * F_fk * greatest(abs(first.x_r), abs(last.x_r))
    scale = greatest(exchanged, abs(stored), viscous, friction, begin, abs(stops), least, FAINT)
    return {
        "energy_input": work,
        "energy_stored": stored,
        "energy_viscous": viscous,
        "energy_friction": friction,
        "energy_residual": abs(work - stored - viscous - friction - stops) / scale,
    }


def held_energy(plant: Plant, state: AnyState) -> Any:
    """Give the spring and kinetic energy of a state of relative motion [J]."""
    v_r, x_r = state.v_r, state.x_r
    return 0.5 * (plant.m * (v_r * v_r) + plant.k_x * (x_r * x_r))
