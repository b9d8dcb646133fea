"""From the words of a scenario to its axes and to its checks, or to their problems."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from drysim.checks import AT, STATUS, Check
from drysim.quantity import shown
from drysim.scenario.reading import Reading
from drysim.scenario.sentences import refuse
from drysim.scenario.shape import keys_of
from drysim.scenario.sweep.axis import SAMPLE, ZIP, Axis
from drysim.scenario.sweep.groups import sampled, zipped
from drysim.scenario.sweep.numerals import Known, Numeral, numerals
from drysim.scenario.sweep.refusals import refusal
from drysim.scenario.sweep.sample import Sample
from drysim.scenario.sweep.values import Values
from drysim.source import LOST, Keys

SWEEP = "sweep"
"""The block; its keys are dotted keys of the scenario."""


def with_axes(reading: Reading) -> dict[str, Any]:
    """Give what depends on the numeric keys of a scenario: its axes, its checks with an `at`.

    Parameters
    ----------
    reading : Reading
        Of the whole scenario; the problems are noted in it.
    """
    words, found = reading.words, {}
    checks = words.get("checks")
    conditional = isinstance(checks, list) and any(map(_has_condition, checks))
    if SWEEP not in words and not conditional:
        return {}
    known = numerals(reading.model, words)
    if SWEEP in words:
        found[SWEEP] = _axes(reading, known)
    if isinstance(checks, list):
        found["checks"] = [_check(reading, known, i, text) for i, text in enumerate(checks)]
    return found


def _has_condition(text: Any) -> bool:
    """Whether a check is one with an `at`."""
    return isinstance(text, str) and AT.search(text) is not None


def _axes(reading: Reading, known: Known) -> Any:
    """Give the axes of a sweep block."""
    block = reading.words[SWEEP]
    if not isinstance(block, Mapping):
        form = "keys with their values, such as `excitation.frequency: [1, 2]`"
        reading.fault(f"sweep must be {form}; not {shown(block)}", (SWEEP,))
        return ()
    if not block:
        reading.fault("sweep has no keys; say which key varies, and over what", (SWEEP,))
    reading.words[SWEEP] = {**block, **_inner(block)}
    axes: list[Axis] = []
    for key, given in block.items():
        if key == ZIP:
            axes += _zipped(reading, known, given)
        elif key == SAMPLE:
            axes += _sampled(reading, known, given)
        elif key != LOST and (axis := _axis(reading, known, key, given)):
            axes.append(axis)
    return tuple(axes)


def _groups(block: Any) -> list[Mapping[str, Any]]:
    """Give the groups of keys in a sweep block: those that `zip` and `sample` hold."""
    if not isinstance(block, Mapping):
        return []  # the key `sweep` itself is mistyped, which is a problem of its own
    zips, sample = block.get(ZIP), block.get(SAMPLE)
    several = zips if isinstance(zips, list) else [zips]
    over = sample.get("over") if isinstance(sample, Mapping) else None
    return [group for group in (*several, over) if isinstance(group, Mapping)]


def _inner(block: Mapping[str, Any]) -> dict[str, Any]:
    """Give the keys that a sweep block holds within its groups."""
    groups = _groups(block)
    return {key: given for group in groups for key, given in group.items() if key != LOST}


def _zipped(reading: Reading, known: Known, given: Any) -> Iterator[Axis]:
    """Give the axes of `zip`: one group of keys, or a list of groups."""
    form = "keys with as many values each, such as {friction.kinetic: [15, 30], ...}"
    groups: list[tuple[Keys, Any]] = [((SWEEP, ZIP), given)]
    if isinstance(given, list):
        groups = [((SWEEP, ZIP, i), group) for i, group in enumerate(given)]
    for at, group in groups:
        if not isinstance(group, Mapping) or len(group) < 2:
            refuse(reading, f"must be two {form}; not {shown(group)}", at)
        else:
            yield from zipped(reading, at, group, _numerals(reading, known, at, group))


def _sampled(reading: Reading, known: Known, given: Any) -> Iterator[Axis]:
    """Give the axes of `sample`."""
    at = (SWEEP, SAMPLE)
    if not isinstance(given, Mapping):
        form = "{kind: latin, count: 1000, seed: 1, over: {...}}"
        refuse(reading, f"must be {form}; not {shown(given)}", at)
        return
    words = reading.block(Sample, given, at)
    over = words.get("over")
    if over is None:
        return
    if not isinstance(over, Mapping) or not over:
        sentence = "must be keys, each with {from, to} or a distribution"
        refuse(reading, f"{sentence}; not {shown(over)}", (*at, "over"))
        return
    yield from sampled(reading, at, words, _numerals(reading, known, (*at, "over"), over))


def _numerals(
    reading: Reading, known: Known, at: Keys, group: Mapping[str, Any]
) -> dict[str, Numeral]:
    """Give the numeric keys of a group; what is wrong with the others is noted."""
    found = {}
    for key in group:
        if key != LOST and (numeral := _numeral(reading, known, (*at, key), key)):
            found[key] = numeral
    return found


def _axis(reading: Reading, known: Known, key: str, given: Any) -> Axis | None:
    """Give one axis; None when it has a problem."""
    at = (SWEEP, key)
    numeral = _numeral(reading, known, at, key)
    if numeral is None:
        return None
    if given is None:
        reading.fault(f"sweep.{key} has no values", at, at_key=True)
        return None
    return Values(reading, at, numeral).axis(key, given)


def _numeral(reading: Reading, known: Known, at: Keys, key: str) -> Numeral | None:
    """Give what is known of a swept key; None when it has a problem."""
    top = key.partition(".")[0]
    field = keys_of(reading.model).get(top)
    wanted = top in reading.document.value or (field is not None and field.is_required())
    if wanted and top not in reading.words:
        return None  # the block that the key stands in has its problem already
    if sentence := refusal(reading.words, key, known):
        reading.fault(sentence, at, at_key=True)
        return None
    if _twice(reading.document.value.get(SWEEP), key):
        reading.fault(f"{key} is swept twice; leave one of both out", at, at_key=True)
        return None
    return known[key]


def _twice(block: Any, key: str) -> bool:
    """Whether a sweep block has a key more than once, in its groups or beside them."""
    groups = _groups(block)
    return sum(key in group for group in (block, *groups)) > 1 if groups else False


def _check(reading: Reading, known: Known, i: int, text: Any) -> Any:
    """Give a check with an `at`, whose keys are known here; any other as it is written."""
    if not _has_condition(text):
        return text
    numerals = {key: numeral for key, numeral in known.items() if numeral}
    try:
        check = Check.parse(text, {key: numeral.unit for key, numeral in numerals.items()})
    except ValueError as fault:
        reading.fault(f"checks.{i}: {fault}", ("checks", i))
        return "T_a < 1"  # any sound check: this one has its problem already
    swept = reading.words.get(SWEEP)
    keys = [condition.key for condition in check.conditions if condition.key != STATUS]
    for key in dict.fromkeys(keys):
        if isinstance(swept, Mapping) and key not in swept:
            sentence = f"checks.{i}: {key} is not swept; it has the same value in every case"
            reading.fault(sentence, ("checks", i))
    return check.based_on({key: numerals[key].here(key) for key in keys})
