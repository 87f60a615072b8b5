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
    """A step of .1 in the mean of two surfaces, whatever it is on each."""
    for scatter in 0.0, 0.3:
        paths = FreePaths((1.0,), (0.0,), np.array([0.0, 1.0]))
        for sign in 1, -1:
            coarser = np.full((1, 1, 2), 0.4 + sign * scatter), np.ones((1, 1))
            paths.add_unit(np.full((1, 1, 2), 0.5), np.ones((1, 1)), 10**6, coarser)
        merged = paths.empty()
        merged.merge(paths)
        for found in paths, merged:
            np.testing.assert_allclose(found.estimate().stderr, 0.1, atol=2e-6)


def test_a_unit_without_points_on_half_the_cells_says_nothing_of_the_mesh():
    paths = FreePaths((1.0,), (0.0,), np.array([0.0, 1.0]))
    one, half = np.ones((1, 1)), np.full((1, 1, 2), 0.5)
    for coarser in (half, one), (half, one), (0 * half, 0 * one):
        paths.add_unit(half, one, 10**6, coarser)
    np.testing.assert_allclose(paths.estimate().stderr, 0, atol=2e-6)


def test_of_neighbouring_bins_the_largest_step_counts():
    """But for bins that are empty, and for the last, of what escapes."""
    share = np.array([[[0.0, 0.2, 0.2, 0.2, 0.4]]])
    step = np.array([[[0.0, 0.1, 0.0, 0.0, 0.3]]])
    paths = FreePaths((1.0,), (0.0,), np.arange(5.0))
    for _ in range(2):
        paths.add_unit(share, np.ones((1, 1)), 10**6, (share - step, np.ones((1, 1))))
    expected = [0, 0.1, 0.1, 0, 0.3]
    np.testing.assert_allclose(paths.estimate().stderr[0, 0], expected, atol=2e-6)
