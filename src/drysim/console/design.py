"""Summary of a design study: what was varied, the best design, what limits it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drysim import wording
from drysim.console.summaries import (
    SummaryRow,
    clean_up_lines,
    describe_hourly_use,
    show_summary,
)
from drysim.metrics.table import HOURLY_STROKE
from drysim.metrics.text import format_metric, label_of
from drysim.scenario.design import WORST
from drysim.study.design import DesignResult, Variant, keys_at_bounds, limits_of, number_of
from drysim.study.statistics import max_seeds
from drysim.study.table import hourly_stroke_used
from drysim.wording import (
    describe_axis,
    describe_case,
    format_count,
    format_deviation,
    format_number,
    format_range,
    format_unit,
    join_words,
    short_key,
)

if TYPE_CHECKING:
    from drysim.study.case import Case

VALUE_WIDTH = 17
"""Width of the values."""

MIN_CHANGE = 1e-4
"""Relative change below which a variant counts as unchanged [-]."""

SHOWN_OF_FRONT = {
    "knee": "knee of the front",
    "end of the front": "end of the front, which has no knee",
}
"""Remarks on the shown design of a front."""

MAX_SHOWN_FRONT = 9
"""Designs of a front that are printed: its ends, evenly spaced ones between them, and its knee;
all are in design.csv."""


def show_design(result: DesignResult, folder: Path | None = None) -> None:
    """Show the summary of a design study."""
    fault = None
    if result.best is None:
        sentence = "no design keeps all limits; below is the one that exceeds them least"
        fault = "✗ design", sentence
    groups = best_rows(result), front_rows(result), variant_rows(result)
    axes = result.case.scenario.sweep
    show_summary(result, result_scene(result), groups, VALUE_WIDTH, folder, axes, fault)


def result_scene(result: DesignResult) -> Iterator[tuple[str, str]]:
    """Yield what was varied, minimised and kept, and how many designs were evaluated."""
    yield from design_scene(result.case)
    yield "evaluated", describe_search(result)


def describe_search(result: DesignResult) -> str:
    """Describe how many designs were evaluated, and why the search ended."""
    state = "nothing more to be gained" if result.converged else "the limit of evaluations"
    if not result.complete:
        state = "interrupted"
    admissible = sum(one.is_admissible for one in result.candidates)
    count = format_count(len(result.candidates), "design")
    return f"{count}, {admissible} admissible; {state}"


def design_scene(case: Case) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what is varied, minimised and kept, under which motion."""
    scenario = case.scenario
    block = scenario.design
    assert block is not None, "a design study has a design block"
    keys = [one.key for one in block.vary]
    varied = [f"{short_key(one.key, keys)} {one.description}" for one in block.vary]
    yield "vary", "; ".join(varied)
    yield "minimise", join_words(block.minimise)
    yield "within", ", ".join(map(str, limits_of(scenario))) or "no limits"
    if block.conditions.axes:
        how = "the worst counts" if block.conditions.take == WORST else "the mean counts"
        yield "over", f"{'; '.join(map(describe_axis, block.conditions.axes))}; {how}"
    varied_keys = {*keys, *(axis.key for axis in block.conditions.axes)}
    forces = any(key.startswith("friction.") for key in varied_keys)
    shared = dict.fromkeys(wording.ALL_SHARED, not forces)
    law = scenario.law()
    yield from wording.describe_scene(scenario, case.plant, law, varied_keys, shared)
    yield "base", scenario.excitation.describe_cases(case.motion, varied_keys, case.records)
    same = not any(key.startswith("excitation.") for key in varied_keys)
    motion = case.motion if same else None
    yield from clean_up_lines(wording.describe_clean_up(motion, records=case.records))
    if (seeds := max_seeds(scenario)) > 1:
        yield "seeds", f"{seeds}, the same for every design"


def best_rows(result: DesignResult) -> Iterator[SummaryRow]:
    """Yield the values of the best design with where the optimum may be, and its objectives."""
    shown, bounds = result.shown, keys_at_bounds(result)
    if shown is None:
        return
    keys = [one.key for one in result.design.vary]
    for one in result.design.vary:
        unit, remarks = format_unit(one.unit), []
        for label, region in (("95 %", result.optimum), ("within 1 %", result.flat)):
            if region is None:
                continue
            low, high = region.ends[one.key]
            if low is None or low != high or one.key not in bounds:
                remarks.append(f"{label}: {describe_region(low, high)}")
        if one.key in bounds:
            remarks.append(f"at its {bounds[one.key]} bound")
        text = format_number(shown.values[one.key], unit)
        yield SummaryRow(short_key(one.key, keys), text, "; ".join(remarks))
    for name, value, half_width in zip(
        result.design.minimise, shown.objectives, result.half_widths, strict=True
    ):
        text = format_metric(name, value, half_width)
        remarks = [words] if (words := SHOWN_OF_FRONT.get(result.shown_name)) else []
        remarks += [f"mean of {shown.rows[0].seeds} seeds"] * (half_width is not None)
        if result.design.conditions.axes and result.design.conditions.take == WORST:
            worst = max(shown.rows, key=lambda row: number_of(row.metrics.get(name)))
            point = {axis.key: worst.point[axis.key] for axis in result.design.conditions.axes}
            remarks.append(f"at {describe_case(point, result.design.conditions.axes)}")
        yield SummaryRow(name, text, "; ".join(remarks))
    yield from hourly_rows(result)
    for limit, objective in result.binding:
        name = result.design.minimise[0]
        least = f"{name} about {format_metric(name, objective)}"
        yield SummaryRow("binding", str(limit), f"{least} without this limit")


def describe_region(low: float | None, high: float | None) -> str:
    """Return the ends of the range of a key, of which those that seeds leave open are None."""
    if low is None and high is None:
        return "not known from these seeds"
    if low is None or high is None:
        other = "lower" if low is None else "upper"
        return f"{format_range(low, high)}, {other} end not known from these seeds"
    return format_range(low, high)


def hourly_rows(result: DesignResult) -> Iterator[SummaryRow]:
    """Yield the stroke that the shown design reaches once an hour, beside its limit."""
    shown = result.shown
    metrics = [row.metrics for row in shown.rows] if shown else []
    stroke = max((one.get(HOURLY_STROKE) or 0.0 for one in metrics), default=0.0)
    if stroke:
        remark = "reached once an hour, extrapolated from the largest peaks"
        if (block := result.scenario.stroke) is not None:
            used = max(hourly_stroke_used(one, block.limits) for one in metrics)
            remark = f"{describe_hourly_use(used)}; {remark}"
        yield SummaryRow(label_of(HOURLY_STROKE), wording.format_length(stroke), remark)


def front_rows(result: DesignResult) -> Iterator[SummaryRow]:
    """Yield designs of the front, by the first objective: its ends, its knee and some more."""
    if len(result.front) < 2:
        return
    front, (first, second) = result.front, result.design.minimise
    names = {len(front) - 1: f"least {second}", 0: f"least {first}"}
    if result.best is not None and result.shown_name == "knee":
        names[front.index(result.best)] = "knee"
    count = min(len(front), MAX_SHOWN_FRONT)
    places = np.linspace(0, len(front) - 1, count).round().astype(int).tolist()
    for at in sorted({*places, *names}):
        one = front[at]
        yield SummaryRow(names.get(at, "front"), result.result(one), result.place(one))


def variant_rows(result: DesignResult) -> Iterator[SummaryRow]:
    """Yield the objectives of variants of the design."""
    for variant in result.variants:
        yield SummaryRow(variant.name, *describe_variant(result, variant))


def describe_variant(result: DesignResult, variant: Variant) -> tuple[str, str]:
    """Return the first objective of a variant, and its change and its admissibility."""
    shown, name = result.shown, result.design.minimise[0]
    assert shown is not None, "variants are those of a design"
    value, least = variant.candidate.objectives[0], shown.objectives[0]
    if value != value:
        return "–", variant.candidate.status
    remarks = []
    if least:
        change = (value - least) / abs(least)
        words = format_deviation(change, digits=2)
        remarks.append(words if abs(change) >= MIN_CHANGE else "unchanged")
    if variant.candidate.excess and not variant.candidate.is_admissible:
        worst = max(range(len(result.limits)), key=variant.candidate.excess.__getitem__)
        remarks.append(f"violates {result.limits[worst]}")
    return f"{name} {format_metric(name, value)}", "; ".join(remarks)
