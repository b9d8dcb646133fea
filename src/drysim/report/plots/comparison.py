"""The picture of a comparison: the motion around a stop, T_a, and how far it is off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim import wording
from drysim.approach.numerics import FIXED_STEP
from drysim.report.plots import against, canvas, curves, heading, ink, layout, moment, panels
from drysim.report.plots.curves import Curve
from drysim.report.plots.labels import spoken
from drysim.report.plots.views import compared

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from drysim.approach.response import Response
    from drysim.report.plots.ink import Style
    from drysim.study.comparisons.comparison import Comparison

# Told apart in grey as well: by width, lightness, dashes and marks.
YARDSTICK: dict[str, Any] = {"color": "#86aed6", "linewidth": 3.4, "marker": "o", "zorder": 1.8}
WITHOUT: dict[str, Any] = {"color": "#6b6b6b", "linewidth": 1.2, "linestyle": (0, (4, 2))}
OTHERS: tuple[dict[str, Any], ...] = (
    {"color": "#b3261e", "linewidth": 1.1, "marker": "s"},
    {"color": "black", "linewidth": 1.2, "linestyle": (0, (6, 1.5, 1, 1.5)), "marker": "^"},
    {"color": "#2e7d32", "linewidth": 1.2, "linestyle": (0, (1.5, 1)), "marker": "D"},
    {"color": "#7b3fa0", "linewidth": 1.1, "linestyle": (0, (8, 2)), "marker": "v"},
    {"color": "#c77700", "linewidth": 1.4, "marker": "P"},
    {"color": "#00897b", "linewidth": 1.2, "linestyle": (0, (4, 1, 1, 1, 1, 1)), "marker": "X"},
    {"color": "#8d6e63", "linewidth": 1.4, "linestyle": (0, (3, 1)), "marker": "<"},
    {"color": "#c2187e", "linewidth": 1.2, "linestyle": (0, (2, 2)), "marker": ">"},
)
FRICTIONLESS = "viscous"

LEFT, LEFT_OF_BARS, GAP = 0.075, 0.115, 0.8
"""Where panels begin [-], and how far their rows are apart [inch]: each has its axis."""


def comparison(made: Comparison, folder: Path) -> None:
    """Write comparison.png: several approaches on the very same base motion.

    Parameters
    ----------
    made : Comparison
    folder : Path
        Where to write.
    """
    canvas.paint(lambda: draw(made), folder / "comparison.png")


def draw(made: Comparison) -> Figure:
    """Give the picture of a comparison, not yet rendered."""
    looks, view = styles(made), compared(made)
    known = any("T_a" in tally.extremes for tally in made.table.tallies.values())
    swept, bars = known and bool(view.key), known and not view.key
    left = LEFT_OF_BARS if bars else LEFT
    figure, grid = layout.sheet(1 + known * len(view.panels), 2, left=left, gap=GAP)
    above = figure.add_subplot(grid[0, 0] if made.of_laws else grid[0, :])
    _overlay(above, made, looks, named=not swept)
    if made.of_laws:
        _loops(figure.add_subplot(grid[0, 1]), made, looks)
    if swept:
        against.over_axis(figure, grid, made, view, looks)
    elif bars:
        against.as_bars(figure, grid, made, looks)
    layout.complete(figure, grid, heading.of_comparison(made, view.left_out))
    return figure


def styles(made: Comparison) -> Mapping[str, Style]:
    """Give every approach its style."""
    looks, rest = {made.yardstick: YARDSTICK}, 0
    for name in made.table.approaches:
        if name == FRICTIONLESS:
            looks.setdefault(name, WITHOUT)
        elif name not in looks:
            looks[name] = OTHERS[rest % len(OTHERS)]
            rest += 1
    return looks


def _overlay(axes: Axes, made: Comparison, looks: Mapping[str, Style], named: bool) -> None:
    """Draw the acceleration of all approaches over a stretch, what is rough at the bottom."""
    yardstick = made.responses[made.yardstick]
    first, last = moment.telling(yardstick, _rivals(made), _begin(made))
    held = panels.held(yardstick.law)
    for at, length in curves.stuck_stretches(yardstick, first, last):
        axes.axvspan(at, at + length, **panels.STUCK, label=f"{held} ({made.yardstick})")
    rough = sorted(
        made.responses, key=lambda name: -_roughness(made.responses[name], first, last)
    )
    for name in rough:
        shown = _stretch(made.responses[name], first, last)
        depth = (
            2.5 if name == made.yardstick else 2.2 if _is_rough(made, name, first, last) else 3
        )
        style = {**looks[name], "marker": "", "zorder": depth}
        axes.plot(shown.t, shown.x_dd, **style, label=name if named else "")
    where = spoken(made.shown, made.table.axes)
    ink.name(axes, f"acceleration of the mass ẍ [m/s²]{': ' if where else ''}{where}")
    axes.set_xlabel("time $t$ [s]")
    if last > first:
        axes.set_xlim(first, last)


def _loops(axes: Axes, made: Comparison, looks: Mapping[str, Style]) -> None:
    """Draw the friction force of every word around the stretch that is drawn beside it."""
    yardstick = made.responses[made.yardstick]
    first, last = moment.telling(yardstick, _rivals(made), _begin(made))
    first, last = moment.cycle(yardstick, first, last)
    stretches = {
        name: _stretch(response, first, last)
        for name, response in made.responses.items()
        if made.laws.get(name)
    }
    peaks = (float(np.abs(shown.x_r).max()) for shown in stretches.values())
    unit = wording.length_unit(max(peaks, default=0.0))
    for name, shown in stretches.items():
        axes.plot(shown.x_r * unit.per_metre, shown.F_f, **{**looks[name], "marker": ""})
    ink.name(axes, "friction force $F_f$ [N]")
    axes.set_xlabel(f"relative displacement $x_r$ [{unit.sign}]")


def _rivals(made: Comparison) -> Sequence[Response]:
    """Give the responses that are held against the yardstick's."""
    apart = (made.yardstick, FRICTIONLESS)
    asked = [response for name, response in made.responses.items() if name not in apart]
    return asked or [*made.responses.values()]


def _begin(made: Comparison) -> float:
    """Give the time from which on the motion counts [s]."""
    measure = made.table.scenario.measure
    return 0.0 if measure.steady else measure.settle


def _stretch(response: Response, first: float, last: float) -> Curve:
    """Give a stretch [s]; jumps of an exact response stand upright.

    Orbits of several approaches may repeat after different times, so each is drawn as often as
    the stretch asks for.
    """
    fixed, length = response.numerics.core == FIXED_STEP, moment.repetition(response)
    pieces = []
    for turn in range(int(first // length), int(last // length) + 1):
        passed = turn * length if turn else 0.0
        begin = max(int((first - passed) / response.dt) - 1, 0)
        part = slice(begin, min(int((last - passed) / response.dt) + 2, len(response)))
        piece = curves.grid(response, part) if fixed else curves.curve(response, part)
        pieces.append(piece._replace(t=piece.t + passed))
    return Curve(*map(np.concatenate, zip(*pieces, strict=True)))


def _roughness(response: Response, first: float, last: float) -> float:
    """Give how much an acceleration goes up and down in a stretch [m/s²]."""
    return float(np.abs(np.diff(_stretch(response, first, last).x_dd)).sum())


def _is_rough(made: Comparison, name: str, first: float, last: float) -> bool:
    """Whether a curve would hide the yardstick."""
    own = _roughness(made.responses[made.yardstick], first, last)
    return _roughness(made.responses[name], first, last) > 2 * own
