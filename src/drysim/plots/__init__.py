"""Pictures; each function takes a result and returns a figure of matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drysim.study.branches import BranchesResult
from drysim.study.compare import Comparison
from drysim.study.design import DesignResult
from drysim.study.ensemble import Ensemble
from drysim.study.fit import FitResult
from drysim.study.outcome import Outcome
from drysim.study.table import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot(
    result: Outcome | Ensemble | Table | Comparison | FitResult | DesignResult | BranchesResult,
) -> Figure:
    """Return the main picture of a result as a figure of matplotlib.

    Parameters
    ----------
    result : Outcome, Ensemble, Table, Comparison, FitResult, DesignResult or BranchesResult
        Of `run`, `sweep`, `compare`, `fit`, `design` or `branches`.

    Returns
    -------
    matplotlib.figure.Figure
        As the commands write it: the motion of a run, distributions over seeds,
        transmissibilities of a sweep, approaches side by side, measured and fitted motion,
        the objective of designs, or branches of periodic motions.
        `figure.savefig` writes it.
    """
    from drysim.plots import branches, comparison, design, ensemble, fit, response, style, sweep

    with style.picture_style():
        if isinstance(result, BranchesResult):
            return branches.draw(result)
        if isinstance(result, Comparison):
            return comparison.draw(result)
        if isinstance(result, DesignResult):
            return design.draw(result)
        if isinstance(result, FitResult):
            return fit.draw_fit(result)
        if isinstance(result, Ensemble):
            return ensemble.draw(result)
        if isinstance(result, Table):
            return sweep.draw_transmissibility(result)
        return response.draw(result)
