"""What makes two pieces of work one, so that one may go on with what another has left."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import drysim
from drysim.core.compiled import source_digest
from drysim.errors import UsageError
from drysim.study.hashes import hashes_of

if TYPE_CHECKING:
    from drysim.scenario import Scenario


def identity(scenario: Scenario) -> dict[str, Any]:
    """Give what makes it one: all words of the scenario, its files, and drysim."""
    words = json.dumps(scenario.resolved(), sort_keys=True)
    digest = hashlib.sha256(words.encode()).hexdigest()
    own = {"drysim": drysim.__version__, "core": source_digest()}
    return own | {"scenario": digest, "files": hashes_of(scenario)}


def of_another(folder: Path) -> UsageError:
    """Give the error for finished cases that are none of this sweep."""
    return UsageError(
        f"{folder} holds cases of another sweep, another record or another drysim",
        "run the command without --resume to begin anew",
    )
