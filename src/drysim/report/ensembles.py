"""Files of many seeds: a row for each seed, and what drysim.json says of all of them."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drysim.metrics import BOUNDED, COMFORT, UNITS
from drysim.report.cells import joined
from drysim.report.rows import known
from drysim.report.sidecar import Ending, Fields, excitation, framed
from drysim.report.tables import STROKE, VIOLATION, heading, write
from drysim.scenario.seeds import SEED
from drysim.study.ensembles.seeds import until_of
from drysim.study.ensembles.statistics import CONFIDENCE, QUANTILES
from drysim.study.hashes import sha256_together
from drysim.study.sweeps.table import OK

if TYPE_CHECKING:
    from drysim.study.ensembles.ensemble import Ensemble
    from drysim.study.ensembles.statistics import Statistic

HEADING = f"{SEED} [-]"


def ensemble(made: Ensemble, folder: Path) -> None:
    """Write ensemble.csv: every metric of every seed, and the hash of its base motion.

    Parameters
    ----------
    made : Ensemble
    folder : Path
        Where to write.
    """
    left_out = {"closure"}
    left_out |= set() if made.scenario.measure.weights else {*COMFORT}
    left_out |= set() if made.scenario.stops else {*BOUNDED}
    names = [name for name in UNITS if name not in left_out]
    headings = [HEADING, *map(heading, names), "status", "sha256"]
    columns = [
        map(str, made.seeds),
        *known(made.rows, names),
        [row.status for row in made.rows],
        [row.sha256 for row in made.rows],
    ]
    write(folder / "ensemble.csv", headings, [joined(columns)])


def stroke_violations(made: Ensemble, folder: Path) -> None:
    """Write stroke_violations.csv: the seeds with which the stroke limit was met, if any."""
    rows = [row for row in made.rows if row.metrics.get("violations")]
    if rows:
        seeds = [str(row.seed) for row in rows]
        columns = [seeds, *known(rows, VIOLATION)]
        headings = [HEADING, *map(heading, STROKE)]
        write(folder / "stroke_violations.csv", headings, [joined(columns)])


def told(made: Ensemble, ending: Ending) -> Fields:
    """Give everything that made the numbers of an ensemble, ready for JSON.

    The metrics are means.
    """
    residual = made.statistics["energy_residual"]
    numerics = {
        **asdict(made.shown.response.numerics),
        "step": made.response.dt,
        "cases": len(made.rows),
        "energy_residual": residual and residual.greatest[0],
    }
    more = {"excitation": _drawn(made), "ensemble": _ensemble(made)}
    return framed(made, made.response.motion, numerics, made.metrics, ending, **more)


def _drawn(made: Ensemble) -> Fields:
    """Give the base motions; the hash is that of the hashes of all seeds, in order."""
    fields = excitation(made.scenario, made.response.motion)
    fields["sha256"] = sha256_together(row.sha256 for row in made.rows)
    return fields | {"seeds": len(made.rows), "sha256_of": "sha256 of every seed, one a line"}


def _ensemble(made: Ensemble) -> Fields:
    """Give the statistics of every metric that is known."""
    until = until_of(made.scenario)
    return {
        "seeds": len(made.rows),
        "first": made.seeds[0],
        "last": made.seeds[-1],
        "failed": sum(row.status != OK for row in made.rows),
        "until": until and until.model_dump(),
        "confidence": CONFIDENCE,
        "metrics": {
            name: _statistic(found)
            for name, found in made.statistics.items()
            if found is not None
        },
    }


def _statistic(found: Statistic) -> dict[str, Any]:
    """Give one statistic in words and numbers."""
    (least, at_least), (greatest, at_greatest) = found.least, found.greatest
    quantiles = {
        f"{100 * share:g} %": value
        for share, value in zip(QUANTILES, found.quantiles, strict=True)
    }
    return {
        "seeds": found.seeds,
        "mean": found.mean,
        "half_width": found.half_width,
        "std": found.std,
        "quantiles": quantiles,
        "least": {"value": least, "seed": at_least},
        "greatest": {"value": greatest, "seed": at_greatest},
    }
