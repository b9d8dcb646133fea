"""Rules on which keys of different blocks may occur together in a file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from drysim.approach import APPROACHES_BY_NAME, EXACT
from drysim.excitation import EXCITATIONS
from drysim.messages import format_value, name_hint
from drysim.metrics.table import METRICS
from drysim.scenario.keys import get_block, members_by_tag
from drysim.scenario.steps import needs_step, step_required
from drysim.yaml_document import KeyPath

KeyFault = tuple[KeyPath, str]
"""Key path and message of a fault."""

EXCITATIONS_BY_KIND = members_by_tag(EXCITATIONS)
"""Excitation classes by kind."""


def key_faults(
    document: Mapping[str, Any], proposal: float | None = None
) -> Iterator[KeyFault]:
    """Yield the faults of rules on which keys may occur together.

    `proposal` is a step for the message where one is missing.
    """
    kind = get_block(document, "excitation").get("kind")
    solver, reference = get_block(document, "solver"), document.get("reference")
    if kind in EXCITATIONS_BY_KIND:
        yield from _step_faults(solver, kind, reference, proposal)
        recorded = "normal_record" in get_block(document, "friction")
        yield from _measure_faults(get_block(document, "measure"), kind, recorded)
        yield from _until_faults(document)
    approach = solver.get("approach", EXACT)
    if reference is not None and "sweep" not in document:
        yield ("reference",), "reference requires a sweep"
    elif reference is not None and reference == approach:
        sentence = f"reference must differ from solver.approach, {approach}"
        yield ("reference",), f"{sentence} (--set reference=null)"
    member = APPROACHES_BY_NAME.get(approach) if isinstance(approach, str) else None
    if member is not None and "friction" in document and not member.supports_friction:
        yield (
            ("friction",),
            f"approach {approach} does not support friction; remove the block "
            "(--set friction=null) or choose stick-slip",
        )


def _step_faults(
    solver: Mapping[str, Any], kind: str, reference: object, proposal: float | None
) -> Iterator[KeyFault]:
    """Yield the faults of solver.step: a record has its own step, others may need one."""
    excitation = EXCITATIONS_BY_KIND[kind]
    names = (solver.get("approach", EXACT), reference)
    approaches = [name for name in names if isinstance(name, str)]
    if "step" not in solver and needs_step(excitation, approaches):
        yield ("solver", "step"), step_required(proposal)
    if excitation.has_own_step and "step" in solver:
        yield (
            ("solver", "step"),
            f"solver.step is not used: a {kind} has its own step; remove it",
        )


def _measure_faults(
    measure: Mapping[str, Any], kind: str, recorded: bool
) -> Iterator[KeyFault]:
    """Yield the faults of a measure block: steady state or time window."""
    steady, times = measure.get("steady"), {"settle", "duration"} & measure.keys()
    periodic = EXCITATIONS_BY_KIND[kind].periodic
    if steady is True and not periodic:
        others = [name for name, member in EXCITATIONS_BY_KIND.items() if member.periodic]
        sentence = f"measure.steady needs {' or '.join(others)} excitation, not {kind}"
        yield ("measure", "steady"), sentence
    elif steady is True and recorded:
        sentence = "measure.steady needs a periodic normal force, not a record"
        yield ("measure", "steady"), f"{sentence}; give measure.duration"
    elif steady is True:
        for key in ("settle", "duration"):
            if key in times:
                yield (
                    ("measure", key),
                    f"measure.{key} is not used with `steady: true`; remove one of them",
                )
    elif not EXCITATIONS_BY_KIND[kind].has_own_end and "duration" not in times:
        by_default = EXCITATIONS_BY_KIND[kind].steady_by_default and not recorded
        if not by_default or times or steady is False:
            other = ", or `steady: true`" if periodic and not recorded else ""
            yield ("measure", "duration"), f"measure.duration is required for {kind}{other}"


def _until_faults(document: Mapping[str, Any]) -> Iterator[KeyFault]:
    """Yield the fault of an `until` metric that is not available."""
    until = get_block(get_block(document, "excitation"), "until")
    name = until.get("metric")
    if not isinstance(name, str):
        return
    keys, unavailable = (
        ("excitation", "until", "metric"),
        f"excitation.until.metric: {format_value(name)} is not available",
    )
    metrics = {metric.name: metric for metric in METRICS}
    if name not in metrics:
        hint = name_hint(name, metrics)
        yield keys, f"{'.'.join(keys)}: unknown metric {format_value(name)}{hint}"
        return
    if name == "closure":
        yield keys, f"{unavailable} for random base motion, which has no periodic orbit"
    for need in metrics[name].needs:
        paths = (key.split(".") for key in need.keys)
        if not any(key in get_block(document, block) for block, key in paths):
            yield keys, f"{unavailable} without {need.name}; give {' or '.join(need.keys)}"
