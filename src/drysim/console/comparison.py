"""The summary of a comparison: a table of approaches, and the verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from drysim import wording
from drysim.console.columns import NONE, show_columns
from drysim.console.paper import folded, line, stdout
from drysim.console.parts import (
    Row,
    show_folder,
    show_rows,
    show_scene,
    show_title,
    show_verdicts,
    show_warnings,
)
from drysim.console.table import scene
from drysim.study.sweeps import survey
from drysim.wording import number, percent

if TYPE_CHECKING:
    from drysim.study.comparisons.comparison import Comparison
    from drysim.study.sweeps.survey import Deviation
    from drysim.study.sweeps.table import Table

VALUE = 11
"""Least width of the words before the places of the worst deviations."""

FINE, COARSE = 4, 3
"""Digits of T_a, by which approaches are compared, and of the rest."""

STROKE = "x_r_peak"
"""The metric that is told in the unit in which the greatest of a column reads well."""

SPARED = ("T_x", "chatter %", "peak |x_r|")
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
    show_scene(paper, [*scene(table), *_laws(comparison), ("yardstick", comparison.yardstick)])
    show_columns(paper, columns(comparison), ("approach",), SPARED)
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


def columns(comparison: Comparison) -> list[list[str]]:
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
        name: survey.worst(survey.deviations(comparison, name))
        for name in comparison.table.approaches
        if name != comparison.yardstick
    }
    return {name: worst for name, worst in found.items() if worst is not None}


def _places(comparison: Comparison) -> Iterator[Row]:
    """Give where the greatest deviations are."""
    found = {name: worst for name, worst in _worst(comparison).items() if worst.value}
    for at, (name, worst) in enumerate(found.items()):
        where = wording.place(worst.row.point, comparison.table.axes)
        yield Row("worst" if at == 0 else "", name, f"at {where}", style="")


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
