"""Summary of one run (`drysim run`) and of a result on the disk (`drysim summarise`).

The parts shared by all summaries follow below: title, scene, metrics, verdicts, folder,
warnings. Summaries of many runs are in `many`, so that a single run does not import their
modules.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from drysim import wording
from drysim.console.terminal import (
    print_line,
    print_paragraph,
    print_table,
    stderr,
    stdout,
    wrap,
)
from drysim.core.model import EndStops
from drysim.errors import WarningMessage
from drysim.excitation.recorded import Record
from drysim.metrics.checks import Check, Verdict
from drysim.metrics.table import (
    EXPOSURE,
    HOURLY_STROKE,
    METRICS,
    PEAK_STROKE,
    UNITS,
    WEIGHTING,
)
from drysim.metrics.text import (
    format_labelled,
    format_metric,
    format_value,
    label_of,
)
from drysim.records.options import SUGGESTED_HIGH_PASS
from drysim.scenario.model import asks_for_peak_acceleration, common_period
from drysim.study.table import HourlyStroke, hourly_stroke_used
from drysim.wording import (
    describe_limits,
    format_count,
    format_length,
    format_number,
    format_percent,
    format_range,
    format_times_by_side,
)

if TYPE_CHECKING:
    from drysim.console.terminal import AnyConsole
    from drysim.metrics.table import Metrics
    from drysim.scenario.axes import Axis
    from drysim.scenario.model import Scenario
    from drysim.study.branches import BranchesResult
    from drysim.study.design import DesignResult
    from drysim.study.ensemble import Ensemble
    from drysim.study.fit import FitResult
    from drysim.study.outcome import Outcome
    from drysim.study.regimes import RegimeMap
    from drysim.study.table import Table

LABEL_WIDTH, RUN_VALUE_WIDTH = 14, 13
"""Columns of the labels on the left, and of the values of a run next to them."""

HEADINGS = (
    "metric", "unit", "value", "mean", "±", "minimum", "5 %", "median", "95 %", "maximum"
)  # fmt: skip
"""Columns of a metric: its value in a run, mean over seeds, or range over cases."""

NEGLIGIBLE_LOSS = 1e-12
"""Share of the work of the base below which a loss is rounding."""

EXTREME_KEYS = {"minimum": "least", "maximum": "greatest"}
"""Keys of the extremes in drysim.json."""

QUANTILE_KEYS = {"5 %": ("0.05", "5 %"), "median": ("0.5", "50 %"), "95 %": ("0.95", "95 %")}
"""Keys of the quantiles in drysim.json: of a sweep, and of an ensemble."""

OPTIONAL_SIDECAR_COLUMNS = ("5 %", "95 %", "unit")
"""Columns that a narrow terminal omits, in this order."""

Fields = Mapping[str, Any]


class SummaryRow(NamedTuple):
    """A line of a summary: label, value and explanation."""

    name: str
    value: str
    remark: str = ""
    style: str = "bold"


def show_outcome(outcome: Outcome, folder: Path | None = None) -> None:
    """Show the summary of a run, and the folder of its files, if they were written."""
    show_summary(outcome, run_scene(outcome), [run_rows(outcome)], RUN_VALUE_WIDTH, folder)


def run_scene(outcome: Outcome) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was solved, and how."""
    scenario, response = outcome.scenario, outcome.response
    numerics = response.numerics
    peak = outcome.metrics[PEAK_STROKE]
    yield from wording.describe_scene(scenario, response.plant, response.law, peak=peak)
    yield "base", scenario.excitation.describe(response.motion)
    yield from clean_up_lines(wording.describe_clean_up(response.motion, response.law))
    yield "approach", f"{numerics.approach}, {numerics.core} core: {numerics.why}"
    if numerics.period_multiple is not None:
        count = _period_count(outcome, numerics.period_multiple)
        long = format_count(count, "period")
        closure = format_number(numerics.closure, digits=2)
        away = ""
        if numerics.distance is not None:
            away = f", distance to the orbit {format_number(numerics.distance, digits=2)}"
        yield (
            "window",
            f"one repetition of the periodic orbit ({long}), closure {closure}{away}",
        )
    else:
        yield "window", _describe_window(outcome)
    if (found := outcome.spectra) is not None:
        averages = format_count(found.segments, "segment")
        each = format_number(found.segment, "s", 3)
        yield "spectra", f"{averages} of {each}, half overlapping"


def _period_count(outcome: Outcome, multiple: int) -> int:
    """Return the number of base periods in a repetition; a second force may need several."""
    base, trajectory = (
        common_period(outcome.scenario.excitation.frequencies),
        outcome.response.trajectory,
    )
    assert trajectory is not None, "the response of an approach has its trajectory"
    return round(trajectory.end / base) if base else multiple


def _describe_window(outcome: Outcome) -> str:
    """Describe the time window of the metrics."""
    settle, duration = outcome.scenario.measure.settle, outcome.scenario.measure.duration
    response = outcome.response
    dt, motion = response.dt, response.motion
    end = (len(response) - 1) * dt
    if duration is None:  # a record ends the window, on the output grid
        duration = end - settle - getattr(motion, "rest", 0) * dt
    settled = f" after settling for {format_number(settle, 's')}" if settle else ""
    words, left = f"{format_number(duration, 's')}{settled}", end - settle - duration
    if left > 0.5 * dt:
        words += (
            f", then {format_number(left, 's')} of ring-down with the base at rest, which "
            "counts in peaks and stroke"
        )
    return words


def run_rows(outcome: Outcome) -> Iterator[SummaryRow]:
    """Yield the main metrics."""
    metrics, stroke = outcome.metrics, outcome.scenario.stroke
    a_x, a_u = (format_value(name, metrics[name]) for name in ("a_x", "a_u"))
    yield _metric_value_row(metrics, "T_a", f"mass {a_x} RMS, base {a_u} RMS")
    yield from _comfort_rows(outcome)
    peak = metrics[PEAK_STROKE]
    x_r, u = format_length(metrics["x_r_rms"], peak), format_length(metrics["u_rms"], peak)
    excitation = outcome.scenario.excitation
    advice = ""
    duration = (len(outcome.response) - 1) * outcome.response.dt
    if (
        isinstance(excitation, Record)
        and metrics["u_rms"] is None
        and duration * SUGGESTED_HIGH_PASS >= 1.0  # a shorter record has no such frequency
    ):
        high_pass = excitation.remove.yaml_with(below=SUGGESTED_HIGH_PASS)
        advice = f"; it needs a high-pass: {high_pass}"
    yield _metric_value_row(metrics, "T_x", f"x_r {x_r} RMS, base displacement {u}{advice}")
    used = format_percent(metrics["stroke_used"])
    limit = ""
    if stroke:
        limit = f"{used} of the stroke limit of {describe_limits(stroke.limits, peak)}"
        if (reached := metrics["stroke_suffices"] or 0.0) > (peak or 0.0):
            limit += f", by {format_length(reached, peak)} while settling"
        if stroke.limits.up != stroke.limits.down:
            low, high = (format_length(metrics[name], peak) for name in ("x_r_min", "x_r_max"))
            limit = f"x_r from {format_range(low, high)}; {limit}"
    if metrics["x_dd_peak"] is not None and asks_for_peak_acceleration(outcome.scenario):
        yield _metric_value_row(metrics, "x_dd_peak", "both sides of every jump included")
    yield _metric_value_row(metrics, PEAK_STROKE, limit)
    if metrics[HOURLY_STROKE] is not None:
        yield _hourly_stroke_row(outcome, peak)
    if outcome.response.law.stops is not None:
        yield from _end_stop_rows(metrics, outcome.response.law.stops)
    elif stroke and metrics["violations"]:
        first = format_number(metrics["t_first_violation"], "s")
        when = f"first at {first}, for a total of {format_number(metrics['t_beyond'], 's')}"
        count = format_times_by_side(metrics, "violations", stroke.limits)
        yield SummaryRow("limit", f"exceeded {count},", when, "bold red")
    events = format_count(len(outcome.response.events), "event")
    yield _metric_value_row(metrics, "stuck_share", events)
    residual = format_number(metrics["energy_residual"], digits=2)
    yield SummaryRow("energy", f"residual {residual}")
    if (error := outcome.response.numerics.error) is not None:
        what = "estimated error of x_r, relative to its peak"
        yield SummaryRow("error", format_number(error, digits=2), what)
    if (exponent := outcome.response.numerics.lyapunov) is not None:
        interval = format_range(exponent.low, exponent.high)
        over = f"95 % interval {interval} over {format_count(exponent.periods, 'period')}"
        rate = format_number(exponent.value, "1/s")
        yield SummaryRow("lyapunov", rate, f"{exponent.verdict}; {over}")


def _metric_value_row(metrics: Metrics, name: str, remark: str) -> SummaryRow:
    """Return a row with the label and the value of a metric."""
    return SummaryRow(label_of(name), format_value(name, metrics[name]), remark)


COMFORT_ROWS = ("SEAT", "SEAT_VDV", "VDV", "a_w", "MTVV", "crest_factor")
"""Weighted metrics in the two rows of every weighted run; others have a row of their own."""


def _comfort_rows(outcome: Outcome) -> Iterator[SummaryRow]:
    """Yield the frequency-weighted metrics, if requested."""
    metrics, weights = outcome.metrics, outcome.scenario.measure.weights
    if weights is None or metrics["a_w"] is None:
        return

    def listed(*names: str) -> str:
        return ", ".join(format_labelled(name, metrics[name]) for name in names)

    yield _metric_value_row(metrics, "SEAT", listed("SEAT_VDV", "VDV"))
    how = f"{weights[0]}, k {format_number(weights[1])}"
    yield _metric_value_row(metrics, "a_w", f"{how}; {listed('MTVV', 'crest_factor')}")
    for metric in METRICS:
        value = metrics[metric.name]
        if WEIGHTING in metric.needs and metric.name not in COMFORT_ROWS and value is not None:
            about, exposure = metric.about.partition(":")[0], outcome.scenario.measure.exposure
            if EXPOSURE in metric.needs and exposure is not None:
                about += f" for {format_number(exposure / 3600, 'h')} a day"
            yield _metric_value_row(metrics, metric.name, about)


def _hourly_stroke_row(outcome: Outcome, peak: float | None) -> SummaryRow:
    """Return the stroke that is reached once an hour, or the rigid stops that limit it."""
    how, style = "reached once an hour, extrapolated from the largest peaks", "bold"
    stops, block = outcome.response.law.stops, outcome.scenario.stroke
    stroke = outcome.metrics[HOURLY_STROKE]
    if stops is not None and stops.rigid and stroke == max(stops.limits):
        how = "limited by the rigid stops"
    elif block is not None and stops is None:
        used = hourly_stroke_used(outcome.metrics, block.limits)
        how = f"{describe_hourly_use(used, peak)}; {how}"
        style = "bold red" if used.share > 1.0 else style
    return SummaryRow(label_of(HOURLY_STROKE), format_length(stroke, peak), how, style)


def describe_hourly_use(used: HourlyStroke, peak: float | None = None) -> str:
    """Describe the share of a limit reached once an hour, of unequal limits with its place."""
    place = "" if used.limit == "the limit" else f" at {format_length(used.x_r, peak)}"
    return f"{format_percent(used.share)} of {used.limit}{place}"


def _end_stop_rows(metrics: Metrics, stops: EndStops) -> Iterator[SummaryRow]:
    """Yield how often and how hard the mass hit its end stops."""
    if not metrics["contacts"]:
        yield SummaryRow("end stops", "not hit")
        return
    impact = f"at up to {format_value('impact_speed', metrics['impact_speed'])}, "
    if metrics["stop_force_peak"] is None:
        impact += format_value("impulse_peak", metrics["impulse_peak"])
    else:
        impact += f"force up to {format_value('stop_force_peak', metrics['stop_force_peak'])}"
    lost = ""
    if (metrics["energy_stops"] or 0.0) > NEGLIGIBLE_LOSS * abs(metrics["energy_input"] or 0.0):
        lost = f"; energy dissipated {format_value('energy_stops', metrics['energy_stops'])}"
    times = format_times_by_side(metrics, "contacts", stops.limits)
    yield SummaryRow("stops hit", times, impact + lost, "bold red")


def show_sidecar(fields: Fields, console: AnyConsole) -> None:
    """Show the summary of a result from the content of its drysim.json."""
    print_line(console, (wording.sanitise(str(fields["scenario"]["name"])), "bold"))
    show_scene(console, sidecar_scene(fields))
    # Of several seeds the plain metrics are means; `ensemble` has their scatter, too.
    found = fields.get("ensemble", fields)["metrics"]
    for approach, metrics in metric_tables(found):
        print_line(console)
        if approach:
            print_line(console, (f"  {approach}", "bold"))
        print_table(
            console, metric_columns(metrics), ("metric", "unit"), OPTIONAL_SIDECAR_COLUMNS
        )
    if "best" in fields:
        print_line(console)
        for name, words in sidecar_best(fields):
            print_labelled(console, name, words)
    if "design" in fields:
        print_line(console)
        print_labelled(console, "best", sidecar_design(fields["design"]))
    if "map" in fields:
        print_line(console)
        for at, words in enumerate(sidecar_map(fields["map"])):
            print_labelled(console, "" if at else "here", words)
    if fields["checks"]:
        print_line(console)
    for passed, words in sidecar_checks(fields):
        mark, style = check_mark(passed)
        print_labelled(console, mark, words, style)


def sidecar_scene(fields: Fields) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was computed."""
    numerics = fields["numerics"]
    yield "command", str(fields["command"])
    for at, axis in enumerate(numerics.get("swept", ())):
        yield "" if at else "swept", f"{axis['key']} ({axis['values']} values)"
    if "ensemble" in fields:
        seeds = fields["ensemble"]
        yield "seeds", f"{seeds['seeds']}, from {seeds['first']} to {seeds['last']}"
        if seeds["failed"]:
            yield "failed", str(seeds["failed"])
    else:
        statuses = numerics.get("statuses") or {}
        lost = [f"{count} {status}" for status, count in statuses.items() if status != "ok"]
        yield "cases", ", ".join([str(numerics.get("cases", 1)), *lost])
    if not fields["complete"]:
        yield "state", "incomplete"
    if words := describe_metrics(fields):
        yield "metrics", words


def sidecar_best(fields: Fields) -> Iterator[tuple[str, str]]:
    """Yield name and description of the best admissible case, and of that over all records."""
    from drysim.scenario.axes import Axis
    from drysim.study.statistics import Row
    from drysim.study.table import BestCase

    axes = [Axis(axis["key"], axis["unit"], ()) for axis in fields["numerics"]["swept"]]
    best, name, kind = fields["best"], "best", "case"
    while best is not None:
        metrics = {best["metric"]: best["value"]}
        row = None if best["at"] is None else Row(best["at"], "", 0.0, 0.0, metrics)
        closest = _sidecar_verdict(best["closest"]) if "closest" in best else None
        counts = best["admissible"], best["cases"]
        found = BestCase(best["metric"], row, *counts, closest, kind=kind)
        yield name, f"{found.result}, {found.describe(axes)}"
        best, name, kind = best.get("over_records"), "all records", "design"


def sidecar_design(found: Fields) -> str:
    """Return the best design of a study, or the closest one, by its field of drysim.json."""
    units = {key: one["unit"] for key, one in found["vary"].items()}
    one = found["best"] or found["closest"]
    if one is None:
        return "no design has numbers"
    values = ", ".join(
        f"{name} {format_metric(name, value)}" for name, value in one["objectives"].items()
    )
    what = "" if found["best"] else "no design keeps all limits; the closest has "
    what = "the knee of the front, " if found["front"] else what
    return f"{what}{values} at {wording.describe_point(one['values'], units)}"


def describe_metrics(fields: Fields) -> str:
    """Describe whose metrics those of a design study are; empty for another result."""
    found = fields.get("design")
    if found is None:
        return ""
    words: str = (
        "of the best design" if found["best"] else "of the design closest to the limits"
    )
    if place := wording.describe_point(found.get("metrics_at") or {}, swept_units(fields)):
        words += f" at {place}, the condition with the highest {found['minimise'][0]}"
    seeds = fields["numerics"].get("seeds", 1)
    return f"{words}; means of {seeds} seeds" if seeds > 1 else words


def sidecar_conditions(fields: Fields) -> list[list[str]]:
    """Return the shown design of a study under each condition, header first; empty for one."""
    found, units = fields["design"], swept_units(fields)
    if not found.get("conditions"):
        return []
    first = found["conditions"][0]
    limits = [check["check"] for check in first["checks"]]
    limited = {Check.of_result(limit).metric for limit in limits}
    names = [
        name
        for name in first["metrics"]
        if (name in found["minimise"] or name not in limited)
        and any(one["metrics"][name] is not None for one in found["conditions"])
    ]
    table = [["condition", *names, *limits]]
    for one in found["conditions"]:
        values, widths = one["metrics"], one["half_widths"]
        worst = one["at"] == found["metrics_at"]
        place = wording.describe_point(one["at"], units)
        cells = (
            wording.UNKNOWN
            if values[name] is None
            else format_metric(name, values[name], widths[name])
            for name in names
        )
        verdicts = map(_sidecar_verdict, one["checks"])
        judged = (
            f"{check_mark(each.passed)[0][0]} {each.found.removeprefix('with ')}"
            for each in verdicts
        )
        table.append([f"{place} (highest {names[0]})" if worst else place, *cells, *judged])
    return table


def sidecar_branches(found: Fields) -> str:
    """Return the motions at the value of the scenario, by the field of drysim.json."""
    stable = [one for one in found["motions"] if one["stable"]]
    words = "; ".join(
        f"T_a {format_number(one['T_a'], digits=4)}, stroke "
        f"{wording.format_length(one['x_r_peak'])}"
        for one in stable
    )
    if found["own_value"] is None:
        return f"{format_count(len(found['branches']), 'branch')} along {found['key']}."
    place = f"{found['key']} {format_number(found['own_value'])}"
    return f"Stable motions at {place}: {words or 'none found'}."


def sidecar_map(found: Fields) -> Iterator[str]:
    """Yield what a regime map says of the scenario itself, by its field of drysim.json."""
    here, units = found["here"], {axis["key"]: axis["unit"] for axis in found["axes"]}
    if here["motion"]:
        place = wording.describe_point(here["values"], units)
        yield f"At {place}: {'; '.join(here['motion'])}."
    for one in here["nearest"]:
        more = "more" if one["distance"] > 0.0 else "less"
        unit = wording.format_unit(units[one["key"]])
        change = f"{format_number(abs(one['distance']), unit, 3)} {more} {one['key']}"
        yield f"{change}: {one['what']}."


def metric_tables(metrics: Fields) -> Iterator[tuple[str, Fields]]:
    """Yield the metrics of every approach of a comparison; else one unnamed table."""
    several = all(isinstance(one, Mapping) and "least" not in one for one in metrics.values())
    yield from metrics.items() if several else [("", metrics)]


def metric_columns(metrics: Fields) -> list[list[str]]:
    """Return metrics as a table by columns."""
    rows = [_metric_row(name, found) for name, found in metrics.items() if name in UNITS]
    known = [row for row in rows if row is not None]
    columns = [list(column) for column in zip(HEADINGS, *known, strict=True)]
    return [column for column in columns if any(column[1:])]


def _metric_row(name: str, found: Any) -> tuple[str, ...] | None:
    """Return the cells of a metric, None if it has no value."""
    if found is None:
        return None
    if not isinstance(found, Mapping):
        found = {"value": found}
    share = found.get("quantiles", {})
    values = {
        "value": found.get("value"),
        "mean": found.get("mean"),
        "±": found.get("half_width"),
        **{head: found[end]["value"] for head, end in EXTREME_KEYS.items() if end in found},
        **{
            head: share.get(one, share.get(other))
            for head, (one, other) in QUANTILE_KEYS.items()
        },
    }
    known = (values.get(head) for head in HEADINGS[2:])
    cells = ("" if one is None else format_number(one) for one in known)
    return name, wording.format_unit(UNITS[name]), *cells


VERDICT_FIELDS = ("half_width", "seeds", "reason", "failed", "cases")
"""Optional fields of a check in drysim.json."""


def sidecar_checks(fields: Fields) -> Iterator[tuple[bool | None, str]]:
    """Yield whether each check passed (None: not judged), and its description."""
    numerics, units = fields.get("numerics", {}), swept_units(fields)
    for check in fields.get("checks", ()):
        verdict = _sidecar_verdict(check)
        yield verdict.passed, describe_verdict(verdict, units, numerics.get("yardstick", ""))


def swept_units(fields: Fields) -> dict[str, str]:
    """Return the units of the keys that differ between cases, by key."""
    return {axis["key"]: axis["unit"] for axis in fields.get("numerics", {}).get("swept", ())}


def _sidecar_verdict(check: Fields) -> Verdict:
    """Return the verdict of a check in drysim.json."""
    known = {key: check[key] for key in VERDICT_FIELDS if key in check}
    comparison, passed = Check.of_result(check["check"]), check["passed"]
    return Verdict(comparison, passed, check["value"], check.get("where"), **known)


# Every summary and its parts.


def show_summary(
    result: Outcome | Ensemble | Table | FitResult | DesignResult | BranchesResult | RegimeMap,
    scene: Iterable[tuple[str, str]],
    groups: Iterable[Iterable[SummaryRow]],
    width: int,
    folder: Path | None,
    axes: Sequence[Axis] = (),
    fault: tuple[str, str] | None = None,
    answer: str = "",
) -> None:
    """Show title, scene, groups of rows, verdicts, the folder of the files and warnings.

    Parameters
    ----------
    result
    scene : iterable of (str, str)
        Label and sentence: what was solved, and how.
    groups : iterable of iterable of SummaryRow
    width : int
        Least width of the values [columns].
    folder : Path or None
        Where the files were written; not shown for interrupted work.
    axes : sequence of Axis, optional
        Keys that differ between cases.
    fault : tuple of str, optional
        Label and sentence: why the result is not what was asked for.
    answer : str, optional
        What a sweep of designs is for, although a check fails in some cases.
    """
    console = stdout()
    # Of a fit or a design study, `scenario` is what was found.
    show_title(console, getattr(result, "source", None) or result.scenario)
    show_scene(console, scene)
    if fault is not None:
        print_line(console)
        print_labelled(console, *fault, "bold red")
    for rows in map(list, groups):
        if rows:
            show_rows(console, rows, width)
    show_verdicts(console, result.checks, axes)
    if answer:
        print_labelled(console, "✓ best", answer, "green")
    show_folder(console, folder if getattr(result, "complete", True) else None)
    show_warnings(result.warnings)


def show_title(console: AnyConsole, scenario: Scenario) -> None:
    """Print the name and the description of a scenario."""
    print_line(console, (wording.sanitise(scenario.name), "bold"))
    if scenario.about:
        print_paragraph(console, "", scenario.about)


def show_scene(console: AnyConsole, words: Iterable[tuple[str, str]]) -> None:
    """Print labelled sentences: what was solved, and how."""
    print_line(console)
    for name, sentence in words:
        print_labelled(console, name, sentence)


def print_labelled(console: AnyConsole, head: str, sentence: str, style: str = "dim") -> None:
    """Print a sentence next to its label."""
    print_paragraph(console, f"  {head}".ljust(LABEL_WIDTH), sentence, style)


def check_mark(passed: bool | None) -> tuple[str, str]:
    """Return the mark of a check and its style."""
    if passed is None:
        return "· skipped", "dim"
    return ("✓ holds", "green") if passed else ("✗ fails", "bold red")


def clean_up_lines(sentences: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield label and sentence of every cleaning step of a record."""
    for at, sentence in enumerate(sentences):
        yield "" if at else "cleaned", sentence


def show_rows(console: AnyConsole, rows: Sequence[SummaryRow], width: int) -> None:
    """Print rows: label, value, explanation.

    The values take at least `width` columns. An explanation that does not fit continues below.
    """
    label = max([LABEL_WIDTH, *(len(row.name) + 3 for row in rows)])
    width = max([width, *(len(row.value) + 1 for row in rows if row.remark)])
    print_line(console)
    for row in rows:
        name, value = f"  {row.name}".ljust(label), row.value.ljust(width)
        first, *continuation = wrap(console, row.remark, label + width) or [""]
        print_line(console, (name, "dim"), (value if first else row.value, row.style), first)
        for words in continuation:
            print_line(console, " " * (label + width), words)


def show_verdicts(
    console: AnyConsole, verdicts: Sequence[Verdict], axes: Sequence[Axis] = (), by: str = ""
) -> None:
    """Print the verdicts of the checks, over many cases with the deciding one.

    `by` is the approach or law of a comparison that decides.
    """
    if verdicts:
        print_line(console)
    units = {axis.key: axis.unit for axis in axes}
    for verdict in verdicts:
        mark, style = check_mark(verdict.passed)
        print_labelled(console, mark, describe_verdict(verdict, units, by), style)


def describe_verdict(verdict: Verdict, units: Mapping[str, str], by: str = "") -> str:
    """Describe a verdict: check, value, deciding approach or law (`by`), and place.

    `units` maps swept keys to their units.
    """
    where = wording.describe_point(verdict.where or {}, units)
    parted, place = ";" if verdict.reason else ",", f" at {where}" if where else ""
    worst = "" if verdict.reason or not verdict.share else "worst "
    words = f"{verdict.check}{verdict.share}{parted} {worst}{verdict.found}"
    return f"{words}{f' by {by}' if by else ''}{place}"


def show_folder(console: AnyConsole, folder: Path | None) -> None:
    """Print where the files were written."""
    if folder is not None:
        print_line(console)
        print_line(console, ("  written".ljust(LABEL_WIDTH), "dim"), str(folder))


MAX_ALIKE = 3
"""Number of warnings with one slug that are printed, as for the records of a sweep."""


def show_warnings(warnings: Sequence[WarningMessage]) -> None:
    """Print warnings on stderr, one paragraph each; with a hint at a terminal."""
    console = stderr()
    seen: Counter[str] = Counter()
    for warning in warnings:
        seen[warning.slug] += 1
        if seen[warning.slug] > MAX_ALIKE:
            continue
        if console.is_terminal:
            sentence = f"{warning.sentence} (drysim explain {warning.slug})"
            print_paragraph(console, "warning: ", sentence, "yellow")
        else:
            print_line(console, "warning: ", warning.sentence)
    for slug, count in seen.items():
        if count > MAX_ALIKE:
            many = format_count(count - MAX_ALIKE, "more warning")
            print_line(console, "warning: ", f"{many} of the kind {slug}: see drysim.json")
