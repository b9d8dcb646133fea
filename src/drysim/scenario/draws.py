"""Draws that a fit has kept, as values of a sweep or conditions of a design."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, NamedTuple

from drysim import system
from drysim.messages import format_value
from drysim.wording import format_count

DRAWS_FILE, RESULT_FILE = "draws.csv", "drysim.json"
"""The draws of a fit, and the file that says which kind of result a folder is."""

OF_THE_RECORD = ("measured.", "start.")
"""Beginnings of the keys that say something of the record only."""

AGAIN = "repeat `drysim fit`"


class FitDraws(NamedTuple):
    """Draws of the fitted values, by key."""

    name: str
    """Folder of the fit, or their table, from the folder of the scenario."""
    path: Path
    columns: dict[str, tuple[float, ...]]
    """Values in SI."""
    units: dict[str, str]
    """Units as in table headers."""

    @property
    def label(self) -> str:
        """The folder in a text; its name where it is that of the scenario itself."""
        return self.name if Path(self.name).name else self.path.resolve().name

    def __len__(self) -> int:
        """Return the number of draws."""
        return len(next(iter(self.columns.values())))


def read_draws(folder: Path, name: object) -> FitDraws:
    """Return the draws of a fit.

    Parameters
    ----------
    folder : Path
        That of the scenario.
    name : object
        Folder of the fit, or its draws alone, as the scenario names it.

    Raises
    ------
    ValueError
        If there is no such fit, it has no draws, or they were changed.
    """
    if not isinstance(name, str) or not name:
        form = "the folder of a fit, such as `out/fit-seat`"
        raise ValueError(f"must be {form}, not {format_value(name)}")
    if os.path.isabs(name):
        name = system.relative_path(name, folder)
    if not (folder / name).exists():
        name = name.replace("\\", "/")  # as Windows separates folders
    path = folder / name
    if not path.exists():
        raise ValueError(f"names a folder that does not exist: {format_value(name)}")
    if path.is_dir():
        check_fit(path, name)
    try:
        text = draws_file(path).read_text(encoding="utf-8")
        header, *rows = text.splitlines()
        units = dict(head.removesuffix("]").split(" [") for head in header.split(","))
        texts = zip(*(row.split(",") for row in rows), strict=True)
        columns = {
            key: tuple(map(float, column))
            for key, column in zip(units, texts, strict=True)
            if "." in key and not key.startswith(OF_THE_RECORD)
        }  # a metric may have no value
    except (OSError, ValueError, UnicodeError) as fault:
        raise ValueError(f"names a table of draws that cannot be read: {name}") from fault
    if not columns:
        raise ValueError(f"names a fit of no key that another scenario has: {name}")
    return FitDraws(name, path, columns, {key: units[key] for key in columns})


def draws_file(path: Path) -> Path:
    """Return the table of draws, given the folder of a fit or the table itself."""
    return path / DRAWS_FILE if path.is_dir() else path


def path_from(path: Path, folder: Path) -> str:
    """Return the path of a fit from another folder."""
    return system.relative_path(os.path.realpath(path), os.path.realpath(folder))


def check_fit(path: Path, name: str) -> None:
    """Raise a ValueError unless a folder is that of a fit, whose draws are as it wrote them."""
    fields = result_fields(path, name)
    kind = fields.get("kind")
    if kind != "fit":
        raise ValueError(f"names the result of `drysim {kind}`, not of a fit: {name}")
    listed = fields.get("files", {}).get(DRAWS_FILE)
    reason = fields.get("fit", {}).get("draws", {}).get("reason")
    if not listed:
        why = f"{reason}, and fit again" if reason else f"it has no {DRAWS_FILE}; {AGAIN}"
        raise ValueError(f"names a fit without draws, {name}: {why}")
    try:
        state = "" if system.file_sha256(path / DRAWS_FILE) == listed else "was changed"
    except (OSError, ValueError):
        state = "is missing"
    if state:
        raise ValueError(f"names a fit whose {DRAWS_FILE} {state}: {name}; {AGAIN}")


def result_fields(path: Path, name: str) -> dict[str, Any]:
    """Return the drysim.json of a folder.

    Raises
    ------
    ValueError
        If it is no result of drysim.
    """
    file = path / RESULT_FILE
    if not file.is_file():
        raise ValueError(f"names no result of drysim: {name} has no {RESULT_FILE}")
    try:
        fields = json.loads(file.read_bytes())
    except (OSError, ValueError, RecursionError):
        fields = None
    parts = fields if isinstance(fields, dict) else {}
    kept = [parts.get("files", {}), inner := parts.get("fit", {})]
    kept.append(inner.get("draws", {}) if isinstance(inner, dict) else None)
    if not parts or not all(isinstance(part, dict) for part in kept):
        raise ValueError(f"names a damaged result: {name}/{RESULT_FILE}; {AGAIN}")
    return parts


def chosen_count(count: Any, draws: FitDraws, default: int) -> int:
    """Return the number of draws to use.

    Raises
    ------
    ValueError
        If the fit has fewer.
    """
    if count is None:
        return min(default, len(draws))
    if not isinstance(count, int) or isinstance(count, bool) or count < 1:
        raise ValueError(f"must be a whole number of at least 1, not {format_value(count)}")
    if count > len(draws):
        raise ValueError(f"is {count}, but the fit has {format_count(len(draws), 'draw')}")
    return count
