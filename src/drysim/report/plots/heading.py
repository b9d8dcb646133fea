"""The words above a picture: title, scene and main results."""

from __future__ import annotations

import re
import textwrap
from typing import TYPE_CHECKING, Any

from drysim import wording
from drysim.report.plots import canvas
from drysim.report.plots.shown import STROKE
from drysim.scenario.sweep.axis import walks
from drysim.study.comparisons.agreement import coinciding
from drysim.study.sweeps.table import LIMIT

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from matplotlib.figure import Figure

    from drysim.scenario import Scenario
    from drysim.study.comparisons.comparison import Comparison
    from drysim.study.outcome import Outcome
    from drysim.study.sweeps.table import Table

ROOM = 0.945 * canvas.WIDTH * 72
"""Width of a line of the scene [pt]: set in whole dots, letters are up to 3 % wider."""

LONGEST = 60
"""Letters from which on a word may be parted."""

LINES = 2
"""Lines that a sentence may take."""

SIZE = 9.0
"""Size of its letters [pt]."""

TITLE: dict[str, Any] = {"size": 13.0, "weight": "bold"}
"""Font of the name above them."""

LONGEST_TITLE = 200
"""Letters beyond which no name fits, however narrow they are."""

LINE = 0.19
"""Height of a line [inch]."""

STOPS = "end stops"
"""The head that a line of the scene keeps; all others go without saying."""

COMMA = r"(?<=[,;]) "
"""Behind what drysim's own lines end, so that a number keeps its name and its unit."""

Lines = tuple[str, list[str], list[str]]
"""Title; words of the user, taken as they are; words of drysim, in which x_r is a symbol."""


def lines(outcome: Outcome, seeds: str = "", results: str = "") -> Lines:
    """Return the heading of the picture of a response, line by line.

    `seeds` and `results` are the words for many seeds, in place of those for the response.
    """
    scenario, motion = outcome.scenario, outcome.response
    seed = None if seeds else getattr(scenario.excitation, "seed", None)
    base = "base motion" if seed is None else f"base motion, seed {seed}"
    base += f": {wording.excitation(scenario.excitation, motion.motion, level=False)}"
    peak = outcome.metrics["x_r_peak"]
    words = wording.scene(motion.plant, motion.law, terms=scenario.terms, peak=peak)
    scene = _scene(words)
    cleaned = _cleaned(wording.clean_up(motion.motion, motion.law))
    above = [*_about(scenario), *_wrapped(base), *cleaned]
    found = [*_wrapped(scene, True), *_wrapped(results or _found(outcome), True)]
    return _title(scenario), [*above, *_wrapped(seeds)], found


def of_table(
    table: Table, left_out: int = 0, what: str = "curves", of_stroke: bool = False
) -> Lines:
    """Give the heading of the picture of a table, and what it leaves out.

    That of the stroke tells its limit: it may be too far away to be drawn.
    """
    scenario = table.scenario
    varied = [axis.key for axis in table.axes]
    base = f"base motion: {wording.excitations(scenario.excitation, varied)}"
    own = next(iter(table.tallies.values()), None)
    if own and (found := own.seeds):
        span = (
            str(found.most) if found.least == found.most else f"{found.least} to {found.most}"
        )
        base += f", means over {span} seeds"
    if table.axes:
        groups = (" with ".join(map(wording.swept, group)) for group in walks(table.axes))
        base += f"; swept: {'; '.join(groups)}"
    if left_out:
        base += f" ({left_out} {what} are not drawn)"
    known: dict[str, Any] = {
        "terms": scenario.terms,
        "swept": varied,
        "ratios": scenario.ratios,
    }
    if own:
        known |= {"shared": own.shared, "peak": own.greatest(STROKE)}
    scene = _scene(wording.scene(scenario.oscillator.plant(), scenario.law(), **known))
    shared = not any(key.startswith("excitation.") for key in varied)
    cleaned = _cleaned(wording.clean_up(table.motion if shared else None))
    words = [*_about(scenario), *_wrapped(base), *cleaned]
    if of_stroke and (limit := _limit(table, known.get("peak"))):
        scene += f"; {limit}"
    return _title(scenario), words, _wrapped(scene, True)


def of_comparison(made: Comparison, left_out: int = 0) -> Lines:
    """Give the heading of the picture of a comparison: the scene and the verdict."""
    title, words, symbols = of_table(made.table, left_out, "combinations")
    verdict = wording.clean("; ".join(dict.fromkeys([*made.verdict[:1], *coinciding(made)])))
    return title, words, [*symbols, *_wrapped(verdict)]


def _title(scenario: Scenario) -> str:
    """Return the name of a scenario, cut where it is wider than the picture."""
    name = wording.clean(scenario.name)[:LONGEST_TITLE]
    if name == wording.clean(scenario.name) and _width(name, False, **TITLE) <= ROOM:
        return name
    while _width(f"{name} …", False, **TITLE) > ROOM:
        name = name[:-1]
    return f"{name.rstrip()} …"


def _about(scenario: Scenario) -> list[str]:
    return _wrapped(wording.clean(scenario.about or ""), apart=" ")


def _limit(table: Table, peak: float | None) -> str:
    """Give the stroke limit that all cases share; that of end stops is told with them."""
    stroke = table.scenario.stroke
    if stroke is None or table.scenario.stops is not None:
        return ""
    swept = any(axis.key == LIMIT for axis in table.axes)
    return "" if swept else f"stroke limit {wording.length(stroke.limit, peak)}"


def _cleaned(told: Sequence[str]) -> list[str]:
    """Give what was done to records, if anything."""
    return _wrapped(f"cleaned: {'; '.join(told)}") if told else []


def _wrapped(words: str, symbols: bool = False, apart: str = COMMA) -> list[str]:
    """Give a sentence in lines that fit, cut where it takes more than it may."""
    parts = re.split(apart, words)
    found = [""]
    for part in (piece for one in parts for piece in textwrap.wrap(one, LONGEST)):
        longer = f"{found[-1]} {part}".lstrip()
        if found[-1] and _width(longer, symbols) > ROOM:
            found.append(part)
        else:
            found[-1] = longer
        if len(found) > LINES:
            break
    if len(found) > LINES:
        last = found[LINES - 1]
        while _width(f"{last} …", symbols) > ROOM:
            last = last.rpartition(" ")[0]
        found = [*found[: LINES - 1], f"{last} …"]
    return [line for line in found if line]


def _width(words: str, symbols: bool, **font: Any) -> float:
    """Return how wide words are [pt]; `font` tells another than that of the scene."""
    from matplotlib.cbook import is_math_text
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    properties: Any = FontProperties(**{"size": SIZE, **font})
    text: Any = _typeset(words) if symbols else words
    math: Any = symbols and is_math_text(text)
    return float(text_to_path.get_text_width_height_descent(text, properties, ismath=math)[0])


def _scene(words: Iterable[tuple[str, str]]) -> str:
    """Give what is solved in one line."""
    return "; ".join(f"{head} {said}" if head == STOPS else said for head, said in words)


def _found(outcome: Outcome) -> str:
    """Give the main results in one line."""
    metrics, stroke = outcome.metrics, outcome.scenario.stroke
    peak = metrics["x_r_peak"]
    limit = f" of {wording.length(stroke.limit, peak)}" if stroke else ""
    parts = [
        f"{name} {wording.number(metrics[name])}"
        for name in ("T_a", "T_x")
        if metrics[name] is not None
    ]
    parts.append(f"peak |x_r| {wording.length(peak)}{limit}")
    parts.append(f"stuck {wording.percent(metrics['stuck_share'])}")
    if metrics["contacts"]:
        parts.append(f"stops met {metrics['contacts']}×")
    elif metrics["violations"]:
        parts.append(f"limit met {metrics['violations']}×")
    multiple = outcome.response.numerics.period_multiple
    if multiple:
        periods = "one period" if multiple == 1 else f"{multiple} periods"
        parts.append(f"steady orbit over {periods}")
    return ", ".join(parts)


def height(head: Lines) -> float:
    """Give the height that a heading takes [inch]."""
    return 0.5 + LINE * (len(head[1]) + len(head[2]))


def write(figure: Figure, head: Lines) -> None:
    """Write a heading into the top of a picture."""
    title, words, symbols = head
    tall = figure.get_figheight()
    place: dict[str, Any] = {"va": "top", "x": 0.02}
    figure.text(y=1 - 0.12 / tall, s=title, parse_math=False, **TITLE, **place)
    at = 0.42
    for line in words:
        figure.text(y=1 - at / tall, s=line, size=SIZE, parse_math=False, **place)
        at += LINE
    for line in symbols:
        figure.text(y=1 - at / tall, s=_typeset(line), size=SIZE, **place)
        at += LINE


def _typeset(text: str) -> str:
    """Set m, F_fk and their like as symbols."""
    text = re.sub(r"\b([A-Za-zσ])_(\w+)", r"$\1_{\2}$", text)
    return re.sub(r"\b([mb]) (?=\d)", r"$\1$ ", text)
