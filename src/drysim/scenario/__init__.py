"""Scenarios: `load` reads one from its file, `cautions` warns of it, `schema` tells editors."""

from __future__ import annotations

from typing import Any

from drysim.scenario.axes import Axis as Axis
from drysim.scenario.load import load as load
from drysim.scenario.model import Scenario as Scenario
from drysim.scenario.model import period as period
from drysim.scenario.warnings import cautions as cautions


def schema() -> dict[str, Any]:
    """Give the JSON schema of scenario files (draft 2020-12); descriptions hold the units."""
    from drysim.scenario.json_schema import describe

    return describe()
