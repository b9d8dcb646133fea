"""Vibration isolation with viscous and dry-friction damping, solved without a time-step error.

The public names are loaded when first asked for, so that importing drysim stays light.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from drysim.late import late

if TYPE_CHECKING:
    from drysim.approach.simulate import simulate
    from drysim.errors import (
        DrysimError,
        OutputError,
        RecordError,
        ScenarioError,
        SolverError,
        UsageError,
    )
    from drysim.scenario import Scenario, load
    from drysim.study.comparisons.compare import compare
    from drysim.study.comparisons.comparison import Comparison
    from drysim.study.ensembles.ensemble import Ensemble
    from drysim.study.outcome import Outcome
    from drysim.study.run import run
    from drysim.study.sweeps.sweep import sweep
    from drysim.study.sweeps.table import Table

__version__ = "0.1.0"

__all__ = [
    "Comparison",
    "DrysimError",
    "Ensemble",
    "Outcome",
    "OutputError",
    "RecordError",
    "Scenario",
    "ScenarioError",
    "SolverError",
    "Table",
    "UsageError",
    "__version__",
    "compare",
    "load",
    "run",
    "simulate",
    "sweep",
]

__getattr__ = late(
    __name__,
    {
        "drysim.approach.simulate": "simulate",
        "drysim.errors": (
            "DrysimError OutputError RecordError ScenarioError SolverError UsageError"
        ),
        "drysim.scenario": "Scenario load",
        "drysim.study.comparisons.compare": "compare",
        "drysim.study.comparisons.comparison": "Comparison",
        "drysim.study.ensembles.ensemble": "Ensemble",
        "drysim.study.outcome": "Outcome",
        "drysim.study.run": "run",
        "drysim.study.sweeps.sweep": "sweep",
        "drysim.study.sweeps.table": "Table",
    },
)


def __dir__() -> list[str]:
    """Give the public names, loaded or not."""
    return sorted({*globals(), *__all__})
