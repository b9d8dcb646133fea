"""Comparison, bench, hard cases, summarise."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drysim import wording
from drysim.approach import EXACT
from drysim.bench.hard_cases import FAILED, HELD, TOLERANCE, UNPROMISED, WRONG
from drysim.bench.score import EXACT_BELOW
from drysim.console.summaries import (
    SummaryRow,
    finding,
    headed,
    judged,
    show_folder,
    show_rows,
    show_scene,
    show_title,
    show_verdicts,
    show_warnings,
    sweep_scene,
)
from drysim.console.terminal import NONE, folded, line, show_columns, stdout
from drysim.metrics import UNITS
from drysim.metrics.checks import Check, Verdict
from drysim.study import compare
from drysim.wording import number, percent

if TYPE_CHECKING:
    from drysim.bench.hard_cases import Ordeals, Trial
    from drysim.bench.score import Bench, Panel, Score
    from drysim.study.compare import Comparison, Deviation
    from drysim.study.table import Table


# The summary of a comparison: a table of approaches, and the verdict.


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


def _off(worst: Deviation) -> str:
    """Give a deviation in percent, of a mean with half of its interval."""
    if not worst.half_width:
        return f"{worst.value * 100:+.3g} %"
    sign = "+" if worst.value >= 0 else ""
    return sign + wording.around(100 * worst.value, 100 * worst.half_width, "%")


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


def _bare(words: str) -> str:
    """Give a percentage for a column that says so itself."""
    return words.removesuffix(" %").replace("below ", "<").replace("above ", ">")


def _range(
    ends: tuple[float, float] | None, factor: float, words: Callable[[float], str]
) -> str:
    """Give a metric over some cases, from its least to its greatest."""
    if ends is None:
        return NONE
    low, high = (words(end * factor) for end in ends)
    return low if low == high else f"{low}–{high}"


# The summary of a bench: scene by scene a table of entries, and what to think of them.


LEFT = ("entry", "verdict")
BENCH_SPARED = ("energy", "samples", "T_a error", "ns a sample")
"""What a narrow terminal does without, in this order."""


def show_bench(bench: Bench, folder: Path | None = None) -> None:
    """Show speed against error.

    Parameters
    ----------
    bench : Bench
    folder : Path, optional
        Where the files were written.
    """
    paper = stdout()
    for panel in bench.panels:
        show_title(paper, panel.scenario)
        show_scene(paper, [*panel.words, ("engine", bench.engine)])
        show_columns(paper, bench_columns(panel), LEFT, BENCH_SPARED)
        for head, sentence in findings(panel):
            headed(paper, head, sentence)
        paper.print()
    show_folder(paper, folder)
    show_warnings(bench.warnings)


def bench_columns(panel: Panel) -> list[list[str]]:
    """Give the table column by column, headings first."""
    scores = panel.scores
    return [
        ["entry", *map(name, scores)],
        ["ns a sample", *(_short(one.time, 3) for one in scores)],
        ["× lfilter", *(_short(one.ratio, 3) for one in scores)],
        ["x_r error", *(_short(one.error_x_r, 2) for one in scores)],
        ["T_a error", *(_short(one.error_T_a, 2) for one in scores)],
        ["energy", *(_short(one.energy_residual, 2) for one in scores)],
        ["samples", *(str(one.samples or NONE) for one in scores)],
        ["verdict", *(one.verdict.partition(",")[0] for one in scores)],
    ]


def name(score: Score) -> str:
    """Give what tells an entry from the others."""
    step = f"Δt {number(score.step * 1e3, 'ms')}" if score.step else ""
    return " ".join(part for part in (score.approach, score.setting, step) if part)


def findings(panel: Panel) -> Iterator[tuple[str, str]]:
    """Say what the exact approach was held to, what comes next to it, and what failed."""
    exact, held = panel.scores[0], panel.reference
    if held is not None and held.in_doubt:
        yield "held to", f"nothing: {name(held)} is in doubt itself"
    elif held is not None and held.error_x_r is not None:
        own = number(held.uncertainty or 0.0, digits=2)
        yield (
            "held to",
            (
                f"the errors of {exact.approach} are those of {name(held)} against it, over "
                f"{held.samples} samples: an upper bound; two runs of the reference differ "
                f"by {own}"
            ),
        )
    elif exact.error_x_r is not None:
        yield "held to", f"{exact.approach} is held to the error of x_r that it states itself"
    others = [
        one for one in panel.scores[1:]
        if one.time and one.error_x_r is not None and one.error_x_r <= EXACT_BELOW
    ]  # fmt: skip
    if exact.time and others:
        next_one = min(others, key=lambda one: one.time or 0.0)
        times = number((next_one.time or 0.0) / exact.time, digits=2)
        yield "next", f"{name(next_one)} is as exact and takes {times} times as long"
    for one in panel.scores:
        if one.verdict.startswith("failed"):
            yield "failed", f"{name(one)}: {one.verdict.partition(', ')[2]}"


def _short(value: float | None, digits: int) -> str:
    return NONE if value is None else number(value, digits=digits)


# The summary of the hard cases: a table of cases and approaches.


HARD_SPARED = ("viscous", "smooth", "signum", "moreau", "switch")
"""What a narrow terminal does without, in this order."""


def show_hard(ordeals: Ordeals, folder: Path | None = None) -> None:
    """Show what became of the hard cases.

    Parameters
    ----------
    ordeals : Ordeals
    folder : Path, optional
        Where the files were written.
    """
    paper = stdout()
    line(paper, ("hard cases", "bold"))
    show_columns(paper, hard_columns(ordeals), ("case",), HARD_SPARED)
    line(paper)
    headed(paper, "held", rule())
    bare = [one.scenario.name for one in ordeals.cases if one.trials[0].word == UNPROMISED]
    if bare:
        sentence = (
            f"{', '.join(bare)}: without checks nothing is promised that {EXACT} could hold "
            "or break; give `checks`"
        )
        headed(paper, UNPROMISED, sentence, "bold red")
    for case in ordeals.cases:
        for one in case.trials:
            if one.word == FAILED or (one.approach == EXACT and one.word == WRONG):
                words = f"{one.approach} on {case.scenario.name}: {one.how}"
                headed(paper, one.word, words, "bold red")
    show_folder(paper, folder)


def rule() -> str:
    """Say what it takes to hold."""
    return (
        f"{EXACT} keeps every check of a case; T_a, peak and RMS of x_r by the others are "
        f"within {percent(TOLERANCE)} of it"
    )


def hard_columns(ordeals: Ordeals) -> list[list[str]]:
    """Give the table column by column, headings first, the sums below."""
    names = [one.approach for one in ordeals.cases[0].trials]
    table = [["case", *(case.scenario.name for case in ordeals.cases), "held"]]
    for at, name in enumerate(names):
        trials = [case.trials[at] for case in ordeals.cases]
        count = sum(one.word == HELD for one in trials)
        table.append([name, *map(cell, trials), f"{count} of {len(trials)}"])
    return table


def cell(trial: Trial) -> str:
    """Give what became of one approach in one case."""
    return trial.how if trial.how and trial.word != FAILED else trial.word


# What a result on the disk says: extremes, quantiles and checks, from its drysim.json.


HEADINGS = (
    "metric", "unit", "value", "mean", "±", "least", "5 %", "median", "95 %", "greatest"
)  # fmt: skip
"""What may be told of a metric: of a run its value, of seeds their mean, of cases a range."""

SHARES = {"5 %": ("0.05", "5 %"), "median": ("0.5", "50 %"), "95 %": ("0.95", "95 %")}
"""Quantiles by what a sweep and what many seeds call them."""

RETOLD_SPARED = ("5 %", "95 %", "unit")
"""What a narrow terminal does without."""

Fields = Mapping[str, Any]


def show_retold(told: Fields) -> None:
    """Show what drysim.json tells of a run, a sweep or a comparison.

    Parameters
    ----------
    told : mapping
        As the file has it.
    """
    paper = stdout()
    line(paper, (wording.clean(str(told["scenario"]["name"])), "bold"))
    show_scene(paper, _scene(told))
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


def _scene(told: Fields) -> Iterator[tuple[str, str]]:
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
        yield from _cases(numerics)
    if not told["complete"]:
        yield "state", "incomplete"


def _cases(numerics: Fields) -> Iterator[tuple[str, str]]:
    """Give how many cases there are, and what became of them."""
    cases = numerics.get("cases", 1)
    statuses = numerics.get("statuses") or {}
    lost = [f"{count} {status}" for status, count in statuses.items() if status != "ok"]
    yield "cases", ", ".join([str(cases), *lost])


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
        yield check["passed"], finding(_verdict(check), units, numerics.get("yardstick", ""))


def _verdict(check: Fields) -> Verdict:
    """Give the verdict that a file tells."""
    known = {key: check[key] for key in ("half_width", "seeds", "reason") if key in check}
    promise = Check.promise(check["check"])
    return Verdict(promise, check["passed"], check["value"], check.get("where"), **known)
