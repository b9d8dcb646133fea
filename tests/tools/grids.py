"""Tables to be reported: real cases of the paper's oscillator on small grids."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import sqrt
from types import SimpleNamespace

from outcomes import PAPER, limits_of, record, stand_in

from drysim.approach.fixed_step import Signum, Smooth, Switch
from drysim.approach.stick_slip import ExactApproach, StickSlip, Viscous
from drysim.core.model import CoulombLaw, Sines, State
from drysim.metrics.table import METRICS, measure
from drysim.orbits.search import find_orbit
from drysim.scenario.axes import Axis
from drysim.study.compare import Comparison
from drysim.study.statistics import Row
from drysim.study.table import Table

FREQUENCY, RMS, FORCE = "excitation.frequency", "excitation.rms", "friction.kinetic"
UNITS = {FREQUENCY: "Hz", RMS: "m/s2", FORCE: "N"}
REST = State(0.0, 0.0)
UNKNOWN = {metric.name: None for metric in METRICS}
MEMBERS = {
    member.approach: member for member in (StickSlip(), Viscous(), Signum(), Smooth(), Switch())
}


def axes(**values):
    """Return swept keys by the names above."""
    keys = {"frequency": FREQUENCY, "rms": RMS, "force": FORCE}
    return tuple(
        Axis(keys[name], UNITS[keys[name]], tuple(map(float, column)))
        for name, column in values.items()
    )


def points(swept):
    """Return the points of a grid; the first axis varies fastest."""
    for values in product(*(axis.values for axis in reversed(swept))):
        yield dict(zip((axis.key for axis in swept), reversed(values), strict=True))


def sine(f, rms):
    return Sines((sqrt(2) * rms,), (f,), (0.0,))


def orbit_row(approach, point, force=15.0, ratio=1.0, limit=0.025):
    """Return the row of a periodic orbit."""
    force = point.get(FORCE, force) * (approach != "viscous")
    law, motion = (
        CoulombLaw(force, force * ratio),
        sine(point.get(FREQUENCY, 2.0), point.get(RMS, 1.0)),
    )
    member, period = MEMBERS[approach], 1 / motion.f[0]
    start, length, closure = REST, 20 * period, 0.0
    if isinstance(member, ExactApproach):
        orbit = find_orbit(PAPER, law, motion, REST, period)
        start, length, closure = orbit.state, orbit.periods * period, orbit.closure
        trajectory = member.trajectory(PAPER, law, motion, start, length)
        window = (0.0, length)
    else:
        trajectory = member.solve(PAPER, law, motion, start, 2.5e-3, length).trajectory
        window = (10 * period, length)
    metrics = measure(trajectory, window, limits_of(limit), closure)
    return Row(point, approach, law.F_fk, law.F_fs, metrics)


def sweep(
    *swept, limit=0.025, reference="viscous", force=15.0, ratio=1.0, kind="harmonic", **words
):
    """Return the table of a sweep, the reference last."""
    rows = [orbit_row("stick-slip", point, force, ratio, limit) for point in points(swept)]
    rest = tuple(axis for axis in swept if axis.key != FORCE)
    if reference:
        rows += [orbit_row(reference, point, force, ratio, limit) for point in points(rest)]
    asked = {"sweep": swept, "reference": reference}
    asked["with_approach"] = lambda _: SimpleNamespace(sweep=rest)
    scene = stand_in(kind, limit, CoulombLaw(force, force * ratio), **asked)
    return Table(scene, swept, tuple(rows), **words)


def spoil(table, status, *numbers, note="because"):
    """Return the table with some rows that have no metrics."""
    rows = [
        replace(row, metrics=UNKNOWN, status=status, note=note) if at in numbers else row
        for at, row in enumerate(table.rows)
    ]
    return replace(table, rows=tuple(rows))


def random_rows(approach, swept, n, limit):
    """Return rows and responses on random base motion that knows its displacement."""
    rest = tuple(axis for axis in swept if approach != "viscous" or axis.key != FORCE)
    for point in points(rest):
        force = point.get(FORCE, 45.0) * (approach != "viscous")
        motion = record(n, point.get(RMS, 0.5))
        response = MEMBERS[approach].solve(
            PAPER, CoulombLaw(force, force), motion, REST, motion.dt
        )
        metrics = measure(response.trajectory, (0.0, response.trajectory.end), limits_of(limit))
        yield Row(point, approach, force, force, metrics), response


def comparison(names, *swept, n=4_000, limit=0.025, shown=None, verdict=("all agree",)):
    """Return a comparison on random base motion; the last name is the reference."""
    rows, responses = [], {}
    at = shown if shown is not None else next(points(swept))
    for name in dict.fromkeys([*names, "viscous"]):
        for row, response in random_rows(name, swept, n, limit):
            rows.append(row)
            if all(at.get(key, value) == value for key, value in row.point.items()):
                responses[name] = response
    table = Table(stand_in("record", limit), swept, tuple(rows))
    return Comparison(table, names[-1], responses, at, verdict)


def orbits(names, frequency=5.0, rms=0.5, force=45.0):
    """Return the comparison of one harmonic case, without a sweep."""
    rows, responses = [], {}
    for name in dict.fromkeys([*names, "viscous"]):
        row = orbit_row(name, {FREQUENCY: frequency, RMS: rms, FORCE: force})
        rows.append(replace(row, point={}))
        law = CoulombLaw(row.F_fk, row.F_fs)
        motion = sine(frequency, rms)
        responses[name] = MEMBERS[name].solve(PAPER, law, motion, REST, 2.5e-3, 10 / frequency)
    table = Table(stand_in("harmonic", 0.025, CoulombLaw(force, force)), (), tuple(rows))
    return Comparison(table, names[-1], responses, {}, ("all agree",))
