"""YAML text with positions, and values laid over it. Knows no scenario."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from drysim.errors import Problem
from drysim.quantity import shown
from drysim.source.overrides import Option as Option
from drysim.source.overrides import Overrides as Overrides
from drysim.source.overrides import laid_over, plain
from drysim.source.place import Place as Place
from drysim.source.place import Unreadable as Unreadable
from drysim.source.place import placer
from drysim.source.text import decoded, read_bytes
from drysim.source.tree import LOST as LOST
from drysim.source.tree import Node, parse, scalar

Keys = tuple[str | int, ...]
"""The steps from the root to a value."""


@dataclass(frozen=True)
class Document:
    """A YAML file as it was read, with the overrides laid over it."""

    file: str
    """Name as it was given."""
    sha256: str
    """Of the bytes of the file, in hex."""
    tree: Node
    """The values with their places; the root is a mapping."""
    problems: tuple[Problem, ...] = ()
    """Faults that leave the rest readable: duplicate keys, tags, faulty overrides."""
    overrides: Mapping[str, Any] = field(default_factory=dict)
    """Values that were set from outside, by dotted key."""

    @cached_property
    def value(self) -> dict[str, Any]:
        """The file as plain mappings, lists and scalars."""
        return dict(plain(self.tree))

    def locate(self, keys: Keys, key: bool = False) -> Place:
        """Give where a value (or its key) stands, or the nearest block around it."""
        node, place = self.tree, self.tree.place
        for step in keys:
            try:
                node = node.value[int(step) if isinstance(node.value, list) else step]
            except (KeyError, IndexError, TypeError, ValueError):
                break
            place = (node.key or node.place) if key else node.place
        return place


def read(path: str | Path, overrides: Overrides = (), dotted: Collection[str] = ()) -> Document:
    """Give the document of a YAML file.

    Parameters
    ----------
    path : str or Path
    overrides : mapping or sequence of str
        Values by dotted key, or `KEY=VALUE` words.
    dotted : collection of str
        Blocks whose keys have dots of their own.

    Raises
    ------
    Unreadable
        When there is no file, or no YAML mapping in it; holds the located problem.
    """
    file = str(path)
    data = read_bytes(Path(path))
    text = decoded(data, file)
    tree, problems = parse(text, placer(file, text))
    if tree is None:
        raise Unreadable(Place(file).problem("the file is empty"))
    if not isinstance(tree.value, dict):
        raise Unreadable(
            tree.place.problem(f"must be keys such as `name: value`, not {shown(tree.value)}")
        )
    tree, taken, faults = laid_over(tree, overrides, dotted)
    return Document(file, hashlib.sha256(data).hexdigest(), tree, problems + faults, taken)


def dump(mapping: Mapping[str, Any]) -> str:
    """Give a mapping as YAML that `read` reads back to the same values."""
    import yaml

    class Dumper(yaml.SafeDumper):
        """Puts words in quotes that would read back as something else."""

    def word(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
        style = None if scalar(text) == text else "'"
        return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)

    Dumper.add_representer(str, word)
    Dumper.ignore_aliases = lambda self, data: True  # type: ignore[method-assign]
    return yaml.dump(mapping, Dumper=Dumper, sort_keys=False, allow_unicode=True, width=96)
