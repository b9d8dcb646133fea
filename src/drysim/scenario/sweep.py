"""The sweep block of a file: its grids, zips and samples become axes, or are told as problems.

A sweep names keys of the scenario by their dotted names. `numerals` of `reading` knows these
with types and units, so values are read by the rules of their key. What a key varies over is a
list or a range (`Values`), alone or side by side with others (`zip`), or is drawn (`sample`, by
a design of `sampling`). `refusal` says why a key cannot be swept at all. Checks with an `at`
are read here, too: they name keys of the same kind.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import takewhile
from math import nan
from typing import Any, get_args

from drysim.excitation.base import as_whole
from drysim.metrics.checks import STATUS, Check, conditional
from drysim.scenario.axes import (
    MOST_VALUES,
    SAMPLE,
    SWEEP,
    ZIP,
    Axis,
    Draw,
    Range,
    Sample,
    by_count,
    by_ratio,
    by_step,
    steps_between,
)
from drysim.scenario.blocks import SEED
from drysim.scenario.model import KINDS, broken
from drysim.scenario.reading import (
    LAWS,
    Known,
    Numeral,
    Reading,
    block_in,
    keys_of,
    numerals,
    refuse,
    tag_of,
)
from drysim.scenario.sampling import (
    Design,
    Distribution,
    Drawn,
    LogNormal,
    Normal,
    Triangular,
    Uniform,
)
from drysim.units import Quantity, meant, near, shown
from drysim.wording import pretty
from drysim.yaml_document import LOST, Keys

MOST_POINTS = 10**12
"""Points of a sample: beyond it somebody has typed too many zeros."""


def with_axes(reading: Reading) -> dict[str, Any]:
    """Give what depends on the numeric keys of a scenario: its axes, its checks with an `at`.

    Parameters
    ----------
    reading : Reading
        Of the whole scenario; the problems are noted in it.
    """
    words, found = reading.words, {}
    checks = words.get("checks")
    known = numerals(reading.model, words)
    if SWEEP in words:
        found[SWEEP] = _axes(reading, known)
    if isinstance(checks, list):
        found["checks"] = [_check(reading, known, i, text) for i, text in enumerate(checks)]
    return found


def _axes(reading: Reading, known: Known) -> Any:
    """Give the axes of a sweep block."""
    block = reading.words[SWEEP]
    if not isinstance(block, Mapping):
        form = "keys with their values, such as `excitation.frequency: [1, 2]`"
        reading.fault(f"sweep must be {form}; not {shown(block)}", (SWEEP,))
        return ()
    if not block:
        reading.fault("sweep has no keys; say which key varies, and over what", (SWEEP,))
    inner = {key: given for group in _groups(block) for key, given in group.items()}
    inner.pop(LOST, None)
    reading.words[SWEEP] = {**block, **inner}
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


def _zipped(reading: Reading, known: Known, given: Any) -> Iterator[Axis]:
    """Give the axes of `zip`: keys that take their values side by side, in groups or in one."""
    form = "keys with as many values each, such as {friction.kinetic: [15, 30], ...}"
    groups: list[tuple[Keys, Any]] = [((SWEEP, ZIP), given)]
    if isinstance(given, list):
        groups = [((SWEEP, ZIP, i), group) for i, group in enumerate(given)]
    for at, group in groups:
        if not isinstance(group, Mapping) or len(group) < 2:
            refuse(reading, f"must be two {form}; not {shown(group)}", at)
            continue
        numerals = _numerals(reading, known, at, group)
        found = [
            axis
            for key, numeral in numerals.items()
            if (axis := Values(reading, (*at, key), numeral).axis(key, group[key]))
        ]
        odd = next((one for one in found if len(one.values) != len(found[0].values)), None)
        if odd is not None:
            sentence = (
                f"has {len(odd.values)} values, and {found[0].key} beside it has "
                f"{len(found[0].values)}; keys that walk together have as many"
            )
            refuse(reading, sentence, (*at, odd.key))
            continue
        name = ".".join(map(str, at[1:]))
        yield from (replace(one, walk=name, place=(*at, one.key)) for one in found)


def _sampled(reading: Reading, known: Known, given: Any) -> Iterator[Axis]:
    """Give the axes of `sample`: keys of whose values a design draws some for every case."""
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
    numerals = _numerals(reading, known, (*at, "over"), over)
    count = _whole(reading, at, words, "count", 1, MOST_POINTS)
    seed = _whole(reading, at, words, "seed", 0, 2**63)
    laws = {
        key: _law(reading, (*at, "over", key), over[key], numeral)
        for key, numeral in numerals.items()
    }
    if count is None or seed is None or "kind" not in words or None in laws.values():
        return
    if words["kind"] not in get_args(Sample.model_fields["kind"].annotation):
        sentence = f"must be latin, sobol or uniform, not {shown(words['kind'])}"
        refuse(reading, sentence, (*at, "kind"))
        return
    design = Design(words["kind"], count, len(laws), seed)
    head = {name: words[name] for name in ("kind", "count", "seed")}
    for k, (key, found) in enumerate(laws.items()):
        assert found is not None
        law, spoken = found
        unit = numerals[key].header
        told = f"{law.words(pretty(unit))} ({count} values, {words['kind']})"
        yield Axis(
            key, unit, Drawn(design, k, law), (head, spoken), "sample", told,
            (*at, "over", key),
        )  # fmt: skip


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
    if not conditional(text):
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


# The values of an axis, read by the rules of its key: a list, or a range.


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


# How the values of a key scatter in a sample.


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
    return _distribution(kind, values, scale, numeral.quantity), spoken


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


def _distribution(
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


# Why a key cannot be swept, in sentences.


STEADY = {kind for kind, member in KINDS.items() if member.steady_by_default}
"""Kinds of excitation that are measured over the periodic orbit when nothing else is said."""


def refusal(words: Mapping[str, Any], key: str, known: Known) -> str | None:
    """Say why a key of the sweep cannot be swept; None when it can.

    `words` are those of the scenario, its `sweep` by dotted keys.
    """
    numeral = known.get(key)
    if numeral is None:
        return _no_number(key, known)
    block, _, name = key.rpartition(".")
    before = takewhile(lambda other: other != key, words["sweep"])
    beside = {other.rpartition(".")[2] for other in before if other.rpartition(".")[0] == block}
    if sentence := _excluded(block, name, numeral, beside):
        return sentence
    given = {"seeds", "until"} & block_in(words, "excitation").keys()
    if key == SEED and given:
        return f"{SEED} cannot be swept beside {min(given)}: every case has the same seeds then"
    if block == "measure" and not _windowed(words):
        return f"{key} has no use here: metrics cover the periodic orbit; give it in measure"
    known_faults = {sentence for _, sentence in broken(words)}
    if "." not in block:  # rules are about blocks that are not within another: try some number
        words = {**words, block: {**block_in(words, block), name: 1.0}}
    faults = (sentence for _, sentence in broken(words))
    return next((sentence for sentence in faults if sentence not in known_faults), None)


def _no_number(key: str, known: Known) -> str:
    """Say what is wrong with a key that is no numeric key of the scenario."""
    inner = next((k for k, numeral in known.items() if numeral and k.startswith(f"{key}.")), "")
    if inner:
        return f"{key} is a block; write a dotted key, such as `{inner}`"
    if key in known:
        return f"{key} is not a number, so it cannot be swept"
    top = key.partition(".")[0]
    if nearest := _nearest(key, known):
        hint = meant(nearest)
    elif top in known and not any(other.startswith(f"{top}.") for other in known):
        hint = f"; this scenario has no {top} block"
    else:
        hint = _instead(top, known)
    return f"unknown key {shown(key)} in sweep{hint}"


def _instead(top: str, known: Known) -> str:
    """Give the keys that a block has, and the member of a shelf that it is."""
    inside = {
        key: numeral
        for key, numeral in known.items()
        if numeral and key.startswith(f"{top}.") and key.split(".")[1] not in LAWS
    }
    if not inside:
        return ""
    model = next(iter(inside.values())).model
    tag = tag_of(model) if model else None
    kind = f" of {' '.join(tag)}" if tag else ""
    return f"; known in {top}{kind} are {', '.join(key.partition('.')[2] for key in inside)}"


def _nearest(key: str, known: Known) -> str | None:
    """Give the numeric key that was probably meant by one that is not there."""
    steps, best, found = key.split("."), (0, False, 0), None
    if len(steps) == 3 and steps[1] in LAWS and known.get(without := f"{steps[0]}.{steps[2]}"):
        return without  # an option of the file's own law, which is a key of the block
    for candidate, numeral in known.items():
        parts = candidate.split(".")
        ours = parts[-1:] if len(steps) == 1 else parts
        if numeral is None or len(ours) != len(steps):
            continue
        if all(a == b or near(a, [b]) for a, b in zip(steps, ours, strict=True)):
            same = sum(a == b for a, b in zip(steps, ours, strict=True))
            rank = (same, numeral.there, -len(parts))
            if found is None or rank > best:
                best, found = rank, candidate
    return found


def _excluded(block: str, name: str, numeral: Numeral, beside: set[str]) -> str | None:
    """Say which key of its block keeps a key from being set."""
    model, given = numeral.model, numeral.given
    if model is None:
        return None
    for group in model.exclusive():
        others = [other for other in group if name in group and other != name]
        if other := next((other for other in others if other in given), ""):
            instead = f"sweep {block}.{other}, or give {name} in its place"
            return f"{block}.{name} has no use here: {block} has {other}; {instead}"
        if other := next((other for other in others if other in beside), ""):
            return f"sweep {block}.{name} or {block}.{other}, not both"
    beside_which = model.needs.get(name)
    if beside_which and beside_which not in given:
        which = f"{block}.{beside_which}, which is not given"
        return f"{block}.{name} has a meaning only beside {which}"
    needed = [k for k, field in keys_of(model).items() if field.is_required() and k != name]
    if needed and not numeral.there:
        return f"{block}.{name} needs its block: give {block} with {' and '.join(needed)}"
    return None


def _windowed(words: Mapping[str, Any]) -> bool:
    """Whether the metrics are taken over a window, not over the periodic orbit."""
    measure, kind = block_in(words, "measure"), block_in(words, "excitation").get("kind")
    return kind not in STEADY or bool({"settle", "duration"} & measure.keys())
