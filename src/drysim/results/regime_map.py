"""A regime map: its files, fields, picture and summary."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drysim import wording
from drysim.core.compile import engine
from drysim.results.fields import stored_fields
from drysim.results.kind import File, Kind, Picture, judgements
from drysim.results.tables import column_header, format_rows, quote_cell, write_csv
from drysim.scenario.text import describe_point, short_key
from drysim.study.regimes import (
    ISOLATION,
    SEVERAL,
    STROKE,
    RegimeMap,
    describe_fixed,
    describe_regime,
    is_random,
    require_map,
)
from drysim.study.statistics import seed_range
from drysim.study.summary import Row, Summary
from drysim.wording import format_number, format_percent, format_quantity

if TYPE_CHECKING:
    from drysim.results.fields import Fields, Provenance
    from drysim.study.case import Case

VALUE_WIDTH = 10
"""Width of the values."""

SHARE_ROWS = {
    ISOLATION: ("T_a below 1", "the mass is isolated"),
    STROKE: ("stroke limit", "|x_r| reaches it"),
    SEVERAL: ("several", "other starts lead to another stable motion"),
}
"""Names and explanations of the shares of the map in which a label is 1."""


def summarise(result: RegimeMap) -> Summary:
    """Return the summary of a regime map."""
    return Summary(
        name=wording.sanitise(result.scenario.name),
        about=result.scenario.about,
        scene=tuple(result_scene(result)),
        groups=(tuple(share_rows(result)), tuple(place_rows(result))),
        width=VALUE_WIDTH,
        checks=judgements(result.checks),
        answer=tuple(answers(result)),
    )


def answers(result: RegimeMap) -> Iterator[str]:
    """Yield what the scenario itself does, and the nearest boundaries along the axes."""
    place, units = result.place, {axis.key: axis.unit for axis in result.axes}
    if motion := [*result.describe_place()]:
        yield f"At {describe_point(place.values, units)}: {'; '.join(motion)}."
    for change in place.changes:
        more = "more" if change.distance > 0.0 else "less"
        step = format_quantity(abs(change.distance), units[change.key], 3)
        yield f"{step} {more} {change.key}: {change.sentence}."


def map_scene(case: Case) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: the axes, and what all points of the map share."""
    scenario = case.scenario
    axes, grid = require_map(scenario)
    keys = [axis.key for axis in axes]
    for name, axis in zip(("over", "and"), axes, strict=True):
        yield name, f"{axis.key} {axis.description}"
    size = f"{grid.columns} × {grid.rows}"
    if is_random(scenario):
        begin, end = case.window
        seeds = wording.format_count(len(seed_range(scenario)), "seed")
        yield "grid", f"{size} motions of {format_number(end - begin, 's')}, {seeds}"
    else:
        remark = "a region may be missed where it is narrower than a cell"
        yield "grid", f"{size} periodic orbits; {remark}"
    yield from describe_fixed(case, keys)
    yield "base", scenario.excitation.describe_cases(case.motion, keys)


def result_scene(result: RegimeMap) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was mapped, and how well the boundaries are known."""
    yield from map_scene(result.case)
    width = max((line.width for line in result.boundaries), default=0.0)
    accuracy = "to rounding"
    if width > 0.0:
        share = format_number(100.0 * width, "%", 1)
        accuracy += f", and to {share} of an axis where the motion settles slowly"
    count = wording.format_count(len(result.boundaries), "line")
    if is_random(result.scenario):
        yield "lines", f"{count} of equal rate, interpolated between {result.cases} points"
    else:
        yield "boundaries", f"{count} by {result.cases} orbits, {accuracy}"


def share_rows(result: RegimeMap) -> Iterator[Row]:
    """Yield the share of the map in each regime."""
    for label, share in result.shares.items():
        yield Row(describe_regime(label), format_percent(share), "of the map")
    for field, (name, remark) in SHARE_ROWS.items():
        if field in result.labels and (share := result.share(field)):
            yield Row(name, format_percent(share), remark)


def place_rows(result: RegimeMap) -> Iterator[Row]:
    """Yield what the scenario itself does, and the nearest boundaries along the axes."""
    place, keys = result.place, [axis.key for axis in result.axes]
    if not place.values:
        yield Row("here", "–", "the file does not state both keys")
        return
    values = ", ".join(
        f"{short_key(axis.key, keys)} {format_quantity(place.values[axis.key], axis.unit)}"
        for axis in result.axes
    )
    yield Row("here", values, "; ".join(result.describe_place()))
    if not place.is_inside:
        yield Row("", "", "outside the map")
    for change in place.changes:
        yield Row(short_key(change.key, keys), change.step, change.sentence)


def write_map_csv(result: RegimeMap, file: Path) -> None:
    """Write map.csv: the points of each traced boundary, in order along its lines."""
    lines, numbers = result.boundaries, Counter[str]()
    names, counts, points = list[bytes](), list[bytes](), [np.empty((0, 2))]
    for line in lines:
        numbers[line.name] += 1
        names += [quote_cell(line.name).encode()] * len(line.points)
        counts += [b"%d" % numbers[line.name]] * len(line.points)
        points.append(line.points)
    rows = format_rows([names, counts, *np.concatenate(points).T])
    keys = [column_header(axis.key, axis.unit) for axis in result.axes]
    write_csv(file, ["boundary", "line [-]", *keys], [rows])


def map_fields(result: RegimeMap, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for a regime map."""
    lines, place = result.boundaries, result.place
    numerics = {
        "method": "break-aways counted on a grid; lines interpolated on its edges"
        if place.rates is not None
        else "periodic orbits on a grid; boundaries bisected on its edges",
        "engine": engine(),
        "cases": result.cases,
        "cell": [float(shares[1]) for shares in result.grid.shares],
        "width": max((line.width for line in lines), default=0.0),
    }
    fields = {
        "axes": [
            {"key": axis.key, "unit": axis.unit, **axis.entry, "count": count}
            for axis, count in zip(result.axes, result.grid, strict=True)
        ],
        "regimes": result.regimes,
        "boundaries": dict(Counter(line.name for line in lines)),
        "here": {
            "values": dict(place.values),
            "motion": list(result.describe_place()),
            "rates": place.rates and place.rates._asdict(),
            "nearest": [
                {"key": change.key, "distance": change.distance, "what": change.sentence}
                for change in place.changes
            ],
        },
    }  # fmt: skip
    return stored_fields(
        result, result.motion, numerics, result.metrics, provenance, map=fields
    )


MAP = Kind(
    name="map",
    what="a regime map",
    files=(File("map.csv", write_map_csv),),
    pictures=(
        Picture(
            "map",
            "regimes.draw",
            "Regimes of the steady motion over two keys, and the boundaries between them",
            fits_axes=True,
        ),
    ),
    fields=map_fields,
    summary=summarise,
)
