"""The text of a file, or a sentence that says why it is none."""

from __future__ import annotations

import os
from pathlib import Path

from yaml.reader import Reader

from drysim import regular
from drysim.quantity import meant, near
from drysim.source.place import Place, Unreadable, placer, split_lines

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
        regular.size(path)
        data = regular.content(path, MAX_BYTES + 1)
    except regular.Irregular as other:
        inside = _inside(path) if str(other) == "a folder" else "; name a file"
        raise Unreadable(here.problem(f"this is {other}{inside}")) from None
    except FileNotFoundError:
        why = ": it is a link that leads nowhere" if path.is_symlink() else _neighbour(path)
        raise Unreadable(here.problem(f"no such file{why}")) from None
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or str(fault)
        raise Unreadable(here.problem(f"cannot be read: {reason}")) from None
    if len(data) > MAX_BYTES:
        raise Unreadable(
            here.problem("larger than 1 MB; is it a record for `excitation.file`?")
        )
    return data


def decoded(data: bytes, file: str) -> str:
    """Give the text of UTF-8 bytes, without its byte order mark.

    Raises
    ------
    Unreadable
        When the bytes are no text, with the place of the first that is none.
    """
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise Unreadable(Place(file).problem("this is UTF-16 text; save it as UTF-8"))
    if b"\0" in data:
        raise Unreadable(Place(file).problem("this is a binary file, not a scenario"))
    data = data.removeprefix(b"\xef\xbb\xbf")
    try:
        text = data.decode()
    except UnicodeDecodeError as fault:
        before = data[: fault.start].decode()
        text = before + data[fault.start :].decode("latin-1")
        sentence = f"byte 0x{data[fault.start]:02X} is not UTF-8; save the file as UTF-8"
        raise Unreadable(_at(text, len(before), file).problem(sentence)) from None
    screen(text, file)
    return text


def screen(text: str, file: str) -> None:
    """Refuse a text with characters that YAML does not know.

    Raises
    ------
    Unreadable
        With the place of the first of them.
    """
    bad = Reader.NON_PRINTABLE.search(text)
    places = [text.find(MARK), bad.start() if bad else -1]
    first = min((place for place in places if place >= 0), default=None)
    if first is not None:
        sentence = f"character U+{ord(text[first]):04X} has no place in a scenario; remove it"
        raise Unreadable(_at(text, first, file).problem(sentence))


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
