"""What jobs consist of: executors, parts that can be resumed, plans of dry runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from drysim.cli.job import Parts
from drysim.cli.process import Plan
from drysim.errors import UsageError
from drysim.scenario.text import describe_clean_up
from drysim.study.statistics import max_seeds, stopping_rule
from drysim.wording import (
    format_count,
    format_number,
    format_quantity,
    format_range,
    join_words,
)

if TYPE_CHECKING:
    from drysim.cli.job import Work
    from drysim.cli.process import OutputMode
    from drysim.scenario.model import Scenario
    from drysim.study.case import Case
    from drysim.study.design import DesignResult
    from drysim.study.fit_model import FitModel
    from drysim.study.plan import CaseRange
    from drysim.study.statistics import Batch
    from drysim.study.store import Store
    from drysim.study.sweep import Execute


def parts_of(name: str, case: Case, ranges: Sequence[CaseRange], resume: bool) -> Parts:
    """Return the parts of a sweep (`cases`) or of an ensemble (`seeds`)."""

    def finished(store: Store) -> tuple[int, int]:
        kept = [block.end - block.begin for block in ranges if store.has(block)]
        return sum(kept), len(kept)

    blocks = len(ranges) if name == "cases" else 0
    return Parts(name, case.scenario, resume, finished, blocks)


def design_parts(case: Case, resume: bool) -> Parts:
    """Return the parts of a design study.

    The number of evaluations may be raised when it is resumed: the first designs stay the same.
    """
    from drysim.scenario.design import MAX_EVALUATIONS
    from drysim.study.design import design_of

    any_number = design_of(case.scenario).model_copy(update={"evaluations": MAX_EVALUATIONS})
    scenario = case.scenario.copy_with({"design": any_number})
    return Parts(
        "designs",
        scenario,
        resume,
        finished=lambda store: (0, 0),
        count=lambda result: len(result.candidates),
    )


def count_batch(advance: Callable[[int], None], batch: Batch) -> None:
    """Advance the progress by the finished cases or seeds of a batch."""
    advance(len(batch))


@contextmanager
def case_executor(
    cluster: str | None,
    workers: int | None,
    mode: OutputMode,
    certificates: tuple[Path | None, Path | None, Path | None],
) -> Iterator[Execute]:
    """Yield the function that solves cases, on this machine or on a cluster.

    Raises
    ------
    UsageError
        When the options contradict each other, or no cluster answers at the address.
    """
    from drysim.study.sweep import on_cluster, on_workers

    if cluster is None:
        if any(certificates):
            raise UsageError(
                "the --tls options need a cluster", "add --cluster tls://host:8786"
            )
        with on_workers(workers) as execute:
            yield execute
        return
    from drysim.console import terminal
    from drysim.study.cluster import LOCAL, Certificates, connect

    if workers is not None and cluster != LOCAL:
        raise UsageError(
            "--workers cannot be combined with the address of a cluster",
            "a cluster has the workers that were started; --cluster local takes --workers",
        )
    all_certificates, warn = Certificates(*certificates), terminal.print_stderr
    with connect(cluster, workers, mode.print_status, warn, all_certificates) as client:
        yield on_cluster(client)


def solve_design(case: Case, work: Work) -> DesignResult:
    """Return the result of a design study; after an interrupt, that of the finished designs."""
    from drysim.study.design import Study

    study = Study(case, work.execute, work.store, work.advance)
    try:
        return study.solve()
    except KeyboardInterrupt:
        if not study.candidates:  # within the first round
            raise
        return study.partial()


def design_plan(case: Case, folder: Path) -> Plan:
    """Return what a design study would do."""
    from drysim.results.design import design_scene
    from drysim.scenario.axes import count_points
    from drysim.study.design import design_of

    scenario = case.scenario
    block, lines = (
        design_of(scenario),
        [f"{name}: {description}" for name, description in design_scene(case)],
    )
    conditions = count_points(scenario.sweep) if scenario.sweep else 1
    each = f"{format_count(conditions, 'condition')} with {describe_seeds(case) or '1 seed'}"
    fields = plan_fields(case, folder) | {
        "vary": [vary.key for vary in block.vary],
        "minimise": list(block.minimise),
        "evaluations": block.evaluations,
        "conditions": conditions,
    }
    first = f"{scenario.name}: at most {block.evaluations} designs, each under {each}"
    return Plan(fields, [first, *lines, *plan_sentences(case)[:1]], case.warnings)


def run_plan(case: Case, folder: Path) -> Plan:
    """Return what a run would do."""
    seeds = f"{many}, " if (many := describe_seeds(case)) else ""
    first, *rest = plan_sentences(case)
    sentences = [f"{case.scenario.name}: {seeds}{first}", *rest]
    return Plan(plan_fields(case, folder), sentences, case.warnings)


def fit_plan(model: FitModel, folder: Path) -> Plan:
    """Return what a fit would do."""
    record, free = model.measurement, [parameter.key for parameter in model.parameters]
    starts = model.starts()
    is_of_curves = model.fit.curves is not None
    source = (
        f"{format_count(len(record.t), 'value')} of curves"
        if is_of_curves
        else f"{len(record.t)} samples of {join_words(model.compared)}, "
        f"step {format_number(record.dt, 's')}"
    )
    sentences = [
        f"{model.scenario.name}: {join_words(free)} from {source}",
        "starts from "
        + ", ".join(
            f"{parameter.key} {format_quantity(value, parameter.unit, 3)}"
            for parameter, value in zip(model.parameters, starts[0], strict=True)
        ),
    ]
    fields = {
        "name": model.scenario.name,
        "free": free,
        "samples": len(record.t),
        "step": None if is_of_curves else record.dt,
        "channels": list(model.compared),
        "folder": folder.as_posix(),
        "warnings": [warning.sentence for warning in record.warnings],
    }
    return Plan(fields, sentences, record.warnings)


def assess_plan(scenario: Scenario, folder: Path) -> Plan:
    """Return what an assessment would evaluate."""
    from drysim.study import assess

    first_axis, others = assess.prepare_runs(scenario)
    runs = [*first_axis, *others]
    all_warnings = [
        *assess.records_warnings(runs, assess.segment_of(first_axis)),
        *assess.check_warnings(scenario),
    ]
    warnings = tuple({warning.sentence: warning for warning in all_warnings}.values())
    lines = [
        f"{run.name}: {format_count(len(run.measurement.t), 'sample')}, "
        f"step {format_number(run.measurement.dt, 's')}"
        for run in runs
    ]
    fields = {
        "name": scenario.name,
        "runs": [run.name for run in runs],
        "samples": [len(run.measurement.t) for run in runs],
        "model": runs[0].has_model,
        "folder": folder.as_posix(),
        "warnings": [warning.sentence for warning in warnings],
    }
    model = ", beside the model" if runs[0].has_model else ""
    first = f"{scenario.name}: {format_count(len(runs), 'record')} to evaluate{model}"
    return Plan(fields, [first, *lines], warnings)


def map_plan(case: Case, folder: Path) -> Plan:
    """Return what a regime map would do."""
    from drysim.results.regime_map import map_scene
    from drysim.study.regimes import require_map

    axes, grid = require_map(case.scenario)
    lines = [f"{name}: {description}" for name, description in map_scene(case)]
    fields = plan_fields(case, folder) | {
        "axes": [axis.key for axis in axes],
        "nodes": grid.nodes,
    }
    first = f"{case.scenario.name}: {grid.nodes} points, and those that trace the boundaries"
    return Plan(fields, [first, *lines], case.warnings)


def grid_plan(case: Case, approaches: Sequence[str], folder: Path) -> Plan:
    """Return what a sweep or a comparison would do, given its approaches or laws."""
    from drysim.scenario.axes import count_points

    scenario = case.scenario
    cases = count_points(scenario.sweep)
    swept = [f"{axis.key}: {len(axis.values)} values" for axis in scenario.sweep]
    each = f", each {seeds}" if (seeds := describe_seeds(case)) else ""
    what = f"{format_count(cases, 'case')} by {join_words(approaches)}{each}"
    first = f"{scenario.name}: {what}; {', '.join(swept) or 'no sweep'}"
    fields = plan_fields(case, folder) | {
        "cases": cases,
        "sweep": swept,
        "approaches": len(approaches),
    }
    return Plan(fields, [first, *plan_sentences(case)[1:]], case.warnings)


def plan_fields(case: Case, folder: Path) -> dict[str, object]:
    """Return the plan as JSON fields."""
    return {
        "name": case.scenario.name,
        "approach": case.approach.approach,
        "step": case.step,
        "steps": case.steps,
        "seeds": max_seeds(case.scenario),
        "window": list(case.window),
        "steady": case.period is not None,
        "clean_up": describe_clean_up(case.motion, case.law),
        "folder": folder.as_posix(),
        "warnings": [warning.sentence for warning in case.warnings],
    }


def plan_sentences(case: Case) -> list[str]:
    """Return the plan as text: time steps and window, base motion, cleaning of a record."""
    begin, end = case.window
    span = format_range(begin, end, "s")
    over = "one repetition of the periodic orbit" if case.period else span
    kind, steps = case.scenario.excitation.kind, describe_clean_up(case.motion, case.law)
    return [
        f"{case.steps} steps of {format_number(case.step, 's')} by {case.approach.approach}, "
        f"metrics over {over}",
        f"base: {describe_base(case)}",
        *(f"{kind}: {step}" for step in steps),
    ]


def describe_base(case: Case) -> str:
    """Describe the base motion; the RMS of a record shows whether its unit is right."""
    varied = [axis.key for axis in case.scenario.sweep]
    return case.scenario.excitation.describe_cases(case.motion, varied, case.records)


def describe_seeds(case: Case) -> str:
    """Describe the number of seeds; empty for a single one."""
    seeds = max_seeds(case.scenario)
    up_to = "up to " if stopping_rule(case.scenario) else ""
    return f"{up_to}{seeds} seeds" if seeds > 1 else ""
