"""YAML files as trees of values that know their places, and values laid over them from outside.

`read_document` goes from a path to a `Document`: ordinary files of at most 1 MB, text in UTF-8, a tree
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
from drysim.units import NUMBER_PATTERN, closest_match, did_you_mean, format_value, shorten

KeyPath = tuple[str | int, ...]
"""The steps from the root to a value."""

Overrides = Mapping[str, object] | Sequence[str]
"""Values by dotted key, or `KEY=VALUE` words."""


class Location(NamedTuple):
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

    def unreadable(self, sentence: str) -> UnreadableError:
        """Give the error for a fault here after which nothing more can be read."""
        return UnreadableError(self.problem(sentence))


Position = tuple[int, int]
"""Line and column, from 0."""

Locator = Callable[[Position, Position], Location]
"""Gives the place between two marks."""


class UnreadableError(Exception):
    """A fault after which nothing more can be read from a file."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.sentence)
        self.problem = problem


def split_lines(text: str) -> list[str]:
    """Give the lines of a text as YAML counts them."""
    return re.split("\r\n|[\n\r\x85\u2028\u2029]", text)


def make_locator(file: str, text: str) -> Locator:
    """Give the function that finds places in a text."""
    lines = split_lines(text)

    def location(start: Position, end: Position) -> Location:
        line, column = min(start[0], len(lines) - 1), start[1]
        source = lines[line]
        last = end[1] if end[0] == line else len(source.rstrip())
        return Location(file, line + 1, column + 1, max(1, last - column), source)

    return location


class Node(NamedTuple):
    """A value with its place; a mapping holds nodes by key, a list holds nodes."""

    value: Any
    location: Location
    key: Location | None = None
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
        return dict(plain_value(self.tree))

    def locate(self, keys: KeyPath, key: bool = False) -> Location:
        """Give where a value (or its key) stands, or the nearest block around it."""
        node, location = self.tree, self.tree.location
        for step in keys:
            try:
                node = node.value[int(step) if isinstance(node.value, list) else step]
            except (KeyError, IndexError, TypeError, ValueError):
                break
            location = (node.key or node.location) if key else node.location
        return location


def read_document(
    path: str | Path, overrides: Overrides = (), dotted_blocks: Collection[str] = ()
) -> Document:
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
    text = _decode(data, file)
    tree, problems = parse(text, make_locator(file, text))
    if tree is None:
        raise Location(file).unreadable("the file is empty")
    if not isinstance(tree.value, dict):
        raise tree.location.unreadable(
            f"must be keys such as `name: value`, not {format_value(tree.value)}"
        )
    tree, applied, faults = _apply_overrides(tree, overrides, dotted_blocks)
    return Document(file, hashlib.sha256(data).hexdigest(), tree, problems + faults, applied)


def dump(mapping: Mapping[str, Any]) -> str:
    """Give a mapping as YAML that `read_document` reads back to the same values."""
    import yaml

    class Dumper(yaml.SafeDumper):
        """Puts words in quotes that would read back as something else."""

    def word(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
        style = None if parse_scalar(text) == text else "'"
        return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)

    Dumper.add_representer(str, word)
    Dumper.ignore_aliases = lambda self, data: True  # type: ignore[method-assign]
    return yaml.dump(mapping, Dumper=Dumper, sort_keys=False, allow_unicode=True, width=96)


# The text of a file, or why it is none.


MAX_BYTES = 1_000_000
"""A scenario is written by hand; what is larger is a record or an attack."""

BYTE_ORDER_MARK, REPLACEMENT_CHARACTER = (
    "\N{ZERO WIDTH NO-BREAK SPACE}",
    "\N{REPLACEMENT CHARACTER}",
)
"""A byte order mark, which has no place within a text; what stands for what has no place."""


def read_bytes(path: Path) -> bytes:
    """Give the content of an ordinary file of at most 1 MB.

    Raises
    ------
    Unreadable
        When there is no such file, or it is a folder, a device, too large or not ours to read.
    """
    here = Location(str(path))
    try:
        system.file_size(path)
        data = system.read_regular_file(path, MAX_BYTES + 1)
    except system.NotARegularFile as other:
        inside = _suggest_file_inside(path) if str(other) == "a folder" else "; name a file"
        raise here.unreadable(f"this is {other}{inside}") from None
    except FileNotFoundError:
        why = ": it is a link that leads nowhere" if path.is_symlink() else _suggest_file(path)
        raise here.unreadable(f"no such file{why}") from None
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or str(fault)
        raise here.unreadable(f"cannot be read: {reason}") from None
    if len(data) > MAX_BYTES:
        raise here.unreadable("larger than 1 MB; is it a record for `excitation.file`?")
    return data


def _decode(data: bytes, file: str) -> str:
    """Give the text of UTF-8 bytes, without its byte order mark."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise Location(file).unreadable("this is UTF-16 text; save it as UTF-8")
    if b"\0" in data:
        raise Location(file).unreadable("this is a binary file, not a scenario")
    data = data.removeprefix(b"\xef\xbb\xbf")
    try:
        text = data.decode()
    except UnicodeDecodeError as fault:
        before = data[: fault.start].decode()
        text = before + data[fault.start :].decode("latin-1")
        sentence = f"byte 0x{data[fault.start]:02X} is not UTF-8; save the file as UTF-8"
        raise _location_of_character(text, len(before), file).unreadable(sentence) from None
    check_characters(text, file)
    return text


def check_characters(text: str, file: str) -> None:
    """Refuse a text with characters that YAML does not know, at the first of them."""
    bad = Reader.NON_PRINTABLE.search(text)
    places = [text.find(BYTE_ORDER_MARK), bad.start() if bad else -1]
    first = min((location for location in places if location >= 0), default=None)
    if first is not None:
        sentence = f"character U+{ord(text[first]):04X} has no place in a scenario; remove it"
        raise _location_of_character(text, first, file).unreadable(sentence)


def _location_of_character(text: str, start: int, file: str) -> Location:
    """Give the place of one character; what cannot be shown is replaced in the line."""
    before = split_lines(text[:start])
    line, column = len(before) - 1, len(before[-1])
    shown = Reader.NON_PRINTABLE.sub(REPLACEMENT_CHARACTER, text).replace(
        BYTE_ORDER_MARK, REPLACEMENT_CHARACTER
    )
    return make_locator(file, shown)((line, column), (line, column + 1))


def _suggest_file(path: Path) -> str:
    """Give the scenario of the same folder that was probably meant, as a hint."""
    try:
        names = sorted(os.listdir(path.parent))
    except OSError:
        return ""
    nearest = closest_match(
        path.name, (name for name in names if name.endswith((".yaml", ".yml")))
    )
    return did_you_mean(nearest and str(path.parent / nearest))


def _suggest_file_inside(path: Path) -> str:
    """Give the only scenario of a folder, as a hint."""
    found = [*path.glob("*.yaml"), *path.glob("*.yml")]
    return did_you_mean(str(found[0])) if len(found) == 1 else "; name a file in it"


# The tree.


MAX_DEPTH = 40
"""A scenario needs five levels; a parser that recurses needs a bound."""

MAX_VALUES = 50_000
"""What aliases may grow a file to: far more than 1 MB holds of anything useful."""

UNREAD_KEYS = "<<"
"""Stands in a mapping for keys that could not be read, so that nobody misses them twice."""

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_WORDS = {"": None, "~": None, "null": None, "true": True, "false": False}


def parse_scalar(text: str) -> object:
    """Give the value of a plain YAML word: a number, true, false, nothing, or the word itself.

    `1e3` is a number; `on`, `no`, `1:30`, `0x10` and dates stay words.
    """
    if NUMBER_PATTERN.fullmatch(text):
        whole = text.lstrip("+-").isdigit() and len(text) <= 18
        return int(text) if whole else float(text)
    word = text if text in _WORDS else text.lower()
    if word in (".inf", "+.inf", "-.inf", ".nan"):
        return float(word.replace(".", ""))
    return _WORDS.get(word, text)


def parse(text: str, locator: Locator) -> tuple[Node | None, tuple[Problem, ...]]:
    """Give the tree of a YAML text, None when it is empty, and the problems that leave a tree.

    Raises
    ------
    Unreadable
        When the text is not YAML, or so large or deep that it can only be an attack.
    """
    builder = _TreeBuilder(yaml.parse(text, Loader=_LOADER), locator)
    try:
        return builder.document(), tuple(builder.problems)
    except yaml.MarkedYAMLError as fault:
        raise UnreadableError(explain_error(fault, text, locator)) from None


class _TreeBuilder:
    """Builds a tree from the events of a YAML parser, each of which knows its place."""

    def __init__(self, events: Iterator[Any], locator: Locator) -> None:
        self.events = events
        self.locator = locator
        self.problems: list[Problem] = []
        self.anchors: dict[str, Node | None] = {}
        self.value_count = 0

    def document(self) -> Node | None:
        """Give the tree of the only document; errors as in `parse`."""
        tree = None
        for event in self.events:
            if isinstance(event, yaml.DocumentStartEvent):
                if tree is not None:
                    sentence = "a second document starts here; a scenario is one document"
                    raise self.location(event).unreadable(sentence)
                tree = self.node(next(self.events), 0)
        return tree

    def node(self, event: Any, depth: int) -> Node:
        """Give the value that starts with an event."""
        location = self.location(event)
        if depth > MAX_DEPTH:
            raise location.unreadable(f"nested deeper than {MAX_DEPTH} levels")
        if isinstance(event, yaml.AliasEvent):
            return self.alias(event.anchor, location)
        if event.anchor is not None:
            self.anchors[event.anchor] = None
        if event.tag is not None:
            self.problems.append(
                location.problem("tags such as `!!float` are refused; remove it")
            )
        if isinstance(event, yaml.ScalarEvent):
            value = event.value if event.style else parse_scalar(event.value)
            node = Node(value, location)
        elif isinstance(event, yaml.SequenceStartEvent):
            node = self.sequence(location, depth)
        else:
            node = self.mapping(location, depth, event.flow_style)
        self.value_count += 1
        if max(self.value_count, node.size) > MAX_VALUES:
            raise location.unreadable(f"this is more than {MAX_VALUES} values, aliases counted")
        if event.anchor is not None:
            self.anchors[event.anchor] = node
        return node

    def alias(self, anchor: Any, location: Location) -> Node:
        """Give the value that an alias repeats."""
        node = self.anchors.get(anchor)
        if node is None:
            word = (
                "stands inside itself" if anchor in self.anchors else "has no anchor before it"
            )
            raise location.unreadable(f"alias `*{shorten(anchor)}` {word}")
        return node._replace(location=location)

    def sequence(self, location: Location, depth: int) -> Node:
        """Give the list whose start was read."""
        values = []
        while not isinstance(event := next(self.events), yaml.SequenceEndEvent):
            values.append(self.node(event, depth + 1))
        return self.collection(values, values, location)

    def mapping(self, location: Location, depth: int, flow: bool) -> Node:
        """Give the mapping whose start was read."""
        values: dict[str, Node] = {}
        while not isinstance(event := next(self.events), yaml.MappingEndEvent):
            known = len(self.problems)
            key = self.node(event, depth + 1)
            if isinstance(key.value, dict | list):
                del self.problems[known:]  # one fault is enough for a key such as `{{ mass }}`
            child = self.node(next(self.events), depth + 1)
            if sentence := _key_error(event, values):
                self.problems.append(key.location.problem(sentence))
                if not isinstance(event, yaml.ScalarEvent) or event.value == UNREAD_KEYS:
                    values[UNREAD_KEYS] = Node(None, key.location, key.location)
                continue
            below = (
                isinstance(child.value, dict | list) and child.location.line > key.location.line
            )
            here = key.location if below or child.value is None else child.location
            values[event.value] = child._replace(key=key.location, location=here)
        first = next((child.key for child in values.values() if child.key), location)
        return self.collection(values, list(values.values()), location if flow else first)

    def collection(self, value: Any, children: list[Node], location: Location) -> Node:
        """Give a list or mapping with its size and depth."""
        size = 1 + sum(child.size for child in children)
        depth = 1 + max((child.depth for child in children), default=0)
        if depth > MAX_DEPTH:
            raise location.unreadable(f"nested deeper than {MAX_DEPTH} levels")
        return Node(value, location, size=size, depth=depth)

    def location(self, event: Any) -> Location:
        """Give where an event stands."""
        start, end = event.start_mark, event.end_mark
        return self.locator((start.line, start.column), (end.line, end.column))


def _key_error(event: Any, known: dict[str, Node]) -> str:
    """Say why a key is refused; empty when it is not."""
    if not isinstance(event, yaml.ScalarEvent):
        return "a key must be a word"
    if event.value == UNREAD_KEYS:
        return "merge keys are not supported; write the keys out, or `key: *alias`"
    if first := known.get(event.value):
        line = first.key.line if first.key else 0
        where = f"; the first is in line {line}" if line else ""
        return f"duplicate key `{shorten(event.value)}`{where}"
    return ""


# What a YAML parser complains about.


_MISSING_SPACE = re.compile(r"(\s*(?:- +)?)([A-Za-z_][\w.]*):([{\[].*|[^\s:/\\][^:]*)$")
"""A key whose colon has no space behind it."""


class _ErrorContext(NamedTuple):
    """Where a parser gave up, and where what it was reading began; lines count from 0."""

    lines: list[str]
    at: Position
    start: Position
    locator: Locator

    @property
    def line(self) -> str:
        """The line at which it gave up."""
        return self.lines[self.at[0]] if self.at[0] < len(self.lines) else ""

    @property
    def sign(self) -> str:
        """The sign at which it did; empty at the end of the line."""
        return self.line[self.at[1] : self.at[1] + 1]

    def here(self, sentence: str, at: Position | None = None, width: int = 1) -> Problem:
        """Give the problem that a sentence makes there, or at another place."""
        line, column = at or self.at
        return self.locator((line, column), (line, column + width)).problem(sentence)


def explain_error(fault: yaml.MarkedYAMLError, text: str, locator: Locator) -> Problem:
    """Give the located sentence for a fault of a YAML parser."""
    mark, context = fault.problem_mark or fault.context_mark, fault.context_mark
    at = (mark.line, mark.column) if mark else (0, 0)
    start = (context.line, context.column) if context else at
    error_context = _ErrorContext(split_lines(text), at, start, locator)
    what = f"{fault.problem or ''} {fault.context or ''}"
    if "mapping values" in what or "expected ':'" in what:
        return _explain_colon_error(error_context)
    if "cannot start any token" in what:
        if error_context.sign == "\t":
            return error_context.here("a tab cannot indent in YAML; use spaces")
        return error_context.here(
            f"a value cannot start with `{error_context.sign}`; put it in quotes"
        )
    if "expected ',' or" in what:
        opening, closing = ("{", "}") if "mapping" in what else ("[", "]")
        if at[0] > start[0]:
            return error_context.here(f"this `{opening}` is not closed by `{closing}`", start)
        return error_context.here(f"`,` or `{closing}` is missing before this")
    if "end of stream" in what and "quoted" in what:
        return error_context.here("this quote is not closed", start)
    if "escape" in what:
        return error_context.here("unknown escape in double quotes; use single quotes", start)
    if re.search(r"expected (key|<block end>|'-' indicator)", what):
        if error_context.line[: error_context.at[1]].strip():
            return error_context.here("nothing may follow the value in its line")
        sentence = "this line fits no block above it; check its indentation"
        return error_context.here(sentence, *_first_word(error_context))
    if error_context.line.startswith("%"):
        sentence = "this directive is not understood; remove it"
        return error_context.here(sentence, width=len(error_context.line.rstrip()))
    if "node content" in what:
        behind = f"`{error_context.sign}`" if error_context.sign else "the end"
        return error_context.here(f"a value is missing before {behind}")
    return error_context.here(f"this is not YAML: {shorten(str(fault.problem), 200)}")


def _explain_colon_error(error_context: _ErrorContext) -> Problem:
    """Say what is wrong where a colon is one too many, or one too few."""
    lines, last = error_context.lines, error_context.at[0]
    for number in range(last, max(-1, last - 3), -1):
        if glued := _MISSING_SPACE.match(lines[number] if number < len(lines) else ""):
            words = f"`{shorten(glued[2])}: {shorten(glued[3])}`"
            sentence = f"a space is missing after the colon: {words}"
            return error_context.here(sentence, (number, len(glued[1])), len(glued[2]))
    if ": " in error_context.line[: error_context.at[1]]:
        return error_context.here("a second `: ` in one value; put the value in quotes")
    number = next((n for n in reversed(range(last)) if lines[n].strip()), last)
    before = lines[number]
    if ":" not in before:
        sentence = "a colon is missing behind this key"
        return error_context.here(sentence, (number, _indent(before)), len(before.strip()))
    sentence = "this line is indented deeper than the one before it allows"
    return error_context.here(sentence, *_first_word(error_context))


def _first_word(error_context: _ErrorContext) -> tuple[Position, int]:
    """Give where the line begins to speak, and how long its first word is."""
    return (error_context.at[0], _indent(error_context.line)), len(
        (error_context.line.split() or [""])[0]
    )


def _indent(line: str) -> int:
    """Give how many spaces a line starts with."""
    return len(line) - len(line.lstrip(" "))


# Overrides.


MAX_OVERRIDE_LENGTH = 200
"""Characters of an override by which messages name it."""


def _apply_overrides(
    tree: Node, overrides: Overrides, dotted_blocks: Collection[str]
) -> tuple[Node, dict[str, Any], tuple[Problem, ...]]:
    """Give the tree with the overrides in it, the overrides as plain values, and problems.

    A value of nothing (`KEY=null`) takes the key away. In the blocks named by `dotted_blocks` the keys
    have dots of their own.
    """
    applied: dict[str, Any] = {}
    problems: list[Problem] = []
    for location, key, value in _override_items(overrides):
        try:
            steps = _split_key(key, location)
            if steps[0] in dotted_blocks:
                steps = _join_dotted_key(tree, steps)
            node, faults = (
                _parse_value(str(value), location)
                if isinstance(value, _UnparsedText)
                else (_to_node(value, location), ())
            )
            tree = _set_node(tree, steps, node, location)
        except UnreadableError as fault:
            problems.append(fault.problem)
        else:
            problems += faults
            applied[key] = plain_value(node)
    return tree, applied, tuple(problems)


def plain_value(node: Node) -> Any:
    """Give the value of a node without its places."""
    if isinstance(node.value, dict):
        return {key: plain_value(child) for key, child in node.value.items()}
    if isinstance(node.value, list):
        return [plain_value(child) for child in node.value]
    return node.value


class OptionOverride(str):
    """A `KEY=VALUE` word that an option of its own stands for, by which messages name it."""

    label: str

    def __new__(cls, word: str, label: str) -> Self:
        """Give the word behind an option, such as `--approach signum`."""
        option = super().__new__(cls, word)
        option.label = label
        return option


class _UnparsedText(str):
    """The text of a value from the command line, still to be read as YAML."""


def _override_items(overrides: Overrides) -> Iterator[tuple[Location, str, object]]:
    """Give place, key and value of every override."""
    if isinstance(overrides, Mapping):
        for key, value in overrides.items():
            yield (
                Location(f"overrides[{shorten(repr(key), MAX_OVERRIDE_LENGTH)}]"),
                str(key),
                value,
            )
        return
    words = [overrides] if isinstance(overrides, str) else overrides
    if not isinstance(words, Sequence) or not all(isinstance(word, str) for word in words):
        given = shorten(repr(overrides), MAX_OVERRIDE_LENGTH)
        raise UsageError(
            f"overrides are a mapping by dotted key, or words such as `friction.kinetic=30`, "
            f"not {given}"
        )
    for word in words:
        key, equals, text = word.partition("=")
        label = word.label if isinstance(word, OptionOverride) else f"--set {word}"
        yield (
            Location(shorten(label, MAX_OVERRIDE_LENGTH)),
            key.strip() if equals else "",
            _UnparsedText(text),
        )


def _split_key(key: str, location: Location) -> list[str]:
    """Give the steps of a dotted key."""
    steps = key.split(".")
    if not all(steps) or len(steps) > MAX_DEPTH:
        raise location.unreadable("write KEY=VALUE, such as `friction.kinetic=30`")
    return steps


def _join_dotted_key(tree: Node, steps: list[str]) -> list[str]:
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


def _parse_value(text: str, location: Location) -> tuple[Node, tuple[Problem, ...]]:
    """Give the value of a YAML text."""
    check_characters(text, location.file)
    node, problems = parse(text, lambda start, end: location)
    if node is None:
        raise location.unreadable("has no value; `null` takes the key away")
    return node, problems


def _to_node(value: Any, location: Location, depth: int = 0) -> Node:
    """Give the node of a Python value."""
    if depth > MAX_DEPTH:
        raise location.unreadable(f"nested deeper than {MAX_DEPTH} levels")
    value = _from_numpy(value, location)
    if isinstance(value, Mapping):
        items = {str(key): _to_node(v, location, depth + 1) for key, v in value.items()}
        return Node({k: v._replace(key=location) for k, v in items.items()}, location, location)
    if isinstance(value, list | tuple):
        return Node([_to_node(v, location, depth + 1) for v in value], location)
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if isinstance(value, str):
        check_characters(value, location.file)
    if isinstance(value, str | bool | int | float) or value is None:
        return Node(value, location)
    raise location.unreadable(
        f"a value of type {type(value).__name__} has no place in a scenario"
    )


def _from_numpy(value: Any, location: Location) -> Any:
    """Give what a number or an array of numpy holds; one that is masked holds nothing."""
    bare = getattr(value, "tolist", lambda: value)()
    if bare is None and value is not None:
        what = f"a value of type {type(value).__name__} with nothing behind its mask"
        raise location.unreadable(f"{what} has no place in a scenario")
    return bare


def _set_node(
    node: Node, steps: list[str], new: Node, location: Location, done: str = ""
) -> Node:
    """Give the node with the new one at the end of the steps; missing blocks are made.

    The entries of a list count from 0.
    """
    step, rest = steps[0], steps[1:]
    if isinstance(node.value, list):
        count = len(node.value)
        if not (step.isdecimal() and len(step) < 9 and int(step) < count):
            entries = f"with entries 0 to {count - 1}" if count else "without entries"
            raise location.unreadable(
                f"{done} is a list {entries}; it has no `{shorten(step)}`"
            )
        items = list(node.value)
        old = items[int(step)]
        items[int(step)] = (
            _set_node(old, rest, new, location, f"{done}.{step}") if rest else new
        )
        return node._replace(value=items)
    if not isinstance(node.value, dict):
        raise location.unreadable(f"{done} is a value; it has no `{shorten(step)}`")
    children = dict(node.value)
    if rest:
        old = children.get(step, Node({}, location))
        children[step] = _set_node(old, rest, new, location, f"{done}.{step}".strip("."))
    elif new.value is not None:
        children[step] = new
    elif children.pop(step, None) is None:
        hint = did_you_mean(closest_match(step, children))
        raise location.unreadable(f"there is no `{shorten(step)}` to take away{hint}")
    if step in children:
        children[step] = children[step]._replace(
            key=node.value[step].key if rest and step in node.value else location
        )
    return node._replace(value=children)
