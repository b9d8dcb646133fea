"""The words above a picture: title, scene and main results."""

from __future__ import annotations

import re
import textwrap
from typing import TYPE_CHECKING, Any

from drysim import wording

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from drysim.study.outcome import Outcome

WRAP = 118
"""Letters that fit into a line of the scene."""

LINE = 0.19
"""Height of a line [inch]."""

Lines = tuple[str, list[str], list[str]]
"""Title; words of the user, taken as they are; words of drysim, in which x_r is a symbol."""


def lines(outcome: Outcome) -> Lines:
    """Give the heading of a picture, line by line."""
    scenario, motion = outcome.scenario, outcome.response
    about = textwrap.wrap(
        wording.clean(scenario.about or ""), WRAP, max_lines=2, placeholder=" …"
    )
    base = wording.excitation(scenario.excitation.kind, motion.motion)
    scene = f"{wording.scene(motion.plant)}; {wording.friction(motion.law)}"
    title = textwrap.shorten(wording.clean(scenario.name), 80, placeholder=" …")
    base = textwrap.shorten(f"base motion: {base}", WRAP, placeholder=" …")
    return title, [*about, base], [scene, _found(outcome)]


def _found(outcome: Outcome) -> str:
    """Give the main results in one line."""
    metrics, stroke = outcome.metrics, outcome.scenario.stroke
    limit = f" of {wording.millimetres(stroke.limit)}" if stroke else ""
    parts = [
        f"{name} {wording.number(metrics[name])}"
        for name in ("T_a", "T_x")
        if metrics[name] is not None
    ]
    parts.append(f"peak |x_r| {wording.millimetres(metrics['x_r_peak'])}{limit}")
    parts.append(f"stuck {wording.percent(metrics['stuck_share'])}")
    if metrics["violations"]:
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
    figure.text(y=1 - 0.12 / tall, s=title, weight="bold", size=13, parse_math=False, **place)
    at = 0.42
    for line in words:
        figure.text(y=1 - at / tall, s=line, size=9, parse_math=False, **place)
        at += LINE
    for line in symbols:
        figure.text(y=1 - at / tall, s=_typeset(line), size=9, **place)
        at += LINE


def _typeset(text: str) -> str:
    """Set m, F_fk and their like as symbols."""
    text = re.sub(r"\b([A-Za-z])_(\w+)", r"$\1_{\2}$", text)
    return re.sub(r"\b([mb]) (?=\d)", r"$\1$ ", text)
