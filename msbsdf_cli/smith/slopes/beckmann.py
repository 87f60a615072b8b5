"""Beckmann's distribution: Gaussian slopes."""

from dataclasses import dataclass

import numpy as np
from scipy.special import erfc

from msbsdf_cli.smith.slopes._distribution import Mirrored
from surfaces.facet import Array

SQRT_PI = float(np.sqrt(np.pi))


@dataclass(frozen=True)
class Beckmann(Mirrored):
    """Gaussian slopes, of variance alpha^2 / 2 along each axis."""

    def D(self, m: Array) -> Array:
        # The fourth root, so that what vanishes at the horizon does so before its divisor.
        slope2 = ((m[0] / self.alpha_x) ** 2 + (m[1] / self.alpha_y) ** 2) / (m[2] * m[2])
        root = np.exp(-slope2 / 4) / m[2]
        square = root * root
        return np.where(m[2] > 0, square * square / (np.pi * self.alpha_x * self.alpha_y), 0)

    def area(self, s: Array, z: Array, a: Array) -> Array:
        # `z * erfc` and not `s * a * erfc`, so that the vertical s = 0 is no special case.
        return (s * np.exp(-a * a) / SQRT_PI - z * erfc(a)) / 2

    def radius2(self, u: Array) -> Array:
        return -np.log(1 - u)

    def beyond(self, a: Array, rng: np.random.Generator) -> Array:
        """Rejection from a gamma density: with y = r - a, exp(-y^2) <= exp(k^2 - 2 k y), and
        k (a + k) = 1 makes the loss smallest: at least 2 / e of the proposals are accepted, for
        any a.
        """
        r = np.empty_like(a)
        lanes = np.arange(a.size)
        dtype = a.dtype.type
        while lanes.size:
            k = (np.sqrt(a * a + 4) - a) / 2
            u = rng.random((3, lanes.size), dtype=dtype)
            y = -np.log((1 - u[0]) * (1 - u[1])) / (2 * (a + k))
            accepted = u[2] < np.exp(-((y - k) ** 2))
            r[lanes.compress(accepted)] = (a + y).compress(accepted)
            rejected = ~accepted
            lanes, a = lanes.compress(rejected), a.compress(rejected)
        return r

    def across(self, x: Array, y: Array, rng: np.random.Generator) -> Array:
        return y  # Gaussian slopes along and across are independent.

    def slope_density(self, x: Array, y: Array) -> Array:
        return np.exp(-(x * x + y * y)) / np.pi

    def marginal_density(self, x: Array) -> Array:
        return np.exp(-x * x) / SQRT_PI
