"""Verdicts over a family of measurements."""

import numpy as np
import pytest
from scipy import stats
from validation.fault_injection import ABOVE

from msbsdf_cli.statistics.multiple_testing import FAILS_AS_EXPECTED, Finding, holm, judge
from msbsdf_cli.statistics.test_statistics import Exact, Mean


def finding(evidence, wanted="holds"):
    return Finding("x", "0", ABOVE, evidence, wanted)


def test_holm_by_hand():
    # .01 <= .05 / 4, .015 <= .05 / 3, then .03 > .05 / 2 ends it, whatever .04 would have been.
    p_values = [0.03, 0.01, 0.04, 0.015]
    level = holm(p_values, 0.05)
    assert [p <= level for p in p_values] == [False, True, False, True]
    assert level == pytest.approx(0.05 / 2)
    assert holm([0.2, 0.9], 0.05) == pytest.approx(0.05 / 2)
    assert holm([1e-9], 0.05) == 0.05


def test_holm_keeps_the_rate_of_the_family():
    # 400 families of 30 tests with nothing to find: a failure in 5 % of them.
    rng = np.random.default_rng(1)
    p_values = rng.random((400, 30))
    failed = sum(any(p <= holm(row, 0.05) for p in row) for row in p_values)
    assert stats.binomtest(failed, 400, 0.05).pvalue > 1e-3


def test_verdicts_take_all_measurements_together():
    # A score of 3.5 fails alone at one in a thousand, and holds among a thousand others.
    odd = finding(Mean(0.0, 3.5, 1.0, 1e9))
    even = [finding(Mean(0.0, z, 1.0, 1e9)) for z in stats.norm.ppf(np.linspace(0.01, 0.99, 999))]
    assert judge([odd], 1e-3)[0].failed
    assert not any(row.failed for row in judge([odd, *even], 1e-3))


def test_what_must_fail_is_held_to_it():
    far = finding(Mean(0.0, 20.0, 1.0, 1e9), FAILS_AS_EXPECTED)
    near = finding(Mean(0.0, 1.0, 1.0, 1e9), FAILS_AS_EXPECTED)
    verdicts = [row.verdict for row in judge([far, near], 1e-3)]
    assert verdicts == ["fails as expected", "holds against expectation"]
    assert [row.failed for row in judge([far, near], 1e-3)] == [False, True]


def test_what_is_not_a_number_fails():
    rows = judge([finding(Exact(1.0, np.nan, 1.0, "")), finding(Mean(0.0, np.nan, 1.0, 9))], 1e-3)
    assert all(row.failed for row in rows)
