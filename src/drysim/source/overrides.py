"""Values set from outside, by `--set KEY=VALUE` or from Python, laid over a tree."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, Self

from drysim.errors import Problem, UsageError
from drysim.quantity import meant, near, short
from drysim.source.place import Place, Unreadable
from drysim.source.text import screen
from drysim.source.tree import MAX_DEPTH, Node, parse

Overrides = Mapping[str, object] | Sequence[str]


SHOWN = 200
"""Characters of an override by which messages name it."""


def laid_over(
    tree: Node, overrides: Overrides, dotted: Collection[str] = ()
) -> tuple[Node, dict[str, Any], tuple[Problem, ...]]:
    """Give the tree with the overrides in it, the overrides as plain values, and problems.

    A value of nothing (`KEY=null`) takes the key away. In the blocks named by `dotted` the keys
    have dots of their own.
    """
    taken: dict[str, Any] = {}
    problems: list[Problem] = []
    for place, key, value in _items(overrides):
        try:
            steps = _steps(key, place)
            if steps[0] in dotted:
                steps = _whole(tree, steps)
            node, faults = (
                _read(str(value), place)
                if isinstance(value, _Text)
                else (_known(value, place), ())
            )
            tree = _put(tree, steps, node, place)
        except Unreadable as fault:
            problems.append(fault.problem)
        else:
            problems += faults
            taken[key] = plain(node)
    return tree, taken, tuple(problems)


def plain(node: Node) -> Any:
    """Give the value of a node without its places."""
    if isinstance(node.value, dict):
        return {key: plain(child) for key, child in node.value.items()}
    if isinstance(node.value, list):
        return [plain(child) for child in node.value]
    return node.value


class Option(str):
    """A `KEY=VALUE` word that an option of its own stands for, by which messages name it."""

    told: str

    def __new__(cls, word: str, told: str) -> Self:
        """Give the word behind an option, such as `--approach signum`."""
        option = super().__new__(cls, word)
        option.told = told
        return option


class _Text(str):
    """The text of a value from the command line, still to be read as YAML."""


def _items(overrides: Overrides) -> Iterator[tuple[Place, str, object]]:
    """Give place, key and value of every override."""
    if isinstance(overrides, Mapping):
        for key, value in overrides.items():
            yield Place(f"overrides[{short(repr(key), SHOWN)}]"), str(key), value
        return
    words = [overrides] if isinstance(overrides, str) else overrides
    if not isinstance(words, Sequence) or not all(isinstance(word, str) for word in words):
        given = short(repr(overrides), SHOWN)
        raise UsageError(
            f"overrides are a mapping by dotted key, or words such as `friction.kinetic=30`, "
            f"not {given}"
        )
    for word in words:
        key, equals, text = word.partition("=")
        told = word.told if isinstance(word, Option) else f"--set {word}"
        yield Place(short(told, SHOWN)), key.strip() if equals else "", _Text(text)


def _steps(key: str, place: Place) -> list[str]:
    """Give the steps of a dotted key."""
    steps = key.split(".")
    if not all(steps) or len(steps) > MAX_DEPTH:
        raise Unreadable(place.problem("write KEY=VALUE, such as `friction.kinetic=30`"))
    return steps


def _whole(tree: Node, steps: list[str]) -> list[str]:
    """Give the steps to a value in a block whose keys have dots.

    What follows the name of the block is one key, unless its beginning is a key already there:
    then the rest leads into that.
    """
    name, *rest = steps
    block = tree.value.get(name)
    known = block.value if block is not None and isinstance(block.value, dict) else {}
    for end in range(len(rest), 0, -1):
        key = ".".join(rest[:end])
        if key in known:
            return [name, key, *rest[end:]]
    return [name, ".".join(rest)] if rest else [name]


def _read(text: str, place: Place) -> tuple[Node, tuple[Problem, ...]]:
    """Give the value of a YAML text."""
    screen(text, place.file)
    node, problems = parse(text, lambda start, end: place)
    if node is None:
        raise Unreadable(place.problem("has no value; `null` takes the key away"))
    return node, problems


def _known(value: Any, place: Place, depth: int = 0) -> Node:
    """Give the node of a Python value."""
    if depth > MAX_DEPTH:
        raise Unreadable(place.problem(f"nested deeper than {MAX_DEPTH} levels"))
    value = _bare(value, place)
    if isinstance(value, Mapping):
        items = {str(key): _known(v, place, depth + 1) for key, v in value.items()}
        return Node({k: v._replace(key=place) for k, v in items.items()}, place, place)
    if isinstance(value, list | tuple):
        return Node([_known(v, place, depth + 1) for v in value], place)
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if isinstance(value, str):
        screen(value, place.file)
    if isinstance(value, str | bool | int | float) or value is None:
        return Node(value, place)
    raise Unreadable(
        place.problem(f"a value of type {type(value).__name__} has no place in a scenario")
    )


def _bare(value: Any, place: Place) -> Any:
    """Give what a number or an array of numpy holds; one that is masked holds nothing."""
    bare = getattr(value, "tolist", lambda: value)()
    if bare is None and value is not None:
        what = f"a value of type {type(value).__name__} with nothing behind its mask"
        raise Unreadable(place.problem(f"{what} has no place in a scenario"))
    return bare


def _put(node: Node, steps: list[str], new: Node, place: Place, done: str = "") -> Node:
    """Give the node with the new one at the end of the steps; missing blocks are made."""
    step, rest = steps[0], steps[1:]
    if isinstance(node.value, list):
        return _put_in_list(node, steps, new, place, done)
    if not isinstance(node.value, dict):
        raise Unreadable(place.problem(f"{done} is a value; it has no `{short(step)}`"))
    children = dict(node.value)
    if rest:
        old = children.get(step, Node({}, place))
        children[step] = _put(old, rest, new, place, f"{done}.{step}".strip("."))
    elif new.value is not None:
        children[step] = new
    elif children.pop(step, None) is None:
        hint = meant(near(step, children))
        raise Unreadable(place.problem(f"there is no `{short(step)}` to take away{hint}"))
    if step in children:
        children[step] = children[step]._replace(
            key=node.value[step].key if rest and step in node.value else place
        )
    return node._replace(value=children)


def _put_in_list(node: Node, steps: list[str], new: Node, place: Place, done: str) -> Node:
    """Give the list with the new node in the entry that the first step counts, from 0."""
    step, rest = steps[0], steps[1:]
    count = len(node.value)
    if not (step.isdecimal() and len(step) < 9 and int(step) < count):
        entries = f"with entries 0 to {count - 1}" if count else "without entries"
        raise Unreadable(
            place.problem(f"{done} is a list {entries}; it has no `{short(step)}`")
        )
    children = list(node.value)
    old = children[int(step)]
    children[int(step)] = _put(old, rest, new, place, f"{done}.{step}") if rest else new
    return node._replace(value=children)
