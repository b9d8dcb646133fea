"""The gallery: scenarios shipped with drysim, found by name, copied with their records."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import drysim
from drysim.errors import OutputError, UsageError
from drysim.units import meant, near
from drysim.yaml_document import read

SUFFIX = ".yaml"

HARD = "hard"
"""Part of the gallery that holds the hard cases: scenes that are hard to compute."""

LOOPS = Path("pictures", "loops")
"""Folder of the gallery that holds the loops of its friction laws."""


@dataclass(frozen=True)
class Piece:
    """A scenario of the gallery: its name, its own words about itself, and its file."""

    name: str
    about: str
    file: Path

    @property
    def loop(self) -> Path | None:
        """The picture of its friction loop, if the gallery shows it."""
        file = self.file.parent / LOOPS / f"{self.file.stem}.png"
        return file if file.is_file() else None


def pieces(part: str = "") -> list[Piece]:
    """Give the scenarios of the gallery, or of a part of it, in the order of their names."""
    return [piece(file) for file in sorted((folder() / part).glob(f"*{SUFFIX}"))]


def find(name: str) -> Piece:
    """Give the scenario of the gallery with this name.

    Raises
    ------
    UsageError
        When the gallery has no such scenario; names the nearest.
    """
    found = (*folder().glob(f"*{SUFFIX}"), *(folder() / HARD).glob(f"*{SUFFIX}"))
    files = {name_of(file): file for file in sorted(found)}
    known = files.get(name.removesuffix(SUFFIX))
    if known is None:
        sentence = f"the gallery has no scenario `{name}`{meant(near(name, files))}"
        raise UsageError(sentence, "`drysim init --list` shows it")
    return piece(known)


def copy(name: str, target: Path) -> list[Path]:
    """Write a scenario of the gallery, and the records it reads, into a folder.

    A file that is there already is never replaced; the very same record is left alone.

    Returns
    -------
    list of Path
        The files written, the scenario first.

    Raises
    ------
    UsageError
        When the gallery has no such scenario.
    OutputError
        When a file is in the way, or the folder cannot be written.
    """
    chosen = find(name).file
    refuse_existing(target / chosen.name)
    home = chosen.parent
    needed = records(read(chosen).value)
    missing = [record for record in needed if not in_place(home / record, target / record)]
    for file in [*missing, chosen.name]:
        write_new(target / file, (home / file).read_bytes())
    return [target / file for file in (chosen.name, *missing)]


def folder() -> Path:
    """Give the gallery's folder: inside an installed package, else in the checkout."""
    home = Path(drysim.__file__).resolve().parent
    installed = home / "scenarios"
    return installed if installed.is_dir() else home.parents[1] / "scenarios"


def piece(file: Path) -> Piece:
    """Give one scenario of the gallery by its file."""
    return Piece(name_of(file), str(read(file).value.get("about", "")), file)


def name_of(file: Path) -> str:
    """Give the name by which a file of the gallery is asked for, such as `hard/never-moves`."""
    return file.relative_to(folder()).with_suffix("").as_posix()


def records(value: object) -> Iterator[str]:
    """Give every file that a scenario of the gallery reads, relative to the gallery."""
    if isinstance(value, dict):
        for key, inner in value.items():
            if key == "file" and isinstance(inner, str):
                yield inner
            else:
                yield from records(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from records(inner)


def in_place(record: Path, copied: Path) -> bool:
    """Tell whether a record lies there already; refuse when something else does."""
    if copied.is_file() and copied.read_bytes() == record.read_bytes():
        return True
    refuse_existing(copied)
    return False


def refuse_existing(file: Path) -> None:
    """Raise an OutputError when something, even a dangling link, has this name."""
    if os.path.lexists(file):
        raise OutputError(
            f"{file} exists already and is left as it is",
            hint="move it away, or work in another folder",
        )


def write_new(file: Path, content: bytes) -> None:
    """Write a file that must not be there yet, completely or not at all."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("xb") as stream:
            try:
                stream.write(content)
                stream.flush()
            except BaseException:  # be it a full disk or Ctrl-C
                file.unlink(missing_ok=True)
                raise
    except OSError as fault:
        raise OutputError(f"{file} cannot be written: {fault.strerror}") from fault
