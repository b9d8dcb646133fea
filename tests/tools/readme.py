"""Generated parts of README.md and the manual: tables from the code, and what commands print.

`make readme` runs this file, which writes them anew; names of pages limit it to these. Every
page is followed in a folder of its own.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

from typer.main import get_command

from drysim.cli import app, main
from drysim.errors import EXIT_BUG
from drysim.manual import pages
from drysim.manual.words import Entry, blocks
from drysim.metrics.table import FIT_METRICS, METRICS

ROOT = Path(__file__).parents[2]
FILES = {"README": ROOT / "README.md"} | {name: page.file for name, page in pages().items()}
"""The README and the pages of the manual, by name."""

TEXTS = {name: file.read_text(encoding="utf-8") for name, file in FILES.items()}
README = TEXTS["README"]
PART = re.compile(r"(<!-- (keys|metrics|commands|speed) -->\n)(.*?)(?=<!-- end -->)", re.S)
YAML = re.compile(r"<!-- file (\S+) -->\n```yaml\n(.*?)^```$", re.S | re.M)
PYTHON = re.compile(r"(^```python\n(.*?)^```\n+```text\n)(.*?)(?=^```$)", re.S | re.M)
CONSOLE = re.compile(r"(?<=^```console\n).*?(?=^```$)", re.S | re.M)

TERMINAL = {"COLUMNS": "100", "LINES": "50", "TERM": "dumb", "DRYSIM_ENGINE": "compiled"}
"""A terminal as wide as the pages; a dumb one takes no colour and no progress bar."""


def keys() -> Iterator[str]:
    """Write a heading and a table for every block of a scenario, and for every kind of it."""
    for block in blocks():
        if block.path:
            kind = f" with `{block.kind}`" if block.kind else ""
            yield f"\n## `{block.path}`{kind}\n\n"
        prefix = f"{block.path}." if block.path else ""
        lines = [row(one, prefix) for one in block.keys]
        yield "\n\n".join(filter(None, [block.text, table(lines)])).rstrip("\n") + "\n"


def row(key: Entry, prefix: str) -> tuple[str, ...]:
    """Return a key as a row, without the path of its block."""
    name, unit = key.word.removeprefix(prefix), key.unit.replace("-", "–")
    text, choices = key.text.replace("|", "\\|"), [choice for choice, _ in key.choices]
    if choices and not (choices[0] in text and choices[-1] in text):
        text += f" One of {', '.join(f'`{choice}`' for choice in choices)}."
    return f"`{name}`", unit, shown(key.default), text


def shown(default: str) -> str:
    """Return a default as a cell: values in code, what must be given in bold."""
    if default.startswith("required"):
        return re.sub("^required", "**required**", default)
    return f"`{default}`" if default else "–"


def table(lines: list[tuple[str, ...]]) -> str:
    """Write a table of keys, if there are any."""
    head = ("key", "unit", "default", "meaning")
    cells = [head, ("---",) * len(head), *lines]
    return "".join(f"| {' | '.join(line)} |\n" for line in cells) if lines else ""


def metrics() -> Iterator[str]:
    """Write the table of metrics."""
    yield "| metric | unit | meaning |\n| --- | --- | --- |\n"
    for name, unit, about, *_ in (*METRICS, *FIT_METRICS):
        about = about.replace("|", "\\|")
        yield f"| `{name}` | {unit.replace('m/s2', 'm/s²').replace('-', '–')} | {about} |\n"


def commands() -> Iterator[str]:
    """Write every command with its help and a table of its arguments and options."""
    group = get_command(app)
    for name, command in group.commands.items():
        words = " ".join(filter(None, [f"drysim {name}", *map(usage, command.params)]))
        yield f"\n## `{words}`\n\n{command.help}\n"
        options = [one for one in command.params if one.name != "help"]
        yield "\n| option | meaning |\n| --- | --- |\n" if options else ""
        for one in options:
            about = " ".join((getattr(one, "help", "") or "").split()).replace("|", "\\|")
            yield f"| `{spelled(one)}` | {about} |\n"
    yield "\n"


def usage(one) -> str:
    """Return an argument as the usage line has it; nothing for options."""
    if one.param_type_name != "argument":
        return ""
    word = one.metavar or one.name.upper()
    return word if one.required else f"[{word}]"


def spelled(one) -> str:
    """Return an option or argument with its metavar."""
    if one.param_type_name == "argument":
        return one.metavar or one.name.upper()
    names = ", ".join([*one.opts, *one.secondary_opts])
    if one.is_flag:
        return names
    choices = get_args(one.type_descriptor.annotation)
    words = [word for word in choices if isinstance(word, str)]
    word = one.metavar or "|".join(words) or "N"
    return f"{names} {word}".replace("|", "\\|")


SHORT = ("stick-slip", "signum", "solve_ivp events DOP853")
"""Rows of the measured table of speed and error that the README shows, by their beginnings."""


def speed() -> Iterator[str]:
    """Write the short table of speed and error, from the measured one."""
    (table,) = re.findall(r"<!-- proof -->\n(.*?)<!-- end -->", TEXTS["speed"], re.S)
    lines = table.splitlines()
    shown = [line for line in lines[2:] if line.removeprefix("| ").startswith(SHORT)]
    yield from (f"{line}\n" for line in [*lines[:2], *shown])


MADE = {"keys": keys, "metrics": metrics, "commands": commands, "speed": speed}


def made(name: str) -> str:
    """Return what belongs between the markers of a name."""
    return "".join(MADE[name]())


class Screen(io.StringIO):
    """Stdout and stderr as a terminal shows them."""

    def isatty(self) -> bool:
        """Claim to be a terminal, so that long sentences are wrapped."""
        return True


def said(command: str, code: int) -> tuple[str, int]:
    """Return what a command prints, and its exit code; `$?` is the code of the one before."""
    if command.startswith("drysim "):
        command, _, following = command.partition(" | ")
        screen = Screen()
        stdout = io.StringIO() if following else screen
        with contextlib.redirect_stdout(stdout), contextlib.redirect_stderr(screen):
            code = main(shlex.split(command)[1:])
        assert code != EXIT_BUG, screen.getvalue()
        if not following:
            return screen.getvalue(), code
        kept = subprocess.run(
            ["sh", "-c", following],
            input=stdout.getvalue(),
            stdout=subprocess.PIPE,
            encoding="utf-8",
        )
        return screen.getvalue() + kept.stdout, kept.returncode
    shell = ["sh", "-c", f"(exit {code}); {command}"]
    done = subprocess.run(
        shell, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8"
    )
    return done.stdout, done.returncode


def screens(text: str) -> Iterator[str]:
    """Type every command of a page, block after block, and return each block anew."""
    code = 0
    for block in CONSOLE.findall(text):
        screen = ""
        for line in re.findall(r"^\$ (.*)$", block, re.M):
            answer, code = said(line, code)
            screen += f"$ {line}\n{answer}"
        yield re.sub(r" +$", "", screen, flags=re.M)


def printed(program: str) -> str:
    """Return what a program of a page prints."""
    screen = io.StringIO()
    with contextlib.redirect_stdout(screen):
        exec(program, {})
    return screen.getvalue()


def followed(name: str, folder: str) -> dict[str, list[str]]:
    """Follow a page in a folder from its first command to its last, then its Python."""
    os.chdir(folder)
    os.environ.pop("FORCE_COLOR", None)
    os.environ |= TERMINAL
    text = TEXTS[name]
    for file, content in YAML.findall(text):
        Path(file).write_text(content, encoding="utf-8")
    programs = [program for _, program, _ in PYTHON.findall(text)]
    return {
        "screens": list(screens(text)),
        "printed": [printed(program) for program in programs],
    }


def renewed(text: str, seen: dict[str, list[str]]) -> str:
    """Return a page with its tables of today, and with what was seen on the way."""
    text = PYTHON.sub(lambda part: part[1] + seen["printed"].pop(0), text)
    text = CONSOLE.sub(lambda _: seen["screens"].pop(0), text)
    return PART.sub(lambda part: part[1] + made(part[2]), text)


if __name__ == "__main__":
    for name in sys.argv[1:] or TEXTS:
        with tempfile.TemporaryDirectory() as folder:
            text = renewed(TEXTS[name], followed(name, folder))
            os.chdir(ROOT)
        FILES[name].write_text(text, encoding="utf-8", newline="\n")
