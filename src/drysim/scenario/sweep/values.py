"""The values of an axis, read by the rules of its key: a list, or a range."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import nan
from typing import Any

from drysim.excitation.generated import as_whole
from drysim.quantity import Quantity, shown
from drysim.scenario.reading import Reading
from drysim.scenario.sentences import refuse
from drysim.scenario.sweep.axis import Axis, Range
from drysim.scenario.sweep.numerals import Numeral
from drysim.scenario.sweep.spread import (
    MOST_VALUES,
    by_count,
    by_ratio,
    by_step,
    steps_between,
)
from drysim.source import Keys


class Faulty(Exception):
    """A problem was noted; nothing more can be said about the axis."""


class Values:
    """What is written for one axis, and the problems of reading it."""

    def __init__(self, reading: Reading, at: Keys, numeral: Numeral) -> None:
        self.reading = reading
        self.at = at
        self.numeral = numeral

    def axis(self, key: str, given: Any) -> Axis | None:
        """Give the axis that the words mean; None when they have a problem."""
        known = len(self.reading.problems)
        try:
            values, words = self._read(given)
        except Faulty:
            return None
        if len(self.reading.problems) > known:
            return None
        return Axis(key, self.numeral.header, values, words)

    def _read(self, given: Any) -> tuple[Sequence[float], Any]:
        """Give the values, and how a file says them in SI."""
        if isinstance(given, list):
            values = self._listed(given)
            return values, list(values)
        if isinstance(given, Mapping):
            return self._spread(self.reading.block(Range, given, self.at))
        form = "a list such as `[1, 2]`, or {from, to, step}"
        raise self._fault(f"must be {form}; not {shown(given)}")

    def _fault(self, sentence: str, *inner: str | int) -> Faulty:
        """Note a problem of a value."""
        keys = (*self.at, *inner)
        refuse(self.reading, sentence, keys)
        return Faulty()

    def _one(self, given: Any, *inner: str | int) -> float:
        """Give one value, which is no number when it has a problem."""
        try:
            return self.numeral.read(given)
        except ValueError as fault:
            self._fault(str(fault), *inner)
            return nan

    def _listed(self, given: list[Any]) -> tuple[float, ...]:
        """Give the values of a list."""
        if not given:
            raise self._fault("has no values")
        values = tuple(self._one(value, i) for i, value in enumerate(given))
        seen: set[float] = set()
        for i, value in enumerate(values):
            if value in seen and value == value:
                self._fault(f"stands in the list already: {shown(given[i])}", i)
            seen.add(value)
        return values

    def _spread(self, words: Mapping[str, Any]) -> tuple[Sequence[float], Any]:
        """Give the values of a range, and the range in SI."""
        if not {"from", "to"} <= words.keys() or not {"step", "count"} & words.keys():
            raise Faulty  # noted when the block was read
        low, high = self._one(words["from"], "from"), self._one(words["to"], "to")
        if low != low or high != high:
            raise Faulty
        if low >= high:
            raise self._fault(f"must be above `from`, {shown(words['from'])}", "to")
        ends = {"from": low, "to": high}
        if "step" in words:
            step, values = self._stepped(low, high, words["step"])
            return self._whole(values, "step"), {**ends, "step": step}
        scale = words.get("scale", "linear")
        values = self._counted(low, high, words["count"], scale)
        whole = self._whole(values, "count")
        return whole, {**ends, "count": words["count"], "scale": scale}

    def _stepped(self, low: float, high: float, given: Any) -> tuple[float, Sequence[float]]:
        """Give the step and the values."""
        unit = self.numeral.unit
        try:
            step = Quantity(unit, above=0).read(given)
        except ValueError as fault:
            raise self._fault(str(fault), "step") from None
        self._refuse_too_many((high - low) / step + 1, "step")
        n, end = steps_between(low, high, step)
        if end != high:
            first, width, last = (f"{x:.12g} {unit}".strip() for x in (low, step, end))
            sentence = f"is not met by steps of {width} from {first}; the nearest is {last}"
            raise self._fault(sentence, "to")
        return step, by_step(low, high, step, n)

    def _counted(self, low: float, high: float, count: Any, scale: Any) -> Sequence[float]:
        """Give a number of values."""
        count = as_whole(count)
        if isinstance(count, bool) or not isinstance(count, int):
            raise self._fault(f"must be a whole number, not {shown(count)}", "count")
        if count < 2:
            sentence = f"must be at least 2, not {count}: both ends are included"
            raise self._fault(sentence, "count")
        if scale not in ("linear", "log"):
            raise self._fault(f"must be linear or log, not {shown(scale)}", "scale")
        if scale == "log" and low <= 0:
            raise self._fault(f"must be above 0 on a log scale, not {low:.12g}", "from")
        self._refuse_too_many(count, "count")
        return by_ratio(low, high, count) if scale == "log" else by_count(low, high, count)

    def _refuse_too_many(self, count: float, key: str) -> None:
        """Note a problem when an axis is beyond all reason."""
        if count > MOST_VALUES:
            sentence = f"asks for {count:.4g} values; an axis has {MOST_VALUES} at most"
            raise self._fault(sentence, key)

    def _whole(self, values: Sequence[float], key: str) -> Sequence[float]:
        """Give the values of a key that takes whole numbers only as such."""
        if self.numeral.quantity is not None:
            return values
        if odd := next((value for value in values if not float(value).is_integer()), None):
            raise self._fault(f"gives {odd:.6g}, and {self.at[1]} takes whole numbers", key)
        return tuple(int(value) for value in values)
