"""Student's t-distribution of slopes, between GGX and Beckmann's.

M. Ribardiere, B. Bringier, D. Meneveaux, L. Simonot, STD: Student's t-Distribution of Slopes for
Microfacet Based BSDFs, Computer Graphics Forum 36(2), 2017.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import gammaln, stdtr

from msbsdf_cli.smith.slopes._distribution import Mirrored
from surfaces.facet import Array


@dataclass(frozen=True)
class StudentT(Mirrored):
    """Slopes, each over its roughness, of density (1 + r^2 / (gamma - 1))^-gamma / pi.

    GGX at gamma = 2, towards Beckmann's as gamma grows. Gamma is above 3/2, where the surface has
    a finite area. One slope is t / sqrt(2), with t of 2 gamma - 2 degrees of freedom.
    """

    gamma: float = 3.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 1.5 < self.gamma < math.inf:
            raise ValueError(f"gamma is {self.gamma}: it is a finite number above 3/2.")

    @property
    def _spread(self) -> float:
        return self.gamma - 1

    def D(self, m: Array) -> Array:
        # (1 + r^2 / (gamma - 1))^-gamma / z^4 in logarithms, which neither overflow nor underflow.
        z2, r2 = m[2] * m[2], (m[0] / self.alpha_x) ** 2 + (m[1] / self.alpha_y) ** 2
        power = (2 * self.gamma - 4) * np.log(np.where(m[2] > 0, m[2], 1))
        density = np.exp(power - self.gamma * np.log(z2 + r2 / self._spread))
        return np.where(m[2] > 0, density / (np.pi * self.alpha_x * self.alpha_y), 0)

    def area(self, s: Array, z: Array, a: Array) -> Array:
        # Where the integral of x p(x) from a on ends the tail is a power, and its logarithm safe.
        mean = self._mean_size * np.exp((1.5 - self.gamma) * np.log1p(a * a / self._spread))
        tail = stdtr(2 * self.gamma - 2, -np.sqrt(2) * a)
        return np.maximum(s * mean - z * tail, 0).astype(z.dtype, copy=False)

    @property
    def _mean_size(self) -> float:
        """The integral of x p(x) over x > 0."""
        ratio = np.exp(gammaln(self.gamma - 1.5) - gammaln(self._spread))
        return float(np.sqrt(self._spread / np.pi) * ratio / 2)

    def radius2(self, u: Array) -> Array:
        return self._spread * np.expm1(-np.log1p(-u) / self._spread)

    def beyond(self, a: Array, rng: np.random.Generator) -> Array:
        """Rejection in v, where 1 + r^2 / (gamma - 1) grows from its value at a by exp(v). The
        density is (1 - a / r) exp(-b v), b = gamma - 3/2. The first factor is at most 1 and at
        most k v / 2, k = (gamma - 1 + a^2) / a^2: proposals are exponential or, where that
        accepts more, of a gamma density; a third or more of them are accepted, for any a.
        """
        r = np.empty_like(a)
        lanes = np.arange(a.size)
        # A facet as steep as that is a wall to rounding, and its square has a square.
        wall = np.finfo(a.dtype).max ** 0.25
        dtype, b = a.dtype.type, self.gamma - 1.5
        while lanes.size:
            u = rng.random((3, lanes.size), dtype=dtype)
            first, second = -np.log1p(-u[0]) / b, -np.log1p(-u[1]) / b
            a2 = a * a
            slope = (self._spread + a2) / (2 * np.maximum(a2, np.finfo(dtype).tiny))
            steep = slope > b
            v = np.where(steep, first, first + second)
            with np.errstate(over="ignore"):
                size = np.minimum(np.sqrt(a2 + (self._spread + a2) * np.expm1(v)), wall)
            accepted = u[2] * np.where(steep, 1, slope * v) < 1 - a / size
            r[lanes.compress(accepted)] = size.compress(accepted)
            rejected = ~accepted
            lanes, a = lanes.compress(rejected), a.compress(rejected)
        return r

    def across(self, x: Array, y: Array, rng: np.random.Generator) -> Array:
        """Given x, the other slope is t of 2 gamma - 1 degrees of freedom, wider where x is."""
        t = rng.standard_t(2 * self.gamma - 1, x.size)
        width = np.sqrt((self._spread + x * x) / (2 * self.gamma - 1))
        return (width * t).astype(x.dtype, copy=False)

    def slope_density(self, x: Array, y: Array) -> Array:
        return (1 + (x * x + y * y) / self._spread) ** -self.gamma / np.pi

    def marginal_density(self, x: Array) -> Array:
        height = np.exp(gammaln(self.gamma - 0.5) - gammaln(self._spread))
        bell = (1 + x * x / self._spread) ** (0.5 - self.gamma)
        return height / np.sqrt(np.pi * self._spread) * bell
