"""The hazard and what it is made of, against quadrature, limits and sampled Gaussian profiles."""

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import multivariate_normal, norm

from msbsdf_cli.memory import hazard, normal
from msbsdf_cli.memory.correlation import NEAREST, ahead, correlation, derivatives
from msbsdf_cli.memory.entry import Lambda, entry
from msbsdf_cli.memory.escape import escape
from msbsdf_cli.memory.march import march
from surfaces.spectrum import GAUSSIAN, spectrum

RNG = np.random.default_rng
SPECTRA = ("gaussian", "matern:1.5", "exponential", "power-law:0.7")


@pytest.mark.parametrize("name", SPECTRA)
def test_means_and_covariances_are_those_of_the_joint_distribution_of_heights(name):
    """By differences of heights a little apart instead of derivatives of the autocorrelation."""
    e, x, lag = 0.02, 1.3, 0.5
    fourth = derivatives(spectrum(name), np.zeros(1))[4, 0]
    mean, C = ahead(spectrum(name), np.array([x]), np.array([lag]), fourth)
    places = np.array([-e, 0, e, x - e, x, x + e, x - lag])
    K = kernel(name, places)
    slope, bend = np.array([-0.5, 0, 0.5]) / e, np.array([1, -2, 1]) / e**2
    rows = np.zeros((7, 7))
    rows[0, 1] = rows[3, 4] = rows[5, 6] = 1
    rows[1, :3], rows[2, :3] = slope, bend
    rows[4, 3:6], rows[6, 3:6], rows[6, 4] = slope, bend, bend[1] + 1
    joint = rows @ K @ rows.T
    start, end = joint[:3, :3], joint[3:, 3:]
    gain = joint[3:, :3] @ np.linalg.inv(start)
    expected = end - gain @ joint[3:, :3].T
    # Differences over e are off by e^2 of derivatives up to the sixth, which waves of length 1 / 16
    # make large.
    tolerance = 3e-3 if name == "gaussian" else 0.15
    scale = np.sqrt(np.outer(np.diag(end), np.diag(end)))
    assert (np.abs(C[0] - expected) < tolerance * scale).all()
    assert abs(mean[0, 0, 2] - gain[0, 1]) < tolerance
    assert abs(mean[0, 0, 1] - (gain[0, 0] - gain[0, 2])) < tolerance


def kernel(name, x):
    apart = np.abs(x[:, None] - x).ravel()
    return derivatives(spectrum(name), apart)[0].reshape(x.size, x.size)


@pytest.mark.parametrize("k", [-3.0, 0.0, 2.0])
def test_tables_of_normal_numbers(k):
    y = np.linspace(k, k + 14, 200_001)
    f = (y - k) * norm.pdf(y)
    mean = (f * y).sum() / f.sum()
    i = normal.node(np.array([k]))
    # Half a node off, times the slope of each, which is at most 1.
    apart = normal.WIDEST / normal.NODES
    assert abs(normal.CROSSING[i] - mean) < 2 * apart
    assert abs(normal.SCATTER[i] - ((f * (y - mean) ** 2).sum() / f.sum())) < 2 * apart
    assert abs(normal.excess(np.array([k])) - f.sum() * (y[1] - y[0])) < 1e-9
    below = np.linspace(k - 14, k, 200_001)
    g = norm.pdf(below) / ndtr(k) * (below[1] - below[0])
    assert abs(normal.TRUNCATED[i] + (g * below).sum()) < 2 * apart


@pytest.mark.parametrize("c", [0.1, 0.7])
def test_without_looking_back_a_level_far_away_has_smiths_hazard(c):
    """Lambda ln C1 falls along the ray as the integral of the hazard grows."""
    level = np.linspace(-1, 3, 41)
    found = hazard.far(correlation(GAUSSIAN, np.float64), level, np.full(41, c))
    below, down = found.below, found.down
    step = np.diff(level) / c
    total = -np.diff(below) + step * (down[1:] + down[:-1]) / 2
    smith = -Lambda(np.array(c)) * np.diff(normal.depth(level))
    # Nodes of the tables are .001 apart; in the sum their rounding cancels, not the trapezoid's.
    np.testing.assert_allclose(total, smith, rtol=0.01, atol=1e-3)
    assert total.sum() == pytest.approx(smith.sum(), rel=5e-3)


def test_looking_back_is_the_ratio_of_two_probabilities():
    """Against the bivariate normal distribution, at a level, far from the facet."""
    cor = correlation(GAUSSIAN, np.float64)
    t, level, c = cor.lag, 0.5, 0.3
    R, R1 = np.exp(-t * t / 2), -t * np.exp(-t * t / 2)
    s = np.linspace(c, c + 10, 2001)
    weight = (s - c) * norm.pdf(s)
    behind = ndtr((level - c * t - R * level - R1 * s) / np.sqrt(1 - R * R - R1 * R1))
    crossing = (weight * behind).sum() / weight.sum()
    free = multivariate_normal.cdf([level, level - c * t], [0, 0], [[1, R], [R, 1]]) / ndtr(level)
    factor = hazard.far(cor, np.array([level]), np.array([c]))[2][0]
    # Both probabilities are by mean and variance.
    assert crossing / free > 1.05
    assert factor == pytest.approx(crossing / free, abs=0.03)


CASES = [(0.9, -1.0, -0.5), (0.3, 0.0, 0.0), (0.9, 0.0, 0.3), (1.5, -2.0, 0.5)]


@pytest.mark.parametrize(("c", "h", "s"), CASES)
def test_rays_leave_as_often_as_sampled_profiles_let_them(c, h, s):
    """The surface along a line is drawn whole, given height and slope at 0."""
    n, x = 20_000, np.arange(1, int(6 / c / 0.06)) * 0.06
    given = np.stack([np.exp(-x * x / 2), x * np.exp(-x * x / 2)], axis=1)
    rest = np.exp(-((x[:, None] - x) ** 2) / 2) - given @ given.T
    power, wave = np.linalg.eigh(rest)
    draw = wave * np.sqrt(np.maximum(power, 0))
    rng = RNG(1)
    free = 0
    for _ in range(4):
        profile = draw @ rng.standard_normal((x.size, n // 4)) + (given @ [h, s])[:, None]
        free += int((profile < (h + c * x)[:, None]).all(axis=0).sum())
    traced = free / n
    u = rng.standard_normal(n)
    facet = np.stack([np.full(n, c - s), np.full(n, h), np.full(n, s), u]).astype(np.float32)
    hits, away = march(correlation(GAUSSIAN), facet, rng.standard_exponential(n, dtype=np.float32))
    assert hits.slot.size + away.slot.size == n
    assert (hits.h < h + c * 60).all()
    # Noise of both, and what the hazard is known to be off (.016 at most where it was measured).
    assert abs(away.size / n - traced) < 4 * np.sqrt(2 * 0.25 / n) + 0.016


def test_the_table_is_what_the_march_finds():
    rng = RNG(3)
    n = 20_000
    h, s, u = rng.standard_normal((3, n))
    c = np.abs(rng.standard_normal(n)) * rng.choice([0.1, 0.5, 2], n)
    # Facets that all but touch the ray are left out: the nodes are too few for these.
    keep = c - s > 0.05
    facet = np.stack([c - s, h, s, u])[:, keep]
    # A hundred: beyond, nothing is left.
    _, away = march(correlation(GAUSSIAN, np.float64), facet, np.full(keep.sum(), 100.0), 0.5)
    exact = np.zeros(keep.sum())
    exact[away.slot] = np.exp(away.left - 100)
    found = escape(GAUSSIAN).probability(h[keep], c[keep], (c - s)[keep], u[keep])
    assert np.sqrt(((found - exact) ** 2).mean()) < 0.006
    assert abs((found - exact).mean()) < 0.003


def test_entries_are_distributed_as_the_density_says():
    """Mean heights and slopes of draws against quadrature over height, slope and curvature."""
    first = entry(GAUSSIAN)
    c, n = 0.4, 40_000
    ray = type("Ray", (), {"c": np.array([-c], np.float32)})
    h, s, _, u = first.draw(ray, n, RNG(4))
    x = np.linspace(-5, 5, 61)
    H, S, U = np.meshgrid(x, x[x > -c], np.linspace(-3.4, 3.4, 18), indexing="ij")
    weight = np.exp(-(H * H + S * S + U * U) / 2) * (S + c)
    weight *= first.escape.probability(H, np.full_like(H, c), S + c, U)
    for drawn, node in ((h, H), (s, S), (u, U)):
        mean = (weight * node).sum() / weight.sum()
        # Four standard errors and the quadrature's.
        assert abs(drawn.mean() - mean) < 4 * drawn.std() / np.sqrt(n) + 0.01
    assert first.normalisation(c) == pytest.approx(1, abs=0.02)


def test_steps_of_the_lattice_are_where_they_say():
    cor = correlation(GAUSSIAN)
    x = np.array([NEAREST / 10, 0.1, 1.0, 100.0])
    found = cor.x[cor.index(x)]
    np.testing.assert_allclose(found[1:3], x[1:3], rtol=0.006)
    assert found[0] == cor.x[0]
    assert found[3] == cor.x[-1]
