"""Roughness in figures: against closed forms, and with error bars that hold."""

import numpy as np
import pytest

import msbsdf_cli as ms
from surfaces.describe import describe
from surfaces.describe.correlation import correlation_lengths
from surfaces.describe.fits import KINDS, fitted
from surfaces.describe.gaussian import errors_of_gaussian, helped
from surfaces.describe.moments import height_parameters, slope_parameters
from surfaces.describe.spread import block_means, covariance
from surfaces.field import HeightField
from surfaces.heightfield import all_waves, shortened, synthesise
from surfaces.levelling import levelled
from surfaces.patch import Patch

CELLS = 8
CELLS_OF_PATCHES = 4


def by_name(rows):
    return {row.quantity: row for row in rows}


def test_a_wave_in_closed_form():
    """h = A sin(k . x): Sa, Sq, Ssk, Sku, and slopes along the wave vector only."""
    n, step, azimuth = 512, (0.5, 0.25), np.arctan2(2 * 7, 5)
    x, y = np.ogrid[:n, :n]
    heights = 3 * np.sin(2 * np.pi * (5 * x + 7 * y) / n + 0.4)
    rows = by_name(describe(Patch(heights, step, periodic=True), "um").rows)
    k = 2 * np.pi / n * np.hypot(5 / step[0], 7 / step[1])
    expected = {
        "sa": 6 / np.pi,
        "sq": 3 / np.sqrt(2),
        "ssk": 0,
        "sku": 1.5,
        "sdq": 3 * k / np.sqrt(2),
        "alpha_x": 3 * k * np.cos(azimuth),
        "alpha_y": 3 * k * np.sin(azimuth),
        "direction_rad": azimuth,
        # The autocorrelation of a wave is a cosine.
        "correlation_length_x": np.arccos(1 / np.e) * n * step[0] / (2 * np.pi * 5),
    }
    for name, value in expected.items():
        # Facets are chords of a wave of 73 points; |h| has kinks.
        assert rows[name].value == pytest.approx(value, rel=2e-3, abs=1e-12), name
    # Slopes along x and along y are half a cell apart.
    assert rows["anisotropy"].value > 50
    assert (rows["sa"].unit, rows["ssk"].unit, rows["direction_rad"].unit) == ("um", "", "rad")


def test_the_correlation_length_of_a_field_whose_autocorrelation_is_exact():
    """All waves have their expected power: R(l) = exp(-l^2) exactly over the period, but for the
    constant wave, whose power pi / 16^2 goes with the mean."""
    heights = synthesise(all_waves(16, np.random.default_rng(1)), 16, CELLS)
    rows = by_name(describe(Patch(heights, (1 / CELLS, 3 / CELLS), periodic=True)).rows)
    # Linear between points 1/8 apart, where the second derivative is 2/e: 1/8^2 / 8 * 2/e / (2/e).
    mean = np.pi / 16**2
    length = np.sqrt(-np.log(1 / np.e + mean * (1 - 1 / np.e)))
    for name, scale in (("x", 1), ("y", 3)):
        found = rows[f"correlation_length_{name}"].value
        assert found == pytest.approx(scale * length, abs=scale / CELLS**2 / 8)
    assert rows["correlation_areas"].value == pytest.approx(256 / length**2, rel=0.01)


@pytest.fixture(scope="module")
def patches():
    """112 patches of 24 correlation lengths, cut from fields of 96, of roughness 0.6 and 0.3."""
    cells = CELLS_OF_PATCHES
    n = 24 * cells
    step = tuple(2 / (a * shortened(cells, 96)) for a in (0.6, 0.3))
    found = []
    for seed in range(7):
        whole = synthesise(all_waves(96, np.random.default_rng(seed)), 96, cells)
        found += [
            Patch(levelled(whole[i : i + n, j : j + n]), step)
            for i in range(0, 4 * n, n)
            for j in range(0, 4 * n, n)
        ]
    return found


def deviations(found, truth):
    """(value - truth) / stderr, a row for each quantity."""
    return np.array([[(f[k].value - v) / f[k].stderr for f in found] for k, v in truth.items()])


def test_error_bars_cover_the_truth_as_often_as_they_say(patches):
    """Roughness within two standard errors in 95 of 100; of 112 at least 100, which 97 of 100 such
    tests reach, and deviations of mean square 1, whose error is sqrt(2 / 112)."""
    truth = {"alpha_x": 0.6, "alpha_y": 0.3, "anisotropy": 2, "direction_rad": 0}
    truth |= {"slope_correlation": 0, "sdq": np.sqrt(0.18 + 0.045)}
    z = deviations([by_name(slope_parameters(p)) for p in patches], truth)
    assert np.all(np.count_nonzero(np.abs(z) < 2, axis=1) >= 100)
    # 24 numbers tell a standard error: t has a mean square of 24 / 22.
    assert np.all(np.abs((z**2).mean(axis=1) - 24 / 22) < 3 * np.sqrt(2 / 112))
    heights = [by_name(height_parameters(p, "") + correlation_lengths(p, "")) for p in patches]
    lengths = [patches[0].step[axis] * CELLS_OF_PATCHES for axis in (0, 1)]
    truth = {f"correlation_length_{name}": x for name, x in zip("xy", lengths, strict=True)}
    truth |= {"sq": 1, "ssk": 0, "sku": 3, "correlation_length": np.sqrt(np.prod(lengths))}
    z = deviations(heights, truth)
    assert np.all(np.count_nonzero(np.abs(z) < 2, axis=1) >= 100)
    # Told from the patch alone, error bars of Sku are short where it is small: 1.38. The sum of
    # those of both axes is long for their mean: 0.66.
    assert np.all(np.abs((z**2).mean(axis=1) - 1) < 2.4 * np.sqrt(2 / 112))


def test_errors_of_gaussian_heights_in_closed_form():
    """rho is exp(-r^2): its cube and its fourth power have the integrals pi / 3 and pi / 4."""
    h = synthesise(all_waves(64, np.random.default_rng(3)), 64, 4)
    expected = np.sqrt([6 * np.pi / 3, 24 * np.pi / 4]) / 64
    np.testing.assert_allclose(errors_of_gaussian(h, periodic=True), expected, rtol=0.05)
    # Of a quarter there are as many areas less, and pairs at a distance are fewer.
    part = errors_of_gaussian(h[:128, :128] - h[:128, :128].mean(), periodic=False)
    np.testing.assert_allclose(part, 2 * expected, rtol=0.15)
    own, gaussian = np.array([0.3, 0.7]), np.array([0.4, 0.1])
    assert helped(own, np.array([0.1, 3.1]), gaussian) == pytest.approx(np.sqrt([0.125, 0.25]))
    for figures in ([0.9, 3.1], [0.1, 3.3], [0.1, 2.7]):
        assert helped(own, np.array(figures), gaussian) is own


@pytest.fixture(scope="module")
def student_slopes():
    """Slopes of 100 patches on which the roughness changes from place to place, such that they are
    Student's t all in all: 0.5 and 0.3, gamma 3."""
    extent, cells, tile, gamma = 128, 2, 2, 3.0
    rng, found, n = np.random.default_rng(8), [], extent * cells // 2
    for seed in range(25):
        h = synthesise(all_waves(extent, np.random.default_rng(seed)), extent, cells)
        slopes = np.stack([np.roll(h, -1, axis) - h for axis in (0, 1)])
        slopes /= slopes.std(axis=(1, 2), keepdims=True)
        freedom, tiles = 2 * gamma - 2, (extent // tile,) * 2
        rough = np.sqrt(freedom / rng.chisquare(freedom, tiles))
        slopes *= np.kron(rough, np.ones((tile * cells,) * 2))
        slopes *= np.array([[[0.5]], [[0.3]]]) / np.sqrt(2)
        found += [slopes[:, i : i + n, j : j + n] for i in (0, n) for j in (0, n)]
    return found


def test_roughness_and_gamma_of_student_t_surfaces(student_slopes):
    fits = [fitted(slopes, KINDS[2]) for slopes in student_slopes]
    errors = np.sqrt([np.diag(fit.covariance) for fit in fits])
    found = np.array(
        [(np.log(f.alpha_x / 0.5), np.log(f.alpha_y / 0.3), f.tail - 0.5) for f in fits]
    )
    gamma = np.array([1 + 1 / f.tail - 3 for f in fits]) / (
        errors[:, 2] / np.square([f.tail for f in fits])
    )
    z = np.column_stack([found / errors, gamma])
    # At least 89 of 100, which 99 of 100 such tests reach.
    assert np.all(np.count_nonzero(np.abs(z) < 2, axis=0) >= 89)
    assert np.all(np.abs((z**2).mean(axis=0) - 24 / 22) < 4 * np.sqrt(2 / 100))


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_fits_to_independent_slopes(kind):
    """Of the models' own distributions: normals visible from the zenith are all there are."""
    model = {
        "beckmann": ms.Beckmann(0.5, 0.3),
        "ggx": ms.Ggx(0.5, 0.3),
        "student_t": ms.StudentT(0.5, 0.3, gamma=4.0),
    }[kind.name]
    n = 256
    m = model.visible_normals(ms.direction(0.0)[:, None], n * n, np.random.default_rng(3))
    slopes = (-m[:2] / m[2]).reshape(2, n, n)
    fit = fitted(slopes, kind)
    errors = np.sqrt(np.diag(fit.covariance))
    assert abs(np.log(fit.alpha_x / 0.5)) < 4 * errors[0] < 0.04
    assert abs(np.log(fit.alpha_y / 0.3)) < 4 * errors[1] < 0.04
    if kind.tail is None:
        assert abs(fit.tail - 1 / 3) < 4 * errors[2] < 0.1
    # Kolmogorov's distribution: above 1.95 once in a thousand.
    assert fit.misfit < 1.95 / n
    others = [
        fitted(slopes, other).misfit for other in KINDS if other.tail not in (None, kind.tail)
    ]
    assert min(others) > 4 * fit.misfit


def test_the_variance_of_a_mean_of_white_noise():
    values = np.random.default_rng(5).standard_normal((2, 300, 410))
    blocks = block_means(values)
    assert blocks.shape == (2, 30, 31)
    found = covariance(blocks) * 300 * 410
    # 24 numbers: to a factor of about 1.5 either way, and uncorrelated to sqrt(1 / 24).
    assert np.all((np.diag(found) > 0.4) & (np.diag(found) < 2))
    assert abs(found[0, 1]) < 4 * np.sqrt(1 / 24)


@pytest.mark.parametrize("periodic", [True, False])
def test_the_filter_lets_half_of_its_length_pass(periodic):
    n, step = 128, (0.5, 0.25)
    x, y = np.meshgrid(*(np.arange(n) + 0.5,) * 2, indexing="ij")
    # A wave of the period, which is its own mirror image too.
    for wave, s in (
        (np.cos(2 * np.pi * 4 * x / n), step[0]),
        (np.cos(2 * np.pi * 4 * y / n), step[1]),
    ):
        patch = Patch(wave, step, periodic)
        np.testing.assert_allclose(patch.filtered(n * s / 4).heights, wave / 2, atol=1e-12)
    with pytest.raises(ValueError, match="filter length is 0"):
        patch.filtered(0)


def test_roughness_over_the_filter_length():
    """The power spectrum exp(-k^2 / 4) less what the filter takes: slope variance 4 / (1 + c)^2."""
    heights = synthesise(all_waves(32, np.random.default_rng(2)), 32, 16)
    rows = describe(Patch(heights, (1 / 16, 1 / 16), periodic=True)).rows
    found = [row for row in rows if row.quantity == "sdq_filtered"]
    assert [row.note.split()[-1] for row in found] == ["0.125", "0.25", "0.5", "1"][: len(found)]
    assert len(found) >= 3
    for row in found:
        c = 8 * np.log(2) * (float(row.note.split()[-1]) / (2 * np.pi)) ** 2
        # Chords: 1 / (2 * 16^2) of the variance.
        assert row.value == pytest.approx(2 / (1 + c), rel=1e-3)


def test_what_geometrical_optics_leaves_out():
    """Correlation length 1e-6, heights 0.5e-6; the radius of curvature of a Gaussian field is
    l^2 / (sqrt(12) Sq)."""
    heights = 0.5e-6 * synthesise(all_waves(16, np.random.default_rng(1)), 16, 16)
    field = HeightField(heights, (1e-6 / 16, 1e-6 / 16))
    radius = 1e-12 / (np.sqrt(12) * 0.5e-6)
    assert field.describe("m", 0.5e-6).warnings == []
    for wavelength, said in ((1.5e-6, ["diffracted"]), (2.5e-6, ["diffracted", "mirror image"])):
        warnings = field.describe("m", wavelength).warnings
        assert len(warnings) == len(said)
        assert all(word in text for word, text in zip(said, warnings, strict=True))
    bends = field.describe("m", 13 * radius).warnings
    assert any("facets bend over 0.07" in text for text in bends)
    with pytest.raises(ValueError, match="wavelength is -1"):
        field.describe("m", -1)


def test_a_small_patch_says_so():
    few = HeightField(synthesise(all_waves(8, np.random.default_rng(1)), 8, 8), (1.0, 1.0))
    assert "correlation areas" in few.describe().warnings[0]
    ramp = np.sin(np.linspace(0, 1, 40))[:, None] + np.zeros(40)
    about = HeightField(ramp, (1.0, 1.0), periodic=False).describe()
    assert "slopes along one axis are all the same" in about.warnings[0]
    assert "too small to describe" in about.warnings[1]
    assert "" in about.to_columns()["value"]
