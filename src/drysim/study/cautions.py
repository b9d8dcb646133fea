"""What a reader of the numbers of a case should know: warnings as values, found after it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from drysim.approach.numerics import FIXED_STEP
from drysim.core.plant import AnyLaw, Stopped
from drysim.errors import Caution
from drysim.wording import length, listed, number, times

if TYPE_CHECKING:
    from drysim.approach.orbit import Orbit
    from drysim.approach.response import Response
    from drysim.metrics import Metrics
    from drysim.study.case import Case

RESIDUAL = 1e-9
"""A balance that closes no better than this [-] is no certificate: rounding leaves 1e-12."""

INEXACT = 1e-3
"""A stated error beyond this share of the peak [-] shows in a picture: no longer exact."""

MOVED = 0.01
"""Share of a metric by which the ends of a record may move it before that is said [-]."""

RATED = ("a_u", "a_x", "T_a", "T_x", "x_r_rms", "x_r_peak", "v_r_rms", "a_w", "SEAT", "VDV")
"""The metrics that are held against the ends of a record by their relative change."""

CLOSE = 1e-6
"""A decision nearer than this [-] to its opposite is within what inputs are known to."""


def found(
    response: Response,
    metrics: Metrics,
    limit: float | None,
    late: bool = False,
    beside: float | None = None,
) -> Iterator[Caution]:
    """Give every warning that follows from a response and its metrics.

    Parameters
    ----------
    response : Response
    metrics : mapping
        Over the whole response where they concern the stroke.
    limit : float or None
        Stroke limit x_rM [m].
    late : bool, optional
        Whether the metrics of the stroke are of more than the window: of the settling, too.
    beside : float or None, optional
        Peak of |x_r| in the window [m], which gives lengths their unit; default: that of
        `metrics`.

    Yields
    ------
    Caution
    """
    if limit is not None and metrics["violations"]:
        yield stroke_violated(metrics, limit, response.law, late, beside)
    if isinstance(response.law, Stopped) and response.law.rigid and metrics["contacts"]:
        yield impacts_left_out()
    residual = metrics["energy_residual"]
    # Fixed steps leave an open balance by nature: a measure then, not an alarm.
    exact = response.numerics.core != FIXED_STEP
    if exact and residual is not None and not abs(residual) <= RESIDUAL:
        yield energy_open(residual)
    error = response.numerics.error
    if error is not None and not error <= INEXACT:
        yield inexact(error)
    closest = response.numerics.closest_decision
    if closest is not None and closest < CLOSE:
        yield close_decision(closest)


def stroke_violated(
    metrics: Metrics, limit: float, law: AnyLaw, late: bool, beside: float | None = None
) -> Caution:
    """Say where the stroke limit was met, and by how much or how hard."""
    t_first, peak = metrics["t_first_violation"] or 0.0, metrics["x_r_peak"] or 0.0
    beside = beside or peak
    if isinstance(law, Stopped):
        sentence = (
            f"the mass comes to its end stops, first at t = {number(t_first, 's')} and with up "
            f"to {number(metrics['impact_speed'], 'm/s')}"
        )
    else:
        sentence = (
            f"the stroke limit of {length(limit, beside)} is met "
            f"{times(metrics['violations'])}, first at t = {number(t_first, 's')}; |x_r| "
            f"reaches {length(peak, beside)}, {length(peak - limit, beside)} too far"
        )
    numbers = {"limit": limit, "x_r_peak": peak, "t_first_violation": t_first}
    return Caution("stroke-violated", sentence + ", settling included" * late, numbers)


def impacts_left_out() -> Caution:
    """Say that an impact has no finite acceleration."""
    sentence = (
        "an impact on a rigid stop is an instant of infinite force: a_x and T_a are of the "
        "motion between impacts; bumpers give them a force and a length"
    )
    return Caution("impacts-left-out", sentence)


def energy_open(residual: float) -> Caution:
    """Say that the energy balance does not close."""
    sentence = (
        f"the energy balance closes to {residual:.1e} only, not to {RESIDUAL:.0e}: "
        "trust no digit beyond it, and please report the scenario"
    )
    return Caution("energy-open", sentence, {"energy_residual": residual})


def inexact(error: float) -> Caution:
    """Say that the stated error of x_r is no small one."""
    sentence = (
        f"x_r may be off by {number(100.0 * error, '%', digits=2)} of its peak: a coarser "
        "solution is that far away, or the orbit is not closed any better; a smaller "
        "`friction.tolerance` tells whether the motion itself makes small errors large"
    )
    return Caution("inexact", sentence, {"error": error})


def close_decision(closest: float) -> Caution:
    """Say that the answer hinges on the last digits of the input."""
    sentence = (
        f"a stop or the start was decided by a relative margin of {closest:.1e} between |F_L| "
        "and F_fs: an input changed by 1e-6 may change the answer; vary friction.static a "
        "little to see"
    )
    return Caution("close-decision", sentence, {"closest_decision": closest})


def orbit_doubtful(orbit: Orbit, case: Case) -> Iterator[Caution]:
    """Say when a periodic orbit was not reached, or not without meeting the stroke limit."""
    if not orbit.settled:
        walks = "" if case.plant.k_x else "without a spring it may walk on for ever; "
        sentence = (
            f"the motion has not settled after {number(orbit.run_up, 's')}: it still changes "
            f"by {number(orbit.closure)} a repetition; {walks}measure it with `steady: false`, "
            "a `settle` and a `duration` instead"
        )
        numbers = {"closure": orbit.closure, "run_up": orbit.run_up}
        yield Caution("not-settled", sentence, numbers)
    if not orbit.unique:
        sentence = (
            "the periodic orbit is one of a continuum: next to nothing draws its neighbours to "
            "it, and they close, too; it is the one that this start leads to"
        )
        yield Caution("not-unique", sentence)
    limit = case.limit
    if limit is not None and orbit.run_up_peak >= limit:
        way, end = "on the way to the periodic orbit", " before the motion settles"
        if not orbit.settled:
            way, end = "in that time", ""
        sentence = (
            f"{way} |x_r| reaches {length(orbit.run_up_peak)}: "
            f"the stroke limit of {length(limit, orbit.run_up_peak)} is met{end}"
        )
        numbers = {"limit": limit, "run_up_peak": orbit.run_up_peak}
        yield Caution("stroke-violated-settling", sentence, numbers)


def moves(metrics: Metrics, others: Metrics) -> dict[str, float]:
    """Return by how much metrics differ from others, those beyond a hundredth, by name [-].

    Of the share of time that the mass is stuck, the difference counts as it is.
    """
    found = {}
    for name in (*RATED, "stuck_share"):
        value, other = metrics.get(name), others.get(name)
        if value is None or other is None:
            continue
        scale = abs(value) or abs(other) or 1.0
        found[name] = (other - value) / (1.0 if name == "stuck_share" else scale)
    return {name: share for name, share in found.items() if abs(share) > MOVED}


def ends_decide(moved: Mapping[str, float], below: float) -> Caution:
    """Say that metrics depend on what a high-pass does at the ends of a record."""
    told = listed(
        [f"{name} by {number(100.0 * share, '%', digits=2)}" for name, share in moved.items()]
    )
    sentence = (
        f"the ends of the high-pass at {number(below, 'Hz')} decide: mirrored about their last "
        f"sample they move {told}; leave out the first and the last "
        f"{number(1.0 / below, 's', digits=3)} of the record by `excitation.window`, or take a "
        "longer record"
    )
    return Caution("record-ends", sentence, moved)
