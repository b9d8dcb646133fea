"""The scenario: a validated file in SI, and the scenarios derived from it.

`Scenario` is first. The sections after it are: values that an approach does not support; the
case at a point of a sweep; the scenario under another approach or friction law, and what either
omits; the resolved scenario as plain values.

Rules on which keys may occur together are checked on the values of a file (`key_faults` in
`rules`), rules on values on the scenario (`unsupported_values`). The cases of a sweep are
derived from the scenario without reading the file again: only the blocks changed by a point are
validated, with the rules they can violate.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from math import pi, sqrt
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from numpy.typing import NDArray
from pydantic import Field, ValidationError, ValidationInfo, WithJsonSchema, field_validator

from drysim.approach import APPROACHES_BY_NAME, EXACT, Approach
from drysim.block import Block, InvalidValue
from drysim.core.model import AnyLaw, CoulombLaw, DynamicLaw, PiecewiseLaw
from drysim.direction import ByDirection, mean_of_directions
from drysim.errors import Problem, ScenarioError
from drysim.excitation import Excitation
from drysim.excitation.base import GeneratedMotion
from drysim.excitation.harmonic import Shock
from drysim.excitation.recorded import Record
from drysim.friction import Coulomb, Friction, RatioInterval
from drysim.metrics.table import Need
from drysim.scenario.assess import Assess, missing_blocks
from drysim.scenario.axes import (
    DIRECTION_KEY,
    FILE_KEY,
    FROM_FIT_KEY,
    SAMPLE_KEY,
    Axis,
    Sweep,
    count_points,
    has_shock_spectrum,
    iter_points,
)
from drysim.scenario.blocks import (
    FORMAT_VERSION,
    ApproachName,
    Checks,
    FolderName,
    Format,
    FromFile,
    Measure,
    Oscillator,
    Solver,
    Start,
    Stops,
    Stroke,
    validate_approach,
)
from drysim.scenario.design import Design
from drysim.scenario.draws import path_from
from drysim.scenario.fit import Fit, missing_values, unstated_start, without_value
from drysim.scenario.keys import block_models, numeric_keys
from drysim.scenario.laws import (
    LAW_KEY,
    LAWS,
    friction_under_law,
    friction_uses_key,
    law_faults,
)
from drysim.scenario.rules import KeyFault
from drysim.scenario.steps import default_step, needs_step, proposed_step, step_required
from drysim.scenario.validation import validation_faults
from drysim.scenario.window import (
    common_period,
    counts_in_periods,
    has_recorded_normal_force,
    is_steady_by_default,
    scene_frequencies,
    times_in_seconds,
)
from drysim.wording import Point, format_count, format_number
from drysim.yaml_document import KeyPath

Columns = dict[str, NDArray[Any]]
"""Columns of values of many cases by dotted key."""

STATIC_KEYS = ("static", "static_ratio", "mu_static")
"""Keys that can set the static limit above kinetic friction."""

STATIC_PATHS = tuple(f"friction.{key}" for key in STATIC_KEYS)
"""Their dotted keys."""

_VARIATION_PREFIXES = ("friction.normal_variation.", "friction.normal_record.")
_STOPS_PREFIX = "stroke.stops."

SIDE_KEYS = ("stroke.limit.up", "stroke.limit.down", "stroke.offset")
"""Keys of stroke limits that differ between the sides."""

LIMIT_KEYS = ("stroke.limit", *SIDE_KEYS)
"""Keys of the stroke limits; each case has its own limits where one of them is swept."""

STATIC_RATIO: KeyPath = ("friction", "static_ratio")
"""Key of the ratio of the friction forces, which may be an interval."""

EQUATION_BLOCKS = ("oscillator", "friction", "excitation")
"""Blocks of a scenario whose numbers are coefficients of the equation of motion."""

CLOSED_FORM_LAWS = tuple(name for name, law in LAWS.items() if law.closed_form)
"""Friction laws that go with end stops and with damping by direction."""


class Scenario(FromFile):
    """A vibration isolator, its base motion, and what to compute."""

    drysim: Format = FORMAT_VERSION
    """Version of the file format."""
    name: FolderName = "scenario"
    """Name of the scenario and of its output folder; default: the name of the file."""
    about: str = ""
    """Description in one sentence."""
    oscillator: Oscillator
    """Mass, spring and damper."""
    friction: Friction | None = Field(None, discriminator=LAW_KEY)
    """Dry friction between mass and base; without this block there is none."""
    stroke: Stroke | None = None
    """Permitted motion of the mass on its base."""
    start: Start = Field({}, validate_default=True)
    """State at t = 0; default: at rest."""
    excitation: Excitation = Field(discriminator="kind")
    """Base motion."""
    solver: Solver = Field({}, validate_default=True)
    """How the motion is computed."""
    measure: Measure = Field({}, validate_default=True)
    """Time window of the metrics."""
    fit: Fit | None = None
    """What `drysim fit` fits to a measured response; other commands ignore it."""
    assess: Assess | None = None
    """What `drysim assess` evaluates: measured records of base and mass; other commands ignore
    it, and only they need `oscillator` and `excitation`."""
    design: Design | None = None
    """What `drysim design` chooses and minimises; other commands ignore it."""
    sweep: Sweep = ()
    """Keys to vary: dotted keys of this file, each with a list of values, or with from, to and
    step, count or per_octave. Every combination is a case; the first key varies fastest."""
    reference: (
        Annotated[ApproachName, WithJsonSchema({"enum": list(APPROACHES_BY_NAME)})] | None
    ) = None
    """Name of a second approach for the sweep, as the reference curve."""
    checks: Checks = ()
    """Conditions on metrics, such as `x_r_peak < 25 mm`; if one fails the exit code is 1. Of
    several seeds the mean is judged, every seed (`x_r_peak < 25 mm with every seed`), or a
    quantile (`x_r_peak p95 < 25 mm`)."""

    @field_validator("solver")
    @classmethod
    def _step_suits(cls, solver: Solver, info: ValidationInfo) -> Solver:
        excitation = info.data.get("excitation")
        if solver.step is not None and isinstance(excitation, GeneratedMotion):
            excitation.check_step(solver.step)
        return solver

    @field_validator("measure", mode="before")
    @classmethod
    def _measure_in_seconds(cls, value: object, info: ValidationInfo) -> object:
        if isinstance(value, Measure):
            value = value.model_dump(exclude_unset=True)
        if not isinstance(value, Mapping):
            return value
        excitation, friction = info.data.get("excitation"), info.data.get("friction")
        is_valid = excitation is not None and "friction" in info.data
        steady = is_steady_by_default(excitation, friction)
        return times_in_seconds(
            value, scene_frequencies(excitation, friction) if is_valid else None, steady
        )

    def law(self) -> AnyLaw:
        """Return the friction law as forces, with end stops if they are modelled.

        Raises
        ------
        RecordError
            If a recorded normal force cannot be used.
        """
        friction = self.active_friction
        law = friction.to_law(self.oscillator.mass) if friction else CoulombLaw(0.0, 0.0)
        # Dynamic laws with these are an error, which `unsupported_values` reports.
        if isinstance(law, DynamicLaw):
            return law
        if self.oscillator.damping_pair is not None:
            law = law.as_piecewise()._replace(damping=self.oscillator.damping_pair)
        if self.stops is None or self.stroke is None:
            return law
        return self.stops.with_friction(law, self.stroke.limits)

    def nominal_law(self) -> AnyLaw:
        """Return the friction law without reading a recorded normal force."""
        friction = self.active_friction
        if friction is None or not has_recorded_normal_force(friction):
            return self.law()
        unrecorded = friction.model_copy(update={"normal_record": None})
        return unrecorded.to_law(self.oscillator.mass)

    @property
    def missing_values(self) -> list[str]:
        """Free keys of the fit without a value in the file, which only a fit provides."""
        return missing_values(self._document.value) if self.fit and self._document else []

    @property
    def missing_blocks(self) -> list[str]:
        """Blocks that the file leaves out, as `drysim assess` needs none of them."""
        return missing_blocks(self._document.value) if self.assess and self._document else []

    @property
    def unstated_start(self) -> list[str]:
        """Keys of the start state that the file leaves to the fit."""
        return unstated_start(self._document.value) if self.fit and self._document else []

    @property
    def active_friction(self) -> Friction | None:
        """Friction of the file's law or, in a comparison, of the compared law."""
        if self.friction is None or not self.compared_law:
            return self.friction
        return friction_under_law(self.friction, self.compared_law)

    @property
    def terms(self) -> tuple[str, ...]:
        """Name of a law other than Coulomb, and its parameters that are not swept."""
        swept = {axis.key for axis in self.sweep}
        return tuple(self.active_friction.describe(swept)) if self.active_friction else ()

    @property
    def ratios(self) -> dict[str, float]:
        """Parameters relative to others (spring, damping, static friction), by key."""
        static = getattr(self.active_friction, "static_ratio", None)
        ratios = {
            "natural_frequency": self.oscillator.natural_frequency,
            "damping_ratio": self.oscillator.damping_ratio,
            "static_ratio": None if self.static_interval else static,
        }
        return {key: value for key, value in ratios.items() if value is not None}

    @property
    def static_interval(self) -> RatioInterval | None:
        """Interval of F_fs/F_fk, if only its bounds are given."""
        ratio = getattr(self.active_friction, "static_ratio", None)
        return ratio if isinstance(ratio, RatioInterval) else None

    @property
    def label(self) -> str:
        """Name of the scenario in tables: its approach, or the law in a comparison."""
        return self.compared_law or self.solver.approach

    @property
    def stops(self) -> Stops | None:
        """End stops, if they are modelled."""
        return None if self.stroke is None else self.stroke.stops

    @property
    def has_sides(self) -> bool:
        """Whether the file tells the two sides of the stroke apart, at least in some cases."""
        swept = any(axis.key in SIDE_KEYS for axis in self.sweep)
        return self.stroke is not None and (swept or self.stroke.has_sides)

    @property
    def static_given(self) -> bool:
        """Whether the static limit is given; True without friction."""
        return self.active_friction is None or self.active_friction.static_given

    @property
    def frequencies(self) -> tuple[float, ...]:
        """All frequencies of periodic base motion and normal force [Hz]."""
        return scene_frequencies(self.excitation, self.active_friction)

    @property
    def step(self) -> float | None:
        """Step of the output grid [s], also where it is the default; None for a record."""
        if self.solver.step is not None or self.excitation.has_own_step:
            return self.solver.step
        measure = self.measure
        return default_step(
            self.frequencies, self._f_0, measure.duration, measure.weights is not None
        )

    @property
    def proposed_step(self) -> float | None:
        """Step for a message where one is missing [s]."""
        return proposed_step(self.excitation, self.frequencies, self._f_0)

    @property
    def _f_0(self) -> float:
        """Natural frequency [Hz]."""
        m, k_x, _ = self.oscillator.plant()
        return sqrt(k_x / m) / (2 * pi)

    def at(self, point: Point) -> "Scenario":
        """Return the case at a point of the sweep, a scenario without sweep.

        The point has values in SI by dotted key; other keys keep their values.

        Raises
        ------
        ScenarioError
            If the values are inconsistent; the message contains the point.
        """
        try:
            return _make_case(self, point)
        except InvalidValue as error:
            problem = _locate(self, point, error)
        raise self._error(problem)

    def error(self, sentence: str, key: str | KeyPath, hint: str = "") -> ScenarioError:
        """Return the error for a key whose value only the complete case shows to be invalid."""
        return self._error(self.problem(sentence, key), hint)

    def _error(self, problem: Problem, hint: str = "") -> ScenarioError:
        name = self.origin["file"] or self.name
        return ScenarioError(f"{name}: 1 error", (problem,), hint)

    def values_of(self, keys: Iterable[str]) -> dict[str, float]:
        """Return the values of keys in SI, without those that have none."""
        entries = numeric_keys(type(self), self.resolved())
        values = {
            key: entry.here(key) for key in keys if (entry := entries.get(key)) is not None
        }
        return {key: value for key, value in values.items() if value is not None}

    def with_values(self, values: Mapping[str, Any]) -> "Scenario":
        """Return the scenario with other values, as `at` does, but without validation.

        That takes a tenth of the time. Values may be columns of many cases; then only
        arithmetic is meaningful on the result (plant, law, motion, ...).
        """
        blocks: dict[str, Any] = {}
        for key, value in values.items():
            if key == DIRECTION_KEY:
                continue
            name, *steps = key.split(".")
            annotation = type(self).model_fields[name].annotation
            block = blocks.get(name, getattr(self, name))
            blocks[name] = _with_field(block, annotation, steps, value)
        return self.copy_with(blocks)

    def with_approach(self, name: str) -> "Scenario":
        """Return the scenario for another approach, without what it does not support.

        `omissions` lists what is left out. Keys that the approach does not use are not swept.

        Raises
        ------
        ValueError
            If there is no such approach.
        """
        member = APPROACHES_BY_NAME[validate_approach(name)]
        used = tuple(axis for axis in self.sweep if approach_uses_key(name, axis.key))
        if used[:1] != self.sweep[:1]:  # no sweep up or down along another key
            used = tuple(axis for axis in used if axis.key != DIRECTION_KEY)
        fields = self._without(name, used, member.supports_direction, member.supports_stops)
        fields["friction"] = _friction_for_approach(member, self.friction)
        return self.copy_with(fields)

    def with_law(self, name: str) -> "Scenario":
        """Return the scenario under another friction law, solved by the exact approach.

        The parameters come from the block of that law within the friction block, then from the
        keys shared with the law of the file. `omissions` lists what is left out; keys that the
        law does not use are not swept.

        Raises
        ------
        ScenarioError
            If a parameter is missing, or the parameters are inconsistent.
        """
        faults = law_faults(self.friction, name)
        problems = [self.problem(sentence, key) for key, sentence in faults]
        if not problems:
            used = tuple(axis for axis in self.sweep if law_uses_key(self, name, axis.key))
            closed = name in CLOSED_FORM_LAWS
            scene = self.copy_with(self._without(EXACT, used, closed, closed), law=name)
            problems = first_conflict(scene)
            if not problems:
                return scene
        file, count = self.origin["file"] or self.name, format_count(len(problems), "error")
        sentence = f"{file} under law {name}: {count}"
        raise ScenarioError(sentence, tuple(problems))

    def _without(
        self, approach: str, used: tuple[Axis, ...], directed: bool, stops: bool
    ) -> dict[str, Any]:
        """Return the fields that change for an approach that supports some features only."""
        fields: dict[str, Any] = {
            "solver": self.solver.model_copy(update={"approach": approach}),
            "sweep": used,
            "reference": None,
        }
        if not directed:
            fields["oscillator"] = self.oscillator.without_direction()
        if self.stroke is not None and not stops:
            fields["stroke"] = self.stroke.model_copy(update={"stops": None})
        return fields

    def variant(self, label: str) -> "Scenario":
        """Return the scenario for an approach or a friction law, by name.

        Raises
        ------
        ScenarioError
            As `with_law`; or if an approach of fixed steps lacks `solver.step`.
        """
        if label in LAWS:
            return self.with_law(label)
        if self.solver.step is None and needs_step(type(self.excitation), [label]):
            sentence = step_required(self.proposed_step, f" for {label}")
            raise self.error(sentence, ("solver", "step"))
        return self.with_approach(label)

    def omissions(self, label: str) -> tuple[str, ...]:
        """Return a message for everything that an approach or a law leaves out."""
        whose = law_omissions if label in LAWS else approach_omissions
        return tuple(whose(self, label))

    def resolved(self, relative_to: Path | None = None) -> dict[str, Any]:
        """Return the scenario as plain values in SI: those of a file with the same result.

        Paths of records are relative to the folder `relative_to`; default: that of this
        scenario.
        """
        values = self.model_dump(by_alias=True, exclude_none=True, mode="json")
        values["excitation"] = {"kind": self.excitation.kind} | values["excitation"]
        if self.fit is not None and relative_to is not None:
            if self.fit.measured is not None:
                values["fit"]["measured"]["file"] = self.fit.measured.file_from(relative_to)
            for curve, block in zip(
                self.fit.curves or (), values["fit"].get("curves", ()), strict=True
            ):
                block["file"] = curve.file_from(relative_to)
        if self.assess is not None and relative_to is not None:
            runs = self.assess.measured
            first, *more = [runs.of_file(file).file_from(relative_to) for file in runs.files]
            values["assess"]["measured"] |= {"file": first, "more_files": more}
        if isinstance(self.excitation, Record) and relative_to is not None:
            values["excitation"]["file"] = self.excitation.file_from(relative_to)
            conditions = self.design.conditions.axes if self.design else ()
            for axis in (*self.sweep, *conditions):
                if axis.key == FILE_KEY:
                    records = [self.excitation.with_file(file) for file in axis.values]
                    block = values["design"]["over"] if axis in conditions else values["sweep"]
                    block[FILE_KEY] = [record.file_from(relative_to) for record in records]
        conditions = self.design.conditions.axes if self.design else ()
        for axis in (*self.sweep, *conditions):
            if axis.source is not None and relative_to is not None:
                block = values["design"]["over"] if axis in conditions else values["sweep"]
                block = block.get(SAMPLE_KEY, block)
                block[FROM_FIT_KEY] = path_from(axis.source, relative_to)
        if self.friction is not None:
            values["friction"] = _friction_dict(self, self.friction, relative_to)
        for key in (*self.missing_values, *self.unstated_start, *self.missing_blocks):
            values = without_value(values, key.split("."))
        member = self.solver.member().model_dump(mode="json", exclude_none=True)
        solver = values["solver"] | {self.solver.approach: member}
        plain = {key: _without_tag(value, "approach") for key, value in solver.items()}
        values["solver"] = {key: value for key, value in plain.items() if value != {}}
        if self.step is not None and not self.sweep and self.design is None:
            values["solver"]["step"] = self.step  # a default may differ between cases
        if "oscillator" in self.missing_blocks:  # no motion is computed
            values = {k: v for k, v in values.items() if k not in ("start", "solver")}
        if self.sweep and counts_in_periods(file_block := self.file_block("measure")):
            values["measure"] |= file_block  # the period may differ between cases
        elif self.measure.steady:
            # Other keys have no effect on a steady state, or are not allowed.
            asked = {"steady", "direction", "weighting", "exposure"}
            values["measure"] = {k: v for k, v in values["measure"].items() if k in asked}
        return {key: value for key, value in values.items() if value not in ("", [], {})}


# Rules between the blocks of a scenario


def provides(scenario: Scenario, need: Need) -> bool:
    """Return whether a scenario states what some metrics need."""
    paths = (key.split(".") for key in need.keys)
    values = (getattr(getattr(scenario, block), name, None) for block, name in paths)
    return any(value is not None and value is not False for value in values)


def shows_peak_acceleration(scenario: Scenario) -> bool:
    """Return whether results show x_dd_peak: for a shock, and where a check names it."""
    shock = isinstance(scenario.excitation, Shock) or has_shock_spectrum(scenario.sweep)
    return shock or any(check.metric == "x_dd_peak" for check in scenario.checks)


def scene_period(scenario: Scenario) -> float | None:
    """Return the common period of base motion and normal force [s], or None."""
    return common_period(scenario.frequencies)


class Feature(NamedTuple):
    """Something that not every approach supports."""

    flag: str
    """Attribute of an approach that says whether it does."""
    fault: str
    """Message on a scenario that needs it, without the name of the approach."""
    omission: str
    """What the approach does in a comparison instead."""


END_STOPS = Feature(
    "supports_stops",
    "does not support end stops; remove them or choose stick-slip",
    "ignores end stops: the mass moves beyond the stroke limit",
)
DIRECTED_DAMPING = Feature(
    "supports_direction",
    "does not support damping that depends on direction; give one value or choose stick-slip",
    "uses the mean of oscillator.damping in both directions",
)
DIRECTED_FRICTION = Feature(
    "supports_direction",
    "does not support friction that depends on direction; give one value or choose stick-slip",
    "uses the mean of the friction forces in both directions",
)
STATIC_LIMIT = Feature(
    "supports_static",
    "does not support a static limit above kinetic friction; remove it or choose stick-slip",
    "has no static limit above kinetic friction and uses F_fs = F_fk",
)
OTHER_LAW = Feature(
    "supports_dynamic",
    "supports Coulomb friction only; choose law coulomb or approach stick-slip",
    "uses Coulomb friction with the forces of the law",
)
VARYING_FORCE = Feature(
    "supports_variation",
    "does not support a varying normal force; remove it or choose stick-slip",
    "uses a constant normal force",
)


def _unsupported_features(
    scenario: Scenario, member: type[Approach], swept: Collection[str] = ()
) -> Iterator[tuple[Feature, KeyPath]]:
    """Yield what an approach does not support, and its key; also if swept keys introduce it."""
    law, friction = scenario.nominal_law(), scenario.friction
    features: list[tuple[Feature, KeyPath]] = []
    if scenario.stops is not None:
        features.append((END_STOPS, ("stroke", "stops")))
    if scenario.oscillator.damping_pair is not None:
        features.append((DIRECTED_DAMPING, ("oscillator", "damping")))
    if friction is not None and member.supports_friction:
        if law.compression is not None:
            directed = isinstance(getattr(friction, "kinetic", None), ByDirection)
            features.append(
                (DIRECTED_FRICTION, ("friction", "kinetic" if directed else "static"))
            )
        if (
            law.F_fs > law.F_fk
            or scenario.static_interval
            or {*swept}.intersection(STATIC_PATHS)
        ):
            given = (key for key in STATIC_KEYS if getattr(friction, key, None) is not None)
            features.append((STATIC_LIMIT, ("friction", next(given, "static"))))
        if law.is_elastic or isinstance(law, DynamicLaw):
            features.append((OTHER_LAW, ("friction", LAW_KEY)))
        recorded = has_recorded_normal_force(friction)
        if law.variation or recorded or any(k.startswith(_VARIATION_PREFIXES) for k in swept):
            key = "normal_record" if recorded else "normal_variation"
            features.append((VARYING_FORCE, ("friction", key)))
    yield from (feature for feature in features if not getattr(member, feature[0].flag))


def unsupported_values(scenario: Scenario) -> Iterator[KeyFault]:
    """Yield the faults of values that the approach or the law does not support."""
    name, laws = scenario.solver.approach, ", ".join(CLOSED_FORM_LAWS)
    member = APPROACHES_BY_NAME[name]
    for feature, keys in _unsupported_features(scenario, member):
        yield keys, f"approach {name} {feature.fault}"
    if scenario.static_interval and scenario.sweep:
        yield from _swept_interval_faults(scenario)
    dynamic = isinstance(scenario.nominal_law(), DynamicLaw)
    if scenario.stops is not None:
        if member.supports_stops and dynamic:
            remedy = "choose one of them or remove the stops"
            yield ("stroke", "stops"), f"end stops support the laws {laws}; {remedy}"
        yield from _rigid_stop_faults(scenario, scenario.stops)
    if scenario.oscillator.damping_pair is not None and member.supports_direction and dynamic:
        remedy = "give one value or choose one of them"
        sentence = f"damping that depends on direction supports the laws {laws}; {remedy}"
        yield ("oscillator", "damping"), sentence


def _swept_interval_faults(scenario: Scenario) -> Iterator[KeyFault]:
    """Yield the faults of a sweep whose static ratio is an interval."""
    keys = {axis.key for axis in scenario.sweep}
    if DIRECTION_KEY in keys:
        sentence = "a sweep up or down cannot have an interval of friction.static_ratio"
        yield STATIC_RATIO, f"{sentence}; give one value"
    if scenario.reference:
        sentence = "friction.static_ratio cannot be an interval beside a reference approach"
        yield STATIC_RATIO, f"{sentence}; remove `reference`, or give one value"


def _rigid_stop_faults(scenario: Scenario, stops: Stops) -> Iterator[KeyFault]:
    """Yield the faults of rigid stops: unsupported law, start beyond a stop."""
    if stops.restitution is None or scenario.stroke is None:
        return
    law = scenario.nominal_law()
    if isinstance(law, PiecewiseLaw) and law.is_elastic and law.varies:
        sentence = "rigid stops do not go with an elastic contact under a varying normal force"
        yield ("stroke", "stops"), f"{sentence}; use bumpers (`stiffness`)"
    up, down = scenario.stroke.limits
    if not -down <= scenario.start.x_r <= up:
        within = f"between {-down:.12g} and {up:.12g} m"
        if up == down:
            within = f"within ±stroke.limit = ±{up:.12g} m"
        sentence = f"start.x_r must be {within} with rigid stops, not {scenario.start.x_r:.12g}"
        yield ("start", "x_r"), sentence


# The case at a point of a sweep

MAX_TRIED_POINTS = 10_000
"""Maximum number of points validated on loading; in larger grids each point is validated when
it is computed."""

RULE_GROUPS = (
    ("oscillator.",),
    ("friction.",),
    ("excitation.", "solver.", "measure.", "friction.normal_variation."),
    ("stroke.", "start."),
)
"""Groups of keys with rules between them; there are no rules between groups."""

MAX_CACHED_BLOCKS = 4096
"""Maximum number of cached blocks; the cases of a grid share most of them."""


def first_conflict(scenario: Scenario) -> list[Problem]:
    """Return the problem of the first inconsistent point of the sweep, as a list.

    Groups of keys with more than `MAX_TRIED_POINTS` points are not tried.
    """
    for group in RULE_GROUPS:
        axes = tuple(axis for axis in scenario.sweep if axis.key.startswith(group))
        if not axes or count_points(axes) > MAX_TRIED_POINTS:
            continue
        try:
            for point in iter_points(axes):
                scenario.at(point)
        except ScenarioError as fault:
            return [*fault.problems]
    return []


def _make_case(scenario: Scenario, point: Point) -> Scenario:
    """Return the case at a point; raise InvalidValue, with the whole key, on a conflict."""
    touched: dict[str, tuple[tuple[str, float], ...]] = {}
    for item in point.items():
        if item[0] == DIRECTION_KEY:
            continue
        name = item[0].partition(".")[0]
        touched[name] = (*touched.get(name, ()), item)
    fields: dict[str, Any] = {
        name: _cached_block(scenario, name, values)
        for name, values in touched.items()
        if name != "measure"
    }
    if any(check.conditions for check in scenario.checks):
        fields["checks"] = tuple(check.with_values(point) for check in scenario.checks)
    case = scenario.copy_with({"sweep": (), "reference": None, **fields})
    if touched.keys() & {"excitation", "solver"}:
        _check_step(case)
    if touched.keys() & {"measure", "excitation", "friction"}:
        case = _with_window(case, touched.get("measure", ()))
    if touched.keys() & {"friction", "stroke", "start"}:
        for keys, sentence in unsupported_values(case):
            raise InvalidValue(sentence, *keys)
        for key, sentence in law_faults(case.friction, case.compared_law):
            raise InvalidValue(sentence, *key.split("."))
    return case


def _cached_block(
    scenario: Scenario, name: str, values: tuple[tuple[str, float], ...]
) -> Block:
    """Return a block with other values in it, from the cache if possible."""
    block_cache = scenario.block_cache  # shared by threads: look up only once
    block = block_cache.get(values)
    if block is None:
        block = _validated_block(scenario, name, values)
        if len(block_cache) >= MAX_CACHED_BLOCKS:
            block_cache.clear()
        block_cache[values] = block
    return block


def _validated_block(
    scenario: Scenario, name: str, values: tuple[tuple[str, float], ...]
) -> Block:
    """Return a block with other values in it, validated."""
    old, block = getattr(scenario, name, None), dict[str, Any]()
    field = type(scenario).model_fields.get(name)
    model = next(iter(block_models(field.annotation) if field else []), None)
    if isinstance(old, Block):
        model, block = type(old), old.model_dump(by_alias=True, exclude_none=True)
    if model is None:
        raise InvalidValue(f"there is no block {name}", name)
    for key, value in values:
        block = _with_value(block, key.split(".")[1:], value, key)
    try:
        return model.model_validate(block, context={"folder": scenario.folder})
    except ValidationError as fault:
        for keys, sentence in validation_faults(fault, {name: block}, (name,)):
            raise InvalidValue(sentence, *keys) from None
        key = values[0][0]
        raise InvalidValue(f"there is no key {key} here", *key.split(".")) from None


def _with_field(block: Any, annotation: Any, steps: Sequence[str], value: Any) -> Any:
    """Return a copy of nested blocks with one value replaced, without validation."""
    if not steps:
        return value
    first, *rest = steps
    if isinstance(block, tuple):
        i = int(first)
        return (*block[:i], _with_field(block[i], None, rest, value), *block[i + 1 :])
    if block is None:
        only: Any = {first: value}
        return next(iter(block_models(annotation))).model_construct(**only)
    assert isinstance(block, Block), "a key leads through blocks and lists"
    fields = type(block).model_fields
    name = next(name for name, field in fields.items() if (field.alias or name) == first)
    inner = _with_field(getattr(block, name), fields[name].annotation, rest, value)
    return block.model_copy(update={name: inner})


def _with_value(block: Any, steps: list[str], value: float, key: str) -> Any:
    """Return a copy of nested values with one value replaced."""
    if not steps:
        raise InvalidValue(f"{key} is a block, not a number", *key.split("."))
    first, *rest = steps
    if isinstance(block, list | tuple):
        if not first.isdecimal() or int(first) >= len(block):
            raise InvalidValue(f"there is no {key}", *key.split("."))
        i = int(first)
        new = _with_value(block[i], rest, value, key) if rest else value
        return [*block[:i], new, *block[i + 1 :]]
    if not isinstance(block, Mapping):
        raise InvalidValue(f"there is no {key}", *key.split("."))
    old = block.get(first)
    if rest:
        inner = old if isinstance(old, Mapping | list | tuple) else {}
        return {**block, first: _with_value(inner, rest, value, key)}
    # An integer, such as a seed, is a float if it comes from an array.
    whole = type(old) is int and isinstance(value, float) and value.is_integer()
    return {**block, first: int(value) if whole else value}


def _check_step(case: Scenario) -> None:
    """Check that the step of the grid suits a generated base motion."""
    excitation, step = case.excitation, case.solver.step
    if isinstance(excitation, GeneratedMotion) and step:
        try:
            excitation.check_step(step)
        except InvalidValue as fault:
            raise InvalidValue(f"solver.step {fault}", "solver", "step") from None


def _with_window(case: Scenario, values: tuple[tuple[str, float], ...]) -> Scenario:
    """Return the case with its window recomputed for its own period."""
    frequencies, file_block = case.frequencies, case.file_block("measure")
    if not values and len(frequencies) < 2 and not counts_in_periods(file_block):
        return case
    times = {**file_block, **{key.partition(".")[2]: value for key, value in values}}
    steady = is_steady_by_default(case.excitation, case.friction)
    try:
        window = times_in_seconds(times, frequencies, steady)
    except InvalidValue as fault:
        raise InvalidValue(
            f"measure.{'.'.join(map(str, fault.path))} {fault}", "measure"
        ) from None
    return case.copy_with({"measure": type(case.measure).model_validate(window)})


def _locate(scenario: Scenario, point: Point, error: InvalidValue) -> Problem:
    """Return the located problem of inconsistent values."""
    key = ".".join(map(str, error.path))
    key = key if key in point else [*point][-1]
    axis = next((axis for axis in scenario.sweep if axis.key == key), None)
    keys: KeyPath = tuple(key.split("."))
    if axis is not None:
        ordered = not axis.is_random and point[key] in axis.values
        i = axis.values.index(point[key]) if ordered else ""
        keys = (*(axis.location or ("sweep", key)), i)
    where = ", ".join(
        f"{name} = {format_number(value, digits=12)}" for name, value in point.items()
    )
    return scenario.problem(f"{error} (at {where})", keys)


# The scenario under another approach, and what that approach leaves out

NO_STATIC_EXCESS = {"static": None, "mu_static": None, "static_ratio": 1.0}
"""Static limit equal to kinetic friction, for approaches that support no other."""


def _friction_for_approach(
    member: type[Approach], friction: Friction | None
) -> Friction | None:
    """Return the friction reduced to what an approach supports."""
    if friction is None or not member.supports_friction:
        return None
    if not isinstance(friction, Coulomb) and not member.supports_dynamic:
        shared = friction.model_dump(exclude_none=True, include=set(Coulomb.model_fields))
        friction = Coulomb(**shared | {"law": COULOMB})
    less: dict[str, Any] = {}
    if isinstance(friction, Coulomb) and not member.supports_direction:
        keys = ("kinetic", "static")
        less |= {key: mean_of_directions(getattr(friction, key)) for key in keys}
    if not member.supports_static and friction.static_given:
        less |= NO_STATIC_EXCESS
    if isinstance(friction, Coulomb) and not member.supports_variation:
        less["normal_variation"] = None
        if friction.normal_record is not None:
            less |= {"normal": friction.mean_normal_force, "normal_record": None}
    return friction.model_copy(update=less)


def approach_uses_key(name: str, key: str) -> bool:
    """Return whether an approach uses a key of the scenario."""
    member = APPROACHES_BY_NAME[name]
    if key == DIRECTION_KEY:
        return member.supports_friction
    block, option, *rest = key.split(".")
    if block == "friction":
        return (
            member.supports_friction
            and option not in LAWS  # options of another law
            and (member.supports_static or key not in STATIC_PATHS)
            and (member.supports_dynamic or option in Coulomb.model_fields)
            and (member.supports_variation or not key.startswith(_VARIATION_PREFIXES))
        )
    if block == "solver" and rest:
        return option == name
    return member.supports_stops or not key.startswith(_STOPS_PREFIX)


def approach_omissions(scenario: Scenario, name: str) -> Iterator[str]:
    """Yield a message for everything that an approach leaves out.

    An approach that supports no friction, `viscous`, is asked for because it leaves that out.
    """
    member = APPROACHES_BY_NAME[validate_approach(name)]
    swept = {axis.key for axis in scenario.sweep}
    for feature, _ in _unsupported_features(scenario, member, swept):
        yield f"{name} {feature.omission}"


# The scenario under another friction law, and what that law leaves out

COULOMB = "coulomb"
"""The law of approaches that support no other."""

NORMAL_FORCE_PREFIX = "normal_"
"""Prefix of the keys of a varying normal force, which are common to all laws."""


def law_uses_key(scenario: Scenario, name: str, key: str) -> bool:
    """Return whether a law uses a key of the scenario."""
    block, option, *_ = key.split(".")
    friction = scenario.friction
    if key.startswith(_STOPS_PREFIX) and name not in CLOSED_FORM_LAWS:
        return False
    if block != "friction" or friction is None or friction.law == name:
        return approach_uses_key(EXACT, key)
    return option == name or friction_uses_key(friction, name, option)


def law_omissions(scenario: Scenario, name: str) -> Iterator[str]:
    """Yield a message for everything that a law leaves out.

    The parameters specific to the law of the file are not listed.
    """
    friction, swept = scenario.friction, {axis.key for axis in scenario.sweep}
    if scenario.stops is not None and name not in CLOSED_FORM_LAWS:
        yield f"{name} {END_STOPS.omission}"
    if scenario.oscillator.damping_pair is not None and name not in CLOSED_FORM_LAWS:
        yield f"{name} {DIRECTED_DAMPING.omission}"
    if friction is None or friction.law == name:
        return
    if scenario.law().compression is not None:
        yield f"{name} {DIRECTED_FRICTION.omission}"
    fields = LAWS[name].model_fields
    used = {key.split(".")[1] for key in swept if key.startswith("friction.")}
    used |= {key for key, value in friction if value is not None}
    for key in sorted(used):
        if key.startswith(NORMAL_FORCE_PREFIX) and key not in fields:
            verb = "uses the mean of" if key == "normal_record" else "ignores"
            yield f"{name} {verb} friction.{key}"
    law, other = scenario.law(), scenario.with_law(name).law()
    if not fields.keys() & {*STATIC_KEYS} and law.F_fs > law.F_fk and other.F_fs == other.F_fk:
        yield f"{name} {STATIC_LIMIT.omission}"


# The resolved scenario as plain values


def _friction_dict(
    scenario: Scenario, friction: Friction, relative_to: Path | None
) -> dict[str, Any]:
    """Return the friction block; defaults that depend on swept keys are left open."""
    swept, still_open = {axis.key for axis in scenario.sweep}, set()
    if friction.normal is None and "oscillator.mass" in swept:
        still_open.add("normal")
    if not friction.static_given and swept.intersection(STATIC_PATHS):
        still_open.add("static_ratio")
    values = {
        key: _without_tag(value, LAW_KEY) if key in LAWS else value
        for key, value in friction.with_defaults(scenario.oscillator.mass).items()
        if key not in still_open
    }
    if relative_to is not None:
        options = ((getattr(friction, law, None), values.get(law, {})) for law in LAWS)
        for block, plain in ((friction, values), *options):
            if (force := getattr(block, "normal_record", None)) is not None:
                plain["normal_record"]["file"] = force.file_from(relative_to)
    return values


def _without_tag(value: Any, name: str) -> Any:
    """Return an options block without its tag, which repeats the key of the block."""
    if not isinstance(value, dict):
        return value
    return {key: option for key, option in value.items() if key != name}
