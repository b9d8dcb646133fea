"""Diagnosis: what a comparison says in sentences, each decided by computing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import inf, log2
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from drysim.approach.numerics import FIXED_STEP
from drysim.approach.stick_slip import Exact
from drysim.study.comparisons.agreement import coinciding, range_of_agreement
from drysim.study.comparisons.comparison import Comparison
from drysim.study.sweeps.cases import Motions, attempted, case_at, response_of
from drysim.study.sweeps.doubts import at
from drysim.study.sweeps.survey import AGREE, deviations, worst
from drysim.study.sweeps.table import OK, Row
from drysim.wording import number, percent

if TYPE_CHECKING:
    from drysim.approach.response import Response
    from drysim.scenario import Scenario

CURED = 0.7
"""Share of an error that a halved step may leave to be a cure: first order leaves half."""

PARASITIC = -0.3
"""Correlation of neighbouring errors of x_dd below which they flip with every step."""

WANTED = 0.01
"""Error of T_a for which the needed sharpness is told [-]."""


AT_REST = "the base stands still"
"""Why a case that was solved has no T_a."""


def diagnose(comparison: Comparison, scenarios: Mapping[str, Scenario]) -> tuple[str, ...]:
    """Give the verdict on every approach that is not the yardstick, the worst first."""
    names = [name for name in scenarios if name not in (comparison.yardstick, "viscous")]
    found = [(worst(deviations(comparison, name)), name) for name in names]
    known = [(deviation, name) for deviation, name in found if deviation is not None]
    said: list[str] = []
    for deviation, name in sorted(known, key=lambda pair: -abs(pair[0].value)):
        said += sentences(comparison, scenarios, name, deviation.row, deviation.value)
    said += unknown(comparison, [name for deviation, name in found if deviation is None])
    said += coinciding(comparison)
    return (*said, *without_friction(comparison))


def sentences(
    comparison: Comparison,
    scenarios: Mapping[str, Scenario],
    name: str,
    row: Row,
    deviation: float,
) -> Iterator[str]:
    """Give what is to be said about one approach at the case where it deviates most."""
    yardstick, exact = comparison.yardstick, comparison.counterpart(row)
    place = at(row, comparison.table.axes)
    if same(scenarios[name], scenarios[yardstick]):
        law = comparison.laws[name]
        yield f"{name} is {yardstick} here: {law} is the law of the scene, solved by stick-slip"
        return
    if abs(deviation) <= AGREE:
        yield f"{name} agrees with {told(comparison)}: T_a {signed(deviation)}{place}"
    elif (doubt := doubtful(comparison)) or comparison.laws.get(name) == name:
        # A law is no error, whatever it changes; nor is what the yardstick may err in itself.
        yield f"{name} differs from {told(comparison)}: T_a {signed(deviation)}{place}{doubt}"
        yield from range_of_agreement(comparison, name)
    else:
        yield f"{name} is off: T_a {signed(deviation)} against {told(comparison)}{place}"
        yield from range_of_agreement(comparison, name)
    if exact is None or doubtful(comparison):
        return
    case = case_at(scenarios[name], row.point)
    response = response_of(case)
    if response.numerics.core != FIXED_STEP:
        return
    flipping = flips(response, response_of(scenarios[yardstick].at(exact.point)))
    if flipping < PARASITIC and abs(deviation) > AGREE:
        yield (
            f"the error of {name} is parasitic vibration of period 2Δt = "
            f"{number(2 * response.dt, 's')}: where the mass should stick, friction of "
            f"{number(row.F_fk, 'N')} flips with every step"
        )
    if abs(deviation) > WANTED:
        yield from remedy(case, name, deviation, first_T_a(exact))


def unknown(comparison: Comparison, names: Sequence[str]) -> Iterator[str]:
    """Say of which words T_a is held against no other, and why."""
    yardstick = comparison.yardstick
    if names and (reason := why_unknown(comparison, yardstick)):
        yield f"T_a of {yardstick}, the yardstick, is not known: {reason}"
        return
    for name in names:
        reason = why_unknown(comparison, name)
        where = f": {reason}" if reason else f" where that of {yardstick} is"
        yield f"T_a of {name} is not known{where}"


def why_unknown(comparison: Comparison, name: str) -> str:
    """Say why no case of a word has T_a; nothing where one has."""
    rows = list(comparison.table.of(name))
    if any(row.metrics.get("T_a") is not None for row in rows):
        return ""
    lost = (f"{row.status}; {row.note}".removesuffix("; ") for row in rows if row.status != OK)
    return next(lost, AT_REST)


def same(one: Scenario, other: Scenario) -> bool:
    """Tell whether two words of a comparison mean one law under one approach."""
    return one.solver.member() == other.solver.member() and one.acting == other.acting


def doubtful(comparison: Comparison) -> str:
    """Say why the yardstick proves no other wrong; nothing where it solves all of the scene."""
    yardstick, scenario = comparison.yardstick, comparison.table.scenario
    if losses := scenario.losses(yardstick):
        return f"; {'; '.join(losses)}"
    if not isinstance(scenario.compared_by(yardstick).solver.member(), Exact):
        return f"; {yardstick} marches by fixed steps, so that it may be off itself"
    return ""


def told(comparison: Comparison) -> str:
    """Give the yardstick; where laws are compared also the law of an approach."""
    yardstick, law = comparison.yardstick, comparison.laws.get(comparison.yardstick)
    tells = comparison.of_laws and law not in (None, "", yardstick)
    return f"{yardstick} ({law})" if tells else yardstick


def flips(response: Response, exact: Response) -> float:
    """Give the correlation of neighbouring errors of x_dd: -1 where they flip each step."""
    last = min(response.t[-1], exact.t[-1])
    t = response.t[response.t <= last]
    error = response.x_dd[: len(t)] - np.interp(t, exact.t, exact.x_dd)
    error -= error.mean()
    power = float(np.dot(error, error))
    return float(np.dot(error[1:], error[:-1])) / power if power else 0.0


def remedy(case: Scenario, name: str, deviation: float, T_a: float | None) -> Iterator[str]:
    """Say whether a smaller step or a sharper function helps, by trying it."""
    step, chosen = case.solver.step, case.solver.member()
    if step is not None:
        finer, halved = tried(case, {"step": 0.5 * step}, T_a), number(0.5 * step, "s")
        if cures(finer, deviation):
            yield f"halving the step of {name} leaves {signed(finer)}"
        elif finer is not None and abs(deviation) > AGREE:
            yield f"a smaller step will not help {name}: at {halved} T_a is {signed(finer)}"
    sharpness = getattr(chosen, "sharpness", None)
    if sharpness is not None:
        doubled = chosen.model_copy(update={"sharpness": 2 * sharpness})
        sharper, twice = tried(case, {name: doubled}, T_a), number(2 * sharpness, "s/m")
        if cures(sharper, deviation):
            order = log2(abs(deviation / sharper)) if sharper else inf
            needed = number(sharpness * (abs(deviation) / WANTED) ** (1 / order), "s/m", 2)
            share = percent(WANTED)
            yield f"{name} needs a sharpness of about {needed} for an error of {share}"
        elif sharper is not None and abs(deviation) > AGREE:
            yield f"a sharper {name} will not help: at {twice} T_a is {signed(sharper)}"


def cures(left: float | None, deviation: float) -> TypeGuard[float]:
    """Tell whether what a change leaves of a deviation is what first order leaves."""
    return left is not None and abs(left) <= CURED * abs(deviation)


def first_T_a(row: Row) -> float | None:
    """Give T_a of a case; of many seeds that of the first, which is tried."""
    return row.over.T_a[0] if row.over else row.metrics["T_a"]


def tried(case: Scenario, change: Mapping[str, Any], T_a: float | None) -> float | None:
    """Give the deviation from T_a of a case whose solver is changed; None where it fails."""
    solver = case.solver.model_copy(update=dict(change))
    changed = case.model_copy(update={"solver": solver})
    metrics, _, _ = attempted(changed, Motions().of)
    found = metrics.get("T_a")
    return found / T_a - 1.0 if found is not None and T_a else None


def without_friction(comparison: Comparison) -> Iterator[str]:
    """Say what dry friction does to the transmissibility, where one case is compared."""
    if comparison.table.axes or comparison.yardstick == "viscous":
        return
    by_name = {row.approach: row.metrics.get("T_a") for row in comparison.table.rows}
    bare, exact = by_name.get("viscous"), by_name.get(comparison.yardstick)
    if bare and exact and number(bare) != number(exact):
        yield f"without dry friction T_a would be {number(bare)} in place of {number(exact)}"


def signed(value: float) -> str:
    """Give a deviation in percent with its sign."""
    return f"{100 * value:+.3g} %"
