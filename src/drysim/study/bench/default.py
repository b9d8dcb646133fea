"""What a bench takes where no scenario is named: the paper's oscillator, twice."""

from __future__ import annotations

from collections.abc import Sequence

from drysim.scenario import Scenario, load
from drysim.study import gallery

GALLERY = (
    ("paper-high-friction", ("excitation.frequency=2", "excitation.rms=0.75")),
    ("paper-random", ("friction.static_ratio=1.2", "excitation.rms=0.67")),
)
"""Scenarios of the gallery, and what is changed in them: a sine at which the mass sticks twice
a period, and noise under 45 N that is 54 N at rest."""


def scenarios(file: str | None, changes: Sequence[str]) -> list[Scenario]:
    """Give the scenarios to bench: the one named, else those of the gallery.

    Raises
    ------
    ScenarioError
        With every problem of a file.
    """
    if file is not None:
        return [load(file, list(changes))]
    return [load(gallery.find(name).file, [*own, *changes]) for name, own in GALLERY]
