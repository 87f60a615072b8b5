"""Means of batches."""

from dataclasses import replace

import numpy as np
from scipy import stats

from msbsdf_cli.validation.batches import of_batches, of_two


def test_a_constant_is_its_own_mean():
    # GGX of roughness 1, seen from the zenith, scatters evenly: nothing is left but rounding.
    assert of_batches(1.0, np.full(8, 1 - 1e-16)).p_value() == 1
    assert of_batches(1.0, np.full(8, 1 - 1e-9)).p_value() == 0


def test_differences_of_batches_have_the_right_error():
    rng = np.random.default_rng(4)
    p = [of_two(rng.normal(size=32), rng.normal(scale=5, size=32)).p_value() for _ in range(300)]
    assert stats.kstest(p, "uniform").pvalue > 1e-3


def test_means_of_skewed_batches_fail_as_often_as_said():
    # Exponential batches: without the correction, one in a hundred below would be three. By chance
    # 8000 runs see one in a hundred as 1.4 once in six thousand.
    rng = np.random.default_rng(6)
    batches = rng.exponential(size=(8_000, 128)) ** 1.5
    mean = 1.329340388179137  # Gamma(5 / 2)
    corrected = [of_batches(mean, row) for row in batches]
    p = np.array([evidence.p_value() for evidence in corrected])
    plain = np.array([replace(evidence, skewness=0.0).p_value() for evidence in corrected])
    assert np.mean(p < 0.001) < 0.5 * np.mean(plain < 0.001)
    assert np.mean(p < 0.01) < 0.014
