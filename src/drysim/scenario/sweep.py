"""Read the sweep block of a file: grids, zips and samples become axes.

A sweep names keys of the scenario in dotted form. `numeric_keys` knows their types and units,
so values follow the rules of their keys (`values`). A key takes the values of a list or a
range, alone or together with others (`zip`), or random values (`sample`, with a design of
`sampling`). `srs` is the natural frequency of a shock response spectrum. The key `direction`
becomes the last axis. `sweepable` explains why a key cannot be swept. Checks with an `at`
condition and the design block are read here as well, because they name keys too.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from glob import glob, has_magic
from itertools import takewhile
from pathlib import Path
from typing import Any, get_args

from drysim.messages import format_value
from drysim.metrics.checks import AT_PATTERN, STATUS, Check, has_condition
from drysim.scenario.axes import (
    BOTH,
    DIRECTION_KEY,
    DOWN,
    FILE_KEY,
    FROM_FIT_KEY,
    MAX_AXIS_VALUES,
    MAX_SAMPLE_POINTS,
    NATURAL_FREQUENCY_KEY,
    SAMPLE_KEY,
    SRS_KEY,
    SWEEP_KEY,
    UP,
    ZIP_KEY,
    Axis,
    KeyRange,
    Sample,
    SampleKind,
    axis_groups,
)
from drysim.scenario.blocks import SEED_KEY
from drysim.scenario.design import (
    DESIGN_KEY,
    DRAWS_OF_DESIGN,
    MAX_KEYS,
    MEAN,
    TAKE_KEY,
    WORST,
    Conditions,
    VaryRange,
)
from drysim.scenario.draws import FitDraws, chosen_count, read_draws
from drysim.scenario.keys import (
    KnownKeys,
    NumericKey,
    fields_by_key,
    get_block,
    numeric_keys,
)
from drysim.scenario.reading import Reading
from drysim.scenario.rules import EXCITATIONS_BY_KIND
from drysim.scenario.sampling import (
    Design,
    SampledValues,
)
from drysim.scenario.sweepable import sweep_fault
from drysim.scenario.validation import spoken_name
from drysim.scenario.values import (
    check_scale,
    read_distribution,
    read_ends,
    read_values,
    read_whole_number,
)
from drysim.system import relative_path
from drysim.wording import format_count, format_quantity_range, join_words
from drysim.yaml_document import UNREAD_KEYS, KeyPath


def read_axes_and_checks(reading: Reading) -> dict[str, Any]:
    """Return axes and checks as fields of the scenario; report their errors."""
    document, fields = reading.values, {}
    checks = document.get("checks")
    keys = numeric_keys(reading.model, document)
    if SWEEP_KEY in document:
        fields[SWEEP_KEY] = _read_axes(reading, keys)
    if isinstance(checks, list):
        fields["checks"] = [
            _read_check(reading, keys, i, text) for i, text in enumerate(checks)
        ]
    return fields


def _read_axes(reading: Reading, keys: KnownKeys) -> Any:
    """Return the axes of a sweep block."""
    block = reading.values[SWEEP_KEY]
    if not isinstance(block, Mapping):
        form = "keys with their values, such as `excitation.frequency: [1, 2]`"
        reading.fault(f"sweep must be {form}; not {format_value(block)}", (SWEEP_KEY,))
        return ()
    if not block:
        reading.fault("sweep has no keys; give at least one key with its values", (SWEEP_KEY,))
    inner = {key: value for group in _key_groups(block) for key, value in group.items()}
    inner.pop(UNREAD_KEYS, None)
    reading.values[SWEEP_KEY] = {**block, **inner}
    axes: list[Axis] = []
    for key, value in block.items():
        if key == ZIP_KEY:
            axes += _read_zip(reading, keys, value)
        elif key == SAMPLE_KEY:
            axes += _read_sample(reading, keys, value)
        elif key == SRS_KEY:
            axes += _read_spectrum(reading, keys, value)
        elif key not in (DIRECTION_KEY, UNREAD_KEYS):
            axis = _read_axis(reading, keys, (SWEEP_KEY, key), block)
            axes += [axis] if axis else []
    reading.values[SWEEP_KEY] |= {axis.key: None for axis in axes if axis.source is not None}
    if block.get(DIRECTION_KEY) is not None:
        with reading.reporting((SWEEP_KEY, DIRECTION_KEY)):
            axes.append(_read_direction(reading, axes, block[DIRECTION_KEY]))
    return tuple(axes)


MAX_CHAIN = 100_000
"""Maximum number of cases of which each starts where another one ended; they are solved in one
block."""


def _read_direction(reading: Reading, axes: Sequence[Axis], value: Any) -> Axis:
    """Return the axis for the directions of a sweep.

    Raises
    ------
    ValueError
        If the value is no direction, or cases along the first axis cannot follow one another.
    """
    directions = {UP: (UP,), DOWN: (DOWN,), BOTH: (UP, DOWN)}
    if value not in (*directions,):
        raise ValueError(f"must be {UP}, {DOWN} or {BOTH}, not {format_value(value)}")
    excitation = get_block(reading.values, "excitation")
    if excitation.get("kind") == "rest":
        raise ValueError(
            "is not possible for rest: without base motion every case comes to rest"
        )
    if {"seeds", "until"} & excitation.keys() or any(
        axis.key == "excitation.seeds" for axis in axes
    ):
        raise ValueError("needs a single seed: a mean over seeds has no last state")
    if not axes and len(reading.problems) == 0:
        raise ValueError("needs a key to vary: each case starts where the previous one ended")
    for axis in axis_groups(axes)[0] if axes else ():
        if sentence := _chain_fault(reading.values, axis):
            raise ValueError(f"is not possible: {sentence}; {OTHER_FIRST_KEY}")
    way = " and ".join(directions[value])
    description = f"{way}: each case begins where the one before it ended"
    return Axis(DIRECTION_KEY, "", directions[value], value, description=description)


OTHER_FIRST_KEY = "list a key such as excitation.rms first, or remove direction"


def _chain_fault(document: Mapping[str, Any], axis: Axis) -> str | None:
    """Return why the cases along an axis cannot follow one another; None if they can."""
    key, stops = axis.key, get_block(get_block(document, "stroke"), "stops")
    if axis.is_random:
        return f"the values of {key}, the first key, are random and have no order"
    if key in (FILE_KEY, SEED_KEY):
        return f"the values of {key}, the first key, have no order"
    if key.startswith("start."):
        return f"{key}, the first key, would be replaced by the end of the previous case"
    if key.startswith("stroke.") and "restitution" in stops:
        return f"a case may end beyond the rigid stops of the next {key}, the first key"
    if len(axis.values) > MAX_CHAIN:
        return f"{key}, the first key, has {len(axis.values)} values, more than {MAX_CHAIN}"
    return None


def _key_groups(block: Any) -> list[Mapping[str, Any]]:
    """Return the groups of keys in `zip`, `sample` and `srs`."""
    if not isinstance(block, Mapping):
        return []  # the key `sweep` is misspelled, which is reported elsewhere
    zips, sample = block.get(ZIP_KEY), block.get(SAMPLE_KEY)
    several = zips if isinstance(zips, list) else [zips]
    over = sample.get("over") if isinstance(sample, Mapping) else None
    spectrum = {NATURAL_FREQUENCY_KEY: block[SRS_KEY]} if SRS_KEY in block else None
    return [group for group in (*several, over, spectrum) if isinstance(group, Mapping)]


def _read_spectrum(reading: Reading, keys: KnownKeys, value: Any) -> Iterator[Axis]:
    """Yield the axis of `srs`: natural frequencies, evenly spaced on a log scale by default."""
    path = (SWEEP_KEY, SRS_KEY)
    kind = get_block(reading.values, "excitation").get("kind")
    if kind in EXCITATIONS_BY_KIND and kind not in SHOCK_KINDS:
        sentence = f"needs a shock, as `excitation.kind: shock` or as a record, not {kind}"
        reading.report_value(sentence, path, at_key=True)
        return
    if isinstance(value, Mapping) and "count" in value:
        value = {"scale": "log", **value}
    if (numeral := _read_key(reading, keys, path, NATURAL_FREQUENCY_KEY)) and (
        axis := read_values(reading, path, numeral, NATURAL_FREQUENCY_KEY, value)
    ):
        yield replace(axis, group=SRS_KEY, location=path)


SHOCK_KINDS = ("shock", "record")
"""Kinds of base motion that have a shock response spectrum."""


def _read_zip(reading: Reading, keys: KnownKeys, value: Any) -> Iterator[Axis]:
    """Yield the axes of `zip`: one or several groups of keys varying together."""
    form = "keys with equally many values, such as {friction.kinetic: [15, 30], ...}"
    groups: list[tuple[KeyPath, Any]] = [((SWEEP_KEY, ZIP_KEY), value)]
    if isinstance(value, list):
        groups = [((SWEEP_KEY, ZIP_KEY, i), group) for i, group in enumerate(value)]
    for path, group in groups:
        if not isinstance(group, Mapping) or len(group) < 2:
            reading.report_value(
                f"must be at least two {form}; not {format_value(group)}", path
            )
            continue
        numerals = _read_keys(reading, keys, path, group)
        axes = [
            axis
            for key, numeral in numerals.items()
            if (axis := read_values(reading, (*path, key), numeral, key, group[key]))
        ]
        uneven = next((axis for axis in axes if len(axis.values) != len(axes[0].values)), None)
        if uneven is not None:
            sentence = (
                f"has {len(uneven.values)} values, but {axes[0].key} has "
                f"{len(axes[0].values)}; keys of a zip need equally many"
            )
            reading.report_value(sentence, (*path, uneven.key))
            continue
        name = ".".join(map(str, path[1:]))
        yield from (replace(axis, group=name, location=(*path, axis.key)) for axis in axes)


def _read_sample(reading: Reading, keys: KnownKeys, value: Any) -> Iterator[Axis]:
    """Yield the axes of `sample`: keys with random values."""
    path = (SWEEP_KEY, SAMPLE_KEY)
    if not isinstance(value, Mapping):
        form = "{kind: latin, count: 1000, seed: 1, over: {...}}"
        reading.report_value(f"must be {form}; not {format_value(value)}", path)
        return
    block = reading.block(Sample, value, path)
    over, elsewhere = block.get("over"), _varied_keys(reading.values[SWEEP_KEY])
    if over is None and FROM_FIT_KEY in block:
        yield from _read_fit(reading, keys, path, block, elsewhere)
        return
    missing = [name for name in Sample.with_over if name not in block]
    for name in missing if over is not None else ():
        reading.report_missing(Sample, name, path)
    if over is None or missing:
        return
    if not isinstance(over, Mapping) or not over:
        sentence = "must be keys, each with {from, to} or a distribution"
        reading.report_value(f"{sentence}; not {format_value(over)}", (*path, "over"))
        return
    numerals = _read_keys(reading, keys, (*path, "over"), over)
    count = read_whole_number(reading, path, block, "count", 1, MAX_SAMPLE_POINTS)
    seed = read_whole_number(reading, path, block, "seed", 0, 2**63)
    laws = {
        key: read_distribution(reading, (*path, "over", key), over[key], numeral)
        for key, numeral in numerals.items()
    }
    if count is None or seed is None or "kind" not in block or None in laws.values():
        return
    if block["kind"] not in get_args(SampleKind):
        sentence = f"must be latin, sobol or uniform, not {format_value(block['kind'])}"
        reading.report_value(sentence, (*path, "kind"))
        return
    if block["kind"] == "sobol" and count > MAX_AXIS_VALUES:
        sentence = f"is at most {MAX_AXIS_VALUES:.0e} for sobol, whose points are drawn at once"
        reading.report_value(f"{sentence}; choose latin or uniform", (*path, "count"))
        return
    design = Design(block["kind"], count, len(laws), seed)
    head = {name: block[name] for name in ("kind", "count", "seed")}
    for k, (key, distribution) in enumerate(laws.items()):
        assert distribution is not None
        law, spec = distribution
        unit = numerals[key].header
        label = f"{law.describe(unit)} ({count} values, {block['kind']})"
        yield Axis(
            key, unit, SampledValues(design, k, law), (head, spec), "sample", label,
            (*path, "over", key),
        )  # fmt: skip
    if FROM_FIT_KEY in block:
        yield from _read_fit(reading, keys, path, block, elsewhere)


def _varied_keys(block: Mapping[str, Any]) -> list[str]:
    """Return the keys that a sweep block varies itself."""
    return [key for key in block if "." in key]


def _read_fit(
    reading: Reading,
    keys: KnownKeys,
    path: KeyPath,
    block: Mapping[str, Any],
    given: Collection[str],
    designed: Collection[str] = (),
    default: int = MAX_AXIS_VALUES,
) -> Iterator[Axis]:
    """Yield the axes of the draws of a fit, without the keys that are varied elsewhere.

    Those are `given` beside the draws, whose label says so, or `designed`. `default` is the
    number of draws if the block states none; default: all of them.
    """
    elsewhere = (*given, *designed)
    location = (*path, FROM_FIT_KEY)
    with reading.reporting(location):
        draws = read_draws(Path(reading.document.file).parent, block[FROM_FIT_KEY])
        drawn = [key for key in draws.columns if key not in elsewhere]
        if unknown := [key for key in drawn if keys.get(key) is None]:
            raise ValueError(f"names a fit of {join_words(unknown)}, which this scenario lacks")
        for key in drawn:
            if fault := sweep_fault(
                reading.values, key, keys, [*elsewhere, *drawn], FROM_FIT_KEY
            ):
                raise ValueError(f"names a fit of {key}: {fault}")
        if not drawn:
            raise ValueError("names a fit whose keys are all varied elsewhere; remove it")
        replaced = [key for key in draws.columns if key in given]
        note = f", {join_words(replaced)} as given, not as drawn" if replaced else ""
        with reading.reporting((*path, "count")):
            count = chosen_count(block.get("count"), draws, default)
            for key in drawn:
                label = f" ({format_count(count, 'draw')} of {draws.label}{note})"
                label = label if key == drawn[-1] else ""
                yield _drawn_axis(keys[key], key, draws, count, location, label)


def _drawn_axis(
    numeral: NumericKey | None,
    key: str,
    draws: FitDraws,
    count: int,
    location: KeyPath,
    label: str,
) -> Axis:
    """Return the axis of a key of a fit; `label` follows its range in a text."""
    assert numeral is not None, "keys that are not numeric were reported"
    values, unit = draws.columns[key][:count], numeral.header
    ends = format_quantity_range(min(values), max(values), unit)
    entry: Any = {FROM_FIT_KEY: draws.name, "count": count}
    group = SAMPLE_KEY if SAMPLE_KEY in location else FROM_FIT_KEY
    return Axis(
        key,
        unit,
        values,
        (entry, None) if group == SAMPLE_KEY else entry,
        group,
        f"{ends}{label}",
        location,
        numeral.bounds,
        draws.path,
    )


def _read_keys(
    reading: Reading, keys: KnownKeys, path: KeyPath, group: Mapping[str, Any]
) -> dict[str, NumericKey]:
    """Return the valid numeric keys of a group; report the others."""
    numerals = {}
    for key in group:
        if key == FILE_KEY and key in keys:
            sentence = f"{key} must be a key of sweep itself; groups take numbers only"
            reading.fault(sentence, (*path, key), at_key=True)
            continue
        if key != UNREAD_KEYS and (numeral := _read_key(reading, keys, (*path, key), key)):
            numerals[key] = numeral
    return numerals


def _read_axis(
    reading: Reading, keys: KnownKeys, path: KeyPath, block: Mapping[str, Any]
) -> Axis | None:
    """Return the axis of a key in a block; None if it has an error."""
    key = str(path[-1])
    value = block[key]
    if key == FILE_KEY and get_block(reading.values, "excitation").get("kind") == "record":
        return _read_files(reading, path, value)
    numeral = _read_key(reading, keys, path, key, () if path[0] == SWEEP_KEY else block)
    if numeral is None:
        return None
    if value is None:
        reading.fault(f"{spoken_name(path)} has no values", path, at_key=True)
        return None
    return read_values(reading, path, numeral, key, value)


def _read_files(reading: Reading, path: KeyPath, value: Any) -> Axis | None:
    """Return the axis for records: a list of files, or a pattern such as `runs/*.csv`."""
    noted, files = len(reading.problems), [value]
    folder = Path(reading.document.file).parent
    with reading.reporting(path):
        if isinstance(value, str):
            # A scenario from Windows may separate folders by backslashes.
            for pattern in dict.fromkeys([value, value.replace("\\", "/")]):
                files = sorted(
                    Path(name).as_posix()
                    for name in glob(pattern, root_dir=folder, recursive=True)
                    if (folder / name).is_file()
                )
                if files:
                    break
            if not files:
                raise ValueError(_pattern_fault(folder, value))
        elif isinstance(value, list):
            files = value
            if not files:
                raise ValueError("has no files")
        else:
            form = "a list of files, or a pattern such as `runs/*.csv`"
            raise ValueError(f"must be {form}; not {format_value(value)}")
    for i, file in enumerate(files):
        with reading.reporting((*path, i)):
            if not isinstance(file, str) or not file:
                raise ValueError(f"must be the name of a file, not {format_value(file)}")
            if file in files[:i]:
                raise ValueError(f"is a duplicate: {format_value(file)}")
            if (folder / file).is_dir():
                raise ValueError(_pattern_fault(folder, file))
            if has_magic(file) and not (folder / file).exists():
                remedy = f"without a list: `{FILE_KEY}: {file}`"
                raise ValueError(f"is a pattern, not a file; write it {remedy}")
    if len(reading.problems) > noted:
        return None
    # Results name the files as here, and are to be free of absolute paths.
    files = [relative_path(file, folder) if os.path.isabs(file) else file for file in files]
    return Axis(FILE_KEY, "", tuple(files), list(files))


def _pattern_fault(folder: Path, pattern: str) -> str:
    """Return why a text is no pattern of files, and what to write."""
    if (folder / pattern).is_dir():
        example = (Path(pattern) / "*.csv").as_posix()
        return f"is a folder, {format_value(pattern)}; write a pattern: `{FILE_KEY}: {example}`"
    fault = f"is a pattern that matches no file: {format_value(pattern)}"
    parts = Path(pattern).parts[:-1]
    above = Path(*takewhile(lambda part: not has_magic(part), parts))
    if not (folder / above).is_dir():
        return f"{fault}; there is no folder {format_value(above.as_posix())}"
    return f"{fault}; write one such as `records/*.csv`, relative to this file"


def _read_key(
    reading: Reading, keys: KnownKeys, path: KeyPath, key: str, varied: Collection[str] = ()
) -> NumericKey | None:
    """Return the numeric key to vary; None if it has an error.

    `varied` are all keys that are varied together; default: those of the sweep.
    """
    top = key.partition(".")[0]
    field = fields_by_key(reading.model).get(top)
    wanted = top in reading.document.value or (field is not None and field.is_required())
    if wanted and top not in reading.values:
        return None  # an error of the block with this key was reported already
    block = SWEEP_KEY if path[0] == SWEEP_KEY else spoken_name(path[:-1])
    if sentence := sweep_fault(reading.values, key, keys, varied, block):
        reading.fault(sentence, path, at_key=True)
        return None
    if block == SWEEP_KEY and _is_swept_twice(reading.document.value.get(SWEEP_KEY), key):
        reading.fault(f"{key} is swept twice; remove one", path, at_key=True)
        return None
    return keys[key]


def _is_swept_twice(block: Any, key: str) -> bool:
    """Return whether a sweep block contains a key more than once."""
    groups = _key_groups(block)
    return sum(key in group for group in (block, *groups)) > 1 if groups else False


def read_design(reading: Reading) -> dict[str, Any]:
    """Return the varied keys and the conditions of the design block; report their errors."""
    block = get_block(reading.values, DESIGN_KEY)
    keys = numeric_keys(reading.model, reading.values)
    fields: dict[str, Any] = {}
    vary, over = block.get("vary"), block.get("over")
    before = len(reading.problems)
    if isinstance(vary, Mapping) and vary:
        fields["vary"] = _read_vary(reading, keys, (DESIGN_KEY, "vary"), vary)
    if isinstance(over, Mapping) and over.keys() - {TAKE_KEY}:
        designed = [*vary] if isinstance(vary, Mapping) else []
        path = (DESIGN_KEY, "over")
        fields["over"] = _read_conditions(reading, keys, path, over, designed)
    if len(reading.problems) > before:  # nothing more is said of these blocks
        reading.reported |= {(DESIGN_KEY, "vary"), (DESIGN_KEY, "over")}
    return fields


def _read_vary(
    reading: Reading, keys: KnownKeys, path: KeyPath, block: Mapping[str, Any]
) -> tuple[KeyRange, ...]:
    """Return the varied keys of a design."""
    ranges = []
    if len(block) > MAX_KEYS:
        reading.report_value(f"has {len(block)} keys; a design has at most {MAX_KEYS}", path)
    for key, bounds in block.items():
        if key == UNREAD_KEYS or not (n := _read_key(reading, keys, (*path, key), key, block)):
            continue
        with reading.reporting((*path, key)):
            if n.quantity is None:
                raise ValueError("takes whole numbers, which design does not support")
            if not isinstance(bounds, Mapping):
                raise ValueError(f"must be {{from, to}}, not {format_value(bounds)}")
            values = reading.block(VaryRange, bounds, (*path, key))
            if (ends := read_ends(reading, (*path, key), n, values)) is not None:
                scale = values.get("scale", "linear")
                check_scale(scale, ends[0])
                ranges.append(KeyRange(key, n.header, *ends, scale == "log", n.bounds))
    return tuple(ranges)


def _read_conditions(
    reading: Reading,
    keys: KnownKeys,
    path: KeyPath,
    block: Mapping[str, Any],
    designed: Collection[str],
) -> Conditions:
    """Return the conditions under which every design is judged; `designed` are varied keys."""
    take = block.get(TAKE_KEY, WORST)
    if take not in (WORST, MEAN):
        sentence = f"must be {WORST} or {MEAN}, not {format_value(take)}"
        reading.report_value(sentence, (*path, TAKE_KEY))
    options = (TAKE_KEY, UNREAD_KEYS, FROM_FIT_KEY, "count")
    varied = {key: value for key, value in block.items() if key not in options}
    axes = [_read_axis(reading, keys, (*path, key), varied) for key in varied]
    stated = [replace(axis, location=(*path, axis.key)) for axis in axes if axis]
    if FROM_FIT_KEY in block:
        stated += _read_fit(reading, keys, path, block, varied, designed, DRAWS_OF_DESIGN)
    elif "count" in block:
        reading.report_value(f"requires {FROM_FIT_KEY}", (*path, "count"), at_key=True)
    return Conditions(tuple(stated), take)


def _read_check(reading: Reading, keys: KnownKeys, i: int, text: Any) -> Any:
    """Return a parsed check if it has an `at` condition, otherwise the text."""
    if not has_condition(text):
        return text
    numerals = {key: numeral for key, numeral in keys.items() if numeral}
    try:
        check = Check.parse(text, {key: numeral.unit for key, numeral in numerals.items()})
    except ValueError as fault:
        sentence = f"{spoken_name(('checks', i))}: {fault}"
        if FILE_KEY in AT_PATTERN.split(text, maxsplit=1)[1]:
            sentence += (
                "; conditions compare numbers, so a check applies to every record: put a "
                "record with limits of its own into a scenario of its own"
            )
        reading.fault(sentence, ("checks", i))
        return "T_a < 1"  # any valid check: the error was reported
    swept = reading.values.get(SWEEP_KEY)
    named = [condition.key for condition in check.conditions if condition.key != STATUS]
    for key in dict.fromkeys(named):
        if isinstance(swept, Mapping) and key not in swept:
            name = spoken_name(("checks", i))
            sentence = f"{name}: {key} is not swept; it has the same value in every case"
            reading.fault(sentence, ("checks", i))
    return check.with_values({key: numerals[key].here(key) for key in named})
