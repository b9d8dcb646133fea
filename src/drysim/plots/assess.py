"""Plot assess.png: measured spectra, transmissibility with its band, and coherence.

Transmissibility and coherence are drawn only where the base has significant power. Elsewhere
they are ratios of spectral leakage.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import Floats
from drysim.metrics.spectra import MIN_POWER_SHARE, TransferEstimate, excited_lines
from drysim.metrics.table import PEAK_STROKE
from drysim.metrics.text import format_labelled
from drysim.plots import style
from drysim.plots.response import BASE_STYLE, MASS_STYLE
from drysim.plots.spectra import draw_psd
from drysim.plots.style import Style, set_title
from drysim.study.assess import AssessResult, band_of_coherence, band_of_H1
from drysim.wording import format_count, format_number, format_percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BAND_STYLE: Style = {"color": "#bcd0e6", "linewidth": 0.0}
H2_STYLE: Style = {"color": "#c77b1f", "linewidth": 1.0, "linestyle": (0, (4, 1.5))}
HV_STYLE: Style = {"color": "#5b8c5a", "linewidth": 1.0, "linestyle": (0, (1, 1.2))}
MODEL_STYLE: Style = {"color": "black", "linewidth": 1.2, "linestyle": (0, (6, 2))}
RUN_STYLE: Style = {**BASE_STYLE, "linewidth": 0.6}

LEAST_SHARE = 0.03
"""Lower end of the transmissibility over its peak: at a lower coherence it is noise."""

Mask = NDArray[np.bool_]


def draw(result: AssessResult) -> Figure:
    """Return the figure of an evaluation."""
    transfer = result.transfer
    excited = excited_lines(transfer.G_u)
    figure, grid = style.panel_grid(1, 3)
    left, middle, right = (figure.add_subplot(grid[0, i]) for i in range(3))
    draw_psd(left, transfer)
    draw_transmissibility(middle, result, transfer, excited)
    draw_coherence(right, transfer, excited)
    for axes in figure.axes:
        axes.set_xscale("log")
        axes.set_xlabel("frequency [Hz]")
        if excited.any():
            axes.set_xlim(transfer.f[0], 2.0 * transfer.f[excited][-1])
        style.set_ticks(axes.xaxis)
    style.finish_figure(figure, heading(result))
    return figure


def heading(result: AssessResult) -> style.Heading:
    """Return the heading: the main numbers, then how the spectra were estimated."""
    metrics, transfer = result.metrics, result.transfer
    names = ("SEAT", "a_w", "VDV", "T_a", PEAK_STROKE, "A_8")
    numbers = [
        format_labelled(name, metrics[name]) for name in names if metrics[name] is not None
    ]
    runs = f"{format_count(len(result.runs), 'run')}: " * (len(result.runs) > 1)
    least = format_percent(MIN_POWER_SHARE)
    spectra = (
        f"Welch, {format_count(transfer.segments, 'segment')} of "
        f"{format_number(transfer.segment, 's', 3)}; H where the base PSD is at least {least} "
        "of its peak"
    )
    return style.make_heading(result.scenario, runs + ", ".join(numbers), "", spectra)


def draw_transmissibility(
    axes: Axes, result: AssessResult, transfer: TransferEstimate, excited: Mask
) -> None:
    """Draw H1 with its band, H2 and Hv, each run, and the model."""
    set_title(axes, "transmissibility |H| [–]")

    def shown(H: NDArray[np.complexfloating]) -> Floats:
        size: Floats = np.where(excited, np.abs(H), np.nan)
        return size

    low, high = (np.where(excited, end, np.nan) for end in band_of_H1(transfer))
    axes.fill_between(transfer.f, low, high, **BAND_STYLE, label="95 % band of H1")
    for run in result.runs if len(result.runs) > 1 else ():
        if run.transfer is not None:
            axes.plot(transfer.f, shown(run.transfer.H1), **RUN_STYLE, label="H1 of each run")
    axes.plot(transfer.f, shown(transfer.H2), **H2_STYLE, label="H2")
    axes.plot(transfer.f, shown(transfer.Hv), **HV_STYLE, label="Hv")
    axes.plot(transfer.f, shown(transfer.H1), **MASS_STYLE, label="H1")
    if (model := result.model_H1) is not None:
        axes.plot(transfer.f, shown(model), **MODEL_STYLE, label="H1 of the model")
    axes.axhline(1.0, color="#8a8a8a", linewidth=0.8)
    axes.set_yscale("log")
    size = shown(transfer.H1)[excited]
    if len(size) and size.min() > 0.0:
        least = max(size.min(), LEAST_SHARE * size.max())
        axes.set_ylim(0.6 * min(least, 1.0), 1.6 * max(size.max(), 1.0))
    style.set_ticks(axes.yaxis)


def draw_coherence(axes: Axes, transfer: TransferEstimate, excited: Mask) -> None:
    """Draw the coherence with its band."""
    set_title(axes, "coherence [–]")
    low, high = (np.where(excited, end, np.nan) for end in band_of_coherence(transfer))
    axes.fill_between(transfer.f, low, high, **BAND_STYLE, label="95 % band of the coherence")
    axes.plot(transfer.f, np.where(excited, transfer.coherence, np.nan), **MASS_STYLE)
    axes.set_ylim(0.0, 1.02)
