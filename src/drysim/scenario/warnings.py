"""Warnings for valid scenarios that are probably not what the user meant.

`scenario_warnings` checks for values in wrong units, a grid or record that is too coarse, a
mass that will not move, an approach outside its range of validity, swept keys without effect,
checks that always or never hold, and unused options. No record is read and no signal is
generated for this. For a sweep, the cases at the ends of each swept key represent all.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import inf, isclose, nan, pi, sqrt, tanh
from typing import Any

import numpy as np

from drysim.approach.stick_slip import ExactApproach
from drysim.block import Block
from drysim.core.model import AnyLaw, Samples, Sines, blocks, max_abs
from drysim.errors import RecordError, WarningMessage
from drysim.excitation.random import RandomMotion
from drysim.excitation.recorded import Record
from drysim.metrics.checks import EVERY_SEED, MEAN, Check
from drysim.metrics.table import METRICS_BY_NAME, SHARE, UNITS, Need
from drysim.scenario.axes import (
    DIRECTION_KEY,
    MAX_STORED_VALUES,
    Axis,
    are_draws,
    axis_groups,
    count_points,
    point_columns,
    points_in,
)
from drysim.scenario.blocks import LimitBySide, Stroke
from drysim.scenario.laws import LAW_KEY, LAWS, excluded_keys
from drysim.scenario.model import LIMIT_KEYS, Scenario, provides
from drysim.wording import Point, format_number, join_words

MIN_STEPS_PER_PERIOD = 20
"""Fewer output points per period do not resolve a sine in a plot."""

MAX_WEIGHTED_FREQUENCY = 80.0
"""Highest third octave of the ISO 2631-1 weightings [Hz]."""

STEP_ROUNDING = 1e-9
"""Relative tolerance for rounding of a step."""

LIMIT_ROUNDING = 1e-12
"""Relative difference of two limits that unit conversion alone can cause [-]."""

LOAD_PREFIXES = ("oscillator.", "friction.", "excitation.", "start.", "stroke.")
"""Prefixes of keys that decide whether the mass moves; if swept, this depends on the case."""

COMMON_STATIC_RATIO = 1.3
"""Upper end of common ratios F_fs/F_fk of dry contacts [-]."""


def scenario_warnings(
    scenario: Scenario,
    motion: Sines | Samples | None = None,
    compared: bool = False,
    swept: bool = True,
) -> tuple[WarningMessage, ...]:
    """Return the warnings for a scenario, including its swept values.

    Parameters
    ----------
    scenario : Scenario
    motion : Sines or Samples, optional
        Base motion, if available. Checks that need it are skipped otherwise, except for sines.
    compared : bool, optional
        Whether other approaches or laws are used as well; their options are then in use.
    swept : bool, optional
        Whether the cases of its sweep are solved; checks otherwise judge the one case.
    """
    if motion is None and scenario.excitation.periodic:
        motion = scenario.excitation.motion()
    warnings = [*_unit_warnings(scenario, motion)]
    if isinstance(motion, Sines):
        warnings += _step_warnings(scenario)
    elif isinstance(scenario.excitation, Record) and motion is not None:
        warnings += _record_warnings(scenario, motion)
    if motion is not None:
        if not any(axis.key.startswith(LOAD_PREFIXES) for axis in scenario.sweep):
            warnings += _friction_warnings(scenario, motion)
        warnings += [
            *_approach_warnings(scenario, motion),
            *weighting_warnings(scenario, motion),
        ]
    warnings += [
        *_sweep_warnings(scenario),
        *_check_warnings(scenario, swept),
        *_zero_force_warnings(scenario),
    ]
    if not compared:
        warnings += [*_unused_option_warnings(scenario), *_unreadable_record_warnings(scenario)]
    return tuple(warnings)


# Base motion, grid, friction, and approaches outside their range of validity

MAX_STIFFNESS = 2.5
"""F_fk c Δt/m [-] close to the stability limit of rk4 on a smooth sign, 2.8."""

MAX_CHATTER = 0.5
"""F_fk/(m a_u) [-] above which chatter dominates the acceleration under signum."""


def _step_warnings(scenario: Scenario) -> Iterator[WarningMessage]:
    """Warn of an output grid too coarse to plot the sines; for a sweep the worst case."""
    warnings = []
    for case in extreme_cases(scenario):
        motion, step = case.excitation.motion(), case.solver.step
        assert isinstance(motion, Sines), "a sweep keeps the kind of excitation"
        m, k_x, _ = case.oscillator.plant()
        f = max(motion.f, default=sqrt(k_x / m) / (2 * pi))
        steps = 1 / (f * step) if f and step else inf
        if steps < MIN_STEPS_PER_PERIOD:
            sentence = (
                f"solver.step gives {steps:.3g} steps per period at {f:g} Hz; "
                f"{1 / (f * MIN_STEPS_PER_PERIOD):.2g} s gives {MIN_STEPS_PER_PERIOD}"
            )
            numbers = {"solver.step": step or 0.0, "frequency": f, "steps": steps}
            warnings.append(WarningMessage("coarse-step", sentence, numbers))
    yield from sorted(warnings, key=lambda warning: warning.numbers["steps"])[:1]


MIN_PERIODS = 0.1
"""Natural periods below which a record is far too short, as if its times had another unit."""


def _record_warnings(scenario: Scenario, motion: Samples) -> Iterator[WarningMessage]:
    """Warn of a record that is too short or too coarse for the oscillator."""
    m, k_x, _ = scenario.oscillator.plant()
    f_0 = sqrt(k_x / m) / (2 * pi)
    length = (len(motion.u_dd) - 1) * motion.dt
    if 0 < length * f_0 < MIN_PERIODS:  # a block without a spring has no natural period
        yield WarningMessage(
            "record-short",
            f"the record lasts {length:.3g} s, far less than the natural period of "
            f"{1 / f_0:.3g} s: check its times and their unit",
            {"length": length, "f_0": f_0},
        )
    if f_0 * motion.dt * MIN_STEPS_PER_PERIOD <= 1 + STEP_ROUNDING:
        return
    sentence = (
        f"the record has a sample every {motion.dt:.6g} s, {1 / (f_0 * motion.dt):.3g} per "
        f"natural period of {1 / f_0:.3g} s: too few to resolve the excitation"
    )
    if getattr(scenario.excitation, "time", None) is not None:
        sentence += (
            "; times are in seconds unless their header has a unit, such as `t [ms]`: if this "
            "is the cause, set `time_unit`"
        )
    yield WarningMessage("coarse-record", sentence, {"step": motion.dt, "f_0": f_0})


def weighting_warnings(
    scenario: Scenario, motion: Sines | Samples, file_spacing: float = 0.0
) -> Iterator[WarningMessage]:
    """Warn of a grid, or of samples before their resampling, too coarse for weighting.

    `file_spacing` is the time step of a measured response in its file [s].
    """
    step = scenario.solver.step
    if isinstance(motion, Samples):
        clean_up = motion.realised.get("clean_up", ())
        assert isinstance(clean_up, list | tuple), "reports of the steps"
        resampled = (each["numbers"] for each in clean_up if each["step"] == "resample")
        before = (float(numbers["step_before"]) for numbers in resampled)
        step = max(motion.dt, file_spacing, *before)
    if (
        scenario.measure.weights
        and step
        and step * MAX_WEIGHTED_FREQUENCY * 2 > 1 + STEP_ROUNDING
    ):
        yield WarningMessage(
            "coarse-weighting",
            f"the step of {step:.6g} s resolves up to {0.5 / step:.4g} Hz, but ISO 2631-1 "
            f"weights up to {MAX_WEIGHTED_FREQUENCY:g} Hz: a_w and the metrics derived from it "
            "miss the rest",
            {"step": step, "highest": 0.5 / step},
        )


def _friction_warnings(scenario: Scenario, motion: Sines | Samples) -> Iterator[WarningMessage]:
    """Warn if the mass will not move, or moves only because no static limit is given.

    A mass at rest on its base sticks while |F_L| = |m ü + k_x x_r| is within F_fs. If the peak
    is above F_fs, and F_fs is not given, a common ratio F_fs/F_fk might still hold the mass;
    the smallest normal force is decisive.
    """
    law, start = scenario.law(), scenario.start.state()
    m, k_x, _ = scenario.oscillator.plant()
    # Upper bound of |ü|, attained by a single sine and by samples.
    peak = max_abs(motion.u_dd) if isinstance(motion, Samples) else sum(motion.A)
    load, least = m * peak + k_x * abs(start.x_r), _least_normal_force(law)
    F_fk, F_fs = min((law.F_fk, law.F_fs), law.compression or (inf, inf), key=max)
    hold, drag = F_fs * least, F_fk * least
    if law.stops is not None:  # a start beyond the limit compresses a bumper
        load += law.stops.elastic_force_and_energy(start.x_r)[0]
    if start.v_r == 0 and load <= hold and law.can_stick:
        yield WarningMessage(
            "will-not-move",
            f"the mass will not move: |F_L| is at most {load:.6g} N, F_fs is {hold:.6g} N",
            {"F_L": load, "F_fs": hold},
        )
    elif hold < load <= COMMON_STATIC_RATIO * drag and not scenario.static_given:
        ratio = load / drag
        yield WarningMessage(
            "static-not-given",
            "friction.static is not given, so F_fs = F_fk; with a friction.static_ratio of "
            f"{ratio:.4g} or more the mass would stay at rest: set it if known",
            {"F_L": load, "F_fk": drag, "ratio": ratio},
        )


def _least_normal_force(law: AnyLaw) -> float:
    """Return the smallest normal force relative to its mean [-]."""
    record = law.force_record
    return 1.0 - law.variation if record is None else float(record.relative.min())


def _approach_warnings(scenario: Scenario, motion: Sines | Samples) -> Iterator[WarningMessage]:
    """Warn if the approach is known to be inaccurate for the scenario."""
    F_fk, m = scenario.law().F_fk, scenario.oscillator.mass
    member = scenario.solver.member()
    step = motion.dt if isinstance(motion, Samples) else scenario.solver.step
    if member.approach == "smooth" and member.method == "rk4" and step is not None:
        stiffness = F_fk * member.sharpness * step / m
        if stiffness > MAX_STIFFNESS:
            enough = MAX_STIFFNESS * m / (F_fk * step)
            yield WarningMessage(
                "smooth-stiff",
                f"F_fk c Δt/m is {format_number(stiffness, digits=3)}, and smooth with rk4 is "
                "unstable above about 2.8: use a sharpness of "
                f"{format_number(enough, 's/m', 2)} or less, a smaller step, or another method",
                {"stiffness": stiffness},
            )
    if member.approach == "signum" and (a_u := _base_rms(motion)) > 0:
        share = F_fk / (m * a_u)
        if share > MAX_CHATTER:
            yield WarningMessage(
                "signum-chatters",
                f"F_fk/(m a_u) is {format_number(share, digits=3)}: instead of sticking, "
                "signum chatters with accelerations of about ±F_fk/m at any step, and if the "
                "mass should always stick T_a tends to this number; use stick-slip",
                {"share": share},
            )


def _base_rms(motion: Sines | Samples) -> float:
    """Return the RMS of ü [m/s²]; phases of sines are ignored."""
    if isinstance(motion, Samples):
        return sqrt(sum(float(part @ part) for part in blocks(motion.u_dd)) / len(motion.u_dd))
    return sqrt(sum(A * A for A in motion.A) / 2)


# Values that look like values in other units, swept values included

LONG_TRAVEL = 1.0
"""Length too large for an isolator [m], such as 25 instead of 25 mm."""

MEGAMETRE_TYPO = 1e5
"""Length so large that `Mm` was probably written for `mm` [m]."""

HIGH_ACCELERATION = 100.0
"""Ten times gravity [m/s²]: with a travel above 1 m the unit is probably mm/s²."""

LOW_FREQUENCY = 0.1
"""Natural frequency [Hz] below which the mass is probably in g or the stiffness in N/mm."""

HIGH_FREQUENCY, HEAVY = 500.0, 10.0
"""Natural frequency [Hz] above which no mount of a mass from 10 kg lies."""

FAINT_DAMPING, MAX_RATIO = 1e-3, 2.0
"""Damping ratio [-] below which a damper of a heavy mass is as good as none, and damping up to
which its number may be meant as a ratio."""

HIGH_DAMPING_RATIO = 5.0
"""Damping ratio [-] from which a percentage was probably meant."""

PERCENT_METRICS = ("SEAT", "SEAT_VDV", "stroke_used")
"""Dimensionless metrics often given in percent."""

HIGH_RATIO = 10.0
"""Limit of such a metric [-] from which a percentage was probably meant."""

WIDE_INTERVAL = 1.0
"""Relative half-width [-] from which a percentage was probably meant."""

MAX_TRAVEL_RATIO = 1000.0
"""Limit over expected travel [-] from which the unit is probably wrong."""


def _unit_warnings(
    scenario: Scenario, motion: Sines | Samples | None
) -> Iterator[WarningMessage]:
    """Warn of values that look like values in other units, once per key.

    For a sweep, the cases at both ends of each swept key are checked.
    """
    warnings: dict[tuple[str, ...], WarningMessage] = {}
    scenes: list[tuple[Scenario, Sines | Samples]] = []
    for case in extreme_cases(scenario):
        case_motion = motion if case.excitation is scenario.excitation else None
        if case is not scenario and case.excitation.periodic:  # its own motion
            case_motion = case.excitation.motion()
        waves = (
            _sine_warnings(case_motion, case.excitation.phases)
            if isinstance(case_motion, Sines)
            else ()
        )
        if case_motion is not None:
            scenes.append((case, case_motion))
        for warning in (
            *_length_warnings(case),
            *_oscillator_warnings(case),
            *_percent_warnings(case),
            *waves,
        ):
            warnings.setdefault((warning.slug, *warning.numbers), warning)
    yield from warnings.values()
    yield from _remote_limit_warnings(scenario, scenes)


def _length_warnings(scenario: Scenario) -> Iterator[WarningMessage]:
    """Warn of lengths that look like millimetres."""
    m, k_x, _ = scenario.oscillator.plant()
    start = abs(scenario.start.x_r)
    lengths = [(key, key, value) for key, value in _typed_limits(scenario.stroke)]
    if k_x * start / m >= HIGH_ACCELERATION:
        lengths.append(("start.x_r", "start.x_r", start))
    varied = scenario.design.vary if scenario.design else ()
    lengths += [
        (axis.key, axis.key, max(abs(axis.low), abs(axis.high)))
        for axis in varied
        if axis.key in (*LIMIT_KEYS, "start.x_r")
    ]
    lengths += [
        (what, key, check.limit)
        for what, key, check in _limits(scenario)
        if not check.unit and UNITS[check.metric] == "m"
    ]
    for what, key, value in lengths:
        if value >= LONG_TRAVEL:
            typed = value / 1e6 if value >= MEGAMETRE_TYPO else value
            sentence = f"{what} is {value:g} m; if it is in millimetres, write `{typed:g} mm`"
            yield WarningMessage("looks-like-millimetres", sentence, {key: value})


def _limits(scenario: Scenario) -> Iterator[tuple[str, str, Check]]:
    """Yield the checks, and the limits of a design study, each with its name and its key."""
    for i, check in enumerate(scenario.checks):
        yield f"the limit of the check `{check}`", f"checks.{i}", check
    if scenario.design is not None:
        for i, check in enumerate(scenario.design.within or ()):
            yield f"the limit `{check}` of design.within", f"design.within.{i}", check


def _typed_limits(stroke: Stroke | None) -> Iterator[tuple[str, float]]:
    """Yield the stroke limits by key, as in the scenario: not shifted by the offset."""
    if stroke is None:
        return
    if isinstance(stroke.limit, LimitBySide):
        yield from (
            ("stroke.limit.up", stroke.limit.up),
            ("stroke.limit.down", stroke.limit.down),
        )
    else:
        yield "stroke.limit", stroke.limit


def _remote_limit_warnings(
    scenario: Scenario, scenes: Sequence[tuple[Scenario, Sines | Samples]]
) -> Iterator[WarningMessage]:
    """Warn of checks with a limit far beyond the expected travel in all cases of a sweep."""
    long = [
        (what, key, check.limit)
        for what, key, check in _limits(scenario)
        if check.limit >= LONG_TRAVEL and check.unit and UNITS[check.metric] == "m"
    ]
    if not long or not scenes:
        return
    reach = max(_expected_travel(*scene) for scene in scenes)
    for what, key, limit in long:
        if limit >= MAX_TRAVEL_RATIO * reach:
            sentence = (
                f"{what} is {limit:g} m, over {MAX_TRAVEL_RATIO:g} times the {reach:.2g} m "
                "expected from base motion and start; check its unit"
            )
            yield WarningMessage("implausible-length", sentence, {key: limit})


def _expected_travel(scenario: Scenario, motion: Sines | Samples) -> float:
    """Return a displacement that a motion without friction hardly exceeds [m].

    Under samples it is a bound: the largest |ü| times the integral of the impulse response, or
    the response to all of |ü| as one impulse. Under sines it is their steady state, at least
    the static one. Infinite without a spring.
    """
    m, k_x, b = scenario.oscillator.plant()
    if k_x == 0.0:
        return inf
    softness, start = m / k_x, scenario.start.state()
    omega = sqrt(k_x / m)
    ratio = 0.5 * b / (m * omega)
    if isinstance(motion, Samples):
        impulse = motion.dt * sum(float(np.abs(part).sum()) for part in blocks(motion.u_dd))
        angle = pi * ratio / (2.0 * sqrt(1.0 - ratio * ratio)) if ratio < 1.0 else inf
        gain = 1.0 / tanh(angle) if angle else inf
        base = min(max_abs(motion.u_dd) * gain * softness, impulse / omega)
    else:
        base = 0.0
        for A, f, _ in zip(*motion, strict=True):
            w = 2.0 * pi * f
            divisor = abs(complex(k_x / m - w * w, 2.0 * ratio * omega * w))
            base += A * max(softness, 1.0 / (w * w), 1.0 / divisor if divisor else inf)
    return base + abs(start.x_r) + abs(start.v_r) / omega


def _percent_warnings(scenario: Scenario) -> Iterator[WarningMessage]:
    """Warn of ratios that look like percentages."""
    key = "oscillator.damping_ratio"
    shares = [(key, key, scenario.oscillator.damping_ratio or 0.0, HIGH_DAMPING_RATIO)]
    shares += [
        (what, path, check.limit, HIGH_RATIO)
        for what, path, check in _limits(scenario)
        if not check.unit and check.metric in PERCENT_METRICS
    ]
    if (until := getattr(scenario.excitation, "until", None)) is not None:
        key = "excitation.until.half_width"
        shares.append((key, key, until.half_width, WIDE_INTERVAL))
    for what, path, value, high in shares:
        if value >= high:
            sentence = f"{what} is {value:g}; if it is in percent, write `{value:g} %`"
            yield WarningMessage("looks-like-percent", sentence, {path: value})


def _oscillator_warnings(scenario: Scenario) -> Iterator[WarningMessage]:
    """Warn of an oscillator that looks like one in other units."""
    m, k_x, b = scenario.oscillator.plant()
    f_0 = sqrt(k_x / m) / (2 * pi)
    numbers = {"oscillator.mass": m, "oscillator.stiffness": k_x, "f_0": f_0}
    if f_0 > HIGH_FREQUENCY and m >= HEAVY:
        is_stiffness = scenario.oscillator.stiffness is not None
        what = f"oscillator.stiffness, {k_x:g} N/m," if is_stiffness else "it"
        sentence = (
            f"the natural frequency is {f_0:.4g} Hz, far above that of a mount for {m:g} kg: "
            f"is {what} in another unit?"
        )
        yield WarningMessage("natural-frequency-high", sentence, numbers)
    given = scenario.oscillator.damping
    if isinstance(given, float) and m >= HEAVY and k_x > 0 and 0 < given <= MAX_RATIO:
        ratio = 0.5 * b / sqrt(k_x * m)
        if ratio < FAINT_DAMPING:
            sentence = (
                f"oscillator.damping {given:g} N·s/m hardly damps {m:g} kg, ξ is {ratio:.2g}; "
                f"if it is the damping ratio, write `damping_ratio: {given:g}`"
            )
            yield WarningMessage("looks-like-ratio", sentence, {"oscillator.damping": given})
    if 0 < f_0 < LOW_FREQUENCY and scenario.oscillator.stiffness is not None:
        yield WarningMessage(
            "looks-like-grams",
            f"the natural frequency is {f_0:.3g} Hz: is oscillator.mass in grams (`{m:g} g`) "
            f"or oscillator.stiffness in N/mm (`{k_x:g} N/mm`)?",
            numbers,
        )


def _sine_warnings(motion: Sines, phases: Iterable[float]) -> Iterator[WarningMessage]:
    """Warn of sines that look like sines in other units; `phases` are as stated [rad]."""
    for A, f in zip(motion.A, motion.f, strict=True):
        u = A / (2 * pi * f) ** 2
        if u >= LONG_TRAVEL and A >= HIGH_ACCELERATION:
            yield WarningMessage(
                "looks-like-millimetres",
                f"at {f:g} Hz the base displacement has an amplitude of {u:.3g} m; if the "
                "excitation is in mm/s², write `mm/s2` after the number",
                {"frequency": f, "amplitude": A, "u": u},
            )
    for phase in phases:
        if abs(phase) > 2 * pi:
            sentence = (
                f"a phase of {phase:g} rad is above 2π; if it is in degrees, write "
                f"`{phase:g} deg`"
            )
            yield WarningMessage("looks-like-degrees", sentence, {"phase": phase})


# Sweeps: cases at the ends of axes, and keys without effect


def extreme_cases(scenario: Scenario) -> Iterator[Scenario]:
    """Yield the cases at the smallest and the largest value of each swept key.

    A scenario without sweep is its only case.
    """
    if not scenario.sweep:
        yield scenario
        return
    first = _point(scenario.sweep, 0)
    for group in axis_groups(scenario.sweep):
        for point in _extreme_points(group):
            yield scenario.at({**first, **point})


def _extreme_points(group: Sequence[Axis]) -> list[dict[str, Any]]:
    """Return the points at which a key of a group has its smallest or largest value."""
    count = len(group[0].values)
    if count > MAX_STORED_VALUES:  # as a rule a range, whose ends are the extremes
        return [_point(group, 0), _point(group, count - 1)]
    # The values of a sample are computed together: one costs as much as a chunk.
    every = list(points_in(point_columns(group, 0, count)))
    values = {axis.key: [point[axis.key] for point in every] for axis in group}
    places = {column.index(pick(column)) for column in values.values() for pick in (min, max)}
    return [every[place] for place in sorted(places)]


def _point(axes: Sequence[Axis], number: int) -> dict[str, Any]:
    """Return a point by its number."""
    return next(points_in(point_columns(axes, number, number + 1)))


def _sweep_warnings(scenario: Scenario) -> Iterator[WarningMessage]:
    """Warn of swept keys without effect, and of what the reference leaves out."""
    for group in axis_groups(scenario.sweep):
        if len(group[0].values) == 1 and group[0].key != DIRECTION_KEY:
            each, them = (" of each", "them") if len(group) > 1 else ("", "it")
            keys = join_words([axis.key for axis in group])
            remedy = f"set {them} in the scenario instead"
            sentence = f"sweep of {keys} has a single value{each}; {remedy}"
            yield WarningMessage("sweep-changes-nothing", sentence, {"values": 1})
    for axis in scenario.sweep:
        if why := _why_without_effect(scenario, axis):
            sentence = f"sweep of {axis.key} {why}"
            yield WarningMessage(
                "sweep-changes-nothing", sentence, {"values": len(axis.values)}
            )
    if reference := scenario.reference:
        for sentence in scenario.omissions(reference):
            yield WarningMessage("left-out", f"reference: {sentence}")


def _why_without_effect(scenario: Scenario, axis: Axis) -> str | None:
    """Return why a swept key with several values has no effect; None if it has one."""
    if axis.key == DIRECTION_KEY or len(axis.values) == 1:
        return None
    if axis.key in LIMIT_KEYS and scenario.stops is None:
        return "does not affect the motion, only when the stroke limit is exceeded"
    approach = scenario.solver.approach
    block, option, *rest = axis.key.split(".")
    if block == "solver" and rest and option != approach:
        return f"has no effect: the approach is {approach}, which does not use {option}"
    exact = isinstance(scenario.solver.member(), ExactApproach)
    if axis.key == "solver.step" and exact and scenario.excitation.periodic:
        return f"has no effect on the metrics: {approach} is exact under sines at any step"
    phase = axis.key.startswith("excitation.") and axis.key.endswith(".phase")
    if phase and scenario.measure.steady and len(scenario.frequencies) == 1:
        return (
            "has no effect: the metrics cover a full period of the steady state (if several "
            "steady states coexist, it can select another one)"
        )
    first, last = (
        _point(scenario.sweep, number) for number in (0, count_points(scenario.sweep) - 1)
    )
    together = next(group for group in axis_groups(scenario.sweep) if axis in group)
    other = last | {a.key: first[a.key] for a in together}
    if _metric_inputs(scenario, last) == _metric_inputs(scenario, other):
        return "has no effect: the quantity is 0 or not used"
    return None


def _metric_inputs(scenario: Scenario, point: Point) -> tuple[object, ...]:
    """Return everything that the metrics of a case depend on."""
    case = scenario.at(point)
    solver = case.solver.step, case.solver.member()
    return (
        case.oscillator.plant(), case.law(), case.excitation, case.start, solver, case.measure
    )  # fmt: skip


# Checks and keys without effect


def _check_warnings(scenario: Scenario, swept: bool) -> Iterator[WarningMessage]:
    """Warn of checks that always or never hold, are duplicates or contradict each other."""
    accepted: dict[str, list[Check]] = {}
    solved = scenario if swept else scenario.copy_with({"sweep": ()})
    seeds = least_seeds_of(solved)
    over_draws = are_draws(scenario.sweep) and seeds == 1
    draws = count_points(scenario.sweep) if over_draws and swept else 0
    for i, check in enumerate(scenario.checks):
        before = accepted.setdefault(check.metric, [])
        duplicate = next(
            (earlier for earlier in before if _is_same_check(earlier, check)), None
        )
        opposite = next(
            (
                earlier
                for earlier in before
                if earlier.contradicts(check) and _apply_together(scenario, earlier, check)
            ),
            None,
        )
        answer, numbers = check.constant_result, {f"checks.{i}": check.limit}
        if draws and check.is_quantile:
            if draws < check.least_seeds:
                yield few_seeds_warning(check, draws, of="draws")
        elif check.judges != MEAN and seeds == 1:
            if draws:
                sentence = (
                    f"the check `{check}` judges every draw, also without `with {EVERY_SEED}`"
                )
            elif over_draws:
                sentence = (
                    f"the check `{check}` judges a single motion; `drysim sweep` the draws"
                )
            else:
                sentence = f"the check `{check}` judges a single motion; give excitation.seeds"
            yield WarningMessage("check-of-one-seed", sentence, numbers)
        elif seeds < check.least_seeds:
            yield few_seeds_warning(check, seeds)
        known_for = METRICS_BY_NAME[check.metric].known_for
        if lacking := lacking_need(scenario, check):
            yield cannot_hold_warning(i, check, lacking)
        elif known_for and not isinstance(scenario.excitation, RandomMotion | Record):
            sentence = (
                f"the check `{check}` cannot hold: {check.metric} is known for {known_for} only"
            )
            yield WarningMessage("check-cannot-hold", sentence, numbers)
        elif answer is not None:
            share = METRICS_BY_NAME[check.metric].kind == SHARE
            hint = (
                "shares are between 0 and 1" if share else f"{check.metric} is never negative"
            )
            if share and check.limit > 1 and not check.unit:
                hint += f"; if it is in percent, write `{check.limit:g} %`"
            word = "fail" if answer else "hold"
            sentence = f"the check `{check}` cannot {word}: {hint}"
            yield WarningMessage(f"check-cannot-{word}", sentence, numbers)
        elif scenario.sweep and not _apply_together(scenario, check):
            sentence = f"the check `{check}` cannot hold: it applies to no case of the sweep"
            yield WarningMessage("check-cannot-hold", sentence, numbers)
        elif duplicate is not None:
            yield WarningMessage("check-twice", f"the check `{check}` is listed twice", numbers)
        elif opposite is not None:
            sentence = (
                f"the checks `{opposite}` and `{check}` contradict each other: one must fail"
            )
            yield WarningMessage("checks-contradict", sentence, numbers)
        else:
            before.append(check)
    within = scenario.design.within if scenario.design else None
    for limit in within or ():
        if 1 < seeds < limit.least_seeds:
            yield few_seeds_warning(limit, seeds)


def least_seeds_of(scenario: Scenario) -> int:
    """Return the number of seeds of a scenario, at most; of a sweep over it the least one."""
    swept = (axis.values for axis in scenario.sweep if axis.key == "excitation.seeds")
    return min(next(swept, [getattr(scenario.excitation, "max_seeds", 1)]))


def few_seeds_warning(
    check: Check, seeds: int, place: str = "", of: str = "seeds"
) -> WarningMessage:
    """Return the warning that a check judges a quantile of too few seeds, or `of` draws.

    `place` says where there are so few seeds.
    """
    least = check.least_seeds
    key, every = {
        "seeds": ("excitation.seeds", f"write `with {EVERY_SEED}`"),
        "draws": ("count", f"judge every draw, without `{check.judges}`"),
    }[of]
    sentence = (
        f"the check `{check}` judges the {check.judges} of {seeds} {of}{place}, which is "
        f"about an extreme of them; give {key}: {least} or more, of which one is "
        f"expected beyond it, or {every}"
    )
    return WarningMessage("quantile-of-few-seeds", sentence, {"seeds": seeds, "least": least})


def cannot_hold_warning(number: int, check: Check, lacking: Need) -> WarningMessage:
    """Return the warning of the check with a number whose metric needs what is not stated."""
    sentence = (
        f"the check `{check}` cannot hold: {check.metric} is not available without "
        f"{lacking.name}; give {' or '.join(lacking.keys)}"
    )
    return WarningMessage("check-cannot-hold", sentence, {f"checks.{number}": check.limit})


def lacking_need(scenario: Scenario, check: Check) -> Need | None:
    """Return what the metric of a check needs and the scenario does not state, if anything."""
    swept = {axis.key for axis in scenario.sweep}
    return next(
        (
            need
            for need in METRICS_BY_NAME[check.metric].needs
            if not provides(scenario, need) and swept.isdisjoint(need.keys)
        ),
        None,
    )


def _is_same_check(check: Check, other: Check) -> bool:
    """Return whether two checks of one metric are equivalent."""
    alike = isclose(check.limit, other.limit, rel_tol=LIMIT_ROUNDING)
    same = (check.op, check.judges) == (other.op, other.judges)
    return alike and same and {*check.conditions} == {*other.conditions}


def _apply_together(scenario: Scenario, *checks: Check) -> bool:
    """Return whether checks can apply to one case of a sweep, judged key by key."""
    swept = {axis.key: axis.values for axis in scenario.sweep}
    conditions = [condition for check in checks for condition in check.conditions]
    for key in {condition.key for condition in conditions}:
        asked = [condition for condition in conditions if condition.key == key]
        default = asked[0].here
        values = swept.get(key, [nan if default is None else default])
        if len(values) > MAX_STORED_VALUES:
            continue
        if not any(all(condition.holds({key: v}) for condition in asked) for v in values):
            return False
    return True


def _zero_force_warnings(scenario: Scenario) -> Iterator[WarningMessage]:
    """Warn of keys that scale a friction force of zero."""
    friction, swept = scenario.active_friction, {axis.key for axis in scenario.sweep}
    force = next(
        (k for k in ("kinetic", "mu_kinetic") if getattr(friction, k, None) == 0), None
    )
    if force is None or f"friction.{force}" in swept:
        return
    ratio, varied = (
        getattr(friction, key, None) for key in ("static_ratio", "normal_variation")
    )
    idle = {"static_ratio": ratio not in (None, 1.0), "normal_variation": varied is not None}
    if scenario.nominal_law().F_fs > 0:
        idle["normal_variation"] = False
    for key in (key for key, is_idle in idle.items() if is_idle):
        if not _is_chosen_by_override(scenario, f"friction.{force}", f"friction.{key}"):
            sentence = f"friction.{key} has no effect: friction.{force} is 0"
            yield WarningMessage("no-effect", sentence, {f"friction.{force}": 0.0})


def _unused_option_warnings(scenario: Scenario) -> Iterator[WarningMessage]:
    """Warn of options not used by the approach and law of the scenario."""
    approach = scenario.solver.approach
    for name, options in scenario.solver:
        idle = isinstance(options, Block) and name not in (approach, scenario.reference)
        if idle and not _is_chosen_by_override(scenario, "solver.approach", f"solver.{name}"):
            sentence = (
                f"solver.{name} has no effect: the approach is {approach}; options of {name} "
                "are used in comparisons only"
            )
            yield WarningMessage("no-effect", sentence)
    friction = scenario.file_block("friction")
    law = friction.get(LAW_KEY)
    options = friction.get(law) if isinstance(law, str) else None
    if not isinstance(law, str) or not isinstance(options, Mapping):
        return
    if not _is_chosen_by_override(scenario, f"friction.{LAW_KEY}", f"friction.{law}"):
        for key in sorted(friction.keys() & excluded_keys(law, options)):
            replacement = key if key in options else ", ".join(options)
            sentence = f"friction.{key} has no effect: friction.{law}.{replacement} replaces it"
            yield WarningMessage("no-effect", sentence)


def _is_chosen_by_override(scenario: Scenario, choice: str, options: str) -> bool:
    """Return whether an override made a choice but did not set its options.

    With `--approach`, for example, the options in the file belong to the choice in the file.
    """
    chosen = scenario.origin["overrides"]
    return choice in chosen and not any(f"{key}.".startswith(f"{options}.") for key in chosen)


def _unreadable_record_warnings(scenario: Scenario) -> Iterator[WarningMessage]:
    """Warn of an unreadable normal-force record in the options of another law."""
    for law in LAWS:
        record = getattr(getattr(scenario.friction, law, None), "normal_record", None)
        if record is not None:
            try:
                record.force_record()
            except RecordError as fault:
                sentence = f"friction.{law}.normal_record cannot be used: {fault.problem}"
                yield WarningMessage("unread-record", sentence)
