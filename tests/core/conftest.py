"""Both engines of the core side by side, so that they cannot drift apart."""

from __future__ import annotations

import importlib
import pkgutil
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

import drysim.core

PARTS = [part.name for part in pkgutil.iter_modules(drysim.core.__path__)]


def core_under(engine: str, folder: Path) -> SimpleNamespace:
    """Return the session's own core if it has that engine, and else a private copy.

    Kernels of a private copy are compiled anew in every session, with their cache in a folder
    of its own: the user's cache knows named tuples as those of the session's own core.
    """
    own = importlib.import_module("drysim.core.compile")
    found = parts() if own.is_plain() == (engine == "plain") else private_parts(engine, folder)
    named = {module.__name__.rpartition(".")[2]: module for module in found}
    return SimpleNamespace(engine=engine, **named)


def parts() -> list[ModuleType]:
    """Import the core, as it is loaded or anew."""
    return [importlib.import_module(f"drysim.core.{name}") for name in PARTS]


def private_parts(engine: str, folder: Path) -> list[ModuleType]:
    """Import the core anew under one engine, leaving the session's own core in place."""
    patch = pytest.MonkeyPatch()
    patch.setenv("DRYSIM_ENGINE", engine)
    patch.setenv("XDG_CACHE_HOME", str(folder))
    own = {
        name: sys.modules.pop(name)
        for name in list(sys.modules)
        if name.startswith("drysim.core")
    }
    package = sys.modules["drysim"]
    attribute = vars(package).get("core")
    try:
        return parts()
    finally:
        for name in [name for name in sys.modules if name.startswith("drysim.core")]:
            del sys.modules[name]
        sys.modules.update(own)
        if attribute is not None:
            vars(package)["core"] = attribute
        patch.undo()


@pytest.fixture(scope="session")
def plain(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """Return the core as plain Python."""
    return core_under("plain", tmp_path_factory.mktemp("plain"))


@pytest.fixture(scope="session")
def fast(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """Return the core as compiled by numba."""
    return core_under("compiled", tmp_path_factory.mktemp("compiled"))


@pytest.fixture(scope="session", params=["plain", "compiled"])
def kernel(request: pytest.FixtureRequest) -> SimpleNamespace:
    """Return the core under each engine in turn."""
    return request.getfixturevalue("plain" if request.param == "plain" else "fast")
