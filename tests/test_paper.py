"""The page on the paper: each number on it is computed here, to the digits that it shows.

The tests read the numbers from the page, so that page and tests cannot drift apart. Scenes are
the gallery's.
"""

from __future__ import annotations

import re
import shlex
import shutil
from collections.abc import Iterable, Mapping
from functools import cache
from math import ceil, cos, cosh, pi, sin, sinh, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drysim.approach.fixed_step import Smooth
from drysim.cli import main
from drysim.core.model import CoulombLaw, Plant
from drysim.manual import pages
from drysim.metrics.table import Metrics
from drysim.scenario.load import load
from drysim.study.ensemble import run
from drysim.study.outcome import Outcome
from drysim.study.sweep import sweep

ROOT = Path(__file__).parents[1]
LOW, HIGH, NOISE = (
    ROOT / "scenarios" / f"paper-{name}.yaml"
    for name in ("low-friction", "high-friction", "random")
)
EL_CENTRO = ROOT.parent / "shared" / "data" / "el_centro_1940_ns.csv"
PLANT = Plant(75.0, 7500.0, 500.0)
F_0 = sqrt(7500 / 75) / (2 * pi)
SLOW = pytest.mark.slow

# The page.

NUMBER = re.compile(r"(?<![\w.√])[-−]?\d+(?:\.\d+)?(?:e-?\d+)?(?!\w)")


def text_of(heading: str) -> str:
    """Return a section of the page."""
    _, _, after = pages()["paper"].text.partition(f"## {heading}\n")
    return after.partition("\n## ")[0]


def rows_of(heading: str, number: int = 0) -> dict[str, list[str]]:
    """Return a table of a section: the other cells of each row by the first."""
    tables = re.findall(r"(?:^\|.*\n)+", text_of(heading), re.M)
    _, _, *lines = tables[number].splitlines()
    rows = [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in lines]
    return {first: cells for first, *cells in rows}


def prose_of(heading: str) -> str:
    """Return a section without its tables."""
    return re.sub(r"(?:^\|.*\n)+", "", text_of(heading), flags=re.M)


def check_numbers(text: str, values: Iterable[float | None]) -> None:
    """Assert that the numbers of a text are these values, to the digits printed."""
    printed, expected = NUMBER.findall(text), list(values)
    assert len(printed) == len(expected), (printed, expected)
    for number, value in zip(printed, expected, strict=True):
        assert value is not None
        _, _, decimals = number.partition(".")
        digits = 0 if "e" in number else len(decimals)
        half = 0.5 * 10.0**-digits * (1 + 1e-6)
        assert abs(float(number.replace("−", "-")) - value) <= half, (number, value, text)


# What drysim computes.


@cache
def solved(
    file: Path, approach: str = "stick-slip", form: str = "tanh", sharpness: float = 1e3
) -> dict[tuple[float, ...], Metrics]:
    """Return the metrics of each case of a sweep: by frequency or force, and level."""
    overrides: dict[str, Any] = {"reference": "viscous"}
    if approach != "viscous":
        overrides = {"solver.approach": approach} | (
            {} if file == NOISE else {"reference": None}
        )
    if approach == "smooth":
        overrides["solver.smooth"] = {"form": form, "sharpness": sharpness}
    rows = [row for row in sweep(load(file, overrides)).rows if row.approach == approach]
    return {tuple(row.point.values()): row.metrics for row in rows}


def steady(
    kinetic: float, frequency: float, rms: float, file: Path = LOW, **options: Any
) -> Outcome:
    """Return one case of Figs. 3 and 4; options have a double underscore for their point."""
    overrides = {key.replace("__", "."): value for key, value in options.items()}
    case = {
        "friction.kinetic": kinetic, "excitation.frequency": frequency, "excitation.rms": rms,
    }  # fmt: skip
    return run(load(file, {**case, **overrides}))


def percent(value: float | None, exact: float | None) -> float:
    """Return by how much a value is off [%]."""
    assert value is not None
    assert exact is not None
    return 100.0 * (value / exact - 1.0)


def worst(errors: Mapping[tuple[float, ...], float]) -> list[float]:
    """Return the error of largest magnitude and its case."""
    case = max(errors, key=lambda point: abs(errors[point]))
    return [errors[case], *case]


def errors_of(
    metric: str, file: Path, approach: str, *smooth: Any
) -> dict[tuple[float, ...], float]:
    """Return by how much a metric of an approach is off in each case [%]."""
    exact = solved(file)
    return {
        case: percent(metrics[metric], exact[case][metric])
        for case, metrics in solved(file, approach, *smooth).items()
    }


def peak_errors(file: Path, approach: str) -> dict[tuple[float, ...], float]:
    """Return by how much the peak of x_r is off [%], measured as by `drysim compare`."""
    exact, metrics = solved(file), solved(file, approach)
    least = 0.05 * max(case["x_r_peak"] for case in exact.values())
    return {
        case: 100.0
        * (metrics[case]["x_r_peak"] - exact[case]["x_r_peak"])
        / max(exact[case]["x_r_peak"], least)
        for case in exact
    }


# Items and commands.


def test_items() -> None:
    rows = rows_of("Items")
    source = Path(__file__).read_text(encoding="utf-8")
    defined = set(re.findall(r"^def (test_\w+)", source, re.M))
    for number in (1, 3, 4, 5):
        assert any(item.startswith(f"Fig. {number}:") for item in rows)
    equations = [item for item in rows if item.startswith("Eq")]
    listed = {number for item in equations for number in re.findall(r"\((\d+)\)", item)}
    assert listed == {"3", "4", "5", "7", "8", "9", "10"}
    for _, page, tests in rows.values():
        assert page.startswith("[")
        names = re.findall(r"`(test_\w+)`", tests)
        assert names
        assert set(names) <= defined


def test_oscillator() -> None:
    head, _, _ = pages()["paper"].text.partition("\n## ")
    for file in (LOW, HIGH, NOISE):
        m, k_x, b = load(file).oscillator.plant()
        check_numbers(head, [m, k_x, b, sqrt(k_x / m) / (2 * pi), 5])


def test_commands(place: Path) -> None:
    for file in (LOW, HIGH, NOISE, LOW.with_name("coexisting-motions.yaml")):
        shutil.copy(file, place)
    figures, items = rows_of("Figures"), rows_of("Items")
    commands = [*figures, *(command for command, *_ in items.values())]
    for command in set(commands):
        program, *arguments = shlex.split(command.strip("`"))
        assert program == "drysim"
        assert main([*arguments, "--dry-run"]) == 0, command
    # `make paper` runs those of the figures.
    (recipe,) = re.findall(
        r"^paper:.*\n((?:\t.*\n)+)", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M
    )
    made = re.sub(r" --out \S+| -s", "", recipe.replace("scenarios/", ""))
    for command in figures:
        assert command.strip("`").removeprefix("drysim ") in made
    forces = figures[next(iter(figures))][0]
    check_numbers(forces, [1, 45, 54])


# The model.


def test_equations() -> None:
    outcome = steady(45, 0.7, 1.0, HIGH, friction__static_ratio=1.2, solver__step=2e-5)
    motion, events = outcome.response, outcome.response.events
    x_r, v_r, x_dd, F_f = motion.x_r, motion.v_r, motion.x_dd, motion.F_f
    F_L = 75.0 * motion.u_dd + 7500.0 * x_r
    slides = ~motion.stuck
    assert 0.2 < 1.0 - slides.mean() < 0.3
    assert F_f[slides] == pytest.approx(45.0 * np.sign(v_r[slides]))  # Eq. (3), Fig. 1
    assert 75.0 * x_dd == pytest.approx(-(7500.0 * x_r + 500.0 * v_r + F_f))  # Eq. (7)
    assert np.all(v_r[motion.stuck] == 0.0)  # Eqs. (4), (9)
    assert F_f[motion.stuck] == pytest.approx(-F_L[motion.stuck])
    assert np.abs(F_L[motion.stuck]).max() <= 54.0
    broken = [i for i, name in enumerate(events.names) if name.startswith("slip") and i]
    assert len(broken) == 2
    assert np.abs(events.F_L[broken]) == pytest.approx(54.0)
    jumps = []
    for t in events.t[broken]:
        after = np.searchsorted(motion.t, t)
        jumps.append(abs(x_dd[after] - x_dd[after - 1]))
        assert abs(v_r[after] - v_r[after - 1]) < 1e-4
    assert jumps == pytest.approx([9 / 75] * 2, abs=4e-4)
    check_numbers(prose_of("Statements"), [10, 3, 4, 1, 9 / 75, 54, 45])


def test_normal_force() -> None:
    outcome = run(
        load(
            LOW,
            {
                "friction.normal_variation": {"amplitude": 0.4, "frequency": 1.7},
                "measure": {"steady": False, "settle": 0, "duration": 5},
            },
        )
    )
    motion = outcome.response
    slides = ~motion.stuck
    force = 15.0 * (1.0 + 0.4 * np.sin(2 * pi * 1.7 * motion.t))
    assert motion.F_f[slides] == pytest.approx((force * np.sign(motion.v_r))[slides])


def test_stroke_limit() -> None:
    limited = run(load(LOW, {"stroke.limit": "15 mm"})).metrics
    assert limited["violations"] == 2
    assert limited["x_r_peak"] > 0.015
    assert run(load(LOW)).metrics["violations"] == 0


# Statements.


def test_harmonic() -> None:
    rows = rows_of("Statements")
    fine = {
        "excitation.frequency": {"from": 0.5, "to": 2.4, "step": 0.01},
        "excitation.rms": [0.5, 0.75, 1.0], "friction.kinetic": [15, 45],
    }  # fmt: skip
    curves: dict[tuple[float, float], dict[float, float]] = {}
    for row in sweep(load(LOW, {"sweep": fine})).rows:
        key = row.point.get("friction.kinetic", 0.0), row.point["excitation.rms"]
        curves.setdefault(key, {})[row.point["excitation.frequency"]] = row.metrics["T_a"]
    crossings = []
    for (force, rms), curve in curves.items():
        if not force:
            continue
        bare = curves[0.0, rms]
        above = [f for f in curve if f > 2.2 and curve[f] > bare[f]]
        assert above == [f for f in curve if f >= above[0]]  # and it stays above
        before = max(f for f in curve if f < above[0])
        gaps = [curve[f] - bare[f] for f in (before, above[0])]
        crossings.append(before + (above[0] - before) * gaps[0] / (gaps[0] - gaps[1]))
    check_numbers(
        *rows["friction worsens isolation above √2·f_0"],
        [sqrt(2) * F_0, min(crossings), max(crossings)],
    )
    peak = {key: max(curve.values()) for key, curve in curves.items()}
    check_numbers(
        *rows["the peak of T_a falls with friction, more so at low intensity"],
        [
            peak[0.0, 1.0], 15, peak[15, 1.0], peak[15, 0.75], peak[15, 0.5], 1, 0.75, 0.5,
            45, peak[45, 1.0], peak[45, 0.75], peak[45, 0.5],
        ],
    )  # fmt: skip
    level = [metrics for (_, rms), metrics in solved(HIGH).items() if rms == 0.5]
    ranges = [
        scale * bound(metrics[name] for metrics in level)
        for name, scale in (("T_a", 1), ("T_x", 1), ("stuck_share", 100))
        for bound in (min, max)
    ]
    check_numbers(
        *rows["with 45 N at 0.50 m/s², T_a hovers around unity and T_x around zero"], ranges
    )
    for file, friction in ((LOW, "15 N"), (HIGH, "45 N")):
        for f in (8.0, 9.0):  # isolation is worse up to the end of the figures
            assert solved(file)[f, 0.5]["T_a"] > solved(LOW, "viscous")[f, 0.5]["T_a"]
        values = [solved(file)[10.0, rms]["T_x"] for rms in (0.5, 0.75, 1.0)]
        check_numbers(" ".join(rows_of("Statements", 1)[friction]), values)
    values = [solved(LOW, "viscous")[10.0, rms]["T_x"] for rms in (0.5, 0.75, 1.0)]
    check_numbers(" ".join(rows_of("Statements", 1)["none"]), values)


def test_peaks() -> None:
    peaks = [
        1e3 * max(metrics["x_r_peak"] for metrics in solved(file, approach).values())
        for file, approach in (
            (LOW, "stick-slip"), (HIGH, "stick-slip"), (LOW, "viscous"), (NOISE, "stick-slip"),
        )
    ]  # fmt: skip
    low, high, bare, noise = peaks
    check_numbers(
        *rows_of("Statements")["the stroke is 25 mm"], [low, 15, high, 45, bare, noise]
    )
    assert max(peaks) < 25.0


def test_random() -> None:
    rows, exact, signum = rows_of("Statements"), solved(NOISE), solved(NOISE, "signum")
    T_a = {case: metrics["T_a"] for case, metrics in exact.items()}
    for rms, force in ((0.33, 5.0), (0.67, 10.0)):
        assert min(T_a[F, level] for F, level in T_a if level == rms) == T_a[force, rms]
    fine = sweep(load(NOISE, {"sweep.friction.kinetic": {"from": 5, "to": 15, "step": 0.5}}))
    ratios = []
    for rms in (0.33, 0.67):
        level = {
            row.point["friction.kinetic"]: row.metrics["T_a"]
            for row in fine.rows
            if row.point["excitation.rms"] == rms
        }
        ratios.append(min(level, key=lambda force: level[force]) / (75 * rms))
    stuck = [100 * exact[70.0, rms]["stuck_share"] for rms in (0.33, 0.67)]
    check_numbers(
        *rows["above a certain friction the mass sticks to its base under noise"],
        [
            T_a[0.0, 0.33], T_a[5.0, 0.33], 5, 0.33, 10, 0.67, 10 / (75 * 0.67), 0.5,
            min(ratios), max(ratios), 70, *stuck,
        ],
    )  # fmt: skip
    assert T_a[10.0, 0.67] == pytest.approx(T_a[5.0, 0.33], abs=5e-4)
    errors = errors_of("T_a", NOISE, "signum")
    (peak, *case), (compared, *other_case) = (
        worst(errors_of("x_r_peak", NOISE, "signum")),
        worst(peak_errors(NOISE, "signum")),
    )
    assert [case[1], other_case[1]] == [0.33, 0.33]
    check_numbers(
        *rows["signum leaves stick-slip as friction grows"],
        [
            0.33, errors[5.0, 0.33], 5, errors[15.0, 0.33], 15, errors[30.0, 0.33], 30,
            errors[70.0, 0.33], 70, peak, case[0], compared, other_case[0], 5,
        ],
    )  # fmt: skip
    growing = [errors[force, 0.33] for force in range(5, 75, 5)]
    assert growing == sorted(growing)
    other = {"solver.approach": "signum", "friction.kinetic": 70, "excitation.rms": 0.33}
    rk4 = run(load(NOISE, {**other, "solver.signum.method": "rk4"})).metrics["T_a"]
    assert rk4 == pytest.approx(signum[70.0, 0.33]["T_a"], rel=0.05)
    check_numbers(
        *rows["at low friction the viscous model transmits slightly more than either"],
        [
            5, 0.33, solved(NOISE, "viscous")[0.33,]["T_a"], T_a[5.0, 0.33],
            signum[5.0, 0.33]["T_a"],
        ],
    )  # fmt: skip


@SLOW
def test_sharpness() -> None:
    def largest(form: str, sharpness: float, *files: Path) -> list[float]:
        """Return the largest error of T_a, and its force, frequency and level."""
        cases = []
        for file in files:
            error, first, rms = worst(errors_of("T_a", file, "smooth", form, sharpness))
            force = 15.0 if file == LOW else 45.0 if file == HIGH else first
            cases.append([abs(error), force, first, rms])
        return max(cases)

    noise = {form: largest(form, 1e3, NOISE) for form in ("tanh", "rational")}
    sines = {form: largest(form, 1e3, LOW, HIGH) for form in ("tanh", "rational")}
    assert noise["tanh"][1:] == noise["rational"][1:]
    times = {
        (form, f): 1.0 + errors_of("x_r_peak", HIGH, "smooth", form, 1e3)[f, 0.5] / 100.0
        for form in ("tanh", "rational")
        for f in (5.0, 10.0)
    }
    for form in ("tanh", "rational"):
        errors = errors_of("x_r_peak", HIGH, "smooth", form, 1e3)
        assert worst(errors)[1:] == [10.0, 0.5]
    check_numbers(
        *rows_of("Statements")["a sharpness c of 1e3 s/m suffices"],
        [
            0, 70, noise["tanh"][0], noise["rational"][0], noise["tanh"][1], noise["tanh"][3],
            3, 4, *sines["tanh"], *sines["rational"],
            1e4, largest("rational", 1e4, NOISE)[0], largest("rational", 1e4, LOW, HIGH)[0],
            45, 0.5, times["tanh", 5.0], times["rational", 5.0], 5,
            times["tanh", 10.0], times["rational", 10.0], 10,
        ],
    )  # fmt: skip


# The method of the paper.


@pytest.mark.parametrize(
    ("figure", "file"), [("Fig. 3", LOW), ("Fig. 4", HIGH), ("Fig. 5", NOISE)]
)
def test_switch(figure: str, file: Path) -> None:
    cells = rows_of("The method of the paper")[figure]
    for metric, cell in zip(("T_a", "T_x"), cells, strict=False):
        check_numbers(cell, worst(errors_of(metric, file, "switch")))
    peaks = peak_errors(file, "switch")
    check_numbers(cells[2], worst(peaks))
    if file != NOISE:
        wrong = [f for (f, _), error in errors_of("T_x", file, "switch").items() if error > 6.0]
        assert wrong
        assert all(ceil(1.0 / f / 2.5e-3 - 1e-9) % 2 for f in wrong)


def test_offset_of_switch() -> None:
    outcome = steady(45, 9.9, 0.5, solver__approach="switch")
    exact, motion = steady(45, 9.9, 0.5).metrics, outcome.response.x_r * 1e3
    halved = []
    for kinetic, frequency, rms in ((15, 6.5, 1.0), (45, 10.0, 0.5)):
        finer = {"solver__approach": "switch", "solver__step": 1.25e-3}
        half = steady(kinetic, frequency, rms, **finer).metrics["T_a"]
        halved.append(percent(half, steady(kinetic, frequency, rms).metrics["T_a"]))
    band = 1e3 * 45.0 * 2.5e-3 / 75.0
    whole = steady(45, 10, 0.5, solver__approach="switch").response.numerics.why
    assert f"a band of {band / 1e3:.3g} m/s" in whole
    check_numbers(
        prose_of("The method of the paper").replace("Figs. 3", "").replace("and 4.", ""),
        [
            10, 2.5, band, 45, 5, 100 * (outcome.metrics["T_x"] / exact["T_x"] - 1),
            outcome.metrics["T_x"], exact["T_x"], ceil(1 / 9.9 / 2.5e-3), abs(motion.mean()),
            (motion.max() - motion.min()) / 2, 6, *halved,
        ],
    )  # fmt: skip


# Choices and sources.


def test_noise_of_choices() -> None:
    (sentence,) = re.findall(
        r"- \*\*The noise of Fig. 5.\*\*(.*?)\n- ", pages()["choices"].text, re.S
    )
    noise = load(NOISE).excitation.model_dump()
    assert noise["points"] == ((0.5, 1.0), (10.0, 1.0))
    options = {"friction.kinetic": 5, "excitation.rms": 0.33, "excitation.seeds": 20}
    rows = run(load(NOISE, options)).rows  # type: ignore[union-attr]
    T_a = [row.metrics["T_a"] for row in rows]
    check_numbers(
        sentence,
        [
            0.5,
            10,
            noise["duration"],
            noise["seed"],
            0.33,
            0.67,
            100 * np.ptp(T_a) / 2 / np.mean(T_a),
            5,
            20,
        ],
    )


def test_den_hartog_is_cited_alike() -> None:
    citation = "Phil. Mag. (7) 9, no. 59 suppl. (May 1930) 801"
    texts = [
        " ".join(file.read_text(encoding="utf-8").split())
        for pattern in ("src/**/*.py", "src/**/*.md", "scenarios/**/*.yaml", "README.md")
        for file in ROOT.glob(pattern)
    ]
    assert sum(citation in text for text in texts) >= 3
    assert [text for text in texts if text.count("Phil. Mag.") != text.count(citation)] == []
    years = [year for text in texts for year in re.findall(r"Hartog \(?(\d{4})", text)]
    assert set(years) == {"1930"}


# Smooth forms, the band, two motions, an earthquake.


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


def smooth(form: str, sharpness: float, **options: Any) -> dict[str, Any]:
    """Return the overrides of a smooth form."""
    block = {"form": form, "sharpness": sharpness, **options}
    return {"solver__approach": "smooth", "solver__smooth": block}


def test_smooth_forms() -> None:
    heading, amplitudes = "Smooth forms against Den Hartog's amplitude", []
    for form, cells in rows_of(heading).items():
        errors: dict[str, list[float]] = {"x_r_peak": [], "T_a": []}
        for frequency in (2.0, 5.0, 10.0):
            exact = steady(15, frequency, 0.75).metrics
            assert exact["x_r_peak"] == pytest.approx(
                den_hartog(15, frequency, 0.75), rel=1e-12
            )
            assert exact["stuck_share"] == 0.0
            metrics = steady(15, frequency, 0.75, **smooth(form, 1e3)).metrics
            for name, several in errors.items():
                several.append(percent(metrics[name], exact[name]))
        check_numbers(" ".join(cells), errors["x_r_peak"] + errors["T_a"])
        amplitudes += errors["x_r_peak"] if form in ("tanh", "erf") else []
    check_numbers(prose_of(heading), [1e3, 15, 0.75, max(amplitudes)])


@pytest.mark.parametrize(
    ("form", "column", "off"),
    [
        *((form, 0, 1.0) for form in ("tanh", "erf", "arctan", "rational")),
        *((form, 1, 0.1) for form in ("tanh", "erf")),
        *(pytest.param(form, 1, 0.1, marks=SLOW) for form in ("arctan", "rational")),
    ],
)
def test_accuracy(form: Any, column: int, off: float) -> None:
    heading = "What equal accuracy costs"
    table = {name: [float(cell) for cell in cells] for name, cells in rows_of(heading).items()}
    sharpness, steps = table[form][column], table[form][2 + column]
    exact = steady(45, 2.0, 0.75)
    assert len(exact.response.events) == 1 + 4
    T_a = steady(45, 2.0, 0.75, **smooth(form, sharpness)).metrics["T_a"]
    assert abs(percent(T_a, exact.metrics["T_a"])) == pytest.approx(off, rel=0.02)
    substeps = Smooth(form=form, sharpness=sharpness).substeps(
        PLANT, CoulombLaw(45.0, 45.0), 2.5e-3
    )
    assert 200 * substeps == pytest.approx(steps, rel=0.01)
    ratios = [table["rational"][i] / table["tanh"][i] for i in (2, 3)]
    check_numbers(
        prose_of(heading),
        [1, 0.1, 45, 0.75, 2, ratios[0], 1, ratios[1], 0.1, 1e4, 1e-6],
    )


@SLOW
def test_stiff_solver() -> None:
    T_a = [
        steady(45, 2.0, 0.75, **smooth("tanh", 1e4, method=method)).metrics["T_a"]
        for method in ("adaptive", "substeps")
    ]
    assert T_a[0] == pytest.approx(T_a[1], rel=1e-6)


def test_band() -> None:
    heading = "The velocity band of Eq. (10)"
    for band, cells in rows_of(heading).items():
        errors = []
        for rms in (0.75, 0.5):
            options = {
                "solver__approach": "switch", "solver__step": 2.5e-4,
                "solver__switch": {"band": band},
            }  # fmt: skip
            exact = steady(45, 10, rms).metrics
            metrics = steady(45, 10, rms, **options).metrics
            errors += [percent(metrics[name], exact[name]) for name in ("T_a", "T_x")]
        check_numbers(" ".join(cells), errors)
    check_numbers(prose_of(heading), [10, 45, 0.25])


def test_two_motions() -> None:
    heading = "Two stable motions"
    for frequency, cells in rows_of(heading).items():
        f, ratio = float(frequency.split()[0]), {"friction__static_ratio": 1.2}
        assert steady(45, f, 0.5, **ratio).metrics["T_a"] == 1.0
        moving = steady(45, f, 0.5, **ratio, start__x_r=5e-3).metrics
        check_numbers(" ".join(cells), [1e3 * moving["x_r_peak"], moving["T_a"]])
    check_numbers(prose_of(heading), [1.2, 45, 0.5, 4, 1, 5])


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
    frequency: float, ratio: float, start: float, stands_still: bool
) -> None:
    options = {"friction__static_ratio": ratio, "start__x_r": start}
    metrics = steady(45, frequency, 0.5, **options).metrics
    assert (metrics["stuck_share"] == 1.0) == stands_still
    assert (metrics["T_a"] == 1.0) == stands_still


@pytest.mark.skipif(not EL_CENTRO.exists(), reason="the record is not part of drysim")
def test_a_block_on_el_centro_moves_as_the_page_says(tmp_path: Path) -> None:
    rows = rows_of("An earthquake record")
    assert list(rows) == ["0.05", "0.1", "0.15", "0.2"]
    t, u_dd = np.loadtxt(  # ü in g
        EL_CENTRO, delimiter=",", skiprows=1, unpack=True
    )
    peak, sliding = np.abs(u_dd).max(), 100.0 - float(rows["0.2"][1])
    prose = re.sub("```.*?```", "", prose_of("An earthquake record"), flags=re.S)
    check_numbers(
        prose, [1940, t.size, (t.size - 1) / t[-1], peak, 0.1, 0.1, 10, round(sliding)]
    )
    file = tmp_path / "block.yaml"
    for coefficient, cells in rows.items():
        file.write_text(
            "drysim: 1\n"
            "oscillator: {mass: 1, stiffness: 0, damping: 0}\n"
            f"friction: {{law: coulomb, kinetic: {float(coefficient) * 9.80665}}}\n"
            f"excitation: {{kind: record, file: {EL_CENTRO}, time: time, column: acc}}\n"
        )
        exact = run(load(file)).metrics
        signum = {"solver.approach": "signum", "solver.signum.method": "semi-implicit"}
        finer = {"excitation.resample": {"rate": "10 kHz", "by": "line"}}
        T_a = [run(load(file, signum | more)).metrics["T_a"] for more in ({}, finer)]
        check_numbers(
            " ".join(cells),
            [1e3 * exact["x_r_peak"], 100 * exact["stuck_share"], exact["T_a"], *T_a],
        )
