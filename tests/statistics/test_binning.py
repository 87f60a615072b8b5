"""Bins of lobes against the angles that define them."""

import numpy as np
import pytest

from msbsdf_cli.statistics.binning import PHI_BINS, THETA_BINS, Bins, lobe_axes, lobe_bin


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_bins_are_those_of_the_angles(rng, dtype):
    w = rng.standard_normal((3, 100_000))
    w = (w / np.sqrt((w * w).sum(axis=0))).astype(dtype)
    theta = np.arccos(np.abs(w[2].astype(float))) * (2 * THETA_BINS / np.pi)
    phi = np.arctan2(w[1].astype(float), w[0]) * (PHI_BINS / (2 * np.pi)) + 0.5
    # Rounding decides within a few units of the last place of an edge.
    away = 100 * np.finfo(dtype).eps * PHI_BINS
    clear = np.all([np.abs(a - np.round(a)) > away for a in (theta, phi)], axis=0)
    clear &= np.hypot(w[0], w[1]) > away
    wanted = np.floor(theta) * PHI_BINS + np.floor(phi) % PHI_BINS
    assert clear.mean() > 0.99
    np.testing.assert_array_equal(lobe_bin(w)[clear], wanted[clear])


def test_bins_in_single_precision_are_those_in_double(rng):
    edges = np.sort(rng.random(20))
    bins = Bins(edges, 0.0, 1.0, np.arange(21))
    around = [np.nextafter(edges.astype(np.float32), np.float32(end)) for end in (0, 1)]
    x = np.concatenate([*around, edges.astype(np.float32), rng.random(10_000, dtype=np.float32)])
    np.testing.assert_array_equal(bins(x), np.searchsorted(edges, x.astype(float), side="right"))


def test_the_middle_of_each_bin_lies_in_it():
    theta, phi, _ = lobe_axes()
    theta, phi = np.repeat(theta, PHI_BINS), np.tile(phi, THETA_BINS)
    w = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    np.testing.assert_array_equal(lobe_bin(w), np.arange(THETA_BINS * PHI_BINS))
    np.testing.assert_array_equal(lobe_bin(w * [[1], [1], [-1]]), lobe_bin(w))
