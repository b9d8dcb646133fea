"""The picture of the transmissibilities of a sweep."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from drysim.report.plots import canvas, ink, many
from drysim.report.plots.over_sweep import over_sweep
from drysim.report.plots.shown import T_A, T_X
from drysim.report.plots.views import view

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from drysim.report.plots.shown import Shown
    from drysim.report.plots.views import Panel
    from drysim.study.sweeps.table import Table


def transmissibility(table: Table, folder: Path) -> None:
    """Write transmissibility.png: T_x on the left, T_a on the right, as in the paper.

    Parameters
    ----------
    table : Table
    folder : Path
        Where to write.
    """
    canvas.paint(lambda: draw(table), folder / "transmissibility.png")


def draw(table: Table) -> Figure:
    """Give the picture of the transmissibilities, not yet rendered."""
    if many.scattered(table):
        return many.draw(table, [T_X, T_A])
    drawn = view(table)
    known = [one for one in (T_X, T_A) if any(True for _ in ink.known(drawn, one.of))] or [T_A]

    def unity(axes: Axes, panel: Panel, quantity: Shown) -> None:
        axes.axhline(1.0, **ink.UNITY)

    return over_sweep(table, drawn, known, unity)
