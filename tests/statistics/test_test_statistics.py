"""p-values and tolerances of single measurements."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from msbsdf_cli.statistics.test_statistics import ChiSquare, Mean, Share


@pytest.mark.parametrize(
    "evidence",
    [
        Mean(1.0, 1.0, 0.1, 31),
        Mean(1.0, 1.0, 0.1, 31, slack=0.2, because="a table"),
        Share(0.3, 3000, 10_000),
        ChiSquare(40.0, 40),
    ],
    ids=["mean", "slack", "share", "chi-square"],
)
def test_tolerance_is_where_the_verdict_turns(evidence):
    level = 1e-4
    tolerance = evidence.tolerance(level)
    for factor, fails in ((0.98, False), (1.02, True)):
        if isinstance(evidence, Share):
            count = round((evidence.expected + factor * tolerance) * evidence.n)
            moved = replace(evidence, count=count)
        else:
            moved = replace(evidence, measured=evidence.expected + factor * tolerance)
        assert (moved.p_value() <= level) == fails
    assert evidence.detectable(level) > tolerance


@pytest.mark.parametrize(("expected", "n"), [(0.3, 50), (0.002, 400), (0.999, 300)])
def test_shares_fail_no_more_often_than_said(expected, n):
    counts = np.arange(n + 1)
    p = np.array([Share(expected, int(k), n).p_value() for k in counts])
    weight = stats.binom.pmf(counts, n, expected)
    for level in (0.1, 1e-2, 1e-4):
        assert weight[p <= level].sum() <= level


def test_chi_square_of_two_samples_is_uniform_under_the_null():
    rng = np.random.default_rng(3)
    shares = 1 / np.arange(1, 60) ** 2
    shares /= shares.sum()
    p = [
        ChiSquare.of_two(rng.multinomial(40_000, shares), rng.multinomial(10_000, shares)).p_value()
        for _ in range(300)
    ]
    assert stats.kstest(p, "uniform").pvalue > 1e-3
