"""Rules between the blocks of a scenario."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from drysim.approach import SHELF
from drysim.core.normal_force.normal import Pressed
from drysim.core.plant import Law, Stopped
from drysim.excitation import EXCITATIONS
from drysim.scenario.blocks import Solver, Stops
from drysim.scenario.seeds import unmeasured
from drysim.scenario.shape import block_in, tag_of
from drysim.source import Keys

if TYPE_CHECKING:
    from drysim.scenario.model import Scenario

Fault = tuple[Keys, str]
STATIC = ("static", "static_ratio", "mu_static")
"""The keys that can put the static limit above kinetic friction."""

DEFAULT = Solver.model_fields["approach"].default
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
    approach = block_in(words, "solver").get("approach", DEFAULT)
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
