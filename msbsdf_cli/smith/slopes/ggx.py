"""GGX, the distribution of Trowbridge and Reitz."""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.smith.slopes._distribution import Slopes
from surfaces.facet import Array, unit_circle


@dataclass(frozen=True)
class Ggx(Slopes):
    """The distribution of Trowbridge and Reitz: normals of a stretched ellipsoid."""

    def D(self, m: Array) -> Array:
        length2 = (m[0] / self.alpha_x) ** 2 + (m[1] / self.alpha_y) ** 2 + m[2] * m[2]
        density = 1 / (np.pi * self.alpha_x * self.alpha_y * length2 * length2)
        return np.where(m[2] > 0, density, 0)

    def sigma(self, d: Array) -> Array:
        x, y, z = self.alpha_x * d[0], self.alpha_y * d[1], d[2]
        s2 = x * x + y * y
        # sqrt(s^2 + z^2) - z as a sum of terms of one sign.
        return s2 / (np.sqrt(s2 + z * z) + np.abs(z)) / 2 + np.maximum(-z, 0)

    def visible_normals(self, wi: Array, n: int, rng: np.random.Generator) -> Array:
        """By spherical caps (Dupuy & Benyoub 2023): on the stretched sphere the visible normal is
        the half vector of `wi` and a direction uniform on the cap z > -wi_z.

        All is measured from the pole opposite to `wi`, by 1 + wi_z = s^2 / (1 - wi_z), so that no
        digit is lost towards it.
        """
        dtype = wi.dtype.type
        x, y, z = self.alpha_x * wi[0], self.alpha_y * wi[1], wi[2]
        s2 = x * x + y * y
        length = np.sqrt(s2 + z * z)
        x, y = x / length, y / length
        cap = (s2 / (length + np.abs(z)) + 2 * np.maximum(z, 0)) / length
        u = rng.random(n, dtype=dtype)
        below = u * cap
        sin_theta = np.sqrt(below * (2 - below))
        cos_phi, sin_phi = unit_circle(n, rng, dtype)
        m = np.empty((3, n), dtype)
        m[0] = self.alpha_x * (x + sin_theta * cos_phi)
        m[1] = self.alpha_y * (y + sin_theta * sin_phi)
        m[2] = cap - below
        return m

    def slope_density(self, x: Array, y: Array) -> Array:
        return 1 / (np.pi * (1 + x * x + y * y) ** 2)

    def marginal_density(self, x: Array) -> Array:
        return 1 / (2 * (1 + x * x) ** 1.5)
