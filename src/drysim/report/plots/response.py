"""The picture of a response: the motion over time and the friction loop."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from drysim import wording
from drysim.report.plots import canvas, curves, heading, layout, panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec

    from drysim.study.outcome import Outcome
    from drysim.wording import LengthUnit

LONG = 20_000
"""Grid points above which the whole response is drawn as bands."""

BUSY = 60
"""Events above which a zoomed view stands below the whole response."""

FAR, NEAR = 3.0, 1.3
"""How many times the peak a stroke limit may be away to be drawn, in all and when zoomed."""


def response(outcome: Outcome, folder: Path) -> None:
    """Write response.png: the motion over time and the friction loop.

    Parameters
    ----------
    outcome : Outcome
    folder : Path
        Where to write.
    """
    canvas.paint(lambda: draw(outcome), folder / "response.png")


def draw(outcome: Outcome) -> Figure:
    """Give the picture of a response, not yet rendered."""
    motion = outcome.response
    zoomed = len(motion) > LONG or len(motion.events) > BUSY
    body, arrange = (8.05, _zoomed) if zoomed else (5.15, _whole)
    head = heading.lines(outcome)
    figure = canvas.blank(body + heading.height(head))
    heading.write(figure, head)
    arrange(figure, outcome)
    known = layout.entries(figure.axes[-3:] + figure.axes[:-3])
    layout.legend(figure, known, columns=7, length=1.8)
    return figure


def _whole(figure: Figure, outcome: Outcome) -> None:
    """Draw all of a short response, the loop as large as the rest."""
    _stretch(figure, _grid(figure, 0.9, 4.9, 2), slice(None), outcome, FAR)


def _zoomed(figure: Figure, outcome: Outcome) -> None:
    """Draw a long response as it goes, and a stretch of it so that it can be read."""
    motion, stroke = outcome.response, outcome.scenario.stroke
    part, unit = curves.zoom(motion, _settle(outcome)), _unit(outcome)
    ends = curves.ends(motion, slice(None))
    above, below = panels.pair(figure, _grid(figure, 5.05, 7.8, 1), *ends, unit)
    if len(motion) > 2 * curves.BINS:
        panels.bands(above, below, motion, unit)
    else:
        panels.lines(above, below, curves.curve(motion, slice(None)), unit)
    if stroke:
        panels.stroke(below, motion, stroke.limit, FAR, unit)
    panels.settled(above, below, _settle(outcome))
    panels.frame(above, below, *curves.ends(motion, part))
    _stretch(figure, _grid(figure, 0.9, 4.15, 2), part, outcome, NEAR)
    figure.axes[-2].set_xlabel("time $t$ [s], framed stretch")


def _stretch(figure: Figure, grid: GridSpec, part: slice, outcome: Outcome, far: float) -> None:
    """Draw a stretch of the response: its curves, what sticks, its friction loop."""
    motion, stroke, unit = outcome.response, outcome.scenario.stroke, _unit(outcome)
    shown, (begin, end) = curves.curve(motion, part), curves.ends(motion, part)
    above, below = panels.pair(figure, grid, begin, end, unit)
    panels.lines(above, below, shown, unit)
    panels.stuck(above, below, part, motion)
    if stroke:
        panels.stroke(below, motion, stroke.limit, far, unit)
    if begin < _settle(outcome) < end:
        panels.settled(above, below, _settle(outcome))
    panels.loop(figure.add_subplot(grid[:, 1]), shown, motion, unit)


def _unit(outcome: Outcome) -> LengthUnit:
    """Give the unit in which x_r is drawn: that in which its peak is told."""
    return wording.length_unit(outcome.metrics["x_r_peak"] or 0.0)


def _settle(outcome: Outcome) -> float:
    """Give the time before the window of the metrics [s]; a steady orbit has none."""
    steady = outcome.response.numerics.period_multiple is not None
    return 0.0 if steady else outcome.scenario.measure.settle


def _grid(figure: Figure, bottom: float, top: float, columns: int) -> GridSpec:
    """Give room for two rows of panels between two heights [inch]."""
    height = figure.get_figheight()
    return figure.add_gridspec(
        2, columns, width_ratios=(1.5, 1)[:columns], wspace=0.17, hspace=0.26,
        left=0.08, right=0.98, bottom=bottom / height, top=top / height,
    )  # fmt: skip
