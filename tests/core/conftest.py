"""Both engines of the core, each in a private copy, so that they cannot drift apart."""

from __future__ import annotations

import importlib
import sys
from types import SimpleNamespace

import pytest

PARTS = (
    "plant", "state", "motion", "compiled", "flow", "wave", "events", "waves", "fade",
    "table", "grid", "integrals", "means", "turns", "forms", "recursion", "law", "stepping",
    "stretches", "trail", "samples.series", "samples.longer", "samples.steps", "samples.stop",
    "samples.within", "samples.glide", "samples.eventful", "samples.march",
    "sines.slide", "sines.cease", "sines.leave",
    "sines.leap", "sines.stretch", "sines.vanish", "sines.period_map", "sines.orbit",
    "sines.orbits", "text.decimal", "text.digits", "text.cells", "many.lanes",
    "many.trapezia", "many.stride", "many.queue", "many.settle", "many.records",
    "contacts.hit", "contacts.joint", "stops.bumper", "stops.bounded", "stops.rest",
    "dynamic_laws.jet", "dynamic_laws.locate", "dynamic_laws.memory", "dynamic_laws.trace",
)  # fmt: skip


def private_core(engine: str) -> SimpleNamespace:
    """Import the core anew under one engine, leaving the session's own core in place."""
    patch = pytest.MonkeyPatch()
    patch.setenv("DRYSIM_ENGINE", engine)
    own = {
        name: sys.modules.pop(name)
        for name in list(sys.modules)
        if name.startswith("drysim.core")
    }
    package = sys.modules["drysim"]
    attribute = vars(package).get("core")
    try:
        found = [importlib.import_module(f"drysim.core.{name}") for name in PARTS]
    finally:
        for name in [name for name in sys.modules if name.startswith("drysim.core")]:
            del sys.modules[name]
        sys.modules.update(own)
        if attribute is not None:
            vars(package)["core"] = attribute
        patch.undo()
    parts = {module.__name__.rpartition(".")[2]: module for module in found}
    return SimpleNamespace(engine=engine, **parts)


@pytest.fixture(scope="session")
def plain() -> SimpleNamespace:
    """Give the core as plain Python."""
    return private_core("plain")


@pytest.fixture(scope="session")
def fast() -> SimpleNamespace:
    """Give the core as compiled by numba."""
    return private_core("compiled")


@pytest.fixture(scope="session", params=["plain", "compiled"])
def kernel(request: pytest.FixtureRequest) -> SimpleNamespace:
    """Give the core under each engine in turn."""
    return request.getfixturevalue("plain" if request.param == "plain" else "fast")
