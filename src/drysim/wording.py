"""Words for what every output tells: numbers, base motion, cases of a sweep, seeds, the scene.

Each function gives a text on one line: four digits, units as people write them, and other
people's words with all that could drive a terminal spelled out. What varies from case to case
is left out of what all cases share.
"""

from __future__ import annotations

import re
from cmath import rect
from collections.abc import Collection, Iterator, Mapping, Sequence
from math import floor, log10, pi, sqrt
from typing import NamedTuple, Protocol

from drysim.core.model import (
    AnyLaw,
    Dynamic,
    Law,
    Plant,
    Pressed,
    Pressure,
    Samples,
    Sines,
    Slider,
    Stopped,
    moments,
    sample_squares,
)

SIGNIFICANT = 4
"""Digits that an engineer reads; the files hold them all."""

UNKNOWN = "not known"


def number(value: float | None, unit: str = "", digits: int = SIGNIFICANT) -> str:
    """Give a number as people write it: few digits, no needless zeros, the unit behind.

    Parameters
    ----------
    value : float or None
        None reads `not known`.
    unit : str, optional
        Unit of the value; empty or a dash for none.
    digits : int, optional
        Significant digits.

    Returns
    -------
    str
        E.g. `17.26 mm`, `7500 N/m`, `2.1e-15`.
    """
    if value is None:
        return UNKNOWN
    value += 0.0  # -0.0 is 0 to people
    size = floor(log10(abs(value))) if value and abs(value) < float("inf") else 0
    if -4 <= size < 6:
        text = f"{value:.{max(0, digits - 1 - size)}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
    else:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        text = f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"
    return f"{text} {unit}" if unit not in ("", "-", "–") else text


class LengthUnit(NamedTuple):
    """A unit of length: how many of it a metre has, and its sign."""

    per_metre: float
    sign: str


FARTHER = 1e3
"""Times a length that another must exceed to be told in a unit of its own."""


def length_unit(size: float, beside: float = 0.0) -> LengthUnit:
    """Return the unit in which a length [m] reads well: mm, or m and µm far from it.

    Lengths of one output share the unit of the one that they stand beside, unless they are
    more than 1000 times as long.
    """
    size = beside if abs(size) <= FARTHER * abs(beside) else size
    if abs(size) >= 10.0:
        return LengthUnit(1.0, "m")
    return LengthUnit(1e6, "µm") if 0.0 < abs(size) < 1e-5 else LengthUnit(1e3, "mm")


def told_in(unit: str, size: float, beside: float = 0.0) -> tuple[float, str]:
    """Return the factor and the unit by which SI values of a size are told.

    Lengths `m` as `length_unit` has it, shares `%` as a hundredth, all else as it is.
    """
    if unit == "m":
        return length_unit(size, beside)
    return (100.0 if unit == "%" else 1.0), unit


def length(value: float | None, beside: float | None = None) -> str:
    """Return a length [m], e.g. `17.26 mm`; `beside` is explained in `length_unit`."""
    unit = length_unit(value or 0.0, beside or 0.0)
    return number(None if value is None else value * unit.per_metre, unit.sign)


def percent(share: float | None) -> str:
    """Give a share [-] in percent; what is neither 0 nor 1 is never rounded to look so."""
    if share is None:
        return UNKNOWN
    if 0 < share < 0.001 or 0.999 < share < 1:
        return "below 0.1 %" if share < 0.5 else "above 99.9 %"
    return number(share * 100, "%", 3)


def several(count: int, thing: str) -> str:
    """Give how many things there are, e.g. `1 case` or `3 cases`."""
    return f"{count} {thing}{'s' * (count != 1)}"


def times(count: float | None) -> str:
    """Give how often something happened, e.g. `once` or `3 times`."""
    return "once" if count == 1 else f"{count} times"


def listed(words: Sequence[str], last: str = "and") -> str:
    """Give words as a list in a sentence, e.g. `a, b and c`; `last` stands before the last."""
    *most, end = words
    return f"{', '.join(most)} {last} {end}" if most else end


def clean(text: str) -> str:
    """Give a user's text on one line, with all that could drive a terminal spelled out."""
    return "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape").decode()
        for sign in " ".join(text.split())
    )


def pretty(unit: str) -> str:
    """Give the unit of a table as people write it; nothing for a plain number."""
    signs = {"2": "²", "3": "³"}
    unit = re.sub(r"(?<=[a-z)])[23]", lambda digit: signs[digit[0]], unit)
    return "" if unit == "-" else unit.replace("*", "·")


# How the base moves.


MUCH = 0.1
"""A mean above this share of the RMS about it changes the RMS by more than half a hundredth."""


class Base(Protocol):
    """An excitation: its kind on the shelf, and the base motion that it gives."""

    @property
    def kind(self) -> str:
        """Kind on the shelf."""

    @property
    def periodic(self) -> bool:
        """Whether it is made of sines."""

    @property
    def own_end(self) -> bool:
        """Whether it has a length of its own."""

    def motion(self) -> Sines | Samples:
        """Give the base motion."""

    def told(self, varied: Collection[str] = ()) -> str:
        """Give what it is by its keys, without those that vary."""


def excitation(base: Base, motion: Sines | Samples, level: bool = True) -> str:
    """Give the base motion: its kind on the shelf, what it is, and what it amounts to.

    Without `level` the RMS of a record is left out.
    """
    kind = f"{base.kind} {base.told()}".strip()
    if isinstance(motion, Samples):
        length = (len(motion.u_dd) - 1) * motion.dt
        scale = _times(motion.realised.get("scale", 1.0))
        files = "".join(f" {clean(source.file)}{scale}" for source in motion.inputs)
        grid = f"{len(motion.u_dd)} samples at {number(1 / motion.dt, 'Hz')}"
        told = (_level(motion) if level and motion.inputs else "") + _realised(motion)
        return f"{kind}{files}, {grid}, {number(length, 's')}{told}"
    if not motion.A:
        return f"{kind}, the base stands still"
    count = f", {len(motion.A)} components," if len(motion.A) > 1 else ""
    return f"{kind}{count} {_band(motion)}, {number(_rms(motion), 'm/s² RMS')}"


def excitations(base: Base, swept: Collection[str]) -> str:
    """Give what the base motions of a sweep have in common, where a key of theirs is swept."""
    keys = [key.removeprefix("excitation.") for key in swept if key.startswith("excitation.")]
    varied = {key.rpartition(".")[2] for key in keys}
    words = f"{base.kind} {base.told(keys)}".strip()
    if hasattr(base, "named"):
        scale = 1.0 if "scale" in varied else getattr(base, "scale", 1.0)
        words += f" {clean(base.named)}{_times(scale)}"
    if not base.periodic:
        return words + "".join(f", {each}" for each in _asked(base, varied))
    motion = base.motion()
    assert isinstance(motion, Sines), "what has frequencies is made of sines"
    band = f" {_band(motion)}" if motion.A and "frequency" not in varied else ""
    level = motion.A and not varied & {"rms", "amplitude", "phase"}
    return words + band + (f", {number(_rms(motion), 'm/s² RMS')}" if level else "")


def _asked(base: Base, varied: Collection[str]) -> Iterator[str]:
    """Give length and level that are asked of a generated motion, and not swept."""
    if base.own_end and hasattr(base, "duration") and "duration" not in varied:
        yield number(base.duration, "s")
    for key, words in (("rms", "m/s² RMS"), ("amplitude", "m/s² amplitude")):
        level = getattr(base, key, None) if base.own_end else None
        if level is not None and key not in varied:
            yield number(level, words)


def clean_up(motion: Sines | Samples | None, law: AnyLaw | None = None) -> list[str]:
    """Give what was done to a record, and to that of a normal force, step by step."""
    steps = motion.realised.get("clean_up", ()) if isinstance(motion, Samples) else ()
    assert isinstance(steps, list | tuple)
    told = [clean(step["sentence"]) for step in steps]
    pressure = law.pressure if isinstance(law, Pressed) else None
    force = pressure.clean_up if pressure else ()
    return told + [f"normal force: {clean(str(step['sentence']))}" for step in force]


def _times(scale: object) -> str:
    """Give the factor on every sample of a record, if it has one."""
    assert isinstance(scale, float), "a factor is a number"
    return "" if scale == 1.0 else f" times {number(scale)}"


def _level(motion: Samples) -> str:
    """Return the RMS of a record, with its mean where that shows in the RMS."""
    end = (len(motion.u_dd) - 1) * motion.dt
    square = sample_squares(motion._replace(u=None), 0.0, end)[0] / end
    mean = moments(motion.u_dd)[0]
    about = sqrt(max(0.0, square - mean**2))
    level = f", {number(sqrt(square), 'm/s² RMS')}, linear between samples"
    if abs(mean) <= MUCH * about:
        return level
    return f"{level}; mean {number(mean, 'm/s²')}, {number(about, 'm/s² RMS')} about it"


def _realised(motion: Samples) -> str:
    """Give what came out of a generated signal beside what was asked for."""
    words = []
    for name, unit in (("rms", "m/s² RMS"), ("velocity_change", "m/s velocity change")):
        found, asked = motion.realised.get(name), motion.realised.get(f"{name}_asked")
        if isinstance(found, float) and isinstance(asked, float):
            words.append(f"{number(found, unit)} (asked for: {number(asked)})")
    error = motion.realised.get("psd_error")
    if isinstance(error, float):
        words.append(f"PSD within {percent(error)} of its peak")
    return "".join(f", {word}" for word in words)


def _band(motion: Sines) -> str:
    """Give the frequency of sines, or what their frequencies lie between."""
    low, high = min(motion.f), max(motion.f)
    return number(low, "Hz") if low == high else f"{number(low)} to {number(high, 'Hz')}"


def _rms(motion: Sines) -> float:
    """Give the RMS of a sum of sines; those of one frequency add up by their phases."""
    sums: dict[float, complex] = {}
    for A, f, phase in zip(*motion, strict=True):
        sums[f] = sums.get(f, 0.0) + rect(A, phase)
    return sqrt(sum(abs(amplitude) ** 2 for amplitude in sums.values()) / 2)


# The cases of a sweep: what is swept, and where one of them is.


FEW = 5
"""Values of a swept key up to which each is named."""

MANY = 10_000
"""Values of a swept key beyond which they can only be evenly spread, in order."""


class Swept(Protocol):
    """A swept key with its unit and values."""

    @property
    def key(self) -> str:
        """Dotted key of the scenario."""

    @property
    def unit(self) -> str:
        """SI unit as in the header of a table."""

    @property
    def values(self) -> Sequence[float]:
        """Values in the unit."""

    @property
    def told(self) -> str:
        """The values in words, where their range does not tell them."""


def swept(axis: Swept) -> str:
    """Give what is swept, e.g. `excitation.frequency 0.5 to 10 Hz (96 values)`."""
    if axis.told:
        return f"{axis.key} {axis.told}"
    unit, values = pretty(axis.unit), axis.values
    if len(values) <= FEW:
        *most, last = apart(values)
        return f"{axis.key} {', '.join([*most, f'{last} {unit}'.rstrip()])}"
    ends = (values[0], values[-1]) if len(values) > MANY else (min(values), max(values))
    low, high = number(ends[0]), number(ends[1], unit)
    return f"{axis.key} {low} to {high} ({len(values)} values)"


def apart(values: Sequence[float]) -> list[str]:
    """Return values in words, with as many digits as it takes to tell them apart."""
    for digits in range(SIGNIFICANT, 18):
        words = [number(value, digits=digits) for value in values]
        if len({*words}) == len({*values}):
            break
    return words


def place(point: Mapping[str, float], axes: Sequence[Swept]) -> str:
    """Give where a case is, e.g. `frequency 1.6 Hz, rms 0.5 m/s²`."""
    return located(point, {axis.key: axis.unit for axis in axes})


def located(point: Mapping[str, float], units: Mapping[str, str]) -> str:
    """Give where a case is by the unit of every swept key."""
    return ", ".join(
        f"{short(key, units)} {number(value, pretty(units.get(key, '')))}"
        for key, value in point.items()
    )


def places(points: Sequence[Mapping[str, float]], axes: Sequence[Swept]) -> str:
    """Give where a few cases are, e.g. `frequency 0.5, 7 Hz`; of several keys one by one."""
    if len(points[0]) > 1:
        return "; ".join(place(point, axes) for point in points)
    units = {axis.key: pretty(axis.unit) for axis in axes}
    *values, last = sorted(value for point in points for value in point.values())
    (key,) = points[0]
    spelled = [*map(number, values), number(last, units.get(key, ""))]
    return f"{short(key, units)} {', '.join(spelled)}"


def stretch(ends: Mapping[str, tuple[float, float]], axes: Sequence[Swept]) -> str:
    """Give between what some cases lie, e.g. `frequency 0.5 to 8 Hz, rms 0.5 to 1 m/s²`."""
    units = {axis.key: pretty(axis.unit) for axis in axes}
    return ", ".join(
        f"{short(key, units)} {f'{number(low)} to ' * (low < high)}"
        f"{number(high, units.get(key, ''))}"
        for key, (low, high) in ends.items()
    )


def short(key: str, keys: Collection[str]) -> str:
    """Give the last word of a swept key, as long as no other ends in it."""
    last = key.rpartition(".")[2]
    return key if sum(other.rpartition(".")[2] == last for other in keys) > 1 else last


# Means over many seeds: a value with its interval, and which seeds there were.


FINEST = 1e-6
"""Half-width over value from which on an interval is told [-]; a narrower one is rounding."""


class Wish(Protocol):
    """When seeds are to be enough."""

    @property
    def metric(self) -> str:
        """Name of the metric."""

    @property
    def half_width(self) -> float:
        """Half-width of its interval over its mean [-]."""


def around(value: float | None, half_width: float | None, unit: str = "") -> str:
    """Give a mean with half of its confidence interval, e.g. `0.8376 ± 0.0014`.

    Both end at the second digit of the half-width, beyond which the mean says nothing.
    """
    if value is None or not half_width or half_width < FINEST * abs(value):
        return number(value, unit)
    places = 1 - floor(log10(half_width))
    if places < 0 or max(abs(value), half_width) < 1e-3 or half_width >= 1e6:
        return f"{number(value)} ± {number(half_width, unit, 2)}"
    words = f"{value + 0.0:.{places}f} ± {half_width:.{places}f}"
    return f"{words} {unit}" if unit else words


def seeds(drawn: Sequence[int], until: Wish | None, counts: Sequence[int] = ()) -> str:
    """Give which seeds there were, and what the values behind a ± are.

    `counts` are the numbers of seeds of many cases, ascending.
    """
    number_of = f"{counts[0]} to {counts[-1]}" if len(counts) > 1 else str(len(drawn))
    span = f"{number_of}{' in every case' * bool(counts)}, from {drawn[0]} to {drawn[-1]}"
    wish = ""
    if until is not None:
        share = number(100 * until.half_width, "%")
        wish = f"until the interval of {until.metric} is ±{share} of its mean; "
    return f"{span}; {wish}values are means, ± half of their 95 % confidence interval"


# What is solved: the oscillator, its dry friction, its end stops.


EVERY = {"kinetic": True, "static": True}
"""Friction forces that all cases share, where there is one case."""

NONE: Mapping[str, float] = {}
"""The ratios of a scene that is given by forces and damping alone."""


def scene(
    plant: Plant,
    law: AnyLaw,
    defaulted: bool = False,
    terms: Sequence[str] = (),
    swept: Collection[str] = (),
    shared: Mapping[str, bool] = EVERY,
    ratios: Mapping[str, float] = NONE,
    peak: float | None = None,
) -> Iterator[tuple[str, str]]:
    """Give what is solved, head by head: oscillator, friction, end stops where there are any.

    `shared` says whether all cases have one `kinetic` and one `static` friction force; the
    other parameters are those of `oscillator` and `friction`. What varies is left out. The
    greatest |x_r| [m], where it is known, gives the unit of end stops.
    """
    forces = friction(law, defaulted, **shared, terms=terms, swept=swept, ratios=ratios)
    heads = (
        ("oscillator", oscillator(plant, swept, ratios)),
        ("friction", forces),
        ("end stops", stops(law, swept, peak)),
    )
    return ((head, words) for head, words in heads if words)


def oscillator(
    plant: Plant, swept: Collection[str] = (), ratios: Mapping[str, float] = NONE
) -> str:
    """Give mass, spring and damper, with what follows from them.

    Parameters
    ----------
    plant : Plant
    swept : collection of str, optional
        Keys that vary from case to case; what they decide is left out.
    ratios : mapping, optional
        What the scenario gives as a ratio, `damping_ratio` and `static_ratio`: it stays where
        what it refers to varies.
    """
    varied = [key for key in swept if key.startswith("oscillator.")]
    m, k_x = "oscillator.mass" not in varied, "oscillator.stiffness" not in varied
    damped = not any("damping" in key for key in varied)
    by_ratio = "damping_ratio" in ratios
    parts = [f"m {number(plant.m, 'kg')}"] * m + [f"k_x {number(plant.k_x, 'N/m')}"] * k_x
    if damped and (not varied or not by_ratio):
        parts.append(f"b {number(plant.b, 'N·s/m')}")
    if plant.k_x > 0 and m and k_x:
        parts.append(f"f_0 {number(sqrt(plant.k_x / plant.m) / (2 * pi), 'Hz')}")
    if plant.k_x > 0 and damped and (not varied or by_ratio):
        xi = plant.b / (2 * sqrt(plant.m * plant.k_x))
        parts.append(f"ξ {number(xi, digits=3)}")
    return ", ".join(parts)


def friction(
    law: AnyLaw,
    defaulted: bool = False,
    kinetic: bool = True,
    static: bool = True,
    terms: Sequence[str] = (),
    swept: Collection[str] = (),
    ratios: Mapping[str, float] = NONE,
) -> str:
    """Give the dry friction.

    Parameters
    ----------
    law : AnyLaw
    defaulted : bool, optional
        Nobody named a static limit.
    kinetic, static : bool, optional
        Whether all cases share the force; one that they do not share is left out.
    terms : sequence of str, optional
        The name of a law other than Coulomb's, and what it has besides its forces.
    swept : collection of str, optional
        As in `oscillator`: how the normal force varies is left out where they decide it.
    ratios : mapping, optional
        As in `oscillator`.
    """
    if law.F_fs == 0 and kinetic and static:
        return "no dry friction"
    limit = static and (not terms or law.F_fs > law.F_fk)
    parts = [f"F_fk {number(law.F_fk, 'N')}"] * kinetic
    parts += [f"F_fs {number(law.F_fs, 'N')}"] * limit
    if not static and "static_ratio" in ratios and "friction.static_ratio" not in swept:
        parts.append(f"F_fs/F_fk {number(ratios['static_ratio'])}")
    text = ", ".join([*terms[:1], *parts])
    if defaulted:
        text += " (not given: F_fs = F_fk)" if text else "F_fs = F_fk (not given)"
    text = ", ".join(filter(None, (text, *terms[1:])))
    varied = {key.rpartition(".")[2] for key in swept if key.startswith("friction.normal_")}
    if not isinstance(law, Dynamic) and law.variation and kinetic and static:
        text += _variation(law, varied)
    if isinstance(law, Pressed) and law.pressure is not None:
        text += f", {_pressure(law.pressure, bool(varied))}"
    return text


def _variation(law: Law | Stopped | Pressed | Slider, varied: Collection[str]) -> str:
    """Give how the normal force varies as a sine, as far as all cases share it."""
    parts = []
    if not {"amplitude", "normal_stiffness"} & {*varied}:
        parts.append(f"± {percent(law.variation)}")
    if "frequency" not in varied:
        parts.append(f"at {number(law.omega / (2 * pi), 'Hz')}")
    whose = "load" if isinstance(law, Slider) else "both"
    return f", {whose} {'varying ' * (parts[0][0] == 'a')}{' '.join(parts)}" if parts else ""


def stops(law: AnyLaw, swept: Collection[str] = (), peak: float | None = None) -> str:
    """Return the end stops, empty where there are none; `swept` as in `oscillator`."""
    if not isinstance(law, Stopped):
        return ""
    parts = [("limit", f"at ±{length(law.x_rM, peak)}")]
    if law.rigid:
        parts += [("stops", "rigid"), ("restitution", f"restitution {number(law.e)}")]
    else:
        parts += [("stiffness", number(law.k_s, "N/m")), ("damping", number(law.b_s, "N·s/m"))]
    varied = {key.rpartition(".")[2] for key in swept if key.startswith("stroke.")}
    return ", ".join(words for key, words in parts if key not in varied)


def _pressure(pressure: Pressure, varied: bool) -> str:
    """Give a recorded normal force: what it lies between, if all cases share it; its file."""
    files = ", ".join(clean(source.file) for source in pressure.inputs)
    if varied:
        return f"F_N recorded ({files})"
    ends = float(pressure.relative.min()), float(pressure.relative.max())
    low, high = (number(pressure.mean * share, digits=3) for share in ends)
    return f"F_N {low} to {high} N ({files})"
