"""Plot branches.png: transmissibility and stroke of all periodic motions along a key.

Stable parts of a branch are solid, unstable ones dashed; every bifurcation has a mark.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from drysim.metrics.table import PEAK_STROKE
from drysim.plots import style
from drysim.plots.style import (
    T_A,
    PlottedMetric,
    Style,
    axis_label,
    plotted,
    set_ticks,
    set_title,
)
from drysim.scenario.text import describe_scene
from drysim.study.branches import (
    Branch,
    BranchesResult,
    describe_branch,
    describe_motions,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLORS = ("#1f4e79", "#b4540a", "#2e7d32", "#6a3d9a", "#a6761d", "#c2185b", "#00838f")
"""Colours of the branches; they are told apart in grey by their places and marks."""

PANEL_HEIGHT = 3.4
"""Height of a panel [inch]."""

LINE_WIDTHS = {True: 2.0, False: 1.2}

MARKS: dict[str, Style] = {
    "fold": {"marker": ">", "markersize": 7},
    "symmetry breaking": {"marker": "D", "markersize": 6},
    "period doubling": {"marker": "s", "markersize": 6},
    "grazing": {"marker": "o", "markersize": 5, "markerfacecolor": "white"},
    "unlocking": {"marker": "X", "markersize": 8},
    "continuum": {"marker": "*", "markersize": 10},
}
"""Marks of the bifurcations."""

OWN_STYLE: Style = {"color": "0.45", "linewidth": 1.0, "linestyle": (0, (1, 2)), "zorder": 0}


def draw(result: BranchesResult) -> Figure:
    """Draw the branches of a scenario."""
    peak = max(
        (float(branch.metrics[PEAK_STROKE].max()) for branch in result.branches), default=0.0
    )
    panels = (T_A, plotted(PEAK_STROKE, peak))
    figure, grid = style.panel_grid(len(panels), 1, PANEL_HEIGHT * len(panels))
    axes: list[Axes] = []
    for i, metric in enumerate(panels):
        axes.append(figure.add_subplot(grid[i, 0], sharex=axes[0] if axes else None))
        draw_panel(axes[-1], result, metric)
        set_title(axes[-1], metric.full_title)
    label = axis_label(result.axis)
    axes[-1].set_xlabel(label.text)
    for panel in axes:
        set_ticks(panel.xaxis, label.factor)
    case = result.case
    scene = describe_scene(result.scenario, case.plant, case.law, {result.axis.key})
    heading = style.make_heading(
        result.scenario,
        describe_motions(result),
        style.join_scene(scene),
        result.scenario.excitation.describe_cases(case.motion, [result.axis.key]),
    )
    style.finish_figure(figure, heading)
    return figure


def draw_panel(axes: Axes, result: BranchesResult, metric: PlottedMetric) -> None:
    """Draw one metric of all branches with their bifurcations."""
    if result.axis.range.is_log:
        axes.set_xscale("log")
    for branch in result.branches:
        draw_branch(axes, branch, metric)
    for bifurcation in result.bifurcations:
        branch = result.branches[bifurcation.branch - 1]
        axes.plot(
            bifurcation.value,
            branch.metrics[metric.name][bifurcation.position] * metric.scale,
            linestyle="none",
            color="black",
            zorder=4,
            clip_on=False,
            label=bifurcation.kind,
            **MARKS[bifurcation.kind],
        )
    if result.stated_value is not None:
        axes.axvline(result.stated_value, label="value in the scenario", **OWN_STYLE)
    axes.margins(x=0.02, y=0.08)
    low, _ = axes.get_ylim()
    axes.set_ylim(bottom=0.0 if metric.name == PEAK_STROKE else max(low, 0.0))
    axes.grid(alpha=0.25)


def draw_branch(axes: Axes, branch: Branch, metric: PlottedMetric) -> None:
    """Draw a branch: its stable parts solid, its unstable ones dashed."""
    values = branch.metrics[metric.name] * metric.scale
    color = COLORS[(branch.number - 1) % len(COLORS)]
    description = describe_branch(branch)
    for stable, part in branch.parts():
        axes.plot(
            branch.values[part],
            values[part],
            color=color,
            linewidth=LINE_WIDTHS[stable],
            linestyle="-" if stable else (0, (4, 2)),
            label=description if stable else f"{description}, unstable",
        )
