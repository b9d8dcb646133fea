"""What is said of many runs: of one case under many seeds, of a sweep, of a comparison.

Each tells the scene in words, extremes or means with where they are, what became of the checks,
and how many cases or seeds have no numbers. Each case is held to its own stroke limit.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from math import isclose
from pathlib import Path
from typing import TYPE_CHECKING

from drysim import wording
from drysim.console.summaries import (
    SummaryRow,
    scene,
    show_folder,
    show_rows,
    show_scene,
    show_title,
    show_verdicts,
    show_warnings,
    steps,
)
from drysim.console.terminal import NONE, folded, line, show_columns, stderr, stdout
from drysim.scenario.model import STATIC
from drysim.study import compare, run
from drysim.study.plan import approaches_of
from drysim.study.statistics import HELD, OK, most, until_of
from drysim.study.table import Tally, stroke_limit
from drysim.wording import around, length, number, percent, several, told_in

if TYPE_CHECKING:
    from drysim.scenario.axes import Axis
    from drysim.study.compare import Comparison, Deviation, Isolation
    from drysim.study.ensemble import Ensemble
    from drysim.study.statistics import Row, Statistic
    from drysim.study.table import Extreme, Seeds, Table


# One case under many seeds.

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
            yield "seeds", wording.seeds(ensemble.seeds, until)
            if not ensemble.complete:
                yield "state", _unfinished(len(ensemble.rows), most(ensemble.scenario), "seed")


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


# A sweep.

TABLE_VALUE = 20
"""Columns of the values beside the names."""

DIGITS = 3
"""Digits of the ends of a range."""

NAMED = 4
"""Curves whose isolation is told one by one."""

ROUNDING = 1e-9
"""Difference of extremes, relative to them, that says nothing about where they are [-]."""


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


def sweep_scene(table: Table) -> Iterator[tuple[str, str]]:
    """Give in words what was swept, and what was not."""
    scenario, axes, own = table.scenario, table.axes, _own(table)
    varied = [axis.key for axis in axes]
    limits = {f"friction.{key}" for key in STATIC}
    defaulted = not limits & {*varied} and not scenario.static_given
    plant, law, base = scenario.oscillator.plant(), scenario.law(), scenario.excitation
    terms, ratios, peak = scenario.terms, scenario.ratios, own.greatest("x_r_peak")
    yield from wording.scene(plant, law, defaulted, terms, varied, own.shared, ratios, peak)
    motion = None if any(key.startswith("excitation.") for key in varied) else table.motion
    if motion:
        yield "base", wording.excitation(base, motion)
        yield from steps(wording.clean_up(motion))
    else:
        yield "base", wording.excitations(base, varied)
    if found := own.seeds:
        first: int = getattr(base, "seed", 1)
        drawn = range(first, first + found.most)
        counts = sorted({found.least, found.most})
        yield "seeds", wording.seeds(drawn, until_of(scenario), counts)
    for i, axis in enumerate(axes):
        yield "" if i else "swept", wording.swept(axis)
    cases = (f"{tally.cases} by {name}" for name, tally in table.tallies.items())
    yield "cases", ", ".join(cases)
    if not table.complete:
        yield "state", _unfinished(len(table.rows), run.count(approaches_of(scenario)), "case")


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


def known(axes: Sequence[Axis], found: Seeds | None, metric: str) -> Iterator[SummaryRow]:
    """Give how well the means of a metric are known at the worst."""
    row = found.widest.get(metric) if found else None
    if row is not None:
        width = row.half_widths[metric]
        mean, where = row.metrics.get(metric), wording.place(row.point, axes)
        words = f"at the worst: {around(mean, width)} at {where}"
        yield SummaryRow("", f"± {number(width, digits=2)}", words)


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


def _missing(table: Table) -> Iterator[SummaryRow]:
    """Count and name the cases that have no numbers."""
    counts: Counter[str] = Counter()
    firsts: dict[str, Row] = {}
    for tally in table.tallies.values():
        for status, (count, first) in tally.lost.items():
            counts[status] += count
            firsts.setdefault(status, first)
    for status, first in firsts.items():
        where = wording.place(first.point, table.axes)
        note = f": {first.note}" if first.note else ""
        cases = several(counts[status], "case")
        yield SummaryRow(status, cases, f"the first at {where}{note}", "bold red")


def extent(table: Table, own: Tally, metric: str) -> str:
    """Return where a metric is least and greatest, in words."""
    if alike(own, metric):
        return "the same in every case" + " that has numbers" * bool(own.lost)
    least, most = (at(table, end) for end in own.extremes[metric])
    return f"least {least}, greatest {most}" if least != most else least


def alike(own: Tally, metric: str) -> bool:
    """Whether a metric is the same in several cases, but for rounding."""
    least, most = own.extremes[metric]
    known = own.cases - sum(count for count, _ in own.lost.values())
    return known > 1 and isclose(least.value, most.value, rel_tol=ROUNDING)


def at(table: Table, extreme: Extreme) -> str:
    """Give where an extreme is."""
    return f"at {wording.place(extreme.row.point, table.axes)}"


def span(low: str, high: str) -> str:
    """Give a range in words; one value where both ends read alike."""
    return low if low == high else f"{low} to {high}"


def _unfinished(done: int, every: int, thing: str) -> str:
    """Give the state of what was interrupted, e.g. `incomplete: 3 of 20 seeds`."""
    return f"incomplete: {done} of {several(every, thing)}"


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


# A comparison.

VALUE = 11
"""Least width of the words before the places of the worst deviations."""

FINE, COARSE = 4, 3
"""Digits of T_a, by which approaches are compared, and of the rest."""

STROKE = "x_r_peak"
"""The metric that is told in the unit in which the greatest of a column reads well."""

COMPARISON_SPARED = ("T_x", "chatter %", "peak |x_r|")
"""What a narrow terminal does without, in this order."""

METRICS: tuple[tuple[str, str, Callable[[float], str]], ...] = (
    ("T_a", "T_a", lambda value: number(value, digits=FINE)),
    ("T_x", "T_x", lambda value: number(value, digits=COARSE)),
    ("peak |x_r|", STROKE, lambda value: number(value, digits=COARSE)),
    ("stuck %", "stuck_share", lambda value: _bare(percent(value))),
    ("chatter %", "chatter_share", lambda value: _bare(percent(value))),
)


def show_comparison(comparison: Comparison, folder: Path | None = None) -> None:
    """Show what several approaches made of the same base motion.

    Parameters
    ----------
    comparison : Comparison
    folder : Path, optional
        Where the files were written.
    """
    paper, table = stdout(), comparison.table
    show_title(paper, table.scenario)
    show_scene(
        paper, [*sweep_scene(table), *_laws(comparison), ("yardstick", comparison.yardstick)]
    )
    show_columns(paper, comparison_columns(comparison), ("approach",), COMPARISON_SPARED)
    if table.axes and (places := list(_places(comparison))):
        show_rows(paper, places, max(VALUE, *map(len, table.tallies)) + 1)
    show_verdicts(paper, table.checks, table.axes, comparison.yardstick)
    if comparison.verdict:
        line(paper)
    for at, sentence in enumerate(comparison.verdict):
        for words in folded(paper, sentence, 2):
            line(paper, ("  ", ""), (words, "" if at else "bold"))
    show_folder(paper, folder)
    show_warnings(table.warnings)


def _laws(comparison: Comparison) -> Iterator[tuple[str, str]]:
    """Give in words every friction law that is compared with that of the scenario."""
    scenario = comparison.table.scenario
    names = [name for name, law in comparison.laws.items() if name == law]
    varied = [axis.key for axis in comparison.table.axes]
    for at, name in enumerate(names):
        one, shared = scenario.with_law(name), comparison.table.tallies[name].shared
        terms = one.terms or (f"law {name}",)
        kinetic, static = shared["kinetic"], shared["static"]
        words = wording.friction(one.law(), False, kinetic, static, terms, varied, one.ratios)
        yield "" if at else "laws", words.removeprefix("law ")


def comparison_columns(comparison: Comparison) -> list[list[str]]:
    """Give the table column by column, headings first, without columns of no number."""
    table = comparison.table
    rows = table.tallies
    found = [_column(table, *metric) for metric in METRICS]
    worst = _worst(comparison)
    off = [_off(worst[name]) if name in worst else NONE for name in rows]
    known = [column for column in found if set(column[1:]) != {NONE}]
    return [["approach", *rows], *known[:1], ["deviation", *off], *known[1:]]


def _column(
    table: Table, heading: str, metric: str, words: Callable[[float], str]
) -> list[str]:
    """Give the column of a metric, its heading first."""
    ends = [own.ends.get(metric) for own in table.tallies.values()]
    factor, sign = 1.0, ""
    if metric == STROKE:
        factor, sign = wording.length_unit(
            max((high for _, high in filter(None, ends)), default=0.0)
        )
    return [f"{heading} {sign}".strip(), *(_range(each, factor, words) for each in ends)]


def _range(
    ends: tuple[float, float] | None, factor: float, words: Callable[[float], str]
) -> str:
    """Give a metric over some cases, from its least to its greatest."""
    if ends is None:
        return NONE
    low, high = (words(end * factor) for end in ends)
    return low if low == high else f"{low}–{high}"


def _bare(words: str) -> str:
    """Give a percentage for a column that says so itself."""
    return words.removesuffix(" %").replace("below ", "<").replace("above ", ">")


def _off(worst: Deviation) -> str:
    """Give a deviation in percent, of a mean with half of its interval."""
    if not worst.half_width:
        return f"{worst.value * 100:+.3g} %"
    sign = "+" if worst.value >= 0 else ""
    return sign + around(100 * worst.value, 100 * worst.half_width, "%")


def _worst(comparison: Comparison) -> dict[str, Deviation]:
    """Give the greatest deviation of every approach that has one."""
    found = {
        name: compare.worst_of(compare.deviations(comparison, name))
        for name in comparison.table.approaches
        if name != comparison.yardstick
    }
    return {name: worst for name, worst in found.items() if worst is not None}


def _places(comparison: Comparison) -> Iterator[SummaryRow]:
    """Give where the greatest deviations are."""
    found = {name: worst for name, worst in _worst(comparison).items() if worst.value}
    for at, (name, worst) in enumerate(found.items()):
        where = wording.place(worst.row.point, comparison.table.axes)
        yield SummaryRow("worst" if at == 0 else "", name, f"at {where}", style="")
