"""Integrals over the facets that a direction sees, against facets drawn at random."""

import numpy as np
import pytest

from msbsdf_cli.methods.solver.slope_quadrature import SlopeQuadrature
from msbsdf_cli.smith.slopes import distribution
from surfaces.facet import fresnel_dielectric


def travelling(theta):
    return np.array([np.sin(theta) * np.cos(0.7), np.sin(theta) * np.sin(0.7), -np.cos(theta)])


CASES = [
    (slopes, alpha, eta, theta)
    for slopes in ("beckmann", "ggx")
    for alpha in ((0.5, 0.5), (1.0, 0.1))
    for eta in (1.5, 1 / 1.5)
    for theta in (0.0, 1.2, 1.8)
]


@pytest.mark.parametrize(("slopes", "alpha", "eta", "theta"), CASES)
def test_both_events_together_are_the_projected_area(slopes, alpha, eta, theta):
    surface, d = distribution(slopes)(*alpha), travelling(theta)
    found = SlopeQuadrature(surface, 24, alpha[0] == alpha[1]).scatter(d, eta)
    sigma = surface.sigma(d[:, None])[0]
    # Both are integrated on nodes of their own: the error of 24 between edges.
    assert sum(light.amount.sum() for light in found) == pytest.approx(sigma, rel=1e-5)


@pytest.mark.parametrize(("slopes", "alpha", "eta", "theta"), CASES)
def test_light_goes_where_visible_normals_send_it(slopes, alpha, eta, theta):
    surface, d = distribution(slopes)(*alpha), travelling(theta)
    m = surface.visible_normals(-d[:, None], 20_000, np.random.default_rng(5))
    m = m / np.linalg.norm(m, axis=0)
    cos_i = np.clip(-(d @ m), 1e-12, 1)
    reflectance, cos_t = fresnel_dielectric(cos_i, eta)
    sent = (
        (d[:, None] + 2 * cos_i * m, reflectance),
        (-(d[:, None] / eta + (cos_i / eta - cos_t) * m), 1 - reflectance),
    )
    sigma = surface.sigma(d[:, None])[0]
    for light, (w, share) in zip(
        SlopeQuadrature(surface, 16, half=False).scatter(d, eta), sent, strict=True
    ):
        # The light of either hemisphere, and its mean direction.
        moments = np.stack([share, share * (w[2] > 0), *(share * w)])
        drawn, error = moments.mean(axis=1), moments.std(axis=1) / np.sqrt(share.size)
        up = light.amount[light.w[2] > 0].sum()
        found = np.array([light.amount.sum(), up, *(light.w @ light.amount)]) / sigma
        # 240 numbers: 4.5 standard errors; 1e-3 for the quadrature, and what no draw has met.
        assert np.all(np.abs(found - drawn) < 4.5 * error + 1e-3)
