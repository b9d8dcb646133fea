"""From `T_a < 1.5` to a verdict."""

from __future__ import annotations

import re

import pytest

from drysim.checks import Check
from drysim.metrics import METRICS


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
        ("T_a < 1e999", "must compare with a finite number, not `1e999`"),
    ],
)
def test_text_that_is_no_check_earns_a_sentence(text, sentence):
    with pytest.raises(ValueError, match=re.escape(sentence)) as fault:
        Check.parse(text)
    assert str(fault.value) == sentence


def test_unknown_metric_that_resembles_none_lists_them_all():
    with pytest.raises(ValueError, match="known are a_u, a_x, T_a"):
        Check.parse("comfort < 1")


@pytest.mark.parametrize(
    ("op", "below", "equal", "above"),
    [
        ("<", True, False, False),
        ("<=", True, True, False),
        (">", False, False, True),
        (">=", False, True, True),
        ("==", False, True, False),
    ],
)
def test_verdict_follows_the_comparison(op, below, equal, above):
    check = Check.parse(f"T_a {op} 1")
    verdicts = [check.judge({"T_a": value}).passed for value in (0.5, 1.0, 1.5)]
    assert verdicts == [below, equal, above]


def test_verdict_says_what_came_out():
    verdict = Check.parse("x_r_peak < 25 mm").judge({"x_r_peak": 0.03})
    assert verdict.sentence == "x_r_peak < 25 mm: fails with 0.03 m"


@pytest.mark.parametrize("metrics", [{"T_x": None}, {}])
def test_metric_that_is_not_known_fails_its_check(metrics):
    verdict = Check.parse("T_x < 1").judge(metrics)
    assert (verdict.passed, verdict.value) == (False, None)
    assert verdict.sentence == "T_x < 1: T_x is not known here, so the check fails"
