import numpy as np
import pytest
from chi_square import chi_square_p
from scipy.integrate import quad

from msbsdf_cli.smith.slopes import NAMES, Beckmann, Ggx, Lambda, StudentT, distribution

DISTRIBUTIONS = sorted(NAMES)


def direction(theta, phi):
    return np.array([[np.sin(theta) * np.cos(phi)], [np.sin(theta) * np.sin(phi)], [np.cos(theta)]])


def density_of_slopes(slopes, r2):
    """Density of slopes over their roughness at the squared distance r2: the textbook's."""
    if isinstance(slopes, Beckmann):
        return np.exp(-r2) / np.pi
    if isinstance(slopes, Ggx):
        return 1 / (np.pi * (1 + r2) ** 2)
    return (1 + r2 / (slopes.gamma - 1)) ** -slopes.gamma / np.pi


def projected_area(slopes, w):
    """Integral of <w, m> D(m) over normals, by quadrature in slopes: independent of the code."""

    def density(x, y):
        r2 = (x / slopes.alpha_x) ** 2 + (y / slopes.alpha_y) ** 2
        return density_of_slopes(slopes, r2) / (slopes.alpha_x * slopes.alpha_y)

    def inner(radius, phi):
        x, y = slopes.alpha_x * radius * np.cos(phi), slopes.alpha_y * radius * np.sin(phi)
        cos = -w[0, 0] * x - w[1, 0] * y + w[2, 0]
        return np.maximum(cos, 0) * density(x, y) * radius * slopes.alpha_x * slopes.alpha_y

    # Tangent map: GGX has a long tail.
    def mapped(s, phi):
        return inner(np.tan(s), phi) / np.cos(s) ** 2

    s = (np.arange(4000) + 0.5) / 4000 * np.pi / 2
    phi = (np.arange(720) + 0.5) / 720 * 2 * np.pi
    return mapped(s[:, None], phi).sum() * (np.pi / 2 / 4000) * (2 * np.pi / 720)


@pytest.mark.parametrize("name", DISTRIBUTIONS)
@pytest.mark.parametrize("alpha", [(0.5, 0.5), (1.0, 0.3)])
@pytest.mark.parametrize("theta", [0.0, 1.2, 1.9])
def test_sigma_is_the_projected_area(name, alpha, theta):
    slopes = distribution(name)(*alpha)
    w = direction(theta, 0.7)
    # The kink where a facet turns away limits the quadrature to about 1e-5.
    assert slopes.sigma(-w)[0] == pytest.approx(projected_area(slopes, w), abs=3e-5)


@pytest.mark.parametrize("name", DISTRIBUTIONS)
def test_sigma_over_the_sphere(name):
    slopes = distribution(name)(0.7, 0.2)
    theta = np.linspace(0, np.pi, 4001)
    d = np.stack([np.sin(theta) * 0.6, np.sin(theta) * 0.8, np.cos(theta)])
    up, down = slopes.sigma(d), slopes.sigma(-d)
    assert np.all(up >= 0)
    assert np.all(np.isfinite(up))
    # Facets project on any plane with signs: sigma(-d) - sigma(d) = d_z, [HHdD16] Eqs. 21, 22.
    np.testing.assert_allclose(down - up, d[2], atol=1e-15)
    # It keeps its relative digits where it vanishes: monotone to the zenith.
    assert np.all(np.diff(up[theta < np.pi / 2]) >= 0)


def test_lambda_of_ggx_in_closed_form():
    theta = 1.1
    expected = (-1 + np.sqrt(1 + (0.4 * np.tan(theta)) ** 2)) / 2
    value = Lambda(distribution("ggx")(0.4, 0.4), direction(theta, 2.0))[0]
    assert value == pytest.approx(expected, rel=1e-14)


def test_beckmann_sigma_keeps_its_digits():
    """Against the asymptotic series of the iterated error function, whose next term bounds it."""
    for a in (5.0, 8.0, 20.0):
        z, s = a / np.hypot(a, 1), 1 / np.hypot(a, 1)
        terms = [1, -3 / (2 * a**2), 15 / (4 * a**4), -105 / (8 * a**6)]
        series = s * np.exp(-a * a) / (4 * np.sqrt(np.pi) * a**2) * sum(terms)
        value = distribution("beckmann")(1, 1).sigma(np.array([[s], [0], [z]]))[0]
        assert value == pytest.approx(series, rel=945 / (16 * a**8) + 1e-9)


@pytest.mark.parametrize("name", DISTRIBUTIONS)
@pytest.mark.parametrize("theta", [0.0, 0.6, 1.5, np.pi / 2, 1.8, 2.6, 3.0])
def test_visible_normals_follow_their_density(name, theta, rng):
    """Chi-square of slopes against <w, m> D(m) / sigma, above, on and below the horizon."""
    slopes = distribution(name)(0.6, 0.6) if theta != 1.5 else distribution(name)(1.0, 0.2)
    n = 400_000
    w = direction(theta, 0.4)
    m = slopes.visible_normals(w, n, rng)
    facing = w[0] * m[0] + w[1] * m[1] + w[2] * m[2]
    assert np.all(facing >= -1e-9 * np.abs(m).max(axis=0))
    x, y = -m[0] / m[2] / slopes.alpha_x, -m[1] / m[2] / slopes.alpha_y
    # Across and along the stretched azimuth of w, the slopes' spread differs by orders.
    azimuth = np.arctan2(slopes.alpha_y * w[1], slopes.alpha_x * w[0])
    along, across = (
        x * np.cos(azimuth) + y * np.sin(azimuth),
        y * np.cos(azimuth) - x * np.sin(azimuth),
    )
    pilot, tested = slice(None, n // 8), slice(n // 8, None)
    edges = [np.quantile(v[pilot], np.linspace(0, 1, 26)[1:-1]) for v in (along, across)]
    counts = np.histogram2d(along[tested], across[tested], edges)[0]
    shares = expected_shares(slopes, w, *edges)
    # The last cell is all that lies outside the edges.
    total = along[tested].size
    counts = np.append(counts.ravel(), total - counts.sum())
    shares = np.append(shares.ravel(), 1 - shares.sum())
    assert chi_square_p(counts, total * shares) > 1e-4


def expected_shares(slopes, w, along, across, sub=60):
    """Probabilities of cells of slopes in the stretched frame of w, by the midpoint rule on a fine
    grid within each, over the projected area in closed form."""

    def fine(edges):
        parts = (np.arange(sub) + 0.5) / sub
        return (edges[:-1, None] + np.diff(edges)[:, None] * parts).ravel()

    p, q = fine(along)[:, None], fine(across)[None]
    r2 = p * p + q * q
    density = density_of_slopes(slopes, r2)
    s = np.hypot(slopes.alpha_x * w[0], slopes.alpha_y * w[1])
    value = np.maximum(w[2] - s * p, 0) * density / slopes.sigma(-w)
    cells = value.reshape(len(along) - 1, sub, len(across) - 1, sub).mean(axis=(1, 3))
    return cells * np.diff(along)[:, None] * np.diff(across)


def test_student_t_is_ggx_at_2_and_beckmann_far_off():
    theta = np.linspace(0, np.pi, 50)
    d = np.stack([np.sin(theta), 0 * theta, np.cos(theta)])
    for gamma, other, error in ((2.0, Ggx, 1e-13), (1e7, Beckmann, 1e-6)):
        mine, theirs = StudentT(0.6, 0.3, gamma), other(0.6, 0.3)
        np.testing.assert_allclose(mine.sigma(d), theirs.sigma(d), rtol=error, atol=error)
        up = d[:, theta < 1]
        np.testing.assert_allclose(mine.D(up), theirs.D(up), rtol=10 * error)


@pytest.mark.parametrize("gamma", [1.7, 2.5, 40.0])
@pytest.mark.parametrize("theta", [1.2, 2.4])
def test_visible_normals_of_any_gamma(gamma, theta, rng):
    """Mean angle of the visible slope along the direction, against a quadrature."""
    slopes, w = StudentT(0.7, 0.4, gamma), direction(theta, 0.0)
    x = -slopes.visible_normals(w, 200_000, rng)[0] / 0.7
    s, z = 0.7 * w[0, 0], w[2, 0]
    end = np.arctan2(z, s)

    def integral(power):
        """Of the angle's power over the density of the visible slope, tan(angle)."""

        def value(u):
            density = max(z - s * np.tan(u), 0) * slopes.marginal_density(np.tan(u))
            return u**power * density / np.cos(u) ** 2

        return quad(value, -np.pi / 2, end, limit=500)[0]

    expected = integral(1) / integral(0)
    angle = np.arctan(x)
    assert abs(angle.mean() - expected) < 4 * angle.std() / np.sqrt(angle.size) + 1e-5


@pytest.mark.parametrize("wrong", [(0, 1), (-1, 1), (1, np.inf), (np.nan, 1)])
def test_impossible_roughness_is_refused(wrong):
    for name in NAMES:
        with pytest.raises(ValueError, match="roughness is a finite number above 0"):
            distribution(name)(*wrong)
    with pytest.raises(ValueError, match="gamma"):
        StudentT(1, 1, 1.5)
    with pytest.raises(ValueError, match="not a slope distribution"):
        distribution("wood")


def test_beckmann_tail_is_not_cut(rng):
    """At grazing the slope has density 2 x exp(-x^2); [HHdD16 impl.]'s search ends at 2.75."""
    w = direction(np.pi / 2, 0.0)
    n = 2_000_000
    m = distribution("beckmann")(1, 1).visible_normals(w, n, rng)
    beyond = np.count_nonzero(m[0] > 2.75)
    expected = n * np.exp(-(2.75**2))
    assert abs(beyond - expected) < 4 * np.sqrt(expected)


@pytest.mark.parametrize("name", DISTRIBUTIONS)
def test_single_precision_stays_single_and_finite(name, rng):
    slopes = distribution(name)(0.5, 0.1)
    for theta in (0.0, 1e-4, 1.57, 1.5707964, 2.9, 3.1415):
        w = direction(theta, 0.3).astype(np.float32)
        m = slopes.visible_normals(w, 100_000, rng)
        assert m.dtype == np.float32
        assert np.isfinite(m).all()
        assert slopes.sigma(w).dtype == np.float32
