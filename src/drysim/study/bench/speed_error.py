"""Speed against error: every entry timed and judged on the same work."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from drysim import wording
from drysim.errors import Caution, DrysimError
from drysim.study.bench import peers, shelf
from drysim.study.bench.attempt import HOPELESS, Runner, Terms, attempt
from drysim.study.bench.clock import Job
from drysim.study.bench.entry import Entry
from drysim.study.bench.judge import Yardstick, verdict
from drysim.study.bench.patience import tried
from drysim.study.bench.peers.scipy_ivp import checked, reference
from drysim.study.bench.scores import EXACT, Panel, Score
from drysim.study.bench.timing import Tried, clocked
from drysim.study.bench.work import Answer, Work
from drysim.wording import number


def entries(work: Work, terms: Terms) -> list[Entry]:
    """Give all entries on a work: the exact one first, the reference last."""
    known = not peers.unknown(work.law)
    others = peers.entries(work) if terms.peers and known else ()
    return [*shelf.entries(work), *others, *([reference()] if known else [])]


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
    last = None if peers.unknown(work.law) else wanted[-1]
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
    if (score.error_x_r or 0.0) <= EXACT or own == exact or not one.work.law.F_fk:
        return score
    return replace(score, verdict=f"{score.verdict}; {own} stops, {exact} by stick-slip")


def residual(work: Work, answer: Answer) -> float | None:
    """Give what the energy balance of an answer leaves [-], where it keeps one."""
    from drysim.metrics import measure

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
    closed = (exact.energy_residual or 0.0) <= EXACT
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
    if unknown := peers.unknown(work.law):
        yield Caution("no-peers", f"no peer knows {unknown}: none takes part")
