"""Text about a scenario, on one line each: swept cases, seeds, cleaning of records, the model.

Text that describes all cases of a sweep omits what varies from case to case.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import pi, sqrt

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
from drysim.excitation.random import Until
from drysim.scenario.axes import Axis
from drysim.scenario.model import STATIC_PATHS, Scenario
from drysim.wording import (
    Point,
    display_unit,
    format_count,
    format_distinct,
    format_length,
    format_number,
    format_percent,
    format_quantity,
    format_quantity_range,
    format_range,
    format_times,
    format_unit,
    sanitise,
    with_unit,
)

# Sweeps: axes and cases.


MAX_LISTED_VALUES = 5
"""Number of values of a swept key up to which each is listed."""


def describe_axis(axis: Axis) -> str:
    """Return a swept key and its values, e.g. `excitation.rms 0.5 to 1 m/s² (6 values)`."""
    if axis.description:
        return f"{axis.key} {axis.description}"
    values = axis.values
    if len(values) <= MAX_LISTED_VALUES:
        return f"{axis.key} {_list_values(values, axis.unit)}"
    span = format_quantity_range(axis.range.low, axis.range.high, axis.unit)
    return f"{axis.key} {span} ({len(values)} values)"


def _list_values(values: Sequence[float], unit: str) -> str:
    """Return values of a key with their unit, lengths as in `length_unit`."""
    if unit == "m":
        factor, unit = display_unit(unit, max(map(abs, values)))
        values = [factor * value for value in values]
    *most, last = format_distinct(values)
    return ", ".join([*most, with_unit(last, format_unit(unit))])


def describe_case(point: Point, axes: Sequence[Axis]) -> str:
    """Return the swept values of a case, e.g. `frequency 1.6 Hz, rms 0.5 m/s²`."""
    return describe_point(point, {axis.key: axis.unit for axis in axes})


def describe_point(point: Point, units: Mapping[str, str]) -> str:
    """Return the values of a point, with the units by swept key."""
    return ", ".join(
        f"{short_key(key, units)} {format_quantity(value, units.get(key, ''))}"
        for key, value in point.items()
    )


def describe_cases(points: Sequence[Point], axes: Sequence[Axis]) -> str:
    """Return the swept values of a few cases, e.g. `frequency 0.5, 7 Hz`."""
    if len(points[0]) > 1:
        return "; ".join(describe_case(point, axes) for point in points)
    units = {axis.key: axis.unit for axis in axes}
    values = sorted(value for point in points for value in point.values())
    (key,) = points[0]
    return f"{short_key(key, units)} {_list_values(values, units.get(key, ''))}"


def describe_range(ends: Mapping[str, tuple[float, float]], axes: Sequence[Axis]) -> str:
    """Return the range of some cases, e.g. `frequency 0.5 to 8 Hz, rms 0.5 to 1 m/s²`."""
    units = {axis.key: axis.unit for axis in axes}
    return ", ".join(
        f"{short_key(key, units)} {format_quantity_range(low, high, units.get(key, ''))}"
        for key, (low, high) in ends.items()
    )


def short_key(key: str, keys: Collection[str]) -> str:
    """Return the last word of a dotted key, or the whole key if that word is not unique."""
    last = key.rpartition(".")[2]
    return key if sum(other.rpartition(".")[2] == last for other in keys) > 1 else last


# Seeds.


def describe_seeds(
    drawn: Sequence[int], until: Until | None, counts: Sequence[int] = ()
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
                sentence = f"{record.file}: {step['sentence']}"
                named.setdefault(step["step"], []).append(sanitise(sentence))
        description = [
            sentences[0]
            + f"; {format_count(len(sentences) - 1, 'more record')} likewise"
            * (len(sentences) > 1)
            for sentences in named.values()
        ]
    force_record = None if law is None else law.force_record
    force = force_record.clean_up if force_record else ()
    return description + [f"normal force: {sanitise(str(step['sentence']))}" for step in force]


# The model: oscillator, friction, end stops.


ALL_SHARED = {"kinetic": True, "static": True}
"""All cases share both friction forces: the default for a single case."""

NO_RATIOS: Mapping[str, float] = {}
"""A scenario that defines forces and damping directly."""


def describe_scene(
    scenario: Scenario,
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
    static_swept = any(key.startswith(STATIC_PATHS) for key in swept)
    defaulted = defaults and not scenario.static_given and not static_swept
    forces = describe_friction(
        law, defaulted, **shared, terms=scenario.terms, swept=swept, ratios=ratios
    )
    parts = (
        ("oscillator", describe_oscillator(plant, swept, ratios, law.damping)),
        ("friction", forces),
        ("end stops", describe_stops(law, swept, peak)),
    )
    return ((label, text) for label, text in parts if text)


def describe_oscillator(
    plant: Plant,
    swept: Collection[str] = (),
    ratios: Mapping[str, float] = NO_RATIOS,
    damping: tuple[float, float] | None = None,
) -> str:
    """Return mass, stiffness and damping, with natural frequency and damping ratio.

    Parameters
    ----------
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
    first, other = format_number(extension), format_number(compression, unit)
    return f"{first} in extension, {other} in compression"


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
    defaulted : bool, optional
        Whether the static limit is the default.
    kinetic, static : bool, optional
        Whether all cases have the same force; otherwise it is omitted.
    terms : sequence of str, optional
        Name of a law other than Coulomb, followed by its further parameters.
    swept, ratios
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
    return ", ".join(text for key, text in parts if key not in varied)


def describe_limits(limits: StrokeLimits, peak: float | None = None) -> str:
    """Return stroke limits as text, in the unit of a displacement `peak` [m]."""
    up, down = (format_length(limit, peak) for limit in limits)
    return up if limits.up == limits.down else f"{up} up and {down} down"


def format_times_by_side(
    metrics: Mapping[str, float | None], name: str, limits: StrokeLimits
) -> str:
    """Return how often something happened; on either side where the limits differ."""
    times = format_times(metrics[name])
    if limits.up == limits.down:
        return times
    return f"{times} ({metrics[f'{name}_up']} up, {metrics[f'{name}_down']} down)"


def _describe_force_record(force_record: NormalForceRecord, varied: bool) -> str:
    """Return range and file of a recorded normal force; only the file if the force varies.

    The range of one that follows from an acceleration is relative to the weight of the mass.
    """
    files = ", ".join(sanitise(source.file) for source in force_record.inputs)
    if varied:
        return f"F_N recorded ({files})"
    low, high = float(force_record.relative.min()), float(force_record.relative.max())
    if (mean := force_record.mean) is None:
        return f"F_N {format_range(low, high, 'm g', 3)} ({files})"
    return f"F_N {format_range(mean * low, mean * high, 'N', 3)} ({files})"
