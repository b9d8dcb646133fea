"""Compare: the same base motion under several approaches and laws, and a verdict on each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from drysim.approach import SHELF
from drysim.errors import Caution, SolverError, UsageError
from drysim.quantity import near, short
from drysim.scenario.laws import LAWS
from drysim.study.case import prepare, require
from drysim.study.comparisons.comparison import Comparison
from drysim.study.comparisons.diagnosis import diagnose
from drysim.study.sweeps import survey
from drysim.study.sweeps.cases import case_at, response_of
from drysim.study.sweeps.gathering import table_of
from drysim.study.sweeps.rows import Rows
from drysim.study.sweeps.sweep import Finished, nothing, settle, solved
from drysim.study.sweeps.table import Row, Table
from drysim.study.sweeps.tally import Tally

if TYPE_CHECKING:
    from drysim.approach.response import Response
    from drysim.scenario import Scenario
    from drysim.study.case import Case

ALWAYS = "viscous"
"""The approach that is added to every comparison: the curve without dry friction."""

WORDS = (*SHELF, *LAWS)
"""What a comparison may name: an approach to the scene's law, or a law to be solved exactly."""


def named(words: str | Sequence[str]) -> tuple[str, ...]:
    """Give the approaches and laws that words name, in a list or in one text; `vs` is dropped.

    Raises
    ------
    UsageError
        When a word is neither, is named twice, or there are fewer than two.
    """
    given = [words] if isinstance(words, str) else words
    if not isinstance(given, Sequence) or not all(isinstance(word, str) for word in given):
        told = short(repr(words))
        raise UsageError(
            f"a comparison takes words, such as `signum vs stick-slip`, or a list, not {told}"
        )
    names = [name for word in given for name in word.split() if name != "vs"]
    for name in names:
        if name not in WORDS:
            nearest = near(name, WORDS)
            known = f"approaches are {', '.join(SHELF)}; laws are {', '.join(LAWS)}"
            hint = f"did you mean `{nearest}`?" if nearest else known
            if Path(name).suffix in (".yaml", ".yml"):
                hint = f"name a file by its option, `--scenario {name}`"
            raise UsageError(f"there is no approach or friction law `{name}`", hint)
        if names.count(name) > 1:
            raise UsageError(f"`{name}` is named twice", "compare it with another word")
    if len(names) < 2:
        others = ", ".join(name for name in WORDS if name not in names)
        raise UsageError(
            "a comparison needs two approaches or laws, such as `signum vs stick-slip`",
            f"add one of {others}",
        )
    return tuple(names)


def compare(
    scenario: Scenario,
    names: str | Sequence[str],
    *,
    workers: int | None = None,
    finished: Finished = nothing,
) -> Comparison:
    """Give what several approaches, or friction laws, make of one scenario.

    Parameters
    ----------
    scenario : Scenario
        With a sweep block, every case of it is compared.
    names : str or sequence of str
        Approaches and friction laws, such as `"signum vs stick-slip"` or a list of them; the
        last is the yardstick. `viscous` is added.
    workers : int, optional
        Threads.
    finished : callable, optional
        As in `sweep`.

    Returns
    -------
    Comparison

    Raises
    ------
    UsageError
        When a name is neither, stands there twice, or there are fewer than two; or when it is
        no scenario.
    ScenarioError
        When the scenario lacks a key of a law.
    """
    names = named(names)
    require(scenario)
    case = prepare(scenario.compared_by(names[-1]), compared=True)
    return solve(scenario, case, names, workers=workers, finished=finished)


def solve(
    scenario: Scenario,
    case: Case,
    names: Sequence[str],
    *,
    workers: int | None = None,
    finished: Finished = nothing,
) -> Comparison:
    """Compare where the yardstick's case is ready to be solved; otherwise as `compare` does."""
    yardstick, scenarios = names[-1], scenarios_of(scenario, names)
    compared = list(scenarios.values())
    settle(case, compared)
    batches = [batch for _, batch in solved(compared, case, workers, finished=finished)]
    tallies = Tally.of(batches, scenario.checks, yardstick)
    losses = [
        Caution("left-out", sentence)
        for name in scenarios
        for sentence in scenario.losses(name)
    ]
    table = table_of(scenario, case, Rows.of(batches), tallies, losses)
    shown = telling(table, names, yardstick)
    responses = dict(responses_at(shown.point, scenarios, yardstick))
    laws = {name: one.acting.law if one.acting else "" for name, one in scenarios.items()}
    bare = Comparison(table, yardstick, responses, shown.point, (), laws)
    return replace(bare, verdict=diagnose(bare, scenarios))


def scenarios_of(scenario: Scenario, names: Sequence[str]) -> dict[str, Scenario]:
    """Give the scenario by every word that is compared, `viscous` included."""
    every = dict.fromkeys((*names, ALWAYS))
    return {name: scenario.compared_by(name) for name in every}


def telling(table: Table, names: Sequence[str], yardstick: str) -> Row:
    """Give the yardstick's row at the worst case of the first word that is off it."""
    scale = Comparison(table, yardstick, {}, {}, ())
    for name in names:
        worst = survey.worst(survey.deviations(scale, name))
        if worst is not None and worst.value:
            return scale.counterpart(worst.row) or worst.row
    first = next(iter(table.of(names[0])))
    return scale.counterpart(first) or first


def responses_at(
    point: Mapping[str, float], scenarios: Mapping[str, Scenario], yardstick: str
) -> Iterator[tuple[str, Response]]:
    """Give the responses at one point; an approach whose numerics fail there has none.

    Raises
    ------
    SolverError
        When it is the yardstick that fails: there is nothing to compare with then.
    """
    for name, scenario in scenarios.items():
        try:
            yield name, response_of(case_at(scenario, point))
        except SolverError:
            if name == yardstick:
                raise
