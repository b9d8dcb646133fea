"""Canvas, layout, axes, heading and legend of all pictures.

Pictures are `matplotlib.figure.Figure` objects without pyplot, which would share state. A
picture has a heading (title, scene, main results), rows of panels and one legend below them;
the number of lines in heading and legend determines the height of the picture.
"""

from __future__ import annotations

import logging
import os
import re
import sys
import warnings
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from math import ceil, log10
from pathlib import Path
from threading import RLock
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from drysim import wording
from drysim.errors import DrysimError, UsageError
from drysim.interrupt import deferred_interrupt
from drysim.metrics.table import METRICS_BY_NAME, PEAK_STROKE
from drysim.metrics.text import MEANINGS, format_labelled, format_metric_ranges
from drysim.scenario.axes import FILE_KEY, FREQUENCY_KEY, Axis, KeyRange, axis_groups
from drysim.scenario.model import LIMIT_KEYS, Scenario
from drysim.scenario.text import (
    ALL_SHARED,
    describe_axis,
    describe_clean_up,
    describe_limits,
    describe_scene,
    short_key,
)
from drysim.study.compare import Comparison, describe_coinciding
from drysim.study.outcome import Outcome
from drysim.study.statistics import OK, Row
from drysim.study.table import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec


WIDTH, DPI = 9.0, 150
"""Width of a picture [inch] and its resolution [dots per inch]. Heights are in inches from the
lower edge."""

Style = dict[str, Any]

RC_PARAMS: Style = {
    "axes.axisbelow": True,
    "axes.formatter.limits": (-3, 4),
    "axes.formatter.useoffset": False,
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 10,
    "font.size": 10,
    "grid.color": "#dcdcdc",
    "grid.linewidth": 0.6,
    "svg.hashsalt": "drysim",
    "text.parse_math": False,
}
"""No text is a formula: their parser takes as long as drawing all lines of a picture."""


SAVE_OPTIONS: dict[str, Style] = {
    ".png": {"metadata": {"Software": None}, "pil_kwargs": {"compress_level": 1}},
    ".svg": {"metadata": {"Date": None, "Creator": None}},
    ".pdf": {"metadata": {"CreationDate": None, "Creator": None, "Producer": None}},
}
"""Options by format. Without date and version of matplotlib, equal pictures are equal files.
Level 1 of zlib takes two thirds of the time of the default for a PNG 10 to 30 % larger."""


def leave_out_documentation() -> None:
    """Have matplotlib write no documentation of its classes; for commands, which show none.

    Docstrings and signatures from lists of properties take matplotlib half of its import.
    """
    import_matplotlib()
    from matplotlib import artist

    artist.kwdoc = lambda artist: ""
    base: Any = artist.Artist
    base._update_set_signature_and_docstring = lambda: None


def save_picture(draw: Callable[[], Figure | None], file: Path) -> None:
    """Draw a figure in drysim's style and write it as PNG, SVG or PDF, by its suffix.

    `draw` is called with drysim's rcParams in effect; if it returns None, no file is written.
    The figure is not used any more.
    """
    with picture_style():
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        if (figure := draw()) is None:
            return
        for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
            if not axis.label.get_text():  # spares matplotlib the search for its place
                axis.set_label_coords(0.0, 0.0)
        options = SAVE_OPTIONS[file.suffix]
        if file.suffix == ".png":  # `savefig` would draw it twice, for the layout
            canvas: Any = FigureCanvasAgg(figure)
            canvas.print_png(str(file), **options)
        else:
            figure.savefig(str(file), **options)


DRAWING = RLock()
"""Held while a picture is drawn: matplotlib shares its settings between threads."""


@contextmanager
def picture_style() -> Iterator[None]:
    """Draw in drysim's style, whatever the user's matplotlibrc says; one thread at a time."""
    with DRAWING, _own_settings():
        yield


@contextmanager
def _own_settings() -> Iterator[None]:
    """Replace the settings of matplotlib."""
    with deferred_interrupt():
        matplotlib = import_matplotlib()
    params: Any = {**matplotlib.rcParamsDefault, **RC_PARAMS}
    del params["backend"]
    with matplotlib.rc_context(params), warnings.catch_warnings():
        # A character that is missing in the font is drawn as a box, without a warning.
        warnings.filterwarnings("ignore", message="Glyph", category=UserWarning)
        yield


def import_matplotlib() -> Any:
    """Import and return matplotlib, whatever backend the environment names.

    A picture needs no backend, and MPLBACKEND may name one that is missing here: programs that
    a notebook starts inherit the one of its kernel.

    Raises
    ------
    DrysimError
        If matplotlib cannot be loaded, for lack of a folder or because of its settings.
    """
    # matplotlib warns where its cache folder is not writable; the picture is not affected.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    backend = None if "matplotlib" in sys.modules else os.environ.pop("MPLBACKEND", None)
    try:
        import matplotlib.font_manager  # needs a folder for its list of fonts
    except Exception as fault:  # it reads settings and folders when it is imported
        reason = " ".join(str(fault).split())
        raise DrysimError(
            f"matplotlib cannot be loaded: {type(fault).__name__}: {reason}",
            "see MPLCONFIGDIR and a file matplotlibrc in this folder; a command computes "
            "without it by --no-plots",
        ) from fault
    finally:
        if backend is not None:
            os.environ["MPLBACKEND"] = backend
    if backend:
        with suppress(ValueError):  # as matplotlib does on import, but for the error
            matplotlib.rcParams["backend"] = backend
    return matplotlib


def register_with_notebook() -> None:
    """Load the backend of a notebook, which teaches IPython to show the figures of a cell."""
    backend = os.environ.get("MPLBACKEND", "")
    if "IPython" in sys.modules and backend.startswith("module://"):
        with suppress(ImportError):
            import_module(backend.removeprefix("module://"))


# Layout: heading, panels, legend.


SINGLE_ROW_HEIGHT, ROW_HEIGHT, LEGEND_LINE_HEIGHT = 4.1, 2.95, 0.21
"""Usual heights of a single row of panels and of one row of several, with titles and tick
labels, and height of a line of the legend [inch]."""

HANDLE_WIDTH, LEGEND_WIDTH = 0.62 * 72, 8.8 * 72
"""Widths of a line sample with its gaps, and of the whole legend [pt]."""


def panel_grid(
    rows: int,
    columns: int,
    height: float | None = None,
    ax: Axes | None = None,
    **options: Any,
) -> tuple[Figure, GridSpec]:
    """Return an empty figure and the grid of its panels.

    `height` is that of all rows [inch]; further options are matplotlib's.

    Raises
    ------
    UsageError
        When the picture shall be drawn into `ax`, axes of the user, and has several panels.
    """
    from matplotlib.figure import Figure

    if ax is not None and (panels := rows * columns) > 1:
        raise panels_error(panels)
    if height is None:
        height = SINGLE_ROW_HEIGHT if rows == 1 else rows * ROW_HEIGHT
    figure = Figure(figsize=(WIDTH, height), dpi=DPI, layout="constrained")
    return figure, figure.add_gridspec(rows, columns, **options)


def panels_error(panels: int | str) -> UsageError:
    """Return the error for a picture of several panels that shall be drawn into axes."""
    return UsageError(
        f"this picture has {panels} panels, and `ax` can hold one",
        "omit `ax`; `plot` returns a figure with all panels",
    )


def finish_figure(
    figure: Figure,
    heading: Heading,
    entries: dict[str, Any] | None = None,
    ax: Axes | None = None,
) -> None:
    """Add heading and legend to a figure of `panel_grid`, which becomes higher by as much.

    All panels have been drawn. `entries` are the handles of the legend by label, by default
    those of all panels. Axes of the user, `ax`, have a legend within them and no heading.
    """
    if entries is None:
        entries = legend_entries(figure.axes if ax is None else [ax])
    most = LEGEND_WIDTH - HANDLE_WIDTH
    entries = {fit_line(label, most): handle for label, handle in entries.items()}
    if ax is not None:
        if entries:
            ax.legend(list(entries.values()), list(entries), fontsize=HEADING_SIZE)
        return
    columns = _legend_columns([HANDLE_WIDTH + text_width(label) for label in entries])
    lines = ceil(len(entries) / columns)
    above = heading_height(heading)
    figure.set_figheight(figure.get_figheight() + above + LEGEND_LINE_HEIGHT * lines)
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0, 0, 1, 1 - above / figure.get_figheight()), w_pad=0.1, h_pad=0.08)
    # The layout asks for texts and axes only, which saves half of its time.
    for axes in figure.axes:
        drawn = *axes.lines, *axes.collections, *axes.patches, *axes.spines.values()
        for artist in drawn:
            artist.set_in_layout(False)
    write_heading(figure, heading)
    if entries:
        figure.legend(
            list(entries.values()), list(entries), loc="outside lower center",
            ncols=columns, frameon=False, fontsize=HEADING_SIZE,
            borderaxespad=0.3, columnspacing=1.2, handletextpad=0.5, handlelength=2.4,
        )  # fmt: skip


def legend_entries(panels: Iterable[Axes]) -> dict[str, Any]:
    """Return the handle of every label that is in view in a panel, without duplicates."""
    entries: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            if label not in entries and is_in_view(axes, handle):
                entries[label] = handle
    return entries


def is_in_view(axes: Axes, artist: Any) -> bool:
    """Whether a line, or a marker, is within the limits of its panel.

    Areas count as in view, and so does a line without points, which stands for others.
    """
    from matplotlib.lines import Line2D

    if not isinstance(artist, Line2D) or not artist.get_clip_on():
        return True
    view = axes.bbox.padded(1.0)  # rounding must not hide what lies on its edge
    path = artist.get_transform().transform_path(artist.get_path())
    points = np.asarray(path.vertices, dtype=float)
    if not len(points) or ((points >= view.min) & (points <= view.max)).all(axis=1).any():
        return True
    crosses = path.cleaned(remove_nans=True).intersects_bbox(view, filled=False)
    return bool(artist.get_linestyle() != "None" and crosses)


def _legend_columns(widths: Sequence[float]) -> int:
    """Return the number of columns of a legend with the fewest lines, by widths of entries."""
    for lines in range(1, len(widths)):
        columns = ceil(len(widths) / lines)
        if sum(map(max, np.array_split(widths, columns))) <= LEGEND_WIDTH:
            return columns
    return 1


# Panels: titles, scales, ticks and labels of axes.


TITLE_SIZE = RC_PARAMS["axes.titlesize"]

MAX_TICK_LETTERS, MAX_TICKS = 44, 99
"""Characters of all tick labels that fit below a panel of half the width, with two per gap;
maximum number of ticks."""

TICK_DIGITS = 8
"""Significant digits of tick labels, of which trailing zeros are omitted; a short axis far from
0 has more."""

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

FORCE_LABEL = "kinetic friction force F_fk [N]"

AXIS_LABELS = {
    FREQUENCY_KEY: "frequency [Hz]",
    "excitation.rms": "base acceleration aᵤ RMS [m/s²]",
    "friction.kinetic": FORCE_LABEL,
    FILE_KEY: FILE_KEY,
}
"""Labels of keys that are not the last word of the key with its symbol and unit."""

SYMBOLS = {
    FREQUENCY_KEY: "f",
    "excitation.rms": "aᵤ",
    "oscillator.mass": "m",
    "oscillator.stiffness": "kₓ",
    "oscillator.natural_frequency": "f₀",
    "oscillator.damping": "b",
    "oscillator.damping_ratio": "ξ",
    "friction.kinetic": "F_fk",
    "friction.static": "F_fs",
    "friction.static_ratio": "F_fs/F_fk",
    "friction.normal": "F_N",
    "friction.mu_kinetic": "µₖ",
}
"""Symbols of keys in legends, from the paper."""


class KeyLabel(NamedTuple):
    """Label of an axis over a key, and the displayed units per SI unit."""

    text: str
    factor: float = 1.0


def axis_label(axis: Axis | KeyRange) -> KeyLabel:
    """Return the label of a swept key, with the symbol of the paper where it has one.

    Lengths are shown in the unit that suits their ends, as on the console.
    """
    if axis.key in AXIS_LABELS:
        return KeyLabel(AXIS_LABELS[axis.key])
    symbol = SYMBOLS.get(axis.key)
    name = axis.key.rpartition(".")[2].replace("_", " ")
    label, unit = f"{name} {symbol}" if symbol else axis.key, wording.format_unit(axis.unit)
    if isinstance(axis, KeyRange):
        ends = axis.low, axis.high
    else:
        ends = axis.values[0], axis.values[-1]
    factor, unit = wording.display_unit(unit, max(map(abs, ends)))
    return KeyLabel(f"{label} [{unit or '–'}]", factor)


def set_title(axes: Axes, title: str, pad: float = 6.0) -> None:
    """Set the title of a panel at its left end; a common power of ten is at the right.

    A fixed position spares matplotlib the search for one.
    """
    axes.set_title(title, loc="left", pad=pad, y=1.0)
    axes.yaxis.set_offset_position("right")


def is_lowest(axes: Any) -> bool:
    """Whether a panel is in the last row, which alone has labels at a shared x-axis."""
    return bool(axes.get_subplotspec().is_last_row())


def column_count(axes: Any) -> int:
    """Return the number of columns of panels in the figure of a panel."""
    grid = axes.get_gridspec()  # axes that a user has placed freely have none
    return 1 if grid is None else int(grid.ncols)


def spans_decade(values: Collection[float]) -> bool:
    """Whether values are positive and span at least a decade."""
    low, high = min(values, default=0.0), max(values, default=0.0)
    return low > 0 and high >= 10.0 * low


def set_axis(
    axes: Axes, which: str, label: KeyLabel, low: float, high: float, is_log: bool
) -> None:
    """Set label, limits, scale and ticks of an axis: `which` is x or y.

    An x-axis without a label is that of the panel below, which has the labels of the ticks.
    """
    scale = "log" if is_log else "linear"
    axes.set(
        **{f"{which}scale": scale, f"{which}lim": (low, high), f"{which}label": label.text}
    )
    set_ticks(getattr(axes, f"{which}axis"), label.factor)
    if not label.text:
        axes.tick_params(labelbottom=False)


def set_ticks(axis: Any, factor: float = 1.0) -> None:
    """Label an axis in full, without a common power of ten, and so that no labels touch.

    The labels are the values times a factor. A logarithmic axis has labels at 1, 2 and 5 of
    every decade, or only at 1 if they are dense.
    """
    from matplotlib.ticker import Locator, LogLocator, MaxNLocator

    low, high = axis.get_view_interval()
    size, length = max(abs(low), abs(high)), abs(high - low)
    digits = max(TICK_DIGITS, 3 + ceil(log10(size / length))) if length else TICK_DIGITS
    room, locators = MAX_TICK_LETTERS, list[Locator]()
    if axis.axis_name == "x":
        room = 2 * MAX_TICK_LETTERS // column_count(axis.axes)
        locators = [MaxNLocator(n, steps=[1, 2, 2.5, 5, 10]) for n in range(9, 1, -1)]
    if axis.get_scale() == "log":
        axis.minorticks_off()
        locators = [LogLocator(subs=subs, numticks=MAX_TICKS) for subs in ((1, 2, 5), (1,))]
    for locator in locators:
        axis.set_major_locator(locator)
        ticks = (x for x in locator.tick_values(low, high) if low <= x <= high)
        if sum(len(tick_label(factor * x, digits)) + 2 for x in ticks) <= room:
            break
    axis.set_major_formatter(lambda x, _: tick_label(factor * x, digits))


def label_decades(axis: Any) -> None:
    """Label a logarithmic axis over many decades by powers of ten."""
    axis.set_minor_formatter("")
    axis.set_major_formatter(lambda x, _: f"10{f'{log10(x):.0f}'.translate(SUPERSCRIPTS)}")


def tick_label(x: float, digits: int = TICK_DIGITS) -> str:
    """Return a tick label, with a typographic minus sign."""
    return wording.format_number(x, digits=digits).replace("-", "\N{MINUS SIGN}")


# Metrics in panels of many cases.


class PlottedMetric(NamedTuple):
    """A metric as it is drawn in a panel."""

    symbol: str
    """Symbol with unit."""
    name: str
    """Name of the metric."""
    scale: float
    """Displayed value over the value in SI units."""
    title: str
    """Name in the panel title."""
    unit: str
    """Displayed unit."""

    def of(self, row: Row) -> float | None:
        """Return the displayed value of a row, or None where it is unknown."""
        value = row.metrics.get(self.name) if row.status == OK else None
        return None if value is None else value * self.scale

    def half_width(self, row: Row) -> float | None:
        """Return the half width of a mean's confidence interval, or None without one."""
        half_width = row.half_widths.get(self.name)
        return None if half_width is None else half_width * self.scale

    @property
    def full_title(self) -> str:
        """Title of a panel: name and symbol."""
        return f"{self.title} {self.symbol}".lstrip()


PANEL_TITLES = {
    "T_x": "relative displacement transmissibility",
    "T_a": "acceleration transmissibility",
    "SEAT": "weighted transmissibility",
    "a_w": "weighted acceleration",
    "x_dd_peak": "acceleration:",
    "impact_speed": "end stops:",
    "stop_force_peak": "end stops:",
    PEAK_STROKE: "stroke:",
}
"""What the title of a panel says before the symbol of the metric."""


FORMULAS = {"T_x": "xᵣ/u"}
"""What is said behind the symbol of a metric."""


def plotted(name: str, greatest: float = 0.0) -> PlottedMetric:
    """Return a metric with its symbol, a length in a unit suited to the greatest value [m]."""
    metric = METRICS_BY_NAME[name]
    scale, unit = wording.display_unit(metric.shown, greatest)
    formula = f" = {FORMULAS[name]}" if name in FORMULAS else ""
    symbol = f"{metric.symbol}{formula} [{unit or '–'}]"
    return PlottedMetric(symbol, name, scale, PANEL_TITLES.get(name, ""), unit)


T_X, T_A, SEAT, A_W = map(plotted, ("T_x", "T_a", "SEAT", "a_w"))
RATIOS = (T_X, T_A, SEAT)
"""Metrics that are 1 where the mass moves as the base does."""
X_DD, IMPACT_SPEED, STOP_FORCE = map(plotted, ("x_dd_peak", "impact_speed", "stop_force_peak"))


# Heading of a picture: title, scene and main results.


HEADING_WIDTH = 0.945 * WIDTH * 72
"""Width available for a line of the heading [pt]. Rendered letters are rounded to whole pixels,
which makes a line up to 3 % wider than computed."""

HEADING_SIZE = 9.0
"""Font size of the heading and of the legend [pt]."""

TITLE_FONT: Style = {"size": 13.0, "weight": "bold"}
"""Font of the title."""

MAX_TITLE_LENGTH = 200
"""Characters above which a title never fits, even in the narrowest ones."""

HEADING_LINE_HEIGHT = 0.19
"""Height of a line of the heading [inch]."""

END_STOPS = "end stops"
"""The only label of the scene that is printed; the other parts are clear without one."""

CLEANED = "cleaned "
"""Says that a record was cleaned; the summary says how."""

CLAUSE_BREAK = r"(?<=[,;]) "
"""Where generated text may be wrapped, so that a number stays with its name and unit."""


MAX_WRAPPED_LINES = 3
"""Lines of the heading for the main results, and for the scene."""


class Heading(NamedTuple):
    """Title of a picture and the lines below it."""

    title: str
    lines: tuple[str, ...]


def response_heading(outcome: Outcome, results: str = "") -> Heading:
    """Return the heading of the picture of a response: main results, then the scene.

    `results` are those of an ensemble, in place of those of this response.
    """
    scenario, solved = outcome.scenario, outcome.response
    seed = None if results else getattr(scenario.excitation, "seed", None)
    base = scenario.excitation.describe(solved.motion, level=False)
    base = CLEANED * bool(describe_clean_up(solved.motion, solved.law)) + base
    peak = outcome.metrics[PEAK_STROKE]
    scene = describe_scene(scenario, solved.plant, solved.law, peak=peak, defaults=False)
    return make_heading(
        scenario,
        results or _main_results(outcome),
        join_scene(scene),
        base if seed is None else f"{base}, seed {seed}",
    )


def table_heading(
    table: Table,
    left_out: int = 0,
    what: str = "curves",
    of_stroke: bool = False,
    results: str = "",
) -> Heading:
    """Return the heading of the picture of a sweep: ranges of the metrics, then the scene.

    `left_out` is the number of curves, or of `what`, that are not drawn. `of_stroke` adds the
    stroke limit, which may lie outside the drawn range. `results` replace the ranges of the
    metrics.
    """
    scenario = table.scenario
    varied = [axis.key for axis in table.axes]
    tally = table.own_tally
    peak = tally.greatest(PEAK_STROKE) if tally else None
    notes = [f"{left_out} {what} not drawn"] if left_out else []
    if tally and (seeds := tally.seeds):
        least = "" if seeds.least == seeds.most else f"{seeds.least} to "
        notes.append(f"means over {least}{seeds.most} seeds")
    unmet = [best for _, best in table.answers if best.row is None]
    notes += [best.describe(table.axes) for best in unmet[:1]]
    if of_stroke and (limit := _stroke_limit(table, peak)):
        notes.append(limit)
    ranges = results or (format_metric_ranges(tally.ends) if tally else "")
    shared = tally.shared if tally else ALL_SHARED
    plant, law = scenario.oscillator.plant(), scenario.law()
    scene = describe_scene(scenario, plant, law, varied, shared, peak, False)
    groups = map(_describe_group, axis_groups(table.axes))
    swept = f"; swept: {'; '.join(groups)}" if table.axes else ""
    base = scenario.excitation.describe_cases(None, varied)
    is_shared = not any(key.startswith("excitation.") for key in varied)
    base = CLEANED * bool(is_shared and describe_clean_up(table.motion)) + base
    return make_heading(scenario, "; ".join([*notes, ranges]), join_scene(scene), base + swept)


def _describe_group(axes: Sequence[Axis]) -> str:
    """Describe keys that vary together; of the draws of a fit their names."""
    (*_, last) = axes
    if last.source is None:
        return " with ".join(map(describe_axis, axes))
    keys = [axis.key for axis in axes]
    names = ", ".join(short_key(key, keys) for key in keys)
    return f"{wording.format_count(len(last.values), 'draw')} of {names} by a fit"


def comparison_heading(comparison: Comparison, left_out: int = 0) -> Heading:
    """Return the heading of the picture of a comparison: verdict, then the scene."""
    verdict = dict.fromkeys([*comparison.verdict[:1], *describe_coinciding(comparison)])
    return table_heading(comparison.table, left_out, "combinations", results="; ".join(verdict))


def make_heading(scenario: Scenario, results: str, scene: str, base: str) -> Heading:
    """Return a heading, with the name of the scenario as its title.

    In `results` and `scene` x_r and the like are typeset as symbols; `base` is drawn as it is,
    behind the scene.
    """
    for name, meaning in MEANINGS.items():
        results = results.replace(f"{name} ", f"{name} ({meaning}) ", 1)
    parts = (wording.typeset(results), f"{wording.typeset(scene)}; {base}".removeprefix("; "))
    lines = (line for part in parts if part for line in wrap(wording.sanitise(part)))
    return Heading(fit_title(scenario.name), tuple(lines))


def heading_height(heading: Heading) -> float:
    """Return the height of a heading [inch]."""
    return 0.5 + HEADING_LINE_HEIGHT * len(heading.lines)


def write_heading(figure: Figure, heading: Heading) -> None:
    """Write a heading at the top of a figure."""
    total_height = figure.get_figheight()
    place: dict[str, Any] = {"va": "top", "x": 0.02}
    figure.text(y=1 - 0.12 / total_height, s=heading.title, **TITLE_FONT, **place)
    offset = 0.42
    for line in heading.lines:
        figure.text(y=1 - offset / total_height, s=line, size=HEADING_SIZE, **place)
        offset += HEADING_LINE_HEIGHT


def fit_title(name: str) -> str:
    """Return a name as the title of a picture, shortened to its width."""
    return fit_line(wording.sanitise(name[:MAX_TITLE_LENGTH]), **TITLE_FONT)


def _stroke_limit(table: Table, peak: float | None) -> str:
    """Return the text of a stroke limit shared by all cases; empty with end stops."""
    stroke = table.scenario.stroke
    if stroke is None or table.scenario.stops is not None:
        return ""
    swept = any(axis.key in LIMIT_KEYS for axis in table.axes)
    return "" if swept else f"stroke limit {describe_limits(stroke.limits, peak)}"


def join_scene(scene: Iterable[tuple[str, str]]) -> str:
    """Join the parts of a scene to one line."""
    return "; ".join(f"{label} {text}" if label == END_STOPS else text for label, text in scene)


def _main_results(outcome: Outcome) -> str:
    """Return the main results on one line."""
    metrics, stroke = outcome.metrics, outcome.scenario.stroke
    peak = metrics[PEAK_STROKE]
    limit = f" (limit {describe_limits(stroke.limits, peak)})" if stroke else ""
    parts = [
        format_labelled(name, metrics[name])
        for name in ("T_a", "SEAT", "a_w", "T_x")
        if metrics[name] is not None
    ]
    parts.append(f"{format_labelled(PEAK_STROKE, peak)}{limit}")
    parts.append(format_labelled("stuck_share", metrics["stuck_share"]))
    if metrics["contacts"]:
        parts.append(f"stops hit {metrics['contacts']}×")
    elif metrics["violations"]:
        parts.append(f"limit exceeded {metrics['violations']}×")
    multiple = outcome.response.numerics.period_multiple
    if multiple:
        periods = "one period" if multiple == 1 else f"{multiple} periods"
        parts.append(f"periodic orbit over {periods}")
    return ", ".join(parts)


def wrap(text: str) -> list[str]:
    """Return text as lines of a heading; what the last one does not hold is cut."""
    lines, clauses = list[str](), re.split(CLAUSE_BREAK, text)
    while clauses and len(lines) < MAX_WRAPPED_LINES - 1:
        line = clauses.pop(0)
        while clauses and text_width(f"{line} {clauses[0]}") <= HEADING_WIDTH:
            line += f" {clauses.pop(0)}"
        lines.append(fit_line(line))
    return [*lines, *([fit_line(" ".join(clauses))] if clauses else [])]


def fit_line(text: str, width: float = HEADING_WIDTH, **font: Any) -> str:
    """Return text, cut at a clause if it is wider than `width` [pt]."""
    if text_width(text, **font) <= width:
        return text
    clauses = re.split(CLAUSE_BREAK, text)
    while len(clauses) > 1 and text_width(f"{' '.join(clauses)} …", **font) > width:
        clauses.pop()
    line = " ".join(clauses)
    while text_width(f"{line} …", **font) > width:  # a single clause
        line = line[:-1]
    return f"{line.rstrip()} …"


def text_width(text: str, **font: Any) -> float:
    """Return the width of text [pt]; `font` overrides the font of the heading."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    properties: Any = FontProperties(**{"size": HEADING_SIZE, **font})
    return float(text_to_path.get_text_width_height_descent(text, properties, ismath=False)[0])
