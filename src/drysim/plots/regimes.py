"""Picture of a regime map: tinted regions with traced boundaries and labels in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim.plots import style
from drysim.plots.style import Style, axis_label, set_axis
from drysim.study.boundaries import LOCKED, REGIME
from drysim.study.break_aways import FIRST, RICE, level_between
from drysim.study.regimes import (
    ISOLATION,
    PERIODS,
    SEVERAL,
    STROKE,
    UNSETTLED,
    UNSYMMETRIC,
    RegimeMap,
    describe_fixed,
    describe_regime,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL_HEIGHT = 5.2
"""Height of the map [inch]."""

RATE_TINTS = ("#ffffff", "#eef3f8", "#dce8f2", "#c6d9ea", "#acc8e0", "#92b6d6", "#78a3cb")
"""Tints of rates of break-aways, from rare to frequent."""

STOP_TINTS = ("#ffffff", "#e6eff7", "#cfe0ef", "#b8d1e6", "#a2c1dc")
"""Tints of symmetric regions by pairs of stops; the last one also of more."""

OTHER_TINTS = {LOCKED: "#d4d4d4", UNSETTLED: "#f5d5d0"}
UNSYMMETRIC_TINT, PERIODS_TINT = "#fbe7bf", "#e3d3ec"

LINE_STYLES: dict[str, Style] = {
    REGIME: {"color": "#333333", "linewidth": 1.3},
    ISOLATION: {"color": "#1f6f43", "linewidth": 1.6, "linestyle": (0, (6, 2))},
    STROKE: {"color": "#b3261e", "linewidth": 1.8, "linestyle": (0, (1, 1.2))},
    SEVERAL: {"color": "#6a3d9a", "linewidth": 1.5, "linestyle": (0, (7, 2, 1.5, 2))},
    RICE: {"color": "#b06000", "linewidth": 1.2, "linestyle": (0, (5, 2))},
}
FIELD_LABELS = {
    ISOLATION: "isolation: Tₐ < 1",
    STROKE: "beyond the stroke limit",
    SEVERAL: "several stable motions",
}
"""Labels of the regions of the other fields, in the colours of their boundaries."""

OWN_STYLE: Style = {
    "linestyle": "none", "marker": "o", "markersize": 8.0, "color": "white",
    "markeredgecolor": "#b3261e", "markeredgewidth": 2.0, "zorder": 6, "label": "this scenario",
}  # fmt: skip

LABEL_SIZE, LETTER_SHARE, LINE_SHARE = 9.0, 0.0088, 0.036
"""Font size of the labels, and width of a letter and height of a line as shares of the map."""

SMALLEST_NAMED = 1e-4
"""Share of the map up to which a regime has no label: its boundaries hide it."""

ROOM = 0.45
"""Least room of a label as a share of its height."""

OUTSIDE_STEP = 0.055
"""Least distance of labels outside the map, as a share of its height."""

MAX_OUTSIDE = 14
"""Most labels outside the map; smaller regions have none."""


def draw(result: RegimeMap, ax: Axes | None = None) -> Figure:
    """Return the figure of a regime map."""
    figure, grid = style.panel_grid(1, 1, PANEL_HEIGHT, ax)
    axes = ax or figure.add_subplot(grid[0, 0])
    for which, axis in zip("xy", result.axes, strict=True):
        set_axis(axes, which, axis_label(axis), axis.low, axis.high, axis.is_log)
    tint(axes, result)
    hatch(axes, result)
    for line in sorted(result.boundaries, key=lambda line: line.field != REGIME):
        axes.plot(*line.points.T, **LINE_STYLES[line.field])
    if result.place.is_inside:
        axes.plot(*([x] for x in result.place.values.values()), **OWN_STYLE)
    if RICE in result.labels:
        name_rates(axes, result)
    else:
        write_labels(axes, result)
    axes.grid(visible=False)
    style.finish_figure(figure, heading(result), ax=ax)
    return figure


def name_rates(axes: Axes, result: RegimeMap) -> None:
    """Write the rate into each counted line and at the end of each line of Rice's formula."""
    for line in result.boundaries:
        label, color = f"{level_between(line.labels):g}/s", LINE_STYLES[line.field]["color"]
        if line.field == REGIME:
            x, y = line.points[len(line.points) // 2].tolist()
            axes.text(
                x, y, label, ha="center", va="center",
                fontsize=LABEL_SIZE, color=color, zorder=5,
                bbox={"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none"},
            )  # fmt: skip
        else:
            end = max(line.points[[0, -1]].tolist())
            axes.annotate(
                label, xy=end, xytext=(4, 4), textcoords="offset points",
                fontsize=LABEL_SIZE, color=color, annotation_clip=False,
            )  # fmt: skip
    drawn = {line.field for line in result.boundaries}
    for field, label in ((REGIME, "break-aways, counted"), (RICE, "by Rice's formula")):
        if field in drawn:
            axes.plot([], [], label=label, **LINE_STYLES[field])


def heading(result: RegimeMap) -> style.Heading:
    """Return the heading: what the scenario does, where that changes, and what is fixed."""
    title = "regimes of the steady motion"
    if RICE in result.labels:
        title = "break-aways from sticking, counted and by Rice's formula"
    if result.place.labels:
        title = f"this scenario: {next(result.describe_place())}"
    if (nearest := result.place.nearest) is not None:
        title = f"{title}; with {nearest}"
    scenario, keys = result.scenario, [axis.key for axis in result.axes]
    base = scenario.excitation.describe_cases(None, keys)
    fixed = style.join_scene(describe_fixed(result.case, keys))
    return style.make_heading(scenario, title, fixed, base)


def tint_of(label: int) -> str:
    """Return the colour of a regime."""
    if label in OTHER_TINTS:
        return OTHER_TINTS[label]
    if label >= FIRST:
        return RATE_TINTS[label - FIRST]
    if label >= UNSYMMETRIC:
        return PERIODS_TINT if label == PERIODS else UNSYMMETRIC_TINT
    return STOP_TINTS[min((label + 1) // 2, len(STOP_TINTS) - 1)]


def tint(axes: Axes, result: RegimeMap) -> None:
    """Fill the regions: cells, and over them the parts of those that hold a boundary."""
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgb

    labels = result.labels[REGIME]
    corner = labels[:-1, :-1]
    colors = np.ones((*corner.shape, 3))
    for label in result.shares:
        colors[corner == label] = to_rgb(tint_of(label))
    x, y = result.nodes
    axes.pcolormesh(x, y, colors, rasterized=True, zorder=0)
    patches = [patch for patch in result.patches if patch.field == REGIME]
    parts = PolyCollection(
        [patch.points for patch in patches],
        facecolors=[tint_of(patch.label) for patch in patches],
        edgecolors="none", antialiased=False, zorder=0.5,
    )  # fmt: skip
    axes.add_collection(parts, autolim=False)


def hatch(axes: Axes, result: RegimeMap) -> None:
    """Hatch the region in which there are several stable motions."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    if SEVERAL not in result.labels or not result.share(SEVERAL):
        return
    x, y = result.nodes
    polygons = [patch.points for patch in result.parts(SEVERAL)]
    for row, whole in enumerate(result.whole_cells(SEVERAL)):
        ends = np.flatnonzero(np.diff(whole, prepend=False, append=False))
        for first, last in ends.reshape(-1, 2).tolist():
            columns, rows = [first, last, last, first], [row, row, row + 1, row + 1]
            polygons.append(np.stack([x[columns], y[rows]], axis=1))
    outline = Path.make_compound_path(
        *(Path(np.concatenate([points, points[:1]]), closed=True) for points in polygons)
    )
    axes.add_patch(
        PathPatch(
            outline, facecolor="none", edgecolor="#b9a3cf", linewidth=0.0, hatch="///", zorder=1
        )
    )


# Labels of the regions.


def write_labels(axes: Axes, result: RegimeMap) -> None:
    """Write the name of each region into its widest place, or beside the map."""
    free = free_nodes(result)
    rows, columns = free.shape
    regions = [
        (REGIME, label, describe_regime(label), tint_of(label), "#222222")
        for label, share in result.shares.items()
        if share > SMALLEST_NAMED
    ]
    regions += [
        (field, 1, label, "none", LINE_STYLES[field]["color"])
        for field, label in FIELD_LABELS.items()
        if field in result.labels and result.share(field)
    ]
    outside = []
    for field, number, label, background, color in regions:
        region = result.labels[field] == number
        if not region.any():  # narrower than a cell everywhere
            patch = max(result.parts(field, number), key=lambda patch: patch.area)
            x, y = patch.points.mean(axis=0).tolist()
            outside.append((float(result.axes[1].share(y)), (x, y), label, color))
            continue
        wide, high = len(label) * LETTER_SHARE * columns, LINE_SHARE * rows
        room, row, column = widest_place(region & free, wide / high)
        if room >= ROOM * high:
            axes.text(
                *node(result, row, column), label, ha="center", va="center",
                fontsize=LABEL_SIZE, color=color, zorder=5,
                bbox={"boxstyle": "round,pad=0.1", "facecolor": background,
                      "edgecolor": "none", "alpha": 0.85},
            )  # fmt: skip
            free[box(row, column, wide, 1.5 * high)] = False
        else:
            _, row, column = widest_place(region, 1.0)
            outside.append((row / (rows - 1), node(result, row, column), label, color))
    write_outside(axes, outside[:MAX_OUTSIDE])


def free_nodes(result: RegimeMap) -> Any:
    """Return which nodes have neighbours with the same labels only and are not marked."""
    free = np.ones(result.labels[REGIME].shape, dtype=bool)
    for labels in result.labels.values():
        across, along = labels[1:] != labels[:-1], labels[:, 1:] != labels[:, :-1]
        free[1:] &= ~across
        free[:-1] &= ~across
        free[:, 1:] &= ~along
        free[:, :-1] &= ~along
    if result.place.is_inside:
        along, across = (axis.share(result.place.values[axis.key]) for axis in result.axes)
        rows, columns = result.labels[REGIME].shape
        row, column = round(across * (rows - 1)), round(along * (columns - 1))
        free[box(row, column, 2.0, LINE_SHARE * rows)] = False
    return free


def node(result: RegimeMap, row: int, column: int) -> tuple[float, float]:
    """Return the values of a node of the grid."""
    along, across = result.nodes
    return float(along[column]), float(across[row])


def box(row: int, column: int, wide: float, high: float) -> tuple[slice, slice]:
    """Return the rows and columns of a box of nodes around a node."""
    low, left = max(0, round(row - 0.5 * high)), max(0, round(column - 0.5 * wide))
    return slice(low, round(row + 0.5 * high) + 1), slice(left, round(column + 0.5 * wide) + 1)


def widest_place(inside: Any, aspect: float) -> tuple[float, int, int]:
    """Return half the height of the largest text box in a region, and its middle as a node.

    `aspect` is the width of the box over its height, in nodes.
    """
    from scipy import ndimage

    padded = np.pad(inside, 1)
    room = ndimage.distance_transform_edt(padded, sampling=(1.0, 1.0 / aspect))[1:-1, 1:-1]
    row, column = np.unravel_index(int(np.argmax(room)), room.shape)
    return float(room[row, column]), int(row), int(column)


def write_outside(
    axes: Axes, several: Sequence[tuple[float, tuple[float, float], str, str]]
) -> None:
    """Write labels beside the map, from top to bottom, each with a line to its region."""
    height = 1.0
    for share, point, label, color in sorted(several, reverse=True):
        height = min(height - OUTSIDE_STEP, share)
        axes.annotate(
            label, xy=point, xytext=(1.02, height), textcoords="axes fraction",
            fontsize=LABEL_SIZE - 0.5, color=color, va="center", annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": "#777777", "linewidth": 0.6,
                        "shrinkA": 0.0, "shrinkB": 0.0},
        )  # fmt: skip
