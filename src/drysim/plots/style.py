"""Canvas, layout, heading and legend of all pictures.

Pictures are `matplotlib.figure.Figure` objects without pyplot, which would share state. A
picture has a heading (title, scene, main results), rows of panels and one legend below them;
the number of lines in heading and legend determines the height of the picture.
"""

from __future__ import annotations

import logging
import re
import textwrap
import warnings
from collections.abc import Callable, Iterable, Sequence
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from drysim import wording
from drysim.scenario.axes import axis_groups
from drysim.scenario.model import LIMIT_KEYS, Scenario
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
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 10,
    "font.size": 10,
    "grid.color": "#dcdcdc",
    "grid.linewidth": 0.6,
}


def save_png(draw: Callable[[], Figure | None], file: Path) -> None:
    """Draw a figure in drysim's style and write it as PNG.

    Parameters
    ----------
    draw : callable
        Returns the figure, or None for no file; called with drysim's rcParams in effect.
    file : Path
        The PNG file.
    """
    # matplotlib warns where its cache folder is not writable; the picture is not affected.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    # A matplotlibrc of the user must not change the picture.
    params: Any = {**matplotlib.rcParamsDefault, **RC_PARAMS}
    del params["backend"]
    with matplotlib.rc_context(params), warnings.catch_warnings():
        # A character that is missing in the font is drawn as a box, without a warning.
        warnings.filterwarnings("ignore", message="Glyph", category=UserWarning)
        if (figure := draw()) is None:
            return
        canvas: Any = FigureCanvasAgg(figure)
        # Without the version of matplotlib, equal pictures are equal files.
        # Level 3 of zlib takes half the time of the default for a file 5 % larger.
        options = {"metadata": {"Software": None}, "pil_kwargs": {"compress_level": 3}}
        canvas.print_png(str(file), **options)


# Layout: heading, panels, legend.


SINGLE_ROW_HEIGHT, ROW_HEIGHT, LEGEND_LINE_HEIGHT = 4.1, 2.95, 0.21
"""Heights of a single row of panels and of one row of several, with titles and tick labels, and
of a line of the legend [inch]."""

HANDLE_WIDTH, LETTER_WIDTH, LEGEND_WIDTH = 0.62, 0.077, 8.8
"""Widths in the legend [inch]: a line sample with its gaps, a character, the whole legend."""


def panel_grid(
    rows: int, columns: int, row_height: float = ROW_HEIGHT, **options: Any
) -> tuple[Figure, GridSpec]:
    """Return an empty figure and the grid of its panels; further options are matplotlib's."""
    from matplotlib.figure import Figure

    height = SINGLE_ROW_HEIGHT if rows == 1 else rows * row_height
    figure = Figure(figsize=(WIDTH, height), dpi=DPI, layout="constrained")
    return figure, figure.add_gridspec(rows, columns, **options)


def finish_figure(
    figure: Figure, heading: Heading, entries: dict[str, Any] | None = None
) -> None:
    """Add heading and legend to a figure, which becomes higher by as much.

    Parameters
    ----------
    figure : Figure
        Of `panel_grid`, with all panels drawn.
    heading : Heading
    entries : dict, optional
        Handles of the legend by label; all of the panels without it.
    """
    entries = legend_entries(figure.axes) if entries is None else entries
    lines = ceil(sum(map(_entry_width, entries)) / LEGEND_WIDTH)
    above = heading_height(heading)
    figure.set_figheight(figure.get_figheight() + above + LEGEND_LINE_HEIGHT * lines)
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0, 0, 1, 1 - above / figure.get_figheight()), w_pad=0.1, h_pad=0.08)
    # The layout asks for texts and axes only, which saves half of its time.
    for axes in figure.axes:
        for artist in (*axes.lines, *axes.collections, *axes.patches):
            artist.set_in_layout(False)
    write_heading(figure, heading)
    if entries:
        figure.legend(
            list(entries.values()), list(entries), loc="outside lower center",
            ncols=ceil(len(entries) / lines), frameon=False, fontsize=9,
            borderaxespad=0.3, columnspacing=1.2, handletextpad=0.5, handlelength=2.4,
        )  # fmt: skip


def legend_entries(panels: Iterable[Axes]) -> dict[str, Any]:
    """Return the handle of every label in the panels, without duplicates."""
    known: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            known.setdefault(label, handle)
    return known


def _entry_width(label: str) -> float:
    """Return the approximate width of a legend entry [inch]."""
    return HANDLE_WIDTH + LETTER_WIDTH * len(re.sub(r"[$\\_{}]", "", label))


# Metrics in panels of many cases.


PEAK_STROKE = "x_r_peak"
"""The metric whose display unit depends on its size."""


class PlottedMetric(NamedTuple):
    """A metric as it is drawn in a panel.

    Attributes
    ----------
    symbol : str
        Symbol with unit, as matplotlib text.
    name : str
        Name of the metric.
    scale : float
        Displayed value over the value in SI units.
    title : str
        Name in the panel title.
    unit : str
        Displayed unit, if it is needed outside of `symbol`.
    """

    symbol: str
    name: str
    scale: float = 1.0
    title: str = ""
    unit: str = ""

    def of(self, row: Row) -> float | None:
        """Return the displayed value of a row, or None where it is unknown."""
        found = row.metrics.get(self.name) if row.status == OK else None
        return None if found is None else found * self.scale

    def half_width(self, row: Row) -> float | None:
        """Return the half width of a mean's confidence interval, or None without one."""
        found = row.half_widths.get(self.name)
        return None if found is None else found * self.scale

    @property
    def full_title(self) -> str:
        """Title of a panel: name and symbol."""
        return f"{self.title} {self.symbol}"


T_X = PlottedMetric("$T_x$ [–]", "T_x", title="relative displacement transmissibility")
T_A = PlottedMetric("$T_a$ [–]", "T_a", title="acceleration transmissibility")
SEAT = PlottedMetric("SEAT [–]", "SEAT", title="weighted transmissibility")
A_W = PlottedMetric("$a_w$ [m/s²]", "a_w", title="weighted acceleration")
IMPACT_SPEED = PlottedMetric("impact speed [m/s]", "impact_speed", title="end stops:")
STOP_FORCE = PlottedMetric("peak force [N]", "stop_force_peak", title="end stops:")


def stroke_metric(greatest: float) -> PlottedMetric:
    """Return the peak of |x_r| in a unit suited to the largest of all peaks [m]."""
    unit = wording.length_unit(greatest)
    symbol = f"peak |$x_r$| [{unit.symbol}]"
    return PlottedMetric(symbol, PEAK_STROKE, unit.units_per_metre, "stroke:", unit.symbol)


# Heading of a picture: title, scene and main results.


HEADING_WIDTH = 0.945 * WIDTH * 72
"""Width available for a line of the heading [pt]. Rendered letters are rounded to whole pixels,
which makes a line up to 3 % wider than computed."""

MAX_WORD_LENGTH = 60
"""Characters above which a word is split."""

MAX_LINES = 2
"""Maximum number of lines of a paragraph in the heading."""

HEADING_SIZE = 9.0
"""Font size of the heading [pt]."""

TITLE_FONT: Style = {"size": 13.0, "weight": "bold"}
"""Font of the title."""

MAX_TITLE_LENGTH = 200
"""Characters above which a title never fits, even in the narrowest ones."""

HEADING_LINE_HEIGHT = 0.19
"""Height of a line of the heading [inch]."""

END_STOPS = "end stops"
"""The only label of the scene that is printed; the other parts are clear without one."""

CLAUSE_BREAK = r"(?<=[,;]) "
"""Where generated text may be wrapped, so that a number stays with its name and unit."""

Heading = tuple[str, list[str], list[str]]
"""Title; lines printed literally (text of the user); lines in which x_r and the like are
typeset as symbols."""


def response_heading(outcome: Outcome, seeds: str = "", results: str = "") -> Heading:
    """Return the heading of the picture of a response.

    Parameters
    ----------
    outcome : Outcome
    seeds, results : str
        Description of the seeds and the results of an ensemble, instead of those of this
        response.
    """
    scenario, motion = outcome.scenario, outcome.response
    seed = None if seeds else getattr(scenario.excitation, "seed", None)
    base = "base motion" if seed is None else f"base motion, seed {seed}"
    base += f": {scenario.excitation.describe(motion.motion, level=False)}"
    peak = outcome.metrics[PEAK_STROKE]
    words = wording.describe_scene(
        scenario, motion.plant, motion.law, peak=peak, defaults=False
    )
    above = _description(scenario, base, wording.describe_clean_up(motion.motion, motion.law))
    found = [*_wrap(_join_scene(words), True), *_wrap(results or _main_results(outcome), True)]
    return _fit_title(scenario), [*above, *_wrap(seeds)], found


def table_heading(
    table: Table, left_out: int = 0, what: str = "curves", of_stroke: bool = False
) -> Heading:
    """Return the heading of the picture of a sweep.

    Parameters
    ----------
    table : Table
    left_out : int
        Number of curves that are not drawn.
    what : str
        What `left_out` counts.
    of_stroke : bool
        Whether to state the stroke limit, which may lie outside the drawn range.
    """
    scenario = table.scenario
    varied = [axis.key for axis in table.axes]
    base = f"base motion: {scenario.excitation.describe_swept(varied)}"
    own = next(iter(table.tallies.values()), None)
    if own and (found := own.seeds):
        span = (
            str(found.most) if found.least == found.most else f"{found.least} to {found.most}"
        )
        base += f", means over {span} seeds"
    if table.axes:
        groups = (
            " with ".join(map(wording.describe_axis, group))
            for group in axis_groups(table.axes)
        )
        base += f"; swept: {'; '.join(groups)}"
    if left_out:
        base += f" ({left_out} {what} not drawn)"
    shared_forces = own.shared if own else wording.ALL_SHARED
    peak = own.greatest(PEAK_STROKE) if own else None
    plant, law = scenario.oscillator.plant(), scenario.law()
    scene = _join_scene(
        wording.describe_scene(scenario, plant, law, varied, shared_forces, peak, False)
    )
    shared = not any(key.startswith("excitation.") for key in varied)
    words = _description(
        scenario, base, wording.describe_clean_up(table.motion if shared else None)
    )
    if of_stroke and (limit := _stroke_limit(table, peak)):
        scene += f"; {limit}"
    return _fit_title(scenario), words, _wrap(scene, True)


def comparison_heading(comparison: Comparison, left_out: int = 0) -> Heading:
    """Return the heading of the picture of a comparison: scene and verdict."""
    title, words, symbols = table_heading(comparison.table, left_out, "combinations")
    verdict = wording.sanitise(
        "; ".join(dict.fromkeys([*comparison.verdict[:1], *describe_coinciding(comparison)]))
    )
    return title, words, [*symbols, *_wrap(verdict)]


def heading_height(heading: Heading) -> float:
    """Return the height of a heading [inch]."""
    return 0.5 + HEADING_LINE_HEIGHT * (len(heading[1]) + len(heading[2]))


def write_heading(figure: Figure, heading: Heading) -> None:
    """Write a heading at the top of a figure."""
    title, words, symbols = heading
    total_height = figure.get_figheight()
    place: dict[str, Any] = {"va": "top", "x": 0.02}
    figure.text(y=1 - 0.12 / total_height, s=title, parse_math=False, **TITLE_FONT, **place)
    at = 0.42
    for line in words:
        figure.text(
            y=1 - at / total_height, s=line, size=HEADING_SIZE, parse_math=False, **place
        )
        at += HEADING_LINE_HEIGHT
    for line in symbols:
        figure.text(y=1 - at / total_height, s=_typeset(line), size=HEADING_SIZE, **place)
        at += HEADING_LINE_HEIGHT


def _fit_title(scenario: Scenario) -> str:
    """Return the name of a scenario, shortened to the width of the picture."""
    whole = wording.sanitise(scenario.name)
    name = whole[:MAX_TITLE_LENGTH]
    if name == whole and _text_width(name, False, **TITLE_FONT) <= HEADING_WIDTH:
        return name
    while _text_width(f"{name} …", False, **TITLE_FONT) > HEADING_WIDTH:
        name = name[:-1]
    return f"{name.rstrip()} …"


def _description(scenario: Scenario, base: str, cleaned: Sequence[str]) -> list[str]:
    """Return the lines on the scenario's purpose, base motion and record cleaning."""
    about = _wrap(wording.sanitise(scenario.about or ""), separator=" ")
    done = f"cleaned: {'; '.join(cleaned)}" if cleaned else ""
    return [*about, *_wrap(base), *_wrap(done)]


def _stroke_limit(table: Table, peak: float | None) -> str:
    """Return the text of a stroke limit shared by all cases; empty with end stops."""
    stroke = table.scenario.stroke
    if stroke is None or table.scenario.stops is not None:
        return ""
    swept = any(axis.key in LIMIT_KEYS for axis in table.axes)
    return "" if swept else f"stroke limit {wording.describe_limits(stroke.limits, peak)}"


def _join_scene(words: Iterable[tuple[str, str]]) -> str:
    """Join the parts of a scene to one line."""
    return "; ".join(f"{label} {text}" if label == END_STOPS else text for label, text in words)


def _main_results(outcome: Outcome) -> str:
    """Return the main results on one line."""
    metrics, stroke = outcome.metrics, outcome.scenario.stroke
    peak = metrics[PEAK_STROKE]
    limit = f" (limit {wording.describe_limits(stroke.limits, peak)})" if stroke else ""
    parts = [
        f"{name} {wording.format_number(metrics[name])}"
        for name in ("T_a", "T_x")
        if metrics[name] is not None
    ]
    parts.append(f"peak |x_r| {wording.format_length(peak)}{limit}")
    parts.append(f"stuck {wording.format_percent(metrics['stuck_share'])}")
    if metrics["contacts"]:
        parts.append(f"stops hit {metrics['contacts']}×")
    elif metrics["violations"]:
        parts.append(f"limit exceeded {metrics['violations']}×")
    multiple = outcome.response.numerics.period_multiple
    if multiple:
        periods = "one period" if multiple == 1 else f"{multiple} periods"
        parts.append(f"periodic orbit over {periods}")
    return ", ".join(parts)


def _wrap(words: str, symbols: bool = False, separator: str = CLAUSE_BREAK) -> list[str]:
    """Wrap a text to the width of the heading, shortened to `MAX_LINES` lines."""
    parts = re.split(separator, words)
    found = [""]
    for part in (piece for one in parts for piece in textwrap.wrap(one, MAX_WORD_LENGTH)):
        longer = f"{found[-1]} {part}".lstrip()
        if found[-1] and _text_width(longer, symbols) > HEADING_WIDTH:
            found.append(part)
        else:
            found[-1] = longer
        if len(found) > MAX_LINES:
            break
    if len(found) > MAX_LINES:
        last = found[MAX_LINES - 1]
        while _text_width(f"{last} …", symbols) > HEADING_WIDTH:
            last = last.rpartition(" ")[0]
        found = [*found[: MAX_LINES - 1], f"{last} …"]
    return [line for line in found if line]


def _text_width(words: str, symbols: bool, **font: Any) -> float:
    """Return the width of a text [pt]; `font` overrides the font of the heading."""
    from matplotlib.cbook import is_math_text
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    properties: Any = FontProperties(**{"size": HEADING_SIZE, **font})
    text: Any = _typeset(words) if symbols else words
    math: Any = symbols and is_math_text(text)
    return float(text_to_path.get_text_width_height_descent(text, properties, ismath=math)[0])


def _typeset(text: str) -> str:
    """Typeset m, b, F_fk and the like as mathematical symbols."""
    text = re.sub(r"\b([A-Za-zσ])_(\w+)", r"$\1_{\2}$", text)
    return re.sub(r"\b([mb]) (?=\d)", r"$\1$ ", text)
