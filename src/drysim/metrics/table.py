"""Table of metrics, and their computation from the continuous solution.

`METRICS` lists all metrics and `measure` computes them. RMS values and energies follow from
integrals over a window, of one case or of columns of many cases. Stroke metrics are in
`stroke`, those that need a grid in `comfort` and `spectra`, and the checks of a scenario in
`checks`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from drysim.approach.solution import Path, Trajectory
from drysim.core.model import AnyState, Plant, StrokeLimits, Totals
from drysim.metrics.stroke import (
    Values,
    bumper_energy,
    excursions,
    impact_metrics,
    path_in_window,
    stroke_statistics,
)

Metrics = Mapping[str, float | int | None]
"""Values by name, None where unknown; read-only."""


class Metric(NamedTuple):
    """Name of a metric for checks and reports, its SI unit and its meaning."""

    name: str
    unit: str
    about: str


METRICS = (
    Metric("a_u", "m/s2", "RMS acceleration of the base"),
    Metric("a_x", "m/s2", "RMS acceleration of the mass"),
    Metric("T_a", "-", "acceleration transmissibility a_x/a_u"),
    Metric("T_x", "-", "relative displacement transmissibility RMS{x_r}/RMS{u}"),
    Metric("x_r_rms", "m", "RMS relative displacement, mean included"),
    Metric("x_r_peak", "m", "stroke: largest |x_r| in the window"),
    Metric("x_r_max", "m", "largest x_r in the window"),
    Metric("x_r_min", "m", "smallest x_r in the window"),
    Metric("v_r_rms", "m/s", "RMS relative velocity"),
    Metric("u_rms", "m", "RMS displacement of the base, where it is known"),
    Metric(
        "stroke_used", "-", "x_r_peak over the stroke limit; of unequal limits the larger share"
    ),
    Metric(
        "stuck_share",
        "-",
        "share of the window without relative motion; 0 under laws that never stick",
    ),
    Metric(
        "chatter_share",
        "-",
        "share of the window with two sign changes of v_r within four steps",
    ),
    Metric("violations", "-", "how often |x_r| reaches the stroke limit, settling included"),
    Metric("violations_up", "-", "how often x_r reaches the upper limit, settling included"),
    Metric("violations_down", "-", "how often x_r reaches the lower limit, settling included"),
    Metric("t_first_violation", "s", "time of the first violation"),
    Metric("t_beyond", "s", "time spent at or beyond the stroke limit, settling included"),
    Metric("crossing_rate", "1/s", "up-crossings of x_r = 0 per second"),
    Metric("limit_rate", "1/s", "how often |x_r| reaches the stroke limit, per second"),
    Metric(
        "stroke_suffices",
        "m",
        "stroke needed for this motion: largest |x_r|, settling included",
    ),
    Metric(
        "stroke_once_an_hour",
        "m",
        "stroke exceeded once an hour if noise or record continues as in the window: "
        "extrapolated from the tail of its peaks (Weibull, exponent 2), at most the position "
        "of rigid stops; unknown below 150 half cycles",
    ),
    Metric("contacts", "-", "contacts with an end stop in the window"),
    Metric("contacts_up", "-", "contacts with the upper end stop in the window"),
    Metric("contacts_down", "-", "contacts with the lower end stop in the window"),
    Metric("impact_speed", "m/s", "largest |v_r| at a contact in the window"),
    Metric("stop_force_peak", "N", "largest force between mass and bumper"),
    Metric("impulse_peak", "N·s", "largest impulse of an impact on a rigid stop"),
    Metric("a_w", "m/s2", "weighted RMS acceleration of the mass, ISO 2631-1, times k"),
    Metric(
        "SEAT",
        "-",
        "seat effective amplitude transmissibility: a_w of the mass over that of the base",
    ),
    Metric("VDV", "m/s^1.75", "vibration dose of the mass over the window, (∫ a_w⁴ dt)^(1/4)"),
    Metric("SEAT_VDV", "-", "VDV of the mass over that of the base"),
    Metric("MTVV", "m/s2", "largest running RMS of a_w, linear over 1 s"),
    Metric("crest_factor", "-", "largest |a_w| over its RMS, of the mass"),
    Metric("energy_input", "J", "work of the base on the relative motion in the window"),
    Metric("energy_stored", "J", "change of kinetic and elastic energy, bumpers included"),
    Metric("energy_friction", "J", "energy dissipated in the dry-friction contact"),
    Metric("energy_viscous", "J", "energy dissipated in the damper"),
    Metric("energy_stops", "J", "energy dissipated at the end stops"),
    Metric(
        "energy_residual",
        "-",
        "residual of the energy balance, relative to the energy exchanged",
    ),
    Metric("closure", "-", "scaled change of the state over one repetition of the orbit"),
)

UNITS = {metric.name: metric.unit for metric in METRICS}
"""Unit of every metric, by name."""

SHARE_METRICS = ("stuck_share", "chatter_share")
"""Metrics that are shares of the window, from 0 to 1."""

SIGNED_METRICS = (
    "x_r_max",
    "x_r_min",
    "energy_input",
    "energy_stored",
    "energy_friction",
    "energy_residual",
)
"""Metrics that may be negative: bristles and elastic contacts return energy."""

COMFORT_METRICS = ("a_w", "SEAT", "VDV", "SEAT_VDV", "MTVV", "crest_factor")
"""Metrics that need a frequency weighting."""

END_STOP_METRICS = (
    "contacts",
    "contacts_up",
    "contacts_down",
    "impact_speed",
    "stop_force_peak",
    "impulse_peak",
    "energy_stops",
)
"""Metrics that need end stops."""

STROKE_LIMIT_METRICS = (
    "stroke_used",
    "violations",
    "violations_up",
    "violations_down",
    "t_first_violation",
    "t_beyond",
    "limit_rate",
)
"""Metrics that need a stroke limit."""

SIDE_METRICS = (
    "x_r_max",
    "x_r_min",
    "violations_up",
    "violations_down",
    "contacts_up",
    "contacts_down",
)
"""Metrics of one side, in tables only where a scenario tells the sides of its stroke apart."""


def measure(
    trajectory: Trajectory,
    window: tuple[float, float],
    limits: StrokeLimits | None,
    closure: float | None = None,
    stationary: bool = False,
) -> Values:
    """Return every metric of `METRICS` by name; None where unknown.

    Weighted metrics need a grid and are None here; see `drysim.metrics.comfort`.

    Parameters
    ----------
    trajectory : Trajectory
        Solution, of a run or of a periodic orbit.
    window : tuple of float
        Begin and end of the window [s].
    limits : StrokeLimits or None
        Needed by the stroke metrics.
    closure : float or None
        Closure of a periodic orbit [-]; None for any other motion.
    stationary : bool
        Whether the motion may be assumed to continue as in the window, as for noise and
        records.
    """
    totals = trajectory.totals(*window)
    path = trajectory.path(window, limits)
    inside = path_in_window(trajectory, path, window)
    lowest, highest = float(inside.min()), float(inside.max())
    peak = max(abs(lowest), abs(highest))
    length = window[1] - window[0]
    values = mean_metrics(totals, length)
    values |= {"x_r_peak": peak, "x_r_max": highest, "x_r_min": lowest, "closure": closure}
    values["chatter_share"] = trajectory.chatter(*window)
    values["stroke_suffices"] = (
        peak_displacement(trajectory, path, (0.0, window[1])) if window[0] else peak
    )
    values |= stroke_statistics(inside, length, limits, stationary)
    ends = trajectory.state(window[0]), trajectory.state(window[1])
    bumper_energies = (
        bumper_energy(trajectory.law, ends[0]),
        bumper_energy(trajectory.law, ends[1]),
    )
    values |= energy_metrics(
        trajectory.plant, trajectory.law.F_fk, totals, *ends, bumper_energies
    )
    if trajectory.law.stops is not None:
        values |= impact_metrics(trajectory, window, repeats=closure is not None)
        values["energy_stops"] = totals.stop_work - (bumper_energies[1] - bumper_energies[0])
        hourly = values.get("stroke_once_an_hour")
        stops = trajectory.law.stops
        if stops.rigid and hourly is not None:  # rigid stops bound the stroke
            values["stroke_once_an_hour"] = min(hourly, max(stops.up, stops.down))
    if limits is not None:
        up, down, t_first, t_beyond = excursions(
            trajectory, path, limits, repeats=closure is not None
        )
        values |= {"violations": up + down, "violations_up": up, "violations_down": down}
        values |= {"t_first_violation": t_first, "t_beyond": t_beyond}
        values["stroke_used"] = float(limits.used(lowest, highest))
    return {metric.name: values.get(metric.name) for metric in METRICS}


def peak_displacement(trajectory: Trajectory, path: Path, window: tuple[float, float]) -> float:
    """Return the largest |x_r| in a window [m], at an extreme point or at an end."""
    begin, end = window
    inside = (path.t >= begin) & (path.t <= end)
    turning = np.abs(path.x_r[inside]).max(initial=0.0)
    return float(max(turning, abs(trajectory.state(begin).x_r), abs(trajectory.state(end).x_r)))


# RMS values and energies from integrals over a window, of one case or of columns of many.

ENERGY_FLOOR_SHARE = 1e-9
"""Share of force times displacement below which energies are rounding, which is about 1e-15."""

ENERGY_FLOOR = 1e-292
"""Energy [J] below which rounding falls under the smallest normal number."""


def mean_metrics(totals: Totals, length: Any) -> dict[str, Any]:
    """Return RMS values, their ratios and the stuck share from integrals over a window.

    Parameters
    ----------
    totals : Totals
        Numbers, or arrays of one shape.
    length : float or ndarray
        Length of the window [s].

    Returns
    -------
    dict
        Metrics by name, of the same type as the integrals; NaN (None for numbers) where
        unknown.
    """
    a_u = sqrt(totals.u_dd2 / length)
    # While the mass is stuck throughout, a_x equals a_u exactly, without rounding.
    a_x = where(totals.stuck >= length, a_u, sqrt(totals.x_dd2 / length))
    x_r = sqrt(totals.x2 / length)
    u = None if totals.u2 is None else sqrt(totals.u2 / length)
    return {
        "a_u": a_u,
        "a_x": a_x,
        "T_a": ratio(a_x, a_u),
        "T_x": ratio(x_r, u),
        "x_r_rms": x_r,
        "v_r_rms": sqrt(totals.v2 / length),
        "u_rms": u,
        "stuck_share": totals.stuck / length,
    }


def energy_metrics(
    plant: Plant,
    F_fk: Any,
    totals: Totals,
    first: AnyState,
    last: AnyState,
    bumpers: tuple[float, float] = (0.0, 0.0),
) -> dict[str, Any]:
    """Return the energy balance of a window and its residual.

    Parameters
    ----------
    plant : Plant
    F_fk : float or ndarray
        Kinetic friction force [N].
    totals : Totals
        Integrals over the window; numbers or arrays, as in `mean_metrics`.
    first, last : State
        At both ends of the window.
    bumpers : tuple of float
        Elastic energy of the end stops at both ends of the window [J].

    Returns
    -------
    dict
        Metrics by name: energies [J] and the residual [-].

    Notes
    -----
    Each term is integrated independently, so the residual certifies the solution. It is
    relative to the largest term or to m·RMS{ü}·RMS{v_r}·t, the energy that base and mass may
    exchange; and at least to the share `ENERGY_FLOOR_SHARE` of F_fk |x_r| and to
    `ENERGY_FLOOR`, so that rounding does not count where a contact rests away from the origin.
    """
    work = -plant.m * totals.power
    begin = mechanical_energy(plant, first) + bumpers[0]
    stored = mechanical_energy(plant, last) + bumpers[1] - begin
    stops = totals.stop_work - (bumpers[1] - bumpers[0])
    viscous, friction = totals.damper_work, totals.friction_work
    viscous = plant.b * totals.v2 if viscous is None else viscous
    friction = F_fk * totals.sliding_distance if friction is None else friction
    exchanged = plant.m * sqrt(totals.u_dd2 * totals.v2)
    least = ENERGY_FLOOR_SHARE * F_fk * maximum(abs(first.x_r), abs(last.x_r))
    scale = maximum(
        exchanged, abs(stored), viscous, friction, begin, abs(stops), least, ENERGY_FLOOR
    )
    return {
        "energy_input": work,
        "energy_stored": stored,
        "energy_viscous": viscous,
        "energy_friction": friction,
        "energy_residual": abs(work - stored - viscous - friction - stops) / scale,
    }


def mechanical_energy(plant: Plant, state: AnyState) -> Any:
    """Return the elastic and kinetic energy of a relative motion [J]."""
    v_r, x_r = state.v_r, state.x_r
    return 0.5 * (plant.m * (v_r * v_r) + plant.k_x * (x_r * x_r))


# Arithmetic on numbers or columns, where the two need different functions.


def sqrt(value: Any) -> Any:
    """Return the square root; numpy's is ten times slower for a single number."""
    return np.sqrt(value) if isinstance(value, np.ndarray) else math.sqrt(value)


def ratio(a: Any, b: Any) -> Any:
    """Return a/b; None, or NaN in a column, where b is 0 or unknown."""
    if not isinstance(b, np.ndarray):
        return a / b if b else None
    return np.divide(a, b, out=np.full(b.shape, np.nan), where=b != 0.0)


def where(which: Any, one: Any, other: Any) -> Any:
    """Return one of two values, by a condition."""
    if isinstance(which, np.ndarray):
        return np.where(which, one, other)
    return one if which else other


def maximum(*values: Any) -> Any:
    """Return the largest of several values."""
    if any(isinstance(value, np.ndarray) for value in values):
        return np.maximum.reduce(np.broadcast_arrays(*values))
    return max(values)
