"""Scenario: the blocks of a file and the rules between them; its cases and variants."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction
from math import gcd, lcm
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, Union

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    GetJsonSchemaHandler,
    PlainSerializer,
    PlainValidator,
    StrictBool,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)
from pydantic_core import CoreSchema

from drysim.approach import EXACT, SHELF
from drysim.core.model import AnyLaw, Law, Pressed, Stopped
from drysim.errors import Problem, ScenarioError
from drysim.excitation import EXCITATIONS
from drysim.excitation.base import Generated
from drysim.excitation.recorded import Record
from drysim.friction import FRICTIONS, terms
from drysim.friction.coulomb import Coulomb
from drysim.metrics.checks import Check
from drysim.metrics.comfort import DIRECTIONS
from drysim.scenario import reading
from drysim.scenario.axes import KEY, Axis, Draw, Range, Sample, faults, points, size, spelled
from drysim.scenario.blocks import (
    FORMAT,
    FolderName,
    Format,
    FromFile,
    Oscillator,
    Solver,
    Start,
    Stops,
    Stroke,
    on_the_shelf,
    unmeasured,
    with_options,
)
from drysim.scenario.reading import BY_NAME, LAWS, block_in, models_in, sentences, tag_of
from drysim.scenario.sampling import Drawn
from drysim.units import NUMBER, Block, Misfit, Quantity, shown
from drysim.wording import number, several
from drysim.yaml_document import Keys

if TYPE_CHECKING:
    from drysim.excitation import Excitation
    from drysim.friction import Friction


# The types of fields that are derived from the shelves, and that of a check.


TOGETHER = "Keys that take their values side by side, as many each: one case for each place."

MOST_CHECKS = 1000
"""Checks of a scenario: more are no promises that anybody made."""


def shelf(members: tuple[type, ...], tag: str) -> Any:
    """Give the type that takes any member of a shelf, told apart by its tag."""
    union: Any = Union.__getitem__(members)
    return Annotated[union, Field(discriminator=tag)] if len(members) > 1 else union


if TYPE_CHECKING:
    from drysim.excitation import Excitation as Excitation
    from drysim.friction import Friction as Friction
    from drysim.scenario.blocks import Solver

    SolverBlock = Solver
else:
    Excitation = shelf(EXCITATIONS, "kind")
    Friction = shelf(FRICTIONS, "law")
    Solver = SolverBlock = with_options(SHELF)


def _parse(given: object) -> Check:
    """Give a check from its text."""
    if not isinstance(given, str | Check):
        raise ValueError(f"write `metric < value`, such as `T_a < 1.5`, not {shown(given)}")
    return given if isinstance(given, Check) else Check.parse(given)


CheckWords = Annotated[
    Check,
    PlainValidator(_parse),
    PlainSerializer(str),
    WithJsonSchema({"type": "string", "pattern": "^.*[<>=].*$", "examples": ["T_a < 1.5"]}),
]


def _few(given: object) -> object:
    """Refuse an endless list before any of it is read."""
    if isinstance(given, list | tuple) and len(given) > MOST_CHECKS:
        raise ValueError(f"must have {MOST_CHECKS} entries at most, not {len(given)}")
    return given


Checks = Annotated[tuple[CheckWords, ...], BeforeValidator(_few), Field(max_length=MOST_CHECKS)]


def _read_before(given: object) -> tuple[Axis, ...]:
    """Give the axes, which the loading has made: it knows every key of the scenario."""
    if not isinstance(given, tuple) or not all(isinstance(axis, Axis) for axis in given):
        raise ValueError("must be read from a file, whose keys it is about")
    return given


class _SweepSchema:
    """What the sweep block looks like to an editor."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Give the JSON schema: dotted keys, each with a list or a range."""

        def part(model: type[Block]) -> dict[str, Any]:
            return model.__get_pydantic_json_schema__(model.__pydantic_core_schema__, handler)

        values = {"type": "array", "minItems": 1, "items": {"type": ["number", "string"]}}
        axis = {"anyOf": [values, part(Range)]}
        walk = {"type": "object", "minProperties": 2, "patternProperties": {KEY: axis}}
        walk |= {"additionalProperties": False}
        several = {"type": "array", "minItems": 1, "items": walk}
        beside = {"description": TOGETHER, "anyOf": [walk, several]}
        sample = part(Sample)
        sample["properties"]["over"]["additionalProperties"] = part(Draw)
        return {
            "type": "object",
            "minProperties": 1,
            "properties": {"zip": beside, "sample": sample},
            "patternProperties": {KEY: axis},
            "additionalProperties": False,
            "examples": [{"excitation.frequency": {"from": 0.5, "to": 10, "step": 0.1}}],
        }


Sweep = Annotated[
    tuple[Axis, ...],
    PlainValidator(_read_before),
    PlainSerializer(spelled),
    _SweepSchema(),
]

ApproachName = Annotated[
    str, AfterValidator(on_the_shelf), WithJsonSchema({"enum": list(SHELF)})
]


# Measure: the window of the metrics, its times counted in seconds or in periods.


MOST_PERIODS = 10_000
"""Periods of the slowest sine in a common period; beyond it nothing repeats in practice."""

_PERIODS = re.compile(rf"\s*({NUMBER.pattern})\s*periods?\s*")


class Measure(Block):
    """The window of the metrics."""

    steady: StrictBool = False
    """Whether the metrics cover exactly one repetition of the periodic orbit that the start
    leads to; default: true for harmonic excitation without settle and duration."""
    settle: Annotated[float, Quantity("s", at_least=0)] = 0.0
    """Time before the window [s], or `20 periods`."""
    duration: Annotated[float, Quantity("s", above=0)] | None = None
    """Length of the window [s], or `20 periods`; default: to the end of the record."""
    direction: Literal["vertical", "horizontal"] | None = None
    """How the mass moves under a person who sits on it; chooses the weighting of ISO 2631-1 and
    its factor: vertical Wk with k = 1, horizontal Wd with k = 1.4 (recalled, not checked
    against the text of the standard). Asks for a_w, SEAT, VDV, SEAT_VDV, MTVV and
    crest_factor."""
    weighting: Literal["Wk", "Wd", "Wc"] | None = None
    """Frequency weighting of ISO 2631-1: alone it has k = 1; beside `direction` it must be that
    of the direction."""
    spectra: StrictBool = False
    """Whether a run gives the spectra of base and mass and the transmissibility H1 between
    them; for random base motion and records."""
    segment: Annotated[float, Quantity("s", above=0)] | None = None
    """Length of a segment of the spectra [s], whose lines are 1/segment apart; default: 8
    natural periods, but 5 s at least (longer where nothing rubs and the resonance is narrower
    than that resolves), and an eighth of the window at most."""

    @model_validator(mode="after")
    def _agree(self) -> Self:
        usual = DIRECTIONS[self.direction][0] if self.direction else self.weighting
        if self.weighting != usual and self.weighting:
            raise Misfit(
                f"must be {usual} beside `direction: {self.direction}`, not {self.weighting}; "
                "take one of both away",
                "weighting",
            )
        if self.segment is not None and not self.spectra:
            raise Misfit("has a meaning only beside `spectra: true`", "segment")
        return self

    @property
    def weights(self) -> tuple[str, float] | None:
        """Weighting and multiplying factor k [-] that are asked for."""
        if self.direction:
            return DIRECTIONS[self.direction]
        return (self.weighting, 1.0) if self.weighting else None


def steady_by_default(excitation: Excitation | None, friction: Friction | None) -> bool:
    """Tell whether a block without times means the steady state; a record never repeats."""
    recorded = getattr(friction, "normal_record", None) is not None
    return excitation is not None and excitation.steady_by_default and not recorded


def in_periods(given: Mapping[str, Any]) -> bool:
    """Whether the words of the block count any time in periods."""
    times = (given.get("settle"), given.get("duration"))
    return any(isinstance(time, str) and _PERIODS.fullmatch(time) for time in times)


def in_seconds(
    given: Mapping[str, Any], frequencies: tuple[float, ...] | None, steady: bool
) -> dict[str, Any]:
    """Give the words of the block with its default and with every time in seconds.

    Parameters
    ----------
    given : mapping
        As the scenario says it.
    frequencies : tuple of float or None
        What repeats [Hz]; None when a fault elsewhere keeps it unknown.
    steady : bool
        Whether a block without times means the steady state.

    Raises
    ------
    Misfit
        When there is no period to count with or to measure over.
    """
    words = dict(given)
    words.setdefault("steady", steady and not {"settle", "duration"} & words.keys())
    period = None if frequencies is None else common_period(frequencies)
    for key in ("settle", "duration"):
        count = _PERIODS.fullmatch(words[key]) if isinstance(words.get(key), str) else None
        if count and period is None and frequencies is not None:
            sentence = f"{shown(words[key])} needs a periodic base motion; give seconds"
            raise Misfit(sentence, key)
        if count:
            words[key] = float(count[1]) * (period or 1.0)
    if words["steady"] is True and period is None and frequencies:
        listed = " and ".join(f"{frequency:.12g} Hz" for frequency in frequencies[-2:])
        raise Misfit(
            f"needs a common period, and {listed} have none within {MOST_PERIODS} periods; "
            "give measure.settle and measure.duration",
            "steady",
        )
    return words


def common_period(frequencies: Iterable[float]) -> float | None:
    """Give the exact common period [s] of frequencies [Hz]; None when there is none.

    Notes
    -----
    A frequency beside others is taken as the decimal number that it is written as: 1.6 Hz and
    0.7 Hz repeat after 10 s exactly.
    """
    frequencies = tuple(frequencies)
    if len(frequencies) == 1:
        return 1.0 / frequencies[0]
    decimals = {Fraction(repr(frequency)) for frequency in frequencies}
    if not decimals:
        return None
    denominator = lcm(*(decimal.denominator for decimal in decimals))
    base = Fraction(gcd(*(int(decimal * denominator) for decimal in decimals)), denominator)
    return float(1 / base) if min(decimals) / base <= MOST_PERIODS else None


def period(scenario: Scenario) -> float | None:
    """Give the common period of base motion and normal force [s]; None when nothing repeats."""
    return common_period(scenario.frequencies)


def frequencies(excitation: Excitation | None, friction: Friction | None) -> tuple[float, ...]:
    """Give every frequency [Hz] of a scene whose base moves periodically."""
    found = excitation.frequencies if excitation else ()
    return (*found, *friction.frequencies) if found and friction else found


# Rules between the blocks of a scenario.


Fault = tuple[Keys, str]
STATIC = ("static", "static_ratio", "mu_static")
"""The keys that can put the static limit above kinetic friction."""

DEFAULT_APPROACH = Solver.model_fields["approach"].default
"""The approach of a scenario that names none."""

KINDS = {tag[1]: member for member in EXCITATIONS if (tag := tag_of(member))}
"""The excitations by name."""


def broken(words: Mapping[str, Any]) -> Iterator[Fault]:
    """Give the sentence for every rule on keys that is broken, and the keys to blame."""
    kind = block_in(words, "excitation").get("kind")
    if kind in KINDS:
        yield from _step(block_in(words, "solver"), kind)
        recorded = "normal_record" in block_in(words, "friction")
        yield from _measure(block_in(words, "measure"), kind, recorded)
        yield from unmeasured(words)
    yield from _reference(words)
    approach = block_in(words, "solver").get("approach")
    member = SHELF.get(approach) if isinstance(approach, str) else None
    if member is not None and "friction" in words and not member.use_friction:
        yield (
            ("friction",),
            f"approach {approach} has no use for friction; take the block away "
            "(--set friction=null) or choose stick-slip",
        )


def _reference(words: Mapping[str, Any]) -> Iterator[Fault]:
    """A reference is another approach beside a sweep."""
    reference = words.get("reference")
    approach = block_in(words, "solver").get("approach", DEFAULT_APPROACH)
    if reference is not None and "sweep" not in words:
        yield ("reference",), "reference has a meaning only beside sweep"
    elif reference is not None and reference == approach:
        sentence = f"reference must be another approach than solver.approach, {approach}"
        yield ("reference",), f"{sentence} (--set reference=null)"


def unused(scenario: Scenario) -> Iterator[Fault]:
    """Give the sentence for every value that the approach cannot use, and its keys."""
    name, law = scenario.solver.approach, scenario.outline()
    member, friction = SHELF[name], scenario.friction
    if scenario.stops is not None:
        yield from _stops(scenario, scenario.stops)
    if not member.use_friction or friction is None:
        return
    if law.F_fs > law.F_fk and not member.use_static:
        key = next(key for key in STATIC if getattr(friction, key, None) is not None)
        sentence = f"approach {name} has no use for a static limit above kinetic friction"
        yield ("friction", key), f"{sentence}; take it away or choose stick-slip"
    if not isinstance(law, Law | Stopped | Pressed) and not member.use_dynamic:
        sentence = f"approach {name} knows Coulomb's friction only"
        yield ("friction", "law"), f"{sentence}; choose law coulomb, or stick-slip"
    recorded = getattr(friction, "normal_record", None) is not None
    if (law.variation or recorded) and not member.use_variation:
        key = "normal_record" if recorded else "normal_variation"
        sentence = f"approach {name} has no use for a varying normal force"
        yield ("friction", key), f"{sentence}; take it away or choose stick-slip"


def _stops(scenario: Scenario, stops: Stops) -> Iterator[Fault]:
    """End stops want an approach and a law that know them, and a mass between them."""
    name, stroke = scenario.solver.approach, scenario.stroke
    assert stroke is not None, "stops are at the ends of a stroke"
    if not SHELF[name].use_stops:
        sentence = f"approach {name} has no use for end stops"
        yield ("stroke", "stops"), f"{sentence}; take them away or choose stick-slip"
    elif SHELF[name].use_friction and _parts(scenario):
        key = "normal_record" if _recorded(scenario) else "normal_variation"
        sentence = "end stops go with a normal force that stays above zero and is no record"
        yield ("stroke", "stops"), f"{sentence}; mend friction.{key}, or take them away"
    elif SHELF[name].use_friction and not isinstance(scenario.law(), Law | Stopped):
        sentence = "end stops go with Coulomb's friction only, not with this friction.law"
        yield ("stroke", "stops"), f"{sentence}; choose law coulomb, or take them away"
    if stops.restitution is not None and abs(scenario.start.x_r) > stroke.limit:
        sentence = (
            f"start.x_r must be at most stroke.limit = {stroke.limit:.12g} m in size, as rigid "
            f"stops let the mass no further, not {scenario.start.x_r:.12g}"
        )
        yield ("start", "x_r"), sentence


def _recorded(scenario: Scenario) -> bool:
    """Tell whether the normal force was recorded."""
    return getattr(scenario.acting, "normal_record", None) is not None


def _parts(scenario: Scenario) -> bool:
    """Tell whether surfaces may part, or follow a recorded normal force."""
    return _recorded(scenario) or isinstance(scenario.law(), Pressed)


def _step(solver: Mapping[str, Any], kind: str) -> Iterator[Fault]:
    """A record owns its step, everything else needs one."""
    own = KINDS[kind].own_step
    if not own and "step" not in solver:
        yield ("solver", "step"), "solver.step is required: distance of the output grid [s]"
    if own and "step" in solver:
        yield (
            ("solver", "step"),
            f"solver.step has no use here: a {kind} owns its step; remove it",
        )


def _measure(measure: Mapping[str, Any], kind: str, recorded: bool) -> Iterator[Fault]:
    """Either one repetition of an orbit, or a window; under a recorded normal force that."""
    steady, times = measure.get("steady"), {"settle", "duration"} & measure.keys()
    periodic = KINDS[kind].periodic
    if steady is True and not periodic:
        others = [name for name, member in KINDS.items() if member.periodic]
        sentence = f"measure.steady needs {' or '.join(others)} excitation, not {kind}"
        yield ("measure", "steady"), sentence
    elif steady is True and recorded:
        sentence = "measure.steady needs a normal force that repeats, and a record does not"
        yield ("measure", "steady"), f"{sentence}; give measure.duration"
    elif steady is True:
        for key in ("settle", "duration"):
            if key in times:
                yield ("measure", key), f"measure.{key} has no use beside `steady: true`"
    elif not KINDS[kind].own_end and "duration" not in times:
        by_default = KINDS[kind].steady_by_default and not recorded
        if not by_default or times or steady is False:
            other = ", or `steady: true`" if periodic and not recorded else ""
            yield ("measure", "duration"), f"measure.duration is required for {kind}{other}"


# The same scene under another approach, and what that approach leaves out.


_STATIC = tuple(f"friction.{key}" for key in STATIC)
_VARIATIONS = ("friction.normal_variation.", "friction.normal_record.")
_STOPS = "stroke.stops."
EQUAL = {"static": None, "mu_static": None, "static_ratio": 1.0}
"""A static limit as an approach takes it that knows none above kinetic friction."""


def solved_by(scenario: Scenario, name: str) -> Scenario:
    """Give the scene solved by an approach; what it cannot use is gone, swept keys included.

    Raises
    ------
    ValueError
        When there is no such approach.
    """
    member, friction = SHELF[on_the_shelf(name)], scenario.friction
    if friction is not None and not member.use_friction:
        friction = None
    if friction is not None and not isinstance(friction, Coulomb) and not member.use_dynamic:
        friction = as_coulomb(friction)
    if friction is not None:
        less: dict[str, Any] = {}
        if not member.use_static and friction.static_given:
            less |= EQUAL
        if isinstance(friction, Coulomb) and not member.use_variation:
            less |= steady_load(friction)
        friction = friction.model_copy(update=less)
    changed: dict[str, Any] = {
        "solver": scenario.solver.model_copy(update={"approach": name}),
        "friction": friction,
        "sweep": tuple(axis for axis in scenario.sweep if approach_uses(name, axis.key)),
        "reference": None,
    }
    if scenario.stroke is not None and not member.use_stops:
        changed["stroke"] = scenario.stroke.model_copy(update={"stops": None})
    return scenario.copied(changed)


def steady_load(friction: Coulomb) -> dict[str, Any]:
    """Give what makes the normal force constant, at its mean."""
    record = friction.normal_record
    mean = {} if record is None else {"normal": record.pressure().mean, "normal_record": None}
    return {"normal_variation": None, **mean}


def as_coulomb(friction: Friction) -> Coulomb:
    """Give the forces of any law as Coulomb's."""
    words = friction.model_dump(exclude_none=True, include=set(Coulomb.model_fields))
    return Coulomb(**words | {"law": "coulomb"})


def approach_uses(name: str, key: str) -> bool:
    """Whether an approach has a use for a key of the scenario."""
    member = SHELF[name]
    if key.startswith("friction.") and not member.use_friction:
        return False
    if key.startswith(_STOPS) and not member.use_stops:
        return False
    if _is_option(key) or (key in _STATIC and not member.use_static):
        return False
    if _is_of_law(key) and not member.use_dynamic:
        return False
    if key.startswith(_VARIATIONS) and not member.use_variation:
        return False
    block, option, *rest = key.split(".")
    return not (block == "solver" and rest) or option == name


def _is_of_law(key: str) -> bool:
    """Whether a key belongs to a friction law and not to Coulomb's."""
    block, option, *_ = key.split(".")
    return block == "friction" and option not in Coulomb.model_fields


def _is_option(key: str) -> bool:
    """Whether a key belongs to a law that a block only has options for."""
    block, option, *_ = key.split(".")
    return block == "friction" and option in LAWS


def left_out_by_approach(scenario: Scenario, name: str) -> Iterator[str]:
    """Give a sentence for everything in the scene that an approach leaves out."""
    member, law = SHELF[on_the_shelf(name)], scenario.law()
    if scenario.stops is not None and not member.use_stops:
        yield f"{name} knows no end stops and lets the mass move on beyond the stroke limit"
    swept = {axis.key for axis in scenario.sweep}
    rubs = law.F_fk > 0 or any(key.startswith("friction.") for key in swept)
    if not member.use_friction:
        if rubs:
            yield f"{name} leaves the dry friction out"
        return
    if not member.use_static and (law.F_fs > law.F_fk or swept & set(_STATIC)):
        yield f"{name} knows no static limit above kinetic friction and takes F_fs = F_fk"
    if not isinstance(law, Law | Stopped | Pressed) and not member.use_dynamic:
        yield f"{name} knows Coulomb's friction only and takes the forces of the law as such"
    varies = isinstance(law, Pressed) or law.variation
    varies = varies or any(key.startswith(_VARIATIONS) for key in swept)
    if not member.use_variation and varies:
        yield f"{name} knows no varying normal force and takes it as constant"


# The case at a point of a sweep, made from the scenario without reading its file again.


FEW = 10_000
"""Points that are tried when a scenario is loaded; in a larger grid, each when it is met."""

BESIDE = (
    ("oscillator.",),
    ("friction.",),
    ("excitation.", "solver.", "measure.", "friction.normal_variation."),
    ("stroke.", "start."),
)
"""Keys between which there are rules; from group to group there are none."""

KEPT = 4096
"""Blocks that a scenario keeps: the cases of a grid share most of them."""

Point = Mapping[str, float]


class Odd(Exception):
    """A value that does not fit the others: its key and the sentence."""

    def __init__(self, key: str, sentence: str) -> None:
        super().__init__(sentence)
        self.key = key


def case_at(scenario: Scenario, point: Point) -> Scenario:
    """Give the case at a point; only the blocks that the point touches are checked again.

    Raises
    ------
    ScenarioError
        When the values of the point do not go together.
    """
    try:
        return _case(scenario, point)
    except Odd as odd:
        problem = _located(scenario, point, odd)
    name = scenario.origin["file"] or scenario.name
    raise ScenarioError(f"{name} is not a scenario yet: 1 problem", (problem,))


def in_conflict(scenario: Scenario, most: int = FEW) -> list[Problem]:
    """Give the problem of the first point whose values do not go together, if there is one.

    Where rules connect more than `most` points, none of them is tried.
    """
    for group in BESIDE:
        axes = tuple(axis for axis in scenario.sweep if axis.key.startswith(group))
        if not axes or size(axes) > most:
            continue
        try:
            for point in points(axes):
                case_at(scenario, point)
        except ScenarioError as fault:
            return [*fault.problems]
    return []


def _case(scenario: Scenario, point: Point) -> Scenario:
    """Give the case at a point, or what is odd about it."""
    touched: dict[str, tuple[tuple[str, float], ...]] = {}
    for item in point.items():
        name = item[0].partition(".")[0]
        touched[name] = (*touched.get(name, ()), item)
    changed: dict[str, Any] = {
        name: _block(scenario, name, values)
        for name, values in touched.items()
        if name != "measure"
    }
    if any(check.conditions for check in scenario.checks):
        changed["checks"] = tuple(check.based_on(point) for check in scenario.checks)
    case = scenario.copied({"sweep": (), "reference": None, **changed})
    if touched.keys() & {"excitation", "solver"}:
        _step_suits(case)
    if touched.keys() & {"measure", "excitation", "friction"}:
        case = _measured(case, touched.get("measure", ()))
    if touched.keys() & {"friction", "stroke", "start"}:
        for keys, sentence in unused(case):
            raise Odd(".".join(map(str, keys)), sentence)
        for key, sentence in faults(case.friction, case.named_law):
            raise Odd(key, sentence)
    return case


def _block(scenario: Scenario, name: str, values: tuple[tuple[str, float], ...]) -> Block:
    """Give a block of the scenario with other values in it; one that was made is kept."""
    kept = scenario.kept  # shared by threads: each takes its block by one look
    block = kept.get(values)
    if block is None:
        block = _made(scenario, name, values)
        if len(kept) >= KEPT:
            kept.clear()
        kept[values] = block
    return block


def _made(scenario: Scenario, name: str, values: tuple[tuple[str, float], ...]) -> Block:
    """Give a block of the scenario with other values in it, validated."""
    old, words = getattr(scenario, name, None), scenario.words_of(name)
    field = type(scenario).model_fields.get(name)
    models = models_in(field.annotation) if field else []
    model = type(old) if isinstance(old, Block) else next(iter(models), None)
    if model is None:
        raise Odd(name, f"there is no block {name}")
    for key, value in values:
        words = _with(words, key.split(".")[1:], value, key)
    try:
        return model.model_validate(words, context={"folder": scenario.folder})
    except ValidationError as fault:
        found = sentences(fault, {name: words}, (name,))
        for keys, sentence in found:
            raise Odd(".".join(map(str, keys)), sentence) from None
        raise Odd(values[0][0], f"{name} takes no {values[0][0]} here") from None


def _with(words: Any, steps: list[str], value: float, key: str) -> Any:
    """Give words with a value at the end of some steps; the old words are left alone."""
    if not steps:
        raise Odd(key, f"{key} is a block, not a number")
    first, *rest = steps
    if isinstance(words, list | tuple):
        if not first.isdecimal() or int(first) >= len(words):
            raise Odd(key, f"there is no {key}")
        i = int(first)
        new = _with(words[i], rest, value, key) if rest else value
        return [*words[:i], new, *words[i + 1 :]]
    if not isinstance(words, Mapping):
        raise Odd(key, f"there is no {key}")
    old = words.get(first)
    if rest:
        inner = old if isinstance(old, Mapping | list | tuple) else {}
        return {**words, first: _with(inner, rest, value, key)}
    # A whole number, such as a seed, may come as a float from an array.
    whole = type(old) is int and isinstance(value, float) and value.is_integer()
    return {**words, first: int(value) if whole else value}


def _step_suits(case: Scenario) -> None:
    """Make sure that the grid of the step can hold a generated base motion."""
    excitation, step = case.excitation, case.solver.step
    if isinstance(excitation, Generated) and step:
        try:
            excitation.check_step(step)
        except Misfit as fault:
            raise Odd("solver.step", f"solver.step {fault}") from None


def _measured(case: Scenario, values: tuple[tuple[str, float], ...]) -> Scenario:
    """Give the case with its window: periods counted anew, a common period looked for."""
    frequencies, spoken = case.frequencies, case.spoken("measure")
    if not values and len(frequencies) < 2 and not in_periods(spoken):
        return case
    words = {**spoken, **{key.partition(".")[2]: value for key, value in values}}
    steady = steady_by_default(case.excitation, case.friction)
    try:
        window = in_seconds(words, frequencies, steady)
    except Misfit as fault:
        raise Odd("measure", f"measure.{'.'.join(map(str, fault.at))} {fault}") from None
    return case.copied({"measure": type(case.measure).model_validate(window)})


def _located(scenario: Scenario, point: Point, odd: Odd) -> Problem:
    """Give the problem of values that do not go together, located at one of them."""
    key = odd.key if odd.key in point else [*point][-1]
    axis = next((axis for axis in scenario.sweep if axis.key == key), None)
    keys: Keys = tuple(key.split("."))
    if axis is not None:
        drawn = isinstance(axis.values, Drawn)
        i = "" if drawn or point[key] not in axis.values else axis.values.index(point[key])
        keys = (*(axis.place or ("sweep", key)), i)
    where = ", ".join(f"{name} = {number(value, digits=12)}" for name, value in point.items())
    return scenario.problem(f"{odd} (at {where})", keys)


# The same scene under another friction law, and what that law leaves out.


COULOMB = "coulomb"
"""The law beside which a mass may have end stops."""

LOAD = "normal_"
"""Beginning of the keys about a normal force that varies: of the scene, whatever the law."""


def acted_by(scenario: Scenario, name: str) -> Scenario:
    """Give the scene under a friction law; swept keys that the law has no use for are gone.

    Raises
    ------
    ScenarioError
        When a key of the law is missing, or its keys do not go together.
    """
    found = [*_faults(scenario, name)]
    if not found:
        solver = scenario.solver.model_copy(update={"approach": EXACT})
        axes = tuple(axis for axis in scenario.sweep if law_uses(scenario, name, axis.key))
        changed: dict[str, Any] = {"solver": solver, "sweep": axes, "reference": None}
        if scenario.stroke is not None and name != COULOMB:
            changed["stroke"] = scenario.stroke.model_copy(update={"stops": None})
        scene = scenario.copied(changed, law=name)
        found = in_conflict(scene)
        if not found:
            return scene
    file, count = scenario.origin["file"] or scenario.name, several(len(found), "problem")
    sentence = f"{file} is not a scenario for law {name} yet: {count}"
    raise ScenarioError(sentence, tuple(found))


def _faults(scenario: Scenario, name: str) -> Iterator[Problem]:
    """Give the located problem of everything that keeps a law from acting in a scene."""
    if scenario.friction is None:
        sentence = f"law {name} needs a friction block, which this scenario has not"
        yield scenario.problem(sentence, "friction")
        return
    for key, sentence in faults(scenario.friction, name):
        yield scenario.problem(sentence, key)


def law_uses(scenario: Scenario, name: str, key: str) -> bool:
    """Whether a law has a use for a key of the scenario."""
    block, option, *_ = key.split(".")
    friction = scenario.friction
    if key.startswith("stroke.stops.") and name != COULOMB:
        return False
    if block != "friction" or friction is None or friction.law == name:
        return approach_uses(EXACT, key)
    return option == name or reading.friction_uses(friction, name, option)


def left_out_by_law(scenario: Scenario, name: str) -> Iterator[str]:
    """Give a sentence for everything in the scene that a law leaves out.

    The keys that make another law what it is are not meant: nobody expects them to count.
    """
    friction = scenario.friction
    if scenario.stops is not None and name != COULOMB:
        yield f"{name} knows no end stops and lets the mass move on beyond the stroke limit"
    if friction is None or friction.law == name:
        return
    known = reading.LAWS[name].model_fields
    for key in sorted(_said(scenario, friction)):
        if key.startswith(LOAD) and key not in known:
            way = "takes its mean" if key == "normal_record" else "leaves it out"
            yield f"{name} has no use for friction.{key} and {way}"
    law, acting = scenario.law(), scenario.with_law(name).law()
    if not known.keys() & {*STATIC} and law.F_fs > law.F_fk and acting.F_fs == acting.F_fk:
        yield f"{name} knows no static limit above kinetic friction and takes F_fs = F_fk"


def _said(scenario: Scenario, friction: Friction) -> set[str]:
    """Give the keys of the friction block that count, given or swept."""
    swept = {
        axis.key.split(".")[1] for axis in scenario.sweep if axis.key.startswith("friction.")
    }
    return swept | {key for key, value in friction if value is not None}


# A scenario as plain words again: overrides and defaults spelled out.


def spelled_out(scenario: Scenario, relative_to: Path | None) -> dict[str, Any]:
    """Give the words of `Scenario.resolved`."""
    words = scenario.model_dump(by_alias=True, exclude_none=True, mode="json")
    if scenario.friction is not None:
        spelt = scenario.friction.spelled_out(scenario.oscillator.mass)
        words["friction"] = {
            key: _options(value, BY_NAME) if key in LAWS else value
            for key, value in spelt.items()
            if key not in _open(scenario)
        }
    words["excitation"] = {"kind": scenario.excitation.kind} | words["excitation"]
    if isinstance(scenario.excitation, Record) and relative_to is not None:
        words["excitation"]["file"] = scenario.excitation.file_from(relative_to)
    if scenario.friction is not None and relative_to is not None:
        options = {law: getattr(scenario.friction, law, None) for law in LAWS}
        blocks = [(scenario.friction, words["friction"])]
        blocks += [(one, words["friction"][law]) for law, one in options.items() if one]
        for block, block_words in blocks:
            force = getattr(block, "normal_record", None)
            if force is not None:
                block_words["normal_record"]["file"] = force.file_from(relative_to)
    member = scenario.solver.member().model_dump(mode="json", exclude_none=True)
    solver = words["solver"] | {scenario.solver.approach: member}
    plain = {key: _options(value, "approach") for key, value in solver.items()}
    words["solver"] = {key: value for key, value in plain.items() if value != {}}
    if scenario.sweep and in_periods(spoken := scenario.spoken("measure")):
        words["measure"] |= spoken  # the period may vary from case to case
    elif scenario.measure.steady:
        # The rest has no use beside a steady state.
        asked = {"steady", "direction", "weighting"}
        words["measure"] = {k: v for k, v in words["measure"].items() if k in asked}
    return {key: value for key, value in words.items() if value not in ("", [], {})}


def _open(scenario: Scenario) -> set[str]:
    """Give the defaults of the friction block that depend on what a sweep varies."""
    friction, swept = scenario.friction, {axis.key for axis in scenario.sweep}
    if friction is None:
        return set()
    left = set()
    if friction.normal is None and "oscillator.mass" in swept:
        left.add("normal")
    if not friction.static_given and swept & {f"friction.{key}" for key in STATIC}:
        left.add("static_ratio")
    return left


def _options(value: Any, name: str) -> Any:
    """Give the options of a member of a shelf without its name, which their key says."""
    if not isinstance(value, dict):
        return value
    return {key: option for key, option in value.items() if key != name}


# Scenario: everything that a scenario file says, checked and in SI.


class Scenario(FromFile):
    """A vibration isolator, how its base moves, and what is asked about it."""

    drysim: Format = FORMAT
    """Version of the file format."""
    name: FolderName = "scenario"
    """Name of the scenario and of its output folder; default: the name of the file."""
    about: str = ""
    """What it is about, in a sentence."""
    oscillator: Oscillator
    """Mass, spring and damper."""
    friction: Friction | None = None
    """Dry friction between mass and base; without this block there is none."""
    stroke: Stroke | None = None
    """How far the mass may move on its base."""
    start: Start = Field({}, validate_default=True)
    """The state at t = 0; default: at rest."""
    excitation: Excitation
    """How the base moves."""
    solver: SolverBlock = Field({}, validate_default=True)
    """How the motion is computed."""
    measure: Measure = Field({}, validate_default=True)
    """The window of the metrics."""
    sweep: Sweep = ()
    """What to vary: dotted keys of this file, each with a list of values, or with from, to and
    step or count. Every combination is a case; the first key varies fastest."""
    reference: ApproachName | None = None
    """Name of an approach that computes the sweep, too, as the curve to compare with."""
    checks: Checks = ()
    """Promises about metrics, such as `x_r_peak < 25 mm`; one that fails makes exit code 1."""

    @field_validator("solver")
    @classmethod
    def _step_suits(cls, solver: Solver, info: ValidationInfo) -> Solver:
        excitation = info.data.get("excitation")
        if solver.step is not None and isinstance(excitation, Generated):
            excitation.check_step(solver.step)
        return solver

    @field_validator("measure", mode="before")
    @classmethod
    def _measure_in_seconds(cls, given: object, info: ValidationInfo) -> object:
        if isinstance(given, Measure):
            given = given.model_dump(exclude_unset=True)
        if not isinstance(given, Mapping):
            return given
        excitation, friction = info.data.get("excitation"), info.data.get("friction")
        known = excitation is not None and "friction" in info.data
        steady = steady_by_default(excitation, friction)
        return in_seconds(given, frequencies(excitation, friction) if known else None, steady)

    def law(self) -> AnyLaw:
        """Give the friction as forces; none without a friction block; and the end stops.

        Raises
        ------
        RecordError
            When the normal force was recorded, and its record cannot be used.
        """
        friction = self.acting
        law = friction.limits(self.oscillator.mass) if friction else Law(0.0, 0.0)
        # Other laws beside stops are a fault, which is told once all is read.
        if self.stops is None or self.stroke is None or not isinstance(law, Law):
            return law
        return self.stops.between(law, self.stroke.limit)

    def outline(self) -> AnyLaw:
        """Give the friction as forces without reading a record: its force is the default."""
        friction = self.acting
        if friction is None or getattr(friction, "normal_record", None) is None:
            return self.law()
        bare = friction.model_copy(update={"normal_record": None})
        return bare.limits(self.oscillator.mass)

    @property
    def acting(self) -> Friction | None:
        """The friction that acts: of the file's law, or of the one that a comparison names."""
        if self.friction is None or not self.named_law:
            return self.friction
        return reading.acting(self.friction, self.named_law)

    @property
    def terms(self) -> tuple[str, ...]:
        """The name of a law other than Coulomb's, and its own keys that all cases share."""
        swept = {axis.key for axis in self.sweep}
        return tuple(terms(self.acting, swept)) if self.acting else ()

    @property
    def ratios(self) -> dict[str, float]:
        """What is given as a ratio, of damping and of friction forces, by its key."""
        given = {
            "damping_ratio": self.oscillator.damping_ratio,
            "static_ratio": getattr(self.acting, "static_ratio", None),
        }
        return {key: value for key, value in given.items() if value is not None}

    @property
    def word(self) -> str:
        """What a table calls the scenario by: its approach, or the law of a comparison."""
        return self.named_law or self.solver.approach

    @property
    def stops(self) -> Stops | None:
        """The end stops, if they are modelled."""
        return None if self.stroke is None else self.stroke.stops

    @property
    def static_given(self) -> bool:
        """Whether the static limit is known; without friction there is none to know."""
        return self.acting is None or self.acting.static_given

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Every frequency of the scene [Hz], if its base moves periodically."""
        return frequencies(self.excitation, self.acting)

    def at(self, point: Mapping[str, float]) -> Scenario:
        """Give the case at a point of the sweep: a scenario without one.

        Parameters
        ----------
        point : mapping
            Values in SI by dotted key; every other key keeps its value.

        Raises
        ------
        ScenarioError
            When the values do not go together; the sentence names the point.
        """
        return case_at(self, point)

    def with_approach(self, name: str) -> Scenario:
        """Give the same scene solved by another approach, without what it cannot use.

        What that is, `losses` says. Keys that the approach has no use for are not swept.
        """
        return solved_by(self, name)

    def with_law(self, name: str) -> Scenario:
        """Give the same scene under another friction law, solved exactly.

        Its keys are those of a block of its name in the friction block, and else those that it
        shares with the file's law. What it leaves out, `losses` says.

        Raises
        ------
        ScenarioError
            When a key is missing, or the keys do not go together.
        """
        return acted_by(self, name)

    def compared_by(self, word: str) -> Scenario:
        """Give the same scene by a word of a comparison, an approach or a law."""
        return self.with_law(word) if word in reading.LAWS else self.with_approach(word)

    def losses(self, word: str) -> tuple[str, ...]:
        """Give a sentence for everything in the scene that an approach or a law leaves out."""
        whose = left_out_by_law if word in reading.LAWS else left_out_by_approach
        return tuple(whose(self, word))

    def resolved(self, relative_to: Path | None = None) -> dict[str, Any]:
        """Give plain words, defaults and all, in SI: a scenario that runs as this one did.

        Parameters
        ----------
        relative_to : Path, optional
            Folder that the words will be written to; default: the folder of this scenario.
        """
        return spelled_out(self, relative_to)
