"""YAML files as trees of values that know their places, and values laid over them from outside.

`read` goes from a path to a `Document`: ordinary files of at most 1 MB, text in UTF-8, a tree
built from the events of a YAML parser, overrides by dotted key (`--set KEY=VALUE`, or a mapping
from Python). A tree rather than what a YAML loader returns, because every later fault is to be
told with its line, and because the traps of YAML 1.1 are closed here: `on`, `1:30` and dates
stay words, duplicate and merge keys and tags are refused. What a parser complains about is said
again in words that help. Nothing here knows what a scenario is.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, Self

import yaml
from yaml.reader import Reader

from drysim import system
from drysim.errors import Problem, UsageError
from drysim.units import NUMBER, meant, near, short, shown

Keys = tuple[str | int, ...]
"""The steps from the root to a value."""

Overrides = Mapping[str, object] | Sequence[str]
"""Values by dotted key, or `KEY=VALUE` words."""


class Place(NamedTuple):
    """A stretch of one line of a file; line and column count from 1, 0 is the whole file."""

    file: str
    line: int = 0
    column: int = 0
    width: int = 1
    source: str = ""

    def problem(self, sentence: str, key: str = "") -> Problem:
        """Give the problem that a sentence makes here."""
        return Problem(
            sentence, self.file, self.line, self.column, self.width, self.source, key
        )

    def unreadable(self, sentence: str) -> Unreadable:
        """Give the error for a fault here after which nothing more can be read."""
        return Unreadable(self.problem(sentence))


Mark = tuple[int, int]
"""Line and column, from 0."""

Placer = Callable[[Mark, Mark], Place]
"""Gives the place between two marks."""


class Unreadable(Exception):
    """A fault after which nothing more can be read from a file."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.sentence)
        self.problem = problem


def split_lines(text: str) -> list[str]:
    """Give the lines of a text as YAML counts them."""
    return re.split("\r\n|[\n\r\x85\u2028\u2029]", text)


def placer(file: str, text: str) -> Placer:
    """Give the function that finds places in a text."""
    lines = split_lines(text)

    def place(start: Mark, end: Mark) -> Place:
        line, column = min(start[0], len(lines) - 1), start[1]
        source = lines[line]
        last = end[1] if end[0] == line else len(source.rstrip())
        return Place(file, line + 1, column + 1, max(1, last - column), source)

    return place


class Node(NamedTuple):
    """A value with its place; a mapping holds nodes by key, a list holds nodes."""

    value: Any
    place: Place
    key: Place | None = None
    """Where its key stands, in a mapping."""
    size: int = 1
    """Values in it, aliases counted as often as they are used."""
    depth: int = 0


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
    text = _decoded(data, file)
    tree, problems = parse(text, placer(file, text))
    if tree is None:
        raise Place(file).unreadable("the file is empty")
    if not isinstance(tree.value, dict):
        raise tree.place.unreadable(
            f"must be keys such as `name: value`, not {shown(tree.value)}"
        )
    tree, taken, faults = _laid_over(tree, overrides, dotted)
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


# The text of a file, or why it is none.


MAX_BYTES = 1_000_000
"""A scenario is written by hand; what is larger is a record or an attack."""

MARK, REPLACED = "\N{ZERO WIDTH NO-BREAK SPACE}", "\N{REPLACEMENT CHARACTER}"
"""A byte order mark, which has no place within a text; what stands for what has no place."""


def read_bytes(path: Path) -> bytes:
    """Give the content of an ordinary file of at most 1 MB.

    Raises
    ------
    Unreadable
        When there is no such file, or it is a folder, a device, too large or not ours to read.
    """
    here = Place(str(path))
    try:
        system.size(path)
        data = system.content(path, MAX_BYTES + 1)
    except system.Irregular as other:
        inside = _inside(path) if str(other) == "a folder" else "; name a file"
        raise here.unreadable(f"this is {other}{inside}") from None
    except FileNotFoundError:
        why = ": it is a link that leads nowhere" if path.is_symlink() else _neighbour(path)
        raise here.unreadable(f"no such file{why}") from None
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or str(fault)
        raise here.unreadable(f"cannot be read: {reason}") from None
    if len(data) > MAX_BYTES:
        raise here.unreadable("larger than 1 MB; is it a record for `excitation.file`?")
    return data


def _decoded(data: bytes, file: str) -> str:
    """Give the text of UTF-8 bytes, without its byte order mark."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise Place(file).unreadable("this is UTF-16 text; save it as UTF-8")
    if b"\0" in data:
        raise Place(file).unreadable("this is a binary file, not a scenario")
    data = data.removeprefix(b"\xef\xbb\xbf")
    try:
        text = data.decode()
    except UnicodeDecodeError as fault:
        before = data[: fault.start].decode()
        text = before + data[fault.start :].decode("latin-1")
        sentence = f"byte 0x{data[fault.start]:02X} is not UTF-8; save the file as UTF-8"
        raise _at(text, len(before), file).unreadable(sentence) from None
    screen(text, file)
    return text


def screen(text: str, file: str) -> None:
    """Refuse a text with characters that YAML does not know, at the first of them."""
    bad = Reader.NON_PRINTABLE.search(text)
    places = [text.find(MARK), bad.start() if bad else -1]
    first = min((place for place in places if place >= 0), default=None)
    if first is not None:
        sentence = f"character U+{ord(text[first]):04X} has no place in a scenario; remove it"
        raise _at(text, first, file).unreadable(sentence)


def _at(text: str, start: int, file: str) -> Place:
    """Give the place of one character; what cannot be shown is replaced in the line."""
    before = split_lines(text[:start])
    line, column = len(before) - 1, len(before[-1])
    shown = Reader.NON_PRINTABLE.sub(REPLACED, text).replace(MARK, REPLACED)
    return placer(file, shown)((line, column), (line, column + 1))


def _neighbour(path: Path) -> str:
    """Give the scenario of the same folder that was probably meant, as a hint."""
    try:
        names = sorted(os.listdir(path.parent))
    except OSError:
        return ""
    nearest = near(path.name, (name for name in names if name.endswith((".yaml", ".yml"))))
    return meant(nearest and str(path.parent / nearest))


def _inside(path: Path) -> str:
    """Give the only scenario of a folder, as a hint."""
    found = [*path.glob("*.yaml"), *path.glob("*.yml")]
    return meant(str(found[0])) if len(found) == 1 else "; name a file in it"


# The tree.


MAX_DEPTH = 40
"""A scenario needs five levels; a parser that recurses needs a bound."""

MAX_VALUES = 50_000
"""What aliases may grow a file to: far more than 1 MB holds of anything useful."""

LOST = "<<"
"""Stands in a mapping for keys that could not be read, so that nobody misses them twice."""

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_WORDS = {"": None, "~": None, "null": None, "true": True, "false": False}


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
                    raise self.place(event).unreadable(sentence)
                tree = self.node(next(self.events), 0)
        return tree

    def node(self, event: Any, depth: int) -> Node:
        """Give the value that starts with an event."""
        place = self.place(event)
        if depth > MAX_DEPTH:
            raise place.unreadable(f"nested deeper than {MAX_DEPTH} levels")
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
            raise place.unreadable(f"this is more than {MAX_VALUES} values, aliases counted")
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
            raise place.unreadable(f"alias `*{short(anchor)}` {word}")
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
            raise place.unreadable(f"nested deeper than {MAX_DEPTH} levels")
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


# What a YAML parser complains about.


_GLUED = re.compile(r"(\s*(?:- +)?)([A-Za-z_][\w.]*):([{\[].*|[^\s:/\\][^:]*)$")
"""A key whose colon has no space behind it."""


class _Spot(NamedTuple):
    """Where a parser gave up, and where what it was reading began; lines count from 0."""

    lines: list[str]
    at: Mark
    start: Mark
    place: Placer

    @property
    def line(self) -> str:
        """The line at which it gave up."""
        return self.lines[self.at[0]] if self.at[0] < len(self.lines) else ""

    @property
    def sign(self) -> str:
        """The sign at which it did; empty at the end of the line."""
        return self.line[self.at[1] : self.at[1] + 1]

    def here(self, sentence: str, at: Mark | None = None, width: int = 1) -> Problem:
        """Give the problem that a sentence makes there, or at another place."""
        line, column = at or self.at
        return self.place((line, column), (line, column + width)).problem(sentence)


def explained(fault: yaml.MarkedYAMLError, text: str, place: Placer) -> Problem:
    """Give the located sentence for a fault of a YAML parser."""
    mark, context = fault.problem_mark or fault.context_mark, fault.context_mark
    at = (mark.line, mark.column) if mark else (0, 0)
    start = (context.line, context.column) if context else at
    spot = _Spot(split_lines(text), at, start, place)
    what = f"{fault.problem or ''} {fault.context or ''}"
    if "mapping values" in what or "expected ':'" in what:
        return _about_a_colon(spot)
    if "cannot start any token" in what:
        if spot.sign == "\t":
            return spot.here("a tab cannot indent in YAML; use spaces")
        return spot.here(f"a value cannot start with `{spot.sign}`; put it in quotes")
    if "expected ',' or" in what:
        opening, closing = ("{", "}") if "mapping" in what else ("[", "]")
        if at[0] > start[0]:
            return spot.here(f"this `{opening}` is not closed by `{closing}`", start)
        return spot.here(f"`,` or `{closing}` is missing before this")
    if "end of stream" in what and "quoted" in what:
        return spot.here("this quote is not closed", start)
    if "escape" in what:
        return spot.here("unknown escape in double quotes; use single quotes", start)
    if re.search(r"expected (key|<block end>|'-' indicator)", what):
        if spot.line[: spot.at[1]].strip():
            return spot.here("nothing may follow the value in its line")
        sentence = "this line fits no block above it; check its indentation"
        return spot.here(sentence, *_head(spot))
    if spot.line.startswith("%"):
        sentence = "this directive is not understood; remove it"
        return spot.here(sentence, width=len(spot.line.rstrip()))
    if "node content" in what:
        behind = f"`{spot.sign}`" if spot.sign else "the end"
        return spot.here(f"a value is missing before {behind}")
    return spot.here(f"this is not YAML: {short(str(fault.problem), 200)}")


def _about_a_colon(spot: _Spot) -> Problem:
    """Say what is wrong where a colon is one too many, or one too few."""
    lines, last = spot.lines, spot.at[0]
    for number in range(last, max(-1, last - 3), -1):
        if glued := _GLUED.match(lines[number] if number < len(lines) else ""):
            words = f"`{short(glued[2])}: {short(glued[3])}`"
            sentence = f"a space is missing after the colon: {words}"
            return spot.here(sentence, (number, len(glued[1])), len(glued[2]))
    if ": " in spot.line[: spot.at[1]]:
        return spot.here("a second `: ` in one value; put the value in quotes")
    number = next((n for n in reversed(range(last)) if lines[n].strip()), last)
    before = lines[number]
    if ":" not in before:
        sentence = "a colon is missing behind this key"
        return spot.here(sentence, (number, _indent(before)), len(before.strip()))
    sentence = "this line is indented deeper than the one before it allows"
    return spot.here(sentence, *_head(spot))


def _head(spot: _Spot) -> tuple[Mark, int]:
    """Give where the line begins to speak, and how long its first word is."""
    return (spot.at[0], _indent(spot.line)), len((spot.line.split() or [""])[0])


def _indent(line: str) -> int:
    """Give how many spaces a line starts with."""
    return len(line) - len(line.lstrip(" "))


# Overrides.


SHOWN = 200
"""Characters of an override by which messages name it."""


def _laid_over(
    tree: Node, overrides: Overrides, dotted: Collection[str]
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
        raise place.unreadable("write KEY=VALUE, such as `friction.kinetic=30`")
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
        raise place.unreadable("has no value; `null` takes the key away")
    return node, problems


def _known(value: Any, place: Place, depth: int = 0) -> Node:
    """Give the node of a Python value."""
    if depth > MAX_DEPTH:
        raise place.unreadable(f"nested deeper than {MAX_DEPTH} levels")
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
    raise place.unreadable(f"a value of type {type(value).__name__} has no place in a scenario")


def _bare(value: Any, place: Place) -> Any:
    """Give what a number or an array of numpy holds; one that is masked holds nothing."""
    bare = getattr(value, "tolist", lambda: value)()
    if bare is None and value is not None:
        what = f"a value of type {type(value).__name__} with nothing behind its mask"
        raise place.unreadable(f"{what} has no place in a scenario")
    return bare


def _put(node: Node, steps: list[str], new: Node, place: Place, done: str = "") -> Node:
    """Give the node with the new one at the end of the steps; missing blocks are made.

    The entries of a list count from 0.
    """
    step, rest = steps[0], steps[1:]
    if isinstance(node.value, list):
        count = len(node.value)
        if not (step.isdecimal() and len(step) < 9 and int(step) < count):
            entries = f"with entries 0 to {count - 1}" if count else "without entries"
            raise place.unreadable(f"{done} is a list {entries}; it has no `{short(step)}`")
        items = list(node.value)
        old = items[int(step)]
        items[int(step)] = _put(old, rest, new, place, f"{done}.{step}") if rest else new
        return node._replace(value=items)
    if not isinstance(node.value, dict):
        raise place.unreadable(f"{done} is a value; it has no `{short(step)}`")
    children = dict(node.value)
    if rest:
        old = children.get(step, Node({}, place))
        children[step] = _put(old, rest, new, place, f"{done}.{step}".strip("."))
    elif new.value is not None:
        children[step] = new
    elif children.pop(step, None) is None:
        hint = meant(near(step, children))
        raise place.unreadable(f"there is no `{short(step)}` to take away{hint}")
    if step in children:
        children[step] = children[step]._replace(
            key=node.value[step].key if rest and step in node.value else place
        )
    return node._replace(value=children)
