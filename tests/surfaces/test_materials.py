"""The scattering kernel: totals, reciprocity, facets added up one by one."""

import numpy as np
import pytest

from msbsdf_cli.smith.slopes import distribution
from surfaces.facet import dot
from surfaces.materials import Conductor, Dielectric, Diffuse


def dielectric_density(slopes, eta, d, w):
    """q (n,) off and through an interface of index `eta` behind over before; reversed,
    q_t(d -> w) = eta^2 q_t'(-w -> -d), where the dash is for the other side."""
    interface = Dielectric(eta)
    reflected, _ = interface.reflection(slopes, d, w)
    return reflected, interface.refraction(slopes, d, w)


def directions(n, seed):
    d = np.random.default_rng(seed).normal(size=(3, n))
    return d / np.sqrt(dot(d, d))


def sphere(n):
    """Product quadrature: Gauss in z on either side of the horizon, even in azimuth."""
    z, weight = np.polynomial.legendre.leggauss(n)
    z, weight = np.concatenate([(z - 1) / 2, (z + 1) / 2]), np.tile(weight / 2, 2)
    phi = (np.arange(2 * n) + 0.5) * np.pi / n
    sin = np.sqrt(1 - z * z)
    w = np.stack([np.outer(sin, np.cos(phi)), np.outer(sin, np.sin(phi)), np.outer(z, 1 + 0 * phi)])
    return w.reshape(3, -1), np.repeat(weight, 2 * n) * np.pi / n


@pytest.mark.parametrize("slopes", ["beckmann", "ggx"])
@pytest.mark.parametrize("material", [Conductor(), Diffuse((0.3, 1.0))])
def test_reciprocity(slopes, material):
    d, w = directions(200, 1), directions(200, 2)
    forth = material.density(distribution(slopes)(0.8, 0.3), d, w)
    back = material.density(distribution(slopes)(0.8, 0.3), -w, -d)
    # A mirror is symmetric to rounding, a diffuse facet to its quadrature.
    np.testing.assert_allclose(forth, back, atol=1e-12 if material.name == "conductor" else 1e-5)


@pytest.mark.parametrize("slopes", ["beckmann", "ggx"])
def test_refraction_is_reciprocal_up_to_the_index_squared(slopes):
    d, w = directions(500, 3), directions(500, 4)
    forth = dielectric_density(distribution(slopes)(0.8, 0.3), 1.5, d, w)
    back = dielectric_density(distribution(slopes)(0.8, 0.3), 1 / 1.5, -w, -d)
    assert np.count_nonzero(forth[1]) > 20
    np.testing.assert_allclose(forth[1], 1.5**2 * back[1], rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("slopes", ["beckmann", "ggx"])
@pytest.mark.parametrize("elevation", [-1.5, -0.7, -0.1, 0.4])
def test_all_that_a_mirror_or_an_interface_scatters_is_sigma(slopes, elevation):
    surface = distribution(slopes)(0.7, 0.5)
    w, weight = sphere(250)
    d = np.array([[0.6 * np.cos(elevation)], [0.8 * np.cos(elevation)], [np.sin(elevation)]])
    sigma = surface.sigma(d)[0]
    before = np.broadcast_to(d, w.shape)
    mirror = Conductor().density(surface, before, w)[0] @ weight
    interface = [sum(dielectric_density(surface, eta, before, w)) @ weight for eta in (1.5, 0.7)]
    # The edges of the kernel cut through the cells of the quadrature: first order in 1/250.
    np.testing.assert_allclose([mirror, *interface], sigma, atol=4e-3 * sigma + 1e-5)


@pytest.mark.parametrize("slopes", ["beckmann", "ggx"])
@pytest.mark.parametrize("alpha", [(1.0, 1.0), (0.8, 0.2), (0.1, 0.1)])
def test_diffuse_facets_added_up_one_by_one(slopes, alpha):
    surface = distribution(slopes)(*alpha)
    d, w = directions(12, 5), directions(12, 6)
    # Awkward pairs: straight on, straight back, vertical, and in one plane with the normal.
    w[:, 0], w[:, 1] = d[:, 0], -d[:, 1]
    d[:, 2], w[:, 2] = [0, 0, -1], [0, 0, 1]
    d[:, 3], w[:, 3] = [0.6, 0, -0.8], [0.8, 0, 0.6]
    expected = np.zeros(12)
    m, weight = sphere(300)
    m, weight = m[:, m[2] > 0] * [[alpha[0]], [alpha[1]], [1]], weight[m[2] > 0]
    length = np.sqrt(dot(m, m))
    m /= length
    weight = surface.D(m) * weight * alpha[0] * alpha[1] / length**3 / np.pi
    for i in range(12):
        expected[i] = (np.maximum(-d[:, i] @ m, 0) * np.maximum(w[:, i] @ m, 0)) @ weight
    value = Diffuse().density(surface, d, w)[0]
    # 300 by 600 facets leave 1e-6; the method's 40 nodes about as much.
    np.testing.assert_allclose(value, expected, atol=5e-6)


@pytest.mark.parametrize("azimuth", [0.3, 1.0, 2.0, 4.0, 5.5])
def test_diffuse_density_straight_from_above(azimuth):
    # The axis of the lune is level there, and its z a zero of either sign.
    slopes = distribution("ggx")(1, 1)
    w = np.array([[0.6 * np.cos(azimuth)], [0.6 * np.sin(azimuth)], [0.8]])
    straight = Diffuse().density(slopes, np.array([[0.0], [0.0], [-1.0]]), w)
    nearly = Diffuse().density(slopes, np.array([[1e-7], [0.0], [-1.0]]), w)
    np.testing.assert_allclose(straight, nearly, rtol=1e-5)


def test_what_absorbs_all_light_reflects_none_and_not_less():
    cos_i = np.append(np.linspace(0.01, 1, 1000), 1 - np.geomspace(1e-16, 1e-3, 100))
    for dtype in (np.float64, np.float32):
        reflectance = Conductor(((1.0, 0.0),)).reflectance(cos_i.astype(dtype))
        assert (reflectance >= 0).all()
