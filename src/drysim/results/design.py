"""A design study: its files, fields, picture and summary."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim import wording
from drysim.console.summary import check_mark
from drysim.manual.words import DESIGN as DESIGN_WORD
from drysim.metrics.table import HOURLY_STROKE, METRICS
from drysim.metrics.table import UNITS as METRIC_UNITS
from drysim.metrics.text import format_metric, label_of
from drysim.results.fields import axis_fields, check_fields, stored_fields
from drysim.results.kind import (
    File,
    Kind,
    Picture,
    clean_up_lines,
    judgements,
    write_scenario,
)
from drysim.results.run import describe_hourly_use
from drysim.results.tables import (
    SEEDS_COLUMN,
    STATUS_COLUMN,
    Column,
    interval_column,
    key_column,
    metric_column,
    requested_metrics,
    write_cases,
)
from drysim.scenario.design import WORST
from drysim.scenario.text import (
    ALL_SHARED,
    describe_axis,
    describe_case,
    describe_clean_up,
    describe_point,
    describe_scene,
    short_key,
)
from drysim.study.design import (
    STROKE_WITH_EVERY_SEED,
    DesignResult,
    Variant,
    keys_at_bounds,
    limits_of,
    number_of,
)
from drysim.study.statistics import judged_value, max_seeds
from drysim.study.summary import BAD, Grid, Note, Row, Summary
from drysim.study.table import hourly_stroke_used
from drysim.wording import (
    format_count,
    format_deviation,
    format_number,
    format_quantity,
    format_range,
    format_unit,
    join_words,
)

if TYPE_CHECKING:
    from drysim.metrics.checks import Verdict
    from drysim.results.fields import Fields, Provenance
    from drysim.study.case import Case
    from drysim.study.design import Candidate
    from drysim.study.statistics import Row as ConditionRow

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


def summarise(result: DesignResult) -> Summary:
    """Return the summary of a design study."""
    faults: tuple[Note, ...] = ()
    if result.best is None:
        sentence = "no design keeps all limits; below is the one that exceeds them least"
        faults = (Note("✗ design", sentence, BAD),)
    groups = best_rows(result), front_rows(result), variant_rows(result)
    conditions = condition_columns(result)
    which = "best" if result.best else "closest"
    title = f"The {which} design under each condition"
    return Summary(
        name=wording.sanitise(result.source.name),
        about=result.source.about,
        scene=tuple(result_scene(result)),
        faults=faults,
        groups=tuple(map(tuple, groups)),
        width=VALUE_WIDTH,
        checks=judgements(result.checks, result.case.scenario.sweep),
        answer=(describe_best(result),),
        details=(Grid(conditions, title=title),) if conditions else (),
    )


def describe_best(result: DesignResult) -> str:
    """Return the best design, or the closest one, in a sentence."""
    design = result.best or result.closest
    if design is None:
        return "No design has numbers."
    names = result.design.minimise
    values = ", ".join(
        f"{name} {format_metric(name, value)}"
        for name, value in zip(names, design.objectives, strict=True)
    )
    units = {key.key: key.unit for key in result.design.vary}
    what = "Best design: " if result.best else "No design keeps all limits; the closest has "
    if len(result.front) > 1:
        what += "the knee of the front, "
    return f"{what}{values} at {describe_point(design.values, units)}."


def describe_metrics(result: DesignResult) -> str:
    """Describe whose metrics those of a design study are."""
    sentence = "of the best design" if result.best else "of the design closest to the limits"
    units = {axis.key: axis.unit for axis in result.design.conditions.axes}
    point = result.place_of(result.shown_row) if result.shown_row else {}
    if place := describe_point(point, units):
        sentence += f" at {place}, the condition with the highest {result.design.minimise[0]}"
    seeds = result.candidates[0].rows[0].seeds
    return f"{sentence}; means of {seeds} seeds" if seeds > 1 else sentence


def condition_columns(result: DesignResult) -> list[list[str]]:
    """Return the shown design under each condition by columns, header first; empty for one."""
    rows = result.several_rows
    if not rows:
        return []
    minimised = result.design.minimise
    limited = {limit.metric for limit in result.limits}
    names = [
        name
        for name in dict.fromkeys((*minimised, *CONDITION_METRICS))
        if (name in minimised or name not in limited)
        and any(row.metrics.get(name) is not None for row in rows)
    ]
    units = {axis.key: axis.unit for axis in result.design.conditions.axes}
    highest = result.shown_row and result.place_of(result.shown_row)
    places = []
    for row in rows:
        place = describe_point(result.place_of(row), units)
        worst = result.place_of(row) == highest
        places.append(f"{place} (highest {names[0]})" if worst else place)
    columns = [["condition", *places]]
    for name in names:
        cells = (_condition_cell(row, name) for row in rows)
        columns.append([name, *cells])
    verdicts = [result.judge((row,)) for row in rows]
    for number, first in enumerate(verdicts[0]):
        cells = (_verdict_cell(each[number]) for each in verdicts)
        columns.append([str(first.check), *cells])
    return columns


def _verdict_cell(verdict: Verdict) -> str:
    mark = check_mark(verdict.passed)[0][0]
    return f"{mark} {verdict.described_value.removeprefix('with ')}"


def _condition_cell(row: ConditionRow, name: str) -> str:
    value = row.metrics.get(name)
    if value is None:
        return wording.UNKNOWN
    return format_metric(name, value, row.half_widths.get(name))


def result_scene(result: DesignResult) -> Iterator[tuple[str, str]]:
    """Yield what was varied, minimised and kept, and how many designs were evaluated."""
    yield from design_scene(result.case)
    yield "evaluated", describe_search(result)


def describe_search(result: DesignResult) -> str:
    """Describe how many designs were evaluated, and why the search ended."""
    state = "nothing more to be gained" if result.converged else "the limit of evaluations"
    if not result.complete:
        state = "interrupted"
    admissible = sum(candidate.is_admissible for candidate in result.candidates)
    count = format_count(len(result.candidates), "design")
    return f"{count}, {admissible} admissible; {state}"


def design_scene(case: Case) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what is varied, minimised and kept, under which motion."""
    scenario = case.scenario
    block = scenario.design
    assert block is not None, "a design study has a design block"
    keys = [vary.key for vary in block.vary]
    varied = [f"{short_key(vary.key, keys)} {vary.description}" for vary in block.vary]
    yield "vary", "; ".join(varied)
    yield "minimise", join_words(block.minimise)
    yield "within", ", ".join(map(str, limits_of(scenario))) or "no limits"
    if block.conditions.axes:
        how = "the worst counts" if block.conditions.take == WORST else "the mean counts"
        yield "over", f"{'; '.join(map(describe_axis, block.conditions.axes))}; {how}"
    varied_keys = {*keys, *(axis.key for axis in block.conditions.axes)}
    forces = any(key.startswith("friction.") for key in varied_keys)
    shared = dict.fromkeys(ALL_SHARED, not forces)
    law = scenario.law()
    yield from describe_scene(scenario, case.plant, law, varied_keys, shared)
    yield "base", scenario.excitation.describe_cases(case.motion, varied_keys, case.records)
    same = not any(key.startswith("excitation.") for key in varied_keys)
    motion = case.motion if same else None
    yield from clean_up_lines(describe_clean_up(motion, records=case.records))
    if (seeds := max_seeds(scenario)) > 1:
        yield "seeds", f"{seeds}, the same for every design"


def best_rows(result: DesignResult) -> Iterator[Row]:
    """Yield the values of the best design with where the optimum may be, and its objectives."""
    shown, bounds = result.shown, keys_at_bounds(result)
    if shown is None:
        return
    keys = [vary.key for vary in result.design.vary]
    for vary in result.design.vary:
        value, remarks = shown.values[vary.key], list[str]()
        factor, unit = wording.display_unit(format_unit(vary.unit), value)
        if vary.key == "oscillator.damping_ratio":
            remarks.append(describe_damping(result))
        for label, region in (("95 %", result.optimum), ("within 1 %", result.flat)):
            if region is None:
                continue
            low, high = region.ends[vary.key]
            if low is None or low != high or vary.key not in bounds:
                ends = (None if end is None else factor * end for end in (low, high))
                remarks.append(f"{label}: {describe_region(*ends)}")
        if vary.key in bounds:
            remarks.append(f"at its {bounds[vary.key]} bound")
        text = format_number(factor * value, unit)
        yield Row(short_key(vary.key, keys), text, "; ".join(remarks))
    for name, value, half_width in zip(
        result.design.minimise, shown.objectives, result.half_widths, strict=True
    ):
        text = format_metric(name, value, half_width)
        remarks = [remark] if (remark := SHOWN_OF_FRONT.get(result.shown_name)) else []
        remarks += [f"mean of {shown.rows[0].seeds} seeds"] * (half_width is not None)
        if result.design.conditions.axes and result.design.conditions.take == WORST:
            worst = max(shown.rows, key=lambda row: number_of(row.metrics.get(name)))
            point = {axis.key: worst.point[axis.key] for axis in result.design.conditions.axes}
            remarks.append(f"at {describe_case(point, result.design.conditions.axes)}")
        yield Row(name, text, "; ".join(remarks))
    yield from hourly_rows(result)
    for binding in result.binding:
        name = result.design.minimise[0]
        least = f"{name} about {format_metric(name, binding.objective)}"
        which = "these limits" if binding.beside else "this limit"
        yield Row("binding", binding.text, f"{least} without {which}")
    if result.best is not None:
        yield from bound_rows(result)


def bound_rows(result: DesignResult) -> Iterator[Row]:
    """Yield the ends of ranges in `design.vary` that keep the best design from being better."""
    bounds = keys_at_bounds(result)
    keys = [vary.key for vary in result.design.vary]
    for vary in result.design.vary:
        if side := bounds.get(vary.key):
            end = vary.low if side == "lower" else vary.high
            if end in vary.bounds:
                continue
            value = format_quantity(end, vary.unit)
            bound = f"{short_key(vary.key, keys)} {'>=' if side == 'lower' else '<='} {value}"
            remark = f"{side} end of its range; a better design may lie beyond"
            yield Row("binding", bound, remark)


def describe_damping(result: DesignResult) -> str:
    """Return the damping coefficient that the damping ratio of the shown design stands for."""
    assert result.shown is not None, "a damping ratio is that of a design"
    cases = (result.scenario.at(result.place_of(row)) for row in result.shown.rows)
    coefficients = [case.oscillator.plant().b for case in cases]
    low, high = min(coefficients), max(coefficients)
    return f"damping {format_range(low, high, format_unit('N*s/m'))}"


def describe_region(low: float | None, high: float | None) -> str:
    """Return the ends of the range of a key, of which those that seeds leave open are None."""
    if low is None and high is None:
        return "not known from these seeds"
    if low is None or high is None:
        other = "lower" if low is None else "upper"
        return f"{format_range(low, high)}, {other} end not known from these seeds"
    return format_range(low, high)


def hourly_rows(result: DesignResult) -> Iterator[Row]:
    """Yield the stroke that the shown design reaches once an hour, beside its limit."""
    shown, block = result.shown, result.scenario.stroke
    rows = [row for row in shown.rows if row.metrics.get(HOURLY_STROKE)] if shown else []
    if not rows:
        return
    if block is None:
        worst, used = max(rows, key=lambda row: number_of(row.metrics[HOURLY_STROKE])), ""
    else:
        worst = max(rows, key=lambda row: hourly_stroke_used(row.metrics, block.limits))
        used = describe_hourly_use(hourly_stroke_used(worst.metrics, block.limits))
    place = describe_case(result.place_of(worst), result.design.conditions.axes)
    remarks = [f"{used}{f' at {place}' if place else ''}".strip()]
    remarks += ["reached once an hour, extrapolated from the largest peaks"]
    stroke = wording.format_length(worst.metrics[HOURLY_STROKE])
    yield Row(label_of(HOURLY_STROKE), stroke, "; ".join(filter(None, remarks)))


def front_rows(result: DesignResult) -> Iterator[Row]:
    """Yield designs of the front, by the first objective: its ends, its knee and some more."""
    if len(result.front) < 2:
        return
    front, (first, second) = result.front, result.design.minimise
    names = {len(front) - 1: f"least {second}", 0: f"least {first}"}
    if result.best is not None and result.shown_name == "knee":
        names[front.index(result.best)] = "knee"
    count = min(len(front), MAX_SHOWN_FRONT)
    places = np.linspace(0, len(front) - 1, count).round().astype(int).tolist()
    for place in sorted({*places, *names}):
        candidate = front[place]
        yield Row(names.get(place, "front"), result.result(candidate), result.place(candidate))


def variant_rows(result: DesignResult) -> Iterator[Row]:
    """Yield the objectives of variants of the design."""
    for variant in result.variants:
        yield Row(variant.name, *describe_variant(result, variant))


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
        deviation = format_deviation(change, digits=2)
        remarks.append(deviation if abs(change) >= MIN_CHANGE else "unchanged")
    if variant.candidate.excess and not variant.candidate.is_admissible:
        worst = max(range(len(result.limits)), key=variant.candidate.excess.__getitem__)
        remarks.append(f"violates {result.limits[worst]}")
    return f"{name} {format_metric(name, value)}", "; ".join(remarks)


OBJECTIVE_COLUMNS = ("objective", "second_objective")
"""Columns of the objectives of a design over all its conditions, each in its own unit."""


def write_design_csv(result: DesignResult, file: Path) -> None:
    """Write design.csv: every evaluated design, under each of its conditions."""
    rows = [row for candidate in result.candidates for row in candidate.rows]
    designs = [candidate for candidate in result.candidates for _ in candidate.rows]
    asked = {*requested_metrics(result.source)}
    named = dict.fromkeys((*result.design.minimise, *(limit.metric for limit in result.limits)))
    names = [*named, *(m.name for m in METRICS if m.in_tables and m.name in asked)]

    def of_design(name: str, unit: str, values: list[Any], whole: bool = False) -> Column:
        column = np.array(values, dtype=float)
        return Column(name, unit, lambda batch: column[batch.first :][: len(batch)], whole)

    keys = {vary.key: vary.unit for vary in result.design.vary}
    columns = [
        of_design("design", "-", [candidate.number for candidate in designs], whole=True),
        *(key_column(key, unit) for key, unit in keys.items()),
        *(key_column(axis.key, axis.unit) for axis in result.case.scenario.sweep),
        *(
            of_design(
                name, METRIC_UNITS[metric], [candidate.objectives[i] for candidate in designs]
            )
            for i, (name, metric) in enumerate(
                zip(OBJECTIVE_COLUMNS, result.design.minimise, strict=False)
            )
        ),
        of_design("excess", "-", [max(candidate.excess, default=0.0) for candidate in designs]),
        of_design(
            "admissible", "-", [candidate.is_admissible for candidate in designs], whole=True
        ),
        of_design(
            "on_front", "-", [candidate in result.front for candidate in designs], whole=True
        ),
        *map(metric_column, dict.fromkeys(names)),
        STATUS_COLUMN,
    ]
    if STROKE_WITH_EVERY_SEED in result.limits:
        most = [number_of(judged_value(STROKE_WITH_EVERY_SEED, row)) for row in rows]
        columns.append(of_design("stroke_used_max", "-", most))
    if rows[0].over:
        columns += [SEEDS_COLUMN, *map(interval_column, named)]
    write_cases(file, columns, rows)


def design_fields(result: DesignResult, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for a design study."""
    names, front = result.design.minimise, result.front if len(result.front) > 1 else ()
    regions = {"optimum": result.optimum, "within_1_percent": result.flat}

    def fields_of(candidate: Candidate) -> Fields:
        return {
            "design": candidate.number,
            "values": candidate.values,
            "objectives": dict(zip(names, candidate.objectives, strict=True)),
            "excess": max(candidate.excess, default=0.0),
            "admissible": candidate.is_admissible,
        }

    fields = {
        "vary": {vary.key: {**vary.entry, "unit": vary.unit} for vary in result.design.vary},
        "minimise": list(names),
        "within": [str(limit) for limit in result.limits],
        "shown": result.shown_name,
        "at_bounds": keys_at_bounds(result),
        "best": result.best and fields_of(result.best),
        "closest": None if result.best or not result.closest else fields_of(result.closest),
        "half_widths": dict(zip(names, result.half_widths, strict=True)),
        **{name: region and region.ends for name, region in regions.items()},
        "binding": [
            {"limit": binding.text, "objective_without": binding.objective}
            for binding in result.binding
        ],
        "variants": {variant.name: fields_of(variant.candidate) for variant in result.variants},
        "front": [fields_of(candidate) for candidate in front],
        "conditions": [_condition_fields(result, row) for row in result.several_rows],
        "metrics_at": result.shown_row and result.place_of(result.shown_row),
        "metrics_of": describe_metrics(result),
    }
    numerics = {
        **result.numerics,
        "method": "surrogate model of objectives and limits (radial basis functions), refined "
        "by exact solutions under the same base motion",
        "evaluations": len(result.candidates),
        "converged": result.converged,
        "swept": axis_fields(result.design.conditions.axes),
        "cases": sum(row.seeds for candidate in result.candidates for row in candidate.rows),
        "seeds": result.candidates[0].rows[0].seeds,
    }
    return stored_fields(
        result, result.motion, numerics, result.metrics, provenance, design=fields
    )


CONDITION_METRICS = ("T_a", "SEAT", "x_r_peak", "stroke_used")
"""Metrics of the best design under each condition, after its objectives."""


def _condition_fields(result: DesignResult, row: ConditionRow) -> Fields:
    """Return limits and main metrics of the shown design under one of its conditions."""
    names = dict.fromkeys((*result.design.minimise, *CONDITION_METRICS))
    return {
        "at": result.place_of(row),
        "metrics": {name: row.metrics.get(name) for name in names},
        "half_widths": {name: row.half_widths.get(name) for name in names},
        "checks": [check_fields(verdict) for verdict in result.judge((row,))],
    }


BEST_FILE = "best.yaml"
"""The scenario of the best design."""


def write_best(result: DesignResult, file: Path) -> None:
    """Write the scenario of the best design, if there is one."""
    write_scenario(result.scenario if result.best else None, file)


DESIGN = Kind(
    name="design",
    what="a design study",
    files=(File("design.csv", write_design_csv), File(BEST_FILE, write_best)),
    pictures=(
        Picture(
            "design",
            "design.draw",
            "Objective of the designs over the varied keys, or front of two objectives",
            fits_axes=True,
        ),
    ),
    fields=design_fields,
    summary=summarise,
    scenario=lambda result: result.source,
    legend=DESIGN_WORD,
)
