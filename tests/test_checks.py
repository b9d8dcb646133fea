"""From `T_a < 1.5` to a verdict."""

from __future__ import annotations

import re

import numpy as np
import pytest
from outcomes import judgement

from drysim.metrics.checks import Check
from drysim.metrics.table import METRICS

UNITS = {"excitation.frequency": "Hz", "excitation.rms": "m/s²", "friction.kinetic": "N"}


@pytest.mark.parametrize(
    ("text", "metric", "op", "limit"),
    [
        ("T_a < 1.75", "T_a", "<", 1.75),
        ("x_r_peak<=25 mm", "x_r_peak", "<=", 0.025),
        ("  a_x >= 0.05 g ", "a_x", ">=", 0.4903325),
        ("stuck_share > 10 %", "stuck_share", ">", 0.1),
        ("violations == 0", "violations", "==", 0.0),
        ("energy_friction < 2 kJ", "energy_friction", "<", 2000.0),
    ],
)
def test_check_compares_a_metric_with_a_number_in_its_unit(text, metric, op, limit):
    check = Check.parse(text)
    assert (check.metric, check.op, check.limit, str(check)) == (metric, op, limit, text)


@pytest.mark.parametrize("metric", METRICS, ids=lambda metric: metric.name)
def test_every_metric_can_be_checked_in_its_own_unit(metric):
    unit = "" if metric.unit == "-" else metric.unit
    assert Check.parse(f"{metric.name} < 2 {unit}").limit == 2.0


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("T_b < 1", "unknown metric `T_b`; did you mean `T_a`?"),
        ("T_a =< 1", "unknown comparison `=<`; use one of < <= > >= =="),
        ("T_a", "write `metric < value`, such as `T_a < 1.5`, not `T_a`"),
        ("T_a < ", "write `metric < value`, such as `T_a < 1.5`, not `T_a <`"),
        ("T_a < 3 N", "`N` is a unit of force, not a plain number"),
        ("T_a p0 < 1", "a quantile lies between p0 and p100, not at `p0`"),
        ("T_a p95 < 1 with every seed", "write either `p95` or `with every seed`, not both"),
        ("T_a < 1 at F > 5 with every seed", "write `with every seed` before `at`"),
        ("T_a < 1 with all seeds", "unknown unit `with all seeds`"),
        ("T_a < 1e999", "must compare with a finite number, not `1e999`"),
        ("T_a < 1 at frequency > 1",
         "`frequency` after `at` is not a numeric key of this scenario"),
        ("T_a < 1 at excitation.frequenzy > 1",
         "`excitation.frequenzy` after `at` is not a numeric key of this scenario; did you "
         "mean `excitation.frequency`?"),
        ("T_a < 1 at excitation.rms",
         "write `at key >= value`, such as `at excitation.frequency >= 8`, not "
         "`at excitation.rms`"),
        ("T_a < 1 at excitation.rms > 1 and",
         "write `at key >= value`, such as `at excitation.frequency >= 8`, not `at`"),
        ("T_a < 1 at excitation.rms > 3 N",
         "`N` is a unit of force, not acceleration [m/s²]"),
        ("T_a < 1 at excitation.rms =< 3", "unknown comparison `=<`; use one of < <= > >= =="),
    ],
)  # fmt: skip
def test_text_that_is_no_check_earns_a_sentence(text, sentence):
    with pytest.raises(ValueError, match=re.escape(sentence)) as fault:
        Check.parse(text, UNITS)
    assert str(fault.value) == sentence


def test_unknown_metric_that_resembles_none_lists_them_all():
    with pytest.raises(ValueError, match="use one of a_u, a_x, T_a"):
        Check.parse("comfort < 1")


@pytest.mark.parametrize(
    ("op", "verdicts"),
    [("<", [True, False, False]), ("<=", [True, True, False]), (">", [False, False, True]),
     (">=", [False, True, True]), ("==", [False, True, False])],
)  # fmt: skip
def test_verdict_follows_the_comparison(op, verdicts):
    check = Check.parse(f"T_a {op} 1")
    assert [check.judge({"T_a": value}).passed for value in (0.5, 1.0, 1.5)] == verdicts


@pytest.mark.parametrize("metrics", [{"T_x": None}, {}])
def test_metric_that_is_not_known_fails_its_check(metrics):
    verdict = Check.parse("T_x < 1").judge(metrics)
    assert (verdict.passed, verdict.value) == (False, None)
    assert verdict.sentence == "T_x < 1: fails; T_x is not known here"
    hourly = Check.parse("stroke_once_an_hour < 1").judge(metrics).reason
    few = "noise and records with at least 150 half cycles of x_r"
    assert hourly == f"stroke_once_an_hour is not known here: it is known for {few} only"


def rows(values: list[float | None]) -> list[tuple[dict[str, float], dict[str, float | None]]]:
    """Return rows of a sweep over 1, 2, 3 ... Hz with these values of T_a."""
    return [
        ({"excitation.frequency": frequency}, {"T_a": value})
        for frequency, value in enumerate(values, 1)
    ]


@pytest.mark.parametrize(
    ("text", "judges", "value"),
    [
        ("x_r_peak < 25 mm  with every seed ", "every seed", 0.04),
        ("x_r_peak > 25 mm with every seed", "every seed", 0.01),
        ("x_r_peak p50 < 25 mm", "p50", 0.015),
        ("x_r_peak p99.5 < 25 mm", "p99.5", 0.04),
        ("x_r_peak < 25 mm with every seed at excitation.rms > 1", "every seed", 0.04),
    ],
)
def test_check_judges_quantile_or_every_seed(text, judges, value):
    check = Check.parse(text, UNITS)
    assert (check.judges, check.limit, str(check)) == (judges, 0.025, text)
    assert check.over_seeds(np.array([0.01, 0.04, 0.01, 0.02])) == pytest.approx(value)


def test_unknown_value_of_a_seed_makes_that_of_all_unknown():
    values = np.array([0.01, np.nan, 0.03])
    for text in ("x_r_peak < 25 mm with every seed", "x_r_peak p95 < 25 mm"):
        assert np.isnan(Check.parse(text).over_seeds(values))


def test_checks_over_seeds_contradict_where_no_values_of_seeds_satisfy_both():
    texts = "T_a < 1 with every seed", "T_a > 2 with every seed", "T_a > 2", "T_a p95 > 2"
    every, *others = map(Check.parse, texts)
    assert all(every.contradicts(other) and other.contradicts(every) for other in others)
    assert not Check.parse("T_a < 1").contradicts(Check.parse("T_a p95 > 2"))


def test_check_with_at_holds_its_conditions_in_si():
    check = Check.parse(
        "T_a < 0.6 at excitation.frequency >= 0.008 kHz and excitation.rms==0.05 g", UNITS
    )
    found = [(one.key, one.op, one.limit) for one in check.conditions]
    assert found == [("excitation.frequency", ">=", 8.0), ("excitation.rms", "==", 0.4903325)]
    assert (check.metric, check.op, check.limit) == ("T_a", "<", 0.6)


@pytest.mark.parametrize(
    ("text", "values", "sentence"),
    [
        ("T_a < 1", [0.5, 0.9, 0.7], "holds with 0.9 at excitation.frequency = 2"),
        ("T_a > 0.1", [0.5, 0.0, 0.7], "fails with 0 at excitation.frequency = 2"),
        ("T_a == 0", [0, 3, 1], "fails with 3 at excitation.frequency = 2"),
        ("T_a < 1", [5.0, None, 0.7], "fails; T_a is not known at excitation.frequency = 2"),
        ("T_a < 1", [5, np.nan, 0.7], "fails; T_a is not known at excitation.frequency = 2"),
        ("T_a < 0.6 at excitation.frequency >= 2", [1.5, 0.4, 0.5],
         "holds with 0.5 at excitation.frequency = 3"),
        ("T_a < 0.6 at excitation.frequency >= 9", [0.1],
         "fails; no case meets the condition"),
    ],
)  # fmt: skip
def test_worst_case_decides_over_many(text, values, sentence):
    verdict = judgement(Check.parse(text, UNITS), rows(values))
    assert verdict.sentence == f"{text}: {sentence}"
    assert verdict.passed == sentence.startswith("holds")


def test_single_case_out_of_reach_is_not_judged():
    check = Check.parse("T_a < 0.6 at excitation.frequency >= 8", UNITS)
    verdict = check.with_values({"excitation.frequency": 1.6}).judge({"T_a": 1.5})
    assert (verdict.passed, verdict.value) == (None, None)
    assert verdict.sentence.endswith(": skipped; the condition is not met")
    near = check.with_values({"excitation.frequency": 9.0}).judge({"T_a": 1.5})
    assert (near.passed, near.value, near.reason) == (False, 1.5, "")


def test_key_that_is_not_swept_has_its_value_in_the_scenario():
    check = Check.parse("T_a < 0.6 at friction.kinetic >= 20", UNITS)
    assert judgement(check.with_values({"friction.kinetic": 30.0}), rows([0.1])).passed
    elsewhere = judgement(check.with_values({"friction.kinetic": 10.0}), rows([0.1]))
    assert elsewhere.reason == "no case meets the condition"


@pytest.mark.parametrize(
    ("text", "value", "found"),
    [
        ("T_a < 1.14329", 1.1432904, "fails with 1.1432904"),
        ("T_a > 1.0035202439", 1.00352024396, "holds with 1.003520244"),
        ("x_r_peak < 25 mm", 0.025000000001, "fails with 25.000000001 mm"),
        ("T_a <= 1.1", 1.1, "holds with 1.1"),
        ("T_a < 1.1", 1.1 + 2e-16, "fails with 1.1000000000000003"),
        ("T_a == 9.6", 9.6 - 2e-15, "fails with 9.599999999999998"),
    ],
)
def test_value_has_as_many_digits_as_tell_it_from_its_bound(text, value, found):
    check = Check.parse(text)
    assert check.judge({check.metric: value}).sentence == f"{text}: {found}"
