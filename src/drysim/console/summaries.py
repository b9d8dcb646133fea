"""What `drysim run` says of one run, and `drysim summarise` of a result on the disk.

The parts that every summary has stand below: title, scene in words, numbers, verdicts, the
folder, warnings. Summaries of many runs are in `many`, so that one run loads nothing of these.
"""

from __future__ import annotations

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
from drysim.core.model import AnyLaw, EndStopLaw
from drysim.errors import WarningMessage
from drysim.excitation.recorded import Record
from drysim.metrics.checks import Check, Verdict
from drysim.metrics.table import UNITS
from drysim.records.options import SUGGESTED_HIGH_PASS
from drysim.scenario.model import common_period
from drysim.wording import (
    format_count,
    format_length,
    format_number,
    format_percent,
    format_times,
)

if TYPE_CHECKING:
    from drysim.console.terminal import AnyConsole
    from drysim.metrics.table import Metrics
    from drysim.scenario.axes import Axis
    from drysim.scenario.model import Scenario
    from drysim.study.outcome import Outcome

LABEL_WIDTH, RUN_VALUE_WIDTH = 14, 13
"""Columns of the names on the left, and of the values of a run beside them."""

HEADINGS = (
    "metric", "unit", "value", "mean", "±", "least", "5 %", "median", "95 %", "greatest"
)  # fmt: skip
"""What may be told of a metric: of a run its value, of seeds their mean, of cases a range."""

QUANTILE_KEYS = {"5 %": ("0.05", "5 %"), "median": ("0.5", "50 %"), "95 %": ("0.95", "95 %")}
"""Quantiles by what a sweep and what many seeds call them."""

OPTIONAL_SIDECAR_COLUMNS = ("5 %", "95 %", "unit")
"""What a narrow terminal does without."""

Fields = Mapping[str, Any]


class SummaryRow(NamedTuple):
    """A line of a summary: what, how much, and what that means."""

    name: str
    value: str
    remark: str = ""
    style: str = "bold"


def show_outcome(outcome: Outcome, folder: Path | None = None) -> None:
    """Show what came out: the scene, how it was solved, metrics, verdicts, warnings.

    Parameters
    ----------
    outcome : Outcome
    folder : Path, optional
        Where the files were written.
    """
    console = stdout()
    show_title(console, outcome.scenario)
    show_scene(console, run_scene(outcome))
    show_rows(console, _run_rows(outcome), RUN_VALUE_WIDTH)
    show_verdicts(console, outcome.checks)
    show_folder(console, folder)
    show_warnings(outcome.warnings)


def run_scene(outcome: Outcome) -> Iterator[tuple[str, str]]:
    """Give in words what was solved, and how."""
    scenario, response = outcome.scenario, outcome.response
    numerics = response.numerics
    defaulted = not scenario.static_given
    peak = outcome.metrics["x_r_peak"]
    terms = scenario.terms
    yield from wording.describe_scene(response.plant, response.law, defaulted, terms, peak=peak)
    yield "base", wording.describe_excitation(scenario.excitation, response.motion)
    yield from clean_up_lines(wording.describe_clean_up(response.motion, response.law))
    yield "approach", f"{numerics.approach}, {numerics.core} core: {numerics.why}"
    if numerics.period_multiple is not None:
        count = _period_count(outcome, numerics.period_multiple)
        long = "a period" if count == 1 else format_count(count, "period")
        closure = format_number(numerics.closure, digits=2)
        yield "window", f"one repetition of the steady orbit ({long}), closes to {closure}"
    else:
        yield "window", _describe_window(outcome)
    if (found := outcome.spectra) is not None:
        averages = format_count(found.segments, "segment")
        each = format_number(found.segment, "s", 3)
        yield "spectra", f"{averages} of {each}, half overlapping"


def _period_count(outcome: Outcome, multiple: int) -> int:
    """Give how many periods of the base a repetition takes; other forces may need several."""
    base, trajectory = (
        common_period(outcome.scenario.excitation.frequencies),
        outcome.response.trajectory,
    )
    assert trajectory is not None, "an approach gives its response with its track"
    return round(trajectory.end / base) if base else multiple


def _describe_window(outcome: Outcome) -> str:
    """Give the stretch of time that the metrics are of; the output grid may miss its end."""
    settle, duration = outcome.scenario.measure.settle, outcome.scenario.measure.duration
    if duration is None:  # a record ends it, on its grid
        duration = (len(outcome.response) - 1) * outcome.response.dt - settle
    settled = f" after settling for {format_number(settle, 's')}" if settle else ""
    return f"{format_number(duration, 's')}{settled}"


def _run_rows(outcome: Outcome) -> Iterator[SummaryRow]:
    """Give the metrics that matter most, in the units of an engineer."""
    metrics, stroke = outcome.metrics, outcome.scenario.stroke
    a_x, a_u = format_number(metrics["a_x"], "m/s²"), format_number(metrics["a_u"], "m/s²")
    yield SummaryRow("T_a", format_number(metrics["T_a"]), f"mass {a_x} RMS, base {a_u} RMS")
    yield from _comfort_rows(outcome)
    peak = metrics["x_r_peak"]
    x_r, u = format_length(metrics["x_r_rms"], peak), format_length(metrics["u_rms"], peak)
    excitation = outcome.scenario.excitation
    advice = ""
    if isinstance(excitation, Record) and metrics["u_rms"] is None:
        advice = f"; for that, state a high-pass: {excitation.remove.yaml_with(below=SUGGESTED_HIGH_PASS)}"
    yield SummaryRow(
        "T_x", format_number(metrics["T_x"]), f"x_r {x_r} RMS, base displacement {u}{advice}"
    )
    used = format_percent(metrics["stroke_used"])
    limit = (
        f"{used} of the stroke limit of {format_length(stroke.limit, peak)}" if stroke else ""
    )
    yield SummaryRow("peak |x_r|", format_length(peak), limit)
    if metrics["stroke_once_an_hour"] is not None:
        yield _hourly_stroke_row(metrics["stroke_once_an_hour"], outcome.response.law, peak)
    if isinstance(outcome.response.law, EndStopLaw):
        yield from _end_stop_rows(metrics)
    elif metrics["violations"]:
        first = format_number(metrics["t_first_violation"], "s")
        when = f"first at {first}, beyond for {format_number(metrics['t_beyond'], 's')}"
        yield SummaryRow("limit met", format_times(metrics["violations"]), when, "bold red")
    events = format_count(len(outcome.response.events), "event")
    yield SummaryRow("stuck", format_percent(metrics["stuck_share"]), events)
    residual = format_number(metrics["energy_residual"], digits=2)
    yield SummaryRow("energy", residual, "is what the energy balance leaves, relative")
    if (error := outcome.response.numerics.error) is not None:
        bound = "at most, relative to its peak, is the error of x_r"
        yield SummaryRow("error", format_number(error, digits=2), bound)


def _comfort_rows(outcome: Outcome) -> Iterator[SummaryRow]:
    """Give the weighted metrics, where they were asked for."""
    metrics, weights = outcome.metrics, outcome.scenario.measure.weights
    if weights is None or metrics["a_w"] is None:
        return
    SEAT, dose = format_number(metrics["SEAT"]), format_number(metrics["VDV"], "m/s^1.75")
    yield SummaryRow("SEAT", SEAT, f"by dose {format_number(metrics['SEAT_VDV'])}, VDV {dose}")
    how = f"{weights[0]}, k {format_number(weights[1])}"
    highest, crest = (
        format_number(metrics["MTVV"], "m/s²"),
        format_number(metrics["crest_factor"]),
    )
    yield SummaryRow(
        "a_w",
        format_number(metrics["a_w"], "m/s²"),
        f"{how}; MTVV {highest}, crest factor {crest}",
    )


def _hourly_stroke_row(stroke: float, law: AnyLaw, peak: float | None) -> SummaryRow:
    """Give the stroke that is met once an hour, or the rigid stops that end it."""
    how = "met once, extrapolated from the greatest peaks"
    if isinstance(law, EndStopLaw) and law.rigid and stroke == law.x_rM:
        how = "as far as the rigid stops let it"
    return SummaryRow("in an hour", format_length(stroke, peak), how)


def _end_stop_rows(metrics: Metrics) -> Iterator[SummaryRow]:
    """Give how often and how hard the mass came to its end stops."""
    if not metrics["contacts"]:
        yield SummaryRow("end stops", "not met")
        return
    impact = f"at up to {format_number(metrics['impact_speed'], 'm/s')}, "
    if metrics["stop_force_peak"] is None:
        impact += f"{format_number(metrics['impulse_peak'], 'N·s')}"
    else:
        impact += f"pushing with up to {format_number(metrics['stop_force_peak'], 'N')}"
    lost = f"; they take {format_number(metrics['energy_stops'], 'J')}"
    yield SummaryRow("stops met", format_times(metrics["contacts"]), impact + lost, "bold red")


def show_sidecar(fields: Fields) -> None:
    """Show what drysim.json tells of a run, a sweep or a comparison.

    Parameters
    ----------
    told : mapping
        As the file has it.
    """
    console = stdout()
    print_line(console, (wording.sanitise(str(fields["scenario"]["name"])), "bold"))
    show_scene(console, _sidecar_scene(fields))
    # Of many seeds the plain metrics are means; beside them stands how they scatter.
    found = fields.get("ensemble", fields)["metrics"]
    for approach, metrics in _metric_tables(found):
        print_line(console)
        if approach:
            print_line(console, (f"  {approach}", "bold"))
        print_table(
            console, _metric_columns(metrics), ("metric", "unit"), OPTIONAL_SIDECAR_COLUMNS
        )
    if fields["checks"]:
        print_line(console)
    for passed, words in sidecar_checks(fields):
        mark, style = check_mark(passed)
        print_labelled(console, mark, words, style)


def _sidecar_scene(fields: Fields) -> Iterator[tuple[str, str]]:
    """Give what was computed, in words."""
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


def _metric_tables(metrics: Fields) -> Iterator[tuple[str, Fields]]:
    """Give the metrics of every approach of a comparison; of anything else without a name."""
    several = all(isinstance(one, Mapping) and "least" not in one for one in metrics.values())
    yield from metrics.items() if several and metrics else [("", metrics)]


def _metric_columns(metrics: Fields) -> list[list[str]]:
    """Give metrics as a table, column by column."""
    rows = [_metric_row(name, found) for name, found in metrics.items() if name in UNITS]
    known = [row for row in rows if row is not None]
    columns = [list(column) for column in zip(HEADINGS, *known, strict=True)]
    return [column for column in columns if any(column[1:])]


def _metric_row(name: str, found: Any) -> tuple[str, ...] | None:
    """Give the cells of a metric; None where it is not known."""
    if found is None:
        return None
    if not isinstance(found, Mapping):
        found = {"value": found}
    share = found.get("quantiles", {})
    values = {
        "value": found.get("value"),
        "mean": found.get("mean"),
        "±": found.get("half_width"),
        **{end: found[end]["value"] for end in ("least", "greatest") if end in found},
        **{
            head: share.get(one, share.get(other))
            for head, (one, other) in QUANTILE_KEYS.items()
        },
    }
    known = (values.get(head) for head in HEADINGS[2:])
    cells = ("" if one is None else format_number(one) for one in known)
    return name, wording.format_unit(UNITS[name]), *cells


def sidecar_checks(fields: Fields) -> Iterator[tuple[bool | None, str]]:
    """Give what became of every check, and in words what came out and where."""
    numerics = fields.get("numerics", {})
    units = {axis["key"]: axis["unit"] for axis in numerics.get("swept", ())}
    for check in fields.get("checks", ()):
        known = {key: check[key] for key in ("half_width", "seeds", "reason") if key in check}
        comparison, passed = Check.comparison(check["check"]), check["passed"]
        verdict = Verdict(comparison, passed, check["value"], check.get("where"), **known)
        yield passed, describe_verdict(verdict, units, numerics.get("yardstick", ""))


# The parts of every summary.


def show_title(console: AnyConsole, scenario: Scenario) -> None:
    """Show the name of a scenario and what it is about."""
    print_line(console, (wording.sanitise(scenario.name), "bold"))
    if scenario.about:
        print_paragraph(console, "", scenario.about)


def show_scene(console: AnyConsole, words: Iterable[tuple[str, str]]) -> None:
    """Show in words what was solved, and how."""
    print_line(console)
    for name, sentence in words:
        print_labelled(console, name, sentence)


def print_labelled(console: AnyConsole, head: str, sentence: str, style: str = "dim") -> None:
    """Show a sentence beside its head in the column of the names."""
    print_paragraph(console, f"  {head}".ljust(LABEL_WIDTH), sentence, style)


def check_mark(passed: bool | None) -> tuple[str, str]:
    """Give the mark of a check and its style."""
    if passed is None:
        return "· unjudged", "dim"
    return ("✓ holds", "green") if passed else ("✗ fails", "bold red")


def clean_up_lines(sentences: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Give what was done to a record, as words of the scene."""
    for at, sentence in enumerate(sentences):
        yield "" if at else "cleaned", sentence


def show_rows(console: AnyConsole, rows: Iterable[SummaryRow], width: int) -> None:
    """Show numbers, each with its remark behind so many columns, or more for a long number.

    Long remarks are set below.
    """
    rows = list(rows)
    width = max([width, *(len(row.value) + 1 for row in rows if row.remark)])
    print_line(console)
    for row in rows:
        name, value = f"  {row.name}".ljust(LABEL_WIDTH), row.value.ljust(width)
        first, *continuation = wrap(console, row.remark, LABEL_WIDTH + width) or [""]
        print_line(console, (name, "dim"), (value if first else row.value, row.style), first)
        for words in continuation:
            print_line(console, " " * (LABEL_WIDTH + width), words)


def show_verdicts(
    console: AnyConsole, verdicts: Sequence[Verdict], axes: Sequence[Axis] = (), by: str = ""
) -> None:
    """Show what became of the checks, over many cases with the one that decided.

    `by` is the word of a comparison that they are judged by.
    """
    if verdicts:
        print_line(console)
    units = {axis.key: axis.unit for axis in axes}
    for verdict in verdicts:
        mark, style = check_mark(verdict.passed)
        print_labelled(console, mark, describe_verdict(verdict, units, by), style)


def describe_verdict(verdict: Verdict, units: Mapping[str, str], by: str = "") -> str:
    """Give a check with what came out, by which word of a comparison, and where.

    `units` has the unit of every swept key.
    """
    where = wording.describe_point(verdict.where or {}, units)
    parted, place = ";" if verdict.reason else ",", f" at {where}" if where else ""
    return f"{verdict.check}{parted} {verdict.found}{f' by {by}' if by else ''}{place}"


def show_folder(console: AnyConsole, folder: Path | None) -> None:
    """Show where the files were written."""
    if folder is not None:
        print_line(console)
        print_line(console, ("  written".ljust(LABEL_WIDTH), "dim"), str(folder))


def show_warnings(warnings: Sequence[WarningMessage]) -> None:
    """Show warnings on stderr, one sentence each."""
    console = stderr()
    for warning in warnings:
        if console.is_terminal:
            print_paragraph(console, "warning: ", warning.sentence, "yellow")
        else:
            print_line(console, "warning: ", warning.sentence)
