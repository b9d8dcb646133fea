"""From the words of a sweep block to its axes, or to every problem that it has."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf
from typing import Any

from drysim.checks import AT, Check
from drysim.quantity import Quantity, shown
from drysim.scenario.axis import (
    MOST_VALUES,
    Axis,
    Range,
    by_count,
    by_ratio,
    by_step,
    steps_between,
)
from drysim.scenario.numerals import Numeral, hindrance, no_number, numerals
from drysim.scenario.reading import Reading, dotted
from drysim.scenario.rules import broken
from drysim.scenario.shape import Model
from drysim.source import LOST, Keys

SWEEP = "sweep"
"""The block; its keys are dotted keys of the scenario."""

_FORM = "a list such as `[1, 2]`, or {from, to, step}"


def with_axes(reading: Reading, model: Model) -> dict[str, Any]:
    """Give the words of a scenario that depend on its numeric keys: its axes and its checks."""
    known = numerals(model, reading.words)
    found: dict[str, Any] = {}
    if SWEEP in reading.words:
        found[SWEEP] = axes(reading, known)
    checks = reading.words.get("checks")
    if isinstance(checks, list):
        found["checks"] = [
            conditional(reading, known, i, text) for i, text in enumerate(checks)
        ]
    return found


def conditional(
    reading: Reading, known: Mapping[str, Numeral | None], i: int, text: Any
) -> Check | Any:
    """Give a check with an `at`, whose keys are known here; any other as it is."""
    if not isinstance(text, str) or not AT.search(text):
        return text
    try:
        check = Check.parse(
            text, {key: numeral.unit for key, numeral in known.items() if numeral}
        )
    except ValueError as fault:
        reading.fault(f"checks.{i}: {fault}", ("checks", i))
        return text
    swept = reading.words.get(SWEEP)
    for condition in check.conditions:
        if isinstance(swept, Mapping) and condition.key not in swept:
            sentence = (
                f"checks.{i}: {condition.key} is not swept; it has one value in all cases"
            )
            reading.fault(sentence, ("checks", i))
    here = {condition.key: known[condition.key] for condition in check.conditions}
    return check.where({key: numeral.here(key) for key, numeral in here.items() if numeral})


def axes(reading: Reading, known: Mapping[str, Numeral | None]) -> tuple[Axis, ...]:
    """Give the axes of a scenario; the problems are noted in the reading.

    Parameters
    ----------
    reading : Reading
        Of the whole scenario; its words hold the sweep block as it was written.
    known : mapping
        Every key of the scenario, the numeric ones with what is known of them.
    """
    block = reading.words.get(SWEEP)
    if block is None:
        return ()
    if not isinstance(block, Mapping):
        form = "keys with their values, such as `excitation.frequency: [1, 2]`"
        reading.fault(f"sweep must be {form}; not {shown(block)}", (SWEEP,))
        return ()
    if not block:
        reading.fault("sweep has no keys; say which key varies, and over what", (SWEEP,))
    found = (_axis(reading, known, key, given) for key, given in block.items() if key != LOST)
    return tuple(axis for axis in found if axis)


def _axis(
    reading: Reading, known: Mapping[str, Numeral | None], key: str, given: Any
) -> Axis | None:
    """Give one axis; None when it has a problem."""
    at = (SWEEP, key)
    top = key.partition(".")[0]
    if top in reading.document.value and top not in reading.words:
        return None  # the block that the key stands in has its problem already
    numeral = known.get(key)
    if numeral is None:
        reading.fault(no_number(key, known), at, at_key=True)
        return None
    if sentence := _unused(reading.words, key, numeral):
        reading.fault(sentence, at, at_key=True)
        return None
    return _Values(reading, at, numeral).axis(key, given)


def _unused(words: Mapping[str, Any], key: str, numeral: Numeral) -> str | None:
    """Say why this scenario has no use for a key."""
    block = key.rpartition(".")[0]
    swept = {other for other in words[SWEEP] if other != key}
    others = {o.rpartition(".")[2] for o in swept if o.rpartition(".")[0] == block}
    if why := hindrance(key, numeral, others):
        return f"sweep of {key} {why}"
    if key in ("measure.settle", "measure.duration") and not _windowed(words):
        return f"sweep of {key} has no use: the metrics cover the periodic orbit; set {key}"
    before = set(broken(words))
    after = [fault for fault in broken(_with(words, key.split("."))) if fault not in before]
    return after[0][1] if after else None


def _windowed(words: Mapping[str, Any]) -> bool:
    """Whether the metrics are over a window that the scenario gives."""
    measure, excitation = words.get("measure", {}), words.get("excitation", {})
    periodic = isinstance(excitation, Mapping) and excitation.get("kind") in ("harmonic",)
    return not periodic or bool({"settle", "duration"} & measure.keys())


def _with(words: Mapping[str, Any], steps: list[str]) -> dict[str, Any]:
    """Give the words with some value at a key."""
    first, *rest = steps
    inner = words.get(first)
    if rest and isinstance(inner, list | tuple):
        return dict(words)
    return {**words, first: _with(inner or {}, rest) if rest else 1.0}


class _Values:
    """The values of one axis, read by the rules of its key."""

    def __init__(self, reading: Reading, at: Keys, numeral: Numeral) -> None:
        self.reading = reading
        self.at = at
        self.numeral = numeral

    def axis(self, key: str, given: Any) -> Axis | None:
        """Give the axis that the words mean; None when they have a problem."""
        known = len(self.reading.problems)
        if isinstance(given, list):
            values = self.listed(given)
            words: Any = list(values)
        elif isinstance(given, Mapping):
            values, words = self.spread(given)
        else:
            self.fault(f"must be {_FORM}; not {shown(given)}")
        if len(self.reading.problems) > known or self.at in self.reading.closed:
            return None
        return Axis(key, self.numeral.header, values, words)

    def fault(self, sentence: str, *inner: str | int) -> None:
        """Note a problem of a value."""
        keys = (*self.at, *inner)
        self.reading.fault(f"{dotted(keys)} {sentence}", keys)

    def one(self, given: Any, *inner: str | int) -> float:
        """Give one value; a problem is noted."""
        try:
            return self.numeral.read(given)
        except ValueError as fault:
            self.fault(str(fault), *inner)
            return inf

    def listed(self, given: list[Any]) -> tuple[float, ...]:
        """Give the values of a list."""
        if not given:
            self.fault("has no values")
        values = tuple(self.one(value, i) for i, value in enumerate(given))
        seen: set[float] = set()
        for i, value in enumerate(values):
            if value in seen and value != inf:
                self.fault(f"stands in the list already: {shown(given[i])}", i)
            seen.add(value)
        return values

    def spread(self, given: Mapping[str, Any]) -> tuple[tuple[float, ...], Any]:
        """Give the values between two ends, and how a file says them in SI."""
        words = self.reading.block(Range, given, self.at)
        if not {"from", "to"} <= words.keys() or not {"step", "count"} & words.keys():
            return (), None
        low, high = self.one(words["from"], "from"), self.one(words["to"], "to")
        if inf in (low, high):
            return (), None
        if low >= high:
            self.fault(f"must be above `from`, {shown(words['from'])}", "to")
            return (), None
        ends = {"from": low, "to": high}
        if "step" in words:
            return self.stepped(low, high, words["step"], ends)
        return self.counted(low, high, words["count"], words.get("scale", "linear"), ends)

    def stepped(
        self, low: float, high: float, given: Any, ends: dict[str, float]
    ) -> tuple[tuple[float, ...], Any]:
        """Give the values of a step."""
        try:
            step = Quantity(self.numeral.unit, above=0).read(given)
        except ValueError as fault:
            self.fault(str(fault), "step")
            return (), None
        if self.too_many((high - low) / step + 1, "step"):
            return (), None
        n, end = steps_between(low, high, step)
        if end != high:
            unit = f" {self.numeral.unit}".rstrip()
            self.fault(
                f"is not met by steps of {step:.12g}{unit} from {low:.12g}{unit}; "
                f"the nearest is {end:.12g}{unit}",
                "to",
            )
            return (), None
        return self.whole(by_step(low, high, step, n), "step"), {**ends, "step": step}

    def counted(
        self, low: float, high: float, count: Any, scale: Any, ends: dict[str, float]
    ) -> tuple[tuple[float, ...], Any]:
        """Give a number of values."""
        if isinstance(count, bool) or not isinstance(count, int):
            self.fault(f"must be a whole number, not {shown(count)}", "count")
        elif count < 2:
            self.fault(f"must be at least 2, not {count}: both ends are included", "count")
        elif scale not in ("linear", "log"):
            self.fault(f"must be linear or log, not {shown(scale)}", "scale")
        elif scale == "log" and low <= 0:
            self.fault(f"must be above 0 on a log scale, not {low:.12g}", "from")
        elif not self.too_many(count, "count"):
            make = by_ratio if scale == "log" else by_count
            words = {**ends, "count": count, "scale": scale}
            return self.whole(make(low, high, count), "count"), words
        return (), None

    def too_many(self, count: float, key: str) -> bool:
        """Note a problem when an axis is beyond all reason."""
        if count <= MOST_VALUES:
            return False
        self.fault(f"asks for {count:.4g} values; an axis has {MOST_VALUES} at most", key)
        return True

    def whole(self, values: tuple[float, ...], key: str) -> tuple[float, ...]:
        """Give the values of a key that takes whole numbers only as such."""
        if self.numeral.quantity is not None:
            return values
        odd = next((value for value in values if not float(value).is_integer()), None)
        if odd is not None:
            self.fault(f"gives {odd:.6g}, and {self.at[1]} takes whole numbers", key)
        return tuple(int(value) for value in values)


def points(axes: tuple[Axis, ...]) -> Iterator[dict[str, float]]:
    """Give every point of a grid without holding them all; the first axis varies fastest."""
    if not axes:
        yield {}
        return
    *inner, last = axes
    for value in last.values:
        for point in points(tuple(inner)):
            yield {**point, last.key: value}
