"""Changes of a source in one place: another operator, another sign of a number, no for yes."""

from __future__ import annotations

import ast
from collections.abc import Iterator

SWAPS: dict[type, str] = {
    ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "==",
    ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.And: "or", ast.Or: "and",
}  # fmt: skip


def mutants(text: str) -> Iterator[tuple[int, str, str]]:
    """Return every change of a source: its line, the line as it was, and the changed source."""
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
            yes_or_no = isinstance(node.value, bool)
            other = repr(not node.value if yes_or_no else -node.value or 1.0).encode()
            changed = line[: node.col_offset] + other + line[node.end_col_offset :]
            yield (
                node.lineno,
                changed.decode().strip(),
                replaced(lines, node.lineno, changed.decode()),
            )


def gaps(node: ast.AST) -> Iterator[tuple[ast.expr, ast.expr, str]]:
    """Return the neighbours of every operator, with what it becomes."""
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in SWAPS:
        yield node.left, node.comparators[0], SWAPS[type(node.ops[0])]
    elif isinstance(node, ast.BinOp) and type(node.op) in SWAPS:
        yield node.left, node.right, SWAPS[type(node.op)]
    elif isinstance(node, ast.BoolOp):
        yield node.values[0], node.values[1], SWAPS[type(node.op)]


def replaced(lines: list[str], row: int, line: str) -> str:
    """Return the source with another line in a row."""
    return "".join([*lines[: row - 1], line, *lines[row:]])
