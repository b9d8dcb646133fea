"""Plot transmissibility.png, stroke.png and srs.png: metrics of a sweep over the swept keys.

Lines
    The x-axis is the frequency, or else the key that varies fastest. Of the other keys, the one
    with most values distinguishes lines and the rest panels (`View`). Few lines differ in
    lightness and markers (legible in greyscale), many lines in colour by value. An axis is
    logarithmic if its values span a decade. Where a value is unknown the line is interrupted,
    and a marker at the lower edge of the panel shows the status. Means over seeds have
    confidence intervals.

Bands
    Random samples, and sweeps with too many cases for lines, are drawn as quantile bands along
    one key above a map of the mean over two keys. Cases are counted block by block while they
    are read (`Histogram`), so that memory does not grow with their number.

Other pictures use the views, curves and axes as well.
"""

from __future__ import annotations

import os
from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import takewhile
from math import inf, isclose, isfinite, isnan, isqrt, nan, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from drysim import wording
from drysim.core.model import Floats
from drysim.metrics.table import PEAK_STROKE
from drysim.metrics.text import format_metric_ranges, format_with_interval, label_of
from drysim.plots import metric_map, response, style
from drysim.plots.ensemble import draw_cumulative
from drysim.plots.style import (
    A_W,
    FORCE_LABEL,
    IMPACT_SPEED,
    RATIOS,
    SEAT,
    STOP_FORCE,
    SYMBOLS,
    T_A,
    T_X,
    TITLE_SIZE,
    X_DD,
    KeyLabel,
    PlottedMetric,
    Style,
    axis_label,
    column_count,
    is_lowest,
    plotted,
    set_axis,
    set_ticks,
    set_title,
    spans_decade,
)
from drysim.scenario.axes import (
    DIRECTION_KEY,
    DOWN,
    FILE_KEY,
    FREQUENCY_KEY,
    SRS_KEY,
    TEXT_KEYS,
    UP,
    Axis,
    EvenlySpaced,
    axis_groups,
    has_shock_spectrum,
    iter_points,
)
from drysim.scenario.model import LIMIT_KEYS, Scenario, shows_peak_acceleration
from drysim.scenario.sampling import Distribution, LogNormal, Normal, SampledValues
from drysim.scenario.text import short_key
from drysim.study.compare import Comparison
from drysim.study.statistics import (
    FAILED,
    MAX_CACHED_ROWS,
    NOT_SETTLED,
    NOT_UNIQUE,
    OK,
    STATUSES,
    Batch,
    Row,
    as_batches,
    median_and_ends,
    share_of_draws,
)
from drysim.study.table import (
    RATIO_KEY,
    BestCase,
    Table,
    bin_values,
    excess_of,
    is_admissible,
    log_bins,
    stroke_limits,
)
from drysim.system import relative_path
from drysim.wording import Point

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_transmissibility(table: Table, ax: Axes | None = None) -> Figure:
    """Return the figure of T_x on the left and T_a on the right, as in the paper.

    SEAT is added where the vibration is weighted, or a_w where SEAT is not known.
    """
    ends = table.tallies[table.approaches[0]].ends if table.rows else {}
    metrics = [T_X, T_A, *[metric for metric in (SEAT, A_W) if metric.name in ends][:1]]
    if needs_quantiles(table):
        return draw_quantiles(table, metrics, ax)
    view = sweep_view(table)
    drawn = [metric for metric in metrics if any(True for _ in finite_values(view, metric.of))]
    return draw_panels(table, view, drawn or [T_A], ax)


def draw_stroke(table: Table, ax: Axes | None = None) -> Figure | None:
    """Return the figure of the peak of |x_r|, the stroke limit and its violations.

    Under a shock it also shows the peak acceleration of the mass. None for a shock response
    spectrum, whose own figure shows both.
    """
    return None if has_shock_spectrum(table.axes) else _draw_peaks(table, ax)


def draw_spectra(table: Table, ax: Axes | None = None) -> Figure | None:
    """Return the figure of shock response spectra: peaks over the natural frequency.

    None for another sweep.
    """
    return _draw_peaks(table, ax) if has_shock_spectrum(table.axes) else None


def _draw_peaks(table: Table, ax: Axes | None) -> Figure:
    """Return the figure of peak stroke and, if asked for, of peak acceleration."""
    ends = table.tallies[table.approaches[0]].ends if table.rows else {}
    peak = plotted(PEAK_STROKE, ends.get(PEAK_STROKE, (0.0, 0.0))[1])
    shown = shows_peak_acceleration(table.scenario) and X_DD.name in ends
    accelerations = [X_DD] * shown
    if needs_quantiles(table):
        return draw_quantiles(table, [*accelerations, peak], ax)
    # |x_r| is nearly the same in all cases that reach an end stop.
    stops = table.scenario.law().stops
    contact = IMPACT_SPEED if stops is not None and stops.rigid else STOP_FORCE
    stop_metrics = [contact] if ends.get(contact.name, (0.0, 0.0))[1] else []
    return draw_panels(table, sweep_view(table), [*accelerations, peak, *stop_metrics], ax)


def _draw_limit(
    axes: Axes, table: Table, view: View, panel: Panel, metric: PlottedMetric
) -> None:
    """Draw the stroke limit unless it would flatten the curves; a swept one for each case.

    Of unequal limits the smaller one is drawn.
    """
    if table.scenario.stroke is None:
        return
    name = limit_name(table.scenario)
    max_level = response.MAX_LIMIT_RATIO * max(finite_values(view, metric.of), default=0.0)

    def limit(row: Row) -> float:
        return metric.scale * min(stroke_limits(table.scenario, row.point) or (0.0,))

    curves = [line_series(view, line, limit) for line in panel.lines]
    levels = [{*y} for _, y in curves]
    every = set().union(*levels)
    if len(every) == 1:
        (level,) = every
        label = f"{name} {wording.format_number(level, metric.unit)}"
        _draw_level(axes, level, max_level, response.LIMIT_STYLE, label)
    elif any(len(limits) > 1 for limits in levels):
        # The curve leaves the panel at its top instead of raising it above `max_level`.
        top = max(axes.dataLim.y1, max_level)
        axes.plot(*curves[0], **response.LIMIT_STYLE, label=name)
        axes.dataLim.y1 = min(axes.dataLim.y1, top)
    elif len(levels) <= MAX_STYLED_LINES:
        for curve_styles, limits in zip(line_styles(view), levels, strict=True):
            level_style = {**response.LIMIT_STYLE, "color": curve_styles["color"]}
            for level in limits:
                _draw_level(axes, level, max_level, level_style, f"{name} per line")


def limit_name(scenario: Scenario) -> str:
    """Return the name of the stroke limit of which pictures show only the smaller side."""
    return "smaller stroke limit" if scenario.has_sides else "stroke limit"


def _draw_level(axes: Axes, level: float, max_level: float, style: Style, label: str) -> None:
    """Draw a stroke limit that is constant along the x-axis, unless it exceeds `max_level`."""
    if level <= max_level:
        axes.axhline(level, **style, label=label)


def _mark_violations(axes: Axes, view: View, panel: Panel, metric: PlottedMetric) -> None:
    """Mark the cases that reach the stroke limit, at the largest |x_r| of all seeds.

    It counts settling, too; the curve has means over the seeds, without settling.
    """
    rows = [row for line in panel.lines for row in line.rows if row.metrics.get("violations")]
    if rows:
        x = [view.x(row) for row in rows]
        y = [metric.scale * (row.largest("stroke_suffices") or nan) for row in rows]
        worst = ", worst seed" * any(row.seeds > 1 for row in rows)
        axes.plot(x, y, **response.VIOLATION_STYLE, label=f"limit exceeded{worst}")


# Assignment of the swept keys to x-axis, lines and panels.


FORCE_KEYS = ("friction.kinetic", "friction.mu_kinetic", "friction.normal")
"""Keys drawn over the resulting kinetic friction force."""

MIN_FREQUENCIES = 5
"""Number of frequencies from which on the frequency is the x-axis, whatever varies fastest."""

MAX_PANELS, MAX_LINES = 4, 60
"""Maximum number of panels and lines; of more, an evenly spaced selection is drawn."""

MAX_FILE_LABELS, MAX_FILE_LETTERS = 20, 24
"""Swept files that are labelled, evenly spaced if there are more; characters of a label."""

FEW_FILES = 6
"""Files up to which their labels are slanted; those of more stand upright."""

MAX_COMPARED_PANELS = 3
"""Maximum number of rows of a comparison, below the row of time histories."""

Choice = TypeVar("Choice")


class Line(NamedTuple):
    """A curve."""

    label: str
    value: float
    """Value of the swept key by which lines differ."""
    rows: Sequence[Row]
    """Cases along the x-axis."""
    direction: str = ""
    """Direction of the sweep, `up` or `down`; empty if every case begins at the start."""


class Panel(NamedTuple):
    """The curves of a panel."""

    point: Point
    """Values of the swept keys by which panels differ."""
    title: str
    """These values as text; empty for a single panel."""
    lines: Sequence[Line]
    references: Sequence[Line]
    """Curves of the approach and of the reference."""


class View(NamedTuple):
    """Assignment of a table to x-axis, lines and panels."""

    key: str
    """Swept key of the x-axis; empty if nothing is swept."""
    label: KeyLabel
    """Label of the x-axis."""
    line: Axis | None
    """Swept key by which lines differ; the first of several keys that vary together."""
    panels: Sequence[Panel]
    left_out: int
    """Number of curves that are not drawn."""
    sampled: bool = False
    """Whether the cases are random samples, which lines do not connect."""
    files: Sequence[Any] = ()
    """Swept files of the x-axis, which are drawn at 0, 1, 2 and so on."""

    def x(self, row: Row) -> float:
        """Return the abscissa of a row; nan for a reference that does not depend on the key."""
        if self.key not in row.point:
            return nan
        if self.files:
            return float(self.files.index(row.point[self.key]))
        return row.F_fk if self.key in FORCE_KEYS else row.point[self.key]


def sweep_view(table: Table) -> View:
    """Return the view of a sweep: lines of its approach and of its reference."""
    x_key, label, linked_keys, others = _split_axes(table.axes)
    line_axes = max(others, key=lambda group: len(group[0].values), default=())
    line_axes = line_axes if line_axes and len(line_axes[0].values) > 1 else ()
    points = _combinations([group for group in others if group is not line_axes])
    shown = evenly_spaced(points, MAX_PANELS)
    directions = [axis for axis in table.axes if axis.key == DIRECTION_KEY]
    line_points = _combinations([group for group in (directions, line_axes) if group])
    drawn_points = evenly_spaced(line_points, MAX_LINES)
    groups = RowGroups(table.own, linked_keys)
    references = [RowGroups(table.of(name), linked_keys) for name in table.approaches[1:]]
    line, files = line_axes[0] if line_axes else None, swept_files(table.axes, x_key)
    panels = [
        _make_panel(point, drawn_points, line, groups, references, table.axes)
        for point in shown
    ]
    left_out = len(points) * len(line_points) - len(shown) * len(drawn_points)
    return View(x_key, label, line, panels, left_out, files=files)


def comparison_view(comparison: Comparison) -> View:
    """Return the view of a comparison: a line per approach, with a panel of the shown case."""
    table = comparison.table
    x_key, label, linked_keys, others = _split_axes(table.axes)
    curves = [RowGroups(table.of(name), linked_keys) for name in table.approaches]
    points = _combinations(others)
    shown_case = [
        point
        for point in points
        if all(comparison.shown.get(k, v) == v for k, v in point.items())
    ]
    shown = evenly_spaced(points, MAX_COMPARED_PANELS)
    if shown_case and shown_case[0] not in shown:
        shown = [shown_case[0], *shown[1:]]
    panels = [
        Panel(
            point,
            panel_title(point, table.axes),
            [Line(curve.name, nan, curve.rows_at(point)) for curve in curves],
            (),
        )
        for point in shown
    ]
    sampled = any(axis.is_random for axis in table.axes)
    files = swept_files(table.axes, x_key)
    return View(x_key, label, None, panels, len(points) - len(shown), sampled, files)


def file_labels(files: Sequence[str]) -> list[str]:
    """Return short labels of files: without their common folder and suffix."""
    folder = ""
    with suppress(ValueError):  # on several drives of Windows
        folder = os.path.commonpath([os.path.dirname(file) for file in files])
    names = [relative_path(file, folder) if folder else file for file in files]
    if len({os.path.splitext(name)[1] for name in names}) == 1:
        names = [os.path.splitext(name)[0] for name in names]
    if len(names) > 1 and max(map(len, names)) > MAX_FILE_LETTERS:
        # Names of measurements often differ in the middle: drop whole words shared by all.
        begin = _shared_words(names)
        end = _shared_words([name[begin:][::-1] for name in names])
        before, behind = "…" * bool(begin), "…" * bool(end)
        names = [f"{before}{name[begin : len(name) - end]}{behind}" for name in names]
    for index, name in enumerate(names):
        if len(name) > MAX_FILE_LETTERS:
            names[index] = f"…{name[1 - MAX_FILE_LETTERS :]}"
    return [wording.sanitise(name) for name in names]


def file_ticks(files: Sequence[str]) -> tuple[list[int], list[str]]:
    """Return positions and labels of files along an axis; of many, an evenly spaced part."""
    labels = file_labels(files)
    places = evenly_spaced(range(len(labels)), MAX_FILE_LABELS)
    return places, [labels[place] for place in places]


def _shared_words(names: Sequence[str]) -> int:
    """Return the number of characters of the whole words with which all names begin."""
    shared = takewhile(lambda signs: len({*signs}) == 1, zip(*names, strict=False))
    return max(
        (length for length, (sign, *_) in enumerate(shared, 1) if not sign.isalnum()), default=0
    )


def swept_files(axes: Sequence[Axis], key: str) -> Sequence[Any]:
    """Return the values of a swept key if they are files, otherwise none."""
    return next((axis.values for axis in axes if axis.key == key == FILE_KEY), ())


def _split_axes(
    axes: Sequence[Axis],
) -> tuple[str, KeyLabel, Collection[str], list[tuple[Axis, ...]]]:
    """Return the key of the x-axis, its label, the keys varied with it, and all other groups.

    Keys that are varied together form a group.
    """
    x_axis, groups = abscissa(axes), axis_groups(axes)
    if x_axis is None:
        return "", KeyLabel(""), (), groups
    linked_keys = {axis.key for group in groups if x_axis in group for axis in group}
    others = [g for g in groups if x_axis not in g and g[0].key != DIRECTION_KEY]
    is_force = x_axis.key in FORCE_KEYS
    label = KeyLabel(FORCE_LABEL) if is_force else axis_label(x_axis)
    return x_axis.key, label, linked_keys, others


def abscissa(axes: Sequence[Axis]) -> Axis | None:
    """Return the swept key of the x-axis: the frequency, or the key that varies fastest.

    The frequency is that of the base, or of a shock response spectrum.

    Files, directions and draws of a fit are the x-axis only if nothing else is swept.
    """
    several = [axis for axis in axes if len(axis.values) > 1] or list(axes)
    several.sort(key=lambda axis: (axis.key in TEXT_KEYS, axis.source is not None))
    frequency = [
        a
        for a in several
        if a.group == SRS_KEY or (a.key == FREQUENCY_KEY and len(a.values) >= MIN_FREQUENCIES)
    ]
    return next(iter(frequency + several), None)


def _combinations(groups: Iterable[Sequence[Axis]]) -> list[dict[str, Any]]:
    """Return all combinations of the values of groups of keys."""
    return [*iter_points([axis for group in groups for axis in group])]


def evenly_spaced(choices: Sequence[Choice], most: int) -> list[Choice]:
    """Return at most `most` of the choices, evenly spaced, including the first and the last."""
    if len(choices) <= most:
        return list(choices)
    return [choices[round(index * (len(choices) - 1) / (most - 1))] for index in range(most)]


class RowGroups:
    """Rows of an approach, grouped by all swept keys except those of the x-axis."""

    def __init__(self, rows: Iterable[Row], linked_keys: Collection[str]) -> None:
        self.groups: defaultdict[frozenset[tuple[str, float]], list[Row]] = defaultdict(list)
        self.keys: set[str] = set()
        self.name = ""
        for row in rows:
            rest = {key: value for key, value in row.point.items() if key not in linked_keys}
            self.keys |= rest.keys()
            self.name = row.approach
            self.groups[frozenset(rest.items())].append(row)

    def rows_at(self, point: Point) -> list[Row]:
        """Return the rows at a point; keys that are not swept in these rows are ignored."""
        values = {key: value for key, value in point.items() if key in self.keys}
        return self.groups.get(frozenset(values.items()), [])


def _make_panel(
    point: Point,
    line_points: Sequence[Point],
    line: Axis | None,
    groups: RowGroups,
    references: Sequence[RowGroups],
    axes: Sequence[Axis],
) -> Panel:
    """Return a panel with a line per line point, for the approach and each reference."""
    values = [line_point[line.key] if line else nan for line_point in line_points]
    if values and isinstance(values[0], str):
        values = [float(i) for i in range(len(values))]
    lines = [
        Line(
            point_label(line_point, axes) or groups.name,
            value,
            groups.rows_at({**point, **line_point}),
            line_point.get(DIRECTION_KEY, ""),
        )
        for value, line_point in zip(values, line_points, strict=True)
    ]
    drawn = [
        Line(curves.name, value, curves.rows_at({**point, **line_point}))
        for curves in references
        for value, line_point in zip(values, line_points, strict=True)
    ]
    return Panel(point, panel_title(point, axes), lines, drawn)


# Labels of points of the sweep.


def point_label(point: Point, axes: Sequence[Axis]) -> str:
    """Return the label of a point of the sweep, with symbols of the paper."""
    units = {axis.key: axis.unit for axis in axes}
    files = swept_files(axes, FILE_KEY)
    labels = dict(zip(files, file_labels(files), strict=True)) if FILE_KEY in point else {}
    return ", ".join(
        f"{SYMBOLS.get(key, short_key(key, units))} "
        f"{labels.get(value) or wording.sanitise(wording.format_quantity(value, units[key]))}"
        for key, value in point.items()
    )


def panel_title(point: Point, axes: Sequence[Axis]) -> str:
    """Return the title of a panel: the values of the keys by which panels differ."""
    several = {axis.key for axis in axes if len(axis.values) > 1}
    return point_label({key: value for key, value in point.items() if key in several}, axes)


# Panels of a sweep: a row per panel of the view, a column per metric.


RowValue = Callable[[Row], float | None]

MAX_STYLED_LINES = 8
"""Number of lines up to which each has its own style; more are coloured by value."""

MAX_MARKED_POINTS, MARKER_SPACING = 20, 0.12
"""Number of points up to which each has a marker; spacing of markers on other lines [panel
diagonals]."""

COLORMAP_END = 0.82
"""Upper end of the colour map; lighter colours are illegible on white [-]."""

MARKERS = "os^DvPX*"
DASHES: dict[str, Style] = {DOWN: {"linestyle": (0, (3, 1.5))}}
DIRECTION_STYLES: dict[str, Style] = {
    UP: {"marker": "^"},
    DOWN: {"marker": "v", "fillstyle": "none", **DASHES[DOWN]},
}
"""Styles of sweeps up and down: solid and dashed, with markers that point in the direction."""
REFERENCE_STYLE: Style = {"color": "black", "linewidth": 1.3, "linestyle": (0, (4, 2))}
FAINT_REFERENCE_STYLE: Style = {"color": "#6b6b6b", "linewidth": 0.9, "linestyle": (0, (4, 2))}
FILE_REFERENCE_STYLE: Style = {"linestyle": "none", "marker": "_", "markersize": 10}
UNITY_STYLE: Style = {"color": "#404040", "linewidth": 0.8, "zorder": 1}
GAP_STYLES: dict[str, Style] = {
    NOT_SETTLED: {"marker": "x", "color": "black"},
    NOT_UNIQUE: {"marker": "o", "color": "black", "fillstyle": "none"},
    FAILED: {"marker": "P", "color": "#b3261e"},
}
OTHER_GAP_STYLE: Style = {"marker": "1", "color": "black"}
INTERVAL_STYLE: Style = {
    "alpha": 0.3, "linewidth": 0.0, "zorder": 1.5,
    "label": "95 % confidence interval of the mean",
}  # fmt: skip

MIN_SHOWN_INTERVAL = 0.005
"""Half-width of an interval, as a share of the largest value, from which on it is seen."""

ADMISSIBLE_STYLE: Style = {
    "color": "#e4efe2", "linewidth": 0.0, "zorder": 0, "label": "admissible",
}  # fmt: skip
BEST_STYLE: Style = {
    "marker": "*", "markersize": 13, "color": "#f2b705", "markeredgecolor": "black",
    "markeredgewidth": 0.8, "linestyle": "none", "zorder": 7, "clip_on": False,
}  # fmt: skip

JUMP_STYLE: Style = {
    "color": "#b3261e", "linewidth": 0.9, "linestyle": (0, (1, 1.5)), "zorder": 1,
}  # fmt: skip

MAX_ROW_TITLE = 0.35
"""Part of the width of a column of panels up to which the title of the row stands in each."""

MAX_NAMED_METRICS = 2
"""Columns of panels up to which the title of each has the name of its metric."""

LOG_SCALE_RATIO = 100.0
"""Ratio of largest to smallest T_a from which on its axis is logarithmic [-]."""

NATURAL_FREQUENCY_KEYS = {
    "oscillator.mass",
    "oscillator.stiffness",
    "oscillator.natural_frequency",
}
"""Keys that change the natural frequency."""


def draw_panels(
    table: Table, view: View, metrics: Sequence[PlottedMetric], ax: Axes | None = None
) -> Figure:
    """Return the figure of a sweep: a row per panel of the view, and a column per metric."""
    count = len(view.panels)
    coloured = view.line is not None and len(view.panels[0].lines) > MAX_STYLED_LINES
    figure, grid = style.panel_grid(count, len(metrics), ax=ax)
    for place, metric in enumerate(metrics):
        first = None
        for row, panel in enumerate(view.panels):
            # All rows share a y-axis, so that they can be compared.
            axes = first = ax or figure.add_subplot(grid[row, place], sharey=first)
            name = metric.full_title if len(metrics) <= MAX_NAMED_METRICS else metric.symbol
            title = metric.symbol if panel.title else name
            set_row_title(axes, panel.title, title, pad=15)
            set_x_axis(axes, view, is_labelled=ax is not None or is_lowest(axes))
            draw_curves(axes, view, panel, metric)
            if metric in RATIOS:
                axes.axhline(1.0, **UNITY_STYLE)
            elif metric.name == PEAK_STROKE:
                _draw_limit(axes, table, view, panel, metric)
                _mark_violations(axes, view, panel, metric)
            mark_gaps(axes, view, panel)
            _mark_admissible(axes, table, view, panel, metric)
            _mark_natural_frequency(axes, table, view)
            for jump in (table.jumps or ()) if view.key == RATIO_KEY else ():
                axes.axvline(jump.value, **JUMP_STYLE, label="jump")
        assert first is not None, "a view has a panel"
        values = list(finite_values(view, metric.of))
        if not values:
            first.text(0.5, 0.5, "not known", transform=first.transAxes, ha="center")
        _set_y_limits(first, values, allow_log=metric is T_A)
    panels = figure.axes if ax is None else [ax]
    entries = style.legend_entries(panels)
    if coloured:
        for line in view.panels[0].lines:
            entries.pop(line.label, None)
        _draw_colorbar(panels, view)
    heading = style.table_heading(table, view.left_out, of_stroke=_shows_stroke(metrics))
    style.finish_figure(figure, heading, entries, ax)
    return figure


def _mark_admissible(
    axes: Axes, table: Table, view: View, panel: Panel, metric: PlottedMetric
) -> None:
    """Mark the best admissible cases, and shade the admissible range of a single line."""
    if not table.answers:
        return
    rows = [row for line in panel.lines for row in line.rows]
    if len(panel.lines) == 1 and rows and not view.files:
        rows.sort(key=view.x)
        x = [view.x(row) for row in rows]
        for i, j in response.runs(is_admissible(Batch.of(0, rows), table.scenario.checks)):
            if x[i] < x[j - 1]:
                axes.axvspan(x[i], x[j - 1], **ADMISSIBLE_STYLE)
    for _, best in table.answers:
        if best.row and any(row.point == best.row.point for row in rows):
            _draw_best(axes, best, table, view.x(best.row), metric.of(best.row))


def _draw_best(axes: Axes, best: BestCase, table: Table, x: float, y: float | None) -> None:
    """Draw the best admissible case, or the best over all records, with its legend."""
    if best.row is None or y is None:
        return
    whose = "best case" if best.kind == "case" else "best for all records"
    place = point_label(best.row.point, table.axes)
    label = f"{whose}: least {wording.typeset(best.result)} at {place}"
    fill: Style = {"fillstyle": "none"} if best.kind == "design" else {}
    axes.plot([x], [y], **BEST_STYLE, **fill, label=label)


def _shows_stroke(metrics: Sequence[PlottedMetric]) -> bool:
    return any(metric.name == PEAK_STROKE for metric in metrics)


def _set_y_limits(axes: Axes, values: Sequence[float], allow_log: bool) -> None:
    """Start the y-axis at 0, or make it logarithmic for a large range if `allow_log`."""
    if allow_log and values and 0 < LOG_SCALE_RATIO * min(values) <= max(values):
        axes.set_yscale("log")
        set_ticks(axes.yaxis)
    else:
        panels = axes.get_shared_y_axes().get_siblings(axes)
        flat = not any(panel.dataLim.y1 > 0.0 for panel in panels)
        axes.set_ylim(0.0, 1.0 if flat else None)


def _mark_natural_frequency(axes: Axes, table: Table, view: View) -> None:
    """Mark the natural frequency f_0 and sqrt(2) f_0, above which a viscous isolator isolates.

    Only if all cases have the same natural frequency.
    """
    varied = {axis.key for axis in table.axes if len(axis.values) > 1}
    if view.key != FREQUENCY_KEY or varied & NATURAL_FREQUENCY_KEYS:
        return
    f_0 = 1.0 / response.natural_period(table.scenario.oscillator.plant())
    low, high = axes.get_xlim()
    for symbol, f, side in (("f₀", f_0, "right"), ("√2 f₀", sqrt(2) * f_0, "left")):
        if low < f < high:
            axes.axvline(f, **NATURAL_FREQUENCY_STYLE)
            foot = axes.get_xaxis_transform()
            axes.text(f, 1.01, symbol, transform=foot, size=8, ha=side)


def _draw_colorbar(panels: Sequence[Axes], view: View) -> None:
    """Draw the colour bar of many lines beside all panels."""
    from matplotlib.cm import ScalarMappable

    assert view.line is not None
    mappable = ScalarMappable(*color_scale(view.line))
    bar = panels[0].figure.colorbar(mappable, ax=panels, aspect=25, pad=0.02)
    label = axis_label(view.line)
    bar.set_label(label.text)
    if view.line.key == FILE_KEY:
        places, labels = file_ticks(view.line.values)
        bar.set_ticks(places, labels=labels)
        bar.ax.tick_params(labelsize=8)
    else:
        set_colorbar_ticks(bar, label.factor)


def set_colorbar_ticks(bar: Any, factor: float = 1.0) -> None:
    """Label a colour bar at round values; the labels are these times a factor."""
    from matplotlib.ticker import MaxNLocator

    bar.ax.yaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10]))
    set_ticks(bar.ax.yaxis, factor)


def line_styles(view: View) -> list[Style]:
    """Return the style of every line of a panel.

    Lines differ in lightness, few lines also in their markers, sweeps up and down in dashes and
    in markers that point up or down.
    """
    import matplotlib

    colormap = matplotlib.colormaps["viridis"]
    lines = view.panels[0].lines
    if len(lines) > MAX_STYLED_LINES and view.line is not None:
        norm, many = color_scale(view.line)
        return [
            {
                "color": many(norm(line.value)),
                "linewidth": 1.0,
                **DASHES.get(line.direction, {}),
            }
            for line in lines
        ]
    values = [*dict.fromkeys(line.value for line in lines)]
    styles = []
    for line in lines:
        index = 0 if view.line is None else values.index(line.value)
        style: Style = {"color": "#0b3c6f", "linewidth": 1.6, "marker": "o", "markersize": 3.5}
        if view.line is not None:
            color = colormap(COLORMAP_END * index / max(len(values) - 1, 1))
            style = {
                "color": color,
                "linewidth": 1.5,
                "marker": MARKERS[index],
                "markersize": 4,
            }
        if view.files and view.line is None:
            style["linestyle"] = "none"
        styles.append(style | DIRECTION_STYLES.get(line.direction, {}))
    return styles


def color_scale(axis: Axis) -> tuple[Any, Any]:
    """Return normalisation and colour map of the values of a swept key."""
    import matplotlib
    from matplotlib.colors import ListedColormap, LogNorm, Normalize

    values = range(len(axis.values)) if axis.key == FILE_KEY else axis.values
    low, high = min(values), max(values)
    dark = matplotlib.colormaps["viridis"]([COLORMAP_END * level / 255 for level in range(256)])
    return (LogNorm if spans_decade(values) else Normalize)(low, high), ListedColormap(dark)


def draw_curves(axes: Axes, view: View, panel: Panel, metric: PlottedMetric) -> None:
    """Draw the lines of a panel, interrupted where the value is unknown.

    Few lines of means over seeds also have confidence intervals.
    """
    curve_styles = line_styles(view)
    series = [line_series(view, line, metric.of) for line in panel.lines]
    for number, (line, curve_style, (x, y)) in enumerate(
        zip(panel.lines, curve_styles, series, strict=True)
    ):
        draw_curve(axes, x, y, curve_style, line.label, number)
    draw_references(axes, view, panel, metric.of, curve_styles)
    if len(panel.lines) <= MAX_STYLED_LINES:
        for line, curve_style, (x, y) in zip(panel.lines, curve_styles, series, strict=True):
            draw_interval(
                axes, x, y, line_series(view, line, metric.half_width)[1], curve_style
            )


def draw_curve(
    axes: Axes,
    x: Sequence[float],
    y: Sequence[float],
    style: Style,
    label: str,
    number: int = 0,
) -> None:
    """Draw a line; a horizontal one if x is nan.

    Markers of neighbouring lines (`number`) are staggered.
    """
    if x and isnan(x[0]):
        axes.axhline(y[0], **{**style, "marker": ""}, label=label)
        return
    few = sum(map(isfinite, y)) <= MAX_MARKED_POINTS or style.get("linestyle") == "none"
    every = 1 if few else (0.03 * number, MARKER_SPACING)
    axes.plot(x, y, **style, markevery=every, label=label, clip_on=False)
    if alone := [i for i in range(len(y)) if _is_isolated(y, i)]:
        points = [x[i] for i in alone], [y[i] for i in alone]
        axes.plot(*points, "o", markersize=3, color=style["color"], clip_on=False)


def _is_isolated(y: Sequence[float], index: int) -> bool:
    """Whether a point has gaps on both sides, so that a line without markers hides it."""
    beside = [y[i] for i in (index - 1, index + 1) if 0 <= i < len(y)]
    return isfinite(y[index]) and not any(map(isfinite, beside))


def draw_references(
    axes: Axes, view: View, panel: Panel, value: RowValue, curve_styles: Sequence[Style]
) -> None:
    """Draw the reference dashed; only once if it is the same for all lines."""
    drawn = [(line, *line_series(view, line, value)) for line in panel.references]
    alike = all(_is_same_curve(y, drawn[0][2]) for _, _, y in drawn)
    if not drawn or (not alike and len(panel.lines) > MAX_STYLED_LINES):
        return
    label = f"{panel.references[0].label}, no dry friction"
    if alike:
        style = REFERENCE_STYLE | (FILE_REFERENCE_STYLE if view.files else {})
        draw_curve(axes, *drawn[0][1:], style, label)
        return
    # One grey legend entry represents the dashed lines of all colours.
    axes.plot([], [], **FAINT_REFERENCE_STYLE, label=label)
    for number, (_, x, y) in enumerate(drawn):
        draw_curve(
            axes,
            x,
            y,
            {
                **FAINT_REFERENCE_STYLE,
                "color": curve_styles[number % len(curve_styles)]["color"],
            },
            "_",
        )


def _is_same_curve(first: Sequence[float], second: Sequence[float]) -> bool:
    """Whether two curves are visually identical."""
    return len(first) == len(second) and all(
        isclose(a, b, rel_tol=1e-6) or a != a or b != b
        for a, b in zip(first, second, strict=True)
    )


def draw_interval(
    axes: Axes, x: Sequence[float], y: Sequence[float], width: Sequence[float], style: Style
) -> None:
    """Draw the confidence intervals of means around a curve, if known."""
    middle, half = np.array(y), np.array(width)
    if np.isfinite(half).any():
        edges = middle - half, middle + half
        drawn = axes.fill_between(x, *edges, color=style["color"], **INTERVAL_STYLE)
        if np.nanmax(half) < MIN_SHOWN_INTERVAL * np.nanmax(abs(middle)):
            drawn.set_label("_")  # thinner than the line


def line_series(view: View, line: Line, value: RowValue) -> tuple[list[float], list[float]]:
    """Return x and y of a line in ascending order of x; nan marks a gap."""
    points = [(view.x(row), value(row)) for row in line.rows]
    points.sort(key=lambda pair: -inf if isnan(pair[0]) else pair[0])
    values = [y for _, y in points]
    return [x for x, _ in points], [
        nan if y is None or not isfinite(y) else float(y) for y in values
    ]


def finite_values(view: View, value: RowValue) -> Iterator[float]:
    """Yield all finite values on the lines of a view."""
    for panel in view.panels:
        for line in panel.lines:
            for row in line.rows:
                if (number := value(row)) is not None and isfinite(number):
                    yield number


def mark_gaps(axes: Axes, view: View, panel: Panel) -> None:
    """Mark cases without a value at the lower edge of a panel, by status."""
    missing = [row for line in panel.lines for row in line.rows if row.status != OK]
    for status, count in Counter(row.status for row in missing).items():
        x = [view.x(row) for row in missing if row.status == status]
        axes.plot(
            x,
            [0.025] * count,
            transform=axes.get_xaxis_transform(),
            linestyle="none",
            markersize=5,
            clip_on=False,
            label=status,
            **GAP_STYLES.get(status, OTHER_GAP_STYLE),
        )


def set_row_title(axes: Axes, row: str, title: str, pad: float = 6.0) -> None:
    """Set the title of a panel in a row of panels with a common title.

    It begins with that of the row; a long one is a line of its own above the first panel.
    """
    place: Any = axes.get_subplotspec()
    room = MAX_ROW_TITLE * style.HEADING_WIDTH / column_count(axes)
    if style.text_width(row, size=TITLE_SIZE) <= room:
        title = f"{row}: {title}".removeprefix(": ")
    elif place.is_first_col():
        row = style.fit_line(row, style.HEADING_WIDTH, size=TITLE_SIZE)
        title = f"{row}\n{title}"
    set_title(axes, title, pad)


NATURAL_FREQUENCY_STYLE: Style = {
    "color": "#909090", "linewidth": 0.8, "linestyle": (0, (1, 2)), "zorder": 1
}  # fmt: skip


def set_x_axis(axes: Axes, view: View, is_labelled: bool) -> None:
    """Set scale, limits and label of the x-axis; logarithmic from a decade on."""
    if view.files:
        places, labels = file_ticks(view.files)
        tilt = {"rotation": 30, "ha": "right"} if len(labels) <= FEW_FILES else {"rotation": 90}
        axes.set_xlim(-0.5, len(view.files) - 0.5)
        axes.set_xticks(places, labels, size=8, **tilt)
        axes.tick_params(labelbottom=is_labelled)
        return
    rows = [row for panel in view.panels for line in panel.lines for row in line.rows]
    x = [value for row in rows if not isnan(value := view.x(row))] or [0.0, 1.0]
    low, high = min(x), max(x)
    margin = 0.0 if low < high else 0.5 * abs(low) or 1.0
    label = view.label if is_labelled else KeyLabel("")
    set_axis(axes, "x", label, low - margin, high + margin, spans_decade(x))


# Many cases: quantile bands along a swept key and a map of the mean.


QUANTILE_BANDS = (
    (0.05, 0.95, "#c9d8e8", "90 % of the cases"),
    (0.25, 0.75, "#8fb0d0", "50 % of the cases"),
)
MEDIAN_STYLE: Style = {"color": "#0b3c6f", "linewidth": 1.6, "label": "median"}


def needs_quantiles(table: Table) -> bool:
    """Whether a table is drawn as quantile bands: random samples, or too many for lines."""
    x_axis = abscissa(table.axes)
    if x_axis is None or x_axis.key in TEXT_KEYS:
        return False
    return len(table.rows) > MAX_CACHED_ROWS or any(axis.is_random for axis in table.axes)


def draw_quantiles(
    table: Table, metrics: Sequence[PlottedMetric], ax: Axes | None = None
) -> Figure:
    """Return the figure of metrics as quantile bands, a column each.

    Below each is a map if several keys are swept. Draws of a fit alone are a distribution.
    """
    if table.is_of_draws:
        return draw_distributions(table, metrics, ax)
    x_axis = abscissa(table.axes)
    assert x_axis is not None, "a sweep has a key"
    others = [
        axis
        for axis in table.axes
        if axis is not x_axis
        and axis.key not in TEXT_KEYS
        and axis.source is None
        and len(axis.values) > 1
    ]
    y_axis = max(others, key=lambda axis: len(axis.values), default=None)
    bins, across = Bins.of(x_axis), None if y_axis is None else Bins.of(y_axis)
    approach, *references = table.approaches
    histograms = [Histogram(metric.name, bins, across) for metric in metrics]
    count_cases(as_batches(table.rows), approach, histograms)
    reference_histograms = [Histogram(metric.name, bins, None) for metric in metrics]
    if references:
        count_cases(as_batches(table.rows), references[0], reference_histograms)
    shown = [i for i, histogram in enumerate(histograms) if histogram.counts.any()] or [
        len(histograms) - 1
    ]
    figure, grid = style.panel_grid(1 if across is None else 2, len(shown), ax=ax)
    for place, i in enumerate(shown):
        metric = metrics[i]
        axes = ax or figure.add_subplot(grid[0, place])
        title = metric.full_title if len(shown) <= MAX_NAMED_METRICS else metric.symbol
        set_title(axes, title)
        draw_quantile_bands(
            axes, histograms[i], reference_histograms[i] if references else None, metric.scale
        )
        draw_reference_level(axes, table, metric)
        set_bin_axis(axes, "x", bins, is_labelled=across is None)
        if across is not None:
            below = figure.add_subplot(grid[1, place])
            set_title(below, f"mean of {title}")
            draw_mean(figure, below, histograms[i], metric.scale)
            for _, best in table.answers:
                if y_axis is not None and (row := best.row):
                    x, y = row.point[x_axis.key], row.point[y_axis.key]
                    _draw_best(below, best, table, x, y)
    heading = style.table_heading(table, of_stroke=_shows_stroke(metrics))
    style.finish_figure(figure, heading, ax=ax)
    return figure


DRAWS_STYLE: Style = {"facecolor": "#c9d8e8", "edgecolor": "none", "zorder": 1}
DRAWS_LEVELS = (0.025, 0.25, 0.5, 0.75, 0.975)
"""Levels at which the distribution over the draws of a fit has ticks [-]."""


def draw_distributions(
    table: Table, metrics: Sequence[PlottedMetric], ax: Axes | None = None
) -> Figure:
    """Return the figure of the distributions of metrics over the draws of a fit."""
    values = {metric: table.values_of(metric.name) for metric in metrics}
    shown = [metric for metric in metrics if len(values[metric])] or [*metrics[-1:]]
    figure, grid = style.panel_grid(1, len(shown), ax=ax)
    results = []
    for place, metric in enumerate(shown):
        axes = ax or figure.add_subplot(grid[0, place])
        set_title(axes, metric.full_title if len(shown) <= MAX_NAMED_METRICS else metric.symbol)
        if not len(drawn := values[metric]):
            continue
        median, low, high = median_and_ends(drawn)
        value, interval = format_with_interval(metric.name, median, low, high)
        share = share_of_draws(len(drawn))
        results.append(f"{label_of(metric.name)} {value} ({share}: {interval})")
        label = f"{share} of the draws" if share.endswith("%") else share
        axes.axvspan(metric.scale * low, metric.scale * high, **DRAWS_STYLE, label=label)
        axes.axvline(metric.scale * median, **MEDIAN_STYLE)
        draw_cumulative(axes, metric.scale * drawn, DRAWS_LEVELS)
        axes.set_ylabel("share of the draws [%]" if place == 0 else "")
        draw_near_limit(axes, table, metric)
        set_ticks(axes.xaxis)
    of_stroke = _shows_stroke(metrics)
    heading = style.table_heading(table, of_stroke=of_stroke, results=", ".join(results))
    style.finish_figure(figure, heading, ax=ax)
    return figure


def draw_near_limit(axes: Axes, table: Table, metric: PlottedMetric) -> None:
    """Draw the stroke limit across a distribution that reaches it."""
    stroke, (low, high) = table.scenario.stroke, axes.get_xlim()
    if metric.name != PEAK_STROKE or not stroke:
        return
    limit = min(stroke.limits) * metric.scale
    if low <= limit <= high:
        label = f"{limit_name(table.scenario)} {wording.format_number(limit, metric.unit)}"
        axes.axvline(limit, **response.LIMIT_STYLE, label=label)


def draw_quantile_bands(
    axes: Axes, histogram: Histogram, reference: Histogram | None, factor: float
) -> None:
    """Draw quantile bands and median of a metric, and the median of the reference."""
    x = histogram.along.x
    for low, high, colour, label in QUANTILE_BANDS:
        ends = histogram.quantile_curve(low) * factor, histogram.quantile_curve(high) * factor
        axes.fill_between(x, *ends, color=colour, linewidth=0, label=label)
    axes.plot(x, histogram.quantile_curve(0.5) * factor, **MEDIAN_STYLE)
    if reference is not None and reference.counts.any():
        label = "median without dry friction"
        axes.plot(x, reference.quantile_curve(0.5) * factor, **REFERENCE_STYLE, label=label)


def draw_reference_level(axes: Axes, table: Table, metric: PlottedMetric) -> None:
    """Draw the stroke limit shared by all cases, or the transmissibility 1."""
    stroke = table.scenario.stroke
    axes.set_ylim(bottom=0.0)
    if metric in RATIOS:
        axes.axhline(1.0, **UNITY_STYLE)
    elif metric.name != PEAK_STROKE or any(axis.key in LIMIT_KEYS for axis in table.axes):
        return
    elif stroke and min(stroke.limits) * metric.scale <= 2.0 * axes.get_ylim()[1]:
        limit = min(stroke.limits) * metric.scale
        label = f"{limit_name(table.scenario)} {wording.format_number(limit, metric.unit)}"
        axes.axhline(limit, **response.LIMIT_STYLE, label=label)
        axes.set_ylim(top=max(axes.get_ylim()[1], 1.05 * limit))


def set_bin_axis(axes: Axes, which: str, bins: Bins, is_labelled: bool = True) -> None:
    """Set scale, limits and label of an axis over bins."""
    label = axis_label(bins.axis) if is_labelled else KeyLabel("")
    set_axis(axes, which, label, bins.edges[0], bins.edges[-1], bins.is_log)


def draw_mean(figure: Figure, axes: Axes, histogram: Histogram, factor: float) -> None:
    """Draw the mean of a metric over two swept keys, with a colour bar."""
    along, across = histogram.along, histogram.across
    assert across is not None, "a map has two axes"
    values = histogram.map * factor
    nowhere = np.zeros(values.shape, dtype=bool)
    mesh = metric_map.draw_cells(axes, along.edges, across.edges, values, nowhere)
    set_bin_axis(axes, "x", along)
    set_bin_axis(axes, "y", across)
    bar = figure.colorbar(
        mesh, cax=axes.inset_axes((1.015, 0.0, 0.025 * column_count(axes), 1.0))
    )
    set_colorbar_ticks(bar)


# Two swept keys on a grid: a map of one metric, with its limit and the best case.


MIN_MAP_VALUES = 5
"""Values of each key from which a map shows more than lines do."""

MIN_SMOOTH_VALUES = 12
"""Least number of values of each key from which on a map is interpolated."""


def draw_map(table: Table, ax: Axes | None = None) -> Figure | None:
    """Return the figure of a metric over two swept keys; None for another sweep.

    The metric is that by which the best case is chosen, or else that of the first check.
    """
    keys = map_keys(table)
    if keys is None or (metric := map_metric(table)) is None:
        return None
    along, across = keys
    x, y = (np.unique(np.array(axis.values, dtype=float)) for axis in keys)
    values, excess = (np.full((len(y), len(x)), missing) for missing in (nan, inf))
    approach = table.approaches[0]
    for batch in as_batches(table.rows):
        if batch.approach == approach:
            place = (
                np.searchsorted(y, batch.points[across.key]),
                np.searchsorted(x, batch.points[along.key]),
            )
            is_ok = batch.status == STATUSES.index(OK)
            values[place] = np.where(is_ok, metric.scale * batch.metrics[metric.name], nan)
            excess[place] = excess_of(batch, table.scenario.checks).max(axis=0)
    figure, grid = style.panel_grid(1, 1, metric_map.HEIGHT, ax)
    axes = ax or figure.add_subplot(grid[0, 0])
    is_log = [axis.range.is_log or spans_decade(axis.values) for axis in keys]
    edges = edges_between(x, is_log[0]), edges_between(y, is_log[1])
    is_known = np.isfinite(values).all()
    has_edge = np.isfinite(excess).all() or np.isneginf(excess).all()
    is_smooth = min(values.shape) >= MIN_SMOOTH_VALUES and is_known and has_edge
    ends = (x, y) if is_smooth else edges
    for which, axis, end, log in zip("xy", keys, ends, is_log, strict=True):
        set_axis(axes, which, axis_label(axis), end[0], end[-1], log)
    if is_smooth:
        drawn = metric_map.draw_levels(axes, x, y, values, excess)
    else:
        drawn = metric_map.draw_cells(axes, *edges, values, excess > 0.0)
    metric_map.add_bar(axes, drawn, metric.symbol)
    for _, best in table.answers:
        if best.row:
            _draw_best(axes, best, table, *(best.row.point[axis.key] for axis in keys))
    checks, ranges = table.scenario.checks, format_metric_ranges(table.tallies[approach].ends)
    results = f"checks {', '.join(map(str, checks))}; {ranges}" if checks else ranges
    heading = style.table_heading(table, of_stroke=True, results=results)
    style.finish_figure(figure, heading, ax=ax)
    return figure


def map_keys(table: Table) -> tuple[Axis, Axis] | None:
    """Return the two keys of a grid of numbers that are drawn as a map, or None.

    Quantiles have maps of their own.
    """
    several = [axis for axis in table.axes if len(axis.values) > 1]
    if len(several) != 2 or table.jumps is not None or needs_quantiles(table):
        return None
    if any(
        axis.group or axis.key in TEXT_KEYS or len(axis.values) < MIN_MAP_VALUES
        for axis in several
    ):
        return None
    several.sort(key=lambda axis: axis is not abscissa(table.axes))
    return several[0], several[1]


def map_metric(table: Table) -> PlottedMetric | None:
    """Return the metric of a map: what is best, or what is checked, or T_a, or the stroke."""
    tally = table.own_tally
    if tally is None:
        return None
    asked = [table.best.objective] if table.best else []
    asked += [check.metric for check in table.scenario.checks]
    names = (name for name in (*asked, "T_a", PEAK_STROKE) if name in tally.ends)
    name = next(names, None)
    return None if name is None else plotted(name, tally.ends[name][1])


# Histograms of a metric along a swept key, updated block by block.


MAX_SINGLE_VALUES, MIN_BINS, MAX_BINS = 120, 6, 48
"""Values of a key up to which each has a bin of its own; minimum and maximum number of bins of
other keys."""

CASES_PER_CELL = 4
"""Average number of random samples per cell of a map, so that few cells are empty."""

COUNTED_RANGE = np.array([1e-9, 1e6])
"""Range of a metric in a histogram; values outside count in the first or last bin."""

FIRST_BIN, LAST_BIN = log_bins(COUNTED_RANGE).tolist()

TAIL_SHARE = 1e-3
"""Tail probability of an unbounded distribution at the end of its axis [-]."""


def count_cases(
    batches: Iterable[Batch], approach: str, histograms: Sequence[Histogram]
) -> None:
    """Add the cases of an approach to histograms."""
    for batch in batches:
        if batch.approach == approach:
            for histogram in histograms:
                histogram.add(batch)


@dataclass
class Histogram:
    """Histogram of a metric in every bin of a key, and its mean over two keys."""

    metric: str
    along: Bins
    across: Bins | None
    """Bins of the x-axis, and of the y-axis of the map (None without a map)."""
    counts: NDArray[np.int64] = field(init=False)
    """Number of cases per bin and value; the values are spaced logarithmically, shape
    (len(along), n)."""
    sums: Floats = field(init=False)
    cell_counts: NDArray[np.int64] = field(init=False)
    """Sum of the metric and number of cases in every cell of the map, shape (len(along) *
    len(across),)."""

    def __post_init__(self) -> None:
        """Allocate empty counts."""
        self.counts = np.zeros((len(self.along), LAST_BIN - FIRST_BIN + 2), dtype=np.int64)
        size = len(self.along) * (len(self.across) if self.across else 0)
        self.sums, self.cell_counts = np.zeros(size), np.zeros(size, dtype=np.int64)

    def add(self, batch: Batch) -> None:
        """Count the cases of a block in which the metric is known."""
        values = batch.metrics[self.metric]
        has_value = values == values
        x = batch.points.get(self.along.axis.key)
        if x is None or not has_value.any():
            return
        values, index = values[has_value], self.along.find(x[has_value])
        bins = log_bins(np.clip(values, *COUNTED_RANGE)) - FIRST_BIN + 1
        np.add.at(self.counts, (index, np.where(values < COUNTED_RANGE[0], 0, bins)), 1)
        y = batch.points.get(self.across.axis.key) if self.across else None
        if self.across is not None and y is not None:
            cell = index * len(self.across) + self.across.find(y[has_value])
            self.sums += np.bincount(cell, values, minlength=len(self.sums))
            self.cell_counts += np.bincount(cell, minlength=len(self.cell_counts))

    def quantile(self, level: float) -> Floats:
        """Return a quantile of the metric in every bin; NaN in bins without cases."""
        below = np.cumsum(self.counts, axis=1)
        total = below[:, -1]
        index = np.argmax(below >= level * np.maximum(total, 1)[:, None], axis=1)
        values = np.where(index == 0, 0.0, bin_values(index - 1 + FIRST_BIN))
        return np.where(total > 0, values, np.nan)

    def quantile_curve(self, level: float) -> Floats:
        """Return a quantile at the points `Bins.x`; the outermost bins extend to the ends."""
        return np.pad(self.quantile(level), self.along.end_points, mode="edge")

    @property
    def map(self) -> Floats:
        """Mean of the metric, shape (bins across, bins along); NaN in cells without cases."""
        assert self.across is not None, "a map has two axes"
        with np.errstate(invalid="ignore", divide="ignore"):
            means = self.sums / self.cell_counts
        return np.asarray(means.reshape(len(self.along), len(self.across)).T)


@dataclass(frozen=True)
class Bins:
    """A swept key as bins."""

    axis: Axis
    centers: Floats
    edges: Floats
    """Centres and edges of the bins, shape (n,) and (n + 1,)."""
    x: Floats
    """Points of curves: the centres, and for a range also its two ends."""
    is_log: bool
    """Whether the axis is logarithmic."""

    @classmethod
    def of(cls, axis: Axis) -> Bins:
        """Return a bin for each of few values, else bins of equal width or equal ratio."""
        values = axis.values
        most = min(MAX_BINS, max(MIN_BINS, isqrt(len(values) // CASES_PER_CELL)))
        if isinstance(values, SampledValues):
            ends = _distribution_range(values.law)
            edges, is_log = _bin_edges(*ends, most, _suits_log_axis(values.law))
        elif axis.source is not None:
            edges, is_log = _bin_edges(min(values), max(values), most)
        else:
            ordered = values if isinstance(values, EvenlySpaced) else sorted({*values})
            if len(ordered) <= MAX_SINGLE_VALUES:
                centers, is_log = np.array(ordered, dtype=float), spans_decade(ordered)
                return cls(axis, centers, edges_between(centers, is_log), centers, is_log)
            edges, is_log = _bin_edges(ordered[0], ordered[-1], MAX_BINS)
            edges = _drop_empty_bins(edges, ordered)
        centers = np.sqrt(edges[1:] * edges[:-1]) if is_log else (edges[1:] + edges[:-1]) / 2
        return cls(axis, centers, edges, np.array([edges[0], *centers, edges[-1]]), is_log)

    def __len__(self) -> int:
        """Return the number of bins."""
        return len(self.centers)

    @property
    def end_points(self) -> int:
        """Number of points of a curve outside the bin centres, at each end."""
        return (len(self.x) - len(self)) // 2

    def find(self, values: Floats) -> NDArray[np.intp]:
        """Return the index of the bin of every value."""
        return np.searchsorted(self.edges[1:-1], values, side="right")


def edges_between(centers: Floats, is_log: bool) -> Floats:
    """Return edges halfway between values on their axis, with outer bins symmetric."""
    if len(centers) == 1:
        return np.array([centers[0] - 0.5, centers[0] + 0.5])
    x = np.log(centers) if is_log else centers
    between = 0.5 * (x[1:] + x[:-1])
    edges = np.array([2 * x[0] - between[0], *between, 2 * x[-1] - between[-1]])
    return np.asarray(np.exp(edges) if is_log else edges)


def _bin_edges(
    low: float, high: float, count: int, allow_log: bool = True
) -> tuple[Floats, bool]:
    """Return edges of bins between two ends, and whether they are spaced logarithmically."""
    is_log = allow_log and spans_decade((low, high))
    return (np.geomspace if is_log else np.linspace)(low, high, count + 1), is_log


def _drop_empty_bins(edges: Floats, ordered: Sequence[float]) -> Floats:
    """Merge bins without a value; spaced values may be wider apart than bins."""
    below = [bisect_left(ordered, edge) for edge in edges[1:-1].tolist()]
    _, first = np.unique([0, *below, len(ordered)], return_index=True)
    return np.append(edges[first[:-1]], edges[-1])


def _distribution_range(law: Distribution) -> tuple[float, float]:
    """Return the ends of a distribution; of an unbounded one extreme quantiles."""
    share = TAIL_SHARE if isinstance(law, Normal | LogNormal) else 0.0
    low, high = law.quantile(np.array([share, 1.0 - share])).tolist()
    return low, high


def _suits_log_axis(law: Distribution) -> bool:
    """Whether a logarithmic axis suits a distribution."""
    return isinstance(law, LogNormal) or getattr(law, "log", False)
