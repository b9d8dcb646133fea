"""Summary of branches: the motions at the value of the scenario, branches, bifurcations."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from drysim import wording
from drysim.console.summaries import SummaryRow, show_summary
from drysim.metrics.table import PEAK_STROKE
from drysim.study.branches import (
    GRAZING,
    Branch,
    BranchesResult,
    describe_branch,
    describe_motions,
)
from drysim.wording import (
    describe_axis,
    format_count,
    format_length,
    format_number,
    format_range,
    format_unit,
    join_words,
)

VALUE_WIDTH = 16
"""Width of the values."""

MAX_RANGES = 3
"""Stable and unstable ranges of a branch that are printed; all points are in branches.csv."""

MAX_SHOWN = 24
"""Bifurcations that are printed; all are in bifurcations.csv."""


def show_branches(result: BranchesResult, folder: Path | None = None) -> None:
    """Show the summary of branches."""
    scene = [*branches_scene(result)]
    if result.own is not None:
        scene.append(("motions", describe_motions(result)))
    groups = branch_rows(result), bifurcation_rows(result)
    show_summary(result, scene, groups, VALUE_WIDTH, folder)


def branches_scene(result: BranchesResult) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was solved, along which key."""
    case, key = result.case, result.axis.key
    yield from wording.describe_scene(result.scenario, case.plant, case.law, {key})
    yield "base", result.scenario.excitation.describe_cases(case.motion, [key])
    yield "along", f"{describe_axis(result.axis)}; {result.starts} starts"
    if result.multiplier_error > 0.0:
        yield (
            "shooting",
            f"orbits close to {result.residual:.1g}, multipliers to "
            f"{result.multiplier_error:.1g}",
        )


def motion_rows(result: BranchesResult) -> Iterator[SummaryRow]:
    """Yield the motions at the value of the scenario, if that is in the range."""
    if result.own is not None:
        yield SummaryRow("motions", describe_motions(result))


def branch_rows(result: BranchesResult) -> Iterator[SummaryRow]:
    """Yield each branch: its range, its kind, where it is stable, T_a and stroke."""
    for one in result.branches:
        words = [describe_branch(one), describe_stability(result, one)]
        if not one.is_locked:
            T_a, peak = one.metrics["T_a"], float(one.metrics[PEAK_STROKE].max())
            span = format_range(float(T_a.min()), float(T_a.max()))
            words[1] += f", T_a {span}, stroke up to {format_length(peak)}"
        else:
            words[1] += ", T_a 1"
        yield SummaryRow(f"branch {one.number}", result.interval(one.values), "; ".join(words))


def describe_stability(result: BranchesResult, branch: Branch) -> str:
    """Describe where a branch is stable, e.g. `stable at 1 to 1.4, unstable at 1.3 to 1.4`."""
    ranges: dict[str, list[str]] = {"stable": [], "unstable": []}
    for is_stable, part in branch.parts():
        ranges["stable" if is_stable else "unstable"].append(
            result.interval(branch.values[part])
        )
    if not all(ranges.values()):
        return "stable" if ranges["stable"] else "unstable"
    return ", ".join(
        f"{word} at {join_words([*found[:MAX_RANGES], *more_ranges(found)])}"
        for word, found in ranges.items()
    )


def more_ranges(ranges: Sequence[str]) -> list[str]:
    """Describe how many ranges are not printed; empty if all are."""
    more = len(ranges) - MAX_RANGES
    return [format_count(more, "more range")] if more > 0 else []


def bifurcation_rows(result: BranchesResult) -> Iterator[SummaryRow]:
    """Yield the bifurcations, by value of the key."""
    for one in result.bifurcations[:MAX_SHOWN]:
        remarks = [f"branch {one.branch}"]
        for counts, name in ((one.stops, "stops"), (one.contacts, "contacts")):
            before, after = map(format_number, counts)
            if one.kind == GRAZING and before != after:
                remarks.append(f"{format_range(before, after)} {name} per period")
        value = format_number(one.value, format_unit(result.axis.unit), 10)
        yield SummaryRow(one.kind, value, "; ".join(remarks))
    if len(result.bifurcations) > MAX_SHOWN:
        more = len(result.bifurcations) - MAX_SHOWN
        yield SummaryRow("…", f"{more} more", "all are in bifurcations.csv")
