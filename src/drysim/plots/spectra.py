"""spectra.png: PSD of base and mass, transmissibility H1 and its coherence.

H1 and coherence are drawn only where the base moves: elsewhere they are ratios of leaks.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drysim import wording
from drysim.metrics.spectra import Spectra, viscous_transmissibility
from drysim.plots import style, sweep
from drysim.plots.response import BASE, FEW, of_mass
from drysim.plots.style import Style
from drysim.study.outcome import Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POWER = 1e-3
"""Where the PSD of the base is below this share of its peak, H1 is the ratio of two leaks."""

DECADES = 1e-6
"""How far below its peak a PSD is drawn."""

VISCOUS: Style = {"color": "#444444", "linewidth": 1.2, "linestyle": (0, (5, 2))}


def spectra(outcome: Outcome, folder: Path) -> None:
    """Write spectra.png, but only when spectra were asked for."""
    if outcome.spectra is not None:
        style.paint(lambda: draw(outcome), folder / "spectra.png")


def draw(outcome: Outcome) -> Figure:
    """Give the picture of the spectra of an outcome, not yet rendered."""
    found = outcome.spectra
    assert found is not None, "only what was asked for is drawn"
    strong = _strong(found.G_u)
    figure, grid = style.sheet(2, 2)
    _densities(figure.add_subplot(grid[:, 0]), found)
    above, below = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    _transmissibility(above, found, strong, outcome)
    _coherence(below, found, strong)
    for axes in figure.axes:
        axes.set_xscale("log")
        if axes is above:
            axes.tick_params(labelbottom=False)
        else:
            axes.set_xlabel("frequency $f$ [Hz]")
        if strong.any():
            low, high = found.f[0], 2.0 * found.f[strong][-1]
            axes.set_xlim(low, high)
            sweep.decades(axes.xaxis, low, high)
    title, words, symbols = style.lines(outcome)
    averages = wording.several(found.segments, "segment")
    how = f"Welch, {averages} of {found.segment:.3g} s, Hann, half overlapping"
    cut = f"; H1 where the base has {wording.percent(POWER)} of its peak PSD and more"
    told = f"spectra: {how}{'' if strong.all() else cut}"
    style.complete(figure, grid, (title, [*words, told], symbols))
    return figure


def _strong(G_u: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell the lines where the base moves, and at both neighbours too: a Hann window leaks."""
    strong: NDArray[np.bool_] = G_u > POWER * G_u.max(initial=0.0)
    inside = strong.copy()
    inside[1:] &= strong[:-1]
    inside[:-1] &= strong[1:]
    return inside


def _densities(axes: Axes, found: Spectra) -> None:
    """Draw the PSD of base and mass."""
    axes.set_title("PSD of acceleration [(m/s²)²/Hz]", loc="left")
    axes.plot(found.f, found.G_x, **of_mass(found.G_x), label="mass ẍ")
    axes.plot(found.f, found.G_u, **BASE, label="base ü")
    peak = max(found.G_u.max(initial=0.0), found.G_x.max(initial=0.0))
    if peak > 0:
        axes.set_yscale("log")
        axes.set_ylim(DECADES * peak, 3.0 * peak)


def _transmissibility(
    axes: Axes, found: Spectra, strong: NDArray[np.bool_], outcome: Outcome
) -> None:
    """Draw H1 where the base moves, and T_a without friction."""
    axes.set_title("transmissibility H1 [–]", loc="left")
    H1 = np.where(strong, np.abs(found.H1), np.nan)
    mark = "." if np.count_nonzero(strong) < FEW else ""
    axes.plot(found.f, H1, **of_mass(H1), marker=mark, label="H1")
    viscous = viscous_transmissibility(outcome.response.plant, found.f)
    axes.plot(found.f, viscous, **VISCOUS, label="$T_a$ without friction")
    axes.set_yscale("log")
    shown = viscous[strong & np.isfinite(viscous) & (viscous > 0)]
    values = np.concatenate((shown, H1[strong & np.isfinite(H1)], [1.0]))
    values = values[values > 0]
    low, high = 0.5 * max(values.min(), 1e-3), 2.0 * values.max()
    axes.set_ylim(low, high)
    sweep.decades(axes.yaxis, low, high)


def _coherence(axes: Axes, found: Spectra, strong: NDArray[np.bool_]) -> None:
    """Draw the coherence where the base moves."""
    axes.set_title("coherence [–]", loc="left")
    mark = "." if np.count_nonzero(strong) < FEW else ""
    coherence = np.where(strong, found.coherence, np.nan)
    axes.plot(found.f, coherence, **of_mass(coherence), marker=mark)
    axes.set_ylim(0.0, 1.0)
