"""The scattering kernel and the quadrature over visible slopes."""

import numpy as np
import pytest
from spheres import direction, hemisphere, sphere

from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.smith.visible_slopes import visible_slopes
from surfaces.facet import dot
from surfaces.materials import Conductor, Dielectric, Diffuse

SLOPES = [Beckmann(1, 1), Ggx(1, 1), Beckmann(1, 0.1), Ggx(20, 0.3)]


@pytest.mark.parametrize("slopes", SLOPES)
def test_visible_slopes_sum_to_the_projected_area(slopes):
    d = -direction([0, 0.5, 1.2, 1.57, 2.0, 2.4], 0.3)
    for split in (False, True):
        _, weight = visible_slopes(slopes, d, split=split)
        np.testing.assert_allclose(weight.sum(axis=0), slopes.sigma(d), rtol=2e-4)


@pytest.mark.parametrize("slopes", SLOPES)
def test_diffuse_kernel_agrees_with_sampled_normals(slopes):
    rng = np.random.default_rng(1)
    d = -direction([0.3, 1.5, 0.9, 2.0], [0.2, 0, 3.0, 1.0])
    w = direction([0.9, 1.4, 1.55, 0.5], [2.0, 0.1, 3.2, 4.0])
    q = Diffuse((0.5, 1.0)).density(slopes, d, w)
    np.testing.assert_allclose(q[0], q[1] / 2)
    for k in range(4):
        m = slopes.visible_normals(-d[:, [k]], 100000, rng)
        m /= np.sqrt(dot(m, m))
        sample = np.maximum(dot(w[:, [k]], m), 0) / np.pi * slopes.sigma(d[:, [k]])
        assert abs(sample.mean() - q[1, k]) < 4 * sample.std() / np.sqrt(sample.size)


@pytest.mark.parametrize("slopes", [Beckmann(1, 1), Ggx(0.7, 0.4)])
@pytest.mark.parametrize("z", [-0.95, -0.3, 0.2])
def test_mirror_kernel_sums_to_the_projected_area(slopes, z):
    # Over the whole sphere, since facets may send light further down; 2 % is the error of this
    # rule at the jump of q where w = d. Facets below the horizon would add up to 29 %.
    d = np.array([[np.sqrt(1 - z * z)], [0], [z]])
    w, solid_angle = sphere(128)
    q = Conductor().density(slopes, d, w)[0]
    np.testing.assert_allclose((q * solid_angle).sum(), slopes.sigma(d)[0], rtol=0.02)
    h = w - d
    assert (q[h[2] <= 0] == 0).all()


@pytest.mark.parametrize("inside", [False, True])
def test_dielectric_kernel_sums_to_the_projected_area(inside):
    # The rule's error at the border of total reflection is below 1 %.
    slopes, glass, d = Beckmann(1, 1), Dielectric(1.5), -direction(0.6, 0.2)[:, None]
    w, solid_angle = sphere(96)
    q = glass.density(slopes, d, w, inside) + glass.density(slopes, d, w, inside, transmitted=True)
    np.testing.assert_allclose((q[0] * solid_angle).sum(), slopes.sigma(d)[0], rtol=0.01)


def test_specular_kernels_are_the_same_from_both_ends():
    rng = np.random.default_rng(2)
    d, w = (direction(np.arccos(rng.uniform(-1, 1, 500)), rng.uniform(0, 6, 500)) for _ in "dw")
    slopes, glass = Ggx(0.8, 0.3), Dielectric(1.5)
    for material in (Conductor(), Conductor(((0.2, 3.9),)), Diffuse()):
        q = material.density(slopes, d, w)
        back = material.density(slopes, -w, -d)
        np.testing.assert_allclose(q, back, rtol=1e-2, atol=2e-5 * q.max())
    q = glass.density(slopes, d, w, transmitted=True)
    back = glass.density(slopes, -w, -d, inside=True, transmitted=True)
    np.testing.assert_allclose(q, 1.5**2 * back, rtol=1e-9)


def test_albedo_of_single_scattering():
    # GGX, alpha 1, normal incidence: 1 - ln 2. The tolerance is that of the quadrature.
    E = first_order_albedo(Ggx(1, 1), Conductor(), direction(0)[:, None])
    np.testing.assert_allclose(E, 1 - np.log(2), atol=1e-6)
    w, solid_angle = hemisphere(48)
    assert abs(solid_angle.sum() - 2 * np.pi) < 1e-9
    assert w.shape == (3, solid_angle.size)
