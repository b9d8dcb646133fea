"""What a scenario file may say: words, checked, and crossed to symbols.

`loading` leads from a file to a Scenario: `reading` holds its keys against those of the model,
`sweep.words` makes axes of the sweep block, the blocks check their values, and `rules` what the
blocks say together. A Scenario gives its cases (`sweep.points`), and itself under another
approach (`others`) or another friction law (`under_law`).
"""

from __future__ import annotations

from typing import Any

from drysim.scenario.cautions import cautions as cautions
from drysim.scenario.loading import load as load
from drysim.scenario.measure import period as period
from drysim.scenario.model import Scenario as Scenario
from drysim.scenario.sweep.axis import Axis as Axis


def schema() -> dict[str, Any]:
    """Give the JSON schema of scenario files (draft 2020-12); descriptions hold the units."""
    from drysim.scenario.json_schema import describe

    return describe()
