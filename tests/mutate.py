"""Change the core in one place at a time, and see whether the tests notice.

    python tests/mutate.py [COUNT [FILE ...]]

COUNT changes are drawn in each file of the core (default 10), always the same; each is made in
a copy of the source, on which the tests of the core run that need no compiler, in a fork of a
process that has loaded what they need. What they do not notice is printed, with the counts;
what nothing can notice stands with its reason in survivors.py.
"""

from __future__ import annotations

import ast
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from random import Random

import mpmath  # noqa: F401
import numpy  # noqa: F401
import pytest

from survivors import EXPLAINED

HOME = Path(__file__).parents[1]
CORE = HOME / "src" / "drysim" / "core"
ORACLE = (
    "tests/core", "tests/independent", "tests/properties", "tests/test_many_records.py",
    "tests/test_orbit_blocks.py", "tests/test_grid_under_sines.py", "tests/test_approaches.py",
)  # fmt: skip
COMPILED = ("fast", "compiled", "twins", "against_leap", "leaves_the_numbers", "hard_records")
"""What is in the names of tests, or of their fixtures, that need the compiler."""

OWN = {
    "decimal": ("decimal", "digits"), "fine_scan": ("stop", "flow", "series"),
    "many_records": ("records", "pieces", "stretches"), "undamped_orbits": ("orbit", "orbits"),
}  # fmt: skip
"""Tests that cost much, and the files of the core that alone are put to them."""

TOO_LONG = 100
"""Seconds after which a change that never ends counts as noticed."""

SWAPS: dict[type, str] = {
    ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "==",
    ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.And: "or", ast.Or: "and",
}  # fmt: skip


def mutants(text: str) -> Iterator[tuple[int, str, str]]:
    """Give every change of a source: its line, the line as it was, and the changed source."""
    lines = text.splitlines(keepends=True)
    for node in ast.walk(ast.parse(text)):
        for left, right, sign in gaps(node):
            row, begin, end = left.end_lineno, left.end_col_offset, right.col_offset
            line = lines[row - 1].encode()
            if right.lineno != row or b"#" in line[begin:end]:
                continue
            between = line[begin:end].decode()
            words = between.split()
            middle = next((word for word in words if word not in "()"), "")
            if not middle:
                continue
            swapped = between.replace(middle, sign, 1).encode()
            changed = line[:begin] + swapped + line[end:]
            yield row, changed.decode().strip(), replaced(lines, row, changed.decode())
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
            line = lines[node.lineno - 1].encode()
            other = b"1.0" if node.value == 0 else repr(-node.value).encode()
            changed = line[: node.col_offset] + other + line[node.end_col_offset :]
            yield (
                node.lineno,
                changed.decode().strip(),
                replaced(lines, node.lineno, changed.decode()),
            )


def gaps(node: ast.AST) -> Iterator[tuple[ast.expr, ast.expr, str]]:
    """Give the neighbours of every operator, with what it becomes."""
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in SWAPS:
        yield node.left, node.comparators[0], SWAPS[type(node.ops[0])]
    elif isinstance(node, ast.BinOp) and type(node.op) in SWAPS:
        yield node.left, node.right, SWAPS[type(node.op)]
    elif isinstance(node, ast.BoolOp):
        yield node.values[0], node.values[1], SWAPS[type(node.op)]


def replaced(lines: list[str], row: int, line: str) -> str:
    """Give the source with another line in a row."""
    return "".join([*lines[: row - 1], line, *lines[row:]])


class Choice:
    """Tests that a change in a file is put to: those of its name first."""

    def __init__(self, name: str) -> None:
        self.name = name

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out what needs the compiler, or has nothing to do with the file."""
        items[:] = sorted(filter(self.serves, items), key=self.distance)

    def serves(self, item: pytest.Item) -> bool:
        """Whether a test may say anything about the file."""
        words = f"{item.nodeid} {' '.join(getattr(item, 'fixturenames', ()))}"
        own = next((files for part, files in OWN.items() if part in item.nodeid), (self.name,))
        return not any(word in words for word in COMPILED) and self.name in own

    def distance(self, item: pytest.Item) -> int:
        """Give how far a test is from the file."""
        return 0 if self.name.rstrip("s") in item.path.stem else 1 + ("core" not in item.nodeid)


def noticed(folder: Path, name: str) -> bool:
    """Whether the tests fail on the source in a folder, changed in the file of a name."""
    child = os.fork()
    if child == 0:
        signal.alarm(TOO_LONG)
        os.chdir(folder.parent)
        with open(os.devnull, "w") as nothing:
            os.dup2(nothing.fileno(), 1)
            os.dup2(nothing.fileno(), 2)
        sys.path.insert(0, str(folder))
        os.environ |= {"PYTHONPATH": str(folder), "DRYSIM_ENGINE": "plain"}
        words = ["-x", "-q", "-p", "no:cacheprovider", "-m", "not slow", *ORACLE]
        os._exit(int(pytest.main(words, plugins=[Choice(name)]) != 0))
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) != 0


def main(count: int, names: list[str]) -> None:
    """Try the drawn changes of every file, and say which survive."""
    # Two changes within a second may be alike in size and time: no byte code is kept.
    sys.dont_write_bytecode = True
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
    files = sorted(CORE.rglob("[a-z]*.py"))
    files = [file for file in files if not names or file.stem in names]
    without = shutil.ignore_patterns("__pycache__", "pictures")
    with tempfile.TemporaryDirectory() as home:
        folder = Path(home) / "src"
        for part in ("src", "tests", "scenarios"):
            shutil.copytree(HOME / part, folder.parent / part, ignore=without)
        shutil.copy(HOME / "pyproject.toml", home)
        tried, lived, told = 0, 0, 0
        for file in files:
            text, copy = file.read_text(), folder / file.relative_to(HOME / "src")
            assert not noticed(folder, file.stem), "the tests fail without any change"
            every = list(mutants(text))
            for row, line, source in Random(1).sample(every, min(count, len(every))):
                copy.write_text(source)
                tried += 1
                if noticed(folder, file.stem):
                    continue
                why = EXPLAINED.get((file.name, line))
                lived, told = lived + (why is None), told + (why is not None)
                print(f"{file.name}:{row}: {line}" + (f" ({why})" if why else ""), flush=True)
            copy.write_text(text)
            so_far = f"{tried} changes so far, {lived} not noticed"
            print(f"{file.name}: {so_far}, and {told} that nothing can notice", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10, sys.argv[2:])
