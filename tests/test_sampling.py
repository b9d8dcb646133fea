"""Samples and keys that walk together: what they draw, how a file says them, their faults."""

from __future__ import annotations

import json
from inspect import signature

import numpy as np
import pytest

from drysim.errors import ScenarioError
from drysim.quantity import Quantity
from drysim.scenario import schema
from drysim.scenario.axes import count_points, iter_points, point_columns
from drysim.scenario.load import load
from drysim.scenario.sampling import Design, LogNormal, Normal, Triangular, Uniform
from drysim.scenario.warnings import extreme_cases, scenario_warnings
from drysim.study.sweep import sweep
from drysim.yaml_document import dump

stats = pytest.importorskip("scipy.stats")

BASE = """\
drysim: 1
name: sampled
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15, static: 15}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {approach: stick-slip, step: 2.5e-3}
"""

OVER = {
    "oscillator.mass": {"distribution": "normal", "mean": "75 kg", "sd": 5, "from": 50},
    "oscillator.damping": {"from": 100, "to": "1 kN*s/m", "scale": "log"},
}
STOPS = "stroke: {limit: 20 mm, stops: {restitution: 0.5}}\n"
TWO, ENDS = [1, 2], {"from": 1, "to": 2}
GAUSS = {"distribution": "normal", "mean": 75, "sd": 5}
SAMPLE = {"kind": "latin", "count": 40, "seed": 7, "over": OVER}


@pytest.fixture
def scenario(scenario):
    """Return the scenario of a sweep block."""
    return lambda block, more="": scenario(BASE + more + dump({"sweep": block}))


@pytest.fixture
def fault(scenario):
    """Return the messages on a faulty sweep block."""

    def told(block):
        with pytest.raises(ScenarioError) as found:
            scenario(block)
        return [problem.sentence for problem in found.value.problems]

    return told


@pytest.mark.parametrize("kind", ["latin", "sobol", "uniform"])
def test_point_of_a_design_is_known_by_its_number_alone(kind):
    design = Design(kind, 10_000, 3, 5)
    whole = design.take(np.arange(10_000))
    some = np.array([9_999, 3, 4, 4096, 3])
    assert np.array_equal(design.take(some), whole[some])
    assert whole.min() >= 0
    assert whole.max() < 1
    assert abs(whole.mean(axis=0) - 0.5).max() < 0.02
    assert not np.array_equal(Design(kind, 10_000, 3, 6).take(some), whole[some])


@pytest.mark.parametrize(("dimensions", "count"), [(1, 16), (3, 1000), (7, 4096)])
@pytest.mark.filterwarnings("ignore:The balance properties:UserWarning")
def test_sobol_design_is_that_of_scipy(dimensions, count):
    word = "rng" if "rng" in signature(stats.qmc.Sobol).parameters else "seed"
    engine = stats.qmc.Sobol(dimensions, **{word: np.random.default_rng(3)})
    points = Design("sobol", count, dimensions, 3).take(np.arange(count))
    assert np.array_equal(points, engine.random(count))


@pytest.mark.parametrize("count", [1, 2, 7, 1000, 4097])
def test_latin_design_has_one_point_in_every_layer(count):
    layers = np.floor(Design("latin", count, 4, 1).take(np.arange(count)) * count)
    for column in layers.T:
        assert sorted(column.tolist()) == list(range(count))
    if count > 100:
        assert abs(np.corrcoef(layers.T) - np.eye(4)).max() < 0.1


@pytest.mark.parametrize(
    ("law", "known"),
    [
        (Uniform(2.0, 5.0), stats.uniform(2, 3)),
        (Uniform(2.0, 50.0, True), stats.loguniform(2, 50)),
        (Normal(75.0, 5.0), stats.norm(75, 5)),
        (Normal(75.0, 5.0, 70.0, 90.0), stats.truncnorm(-1, 3, 75, 5)),
        (Triangular(1.0, 2.0, 5.0), stats.triang(0.25, 1, 4)),
        (LogNormal(2.0, 1.0), stats.lognorm(np.log(1.25) ** 0.5, scale=2 / 1.25**0.5)),
    ],
)
def test_quantiles_are_those_of_the_known_distribution(law, known):
    shares = np.linspace(0.001, 0.999, 97)
    assert law.quantile(shares) == pytest.approx(known.ppf(shares), rel=1e-9)


@pytest.mark.parametrize(
    ("low", "high"), [(4.5, 6), (8.2, 225), (9, 15), (37, 39), (50, 51), (1e4, np.inf)]
)
def test_samples_of_a_far_tail_scatter_and_lie_at_its_near_end(low, high):
    shares = np.array([1e-6, 0.01, 0.3, 0.5, 0.9, 0.999])
    mp = pytest.importorskip("mpmath").mp
    with mp.workdps(40):
        above = Normal(75.0, 1.0, 75.0 + low, 75.0 + high).quantile(shares)
        below = Normal(75.0, 1.0, 75.0 - high, 75.0 - low).quantile(1.0 - shares)
        ends = [mp.erfc(mp.mpf(end) / mp.sqrt(2)) for end in (75.0 + low - 75.0, high)]
        for share, value in zip(shares, above, strict=True):
            beyond = mp.erfc((mp.mpf(float(value)) - 75) / mp.sqrt(2))
            told = (ends[0] - beyond) / (ends[0] - ends[1])
            rounding = 1e-13 * float(value) ** 2  # of scipy's `ndtri_exp`
            assert float(told) == pytest.approx(share, abs=1e-10 + rounding)
    assert below == pytest.approx(150.0 - above, abs=1e-9)
    assert np.all(np.diff(above) > 0)


def test_lognormal_of_a_far_tail_is_the_normal_of_its_logarithm():
    law = LogNormal(75.0, 1.0, 1.0, 20.0)
    width = np.log1p(1 / 75**2) ** 0.5
    ends = [(np.log(end / 75.0) + width**2 / 2) / width for end in (1.0, 20.0)]
    known = stats.truncnorm(*ends, np.log(75.0) - width**2 / 2, width)
    shares = np.linspace(0.001, 0.999, 97)
    assert law.quantile(shares) == pytest.approx(np.exp(known.ppf(shares)), rel=1e-9)


@pytest.mark.parametrize("law", [Normal, LogNormal])
@pytest.mark.parametrize("sd", [1e-320, 1e-200, 1e-9])
def test_tail_beyond_all_numbers_lies_at_its_near_end(law, sd):
    shares = np.array([0.0, 0.5, 1.0 - 2.0**-53])
    assert law(75.0, sd, 1.0, 30.0).quantile(shares) == pytest.approx(30.0)
    assert law(75.0, sd, 80.0, 300.0).quantile(shares) == pytest.approx(80.0)


def test_widest_of_lognormals_is_drawn_in_numbers():
    assert np.all(np.isfinite(LogNormal(75.0, 1e200).quantile(np.array([0.1, 0.5]))))


def test_sample_beside_a_grid_multiplies_it(scenario):
    found = scenario({"excitation.frequency": [1, 2], "sample": SAMPLE})
    assert count_points(found.sweep) == 80
    every = list(iter_points(found.sweep))
    assert [p["excitation.frequency"] for p in every[:4]] == [1, 2, 1, 2]
    assert every[0]["oscillator.mass"] == every[1]["oscillator.mass"]
    assert len({p["oscillator.mass"] for p in every}) == 40
    columns = point_columns(found.sweep, 13, 29)
    assert [float(x) for x in columns["oscillator.damping"]] == [
        p["oscillator.damping"] for p in every[13:29]
    ]


def test_keys_of_a_zip_walk_together(scenario):
    walk = {"friction.kinetic": [15, 30], "friction.static": ["18 N", 36]}
    found = scenario({"zip": walk, "excitation.rms": [0.5, 1]})
    assert [tuple(p.values()) for p in iter_points(found.sweep)] == [
        (15, 18, 0.5), (30, 36, 0.5), (15, 18, 1), (30, 36, 1)
    ]  # fmt: skip


def test_several_zips_are_a_grid(scenario):
    one = {"friction.kinetic": [1, 2], "friction.static": [3, 4]}
    damping = {"from": 1, "to": 3, "step": 1}
    other = {"oscillator.mass": [60, 70, 80], "oscillator.damping": damping}
    assert count_points(scenario({"zip": [one, other]}).sweep) == 6


def test_resolved_block_runs_again_as_it_is(scenario, tmp_path):
    walk = {"friction.kinetic": [15, 30], "friction.static": [18, 36]}
    found = scenario({"zip": [walk], "sample": SAMPLE})
    (tmp_path / "again.yaml").write_text(dump(found.resolved()))
    again = load(tmp_path / "again.yaml")
    assert list(iter_points(again.sweep)) == list(iter_points(found.sweep))
    assert again.resolved() == found.resolved()


def test_sweep_of_a_sample_leaves_keys_out_that_the_reference_has_no_use_for(scenario):
    found = scenario({"zip": {"friction.kinetic": [15, 30], "friction.static": [18, 36]},
                      "sample": SAMPLE | {"count": 5}})  # fmt: skip
    table = sweep(found.copy_with({"reference": "viscous"}))
    assert [len(list(table.of(name))) for name in table.approaches] == [10, 5]
    assert set(table[10].point) == set(OVER)


def changed(**words):
    """Return a sample with other words in it."""
    return {"sample": {k: v for k, v in {**SAMPLE, **words}.items() if v is not None}}


@pytest.mark.parametrize(
    ("block", "words"),
    [
        (changed(kind="lattice"), "sweep.sample.kind must be latin, sobol or uniform"),
        (changed(count=0), "sweep.sample.count must be 1 to"),
        (changed(count=2.5), "sweep.sample.count must be a whole number"),
        (changed(seed=None), "sweep.sample.seed is required"),
        (changed(sed=1), "unknown key `sed`"),
        (changed(over={"oscillator.mas": ENDS}), "did you mean `oscillator.mass`"),
        (changed(over={"oscillator.mass": {"from": 1}}), "to is required (uniform)"),
        (changed(over={"oscillator.mass": {"from": 2, "to": 1}}), "must be above `from`, 2"),
        (changed(over={"oscillator.mass": {"from": -2, "to": 1}}), "must be above 0 kg"),
        (changed(over={"oscillator.mass": GAUSS | {"sd": 0, "from": 1}}),
         "sd must be above 0 kg"),
        (changed(over={"oscillator.mass": {"from": 1, "to": 2, "mean": 1}}),
         "is not used for a uniform distribution"),
        (changed(over={"oscillator.mass": {"from": 1, "to": 2, "distribution": "gauss"}}),
         "must be uniform, normal, lognormal, triangular"),
        (changed(over={}), "must be keys"),
        ({"sample": [1]}, "sweep.sample must be {kind: latin"),
        ({"zip": {"friction.kinetic": [1, 2]}}, "sweep.zip must be at least two keys"),
        ({"zip": {"friction.kinetic": [1, 2], "oscillator.mass": [1, 2, 3]}},
         "has 3 values, but friction.kinetic has 2"),
        ({"zip": {"friction.kinetic": [1, 2], "friction.kinetik": [1, 2]}},
         "did you mean `friction.kinetic`"),
        ({"friction.kinetic": [1], "zip": {"friction.kinetic": TWO, "oscillator.mass": TWO}},
         "friction.kinetic is swept twice"),
    ],
)  # fmt: skip
def test_faults_of_samples_and_zips_are_located_sentences(fault, block, words):
    assert any(words in sentence for sentence in fault(block))


def test_normal_distribution_without_ends_is_cut_at_the_bounds_of_its_key(scenario):
    wide = {"distribution": "normal", "mean": 0.5, "sd": 2.0}
    over = {"oscillator.mass": GAUSS, "stroke.stops.restitution": wide}
    block = {"sample": SAMPLE | {"count": 1000, "over": over}}
    mass, restitution = (axis.values for axis in scenario(block, STOPS).sweep)
    assert np.mean(mass) == pytest.approx(75.0, abs=0.1)
    assert np.std(mass) == pytest.approx(5.0, rel=0.02)
    assert 0.0 <= min(restitution) < 0.01 < 0.99 < max(restitution) <= 1.0
    known = stats.truncnorm(-0.25, 0.25, 0.5, 2.0)
    assert stats.kstest(np.array(restitution[:]), known.cdf).statistic < 0.01


@pytest.mark.parametrize("kind", ["normal", "lognormal"])
def test_key_above_zero_is_never_drawn_as_zero(kind):
    low, high = Quantity("kg", above=0).ends
    shape = Normal if kind == "normal" else LogNormal
    values = shape(1.0, 50.0, low, high).quantile(np.array([0.0, 0.5, 1.0 - 2.0**-53]))
    assert all(Quantity("kg", above=0).read(value) for value in values.tolist())


def test_values_of_a_zip_are_tried_side_by_side(fault):
    walk = {"friction.kinetic": [15, 30], "friction.static": [18, 20]}
    (sentence,) = fault({"zip": walk})
    assert "must be at least the kinetic 30 N, not 20 N" in sentence


def test_schema_knows_samples_and_zips():
    block = schema()["properties"]["sweep"]
    assert {"zip", "sample"} <= block["properties"].keys()
    assert "sobol" in json.dumps(block["properties"]["sample"])


@pytest.mark.parametrize("kind", ["latin", "sobol", "uniform"])
def test_values_of_a_sample_in_order_are_those_by_number(scenario, kind):
    for axis in scenario({"sample": SAMPLE | {"kind": kind}}).sweep:
        assert list(axis.values) == pytest.approx(
            [*map(axis.values.item, range(40))], rel=1e-15
        )


def test_extremes_of_a_sample_are_its_least_and_greatest_values(scenario):
    found = scenario({"sample": SAMPLE, "friction.kinetic": [1, 3, 2]})
    cases = [*extreme_cases(found)]
    for key, axis in zip(("mass", "damping"), found.sweep, strict=False):
        of_cases = {getattr(case.oscillator, key) for case in cases}
        assert {min(axis.values), max(axis.values)} <= of_cases
    assert {case.friction.kinetic for case in cases} == {1.0, 3.0}
    assert len(cases) <= 6


def test_draws_of_a_sample_do_not_multiply_with_its_cases(scenario, monkeypatch):
    drawn = []
    take = Design.take
    monkeypatch.setattr(Design, "take", lambda *given: drawn.append(1) or take(*given))
    counts = []
    for count in (20, 200):
        drawn.clear()
        scenario_warnings(scenario({"sample": SAMPLE | {"count": count}}))
        counts.append(len(drawn))
    assert counts[0] == counts[1] < 30
