"""The values of a key in a sweep, read from a file: a list, a range or a distribution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil, log2, nan
from typing import Any

from drysim.block import InvalidValue
from drysim.excitation.base import as_integer
from drysim.messages import format_value
from drysim.quantity import Quantity
from drysim.scenario.axes import (
    MAX_AXIS_VALUES,
    Axis,
    Draw,
    Range,
    decimal_arange,
    decimal_geomspace,
    decimal_linspace,
    nearest_steps,
)
from drysim.scenario.keys import (
    NumericKey,
)
from drysim.scenario.reading import Reading
from drysim.scenario.sampling import (
    Distribution,
    LogNormal,
    Normal,
    Triangular,
    Uniform,
)
from drysim.scenario.validation import spoken_name
from drysim.yaml_document import KeyPath


def read_values(
    reading: Reading, path: KeyPath, numeral: NumericKey, key: str, value: Any
) -> Axis | None:
    """Return the axis for the values of a key; None if they have an error."""
    noted = len(reading.problems)
    values: Sequence[float] = ()
    entry: Any = None
    with reading.reporting(path):
        if isinstance(value, list):
            values = _read_list(reading, path, numeral, value)
            entry = list(values)
        elif isinstance(value, Mapping):
            values, entry = _read_range(reading, path, numeral, value)
            if numeral.quantity is None:
                spacing = next(name for name in Range.one_of[0] if name in value)
                values = _whole_values(key, values, spacing)
        else:
            form = "a list such as `[1, 2]`, or {from, to, step}"
            raise ValueError(f"must be {form}; not {format_value(value)}")
    if len(reading.problems) > noted or entry is None:
        return None
    return Axis(key, numeral.header, values, entry, bounds=numeral.bounds)


def _read_list(
    reading: Reading, path: KeyPath, numeral: NumericKey, entries: list[Any]
) -> tuple[float, ...]:
    """Return the values of a list."""
    if not entries:
        raise ValueError("has no values")
    values: dict[float, None] = {}  # in order
    for i, entry in enumerate(entries):
        with reading.reporting((*path, i)):
            value = numeral.read(entry)
            if value in values:
                raise ValueError(f"is a duplicate: {format_value(entry)}")
            values[value] = None
    return tuple(values)


def _read_range(
    reading: Reading, path: KeyPath, numeral: NumericKey, block: Mapping[str, Any]
) -> tuple[Sequence[float], Any]:
    """Return the values of a range and the range in SI, which is None after an error."""
    given = reading.block(Range, block, path)
    if not {"from", "to"} <= given.keys() or not {*Range.one_of[0]} & given.keys():
        return (), None  # reported
    if (ends := read_ends(reading, path, numeral, given)) is None:
        return (), None
    entry: dict[str, Any] = dict(zip(("from", "to"), ends, strict=True))
    if "step" in given:
        step, values = _step_values(numeral.unit, *ends, given["step"])
        return values, {**entry, "step": step}
    count, scale = given.get("count"), given.get("scale", "linear")
    if "per_octave" in given:
        count, scale = _count_in_octaves(*ends, given["per_octave"]), "log"
    values = _count_values(*ends, count, scale)
    return values, {**entry, "count": count, "scale": scale}


def read_ends(
    reading: Reading, path: KeyPath, numeral: NumericKey, values: Mapping[str, Any]
) -> tuple[float, float] | None:
    """Return `from` and `to` of a range; None if one of them is missing or has an error."""
    ends = {name: values[name] for name in ("from", "to") if name in values}
    numbers = _read_numbers(reading, path, numeral, ends)
    if len(numbers) < 2:
        return None
    if numbers["from"] >= numbers["to"]:
        raise InvalidValue(f"must be above `from`, {format_value(ends['from'])}", "to")
    return numbers["from"], numbers["to"]


def _read_numbers(
    reading: Reading, path: KeyPath, numeral: NumericKey, values: Mapping[str, Any]
) -> dict[str, float]:
    """Return the valid values of keys whose values are in the unit of a swept key."""
    numbers = {}
    for name, value in values.items():
        with reading.reporting((*path, name)):
            quantity = Quantity(numeral.unit, above=0) if name == "sd" else numeral
            numbers[name] = quantity.read(value)
    return numbers


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
    check_scale("log", low)
    intervals = per_octave * log2(high / low)
    _limit_count(intervals + 1, "per_octave")
    return 1 + max(1, ceil(intervals - 1e-9))  # rounding of log2 gives no further value


def _count_values(low: float, high: float, value: Any, scale: Any) -> Sequence[float]:
    """Return the values of a range with a count."""
    count = _whole_number(value, "count")
    if count < 2:
        raise InvalidValue(f"must be at least 2, not {count}: both ends are included", "count")
    check_scale(scale, low)
    _limit_count(count, "count")
    space = decimal_geomspace if scale == "log" else decimal_linspace
    return space(low, high, count)


def check_scale(scale: Any, low: float) -> None:
    """Raise InvalidValue for a scale that there is not, or a log scale from 0 or below."""
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


def _whole_values(key: str, values: Sequence[float], path: str) -> Sequence[float]:
    """Return the values of an integer key as integers."""
    if fractional := next((value for value in values if not float(value).is_integer()), None):
        raise InvalidValue(f"gives {fractional:.6g}, but {key} takes whole numbers", path)
    return tuple(int(value) for value in values)


# Distributions of the keys of a sample


def read_whole_number(
    reading: Reading, path: KeyPath, values: Mapping[str, Any], name: str, least: int, most: int
) -> int | None:
    """Return an integer within bounds; None if it has an error."""
    if values.get(name) is None:
        return None  # reported when the block was read
    with reading.reporting(path):
        value = _whole_number(values[name], name)
        if least <= value <= most:
            return value
        raise InvalidValue(f"must be {least} to {most:.0e}, not {format_value(value)}", name)
    return None


def read_distribution(
    reading: Reading, path: KeyPath, value: Any, numeral: NumericKey
) -> tuple[Distribution, dict[str, Any]] | None:
    """Return a distribution and its block in SI; None if it has an error."""
    noted = len(reading.problems)
    with reading.reporting(path):
        if not isinstance(value, Mapping):
            form = "{from, to}, or a distribution such as {distribution: normal, mean, sd}"
            raise ValueError(f"must be {form}; not {format_value(value)}")
        if numeral.quantity is None:
            sentence = "takes whole numbers, which sample does not support"
            raise ValueError(f"{sentence}; list them in sweep")
        parameters = reading.block(Draw, value, path)
        kind = parameters.get("distribution", "uniform")
        if not isinstance(kind, str) or kind not in Draw.parameters:
            sentence = f"must be {', '.join(Draw.parameters)}; not {format_value(kind)}"
            raise InvalidValue(sentence, "distribution")
        needed, allowed = Draw.parameters[kind]
        for name in needed:
            if name not in parameters:
                reading.fault(f"{spoken_name((*path, name))} is required ({kind})", path)
        for name in parameters.keys() - {*needed, *allowed, "distribution"}:
            sentence = f"is not used for a {kind} distribution"
            reading.report_value(sentence, (*path, name), at_key=True)
        options = {n: parameters[n] for n in ("scale", "distribution") if n in parameters}
        numbers = {n: parameters[n] for n in parameters if n not in options}
        values = _read_numbers(reading, path, numeral, numbers)
        if len(reading.problems) == noted:
            scale = parameters.get("scale", "linear")
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
    check_scale(scale, low)
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
