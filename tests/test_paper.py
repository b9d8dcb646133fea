"""The findings of the paper, one test each; how far its words hold is in the bounds."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, cosh, pi, sin, sinh, sqrt
from pathlib import Path
from typing import Any

import pytest

from drysim.approach.fixed_step import Smooth
from drysim.core.model import CoulombLaw, Plant
from drysim.manual import pages
from drysim.metrics.table import Metrics
from drysim.scenario.load import load
from drysim.study.compare import compare
from drysim.study.ensemble import run
from drysim.study.statistics import Row
from drysim.study.sweep import sweep

HARMONIC = """\
drysim: 1
name: harmonic
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {approach: stick-slip, step: 2.5e-3}
sweep:
  excitation.frequency: {from: 0.5, to: 10, step: 0.5}
  excitation.rms: [0.50, 0.75, 1.00]
  friction.kinetic: [15, 45]
reference: viscous
"""

RANDOM = """\
drysim: 1
name: random
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation:
  {kind: psd, points: [[0.5, 1], [10, 1]], rms: 0.33, duration: 60, seed: 1}
solver: {approach: stick-slip, step: 2.5e-3}
sweep: {friction.kinetic: [5, 15, 25, 35, 45, 55]}
"""

EL_CENTRO = Path(__file__).parents[2] / "shared" / "data" / "el_centro_1940_ns.csv"

F_0 = sqrt(7500 / 75) / (2 * pi)

Curve = dict[float, Row]


@pytest.fixture(scope="module")
def curves(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[float, float], Curve]:
    """Return the curves of Figs. 3 and 4 by friction force and intensity; 0 N is viscous."""
    file = tmp_path_factory.mktemp("paper") / "harmonic.yaml"
    file.write_text(HARMONIC)
    found: dict[tuple[float, float], Curve] = {}
    for row in sweep(load(file)).rows:
        key = row.point.get("friction.kinetic", 0.0), row.point["excitation.rms"]
        found.setdefault(key, {})[row.point["excitation.frequency"]] = row
    return found


def peak(curve: Curve) -> float:
    """Return the greatest T_a of a curve."""
    return max(row.metrics["T_a"] for row in curve.values())


@pytest.mark.parametrize("rms", [0.50, 0.75, 1.00])
def test_friction_worsens_isolation_above_root_two_of_the_natural_frequency(
    curves: dict[tuple[float, float], Curve], rms: float
) -> None:
    bare, low, high = (curves[F, rms] for F in (0.0, 15.0, 45.0))
    above = [f for f in bare if f > 1.05 * sqrt(2) * F_0]
    assert len(above) > 10
    for f in above:
        assert bare[f].metrics["T_a"] < low[f].metrics["T_a"] < high[f].metrics["T_a"]


def test_peak_falls_with_friction_and_more_so_at_low_intensity(
    curves: dict[tuple[float, float], Curve],
) -> None:
    for rms in (0.50, 0.75, 1.00):
        assert peak(curves[0.0, rms]) > peak(curves[15.0, rms]) > peak(curves[45.0, rms])
    for F in (15.0, 45.0):
        assert peak(curves[F, 0.50]) < peak(curves[F, 0.75]) < peak(curves[F, 1.00])


def test_high_friction_at_low_intensity_hovers_around_unity_and_zero(
    curves: dict[tuple[float, float], Curve],
) -> None:
    # It creeps: about half the time stuck, and never quite still.
    for row in curves[45.0, 0.50].values():
        assert 0.98 < row.metrics["T_a"] < 1.02
        assert row.metrics["T_x"] < 0.07
        assert 0.4 < row.metrics["stuck_share"] < 0.6


def test_signum_leaves_stick_slip_as_friction_grows(tmp_path: Path) -> None:
    file = tmp_path / "random.yaml"
    file.write_text(RANDOM)
    found = compare(load(file), ("signum", "stick-slip"))
    deviations = [found.deviation(row) for row in found.table.of("signum")]
    assert all(deviation is not None for deviation in deviations)
    assert abs(deviations[0]) < 0.02
    assert deviations[1:] == sorted(deviations[1:])
    assert deviations[-1] > 0.25


def test_at_low_friction_the_viscous_model_shows_slightly_more_than_either(
    tmp_path: Path,
) -> None:
    file = tmp_path / "random.yaml"
    file.write_text(RANDOM[: RANDOM.index("sweep:")])
    found = compare(load(file, {"friction.kinetic": 5}), ("signum", "stick-slip"))
    T_a = {row.approach: row.metrics["T_a"] for row in found.table.rows}
    for approach in ("signum", "stick-slip"):
        assert T_a[approach] < T_a["viscous"] < 1.1 * T_a[approach]


@pytest.mark.parametrize(
    ("kinetic", "frequency", "rms", "form", "metric", "off"),
    [
        (45, 10.0, 0.75, "tanh", "T_a", -0.0242),
        (15, 10.0, 0.5, "rational", "T_a", -0.1216),
        (45, 10.0, 0.5, "tanh", "x_r_peak", 2.95),
        (45, 10.0, 0.5, "rational", "x_r_peak", 7.39),
        (45, 5.0, 0.5, "tanh", "x_r_peak", 1.56),
        (45, 5.0, 0.5, "rational", "x_r_peak", 4.93),
    ],
)
def test_sharpness_of_a_thousand_errs_on_sines_as_the_readme_says(
    tmp_path: Path,
    kinetic: float,
    frequency: float,
    rms: float,
    form: str,
    metric: str,
    off: float,
) -> None:
    file = tmp_path / "harmonic.yaml"
    file.write_text(HARMONIC[: HARMONIC.index("sweep:")])
    words = {
        "friction.kinetic": kinetic, "excitation.frequency": frequency, "excitation.rms": rms,
        "solver.smooth": {"form": form, "sharpness": 1e3},
    }  # fmt: skip
    exact = run(load(file, words)).metrics[metric]
    smooth = run(load(file, words | {"solver.approach": "smooth"})).metrics[metric]
    assert exact is not None
    assert smooth is not None
    assert smooth / exact - 1 == pytest.approx(off, rel=0.01)


@pytest.mark.parametrize(
    ("frequency", "ratio", "start", "stands_still"),
    [
        (0.5, 1.178, 0.0, False),
        (0.5, 1.179, 0.0, True),
        (0.5, 1.179, 5e-3, False),
        (0.5, 1.38, 0.0, True),
        (0.5, 1.38, 5e-3, False),
        (0.5, 1.39, 5e-3, True),
        (1.0, 1.22, 5e-3, False),
        (1.0, 1.25, 5e-3, True),
        (1.6, 1.2, 5e-3, True),
    ],
)
def test_a_stick_slip_orbit_coexists_with_rest_above_the_static_limit_that_holds_a_mass_at_rest(
    tmp_path: Path, frequency: float, ratio: float, start: float, stands_still: bool
) -> None:
    file = tmp_path / "harmonic.yaml"
    file.write_text(HARMONIC[: HARMONIC.index("sweep:")])
    words = {
        "friction.kinetic": 45, "friction.static_ratio": ratio, "start.x_r": start,
        "excitation.frequency": frequency, "excitation.rms": 0.5,
    }  # fmt: skip
    metrics = run(load(file, words)).metrics
    assert (metrics["stuck_share"] == 1.0) == stands_still
    assert (metrics["T_a"] == 1.0) == stands_still


# The tables of the manual's page on the paper.


def table(heading: str) -> dict[str, list[float]]:
    """Return the numbers of a table of the page, by the first cell of their row."""
    text = pages()["paper"].file.read_text(encoding="utf-8")
    section = text.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    _, _, *lines = [line for line in section.splitlines() if line.startswith("|")]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {name: [float(cell.split()[0]) for cell in cells] for name, *cells in rows}


@pytest.fixture
def metrics_of(tmp_path: Path) -> Callable[..., Metrics]:
    """Return a function that gives the metrics of a steady state: force, frequency, RMS."""
    file = tmp_path / "harmonic.yaml"
    file.write_text(HARMONIC[: HARMONIC.index("sweep:")])

    def measured(kinetic: float, frequency: float, rms: float, **words: Any) -> Metrics:
        point = {
            "friction.kinetic": kinetic, "excitation.frequency": frequency,
            "excitation.rms": rms,
        }  # fmt: skip
        solver = {f"solver.{key}": value for key, value in words.pop("solver", {}).items()}
        return run(load(file, point | solver | words.get("more", {}))).metrics

    return measured


def smooth(form: str, sharpness: float, **options: Any) -> dict[str, Any]:
    """Return the solver block of a smooth form."""
    return {"approach": "smooth", "smooth": {"form": form, "sharpness": sharpness, **options}}


def percent(value: float | None, exact: float | None) -> float:
    """Return by how much a value is off [%]."""
    assert value is not None
    assert exact is not None
    return 100.0 * (value / exact - 1.0)


def den_hartog(F_fk: float, frequency: float, rms: float) -> float:
    """Return the amplitude of sliding without stops [m], from Den Hartog's formula."""
    m, k_x, b, P = 75.0, 7500.0, 500.0, 75.0 * rms * sqrt(2.0)
    beta, zeta, phi = frequency / F_0, b / (2 * sqrt(k_x * m)), F_fk / P
    q = sqrt(1 - zeta**2)
    D = cosh(pi * zeta / beta) + cos(pi * q / beta)
    G = (sinh(pi * zeta / beta) - zeta / q * sin(pi * q / beta)) / D
    H = sin(pi * q / beta) / (beta * q * D)
    linear = 1.0 / ((1 - beta**2) ** 2 + (2 * zeta * beta) ** 2)
    return P / k_x * (-G * phi + sqrt(linear - (H * phi) ** 2))


@pytest.mark.parametrize("form", ["tanh", "erf", "arctan", "rational"])
def test_smooth_forms_err_from_den_hartog_as_the_page_says(
    metrics_of: Callable[..., Metrics], form: str
) -> None:
    said = table("Smooth forms against Den Hartog's amplitude")[form]
    for frequency, x_r, T_a in zip((2.0, 5.0, 10.0), said[:3], said[3:], strict=True):
        exact, amplitude = metrics_of(15, frequency, 0.75), den_hartog(15, frequency, 0.75)
        found = metrics_of(15, frequency, 0.75, solver=smooth(form, 1e3))
        assert exact["x_r_peak"] == pytest.approx(amplitude, rel=1e-12)
        assert percent(found["x_r_peak"], amplitude) == pytest.approx(x_r, abs=0.006)
        assert percent(found["T_a"], exact["T_a"]) == pytest.approx(T_a, abs=0.006)


SLOW = pytest.mark.slow


@pytest.mark.parametrize(
    ("form", "column", "off"),
    [
        *((form, 0, 1.0) for form in ("tanh", "erf", "arctan", "rational")),
        *((form, 1, 0.1) for form in ("tanh", "erf")),
        *(pytest.param(form, 1, 0.1, marks=SLOW) for form in ("arctan", "rational")),
    ],
)
def test_sharpness_and_steps_of_equal_accuracy_are_those_of_the_page(
    metrics_of: Callable[..., Metrics], form: Any, column: int, off: float
) -> None:
    said, exact = table("What equal accuracy costs")[form], metrics_of(45, 2.0, 0.75)
    sharpness, steps = said[column], said[2 + column]
    found = metrics_of(45, 2.0, 0.75, solver=smooth(form, sharpness))
    assert abs(percent(found["T_a"], exact["T_a"])) == pytest.approx(off, rel=0.02)
    approach = Smooth(form=form, sharpness=sharpness)
    a_step = approach.substeps(Plant(75.0, 7500.0, 500.0), CoulombLaw(45.0, 45.0), 2.5e-3)
    assert 200 * a_step == pytest.approx(steps, rel=0.01)


@SLOW
def test_stiff_solver_agrees_with_small_fixed_steps(metrics_of: Callable[..., Metrics]) -> None:
    found = [
        metrics_of(45, 2.0, 0.75, solver=smooth("tanh", 1e4, method=method))["T_a"]
        for method in ("adaptive", "substeps")
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-6)


def test_velocity_band_errs_as_the_page_says(metrics_of: Callable[..., Metrics]) -> None:
    for band, said in table("The velocity band of Eq. (10)").items():
        solver = {
            "approach": "switch", "step": 2.5e-4,
            "switch": {"band": float(band.split()[0]) * 1e-3},
        }  # fmt: skip
        errors = []
        for rms in (0.75, 0.5):
            exact, found = metrics_of(45, 10, rms), metrics_of(45, 10, rms, solver=solver)
            errors += [percent(found[name], exact[name]) for name in ("T_a", "T_x")]
        assert errors == pytest.approx(said, abs=0.06)


def test_two_stable_motions_are_those_of_the_page(metrics_of: Callable[..., Metrics]) -> None:
    for frequency, (amplitude, T_a) in table("Two stable motions").items():
        ratio, f = {"friction.static_ratio": 1.2}, float(frequency.split()[0])
        at_rest = metrics_of(45, f, 0.5, more=ratio)
        moving = metrics_of(45, f, 0.5, more=ratio | {"start.x_r": 5e-3})
        assert at_rest["T_a"] == 1.0
        assert moving["x_r_peak"] == pytest.approx(amplitude * 1e-3, rel=1e-3)
        assert moving["T_a"] == pytest.approx(T_a, abs=6e-6)


@pytest.mark.skipif(not EL_CENTRO.exists(), reason="the record is not part of drysim")
def test_a_block_on_el_centro_moves_as_the_page_says(tmp_path: Path) -> None:
    rows = table("An earthquake record")
    assert list(rows) == ["0.05", "0.1", "0.15", "0.2"]
    file = tmp_path / "block.yaml"
    for coefficient, row in rows.items():
        file.write_text(
            "drysim: 1\n"
            "oscillator: {mass: 1, stiffness: 0, damping: 0}\n"
            f"friction: {{law: coulomb, kinetic: {float(coefficient) * 9.80665}}}\n"
            f"excitation: {{kind: record, file: {EL_CENTRO}, time: time, column: acc}}\n"
        )
        exact = run(load(file)).metrics
        signum = {"solver.approach": "signum", "solver.signum.method": "semi-implicit"}
        coarse = run(load(file, signum)).metrics
        fine = run(
            load(file, signum | {"excitation.resample": {"rate": "10 kHz", "by": "line"}})
        ).metrics
        assert exact["x_r_peak"] * 1e3 == pytest.approx(row[0], rel=5e-4)
        assert exact["stuck_share"] * 100.0 == pytest.approx(row[1], abs=0.005)
        assert exact["T_a"] == pytest.approx(row[2], abs=5e-4)
        assert [coarse["T_a"], fine["T_a"]] == pytest.approx(row[3:], abs=5e-4)
