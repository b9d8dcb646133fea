"""Summary of branches: the motions at the value of the scenario, branches, bifurcations."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from drysim import wording
from drysim.console.summaries import (
    SummaryRow,
    print_labelled,
    show_folder,
    show_rows,
    show_scene,
    show_title,
    show_warnings,
)
from drysim.console.terminal import stdout
from drysim.study.branches import (
    GRAZING,
    Branch,
    BranchesResult,
    describe_branch,
    describe_motions,
)
from drysim.wording import describe_axis, format_length, format_number, format_unit

VALUE_WIDTH = 16
"""Width of the values."""

MAX_SHOWN = 24
"""Bifurcations that are printed; all are in bifurcations.csv."""


def show_branches(result: BranchesResult, folder: Path | None = None) -> None:
    """Show the summary of branches."""
    console = stdout()
    show_title(console, result.scenario)
    show_scene(console, branches_scene(result))
    if result.motions:
        print_labelled(console, "motions", describe_motions(result))
    show_rows(console, branch_rows(result), VALUE_WIDTH)
    if result.bifurcations:
        show_rows(console, bifurcation_rows(result), VALUE_WIDTH)
    show_folder(console, folder)
    show_warnings(result.warnings)


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


def branch_rows(result: BranchesResult) -> Iterator[SummaryRow]:
    """Yield each branch: its range, its kind and its transmissibility."""
    for one in result.branches:
        low, high = result.place(float(one.values.min())), result.place(float(one.values.max()))
        yield SummaryRow(
            f"branch {one.number}", f"{low} to {high}", f"{describe_branch(one)}; {sizes(one)}"
        )


def sizes(branch: Branch) -> str:
    """Describe stability and range of T_a and stroke of a branch."""
    share = float(branch.stable.mean())
    stability = "stable" if share == 1.0 else "unstable" if share == 0.0 else "partly stable"
    T_a, peak = branch.metrics["T_a"], branch.metrics["x_r_peak"]
    if branch.is_locked:
        return "stable, T_a 1"
    low, high = (format_number(float(value), digits=4) for value in (T_a.min(), T_a.max()))
    return f"{stability}, T_a {low} to {high}, stroke up to {format_length(float(peak.max()))}"


def bifurcation_rows(result: BranchesResult) -> Iterator[SummaryRow]:
    """Yield the bifurcations, by value of the key."""
    for one in result.bifurcations[:MAX_SHOWN]:
        remarks = [f"branch {one.branch}"]
        for counts, name in ((one.stops, "stops"), (one.contacts, "contacts")):
            before, after = map(format_number, counts)
            if one.kind == GRAZING and before != after:
                remarks.append(f"{before} to {after} {name} per period")
        value = format_number(one.value, format_unit(result.axis.unit), 10)
        yield SummaryRow(one.kind, value, "; ".join(remarks))
    if len(result.bifurcations) > MAX_SHOWN:
        more = len(result.bifurcations) - MAX_SHOWN
        yield SummaryRow("…", f"{more} more", "all are in bifurcations.csv")
