"""YAML files as trees of located values, with overrides.

`read_document` reads a regular UTF-8 file of at most 1 MB into a `Document`: a tree built from
the events of the YAML parser, so that every later error can point to line and column, with the
overrides (`--set KEY=VALUE`, or a mapping from Python) applied to it.

Some features of YAML 1.1 are restricted on purpose: `on`, `1:30` and dates stay text; duplicate
keys, merge keys and tags are errors. Messages of the YAML parser are replaced by explanations.
The module does not know the keys of a scenario.
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
from drysim.messages import closest_match, did_you_mean, format_value, shorten
from drysim.units import NUMBER_PATTERN

KeyPath = tuple[str | int, ...]
"""Keys and list indices from the root to a value."""

Overrides = Mapping[str, object] | Sequence[str]
"""Values by dotted key, or `KEY=VALUE` words."""


class Location(NamedTuple):
    """Part of one line of a file.

    Line and column count from 1; a line of 0 stands for the whole file.
    """

    file: str
    line: int = 0
    column: int = 0
    width: int = 1
    source: str = ""
    remark: str = ""
    """What is there, if it is not what the problem is about."""

    def problem(self, sentence: str, key: str = "") -> Problem:
        """Return a problem at this location."""
        return Problem(
            sentence,
            self.file,
            self.line,
            self.column,
            self.width,
            self.source,
            key,
            remark=self.remark,
        )

    def unreadable(self, sentence: str) -> UnreadableError:
        """Return the exception for an error after which the file cannot be read further."""
        return UnreadableError(self.problem(sentence))


Position = tuple[int, int]
"""Line and column, counted from 0."""

Locator = Callable[[Position, Position], Location]
"""Returns the location between two positions."""


class UnreadableError(Exception):
    """An error after which nothing more can be read from a file."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.sentence)
        self.problem = problem


def split_lines(text: str) -> list[str]:
    """Split a text into lines as YAML defines them."""
    return re.split("\r\n|[\n\r\x85\u2028\u2029]", text)


def make_locator(file: str, text: str) -> Locator:
    """Return the function that maps positions in a text to locations."""
    lines = split_lines(text)

    def location(start: Position, end: Position) -> Location:
        line, column = min(start[0], len(lines) - 1), start[1]
        source = lines[line]
        last = end[1] if end[0] == line else len(source.rstrip())
        return Location(file, line + 1, column + 1, max(1, last - column), source)

    return location


class Node(NamedTuple):
    """A value with its location; a mapping contains nodes by key, a list contains nodes."""

    value: Any
    location: Location
    key: Location | None = None
    """Location of the key, for values of a mapping."""
    size: int = 1
    """Number of values, aliases counted as often as they are used."""
    depth: int = 0


@dataclass(frozen=True)
class Document:
    """A YAML file with overrides applied."""

    file: str
    """File name as passed to `read_document`."""
    sha256: str
    """SHA-256 of the bytes of the file, in hex."""
    tree: Node
    """The located values; the root is a mapping."""
    problems: tuple[Problem, ...] = ()
    """Errors that do not prevent reading the rest: duplicate keys, tags, faulty overrides."""
    overrides: Mapping[str, Any] = field(default_factory=dict)
    """Values of the overrides, by dotted key."""

    @cached_property
    def value(self) -> dict[str, Any]:
        """The document as plain mappings, lists and scalars."""
        return dict(plain_value(self.tree))

    def locate(self, keys: KeyPath, key: bool = False) -> Location:
        """Return the location of a value (or of its key), or of the closest enclosing block."""
        node, location = self.tree, self.tree.location
        for step in keys:
            if isinstance(node.value, str):
                break  # text that stands for a list, such as a pattern of files
            try:
                node = node.value[int(step) if isinstance(node.value, list) else step]
            except (KeyError, IndexError, TypeError, ValueError):
                home = "file" if node is self.tree else "block"
                return location._replace(remark=f"in this {home}")
            location = (node.key or node.location) if key else node.location
        return location


def read_document(
    path: str | os.PathLike[str],
    overrides: Overrides = (),
    dotted_blocks: Collection[str] = (),
) -> Document:
    """Read a YAML file and apply overrides.

    Parameters
    ----------
    overrides : mapping or sequence of str
        Values by dotted key, or `KEY=VALUE` words.
    dotted_blocks : collection of str
        Blocks whose keys contain dots, by their dotted path.

    Raises
    ------
    UnreadableError
        If the file does not exist or is no YAML mapping; holds the located problem.
    """
    file, data = str(path), read_bytes(Path(path))
    text = _decode(data, file)
    locator = make_locator(file, text)
    return _to_document(file, text, locator, data, overrides, dotted_blocks)


def document_of(
    value: Mapping[str, object] | str,
    file: str,
    overrides: Overrides = (),
    dotted_blocks: Collection[str] = (),
) -> Document:
    """Return the document of a YAML text, or of a mapping, as `read_document` does of a file.

    `file` is its name in messages. A mapping is written as YAML first; numpy values and paths
    become numbers and text. Its problems have a key, but no line.
    """
    if isinstance(value, str):
        text = value
        locator = make_locator(file, text)
    else:
        plain = {
            str(key): plain_value(_to_node(inner, Location(f"{file}[{str(key)!r}]")))
            for key, inner in value.items()
        }
        text = dump(plain)
        locator = _no_place
    check_characters(text, file)
    return _to_document(file, text, locator, text.encode(), overrides, dotted_blocks)


def _no_place(start: Position, end: Position) -> Location:
    """Return the location of what is in no file."""
    return Location("")


def _to_document(
    file: str,
    text: str,
    locator: Locator,
    data: bytes,
    overrides: Overrides,
    dotted_blocks: Collection[str],
) -> Document:
    """Return the document of a text with overrides; raises like `read_document`."""
    tree, problems = parse(text, locator)
    if tree is None:
        raise Location(file).unreadable("the file is empty")
    if not isinstance(tree.value, dict):
        raise tree.location.unreadable(
            f"must be keys such as `name: value`, not {format_value(tree.value)}"
        )
    tree, applied, faults = _apply_overrides(tree, overrides, dotted_blocks)
    return Document(file, hashlib.sha256(data).hexdigest(), tree, problems + faults, applied)


def dump(mapping: Mapping[str, Any]) -> str:
    """Return a mapping as YAML that `read_document` reads back to the same values."""

    class Dumper(yaml.SafeDumper):
        """Quotes text that would be read back as another value."""

    def word(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
        style = None if parse_scalar(text) == text else "'"
        return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)

    Dumper.add_representer(str, word)
    Dumper.ignore_aliases = lambda self, data: True  # type: ignore[method-assign]
    return yaml.dump(mapping, Dumper=Dumper, sort_keys=False, allow_unicode=True, width=96)


# File to text.


MAX_BYTES = 1_000_000
"""Scenarios are written by hand; a larger file is a measured record or an attack."""

FORBIDDEN = re.compile(f"{Reader.NON_PRINTABLE.pattern}|\N{ZERO WIDTH NO-BREAK SPACE}")
"""A character that is not allowed in a text: unprintable, or a byte order mark inside it."""


def read_bytes(path: Path) -> bytes:
    """Return the contents of a regular file of at most 1 MB.

    Raises
    ------
    UnreadableError
        If the path does not exist, is a folder or device, is too large or not readable.
    """
    here = Location(str(path))
    try:
        system.file_size(path)
        data = system.read_regular_file(path, MAX_BYTES + 1)
    except system.NotARegularFile as other:
        inside = _suggest_file_inside(path) if str(other) == "a folder" else "; name a file"
        raise here.unreadable(f"this is {other}{inside}") from None
    except FileNotFoundError:
        why = ": broken symbolic link" if path.is_symlink() else _suggest_file(path)
        if "*" in path.name:
            why = ": no file has a name of this pattern"
        if path.parts[0] in ("http:", "https:"):
            why = ": drysim reads no addresses of the web, only files"
        raise here.unreadable(f"no such file{why}") from None
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or str(fault)
        raise here.unreadable(f"cannot be read: {reason}") from None
    if len(data) > MAX_BYTES:
        raise here.unreadable("larger than 1 MB; is it a record for `excitation.file`?")
    return data


def _decode(data: bytes, file: str) -> str:
    """Decode UTF-8 and remove a byte order mark."""
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
    """Raise at the first character that YAML does not allow."""
    if bad := FORBIDDEN.search(text):
        sentence = f"character U+{ord(bad[0]):04X} is not allowed in a scenario; remove it"
        raise _location_of_character(text, bad.start(), file).unreadable(sentence)


def _location_of_character(text: str, start: int, file: str) -> Location:
    """Return the location of one character, with unprintable ones replaced in its line."""
    before = split_lines(text[:start])
    line, column = len(before) - 1, len(before[-1])
    shown = FORBIDDEN.sub("\N{REPLACEMENT CHARACTER}", text)
    return make_locator(file, shown)((line, column), (line, column + 1))


def _suggest_file(path: Path) -> str:
    """Return a hint with the closest scenario name in the same folder."""
    try:
        names = sorted(os.listdir(path.parent))
    except OSError:
        return ""
    nearest = closest_match(
        path.name, (name for name in names if name.endswith((".yaml", ".yml")))
    )
    return did_you_mean(nearest and str(path.parent / nearest))


def _suggest_file_inside(path: Path) -> str:
    """Return a hint with the only scenario of a folder."""
    files = [*path.glob("*.yaml"), *path.glob("*.yml")]
    return did_you_mean(str(files[0])) if len(files) == 1 else "; name a file in it"


# Text to tree.


MAX_DEPTH = 40
"""Scenarios need five levels. The limit protects the recursive construction of the tree."""

MAX_VALUES = 50_000
"""Limit for the expansion of aliases, far above the number of values in a useful file."""

UNREAD_KEYS = "<<"
"""Marks a mapping with unreadable keys, so that they are not reported as missing as well."""

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_WORDS = {"": None, "~": None, "null": None, "true": True, "false": False}


def parse_scalar(text: str) -> object:
    """Return the value of a plain YAML scalar: number, true, false, None, or the text itself.

    `1e3` is a number; `on`, `no`, `1:30`, `0x10` and dates stay text.
    """
    if NUMBER_PATTERN.fullmatch(text):
        whole = text.lstrip("+-").isdigit() and len(text) <= 18
        return int(text) if whole else float(text)
    word = text if text in _WORDS else text.lower()
    if word in (".inf", "+.inf", "-.inf", ".nan"):
        return float(word.replace(".", ""))
    return _WORDS.get(word, text)


def parse(text: str, locator: Locator) -> tuple[Node | None, tuple[Problem, ...]]:
    """Return the tree of a YAML text, and the errors that do not prevent building it.

    The tree of an empty text is None.

    Raises
    ------
    UnreadableError
        If the text is no YAML, or is excessively large or deep.
    """
    builder = _TreeBuilder(yaml.parse(text, Loader=_LOADER), locator)
    try:
        return builder.document(), tuple(builder.problems)
    except yaml.MarkedYAMLError as fault:
        raise UnreadableError(explain_error(fault, text, locator)) from None


class _TreeBuilder:
    """Builds a tree from the events of a YAML parser."""

    def __init__(self, events: Iterator[Any], locator: Locator) -> None:
        self.events = events
        self.locator = locator
        self.problems: list[Problem] = []
        self.anchors: dict[str, Node | None] = {}
        self.value_count = 0

    def document(self) -> Node | None:
        """Return the tree of the only document; raises like `parse`."""
        tree = None
        for event in self.events:
            if isinstance(event, yaml.DocumentStartEvent):
                if tree is not None:
                    sentence = "a second document starts here; a scenario is one document"
                    raise self.location(event).unreadable(sentence)
                tree = self.node(next(self.events), 0)
        return tree

    def node(self, event: Any, depth: int) -> Node:
        """Return the value that starts with an event."""
        location = self.location(event)
        if depth > MAX_DEPTH:
            raise location.unreadable(f"nested deeper than {MAX_DEPTH} levels")
        if isinstance(event, yaml.AliasEvent):
            return self.alias(event.anchor, location)
        if event.anchor is not None:
            self.anchors[event.anchor] = None
        if event.tag is not None:
            self.problems.append(
                location.problem("tags such as `!!float` are not supported; remove it")
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
            raise location.unreadable(f"more than {MAX_VALUES} values, with aliases expanded")
        if event.anchor is not None:
            self.anchors[event.anchor] = node
        return node

    def alias(self, anchor: Any, location: Location) -> Node:
        """Return the value that an alias refers to."""
        node = self.anchors.get(anchor)
        if node is None:
            word = "contains itself" if anchor in self.anchors else "has no anchor before it"
            raise location.unreadable(f"alias `*{shorten(anchor)}` {word}")
        return node._replace(location=location)

    def sequence(self, location: Location, depth: int) -> Node:
        """Return the list that starts here."""
        values = []
        while not isinstance(event := next(self.events), yaml.SequenceEndEvent):
            values.append(self.node(event, depth + 1))
        return self.collection(values, values, location)

    def mapping(self, location: Location, depth: int, flow: bool) -> Node:
        """Return the mapping that starts here."""
        values: dict[str, Node] = {}
        while not isinstance(event := next(self.events), yaml.MappingEndEvent):
            noted = len(self.problems)
            key = self.node(event, depth + 1)
            if isinstance(key.value, dict | list):
                del self.problems[noted:]  # one error is enough for a key such as `{{ mass }}`
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
        """Return a list or mapping with its size and depth."""
        size = 1 + sum(child.size for child in children)
        depth = 1 + max((child.depth for child in children), default=0)
        if depth > MAX_DEPTH:
            raise location.unreadable(f"nested deeper than {MAX_DEPTH} levels")
        return Node(value, location, size=size, depth=depth)

    def location(self, event: Any) -> Location:
        """Return the location of an event."""
        start, end = event.start_mark, event.end_mark
        return self.locator((start.line, start.column), (end.line, end.column))


def _key_error(event: Any, values: dict[str, Node]) -> str:
    """Return why a key is rejected; empty if it is accepted."""
    if not isinstance(event, yaml.ScalarEvent):
        return "a key must be a word"
    if event.value == UNREAD_KEYS:
        return "merge keys are not supported; write the keys out, or `key: *alias`"
    if first := values.get(event.value):
        line = first.key.line if first.key else 0
        where = f"; the first is in line {line}" if line else ""
        return f"duplicate key `{shorten(event.value)}`{where}"
    return ""


# Explanations of parser errors.


_MISSING_SPACE = re.compile(r"(\s*(?:- +)?)([A-Za-z_][\w.]*):([{\[].*|[^\s:/\\][^:]*)$")
"""A key whose colon is not followed by a space."""


class _ErrorContext(NamedTuple):
    """Where a parser stopped, and where the construct that it was reading begins.

    Lines and columns count from 0.
    """

    lines: list[str]
    stop: Position
    start: Position
    locator: Locator

    @property
    def line(self) -> str:
        """The line in which the parser stopped."""
        return self.lines[self.stop[0]] if self.stop[0] < len(self.lines) else ""

    @property
    def sign(self) -> str:
        """The character at which the parser stopped; empty at the end of the line."""
        return self.line[self.stop[1] : self.stop[1] + 1]

    def here(self, sentence: str, position: Position | None = None, width: int = 1) -> Problem:
        """Return a problem at the position of the error, or at another one."""
        line, column = position or self.stop
        return self.locator((line, column), (line, column + width)).problem(sentence)


def explain_error(fault: yaml.MarkedYAMLError, text: str, locator: Locator) -> Problem:
    """Return a located explanation of an error of the YAML parser."""
    mark, context = fault.problem_mark or fault.context_mark, fault.context_mark
    stop = (mark.line, mark.column) if mark else (0, 0)
    start = (context.line, context.column) if context else stop
    error_context = _ErrorContext(split_lines(text), stop, start, locator)
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
        if stop[0] > start[0]:
            return error_context.here(f"this `{opening}` is not closed by `{closing}`", start)
        return error_context.here(f"`,` or `{closing}` is missing before this")
    if "end of stream" in what and "quoted" in what:
        return error_context.here("this quote is not closed", start)
    if "escape" in what:
        return error_context.here("unknown escape in double quotes; use single quotes", start)
    if re.search(r"expected (key|<block end>|'-' indicator)", what):
        if error_context.line[: error_context.stop[1]].strip():
            return error_context.here("unexpected text after the value")
        sentence = "the indentation of this line matches no block above"
        return error_context.here(sentence, *_first_word(error_context))
    if error_context.line.startswith("%"):
        sentence = "this directive is not understood; remove it"
        return error_context.here(sentence, width=len(error_context.line.rstrip()))
    if "node content" in what:
        behind = f"`{error_context.sign}`" if error_context.sign else "the end"
        return error_context.here(f"a value is missing before {behind}")
    return error_context.here(f"this is not YAML: {shorten(str(fault.problem), 200)}")


def _explain_colon_error(error_context: _ErrorContext) -> Problem:
    """Explain an error caused by a missing or superfluous colon."""
    lines, last = error_context.lines, error_context.stop[0]
    for number in range(last, max(-1, last - 3), -1):
        if glued := _MISSING_SPACE.match(lines[number] if number < len(lines) else ""):
            quoted = f"`{shorten(glued[2])}: {shorten(glued[3])}`"
            sentence = f"a space is missing after the colon: {quoted}"
            return error_context.here(sentence, (number, len(glued[1])), len(glued[2]))
    if ": " in error_context.line[: error_context.stop[1]]:
        return error_context.here("a second `: ` in one value; put the value in quotes")
    number = next((n for n in reversed(range(last)) if lines[n].strip()), last)
    before = lines[number]
    if ":" not in before:
        sentence = "a colon is missing after this key"
        return error_context.here(sentence, (number, _indent(before)), len(before.strip()))
    sentence = "this line is indented deeper than the one before it allows"
    return error_context.here(sentence, *_first_word(error_context))


def _first_word(error_context: _ErrorContext) -> tuple[Position, int]:
    """Return the position and length of the first word of the line."""
    return (error_context.stop[0], _indent(error_context.line)), len(
        (error_context.line.split() or [""])[0]
    )


def _indent(line: str) -> int:
    """Return the number of leading spaces."""
    return len(line) - len(line.lstrip(" "))


# Overrides.


MAX_OVERRIDE_LENGTH = 200
"""Characters of an override in messages."""


def _apply_overrides(
    tree: Node, overrides: Overrides, dotted_blocks: Collection[str]
) -> tuple[Node, dict[str, Any], tuple[Problem, ...]]:
    """Return the tree with the overrides, their plain values, and the problems.

    The value `null` (`KEY=null`) removes a key. Keys of the blocks in `dotted_blocks` may
    contain dots.
    """
    applied: dict[str, Any] = {}
    problems: list[Problem] = []
    for location, key, value in _override_items(overrides):
        try:
            steps = _split_key(key, location)
            for block in dotted_blocks:
                path = block.split(".")
                if steps[: len(path)] == path:
                    steps = _join_dotted_key(tree, path, steps[len(path) :])
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
    """Return the value of a node without locations."""
    if isinstance(node.value, dict):
        return {key: plain_value(child) for key, child in node.value.items()}
    if isinstance(node.value, list):
        return [plain_value(child) for child in node.value]
    return node.value


class OptionOverride(str):
    """An override given by a dedicated option; messages show the option instead of `--set`."""

    label: str

    def __new__(cls, word: str, label: str) -> Self:
        """Create the override `word` for an option such as `--approach signum`."""
        option = super().__new__(cls, word)
        option.label = label
        return option


class _UnparsedText(str):
    """The value of an override from the command line, not yet parsed as YAML."""


def _override_items(overrides: Overrides) -> Iterator[tuple[Location, str, object]]:
    """Yield location, key and value of every override."""
    if isinstance(overrides, Mapping):
        for key, value in overrides.items():
            yield (
                Location(f"overrides[{shorten(repr(key), MAX_OVERRIDE_LENGTH)}]"),
                str(key),
                value,
            )
        return
    assignments = [overrides] if isinstance(overrides, str) else overrides
    if not isinstance(assignments, Sequence) or not all(
        isinstance(word, str) for word in assignments
    ):
        given = shorten(repr(overrides), MAX_OVERRIDE_LENGTH)
        raise UsageError(
            "overrides must be a mapping by dotted key, or words such as "
            f"`friction.kinetic=30`, not {given}"
        )
    for word in assignments:
        key, equals, text = word.partition("=")
        label = word.label if isinstance(word, OptionOverride) else f"--set {word}"
        yield (
            Location(shorten(label, MAX_OVERRIDE_LENGTH)),
            key.strip() if equals else "",
            _UnparsedText(text),
        )


def _split_key(key: str, location: Location) -> list[str]:
    """Split a dotted key."""
    steps = key.split(".")
    if not all(steps) or len(steps) > MAX_DEPTH:
        raise location.unreadable("write KEY=VALUE, such as `friction.kinetic=30`")
    return steps


def _join_dotted_key(tree: Node, path: list[str], rest: list[str]) -> list[str]:
    """Return the path to a value in a block whose keys contain dots.

    What follows the block is one key, unless a prefix of it is an existing key: then the
    remainder is a path inside the value of that key.
    """
    block: Node | None = tree
    for name in path:
        inside = block is not None and isinstance(block.value, dict)
        block = block.value.get(name) if block is not None and inside else None
    keys = block.value if block is not None and isinstance(block.value, dict) else {}
    for end in range(len(rest), 0, -1):
        key = ".".join(rest[:end])
        if key in keys:
            return [*path, key, *rest[end:]]
    return [*path, ".".join(rest)] if rest else path


def _parse_value(text: str, location: Location) -> tuple[Node, tuple[Problem, ...]]:
    """Parse the YAML text of a value."""
    check_characters(text, location.file)
    node, problems = parse(text, lambda start, end: location)
    if node is None:
        raise location.unreadable("has no value; `null` removes the key")
    return node, problems


def _to_node(value: Any, location: Location, depth: int = 0) -> Node:
    """Return the node of a Python value."""
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
        f"a value of type {type(value).__name__} is not allowed in a scenario"
    )


def _from_numpy(value: Any, location: Location) -> Any:
    """Return the Python value of a numpy scalar or array; raise for a masked scalar."""
    converted = getattr(value, "tolist", lambda: value)()
    if converted is None and value is not None:
        what = f"a masked value of type {type(value).__name__}"
        raise location.unreadable(f"{what} is not allowed in a scenario")
    return converted


def _set_node(
    node: Node, steps: list[str], new: Node, location: Location, done: str = ""
) -> Node:
    """Return a copy of the tree with a node replaced; missing blocks are created.

    List entries count from 0.
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
        hint = ""
        if ".measured." in done and isinstance(node.value, str):  # short for its block
            hint = f"; write `{done}={{column: {shorten(node.value)}, {shorten(step)}: …}}`"
        raise location.unreadable(f"{done} is a value; it has no `{shorten(step)}`{hint}")
    children = dict(node.value)
    if rest:
        old = children.get(step, Node({}, location))
        children[step] = _set_node(old, rest, new, location, f"{done}.{step}".strip("."))
    elif new.value is not None:
        children[step] = new
    elif children.pop(step, None) is None:
        nearest = closest_match(step, children)
        hint = did_you_mean(nearest and shorten(nearest))
        raise location.unreadable(f"there is no `{shorten(step)}` to remove{hint}")
    if step in children:
        children[step] = children[step]._replace(
            key=node.value[step].key if rest and step in node.value else location
        )
    return node._replace(value=children)
