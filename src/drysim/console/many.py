"""Summaries of many runs: an ensemble over seeds, a sweep, a comparison.

Each has the scene, extremes or means with their places, the verdicts of the checks, and the
number of cases or seeds without values. Every case is checked against its own stroke limit.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from math import isclose
from pathlib import Path
from typing import TYPE_CHECKING

from drysim import wording
from drysim.console.summaries import (
    SummaryRow,
    clean_up_lines,
    describe_hourly_use,
    run_scene,
    show_folder,
    show_rows,
    show_scene,
    show_summary,
    show_title,
    show_verdicts,
    show_warnings,
)
from drysim.console.terminal import NO_VALUE, print_line, print_table, stderr, stdout, wrap
from drysim.metrics.table import HOURLY_STROKE, METRICS_BY_NAME, PEAK_STROKE, SHARE
from drysim.metrics.text import KEY_RATIOS, format_metric_range, format_value, label_of
from drysim.scenario.axes import EXTREME_KEY
from drysim.scenario.model import asks_for_peak_acceleration
from drysim.study import compare, run
from drysim.study.plan import approaches_of
from drysim.study.statistics import MAX_CACHED_ROWS, OK, max_seeds, stopping_rule
from drysim.study.table import Tally, hourly_stroke_used, largest_excess, stroke_limits
from drysim.study.warnings import describe_seeds_beyond
from drysim.wording import (
    display_unit,
    format_count,
    format_deviation,
    format_interval,
    format_length,
    format_number,
    format_percent,
    format_range,
)

if TYPE_CHECKING:
    from drysim.scenario.axes import Axis
    from drysim.study.compare import Comparison, Deviation, Isolation
    from drysim.study.ensemble import Ensemble
    from drysim.study.statistics import Row, Statistic
    from drysim.study.table import Extreme, Jump, SeedSummary, Table


# An ensemble: one case with many seeds.

ENSEMBLE_VALUE_WIDTH = 22
"""Columns of the values."""

MAIN_METRICS = ("T_a", "SEAT", "a_w", "T_x", PEAK_STROKE, HOURLY_STROKE, "stuck_share")
"""Metrics with a row of their own, besides that of the stopping rule."""

END_STOP_METRICS = {
    "impact_speed": "at up to",
    "stop_force_peak": "force up to",
    "impulse_peak": "impulse up to",
}
"""Metrics of the severity of end-stop impacts, and the words before their values."""

MIN_QUANTILE_SEEDS = 13
"""Least number of seeds for which the 5 % and 95 % quantiles differ from the extremes."""


def show_ensemble(ensemble: Ensemble, folder: Path | None = None) -> None:
    """Show the summary of an ensemble, and the folder of its files, if they were written."""
    scene, rows = ensemble_scene(ensemble), ensemble_rows(ensemble)
    show_summary(ensemble, scene, [rows], ENSEMBLE_VALUE_WIDTH, folder)


def ensemble_scene(ensemble: Ensemble) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was solved, and with which seeds."""
    for name, words in run_scene(ensemble.shown):
        yield name, words
        if name == "base":
            until = stopping_rule(ensemble.scenario)
            yield "seeds", wording.describe_seeds(ensemble.seeds, until)
            if not ensemble.complete:
                yield (
                    "state",
                    _describe_incomplete(
                        len(ensemble.rows), max_seeds(ensemble.scenario), "seed"
                    ),
                )


def ensemble_rows(ensemble: Ensemble) -> Iterator[SummaryRow]:
    """Yield the main metrics, and the metric of the stopping rule."""
    until = stopping_rule(ensemble.scenario)
    good = sum(row.status == OK for row in ensemble.rows)
    peak = ensemble.statistics[PEAK_STROKE]
    peak_scale = peak.greatest[0] if peak else 0.0
    for name in dict.fromkeys((*MAIN_METRICS, *([until.metric] if until else []))):
        metric, found = METRICS_BY_NAME[name], ensemble.statistics[name]
        decides = until is not None and name == until.metric
        # A mean over only some of the seeds is biased: omitted here, but kept in drysim.json.
        if found is not None and (decides or found.seeds == good):
            scale, unit = display_unit(metric.shown, found.greatest[0], peak_scale)
            width = None if found.half_width is None else found.half_width * scale
            words = format_interval(found.mean * scale, width, unit)
            scatter = _describe_scatter(ensemble, name, found, scale, unit)
            yield SummaryRow(metric.label, words, "; ".join(scatter))
    yield from _limit_rows(ensemble)
    residual = ensemble.statistics["energy_residual"]
    if residual:
        words = format_number(residual.greatest[0], digits=2)
        yield SummaryRow("energy", f"residual at most {words}")
    if lost := sum(row.status != OK for row in ensemble.rows):
        yield SummaryRow("failed", format_count(lost, "seed"), style="bold red")


def _describe_scatter(
    ensemble: Ensemble, metric: str, found: Statistic, scale: float, unit: str
) -> Iterator[str]:
    """Yield the scatter of a metric over the seeds."""
    low, high = (found.quantiles[at] * scale for at in (0, -1))
    if format_number(low) != format_number(high):
        which = "90 % of" if found.seeds >= MIN_QUANTILE_SEEDS else f"all {found.seeds}"
        yield f"{which} seeds: {format_range(low, high, unit)}"
    if found.seeds < len(ensemble.rows):
        yield f"from {found.seeds} of {len(ensemble.rows)} seeds"
    used, stroke = ensemble.statistics.get("stroke_used"), ensemble.scenario.stroke
    if metric == HOURLY_STROKE and stroke is not None and not ensemble.scenario.stops:
        hourly = hourly_stroke_used(ensemble.metrics, stroke.limits)
        yield f"mean {describe_hourly_use(hourly)}"
    if metric == PEAK_STROKE and used:
        share, seed = used.greatest
        yield f"largest with seed {seed}, {format_percent(share)} of the stroke limit"


def _limit_rows(ensemble: Ensemble) -> Iterator[SummaryRow]:
    """Yield how many seeds exceed the stroke limit, and how hard they hit end stops."""
    beyond = sum(bool(row.metrics.get("violations")) for row in ensemble.rows)
    if beyond:
        seeds, how = format_count(beyond, "seed"), [f"of {len(ensemble.rows)}"]
        name, value = "limit", f"exceeded for {seeds}"
        for metric, words in END_STOP_METRICS.items():
            if (found := ensemble.statistics.get(metric)) and found.greatest[0] > 0:
                greatest, seed = found.greatest
                name, value = "stops hit", seeds
                how.append(f"{words} {format_value(metric, greatest)} with seed {seed}")
        yield SummaryRow(name, value, ", ".join(how), "bold red")


# A sweep.

TABLE_VALUE_WIDTH = 20
"""Columns of the values."""

MAX_NAMED_CURVES = 4
"""Curves whose isolation frequency is listed one by one."""

ROUNDING_TOLERANCE = 1e-9
"""Relative difference of extremes below which their places mean nothing [-]."""


def show_table(table: Table, folder: Path | None = None) -> None:
    """Show the summary of a sweep, and the folder of its files, if they were written."""
    show_summary(
        table,
        sweep_scene(table),
        [table_rows(table)],
        TABLE_VALUE_WIDTH,
        folder,
        table.axes,
        answer=_describe_answer(table),
    )


def sweep_scene(table: Table) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was swept, and what was not."""
    scenario, axes, own = table.scenario, table.axes, _main_tally(table)
    varied = [axis.key for axis in axes]
    plant, law, base = scenario.oscillator.plant(), scenario.law(), scenario.excitation
    peak = own.greatest(PEAK_STROKE)
    yield from wording.describe_scene(scenario, plant, law, varied, own.shared, peak)
    yield "base", base.describe_cases(table.motion, varied, table.records)
    same = not any(key.startswith("excitation.") for key in varied)
    motion = table.motion if same else None
    yield from clean_up_lines(wording.describe_clean_up(motion, records=table.records))
    if found := own.seeds:
        first: int = getattr(base, "seed", 1)
        drawn = range(first, first + found.most)
        counts = sorted({found.least, found.most})
        yield "seeds", wording.describe_seeds(drawn, stopping_rule(scenario), counts)
    for i, axis in enumerate(axes):
        yield "" if i else "swept", wording.describe_axis(axis)
    cases = (f"{tally.cases} by {name}" for name, tally in table.tallies.items())
    yield "cases", ", ".join(cases)
    if not table.complete:
        yield (
            "state",
            _describe_incomplete(
                len(table.rows), run.count_cases(approaches_of(scenario)), "case"
            ),
        )


def _main_tally(table: Table) -> Tally:
    """Return the extremes over the cases of the scenario's approach, references left out."""
    return table.own_tally or Tally(table.scenario.solver.approach)


def table_rows(table: Table) -> Iterator[SummaryRow]:
    """Yield the main metrics."""
    own = _main_tally(table)
    for metric in KEY_RATIOS:
        if metric in own.extremes:
            yield _range_row(table, own, metric)
            yield from widest_interval_row(table.axes, own.seeds, metric)
    # If the frequency is sampled together with other keys, there are no curves over it.
    over_frequency = any(
        axis.key == compare.FREQUENCY_KEY and len(axis.values) > 1 and not axis.group
        for axis in table.axes
    )
    if over_frequency and "T_a" in own.extremes and own.cases <= MAX_CACHED_ROWS:
        yield _isolation_row(table, compare.isolation_limits(table.own))
    if asks_for_peak_acceleration(table.scenario) and "x_dd_peak" in own.extremes:
        yield _range_row(table, own, "x_dd_peak")
    yield from stroke_rows(table, own)
    yield from _hysteresis_rows(table)
    yield from _jump_rows(table)
    yield from _best_rows(table)
    if ends := own.extremes.get("stuck_share"):
        remark = f"maximum {describe_place(table, ends[1])}" if ends[1].value else ""
        if remark and is_constant(own, "stuck_share"):
            remark = describe_extent(table, own, "stuck_share")
        low, high = (format_value("stuck_share", end.value) for end in ends)
        yield SummaryRow(label_of("stuck_share"), format_range(low, high), remark)
    if ends := own.extremes.get("energy_residual"):
        residual = format_number(ends[1].value, digits=2)
        yield SummaryRow("energy", f"residual at most {residual}")
    yield from _failure_rows(table)


def _range_row(table: Table, own: Tally, metric: str) -> SummaryRow:
    """Return the range of a metric over the cases, and where its ends are."""
    return SummaryRow(
        label_of(metric),
        format_metric_range(metric, own.ends[metric]),
        describe_extent(table, own, metric),
    )


def widest_interval_row(
    axes: Sequence[Axis], found: SeedSummary | None, metric: str
) -> Iterator[SummaryRow]:
    """Yield the widest confidence interval of the mean of a metric."""
    row = found.widest.get(metric) if found else None
    if row is not None:
        width = row.half_widths[metric]
        mean, where = row.metrics.get(metric), wording.describe_case(row.point, axes)
        words = f"widest interval: {format_interval(mean, width)} at {where}"
        yield SummaryRow("", f"± {format_number(width, digits=2)}", words)


def _isolation_row(table: Table, found: Sequence[Isolation]) -> SummaryRow:
    """Return the frequency above which the seat isolates, over all curves that do."""
    begins = [one.above for one in found if one.above is not None]
    if not begins:
        return SummaryRow("isolation", "nowhere", "T_a is not below 1 at the end of any curve")
    first, last, remark = min(begins), max(begins), "T_a stays below 1"
    alike = first == last and len(begins) == len(found)
    if not alike and len(found) <= MAX_NAMED_CURVES:
        remark += ": " + "; ".join(
            f"{wording.describe_case(one.point, table.axes)} "
            + ("nowhere" if one.above is None else f"from {format_number(one.above, 'Hz')}")
            for one in found
        )
    elif not alike:
        lost = len(begins) < len(found)
        curves = f"{len(begins)} of {len(found)}" if lost else f"all {len(found)}"
        remark += f" on {curves} curves" + ", nowhere on the others" * lost
        if first < last:
            remark += f"; on {begins.count(first)} of them from {format_number(first, 'Hz')}"
    return SummaryRow("isolation", f"from {format_number(last, 'Hz')}", remark)


def _hysteresis_rows(table: Table) -> Iterator[SummaryRow]:
    """Yield where the sweeps up and down differ, with the greatest difference of T_a."""
    found = table.hysteresis
    if found is None:
        return
    if not found:
        yield SummaryRow("hysteresis", "none", "T_a is the same up and down, in every case")
        return
    low, high = min(one.low for one in found), max(one.high for one in found)
    unit, widest = wording.format_unit(table.axes[0].unit), max(found, key=lambda one: one.gap)
    up, down = (
        row.status if row.status != OK else format_number(row.metrics["T_a"], digits=5)
        for row in (widest.up, widest.down)
    )
    where = wording.describe_case(widest.point, table.axes)
    yield SummaryRow(
        "hysteresis",
        format_range(low, high, unit),
        f"T_a {up} up against {down} down at {where}",
    )


def _jump_rows(table: Table) -> Iterator[SummaryRow]:
    """Yield the values of the static ratio at which the answer jumps."""
    if table.jumps is None:
        return
    resolved = all(warning.slug != "jumps-unresolved" for warning in table.warnings)
    if not table.jumps and resolved:
        yield SummaryRow("jumps", "none", "no metric changes abruptly by more than 1 %")
    elif not table.jumps:
        yield SummaryRow("jumps", "not known", "the answer changes too often: see the warning")
    if table.axes[-1].key == EXTREME_KEY:
        yield from _swept_jump_rows(table)
        return
    for at, jump in enumerate(table.jumps[:MAX_NAMED_JUMPS]):
        name = "" if at else "jumps"
        yield SummaryRow(name, f"at {format_number(jump.value, digits=7)}", describe_jump(jump))
    if (left := len(table.jumps) - MAX_NAMED_JUMPS) > 0:
        yield SummaryRow("", f"and {left} more", "all are in drysim.json")


def _swept_jump_rows(table: Table) -> Iterator[SummaryRow]:
    """Yield where the answer jumps in the cases of a sweep, and the largest jump of T_a."""
    if not table.jumps:
        return

    def size(jump: Jump) -> float:
        below, above = jump.below.metrics["T_a"], jump.above.metrics["T_a"]
        return 0.0 if below is None or above is None else abs(below - above)

    low, high = (pick(jump.value for jump in table.jumps) for pick in (min, max))
    largest = max(table.jumps, key=size)
    place = wording.describe_case(largest.point, table.axes)
    count = wording.format_count(len(table.jumps), "jump")
    words = f"{count}, the largest of T_a at {place}: {describe_jump(largest)}"
    yield SummaryRow("jumps", f"at {format_range(low, high, digits=7)}", words)


MAX_NAMED_JUMPS = 6
"""Jumps that are listed one by one."""


JUMPING_METRICS = {"T_a": 5, PEAK_STROKE: 4, "stuck_share": 3}
"""Metrics of both sides of a jump, and their significant digits."""


def describe_jump(jump: Jump) -> str:
    """Describe a jump by the metrics that read differently on both sides."""
    if jump.below.status != jump.above.status:
        return f"{jump.below.status} below, {jump.above.status} above"
    parts = []
    for metric, digits in JUMPING_METRICS.items():
        below, above = (
            format_value(metric, row.metrics.get(metric), digits)
            for row in (jump.below, jump.above)
        )
        if below != above:
            parts.append(f"{label_of(metric)} from {below} to {above}")
    return ", ".join(parts)


def _best_rows(table: Table) -> Iterator[SummaryRow]:
    """Yield the best admissible case of a sweep of designs, and the best over all records."""
    for name, best in table.answers:
        least, style = "", ""
        if best.row is None:
            style = "bold red"
            ends = _main_tally(table).extremes.get(PEAK_STROKE)
            if ends and best.kind == "case":
                where = describe_place(table, ends[0])
                least = (
                    f"; the least {label_of(PEAK_STROKE)} is "
                    f"{format_length(ends[0].value)} {where}"
                )
        yield SummaryRow(name, best.result, best.describe(table.axes, least), style)


def _describe_answer(table: Table) -> str:
    """Return the answer of a sweep of designs in which a check fails; empty without one."""
    for _, best in reversed(table.answers):
        if best.row and any(verdict.passed is False for verdict in table.checks):
            words = f"the best admissible {best.kind}, at {best.place(table.axes)},"
            return f"{words} keeps every check that applies to it"
    return ""


def stroke_rows(table: Table, own: Tally) -> Iterator[SummaryRow]:
    """Yield the greatest stroke and by how much the limit is exceeded."""
    ends, used = own.extremes.get(PEAK_STROKE), own.extremes.get("stroke_used")
    if ends is None:
        return
    peak, share = ends[1], format_percent(ends[1].row.metrics.get("stroke_used"))
    remark = f"{share} of the stroke limit, " if used else ""
    reached = peak.row.metrics.get("stroke_suffices") or 0.0
    if used and reached > peak.value:
        remark = (
            f"{share} of the stroke limit, by {format_length(reached, peak.value)} while "
            "settling, "
        )
    same = is_constant(own, PEAK_STROKE) and not (used and not is_constant(own, "stroke_used"))
    where = describe_extent(table, own, PEAK_STROKE) if same else describe_place(table, peak)
    yield SummaryRow(label_of(PEAK_STROKE), format_length(peak.value), f"{remark}{where}")
    # If the limit is swept, another case may use a greater share of its own.
    if used and format_percent(used[1].value) != share:
        most = format_percent(used[1].value)
        yield SummaryRow(
            "", most, f"largest share of the stroke limit, {describe_place(table, used[1])}"
        )
    if own.beyond:
        cases, remark = format_count(own.beyond, "case"), f"of {own.cases}, "
        if table.scenario.stops and (speed := own.extremes.get("impact_speed")):
            name, value = "stops hit", cases
            words = END_STOP_METRICS["impact_speed"]
            fastest = format_value("impact_speed", speed[1].value)
            remark += f"{words} {fastest}, {describe_place(table, speed[1])}"
        else:
            name, value = "limit", f"exceeded in {cases}"
            remark += _describe_violation(table, own)
        yield SummaryRow(name, value, remark, "bold red")


def _describe_violation(table: Table, own: Tally) -> str:
    """Describe by how much, or when, the stroke limit is exceeded."""
    worst = own.worst
    limits = stroke_limits(table.scenario, worst.point) if worst else None
    if worst is None or limits is None:
        return ""
    if own.seeds:
        return describe_seeds_beyond(worst)
    _, _, beyond = largest_excess(worst.metrics, limits)
    return f"by up to {format_length(beyond, own.greatest('x_r_peak'))}"


def _failure_rows(table: Table) -> Iterator[SummaryRow]:
    """Yield the number of cases without values by status, with the first one."""
    counts: Counter[str] = Counter()
    firsts: dict[str, Row] = {}
    for tally in table.tallies.values():
        for status, (count, first) in tally.lost.items():
            counts[status] += count
            firsts.setdefault(status, first)
    for status, first in firsts.items():
        where = wording.describe_case(first.point, table.axes)
        note = f": {first.note}" if first.note else ""
        cases = format_count(counts[status], "case")
        yield SummaryRow(status, cases, f"first at {where}{note}", "bold red")


def describe_extent(table: Table, own: Tally, metric: str) -> str:
    """Describe where a metric has its minimum and its maximum."""
    if is_constant(own, metric):
        return "the same in every case" + " that has a value" * bool(own.lost)
    least, most = (describe_place(table, end) for end in own.extremes[metric])
    return f"minimum {least}, maximum {most}" if least != most else least


def is_constant(own: Tally, metric: str) -> bool:
    """Whether a metric is the same in several cases, up to rounding."""
    least, most = own.extremes[metric]
    known = own.cases - sum(count for count, _ in own.lost.values())
    return known > 1 and isclose(least.value, most.value, rel_tol=ROUNDING_TOLERANCE)


def describe_place(table: Table, extreme: Extreme) -> str:
    """Describe where an extreme is."""
    return f"at {wording.describe_case(extreme.row.point, table.axes)}"


def _describe_incomplete(done: int, every: int, thing: str) -> str:
    """Describe interrupted work, e.g. `incomplete: 3 of 20 seeds`."""
    return f"incomplete: {done} of {format_count(every, thing)}"


def show_interrupted(kept: int, what: str, folder: Path) -> None:
    """Print on stderr how much of interrupted work was kept, and how to continue."""
    console = stderr()
    if not kept:
        print_line(console, f"interrupted before any {what} was finished")
        return
    cases = f"{format_count(kept, f'finished {what}')} {'is' if kept == 1 else 'are'}"
    print_line(
        console,
        f"interrupted: {cases} kept in {folder}.partial; the same command with --resume "
        "computes only the rest",
    )


# A comparison.

COMPARISON_VALUE_WIDTH = 11
"""Least width of the approach names in the rows of the worst deviations [columns]."""

COMPARISON_METRICS = {
    "T_a": 4, "SEAT": 3, "a_w": 3, "T_x": 3, PEAK_STROKE: 3, "stuck_share": 3,
    "chatter_share": 3,
}  # fmt: skip
"""Metrics in the columns, and their significant digits; approaches are compared by T_a."""

OPTIONAL_COMPARISON_METRICS = ("a_w", "T_x", "chatter_share", PEAK_STROKE)
"""Columns that a narrow terminal omits, in this order."""


def show_comparison(comparison: Comparison, folder: Path | None = None) -> None:
    """Show the summary of a comparison, and the folder of its files, if they were written."""
    console, table = stdout(), comparison.table
    show_title(console, table.scenario)
    show_scene(console, comparison_scene(comparison))
    optional = [label_of(name) for name in OPTIONAL_COMPARISON_METRICS]
    print_table(console, comparison_columns(comparison), ("approach",), optional)
    if table.axes and (places := list(worst_rows(comparison))):
        show_rows(console, places, max(COMPARISON_VALUE_WIDTH, *map(len, table.tallies)) + 1)
    show_verdicts(console, table.checks, table.axes, comparison.yardstick)
    if comparison.verdict:
        print_line(console)
    for at, sentence in enumerate(comparison.verdict):
        for words in wrap(console, sentence, 2):
            print_line(console, ("  ", ""), (words, "" if at else "bold"))
    show_folder(console, folder)
    show_warnings(table.warnings)


def comparison_scene(comparison: Comparison) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was swept, the friction laws, and the reference."""
    yield from sweep_scene(comparison.table)
    yield from _law_lines(comparison)
    yield "reference", comparison.yardstick


def _law_lines(comparison: Comparison) -> Iterator[tuple[str, str]]:
    """Yield label and sentence of every friction law that is compared."""
    scenario = comparison.table.scenario
    names = [name for name, law in comparison.laws.items() if name == law]
    varied = [axis.key for axis in comparison.table.axes]
    for at, name in enumerate(names):
        one, shared = scenario.with_law(name), comparison.table.tallies[name].shared
        terms = one.terms or (f"law {name}",)
        kinetic, static = shared["kinetic"], shared["static"]
        words = wording.describe_friction(
            one.law(), False, kinetic, static, terms, varied, one.ratios
        )
        yield "" if at else "laws", words.removeprefix("law ")


def comparison_columns(comparison: Comparison) -> list[list[str]]:
    """Return the table by columns, header first, without columns that have no value."""
    table = comparison.table
    rows = table.tallies
    found = [_metric_column(table, *metric) for metric in COMPARISON_METRICS.items()]
    worst = _worst_deviations(comparison)
    off = [
        format_deviation(worst[name].value, worst[name].half_width)
        if name in worst
        else NO_VALUE
        for name in rows
    ]
    known = [column for column in found if set(column[1:]) != {NO_VALUE}]
    return [["approach", *rows], *known[:1], ["deviation", *off], *known[1:]]


def _metric_column(table: Table, name: str, digits: int) -> list[str]:
    """Return the column of a metric, header with the unit first."""
    metric = METRICS_BY_NAME[name]
    ends = [own.ends.get(name) for own in table.tallies.values()]
    greatest = max((high for _, high in filter(None, ends)), default=0.0)
    factor, unit = wording.display_unit(metric.shown, greatest)

    def cell(value: float) -> str:
        if metric.kind != SHARE:
            return format_number(value * factor, digits=digits)
        percentage = format_percent(value).removesuffix(" %")
        return percentage.replace("below ", "<").replace("above ", ">")

    cells = []
    for pair in ends:
        low, high = (NO_VALUE, NO_VALUE) if pair is None else map(cell, pair)
        cells.append(low if low == high else f"{low}–{high}")
    return [wording.with_unit(metric.label, unit), *cells]


def _worst_deviations(comparison: Comparison) -> dict[str, Deviation]:
    """Return the greatest deviation of every approach that has one."""
    found = {
        name: compare.largest_deviation(compare.deviations(comparison, name))
        for name in comparison.table.approaches
        if name != comparison.yardstick
    }
    return {name: worst for name, worst in found.items() if worst is not None}


def worst_rows(comparison: Comparison) -> Iterator[SummaryRow]:
    """Yield where the greatest deviations are."""
    found = {
        name: worst for name, worst in _worst_deviations(comparison).items() if worst.value
    }
    for at, (name, worst) in enumerate(found.items()):
        where = wording.describe_case(worst.row.point, comparison.table.axes)
        yield SummaryRow("worst" if at == 0 else "", name, f"at {where}", style="")
