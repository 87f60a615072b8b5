"""Distances without noise: nearly the true ones, whatever the noise, within their error bars."""

import numpy as np
import pytest

from msbsdf_cli.statistics.distances import (
    Histogram,
    kolmogorov_smirnov,
    leftover,
    total_variation,
    unfolded,
)

SHAPES = {
    "even": np.tile([1.0, -1.0], 100),
    "few": np.where(np.arange(200) % 20 == 0, 10.0, 0.0),
    "mixed": np.random.default_rng(1).exponential(size=200) * np.tile([1.0, -1.0], 100),
    "none": np.zeros(200),
}


def estimates(measure, shape, noise, rng, draws=200):
    """`own` and its error bar over many draws of the noise."""
    zero = Histogram(np.zeros(shape.size), np.zeros(shape.size))
    stderr = np.full(shape.size, noise)
    noisy = shape + noise * rng.standard_normal((draws, shape.size))
    found = [measure(Histogram(values, stderr), zero) for values in noisy]
    return np.array([d.own for d in found]), np.array([d.own_stderr for d in found])


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("noise", [0.25, 0.7, 1.0, 2.0])
def test_total_variation_without_noise_does_not_depend_on_the_noise(name, noise, rng):
    shape = SHAPES[name]
    truth = np.abs(shape).sum() / 2
    own, stated = estimates(total_variation, shape, noise, rng)
    scatter = own.std() / np.sqrt(own.size)
    # The bias that no estimate is free of, and nothing of the folded noise, which is .8 a bin.
    assert abs(own.mean() - truth) < leftover()[0] * noise * shape.size / 2 + 4 * scatter
    assert np.abs(own - truth).max() < 4 * stated.mean()
    assert own.std() < stated.mean()


def test_what_noise_folds_is_unfolded(rng):
    """The mean of the estimate is |mu| to the stated bias, by Monte Carlo, not by its own sums."""
    bias, scatter = leftover()
    assert bias < 0.2
    for mu in (0.0, 0.3, 1.0, 2.0, 3.5, 5.0):
        values = unfolded(np.abs(mu + rng.standard_normal(200_000)))
        assert abs(values.mean() - mu) < bias + 4 * scatter / np.sqrt(200_000)
        assert values.std() < 1.01 * scatter


@pytest.mark.parametrize("size", [0.0, 0.5, 3.0, 20.0])
def test_kolmogorov_smirnov_distance_without_noise(size, rng):
    shape = np.zeros(40)
    shape[5], shape[30] = size, -size
    own, stated = estimates(kolmogorov_smirnov, shape, 0.3, rng)
    assert np.sqrt(((own - size) ** 2).mean()) < stated.mean()


def test_no_noise_no_change():
    shape = SHAPES["mixed"]
    none = np.zeros(shape.size)
    d = total_variation(Histogram(shape, none), Histogram(none, none))
    assert d.own == d.found == pytest.approx(np.abs(shape).sum() / 2)
    assert d.own_stderr == d.noise == 0


def test_bins_that_scatter_together_are_known_to(rng):
    """Each surface has a brightness of its own beside the noise of its bins: the error bar from
    independent bins would be too small by half."""
    shape, surfaces, draws = np.full(100, 3.0), 16, 200
    own, stated = [], []
    for _ in range(draws):
        brightness = rng.standard_normal((surfaces, 1))
        units = shape + brightness + 3 * rng.standard_normal((surfaces, shape.size))
        stderr = units.std(axis=0, ddof=1) / np.sqrt(surfaces)
        zero = Histogram(np.zeros(shape.size), np.zeros(shape.size))
        d = total_variation(zero, Histogram(units.mean(axis=0), stderr), units)
        own.append(d.own)
        stated.append(d.own_stderr)
    ratio = np.std(own) / np.sqrt(np.mean(np.square(stated)))
    assert 0.75 < ratio < 1.15
