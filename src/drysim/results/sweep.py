"""A sweep: all cases of a scenario. Its files, fields, pictures and summary.

Extremes come with their places. Every case is checked against its own stroke limit.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from math import isclose
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim import wording
from drysim.metrics.table import METRICS, PEAK_STROKE
from drysim.metrics.text import (
    KEY_RATIOS,
    MEANINGS,
    describe_residual,
    format_metric_range,
    format_metric_ranges,
    format_value,
    format_with_interval,
    label_of,
)
from drysim.results.ensemble import END_STOP_METRICS
from drysim.results.fields import check_fields, metric_fields, numerics_fields, stored_fields
from drysim.results.kind import (
    File,
    Kind,
    Picture,
    clean_up_lines,
    describe_incomplete,
    judgements,
)
from drysim.results.tables import (
    Column,
    batches_to_format,
    case_columns,
    columns_of,
    format_cases,
    has_means,
    key_column,
    metric_column,
    require_package,
    write_csv,
    write_violations,
)
from drysim.scenario.axes import DIRECTION_KEY, EXTREME_KEY
from drysim.scenario.model import shows_peak_acceleration
from drysim.scenario.text import (
    describe_axis,
    describe_case,
    describe_clean_up,
    describe_scene,
    describe_seeds,
)
from drysim.study import run
from drysim.study.plan import approaches_of
from drysim.study.statistics import (
    MAX_CACHED_ROWS,
    OK,
    as_batches,
    averages_seeds,
    median_and_ends,
    quantiles_of_draws,
    share_of_draws,
    stopping_rule,
)
from drysim.study.summary import BAD, GOOD, Note, Row, Summary
from drysim.study.table import (
    JUMP_METRICS,
    MAX_ISOLATION_CASES,
    QUANTILE_LEVELS,
    RATIO_KEY,
    Tally,
    largest_excess,
    stroke_limits,
)
from drysim.study.warnings import describe_seeds_beyond, format_at, share_of_cases
from drysim.wording import (
    format_count,
    format_interval,
    format_length,
    format_number,
    format_percent,
    format_percent_range,
    format_range,
)

if TYPE_CHECKING:
    from drysim.results.fields import Fields, Provenance
    from drysim.scenario.axes import Axis
    from drysim.scenario.model import Scenario
    from drysim.study.plan import AsText
    from drysim.study.statistics import Batch
    from drysim.study.statistics import Row as CaseRow
    from drysim.study.table import BestCase, Extreme, Isolation, Jump, SeedSummary, Table

VALUE_WIDTH = 20
"""Columns of the values."""

MAX_NAMED_CURVES = 4
"""Curves whose isolation frequency is listed one by one."""

ROUNDING_TOLERANCE = 1e-9
"""Relative difference of extremes below which their places mean nothing [-]."""


def summarise(table: Table) -> Summary:
    """Return the summary of a sweep."""
    return Summary(
        name=wording.sanitise(table.scenario.name),
        about=table.scenario.about,
        scene=tuple(sweep_scene(table)),
        groups=(tuple(table_rows(table)),),
        width=VALUE_WIDTH,
        checks=judgements(table.checks, table.axes),
        conclusion=tuple(conclusions(table)),
        answer=tuple(answers(table)),
    )


def answers(table: Table) -> Iterator[str]:
    """Yield the ranges of the main metrics, and the best cases of a sweep of designs."""
    tally = _main_tally(table)
    if tally.ends:
        cases = "all cases" if table.complete else "the cases computed so far"
        yield f"Over {cases}: {format_metric_ranges(tally.ends)}."
    for name, best in table.answers:
        yield f"{name}: {best.result}, {best.describe(table.axes)}"


def sweep_scene(table: Table) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was swept, and what was not."""
    scenario, axes, tally = table.scenario, table.axes, _main_tally(table)
    varied = [axis.key for axis in axes]
    plant, law, base = scenario.oscillator.plant(), scenario.law(), scenario.excitation
    peak = tally.greatest(PEAK_STROKE)
    yield from describe_scene(scenario, plant, law, varied, tally.shared, peak)
    yield "base", base.describe_cases(table.motion, varied, table.records)
    same = not any(key.startswith("excitation.") for key in varied)
    motion = table.motion if same else None
    yield from clean_up_lines(describe_clean_up(motion, records=table.records))
    if seeds := tally.seeds:
        first: int = getattr(base, "seed", 1)
        drawn = range(first, first + seeds.most)
        counts = sorted({seeds.least, seeds.most})
        yield "seeds", describe_seeds(drawn, stopping_rule(scenario), counts)
    for i, axis in enumerate(axes):
        yield "" if i else "swept", describe_axis(axis)
    cases = (f"{tally.cases} by {name}" for name, tally in table.tallies.items())
    yield "cases", ", ".join(cases)
    if not table.complete:
        yield (
            "state",
            describe_incomplete(
                len(table.rows), run.count_cases(approaches_of(scenario)), "case"
            ),
        )


def _main_tally(table: Table) -> Tally:
    """Return the extremes over the cases of the scenario's approach, references left out."""
    return table.own_tally or Tally(table.scenario.solver.approach)


def table_rows(table: Table) -> Iterator[Row]:
    """Yield the main metrics."""
    tally = _main_tally(table)
    for metric in KEY_RATIOS:
        if metric in tally.extremes:
            yield _range_row(table, tally, metric)
            yield from widest_interval_row(table.axes, tally.seeds, metric)
    if table.has_frequency_curves:
        yield _isolation_row(table, table.isolation)
    if shows_peak_acceleration(table.scenario) and "x_dd_peak" in tally.extremes:
        yield _range_row(table, tally, "x_dd_peak")
    yield from stroke_rows(table, tally)
    yield from _hysteresis_rows(table)
    yield from _jump_rows(table)
    yield from _best_rows(table)
    if ends := tally.extremes.get("stuck_share"):
        yield _stuck_row(table, tally, ends)
    if ends := tally.extremes.get("energy_residual"):
        yield Row("energy", describe_residual(ends[1].value, "at most "))
    yield from _failure_rows(table)


def _range_row(table: Table, tally: Tally, metric: str) -> Row:
    """Return the range of a metric over the cases, and where its ends are."""
    if table.is_of_draws:
        return _draws_row(table, metric, MEANINGS.get(metric, ""))
    return Row(
        label_of(metric),
        format_metric_range(metric, tally.ends[metric]),
        "; ".join(filter(None, (MEANINGS.get(metric), describe_extent(table, tally, metric)))),
    )


def _stuck_row(table: Table, tally: Tally, ends: tuple[Extreme, Extreme]) -> Row:
    """Return the share of the time that the mass is stuck."""
    if table.is_of_draws and ends[1].value:
        return _draws_row(table, "stuck_share")
    remark = f"maximum {describe_place(table, ends[1])}" if ends[1].value else ""
    if remark and is_constant(tally, "stuck_share"):
        remark = describe_extent(table, tally, "stuck_share")
    span = format_percent_range(*(end.value for end in ends))
    return Row(label_of("stuck_share"), span, remark)


def _draws_row(table: Table, metric: str, remark: str = "") -> Row:
    """Return the median of a metric over the draws of a fit, and the ends of 95 % of them."""
    values = table.values_of(metric)
    median, interval = format_with_interval(metric, *median_and_ends(values))
    parts = f"{share_of_draws(len(values))}: {interval}", remark
    return Row(label_of(metric), median, "; ".join(filter(None, parts)))


def widest_interval_row(
    axes: Sequence[Axis], seeds: SeedSummary | None, metric: str
) -> Iterator[Row]:
    """Yield the widest confidence interval of the mean of a metric."""
    row = seeds.widest.get(metric) if seeds else None
    if row is not None:
        width = row.half_widths[metric]
        mean, where = row.metrics.get(metric), describe_case(row.point, axes)
        remark = f"widest interval: {format_interval(mean, width)} at {where}"
        yield Row("", f"± {format_number(width, digits=2)}", remark)


def _isolation_row(table: Table, isolations: Sequence[Isolation] | None) -> Row:
    """Return the frequency above which the seat isolates, over all curves that do."""
    if isolations is None:
        many = f"not determined, as there are more than {MAX_ISOLATION_CASES} cases"
        return Row("isolation", wording.UNKNOWN, many)
    begins = [curve.above for curve in isolations if curve.above is not None]
    if not begins:
        return Row("isolation", "nowhere", "T_a is not below 1 at the end of any curve")
    first, last, remark = min(begins), max(begins), "T_a stays below 1"
    alike = first == last and len(begins) == len(isolations)
    if not alike and len(isolations) <= MAX_NAMED_CURVES:
        remark += ": " + "; ".join(
            f"{describe_case(curve.point, table.axes)} "
            + ("nowhere" if curve.above is None else f"from {format_number(curve.above, 'Hz')}")
            for curve in isolations
        )
    elif not alike:
        lost = len(begins) < len(isolations)
        curves = f"{len(begins)} of {len(isolations)}" if lost else f"all {len(isolations)}"
        remark += f" on {curves} curves" + ", nowhere on the others" * lost
        if first < last:
            remark += f"; on {begins.count(first)} of them from {format_number(first, 'Hz')}"
    return Row("isolation", f"from {format_number(last, 'Hz')}", remark)


def _hysteresis_rows(table: Table) -> Iterator[Row]:
    """Yield where the sweeps up and down differ, with the greatest difference of T_a."""
    loops = table.hysteresis
    if loops is None:
        return
    if not loops:
        yield Row("hysteresis", "none", "T_a is the same up and down, in every case")
        return
    low, high = min(loop.low for loop in loops), max(loop.high for loop in loops)
    widest = max(loops, key=lambda loop: loop.gap)
    up, down = (
        row.status if row.status != OK else format_number(row.metrics["T_a"], digits=5)
        for row in (widest.up, widest.down)
    )
    where = describe_case(widest.point, table.axes)
    yield Row(
        "hysteresis",
        wording.format_quantity_range(low, high, table.axes[0].unit),
        f"T_a {up} up against {down} down at {where}",
    )


def _jump_rows(table: Table) -> Iterator[Row]:
    """Yield the values of the static ratio at which the answer jumps."""
    if table.jumps is None:
        return
    resolved = all(warning.slug != "jumps-unresolved" for warning in table.warnings)
    if not table.jumps and resolved:
        yield Row("jumps", "none", "no metric changes abruptly by more than 1 %")
    elif not table.jumps:
        yield Row("jumps", "not known", "the answer changes too often: see the warning")
    if table.axes[-1].key == EXTREME_KEY:
        yield from _swept_jump_rows(table)
        return
    for place, jump in enumerate(table.jumps[:MAX_NAMED_JUMPS]):
        name = "" if place else "jumps"
        yield Row(name, f"at {format_number(jump.value, digits=7)}", describe_jump(jump))
    if (left := len(table.jumps) - MAX_NAMED_JUMPS) > 0:
        yield Row("", f"and {left} more", "all are in drysim.json")


def _swept_jump_rows(table: Table) -> Iterator[Row]:
    """Yield where the answer jumps in the cases of a sweep, and the largest jump of T_a."""
    if not table.jumps:
        return

    def size(jump: Jump) -> float:
        below, above = jump.below.metrics["T_a"], jump.above.metrics["T_a"]
        return 0.0 if below is None or above is None else abs(below - above)

    low, high = (pick(jump.value for jump in table.jumps) for pick in (min, max))
    largest = max(table.jumps, key=size)
    place = describe_case(largest.point, table.axes)
    count = wording.format_count(len(table.jumps), "jump")
    remark = f"{count}, the largest of T_a at {place}: {describe_jump(largest)}"
    yield Row("jumps", f"at {format_range(low, high, digits=7)}", remark)


MAX_NAMED_JUMPS = 6
"""Jumps that are listed one by one."""


JUMPING_METRICS = {"T_a": 5, PEAK_STROKE: 4, "stuck_share": 3}
"""Metrics of both sides of a jump, and their significant digits."""


def describe_jump(jump: Jump) -> str:
    """Describe a jump by the metrics that read differently on both sides."""
    if jump.below.status != jump.above.status:
        return f"{jump.below.status} below, {jump.above.status} above"
    parts = []
    for metric, digits in JUMPING_METRICS.items():
        below, above = (
            format_value(metric, row.metrics.get(metric), digits)
            for row in (jump.below, jump.above)
        )
        if below != above:
            parts.append(f"{label_of(metric)} from {below} to {above}")
    return ", ".join(parts)


def _best_rows(table: Table) -> Iterator[Row]:
    """Yield the best admissible case of a sweep of designs, and the best over all records."""
    for name, best in table.answers:
        least, tone = "", ""
        if best.row is None:
            tone = BAD
            ends = _main_tally(table).extremes.get(PEAK_STROKE)
            if ends and best.kind == "case":
                where = describe_place(table, ends[0])
                mean = " on average" * (ends[0].row.seeds > 1)
                least = (
                    f"; the least {label_of(PEAK_STROKE)} is "
                    f"{format_length(ends[0].value)}{mean} {where}"
                )
        yield Row(name, best.result, best.describe(table.axes, least), tone)


def conclusions(table: Table) -> Iterator[Note]:
    """Yield the answer of a sweep of designs in which a check fails."""
    for _, best in reversed(table.answers):
        if best.row and any(verdict.passed is False for verdict in table.checks):
            best_case = f"the best admissible {best.kind}, at {best.place(table.axes)},"
            sentence = f"{best_case} keeps every check that applies to it"
            yield Note("✓ best", sentence, GOOD)
            return


def stroke_rows(table: Table, tally: Tally) -> Iterator[Row]:
    """Yield the greatest stroke and by how much the limit is exceeded."""
    if PEAK_STROKE not in tally.extremes:
        return
    if not table.is_of_draws:
        yield from _peak_rows(table, tally)
    elif used := tally.extremes.get("stroke_used"):
        share = format_percent(used[1].value)
        yield _draws_row(table, PEAK_STROKE, f"at most {share} of the stroke limit")
    else:
        yield _draws_row(table, PEAK_STROKE)
    if tally.beyond:
        cases = share_of_cases(tally.beyond, tally.cases)
        if table.scenario.stops and (speed := tally.extremes.get("impact_speed")):
            name = "stops hit"
            verb = END_STOP_METRICS["impact_speed"]
            fastest = format_value("impact_speed", speed[1].value)
            remark = f"{verb} {fastest}, {describe_place(table, speed[1])}"
        else:
            name = "limit"
            remark = f"exceeded {_describe_violation(table, tally)}"
        yield Row(name, cases, remark, BAD)


def _peak_rows(table: Table, tally: Tally) -> Iterator[Row]:
    """Yield the greatest stroke over the cases, and the largest share of the limit."""
    (_, peak), used = tally.extremes[PEAK_STROKE], tally.extremes.get("stroke_used")
    share = format_percent(peak.row.metrics.get("stroke_used"))
    remark = f"{share} of the stroke limit, " if used else ""
    reached = peak.row.metrics.get("stroke_suffices") or 0.0
    if used and reached > peak.value:
        remark = (
            f"{share} of the stroke limit, by {format_length(reached, peak.value)} while "
            "settling, "
        )
    same = is_constant(tally, PEAK_STROKE) and not (
        used and not is_constant(tally, "stroke_used")
    )
    where = describe_extent(table, tally, PEAK_STROKE) if same else describe_place(table, peak)
    yield Row(label_of(PEAK_STROKE), format_length(peak.value), f"{remark}{where}")
    # If the limit is swept, another case may use a greater share of its own.
    if used and format_percent(used[1].value) != share:
        most = format_percent(used[1].value)
        yield Row(
            "", most, f"largest share of the stroke limit, {describe_place(table, used[1])}"
        )


def _describe_violation(table: Table, tally: Tally) -> str:
    """Describe by how much, or when, the stroke limit is exceeded."""
    worst = tally.worst
    limits = stroke_limits(table.scenario, worst.point) if worst else None
    if worst is None or limits is None:
        return ""
    if tally.seeds:
        return f"{describe_seeds_beyond(worst)}{format_at(worst, table.axes)}"
    _, _, beyond = largest_excess(worst.metrics, limits)
    return f"by up to {format_length(beyond, tally.greatest('x_r_peak'))}"


def _failure_rows(table: Table) -> Iterator[Row]:
    """Yield the number of cases without values by status, with the first one."""
    counts: Counter[str] = Counter()
    firsts: dict[str, CaseRow] = {}
    for tally in table.tallies.values():
        for status, (count, first) in tally.lost.items():
            counts[status] += count
            firsts.setdefault(status, first)
    for status, first in firsts.items():
        where = describe_case(first.point, table.axes)
        note = f": {first.note}" if first.note else ""
        cases = format_count(counts[status], "case")
        yield Row(status, cases, f"first at {where}{note}", BAD)


def describe_extent(table: Table, tally: Tally, metric: str) -> str:
    """Describe where a metric has its minimum and its maximum."""
    if is_constant(tally, metric):
        return "the same in every case" + " that has a value" * bool(tally.lost)
    least, most = (describe_place(table, end) for end in tally.extremes[metric])
    return f"minimum {least}, maximum {most}" if least != most else least


def is_constant(tally: Tally, metric: str) -> bool:
    """Whether a metric is the same in several cases, up to rounding."""
    least, most = tally.extremes[metric]
    count = tally.cases - sum(count for count, _ in tally.lost.values())
    return count > 1 and isclose(least.value, most.value, rel_tol=ROUNDING_TOLERANCE)


def describe_place(table: Table, extreme: Extreme) -> str:
    """Describe where an extreme is."""
    return f"at {describe_case(extreme.row.point, table.axes)}"


def transmissibility_text(scenario: Scenario) -> AsText | None:
    """Return what formats the cases of a large sweep in the workers; None for a small one.

    The rows of a small table are formatted together: its batches may hold a single case each.
    """
    if run.count_cases(approaches_of(scenario)) <= MAX_CACHED_ROWS:
        return None
    columns = columns_of(scenario, scenario.sweep, averages_seeds(scenario))
    return partial(format_cases, columns)


def write_transmissibility_csv(table: Table, file: Path) -> None:
    """Write transmissibility.csv: every case of a sweep, then those of its reference."""
    from drysim.study.store import StoredBatches

    columns, batches = case_columns(table), batches_to_format(table.rows)
    as_text = partial(format_cases, columns)
    blocks: Iterator[bytes] = map(as_text, batches)
    if isinstance(batches, StoredBatches):
        blocks = batches.texts(as_text)
    write_csv(file, [column.header for column in columns], blocks)


def all_cases(table: Table) -> tuple[list[Column], Iterable[Batch]]:
    """Return the columns of transmissibility.csv, those of all other metrics, and the cases."""
    columns = case_columns(table)
    names = {column.name for column in columns}
    others = [metric_column(metric.name) for metric in METRICS if metric.name not in names]
    return [*columns, *others], as_batches(table.rows)


def write_case_violations_csv(table: Table, file: Path) -> None:
    """Write stroke_violations.csv of a sweep, if the stroke limit was exceeded.

    The viscous reference is left out: it is not the seat under test.
    """
    tally = table.own_tally
    if tally is not None and tally.beyond:
        keys = [key_column(axis.key, axis.unit) for axis in table.axes]
        write_violations(file, keys, table.rows, tally.approach)


PARQUET_FOLDER = "transmissibility"
"""The dataset: `approach=<name>/<number of the first case>.parquet` in it."""


def require_pyarrow() -> None:
    """Verify, before any work, that pyarrow is installed; see `require_package`."""
    require_package("pyarrow", "parquet", "--format parquet", ", or omit --format")


def write_transmissibility_parquet(table: Table, folder: Path) -> None:
    """Write the cases of a sweep as a dataset, with the columns of transmissibility.csv."""
    import pyarrow.parquet

    columns = case_columns(table)[1:]  # the approach is in the path
    if has_means(table):  # a mean of counts may have decimals
        columns = [
            column._replace(whole=column.whole and _is_whole(column, table))
            for column in columns
        ]
    for batch in as_batches(table.rows):
        place = folder / PARQUET_FOLDER / f"approach={batch.approach}"
        place.mkdir(parents=True, exist_ok=True)
        file = place / f"{batch.first:012d}.parquet"
        pyarrow.parquet.write_table(_arrow_table(columns, batch), file)


def _is_whole(column: Column, table: Table) -> bool:
    """Whether all known numbers of a column are whole."""
    parts = (np.asarray(column.values(batch)) for batch in as_batches(table.rows))
    return all(bool(((part % 1 == 0) | np.isnan(part)).all()) for part in parts)


def _arrow_table(columns: Sequence[Column], batch: Batch) -> Any:
    """Return a batch as an Arrow table, the unit of each column in its metadata."""
    import pyarrow

    fields, arrays = [], []
    for name, unit, values_of, whole in columns:
        values, kind, missing = values_of(batch), pyarrow.string(), None
        if isinstance(values, np.ndarray):
            kind, missing = pyarrow.float64(), np.isnan(values)
            if whole or values.dtype.kind == "i":
                kind, values = pyarrow.int64(), np.where(missing, 0, values).astype(np.int64)
        fields.append(pyarrow.field(name, kind, metadata={"unit": unit or "-"}))
        arrays.append(pyarrow.array(values, kind, mask=missing))
    return pyarrow.table(arrays, schema=pyarrow.schema(fields))


def table_fields(table: Table, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for a sweep.

    The metrics are extremes over the cases of the scenario's approach, references left out.
    """
    approach, *references = table.approaches or ("",)
    tally = table.tallies.get(approach)
    numerics = {
        "approach": approach,
        "reference": next(iter(references), None),
        **numerics_fields(table, tally),
    }
    metrics = metric_fields(tally)
    if table.is_of_draws:
        levels = (0.025, *QUANTILE_LEVELS, 0.975)
        for name in metrics:
            quantiles = quantiles_of_draws(table.values_of(name), levels)
            metrics[name]["quantiles"] = {
                f"{level:g}": value for level, value in zip(levels, quantiles, strict=True)
            }
    further: Fields = {"best": _best_fields(table.best)} if table.best else {}
    if table.hysteresis is not None:
        further["hysteresis"] = [
            {
                "key": table.axes[0].key,
                "from": loop.low,
                "to": loop.high,
                "T_a": {
                    row.point[DIRECTION_KEY]: row.metrics["T_a"] for row in (loop.up, loop.down)
                },
                "where": loop.point,
            }
            for loop in table.hysteresis
        ]
    if table.jumps is not None:
        further["jumps"] = [
            {
                "key": RATIO_KEY,
                "at": jump.value,
                "where": jump.point,
                **{
                    name: {"below": jump.below.metrics[name], "above": jump.above.metrics[name]}
                    for name in JUMP_METRICS
                },
            }
            for jump in table.jumps
        ]
    return stored_fields(table, table.motion, numerics, metrics, provenance, **further)


def _best_fields(best: BestCase) -> Fields:
    """Return the best admissible case, or the check that the closest one fails."""
    place = None if best.row is None else dict(best.row.point)
    count = {"admissible": best.admissible, "cases": best.cases}
    fields: Fields = {"metric": best.objective, "value": best.value, "at": place, **count}
    if best.closest:
        fields["closest"] = check_fields(best.closest)
    if best.over_records:
        fields["over_records"] = _best_fields(best.over_records)
    return fields


SWEEP = Kind(
    name="sweep",
    what="a sweep",
    files=(
        File("transmissibility.csv", write_transmissibility_csv, "csv", cases=all_cases),
        File(
            f"{PARQUET_FOLDER}/approach=*/*.parquet", write_transmissibility_parquet, "parquet"
        ),
        File("stroke_violations.csv", write_case_violations_csv),
    ),
    pictures=(
        Picture(
            "transmissibility",
            "sweep.draw_transmissibility",
            "Transmissibilities of the cases",
            fits_axes=True,
        ),
        Picture(
            "stroke",
            "sweep.draw_stroke",
            "Largest relative displacement of the cases, and its limit",
            fits_axes=True,
        ),
        Picture(
            "map",
            "sweep.draw_map",
            "A metric over the two swept keys, where a limit is exceeded, and the best case",
            fits_axes=True,
        ),
        Picture(
            "srs",
            "sweep.draw_spectra",
            "Shock response spectra: peak acceleration and stroke over the natural frequency",
            fits_axes=True,
        ),
    ),
    fields=table_fields,
    summary=summarise,
)
