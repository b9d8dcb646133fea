"""A comparison of approaches or friction laws: its files, fields, pictures and summary."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drysim import wording
from drysim.console.terminal import NO_VALUE
from drysim.metrics.table import METRICS_BY_NAME, PEAK_STROKE, SHARE
from drysim.metrics.text import label_of
from drysim.results.fields import metric_fields, numerics_fields, stored_fields
from drysim.results.kind import File, Kind, Picture, judgements
from drysim.results.sweep import sweep_scene
from drysim.results.tables import Column, case_columns, has_means, write_cases
from drysim.scenario.text import describe_case, describe_friction
from drysim.study import compare
from drysim.study.summary import PLAIN, Grid, Row, Summary
from drysim.wording import format_deviation, format_number, format_percent

if TYPE_CHECKING:
    from drysim.results.fields import Fields, Provenance
    from drysim.study.compare import Comparison, Deviation
    from drysim.study.table import Table

VALUE_WIDTH = 11
"""Least width of the approach names in the rows of the worst deviations [columns]."""


COMPARISON_METRICS = {
    "T_a": 4, "SEAT": 3, "a_w": 3, "T_x": 3, PEAK_STROKE: 3, "stuck_share": 3,
    "chatter_share": 3,
}  # fmt: skip
"""Metrics in the columns, and their significant digits; approaches are compared by T_a."""

OPTIONAL_METRICS = ("a_w", "T_x", "chatter_share", PEAK_STROKE)
"""Metrics whose columns a narrow terminal omits, in this order."""


def summarise(comparison: Comparison) -> Summary:
    """Return the summary of a comparison."""
    table = comparison.table
    rows = tuple(worst_rows(comparison)) if table.axes else ()
    optional = [label_of(name) for name in OPTIONAL_METRICS]
    return Summary(
        name=wording.sanitise(table.scenario.name),
        about=table.scenario.about,
        scene=tuple(comparison_scene(comparison)),
        table=Grid(comparison_columns(comparison), ("approach",), optional),
        groups=(rows,),
        width=max(VALUE_WIDTH, *map(len, table.tallies)) + 1,
        checks=judgements(table.checks, table.axes, comparison.reference),
        verdict=comparison.verdict,
    )


def comparison_scene(comparison: Comparison) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was swept, the friction laws, and the reference."""
    yield from sweep_scene(comparison.table)
    yield from _law_lines(comparison)
    yield "reference", comparison.reference


def _law_lines(comparison: Comparison) -> Iterator[tuple[str, str]]:
    """Yield label and sentence of every friction law that is compared."""
    scenario = comparison.table.scenario
    names = [name for name, law in comparison.laws.items() if name == law]
    varied = [axis.key for axis in comparison.table.axes]
    for place, name in enumerate(names):
        variant, shared = scenario.with_law(name), comparison.table.tallies[name].shared
        terms = variant.terms or (f"law {name}",)
        kinetic, static = shared["kinetic"], shared["static"]
        description = describe_friction(
            variant.law(), False, kinetic, static, terms, varied, variant.ratios
        )
        yield "" if place else "laws", description.removeprefix("law ")


def comparison_columns(comparison: Comparison) -> list[list[str]]:
    """Return the table by columns, header first, without columns that have no value."""
    table = comparison.table
    rows = table.tallies
    columns = [_metric_column(table, *metric) for metric in COMPARISON_METRICS.items()]
    worst = _worst_deviations(comparison)
    off = [
        format_deviation(worst[name].value, worst[name].half_width)
        if name in worst
        else NO_VALUE
        for name in rows
    ]
    columns = [column for column in columns if set(column[1:]) != {NO_VALUE}]
    return [["approach", *rows], *columns[:1], ["deviation", *off], *columns[1:]]


def _metric_column(table: Table, name: str, digits: int) -> list[str]:
    """Return the column of a metric, header with the unit first."""
    metric = METRICS_BY_NAME[name]
    ends = [tally.ends.get(name) for tally in table.tallies.values()]
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
    deviations = {
        name: compare.largest_deviation(compare.deviations(comparison, name))
        for name in comparison.table.approaches
        if name != comparison.reference
    }
    return {name: worst for name, worst in deviations.items() if worst is not None}


def worst_rows(comparison: Comparison) -> Iterator[Row]:
    """Yield where the greatest deviations are."""
    deviations = {
        name: worst for name, worst in _worst_deviations(comparison).items() if worst.value
    }
    for place, (name, worst) in enumerate(deviations.items()):
        where = describe_case(worst.row.point, comparison.table.axes)
        yield Row("worst" if place == 0 else "", name, f"at {where}", tone=PLAIN)


def write_comparison_csv(result: Comparison, file: Path) -> None:
    """Write comparison.csv: every case with every approach, and its deviation."""
    table = result.table
    pairs = [result.off(row) or (None, None) for row in table.rows]
    off = np.array(pairs, dtype=float).reshape(-1, 2)

    def deviation(name: str, index: int) -> Column:
        return Column(name, "-", lambda batch: off[batch.first :][: len(batch), index])

    columns = [*case_columns(table), deviation("T_a_deviation", 0)]
    if has_means(table):
        columns.append(deviation("T_a_deviation_half_width", 1))
    if result.of_laws:
        laws = {name: law.encode() for name, law in result.laws.items()}
        columns.append(Column("law", "", lambda batch: [laws[batch.approach]] * len(batch)))
    write_cases(file, columns, table.rows)


def comparison_fields(comparison: Comparison, provenance: Provenance) -> Fields:
    """Return the content for a comparison: extremes per approach, deviations, verdict."""
    table, reference = comparison.table, comparison.reference
    numerics = {
        "approaches": table.approaches,
        "yardstick": reference,
        "laws": comparison.laws,
        **numerics_fields(table, table.tallies.get(reference)),
    }
    metrics = {
        name: {**metric_fields(tally), **_deviation_fields(comparison, name)}
        for name, tally in table.tallies.items()
    }
    response = comparison.responses.get(reference)
    motion = table.motion if response is None else response.motion
    return stored_fields(
        comparison, motion, numerics, metrics, provenance, verdict=comparison.verdict
    )


def _deviation_fields(comparison: Comparison, approach: str) -> Fields:
    """Return the greatest deviation from the reference, and its place."""
    worst = compare.largest_deviation(compare.deviations(comparison, approach))
    if worst is None or approach == comparison.reference:
        return {}
    deviation = {"value": worst.value, "where": dict(worst.row.point)}
    mean = {} if worst.half_width is None else {"half_width": worst.half_width}
    return {"T_a_deviation": deviation | mean}


COMPARISON = Kind(
    name="comparison",
    what="a comparison",
    files=(File("comparison.csv", write_comparison_csv),),
    pictures=(
        Picture(
            "comparison",
            "comparison.draw",
            "Motion where the first approach has its largest error, and transmissibility of "
            "all",
        ),
    ),
    fields=comparison_fields,
    summary=summarise,
    scenario=lambda result: result.table.scenario,
)
