"""Pydantic without plug-ins: to look for them takes longer than to load a scenario."""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

LOADER = "pydantic.plugin._loader"
"""The module that asks every installed package whether it is a plug-in of pydantic."""


class NoPlugins(ModuleType):
    """Stands where pydantic looks for plug-ins; anything else the real module answers."""

    @staticmethod
    def get_plugins() -> tuple[()]:
        """Give no plug-in: drysim has none."""
        return ()

    def __getattr__(self, name: str) -> Any:
        """Give what another pydantic may want of its module."""
        if name.startswith("__"):
            raise AttributeError(name)
        sys.modules.pop(LOADER, None)
        return getattr(import_module(LOADER), name)


def forgo() -> None:
    """Let this process do without, unless they were loaded already."""
    sys.modules.setdefault(LOADER, NoPlugins(LOADER))
