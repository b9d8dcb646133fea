"""`drysim bench` and `drysim bench --steady`: speed and error of every entry.

Without `--steady` all entries solve the same time history of each scenario, and are timed and
compared with the exact solution. With `--steady` the work is a sweep of steady states: the
exact approach computes all periodic orbits directly; the other entries integrate some of the
cases until they settle, and their last periods are compared with the orbits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

from drysim.approach import EXACT
from drysim.bench import score
from drysim.bench.scipy_ivp import reference_entry, second_run, unsupported_law
from drysim.bench.score import (
    EXACT_BELOW,
    Bench,
    BenchCase,
    ErrorPair,
    Reference,
    Score,
    verdict,
)
from drysim.bench.timing import (
    MIN_JOB_TIME,
    TIME_LIMIT,
    BenchOptions,
    Job,
    ReadyEntry,
    TimedEntry,
    time_entries,
    time_once,
    try_entry,
    try_within,
)
from drysim.bench.work import Answer, Entry, Work, make_work
from drysim.core.compile import MAX_PLAIN_STEPS, choose_engine, engine
from drysim.core.model import Sines, State
from drysim.errors import DrysimError, SolverError, UsageError, WarningMessage
from drysim.scenario.axes import count_points, iter_points
from drysim.scenario.load import load
from drysim.scenario.model import Scenario
from drysim.scenario.text import describe_axis, describe_scene
from drysim.study import gallery, run, sweep
from drysim.study.preparation import assemble, prepare, refuse_direction
from drysim.wording import format_number

if TYPE_CHECKING:
    from drysim.study.case import Case


BENCH_SCENARIOS = (
    ("paper-high-friction", ("excitation.frequency=2", "excitation.rms=0.75")),
    ("paper-random", ("friction.static_ratio=1.2", "excitation.rms=0.67")),
)
"""Scenarios of the gallery with changes: a sine with two stick phases per period, and noise
with friction of 45 N (kinetic) and 54 N (static)."""

STEADY_SCENARIOS = (("paper-low-friction", ()), ("paper-high-friction", ()))
"""The paper's Figs. 3 and 4."""


class PreparedBench(NamedTuple):
    """A benchmark to be run.

    Attributes
    ----------
    cases : list of dict
        Name, size and number of entries of every case.
    warnings : list of WarningMessage
    run : callable
        Runs the benchmark; calls its argument after every entry.
    """

    cases: list[dict[str, Any]]
    warnings: list[WarningMessage]
    run: Callable[[Job], Bench]


def load_scenarios(file: str | None, changes: Sequence[str], swept: bool) -> list[Scenario]:
    """Load the scenarios of a benchmark: the given file, else those of the gallery.

    Parameters
    ----------
    file : str or None
    changes : sequence of str
        Changes as KEY=VALUE.
    swept : bool
        Whether the benchmark is of steady states.

    Raises
    ------
    ScenarioError
        With all errors of a file.
    """
    if file is not None:
        return [load(file, list(changes))]
    scenarios = STEADY_SCENARIOS if swept else BENCH_SCENARIOS
    return [
        load(gallery.find(name).file, [*overrides, *changes]) for name, overrides in scenarios
    ]


def time_history_bench(inputs: Sequence[Scenario], options: BenchOptions) -> PreparedBench:
    """Prepare the benchmark of one time history per scenario."""
    works = [make_work(scenario, options.samples) for scenario in inputs]
    cases = [
        {"name": work.scenario.name, "samples": work.samples, "step": work.step,
         "entries": len(entries(work, options))}
        for work in works
    ]  # fmt: skip
    warnings = [warning for work in works for warning in work.warnings]
    return PreparedBench(cases, warnings, bench_runner(bench_case, works, options))


def steady_state_bench(inputs: Sequence[Scenario], options: BenchOptions) -> PreparedBench:
    """Prepare the benchmark of the steady states in the sweep of every scenario."""
    ready = [prepare_sweep(scenario) for scenario in inputs]
    cases = [
        {"name": case.scenario.name, "steady_states": count_points(case.scenario.sweep),
         "entries": count_entries(case, options)}
        for case in ready
    ]  # fmt: skip
    warnings = [warning for case in ready for warning in case.warnings]
    return PreparedBench(cases, warnings, bench_runner(steady_bench_case, ready, options))


def bench_runner(
    make_case: Callable[[Any, BenchOptions, Job], BenchCase],
    inputs: Sequence[object],
    options: BenchOptions,
) -> Callable[[Job], Bench]:
    """Return the function that runs a benchmark, with one case per input."""

    def run(finished: Job) -> Bench:
        choose_engine(MAX_PLAIN_STEPS + 1)
        cases = tuple(make_case(task, options, finished) for task in inputs)
        return Bench(cases, engine())

    return run


# Time histories.


def entries(work: Work, options: BenchOptions) -> list[Entry]:
    """Return all entries on a work: the exact one first, the reference last."""
    return with_peers(score.entries(work), work, options)


def with_peers(own_entries: Iterable[Entry], work: Work, options: BenchOptions) -> list[Entry]:
    """Return entries with those of all peers and the reference, if these support the law."""
    if unsupported_law(work.law):
        return list(own_entries)
    peers = (entry for peer in options.peers for entry in peer.entries(work))
    return [*own_entries, *peers, reference_entry()]


def bench_case(work: Work, options: BenchOptions, finished: Job) -> BenchCase:
    """Time and score all entries on one work.

    Parameters
    ----------
    work : Work
    options : BenchOptions
    finished : callable
        Called after the preparation of every entry.

    Raises
    ------
    SolverError
        If the exact approach fails; the failure of any other entry is its verdict.
    """
    all_entries, reference = entries(work, options), Reference.of(work)
    last = None if unsupported_law(work.law) else all_entries[-1]
    scores: list[Score] = []
    ready: list[TimedEntry] = []
    stated_error: float | None = None
    for entry in all_entries:
        prepared = try_entry(entry, work, options)
        scores.append(score_answer(entry, prepared, reference))
        if isinstance(prepared, ReadyEntry) and entry is last:
            scores[-1] = with_uncertainty(scores[-1], prepared, reference)
        # Only the score is kept, to free the memory of the answer.
        if isinstance(prepared, ReadyEntry):
            stated_error = prepared.answer.error if entry is all_entries[0] else stated_error
            ready.append(TimedEntry(prepared.run, prepared.once, scores[-1]))
        finished()
    lfilter_time, timed = time_entries(work, ready, options)
    timed_scores = iter(timed)
    scores = [next(timed_scores) if score.samples else score for score in scores]
    reference_score = scores[-1] if last else None
    scores[0] = score_exact(scores[0], reference_score, stated_error)
    warnings = (
        *work_warnings(work, all_entries),
        *reference_warnings(scores[0], reference_score),
    )
    scene = tuple(describe_work(work, lfilter_time))
    return BenchCase(
        work.scenario,
        work.motion,
        scene,
        tuple(scores),
        lfilter_time,
        reference_score,
        warnings,
    )


def describe_work(work: Work, lfilter_time: float) -> Iterator[tuple[str, str]]:
    """Yield labels and text that describe a work and the time of the filter."""
    yield from describe_scene(work.scenario, work.plant, work.law)
    yield "base", work.scenario.excitation.describe(work.motion)
    length = format_number(work.end, "s")
    yield (
        "work",
        f"{work.samples} samples of {format_number(work.step, 's')}: the first {length}",
    )
    yield describe_lfilter(lfilter_time)


def describe_lfilter(time: float) -> tuple[str, str]:
    """Return label and text of the time of the filter."""
    return "lfilter", f"{format_number(time, 'ns', 3)} per sample, the unit of all ratios"


def score_of(entry: Entry, samples: int = 0, verdict: str = "") -> Score:
    """Return a score of an entry with a verdict, without errors and times."""
    return Score(
        entry.approach, entry.setting, entry.by_drysim, entry.step, samples, verdict=verdict
    )


def score_answer(entry: Entry, prepared: ReadyEntry | str, reference: Reference) -> Score:
    """Return the score of an entry, without its time."""
    if isinstance(prepared, str):
        return score_of(entry, 0, f"failed, {prepared}")
    samples, scene = prepared.work.samples, (prepared.work, prepared.answer)
    try:
        errors = reference.errors(*scene)
    except DrysimError as fault:
        return score_of(entry, samples, f"failed, {fault}")
    symptoms = reference.symptoms(*scene)
    return replace(
        score_of(entry, samples, verdict(errors, symptoms, entry.other_law)),
        error_x_r=errors[0],
        error_T_a=errors[1],
        energy_residual=energy_residual_of(*scene),
    )


def with_uncertainty(score: Score, ready: ReadyEntry, reference: Reference) -> Score:
    """Return the score of the reference with its uncertainty from a second run.

    If both runs agree with each other but not with the exact approach, the verdict also has the
    numbers of stops.
    """
    second = try_within(lambda: second_run(ready.work), TIME_LIMIT)
    if isinstance(second, str):
        return replace(
            score, error_x_r=None, error_T_a=None, verdict=f"failed, second run: {second}"
        )
    score = replace(score, uncertainty=reference.max_difference(ready.answer, second))
    if score.in_doubt:
        return replace(score, verdict=f"in doubt, {describe_difference(score)}")
    stops, exact = ready.answer.stops, int((reference.stops <= ready.work.end).sum())
    if (score.error_x_r or 0.0) <= EXACT_BELOW or stops == exact or not ready.work.law.F_fk:
        return score
    return replace(score, verdict=f"{score.verdict}; {stops} stops, {exact} by stick-slip")


def energy_residual_of(work: Work, answer: Answer) -> float | None:
    """Return the relative residual of the energy balance of an answer [-], if computed."""
    from drysim.metrics.table import measure

    if answer.trajectory is None:
        return None
    return measure(answer.trajectory, (0.0, work.end), None)["energy_residual"]


def score_exact(
    exact: Score, reference_score: Score | None, stated_error: float | None = None
) -> Score:
    """Return the score of the exact approach, whose errors are those of the reference.

    Without a reference the verdict rests on its own error estimate, or on its energy balance.
    """
    errors: ErrorPair = None, None
    if reference_score is not None and reference_score.in_doubt:
        judged = f"in doubt, {describe_difference(reference_score)}"
    elif reference_score is not None and reference_score.error_x_r is not None:
        errors = reference_score.error_x_r, reference_score.error_T_a
        judged = verdict(errors, (False, False), False)
    elif stated_error is not None:
        errors = stated_error, None
        judged = verdict(errors, (False, False), False).partition(",")[0]
        judged += ", by its own error estimate"
    elif (exact.energy_residual or 0.0) <= EXACT_BELOW:
        judged = "exact by its energy balance"
    else:
        judged = "wrong, its energy balance is not closed"
    return replace(exact, error_x_r=errors[0], error_T_a=errors[1], verdict=judged)


def describe_difference(reference_score: Score) -> str:
    """Describe the difference of two runs of the reference."""
    off = format_number(100.0 * (reference_score.uncertainty or 0.0), "%", 2)
    return f"two runs of the reference differ by {off} of the peak of x_r"


def reference_warnings(exact: Score, reference_score: Score | None) -> Iterator[WarningMessage]:
    """Yield a warning if the reference itself may be inaccurate."""
    if reference_score is not None and reference_score.in_doubt:
        off = format_number(100.0 * (reference_score.error_x_r or 0.0), "%", 2)
        sentence = (
            f"the reference, {reference_score.approach} {reference_score.setting}, is in "
            f"doubt: {describe_difference(reference_score)}, the reference and "
            f"{exact.approach} by {off}; the error of {exact.approach} is unknown"
        )
        numbers = {
            "uncertainty": reference_score.uncertainty or 0.0,
            "error": reference_score.error_x_r or 0.0,
        }
        yield WarningMessage("reference-in-doubt", sentence, numbers)


def work_warnings(work: Work, all_entries: Sequence[Entry]) -> Iterator[WarningMessage]:
    """Yield the warnings on a scene and on approaches that leave something of it out."""
    yield from work.warnings
    for name in dict.fromkeys(entry.approach for entry in all_entries if entry.by_drysim):
        for sentence in work.scenario.omissions(name):
            yield WarningMessage("left-out", sentence)
    if what := unsupported_law(work.law):
        yield WarningMessage(
            "no-peers", f"no other program supports {what}: only drysim's approaches run"
        )


# Steady states.

SETTLING_PERIODS, SAMPLES_PER_PERIOD = 100, 256
"""Periods to settle, after which the start has no influence, and samples per period."""

MAX_CASES = 12
"""Maximum number of evenly spaced cases of a sweep that are integrated."""


@dataclass(frozen=True, eq=False)
class SteadyCase:
    """A case of a sweep.

    Attributes
    ----------
    work : Work
        The case from its start until it has settled.
    period : Work
        One period from a state on the orbit.
    orbit : Reference
        Exact solution of `period`.
    """

    work: Work
    period: Work
    orbit: Reference

    def last(self, answer: Answer) -> Answer:
        """Return the last period of an answer."""
        part = slice(-SAMPLES_PER_PERIOD - 1, None)
        return Answer(answer.x_r[part], answer.v_r[part], lambda: answer.friction()[part])


def steady_cases(case: Case) -> Iterator[SteadyCase]:
    """Yield evenly spaced cases of a sweep whose orbit has the period of the base."""
    from drysim.orbits.search import find_orbit

    motions, every = run.MotionCache.starting_with(case), list(iter_points(case.scenario.sweep))
    for i in range(min(MAX_CASES, len(every))):
        point = every[(2 * i + 1) * len(every) // (2 * min(MAX_CASES, len(every)))]
        scenario = case.scenario.at(point)
        prepared = assemble(scenario, motions.of(scenario))
        assert prepared.period is not None, "all cases of a steady sweep have a period"
        assert isinstance(prepared.motion, Sines), "only sines repeat"
        orbit = find_orbit(
            prepared.plant, prepared.law, prepared.motion, prepared.start, prepared.period
        )
        if orbit.settled and orbit.periods == 1:
            scene = (scenario, prepared.plant, prepared.law, prepared.motion)
            step = prepared.period / SAMPLES_PER_PERIOD
            period = Work(*scene, State(*orbit.state[:2]), step, SAMPLES_PER_PERIOD)
            work = Work(*scene, prepared.start, step, SETTLING_PERIODS * SAMPLES_PER_PERIOD)
            yield SteadyCase(work, period, Reference.of(period))


def follow_orbits(cases: Sequence[SteadyCase]) -> Score | None:
    """Return the errors of the reference over one period that begins on the orbit.

    Integration from the start may not have settled after `SETTLING_PERIODS`. An orbit to which
    the reference returns after one period is confirmed. None if the reference fails.
    """
    entry = reference_entry()
    score = Score(entry.approach, f"{entry.setting} from the orbit on", False, None, 0)
    errors, max_difference = [], 0.0
    try:
        for case in cases:
            answer = entry.ready(case.period)()
            errors.append(case.orbit.errors(case.period, answer))
            max_difference = max(
                max_difference, case.orbit.max_difference(answer, second_run(case.period))
            )
    except SolverError:
        return None
    off = max(error or 0.0 for error, _ in errors)
    T_a = max((error or 0.0 for _, error in errors), key=abs)
    score = replace(score, samples=SAMPLES_PER_PERIOD * len(errors), uncertainty=max_difference)
    return replace(score, error_x_r=off, error_T_a=T_a)


TRIAL_PERIODS, MAX_CASE_TIME, STEADY_TIME_LIMIT = 4, 8.0, 60.0
"""Periods of the trial run of a case, largest accepted estimate of its time [s], and time limit
of an entry [s]."""


def prepare_sweep(scenario: Scenario) -> Case:
    """Prepare a sweep of steady states without its reference approach.

    Raises
    ------
    UsageError
        If the scenario has no sweep or does not measure steady states.
    """
    refuse_direction(scenario, "drysim bench")
    case = prepare(scenario.copy_with({"reference": None}), compared=True)
    if not scenario.sweep or case.period is None:
        raise UsageError(
            f"{scenario.name} has no sweep of steady states",
            "use a scenario with a `sweep` block and `measure: {steady: true}`",
        )
    return case


def steady_entries(work: Work, options: BenchOptions) -> list[Entry]:
    """Return the integrating entries: drysim's at one step per sample, peers, the reference."""
    own_entries = (
        entry for entry in score.entries(work) if entry.points == 1 and entry.approach != EXACT
    )
    return with_peers(own_entries, work, options)


def count_entries(case: Case, options: BenchOptions) -> int:
    """Return the number of integrating entries of a sweep."""
    first = next(steady_cases(case), None)
    return 0 if first is None else len(steady_entries(first.work, options))


def steady_bench_case(case: Case, options: BenchOptions, finished: Job) -> BenchCase:
    """Time and score all entries on one sweep; parameters as of `bench_case`."""
    scenario, steady = case.scenario, list(steady_cases(case))
    works = [each.work for each in steady]
    all_entries = list(zip(*(steady_entries(work, options) for work in works), strict=True))
    tried = []
    for variants in all_entries:
        tried.append(try_steady_entry(variants, steady, options))
        finished()
    total = count_points(scenario.sweep)
    timed = [entry for entry in tried if isinstance(entry, TimedEntry)]
    lfilter_time, scores = time_entries(
        works[0], [time_orbit_search(case, total), *timed], options
    )
    reference_score = None if unsupported_law(case.law) else follow_orbits(steady)
    failed = [entry for entry in tried if isinstance(entry, Score)]
    scores = [score_exact(scores[0], reference_score), *scores[1:], *failed]
    scene = tuple(describe_steady_work(case, works, total, lfilter_time))
    warnings_of_work = work_warnings(works[0], [variants[0] for variants in all_entries])
    warnings = (*warnings_of_work, *reference_warnings(scores[0], reference_score))
    return BenchCase(
        scenario, None, scene, tuple(scores), lfilter_time, reference_score, warnings
    )


def describe_steady_work(
    case: Case, works: Sequence[Work], total: int, lfilter_time: float
) -> Iterator[tuple[str, str]]:
    """Yield labels and text that describe a sweep and the time of the filter."""
    scenario, varied = case.scenario, [axis.key for axis in case.scenario.sweep]
    shared = {
        "kinetic": len({work.law.F_fk for work in works}) < 2,
        "static": len({work.law.F_fs for work in works}) < 2,
    }
    yield from describe_scene(scenario, case.plant, case.law, varied, shared)
    yield "base", scenario.excitation.describe_cases(None, varied)
    for index, axis in enumerate(scenario.sweep):
        yield "" if index else "swept", describe_axis(axis)
    each = f"{SETTLING_PERIODS} periods of {SAMPLES_PER_PERIOD} samples"
    others = f"the others integrate up to {len(works)} cases"
    yield "work", f"{total} steady states, {each} each; {EXACT} finds all orbits, {others}"
    yield describe_lfilter(lfilter_time)


def time_orbit_search(case: Case, total: int) -> TimedEntry:
    """Return the search of all orbits including metrics, as in `drysim sweep`, to be timed."""

    def run() -> object:
        return sweep.solve(case, workers=1)

    run()
    _, once = time_once(run)
    samples = total * SETTLING_PERIODS * SAMPLES_PER_PERIOD
    return TimedEntry(run, once, Score(EXACT, "periodic orbits", True, None, samples))


def try_steady_entry(
    variants: Sequence[Entry], cases: Sequence[SteadyCase], options: BenchOptions
) -> TimedEntry | Score:
    """Integrate an entry through as many cases as time permits; return a score if it fails."""
    result = try_within(lambda: march_entry(variants, cases, options), STEADY_TIME_LIMIT)
    return score_of(variants[0], 0, f"failed, {result}") if isinstance(result, str) else result


def require_short_time(entry: Entry, work: Work) -> None:
    """Raise SolverError if a case would take too long, estimated from a few periods."""
    run = entry.ready(work.first(TRIAL_PERIODS * SAMPLES_PER_PERIOD))
    run()
    whole = time_once(run)[1] * SETTLING_PERIODS / TRIAL_PERIODS
    if whole > MAX_CASE_TIME:
        raise SolverError(f"a case would take about {format_number(whole, 's', 1)}")


def march_entry(
    variants: Sequence[Entry], cases: Sequence[SteadyCase], options: BenchOptions
) -> TimedEntry:
    """Integrate an entry through as many cases as time permits, and score the last periods."""
    first = variants[0]
    require_short_time(first, cases[0].work)
    _, once = time_once(first.ready(cases[0].work))
    count = max(
        1, min(len(cases), int(options.patience * len(cases) / max(once, MIN_JOB_TIME)))
    )
    runs = [entry.ready(scene.work) for entry, scene in zip(variants, cases, strict=True)][
        :count
    ]
    off, T_a, chatters, moves = 0.0, 0.0, False, False
    for scene, ready in zip(cases, runs, strict=False):
        last = scene.last(ready())
        error, case_error_T_a = scene.orbit.errors(scene.period, last)
        symptoms = scene.orbit.symptoms(scene.period, last)
        off, T_a = max(off, error or 0.0), max(T_a, case_error_T_a or 0.0, key=abs)
        chatters, moves = chatters or symptoms[0], moves or symptoms[1]
    judged = verdict((off, T_a), (chatters, moves), first.other_law)
    samples = count * SETTLING_PERIODS * SAMPLES_PER_PERIOD
    score = replace(score_of(first, samples, judged), error_x_r=off, error_T_a=T_a)
    return TimedEntry(lambda: [run() for run in runs], once * count, score)
