"""Scenarios: `load` reads a file, `scenario_warnings` checks it, `schema` describes it.

The package itself can be called: `drysim.scenario({...})`, as `load.scenario`.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from types import ModuleType
from typing import TYPE_CHECKING, Any

from drysim.scenario.axes import Axis as Axis
from drysim.scenario.load import load as load
from drysim.scenario.load import scenario as make_scenario
from drysim.scenario.model import Scenario as Scenario
from drysim.scenario.model import scene_period as scene_period
from drysim.scenario.warnings import scenario_warnings as scenario_warnings

if TYPE_CHECKING:
    from drysim.yaml_document import Overrides


class _CallablePackage(ModuleType):
    """The package as a function; a function of its name would hide it once it is imported."""

    def __call__(
        self, source: Mapping[str, object] | str, overrides: Overrides = ()
    ) -> Scenario:
        """Make a scenario from a mapping, or from YAML text; see `load.scenario`."""
        return make_scenario(source, overrides)


scenario = sys.modules[__name__]
scenario.__class__ = _CallablePackage


def schema() -> dict[str, Any]:
    """Return the JSON schema of scenario files (draft 2020-12), with units in descriptions."""
    from drysim.scenario.json_schema import scenario_schema

    return scenario_schema()
