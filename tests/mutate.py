"""Change the core in one place at a time, and see whether the tests notice.

    python tests/mutate.py [COUNT [FILE ...]]

COUNT changes are drawn in each file of the core (default 10), always the same; each is made in
a copy of the source, on which those tests of the core run that need no compiler. What they do
not notice is printed, with the counts.
"""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from random import Random

HOME = Path(__file__).parents[1]
CORE = HOME / "src" / "drysim" / "core"
ORACLE = (
    "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", "not slow",
    "-k", "not compiled and not agree and not newton_leaves and not block_is",
    "--ignore=tests/core/test_decimal.py", "--ignore=tests/core/test_march_against_leap.py",
    "--ignore=tests/core/test_twins.py",
    "tests/core", "tests/independent/test_found.py",
    "tests/independent/test_solution.py::test_friction_that_varies_agrees_with_fifty_digits",
)  # fmt: skip
TOO_LONG = 240.0
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


def noticed(folder: Path) -> bool:
    """Whether the tests fail on the source in a folder."""
    environment = {**os.environ, "PYTHONPATH": str(folder), "DRYSIM_ENGINE": "plain"}
    try:
        done = subprocess.run(
            [sys.executable, *ORACLE], cwd=folder.parent, env=environment, capture_output=True,
            timeout=TOO_LONG, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return True
    return done.returncode != 0


def main(count: int, names: list[str]) -> None:
    """Try the drawn changes of every file, and say which survive."""
    files = [CORE / f"{name}.py" for name in names] or sorted(CORE.glob("[a-z]*.py"))
    with tempfile.TemporaryDirectory() as home:
        folder = Path(home) / "src"
        for part in ("src", "tests", "scenarios"):
            shutil.copytree(HOME / part, folder.parent / part)
        shutil.copy(HOME / "pyproject.toml", home)
        assert not noticed(folder), "the tests fail without any change"
        tried, lived = 0, 0
        for file in files:
            text, copy = file.read_text(), folder / "drysim" / "core" / file.name
            every = list(mutants(text))
            for row, line, source in Random(1).sample(every, min(count, len(every))):
                copy.write_text(source)
                tried += 1
                if not noticed(folder):
                    lived += 1
                    print(f"{file.name}:{row}: {line}", flush=True)
            copy.write_text(text)
            print(f"{file.name}: {tried} changes so far, {lived} not noticed", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10, sys.argv[2:])
