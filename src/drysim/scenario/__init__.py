"""Scenarios: `load` reads a file, `scenario_warnings` checks it, `schema` describes it."""

from __future__ import annotations

from typing import Any

from drysim.scenario.axes import Axis as Axis
from drysim.scenario.load import load as load
from drysim.scenario.model import Scenario as Scenario
from drysim.scenario.model import scene_period as scene_period
from drysim.scenario.warnings import scenario_warnings as scenario_warnings


def schema() -> dict[str, Any]:
    """Return the JSON schema of scenario files (draft 2020-12), with units in descriptions."""
    from drysim.scenario.json_schema import scenario_schema

    return scenario_schema()
