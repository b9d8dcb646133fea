"""The canvas: Figure objects only, never pyplot, so that two pictures share nothing."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, DOTS = 9.0, 150
"""Width of a picture [inch] and dots per inch; all heights are inches from its foot."""

STYLE: dict[str, Any] = {
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


def paint(draw: Callable[[], Figure], file: Path) -> None:
    """Draw a picture in the style of drysim and write it as PNG.

    Parameters
    ----------
    draw : callable
        Gives the picture, not yet rendered.
    file : Path
    """
    # That its cache has no home is nothing to tell anybody.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    # Nobody's own matplotlibrc changes the picture.
    style: Any = dict(matplotlib.rcParamsDefault)
    style.update(STYLE)
    del style["backend"]
    with matplotlib.rc_context(style), warnings.catch_warnings():
        # A sign that the font lacks is drawn as a box; that is all there is to say.
        warnings.filterwarnings("ignore", message="Glyph", category=UserWarning)
        canvas: Any = FigureCanvasAgg(draw())
        # The version of matplotlib would change the file where the picture is the same.
        canvas.print_png(str(file), metadata={"Software": None})


def blank(height: float) -> Figure:
    """Give an empty picture of a height [inch]."""
    from matplotlib.figure import Figure

    return Figure(figsize=(WIDTH, height), dpi=DOTS)
