"""Pictures; each function takes a result and returns a figure of matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from drysim.study.branches import BranchesResult
    from drysim.study.compare import Comparison
    from drysim.study.design import DesignResult
    from drysim.study.ensemble import Ensemble
    from drysim.study.fit import FitResult
    from drysim.study.outcome import Outcome
    from drysim.study.regimes import RegimeMap
    from drysim.study.table import Table


def plot(
    result: (
        Outcome
        | Ensemble
        | Table
        | Comparison
        | FitResult
        | DesignResult
        | BranchesResult
        | RegimeMap
    ),
) -> Figure:
    """Return the main picture of a result as a figure of matplotlib.

    Parameters
    ----------
    result : object
        What `run`, `sweep`, `compare`, `fit`, `design`, `branches` or `map_regimes` returned.

    Returns
    -------
    matplotlib.figure.Figure
        As the commands write it: the motion of a run, distributions over seeds,
        transmissibilities of a sweep, approaches side by side, measured and fitted motion,
        the objective of designs, branches of periodic motions, or regimes over two keys.
        `figure.savefig` writes it.
    """
    from drysim.plots import (
        branches,
        comparison,
        design,
        ensemble,
        fit,
        regimes,
        response,
        style,
        sweep,
    )
    from drysim.study.branches import BranchesResult
    from drysim.study.compare import Comparison
    from drysim.study.design import DesignResult
    from drysim.study.ensemble import Ensemble
    from drysim.study.fit import FitResult
    from drysim.study.regimes import RegimeMap
    from drysim.study.table import Table

    style.import_matplotlib()
    style.register_with_notebook()
    with style.picture_style():
        if isinstance(result, BranchesResult):
            return branches.draw(result)
        if isinstance(result, Comparison):
            return comparison.draw(result)
        if isinstance(result, DesignResult):
            return design.draw(result)
        if isinstance(result, RegimeMap):
            return regimes.draw(result)
        if isinstance(result, FitResult):
            return fit.draw_fit(result)
        if isinstance(result, Ensemble):
            return ensemble.draw(result)
        if isinstance(result, Table):
            return sweep.draw_transmissibility(result)
        return response.draw(result)
