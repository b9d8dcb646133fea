"""Warnings that follow from results: of a case, of many cases, and of an ensemble.

Each function returns values, not output. Warnings known before the computation come from
`scenario.warnings` and `study.budget`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import ceil

import numpy as np

from drysim.approach.solution import LyapunovExponent, Orbit, Response
from drysim.core.model import AnyLaw, StrokeLimits
from drysim.errors import WarningMessage
from drysim.metrics.checks import Verdict
from drysim.metrics.table import HOURLY_STROKE, STROKE_USED, Metrics
from drysim.scenario.axes import Axis
from drysim.scenario.blocks import SEED_KEY
from drysim.scenario.model import LIMIT_KEYS, Scenario
from drysim.scenario.text import describe_case, describe_limits, format_times_by_side
from drysim.scenario.warnings import few_seeds_warning, least_seeds_of
from drysim.study.case import Case
from drysim.study.outcome import Outcome
from drysim.study.statistics import (
    FAILED,
    Batch,
    Row,
    Statistic,
    interval,
    is_narrow,
    max_seeds,
    stopping_rule,
)
from drysim.study.table import (
    Count,
    HourlyStroke,
    SeedSummary,
    Tally,
    hourly_stroke_used,
    largest_excess,
    seeds_beyond,
    stroke_limits,
)
from drysim.wording import (
    format_count,
    format_length,
    format_number,
    format_percent,
    join_words,
)

MAX_RESIDUAL = 1e-9
"""Residual of energy and laws up to which a motion is certified [-]; rounding leaves 1e-12."""

MAX_STATED_ERROR = 1e-3
"""Error estimate, relative to the peak, from which it is visible in a picture [-]."""

MAX_END_EFFECT = 0.01
"""Change of a metric by the ends of a record from which a warning is given [-]."""

RELATIVE_METRICS = (
    "a_u", "a_x", "T_a", "T_x", "x_r_rms", "x_r_peak", "v_r_rms", "a_w", "SEAT", "VDV",
)  # fmt: skip
"""Metrics whose relative change by the ends of a record is checked."""

CLOSE_MARGIN = 1e-6
"""Relative margin of a decision below which it is within the uncertainty of the inputs [-]."""


# One case.


def response_warnings(
    response: Response,
    metrics: Metrics,
    limits: StrokeLimits | None,
    includes_settling: bool = False,
    window_peak: float | None = None,
) -> Iterator[WarningMessage]:
    """Yield the warnings that follow from a response.

    Parameters
    ----------
    response : Response
    metrics : mapping
        Metrics of the complete response, if it exceeds the stroke limit; else of the window.
    limits : StrokeLimits or None
    includes_settling : bool, optional
        Whether the metrics include the time before the window.
    window_peak : float, optional
        Peak of |x_r| in the window [m], which sets the unit of lengths; default: of the
        metrics.
    """
    stops = response.law.stops
    if limits is not None and metrics["violations"]:
        yield stroke_warning(metrics, limits, response.law, includes_settling, window_peak)
    elif limits is not None and stops is None:
        yield from hourly_stroke_warnings(metrics, limits)
    if stops is not None and stops.rigid and metrics["contacts"]:
        yield rigid_impact_warning()
    yield from certificate_warnings(metrics["energy_residual"], metrics["law_residual"])
    error = response.numerics.error
    if error is not None and not error <= MAX_STATED_ERROR:
        sentence = (
            f"the estimated error of x_r is {format_number(100.0 * error, '%', digits=2)} "
            "of its peak, from a coarser solution or the closure of the orbit; try a smaller "
            "`friction.tolerance` to see whether the motion amplifies small errors"
        )
        yield WarningMessage("inexact", sentence, {"error": error})
    closest = response.numerics.closest_decision
    if closest is not None and closest < CLOSE_MARGIN:
        sentence = (
            f"a decision between stick and slip has a relative margin of {closest:.1e}: the "
            "mass stops, sticks or breaks away, or just does not; a relative change of 1e-6 in "
            "an input may change the result; vary friction.static slightly to check"
        )
        yield WarningMessage("close-decision", sentence, {"closest_decision": closest})


def stroke_warning(
    metrics: Metrics,
    limits: StrokeLimits,
    law: AnyLaw,
    includes_settling: bool,
    window_peak: float | None = None,
) -> WarningMessage:
    """Return the warning about the stroke limit or end stops."""
    t_first, peak = metrics["t_first_violation"] or 0.0, metrics["x_r_peak"] or 0.0
    window_peak = window_peak or peak
    symbol, reached, beyond = largest_excess(metrics, limits)
    if law.stops is not None:
        sentence = (
            f"the mass hits its end stops, first at t = {format_number(t_first, 's')}, at up "
            f"to {format_number(metrics['impact_speed'], 'm/s')}"
        )
    else:
        sentence = (
            f"the stroke limit of {describe_limits(limits, window_peak)} is exceeded "
            f"{format_times_by_side(metrics, 'violations', limits)}, first at "
            f"t = {format_number(t_first, 's')}; {symbol} reaches "
            f"{format_length(reached, window_peak)}, "
            f"{format_length(beyond, window_peak)} beyond the limit"
        )
    numbers = limit_numbers(limits) | {"x_r_peak": peak, "t_first_violation": t_first}
    return WarningMessage(
        "stroke-violated", sentence + " (settling included)" * includes_settling, numbers
    )


def hourly_stroke_warnings(
    metrics: Metrics, limits: StrokeLimits, where: str = ""
) -> Iterator[WarningMessage]:
    """Warn if the stroke that is exceeded once an hour is beyond the limit.

    `where` is added to the sentence, such as the number of seeds of a mean.
    """
    used = hourly_stroke_used(metrics, limits)
    if used.share <= 1.0:
        return
    sentence = (
        f"the stroke limit of {describe_limits(limits, used.x_r)} "
        f"{describe_hourly_stroke(used)}{where}"
    )
    numbers = limit_numbers(limits) | {HOURLY_STROKE: abs(used.x_r)}
    yield WarningMessage("stroke-too-short", sentence, numbers)


def describe_hourly_stroke(used: HourlyStroke, mean: str = "") -> str:
    """Describe by how much a limit is too small for what is reached once an hour."""
    return (
        "is not exceeded in this time, but is expected to be if the base moves on like this: "
        f"the peak reached once an hour is {format_length(used.x_r, used.x_r)}{mean}, "
        f"{format_percent(used.share)} of {used.limit} (extrapolated)"
    )


def limit_numbers(limits: StrokeLimits) -> dict[str, float]:
    """Return the stroke limits as numbers of a warning [m]; one if they are equal."""
    if limits.up == limits.down:
        return {"limit": limits.up}
    return {"limit_up": limits.up, "limit_down": limits.down}


def rigid_impact_warning() -> WarningMessage:
    """Return the warning that a rigid impact has no finite acceleration."""
    sentence = (
        "the force of an impact on a rigid stop is infinite: a_x and T_a cover only the motion "
        "between impacts; use bumpers (stroke.stops.stiffness) for finite forces"
    )
    return WarningMessage("impacts-left-out", sentence)


def certificate_warnings(energy: float | None, law: float | None) -> Iterator[WarningMessage]:
    """Warn of a motion that its residuals of energy and laws do not certify.

    `law` is None for fixed steps. These never close the energy balance: its residual is then a
    metric, no warning.
    """
    if law is None:
        return
    if energy is not None and not abs(energy) <= MAX_RESIDUAL:
        sentence = (
            f"the energy residual is {energy:.1e}, above {MAX_RESIDUAL:.0e}: "
            "digits beyond it are unreliable; please report the scenario"
        )
        yield WarningMessage("energy-open", sentence, {"energy_residual": energy})
    if not law <= MAX_RESIDUAL:
        sentence = (
            f"the motion violates the laws of friction or stops by {law:.1e} of the forces, "
            f"above {MAX_RESIDUAL:.0e}; please report the scenario"
        )
        yield WarningMessage("law-violated", sentence, {"law_residual": law})


def orbit_warnings(
    orbit: Orbit, case: Case, exponent: LyapunovExponent | None
) -> Iterator[WarningMessage]:
    """Warn of an orbit that is not settled or not unique, and of the stroke before that.

    The Lyapunov exponent is that of a motion that is not settled, where it is known.
    """
    if not orbit.settled:
        drift = "" if case.plant.k_x else "without a spring it may drift for ever; "
        sentence = (
            f"the motion has not settled after {format_number(orbit.run_up, 's')}: it still "
            f"changes by {format_number(orbit.closure)} per repetition; {drift}"
        )
        numbers = {"closure": orbit.closure, "run_up": orbit.run_up}
        if exponent is not None:
            sentence += f"it is {exponent.verdict}; "
            numbers |= {
                "lyapunov": exponent.value,
                "lyapunov_low": exponent.low,
                "lyapunov_high": exponent.high,
            }
        sentence += "use `steady: false` with `settle` and `duration` instead"
        yield WarningMessage("not-settled", sentence, numbers)
    if not orbit.unique:
        sentence = (
            "the periodic orbit is neutrally stable and not unique; this is the one reached "
            "from the given start"
        )
        yield WarningMessage("not-unique", sentence)
    limits = case.limits
    # Only |x_r| is known before the motion settles, not on which side.
    if limits is not None and orbit.run_up_peak >= min(limits):
        when = "before the motion settles" if orbit.settled else "in this time"
        same = limits.up == limits.down
        exceeds = "exceeds the" if same else "may exceed the smaller"
        sentence = (
            f"{when} |x_r| reaches {format_length(orbit.run_up_peak)} and {exceeds} "
            f"stroke limit of {format_length(min(limits), orbit.run_up_peak)}"
        )
        numbers = {"limit": min(limits), "run_up_peak": orbit.run_up_peak}
        yield WarningMessage("stroke-violated-settling", sentence, numbers)


def changed_metrics(metrics: Metrics, others: Metrics) -> dict[str, float]:
    """Return the relative changes of metrics beyond `MAX_END_EFFECT`, by name [-].

    The change of `stuck_share` is absolute.
    """
    changes = {}
    for name in (*RELATIVE_METRICS, "stuck_share"):
        value, other = metrics.get(name), others.get(name)
        if value is None or other is None:
            continue
        scale = abs(value) or abs(other) or 1.0
        changes[name] = (other - value) / (1.0 if name == "stuck_share" else scale)
    return {name: share for name, share in changes.items() if abs(share) > MAX_END_EFFECT}


def record_end_warning(moved: Mapping[str, float], below: float) -> WarningMessage:
    """Return the warning that metrics depend on the ends of a high-passed record."""
    changes = join_words(
        [
            f"{name} by {format_number(100.0 * share, '%', digits=2)}"
            for name, share in moved.items()
        ]
    )
    sentence = (
        f"the high-pass at {format_number(below, 'Hz')} depends on how the record is continued "
        f"beyond its ends: reflection about the last sample changes {changes}; leave out the "
        f"first and the last {format_number(1.0 / below, 's', digits=3)} of the record by "
        "`excitation.window`, or use a longer record"
    )
    return WarningMessage("record-ends", sentence, moved)


# Sweeps and comparisons.


def status_warnings(tallies: Iterable[Tally], axes: Sequence[Axis]) -> Iterator[WarningMessage]:
    """Warn of cases without numbers, by approach and status."""
    for tally in tallies:
        for status, (lost, row) in tally.lost.items():
            first = f"the first at {describe_case(row.point, axes)}: " if row.point else ""
            sentence = (
                f"{lost} of {format_count(tally.cases, 'case')} by {tally.approach}: {status}; "
                f"{first}{row.note}"
            )
            slug = "case-failed" if status == FAILED else status.replace(" ", "-")
            yield WarningMessage(slug, sentence, {"cases": lost})


def share_of_cases(count: int, cases: int) -> str:
    """Return in how many cases of a sweep something happens."""
    return f"in {count} of {cases} cases" if cases > 1 else "in the only case"


def table_stroke_warnings(tally: Tally, scenario: Scenario) -> Iterator[WarningMessage]:
    """Warn of cases that exceed the stroke limit, with the worst one."""
    worst, impacts = tally.worst, tally.extremes.get("impact_speed")
    axes = scenario.sweep
    if impacts is not None and impacts[1].value and worst is not None:
        # With end stops, |x_r| is nearly the same in all cases.
        fastest, row = impacts[1]
        sentence = (
            f"the mass hits its end stops {share_of_cases(tally.beyond, tally.cases)}, "
            f"at up to {format_number(fastest, 'm/s')}{format_at(row, axes)}"
        )
        numbers = {"impact_speed": fastest, "cases": tally.beyond}
        yield WarningMessage("stroke-violated", sentence, numbers)
        if scenario.stops and scenario.stops.stiffness is None:
            yield rigid_impact_warning()
    elif worst is not None and (limits := stroke_limits(scenario, worst.point)) is not None:
        peak = worst.metrics.get("x_r_peak") or 0.0
        window_peak = tally.greatest("x_r_peak") or peak
        swept = any(key in worst.point for key in LIMIT_KEYS)
        which = "" if swept else f" of {describe_limits(limits, window_peak)}"
        where = share_of_cases(tally.beyond, tally.cases)
        sentence = f"the stroke limit{which} is exceeded {where}"
        if worst.over:
            share = format_percent(worst.largest(STROKE_USED))
            sentence += f"; up to {share} of it is used{format_at(worst, axes)}"
            sentence += f", where it is exceeded {describe_seeds_beyond(worst)}"
        else:
            symbol, reached, _ = largest_excess(worst.metrics, limits)
            reached_text = format_length(reached, window_peak)
            sentence += f"; {symbol} reaches {reached_text}{format_at(worst, axes)}"
        numbers = limit_numbers(limits) | {"x_r_peak": peak, "cases": tally.beyond}
        yield WarningMessage("stroke-violated", sentence, numbers)
    if tally.too_short is not None and not scenario.stops:
        cases, row = tally.too_short
        limits = stroke_limits(scenario, row.point)
        assert limits is not None, "a stroke is too short for a limit only"
        used = hourly_stroke_used(row.metrics, limits)
        hourly = describe_hourly_stroke(used, " on average" * bool(row.over))
        sentence = (
            f"{share_of_cases(cases, tally.cases)} the stroke limit {hourly}"
            f"{format_at(row, axes)}"
        )
        numbers = limit_numbers(limits) | {HOURLY_STROKE: abs(used.x_r), "cases": cases}
        yield WarningMessage("stroke-too-short", sentence, numbers)


def describe_seeds_beyond(row: Row) -> str:
    """Describe for how many seeds of a case the stroke limit is exceeded."""
    beyond = seeds_beyond(row)
    which = "all" if beyond == row.seeds else f"{beyond} of"
    return f"for {which} {row.seeds} seeds"


def format_at(row: Row, axes: Sequence[Axis]) -> str:
    """Return the point of a row as the end of a sentence; "" without swept keys."""
    return f" at {describe_case(row.point, axes)}" if row.point else ""


def table_interval_warnings(
    scenario: Scenario, summary: SeedSummary | None
) -> Iterator[WarningMessage]:
    """Warn of confidence intervals wider than required, and of undecided checks."""
    if summary is None:
        return
    until = stopping_rule(scenario)
    if summary.too_wide and until:
        sentence = (
            f"in {summary.too_wide.cases} of {summary.cases} cases the confidence interval of "
            f"{until.metric} is wider than ±{format_number(100 * until.half_width, '%')} of "
            f"its mean after all {max_seeds(scenario)} seeds"
            f"{describe_first(summary.too_wide, scenario)}"
        )
        yield WarningMessage("interval-wide", sentence, {"cases": summary.too_wide.cases})
    for check in scenario.checks:
        if summary.least < check.least_seeds <= least_seeds_of(scenario):
            yield few_seeds_warning(check, summary.least, FEW_BY_RULE)
    for check, undecided in summary.undecided.items():
        sentence = (
            f"`{check}` is undecided in {undecided.cases} of {summary.cases} cases"
            f"{describe_first(undecided, scenario)}: the limit lies within the 95 % confidence "
            "interval of the mean; use more seeds"
        )
        yield WarningMessage("check-undecided", sentence, {"cases": undecided.cases})


def describe_first(count: Count, scenario: Scenario) -> str:
    """Describe where the first of some cases is, if there are several places."""
    where = describe_case(count.first.point, scenario.sweep)
    return f", the first at {where}" if where else ""


# Ensembles.

SeedStatistics = Mapping[str, Statistic | None]

FEW_BY_RULE = " by the rule `excitation.until`"
"""Why there are fewer seeds than asked for."""

REPLACED_SLUGS = {
    "energy-open", "law-violated", "stroke-violated", "stroke-too-short", "impacts-left-out",
}  # fmt: skip
"""Warnings about a single seed, replaced by those about all seeds."""


def ensemble_warnings(
    case: Case,
    seeds: Batch,
    statistics: SeedStatistics,
    verdicts: Sequence[Verdict],
    shown: Outcome,
) -> Iterator[WarningMessage]:
    """Yield all warnings about an ensemble, those of its case first."""
    has_motion = not (seeds.metrics["stuck_share"] >= 1.0).all()
    for warning in case.warnings:
        # The warning is about the first seed; another seed may move.
        if not (has_motion and warning.slug == "will-not-move"):
            yield warning
    yield from failure_warnings(seeds)
    yield from (warning for warning in shown.warnings if warning.slug not in REPLACED_SLUGS)
    if case.limits is not None:
        yield from ensemble_stroke_warnings(seeds, statistics, case.limits)
    stops = case.law.stops
    if stops is not None and stops.rigid and has_contacts(statistics):
        yield rigid_impact_warning()
    residuals = (statistics.get(name) for name in ("energy_residual", "law_residual"))
    yield from certificate_warnings(
        *(statistic and statistic.greatest[0] for statistic in residuals)
    )
    yield from wide_interval_warnings(case, seeds)
    yield from undecided_warnings(verdicts)
    for verdict in verdicts:
        if 1 < verdict.seeds < verdict.check.least_seeds <= max_seeds(case.scenario):
            yield few_seeds_warning(verdict.check, verdict.seeds, FEW_BY_RULE)
    if case.scenario.measure.spectra:
        sentence = f"spectra.csv and spectra.png show seed {seeds.points[SEED_KEY][0]} only"
        yield WarningMessage("spectra-of-one-seed", sentence)


def failure_warnings(seeds: Batch) -> Iterator[WarningMessage]:
    """Warn of seeds whose numerics failed."""
    lost = seeds.notes
    if lost:
        first, note = next(iter(lost.items()))
        sentence = (
            f"the numerics failed for {len(lost)} of {len(seeds)} seeds, which the means "
            f"exclude; the first is seed {seeds.points[SEED_KEY][first]}: {note}"
        )
        yield WarningMessage("case-failed", sentence, {"seeds": len(lost)})


def ensemble_stroke_warnings(
    seeds: Batch, statistics: SeedStatistics, limits: StrokeLimits
) -> Iterator[WarningMessage]:
    """Warn of seeds that exceed the stroke limit, with the worst one."""
    beyond = int((seeds.metrics["violations"] > 0.0).sum())
    used, impacts = statistics.get(STROKE_USED), statistics.get("impact_speed")
    if beyond and impacts and has_contacts(statistics):
        fastest, seed = impacts.greatest
        sentence = (
            f"the mass hits its end stops for {beyond} of {len(seeds)} seeds, at up to "
            f"{format_number(fastest, 'm/s')} for seed {seed}"
        )
        numbers = {"impact_speed": fastest, "seed": seed, "seeds": beyond}
        yield WarningMessage("stroke-violated", sentence, numbers)
    elif beyond and used:
        seed = used.greatest[1]
        worst = seeds.row(seeds.points[SEED_KEY].tolist().index(seed))
        symbol, reached, _ = largest_excess(worst.metrics, limits)
        sentence = (
            f"the stroke limit of {describe_limits(limits, reached)} is exceeded for {beyond} "
            f"of {len(seeds)} seeds; {symbol} reaches {format_length(reached)} for seed {seed}"
        )
        peak = abs(reached)
        numbers = limit_numbers(limits) | {"x_r_peak": peak, "seed": seed, "seeds": beyond}
        yield WarningMessage("stroke-violated", sentence, numbers)
    elif impacts is None:
        means = {name: statistic and statistic.mean for name, statistic in statistics.items()}
        yield from hourly_stroke_warnings(means, limits, f", mean of {len(seeds)} seeds")


def has_contacts(statistics: SeedStatistics) -> bool:
    """Whether the mass reaches an end stop within the window under any seed."""
    impacts = statistics.get("contacts")
    return impacts is not None and impacts.greatest[0] > 0


def wide_interval_warnings(case: Case, seeds: Batch) -> Iterator[WarningMessage]:
    """Warn when the interval is wider than the stopping rule demands after all seeds."""
    until, n = stopping_rule(case.scenario), len(seeds)
    if until is None or n < max_seeds(case.scenario):
        return
    values = seeds.metrics[until.metric]
    if is_narrow(until, values.tolist()):
        return
    series = values[~np.isnan(values)].tolist()
    mean, half_width = interval(series) if series else (0.0, None)
    count, name = len(series), until.metric
    target = format_number(100 * until.half_width, "%")
    if count < n:
        sentence = (
            f"only {count} of {n} seeds give {name}; the stopping rule `until` cannot be met"
        )
        yield WarningMessage("interval-wide", sentence, {"seeds": n, "known": count})
    elif not mean or half_width is None:
        sentence = (
            f"the mean of {name} is 0 after {n} seeds; an interval of ±{target} of it cannot "
            "be reached"
        )
        yield WarningMessage("interval-wide", sentence, {"seeds": n})
    else:
        share = half_width / abs(mean)
        needed = ceil(n * (share / until.half_width) ** 2)
        sentence = (
            f"after all {n} seeds the confidence interval of {name} is "
            f"±{format_number(100 * share, '%', 3)} of its mean, not ±{target}; "
            f"excitation.seeds: {format_number(needed, digits=2)} would suffice"
        )
        yield WarningMessage("interval-wide", sentence, {"half_width": share, "seeds": n})


def undecided_warnings(verdicts: Sequence[Verdict]) -> Iterator[WarningMessage]:
    """Warn of each check whose limit lies within the confidence interval."""
    for verdict in verdicts:
        if verdict.undecided:
            sentence = (
                f"`{verdict.check}` {'holds' if verdict.passed else 'fails'} for the mean of "
                f"{verdict.seeds} seeds, but the limit lies within its 95 % confidence "
                "interval; use more seeds"
            )
            numbers = {"value": verdict.value or 0.0, "half_width": verdict.half_width or 0.0}
            yield WarningMessage("check-undecided", sentence, numbers)
