"""Rows of CSV: numbers as the shortest text that reads back as the same number."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from drysim import machine
from drysim.core.compiled import is_plain

WORKERS = 4
"""Most threads that make text; one more writes it down, and hardly a disk is faster."""

Text = bytes | memoryview
Given = TypeVar("Given")


class Block(NamedTuple):
    """Columns of numbers, and which word stands in each row; all of shape (n,)."""

    numbers: Sequence[NDArray[np.float64]]
    codes: NDArray[np.generic]


class Cases(NamedTuple):
    """Cases of one approach as columns of numbers, shape (columns, n); NaN for not known."""

    approach: str
    numbers: NDArray[np.float64]
    whole: Sequence[bool]
    status: NDArray[np.int8]


def texts(values: NDArray[np.float64]) -> Iterator[str]:
    """Give the shortest text that reads back as the same number; -0.0 becomes 0.0."""
    return map(repr, (values + 0.0).tolist())


def joined(columns: Iterable[Iterable[str]]) -> bytes:
    """Give columns of cells as rows."""
    return "".join(map("{}\n".format, map(",".join, zip(*columns, strict=True)))).encode()


def rows(blocks: Iterable[Block], words: Sequence[str], place: int) -> Iterator[Text]:
    """Give blocks as rows, in order.

    Parameters
    ----------
    blocks : iterable of Block
    words : sequence of str
        By code.
    place : int
        Columns of numbers before the words.
    """
    if is_plain():
        return (_spoken(words, place, block) for block in blocks)
    return _ahead(partial(_printed, words, place), blocks)


def _spoken(words: Sequence[str], place: int, block: Block) -> bytes:
    """Give the rows of a block, in plain Python."""
    columns: list[Iterable[str]] = [texts(column) for column in block.numbers]
    columns.insert(place, map(words.__getitem__, block.codes.tolist()))
    return joined(columns)


def _printed(words: Sequence[str], place: int, block: Block) -> memoryview:
    """Give the rows of a block by the kernel."""
    from drysim.core.text.digits import WIDTH, put_rows

    numbers, table = np.stack(block.numbers), _table(words)
    longest = len(numbers) * (WIDTH + 1) + table.shape[1] + 1
    out = np.empty(len(block.codes) * longest, np.uint8)
    codes = block.codes.astype(np.int64)
    return out[: put_rows(numbers.view(np.uint64), codes, table, place, out)].data


def _table(words: Sequence[str]) -> NDArray[np.uint8]:
    """Give words as rows of letters, as the kernel wants them."""
    letters = np.array([word.encode() for word in words])
    return letters.view(np.uint8).reshape(len(words), -1)


def cases(blocks: Iterable[Cases], words: Sequence[str], place: int) -> Iterator[Text]:
    """Give blocks of cases as rows, in order; `words` and `place` are those of the status."""
    if is_plain():
        return (_listed(words, place, block) for block in blocks)
    return _ahead(partial(_put, words, place), blocks)


def _listed(words: Sequence[str], place: int, block: Cases) -> bytes:
    """Give the rows of a block of cases, in plain Python."""
    columns: list[Iterable[str]] = []
    for column, whole in zip(block.numbers.tolist(), block.whole, strict=True):
        kind = int if whole else float
        columns.append(["" if x != x else str(kind(x) + 0) for x in column])
    columns.insert(place, map(words.__getitem__, block.status.tolist()))
    return joined([[block.approach] * len(block.status), *columns])


def _put(words: Sequence[str], place: int, block: Cases) -> memoryview:
    """Give the rows of a block of cases by the kernel."""
    from drysim.core.text.cells import put_cases
    from drysim.core.text.digits import WIDTH

    table = _table(words)
    name = np.frombuffer(block.approach.encode(), np.uint8)
    longest = len(block.numbers) * (WIDTH + 1) + table.shape[1] + len(name) + 2
    out = np.empty(len(block.status) * longest, np.uint8)
    whole, codes = np.array(block.whole), block.status.astype(np.int64)
    bits = np.ascontiguousarray(block.numbers).view(np.uint64)
    return out[: put_cases(bits, whole, name, codes, table, place, out)].data


def _ahead(make: Callable[[Given], memoryview], blocks: Iterable[Given]) -> Iterator[Text]:
    """Give the text of every block, in order; some are made ahead, in threads."""
    from drysim.study.in_order import in_order

    return in_order(make, blocks, min(machine.processors(), WORKERS))


def text(value: float | None) -> str:
    """Give the shortest text that reads back as the same number; nothing for not known."""
    return "" if value is None else str(value + 0)
