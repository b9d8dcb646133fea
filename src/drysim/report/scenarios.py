"""The resolved scenario beside every result: defaults spelled out, it runs again as it is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from drysim.report.claim import SCENARIO
from drysim.source import dump

if TYPE_CHECKING:
    from drysim.scenario import Scenario
    from drysim.study.bench.scores import Bench
    from drysim.study.comparisons.comparison import Comparison
    from drysim.study.ensembles.ensemble import Ensemble
    from drysim.study.outcome import Outcome
    from drysim.study.sweeps.table import Table


def own(made: Outcome | Ensemble | Table, folder: Path) -> None:
    """Write scenario.yaml.

    Parameters
    ----------
    made : Outcome or Ensemble or Table
    folder : Path
        Where to write.
    """
    _write(made.scenario, folder, SCENARIO)


def compared(made: Comparison, folder: Path) -> None:
    """Write scenario.yaml: what all approaches share."""
    _write(made.table.scenario, folder, SCENARIO)


def benched(made: Bench, folder: Path) -> None:
    """Write scenario.yaml; of several scenes each under its own name."""
    alone = len(made.panels) == 1
    for panel in made.panels:
        _write(panel.scenario, folder, SCENARIO if alone else f"{panel.scenario.name}.yaml")


def _write(scenario: Scenario, folder: Path, name: str) -> None:
    """Write a scenario as plain words."""
    words = dump(scenario.resolved(relative_to=folder))
    (folder / name).write_text(words, encoding="utf-8", newline="\n")
