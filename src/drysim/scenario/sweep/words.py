"""From the words of a scenario to its axes and to its checks, or to their problems."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drysim.checks import AT, Check
from drysim.quantity import shown
from drysim.scenario.reading import Reading
from drysim.scenario.shape import keys_of
from drysim.scenario.sweep.axis import Axis
from drysim.scenario.sweep.numerals import Known, numerals
from drysim.scenario.sweep.refusals import refusal
from drysim.scenario.sweep.values import Values
from drysim.source import LOST

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
    axes = [_axis(reading, known, key, given) for key, given in block.items() if key != LOST]
    return tuple(axis for axis in axes if axis)


def _axis(reading: Reading, known: Known, key: str, given: Any) -> Axis | None:
    """Give one axis; None when it has a problem."""
    at, top = (SWEEP, key), key.partition(".")[0]
    field = keys_of(reading.model).get(top)
    wanted = top in reading.document.value or (field is not None and field.is_required())
    if wanted and top not in reading.words:
        return None  # the block that the key stands in has its problem already
    if sentence := refusal(reading.words, key, known):
        reading.fault(sentence, at, at_key=True)
        return None
    if given is None:
        reading.fault(f"sweep.{key} has no values", at, at_key=True)
        return None
    numeral = known[key]
    return Values(reading, at, numeral).axis(key, given) if numeral else None


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
    for key in dict.fromkeys(condition.key for condition in check.conditions):
        if isinstance(swept, Mapping) and key not in swept:
            sentence = f"checks.{i}: {key} is not swept; it has the same value in every case"
            reading.fault(sentence, ("checks", i))
    keys = [condition.key for condition in check.conditions]
    return check.based_on({key: numerals[key].here(key) for key in keys})
