"""Gallery: scenarios shipped with drysim, found by name and copied with their records."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import drysim
from drysim.errors import OutputError, UsageError
from drysim.messages import closest_match, did_you_mean
from drysim.scenario.assess import ASSESS_KEY
from drysim.scenario.axes import SWEEP_KEY
from drysim.scenario.design import DESIGN_KEY
from drysim.scenario.fit import FIT_KEY
from drysim.wording import sanitise
from drysim.yaml_document import read_document

SUFFIX = ".yaml"

SUFFIXES = (SUFFIX, ".yml")
"""Suffixes of scenario files; those that drysim writes have the first by default."""

SCHEMA_FILE = "scenario.schema.json"
"""JSON schema of scenario files, beside them for editors."""

HARD_FOLDER = "hard"
"""Folder of the hard cases: scenes that are difficult to compute."""

NAMED_COMMANDS = ("branches", "map")
"""Commands without a block of their own: the comments of their scenarios name them."""

COMPARE_PATTERN = re.compile(r"comparisons such as `(?P<words>drysim compare [^`]+)`")
"""What the comments of a scenario that is made for comparisons name."""

LOOPS_FOLDER = Path("pictures", "loops")
"""Folder with the pictures of the friction loops."""


@dataclass(frozen=True)
class GalleryScenario:
    """Scenario of the gallery: its name, its description, and its file."""

    name: str
    about: str
    file: Path

    @property
    def command(self) -> str:
        """Command that the scenario is made for: by its blocks, or as its comments say."""
        document, text = read_document(self.file).value, self.file.read_text(encoding="utf-8")
        studies = (name for name in (FIT_KEY, DESIGN_KEY, ASSESS_KEY) if name in document)
        named = (name for name in NAMED_COMMANDS if f"`drysim {name}`" in text)
        return next(chain(studies, named), SWEEP_KEY if SWEEP_KEY in document else "run")

    def command_line(self, file: Path) -> str:
        """Return the command that the scenario is made for, with a copy of its file."""
        if said := COMPARE_PATTERN.search(self.file.read_text(encoding="utf-8")):
            return f"{' '.join(said['words'].replace('#', ' ').split())} {file}"
        return f"drysim {self.command} {file}"

    @property
    def loop(self) -> Path | None:
        """Picture of its friction loop, if there is one."""
        file = self.file.parent / LOOPS_FOLDER / f"{self.file.stem}.png"
        return file if file.is_file() else None


def list_scenarios(part: str = "") -> list[GalleryScenario]:
    """Return the scenarios of the gallery, or of one of its folders, ordered by name."""
    return [read_scenario(file) for file in sorted((folder() / part).glob(f"*{SUFFIX}"))]


def find(name: str) -> GalleryScenario:
    """Return the scenario of the gallery with this name.

    Raises
    ------
    UsageError
        When there is no such scenario; the message contains the most similar name.
    """
    all_files = (*folder().glob(f"*{SUFFIX}"), *(folder() / HARD_FOLDER).glob(f"*{SUFFIX}"))
    files = {scenario_name(file): file for file in sorted(all_files)}
    file = files.get(name.removesuffix(SUFFIX))
    if file is None:
        sentence = (
            f"the gallery has no scenario `{name}`{did_you_mean(closest_match(name, files))}"
        )
        hint = "`drysim init --list` shows all names"
        if Path(name).is_file() and Path(name).suffix not in SUFFIXES:
            hint = f"`drysim init --from {shlex.quote(name)}` writes a scenario for a record"
        raise UsageError(sentence, hint)
    return read_scenario(file)


def copy(name: str, target: Path) -> list[Path]:
    """Copy a scenario of the gallery, and the records that it reads, to a folder.

    Existing files are never replaced; an identical record is kept.

    Returns
    -------
    list of Path
        Files written, the scenario first.

    Raises
    ------
    UsageError
        When there is no such scenario.
    OutputError
        When a file exists, or the folder cannot be written.
    """
    chosen = find(name).file
    refuse_existing(target / chosen.name)
    home = chosen.parent
    needed = dict.fromkeys(record_files(read_document(chosen).value))
    missing = [record for record in needed if not is_copied(home / record, target / record)]
    for file in [*missing, chosen.name]:
        write_new(target / file, (home / file).read_bytes())
    return [target / file for file in (chosen.name, *missing)]


def folder() -> Path:
    """Return the folder of the gallery: in the installed package, or else in the checkout."""
    home = Path(drysim.__file__).resolve().parent
    installed = home / "scenarios"
    return installed if installed.is_dir() else home.parents[1] / "scenarios"


def read_scenario(file: Path) -> GalleryScenario:
    """Return one scenario of the gallery by its file."""
    return GalleryScenario(
        scenario_name(file), str(read_document(file).value.get("about", "")), file
    )


def scenario_name(file: Path) -> str:
    """Return the name of a file of the gallery, such as `hard/never-moves`."""
    return file.relative_to(folder()).with_suffix("").as_posix()


def record_files(value: object) -> Iterator[str]:
    """Yield every file that a scenario of the gallery reads, relative to the gallery."""
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
    """Whether an identical copy of a record exists; raise an OutputError for any other file."""
    if copied.is_file() and copied.read_bytes() == record.read_bytes():
        return True
    refuse_existing(copied)
    return False


def new_file(name: str) -> Path:
    """Return the file of a new scenario: the name, with a suffix unless it has one.

    Raises
    ------
    UsageError
        If nothing is left of the name but folders and a suffix.
    """
    suffix = next((each for each in SUFFIXES if name.endswith(each)), "")
    stem = name.removesuffix(suffix)
    if os.path.basename(stem) in ("", os.curdir, os.pardir):
        sentence = f"`{sanitise(name)}` is not the name of a file"
        raise UsageError(sentence, f"give a name such as `seat` or `seat{SUFFIX}`")
    return Path(stem + (suffix or SUFFIX))


def refuse_existing(file: Path) -> None:
    """Raise an OutputError if the name exists, even as a dangling link."""
    if os.path.lexists(file):
        raise OutputError(
            f"{file} already exists and is not replaced",
            hint="move it, or use another folder",
        )


def write_new(file: Path, content: bytes) -> None:
    """Write a new file, completely or not at all."""
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
