"""Steady states against error: the orbits of a sweep, beside marching until they settle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from drysim import wording
from drysim.approach import EXACT
from drysim.errors import SolverError, UsageError
from drysim.scenario.sweep.axis import size as cases_of_grid
from drysim.study.bench import peers, shelf
from drysim.study.bench.attempt import Terms
from drysim.study.bench.clock import QUICKEST, Job, timed
from drysim.study.bench.judge import verdict
from drysim.study.bench.patience import tried
from drysim.study.bench.peers.scipy_ivp import reference
from drysim.study.bench.scores import Panel, Score
from drysim.study.bench.settling import A_PERIOD, PERIODS, Settling, followed, settlings
from drysim.study.bench.speed_error import cautions, doubts, held_to
from drysim.study.bench.timing import Tried, clocked
from drysim.study.bench.work import Work
from drysim.study.case import prepare
from drysim.study.sweeps import sweep
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.scenario import Scenario
    from drysim.study.bench.entry import Entry
    from drysim.study.case import Case

TASTE, TOO_LONG, HOPELESS = 4, 8.0, 60.0
"""Periods that tell how long a case would take [s], from where on that is too long [s], and
the time after which an entry has failed [s]."""


def cases_of(scenario: Scenario) -> Case:
    """Give a sweep of steady states, ready to be solved, its reference left aside.

    Raises
    ------
    UsageError
        When the scenario sweeps nothing, or measures no steady state.
    """
    case = prepare(scenario.copied({"reference": None}), compared=True)
    if not scenario.sweep or case.period is None:
        raise UsageError(
            f"{scenario.name} has no steady states to sweep",
            "name a scenario with a sweep block and `measure: {steady: true}`",
        )
    return case


def entries(work: Work, terms: Terms) -> list[Entry]:
    """Give what marches: the shelf at the step of the work, the peers, the reference last."""
    own = [one for one in shelf.entries(work) if one.points == 1 and one.approach != EXACT]
    if peers.unknown(work.law):
        return own
    return [*own, *(peers.entries(work) if terms.peers else ()), reference()]


def size(case: Case) -> int:
    """Give the number of steady states of a sweep."""
    return cases_of_grid(case.scenario.sweep)


def count(case: Case, terms: Terms) -> int:
    """Give the number of entries that march through a sweep."""
    known = next(settlings(case), None)
    return 0 if known is None else len(entries(known.work, terms))


def panel(case: Case, terms: Terms, finished: Job) -> Panel:
    """Give the scores on one sweep."""
    scenario, known = case.scenario, list(settlings(case))
    wanted = list(zip(*(entries(one.work, terms) for one in known), strict=True))
    tried = []
    for alike in wanted:
        tried.append(attempt(alike, known, terms))
        finished()
    total = size(case)
    marches = [one for one in tried if isinstance(one, Tried)]
    plain, scores = clocked(known[0].work, [search(case, total), *marches], terms)
    held = None if peers.unknown(case.law) else followed(known)
    failed = [one for one in tried if isinstance(one, Score)]
    scores = [held_to(scores[0], held), *scores[1:], *failed]
    words = tuple(words_of(case, [one.work for one in known], total, plain))
    said = cautions(known[0].work, [alike[0] for alike in wanted])
    warnings = (*said, *doubts(scores[0], held))
    return Panel(scenario, None, words, tuple(scores), plain, held, warnings)


def words_of(
    case: Case, works: Sequence[Work], total: int, plain: float
) -> Iterator[tuple[str, str]]:
    """Give in words what is solved, and how long the filter takes [ns]."""
    scenario, varied = case.scenario, [axis.key for axis in case.scenario.sweep]
    defaulted, terms = not scenario.static_given, scenario.terms
    shared = {
        "kinetic": len({work.law.F_fk for work in works}) < 2,
        "static": len({work.law.F_fs for work in works}) < 2,
    }
    yield from wording.scene(
        case.plant, case.law, defaulted, terms, varied, shared, scenario.ratios
    )
    yield "base", wording.excitations(scenario.excitation, varied)
    for at, axis in enumerate(scenario.sweep):
        yield "" if at else "swept", wording.swept(axis)
    each = f"{PERIODS} periods of {A_PERIOD} samples"
    others = f"the others march through up to {len(works)} of them"
    yield "work", f"{total} steady states, each as {each}; {EXACT} finds all orbits, {others}"
    yield "lfilter", f"{number(plain, 'ns', 3)} a sample: the time that ratios refer to"


def search(case: Case, total: int) -> Tried:
    """Give the search of all orbits, as `drysim sweep` does it, metrics included."""

    def run() -> object:
        return sweep.solve(case, workers=1)

    run()
    _, once = timed(run)
    samples = total * PERIODS * A_PERIOD
    return Tried(run, once, Score(EXACT, "periodic orbits", True, None, samples))


def attempt(alike: Sequence[Entry], known: Sequence[Settling], terms: Terms) -> Tried | Score:
    """March an entry through as many cases as patience allows; or say how it fails."""
    found = tried(lambda: marched(alike, known, terms), HOPELESS)
    if isinstance(found, Tried):
        return found
    first = alike[0]
    score = Score(first.approach, first.setting, first.own, first.step, 0)
    return replace(score, verdict=f"failed, {found}")


def refuse_the_hopeless(entry: Entry, work: Work) -> None:
    """Raise where a few periods show that a case would take too long."""
    run = entry.ready(work.first(TASTE * A_PERIOD))
    run()
    whole = timed(run)[1] * PERIODS / TASTE
    if whole > TOO_LONG:
        raise SolverError(f"a case would take some {number(whole, 's', 1)}")


def marched(alike: Sequence[Entry], known: Sequence[Settling], terms: Terms) -> Tried:
    """March an entry through as many cases as patience allows, and judge its last periods."""
    first = alike[0]
    refuse_the_hopeless(first, known[0].work)
    _, once = timed(first.ready(known[0].work))
    count = max(1, min(len(known), int(terms.patience * len(known) / max(once, QUICKEST))))
    runs = [one.ready(scene.work) for one, scene in zip(alike, known, strict=True)][:count]
    off, T_a, chatters, moves = 0.0, 0.0, False, False
    for scene, ready in zip(known, runs, strict=False):
        last = scene.last(ready())
        error, error_T_a = scene.orbit.errors(scene.period, last)
        symptoms = scene.orbit.symptoms(scene.period, last)
        off, T_a = max(off, error or 0.0), max(T_a, error_T_a or 0.0, key=abs)
        chatters, moves = chatters or symptoms[0], moves or symptoms[1]
    words = verdict((off, T_a), (chatters, moves), bool(first.lacks))
    samples = count * PERIODS * A_PERIOD
    score = Score(first.approach, first.setting, first.own, first.step, samples)
    score = replace(score, error_x_r=off, error_T_a=T_a, verdict=words)

    def all_runs() -> None:
        for one in runs:
            one()

    return Tried(all_runs, once * count, score)
