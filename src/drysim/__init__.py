"""Vibration isolation with viscous and dry-friction damping, solved without a time-step error.

The public names are imported on first access, so that `import drysim` stays fast.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def lazy_getattr(package: str, modules: Mapping[str, str]) -> Callable[[str], Any]:
    """Return the `__getattr__` (PEP 562) of a package whose names are imported on first access.

    Parameters
    ----------
    package : str
        Its `__name__`.
    modules : mapping
        Module name to the names it defines, separated by blanks.

    Returns
    -------
    callable
        Imports the module that defines a name and stores the object in the package.
    """
    module_of = {name: module for module, names in modules.items() for name in names.split()}

    def load(name: str) -> Any:
        if name not in module_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        from drysim.interrupt import deferred_interrupt

        with deferred_interrupt():
            value = getattr(import_module(module_of[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    return load


__version__ = "0.1.0"

__all__ = [
    "AssessResult",
    "BranchesResult",
    "Comparison",
    "DesignResult",
    "DrysimError",
    "Ensemble",
    "FitResult",
    "Outcome",
    "OutputError",
    "RecordError",
    "RegimeMap",
    "Scenario",
    "ScenarioError",
    "SolverError",
    "Table",
    "UsageError",
    "__version__",
    "assess",
    "branches",
    "compare",
    "design",
    "explain",
    "fit",
    "load",
    "map_regimes",
    "plot",
    "report",
    "run",
    "scenario",
    "simulate",
    "sweep",
    "validate",
]

# `save`, `to_frame` and `to_html` are for the methods of results, whose layer is below theirs.
__getattr__ = lazy_getattr(
    __name__,
    {
        "drysim.approach.simulate": "simulate",
        "drysim.errors": (
            "DrysimError OutputError RecordError ScenarioError SolverError UsageError"
        ),
        "drysim.console.pages": "explain",
        "drysim.output": "save",
        "drysim.output.report": "report",
        "drysim.results.frames": "to_frame",
        "drysim.results.notebook": "to_html",
        "drysim.results.pictures": "plot",
        "drysim.scenario": "Scenario load scenario",
        "drysim.study.assess": "AssessResult assess",
        "drysim.study.branches": "BranchesResult branches",
        "drysim.study.compare": "Comparison compare",
        "drysim.study.design": "DesignResult design",
        "drysim.study.ensemble": "Ensemble run",
        "drysim.study.fit": "FitResult fit",
        "drysim.study.outcome": "Outcome",
        "drysim.study.regimes": "RegimeMap map_regimes",
        "drysim.study.sweep": "sweep",
        "drysim.study.table": "Table",
        "drysim.study.validate": "validate",
    },
)


def __dir__() -> list[str]:
    """Return the public names, imported or not."""
    return sorted(__all__)
