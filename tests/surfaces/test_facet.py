import numpy as np
import pytest

from surfaces.facet import (
    absorptance_conductor,
    dot,
    fresnel_dielectric,
    lambertian,
    reflect,
    unit_circle,
)
from surfaces.materials import Conductor, Dielectric, Diffuse
from surfaces.materials._metals import METALS


def unit(v):
    return v / np.sqrt(dot(v, v))


def facing_pairs(n, rng):
    """Random unit normals with m_z > 0 and directions of travel that meet them."""
    m = unit(rng.standard_normal((3, n)))
    m[2] = np.abs(m[2])
    d = unit(rng.standard_normal((3, n)))
    return d * -np.sign(dot(d, m)), m


def test_fresnel_at_normal_incidence():
    # ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2), and no refraction of the direction.
    one = np.ones(1)
    fresnel, cos_t = fresnel_dielectric(one, 1.5)
    assert fresnel[0] == pytest.approx(0.04, abs=1e-15)
    assert cos_t[0] == 1
    n, k = 0.43, 2.455
    expected = ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2)
    assert Conductor(((n, k),)).reflectance(one)[0, 0] == pytest.approx(expected, rel=1e-14)


def test_fresnel_conductor_without_absorption_is_the_dielectric():
    cos_i = np.linspace(1e-6, 1, 1000)
    np.testing.assert_allclose(
        1 - absorptance_conductor(cos_i, 1.7, 0.0), fresnel_dielectric(cos_i, 1.7)[0], rtol=1e-9
    )


def test_fresnel_conductor_against_complex_arithmetic():
    cos_i = np.linspace(1e-4, 1, 500)
    for index in (complex(*METALS["gold"][1]), complex(3.0, 0.2), complex(0.05, 0.01)):
        cos_t = np.sqrt(1 - (1 - cos_i**2) / index**2)
        r_s = (cos_i - index * cos_t) / (cos_i + index * cos_t)
        r_p = (index * cos_i - cos_t) / (index * cos_i + cos_t)
        expected = (np.abs(r_s) ** 2 + np.abs(r_p) ** 2) / 2
        np.testing.assert_allclose(
            1 - absorptance_conductor(cos_i, index.real, index.imag), expected, rtol=1e-10
        )


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("n", [1e-4, 0.001, 0.9, 1.3, 40.0])
@pytest.mark.parametrize("k", [1e-4, 0.5, 10.0, 300.0])
def test_absorption_to_all_digits(n, k, dtype):
    """Against 1 - |r|^2 in long arithmetic, also where 1 - F is below the rounding of F."""
    cos_i = np.linspace(1e-3, 1, 200).astype(dtype)
    n, k = float(dtype(n)), float(dtype(k))
    c = cos_i.astype(np.longdouble)
    g = np.sqrt(np.clongdouble(complex(n, k)) ** 2 - (1 - c) * (1 + c))
    index2 = np.clongdouble(complex(n, k)) ** 2
    # 1 - |(1 - z) / (1 + z)|^2 = 4 Re z / |1 + z|^2.
    s, p = g / c, g / (index2 * c)
    expected = sum(2 * z.real / np.abs(1 + z) ** 2 for z in (s, p))
    absorbed = absorptance_conductor(cos_i, dtype(n), dtype(k))
    assert absorbed.dtype == dtype
    # n^2 - k^2 - sin^2 loses digits where it nearly vanishes, as for n near 1 at grazing.
    np.testing.assert_allclose(absorbed, expected, rtol=200 * np.finfo(dtype).eps)


def test_a_metal_that_hardly_absorbs_in_either_precision(rng):
    for dtype in (np.float32, np.float64):
        d, m = (a.astype(dtype) for a in facing_pairs(1000, rng))
        gain = Conductor(((0.001, 10.0),)).scatter(d, m, None, rng).gain
        cos_i = np.abs(dot(d, m)).astype(float)
        expected = absorptance_conductor(cos_i, 0.001, 10.0)
        np.testing.assert_allclose(
            1 - gain[0], expected, rtol=1e-4 if dtype is np.float32 else 1e-9
        )


def test_no_absorption_at_the_critical_angle():
    cos_c = np.sqrt(1 - 0.25)
    for cos_i in (cos_c, np.nextafter(cos_c, 0), np.nextafter(cos_c, 1)):
        absorbed = absorptance_conductor(np.array([cos_i]), 0.5, 0.0)
        # Beyond, the refracted share grows with the root of the distance, that of rounding here.
        assert 0 <= absorbed[0] < 1e-6


def test_total_internal_reflection():
    fresnel, cos_t = fresnel_dielectric(np.array([0.1, 0.7]), 1 / 1.5)
    assert fresnel[0] == 1
    assert cos_t[0] == 0
    assert fresnel[1] == 1


def test_reflection_keeps_length_and_angle(rng):
    d, m = facing_pairs(1000, rng)
    out = reflect(d, 3.7 * m)
    np.testing.assert_allclose(dot(out, out), 1, rtol=1e-14)
    np.testing.assert_allclose(dot(out, m), -dot(d, m), atol=1e-14)


def test_dielectric_obeys_snell_and_fresnel(rng):
    n = 200_000
    d, m = facing_pairs(n, rng)
    inside = rng.random(n) < 0.5
    out = Dielectric(1.5).scatter(d, 0.3 * m, inside, rng)
    np.testing.assert_allclose(dot(out.d, out.d), 1, rtol=1e-12)
    sine = [np.sqrt(np.maximum(1 - dot(v, m) ** 2, 0)) for v in (d, out.d)]
    ratio = np.where(out.transmitted, np.where(inside, 1.5, 1 / 1.5), 1)
    # sin = sqrt(1 - cos^2) loses digits near normal incidence: 1e-16 / 1e-8.
    np.testing.assert_allclose(sine[1], sine[0] * ratio, atol=3e-8)
    assert np.all((dot(out.d, m) < 0) == out.transmitted)
    eta = np.where(inside, 1 / 1.5, 1.5)
    fresnel, _ = fresnel_dielectric(-dot(d, m), eta)
    # A sum of n independent choices: 4 standard errors.
    expected, variance = (1 - fresnel).sum(), (fresnel * (1 - fresnel)).sum()
    assert abs(out.transmitted.sum() - expected) < 4 * np.sqrt(variance)


def test_lambertian_lobe(rng):
    n = 400_000
    m = unit(np.array([[0.6], [-0.3], [0.2]])) * np.ones((1, n))
    out = lambertian(m, n, rng)
    np.testing.assert_allclose(dot(out, out), 1, rtol=1e-12)
    cos = dot(out, m)
    assert cos.min() >= 0
    # A cosine lobe: cos^2 is uniform, and the mean direction is 2/3 of the normal.
    counts = np.histogram(cos**2, 50, (0, 1))[0]
    from chi_square import chi_square_p

    assert chi_square_p(counts, np.full(50, n / 50)) > 1e-4
    # Standard deviation of a component is at most 0.5.
    np.testing.assert_allclose(out.mean(axis=1), 2 / 3 * m[:, 0], atol=4 * 0.5 / np.sqrt(n))


def test_unit_circle_is_uniform_and_of_length_one(rng):
    for dtype in (np.float32, np.float64):
        c, s = unit_circle(200_000, rng, dtype)
        assert c.dtype == dtype
        np.testing.assert_allclose(c * c + s * s, 1, rtol=8 * np.finfo(dtype).eps)
        assert abs(c.mean()) < 4 * np.sqrt(0.5 / 200_000)
        assert abs((c * s).mean()) < 4 * np.sqrt(0.125 / 200_000)


def test_absorption(rng):
    d, m = facing_pairs(1000, rng)
    assert Conductor().scatter(d, m, None, rng).gain is None
    gold = Conductor(METALS["gold"]).scatter(d, m, None, rng)
    assert gold.gain.shape == (3, 1000)
    assert np.all((gold.gain > 0) & (gold.gain < 1))
    assert np.all(Diffuse((0.3,)).scatter(d, m, None, rng).gain == 0.3)
