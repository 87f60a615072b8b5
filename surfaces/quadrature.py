"""Gauss-Legendre quadrature on the unit interval, and over a hemisphere."""

from functools import cache

import numpy as np
from scipy.special import roots_legendre

from surfaces.facet import Array


@cache
def gauss(n: int) -> tuple[Array, Array]:
    """Nodes and weights (n,) on [0, 1], not to be written to."""
    x, weight = roots_legendre(n)
    x, weight = (x + 1) / 2, weight / 2
    x.flags.writeable = weight.flags.writeable = False
    return x, weight


def hemisphere(polar: int, azimuthal: int, power: int = 1) -> tuple[Array, Array]:
    """Directions (3, polar x azimuthal) of a product rule over the hemisphere z > 0, and their
    solid angles: Gauss nodes in the cosine's `power`-th root, so that a higher one is finer towards
    the horizon, and even azimuths."""
    u, weight = gauss(polar)
    phi = 2 * np.pi / azimuthal * np.arange(azimuthal)
    z, phi = (a.ravel() for a in np.meshgrid(u**power, phi, indexing="ij"))
    s = np.sqrt(1 - z * z)
    solid_angle = power * u ** (power - 1) * weight * (2 * np.pi / azimuthal)
    return np.stack([s * np.cos(phi), s * np.sin(phi), z]), np.repeat(solid_angle, azimuthal)
