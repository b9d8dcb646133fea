"""Plot spectra.png (PSD of base and mass, H1, coherence) and bands.png (third octaves).

H1 and coherence are drawn only at frequencies where the base has significant power. Elsewhere
they are ratios of spectral leakage.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drysim import wording
from drysim.metrics.spectra import (
    BANDS,
    MIN_POWER_SHARE,
    Spectra,
    TransferEstimate,
    excited_lines,
    viscous_transmissibility,
)
from drysim.plots import style
from drysim.plots.response import BASE_STYLE, MARKED_POINTS, mass_style
from drysim.plots.style import Style, set_title
from drysim.study.outcome import Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PSD_RANGE = 1e-6
"""Lower end of the PSD axis over the peak [-]."""

BASE_BAR_STYLE: Style = {"color": "#c9c9c9", "edgecolor": "#9d9d9d", "linewidth": 0.6}
MASS_BAR_STYLE: Style = {"color": "#0b3c6f"}
VISCOUS_STYLE: Style = {"color": "#444444", "linewidth": 1.2, "linestyle": (0, (5, 2))}


def draw_bands(outcome: Outcome, ax: Axes | None = None) -> Figure | None:
    """Return the figure of the RMS values in bands, None if they were not requested."""
    bands = None if outcome.spectra is None else outcome.spectra.bands
    if bands is None:
        return None
    weights = outcome.scenario.measure.weights
    pairs = [("RMS acceleration", bands.a_u, bands.a_x)]
    if weights is not None and bands.a_wu is not None and bands.a_w is not None:
        pairs.append((f"weighted {weights[0]}, k {weights[1]:g}", bands.a_wu, bands.a_w))
    figure, grid = style.panel_grid(1, len(pairs), ax=ax)
    numbers, axes = np.arange(len(BANDS)), None
    for i, (what, base, mass) in enumerate(pairs):
        axes = ax or figure.add_subplot(grid[0, i], sharey=axes)
        set_title(axes, f"{what} in one-third octaves [m/s²]")
        axes.bar(numbers, np.nan_to_num(base), width=0.9, **BASE_BAR_STYLE, label="base ü")
        axes.bar(numbers, np.nan_to_num(mass), width=0.5, **MASS_BAR_STYLE, label="mass ẍ")
        axes.set_xticks(numbers[::3], [f"{f:g}" for f in BANDS[::3]])
        axes.set_xlabel("centre frequency [Hz]")
        axes.grid(visible=False, axis="x")
    style.finish_figure(figure, style.response_heading(outcome), ax=ax)
    return figure


def draw(outcome: Outcome) -> Figure | None:
    """Return the figure of the spectra of an outcome, None if they were not requested."""
    spectra = outcome.spectra
    if spectra is None:
        return None
    excited = excited_lines(spectra.G_u)
    figure, grid = style.panel_grid(2, 2)
    draw_psd(figure.add_subplot(grid[:, 0]), spectra)
    above, below = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    _draw_transmissibility(above, spectra, excited, outcome)
    _draw_coherence(below, spectra, excited)
    for axes in figure.axes:
        axes.set_xscale("log")
        if axes is above:
            axes.tick_params(labelbottom=False)
        else:
            axes.set_xlabel("frequency [Hz]")
        if excited.any():
            low, high = spectra.f[0], 2.0 * spectra.f[excited][-1]
            axes.set_xlim(low, high)
        style.set_ticks(axes.xaxis)
    heading = style.response_heading(outcome)
    averages = wording.format_count(spectra.segments, "segment")
    method = f"Welch, {averages} of {spectra.segment:.3g} s, Hann, 50 % overlap"
    least = wording.format_percent(MIN_POWER_SHARE)
    cut = f"; H1 where the base PSD is at least {least} of its peak"
    caption = f"spectra: {method}{'' if excited.all() else cut}"
    style.finish_figure(figure, heading._replace(lines=(heading.lines[0], caption)))
    return figure


def draw_psd(axes: Axes, spectra: Spectra | TransferEstimate) -> None:
    """Draw the PSD of base and mass."""
    set_title(axes, "PSD of acceleration [(m/s²)²/Hz]")
    axes.plot(spectra.f, spectra.G_x, **mass_style(spectra.G_x), label="mass ẍ")
    axes.plot(spectra.f, spectra.G_u, **BASE_STYLE, label="base ü")
    peak = max(spectra.G_u.max(initial=0.0), spectra.G_x.max(initial=0.0))
    if peak > 0:
        axes.set_yscale("log")
        axes.set_ylim(PSD_RANGE * peak, 3.0 * peak)
        style.label_decades(axes.yaxis)


def _draw_transmissibility(
    axes: Axes, spectra: Spectra, excited: NDArray[np.bool_], outcome: Outcome
) -> None:
    """Draw H1 at the excited lines, and T_a of the frictionless oscillator."""
    set_title(axes, "transmissibility H1 [–]")
    H1 = np.where(excited, np.abs(spectra.H1), np.nan)
    mark = "." if np.count_nonzero(excited) < MARKED_POINTS else ""
    axes.plot(spectra.f, H1, **mass_style(H1), marker=mark, label="H1")
    viscous = viscous_transmissibility(outcome.response.plant, spectra.f)
    axes.plot(spectra.f, viscous, **VISCOUS_STYLE, label="Tₐ without friction")
    axes.set_yscale("log")
    shown = viscous[excited & np.isfinite(viscous) & (viscous > 0)]
    values = np.concatenate((shown, H1[excited & np.isfinite(H1)], [1.0]))
    values = values[values > 0]
    low, high = 0.5 * max(values.min(), 1e-3), 2.0 * values.max()
    axes.set_ylim(low, high)
    style.set_ticks(axes.yaxis)


def _draw_coherence(axes: Axes, spectra: Spectra, excited: NDArray[np.bool_]) -> None:
    """Draw the coherence at the excited lines."""
    set_title(axes, "coherence [–]")
    mark = "." if np.count_nonzero(excited) < MARKED_POINTS else ""
    coherence = np.where(excited, spectra.coherence, np.nan)
    axes.plot(spectra.f, coherence, **mass_style(coherence), marker=mark)
    axes.set_ylim(0.0, 1.0)
