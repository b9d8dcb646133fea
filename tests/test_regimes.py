"""Regime maps: boundaries against closed forms and tables, lines, files, faults."""

from __future__ import annotations

import csv
import re
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from seat import fields_of, load_text

import drysim
from drysim.core.orbit import ANSWER_COLUMNS, SINES
from drysim.orbits.coulomb import solve_orbits
from drysim.study.boundaries import (
    LOCKED,
    REGIME,
    Crossing,
    Grid,
    Joined,
    join_crossings,
    polylines,
)
from drysim.study.regimes import (
    ISOLATION,
    PERIODS,
    SEVERAL,
    STROKE,
    UNSETTLED,
    UNSYMMETRIC,
    describe_change,
    describe_regime,
    merge_unsettled,
    polygon_area,
)

PAPER = """
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45, static_ratio: 1.2}
stroke: {limit: 15 mm}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {step: 2.5e-3}
"""
SPECTRUM = """
oscillator: {mass: 1, natural_frequency: 5, damping_ratio: 0.05}
excitation: {kind: shock, pulse: half-sine, amplitude: 10, duration: 10 ms}
solver: {step: 1e-3}
measure: {duration: 1}
sweep: {srs: {from: 1, to: 9, count: 5}}
"""
OVER = """
sweep:
  excitation.frequency: {from: 0.25, to: 10, count: 33, scale: log}
  friction.kinetic: {from: 0, to: 120, count: 33}
"""


def unit_plane(folder: Path, beta: float, zeta: float, phi: float, ratio: float = 1.0):
    """Return the map over β and φ of an oscillator with m = k_x = A = 1."""
    f = beta / (2 * np.pi)
    text = f"""
oscillator: {{mass: 1, stiffness: 1, damping: {2 * zeta!r}}}
friction: {{law: coulomb, kinetic: {phi!r}, static_ratio: {ratio}}}
excitation: {{kind: harmonic, frequency: {f!r}, amplitude: 1}}
solver: {{step: 0.1}}
sweep:
  excitation.frequency: {{from: {0.8 * f!r}, to: {1.2 * f!r}, count: 33}}
  friction.kinetic: {{from: {0.5 * phi!r}, to: {1.5 * phi!r}, count: 33}}
"""
    return drysim.map_regimes(load_text(folder, text))


@pytest.mark.parametrize(
    ("beta", "zeta", "phi", "known", "sentence", "error"),
    [(0.25, 0.05, 0.053, 0.051111380, "it slides without stops", 1e-9),
     (0.25, 0.05, 0.22, 0.229713945, "it stops 4 times a period", 1e-9),
     (0.25, 0.05, 0.27, 0.282327218, "it stops twice a period", 1e-9),
     (0.5, 0.05, 0.3, 0.287808502, "it slides without stops", 1e-9),
     (0.3, 1 / 3, 0.05, 0.047206091, "it slides without stops", 1e-9),
     (0.8, 0.05, 0.7, 0.729441, "it stops twice a period", 1e-6),
     (5.0, 1 / 3, 0.5, 0.512873, "it stops twice a period", 1e-6)],
)  # fmt: skip
def test_number_of_stops_changes_at_the_known_friction(
    tmp_path, beta, zeta, phi, known, sentence, error
):
    found = unit_plane(tmp_path, beta, zeta, phi)
    ends = [
        phi + one.distance
        for one in found.place.changes
        if one.key == "friction.kinetic" and one.sentence == sentence
    ]
    assert min(ends, key=lambda end: abs(end - known)) == pytest.approx(known, abs=error)


@pytest.fixture(scope="module")
def paper(tmp_path_factory):
    """Return the map of the paper's oscillator over frequency and friction."""
    return drysim.map_regimes(load_text(tmp_path_factory.mktemp("paper"), PAPER + OVER))


def lines(found: drysim.RegimeMap, name: str) -> list[np.ndarray]:
    """Return the lines of a boundary."""
    return [one.points for one in found.boundaries if one.name == name]


def test_mass_is_locked_where_the_static_limit_exceeds_the_inertia_force(paper):
    (locked,) = lines(paper, "locked | 2 stops a period")
    force = 75.0 * np.sqrt(2.0) / 1.2
    assert locked[:, 1] == pytest.approx(force, rel=1e-10)
    assert sorted(locked[[0, -1], 0]) == pytest.approx([0.25, 10.0])
    assert ((paper.labels[REGIME] == LOCKED) == (paper.nodes[1][:, None] >= force)).all()


def test_isolation_begins_at_root_two_times_the_natural_frequency_without_friction(paper):
    (line,) = lines(paper, "T_a = 1")
    lowest = line[np.argmin(line[:, 1])]
    assert lowest == pytest.approx([np.sqrt(2.0) * 10.0 / (2.0 * np.pi), 0.0], abs=1e-10)


def test_every_point_of_a_line_separates_the_motions_that_it_names(paper):
    scenario = paper.scenario
    for name, below, above in (("sliding without stops | 2 stops a period", 0, 2),):
        (line,) = lines(paper, name)
        for f, force in line[5:-5:9].tolist():
            for change, stops in ((-1e-6, below), (1e-6, above)):
                point = {"excitation.frequency": f, "friction.kinetic": force * (1 + change)}
                events = drysim.run(scenario.at(point)).events.kind
                assert np.count_nonzero(events[1:] == 0) == stops, (f, force)
    (line,) = lines(paper, "stroke limit reached")
    for f, force in line[1:-1:5].tolist():
        point = {"excitation.frequency": f, "friction.kinetic": force}
        peak = drysim.run(scenario.at(point)).metrics["x_r_peak"]
        assert peak == pytest.approx(0.015, rel=1e-9)


def test_second_motion_ends_at_its_fold(tmp_path):
    # The paper's Fig. 4 at 0.50 m/s²: locked from rest; a stable orbit exists up to the fold.
    text = PAPER.replace("rms: 1.0", "rms: 0.5").replace("frequency: 1.6", "frequency: 1.0")
    over = """
sweep:
  excitation.frequency: {from: 0.4, to: 1.2, count: 33}
  friction.static_ratio: {from: 1, to: 1.5, count: 33}
"""
    for frequency, fold in ((0.5, 1.38072), (1.0, 1.23209)):
        scenario = load_text(tmp_path, text + over, **{"excitation.frequency": frequency})
        found = drysim.map_regimes(scenario)
        assert found.place.labels[REGIME] == LOCKED
        assert found.place.labels[SEVERAL] == 1
        (end,) = (
            1.2 + one.distance for one in found.place.changes
            if one.sentence == "a second stable motion ends" and one.distance > 0.0
            and one.key == "friction.static_ratio"
        )  # fmt: skip
        assert end == pytest.approx(fold, abs=2e-5)
        assert "another start leads to another stable motion" in found.describe_place()


@pytest.mark.slow
def test_loss_of_symmetry_is_found_within_the_reported_strip(tmp_path):
    # Shaw (1986); next to it the motion settles too slowly, so the boundary is a strip.
    found = unit_plane(tmp_path, 0.5, 0.05, 0.23, 2.0)
    broken = [
        one for one in found.boundaries
        if one.name == "2 stops a period | unsymmetric, 2 stops a period"
    ]  # fmt: skip
    (less,) = (one for one in found.place.changes if one.key == "friction.kinetic")
    assert less.sentence == "it stops twice a period, unsymmetrically"
    assert 0.23 + less.distance == pytest.approx(0.217466646, abs=5e-4)
    assert max(one.width for one in broken) > 0.0


def test_number_of_workers_changes_no_byte(command, tmp_path, monkeypatch):
    (tmp_path / "plane.yaml").write_text(f"drysim: 1\n{PAPER}{OVER}")
    for name in ("MIN_TIME_PER_WORKER", "MIN_CHUNK_TIME"):  # nothing is too short for a process
        monkeypatch.setattr(f"drysim.parallel.{name}", 1e-9)
    results = []
    for workers in (1, 2, 3):
        words = ("--no-plots", "--quiet", "--workers", workers, "--out", workers)
        assert command("map", "plane.yaml", *words).code == 0
        fields = fields_of(tmp_path / str(workers))
        contents = (tmp_path / str(workers) / "map.csv").read_bytes()
        results.append((contents, fields["map"], fields["numerics"]))
    assert results[0] == results[1] == results[2]


def test_shares_of_regimes_are_areas(paper):
    locked = 1.0 - 75.0 * np.sqrt(2.0) / 1.2 / 120.0
    assert paper.regimes["locked"] == pytest.approx(locked, rel=1e-9)
    assert sum(paper.regimes.values()) == pytest.approx(1.0, rel=1e-7)


def test_answers_to_no_scenes_have_all_columns_on_the_plain_engine(monkeypatch):
    # Where no edge has a boundary, none is bisected. The plain engine has lists.
    monkeypatch.setattr("drysim.orbits.coulomb.as_engine_array", np.ndarray.tolist)
    monkeypatch.setattr("drysim.core.orbit.solve_orbits", lambda *_: None)
    assert solve_orbits(np.empty((0, SINES + 3))).shape == (0, ANSWER_COLUMNS)


def test_mass_without_friction_has_no_stops_and_one_motion(tmp_path):
    text = PAPER.replace("friction: {law: coulomb, kinetic: 45, static_ratio: 1.2}\n", "")
    over = """
sweep:
  excitation.frequency: {from: 0.5, to: 5, count: 33}
  oscillator.damping: {from: 50, to: 1000, count: 33}
"""
    found = drysim.map_regimes(load_text(tmp_path, text + over))
    assert {*found.shares} == {0}
    (line,) = lines(found, "T_a = 1")
    assert line[:, 0] == pytest.approx(np.sqrt(2.0) * 10.0 / (2.0 * np.pi), abs=1e-9)
    assert SEVERAL not in found.labels


def test_scenario_outside_of_the_map_has_a_regime_and_no_distances(tmp_path):
    found = drysim.map_regimes(load_text(tmp_path, PAPER + OVER, **{"friction.kinetic": 300}))
    assert found.place.labels == {REGIME: LOCKED, ISOLATION: LOCKED, STROKE: 0, SEVERAL: 0}
    assert found.place.changes == ()


def test_nearest_change_of_regime_is_named_behind_other_boundaries(tmp_path):
    scenario = load_text(
        tmp_path, PAPER + OVER, **{"excitation.frequency": 1.2, "friction.kinetic": 28}
    )
    place = drysim.map_regimes(scenario).place
    more = [
        (one.field, one.sentence)
        for one in place.changes
        if one.key == "friction.kinetic" and one.distance > 0.0
    ]
    assert more == [
        (STROKE, "it stays within the stroke limit"),
        (REGIME, "it stops twice a period"),
    ]
    assert place.nearest is not None
    assert place.nearest.field == REGIME
    assert abs(place.nearest.share) == min(
        abs(one.share) for one in place.changes if one.field == REGIME
    )


def test_sentence_of_a_boundary_depends_on_its_direction():
    assert describe_change(ISOLATION, 1) == "isolation begins, T_a falls below 1"
    assert describe_change(ISOLATION, 0) == "isolation ends, T_a rises above 1"
    assert describe_change(STROKE, 1) == "it reaches the stroke limit"
    assert describe_change(STROKE, 0) == "it stays within the stroke limit"


# Joining of crossings.


def test_lines_follow_the_regions_of_a_checkerboard_and_meet_where_three_do():
    grid = Grid(3, 3)
    points = np.stack(np.meshgrid([0, 0.5, 1], [0, 0.5, 1]), axis=-1).reshape(-1, 2)
    for labels in ([0, 0, 1, 0, 0, 1, 2, 2, 1], [0, 1, 0, 1, 0, 1, 0, 1, 0]):
        labels = np.array(labels)
        ends = labels[grid.edges]
        crossings = {
            int(i): [Crossing(0.5, int(a), int(b), 0.0)]
            for i, (a, b) in enumerate(ends.tolist())
            if a != b
        }
        joined = join_crossings(grid, points, labels, crossings)
        ends = [n for several in joined.segments.values() for pair in several for n in pair]
        # Within the map every line goes on; it ends at the edge of the map.
        counts = np.bincount(ends)
        for number, count in enumerate(counts.tolist()):
            inner = all(0.0 < x < 1.0 for x in joined.points[number])
            assert count >= (2 if inner else 1)
        cells = {cell for edge in crossings for cell in grid.cells_at(edge)}
        assert sum(areas_of(joined).values()) == pytest.approx(0.25 * len(cells))


def test_polylines_use_each_segment_once_and_close_loops():
    found = sorted(polylines([(1, 2), (3, 2), (3, 4), (7, 8), (8, 9), (9, 7)]), key=len)
    assert found[0] in ([1, 2, 3, 4], [4, 3, 2, 1])
    assert found[1][0] == found[1][-1]
    assert {*found[1]} == {7, 8, 9}


def test_unsettled_strip_within_an_edge_is_one_boundary():
    first, last = Crossing(0.2, 2, UNSETTLED, 0.0), Crossing(0.4, UNSETTLED, 5, 0.0)
    (one,) = merge_unsettled([first, last])
    assert (one.share, one.before, one.after, one.width) == pytest.approx((0.3, 2, 5, 0.2))
    assert merge_unsettled([first, last._replace(after=2)]) == []
    (one,) = merge_unsettled([first, last._replace(after=LOCKED)])
    assert (one.share, one.width) == (0.4, 0.0)


def test_band_between_two_columns_of_nodes_goes_on_from_cell_to_cell():
    grid = Grid(2, 4)
    along, across = grid.shares
    points = np.stack(np.meshgrid(along, across), axis=-1).reshape(-1, 2)
    narrow = [Crossing(0.5, 0, 1, 0.0), Crossing(0.51, 1, 0, 0.0)]
    joined = join_crossings(
        grid, points, np.zeros(8, dtype=int), dict.fromkeys(range(4), narrow)
    )
    lines = [
        np.array([joined.points[i] for i in line]) for line in polylines(joined.segments[0, 1])
    ]
    assert sorted(sorted({*line[:, 0]}) for line in lines) == [[0.5], [0.51]]
    assert areas_of(joined) == pytest.approx({0: 0.99, 1: 0.01})


def test_bands_within_each_other_fill_a_cell():
    grid = Grid(2, 2)
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    across = [Crossing(0.5, 0, 1, 0.0), Crossing(0.6, 1, 2, 0.0), Crossing(0.9, 2, 3, 0.0)]
    joined = join_crossings(grid, points, np.array([0, 3, 0, 3]), {0: across, 1: across})
    assert areas_of(joined) == pytest.approx({0: 0.5, 1: 0.1, 2: 0.3, 3: 0.1})


def areas_of(joined: Joined) -> dict[int, float]:
    """Return the area of each label in the divided cells."""
    areas = Counter[int]()
    for label, polygon in joined.patches:
        areas[label] += polygon_area(polygon)
    return dict(areas)


def test_regimes_have_names():
    assert [describe_regime(one) for one in (UNSETTLED, LOCKED, 0, 2, UNSYMMETRIC + 1)] == [
        "no single steady motion", "locked", "sliding without stops", "2 stops a period",
        "unsymmetric, 1 stop a period",
    ]  # fmt: skip
    assert describe_regime(PERIODS) == "repeats after several periods"


def test_legend_of_a_map_names_the_point_of_the_scenario(paper):
    (legend,) = paper.plot().legends
    assert [text.get_text() for text in legend.get_texts()] == ["this scenario"]


# The command.


def test_weighting_and_checks_of_it_change_nothing(tmp_path):
    weighted = "measure: {direction: vertical, exposure: 4 h}\nchecks: [SEAT < 0.9, T_a < -1]\n"
    small = OVER.replace("33", "5")
    plain, result = (
        drysim.map_regimes(load_text(tmp_path, PAPER + small + more)) for more in ("", weighted)
    )
    assert (result.labels[REGIME] == plain.labels[REGIME]).all()
    assert not result.warnings
    assert [verdict.passed for verdict in result.checks] == [None, None]


def test_command_writes_lines_picture_and_report(command, tmp_path):
    (tmp_path / "plane.yaml").write_text(f"drysim: 1\n{PAPER}{OVER}")
    done = command("map", "plane.yaml", "--report")
    assert done.code == 0, done.err
    assert "2.67 N more" in done.out
    folder = tmp_path / "out" / "plane-map"
    assert {file.name for file in folder.iterdir()} >= {
        "map.csv",
        "map.png",
        "report.html",
        "scenario.yaml",
    }
    rows = list(csv.reader((folder / "map.csv").read_text().splitlines()))
    assert rows[0] == [
        "boundary",
        "line [-]",
        "excitation.frequency [Hz]",
        "friction.kinetic [N]",
    ]
    assert {row[0] for row in rows[1:]} >= {"T_a = 1", "locked | 2 stops a period"}
    fields = fields_of(folder)
    assert fields["map"]["here"]["motion"][0] == "sliding without stops"
    summary = command("summarise", str(folder))
    assert re.search(r"kinetic +2\.67 N more +it stops twice a period", summary.out)
    sentence = "2.67 N more friction.kinetic: it stops twice a period."
    assert sentence in fields["summary"]["answer"]
    again = command("report", str(folder), "--out", "again.html")
    assert again.code == 0, again.err


@pytest.mark.parametrize(
    ("text", "words"),
    [(PAPER, "sweep is required: its two keys are the axes"),
     (PAPER + "sweep: {friction.kinetic: {from: 1, to: 9, count: 5}}",
      "sweep has 1: friction.kinetic; add a second one"),
     (PAPER + "sweep: {friction.kinetic: [1, 2], oscillator.mass: {from: 1, to: 9, count: 5}}",
      "friction.kinetic has a list of values; a map needs a range"),
     (PAPER + "sweep: {solver.step: {from: 1e-3, to: 2e-3, count: 5}, "
      "oscillator.mass: {from: 1, to: 9, count: 5}}", "solver.step cannot be an axis"),
     (PAPER + "sweep: {zip: {friction.kinetic: [1, 2], oscillator.mass: [1, 2]}}",
      "sweep.zip varies keys together"),
     (SPECTRUM, "excitation.kind shock has no periodic orbits"),
     (PAPER + "sweep: {friction.kinetic: {from: 1, to: 9, count: 5}, direction: up}",
      "sweep.direction does not apply to `drysim map`"),
     (PAPER + "sweep: {friction.kinetic: {from: 1, to: 9, count: 5000}, "
      "oscillator.mass: {from: 1, to: 9, count: 5000}}", "25000000 nodes"),
     (PAPER.replace("law: coulomb, kinetic: 45, static_ratio: 1.2",
                    "law: stribeck, kinetic: 45, static: 50, stribeck_velocity: 0.1")
      + "sweep: {oscillator.damping: {from: 100, to: 900, count: 5}, "
      "oscillator.mass: {from: 1, to: 9, count: 5}}",
      "friction.law stribeck is not supported"),
     (PAPER.replace("{limit: 15 mm}", "{limit: 15 mm, stops: {restitution: 0.5}}") + OVER,
      "end stops, which a map does not support"),
     (PAPER.replace("static_ratio: 1.2", "static: 50") + OVER,
      "static")],
    ids=["no-sweep", "one-key", "list", "step", "zip", "srs", "direction", "nodes",
         "law", "stops", "static"],
)  # fmt: skip
def test_what_a_map_does_not_support_is_located(command, tmp_path, text, words):
    (tmp_path / "plane.yaml").write_text(f"drysim: 1\n{text}\n")
    done = command("map", "plane.yaml")
    assert done.code == 2, done.out
    assert words in done.err
    assert "plane.yaml:" in done.err
    assert "Traceback" not in done.err
    assert not (tmp_path / "out").exists()


COEXISTING = """
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 36, static_ratio: 1.5}
excitation: {kind: harmonic, frequency: 0.4, amplitude: 0.8}
solver: {step: 0.0125}
sweep:
"""


def test_second_motion_ends_at_the_fold_of_its_branch_within_the_stated_width(tmp_path):
    ratios, forces = "{from: 1, to: 3.5, count: 33}", "{from: 20, to: 50, count: 33}"
    keys = f"  friction.static_ratio: {ratios}\n  friction.kinetic: {forces}\n"
    lines = drysim.map_regimes(load_text(tmp_path, COEXISTING + keys)).boundaries
    ends = [line for line in lines if line.field == SEVERAL]
    points = np.concatenate([line.points for line in ends])
    assert all(0.0 < line.width < 1e-7 for line in ends)
    # Along the ratio at a force of the grid: from a fold at 35 N.
    at = points[(points[:, 1] == 35.0) & (points[:, 0] > 2.5), 0]
    assert len(at) == 1
    along = f"  friction.static_ratio: {{from: {at[0] - 0.05}, to: {at[0] + 0.05}, count: 9}}\n"
    text = (COEXISTING + along).replace("kinetic: 36", "kinetic: 35")
    found = drysim.branches(load_text(tmp_path, text)).bifurcations
    folds = [float(one.value) for one in found if one.kind == "fold"]
    width = max(line.width for line in ends) * 2.5
    assert min(abs(fold - at[0]) for fold in folds) <= 0.5 * width


def test_second_motion_narrower_than_a_cell_is_followed_to_its_folds(tmp_path):
    # Next to the locked mass, between 58.74 N and folds that come closer with the frequency.
    text = """
oscillator: {mass: 90, stiffness: 6000, damping: 500}
friction: {law: coulomb, kinetic: 40, static_ratio: 1.3}
excitation: {kind: harmonic, frequency: 1.5, rms: 0.6}
solver: {step: 0.01}
sweep:
  friction.kinetic: {from: 0, to: 80, step: 2}
"""
    over = "  excitation.frequency: {from: 0.5, to: 5, count: 37}\n"
    result = drysim.map_regimes(load_text(tmp_path, text + over))
    assert not result.labels[SEVERAL][result.nodes[1] > 1.7].any()
    onset, folds = sorted(lines(result, "several stable motions"), key=lambda line: line[-1, 0])
    assert onset[:, 0] == pytest.approx(90 * 0.6 * np.sqrt(2) / 1.3, rel=1e-7)
    for line in (onset, folds):
        assert sorted(line[[0, -1], 1]) == pytest.approx([0.5, 5.0])
    ends = [line[np.argsort(line[:, 1])] for line in (onset, folds)]
    outline = np.concatenate([ends[0], ends[1][::-1]])
    assert result.share(SEVERAL) == pytest.approx(polygon_area(outline) / (80 * 4.5), rel=1e-6)
    (fold,) = folds[folds[:, 1] == 2.5, 0]
    upper = over.replace("0.5", "2").replace("37", "33")
    picture = drysim.map_regimes(load_text(tmp_path, text + upper)).plot()
    assert "several stable motions" in [label.get_text() for label in picture.axes[0].texts]
    point = {"excitation.frequency": 2.5}
    found = drysim.branches(load_text(tmp_path, text, **point)).bifurcations
    values = [float(one.value) for one in found if one.kind == "fold"]
    assert min(abs(value - fold) for value in values) <= 80 * 1e-7
