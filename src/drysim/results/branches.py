"""Branches of periodic motions: their files, fields, picture and summary."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drysim import wording
from drysim.metrics.table import PEAK_STROKE
from drysim.results.fields import stored_fields
from drysim.results.kind import File, Kind, Picture, judgements
from drysim.results.tables import Values, column_header, format_rows, write_csv
from drysim.scenario.text import describe_axis, describe_scene
from drysim.study.branches import (
    GRAZING,
    Branch,
    BranchesResult,
    describe_branch,
    describe_motions,
)
from drysim.study.summary import Row, Summary
from drysim.wording import (
    format_count,
    format_length,
    format_number,
    format_quantity,
    format_range,
    join_words,
)

if TYPE_CHECKING:
    from drysim.results.fields import Fields, Provenance

VALUE_WIDTH = 16
"""Width of the values."""

MAX_RANGES = 3
"""Stable and unstable ranges of a branch that are printed; all points are in branches.csv."""

MAX_SHOWN = 24
"""Bifurcations that are printed; all are in bifurcations.csv."""


def summarise(result: BranchesResult) -> Summary:
    """Return the summary of branches."""
    scene = [*branches_scene(result)]
    if result.stated_value is not None:
        scene.append(("motions", describe_motions(result)))
    return Summary(
        name=wording.sanitise(result.scenario.name),
        about=result.scenario.about,
        scene=scene,
        groups=(tuple(branch_rows(result)), tuple(bifurcation_rows(result))),
        width=VALUE_WIDTH,
        checks=judgements(result.checks),
        answer=(describe_answer(result),),
    )


def describe_answer(result: BranchesResult) -> str:
    """Return the stable motions at the value of the scenario in a sentence."""
    if result.stated_value is None:
        return f"{format_count(len(result.branches), 'branch')} along {result.axis.key}."
    stable = "; ".join(
        f"T_a {format_number(motion.T_a, digits=4)}, stroke {format_length(motion.x_r_peak)}"
        for motion in result.motions
        if motion.stable
    )
    place = f"{result.axis.key} {format_number(result.stated_value)}"
    return f"Stable motions at {place}: {stable or 'none found'}."


def branches_scene(result: BranchesResult) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was solved, along which key."""
    case, key = result.case, result.axis.key
    yield from describe_scene(result.scenario, case.plant, case.law, {key})
    yield "base", result.scenario.excitation.describe_cases(case.motion, [key])
    yield "along", f"{describe_axis(result.axis)}; {result.starts} starts"
    if result.multiplier_error > 0.0:
        yield (
            "shooting",
            f"orbits close to {result.residual:.1g}, multipliers to "
            f"{result.multiplier_error:.1g}",
        )


def branch_rows(result: BranchesResult) -> Iterator[Row]:
    """Yield each branch: its range, its kind, where it is stable, T_a and stroke."""
    for branch in result.branches:
        remarks = [describe_branch(branch), describe_stability(result, branch)]
        if not branch.is_locked:
            T_a, peak = branch.metrics["T_a"], float(branch.metrics[PEAK_STROKE].max())
            span = format_range(float(T_a.min()), float(T_a.max()))
            remarks[1] += f", T_a {span}, stroke up to {format_length(peak)}"
        else:
            remarks[1] += ", T_a 1"
        yield Row(f"branch {branch.number}", result.interval(branch.values), "; ".join(remarks))


def describe_stability(result: BranchesResult, branch: Branch) -> str:
    """Describe where a branch is stable, e.g. `stable at 1 to 1.4, unstable at 1.3 to 1.4`."""
    ranges: dict[str, list[str]] = {"stable": [], "unstable": []}
    values = branch.values.copy()
    for bifurcation in result.bifurcations:  # an end is extrapolated beyond the last point
        ends = (0, len(values) - 1)
        if bifurcation.branch == branch.number and bifurcation.position in ends:
            values[bifurcation.position] = bifurcation.value
    for is_stable, part in branch.parts():
        ranges["stable" if is_stable else "unstable"].append(result.interval(values[part]))
    if not all(ranges.values()):
        return "stable" if ranges["stable"] else "unstable"
    return ", ".join(
        f"{word} at {join_words([*intervals[:MAX_RANGES], *more_ranges(intervals)])}"
        for word, intervals in ranges.items()
    )


def more_ranges(ranges: Sequence[str]) -> list[str]:
    """Describe how many ranges are not printed; empty if all are."""
    more = len(ranges) - MAX_RANGES
    return [format_count(more, "more range")] if more > 0 else []


def bifurcation_rows(result: BranchesResult) -> Iterator[Row]:
    """Yield the bifurcations, by value of the key."""
    for bifurcation in result.bifurcations[:MAX_SHOWN]:
        remarks = [f"branch {bifurcation.branch}"]
        for counts, name in ((bifurcation.stops, "stops"), (bifurcation.contacts, "contacts")):
            before, after = map(format_number, counts)
            if bifurcation.kind == GRAZING and before != after:
                remarks.append(f"{format_range(before, after)} {name} per period")
        value = format_quantity(bifurcation.value, result.axis.unit, 10)
        yield Row(bifurcation.kind, value, "; ".join(remarks))
    if len(result.bifurcations) > MAX_SHOWN:
        more = len(result.bifurcations) - MAX_SHOWN
        yield Row("…", f"{more} more", "all are in bifurcations.csv")


BRANCH_METRICS = ("T_a", "T_x", "x_r_peak", "stuck_share")
"""Metrics of the points of a branch."""


def write_branches_csv(result: BranchesResult, file: Path) -> None:
    """Write branches.csv: every point of every branch, in the order along it."""
    headers = [
        "branch [-]",
        column_header(result.axis.key, result.axis.unit),
        *map(column_header, BRANCH_METRICS),
        "stops_per_period [-]",
        "symmetric [-]",
        "periods [-]",
        "stable [-]",
        *(f"multiplier_{i}{part}" for i in (1, 2) for part in (" [-]", "_phase [rad]")),
        "contacts_per_period [-]",
        "residual [-]",
        "multiplier_error [-]",
    ]

    def blocks() -> Iterator[bytes]:
        for branch in result.branches:
            count = len(branch.values)

            def same(value: float, count: int = count) -> NDArray[np.float64]:
                return np.full(count, float(value))

            parts = [
                part
                for i in (0, 1)
                for part in (abs(branch.multipliers[:, i]), np.angle(branch.multipliers[:, i]))
            ]
            yield format_rows(
                [
                    same(branch.number),
                    branch.values,
                    *(branch.metrics[name] for name in BRANCH_METRICS),
                    branch.stops,
                    same(branch.symmetric),
                    same(branch.periods),
                    branch.stable.astype(float),
                    *parts,
                    branch.contacts,
                    branch.residual,
                    branch.multiplier_error,
                ]
            )

    write_csv(file, headers, blocks())


def write_bifurcations_csv(result: BranchesResult, file: Path) -> None:
    """Write bifurcations.csv: where motions appear, vanish or change, by value of the key."""
    headers = [
        "bifurcation",
        "branch [-]",
        column_header(result.axis.key, result.axis.unit),
        "stops_before [-]",
        "stops_after [-]",
        "x_r_peak [m]",
        "contacts_before [-]",
        "contacts_after [-]",
    ]
    bifurcations = result.bifurcations
    numbers = np.array(
        [
            (
                bifurcation.branch,
                bifurcation.value,
                *bifurcation.stops,
                bifurcation.x_r_peak,
                *bifurcation.contacts,
            )
            for bifurcation in bifurcations
        ]
    ).reshape(-1, 7)
    columns: list[Values] = [
        [bifurcation.kind.encode() for bifurcation in bifurcations],
        *numbers.T.copy(),
    ]
    write_csv(file, headers, [format_rows(columns)] if bifurcations else [])


def branches_fields(result: BranchesResult, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for branches."""
    fields = {
        "key": result.axis.key,
        "unit": result.axis.unit,
        "own_value": result.stated_value,
        "starts": result.starts,
        "branches": [
            {
                "branch": branch.number,
                "kind": branch.kind,
                "periods": branch.periods,
                "points": len(branch.values),
                "lowest": float(branch.values.min()),
                "highest": float(branch.values.max()),
                "stable_points": int(branch.stable.sum()),
                "ends": list(branch.ends),
            }
            for branch in result.branches
        ],
        "bifurcations": [bifurcation._asdict() for bifurcation in result.bifurcations],
        "motions": [
            {**motion._asdict(), "branch": motion.branch.number} for motion in result.motions
        ],
    }
    numerics = {
        **result.numerics,
        "method": f"pseudo-arclength continuation of periodic orbits, {result.method}",
        "points": sum(len(branch.values) for branch in result.branches),
        "residual": result.residual,
        "multiplier_error": result.multiplier_error,
    }
    return stored_fields(result, result.motion, numerics, {}, provenance, branches=fields)


BRANCHES = Kind(
    name="branches",
    what="branches of periodic motions",
    files=(
        File("branches.csv", write_branches_csv),
        File("bifurcations.csv", write_bifurcations_csv),
    ),
    pictures=(
        Picture(
            "branches",
            "branches.draw",
            "All periodic motions along the key: stable ones solid, unstable ones dashed",
        ),
    ),
    fields=branches_fields,
    summary=summarise,
)
