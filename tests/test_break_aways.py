"""Break-aways under random base motion: counts, Rice's formula, the map of rates."""

from __future__ import annotations

from math import exp, log, sqrt

import numpy as np
import pytest
from seat import fields_of

import drysim
from drysim.study.boundaries import REGIME
from drysim.study.break_aways import (
    FIRST,
    LEVELS,
    RICE,
    Rates,
    count_break_aways,
    describe_label,
    level_between,
    measure_rates,
    rice_rate,
)
from drysim.study.run import MotionCache

LOW, HIGH, DENSITY = 1.0, 20.0, 0.05
SIGMA = sqrt(DENSITY * (HIGH - LOW))
ZERO_CROSSINGS = sqrt((HIGH**3 - LOW**3) / (3.0 * (HIGH - LOW)))
"""RMS [m/s²] and rate of upward zero crossings [Hz] of noise with a flat PSD."""

SEAT = f"""
oscillator: {{mass: 50, stiffness: 100, damping: 300}}
friction: {{law: coulomb, kinetic: 100}}
excitation:
  {{kind: psd, points: [[{LOW}, {DENSITY}], [{HIGH}, {DENSITY}]], duration: 60, seed: 1}}
solver: {{step: 2 ms}}
"""
OVER = """
sweep:
  friction.kinetic: {from: 25, to: 250, count: 10}
  oscillator.mass: {from: 40, to: 120, count: 9}
"""


def test_rice_rate_follows_from_the_moments_of_the_psd():
    motion = drysim.run(drysim.scenario(SEAT)).scenario.excitation.sample(1e-3)
    for level in (0.0, 1.0, 2.0, 3.0):
        known = 2.0 * ZERO_CROSSINGS * exp(-0.5 * level**2)
        assert rice_rate(motion, level * SIGMA) == pytest.approx(known, rel=0.02)


def test_rare_break_aways_are_the_exceedances_of_the_static_limit():
    # Between them the mass sticks: each time |ü| leaves the band ±F_fs/m it breaks away once.
    threshold = 2.5 * SIGMA
    scenario = drysim.scenario(SEAT, {"friction.kinetic": 50 * threshold})
    result = drysim.run(scenario)
    beyond = np.abs(scenario.excitation.sample(2e-3).u_dd) > threshold
    exceedances = np.count_nonzero(beyond[1:] & ~beyond[:-1])
    counted = count_break_aways(result.events, 0.0, 60.0)
    assert exceedances > 50
    assert abs(counted - exceedances) <= 0.05 * exceedances


def test_counted_rate_agrees_with_rice_where_the_mass_mostly_sticks():
    text = SEAT.replace("seed: 1", "seed: 1, seeds: 8")
    scenario = drysim.scenario(text, {"friction.kinetic": 50 * 2.7 * SIGMA})
    counted, rice, _ = measure_rates(scenario, MotionCache())
    number = rice * 8 * 60.0
    assert number > 200.0
    assert abs(counted - rice) < 4.0 * rice / sqrt(number)


DRAWN = """
oscillator: {{mass: 75, natural_frequency: {f_0}, damping_ratio: {xi}}}
friction: {{law: coulomb, kinetic: {F_fk}, static_ratio: {ratio}}}
excitation:
  {{kind: psd, points: [[{band[0]}, 1.0], [{band[1]}, 1.0]], rms: 1, duration: 200, seed: 1}}
solver: {{step: 2 ms}}
"""


def test_rice_rate_is_given_where_it_holds_and_is_wrong_by_far_elsewhere():
    draw, given, refused = np.random.default_rng(0), 0, []
    for _ in range(24):
        F_fs = 75.0 * draw.uniform(1.0, 3.0)
        ratio = float(draw.choice([1.0, 1.2, 2.0, 5.0, 20]))
        f_0, xi = float(draw.choice([0.5, 1.6, 5.0])), float(draw.choice([0.05, 0.3, 1.0]))
        band = [(0.5, 2.0), (1.0, 10.0), (5.0, 40.0)][int(draw.integers(3))]
        text = DRAWN.format(f_0=f_0, xi=xi, F_fk=F_fs / ratio, ratio=ratio, band=band)
        scenario = drysim.scenario(text)
        rates = measure_rates(scenario, MotionCache())
        formula = rice_rate(scenario.excitation.sample(2e-3), F_fs / 75.0)
        number = 200.0 * rates.counted
        if rates.rice is None:
            refused.append(max(rates.counted / formula, formula / max(rates.counted, 1e-9)))
            assert "the mass sticks" in str(rates)
            assert "does not apply, as" in str(rates)
        else:
            given += 1
            assert rates.rice == formula
            assert not rates.reason
            scatter = 3.0 * sqrt(number + 9.0) / 200.0
            assert abs(rates.counted - formula) < 0.4 * formula + scatter
    assert given > 6
    assert max(refused) > 5.0


def test_mass_that_never_sticks_never_breaks_away():
    scenario = drysim.scenario(SEAT, {"friction.kinetic": 0})
    assert measure_rates(scenario, MotionCache()).counted == 0.0


@pytest.fixture(scope="module")
def noise_map():
    """Return the map of rates over friction and mass."""
    return drysim.map_regimes(drysim.scenario(SEAT + OVER))


def test_lines_of_rice_are_at_the_friction_of_their_rate(noise_map):
    found = [line for line in noise_map.boundaries if line.field == RICE]
    assert {level_between(line.labels) for line in found} == {0.1, 1.0, 10.0}
    for line in found:
        rate = level_between(line.labels)
        force = SIGMA * sqrt(2.0 * log(2.0 * ZERO_CROSSINGS / rate)) * line.points[:, 1]
        assert line.points[:, 0] == pytest.approx(force, rel=0.04)


def test_labels_of_the_nodes_are_their_counted_rates(noise_map):
    scenario = noise_map.scenario.copy_with({"sweep": ()})
    forces, masses = (nodes.tolist() for nodes in noise_map.nodes)
    for i, j in ((0, 0), (4, 5), (9, 2)):
        point = {"friction.kinetic": forces[i], "oscillator.mass": masses[j]}
        counted = measure_rates(scenario.at(point), MotionCache()).counted
        label = int(noise_map.labels[REGIME][j, i])
        assert counted < level_between((label, label + 1))
        assert label == FIRST + 2 or counted >= level_between((label - 1, label))


def test_scenario_itself_has_both_rates_and_its_distances(noise_map):
    place = noise_map.place
    assert place.rates == measure_rates(
        noise_map.scenario.copy_with({"sweep": ()}), MotionCache()
    )
    assert {one.field for one in place.changes} == {REGIME}
    assert "1 break-away a second" in {one.sentence for one in place.changes}
    (words,) = noise_map.describe_place()
    assert words == str(place.rates)
    assert str(Rates(0.25, 0.5)) == "breaks away 0.25 times a second, 0.5 by Rice's formula"


def test_map_of_rates_does_not_depend_on_the_number_of_threads(noise_map):
    alone = drysim.map_regimes(drysim.scenario(SEAT + OVER), workers=1)
    for one, other in zip(noise_map.boundaries, alone.boundaries, strict=True):
        assert one.name == other.name
        assert np.array_equal(one.points, other.points)


def test_command_writes_the_lines_of_both_rates(command, tmp_path):
    (tmp_path / "noise.yaml").write_text(SEAT + OVER)
    done = command("map", "noise.yaml", "--report")
    assert done.code == 0, done.err
    assert "by Rice's formula" in " ".join(done.out.split())
    folder = tmp_path / "out" / "noise-map"
    lines = {row.partition(",")[0] for row in (folder / "map.csv").read_text().splitlines()}
    assert {"1 break-away a second", "1 break-away a second by Rice's formula"} <= lines
    rates = fields_of(folder)["map"]["here"]["rates"]
    assert rates["counted"] > 0.0
    assert rates["rice"] > 0.0


@pytest.mark.parametrize(
    ("change", "words"),
    [("friction.static_ratio={from: 1, to: 1.2}", "friction.static_ratio"),
     ("solver.approach=signum", "needs the approach stick-slip"),
     ("friction.normal_variation={amplitude: 0.5, frequency: 1}", "a constant normal force"),
     ("excitation.until={metric: T_a, half_width: 1%}", "excitation.until is not supported")],
)  # fmt: skip
def test_what_a_map_of_rates_does_not_support_is_refused(refused, tmp_path, change, words):
    (tmp_path / "noise.yaml").write_text(SEAT + OVER)
    assert words in " ".join(refused("map", "noise.yaml", "--set", change).split())


def test_rates_between_two_levels_are_written_as_a_range():
    labels = range(FIRST, FIRST + len(LEVELS) + 1)
    texts = [describe_label(label) for label in labels]
    assert texts[0] == "up to 0.001 break-aways a second"
    assert texts[4] == "1 to 10 break-aways a second"
    assert texts[-1] == "above 100 break-aways a second"
