import numpy as np
import pytest

from surfaces.heightfield import all_waves, some_waves, synthesise
from surfaces.surface import Surface

EXTENT, CELLS, FIELDS = 8, 8, 200


@pytest.fixture(scope="module", params=["all", 300])
def fields(request):
    rng = np.random.default_rng(7)
    out = []
    for _ in range(FIELDS):
        if request.param == "all":
            amplitudes = all_waves(EXTENT, rng)
        else:
            amplitudes = some_waves(EXTENT, request.param, rng)
        out.append(synthesise(amplitudes, EXTENT, CELLS))
    return np.array(out)


def mean_and_error(per_field):
    return per_field.mean(), per_field.std(ddof=1) / np.sqrt(len(per_field))


def test_heights_have_mean_0_and_variance_1(fields):
    mean, stderr = mean_and_error(fields.mean(axis=(1, 2)))
    assert abs(mean) < 4 * stderr
    mean, stderr = mean_and_error((fields**2).mean(axis=(1, 2)))
    assert abs(mean - 1) < 4 * stderr


def test_correlation_function(fields):
    for lag in (1, 4, 8, 16):
        for axis in (1, 2):
            product = (fields * np.roll(fields, lag, axis=axis)).mean(axis=(1, 2))
            mean, stderr = mean_and_error(product)
            assert abs(mean - np.exp(-((lag / CELLS) ** 2))) < 4 * stderr


def test_slopes_have_variance_2_and_do_not_depend_on_heights(fields):
    # Central differences over 2 cells, delta = 1/4: variance (1 - exp(-4 delta^2)) / (2 delta^2).
    slope = (np.roll(fields, -1, axis=1) - np.roll(fields, 1, axis=1)) * CELLS / 2
    delta = 1 / CELLS
    expected = (1 - np.exp(-4 * delta**2)) / (2 * delta**2)
    mean, stderr = mean_and_error((slope**2).mean(axis=(1, 2)))
    assert abs(mean - expected) < 4 * stderr + 1e-12
    for power in (1, 2):
        product = (fields**power * slope**power).mean(axis=(1, 2))
        apart = (fields**power).mean(axis=(1, 2)).mean() * (slope**power).mean(axis=(1, 2)).mean()
        mean, stderr = mean_and_error(product)
        assert abs(mean - apart) < 4 * stderr


def test_heights_are_gaussian(fields):
    # Fourth moment 3, less 3/2 sum a^4 (number of waves finite): below 1.5 / (EXTENT^2 / pi).
    mean, stderr = mean_and_error((fields**4).mean(axis=(1, 2)))
    assert abs(mean - 3) < 4 * stderr + 1.5 * np.pi / EXTENT**2


def test_the_slope_variance_of_each_realisation_is_exact():
    rng = np.random.default_rng(3)
    for _ in range(3):
        field = synthesise(all_waves(16, rng), 16, 8)
        spectrum = np.fft.fft2(field)
        k = np.fft.fftfreq(len(field), 1 / 8) * 2 * np.pi
        variance = (np.abs(spectrum) ** 2 * k[:, None] ** 2).sum() / len(field) ** 4
        assert variance == pytest.approx(2, rel=1e-12)


def test_the_same_field_on_any_grid_and_periodic():
    amplitudes = all_waves(8, np.random.default_rng(1))
    coarse, fine = (synthesise(amplitudes, 8, cells) for cells in (4, 12))
    np.testing.assert_allclose(fine[::3, ::3], coarse, atol=1e-12)


def test_facet_slopes_are_beckmann_and_axes_do_not_mix():
    """Facets have variance alpha^2 / 2 exactly, and x and y slopes do not correlate: sampled
    without the mesh, over realisations."""
    rng = np.random.default_rng(11)
    alpha = (1.0, 0.3)
    moments = []
    for _ in range(60):
        surface = Surface(synthesise(all_waves(8, rng), 8, 4), 4)
        stretch = surface.stretch(*alpha, 0.7)
        _, planes = surface.period_triangles
        x, y = -stretch.normals(planes[1:])[:2]
        moments.append([(x * x).mean(), (y * y).mean(), (x * y).mean()])
    mean = np.mean(moments, axis=0)
    stderr = np.std(moments, axis=0, ddof=1) / np.sqrt(len(moments))
    expected = np.array([alpha[0] ** 2 / 2, alpha[1] ** 2 / 2, 0])
    # Single-precision heights: 1e-7 relative.
    assert np.all(np.abs(mean - expected) < 4 * stderr + 1e-6)
