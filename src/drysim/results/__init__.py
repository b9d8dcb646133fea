"""Kinds of results: one file each, with all that is written, drawn and said of a result.

A result names its kind; `kind_of` returns it. To add a kind, write its file and name it in
`KINDS`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from drysim.errors import UsageError

if TYPE_CHECKING:
    from drysim.results.fields import Fields, Provenance
    from drysim.results.kind import Kind

KINDS: Mapping[str, str] = {
    "run": "run.RUN",
    "ensemble": "ensemble.ENSEMBLE",
    "sweep": "sweep.SWEEP",
    "comparison": "comparison.COMPARISON",
    "bench": "bench.BENCH",
    "hard": "hard.HARD",
    "fit": "fit.FIT",
    "assess": "assess.ASSESS",
    "design": "design.DESIGN",
    "branches": "branches.BRANCHES",
    "map": "regime_map.MAP",
}
"""Where each kind is defined: module and object. They are imported when they are needed: a
command has one kind of result."""


def kind_named(name: str) -> Kind:
    """Return a kind by its name."""
    module, defined = KINDS[name].split(".")
    kind: Kind = getattr(import_module(f"drysim.results.{module}"), defined)
    return kind


def kind_of(result: Any) -> Kind:
    """Return the kind of a result.

    Raises
    ------
    UsageError
        When it is no result.
    """
    name = getattr(result, "kind", "")
    if name not in KINDS:
        raise UsageError(
            f"expected a result, not {type(result).__name__}",
            "pass what drysim.run, sweep, compare, fit, assess, design, branches or "
            "map_regimes returned",
        )
    return kind_named(name)


def all_kinds() -> Iterator[Kind]:
    """Yield all kinds."""
    return map(kind_named, KINDS)


def fields_of(result: Any, provenance: Provenance) -> Fields:
    """Return the content of drysim.json."""
    from drysim.results.fields import sanitise
    from drysim.study.summary import as_fields

    kind = kind_of(result)
    summary = sanitise(as_fields(kind.summary(result)))
    return {**kind.fields(result, provenance), "summary": summary}
