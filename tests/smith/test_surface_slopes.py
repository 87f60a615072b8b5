"""Slopes counted on a surface: everything follows from the same density."""

import json
from dataclasses import replace

import numpy as np
import pytest
from chi_square import chi_square_p

import msbsdf_cli as ms
from msbsdf_cli.methods.single import Single
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes._visible_cells import AZIMUTH_BINS, POLAR_BINS, _corners
from msbsdf_cli.smith.slopes.surface import SIDE, Surface


@pytest.fixture(scope="module")
def facets():
    """Skewed, correlated slopes of unequal roughness (2, n), of mean 0."""
    a, b = np.random.default_rng(1).standard_normal((2, 300_000))
    slopes = np.stack([0.4 * np.exp(0.5 * a), 0.2 * b + 0.1 * a])
    return slopes - slopes.mean(axis=1, keepdims=True)


@pytest.fixture(scope="module")
def skewed(facets):
    return Surface.of(facets)


def direction(theta, phi):
    return np.array([[np.sin(theta) * np.cos(phi)], [np.sin(theta) * np.sin(phi)], [np.cos(theta)]])


@pytest.mark.parametrize("phi", [0.0, 2.0, 4.0])
def test_the_projected_area_is_that_of_the_facets(facets, skewed, phi):
    for theta in (0.0, 0.4, 1.2, np.pi / 2, 1.9, 2.7, np.pi):
        d = direction(theta, phi)
        facing = np.maximum(d[0] * facets[0] + d[1] * facets[1] - d[2], 0).mean()
        # Where facets turn away within a cell, their spread in it counts: cells are 1/20 wide.
        assert skewed.sigma(d)[0] == pytest.approx(facing, abs=5e-4)
        assert skewed.sigma(-d)[0] - skewed.sigma(d)[0] == pytest.approx(d[2, 0], abs=1e-12)


def test_the_density_of_slopes(facets, skewed):
    """By the midpoint rule: it sums to 1, has mean 0, and variance alpha^2 / 2."""
    x, y = np.linspace(-12, 12, 6001), np.linspace(-12, 12, 1501)
    area = (x[1] - x[0]) * (y[1] - y[0])
    density = skewed.slope_density(x[:, None], y) * area
    # An edge of a cell is right to half a step.
    assert density.sum() == pytest.approx(1, abs=0.01)
    assert (density.sum(axis=1) @ x) == pytest.approx(0, abs=0.01)
    assert (density.sum(axis=1) @ x**2) == pytest.approx(0.5, abs=0.01)
    assert (density.sum(axis=0) @ y**2) == pytest.approx(0.5, abs=0.01)
    along = skewed.marginal_density(x)
    np.testing.assert_allclose(along, density.sum(axis=1) / (x[1] - x[0]), atol=0.02)
    m = np.array([[0.3], [-0.1], [1.0]]) / np.sqrt(1.1)
    expected = skewed.slope_density(-0.3 / skewed.alpha_x, 0.1 / skewed.alpha_y) * 1.1**2
    assert skewed.D(m)[0] == pytest.approx(expected / (skewed.alpha_x * skewed.alpha_y))
    assert skewed.D(-m)[0] == 0


@pytest.mark.parametrize("theta", [0.0, 0.6, 1.5, 1.8, 2.3])
def test_visible_normals_follow_their_density(skewed, theta, rng):
    """Chi-square over cells, against what is seen of them by the midpoint rule within each."""
    n, w = 400_000, direction(theta, 2.5)
    m = skewed.visible_normals(w, n, rng)
    assert np.all(w[0] * m[0] + w[1] * m[1] + w[2] * m[2] > 0)
    edges = [
        axis * alpha
        for axis, alpha in zip(skewed._grid, (skewed.alpha_x, skewed.alpha_y), strict=False)
    ]
    counts = np.histogram2d(-m[0], -m[1], edges)[0]
    assert counts.sum() == n
    part = (np.arange(12) + 0.5) / 12
    x, y = (e[:-1, None] + np.diff(e)[:, None] * part for e in edges)
    seen = np.maximum(w[2] - w[0] * x[:, :, None, None] - w[1] * y, 0).mean(axis=(1, 3))
    shares = np.zeros(SIDE**2)
    shares[list(skewed.cells)] = skewed.shares
    expected = seen * shares.reshape(SIDE, SIDE) / skewed.sigma(-w)
    # The table of projected areas is right to 1e-5 of 1 or so.
    assert expected.sum() == pytest.approx(1, abs=2e-3 if theta > 2 else 2e-4)
    likely = expected * n > 25
    rest = n - counts[likely].sum(), n * (expected.sum() - expected[likely].sum())
    counts, expected = np.append(counts[likely], rest[0]), np.append(n * expected[likely], rest[1])
    assert chi_square_p(counts, expected / expected.sum() * n) > 1e-4


def test_light_on_gaussian_slopes_is_light_on_beckmanns():
    """From so many slopes that their own scatter is below the noise of the walks."""
    slopes = np.random.default_rng(2).standard_normal((2, 4_000_000))
    counted = Surface.of(slopes * np.array([[0.7], [0.5]]) / np.sqrt(2))
    exact = ms.Beckmann(counted.alpha_x, counted.alpha_y)
    for theta in (0.0, 1.0, 1.5):
        a, b = (
            ms.walk(ms.Smith(s, ms.Conductor()), ms.direction(theta, 0.3), 500_000, seed=seed)
            for s, seed in ((counted, 1), (exact, 2))
        )
        noise = np.hypot(a.energy_stderr, b.energy_stderr)
        assert np.all(np.abs(a.energy - b.energy) < 4 * noise)


def test_what_is_hardly_seen_does_not_hang(skewed, rng):
    """Steeper and steeper from below, to where only the edge of the last cell is seen."""
    edge = float(skewed._grid[0][-1]) * skewed.alpha_x
    for steep in (0.7, 0.99, 0.9999, 1.0, 1.001):
        theta = np.pi / 2 + np.arctan(edge * steep)
        m = skewed.visible_normals(direction(theta, np.pi), 8, rng)
        assert np.isfinite(m).all()
        assert (m[2] > 0).all()


def test_single_precision_stays_single(skewed, rng):
    for theta in (0.0, 1e-4, 1.57, 1.5707964, 1.9):
        w = direction(theta, 0.3).astype(np.float32)
        m = skewed.visible_normals(w, 1000, rng)
        assert m.dtype == skewed.sigma(w).dtype == skewed.D(m).dtype == np.float32
        assert np.isfinite(m).all()


def test_a_scene_of_it_is_saved_and_restored(skewed):
    scene = Scene(ms.Conductor(), skewed, (0.5,))
    again = Scene.of(json.loads(json.dumps(scene.settings())))
    assert again == scene
    assert scene.slug().startswith("conductor-surface-")


def test_impossible_slopes_are_refused(facets):
    with pytest.raises(ValueError, match="no rough surface"):
        Surface.of(facets * np.array([[1], [0]]))
    with pytest.raises(ValueError, match="each with a share"):
        Surface(1, 1)
    with pytest.raises(ValueError, match="from 0 to 4095"):
        Surface(1, 1, (4096,), (1.0,), 2.0)


def test_bounds_hold_in_all_of_a_bin_and_a_cell(skewed, rng):
    """What any direction sees of any corner of a cell; within it is in between."""
    visible = skewed._visible
    corners = _corners(visible.low, visible.size).reshape(2, 4, -1)
    n = 3000
    psi, phi = np.arcsin(rng.uniform(-1, 1, n)), rng.uniform(-np.pi, np.pi, n)
    bins = ((psi / np.pi + 0.5) * POLAR_BINS).astype(int) * AZIMUTH_BINS
    bins += ((phi / np.pi + 1) / 2 * AZIMUTH_BINS).astype(int)
    for k, p, f in zip(bins, psi, phi, strict=True):
        along = np.cos(f) * corners[0] + np.sin(f) * corners[1]
        seen = (np.sin(p) - np.cos(p) * along).max(axis=0)
        # Bounds are kept in single precision.
        assert np.all(seen <= visible.bound[k] + 1e-6 * np.abs(seen))


def test_equal_roughness_makes_no_count_isotropic(skewed, rng):
    """Albedos of isotropic slopes are those of one side of the plane of incidence, twice."""
    of_one = replace(skewed, alpha_x=0.5, alpha_y=0.5)
    wi = direction(1.3, 0.8)
    weight = Single(of_one, ms.Conductor(), 1).sample(wi[:, 0], 100_000, rng)[1][0]
    albedo = first_order_albedo(of_one, ms.Conductor(), wi)[0]
    # Densities that jump from cell to cell cost the quadrature two hundredths; one side is .14 off.
    assert albedo == pytest.approx(weight.mean(), abs=4 * weight.std() / 100_000**0.5 + 0.02)
