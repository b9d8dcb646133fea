"""What a reader of the numbers should know: warnings as values, found after the work.

They are about a case (its response, its orbit, the ends of its record), about the many cases
of a table, or about the many seeds of an ensemble. What is known before any work is said by
`scenario.warnings` and `study.case`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import ceil

from drysim.approach.solution import FIXED_STEP, Orbit, Response
from drysim.core.model import AnyLaw, Stopped
from drysim.errors import Caution
from drysim.metrics.checks import Verdict
from drysim.metrics.table import Metrics
from drysim.scenario.axes import Axis
from drysim.scenario.model import Scenario
from drysim.study.case import Case
from drysim.study.outcome import Outcome
from drysim.study.statistics import (
    FAILED,
    LIMIT,
    Row,
    Statistic,
    most,
    narrow,
    until_of,
    width_of,
)
from drysim.study.table import Count, Seeds, Tally, stroke_limit
from drysim.wording import length, listed, number, place, several, times

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


# Of one case.


def found(
    response: Response,
    metrics: Metrics,
    limit: float | None,
    late: bool = False,
    beside: float | None = None,
) -> Iterator[Caution]:
    """Give every warning that follows from a response, its metrics and the stroke limit [m].

    Where the stroke is concerned the metrics are those of the whole response, `late` when this
    is more than the window: the settling, too. The peak of |x_r| in the window [m], `beside`,
    gives lengths their unit; default: that of the metrics.
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
        sentence = (
            f"x_r may be off by {number(100.0 * error, '%', digits=2)} of its peak: a coarser "
            "solution is that far away, or the orbit is not closed any better; a smaller "
            "`friction.tolerance` tells whether the motion itself makes small errors large"
        )
        yield Caution("inexact", sentence, {"error": error})
    closest = response.numerics.closest_decision
    if closest is not None and closest < CLOSE:
        sentence = (
            f"a stop or the start was decided by a relative margin of {closest:.1e} between "
            "|F_L| and F_fs: an input changed by 1e-6 may change the answer; vary "
            "friction.static a little to see"
        )
        yield Caution("close-decision", sentence, {"closest_decision": closest})


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


# Of many cases.


def statuses(tallies: Iterable[Tally], axes: Sequence[Axis]) -> Iterator[Caution]:
    """Say how many cases of each approach have no numbers, and why the first has none."""
    for tally in tallies:
        for status, (lost, row) in tally.lost.items():
            first = f"the first at {place(row.point, axes)}: " if row.point else ""
            sentence = (
                f"{lost} of {several(tally.cases, 'case')} by {tally.approach}: {status}; "
                f"{first}{row.note}"
            )
            slug = "case-failed" if status == FAILED else status.replace(" ", "-")
            yield Caution(slug, sentence, {"cases": lost})


def case_strokes(tally: Tally, scenario: Scenario) -> Iterator[Caution]:
    """Say in how many cases the stroke limit is met, and where the most."""
    worst, hits = tally.worst, tally.extremes.get("impact_speed")
    axes = scenario.sweep
    if hits is not None and hits[1].value and worst is not None:
        # Where there are end stops, |x_r| hardly tells one case from another.
        fastest, row = hits[1]
        sentence = (
            f"the mass comes to its end stops in {tally.beyond} of {tally.cases} cases, "
            f"with up to {number(fastest, 'm/s')}{at(row, axes)}"
        )
        numbers = {"impact_speed": fastest, "cases": tally.beyond}
        yield Caution("stroke-violated", sentence, numbers)
        if scenario.stops and scenario.stops.stiffness is None:
            yield impacts_left_out()
    elif worst is not None and (limit := stroke_limit(scenario, worst)) is not None:
        peak = worst.metrics.get("x_r_peak") or 0.0
        some, mean = (", with some seeds", " in the mean") if worst.over else ("", "")
        beside = tally.greatest("x_r_peak") or peak
        which = "" if LIMIT in worst.point else f" of {length(limit, beside)}"
        sentence = (
            f"the stroke limit{which} is met in {tally.beyond} of {tally.cases} cases{some}; "
            f"|x_r| reaches {length(peak, beside)}{mean}{at(worst, axes)}"
        )
        numbers = {"limit": limit, "x_r_peak": peak, "cases": tally.beyond}
        yield Caution("stroke-violated", sentence, numbers)


def at(row: Row, axes: Sequence[Axis]) -> str:
    """Give the point of a row as the end of a sentence, if there is more than one."""
    return f" at {place(row.point, axes)}" if row.point else ""


def wide_means(scenario: Scenario, found: Seeds | None) -> Iterator[Caution]:
    """Say which intervals are wider than asked, and which checks are not decided."""
    if found is None:
        return
    until = until_of(scenario)
    if found.wide and until:
        sentence = (
            f"in {found.wide.cases} of {found.cases} cases the interval of {until.metric} is "
            f"wider than ±{number(100 * until.half_width, '%')} of its mean after "
            f"{most(scenario)} seeds, the most there may be{first_of(found.wide, scenario)}"
        )
        yield Caution("interval-wide", sentence, {"cases": found.wide.cases})
    for check, undecided in found.open.items():
        sentence = (
            f"`{check}` is not decided in {undecided.cases} of {found.cases} cases"
            f"{first_of(undecided, scenario)}: the limit lies within the 95 % confidence "
            "interval of the mean; only more seeds can decide"
        )
        yield Caution("check-undecided", sentence, {"cases": undecided.cases})


def first_of(found: Count, scenario: Scenario) -> str:
    """Say where the first of some cases is, unless there is only one place."""
    where = place(found.first.point, scenario.sweep)
    return f", the first at {where}" if where else ""


# Of many seeds of one case.

Found = Mapping[str, Statistic | None]

OF_ALL = {"energy-open", "stroke-violated", "impacts-left-out"}
"""Warnings about a single seed in whose place stand those about all of them."""


def remarks(
    case: Case, rows: Sequence[Row], found: Found, verdicts: Sequence[Verdict], shown: Outcome
) -> Iterator[Caution]:
    """Give every warning about an ensemble, those of its case first."""
    moves = any((row.metrics.get("stuck_share") or 0.0) < 1.0 for row in rows)
    for caution in case.cautions:
        # It was said of the first seed; another one may do what that does not.
        if not (moves and caution.slug == "will-not-move"):
            yield caution
    yield from failures(rows)
    yield from (caution for caution in shown.warnings if caution.slug not in OF_ALL)
    if case.limit is not None:
        yield from seed_strokes(rows, found, case.limit)
    if isinstance(case.law, Stopped) and case.law.rigid and contacts(found):
        yield impacts_left_out()
    residual = found.get("energy_residual")
    slugs = {caution.slug for caution in shown.warnings}
    if residual and residual.greatest[0] > RESIDUAL and "energy-open" in slugs:
        yield energy_open(residual.greatest[0])
    yield from wide(case, rows)
    yield from undecided(verdicts)
    if case.scenario.measure.spectra:
        sentence = f"spectra.csv and spectra.png are of seed {rows[0].seed} alone"
        yield Caution("spectra-of-one-seed", sentence)


def failures(rows: Sequence[Row]) -> Iterator[Caution]:
    """Say with how many seeds the numerics failed, and why with the first of them."""
    lost = [row for row in rows if row.status == FAILED]
    if lost:
        sentence = (
            f"the numerics failed with {len(lost)} of {len(rows)} seeds, which the means leave "
            f"out; the first is seed {lost[0].seed}: {lost[0].note}"
        )
        yield Caution("case-failed", sentence, {"seeds": len(lost)})


def seed_strokes(rows: Sequence[Row], found: Found, limit: float) -> Iterator[Caution]:
    """Say with how many seeds the stroke limit is met, and where the most."""
    beyond = sum(bool(row.metrics.get("violations")) for row in rows)
    most_of_all, hits = found["stroke_suffices"], found.get("impact_speed")
    if beyond and hits and contacts(found):
        fastest, seed = hits.greatest
        sentence = (
            f"the mass comes to its end stops with {beyond} of {len(rows)} seeds, with up to "
            f"{number(fastest, 'm/s')} with seed {seed}"
        )
        numbers = {"impact_speed": fastest, "seed": seed, "seeds": beyond}
        yield Caution("stroke-violated", sentence, numbers)
    elif beyond and most_of_all:
        peak, seed = most_of_all.greatest
        sentence = (
            f"the stroke limit of {length(limit, peak)} is met with {beyond} of {len(rows)} "
            f"seeds; |x_r| reaches {length(peak)} with seed {seed}"
        )
        numbers = {"limit": limit, "x_r_peak": peak, "seed": seed, "seeds": beyond}
        yield Caution("stroke-violated", sentence, numbers)


def contacts(found: Found) -> bool:
    """Tell whether the mass comes to end stops within the window of any seed."""
    hits = found.get("contacts")
    return hits is not None and hits.greatest[0] > 0


def wide(case: Case, rows: Sequence[Row]) -> Iterator[Caution]:
    """Say when the interval is not as narrow as asked after all seeds that there may be."""
    until = until_of(case.scenario)
    if until is None or len(rows) < most(case.scenario) or narrow(case.scenario, rows):
        return
    mean, half_width, known = width_of(rows, until.metric)
    n, name, asked = len(rows), until.metric, number(100 * until.half_width, "%")
    if known < n:
        sentence = f"{name} is known with {known} of {n} seeds only, so until never holds"
        yield Caution("interval-wide", sentence, {"seeds": n, "known": known})
    elif not mean or half_width is None:
        sentence = (
            f"the mean of {name} is 0 after {n} seeds, and no interval is {asked} of that"
        )
        yield Caution("interval-wide", sentence, {"seeds": n})
    else:
        share = half_width / abs(mean)
        needed = ceil(n * (share / until.half_width) ** 2)
        sentence = (
            f"after {n} seeds, the most there may be, the interval of {name} is "
            f"±{number(100 * share, '%', 3)} of its mean, not ±{asked}: "
            f"excitation.seeds: {number(needed, digits=2)} would do"
        )
        yield Caution("interval-wide", sentence, {"half_width": share, "seeds": n})


def undecided(verdicts: Sequence[Verdict]) -> Iterator[Caution]:
    """Say of every check whose limit lies within the interval that it is not decided."""
    for verdict in verdicts:
        if verdict.undecided:
            sentence = (
                f"`{verdict.check}` {'holds' if verdict.passed else 'fails'} by the mean of "
                f"{verdict.seeds} seeds, but the limit lies within its 95 % confidence "
                "interval: only more seeds can decide"
            )
            numbers = {"value": verdict.value or 0.0, "half_width": verdict.half_width or 0.0}
            yield Caution("check-undecided", sentence, numbers)
