"""The files that a scenario names: their keys, paths and hashes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from drysim import system
from drysim.block import Block
from drysim.core.model import Input
from drysim.excitation.recorded import Record
from drysim.scenario.axes import FILE_KEY, FROM_FIT_KEY, SAMPLE_KEY, SWEEP_KEY, Axis
from drysim.scenario.design import DESIGN_KEY
from drysim.scenario.draws import draws_file
from drysim.scenario.model import Scenario
from drysim.yaml_document import KeyPath


def named_files(scenario: Scenario) -> Iterator[tuple[KeyPath, Path]]:
    """Yield the files that a scenario names, each with the path of its key."""
    yield from _named_files(scenario, ())
    if isinstance(scenario.excitation, Record):
        for i, file in enumerate(swept_files(scenario)):
            yield (SWEEP_KEY, FILE_KEY, i), scenario.excitation.with_file(file).path
    for axes, path in drawn_axes(scenario):
        if axes[0].source is not None:
            yield (*path, FROM_FIT_KEY), draws_file(axes[0].source)
    if scenario.assess is not None:
        measured = scenario.assess.measured
        for i, file in enumerate(measured.more_files):
            yield ("assess", "measured", "more_files", i), measured.of_file(file).path


def drawn_axes(scenario: Scenario) -> Iterator[tuple[list[Axis], KeyPath]]:
    """Yield the axes that are draws of a fit, each group with the path of its block."""
    conditions = scenario.design.conditions.axes if scenario.design is not None else ()
    places = ((scenario.sweep, (SWEEP_KEY, SAMPLE_KEY)), (conditions, (DESIGN_KEY, "over")))
    for axes, path in places:
        if drawn := [axis for axis in axes if axis.source is not None]:
            yield drawn, path


def drawn_inputs(scenario: Scenario) -> Iterator[Input]:
    """Yield the tables of draws that a sweep takes."""
    for axis in scenario.sweep:
        if axis.source is not None:
            file = draws_file(axis.source)
            name = axis.entry[0] if isinstance(axis.entry, tuple) else axis.entry
            named = "/".join((name[FROM_FIT_KEY], *file.parts[len(axis.source.parts) :]))
            yield Input(named, system.file_sha256(file), system.file_size(file))
            return


def _named_files(block: Block, keys: KeyPath) -> Iterator[tuple[KeyPath, Path]]:
    path = getattr(block, "path", None)
    if isinstance(path, Path):
        yield (*keys, "file"), path
    for name in type(block).model_fields:
        if isinstance(inner := getattr(block, name), Block):
            yield from _named_files(inner, (*keys, name))
        elif isinstance(inner, tuple):
            for i, part in enumerate(inner):
                if isinstance(part, Block):
                    yield from _named_files(part, (*keys, name, i))


def file_hashes(scenario: Scenario) -> dict[str, str]:
    """Return the SHA-256 (hex) of each file that a scenario names, by key.

    A file that cannot be read is left out: reading its contents says what is wrong.
    """
    hashes = {}
    for keys, path in named_files(scenario):
        with suppress(OSError, ValueError, system.NotARegularFile):
            hashes[".".join(map(str, keys))] = system.file_sha256(path)
    return hashes


def swept_files(scenario: Scenario) -> Sequence[str]:
    """Return the records that a sweep varies, as in the scenario; none for other sweeps."""
    return next((axis.values for axis in scenario.sweep if axis.key == FILE_KEY), ())


def files_location(scenario: Scenario) -> KeyPath:
    """Return the keys under which a scenario lists the records that its sweep varies."""
    axis = next(axis for axis in scenario.sweep if axis.key == FILE_KEY)
    return axis.location or (SWEEP_KEY, FILE_KEY)
