"""Packages that read one format: imported late, kept quiet, their exceptions made faults."""

from __future__ import annotations

import gc
import logging
import re
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, TypeVar

from drysim.errors import RecordError
from drysim.excitation.record.file import Cell, File, fault

T = TypeVar("T")

COPY = re.compile(r"'?<_io\.BytesIO [^>]*>'?")
"""How packages name the bytes that they were given in place of a file."""


def package(module: str, extra: str, file: File, name: str = "") -> Any:
    """Give a package that only one format needs; `name` is what it is called, if otherwise.

    Raises
    ------
    RecordError
        When it is not installed; the sentence says how to install it.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return import_module(module)
    except ImportError:
        sentence = f"a `{file.path.suffix}` record needs the package {name or module}"
        way = f'pip install "drysim[{extra}]"'
        raise fault(file.shown, f"{sentence}; install it by: {way}") from None


def read_by(read: Callable[[], T], file: File, what: str) -> T:
    """Let a package read: without its warnings and its log, and with what it raises as a fault.

    Raises
    ------
    RecordError
        For any exception; its sentence begins with `what`.
    """
    with _hushed():
        try:
            return read()
        except RecordError:
            raise
        except Exception as error:  # a parser raises whatever a damaged file leads it to
            why = _why(error)
        gc.collect()  # half-made readers may complain once more when they are let go
    raise fault(file.shown, f"{what}: {why}")


def _why(error: Exception) -> str:
    """Give what an exception says in one short line, without what it calls our copy."""
    words = COPY.sub("the file", " ".join(str(error).split()))
    return Cell(words, 0).quote or type(error).__name__


@contextmanager
def _hushed() -> Iterator[None]:
    log, hook = logging.root.manager.disable, sys.unraisablehook
    logging.disable(logging.CRITICAL)
    sys.unraisablehook = lambda _: None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        sys.unraisablehook = hook
        logging.disable(log)
