"""What a bench is asked: its scenarios, by default the paper's, and the job they make."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from drysim.core.compiled import PLAIN_STEPS, engine, settle
from drysim.scenario import Scenario, load
from drysim.study import gallery
from drysim.study.bench import peers, speed_error, steady
from drysim.study.bench.clock import Job
from drysim.study.bench.scores import Bench
from drysim.study.bench.work import work_of

if TYPE_CHECKING:
    from drysim.errors import Caution
    from drysim.study.bench.attempt import Terms
    from drysim.study.bench.scores import Panel

GALLERY = (
    ("paper-high-friction", ("excitation.frequency=2", "excitation.rms=0.75")),
    ("paper-random", ("friction.static_ratio=1.2", "excitation.rms=0.67")),
)
"""Scenarios of the gallery, and what is changed in them: a sine at which the mass sticks twice
a period, and noise under 45 N that is 54 N at rest."""

STEADY = (("paper-low-friction", ()), ("paper-high-friction", ()))
"""The paper's Figs. 3 and 4."""


class Asked(NamedTuple):
    """A bench that is ready to be run: its cases in words, and the work."""

    cases: list[dict[str, Any]]
    cautions: list[Caution]
    run: Callable[[Job], Bench]


def scenarios(file: str | None, changes: Sequence[str], swept: bool) -> list[Scenario]:
    """Give the scenarios to bench: the one named, else those of the gallery.

    Raises
    ------
    ScenarioError
        With every problem of a file.
    """
    if file is not None:
        return [load(file, list(changes))]
    known = STEADY if swept else GALLERY
    return [load(gallery.find(name).file, [*own, *changes]) for name, own in known]


def marching(asked: Sequence[Scenario], terms: Terms) -> Asked:
    """Give the bench of one motion a scenario."""
    works = [work_of(one, terms.samples) for one in asked]
    cases = [
        {"name": work.scenario.name, "samples": work.samples, "step": work.step,
         "entries": len(speed_error.entries(work, terms))}
        for work in works
    ]  # fmt: skip
    cautions = [caution for work in works for caution in work.cautions]
    return Asked(cases, cautions, held(speed_error.panel, works, terms))


def settling(asked: Sequence[Scenario], terms: Terms) -> Asked:
    """Give the bench of the steady states of every scenario's sweep."""
    ready = [steady.cases_of(one) for one in asked]
    cases = [
        {"name": case.scenario.name, "steady_states": steady.size(case),
         "entries": steady.count(case, terms)}
        for case in ready
    ]  # fmt: skip
    cautions = [caution for case in ready for caution in case.cautions]
    return Asked(cases, cautions, held(steady.panel, ready, terms))


def held(
    panel: Callable[[Any, Terms, Job], Panel], asked: Sequence[object], terms: Terms
) -> Callable[[Job], Bench]:
    """Give the function that holds a bench, a panel for each of what is asked."""

    def run(finished: Job) -> Bench:
        settle(PLAIN_STEPS + 1)
        panels = tuple(panel(one, terms, finished) for one in asked)
        return Bench(panels, peers.absent() if terms.peers else (), engine())

    return run
