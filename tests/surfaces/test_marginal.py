"""Ridges and pits: heights of a stated skewness, slopes of a stated variance, and light on them."""

import numpy as np
import pytest
from scipy import integrate, optimize, stats

import msbsdf_cli as ms
from msbsdf_cli.experiments.control_variates import controls, expected
from msbsdf_cli.experiments.random_surfaces import (
    Resolution,
    counted,
    facet_slopes,
    make_surface,
    realisation,
)
from msbsdf_cli.experiments.realisations import simulate
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.heights import height_distribution
from msbsdf_cli.smith.slopes import Beckmann
from msbsdf_cli.statistics.tally import Tally
from surfaces.field import HeightField
from surfaces.marginal import GAUSSIAN_HEIGHTS, marginal
from surfaces.materials import Conductor, Dielectric
from surfaces.spectrum import GAUSSIAN, spectrum
from surfaces.surface import Surface
from surfaces.tracing import Tracer
from surfaces.views import UPRIGHT, Views

SOME = [("ridges", 1.0), ("ridges:0.3", 0.3), ("pits:2", -2.0), ("ridges:4", 4.0)]


@pytest.mark.parametrize(("name", "skewness"), SOME)
def test_moments_and_inverse(name, skewness):
    heights_are = marginal(name)
    assert marginal(heights_are.name) == heights_are
    moments = [
        integrate.quad(
            lambda g, p=p: float(heights_are.heights(np.array(g))) ** p * stats.norm.pdf(g), -12, 12
        )[0]
        for p in (1, 2, 3)
    ]
    np.testing.assert_allclose(moments, [0, 1, skewness], atol=1e-6)
    g = np.linspace(-4, 4, 9)
    np.testing.assert_allclose(heights_are.gaussian(heights_are.heights(g)), g, atol=1e-9)
    beyond = -np.sign(skewness) * 1e3
    assert heights_are.gaussian(beyond) == np.sign(beyond) * np.inf


@pytest.mark.parametrize(("name", "skewness"), SOME)
def test_heights_at_two_points(name, skewness):
    """Against a quadrature over both Gaussian heights, of variance 0.98, for several correlations;
    at points close together it is what slopes have."""
    heights_are, variance = marginal(name), 0.98
    g, weight = np.polynomial.hermite_e.hermegauss(64)
    weight = np.outer(weight, weight) / weight.sum() ** 2
    for apart in (0.01, 0.3, 0.98):
        a, b = np.meshgrid(g * np.sqrt(variance - apart / 2), g * np.sqrt(apart / 2), indexing="ij")
        far = heights_are.heights(a + b) - heights_are.heights(a - b)
        assert heights_are.half_structure(variance, apart) == pytest.approx(
            (far**2 * weight).sum() / 2, rel=1e-6
        )
    near = heights_are.half_structure(1.0, 1e-7) / 1e-7
    assert near == pytest.approx(heights_are.slope_variance, rel=1e-6)
    by_height = np.array(heights_are.roughness())
    assert by_height[:, 0] ** 2 @ by_height[:, 1] == pytest.approx(1, rel=1e-6)
    length = heights_are.correlation_length(GAUSSIAN)
    far = 1 - GAUSSIAN.autocorrelation(np.array([length]))
    assert heights_are.half_structure(1.0, far)[0] == pytest.approx(1 - 1 / np.e)
    assert marginal("gaussian") is GAUSSIAN_HEIGHTS
    assert GAUSSIAN_HEIGHTS.correlation_length(GAUSSIAN) == 1


@pytest.mark.parametrize("autocorrelation", ["gaussian", "power-law:0.8"])
@pytest.mark.parametrize(("name", "skewness"), [("ridges:1.5", 1.5), ("pits:1.5", -1.5)])
def test_surfaces_have_the_skewness_and_the_slope_variance(name, skewness, autocorrelation):
    """Means over 64 surfaces, however coarse the mesh, within 4 of their standard errors, which
    the last lines say are small."""
    found = []
    for seed in range(64):
        resolution = Resolution(4, 16, 1, None, autocorrelation, name)
        surface = make_surface(resolution, np.random.default_rng(seed))
        _, planes = surface.period_triangles
        x, y = -surface.stretch(1.0, 0.3, 0.7).normals(planes[1:])[:2]
        h = surface.heights
        found.append([(h**3).mean(), h.mean(), (x * x).mean() / 0.5, (y * y).mean() / 0.045])
    mean, stderr = np.mean(found, axis=0), np.std(found, axis=0, ddof=1) / 8
    # Powers of a period's constant wave are left out of the skewness that is stated.
    assert np.all(np.abs(mean - [skewness, 0, 1, 1]) < 4 * stderr)
    assert np.all(stderr < [0.2, 0.05, 0.05, 0.05])


def energies(name, upside_down, seeds, material, theta):
    """Energies (surfaces, order, side) of light on surfaces as they are or upside down."""
    found, wi = [], ms.direction(theta=theta, phi=0.3)
    for seed in seeds:
        surface = make_surface(Resolution(6, 10, 1, heights_of=name), np.random.default_rng(seed))
        if upside_down:
            surface = Surface(-surface.heights, surface.cells, marginal=surface.marginal)
        tally = Tally(3, independent=False)
        tracer = Tracer(surface, surface.stretch(1.0, 1.0, 0.3), material, UPRIGHT)
        for light in tracer.trace(wi, 4000, np.random.default_rng(seed), 1000):
            tally.add(light)
        views = tally.views(tally.sums[0] / tally.rays)
        assert views["side"].sum() + views["unresolved"] == pytest.approx(1)
        found.append(views["energy"])
    return np.array(found)


@pytest.mark.parametrize(("material", "theta"), [(Conductor(), 0.5), (Dielectric(1.5), 1.4)])
def test_ridges_seen_from_below_are_pits(material, theta):
    """Of independent surfaces; ridges and pits themselves differ by far more than noise."""
    pits = energies("pits:2", False, range(24), material, theta)
    below = energies("ridges:2", True, range(100, 124), material, theta)
    above = energies("ridges:2", False, range(200, 224), material, theta)
    means = [e.mean(axis=0) for e in (pits, below, above)]
    squares = [e.var(axis=0, ddof=1) / 24 + 1e-8 for e in (pits, below, above)]
    same = (means[0] - means[1]) / np.sqrt(squares[0] + squares[1])
    other = (means[0] - means[2]) / np.sqrt(squares[0] + squares[2])
    assert np.abs(same).max() < 4
    assert np.abs(other).max() > 6


def test_simulations_see_ridges_from_above_only():
    """A mesh is four surfaces, and not eight: with those upside down, ridges would be like pits."""
    scene, found = Scene(Conductor(), Beckmann(1, 1), (0.5,), 0.3), {}
    for name in ("ridges:2", "pits:2"):
        resolution = Resolution(6, 10, 32, heights_of=name)
        paths = FreePaths((), (), np.array([0.0, 1.0]))
        run = simulate(scene, 100_000, resolution, paths, 3, 1, 1000, True)
        assert (run.heights, run.scene.slopes.name) == (name, "surface")
        alone = energies(name, False, range(300, 340), Conductor(), 0.5)[:, :2, 0]
        stated = run.tallies[0].estimate("energy")
        found[name] = stated.value[:2, 0], stated.stderr[:2, 0]
        noise = np.hypot(found[name][1], alone.std(axis=0, ddof=1) / np.sqrt(40))
        assert np.all(np.abs(found[name][0] - alone.mean(axis=0)) < 4 * noise)
    (ridges, error), (pits, other) = found.values()
    assert np.abs((ridges - pits) / np.hypot(error, other)).max() > 5


def test_controls_know_the_slopes_of_ridges():
    """Slopes given the height are Gaussian; facets, which are flat, differ by less than 1e-3."""
    wi, resolution = ms.direction(theta=1.0, phi=0.3), Resolution(8, 12, 1, heights_of="ridges:2")
    found = []
    for number in range(96):
        surface = realisation(resolution, number, 5)
        found.append(controls(surface, Views(surface.stretch(0.7, 0.7, 0.3), UPRIGHT), wi))
    stderr = np.std(found, axis=0, ddof=1) / np.sqrt(96)
    apart = np.mean(found, axis=0) - expected(Beckmann(0.7, 0.7), wi, marginal("ridges:2"))
    assert np.all(np.abs(apart) < 4 * stderr + 1e-3)
    beckmann = expected(Beckmann(0.7, 0.7), wi)
    assert np.abs(np.mean(found, axis=0) - beckmann).max() > 10 * stderr.max()


def test_slopes_are_counted_on_facets():
    """The kurtosis of a slope, 3 exp(4 s^2), of 16 surfaces, that of skewed ones within a third, as
    much as they scatter; and what facets show of themselves, the same in every quarter."""
    scene = Scene(Conductor(), Beckmann(0.8, 0.4), (0.0,))
    # exp(s^2) is the root w of (w + 2) sqrt(w - 1) = 2.
    w = optimize.brentq(lambda w: (w + 2) * np.sqrt(w - 1) - 2, 1, 2)
    for name, expected_kurtosis, within in (("gaussian", 3, 0.1), ("ridges:2", 3 * w**4, 0.35)):
        slopes = facet_slopes(scene, Resolution(8, 16, 16, heights_of=name), 1)
        np.testing.assert_allclose((slopes**2).mean(axis=(1, 2)), [0.32, 0.08], rtol=1e-9)
        kurtosis = (slopes**4).mean(axis=(1, 2)) / (slopes**2).mean(axis=(1, 2)) ** 2
        np.testing.assert_allclose(kurtosis, expected_kurtosis, rtol=within)
        table = counted(slopes, scene.alpha)
        assert table.alpha == (0.8, 0.4)
        d = ms.direction(theta=1.2, phi=0.4)
        x, y = slopes
        quarters = (x, y), (-2 * y, x / 2), (-x, -y), (2 * y, -x / 2)
        area = np.mean([np.maximum(d[2] - d[0] * a - d[1] * b, 0).mean() for a, b in quarters])
        assert table.sigma(-d[:, None])[0] == pytest.approx(area, abs=5e-4)


def test_free_paths_of_the_model_know_the_heights(rng):
    """-ln of the share of heights that are below."""
    for name in ("ridges:2", "pits:1"):
        law, heights_are = height_distribution(name), marginal(name)
        h = np.sort(heights_are.heights(rng.standard_normal(100_000)))
        below = np.searchsorted(h, [-0.5, 0, 0.5, 1]) / h.size
        np.testing.assert_allclose(np.exp(-law.t(np.array([-0.5, 0, 0.5, 1]))), below, atol=0.006)
        assert np.all(np.isfinite(law.t(np.array(law.starts[:-1]))))
    assert height_distribution("ridges:2").t(-5.0) == np.inf


def test_a_field_of_ridges():
    field = HeightField.random(alpha=0.6, seed=1, extent=32, cells=4, heights_of="ridges:1")
    # Of one surface; its skewness and its roughness scatter by some tenths.
    assert 0.5 < float((field.heights**3).mean()) < 1.6
    assert field.describe()["alpha_x"].value == pytest.approx(0.6, rel=0.1)
    assert spectrum("exponential").distance(0.5) < spectrum("exponential").correlation_length


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("hills", "gaussian, ridges, pits"),
        ("ridges:", "gaussian, ridges, pits"),
        ("ridges:high", "gaussian, ridges, pits"),
        ("ridges:nan", "gaussian, ridges, pits"),
        ("gaussian:1", "gaussian, ridges, pits"),
        ("ridges:5", "skewness is 5: a number from 0.01 to 4"),
        ("pits:-1", "skewness is -1: a number from 0.01 to 4"),
        ("pits:0", "skewness is 0"),
        ("ridges:inf", "skewness is inf"),
    ],
)
def test_what_is_no_distribution_of_heights_is_refused(text, said):
    with pytest.raises(ValueError, match=said):
        marginal(text)
