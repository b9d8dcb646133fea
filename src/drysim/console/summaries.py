"""Run, ensemble, sweep."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import isclose
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from drysim import wording
from drysim.console.terminal import folded, line, paragraph, stderr, stdout
from drysim.core.model import AnyLaw, Stopped
from drysim.errors import Caution
from drysim.excitation.recorded import Record
from drysim.records.options import HIGH_PASS, Removal
from drysim.scenario.model import STATIC, common_period
from drysim.study import compare, run
from drysim.study.plan import approaches_of
from drysim.study.rows import HELD, OK
from drysim.study.statistics import most, until_of
from drysim.study.table import Tally, stroke_limit
from drysim.wording import around, length, number, percent, seeds, several, times, told_in

if TYPE_CHECKING:
    from drysim.console.terminal import Paper
    from drysim.metrics import Metrics
    from drysim.metrics.checks import Verdict
    from drysim.scenario.axes import Axis
    from drysim.scenario.model import Scenario
    from drysim.study import rows
    from drysim.study.compare import Isolation
    from drysim.study.ensemble import Ensemble
    from drysim.study.outcome import Outcome
    from drysim.study.statistics import Statistic
    from drysim.study.table import Extreme, Seeds, Table


# The parts of every summary: title, words, numbers, verdicts, warnings, the folder.


HEAD = 14
"""Columns of the names on the left."""


class SummaryRow(NamedTuple):
    """A line of a summary: what, how much, and what that means."""

    name: str
    value: str
    remark: str = ""
    style: str = "bold"


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


def unfinished(done: int, every: int, thing: str) -> str:
    """Give the state of what was interrupted, e.g. `incomplete: 3 of 20 seeds`."""
    return f"incomplete: {done} of {several(every, thing)}"


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


# The summary of an outcome: scene, approach, metrics, verdicts, warnings.


RECORD = "record"
RUN_VALUE = 13
"""Columns of the values beside the names."""


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


def _hourly(stroke: float, law: AnyLaw, peak: float | None) -> SummaryRow:
    """Give the stroke that is met once an hour, or the rigid stops that end it."""
    how = "met once, extrapolated from the greatest peaks"
    if isinstance(law, Stopped) and law.rigid and stroke == law.x_rM:
        how = "as far as the rigid stops let it"
    return SummaryRow("in an hour", length(stroke, peak), how)


def _high_pass(outcome: Outcome) -> str:
    """Say what makes the displacement of a record of acceleration or velocity known."""
    excitation = outcome.scenario.excitation
    removal = excitation.remove if isinstance(excitation, Record) else Removal()
    return f"for that, state a high-pass: {removal.with_too(below=HIGH_PASS)}"


def _run_rows(outcome: Outcome) -> Iterator[SummaryRow]:
    """Give the metrics that matter most, in the units of an engineer."""
    metrics, stroke = outcome.metrics, outcome.scenario.stroke
    a_x, a_u = number(metrics["a_x"], "m/s²"), number(metrics["a_u"], "m/s²")
    yield SummaryRow("T_a", number(metrics["T_a"]), f"mass {a_x} RMS, base {a_u} RMS")
    yield from _felt(outcome)
    peak = metrics["x_r_peak"]
    x_r, u = length(metrics["x_r_rms"], peak), length(metrics["u_rms"], peak)
    record = outcome.scenario.excitation.kind == RECORD
    way = f"; {_high_pass(outcome)}" if record and metrics["u_rms"] is None else ""
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


# The summary of many seeds: what was drawn, means with their intervals, verdicts, warnings.


ENSEMBLE_VALUE = 22
"""Columns of the values beside the names."""

MAIN = (
    ("T_a", "T_a", ""),
    ("SEAT", "SEAT", ""),
    ("a_w", "a_w", "m/s²"),
    ("T_x", "T_x", ""),
    ("peak |x_r|", "x_r_peak", "m"),
    ("in an hour", "stroke_once_an_hour", "m"),
    ("stuck", "stuck_share", "%"),
)
"""Name, metric and unit of the rows."""


HITS = (
    ("impact_speed", "m/s", "at up to"),
    ("stop_force_peak", "N", "pushing with up to"),
    ("impulse_peak", "N·s", "with an impulse of up to"),
)
"""Metric, unit and words of how hard end stops are met."""

FEWEST = 13
"""Seeds from which on the quantiles of 5 and 95 % are others than the least and greatest."""


def show_ensemble(ensemble: Ensemble, folder: Path | None = None) -> None:
    """Show what came out of many seeds.

    Parameters
    ----------
    ensemble : Ensemble
    folder : Path, optional
        Where the files were written.
    """
    paper = stdout()
    show_title(paper, ensemble.scenario)
    show_scene(paper, _scene(ensemble))
    show_rows(paper, _ensemble_rows(ensemble), ENSEMBLE_VALUE)
    show_verdicts(paper, ensemble.checks)
    if ensemble.complete:
        show_folder(paper, folder)
    show_warnings(ensemble.warnings)


def _scene(ensemble: Ensemble) -> Iterator[tuple[str, str]]:
    """Give in words what was solved, and with which seeds."""
    for name, words in scene(ensemble.shown):
        yield name, words
        if name == "base":
            until = until_of(ensemble.scenario)
            yield "seeds", seeds(ensemble.seeds, until)
            if not ensemble.complete:
                yield "state", unfinished(len(ensemble.rows), most(ensemble.scenario), "seed")


def _ensemble_rows(ensemble: Ensemble) -> Iterator[SummaryRow]:
    """Give the metrics that matter most, and the one that decided when to stop."""
    until = until_of(ensemble.scenario)
    rows, good = list(MAIN), sum(row.status == OK for row in ensemble.rows)
    peak = ensemble.statistics["x_r_peak"]
    beside = peak.greatest[0] if peak else 0.0
    if until and until.metric not in {metric for _, metric, _ in MAIN}:
        rows.append((until.metric, until.metric, ""))
    for name, metric, given in rows:
        found = ensemble.statistics[metric]
        wished = until is not None and metric == until.metric
        # What only some seeds know is a mean over chosen ones; drysim.json has it.
        if found is not None and (wished or found.seeds == good):
            scale, unit = told_in(given, found.greatest[0], beside)
            width = None if found.half_width is None else found.half_width * scale
            words = around(found.mean * scale, width, unit)
            yield SummaryRow(
                name, words, "; ".join(_remarks(ensemble, metric, found, scale, unit))
            )
    yield from _limit(ensemble)
    residual = ensemble.statistics["energy_residual"]
    if residual:
        words = number(residual.greatest[0], digits=2)
        yield SummaryRow("energy", words, "is the most that an energy balance leaves, relative")
    if lost := sum(row.status != OK for row in ensemble.rows):
        yield SummaryRow("failed", several(lost, "seed"), style="bold red")


def _remarks(
    ensemble: Ensemble, metric: str, found: Statistic, scale: float, unit: str
) -> Iterator[str]:
    """Give how a metric scatters from seed to seed."""
    low, high = (found.quantiles[at] * scale for at in (0, -1))
    if number(low) != number(high):
        which = "9 of 10" if found.seeds >= FEWEST else f"all {found.seeds}"
        yield f"{which} seeds from {number(low)} to {number(high, unit)}"
    if found.seeds < len(ensemble.rows):
        yield f"known with {found.seeds} of {len(ensemble.rows)} seeds"
    if metric == "x_r_peak" and (stroke := ensemble.scenario.stroke):
        value, seed = found.greatest
        used = percent(value / stroke.limit)
        yield f"most with seed {seed}, {used} of the stroke limit"


def _limit(ensemble: Ensemble) -> Iterator[SummaryRow]:
    """Give how many seeds meet the stroke limit, and how hard where there are end stops."""
    beyond = sum(bool(row.metrics.get("violations")) for row in ensemble.rows)
    if beyond:
        name, how = "limit met", [f"of {len(ensemble.rows)}"]
        for metric, unit, words in HITS:
            if (found := ensemble.statistics.get(metric)) and found.greatest[0] > 0:
                value, seed = found.greatest
                name = "stops met"
                how.append(f"{words} {number(value, unit)} with seed {seed}")
        yield SummaryRow(name, several(beyond, "seed"), ", ".join(how), "bold red")


# What the summary of many cases says of means over seeds, and of the stroke.
#
# Each case is held to its own stroke limit.


ROUNDING = 1e-9
"""Difference of extremes, relative to them, that says nothing about where they are [-]."""


def swept_seeds(scenario: Scenario, found: Seeds | None) -> str:
    """Give which seeds every case has; nothing where none has many."""
    if found is None:
        return ""
    first: int = getattr(scenario.excitation, "seed", 1)
    until = until_of(scenario)
    counts = sorted({found.least, found.most})
    return wording.seeds(range(first, first + found.most), until, counts)


def known(axes: Sequence[Axis], found: Seeds | None, metric: str) -> Iterator[SummaryRow]:
    """Give how well the means of a metric are known at the worst."""
    row = found.widest.get(metric) if found else None
    if row is not None:
        width = row.half_widths[metric]
        mean, where = row.metrics.get(metric), wording.place(row.point, axes)
        words = f"at the worst: {wording.around(mean, width)} at {where}"
        yield SummaryRow("", f"± {wording.number(width, digits=2)}", words)


def alike(own: Tally, metric: str) -> bool:
    """Whether a metric is the same in several cases, but for rounding."""
    least, most = own.extremes[metric]
    known = own.cases - sum(count for count, _ in own.lost.values())
    return known > 1 and isclose(least.value, most.value, rel_tol=ROUNDING)


def extent(table: Table, own: Tally, metric: str) -> str:
    """Return where a metric is least and greatest, in words."""
    if alike(own, metric):
        return "the same in every case" + " that has numbers" * bool(own.lost)
    least, most = (at(table, end) for end in own.extremes[metric])
    return f"least {least}, greatest {most}" if least != most else least


def stroke(table: Table, own: Tally) -> Iterator[SummaryRow]:
    """Give the greatest stroke, and by how much the limit is met."""
    ends, used = own.extremes.get("x_r_peak"), own.extremes.get("stroke_used")
    if ends is None:
        return
    peak, share = ends[1], percent(ends[1].row.metrics.get("stroke_used"))
    remark = f"{share} of the stroke limit, " if used else ""
    same = alike(own, "x_r_peak") and not (used and not alike(own, "stroke_used"))
    where = extent(table, own, "x_r_peak") if same else at(table, peak)
    yield SummaryRow("peak |x_r|", length(peak.value), f"{remark}{where}")
    # Where the limit is swept, another case may use more of its own.
    if used and percent(used[1].value) != share:
        most = percent(used[1].value)
        yield SummaryRow("", most, f"of the stroke limit at the most, {at(table, used[1])}")
    if own.beyond:
        name, remark = _met(table, own)
        yield SummaryRow(
            name, several(own.beyond, "case"), f"of {own.cases}, {remark}", "bold red"
        )


def _met(table: Table, own: Tally) -> tuple[str, str]:
    """Give what was met and how hard or how far."""
    ends, worst = own.extremes.get("impact_speed"), own.worst
    if ends and table.scenario.stops:
        return "stops met", f"at up to {number(ends[1].value, 'm/s')}, {at(table, ends[1])}"
    limit = stroke_limit(table.scenario, worst) if worst else None
    if own.seeds or worst is None or limit is None:
        return "limit met", "with some of the seeds"
    peak = worst.metrics["x_r_peak"] or 0.0
    if peak < limit:
        return "limit met", "while it settles"
    return "limit met", f"{length(peak - limit, own.greatest('x_r_peak'))} too far at the worst"


def at(table: Table, extreme: Extreme) -> str:
    """Give where an extreme is."""
    return f"at {wording.place(extreme.row.point, table.axes)}"


# The summary of a sweep: what was swept, extremes with where, isolation, what is missing.


TABLE_VALUE = 20
"""Columns of the values beside the names."""

DIGITS = 3
"""Digits of the ends of a range."""

NAMED = 4
"""Curves whose isolation is told one by one."""


def show_table(table: Table, folder: Path | None = None) -> None:
    """Show what a sweep came to.

    Parameters
    ----------
    table : Table
    folder : Path, optional
        Where the files were written.
    """
    paper = stdout()
    show_title(paper, table.scenario)
    show_scene(paper, sweep_scene(table))
    show_rows(paper, _table_rows(table), TABLE_VALUE)
    show_verdicts(paper, table.checks, table.axes)
    if table.complete:
        show_folder(paper, folder)
    show_warnings(table.warnings)


def show_interrupted(kept: int, what: str, folder: Path) -> None:
    """Say on stderr what was kept of interrupted work, cases or seeds, and how it goes on."""
    paper = stderr()
    if not kept:
        line(paper, f"interrupted before any {what} was finished")
        return
    cases = f"{several(kept, f'finished {what}')} {'is' if kept == 1 else 'are'}"
    line(
        paper,
        f"interrupted: {cases} kept in {folder}.partial; the same command with --resume "
        "computes only the rest",
    )


def sweep_scene(table: Table) -> Iterator[tuple[str, str]]:
    """Give in words what was swept, and what was not."""
    scenario, axes = table.scenario, table.axes
    varied = [axis.key for axis in axes]
    limits = {f"friction.{key}" for key in STATIC}
    defaulted = not limits & {*varied} and not scenario.static_given
    plant, law, shared = scenario.oscillator.plant(), scenario.law(), _own(table).shared
    ratios, base = scenario.ratios, scenario.excitation
    peak = _own(table).greatest("x_r_peak")
    yield from wording.scene(
        plant, law, defaulted, scenario.terms, varied, shared, ratios, peak
    )
    fixed = table.motion and not any(key.startswith("excitation.") for key in varied)
    if table.motion and fixed:
        yield "base", wording.excitation(base, table.motion)
    else:
        yield "base", wording.excitations(base, varied)
    yield from steps(wording.clean_up(table.motion) if fixed else ())
    if words := swept_seeds(scenario, _own(table).seeds):
        yield "seeds", words
    for i, axis in enumerate(axes):
        yield "" if i else "swept", wording.swept(axis)
    counts = (f"{tally.cases} by {name}" for name, tally in table.tallies.items())
    yield "cases", ", ".join(counts)
    if not table.complete:
        yield "state", unfinished(len(table.rows), run.count(approaches_of(scenario)), "case")


def _own(table: Table) -> Tally:
    """Give what the cases of the approach come to that was asked for."""
    return next(iter(table.tallies.values()), Tally(table.scenario.solver.approach))


def _table_rows(table: Table) -> Iterator[SummaryRow]:
    """Give the numbers that matter most, in the units of an engineer."""
    own = _own(table)
    for metric in ("T_a", "SEAT", "T_x"):
        if ends := own.extremes.get(metric):
            values = span(*(number(end.value, digits=DIGITS) for end in ends))
            yield SummaryRow(metric, values, extent(table, own, metric))
            yield from known(table.axes, own.seeds, metric)
    # Where the frequency is drawn together with other keys, a curve is a single case.
    over_frequency = any(
        axis.key == compare.FREQUENCY and len(axis.values) > 1 and not axis.walk
        for axis in table.axes
    )
    if over_frequency and "T_a" in own.extremes and own.cases <= HELD:
        yield _isolation(table, compare.isolation(table.own))
    yield from stroke(table, own)
    if ends := own.extremes.get("stuck_share"):
        remark = f"most {at(table, ends[1])}" if ends[1].value else ""
        if remark and alike(own, "stuck_share"):
            remark = extent(table, own, "stuck_share")
        yield SummaryRow("stuck", span(*(percent(end.value) for end in ends)), remark)
    if ends := own.extremes.get("energy_residual"):
        residual = number(ends[1].value, digits=2)
        yield SummaryRow(
            "energy", residual, "is the most that an energy balance leaves, relative"
        )
    yield from _missing(table)


def _isolation(table: Table, found: Sequence[Isolation]) -> SummaryRow:
    """Give from which frequency on the seat isolates, on every curve that ever does."""
    begins = [one.above for one in found if one.above is not None]
    if not begins:
        return SummaryRow(
            "isolation", "nowhere", "T_a does not stay below 1 up to the end of a curve"
        )
    first, last, remark = min(begins), max(begins), "T_a stays below 1"
    alike = first == last and len(begins) == len(found)
    if not alike and len(found) <= NAMED:
        remark += ": " + "; ".join(
            f"{wording.place(one.point, table.axes)} "
            + ("nowhere" if one.above is None else f"from {number(one.above, 'Hz')}")
            for one in found
        )
    elif not alike:
        lost = len(begins) < len(found)
        curves = f"{len(begins)} of {len(found)}" if lost else f"all {len(found)}"
        remark += f" on {curves} curves" + ", nowhere on the others" * lost
        if first < last:
            remark += f"; on {begins.count(first)} of them from {number(first, 'Hz')}"
    return SummaryRow("isolation", f"from {number(last, 'Hz')}", remark)


def _missing(table: Table) -> Iterator[SummaryRow]:
    """Count and name the cases that have no numbers."""
    counts: Counter[str] = Counter()
    firsts: dict[str, rows.Row] = {}
    for tally in table.tallies.values():
        for status, (count, first) in tally.lost.items():
            counts[status] += count
            firsts.setdefault(status, first)
    for status, first in firsts.items():
        where = wording.place(first.point, table.axes)
        note = f": {first.note}" if first.note else ""
        cases = several(counts[status], "case")
        yield SummaryRow(status, cases, f"the first at {where}{note}", "bold red")


def span(low: str, high: str) -> str:
    """Give a range in words; one value where both ends read alike."""
    return low if low == high else f"{low} to {high}"
