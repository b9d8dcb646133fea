"""YAML as a tree of values that know their places. The traps of YAML 1.1 are closed here."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import yaml

from drysim.errors import Problem
from drysim.quantity import NUMBER, short
from drysim.source.place import Place, Placer, Unreadable
from drysim.source.syntax import explained

MAX_DEPTH = 40
"""A scenario needs five levels; a parser that recurses needs a bound."""

MAX_VALUES = 50_000
"""What aliases may grow a file to: far more than 1 MB holds of anything useful."""

LOST = "<<"
"""Stands in a mapping for keys that could not be read, so that nobody misses them twice."""

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_WORDS = {"": None, "~": None, "null": None, "true": True, "false": False}


class Node(NamedTuple):
    """A value with its place; a mapping holds nodes by key, a list holds nodes."""

    value: Any
    place: Place
    key: Place | None = None
    """Where its key stands, in a mapping."""
    size: int = 1
    """Values in it, aliases counted as often as they are used."""
    depth: int = 0


def scalar(text: str) -> object:
    """Give the value of a plain YAML word: a number, true, false, nothing, or the word itself.

    `1e3` is a number; `on`, `no`, `1:30`, `0x10` and dates stay words.
    """
    if NUMBER.fullmatch(text):
        whole = text.lstrip("+-").isdigit() and len(text) <= 18
        return int(text) if whole else float(text)
    word = text if text in _WORDS else text.lower()
    if word in (".inf", "+.inf", "-.inf", ".nan"):
        return float(word.replace(".", ""))
    return _WORDS.get(word, text)


def parse(text: str, place: Placer) -> tuple[Node | None, tuple[Problem, ...]]:
    """Give the tree of a YAML text, None when it is empty, and the problems that leave a tree.

    Raises
    ------
    Unreadable
        When the text is not YAML, or so large or deep that it can only be an attack.
    """
    builder = _Builder(yaml.parse(text, Loader=_LOADER), place)
    try:
        return builder.document(), tuple(builder.problems)
    except yaml.MarkedYAMLError as fault:
        raise Unreadable(explained(fault, text, place)) from None


class _Builder:
    """Builds a tree from the events of a YAML parser, each of which knows its place."""

    def __init__(self, events: Iterator[Any], place: Placer) -> None:
        self.events = events
        self.placer = place
        self.problems: list[Problem] = []
        self.anchors: dict[str, Node | None] = {}
        self.read = 0

    def document(self) -> Node | None:
        """Give the tree of the only document; errors as in `parse`."""
        tree = None
        for event in self.events:
            if isinstance(event, yaml.DocumentStartEvent):
                if tree is not None:
                    sentence = "a second document starts here; a scenario is one document"
                    raise Unreadable(self.place(event).problem(sentence))
                tree = self.node(next(self.events), 0)
        return tree

    def node(self, event: Any, depth: int) -> Node:
        """Give the value that starts with an event."""
        place = self.place(event)
        if depth > MAX_DEPTH:
            raise Unreadable(place.problem(f"nested deeper than {MAX_DEPTH} levels"))
        if isinstance(event, yaml.AliasEvent):
            return self.alias(event.anchor, place)
        if event.anchor is not None:
            self.anchors[event.anchor] = None
        if event.tag is not None:
            self.problems.append(place.problem("tags such as `!!float` are refused; remove it"))
        if isinstance(event, yaml.ScalarEvent):
            value = event.value if event.style else scalar(event.value)
            node = Node(value, place)
        elif isinstance(event, yaml.SequenceStartEvent):
            node = self.sequence(place, depth)
        else:
            node = self.mapping(place, depth, event.flow_style)
        self.read += 1
        if max(self.read, node.size) > MAX_VALUES:
            raise Unreadable(
                place.problem(f"this is more than {MAX_VALUES} values, aliases counted")
            )
        if event.anchor is not None:
            self.anchors[event.anchor] = node
        return node

    def alias(self, anchor: Any, place: Place) -> Node:
        """Give the value that an alias repeats."""
        node = self.anchors.get(anchor)
        if node is None:
            word = (
                "stands inside itself" if anchor in self.anchors else "has no anchor before it"
            )
            raise Unreadable(place.problem(f"alias `*{short(anchor)}` {word}"))
        return node._replace(place=place)

    def sequence(self, place: Place, depth: int) -> Node:
        """Give the list whose start was read."""
        values = []
        while not isinstance(event := next(self.events), yaml.SequenceEndEvent):
            values.append(self.node(event, depth + 1))
        return self.collection(values, values, place)

    def mapping(self, place: Place, depth: int, flow: bool) -> Node:
        """Give the mapping whose start was read."""
        values: dict[str, Node] = {}
        while not isinstance(event := next(self.events), yaml.MappingEndEvent):
            known = len(self.problems)
            key = self.node(event, depth + 1)
            if isinstance(key.value, dict | list):
                del self.problems[known:]  # one fault is enough for a key such as `{{ mass }}`
            child = self.node(next(self.events), depth + 1)
            if sentence := _refusal(event, values):
                self.problems.append(key.place.problem(sentence))
                if not isinstance(event, yaml.ScalarEvent) or event.value == LOST:
                    values[LOST] = Node(None, key.place, key.place)
                continue
            below = isinstance(child.value, dict | list) and child.place.line > key.place.line
            here = key.place if below or child.value is None else child.place
            values[event.value] = child._replace(key=key.place, place=here)
        first = next((child.key for child in values.values() if child.key), place)
        return self.collection(values, list(values.values()), place if flow else first)

    def collection(self, value: Any, children: list[Node], place: Place) -> Node:
        """Give a list or mapping with its size and depth."""
        size = 1 + sum(child.size for child in children)
        depth = 1 + max((child.depth for child in children), default=0)
        if depth > MAX_DEPTH:
            raise Unreadable(place.problem(f"nested deeper than {MAX_DEPTH} levels"))
        return Node(value, place, size=size, depth=depth)

    def place(self, event: Any) -> Place:
        """Give where an event stands."""
        start, end = event.start_mark, event.end_mark
        return self.placer((start.line, start.column), (end.line, end.column))


def _refusal(event: Any, known: dict[str, Node]) -> str:
    """Say why a key is refused; empty when it is not."""
    if not isinstance(event, yaml.ScalarEvent):
        return "a key must be a word"
    if event.value == LOST:
        return "merge keys are not supported; write the keys out, or `key: *alias`"
    if first := known.get(event.value):
        line = first.key.line if first.key else 0
        where = f"; the first is in line {line}" if line else ""
        return f"duplicate key `{short(event.value)}`{where}"
    return ""
