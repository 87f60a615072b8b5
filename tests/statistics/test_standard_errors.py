"""Every standard error of a mean of two is half of their difference: n - 1, and not n."""

import numpy as np
import pytest

from msbsdf_cli.experiments.convergence import _mean
from msbsdf_cli.experiments.evaluate import _scatter
from msbsdf_cli.methods.estimate import Estimate
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.statistics.tally import Tally
from msbsdf_cli.validation.batches import of_batches

TWO = np.array([0.25, 0.75])


def test_of_two_units_of_a_tally():
    tally = Tally(1)
    for energy in TWO:
        unit = Tally(1)
        unit.views(unit.sums[0])["energy"][0, 0] = energy
        unit.sums[1] = unit.sums[0] ** 2
        unit.units, unit.rays = 1, 10**9
        tally.merge(unit)
    assert tally.estimate("energy").stderr[0, 0] == pytest.approx(0.25)


def test_of_two_surfaces_with_free_paths():
    paths = FreePaths((1.0,), (0.0,), np.array([0.0, 1.0]))
    for share in TWO:
        bins = np.array([[[1 - share, share]]])
        paths.add_unit(bins, np.ones((1, 1)), 10**9)
    assert paths.estimate().stderr[0, 0, 1] == pytest.approx(0.25)


def test_of_two_walks_of_a_method():
    estimate = Estimate(1, 1, 1)
    estimate.add(1, TWO.reshape(1, 2, 1), np.arange(2))
    mean, stderr = estimate.mean(2)
    assert mean[0, 0, 0] == 0.5
    assert stderr[0, 0, 0] == pytest.approx(0.25)


def test_of_two_parts_of_the_samples():
    assert _scatter(TWO[:, None], np.full(2, 0.5), 1) == pytest.approx(0.25)


def test_of_two_fields_of_a_convergence():
    assert _mean(TWO)[1] == pytest.approx(0.25)


def test_of_two_batches_of_an_identity():
    assert of_batches(0.5, TWO).stderr == pytest.approx(0.25)


def test_free_paths_state_what_half_the_cells_would_have_more():
    """A step of .1 on surfaces that agree is all error; one that scatters as much is noise."""
    for scatter, expected in ((0.0, 0.1), (0.3, 0.0)):
        paths = FreePaths((1.0,), (0.0,), np.array([0.0, 1.0]))
        for sign in 1, -1:
            coarser = np.full((1, 1, 2), 0.4 + sign * scatter)
            paths.add_unit(np.full((1, 1, 2), 0.5), np.ones((1, 1)), 10**6, coarser)
        merged = paths.empty()
        merged.merge(paths)
        for found in paths, merged:
            np.testing.assert_allclose(found.estimate().stderr, expected, atol=2e-6)
