"""`drysim bench` and `drysim bench --steady`: speed against error of every entry.

A bench times and judges all entries on one motion a scenario. With `--steady` the work is a
sweep of steady states: the exact approach finds all orbits, the others march through some cases
until these settle, and their last periods are held to the orbits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

from drysim import wording
from drysim.approach import EXACT
from drysim.approach.stick_slip import StickSlip
from drysim.bench import score
from drysim.bench.scipy_ivp import checked, reference, unknown
from drysim.bench.score import EXACT_BELOW, Bench, Panel, Score, Yardstick, verdict
from drysim.bench.timing import (
    HOPELESS,
    QUICKEST,
    Job,
    Runner,
    Terms,
    Tried,
    attempt,
    clocked,
    timed,
    tried,
)
from drysim.bench.work import Answer, Entry, Work, work_of
from drysim.core.compile import PLAIN_STEPS, engine, settle
from drysim.core.model import Sines, State
from drysim.errors import Caution, DrysimError, SolverError, UsageError
from drysim.scenario.axes import points, size
from drysim.scenario.load import load
from drysim.scenario.model import Scenario
from drysim.study import gallery, run, sweep
from drysim.study.case import assemble, prepare
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.study.case import Case


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
         "entries": len(entries(work, terms))}
        for work in works
    ]  # fmt: skip
    cautions = [caution for work in works for caution in work.cautions]
    return Asked(cases, cautions, held(panel, works, terms))


def settling(asked: Sequence[Scenario], terms: Terms) -> Asked:
    """Give the bench of the steady states of every scenario's sweep."""
    ready = [cases_of(one) for one in asked]
    cases = [
        {"name": case.scenario.name, "steady_states": size(case.scenario.sweep),
         "entries": count(case, terms)}
        for case in ready
    ]  # fmt: skip
    cautions = [caution for case in ready for caution in case.cautions]
    return Asked(cases, cautions, held(steady_panel, ready, terms))


def held(
    panel: Callable[[Any, Terms, Job], Panel], asked: Sequence[object], terms: Terms
) -> Callable[[Job], Bench]:
    """Give the function that holds a bench, a panel for each of what is asked."""

    def run(finished: Job) -> Bench:
        settle(PLAIN_STEPS + 1)
        panels = tuple(panel(one, terms, finished) for one in asked)
        return Bench(panels, engine())

    return run


# One motion.


def entries(work: Work, terms: Terms) -> list[Entry]:
    """Give all entries on a work: the exact one first, the reference last."""
    own = list(score.entries(work))
    return own if unknown(work.law) else [*own, *others(work, terms), reference()]


def others(work: Work, terms: Terms) -> Iterator[Entry]:
    """Give the entries of all peers that take part."""
    for peer in terms.peers:
        yield from peer.entries(work)


def panel(work: Work, terms: Terms, finished: Job) -> Panel:
    """Give the scores on one work.

    Parameters
    ----------
    work : Work
    terms : Terms
    finished : callable
        Called when an entry has been made ready.

    Raises
    ------
    SolverError
        When the exact approach fails; whatever happens to another is its score.
    """
    wanted, yardstick = entries(work, terms), Yardstick.of(work)
    last = None if unknown(work.law) else wanted[-1]
    scores: list[Score] = []
    ready: list[Tried] = []
    stated: float | None = None
    for entry in wanted:
        one = attempt(entry, work, terms)
        scores.append(judged(entry, one, yardstick))
        if isinstance(one, Runner) and entry is last:
            scores[-1] = with_uncertainty(scores[-1], one, yardstick)
        # The answer itself, with all its points, is let go here.
        if isinstance(one, Runner):
            stated = one.answer.error if entry is wanted[0] else stated
            ready.append(Tried(one.run, one.once, scores[-1]))
        finished()
    plain, timed = clocked(work, ready, terms)
    in_turn = iter(timed)
    scores = [next(in_turn) if score.samples else score for score in scores]
    held = scores[-1] if last else None
    scores[0] = held_to(scores[0], held, stated)
    said = (*cautions(work, wanted), *doubts(scores[0], held))
    found = (tuple(scores), plain, held, said)
    return Panel(work.scenario, work.motion, tuple(words_of(work, plain)), *found)


def words_of(work: Work, plain: float) -> Iterator[tuple[str, str]]:
    """Give in words what every entry solves, and how long the filter takes [ns]."""
    defaulted, terms = not work.scenario.static_given, work.scenario.terms
    yield from wording.scene(work.plant, work.law, defaulted, terms)
    yield "base", wording.excitation(work.scenario.excitation, work.motion)
    length = number(work.end, "s")
    yield "work", f"{work.samples} samples of {number(work.step, 's')}, {length} from the start"
    yield "lfilter", f"{number(plain, 'ns', 3)} a sample: the time that ratios refer to"


def judged(entry: Entry, one: Runner | str, yardstick: Yardstick) -> Score:
    """Give the score of an entry, its time left open."""
    score = Score(entry.approach, entry.setting, entry.own, entry.step, 0)
    if isinstance(one, str):
        return replace(score, verdict=f"failed, {one}")
    score = replace(score, samples=one.work.samples)
    try:
        errors = yardstick.errors(one.work, one.answer)
    except DrysimError as fault:
        return replace(score, verdict=f"failed, {fault}")
    scene = (one.work, one.answer)
    words = verdict(errors, yardstick.symptoms(*scene), bool(entry.lacks))
    off, T_a = errors
    return replace(
        score, error_x_r=off, error_T_a=T_a, energy_residual=residual(*scene), verdict=words
    )


def with_uncertainty(score: Score, one: Runner, yardstick: Yardstick) -> Score:
    """Return the score of the reference with what a second run of it differs by.

    Where both runs agree, yet not with the exact approach, the verdict counts the stops, too.
    """
    again = tried(lambda: checked(one.work), HOPELESS)
    if isinstance(again, str):
        words = f"failed, its second run: {again}"
        return replace(score, error_x_r=None, error_T_a=None, verdict=words)
    score = replace(score, uncertainty=yardstick.apart(one.answer, again))
    if score.in_doubt:
        return replace(score, verdict=f"in doubt, {apart(score)}")
    own, exact = one.answer.stops, int((yardstick.stops <= one.work.end).sum())
    if (score.error_x_r or 0.0) <= EXACT_BELOW or own == exact or not one.work.law.F_fk:
        return score
    return replace(score, verdict=f"{score.verdict}; {own} stops, {exact} by stick-slip")


def residual(work: Work, answer: Answer) -> float | None:
    """Give what the energy balance of an answer leaves [-], where it keeps one."""
    from drysim.metrics.table import measure

    if answer.track is None:
        return None
    return measure(answer.track, (0.0, work.end), None)["energy_residual"]


def held_to(exact: Score, held: Score | None, stated: float | None = None) -> Score:
    """Give the score of the exact approach, whose errors are those of the reference.

    Without a reference the error that it states itself counts, and else its energy balance.
    """
    if held is not None and held.in_doubt:
        words = f"in doubt, {apart(held)}"
        return replace(exact, error_x_r=None, error_T_a=None, verdict=words)
    if held is not None and held.error_x_r is not None:
        off, T_a = held.error_x_r, held.error_T_a
        words = verdict((off, T_a), (False, False), False)
        return replace(exact, error_x_r=off, error_T_a=T_a, verdict=words)
    if stated is not None:
        word = verdict((stated, None), (False, False), False).partition(",")[0]
        words = f"{word}, by the error that it states"
        return replace(exact, error_x_r=stated, error_T_a=None, verdict=words)
    closed = (exact.energy_residual or 0.0) <= EXACT_BELOW
    words = "exact by its energy balance" if closed else "wrong, its energy balance is open"
    return replace(exact, error_x_r=None, error_T_a=None, verdict=words)


def apart(held: Score) -> str:
    """Say by how much two runs of a reference differ."""
    off = number(100.0 * (held.uncertainty or 0.0), "%", 2)
    return f"two runs of the reference differ by {off} of the peak of x_r"


def doubts(exact: Score, held: Score | None) -> Iterator[Caution]:
    """Warn where the reference is in doubt rather than the exact approach."""
    if held is not None and held.in_doubt:
        off = number(100.0 * (held.error_x_r or 0.0), "%", 2)
        sentence = (
            f"the reference, {held.approach} {held.setting}, is in doubt: {apart(held)}, "
            f"it and {exact.approach} by {off}; the error of {exact.approach} is not known here"
        )
        numbers = {"uncertainty": held.uncertainty or 0.0, "error": held.error_x_r or 0.0}
        yield Caution("reference-in-doubt", sentence, numbers)


def cautions(work: Work, wanted: Sequence[Entry]) -> Iterator[Caution]:
    """Give what is to be said about a scene, and about approaches that leave something out."""
    yield from work.cautions
    for sentence in dict.fromkeys(words for one in wanted if one.own for words in one.lacks):
        yield Caution("left-out", sentence)
    if what := unknown(work.law):
        yield Caution("no-peers", f"no peer knows {what}: none takes part")


# Steady states.

PERIODS, A_PERIOD = 100, 256
"""What settling takes: after so many periods of so many samples the start is forgotten."""

FEW = 12
"""Cases of a sweep, evenly spread, through which everything but the orbit search marches."""


@dataclass(frozen=True, eq=False)
class Settling:
    """A case of the sweep as work, one period of it, and the orbit that it must come to."""

    work: Work
    period: Work
    orbit: Yardstick

    def last(self, answer: Answer) -> Answer:
        """Give the last period of an answer."""
        part = slice(-A_PERIOD - 1, None)
        return Answer(answer.x_r[part], answer.v_r[part], lambda: answer.friction()[part])


def settlings(case: Case) -> Iterator[Settling]:
    """Give some cases of a sweep, evenly spread; those whose orbit takes one period."""
    motions, every = run.Motions.beginning_with(case), list(points(case.scenario.sweep))
    for at in range(min(FEW, len(every))):
        point = every[(2 * at + 1) * len(every) // (2 * min(FEW, len(every)))]
        own = case.scenario.at(point)
        found = assemble(own, motions.of(own))
        assert found.period is not None, "all cases of a steady sweep have a period"
        assert isinstance(found.motion, Sines), "only sines repeat"
        orbit = StickSlip().orbit(
            found.plant, found.law, found.motion, found.start, found.period
        )
        if orbit.settled and orbit.periods == 1:
            scene = (own, found.plant, found.law, found.motion)
            step = found.period / A_PERIOD
            period = Work(*scene, State(*orbit.state[:2]), step, A_PERIOD)
            work = Work(*scene, found.start, step, PERIODS * A_PERIOD)
            yield Settling(work, period, Yardstick.of(period))


def followed(known: Sequence[Settling]) -> Score | None:
    """Give the errors of the reference where it begins on the orbits and follows them once.

    What marches from the start may not have settled after all its periods; an orbit that the
    reference comes back to is one. None where the reference itself fails.
    """
    entry = reference()
    score = Score(entry.approach, f"{entry.setting} from the orbit on", False, None, 0)
    found, apart = [], 0.0
    try:
        for one in known:
            answer = entry.ready(one.period)()
            found.append(one.orbit.errors(one.period, answer))
            apart = max(apart, one.orbit.apart(answer, checked(one.period)))
    except SolverError:
        return None
    off = max(error or 0.0 for error, _ in found)
    T_a = max((error or 0.0 for _, error in found), key=abs)
    score = replace(score, samples=A_PERIOD * len(found), uncertainty=apart)
    return replace(score, error_x_r=off, error_T_a=T_a)


TASTE, TOO_LONG, STEADY_HOPELESS = 4, 8.0, 60.0
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


def steady_entries(work: Work, terms: Terms) -> list[Entry]:
    """Give what marches: the shelf at the step of the work, the peers, the reference last."""
    own = [one for one in score.entries(work) if one.points == 1 and one.approach != EXACT]
    return own if unknown(work.law) else [*own, *others(work, terms), reference()]


def count(case: Case, terms: Terms) -> int:
    """Give the number of entries that march through a sweep."""
    known = next(settlings(case), None)
    return 0 if known is None else len(steady_entries(known.work, terms))


def steady_panel(case: Case, terms: Terms, finished: Job) -> Panel:
    """Give the scores on one sweep."""
    scenario, known = case.scenario, list(settlings(case))
    wanted = list(zip(*(steady_entries(one.work, terms) for one in known), strict=True))
    tried = []
    for alike in wanted:
        tried.append(attempt_steady(alike, known, terms))
        finished()
    total = size(scenario.sweep)
    marches = [one for one in tried if isinstance(one, Tried)]
    plain, scores = clocked(known[0].work, [search(case, total), *marches], terms)
    held = None if unknown(case.law) else followed(known)
    failed = [one for one in tried if isinstance(one, Score)]
    scores = [held_to(scores[0], held), *scores[1:], *failed]
    words = tuple(steady_words(case, [one.work for one in known], total, plain))
    said = cautions(known[0].work, [alike[0] for alike in wanted])
    warnings = (*said, *doubts(scores[0], held))
    return Panel(scenario, None, words, tuple(scores), plain, held, warnings)


def steady_words(
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


def attempt_steady(
    alike: Sequence[Entry], known: Sequence[Settling], terms: Terms
) -> Tried | Score:
    """March an entry through as many cases as patience allows; or say how it fails."""
    found = tried(lambda: marched(alike, known, terms), STEADY_HOPELESS)
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
