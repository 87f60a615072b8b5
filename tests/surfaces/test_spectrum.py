"""Spectra of random surfaces: closed forms, and fields that have what they say."""

import numpy as np
import pytest

from msbsdf_cli.experiments.random_surfaces import Resolution, make_surface, realisation
from msbsdf_cli.experiments.resolution import as_fine
from surfaces.heightfield import all_waves, shortened, some_waves, synthesise
from surfaces.spectrum import GAUSSIAN, NAMES, spectrum
from surfaces.spectrum.matern import BAND

SOME = ("gaussian", "exponential", "matern:2.5", "power-law:0.8", "power-law:0.3")


@pytest.mark.parametrize("name", [*SOME, "matern:0.1", "matern:50"])
def test_heights_have_variance_1_and_slopes_2(name):
    """R(0) = 1 and -R''(0) = 2, by differences."""
    kind, h = spectrum(name), 1e-3
    assert kind.name == name
    r = kind.autocorrelation(np.array([0, h, 2 * h]))
    assert r[0] == pytest.approx(1, abs=1e-12)
    # The fourth derivative is below 3/8 k_max^2 times 2.
    assert 2 * (1 - r[1]) / h**2 == pytest.approx(2, abs=kind.k_max**2 * h**2)
    assert kind.autocorrelation(np.array([kind.correlation_length]))[0] == pytest.approx(1 / np.e)
    assert kind.chord_variance(1 / h) == pytest.approx(1, abs=kind.k_max**2 * h**2)
    assert kind.chord_variance(10) < kind.chord_variance(20) < 1


def test_closed_forms():
    r = np.linspace(0, 6, 50)
    np.testing.assert_allclose(GAUSSIAN.autocorrelation(r), np.exp(-r * r), atol=1e-12)
    chord = 8 * np.sqrt(1 / 64 / -np.expm1(-1 / 64))
    assert shortened(8, 16) == pytest.approx(chord, rel=1e-12)
    assert 8 / np.sqrt(GAUSSIAN.chord_variance(8)) == pytest.approx(chord, rel=1e-12)
    smooth = spectrum("matern:2.5")
    x = r / smooth.length
    # Beyond the band there is 16^-5 of the variance.
    np.testing.assert_allclose(
        smooth.autocorrelation(r), (1 + x + x * x / 3) * np.exp(-x), atol=2 * BAND**-5
    )
    rough = spectrum("exponential")
    np.testing.assert_allclose(
        rough.autocorrelation(r), spectrum("matern:0.5").autocorrelation(r), atol=1e-12
    )
    # What is cut off has this variance, and its autocorrelation is no larger.
    cut = 1 / np.sqrt(1 + BAND**2)
    apart = (1 - cut) * rough.autocorrelation(r) - np.exp(-r / rough.length)
    assert np.abs(apart).max() <= cut * (1 + 1e-9)
    for H in (0.3, 0.8):
        heights = 1 / 2 + (1 - BAND ** (-2 * H)) / (2 * H)
        slopes = 1 / 4 + (BAND ** (2 - 2 * H) - 1) / (2 - 2 * H)
        found = spectrum(f"power-law:{H}").length
        assert found == pytest.approx(np.sqrt(slopes / heights) / 2, rel=1e-9)


@pytest.mark.parametrize("name", SOME)
def test_fields_have_the_autocorrelation(name):
    """Over realisations, and the slope variance exactly in each."""
    kind, extent, cells = spectrum(name), 24, 6
    products, heights = [], []
    for seed in range(40):
        field = synthesise(all_waves(extent, np.random.default_rng(seed), kind), extent, cells)
        k = np.fft.fftfreq(len(field), 1 / cells) * 2 * np.pi
        power = np.abs(np.fft.fft2(field)) ** 2 / len(field) ** 4
        if kind.k_max < np.pi * cells:
            assert (k**2 @ power).sum() == pytest.approx(2, rel=1e-9)
        lags = np.fft.ifft(power.sum(axis=1)).real * len(field)
        products.append(lags[[0, 3, 6, 12, 18]])
        heights.append(field.mean())
    mean, noise = np.mean(products, axis=0), np.std(products, axis=0, ddof=1) / np.sqrt(40)
    expected = kind.autocorrelation(np.array([0, 3, 6, 12, 18]) / cells)
    # A sum over the waves of the period in place of an integral.
    period = 2 * kind.correlation_length**2 / extent**2
    assert np.all(np.abs(mean - expected) < 4 * noise + period)
    few = [some_waves(extent, 300, np.random.default_rng(seed), kind) for seed in range(40)]
    variance = [(synthesise(a, extent, cells) ** 2).mean() for a in few]
    stderr = np.std(variance, ddof=1) / np.sqrt(40)
    assert abs(np.mean(variance) - 1) < 4 * stderr + period


@pytest.mark.parametrize("name", SOME)
def test_facets_have_beckmanns_slopes(name):
    """Variance alpha^2 / 2, whatever the spectrum and however coarse the mesh."""
    moments = []
    for seed in range(12):
        surface = make_surface(Resolution(4, 16, 1, None, name), np.random.default_rng(seed))
        _, planes = surface.period_triangles
        x, y = -surface.stretch(1.0, 0.3, 0.7).normals(planes[1:])[:2]
        moments.append([(x * x).mean(), (y * y).mean(), (x * y).mean()])
    mean, stderr = np.mean(moments, axis=0), np.std(moments, axis=0, ddof=1) / np.sqrt(12)
    assert np.all(np.abs(mean - [0.5, 0.045, 0]) < 4 * stderr + 1e-6)


def test_meshes_are_as_fine_for_every_spectrum():
    assert as_fine(GAUSSIAN, 16) == 16
    for name in SOME[1:]:
        cells = as_fine(spectrum(name), 16)
        lacks = 1 - spectrum(name).chord_variance(cells)
        assert cells > 16
        assert lacks == pytest.approx(1 - GAUSSIAN.chord_variance(16), rel=0.2)
        assert lacks < 1 - GAUSSIAN.chord_variance(16) + 1e-9


def test_a_realisation_is_that_of_its_spectrum():
    fields = {name: realisation(Resolution(4, 8, 1, None, name), 0, 0).heights for name in SOME}
    assert len({heights.tobytes() for heights in fields.values()}) == len(SOME)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("wood", "one of exponential, gaussian, matern, power-law"),
        ("matern", "matern:NU is wanted"),
        ("matern:rough", "matern:NU is wanted"),
        ("gaussian:rough", "gaussian is wanted"),
        ("matern:0", "nu is 0: a number from 0.1 to 50"),
        ("matern:nan", "nu is nan"),
        ("gaussian:1", "gaussian is wanted"),
        ("power-law:1", "H is 1: a number above 0 and below 1"),
        ("exponential:2,3", "exponential is wanted"),
    ],
)
def test_what_is_no_spectrum_is_refused(text, said):
    assert set(NAMES) == {"exponential", "gaussian", "matern", "power-law"}
    with pytest.raises(ValueError, match=said):
        spectrum(text)
