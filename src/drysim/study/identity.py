"""What makes two pieces of work one, so that one may go on with what another has left."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import drysim
from drysim.core.compiled import source_digest
from drysim.errors import OutputError, UsageError
from drysim.study.hashes import hashes_of

if TYPE_CHECKING:
    from drysim.scenario import Scenario


def identity(scenario: Scenario) -> dict[str, Any]:
    """Give what makes it one: all words of the scenario, its files, and drysim."""
    words = json.dumps(scenario.resolved(), sort_keys=True)
    digest = hashlib.sha256(words.encode()).hexdigest()
    own = {"drysim": drysim.__version__, "core": source_digest()}
    return own | {"scenario": digest, "files": hashes_of(scenario)}


def digest_of(what: Mapping[str, Any]) -> str:
    """Return what makes it one in short (hex): each finished part of the work bears it."""
    return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:32]


def removed(folder: Path) -> OutputError:
    """Return the error for a `<name>.partial` that lost files while it was in use."""
    return OutputError(
        f"{folder} was removed, in whole or in part, while drysim was writing it",
        "let nothing else write there, and run the command again",
    )


def of_another(folder: Path) -> UsageError:
    """Give the error for finished cases that are none of this sweep."""
    return UsageError(
        f"{folder} holds cases of another sweep, another record or another drysim",
        "run the command without --resume to begin anew",
    )
