"""What `drysim run` says of one run, and `drysim summarise` of a result on the disk.

The parts that every summary has stand below: title, scene in words, numbers, verdicts, the
folder, warnings. Summaries of many runs are in `many`, so that one run loads nothing of these.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from drysim import wording
from drysim.console.terminal import folded, line, paragraph, show_columns, stderr, stdout
from drysim.core.model import AnyLaw, Stopped
from drysim.errors import Caution
from drysim.excitation.recorded import Record
from drysim.metrics.checks import Check, Verdict
from drysim.metrics.table import UNITS
from drysim.records.options import HIGH_PASS
from drysim.scenario.model import common_period
from drysim.wording import length, number, percent, several, times

if TYPE_CHECKING:
    from drysim.console.terminal import Paper
    from drysim.metrics.table import Metrics
    from drysim.scenario.axes import Axis
    from drysim.scenario.model import Scenario
    from drysim.study.outcome import Outcome

HEAD, RUN_VALUE = 14, 13
"""Columns of the names on the left, and of the values of a run beside them."""

HEADINGS = (
    "metric", "unit", "value", "mean", "±", "least", "5 %", "median", "95 %", "greatest"
)  # fmt: skip
"""What may be told of a metric: of a run its value, of seeds their mean, of cases a range."""

SHARES = {"5 %": ("0.05", "5 %"), "median": ("0.5", "50 %"), "95 %": ("0.95", "95 %")}
"""Quantiles by what a sweep and what many seeds call them."""

RETOLD_SPARED = ("5 %", "95 %", "unit")
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
    paper = stdout()
    show_title(paper, outcome.scenario)
    show_scene(paper, scene(outcome))
    show_rows(paper, _run_rows(outcome), RUN_VALUE)
    show_verdicts(paper, outcome.checks)
    show_folder(paper, folder)
    show_warnings(outcome.warnings)


def scene(outcome: Outcome) -> Iterator[tuple[str, str]]:
    """Give in words what was solved, and how."""
    scenario, response = outcome.scenario, outcome.response
    numerics = response.numerics
    defaulted = not scenario.static_given
    peak = outcome.metrics["x_r_peak"]
    terms = scenario.terms
    yield from wording.scene(response.plant, response.law, defaulted, terms, peak=peak)
    yield "base", wording.excitation(scenario.excitation, response.motion)
    yield from steps(wording.clean_up(response.motion, response.law))
    yield "approach", f"{numerics.approach}, {numerics.core} core: {numerics.why}"
    if numerics.period_multiple is not None:
        count = _periods(outcome, numerics.period_multiple)
        long = "a period" if count == 1 else several(count, "period")
        closure = number(numerics.closure, digits=2)
        yield "window", f"one repetition of the steady orbit ({long}), closes to {closure}"
    else:
        yield "window", _window(outcome)
    if (found := outcome.spectra) is not None:
        averages = several(found.segments, "segment")
        each = number(found.segment, "s", 3)
        yield "spectra", f"{averages} of {each}, half overlapping"


def _periods(outcome: Outcome, multiple: int) -> int:
    """Give how many periods of the base a repetition takes; other forces may need several."""
    base, track = common_period(outcome.scenario.excitation.frequencies), outcome.response.track
    assert track is not None, "an approach gives its response with its track"
    return round(track.end / base) if base else multiple


def _window(outcome: Outcome) -> str:
    """Give the stretch of time that the metrics are of; the output grid may miss its end."""
    settle, duration = outcome.scenario.measure.settle, outcome.scenario.measure.duration
    if duration is None:  # a record ends it, on its grid
        duration = (len(outcome.response) - 1) * outcome.response.dt - settle
    settled = f" after settling for {number(settle, 's')}" if settle else ""
    return f"{number(duration, 's')}{settled}"


def _run_rows(outcome: Outcome) -> Iterator[SummaryRow]:
    """Give the metrics that matter most, in the units of an engineer."""
    metrics, stroke = outcome.metrics, outcome.scenario.stroke
    a_x, a_u = number(metrics["a_x"], "m/s²"), number(metrics["a_u"], "m/s²")
    yield SummaryRow("T_a", number(metrics["T_a"]), f"mass {a_x} RMS, base {a_u} RMS")
    yield from _felt(outcome)
    peak = metrics["x_r_peak"]
    x_r, u = length(metrics["x_r_rms"], peak), length(metrics["u_rms"], peak)
    excitation = outcome.scenario.excitation
    way = ""
    if isinstance(excitation, Record) and metrics["u_rms"] is None:
        way = f"; for that, state a high-pass: {excitation.remove.with_too(below=HIGH_PASS)}"
    yield SummaryRow(
        "T_x", number(metrics["T_x"]), f"x_r {x_r} RMS, base displacement {u}{way}"
    )
    used = percent(metrics["stroke_used"])
    limit = f"{used} of the stroke limit of {length(stroke.limit, peak)}" if stroke else ""
    yield SummaryRow("peak |x_r|", length(peak), limit)
    if metrics["stroke_once_an_hour"] is not None:
        yield _hourly(metrics["stroke_once_an_hour"], outcome.response.law, peak)
    if isinstance(outcome.response.law, Stopped):
        yield from _hits(metrics)
    elif metrics["violations"]:
        first = number(metrics["t_first_violation"], "s")
        when = f"first at {first}, beyond for {number(metrics['t_beyond'], 's')}"
        yield SummaryRow("limit met", times(metrics["violations"]), when, "bold red")
    events = several(len(outcome.response.events), "event")
    yield SummaryRow("stuck", percent(metrics["stuck_share"]), events)
    residual = number(metrics["energy_residual"], digits=2)
    yield SummaryRow("energy", residual, "is what the energy balance leaves, relative")
    if (error := outcome.response.numerics.error) is not None:
        bound = "at most, relative to its peak, is the error of x_r"
        yield SummaryRow("error", number(error, digits=2), bound)


def _felt(outcome: Outcome) -> Iterator[SummaryRow]:
    """Give the weighted metrics, where they were asked for."""
    metrics, weights = outcome.metrics, outcome.scenario.measure.weights
    if weights is None or metrics["a_w"] is None:
        return
    SEAT, dose = number(metrics["SEAT"]), number(metrics["VDV"], "m/s^1.75")
    yield SummaryRow("SEAT", SEAT, f"by dose {number(metrics['SEAT_VDV'])}, VDV {dose}")
    how = f"{weights[0]}, k {number(weights[1])}"
    highest, crest = number(metrics["MTVV"], "m/s²"), number(metrics["crest_factor"])
    yield SummaryRow(
        "a_w", number(metrics["a_w"], "m/s²"), f"{how}; MTVV {highest}, crest factor {crest}"
    )


def _hourly(stroke: float, law: AnyLaw, peak: float | None) -> SummaryRow:
    """Give the stroke that is met once an hour, or the rigid stops that end it."""
    how = "met once, extrapolated from the greatest peaks"
    if isinstance(law, Stopped) and law.rigid and stroke == law.x_rM:
        how = "as far as the rigid stops let it"
    return SummaryRow("in an hour", length(stroke, peak), how)


def _hits(metrics: Metrics) -> Iterator[SummaryRow]:
    """Give how often and how hard the mass came to its end stops."""
    if not metrics["contacts"]:
        yield SummaryRow("end stops", "not met")
        return
    hardest = f"at up to {number(metrics['impact_speed'], 'm/s')}, "
    if metrics["stop_force_peak"] is None:
        hardest += f"{number(metrics['impulse_peak'], 'N·s')}"
    else:
        hardest += f"pushing with up to {number(metrics['stop_force_peak'], 'N')}"
    lost = f"; they take {number(metrics['energy_stops'], 'J')}"
    yield SummaryRow("stops met", times(metrics["contacts"]), hardest + lost, "bold red")


def show_retold(told: Fields) -> None:
    """Show what drysim.json tells of a run, a sweep or a comparison.

    Parameters
    ----------
    told : mapping
        As the file has it.
    """
    paper = stdout()
    line(paper, (wording.clean(str(told["scenario"]["name"])), "bold"))
    show_scene(paper, _told_scene(told))
    # Of many seeds the plain metrics are means; beside them stands how they scatter.
    found = told.get("ensemble", told)["metrics"]
    for approach, metrics in _tables(found):
        line(paper)
        if approach:
            line(paper, (f"  {approach}", "bold"))
        show_columns(paper, _columns(metrics), ("metric", "unit"), RETOLD_SPARED)
    if told["checks"]:
        line(paper)
    for passed, words in told_checks(told):
        mark, style = judged(passed)
        headed(paper, mark, words, style)


def _told_scene(told: Fields) -> Iterator[tuple[str, str]]:
    """Give what was computed, in words."""
    numerics = told["numerics"]
    yield "command", str(told["command"])
    for at, axis in enumerate(numerics.get("swept", ())):
        yield "" if at else "swept", f"{axis['key']} ({axis['values']} values)"
    if "ensemble" in told:
        seeds = told["ensemble"]
        yield "seeds", f"{seeds['seeds']}, from {seeds['first']} to {seeds['last']}"
        if seeds["failed"]:
            yield "failed", str(seeds["failed"])
    else:
        statuses = numerics.get("statuses") or {}
        lost = [f"{count} {status}" for status, count in statuses.items() if status != "ok"]
        yield "cases", ", ".join([str(numerics.get("cases", 1)), *lost])
    if not told["complete"]:
        yield "state", "incomplete"


def _tables(metrics: Fields) -> Iterator[tuple[str, Fields]]:
    """Give the metrics of every approach of a comparison; of anything else without a name."""
    several = all(isinstance(one, Mapping) and "least" not in one for one in metrics.values())
    yield from metrics.items() if several and metrics else [("", metrics)]


def _columns(metrics: Fields) -> list[list[str]]:
    """Give metrics as a table, column by column."""
    rows = [_row(name, found) for name, found in metrics.items() if name in UNITS]
    known = [row for row in rows if row is not None]
    columns = [list(column) for column in zip(HEADINGS, *known, strict=True)]
    return [column for column in columns if any(column[1:])]


def _row(name: str, found: Any) -> tuple[str, ...] | None:
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
        **{head: share.get(one, share.get(other)) for head, (one, other) in SHARES.items()},
    }
    known = (values.get(head) for head in HEADINGS[2:])
    cells = ("" if one is None else number(one) for one in known)
    return name, wording.pretty(UNITS[name]), *cells


def told_checks(told: Fields) -> Iterator[tuple[bool | None, str]]:
    """Give what became of every check, and in words what came out and where."""
    numerics = told.get("numerics", {})
    units = {axis["key"]: axis["unit"] for axis in numerics.get("swept", ())}
    for check in told.get("checks", ()):
        known = {key: check[key] for key in ("half_width", "seeds", "reason") if key in check}
        promise, passed = Check.promise(check["check"]), check["passed"]
        verdict = Verdict(promise, passed, check["value"], check.get("where"), **known)
        yield passed, finding(verdict, units, numerics.get("yardstick", ""))


# The parts of every summary.


def show_title(paper: Paper, scenario: Scenario) -> None:
    """Show the name of a scenario and what it is about."""
    line(paper, (wording.clean(scenario.name), "bold"))
    if scenario.about:
        paragraph(paper, "", scenario.about)


def show_scene(paper: Paper, words: Iterable[tuple[str, str]]) -> None:
    """Show in words what was solved, and how."""
    line(paper)
    for name, sentence in words:
        headed(paper, name, sentence)


def headed(paper: Paper, head: str, sentence: str, style: str = "dim") -> None:
    """Show a sentence beside its head in the column of the names."""
    paragraph(paper, f"  {head}".ljust(HEAD), sentence, style)


def judged(passed: bool | None) -> tuple[str, str]:
    """Give the mark of a check and its style."""
    if passed is None:
        return "· unjudged", "dim"
    return ("✓ holds", "green") if passed else ("✗ fails", "bold red")


def steps(sentences: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Give what was done to a record, as words of the scene."""
    for at, sentence in enumerate(sentences):
        yield "" if at else "cleaned", sentence


def show_rows(paper: Paper, rows: Iterable[SummaryRow], width: int) -> None:
    """Show numbers, each with its remark behind so many columns, or more for a long number.

    Long remarks are set below.
    """
    rows = list(rows)
    width = max([width, *(len(row.value) + 1 for row in rows if row.remark)])
    line(paper)
    for row in rows:
        name, value = f"  {row.name}".ljust(HEAD), row.value.ljust(width)
        first, *further = folded(paper, row.remark, HEAD + width) or [""]
        line(paper, (name, "dim"), (value if first else row.value, row.style), first)
        for words in further:
            line(paper, " " * (HEAD + width), words)


def show_verdicts(
    paper: Paper, verdicts: Sequence[Verdict], axes: Sequence[Axis] = (), by: str = ""
) -> None:
    """Show what became of the checks, over many cases with the one that decided.

    `by` is the word of a comparison that they are judged by.
    """
    if verdicts:
        line(paper)
    units = {axis.key: axis.unit for axis in axes}
    for verdict in verdicts:
        mark, style = judged(verdict.passed)
        headed(paper, mark, finding(verdict, units, by), style)


def finding(verdict: Verdict, units: Mapping[str, str], by: str = "") -> str:
    """Give a check with what came out, by which word of a comparison, and where.

    `units` has the unit of every swept key.
    """
    where = wording.located(verdict.where or {}, units)
    parted, place = ";" if verdict.reason else ",", f" at {where}" if where else ""
    return f"{verdict.check}{parted} {verdict.found}{f' by {by}' if by else ''}{place}"


def show_folder(paper: Paper, folder: Path | None) -> None:
    """Show where the files were written."""
    if folder is not None:
        line(paper)
        line(paper, ("  written".ljust(HEAD), "dim"), str(folder))


def show_warnings(warnings: Sequence[Caution]) -> None:
    """Show warnings on stderr, one sentence each."""
    paper = stderr()
    for caution in warnings:
        if paper.is_terminal:
            paragraph(paper, "warning: ", caution.sentence, "yellow")
        else:
            line(paper, "warning: ", caution.sentence)
