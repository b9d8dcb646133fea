"""Table of metrics: name, unit, meaning and formula of each, for one case or columns of cases.

A metric is one row of `METRICS`; its formula takes a `Measured`, the quantities that all
metrics follow from. `measure` computes these from the continuous solution of a case; the orbits
of a sweep give them as columns. What needs the path of the motion is in `stroke`, what needs a
grid in `comfort` and `spectra`, and the checks of a scenario are in `checks`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np

from drysim.approach.solution import Trajectory
from drysim.core.model import (
    ATTRACTING_MODULUS,
    NO_LIMITS,
    Floats,
    Plant,
    State,
    StrokeLimits,
    Totals,
)
from drysim.metrics.comfort import DAY_OF_WORK, Weighted, weighted_samples
from drysim.metrics.energy import bumper_energy, contact_energy, mechanical_energy
from drysim.metrics.stroke import (
    MIN_HALF_CYCLES,
    Excursions,
    StopLoads,
    excursions,
    hourly_stroke,
    impacts,
    path_measures,
)
from drysim.wording import format_unit, typeset

Metrics = Mapping[str, float | int | None]
"""Values by name, None where unknown; read-only."""

Values = dict[str, float | int | None]
"""Metrics by name; None where unknown."""

ENERGY_FLOOR_SHARE = 1e-9
"""Share of force times displacement below which energies are rounding, which is about 1e-15."""

ENERGY_FLOOR = 1e-292
"""Energy [J] below which rounding falls under the smallest normal number."""


@dataclass(frozen=True)
class Measured:
    """What the metrics of a motion follow from: numbers, or columns of those of many cases."""

    plant: Plant
    F_fk: Any
    """Kinetic friction force [N]."""
    length: Any
    """Length of the window [s]."""
    totals: Totals
    """Integrals over the window."""
    begin: State
    end: State
    """At both ends of the window."""
    lowest: Any
    highest: Any
    """Extremes of x_r in the window and the ring-down after it [m], or 0 where x_r stays on
    the other side."""
    run_lowest: Any
    run_highest: Any
    """The same from the start to the end of the run, settling and ring-down included [m]."""
    upcrossings: Any
    """Number of upward zero crossings of x_r in the window."""
    chatter: Any
    """Share of the window with two sign changes of v_r within four steps [-]."""
    closure: Any
    """Closure of a periodic orbit [-]; None for any other motion."""
    x_dd_peak: float | None = None
    """Largest |x_dd| in the window [m/s²]; None where unknown."""
    hourly: float | None = None
    """Stroke exceeded once an hour, extrapolated [m]; None where unknown."""
    hourly_by_side: tuple[float | None, float | None] = (None, None)
    """The same of x_r > 0 and of x_r < 0 alone."""
    limits: StrokeLimits | None = None
    limit_entries: Any = 0
    """How often x_r reaches a limit in the window."""
    excursions: Excursions | None = None
    """To the limits, from the start to the end of the run."""
    impacts: StopLoads | None = None
    """On the end stops in the window and the ring-down."""
    bumper_energies: tuple[float, float] = (0.0, 0.0)
    """Elastic energy of the end stops at both ends of the window [J]."""
    contact_energies: tuple[float, float] = (0.0, 0.0)
    """Energy stored in the friction contact at both ends of the window [J]."""
    jacobian: tuple[Any, Any] | None = None
    """Trace and determinant of the Jacobian of a periodic orbit, the derivative of the state
    after a repetition by the state before it; None where unknown."""
    weighted: Weighted | None = None
    """Frequency-weighted accelerations."""
    settings: Any = None
    """The measure block of the scenario."""

    @property
    def exposure(self) -> float | None:
        """Duration of exposure a day [s], if it is stated."""
        return getattr(self.settings, "exposure", None)

    @cached_property
    def a_u(self) -> Any:
        """RMS acceleration of the base [m/s²]."""
        return sqrt(self.totals.u_dd2 / self.length)

    @cached_property
    def a_x(self) -> Any:
        """RMS acceleration of the mass [m/s²]: of a stuck mass exactly that of the base."""
        stuck = self.totals.stuck >= self.length
        return where(stuck, self.a_u, sqrt(self.totals.x_dd2 / self.length))

    @cached_property
    def x_r(self) -> Any:
        """RMS relative displacement [m]."""
        return sqrt(self.totals.x2 / self.length)

    @cached_property
    def u(self) -> Any:
        """RMS displacement of the base [m]; None where it is not known."""
        return None if self.totals.u2 is None else sqrt(self.totals.u2 / self.length)

    @cached_property
    def peak(self) -> Any:
        """Largest |x_r| in the window and the ring-down [m]."""
        return maximum(abs(self.lowest), abs(self.highest))

    @cached_property
    def reached(self) -> Any:
        """Largest |x_r| of the run [m]."""
        return maximum(abs(self.run_lowest), abs(self.run_highest))

    @cached_property
    def work(self) -> Any:
        """Work of the base on the relative motion [J]."""
        return -self.plant.m * self.totals.power

    @cached_property
    def energies(self) -> tuple[Any, Any]:
        """Kinetic and elastic energy at both ends of the window [J]."""
        begin, end = (
            mechanical_energy(self.plant, state) + bumper + contact
            for state, bumper, contact in zip(
                (self.begin, self.end), self.bumper_energies, self.contact_energies, strict=True
            )
        )
        return begin, end

    @cached_property
    def stored(self) -> Any:
        """Change of kinetic and elastic energy [J]."""
        return self.energies[1] - self.energies[0]

    @cached_property
    def multipliers(self) -> tuple[Any, Any]:
        """Floquet multipliers of a periodic orbit, the larger modulus first.

        They are the eigenvalues of the Jacobian. A mass that sticks forgets its velocity, so
        that one of them is zero; what rounding leaves of it, and its sign, are not reported.
        """
        trace, determinant = (np.asarray(value, complex) for value in self.jacobian or ())
        root = np.sqrt(0.25 * trace * trace - determinant)
        # The sum without cancellation, and the other one by the product of both.
        first = 0.5 * trace + np.where(trace.real >= 0.0, root, -root)
        with np.errstate(invalid="ignore", divide="ignore"):
            second = np.where(first == 0.0, 0.0, determinant / first)
        return first, np.where(np.abs(second) < ZERO_MULTIPLIER, 0.0, second)

    @cached_property
    def stable(self) -> Any:
        """1 where disturbances of a periodic orbit die out or the mass stays stuck, else 0."""
        modulus = np.abs(self.multipliers[0])
        stuck = np.asarray(self.totals.stuck) >= self.length
        stable = stuck | (modulus < ATTRACTING_MODULUS)
        return plain(np.where(np.isnan(modulus), np.nan, stable))

    @cached_property
    def friction_loss(self) -> Any:
        """Energy dissipated in the contact [J]."""
        loss = self.totals.friction_loss
        return self.F_fk * self.totals.sliding_distance if loss is None else loss

    @cached_property
    def viscous_loss(self) -> Any:
        """Energy dissipated in the damper [J]."""
        work = self.totals.damper_work
        return self.plant.b * self.totals.v2 if work is None else work

    @cached_property
    def stop_loss(self) -> Any:
        """Energy dissipated at the end stops [J]."""
        begin, end = self.bumper_energies
        return self.totals.stop_work - (end - begin)

    @cached_property
    def energy_residual(self) -> Any:
        """Residual of the energy balance, relative to the energy exchanged [-].

        Notes
        -----
        Each term is integrated by itself, the dissipated energies from the forces that the law
        demands of the motion: friction takes its limit times |v_r|. A motion that turns or
        slides against the law leaves a residual of the size of the energy in question. A force
        beyond its limit at rest does no work; `Totals.violation` has it.

        The residual is relative to the largest term or to m·RMS{ü}·RMS{v_r}·t, the energy that
        base and mass may exchange; and at least to the share `ENERGY_FLOOR_SHARE` of F_fk |x_r|
        and to `ENERGY_FLOOR`, so that rounding does not count where a contact rests away from
        the origin.
        """
        totals, viscous, friction = self.totals, self.viscous_loss, self.friction_loss
        exchanged = self.plant.m * sqrt(totals.u_dd2 * totals.v2)
        farthest = maximum(abs(self.begin.x_r), abs(self.end.x_r))
        least = ENERGY_FLOOR_SHARE * self.F_fk * farthest
        scale = maximum(
            exchanged, abs(self.stored), viscous, friction, self.energies[0],
            abs(self.stop_loss), least, ENERGY_FLOOR,
        )  # fmt: skip
        return abs(self.work - self.stored - viscous - friction - self.stop_loss) / scale


SHARE, SIGNED, COUNT = "share", "signed", "count"
"""Kinds of metrics: a share of the window from 0 to 1, a number of either sign, a count. Others
are at least 0."""


class Need(NamedTuple):
    """What some metrics need: an attribute of `Measured` that other motions do not have."""

    attribute: str
    name: str
    """Name in messages."""
    keys: tuple[str, ...]
    """Scenario keys one of which asks for it."""


LIMITS = Need("limits", "a stroke limit", ("stroke.limit",))
STOPS = Need("impacts", "end stops", ("stroke.stops",))
ORBIT = Need("jacobian", "a steady state in closed form", ("measure.steady",))
WEIGHTING = Need("weighted", "a weighting", ("measure.direction", "measure.weighting"))
EXPOSURE = Need("exposure", "an exposure a day", ("measure.exposure",))
NEEDS = LIMITS, STOPS, ORBIT, WEIGHTING, EXPOSURE

PEAK_STROKE = "x_r_peak"
"""Metric that is the stroke."""

STROKE_USED = "stroke_used"
"""Metric by which the stroke limit is judged."""

HOURLY_STROKE = "stroke_once_an_hour"
"""Metric by which it is judged beyond the time that was computed."""

HOURLY_STROKES_BY_SIDE = "stroke_once_an_hour_up", "stroke_once_an_hour_down"
"""Metrics by which unequal limits are."""

STATIONARY = f"noise and records with at least {MIN_HALF_CYCLES} half cycles of x_r"
"""Motions that are assumed to go on as in the window."""

ZERO_MULTIPLIER = 1e-13
"""Modulus of the smaller Floquet multiplier that is rounding: those of orbits without sticking
are larger by many orders of magnitude."""


class Metric(NamedTuple):
    """One metric."""

    name: str
    """Name in checks and tables."""
    unit: str
    """SI unit."""
    about: str
    """Meaning."""
    formula: Callable[[Any], Any]
    """Returns the value of a `Measured`; None, or NaN in a column, where it is not known."""
    needs: tuple[Need, ...] = ()
    """What the metric is not known without."""
    kind: str = ""
    """SHARE, SIGNED, COUNT, or ""."""
    short_label: str = ""
    """Label, if it is not the name."""
    by_side: bool = False
    """Whether the metric is of one side of the stroke; tables have it only where the sides are
    told apart."""
    in_tables: bool = False
    """Whether it is in every table of cases; others are there if the scenario asks for them."""
    with_interval: bool = False
    """Whether tables also have its confidence interval, where it is a mean over seeds."""
    with_quantiles: bool = False
    """Whether its quantiles over the cases are in drysim.json."""
    known_for: str = ""
    """Motions for which it is known, if these are few; completes "known for ... only"."""

    @property
    def label(self) -> str:
        """Label in summaries and headings, e.g. `peak |x_r|`."""
        return self.short_label or self.name

    @property
    def symbol(self) -> str:
        """Label in pictures, with lowered indices."""
        return typeset(self.label)

    @property
    def shown(self) -> str:
        """Unit in text and pictures, for `wording.display_unit`; empty for a plain number."""
        return "%" if self.kind == SHARE else format_unit(self.unit)


METRICS = (
    Metric("a_u", "m/s2", "RMS acceleration of the base", lambda m: m.a_u, in_tables=True),
    Metric("a_x", "m/s2", "RMS acceleration of the mass",
           lambda m: m.a_x, in_tables=True, with_interval=True),
    Metric("T_a", "-", "acceleration transmissibility a_x/a_u",
           lambda m: ratio(m.a_x, m.a_u), in_tables=True, with_interval=True,
           with_quantiles=True),
    Metric("T_x", "-", "relative displacement transmissibility RMS{x_r}/RMS{u}",
           lambda m: ratio(m.x_r, m.u), in_tables=True, with_interval=True,
           with_quantiles=True),
    Metric("x_r_rms", "m", "RMS relative displacement, mean included",
           lambda m: m.x_r, in_tables=True, with_interval=True),
    Metric(PEAK_STROKE, "m", "stroke: largest |x_r| in the window and its ring-down",
           lambda m: m.peak, short_label="peak |x_r|", in_tables=True, with_interval=True,
           with_quantiles=True),
    Metric("x_r_max", "m", "largest x_r in the window and its ring-down, at least 0",
           lambda m: m.highest, kind=SIGNED, by_side=True),
    Metric("x_r_min", "m", "smallest x_r in the window and its ring-down, at most 0",
           lambda m: m.lowest, kind=SIGNED, by_side=True),
    Metric("x_dd_peak", "m/s2", "largest |ẍ| of the mass in the window and its ring-down, "
           "between the grid points too, both sides of a jump included, rigid impacts not (a "
           "fixed-step approach knows its grid points only); for base motion in samples and "
           "a constant normal force, not under stribeck, dahl, lugre and leuven",
           lambda m: m.x_dd_peak, short_label="peak |ẍ|"),
    Metric("v_r_rms", "m/s", "RMS relative velocity", lambda m: sqrt(m.totals.v2 / m.length)),
    Metric("u_rms", "m", "RMS displacement of the base, where it is known", lambda m: m.u),
    Metric(STROKE_USED, "-", "largest |x_r| over the stroke limit, settling included; of "
           "unequal limits the larger share",
           lambda m: maximum(
               m.run_highest / m.limits.up, abs(m.run_lowest) / m.limits.down
           ),
           (LIMITS,), in_tables=True),
    Metric("stuck_share", "-", "share of the window in which the mass is at rest relative to "
           "the base, stuck by dry friction or pressed against a rigid stop",
           lambda m: m.totals.stuck / m.length, kind=SHARE, short_label="stuck",
           in_tables=True, with_interval=True, with_quantiles=True),
    Metric("chatter_share", "-", "share of the window with two sign changes of v_r within "
           "four steps",
           lambda m: m.chatter, kind=SHARE, short_label="chatter", in_tables=True),
    Metric("violations", "-", "how often |x_r| reaches the stroke limit, settling included",
           lambda m: m.excursions.up + m.excursions.down, (LIMITS,), COUNT, in_tables=True),
    Metric("violations_up", "-", "how often x_r reaches the upper limit, settling included",
           lambda m: m.excursions.up, (LIMITS,), COUNT, by_side=True),
    Metric("violations_down", "-", "how often x_r reaches the lower limit, settling included",
           lambda m: m.excursions.down, (LIMITS,), COUNT, by_side=True),
    Metric("t_first_violation", "s", "time of the first violation",
           lambda m: m.excursions.t_first, (LIMITS,)),
    Metric("t_beyond", "s", "time spent at or beyond the stroke limit, settling included",
           lambda m: m.excursions.t_beyond, (LIMITS,)),
    Metric("crossing_rate", "1/s", "up-crossings of x_r = 0 per second",
           lambda m: m.upcrossings / m.length),
    Metric("limit_rate", "1/s", "how often |x_r| reaches the stroke limit, per second",
           lambda m: m.limit_entries / m.length, (LIMITS,)),
    Metric("stroke_suffices", "m", "stroke needed for this motion: largest |x_r|, settling "
           "and ring-down included",
           lambda m: m.reached),
    Metric(HOURLY_STROKE, "m", "stroke exceeded once an hour if noise or record "
           "continues as in the window: extrapolated from the tail of its peaks (Weibull, "
           "exponent 2), at least the largest peak of less than an hour, at most the "
           "position of rigid stops; unknown below 150 half cycles",
           lambda m: m.hourly, short_label="hourly peak", known_for=STATIONARY),
    Metric(HOURLY_STROKES_BY_SIDE[0], "m", "x_r exceeded once an hour, extrapolated as "
           "stroke_once_an_hour from the peaks of this side",
           lambda m: m.hourly_by_side[0], by_side=True, known_for=STATIONARY),
    Metric(HOURLY_STROKES_BY_SIDE[1], "m", "-x_r exceeded once an hour, extrapolated as "
           "stroke_once_an_hour from the peaks of this side",
           lambda m: m.hourly_by_side[1], by_side=True, known_for=STATIONARY),
    Metric("contacts", "-", "contacts with an end stop in the window",
           lambda m: m.impacts.up + m.impacts.down, (STOPS,), COUNT),
    Metric("contacts_up", "-", "contacts with the upper end stop in the window",
           lambda m: m.impacts.up, (STOPS,), COUNT, by_side=True),
    Metric("contacts_down", "-", "contacts with the lower end stop in the window",
           lambda m: m.impacts.down, (STOPS,), COUNT, by_side=True),
    Metric("impact_speed", "m/s", "largest |v_r| at a contact in the window",
           lambda m: m.impacts.speed, (STOPS,), short_label="impact speed"),
    Metric("stop_force_peak", "N", "largest force between mass and bumper",
           lambda m: m.impacts.force, (STOPS,), short_label="peak force"),
    Metric("impulse_peak", "N·s", "largest impulse of an impact on a rigid stop",
           lambda m: m.impacts.impulse, (STOPS,)),
    Metric("a_w", "m/s2", "weighted RMS acceleration of the mass, ISO 2631-1, times k",
           lambda m: m.weighted.a_w, (WEIGHTING,), with_quantiles=True),
    Metric("SEAT", "-", "seat effective amplitude transmissibility: a_w of the mass over "
           "that of the base",
           lambda m: ratio(m.weighted.a_w, m.weighted.base_a_w), (WEIGHTING,),
           with_quantiles=True),
    Metric("VDV", "m/s^1.75", "vibration dose of the mass over the window, (∫ a_w⁴ dt)^(1/4)",
           lambda m: m.weighted.dose, (WEIGHTING,)),
    Metric("SEAT_VDV", "-", "VDV of the mass over that of the base",
           lambda m: ratio(m.weighted.dose, m.weighted.base_dose), (WEIGHTING,)),
    Metric("MTVV", "m/s2", "largest running RMS of a_w, linear over 1 s",
           lambda m: m.weighted.running, (WEIGHTING,)),
    Metric("crest_factor", "-", "largest |a_w| over its RMS, of the mass",
           lambda m: ratio(m.weighted.peak, m.weighted.a_w), (WEIGHTING,),
           short_label="crest factor"),
    Metric("A_8", "m/s2", "daily exposure A(8): a_w √(exposure/8 h), with the exposure a day "
           "that is stated",
           lambda m: m.weighted.a_w * sqrt(m.exposure / DAY_OF_WORK), (WEIGHTING, EXPOSURE)),
    Metric("VDV_day", "m/s^1.75", "daily vibration dose: VDV (exposure/window)^(1/4), with the "
           "exposure a day that is stated",
           lambda m: m.weighted.dose * (m.exposure / m.length) ** 0.25, (WEIGHTING, EXPOSURE),
           short_label="daily VDV"),
    Metric("energy_input", "J", "work of the base on the relative motion in the window",
           lambda m: m.work, kind=SIGNED),
    Metric("energy_stored", "J", "change of kinetic and elastic energy: of mass, spring and "
           "bumpers, and of the springs or bristles of the friction contact",
           lambda m: m.stored, kind=SIGNED),
    # lugre and leuven with a small σ_2 are not passive, and fixed steps are no solution
    Metric("energy_friction", "J", "energy dissipated in the dry-friction contact, without "
           "what its springs or bristles store",
           lambda m: m.friction_loss, kind=SIGNED),
    Metric("energy_viscous", "J", "energy dissipated in the damper", lambda m: m.viscous_loss),
    Metric("energy_stops", "J", "energy dissipated at the end stops",
           lambda m: m.stop_loss, (STOPS,)),
    Metric("energy_residual", "-", "residual of the energy balance, relative to the energy "
           "exchanged; friction and stops take what their law demands of the motion",
           lambda m: m.energy_residual, kind=SIGNED),
    Metric("law_residual", "-", "largest violation of the laws of friction and stops that "
           "does no work, relative to the forces: friction beyond its limit at rest, or a slip "
           "that begins below it; an elastic contact beyond its limit; a rigid stop that pulls "
           "or is penetrated; unknown for a fixed-step approach",
           lambda m: m.totals.violation),
    Metric("closure", "-", "scaled change of the state over one repetition of the orbit; no "
           "error: beside a multiplier near 1 the motion is much farther from the orbit",
           lambda m: m.closure, in_tables=True),
    Metric("multiplier_1", "-", "modulus of the larger Floquet multiplier: a disturbance of "
           "the orbit becomes as many times larger per repetition",
           lambda m: plain(np.abs(m.multipliers[0])), (ORBIT,)),
    Metric("multiplier_1_phase", "rad", "phase of the larger Floquet multiplier",
           lambda m: plain(np.angle(m.multipliers[0])), (ORBIT,), SIGNED),
    Metric("multiplier_2", "-", "modulus of the smaller Floquet multiplier",
           lambda m: plain(np.abs(m.multipliers[1])), (ORBIT,)),
    Metric("multiplier_2_phase", "rad", "phase of the smaller Floquet multiplier",
           lambda m: plain(np.angle(m.multipliers[1])), (ORBIT,), SIGNED),
    Metric("stable", "-", "1 if disturbances of the orbit die out or the mass stays stuck, "
           "else 0",
           lambda m: m.stable, (ORBIT,), COUNT),
)  # fmt: skip

FIT_METRICS = (
    Metric(
        "fit_error",
        "-",
        "RMS of measured minus fitted response, relative to the measured one",
        lambda m: None,
    ),
    Metric(
        "fit_error_held_out",
        "-",
        "fit_error on the part of the record that was held out",
        lambda m: None,
    ),
)
"""Metrics of a fit, which follow from no single motion."""

FIT_NAMES = frozenset(metric.name for metric in FIT_METRICS)
"""Metrics that only a fit has."""

METRICS_BY_NAME = {metric.name: metric for metric in (*METRICS, *FIT_METRICS)}

UNITS = {name: metric.unit for name, metric in METRICS_BY_NAME.items()}
"""Unit of every metric, by name."""


def evaluate(measured: Measured) -> dict[str, Any]:
    """Return every metric by name, as a number of Python or a column; None where unknown."""
    absent = tuple(need for need in NEEDS if getattr(measured, need.attribute) is None)
    values = {name: formula and formula(measured) for name, formula in formulas_without(absent)}
    return {
        name: value.item() if isinstance(value, np.generic) else value
        for name, value in values.items()
    }


OF_ACCELERATIONS = ("a_u", "a_x", "T_a", "x_dd_peak")
OF_STROKE = ("x_r_rms", PEAK_STROKE, "x_r_max", "x_r_min", STROKE_USED, "stroke_suffices")
"""Metrics of measured samples besides the weighted ones: of acceleration and of stroke."""

ABOUT_SAMPLES = {
    PEAK_STROKE: "stroke: largest |x_r| of the samples in the window",
    "x_r_max": "largest x_r of the samples in the window, at least 0",
    "x_r_min": "smallest x_r of the samples in the window, at most 0",
    "x_dd_peak": "largest |ẍ| of the samples of the mass in the window",
}
"""What metrics mean of measured samples where that differs from a computed motion."""


def evaluate_samples(
    x_dd: Floats,
    u_dd: Floats | None,
    x_r: Floats | None,
    dt: float,
    part: slice,
    limits: StrokeLimits | None = None,
    settings: Any = None,
) -> Values:
    """Return every metric of measured samples by name; None where unknown.

    Parameters
    ----------
    x_dd, u_dd, x_r : ndarray, shape (n,)
        Samples of mass and base [m/s²] and of the stroke [m], None where not measured.
    dt : float
        Step [s].
    part : slice
        Samples of the window.
    limits : StrokeLimits or None
    settings : Measure, optional
        The measure block of the scenario.
    """
    weights = settings and settings.weights
    weighted = weights and weighted_samples(x_dd, u_dd, dt, part, *weights)
    base, stroke = (np.zeros(1) if s is None else s[part] for s in (u_dd, x_r))
    whole, mass = np.zeros(1) if x_r is None else x_r, x_dd[part]
    length, rest = len(mass) * dt, State(0.0, 0.0)
    squares = [float(np.mean(np.square(s))) * length for s in (stroke, mass, base)]
    measured = Measured(
        Plant(1.0, 0.0, 0.0), 0.0, length,
        Totals(squares[0], 0.0, squares[1], 0.0, 0.0, 0.0, squares[2], None),
        rest, rest,
        lowest=min(float(stroke.min()), 0.0), highest=max(float(stroke.max()), 0.0),
        run_lowest=min(float(whole.min()), 0.0), run_highest=max(float(whole.max()), 0.0),
        upcrossings=0, chatter=0.0, closure=None, x_dd_peak=float(np.abs(mass).max()),
        limits=limits, weighted=weighted, settings=settings,
    )  # fmt: skip
    names = {*OF_ACCELERATIONS, *(OF_STROKE if x_r is not None else ())}
    names -= {"a_u", "T_a"} if u_dd is None else set()
    return {
        metric.name: metric.formula(measured)
        if (metric.name in names or WEIGHTING in metric.needs)
        and all(getattr(measured, need.attribute) is not None for need in metric.needs)
        else None
        for metric in METRICS
    }


@cache
def formulas_without(absent: tuple[Need, ...]) -> list[tuple[str, Callable[[Any], Any] | None]]:
    """Return name and formula of every metric, None for those that need what is absent."""
    return [
        (metric.name, None if set(absent) & set(metric.needs) else metric.formula)
        for metric in METRICS
    ]


SHARED = "plant", "F_fk", "length", "limits", "settings"
"""Attributes of `Measured` that all seeds of a case have in common."""


def stack(seeds: Sequence[Measured]) -> Measured:
    """Return what was measured of several seeds of a case as columns, NaN where unknown."""
    every = {
        field.name: [getattr(seed, field.name) for seed in seeds] for field in fields(Measured)
    }
    return Measured(
        **{name: each[0] if name in SHARED else column(each) for name, each in every.items()}
    )


def column(values: Sequence[Any]) -> Any:
    """Return values as a column, tuples as a tuple of columns, and None if all are None."""
    first = next((value for value in values if value is not None), None)
    if isinstance(first, tuple):
        columns = map(column, zip(*values, strict=True))
        return type(first)(*columns) if hasattr(first, "_fields") else tuple(columns)
    return None if first is None else np.array(values, dtype=float)


def measure(
    trajectory: Trajectory,
    window: tuple[float, float],
    limits: StrokeLimits | None,
    closure: float | None = None,
    run_end: float | None = None,
) -> Values:
    """Return every metric of a case by name, None where unknown; parameters as in `observe`."""
    return evaluate(observe(trajectory, window, limits, closure, run_end=run_end))


def observe(
    trajectory: Trajectory,
    window: tuple[float, float],
    limits: StrokeLimits | None,
    closure: float | None = None,
    stationary: bool = False,
    weighted: Weighted | None = None,
    settings: Any = None,
    run_end: float | None = None,
) -> Measured:
    """Return what the metrics of a case follow from.

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
    weighted : Weighted or None
        Needed by the frequency-weighted metrics.
    settings : Measure, optional
        The measure block of the scenario.
    run_end : float, optional
        End of the run [s], up to which peaks, violations and contacts count; default: the end
        of the window.
    """
    (begin, end), law, repeats = window, trajectory.law, closure is not None
    last = end if run_end is None else run_end
    path, peaks = path_measures(trajectory, (begin, end, last), limits or NO_LIMITS)
    hourly: float | None = None
    by_side: list[float | None] = [None, None]
    if stationary:
        hourly = hourly_stroke(np.abs(peaks), end - begin)
        if hourly is not None:
            heights = peaks[peaks > 0.0], -peaks[peaks < 0.0]
            by_side = [hourly_stroke(one_side, end - begin, 1) for one_side in heights]
    states = trajectory.state(begin), trajectory.state(end)
    totals = trajectory.totals(begin, end)
    x_dd_peak = totals.x_dd_peak
    if x_dd_peak is not None and last > end:
        x_dd_peak = max(x_dd_peak, trajectory.totals(end, last).x_dd_peak or 0.0)
    stops = law.stops
    if hourly is not None and stops is not None and stops.rigid:  # these bound the stroke
        hourly = min(hourly, max(stops.limits))
        by_side = [
            stroke and min(stroke, limit)
            for stroke, limit in zip(by_side, stops.limits, strict=True)
        ]
    return Measured(
        trajectory.plant,
        law.F_fk,
        end - begin,
        totals,
        State(*states[0][:2]),
        State(*states[1][:2]),
        lowest=min(path.lowest, 0.0),
        highest=max(path.highest, 0.0),
        run_lowest=min(path.run_lowest, 0.0),
        run_highest=max(path.run_highest, 0.0),
        upcrossings=path.upcrossings,
        chatter=trajectory.chatter(begin, end),
        closure=closure,
        x_dd_peak=x_dd_peak,
        hourly=hourly,
        hourly_by_side=(by_side[0], by_side[1]),
        limits=limits,
        limit_entries=path.entries,
        excursions=excursions(trajectory, limits, repeats) if limits else None,
        impacts=impacts(trajectory, (begin, last), repeats) if stops else None,
        bumper_energies=(bumper_energy(law, states[0]), bumper_energy(law, states[1])),
        contact_energies=(contact_energy(law, states[0]), contact_energy(law, states[1])),
        jacobian=trajectory.jacobian() if repeats else None,
        weighted=weighted,
        settings=settings,
    )


# Arithmetic on numbers or columns, where the two need different functions.


def plain(value: Any) -> Any:
    """Return a float for an array without dimensions."""
    return float(value) if np.ndim(value) == 0 else np.asarray(value, float)


def sqrt(value: Any) -> Any:
    """Return the square root; numpy's is ten times slower for a single number."""
    return np.sqrt(value) if isinstance(value, np.ndarray) else math.sqrt(value)


def ratio(a: Any, b: Any) -> Any:
    """Return a/b; None, or NaN in a column, where b is 0 or unknown."""
    if not isinstance(b, np.ndarray):
        return a / b if b else None
    return np.divide(a, b, out=np.full(b.shape, np.nan), where=b != 0.0)


def where(which: Any, first: Any, second: Any) -> Any:
    """Return one of two values, by a condition."""
    if isinstance(which, np.ndarray):
        return np.where(which, first, second)
    return first if which else second


def maximum(*values: Any) -> Any:
    """Return the largest of several values."""
    if any(isinstance(value, np.ndarray) for value in values):
        return np.maximum.reduce(np.broadcast_arrays(*values))
    return max(values)
