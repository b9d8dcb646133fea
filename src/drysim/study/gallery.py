"""The gallery: scenarios shipped with drysim, found by name, copied with their records."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import drysim
from drysim.errors import OutputError, UsageError
from drysim.units import closest_match, did_you_mean
from drysim.yaml_document import read_document

SUFFIX = ".yaml"

HARD_FOLDER = "hard"
"""Part of the gallery that holds the hard cases: scenes that are hard to compute."""

LOOPS_FOLDER = Path("pictures", "loops")
"""Folder of the gallery that holds the loops of its friction laws."""


@dataclass(frozen=True)
class GalleryScenario:
    """A scenario of the gallery: its name, its own words about itself, and its file."""

    name: str
    about: str
    file: Path

    @property
    def loop(self) -> Path | None:
        """The picture of its friction loop, if the gallery shows it."""
        file = self.file.parent / LOOPS_FOLDER / f"{self.file.stem}.png"
        return file if file.is_file() else None


def list_scenarios(part: str = "") -> list[GalleryScenario]:
    """Give the scenarios of the gallery, or of a part of it, in the order of their names."""
    return [read_scenario(file) for file in sorted((folder() / part).glob(f"*{SUFFIX}"))]


def find(name: str) -> GalleryScenario:
    """Give the scenario of the gallery with this name.

    Raises
    ------
    UsageError
        When the gallery has no such scenario; names the nearest.
    """
    found = (*folder().glob(f"*{SUFFIX}"), *(folder() / HARD_FOLDER).glob(f"*{SUFFIX}"))
    files = {scenario_name(file): file for file in sorted(found)}
    known = files.get(name.removesuffix(SUFFIX))
    if known is None:
        sentence = (
            f"the gallery has no scenario `{name}`{did_you_mean(closest_match(name, files))}"
        )
        raise UsageError(sentence, "`drysim init --list` shows it")
    return read_scenario(known)


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
    needed = record_files(read_document(chosen).value)
    missing = [record for record in needed if not is_copied(home / record, target / record)]
    for file in [*missing, chosen.name]:
        write_new(target / file, (home / file).read_bytes())
    return [target / file for file in (chosen.name, *missing)]


def folder() -> Path:
    """Give the gallery's folder: inside an installed package, else in the checkout."""
    home = Path(drysim.__file__).resolve().parent
    installed = home / "scenarios"
    return installed if installed.is_dir() else home.parents[1] / "scenarios"


def read_scenario(file: Path) -> GalleryScenario:
    """Give one scenario of the gallery by its file."""
    return GalleryScenario(
        scenario_name(file), str(read_document(file).value.get("about", "")), file
    )


def scenario_name(file: Path) -> str:
    """Give the name by which a file of the gallery is asked for, such as `hard/never-moves`."""
    return file.relative_to(folder()).with_suffix("").as_posix()


def record_files(value: object) -> Iterator[str]:
    """Give every file that a scenario of the gallery reads, relative to the gallery."""
    if isinstance(value, dict):
        for key, inner in value.items():
            if key == "file" and isinstance(inner, str):
                yield inner
            else:
                yield from record_files(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from record_files(inner)


def is_copied(record: Path, copied: Path) -> bool:
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
            except BaseException:  # also a full disk or Ctrl-C
                file.unlink(missing_ok=True)
                raise
    except OSError as fault:
        raise OutputError(f"{file} cannot be written: {fault.strerror}") from fault
