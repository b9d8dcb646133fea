"""Read the sweep block of a file: grids, zips and samples become axes.

A sweep names keys of the scenario in dotted form. `numeric_keys` knows their types and units,
so values follow the rules of their keys. A key takes the values of a list or a range, alone or
together with others (`zip`), or random values (`sample`, with a design of `sampling`). `srs` is
the natural frequency of a shock response spectrum. The key `direction` becomes the last axis.
`sweep_fault` explains why a key cannot be swept. Checks with an `at` condition and the design
block are read here as well, because they name keys too.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from glob import glob, has_magic
from itertools import takewhile
from math import ceil, log2, nan
from pathlib import Path
from typing import Any, get_args

from drysim.block import InvalidValue
from drysim.excitation.base import as_integer
from drysim.messages import closest_match, did_you_mean, format_value
from drysim.metrics.checks import AT_PATTERN, STATUS, Check, has_condition
from drysim.quantity import Quantity
from drysim.scenario.axes import (
    BOTH,
    DIRECTION_KEY,
    DOWN,
    FILE_KEY,
    MAX_AXIS_VALUES,
    NATURAL_FREQUENCY_KEY,
    SAMPLE_KEY,
    SRS_KEY,
    SWEEP_KEY,
    UP,
    ZIP_KEY,
    Axis,
    Draw,
    KeyRange,
    Range,
    Sample,
    axis_groups,
    decimal_arange,
    decimal_geomspace,
    decimal_linspace,
    nearest_steps,
)
from drysim.scenario.blocks import SEED_KEY
from drysim.scenario.design import (
    DESIGN_KEY,
    MAX_KEYS,
    MEAN,
    TAKE_KEY,
    WORST,
    Conditions,
    VaryRange,
)
from drysim.scenario.keys import (
    KnownKeys,
    NumericKey,
    discriminator,
    fields_by_key,
    get_block,
    numeric_keys,
)
from drysim.scenario.laws import LAWS
from drysim.scenario.model import EXCITATIONS_BY_KIND, key_faults
from drysim.scenario.reading import Reading
from drysim.scenario.sampling import (
    Design,
    Distribution,
    LogNormal,
    Normal,
    SampledValues,
    Triangular,
    Uniform,
)
from drysim.scenario.validation import dotted_name
from drysim.system import relative_path
from drysim.wording import format_unit
from drysim.yaml_document import UNREAD_KEYS, KeyPath

MAX_SAMPLE_POINTS = 10**12
"""Maximum number of points of a sample; more are probably a typing error."""


def read_axes_and_checks(reading: Reading) -> dict[str, Any]:
    """Return axes and checks as fields of the scenario; report their errors."""
    words, found = reading.words, {}
    checks = words.get("checks")
    known = numeric_keys(reading.model, words)
    if SWEEP_KEY in words:
        found[SWEEP_KEY] = _read_axes(reading, known)
    if isinstance(checks, list):
        found["checks"] = [
            _read_check(reading, known, i, text) for i, text in enumerate(checks)
        ]
    return found


def _read_axes(reading: Reading, known: KnownKeys) -> Any:
    """Return the axes of a sweep block."""
    block = reading.words[SWEEP_KEY]
    if not isinstance(block, Mapping):
        form = "keys with their values, such as `excitation.frequency: [1, 2]`"
        reading.fault(f"sweep must be {form}; not {format_value(block)}", (SWEEP_KEY,))
        return ()
    if not block:
        reading.fault("sweep has no keys; give at least one key with its values", (SWEEP_KEY,))
    inner = {key: value for group in _key_groups(block) for key, value in group.items()}
    inner.pop(UNREAD_KEYS, None)
    reading.words[SWEEP_KEY] = {**block, **inner}
    axes: list[Axis] = []
    for key, value in block.items():
        if key == ZIP_KEY:
            axes += _read_zip(reading, known, value)
        elif key == SAMPLE_KEY:
            axes += _read_sample(reading, known, value)
        elif key == SRS_KEY:
            axes += _read_spectrum(reading, known, value)
        elif key not in (DIRECTION_KEY, UNREAD_KEYS):
            axis = _read_axis(reading, known, (SWEEP_KEY, key), block)
            axes += [axis] if axis else []
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
    excitation = get_block(reading.words, "excitation")
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
        if sentence := _chain_fault(reading.words, axis):
            raise ValueError(f"is not possible: {sentence}; {OTHER_FIRST_KEY}")
    way = " and ".join(directions[value])
    words = f"{way}: each case begins where the one before it ended"
    return Axis(DIRECTION_KEY, "", directions[value], value, description=words)


OTHER_FIRST_KEY = "list a key such as excitation.rms first, or remove direction"


def _chain_fault(words: Mapping[str, Any], axis: Axis) -> str | None:
    """Return why the cases along an axis cannot follow one another; None if they can."""
    key, stops = axis.key, get_block(get_block(words, "stroke"), "stops")
    if isinstance(axis.values, SampledValues):
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


def _read_spectrum(reading: Reading, known: KnownKeys, value: Any) -> Iterator[Axis]:
    """Yield the axis of `srs`: natural frequencies, evenly spaced on a log scale by default."""
    at = (SWEEP_KEY, SRS_KEY)
    kind = get_block(reading.words, "excitation").get("kind")
    if kind in EXCITATIONS_BY_KIND and kind not in SHOCK_KINDS:
        sentence = f"needs a shock, as `excitation.kind: shock` or as a record, not {kind}"
        reading.report_value(sentence, at, at_key=True)
        return
    if isinstance(value, Mapping) and "count" in value:
        value = {"scale": "log", **value}
    if (numeral := _read_key(reading, known, at, NATURAL_FREQUENCY_KEY)) and (
        axis := _read_values(reading, at, numeral, NATURAL_FREQUENCY_KEY, value)
    ):
        yield replace(axis, group=SRS_KEY, location=at)


SHOCK_KINDS = ("shock", "record")
"""Kinds of base motion that have a shock response spectrum."""


def _read_zip(reading: Reading, known: KnownKeys, value: Any) -> Iterator[Axis]:
    """Yield the axes of `zip`: one or several groups of keys varying together."""
    form = "keys with equally many values, such as {friction.kinetic: [15, 30], ...}"
    groups: list[tuple[KeyPath, Any]] = [((SWEEP_KEY, ZIP_KEY), value)]
    if isinstance(value, list):
        groups = [((SWEEP_KEY, ZIP_KEY, i), group) for i, group in enumerate(value)]
    for at, group in groups:
        if not isinstance(group, Mapping) or len(group) < 2:
            reading.report_value(f"must be at least two {form}; not {format_value(group)}", at)
            continue
        numerals = _read_keys(reading, known, at, group)
        found = [
            axis
            for key, numeral in numerals.items()
            if (axis := _read_values(reading, (*at, key), numeral, key, group[key]))
        ]
        uneven = next((one for one in found if len(one.values) != len(found[0].values)), None)
        if uneven is not None:
            sentence = (
                f"has {len(uneven.values)} values, but {found[0].key} has "
                f"{len(found[0].values)}; keys of a zip need equally many"
            )
            reading.report_value(sentence, (*at, uneven.key))
            continue
        name = ".".join(map(str, at[1:]))
        yield from (replace(one, group=name, location=(*at, one.key)) for one in found)


def _read_sample(reading: Reading, known: KnownKeys, value: Any) -> Iterator[Axis]:
    """Yield the axes of `sample`: keys with random values."""
    at = (SWEEP_KEY, SAMPLE_KEY)
    if not isinstance(value, Mapping):
        form = "{kind: latin, count: 1000, seed: 1, over: {...}}"
        reading.report_value(f"must be {form}; not {format_value(value)}", at)
        return
    words = reading.block(Sample, value, at)
    over = words.get("over")
    if over is None:
        return
    if not isinstance(over, Mapping) or not over:
        sentence = "must be keys, each with {from, to} or a distribution"
        reading.report_value(f"{sentence}; not {format_value(over)}", (*at, "over"))
        return
    numerals = _read_keys(reading, known, (*at, "over"), over)
    count = _read_whole_number(reading, at, words, "count", 1, MAX_SAMPLE_POINTS)
    seed = _read_whole_number(reading, at, words, "seed", 0, 2**63)
    laws = {
        key: _read_distribution(reading, (*at, "over", key), over[key], numeral)
        for key, numeral in numerals.items()
    }
    if count is None or seed is None or "kind" not in words or None in laws.values():
        return
    if words["kind"] not in get_args(Sample.model_fields["kind"].annotation):
        sentence = f"must be latin, sobol or uniform, not {format_value(words['kind'])}"
        reading.report_value(sentence, (*at, "kind"))
        return
    design = Design(words["kind"], count, len(laws), seed)
    head = {name: words[name] for name in ("kind", "count", "seed")}
    for k, (key, found) in enumerate(laws.items()):
        assert found is not None
        law, spec = found
        unit = numerals[key].header
        label = f"{law.describe(format_unit(unit))} ({count} values, {words['kind']})"
        yield Axis(
            key, unit, SampledValues(design, k, law), (head, spec), "sample", label,
            (*at, "over", key),
        )  # fmt: skip


def _read_keys(
    reading: Reading, known: KnownKeys, at: KeyPath, group: Mapping[str, Any]
) -> dict[str, NumericKey]:
    """Return the valid numeric keys of a group; report the others."""
    found = {}
    for key in group:
        if key == FILE_KEY and key in known:
            sentence = f"{key} must be a key of sweep itself; groups take numbers only"
            reading.fault(sentence, (*at, key), at_key=True)
            continue
        if key != UNREAD_KEYS and (numeral := _read_key(reading, known, (*at, key), key)):
            found[key] = numeral
    return found


def _read_axis(
    reading: Reading, known: KnownKeys, at: KeyPath, block: Mapping[str, Any]
) -> Axis | None:
    """Return the axis of a key in a block; None if it has an error."""
    key = str(at[-1])
    value = block[key]
    if key == FILE_KEY and get_block(reading.words, "excitation").get("kind") == "record":
        return _read_files(reading, at, value)
    numeral = _read_key(reading, known, at, key, () if at[0] == SWEEP_KEY else block)
    if numeral is None:
        return None
    if value is None:
        reading.fault(f"{dotted_name(at)} has no values", at, at_key=True)
        return None
    return _read_values(reading, at, numeral, key, value)


def _read_files(reading: Reading, at: KeyPath, value: Any) -> Axis | None:
    """Return the axis for records: a list of files, or a pattern such as `runs/*.csv`."""
    known, files = len(reading.problems), [value]
    folder = Path(reading.document.file).parent
    with reading.reporting(at):
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
        with reading.reporting((*at, i)):
            if not isinstance(file, str) or not file:
                raise ValueError(f"must be the name of a file, not {format_value(file)}")
            if file in files[:i]:
                raise ValueError(f"is a duplicate: {format_value(file)}")
            if (folder / file).is_dir():
                raise ValueError(_pattern_fault(folder, file))
            if has_magic(file) and not (folder / file).exists():
                remedy = f"without a list: `{FILE_KEY}: {file}`"
                raise ValueError(f"is a pattern, not a file; write it {remedy}")
    if len(reading.problems) > known:
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
    reading: Reading, known: KnownKeys, at: KeyPath, key: str, varied: Iterable[str] = ()
) -> NumericKey | None:
    """Return the numeric key to vary; None if it has an error.

    `varied` are all keys that are varied together; default: those of the sweep.
    """
    top = key.partition(".")[0]
    field = fields_by_key(reading.model).get(top)
    wanted = top in reading.document.value or (field is not None and field.is_required())
    if wanted and top not in reading.words:
        return None  # an error of the block with this key was reported already
    block = SWEEP_KEY if at[0] == SWEEP_KEY else dotted_name(at[:-1])
    if sentence := sweep_fault(reading.words, key, known, varied, block):
        reading.fault(sentence, at, at_key=True)
        return None
    if block == SWEEP_KEY and _is_swept_twice(reading.document.value.get(SWEEP_KEY), key):
        reading.fault(f"{key} is swept twice; remove one", at, at_key=True)
        return None
    return known[key]


def _is_swept_twice(block: Any, key: str) -> bool:
    """Return whether a sweep block contains a key more than once."""
    groups = _key_groups(block)
    return sum(key in group for group in (block, *groups)) > 1 if groups else False


def read_design(reading: Reading) -> dict[str, Any]:
    """Return the varied keys and the conditions of the design block; report their errors."""
    block = get_block(reading.words, DESIGN_KEY)
    known = numeric_keys(reading.model, reading.words)
    found: dict[str, Any] = {}
    vary, over = block.get("vary"), block.get("over")
    before = len(reading.problems)
    if isinstance(vary, Mapping) and vary:
        found["vary"] = _read_vary(reading, known, (DESIGN_KEY, "vary"), vary)
    if isinstance(over, Mapping) and over.keys() - {TAKE_KEY}:
        found["over"] = _read_conditions(reading, known, (DESIGN_KEY, "over"), over)
    if len(reading.problems) > before:  # nothing more is said of these blocks
        reading.reported |= {(DESIGN_KEY, "vary"), (DESIGN_KEY, "over")}
    return found


def _read_vary(
    reading: Reading, known: KnownKeys, at: KeyPath, block: Mapping[str, Any]
) -> tuple[KeyRange, ...]:
    """Return the varied keys of a design."""
    found = []
    if len(block) > MAX_KEYS:
        reading.report_value(f"has {len(block)} keys; a design has at most {MAX_KEYS}", at)
    for key, words in block.items():
        if key == UNREAD_KEYS or not (n := _read_key(reading, known, (*at, key), key, block)):
            continue
        with reading.reporting((*at, key)):
            if n.quantity is None:
                raise ValueError("takes whole numbers, which design does not support")
            if not isinstance(words, Mapping):
                raise ValueError(f"must be {{from, to}}, not {format_value(words)}")
            values = reading.block(VaryRange, words, (*at, key))
            if (ends := _read_ends(reading, (*at, key), n, values)) is not None:
                scale = values.get("scale", "linear")
                _check_scale(scale, ends[0])
                found.append(KeyRange(key, n.header, *ends, scale == "log"))
    return tuple(found)


def _read_conditions(
    reading: Reading, known: KnownKeys, at: KeyPath, block: Mapping[str, Any]
) -> Conditions:
    """Return the conditions under which every design is judged."""
    take = block.get(TAKE_KEY, WORST)
    if take not in (WORST, MEAN):
        sentence = f"must be {WORST} or {MEAN}, not {format_value(take)}"
        reading.report_value(sentence, (*at, TAKE_KEY))
    keys = {key: value for key, value in block.items() if key not in (TAKE_KEY, UNREAD_KEYS)}
    axes = (_read_axis(reading, known, (*at, key), keys) for key in keys)
    return Conditions(
        tuple(replace(axis, location=(*at, axis.key)) for axis in axes if axis), take
    )


def _read_check(reading: Reading, known: KnownKeys, i: int, text: Any) -> Any:
    """Return a parsed check if it has an `at` condition, otherwise the text."""
    if not has_condition(text):
        return text
    numerals = {key: numeral for key, numeral in known.items() if numeral}
    try:
        check = Check.parse(text, {key: numeral.unit for key, numeral in numerals.items()})
    except ValueError as fault:
        sentence = f"checks.{i}: {fault}"
        if FILE_KEY in AT_PATTERN.split(text, maxsplit=1)[1]:
            sentence += (
                "; conditions compare numbers, so a check applies to every record: put a "
                "record with limits of its own into a scenario of its own"
            )
        reading.fault(sentence, ("checks", i))
        return "T_a < 1"  # any valid check: the error was reported
    swept = reading.words.get(SWEEP_KEY)
    keys = [condition.key for condition in check.conditions if condition.key != STATUS]
    for key in dict.fromkeys(keys):
        if isinstance(swept, Mapping) and key not in swept:
            sentence = f"checks.{i}: {key} is not swept; it has the same value in every case"
            reading.fault(sentence, ("checks", i))
    return check.with_values({key: numerals[key].here(key) for key in keys})


# The values of an axis: a list or a range


def _read_values(
    reading: Reading, at: KeyPath, numeral: NumericKey, key: str, value: Any
) -> Axis | None:
    """Return the axis for the values of a key; None if they have an error."""
    known = len(reading.problems)
    values: Sequence[float] = ()
    words: Any = None
    with reading.reporting(at):
        if isinstance(value, list):
            values = _read_list(reading, at, numeral, value)
            words = list(values)
        elif isinstance(value, Mapping):
            values, words = _read_range(reading, at, numeral, value)
            if numeral.quantity is None:
                spacing = next(name for name in Range.one_of[0] if name in value)
                values = _whole_values(key, values, spacing)
        else:
            form = "a list such as `[1, 2]`, or {from, to, step}"
            raise ValueError(f"must be {form}; not {format_value(value)}")
    if len(reading.problems) > known or words is None:
        return None
    return Axis(key, numeral.header, values, words)


def _read_list(
    reading: Reading, at: KeyPath, numeral: NumericKey, entries: list[Any]
) -> tuple[float, ...]:
    """Return the values of a list."""
    if not entries:
        raise ValueError("has no values")
    values: dict[float, None] = {}  # in order
    for i, entry in enumerate(entries):
        with reading.reporting((*at, i)):
            value = numeral.read(entry)
            if value in values:
                raise ValueError(f"is a duplicate: {format_value(entry)}")
            values[value] = None
    return tuple(values)


def _read_range(
    reading: Reading, at: KeyPath, numeral: NumericKey, block: Mapping[str, Any]
) -> tuple[Sequence[float], Any]:
    """Return the values of a range and the range in SI, which is None after an error."""
    words = reading.block(Range, block, at)
    if not {"from", "to"} <= words.keys() or not {*Range.one_of[0]} & words.keys():
        return (), None  # reported
    if (ends := _read_ends(reading, at, numeral, words)) is None:
        return (), None
    known: dict[str, Any] = dict(zip(("from", "to"), ends, strict=True))
    if "step" in words:
        step, values = _step_values(numeral.unit, *ends, words["step"])
        return values, {**known, "step": step}
    count, scale = words.get("count"), words.get("scale", "linear")
    if "per_octave" in words:
        count, scale = _count_in_octaves(*ends, words["per_octave"]), "log"
    values = _count_values(*ends, count, scale)
    return values, {**known, "count": count, "scale": scale}


def _read_ends(
    reading: Reading, at: KeyPath, numeral: NumericKey, words: Mapping[str, Any]
) -> tuple[float, float] | None:
    """Return `from` and `to` of a range; None if one of them is missing or has an error."""
    ends = {name: words[name] for name in ("from", "to") if name in words}
    numbers = _read_numbers(reading, at, numeral, ends)
    if len(numbers) < 2:
        return None
    if numbers["from"] >= numbers["to"]:
        raise InvalidValue(f"must be above `from`, {format_value(ends['from'])}", "to")
    return numbers["from"], numbers["to"]


def _read_numbers(
    reading: Reading, at: KeyPath, numeral: NumericKey, words: Mapping[str, Any]
) -> dict[str, float]:
    """Return the valid values of keys whose values are in the unit of a swept key."""
    found = {}
    for name, value in words.items():
        with reading.reporting((*at, name)):
            quantity = Quantity(numeral.unit, above=0) if name == "sd" else numeral
            found[name] = quantity.read(value)
    return found


def _step_values(
    unit: str, low: float, high: float, value: Any
) -> tuple[float, Sequence[float]]:
    """Return the step and the values of a range with a step."""
    try:
        step = Quantity(unit, above=0).read(value)
    except ValueError as fault:
        raise InvalidValue(str(fault), "step") from None
    _limit_count((high - low) / step + 1, "step")
    n, end = nearest_steps(low, high, step)
    if end != high:
        first, width, last = (f"{x:.12g} {unit}".strip() for x in (low, step, end))
        sentence = f"is not reached by steps of {width} from {first}"
        raise InvalidValue(f"{sentence}; the nearest value is {last}", "to")
    return step, decimal_arange(low, high, step, n)


def _count_in_octaves(low: float, high: float, value: Any) -> int:
    """Return the number of values of a range with at least `value` per octave."""
    per_octave = _whole_number(value, "per_octave")
    if per_octave < 1:
        raise InvalidValue(f"must be at least 1, not {per_octave}", "per_octave")
    _check_scale("log", low)
    intervals = per_octave * log2(high / low)
    _limit_count(intervals + 1, "per_octave")
    return 1 + max(1, ceil(intervals - 1e-9))  # rounding of log2 gives no further value


def _count_values(low: float, high: float, value: Any, scale: Any) -> Sequence[float]:
    """Return the values of a range with a count."""
    count = _whole_number(value, "count")
    if count < 2:
        raise InvalidValue(f"must be at least 2, not {count}: both ends are included", "count")
    _check_scale(scale, low)
    _limit_count(count, "count")
    space = decimal_geomspace if scale == "log" else decimal_linspace
    return space(low, high, count)


def _check_scale(scale: Any, low: float) -> None:
    if scale not in ("linear", "log"):
        raise InvalidValue(f"must be linear or log, not {format_value(scale)}", "scale")
    if scale == "log" and low <= 0:
        raise InvalidValue(f"must be above 0 on a log scale, not {low:.12g}", "from")


def _limit_count(count: float, key: str) -> None:
    if count > MAX_AXIS_VALUES:
        sentence = f"gives {count:.4g} values; an axis can have at most {MAX_AXIS_VALUES}"
        raise InvalidValue(sentence, key)


def _whole_number(value: Any, key: str) -> int:
    """Return an integer, which may be written as 1e3."""
    number = as_integer(value)
    if isinstance(number, bool) or not isinstance(number, int):
        raise InvalidValue(f"must be a whole number, not {format_value(number)}", key)
    return number


def _whole_values(key: str, values: Sequence[float], at: str) -> Sequence[float]:
    """Return the values of an integer key as integers."""
    if fractional := next((value for value in values if not float(value).is_integer()), None):
        raise InvalidValue(f"gives {fractional:.6g}, but {key} takes whole numbers", at)
    return tuple(int(value) for value in values)


# Distributions of the keys of a sample


def _read_whole_number(
    reading: Reading, at: KeyPath, words: Mapping[str, Any], name: str, least: int, most: int
) -> int | None:
    """Return an integer within bounds; None if it has an error."""
    if words.get(name) is None:
        return None  # reported when the block was read
    with reading.reporting(at):
        value = _whole_number(words[name], name)
        if least <= value <= most:
            return value
        raise InvalidValue(f"must be {least} to {most:.0e}, not {format_value(value)}", name)
    return None


def _read_distribution(
    reading: Reading, at: KeyPath, value: Any, numeral: NumericKey
) -> tuple[Distribution, dict[str, Any]] | None:
    """Return a distribution and its block in SI; None if it has an error."""
    noted = len(reading.problems)
    with reading.reporting(at):
        if not isinstance(value, Mapping):
            form = "{from, to}, or a distribution such as {distribution: normal, mean, sd}"
            raise ValueError(f"must be {form}; not {format_value(value)}")
        if numeral.quantity is None:
            sentence = "takes whole numbers, which sample does not support"
            raise ValueError(f"{sentence}; list them in sweep")
        words = reading.block(Draw, value, at)
        kind = words.get("distribution", "uniform")
        if not isinstance(kind, str) or kind not in Draw.parameters:
            sentence = f"must be {', '.join(Draw.parameters)}; not {format_value(kind)}"
            raise InvalidValue(sentence, "distribution")
        needed, allowed = Draw.parameters[kind]
        for name in needed:
            if name not in words:
                reading.fault(f"{dotted_name((*at, name))} is required ({kind})", at)
        for name in words.keys() - {*needed, *allowed, "distribution"}:
            sentence = f"is not used for a {kind} distribution"
            reading.report_value(sentence, (*at, name), at_key=True)
        options = {n: words[n] for n in ("scale", "distribution") if n in words}
        numbers = {n: words[n] for n in words if n not in options}
        values = _read_numbers(reading, at, numeral, numbers)
        if len(reading.problems) == noted:
            scale = words.get("scale", "linear")
            return _make_distribution(kind, values, scale, numeral.quantity), values | options
    return None


def _make_distribution(
    kind: str, values: Mapping[str, float], scale: Any, quantity: Quantity
) -> Distribution:
    """Return a distribution; by default it is truncated to the bounds of the key.

    Raises
    ------
    InvalidValue
        If the parameters are inconsistent.
    """
    low, high = values.get("from", nan), values.get("to", nan)
    if low >= high:
        raise InvalidValue(f"must be above `from`, {low:.12g}", "to")
    _check_scale(scale, low)
    if kind == "uniform":
        return Uniform(low, high, scale == "log")
    if kind == "triangular":
        if not low <= values["mode"] <= high:
            raise InvalidValue(f"must be between {low:.12g} and {high:.12g}", "mode")
        return Triangular(low, values["mode"], high)
    least, most = quantity.ends
    ends = {"low": values.get("from", least), "high": values.get("to", most)}
    if kind == "normal":
        return Normal(values["mean"], values["sd"], **ends)
    if values["mean"] <= 0:
        raise InvalidValue("must be above 0 for a lognormal distribution", "mean")
    ends["low"] = values.get("from", max(least, 0.0))
    return LogNormal(values["mean"], values["sd"], **ends)


# Why a key cannot be swept


def sweep_fault(
    words: Mapping[str, Any],
    key: str,
    known: KnownKeys,
    varied: Iterable[str] = (),
    block_name: str = SWEEP_KEY,
) -> str | None:
    """Return why a key cannot be varied; None if it can.

    `words` is the scenario as plain values, whose `sweep` has dotted keys, and `known` has its
    keys, from `numeric_keys`. `varied` are all keys that are varied together in the block
    `block_name`, by default those of the sweep.
    """
    numeral = known.get(key)
    if numeral is None:
        return _not_numeric_fault(key, known, block_name)
    block, _, name = key.rpartition(".")
    earlier = takewhile(lambda other: other != key, varied or words[SWEEP_KEY])
    swept = {other.rpartition(".")[2] for other in earlier if other.rpartition(".")[0] == block}
    if sentence := _exclusion_fault(block, name, numeral, swept):
        return sentence
    seed_keys = {"seeds", "until"} & get_block(words, "excitation").keys()
    if key == SEED_KEY and seed_keys:
        return (
            f"{SEED_KEY} cannot be swept with excitation.{min(seed_keys)}: every case uses the "
            "same seeds"
        )
    if key in ("measure.settle", "measure.duration") and not _has_window(words):
        return f"{key} is not used: metrics cover the steady state; set it in measure as well"
    known_faults = {sentence for _, sentence in key_faults(words)}
    if "." not in block:  # rules concern top-level blocks: try a number
        words = {**words, block: {**get_block(words, block), name: 1.0}}
    faults = (sentence for _, sentence in key_faults(words))
    return next((sentence for sentence in faults if sentence not in known_faults), None)


def _not_numeric_fault(key: str, known: KnownKeys, block_name: str) -> str:
    """Return the message for a key that is not numeric or unknown."""
    inner = next((k for k, numeral in known.items() if numeral and k.startswith(f"{key}.")), "")
    if inner:
        return f"{key} is a block; write a dotted key, such as `{inner}`"
    if key in known:
        return f"{key} is not a number, so it cannot be varied"
    top = key.partition(".")[0]
    nearest = _closest_key(key, known)
    if block_name == SWEEP_KEY and nearest is None:
        nearest = closest_match(key, [DIRECTION_KEY])
    if nearest:
        hint = did_you_mean(nearest)
    elif top in known and not any(other.startswith(f"{top}.") for other in known):
        hint = f"; this scenario has no {top} block"
    else:
        hint = _known_keys_hint(top, known)
    return f"unknown key {format_value(key)} in {block_name}{hint}"


def _known_keys_hint(top: str, known: KnownKeys) -> str:
    """Return a hint with the numeric keys of a block."""
    inside = {
        key: numeral
        for key, numeral in known.items()
        if numeral and key.startswith(f"{top}.") and key.split(".")[1] not in LAWS
    }
    if not inside:
        return ""
    model = next(iter(inside.values())).model
    tag = discriminator(model) if model else None
    kind = f" of {' '.join(tag)}" if tag else ""
    return f"; known in {top}{kind} are {', '.join(key.partition('.')[2] for key in inside)}"


def _closest_key(key: str, known: KnownKeys) -> str | None:
    """Return the numeric key closest to an unknown one; None if none is close."""
    steps, best, found = key.split("."), (0, False, 0), None
    if len(steps) == 3 and steps[1] in LAWS and known.get(without := f"{steps[0]}.{steps[2]}"):
        return without  # options of the file's own law are keys of the block
    for candidate, numeral in known.items():
        parts = candidate.split(".")
        ours = parts[-1:] if len(steps) == 1 else parts
        if numeral is None or len(ours) != len(steps):
            continue
        if all(a == b or closest_match(a, [b]) for a, b in zip(steps, ours, strict=True)):
            same = sum(a == b for a, b in zip(steps, ours, strict=True))
            rank = (same, numeral.present, -len(parts))
            if found is None or rank > best:
                best, found = rank, candidate
    return found


def _exclusion_fault(block: str, name: str, numeral: NumericKey, swept: set[str]) -> str | None:
    """Return why other keys of its block exclude a key; None if none does."""
    model, values = numeral.model, numeral.block
    if model is None:
        return None
    for group in model.exclusive_groups():
        others = [other for other in group if name in group and other != name]
        if other := next((other for other in others if other in values), ""):
            instead = f"vary {block}.{other}, or give {name} instead"
            return f"{block}.{name} is not used: {block} has {other}; {instead}"
        if other := next((other for other in others if other in swept), ""):
            return f"vary {block}.{name} or {block}.{other}, not both"
    required = model.needs.get(name)
    if required and required not in values:
        which = f"{block}.{required}, which is not given"
        return f"{block}.{name} requires {which}"
    needed = [
        k for k, field in fields_by_key(model).items() if field.is_required() and k != name
    ]
    if needed and not numeral.present:
        return f"{block}.{name} needs its block: give {block} with {' and '.join(needed)}"
    return None


def _has_window(words: Mapping[str, Any]) -> bool:
    """Return whether the metrics cover a time window, not the steady state."""
    member = EXCITATIONS_BY_KIND.get(get_block(words, "excitation").get("kind", ""))
    times = {"settle", "duration"} & get_block(words, "measure").keys()
    return member is None or not member.steady_by_default or bool(times)
