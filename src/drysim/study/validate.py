"""All problems of a scenario, found without computing: `drysim validate`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from os import PathLike

from drysim.errors import Problem, RecordError, ScenarioError, UsageError, WarningMessage
from drysim.excitation.recorded import Record
from drysim.scenario.axes import SWEEP_KEY
from drysim.scenario.design import DESIGN_KEY
from drysim.scenario.load import NO_FILE, load
from drysim.scenario.load import scenario as make_scenario
from drysim.scenario.model import Scenario
from drysim.scenario.text import describe_clean_up
from drysim.study.preparation import prepare, without_fit_checks
from drysim.wording import format_count
from drysim.yaml_document import KeyPath, Overrides


def validate(
    source: str | PathLike[str] | Mapping[str, object] | Scenario, overrides: Overrides = ()
) -> tuple[Problem, ...]:
    """Return all problems of a scenario, without computing.

    Parameters
    ----------
    source : str, Path, mapping or Scenario
        A scenario file, the keys of one as nested mappings, or a scenario that was loaded.
    overrides : mapping or sequence of str
        As in `load`; none for a scenario that was loaded.

    Returns
    -------
    tuple of Problem
        Each with its `.sentence`, its place (`.file`, `.line`, `.column`) and its `.severity`:
        an `error`, for which `run`, or `fit` where values are to be fitted, refuses to compute,
        a `warning` or a `note`. Without errors the scenario runs.

    Raises
    ------
    UsageError
        If `source` or the overrides have another type.
    """
    file = NO_FILE if isinstance(source, Mapping | Scenario) else str(source)
    try:
        scenario = _load(source, overrides)
    except ScenarioError as fault:
        return fault.problems
    try:
        notes, warned = describe_scenario(scenario)
    except ScenarioError as fault:
        return fault.problems
    except RecordError as fault:
        return (fault.problem,)
    except UsageError as fault:
        return (Problem(str(fault), file),)
    return (
        *(Problem(note, file, severity="note") for note in notes),
        *dict.fromkeys(locate_warning(scenario, warning, file) for warning in warned),
    )


KEY = re.compile(r"\b[a-z]\w*(?:\.\w+)+")
"""A dotted key in a sentence."""

LISTED = ("checks.", "design.within.")
"""Keys of entries whose text may name other keys."""

MEASURED = "measured"
"""The channels of a fit or of an assessment."""

KEYS_BY_WARNING = {
    "will-not-move": "friction",
    "left-out": "solver.approach",
    "signum-chatters": "solver.approach",
    "smooth-stiff": "solver.approach",
    "looks-like-grams": "oscillator",
    "natural-frequency-high": "oscillator",
    "looks-like-degrees": "excitation",
    "coarse-weighting": "measure",
    "few-lines": "excitation.duration",
    "pulse-cut": "measure",
    "response-cut": "measure",
    "displacement-ends": "excitation.file",
    "coarse-record": "excitation.file",
    "sweep-changes-nothing": "sweep",
    "channels-suspect": MEASURED,
    "measurement-cut": MEASURED,
    "filters-differ": MEASURED,
}
"""Keys to look at for warnings whose sentences name none."""

RECORD_WARNING = "record-"
"""Begins the slugs of warnings about a record."""


def locate_warning(scenario: Scenario, warning: WarningMessage, file: str) -> Problem:
    """Return a warning as a problem at the key that it is about, if the file has its block."""
    document = scenario.document
    blocks = document.value if document else {}
    measured = "fit.measured" if scenario.fit else "assess.measured"
    record = "excitation.file" if "excitation" in blocks and not scenario.fit else measured
    key = KEYS_BY_WARNING.get(
        warning.slug, record if warning.slug.startswith(RECORD_WARNING) else ""
    )
    varied = varied_places(scenario)
    keys = [
        *(key for key in warning.numbers if key.startswith(LISTED)),
        *KEY.findall(warning.sentence),
        *warning.numbers,
        measured if key == MEASURED else key,
    ]
    for key in keys:
        path = varied.get(key, tuple(key.split(".")))
        if document is not None and path[0] in blocks:
            problem = document.locate(path, key=True).problem(warning.sentence, key)
            return replace(problem, severity="warning")
    return Problem(warning.sentence, file, severity="warning")


def varied_places(scenario: Scenario) -> dict[str, KeyPath]:
    """Return where the file has the values of each varied key."""
    axes, places = scenario.sweep, dict[str, KeyPath]()
    if scenario.design is not None:
        axes += scenario.design.conditions.axes
        places = {axis.key: (DESIGN_KEY, "vary", axis.key) for axis in scenario.design.vary}
    return places | {axis.key: axis.location or (SWEEP_KEY, axis.key) for axis in axes}


def _load(
    source: str | PathLike[str] | Mapping[str, object] | Scenario, overrides: Overrides
) -> Scenario:
    """Return a scenario, whatever it is given as."""
    if isinstance(source, Scenario):
        if overrides:
            raise UsageError("a scenario that was loaded takes no overrides")
        return source
    if isinstance(source, Mapping):
        return make_scenario(source, overrides)
    return load(source, overrides)


def describe_scenario(scenario: Scenario) -> tuple[list[str], list[WarningMessage]]:
    """Return what is read and cleaned up, and the warnings about a scenario.

    Raises
    ------
    RecordError, ScenarioError, UsageError
        When the scenario cannot be computed.
    """
    notes: list[str] = []
    warned: list[WarningMessage] = []
    if scenario.fit is not None:
        from drysim.study.fit import read_model

        model, is_of_curves = read_model(scenario), scenario.fit.curves is not None
        model.starts()
        measured = model.measurement
        span = f"{len(measured.t)} samples over {float(measured.t[-1] - measured.t[0]):.6g} s"
        channels = ", ".join(measured.channels)
        notes.append(
            f"measured: {format_count(len(measured.t), 'value')} of curves"
            if is_of_curves
            else f"measured: {channels}, {span}"
        )
        warned += measured.warnings
        scenario = without_fit_checks(scenario)
    if scenario.assess is not None:
        from drysim.study import assess

        runs, others = assess.prepare_runs(scenario)
        file = assess.base_file(scenario)
        on_base = f" on the base of {file}" if file else ""
        for run in (*runs, *others):
            t = run.measurement.t
            span = f"{len(t)} samples over {float(t[-1] - t[0]):.6g} s"
            notes.append(f"assessed: {run.name}{on_base}, {span}")
        notes += assess.describe_clean_ups([*runs, *others])
        warned += assess.records_warnings([*runs, *others], assess.segment_of(runs))
        warned += assess.check_warnings(scenario)
    cases = []
    if scenario.design is not None:
        from drysim.study.design import prepare_design

        cases.append(prepare_design(scenario))
    if not (scenario.missing_values or scenario.missing_blocks):
        cases.append(prepare(scenario, swept=bool(scenario.sweep), interval=True))
    is_described = scenario.assess is not None and scenario.assess.measured.u_dd is None
    for case in cases[:1]:  # the conditions of a design have all records
        motion = None if is_described else case.motion
        notes += describe_clean_up(motion, case.law, case.records)
        if isinstance(base := case.scenario.excitation, Record):
            varied = [axis.key for axis in case.scenario.sweep]
            notes.append(f"base: {base.describe_cases(case.motion, varied, case.records)}")
    warned += [warning for case in cases for warning in case.warnings]
    return notes, warned
