"""Optional packages that read records: imported on demand, silenced, faults as record errors.

A package is handed a file of unknown origin. It gets the bytes that were hashed, never a name
from within the file, and none of its functions that evaluates text of the file is called:
`drysim.records.mdf` reads raw values and applies conversions itself.
"""

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
from drysim.records.columns import (
    NO_FULL_SCALE,
    NOT_TEXT,
    USE_CHANNEL,
    ColumnLabel,
    RecordFile,
    shorten_quote,
)

T = TypeVar("T")

UNUSED_KEYS = {**NOT_TEXT, "column": USE_CHANNEL, "full_scale": NO_FULL_SCALE}
"""Keys without meaning for all formats that optional packages read."""

BUFFER_REPR = re.compile(r"'?<_io\.BytesIO [^>]*>'?")
"""How packages refer to the in-memory copy of a file."""


def import_package(module: str, extra: str, file: RecordFile, name: str = "") -> Any:
    """Import an optional package; raise with the installation command if it is missing.

    `name` is the name of the distribution if it differs from the module.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return import_module(module)
    except ImportError:
        sentence = f"a `{file.path.suffix}` record needs the package {name or module}"
        command = f'pip install "drysim[{extra}]"'
        raise file.error(f"{sentence}; install it with: {command}") from None


def call_package(read: Callable[[], T], file: RecordFile, what: str) -> T:
    """Call a package silently; any exception becomes a record error that begins with `what`."""
    with _silenced():
        try:
            return read()
        except RecordError:
            raise
        except Exception as error:  # parsers raise exceptions of any type on damaged files
            text = BUFFER_REPR.sub("the file", " ".join(str(error).split()))
            why = shorten_quote(text) or type(error).__name__
        gc.collect()  # incomplete readers may report errors when they are deleted
    raise file.error(f"{what}: {why}")


def label_of_samples(name: str, unit: str) -> ColumnLabel:
    """Return the label of a channel; programs write comments in place of its unit, too."""
    return ColumnLabel(name, name, unit, is_unit_certain=False)


def label_of_times(name: str, unit: str) -> ColumnLabel:
    """Return the label of the times of a channel."""
    return ColumnLabel(f"time of {name}", f"time of {name}", unit)


@contextmanager
def _silenced() -> Iterator[None]:
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
