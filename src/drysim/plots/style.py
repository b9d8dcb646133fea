"""What all pictures share: canvas, layout, heading and legend.

A picture is a Figure object, never of pyplot, so that two pictures share nothing. Rows of
panels have the heading above them, which tells title, scene and main results, and one legend
below; what these take decides the height of the picture.
"""

from __future__ import annotations

import logging
import re
import textwrap
import warnings
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from drysim import wording
from drysim.scenario.axes import axis_groups
from drysim.scenario.model import Scenario
from drysim.study.compare import Comparison, describe_coinciding
from drysim.study.outcome import Outcome
from drysim.study.statistics import LIMIT_KEY, OK, Row
from drysim.study.table import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec


WIDTH, DPI = 9.0, 150
"""Width of a picture [inch] and dots per inch; all heights are inches from its foot."""

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


def save_png(draw: Callable[[], Figure], file: Path) -> None:
    """Draw a picture in the style of drysim, as `draw` gives it, and write it as PNG."""
    # That its cache has no home is nothing to tell anybody.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    # Nobody's own matplotlibrc changes the picture.
    style: Any = {**matplotlib.rcParamsDefault, **RC_PARAMS}
    del style["backend"]
    with matplotlib.rc_context(style), warnings.catch_warnings():
        # A sign that the font lacks is drawn as a box; that is all there is to say.
        warnings.filterwarnings("ignore", message="Glyph", category=UserWarning)
        canvas: Any = FigureCanvasAgg(draw())
        # The version of matplotlib would change the file where the picture is the same.
        canvas.print_png(str(file), metadata={"Software": None})


def new_figure(height: float) -> Figure:
    """Give an empty picture of a height [inch]."""
    from matplotlib.figure import Figure

    return Figure(figsize=(WIDTH, height), dpi=DPI)


# Where things stand in a picture of rows of panels.


SINGLE_ROW_HEIGHT, ROW_HEIGHT = 3.3, 2.3
"""Height of a row of panels [inch]: the only one, and one of several."""

ROW_GAP, FOOT_HEIGHT, LEGEND_LINE_HEIGHT = 0.62, 0.52, 0.21
"""Room above a row of panels, below the lowest one, and of a line of the legend [inch]."""

LEFT, RIGHT, COLUMN_GAP = 0.075, 0.98, 0.17
"""Where panels begin and end [-], and the room between two in widths of one [-]."""

HANDLE_WIDTH, LETTER_WIDTH, LEGEND_WIDTH = 0.62, 0.077, 8.8
"""Widths in a legend [inch]: a line with its gaps, a letter, and all there is."""


def panel_grid(
    rows: int,
    columns: int,
    left: float = LEFT,
    right: float = RIGHT,
    gap: float = ROW_GAP,
    aside: float = COLUMN_GAP,
) -> tuple[Figure, GridSpec]:
    """Give an empty picture, and room for its panels.

    `gap` [inch] is between their rows, `aside` [panels] between their columns.
    """
    figure = new_figure(rows * _row_height(rows))
    grid = figure.add_gridspec(
        rows, columns, left=left, right=right, wspace=aside, hspace=gap / _row_height(rows)
    )
    return figure, grid


def finish_figure(
    figure: Figure, grid: GridSpec, words: Heading, unnamed: Collection[str] = ()
) -> tuple[float, float]:
    """Give a picture its height, heading and legend; tells where its panels begin and end.

    Parameters
    ----------
    figure, grid
        As `panel_grid` gave them, the panels drawn.
    words : Lines
        The heading.
    unnamed : collection of str
        Labels that the legend leaves out.
    """
    known = legend_entries(figure.axes, unnamed)
    lines = ceil(sum(map(_entry_width, known)) / LEGEND_WIDTH)
    foot = FOOT_HEIGHT + LEGEND_LINE_HEIGHT * lines + 0.06
    row = _row_height(grid.nrows)
    between = (grid.nrows - 1) * (grid.hspace or 0.0) * row
    body = foot + grid.nrows * row + between + ROW_GAP
    total_height = body + heading_height(words) - 0.2
    figure.set_figheight(total_height)
    bottom, top = foot / total_height, (body - ROW_GAP) / total_height
    grid.update(bottom=bottom, top=top)
    for axes in figure.axes:
        if (subplot := axes.get_subplotspec()) is not None:
            axes.set_position(subplot.get_position(figure))
    write_heading(figure, words)
    if known:
        add_legend(figure, known, columns=ceil(len(known) / lines), length=2.4)
    return bottom, top


def add_legend(figure: Figure, known: Mapping[str, Any], columns: int, length: float) -> None:
    """Name lines below all panels, each behind a piece of so many letters."""
    figure.legend(
        list(known.values()), list(known), loc="lower center", ncols=columns, frameon=False,
        fontsize=9, borderaxespad=0.3, columnspacing=1.2, handletextpad=0.5,
        handlelength=length,
    )  # fmt: skip


def legend_entries(panels: Iterable[Axes], unnamed: Collection[str] = ()) -> dict[str, Any]:
    """Give the labelled lines of panels, each once."""
    known: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            if label not in unnamed:
                known.setdefault(label, handle)
    return known


def _row_height(rows: int) -> float:
    """Give the height of one of some rows of panels [inch]."""
    return SINGLE_ROW_HEIGHT if rows == 1 else ROW_HEIGHT


def _entry_width(label: str) -> float:
    """Give about how wide an entry of the legend is [inch]."""
    return HANDLE_WIDTH + LETTER_WIDTH * len(re.sub(r"[$\\_{}]", "", label))


# What panels show of many cases: metrics, in words, symbols and scales.


PEAK_STROKE = "x_r_peak"
"""The metric whose unit is chosen for its size."""


class Quantity(NamedTuple):
    """What a panel shows: symbol, metric, scale, what it is called, and the unit of that."""

    symbol: str
    metric: str
    scale: float = 1.0
    title: str = ""
    unit: str = ""

    def of(self, row: Row) -> float | None:
        """Give the value of a row; None where it is not known."""
        found = row.metrics.get(self.metric) if row.status == OK else None
        return None if found is None else found * self.scale

    def width(self, row: Row) -> float | None:
        """Give half the interval of a mean over many seeds; None where there is none."""
        found = row.half_widths.get(self.metric)
        return None if found is None else found * self.scale

    @property
    def words(self) -> str:
        """The title of a panel that has no other."""
        return f"{self.title} {self.symbol}"


T_X = Quantity("$T_x$ [–]", "T_x", title="relative displacement transmissibility")
T_A = Quantity("$T_a$ [–]", "T_a", title="acceleration transmissibility")
SEAT = Quantity("SEAT [–]", "SEAT")
IMPACT_SPEED = Quantity("impact speed [m/s]", "impact_speed", title="end stops:")
STOP_FORCE = Quantity("peak force [N]", "stop_force_peak", title="end stops:")


def stroke_quantity(greatest: float) -> Quantity:
    """Give the peak of |x_r| in the unit in which the greatest of them [m] reads well."""
    unit = wording.length_unit(greatest)
    symbol = f"peak |$x_r$| [{unit.sign}]"
    return Quantity(symbol, PEAK_STROKE, unit.units_per_metre, "stroke:", unit.sign)


# The words above a picture: title, scene and main results.


HEADING_WIDTH = 0.945 * WIDTH * 72
"""Width of a line of the scene [pt]: set in whole dots, letters are up to 3 % wider."""

MAX_WORD_LENGTH = 60
"""Letters from which on a word may be parted."""

MAX_LINES = 2
"""Lines that a sentence may take."""

HEADING_SIZE = 9.0
"""Size of its letters [pt]."""

TITLE_FONT: Style = {"size": 13.0, "weight": "bold"}
"""Font of the name above them."""

MAX_TITLE_LENGTH = 200
"""Letters beyond which no name fits, however narrow they are."""

HEADING_LINE_HEIGHT = 0.19
"""Height of a line [inch]."""

END_STOPS = "end stops"
"""The head that a line of the scene keeps; all others go without saying."""

CLAUSE_BREAK = r"(?<=[,;]) "
"""Behind what drysim's own lines end, so that a number keeps its name and its unit."""

Heading = tuple[str, list[str], list[str]]
"""Title; words of the user, taken as they are; words of drysim, in which x_r is a symbol."""


def response_heading(outcome: Outcome, seeds: str = "", results: str = "") -> Heading:
    """Return the heading of the picture of a response, line by line.

    `seeds` and `results` are the words for many seeds, in place of those for the response.
    """
    scenario, motion = outcome.scenario, outcome.response
    seed = None if seeds else getattr(scenario.excitation, "seed", None)
    base = "base motion" if seed is None else f"base motion, seed {seed}"
    base += f": {wording.describe_excitation(scenario.excitation, motion.motion, level=False)}"
    words = wording.describe_scene(
        motion.plant, motion.law, terms=scenario.terms, peak=outcome.metrics[PEAK_STROKE]
    )
    above = _description(scenario, base, wording.describe_clean_up(motion.motion, motion.law))
    found = [*_wrap(_join_scene(words), True), *_wrap(results or _main_results(outcome), True)]
    return _fit_title(scenario), [*above, *_wrap(seeds)], found


def table_heading(
    table: Table, left_out: int = 0, what: str = "curves", of_stroke: bool = False
) -> Heading:
    """Give the heading of the picture of a table, and what it leaves out.

    That of the stroke tells its limit: it may be too far away to be drawn.
    """
    scenario = table.scenario
    varied = [axis.key for axis in table.axes]
    base = f"base motion: {wording.describe_swept_excitation(scenario.excitation, varied)}"
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
        base += f" ({left_out} {what} are not drawn)"
    known: dict[str, Any] = {
        "terms": scenario.terms,
        "swept": varied,
        "ratios": scenario.ratios,
    }
    if own:
        known |= {"shared": own.shared, "peak": own.greatest(PEAK_STROKE)}
    scene = _join_scene(
        wording.describe_scene(scenario.oscillator.plant(), scenario.law(), **known)
    )
    shared = not any(key.startswith("excitation.") for key in varied)
    words = _description(
        scenario, base, wording.describe_clean_up(table.motion if shared else None)
    )
    if of_stroke and (limit := _stroke_limit(table, known.get("peak"))):
        scene += f"; {limit}"
    return _fit_title(scenario), words, _wrap(scene, True)


def comparison_heading(comparison: Comparison, left_out: int = 0) -> Heading:
    """Give the heading of the picture of a comparison: the scene and the verdict."""
    title, words, symbols = table_heading(comparison.table, left_out, "combinations")
    verdict = wording.sanitise(
        "; ".join(dict.fromkeys([*comparison.verdict[:1], *describe_coinciding(comparison)]))
    )
    return title, words, [*symbols, *_wrap(verdict)]


def heading_height(heading: Heading) -> float:
    """Give the height that a heading takes [inch]."""
    return 0.5 + HEADING_LINE_HEIGHT * (len(heading[1]) + len(heading[2]))


def write_heading(figure: Figure, heading: Heading) -> None:
    """Write a heading into the top of a picture."""
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
    """Return the name of a scenario, cut where it is wider than the picture."""
    whole = wording.sanitise(scenario.name)
    name = whole[:MAX_TITLE_LENGTH]
    if name == whole and _text_width(name, False, **TITLE_FONT) <= HEADING_WIDTH:
        return name
    while _text_width(f"{name} …", False, **TITLE_FONT) > HEADING_WIDTH:
        name = name[:-1]
    return f"{name.rstrip()} …"


def _description(scenario: Scenario, base: str, cleaned: Sequence[str]) -> list[str]:
    """Give the lines of what it is about, how the base moves, and what was done to records."""
    about = _wrap(wording.sanitise(scenario.about or ""), separator=" ")
    done = f"cleaned: {'; '.join(cleaned)}" if cleaned else ""
    return [*about, *_wrap(base), *_wrap(done)]


def _stroke_limit(table: Table, peak: float | None) -> str:
    """Give the stroke limit that all cases share; that of end stops is told with them."""
    stroke = table.scenario.stroke
    if stroke is None or table.scenario.stops is not None:
        return ""
    swept = any(axis.key == LIMIT_KEY for axis in table.axes)
    return "" if swept else f"stroke limit {wording.format_length(stroke.limit, peak)}"


def _join_scene(words: Iterable[tuple[str, str]]) -> str:
    """Give what is solved in one line."""
    return "; ".join(
        f"{heading} {sentence}" if heading == END_STOPS else sentence
        for heading, sentence in words
    )


def _main_results(outcome: Outcome) -> str:
    """Give the main results in one line."""
    metrics, stroke = outcome.metrics, outcome.scenario.stroke
    peak = metrics[PEAK_STROKE]
    limit = f" of {wording.format_length(stroke.limit, peak)}" if stroke else ""
    parts = [
        f"{name} {wording.format_number(metrics[name])}"
        for name in ("T_a", "T_x")
        if metrics[name] is not None
    ]
    parts.append(f"peak |x_r| {wording.format_length(peak)}{limit}")
    parts.append(f"stuck {wording.format_percent(metrics['stuck_share'])}")
    if metrics["contacts"]:
        parts.append(f"stops met {metrics['contacts']}×")
    elif metrics["violations"]:
        parts.append(f"limit met {metrics['violations']}×")
    multiple = outcome.response.numerics.period_multiple
    if multiple:
        periods = "one period" if multiple == 1 else f"{multiple} periods"
        parts.append(f"steady orbit over {periods}")
    return ", ".join(parts)


def _wrap(words: str, symbols: bool = False, separator: str = CLAUSE_BREAK) -> list[str]:
    """Give a sentence in lines that fit, cut where it takes more than it may."""
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
    """Return how wide words are [pt]; `font` tells another than that of the scene."""
    from matplotlib.cbook import is_math_text
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    properties: Any = FontProperties(**{"size": HEADING_SIZE, **font})
    text: Any = _typeset(words) if symbols else words
    math: Any = symbols and is_math_text(text)
    return float(text_to_path.get_text_width_height_descent(text, properties, ismath=math)[0])


def _typeset(text: str) -> str:
    """Set m, F_fk and their like as symbols."""
    text = re.sub(r"\b([A-Za-zσ])_(\w+)", r"$\1_{\2}$", text)
    return re.sub(r"\b([mb]) (?=\d)", r"$\1$ ", text)
