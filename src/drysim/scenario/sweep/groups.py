"""Keys that walk together: `zip` and `sample` of a sweep block, read with their problems."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from drysim.excitation.generated import as_whole
from drysim.quantity import Quantity, shown
from drysim.scenario.reading import Reading
from drysim.scenario.sentences import refuse
from drysim.scenario.sweep.axis import Axis
from drysim.scenario.sweep.design import Design
from drysim.scenario.sweep.drawn import (
    Distribution,
    Drawn,
    LogNormal,
    Normal,
    Triangular,
    Uniform,
)
from drysim.scenario.sweep.numerals import Numeral
from drysim.scenario.sweep.sample import Draw, Sample
from drysim.scenario.sweep.values import Values
from drysim.source import Keys
from drysim.wording import pretty

MOST_POINTS = 10**12
"""Points of a sample: beyond it somebody has typed too many zeros."""

MOST_SEED = 2**63


def zipped(
    reading: Reading, at: Keys, given: Mapping[str, Any], known: Mapping[str, Numeral]
) -> Iterator[Axis]:
    """Give keys that take their values side by side; all have as many."""
    found = [
        axis
        for key, numeral in known.items()
        if (axis := Values(reading, (*at, key), numeral).axis(key, given[key]))
    ]
    for axis in found[1:]:
        if len(axis.values) != len(found[0].values):
            sentence = (
                f"has {len(axis.values)} values, and {found[0].key} beside it has "
                f"{len(found[0].values)}; keys that walk together have as many"
            )
            refuse(reading, sentence, (*at, axis.key))
            return
    name = ".".join(map(str, at[1:]))
    yield from (axis.walking(name, (*at, axis.key)) for axis in found)


def sampled(
    reading: Reading, at: Keys, words: Mapping[str, Any], known: Mapping[str, Numeral]
) -> Iterator[Axis]:
    """Give the keys of a sample, whose words were read as a `Sample`."""
    count = _whole(reading, at, words, "count", 1, MOST_POINTS)
    seed = _whole(reading, at, words, "seed", 0, MOST_SEED)
    laws = {
        key: _law(reading, (*at, "over", key), words["over"][key], numeral)
        for key, numeral in known.items()
    }
    if count is None or seed is None or "kind" not in words or None in laws.values():
        return
    if words["kind"] not in Sample.model_fields["kind"].annotation.__args__:  # type: ignore[union-attr]
        sentence = f"must be latin, sobol or uniform, not {shown(words['kind'])}"
        refuse(reading, sentence, (*at, "kind"))
        return
    design = Design(words["kind"], count, len(laws), seed)
    head = {name: words[name] for name in ("kind", "count", "seed")}
    for k, (key, found) in enumerate(laws.items()):
        assert found is not None
        law, spoken = found
        unit = known[key].header
        told = f"{law.words(pretty(unit))} ({count} values, {words['kind']})"
        yield Axis(
            key, unit, Drawn(design, k, law), (head, spoken), "sample", told,
            (*at, "over", key),
        )  # fmt: skip


def _whole(
    reading: Reading, at: Keys, words: Mapping[str, Any], name: str, least: int, most: int
) -> int | None:
    """Give a whole number within bounds; None when it has a problem."""
    given, place = as_whole(words.get(name)), (*at, name)
    if given is None:
        return None  # noted when the block was read
    if isinstance(given, bool) or not isinstance(given, int):
        refuse(reading, f"must be a whole number, not {shown(given)}", place)
        return None
    if not least <= given <= most:
        sentence = f"must be {least} to {most:.0e}, not {shown(given)}"
        refuse(reading, sentence, place)
        return None
    return given


def _law(
    reading: Reading, at: Keys, given: Any, numeral: Numeral
) -> tuple[Distribution, dict[str, Any]] | None:
    """Give how a key scatters, and how a file says it in SI; None when it has a problem."""
    noted = len(reading.problems)
    if not isinstance(given, Mapping):
        form = "{from, to}, or a distribution such as {distribution: normal, mean, sd}"
        refuse(reading, f"must be {form}; not {shown(given)}", at)
        return None
    if numeral.quantity is None:
        refuse(reading, "takes whole numbers; list them in sweep instead", at)
        return None
    words = reading.block(Draw, given, at)
    kind = words.get("distribution", "uniform")
    if not isinstance(kind, str) or kind not in Draw.takes:
        sentence = f"must be {', '.join(Draw.takes)}; not {shown(kind)}"
        refuse(reading, sentence, (*at, "distribution"))
        return None
    needed, allowed = Draw.takes[kind]
    for name in needed:
        if name not in words:
            reading.fault(f"{'.'.join(map(str, (*at, name)))} is required ({kind})", at)
    for name in words.keys() - {*needed, *allowed, "distribution"}:
        place = (*at, name)
        refuse(reading, f"has no use for a {kind} distribution", place, at_key=True)
    values = {name: _one(reading, (*at, name), words[name], numeral, name) for name in words
              if name not in ("distribution", "scale")}  # fmt: skip
    if len(reading.problems) > noted:
        return None
    spoken = {**values} | {n: words[n] for n in ("scale", "distribution") if n in words}
    scale = words.get("scale", "linear")
    if found := _misfit(kind, values, scale):
        sentence, name = found
        refuse(reading, sentence, (*at, name))
        return None
    return _made(kind, values, scale, numeral.quantity), spoken


def _one(reading: Reading, at: Keys, given: Any, numeral: Numeral, name: str) -> float:
    """Give one number of a distribution in the unit of its key."""
    try:
        if name == "sd":
            return Quantity(numeral.unit, above=0).read(given)
        return numeral.read(given)
    except ValueError as fault:
        refuse(reading, str(fault), at)
        return float("nan")


def _misfit(kind: str, values: Mapping[str, float], scale: Any) -> tuple[str, str] | None:
    """Give what is wrong with values that do not fit each other, and the one to blame."""
    low, high = values.get("from", float("nan")), values.get("to", float("nan"))
    if low >= high:
        return f"must be above `from`, {low:.12g}", "to"
    if scale not in ("linear", "log"):
        return f"must be linear or log, not {shown(scale)}", "scale"
    if scale == "log" and low <= 0:
        return f"must be above 0 on a log scale, not {low:.12g}", "from"
    if kind == "triangular" and not low <= values["mode"] <= high:
        return f"must lie from {low:.12g} to {high:.12g}", "mode"
    if kind == "lognormal" and values["mean"] <= 0:
        return "must be above 0 for a lognormal distribution", "mean"
    return None


def _made(
    kind: str, values: Mapping[str, float], scale: str, quantity: Quantity
) -> Distribution:
    """Give a distribution, cut at the bounds of its key where it has no ends of its own."""
    if kind == "uniform":
        return Uniform(values["from"], values["to"], scale == "log")
    if kind == "triangular":
        return Triangular(values["from"], values["mode"], values["to"])
    least, most = quantity.ends
    if kind == "lognormal":
        least = max(least, 0.0)
    ends = {"low": values.get("from", least), "high": values.get("to", most)}
    shape = Normal if kind == "normal" else LogNormal
    return shape(values["mean"], values["sd"], **ends)
