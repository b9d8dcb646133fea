"""What a machine can write of README.md: tables of keys and metrics, and what is printed.

`make readme` runs this file, which writes them anew. With the name of a folder it works there,
and prints what it has seen.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from drysim.cli import main
from drysim.errors import EXIT_BUG
from drysim.metrics.table import METRICS
from drysim.scenario import schema

FILE = Path(__file__).parents[2] / "README.md"
README = FILE.read_text(encoding="utf-8")
PART = re.compile(r"(<!-- (keys|metrics) -->\n)(.*?)(?=<!-- end -->)", re.S)
PYTHON = re.compile(r"(^```python\n(.*?)^```\n+```text\n)(.*?)(?=^```$)", re.S | re.M)
CONSOLE = re.compile(r"(?<=^```console\n).*?(?=^```$)", re.S | re.M)

TERMINAL = {"COLUMNS": "100", "LINES": "50", "TERM": "dumb", "DRYSIM_ENGINE": "compiled"}
"""A screen as wide as the README; a dumb terminal takes no colour and no progress bar."""

CONSTANT = {"const", "default"}
"""A key with the first of these and without the other tells kinds of a block apart."""


NOTES = "Notes\n-----"
"""A heading of docstrings, which has no place within a line."""

OPTIONS = "Options of another law, any of its keys: they count where a comparison names it."
"""What stands for the blocks of all laws that a block of one law may hold."""


def keys() -> Iterator[str]:
    """Give a heading and a table for every block of a scenario, and for every kind of one."""
    words = schema()
    yield table(list(rows(words, words, deep=False)))
    for key, field in words["properties"].items():
        for way, block in blocks(words, field):
            tag = [f"`{name}: {given['const']}`" for name, given in constants(block)]
            yield f"\n#### {' with '.join([f'`{key}{way}`', *tag])}\n\n"
            about = " ".join(block.get("description", "").replace(NOTES, "").split())
            parts = [about, table(list(rows(words, block)))]
            yield "\n\n".join(filter(None, parts)).rstrip("\n") + "\n"


def table(lines: list[tuple[str, ...]]) -> str:
    """Give a table of keys, if there are any."""
    if not lines:
        return ""
    head = ("key", "unit", "default", "meaning")
    cells = [head, ("---",) * len(head), *lines]
    return "".join(f"| {' | '.join(line)} |\n" for line in cells)


def rows(words, block, prefix="", deep=True) -> Iterator[tuple[str, ...]]:
    """Give key, unit, default and meaning of every key of a block, and of the blocks in it."""
    tags, told = [name for name, _ in constants(block)], False
    for key, field in block["properties"].items():
        if key in tags or (optional(field) and told):
            continue
        told = told or optional(field)
        if optional(field):
            yield f"`{prefix}<law>`", "", "–", OPTIONS
            continue
        text, unit = meaning(field)
        yield f"`{prefix}{key}`", unit, default(block, key, field), text
        for way, inner in blocks(words, field) if deep else ():
            yield from rows(words, inner, f"{prefix}{key}{way}.")


def optional(field) -> bool:
    """Whether a field holds the options of another friction law."""
    return field.get("$ref", "").endswith("Options")


def meaning(field) -> tuple[str, str]:
    """Give what a key means, and the unit that its text names in brackets."""
    text = " ".join(field["description"].split())
    unit = "".join(re.findall(r" \[([^\], ]+)\]", re.sub("`[^`]*`", "", text))[:1])
    text = text.replace(f" [{unit}]", "", 1).replace("|", "\\|")
    choices = field.get("enum", ())
    if choices and not (str(choices[0]) in text and str(choices[-1]) in text):
        text += f" One of {', '.join(f'`{word}`' for word in choices)}."
    return text, unit.replace("-", "–")


def default(block, key, field) -> str:
    """Give what a key is when nobody says it."""
    if key in block.get("required", ()):
        return "**required**"
    for rule in block.get("allOf", ()):
        either = [option["required"][0] for option in rule.get("oneOf", ())]
        if key in either:
            others = " or ".join(f"`{other}`" for other in either if other != key)
            return f"**required**, or {others}"
    value = field.get("default")
    for rule in block.get("allOf", ()):
        either = [option["required"][0] for option in rule.get("anyOf", ())]
        if key in either and value is not None:
            others = " or ".join(f"`{other}`" for other in either if other != key)
            return f"**required**, or {others}: then `{value}`"
    if isinstance(value, bool | float):
        value = f"{value:g}" if isinstance(value, float) else str(value).lower()
    return "–" if value in (None, "", []) or isinstance(value, dict) else f"`{value}`"


def constants(block) -> list[tuple[str, dict]]:
    """Give the keys by which a block says of what kind it is."""
    properties = block["properties"].items()
    return [(key, field) for key, field in properties if {"const"} == field.keys() & CONSTANT]


def blocks(words, field) -> Iterator[tuple[str, dict]]:
    """Give the blocks that a field may hold, and the way there: a list, a key, or none."""
    if "$ref" in field:
        field = words["$defs"][field["$ref"].rpartition("/")[2]]
    if "properties" in field:
        yield "", field
    for part in (*field.get("oneOf", ()), *field.get("anyOf", ())):
        yield from blocks(words, part)
    for key, way in (("items", "[]"), ("additionalProperties", ".<key>")):
        if isinstance(field.get(key), dict):
            yield from ((way + further, block) for further, block in blocks(words, field[key]))
    for named in field.get("patternProperties", {}).values():
        yield from ((".<key>" + further, block) for further, block in blocks(words, named))


def metrics() -> Iterator[str]:
    """Give the table of metrics."""
    yield "| metric | unit | meaning |\n| --- | --- | --- |\n"
    for name, unit, about in METRICS:
        about = about.replace("|", "\\|")
        yield f"| `{name}` | {unit.replace('m/s2', 'm/s²').replace('-', '–')} | {about} |\n"


MADE = {"keys": keys, "metrics": metrics}


def made(name: str) -> str:
    """Give what belongs between the markers of a name."""
    return "".join(MADE[name]())


class Screen(io.StringIO):
    """Stdout and stderr as a terminal shows them."""

    def isatty(self) -> bool:
        """Say yes, so that long sentences are set in lines."""
        return True


def said(command: str, code: int) -> tuple[str, int]:
    """Give what a command shows, and its exit code; `$?` is the code of the one before."""
    if command.startswith("drysim "):
        screen = Screen()
        with contextlib.redirect_stdout(screen), contextlib.redirect_stderr(screen):
            code = main(shlex.split(command)[1:])
        assert code != EXIT_BUG, screen.getvalue()
        return screen.getvalue(), code
    shell = ["sh", "-c", f"(exit {code}); {command}"]
    done = subprocess.run(
        shell, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8"
    )
    return done.stdout, done.returncode


def screens() -> Iterator[str]:
    """Type every command of the README, block after block, and give each block anew."""
    code = 0
    for block in CONSOLE.findall(README):
        screen = ""
        for line in re.findall(r"^\$ (.*)$", block, re.M):
            answer, code = said(line, code)
            screen += f"$ {line}\n{answer}"
        yield re.sub(r" +$", "", screen, flags=re.M)


def printed(program: str) -> str:
    """Give what a program of the README prints."""
    screen = io.StringIO()
    with contextlib.redirect_stdout(screen):
        exec(program, {})
    return screen.getvalue()


def followed(folder: str) -> dict[str, list[str]]:
    """Follow the README in a folder from its first command to its last, then its Python."""
    os.chdir(folder)
    os.environ.pop("FORCE_COLOR", None)
    os.environ |= TERMINAL
    programs = [program for _, program, _ in PYTHON.findall(README)]
    return {"screens": list(screens()), "printed": [printed(program) for program in programs]}


def renewed(seen: dict[str, list[str]]) -> str:
    """Give the README with its tables of today, and with what was seen on the way."""
    text = PYTHON.sub(lambda part: part[1] + seen["printed"].pop(0), README)
    text = CONSOLE.sub(lambda _: seen["screens"].pop(0), text)
    return PART.sub(lambda part: part[1] + made(part[2]), text)


if __name__ == "__main__":
    if sys.argv[1:]:
        print(json.dumps(followed(sys.argv[1])))
    else:
        with tempfile.TemporaryDirectory() as folder:
            text = renewed(followed(folder))
        FILE.write_text(text, encoding="utf-8", newline="\n")
