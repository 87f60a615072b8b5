"""Means of independent batches, with their errors and their skewness."""

import numpy as np

from msbsdf_cli.statistics.test_statistics import Mean
from surfaces.facet import Array


def of_batches(expected: float, batches: Array, slack: float = 0.0, because: str = "") -> Mean:
    """A mean of equal, independent batches (k,)."""
    mean, variance, third = mean_of(batches)
    stderr, skewness = float(np.sqrt(variance)), _skewness(variance, third)
    return Mean(expected, mean, stderr, batches.size - 1, slack, because, skewness)


def of_two(one: Array, two: Array, slack: float = 0.0, because: str = "") -> Mean:
    """The means of two independent sets of batches, `one` (k,) in the place of the expected.

    The degrees of freedom are Welch's.
    """
    (a, a_variance, a_third), (b, b_variance, b_third) = mean_of(one), mean_of(two)
    variance = a_variance + b_variance
    parts = a_variance**2 / max(one.size - 1, 1) + b_variance**2 / max(two.size - 1, 1)
    df = variance**2 / parts if parts > 0 else one.size + two.size - 2
    skewness = _skewness(variance, b_third - a_third)
    return Mean(a, b, float(np.sqrt(variance)), float(df), slack, because, skewness)


def of_pairs(one: Array, two: Array, slack: float = 0.0, because: str = "") -> Mean:
    """The means of two figures of the same independent trials (k,), `one` in the place of the
    expected: what they have in common is no noise of their difference."""
    difference, variance, third = mean_of(two - one)
    stderr, skewness = float(np.sqrt(variance)), _skewness(variance, third)
    expected = float(one.mean())
    return Mean(expected, expected + difference, stderr, one.size - 1, slack, because, skewness)


def mean_of(batches: Array) -> tuple[float, float, float]:
    """Mean of independent batches (k,), its variance and its third central moment; of a single
    batch, which has no noise, these are 0."""
    n = batches.size
    if n == 1:
        return float(batches[0]), 0.0, 0.0
    third = float(((batches - batches.mean()) ** 3).mean()) / n**2
    return float(batches.mean()), float(batches.var(ddof=1)) / n, third


def _skewness(variance: float, third: float) -> float:
    return third / variance**1.5 if variance > 0 else 0.0
