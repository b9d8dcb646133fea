"""Text shared by all outputs: numbers, cleaning of records, swept cases, seeds, the model.

Each function returns text on one line. Numbers have four significant digits, units are written
as in print (`m/s²`, `N·s/m`), and unprintable characters of foreign text are escaped. Text that
describes all cases of a sweep omits what varies from case to case.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from math import floor, log10, pi, sqrt
from typing import Any, NamedTuple, Protocol

from drysim.core.model import (
    AnyLaw,
    CoulombLaw,
    DynamicLaw,
    NormalForceRecord,
    PiecewiseLaw,
    Plant,
    RecordSummary,
    Samples,
    Sines,
    StrokeLimits,
    has_friction,
)

SIGNIFICANT_DIGITS = 4
"""Significant digits in text; the output files contain all digits."""

UNKNOWN = "not known"

Point = Mapping[str, Any]
"""Swept keys of a case with their values: numbers in SI, text for files."""


def format_number(
    value: float | str | None, unit: str = "", digits: int = SIGNIFICANT_DIGITS
) -> str:
    """Return a number with few digits, without trailing zeros, followed by its unit.

    Parameters
    ----------
    value : float or str or None
        None yields `not known`; of text, such as a swept file, control characters are
        escaped.
    unit : str, optional
        Unit of the value; empty or a dash for none.
    digits : int, optional
        Significant digits.

    Returns
    -------
    str
        E.g. `17.26 mm`, `7500 N/m`, `2.1e-15`.
    """
    if isinstance(value, str):
        return sanitise(value)
    if value is None:
        return UNKNOWN
    value += 0.0  # -0.0 is printed as 0
    size = floor(log10(abs(value))) if value and abs(value) < float("inf") else 0
    if -4 <= size < 6:
        text = f"{value:.{max(0, digits - 1 - size)}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
    else:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        text = f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"
    return with_unit(text, unit)


def format_range(
    low: float | str | None,
    high: float | str | None,
    unit: str = "",
    digits: int = SIGNIFICANT_DIGITS,
) -> str:
    """Return a range or interval; one value if both ends read the same.

    Parameters
    ----------
    low, high : float or str or None
        Ends, as numbers or as text; None for an end that is not known.
    unit : str, optional
        Unit of both, as in `format_number`.
    digits : int, optional
        Significant digits of numbers.

    Returns
    -------
    str
        E.g. `1 to 2 Hz`, `at least 1 Hz`, `at most 2 Hz`.
    """
    first, last = (format_number(end, digits=digits) for end in (low, high))
    if low is None and high is None:
        return UNKNOWN
    if high is None:
        words = f"at least {first}"
    elif low is None:
        words = f"at most {last}"
    else:
        words = first if first == last else f"{first} to {last}"
    return with_unit(words, unit)


def with_unit(words: str, unit: str) -> str:
    """Return text followed by a unit; empty or a dash for none."""
    return f"{words} {unit}" if unit not in ("", "-", "–") else words


def format_deviation(deviation: float, half_width: float | None = None, digits: int = 3) -> str:
    """Return a relative deviation [-] in percent with its sign, of a mean with its interval.

    Returns
    -------
    str
        E.g. `+84 %`, `-1.20 ± 0.35 %`.
    """
    sign = "+" if deviation >= 0 else ""
    if half_width:
        return sign + format_interval(100 * deviation, 100 * half_width, "%")
    return sign + format_number(100 * deviation, "%", digits)


class LengthUnit(NamedTuple):
    """A unit of length: units per metre, and symbol."""

    units_per_metre: float
    symbol: str


UNIT_CHANGE_RATIO = 1e3
"""Ratio of two lengths above which each has a unit of its own."""


def length_unit(size: float, reference: float = 0.0) -> LengthUnit:
    """Return the unit in which a length is readable: mm, or m or µm for extreme lengths.

    Parameters
    ----------
    size : float
        The length [m].
    reference : float, optional
        A length [m] in the same output. Its unit is used unless `size` is more than
        `UNIT_CHANGE_RATIO` times as long.
    """
    size = reference if abs(size) <= UNIT_CHANGE_RATIO * abs(reference) else size
    if abs(size) >= 10.0:
        return LengthUnit(1.0, "m")
    return LengthUnit(1e6, "µm") if 0.0 < abs(size) < 1e-5 else LengthUnit(1e3, "mm")


def display_unit(unit: str, size: float, reference: float = 0.0) -> tuple[float, str]:
    """Return the factor from SI and the unit in which a value is shown.

    Lengths are shown as in `length_unit`, shares in percent, all else in SI.
    """
    if unit == "m":
        return length_unit(size, reference)
    return (100.0 if unit == "%" else 1.0), unit


def format_length(value: float | None, reference: float | None = None) -> str:
    """Return a length [m], e.g. `17.26 mm`; `reference` as in `length_unit`."""
    unit = length_unit(value or 0.0, reference or 0.0)
    return format_number(None if value is None else value * unit.units_per_metre, unit.symbol)


def format_percent(share: float | None) -> str:
    """Return a share [-] in percent; only 0 and 1 are shown as 0 % and 100 %."""
    if share is None:
        return UNKNOWN
    if 0 < share < 0.001 or 0.999 < share < 1:
        return "below 0.1 %" if share < 0.5 else "above 99.9 %"
    return format_number(share * 100, "%", 3)


def format_count(count: int, thing: str) -> str:
    """Return a count with its noun, e.g. `1 case` or `3 cases`."""
    plural = "es" if thing.endswith("ch") else "s"
    return f"{count} {thing}{plural * (count != 1)}"


def format_times(count: float | None) -> str:
    """Return a number of repetitions, e.g. `once` or `3 times`."""
    return "once" if count == 1 else f"{count} times"


def format_times_by_side(
    metrics: Mapping[str, float | None], name: str, limits: StrokeLimits
) -> str:
    """Return how often something happened; on either side where the limits differ."""
    times = format_times(metrics[name])
    if limits.up == limits.down:
        return times
    return f"{times} ({metrics[f'{name}_up']} up, {metrics[f'{name}_down']} down)"


def join_words(words: Sequence[str], last: str = "and") -> str:
    """Join words to a list in a sentence, e.g. `a, b and c`; `last` precedes the last word."""
    *most, end = words
    return f"{', '.join(most)} {last} {end}" if most else end


def sanitise(text: str) -> str:
    """Return foreign text on one line, with control characters and escape sequences escaped."""
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode()
        for character in " ".join(text.split())
    )


def format_unit(unit: str) -> str:
    """Return a unit as in print, e.g. `m/s²` for `m/s2`; empty for a plain number."""
    superscripts = {"2": "²", "3": "³"}
    unit = re.sub(r"(?<=[a-z)])[23]", lambda digit: superscripts[digit[0]], unit)
    return "" if unit == "-" else unit.replace("*", "·")


SUBSCRIPTS = str.maketrans("012ehkmnoprstuvxa", "₀₁₂ₑₕₖₘₙₒₚᵣₛₜᵤᵥₓₐ")
"""The letters and digits of indices that are characters of their own; f and w are not."""


def typeset(text: str) -> str:
    """Lower the indices of T_a, x_r and the like; those of F_fk and a_w stay as they are.

    x_r_min is no symbol.
    """
    return re.sub(
        r"\b([A-Za-zσ])_([012aehkmnoprstuvx]+)\b",
        lambda symbol: symbol[1] + symbol[2].translate(SUBSCRIPTS),
        text,
    )


# Cleaning of records.


def describe_clean_up(
    motion: Sines | Samples | None,
    law: AnyLaw | None = None,
    records: Sequence[RecordSummary] = (),
) -> list[str]:
    """Return the processing steps of a record, and of a recorded normal force.

    Of several records, each step is that of the first record that has it.
    """
    steps = motion.realised.get("clean_up", ()) if isinstance(motion, Samples) else ()
    assert isinstance(steps, list | tuple)
    description = [sanitise(step["sentence"]) for step in steps]
    if records:
        named: dict[object, list[str]] = {}
        for record in records:
            for step in record.clean_up:
                words = f"{record.file}: {step['sentence']}"
                named.setdefault(step["step"], []).append(sanitise(words))
        description = [
            words[0]
            + f"; {format_count(len(words) - 1, 'more record')} likewise" * (len(words) > 1)
            for words in named.values()
        ]
    force_record = None if law is None else law.force_record
    force = force_record.clean_up if force_record else ()
    return description + [f"normal force: {sanitise(str(step['sentence']))}" for step in force]


# Sweeps: axes and cases.


MAX_LISTED_VALUES = 5
"""Number of values of a swept key up to which each is listed."""

MAX_SCANNED_VALUES = 10_000
"""More values than this come from an ordered range, so that first and last are the extremes."""


class AxisLike(Protocol):
    """A swept key with unit and values."""

    @property
    def key(self) -> str:
        """Dotted key of the scenario."""

    @property
    def unit(self) -> str:
        """SI unit as in the header of a table."""

    @property
    def values(self) -> Sequence[Any]:
        """Values [unit]."""

    @property
    def description(self) -> str:
        """Description of the values; empty where their range describes them."""


def describe_axis(axis: AxisLike) -> str:
    """Return a swept key and its values, e.g. `excitation.rms 0.5 to 1 m/s² (6 values)`."""
    if axis.description:
        return f"{axis.key} {axis.description}"
    unit, values = format_unit(axis.unit), axis.values
    if len(values) <= MAX_LISTED_VALUES:
        *most, last = format_distinct(values)
        return f"{axis.key} {', '.join([*most, f'{last} {unit}'.rstrip()])}"
    ends = (
        (values[0], values[-1])
        if len(values) > MAX_SCANNED_VALUES
        else (min(values), max(values))
    )
    return f"{axis.key} {format_range(*ends, unit)} ({len(values)} values)"


def format_distinct(values: Sequence[float]) -> list[str]:
    """Return values as text, with as many digits as needed to distinguish them."""
    for digits in range(SIGNIFICANT_DIGITS, 18):
        words = [format_number(value, digits=digits) for value in values]
        if len({*words}) == len({*values}):
            break
    return words


def describe_case(point: Point, axes: Sequence[AxisLike]) -> str:
    """Return the swept values of a case, e.g. `frequency 1.6 Hz, rms 0.5 m/s²`."""
    return describe_point(point, {axis.key: axis.unit for axis in axes})


def describe_point(point: Point, units: Mapping[str, str]) -> str:
    """Return the values of a point, with the units by swept key."""
    return ", ".join(
        f"{short_key(key, units)} {format_number(value, format_unit(units.get(key, '')))}"
        for key, value in point.items()
    )


def describe_cases(points: Sequence[Point], axes: Sequence[AxisLike]) -> str:
    """Return the swept values of a few cases, e.g. `frequency 0.5, 7 Hz`."""
    if len(points[0]) > 1:
        return "; ".join(describe_case(point, axes) for point in points)
    units = {axis.key: format_unit(axis.unit) for axis in axes}
    *values, last = sorted(value for point in points for value in point.values())
    (key,) = points[0]
    texts = [*map(format_number, values), format_number(last, units.get(key, ""))]
    return f"{short_key(key, units)} {', '.join(texts)}"


def describe_range(ends: Mapping[str, tuple[float, float]], axes: Sequence[AxisLike]) -> str:
    """Return the range of some cases, e.g. `frequency 0.5 to 8 Hz, rms 0.5 to 1 m/s²`."""
    units = {axis.key: format_unit(axis.unit) for axis in axes}
    return ", ".join(
        f"{short_key(key, units)} {format_range(low, high, units.get(key, ''))}"
        for key, (low, high) in ends.items()
    )


def short_key(key: str, keys: Collection[str]) -> str:
    """Return the last word of a dotted key, or the whole key if that word is not unique."""
    last = key.rpartition(".")[2]
    return key if sum(other.rpartition(".")[2] == last for other in keys) > 1 else last


# Ensembles: means with confidence intervals, and seeds.


MIN_RELATIVE_HALF_WIDTH = 1e-6
"""Relative half-width [-] below which an interval is rounding and not shown."""


class StoppingRule(Protocol):
    """The stopping rule for the number of seeds."""

    @property
    def metric(self) -> str:
        """Name of the metric."""

    @property
    def half_width(self) -> float:
        """Half-width of the confidence interval relative to the mean [-]."""


def format_interval(value: float | None, half_width: float | None, unit: str = "") -> str:
    """Return a mean with the half-width of its confidence interval, e.g. `0.8376 ± 0.0014`.

    Both end at the second significant digit of the half-width.
    """
    if value is None or not half_width or half_width < MIN_RELATIVE_HALF_WIDTH * abs(value):
        return format_number(value, unit)
    places = 1 - floor(log10(half_width))
    if places < 0 or max(abs(value), half_width) < 1e-3 or half_width >= 1e6:
        return f"{format_number(value)} ± {format_number(half_width, unit, 2)}"
    words = f"{value + 0.0:.{places}f} ± {half_width:.{places}f}"
    return f"{words} {unit}" if unit else words


def describe_seeds(
    drawn: Sequence[int], until: StoppingRule | None, counts: Sequence[int] = ()
) -> str:
    """Return the seeds that were drawn and the meaning of values with ±.

    `counts` are the numbers of seeds of the cases of a sweep, ascending.
    """
    number_of = f"{counts[0]} to {counts[-1]}" if len(counts) > 1 else str(len(drawn))
    span = f"{number_of}{' in every case' * bool(counts)}, from {drawn[0]} to {drawn[-1]}"
    rule = ""
    if until is not None:
        share = format_number(100 * until.half_width, "%")
        rule = f"until the interval of {until.metric} is ±{share} of its mean; "
    return f"{span}; {rule}values are mean ± half-width of the 95 % confidence interval"


# The model: oscillator, friction, end stops.


ALL_SHARED = {"kinetic": True, "static": True}
"""All cases share both friction forces: the default for a single case."""

STATIC_KEYS = ("friction.static", "friction.mu_static")
"""How the keys of the static limit begin."""

NO_RATIOS: Mapping[str, float] = {}
"""A scenario that defines forces and damping directly."""


class SceneLike(Protocol):
    """A scenario as seen by this module."""

    @property
    def terms(self) -> tuple[str, ...]:
        """Name of a law other than Coulomb, and its parameters that are not swept."""

    @property
    def ratios(self) -> dict[str, float]:
        """Parameters relative to others, by key."""

    @property
    def static_given(self) -> bool:
        """Whether the static limit is given."""


def describe_scene(
    scenario: SceneLike,
    plant: Plant,
    law: AnyLaw,
    swept: Collection[str] = (),
    shared: Mapping[str, bool] = ALL_SHARED,
    peak: float | None = None,
    defaults: bool = True,
) -> Iterator[tuple[str, str]]:
    """Yield label and text of the oscillator, the friction and the end stops, if any.

    Parameters
    ----------
    scenario : SceneLike
    plant, swept
        As in `describe_oscillator`.
    law : AnyLaw
        Law that was solved; approaches without dry friction leave it out.
    shared : mapping, optional
        Whether all cases have the same `kinetic` and the same `static` friction force.
    peak : float, optional
        Greatest |x_r| [m], which determines the unit of end stops.
    defaults : bool, optional
        Whether to say that the static limit is not given.
    """
    ratios = scenario.ratios
    static_swept = any(key.startswith(STATIC_KEYS) for key in swept)
    defaulted = defaults and not scenario.static_given and not static_swept
    forces = describe_friction(
        law, defaulted, **shared, terms=scenario.terms, swept=swept, ratios=ratios
    )
    parts = (
        ("oscillator", describe_oscillator(plant, swept, ratios, law.damping)),
        ("friction", forces),
        ("end stops", describe_stops(law, swept, peak)),
    )
    return ((label, words) for label, words in parts if words)


def describe_oscillator(
    plant: Plant,
    swept: Collection[str] = (),
    ratios: Mapping[str, float] = NO_RATIOS,
    damping: tuple[float, float] | None = None,
) -> str:
    """Return mass, stiffness and damping, with natural frequency and damping ratio.

    Parameters
    ----------
    plant : Plant
    swept : collection of str, optional
        Dotted keys that vary; what they determine is omitted.
    ratios : mapping, optional
        Parameters of the scenario relative to others: `natural_frequency`, `damping_ratio` and
        `static_ratio`. Each is included even if the quantity it refers to varies.
    damping : tuple of float, optional
        Damping of extension and compression [N·s/m], where they differ.
    """
    varied = [key for key in swept if key.startswith("oscillator.")]
    m, f_0 = "oscillator.mass" not in varied, "oscillator.natural_frequency" not in varied
    by_frequency = "natural_frequency" in ratios
    k_x = f_0 and "oscillator.stiffness" not in varied and (m or not by_frequency)
    damped = not any("damping" in key for key in varied)
    by_ratio = "damping_ratio" in ratios
    parts = [f"m {format_number(plant.m, 'kg')}"] * m + [
        f"k_x {format_number(plant.k_x, 'N/m')}"
    ] * k_x
    if damped and (not varied or not by_ratio):
        parts.append(f"b {_format_directions((plant.b, plant.b), damping, 'N·s/m')}")
    if plant.k_x > 0 and (f_0 if by_frequency else m and k_x):
        parts.append(f"f_0 {format_number(sqrt(plant.k_x / plant.m) / (2 * pi), 'Hz')}")
    if plant.k_x > 0 and damped and (not varied or by_ratio):
        xi = plant.b / (2 * sqrt(plant.m * plant.k_x))
        parts.append(f"ξ {format_number(xi, digits=3)}")
    return ", ".join(parts)


def _format_directions(
    same: tuple[float, float], pair: tuple[float, float] | None, unit: str
) -> str:
    """Return a value, or those of extension and compression where they differ."""
    extension, compression = pair or same
    if extension == compression:
        return format_number(extension, unit)
    one, other = format_number(extension), format_number(compression, unit)
    return f"{one} in extension, {other} in compression"


def describe_friction(
    law: AnyLaw,
    defaulted: bool = False,
    kinetic: bool = True,
    static: bool = True,
    terms: Sequence[str] = (),
    swept: Collection[str] = (),
    ratios: Mapping[str, float] = NO_RATIOS,
) -> str:
    """Return the friction law with its forces.

    Parameters
    ----------
    law : AnyLaw
    defaulted : bool, optional
        Whether the static limit is the default.
    kinetic, static : bool, optional
        Whether all cases have the same force; otherwise it is omitted.
    terms : sequence of str, optional
        Name of a law other than Coulomb, followed by its further parameters.
    swept : collection of str, optional
        As in `describe_oscillator`.
    ratios : mapping, optional
        As in `describe_oscillator`.
    """
    if not has_friction(law) and kinetic and static:
        return "no dry friction"
    limit = static and (not terms or law.F_fs > law.F_fk)
    F_fk, F_fs = law.compression or (law.F_fk, law.F_fs)
    parts = [f"F_fk {_format_directions((law.F_fk, F_fk), None, 'N')}"] * kinetic
    parts += [f"F_fs {_format_directions((law.F_fs, F_fs), None, 'N')}"] * limit
    if not static and "static_ratio" in ratios and "friction.static_ratio" not in swept:
        parts.append(f"F_fs/F_fk {format_number(ratios['static_ratio'])}")
    text = ", ".join([*terms[:1], *parts])
    if defaulted:
        text += " (not given: F_fs = F_fk)" if text else "F_fs = F_fk (not given)"
    text = ", ".join(filter(None, (text, *terms[1:])))
    varied = {key.rpartition(".")[2] for key in swept if key.startswith("friction.normal_")}
    if not isinstance(law, DynamicLaw) and law.variation and kinetic and static:
        text += _describe_variation(law, varied)
    if law.force_record is not None:
        text += f", {_describe_force_record(law.force_record, bool(varied))}"
    return text


def _describe_variation(law: CoulombLaw | PiecewiseLaw, varied: Collection[str]) -> str:
    """Return the sinusoidal variation of the normal force, as far as it does not vary."""
    parts = []
    if not {"amplitude", "normal_stiffness"} & {*varied}:
        parts.append(f"± {format_percent(law.variation)}")
    if "frequency" not in varied:
        parts.append(f"at {format_number(law.omega / (2 * pi), 'Hz')}")
    whose = "load" if law.is_elastic else "both"
    return f", {whose} {'varying ' * (parts[0][0] == 'a')}{' '.join(parts)}" if parts else ""


def describe_stops(law: AnyLaw, swept: Collection[str] = (), peak: float | None = None) -> str:
    """Return the end stops; empty without any. `swept` as in `describe_oscillator`."""
    if law.stops is None:
        return ""
    stops = law.stops
    up, down = stops.limits
    sides = f"±{format_length(up, peak)}"
    if up != down:
        sides = f"{format_length(-down, peak)} and {format_length(up, peak)}"
    parts = [("limit", f"at {sides}")]
    if stops.rigid:
        parts += [("stops", "rigid"), ("restitution", f"restitution {format_number(stops.e)}")]
    else:
        stiffness, texts = 0.0, []
        for begin, added in stops.stages:
            stiffness += added
            where = f" from {format_length(begin)}" if begin else ""
            texts.append(format_number(stiffness, "N/m") + where)
        parts += [("stiffness", ", ".join(texts))] if len(texts) == 1 or not swept else []
        parts += [("damping", format_number(stops.b_s, "N·s/m"))]
    varied = {
        "limit" if key.startswith(("stroke.limit", "stroke.offset")) else key.rpartition(".")[2]
        for key in swept
        if key.startswith("stroke.")
    }
    return ", ".join(words for key, words in parts if key not in varied)


def describe_limits(limits: StrokeLimits, peak: float | None = None) -> str:
    """Return stroke limits as text, in the unit of a displacement `peak` [m]."""
    up, down = (format_length(limit, peak) for limit in limits)
    return up if limits.up == limits.down else f"{up} up and {down} down"


def _describe_force_record(force_record: NormalForceRecord, varied: bool) -> str:
    """Return range and file of a recorded normal force; only the file if the force varies."""
    files = ", ".join(sanitise(source.file) for source in force_record.inputs)
    if varied:
        return f"F_N recorded ({files})"
    relative, mean = force_record.relative, force_record.mean
    low, high = mean * float(relative.min()), mean * float(relative.max())
    return f"F_N {format_range(low, high, 'N', 3)} ({files})"
